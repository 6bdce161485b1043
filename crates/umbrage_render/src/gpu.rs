//! The device: headless, Vulkan, WebGPU's baseline and its default limits.

use std::sync::{Arc, Mutex, PoisonError};

use pollster::block_on;
use umbrage_compose::{Limit, Target};
use umbrage_wgpu::{TooLarge, device};

/// A device to render with, without a window.
pub struct Gpu {
    pub(crate) device: wgpu::Device,
    pub(crate) queue: wgpu::Queue,
    adapter: String,
    /// Nanoseconds a tick of its clock; none where it tells no times.
    timestamp_period: Option<f32>,
    stray: Arc<Mutex<Vec<String>>>,
}

/// Why the device could not be had, or refused work.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum GpuError {
    /// No adapter.
    #[error(
        "no Vulkan adapter was found ({0}); install a driver, on Debian \
         `apt-get install mesa-vulkan-drivers libvulkan1`, whose software renderer needs no graphics card"
    )]
    NoAdapter(String),
    /// The adapter gives no device.
    #[error(
        "the adapter `{adapter}` gives no device with WebGPU's default limits: {reason}; update its driver"
    )]
    NoDevice {
        /// The adapter.
        adapter: String,
        /// Why, in the driver's words.
        reason: String,
    },
    /// The device has no memory left.
    #[error("the device is out of memory; render a smaller picture, or smaller shadow maps")]
    OutOfMemory,
    /// The device refused a command or a resource.
    #[error("the device refused the work: {0}")]
    Refused(String),
    /// Something is larger than the device allows.
    #[error(transparent)]
    TooLarge(#[from] TooLarge),
}

impl Gpu {
    /// Opens the machine's Vulkan adapter; the software renderer will do. Where there is no desktop's session, one of
    /// Mesa's layers complains of `XDG_RUNTIME_DIR` on standard error; `NODEVICE_SELECT=1` in the process's environment
    /// turns it off, which is the program's to say, not a library's.
    ///
    /// # Errors
    /// No adapter, or one below WebGPU's baseline.
    pub fn new() -> Result<Self, GpuError> {
        let adapter = find_adapter()?;
        let name = adapter.get_info().name;
        let descriptor = wgpu::DeviceDescriptor {
            label: Some("umbrage"),
            // Beyond the baseline, where there is more: only what measures, and what a plan may need.
            required_features: adapter.features()
                & (wgpu::Features::TIMESTAMP_QUERY
                    | wgpu::Features::FLOAT32_BLENDABLE
                    | wgpu::Features::FLOAT32_FILTERABLE),
            ..Default::default()
        };
        let (device, queue) =
            block_on(adapter.request_device(&descriptor)).map_err(|error| GpuError::NoDevice {
                adapter: name.clone(),
                reason: error.to_string(),
            })?;
        Ok(Self::from_wgpu(device, queue, name))
    }

    /// A device that exists already; `adapter` is its adapter's name, for reports.
    ///
    /// Errors of the device that no scope catches are told by the next [render](crate::Renderer::render): this takes the
    /// place of a handler that the device may have had.
    pub fn from_wgpu(device: wgpu::Device, queue: wgpu::Queue, adapter: impl Into<String>) -> Self {
        // Left alone, wgpu panics on an error that no scope catches.
        let stray = Arc::new(Mutex::new(Vec::new()));
        let list = Arc::clone(&stray);
        device.on_uncaptured_error(Arc::new(move |error: wgpu::Error| {
            list.lock()
                .unwrap_or_else(PoisonError::into_inner)
                .push(error.to_string());
        }));
        let timed = device.features().contains(wgpu::Features::TIMESTAMP_QUERY);
        Self {
            timestamp_period: timed.then(|| queue.get_timestamp_period()),
            device,
            queue,
            adapter: adapter.into(),
            stray,
        }
    }

    /// The target `this`: all that the machine's Vulkan adapter offers through wgpu, whether a device
    /// of ours asks for it or not.
    ///
    /// # Errors
    /// No adapter.
    pub fn target() -> Result<Target, GpuError> {
        let adapter = find_adapter()?;
        let capabilities = wgpu::wgc::device::features_to_naga_capabilities(
            adapter.features(),
            adapter.get_downlevel_capabilities().flags,
        );
        let target = limits(&adapter.limits()).fold(
            Target::new("this", capabilities),
            |target, (limit, value)| target.with_limit(limit, value),
        );
        let writes = wgpu::Features::VERTEX_WRITABLE_STORAGE;
        Ok(match adapter.features().contains(writes) {
            true => target.with_vertex_writes(),
            false => target,
        })
    }

    /// The adapter's name.
    pub fn adapter(&self) -> &str {
        &self.adapter
    }

    /// Whether the adapter tells how long a pass takes; where it does not, a report has no
    /// [`times`](crate::Report::times).
    pub fn has_timestamps(&self) -> bool {
        self.timestamp_period.is_some()
    }

    /// Nanoseconds a tick of a timestamp; none where the adapter has none.
    pub(crate) fn timestamp_period(&self) -> Option<f32> {
        self.timestamp_period
    }

    /// Waits until all that was submitted is done.
    pub(crate) fn wait(&self) -> Result<(), GpuError> {
        match self.device.poll(wgpu::PollType::wait_indefinitely()) {
            Ok(_) => Ok(()),
            Err(error) => Err(GpuError::Refused(format!("it did not finish: {error}"))),
        }
    }

    /// Waits until all that was submitted is done, and gives the bytes of `buffer`.
    pub(crate) fn read(
        &self,
        buffer: &wgpu::Buffer,
        read: impl FnOnce(&[u8]),
    ) -> Result<(), GpuError> {
        let refused = |error: &dyn std::fmt::Display| {
            GpuError::Refused(format!("a result cannot be read back: {error}"))
        };
        let (sender, receiver) = std::sync::mpsc::channel();
        buffer.map_async(wgpu::MapMode::Read, .., move |result| {
            // The receiver waits below, unless waiting failed and says so itself.
            let _ = sender.send(result);
        });
        self.wait()?;
        match receiver.try_recv() {
            Ok(Ok(())) => {}
            Ok(Err(error)) => return Err(refused(&error)),
            Err(error) => return Err(refused(&error)),
        }
        let mapped = buffer
            .get_mapped_range(..)
            .map_err(|error| refused(&error))?;
        read(&mapped);
        drop(mapped);
        buffer.unmap();
        Ok(())
    }

    /// Does `work`, and gives the first error that the device found in it.
    pub(crate) fn check<T>(&self, work: impl FnOnce() -> T) -> Result<T, GpuError> {
        use wgpu::ErrorFilter::{Internal, OutOfMemory, Validation};
        let scopes = [OutOfMemory, Internal, Validation].map(|f| self.device.push_error_scope(f));
        let done = work();
        let mut found = None;
        for scope in scopes.into_iter().rev() {
            // Resources made without memory are refused when used: the want of memory is the cause.
            found = match block_on(scope.pop()) {
                Some(error @ wgpu::Error::OutOfMemory { .. }) => Some(error),
                error => found.or(error),
            };
        }
        let stray = std::mem::take(&mut *self.stray.lock().unwrap_or_else(PoisonError::into_inner));
        match (found, stray.into_iter().next()) {
            (Some(wgpu::Error::OutOfMemory { .. }), _) => Err(GpuError::OutOfMemory),
            (Some(error), _) => Err(GpuError::Refused(one_line(&error.to_string()))),
            (None, Some(stray)) => Err(GpuError::Refused(one_line(&stray))),
            (None, None) => Ok(done),
        }
    }

    /// A buffer that holds `bytes`; `what` names it in an error.
    pub(crate) fn buffer(
        &self,
        what: &str,
        usage: wgpu::BufferUsages,
        bytes: &[u8],
    ) -> Result<wgpu::Buffer, GpuError> {
        Ok(device::buffer(self.parts(), what, usage, bytes)?)
    }

    /// A texture; `what` names it in an error.
    pub(crate) fn texture(
        &self,
        what: &str,
        size: wgpu::Extent3d,
        levels: u32,
        format: wgpu::TextureFormat,
        usage: wgpu::TextureUsages,
    ) -> Result<wgpu::Texture, GpuError> {
        let made = device::texture(&self.device, what, size, levels, format, usage);
        Ok(made?)
    }

    /// The device and its queue.
    pub(crate) fn parts(&self) -> umbrage_wgpu::Gpu<'_> {
        (&self.device, &self.queue)
    }
}

/// Limits of wgpu that the composer checks.
fn limits(limits: &wgpu::Limits) -> impl Iterator<Item = (Limit, u64)> {
    let counts = [
        (Limit::BindGroups, limits.max_bind_groups),
        (
            Limit::BindingsPerBindGroup,
            limits.max_bindings_per_bind_group,
        ),
        (
            Limit::SampledTexturesPerStage,
            limits.max_sampled_textures_per_shader_stage,
        ),
        (
            Limit::SamplersPerStage,
            limits.max_samplers_per_shader_stage,
        ),
        (
            Limit::StorageBuffersPerStage,
            limits.max_storage_buffers_per_shader_stage,
        ),
        (
            Limit::StorageTexturesPerStage,
            limits.max_storage_textures_per_shader_stage,
        ),
        (
            Limit::UniformBuffersPerStage,
            limits.max_uniform_buffers_per_shader_stage,
        ),
        (Limit::VertexAttributes, limits.max_vertex_attributes),
        (
            Limit::InterStageShaderVariables,
            limits.max_inter_stage_shader_variables,
        ),
        (Limit::ColorAttachments, limits.max_color_attachments),
        (
            Limit::ComputeWorkgroupStorageSize,
            limits.max_compute_workgroup_storage_size,
        ),
        (
            Limit::ComputeInvocationsPerWorkgroup,
            limits.max_compute_invocations_per_workgroup,
        ),
        (
            Limit::ComputeWorkgroupSizeX,
            limits.max_compute_workgroup_size_x,
        ),
        (
            Limit::ComputeWorkgroupSizeY,
            limits.max_compute_workgroup_size_y,
        ),
        (
            Limit::ComputeWorkgroupSizeZ,
            limits.max_compute_workgroup_size_z,
        ),
    ];
    let sizes = [
        (
            Limit::UniformBufferBindingSize,
            limits.max_uniform_buffer_binding_size,
        ),
        (
            Limit::StorageBufferBindingSize,
            limits.max_storage_buffer_binding_size,
        ),
    ];
    let counts = counts.map(|(limit, count)| (limit, u64::from(count)));
    counts.into_iter().chain(sizes)
}

/// The machine's Vulkan adapter. Probing other backends as well would print noise.
fn find_adapter() -> Result<wgpu::Adapter, GpuError> {
    let instance = wgpu::Instance::new(wgpu::InstanceDescriptor {
        backends: wgpu::Backends::VULKAN,
        ..wgpu::InstanceDescriptor::new_without_display_handle()
    });
    block_on(instance.request_adapter(&wgpu::RequestAdapterOptions::default()))
        .map_err(|error| GpuError::NoAdapter(about_vulkan(&error.to_string())))
}

/// Part of wgpu's account of all backends that is about the one that was asked for.
fn about_vulkan(account: &str) -> String {
    let mut parts = account.split([';', ',']).map(str::trim);
    parts
        .find(|part| part.contains("vulkan"))
        .unwrap_or(account)
        .to_owned()
}

/// An error's text as one paragraph.
pub(crate) fn one_line(text: &str) -> String {
    text.split_whitespace().collect::<Vec<_>>().join(" ")
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Wgpu's default limits are WebGPU's, so the two tables must agree, and none may be missing.
    #[test]
    fn each_limit_is_the_devices_own() {
        let told: Vec<_> = limits(&wgpu::Limits::default()).collect();
        for limit in Limit::ALL {
            let value = told.iter().find(|(known, _)| known == limit);
            assert_eq!(value, Some(&(*limit, limit.webgpu())), "{}", limit.name());
        }
        assert_eq!(told.len(), Limit::ALL.len());
    }

    #[test]
    fn a_device_may_be_somebody_elses() {
        let theirs = Gpu::new().expect("an adapter");
        let ours = Gpu::from_wgpu(theirs.device.clone(), theirs.queue.clone(), "theirs");
        assert_eq!(ours.adapter(), "theirs");
        assert_eq!(ours.has_timestamps(), theirs.has_timestamps());
        assert_eq!(ours.check(|| 1), Ok(1));
    }

    #[test]
    fn what_the_device_refuses_is_an_error() {
        let gpu = Gpu::new().expect("an adapter");
        assert!(!gpu.adapter().is_empty());
        let work = || {
            gpu.device.create_sampler(&wgpu::SamplerDescriptor {
                anisotropy_clamp: 0,
                ..Default::default()
            })
        };
        assert!(matches!(gpu.check(work), Err(GpuError::Refused(_))));
        assert!(gpu.check(|| ()).is_ok());
        let size = wgpu::Extent3d {
            width: 1 << 20,
            height: 1,
            depth_or_array_layers: 1,
        };
        let format = wgpu::TextureFormat::R32Float;
        let texture = gpu.texture("a map", size, 1, format, wgpu::TextureUsages::COPY_DST);
        let message = texture.expect_err("too large").to_string();
        assert!(
            message.contains("a map has 1048576 by 1 texels"),
            "{message}"
        );
    }
}

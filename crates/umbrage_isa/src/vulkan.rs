//! Pipelines by Vulkan itself: wgpu cannot open a device without hardware, and gives no statistics.
//!
//! The one module with unsafe code. It runs in a process of its own alone, so that what the driver does
//! there, crashing included, is no danger to the caller.

#![allow(
    unsafe_code,
    reason = "every call of Vulkan is unsafe; each says why it may be made"
)]

use std::ffi::{CStr, CString};

use ash::{khr::pipeline_executable_properties as executables, vk};

use crate::wire::{self, Draw, Executable, Job, Shader, Work};

/// A device that compiles, and does nothing else.
pub(crate) struct Gpu {
    name: String,
    device: ash::Device,
    executables: executables::Device,
    // Its functions must outlive all that was made of them.
    _entry: ash::Entry,
}

impl Gpu {
    /// Opens the first device that the loader offers.
    pub(crate) fn open() -> Result<Self, String> {
        // SAFETY: the loader's library has initialisers, but none that asks anything of us.
        let entry = unsafe { ash::Entry::load() }.map_err(|error| {
            format!("the Vulkan loader cannot be loaded ({error}); install libvulkan1")
        })?;
        let application = vk::ApplicationInfo::default().api_version(vk::API_VERSION_1_3);
        let info = vk::InstanceCreateInfo::default().application_info(&application);
        // SAFETY: `info` and what it points to outlive the call.
        let instance = unsafe { entry.create_instance(&info, None) }
            .map_err(|error| format!("no Vulkan instance: {error}"))?;
        // SAFETY: the instance is alive, and it is never destroyed: the process ends with it.
        let devices = unsafe { instance.enumerate_physical_devices() }
            .map_err(|error| format!("no Vulkan device: {error}"))?;
        let physical = *devices.first().ok_or("the driver offers no device")?;
        // SAFETY: `physical` is the living instance's.
        let properties = unsafe { instance.get_physical_device_properties(physical) };
        let name = text(&properties.device_name);
        if properties.api_version < vk::API_VERSION_1_3 {
            return Err(format!("`{name}` knows no Vulkan 1.3"));
        }
        let device = open_device(&instance, physical)
            .map_err(|error| format!("`{name}` cannot be opened: {error}"))?;
        Ok(Self {
            name,
            executables: executables::Device::new(&instance, &device),
            device,
            _entry: entry,
        })
    }

    /// The device's own name, which holds the family's.
    pub(crate) fn name(&self) -> &str {
        &self.name
    }

    /// Makes the pipeline, and returns what the driver says of each stage.
    pub(crate) fn compile(&self, job: &Job) -> Result<Vec<Executable>, String> {
        let mut made = Made::new(&self.device);
        let layout = made.layout(&job.sets)?;
        let pipeline = match &job.work {
            Work::Draw(draw) => made.render_pipeline(layout, draw),
            Work::Compute(shader) => made.compute_pipeline(layout, shader),
        }?;
        self.executables(pipeline)
            .map_err(|error| format!("the driver gives no statistics: {error}"))
    }

    fn executables(&self, pipeline: vk::Pipeline) -> Result<Vec<Executable>, vk::Result> {
        let info = vk::PipelineInfoKHR::default().pipeline(pipeline);
        // SAFETY: the pipeline is alive, the device's own, and its device has the extension's feature on.
        let found = unsafe { self.executables.get_pipeline_executable_properties(&info) }?;
        (0..)
            .zip(found)
            .map(|(index, properties)| {
                let info = vk::PipelineExecutableInfoKHR::default()
                    .pipeline(pipeline)
                    .executable_index(index);
                // SAFETY: as above; the pipeline was made to keep statistics, and `index` is below the
                // number of executables that was just found.
                let statistics =
                    unsafe { self.executables.get_pipeline_executable_statistics(&info) }?;
                Ok(Executable {
                    stages: properties.stages.as_raw(),
                    statistics: statistics.iter().filter_map(statistic).collect(),
                })
            })
            .collect()
    }
}

/// A device with the features that wgpu turns on wherever they change what a shader is compiled to.
fn open_device(
    instance: &ash::Instance,
    physical: vk::PhysicalDevice,
) -> Result<ash::Device, String> {
    // SAFETY: `physical` is the living instance's.
    let offered = unsafe { instance.enumerate_device_extension_properties(physical) }
        .map_err(|error| error.to_string())?;
    let offers = |name: &CStr| {
        let mut names = offered
            .iter()
            .map(vk::ExtensionProperties::extension_name_as_c_str);
        names.any(|offered| offered == Ok(name))
    };
    if !offers(executables::NAME) {
        return Err("it lacks VK_KHR_pipeline_executable_properties".to_owned());
    }
    let mut extensions = vec![executables::NAME.as_ptr()];
    let mut robustness = vk::PhysicalDeviceRobustness2FeaturesEXT::default()
        .robust_buffer_access2(true)
        .robust_image_access2(true);
    let mut statistics = vk::PhysicalDevicePipelineExecutablePropertiesFeaturesKHR::default()
        .pipeline_executable_info(true);
    let mut rendering = vk::PhysicalDeviceVulkan13Features::default()
        .dynamic_rendering(true)
        .robust_image_access(true)
        .shader_zero_initialize_workgroup_memory(true);
    let features = vk::PhysicalDeviceFeatures::default()
        .robust_buffer_access(true)
        .image_cube_array(true)
        .sample_rate_shading(true)
        .fragment_stores_and_atomics(true)
        .vertex_pipeline_stores_and_atomics(true);
    let queue = [vk::DeviceQueueCreateInfo::default().queue_priorities(&[1.0])];
    let mut info = vk::DeviceCreateInfo::default()
        .queue_create_infos(&queue)
        .enabled_features(&features)
        .push_next(&mut statistics)
        .push_next(&mut rendering);
    if offers(ash::ext::robustness2::NAME) {
        extensions.push(ash::ext::robustness2::NAME.as_ptr());
        info = info.push_next(&mut robustness);
    }
    let info = info.enabled_extension_names(&extensions);
    // SAFETY: `info` and what it points to outlive the call; what the device lacks it refuses.
    unsafe { instance.create_device(physical, &info, None) }.map_err(|error| error.to_string())
}

/// Objects made for one pipeline; they go with it.
struct Made<'a> {
    device: &'a ash::Device,
    modules: Vec<vk::ShaderModule>,
    sets: Vec<vk::DescriptorSetLayout>,
    layouts: Vec<vk::PipelineLayout>,
    pipelines: Vec<vk::Pipeline>,
}

impl<'a> Made<'a> {
    fn new(device: &'a ash::Device) -> Self {
        Self {
            device,
            modules: Vec::new(),
            sets: Vec::new(),
            layouts: Vec::new(),
            pipelines: Vec::new(),
        }
    }

    fn layout(&mut self, sets: &[Vec<wire::Slot>]) -> Result<vk::PipelineLayout, String> {
        let failed = |error| format!("the bindings cannot be laid out: {error}");
        for slots in sets {
            let bindings: Vec<_> = slots
                .iter()
                .map(|slot| {
                    vk::DescriptorSetLayoutBinding::default()
                        .binding(slot.binding)
                        .descriptor_type(vk::DescriptorType::from_raw(slot.descriptor))
                        .descriptor_count(1)
                        .stage_flags(vk::ShaderStageFlags::from_raw(slot.stages))
                })
                .collect();
            let info = vk::DescriptorSetLayoutCreateInfo::default().bindings(&bindings);
            // SAFETY: `info` and what it points to outlive the call.
            let set = unsafe { self.device.create_descriptor_set_layout(&info, None) };
            self.sets.push(set.map_err(failed)?);
        }
        let info = vk::PipelineLayoutCreateInfo::default().set_layouts(&self.sets);
        // SAFETY: the sets' layouts are alive and the device's own.
        let layout = unsafe { self.device.create_pipeline_layout(&info, None) }.map_err(failed)?;
        self.layouts.push(layout);
        Ok(layout)
    }

    fn module(&mut self, shader: &Shader) -> Result<(vk::ShaderModule, CString), String> {
        let name = CString::new(shader.entry_point.as_str())
            .map_err(|_| "an entry point's name holds a zero byte".to_owned())?;
        let info = vk::ShaderModuleCreateInfo::default().code(&shader.code);
        // SAFETY: the words are naga's, of a module that its validator has passed.
        let module = unsafe { self.device.create_shader_module(&info, None) };
        let module = module.map_err(|error| format!("the shader was refused: {error}"))?;
        self.modules.push(module);
        Ok((module, name))
    }

    fn compute_pipeline(
        &mut self,
        layout: vk::PipelineLayout,
        shader: &Shader,
    ) -> Result<vk::Pipeline, String> {
        let (module, name) = self.module(shader)?;
        let stage = stage(vk::ShaderStageFlags::COMPUTE, module, &name);
        let info = vk::ComputePipelineCreateInfo::default()
            .flags(vk::PipelineCreateFlags::CAPTURE_STATISTICS_KHR)
            .stage(stage)
            .layout(layout);
        let cache = vk::PipelineCache::null();
        // SAFETY: module and layout are alive and the device's own, and fit each other: both are of one
        // reflection. All that `info` points to outlives the call.
        let made = unsafe { self.device.create_compute_pipelines(cache, &[info], None) };
        self.keep(made)
    }

    fn render_pipeline(
        &mut self,
        layout: vk::PipelineLayout,
        draw: &Draw,
    ) -> Result<vk::Pipeline, String> {
        let vertex = self.module(&draw.vertex)?;
        let fragment = match &draw.fragment {
            Some(shader) => Some(self.module(shader)?),
            None => None,
        };
        let mut stages = vec![stage(vk::ShaderStageFlags::VERTEX, vertex.0, &vertex.1)];
        if let Some((module, name)) = &fragment {
            stages.push(stage(vk::ShaderStageFlags::FRAGMENT, *module, name));
        }
        let (buffers, attributes): (Vec<_>, Vec<_>) =
            (0..).zip(&draw.attributes).map(input).unzip();
        let inputs = vk::PipelineVertexInputStateCreateInfo::default()
            .vertex_binding_descriptions(&buffers)
            .vertex_attribute_descriptions(&attributes);
        let assembly = vk::PipelineInputAssemblyStateCreateInfo::default()
            .topology(vk::PrimitiveTopology::from_raw(draw.topology));
        let viewport = vk::PipelineViewportStateCreateInfo::default()
            .viewport_count(1)
            .scissor_count(1);
        let dynamic = [
            vk::DynamicState::VIEWPORT,
            vk::DynamicState::SCISSOR,
            vk::DynamicState::BLEND_CONSTANTS,
            vk::DynamicState::STENCIL_REFERENCE,
        ];
        let dynamic = vk::PipelineDynamicStateCreateInfo::default().dynamic_states(&dynamic);
        let raster = vk::PipelineRasterizationStateCreateInfo::default()
            .cull_mode(vk::CullModeFlags::from_raw(draw.cull))
            .front_face(vk::FrontFace::from_raw(draw.front))
            .line_width(1.0);
        let samples = vk::PipelineMultisampleStateCreateInfo::default()
            .rasterization_samples(vk::SampleCountFlags::TYPE_1);
        let depth = draw.depth.as_ref().map_or_else(Default::default, |depth| {
            vk::PipelineDepthStencilStateCreateInfo::default()
                .depth_test_enable(true)
                .depth_write_enable(depth.write)
                .depth_compare_op(vk::CompareOp::from_raw(depth.compare))
        });
        let blends: Vec<_> = draw.colors.iter().map(blend).collect();
        let blends = vk::PipelineColorBlendStateCreateInfo::default().attachments(&blends);
        let formats = draw
            .colors
            .iter()
            .map(|color| vk::Format::from_raw(color.format));
        let formats: Vec<_> = formats.collect();
        let mut targets =
            vk::PipelineRenderingCreateInfo::default().color_attachment_formats(&formats);
        if let Some(depth) = &draw.depth {
            targets = targets.depth_attachment_format(vk::Format::from_raw(depth.format));
        }
        let info = vk::GraphicsPipelineCreateInfo::default()
            .flags(vk::PipelineCreateFlags::CAPTURE_STATISTICS_KHR)
            .stages(&stages)
            .vertex_input_state(&inputs)
            .input_assembly_state(&assembly)
            .viewport_state(&viewport)
            .rasterization_state(&raster)
            .multisample_state(&samples)
            .depth_stencil_state(&depth)
            .color_blend_state(&blends)
            .dynamic_state(&dynamic)
            .layout(layout)
            .push_next(&mut targets);
        let cache = vk::PipelineCache::null();
        // SAFETY: modules and layout are alive and the device's own, and fit each other: all are of one
        // reflection. All that `info` points to outlives the call.
        let made = unsafe { self.device.create_graphics_pipelines(cache, &[info], None) };
        self.keep(made)
    }

    /// The one pipeline that was asked for.
    fn keep(
        &mut self,
        made: Result<Vec<vk::Pipeline>, (Vec<vk::Pipeline>, vk::Result)>,
    ) -> Result<vk::Pipeline, String> {
        let pipelines =
            made.map_err(|(_, error)| format!("the driver refuses the pipeline: {error}"))?;
        self.pipelines.extend(&pipelines);
        let pipeline = pipelines.first().copied();
        pipeline.ok_or_else(|| "the driver made no pipeline".to_owned())
    }
}

impl Drop for Made<'_> {
    fn drop(&mut self) {
        // SAFETY: all of it is the living device's, made once, destroyed here alone, and nothing was ever
        // handed to the device to run.
        unsafe {
            for pipeline in &self.pipelines {
                self.device.destroy_pipeline(*pipeline, None);
            }
            for layout in &self.layouts {
                self.device.destroy_pipeline_layout(*layout, None);
            }
            for set in &self.sets {
                self.device.destroy_descriptor_set_layout(*set, None);
            }
            for module in &self.modules {
                self.device.destroy_shader_module(*module, None);
            }
        }
    }
}

fn stage(
    stage: vk::ShaderStageFlags,
    module: vk::ShaderModule,
    name: &CStr,
) -> vk::PipelineShaderStageCreateInfo<'_> {
    vk::PipelineShaderStageCreateInfo::default()
        .stage(stage)
        .module(module)
        .name(name)
}

fn input(
    (buffer, attribute): (u32, &wire::Attribute),
) -> (
    vk::VertexInputBindingDescription,
    vk::VertexInputAttributeDescription,
) {
    (
        vk::VertexInputBindingDescription::default()
            .binding(buffer)
            .stride(attribute.size),
        vk::VertexInputAttributeDescription::default()
            .location(attribute.location)
            .binding(buffer)
            .format(vk::Format::from_raw(attribute.format)),
    )
}

fn blend(color: &wire::Color) -> vk::PipelineColorBlendAttachmentState {
    let state = vk::PipelineColorBlendAttachmentState::default()
        .color_write_mask(vk::ColorComponentFlags::from_raw(color.write_mask));
    let Some([rgb, alpha]) = color.blend else {
        return state;
    };
    state
        .blend_enable(true)
        .src_color_blend_factor(vk::BlendFactor::from_raw(rgb[0]))
        .dst_color_blend_factor(vk::BlendFactor::from_raw(rgb[1]))
        .color_blend_op(vk::BlendOp::from_raw(rgb[2]))
        .src_alpha_blend_factor(vk::BlendFactor::from_raw(alpha[0]))
        .dst_alpha_blend_factor(vk::BlendFactor::from_raw(alpha[1]))
        .alpha_blend_op(vk::BlendOp::from_raw(alpha[2]))
}

/// Name and value; nothing of what is no whole number.
fn statistic(found: &vk::PipelineExecutableStatisticKHR<'_>) -> Option<(String, u64)> {
    if found.format != vk::PipelineExecutableStatisticFormatKHR::UINT64 {
        return None;
    }
    // SAFETY: the format, which the driver gave with it, says which of the union's fields is set.
    let value = unsafe { found.value.u64 };
    Some((text(&found.name), value))
}

/// The text before the first zero.
fn text(chars: &[std::ffi::c_char]) -> String {
    let bytes: Vec<u8> = chars
        .iter()
        .map(|c| c.to_ne_bytes()[0])
        .take_while(|byte| *byte != 0)
        .collect();
    String::from_utf8_lossy(&bytes).into_owned()
}

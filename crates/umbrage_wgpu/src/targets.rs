//! Parts of a plan's textures and buffers that its passes write and read, checked.

use std::collections::BTreeSet;

use umbrage_compose::{BindingKind, Permutation, TextureDimension};
use umbrage_shadow::{
    Blend, CasterPass, ColorTarget, ComputePass, MAX_REGIONS, Pass, Reads, Region, ScreenPass,
    ShadowPlan, Slice, Source, TextureDesc, TextureShape, Viewport, Workgroups,
};

use crate::{
    ColorState, Error, Job, MAX, ShadowResources,
    execute::Execution,
    record::{Place, Touches},
};

/// What a render pass draws into.
pub(crate) struct Targets {
    /// The depth's format, its view, and how it begins.
    pub(crate) depth: Option<(wgpu::TextureFormat, wgpu::TextureView, wgpu::LoadOp<f32>)>,
    pub(crate) colors: Vec<Color>,
}

/// A colour that a render pass draws into.
pub(crate) struct Color {
    pub(crate) state: ColorState,
    view: wgpu::TextureView,
    load: wgpu::LoadOp<wgpu::Color>,
}

/// A slice of one of the plan's textures.
struct Found {
    desc: TextureDesc,
    view: wgpu::TextureView,
    /// Texels across and down.
    size: [u32; 2],
}

impl Execution<'_> {
    pub(crate) fn bad(&self, problem: &str) -> Error {
        bad_plan(self.job, problem)
    }

    /// A texture of the plan.
    fn texture(&self, name: &str) -> Option<&(TextureDesc, wgpu::Texture)> {
        let own = self.resources.textures.contains_key(name);
        self.memory.textures.get(name).filter(|_| own)
    }

    /// The texture that a slice is of.
    fn sliced(&self, target: &Slice) -> Result<&(TextureDesc, wgpu::Texture), Error> {
        let name = &target.texture;
        let Some(found) = self.texture(name) else {
            let problem = format!("the target `{name}`, which is none of its textures");
            return Err(self.bad(&problem));
        };
        let (desc, layer, level) = (&found.0, target.layer, target.level);
        if layer >= desc.shape.layers() || level >= desc.levels {
            let problem = format!(
                "what is drawn into layer {layer} of `{name}`, level {level}, which has {} layers and {} levels",
                desc.shape.layers(),
                desc.levels
            );
            return Err(self.bad(&problem));
        }
        Ok(found)
    }

    /// A slice that a pass draws into, and which has room for `area`.
    fn target(&self, target: &Slice, area: &Viewport) -> Result<Found, Error> {
        let (desc, texture) = self.sliced(target)?;
        let (name, layer, level) = (&desc.name, target.layer, target.level);
        let size = [desc.width, desc.height].map(|texels| (texels >> level).max(1));
        let inside = |start: u32, extent: u32, all: u32| {
            extent > 0 && start.checked_add(extent).is_some_and(|end| end <= all)
        };
        if !inside(area.x, area.width, size[0]) || !inside(area.y, area.height, size[1]) {
            let problem = format!(
                "what is drawn into {area:?}, outside the {} by {} texels of `{name}`",
                size[0], size[1]
            );
            return Err(self.bad(&problem));
        }
        let view = texture.create_view(&wgpu::TextureViewDescriptor {
            dimension: Some(wgpu::TextureViewDimension::D2),
            base_array_layer: layer,
            array_layer_count: Some(1),
            base_mip_level: level,
            mip_level_count: Some(1),
            ..Default::default()
        });
        Ok(Found {
            desc: desc.clone(),
            view,
            size,
        })
    }

    /// Targets of a pass of casters.
    pub(crate) fn caster_targets(&mut self, pass: &CasterPass) -> Result<Targets, Error> {
        let (mut first, mut targets) = (None, Targets::NONE);
        if let Some(depth) = &pass.depth {
            let found = self.target(&depth.target, &pass.viewport)?;
            if !is_depth(found.desc.format) {
                let problem = format!(
                    "casters into `{}`, whose format {:?} is not of depth alone",
                    found.desc.name, found.desc.format
                );
                return Err(self.bad(&problem));
            }
            self.same_size(&mut first, &found)?;
            let load = match self.begins(&depth.target) || depth.clears {
                true => wgpu::LoadOp::Clear(found.desc.empty),
                false => wgpu::LoadOp::Load,
            };
            targets.depth = Some((found.desc.format, found.view, load));
        }
        for color in &pass.colors {
            let found = self.target(&color.target, &pass.viewport)?;
            self.same_size(&mut first, &found)?;
            targets.colors.push(self.color(color, found)?);
        }
        self.check_colors(&targets)?;
        Ok(targets)
    }

    /// Targets of a full-screen pass.
    pub(crate) fn screen_targets(&mut self, pass: &ScreenPass) -> Result<Targets, Error> {
        let (mut first, mut targets) = (None, Targets::NONE);
        for target in &pass.targets {
            let found = self.target(target, &pass.viewport)?;
            self.same_size(&mut first, &found)?;
            if !is_depth(found.desc.format) {
                let color = ColorTarget {
                    target: target.clone(),
                    channels: channels(found.desc.format),
                    blend: Blend::Replace,
                };
                targets.colors.push(self.color(&color, found)?);
            } else if targets.depth.is_some() {
                return Err(self.bad("a full-screen pass into two textures of depth"));
            } else {
                let load = match self.begins(target) {
                    true => wgpu::LoadOp::Clear(found.desc.empty),
                    false => wgpu::LoadOp::Load,
                };
                targets.depth = Some((found.desc.format, found.view, load));
            }
        }
        self.check_colors(&targets)?;
        Ok(targets)
    }

    /// Whether a pass is the plan's first one into a slice.
    fn begins(&mut self, target: &Slice) -> bool {
        self.filled.insert(place(target))
    }

    /// Whether all targets of a pass are as large as the first one.
    fn same_size(
        &self,
        first: &mut Option<(String, [u32; 2])>,
        found: &Found,
    ) -> Result<(), Error> {
        let (name, size) = (&found.desc.name, found.size);
        let (other, expected) = first.get_or_insert_with(|| (name.clone(), size));
        if size == *expected {
            return Ok(());
        }
        let problem = format!(
            "what is drawn into the {} by {} texels of `{other}` and the {} by {} of `{name}`: both must be as large",
            expected[0], expected[1], size[0], size[1]
        );
        Err(self.bad(&problem))
    }

    /// A colour that a pass draws into.
    fn color(&mut self, color: &ColorTarget, found: Found) -> Result<Color, Error> {
        let (name, format) = (&found.desc.name, found.desc.format);
        if !is_floats(format) {
            let problem = format!("a colour into `{name}`, which is not of floats ({format:?})");
            return Err(self.bad(&problem));
        }
        let there = channels(format);
        if color.channels.is_empty() || !there.contains(color.channels) {
            let (wanted, there) = (channel_names(color.channels), channel_names(there));
            let problem = format!(
                "a colour into the channels `{wanted}` of `{name}`, whose format {format:?} has `{there}`"
            );
            return Err(self.bad(&problem));
        }
        let empty = f64::from(found.desc.empty);
        let load = match self.begins(&color.target) {
            true => wgpu::LoadOp::Clear(wgpu::Color {
                r: empty,
                g: empty,
                b: empty,
                a: empty,
            }),
            false => wgpu::LoadOp::Load,
        };
        Ok(Color {
            state: ColorState {
                format,
                blend: match color.blend {
                    Blend::Replace => None,
                    Blend::Max => Some(MAX),
                },
                channels: color.channels,
            },
            view: found.view,
            load,
        })
    }

    /// Whether the device can draw into so many colours at once.
    fn check_colors(&self, targets: &Targets) -> Result<(), Error> {
        let limits = self.shared.device.limits();
        let mut bytes = 0_u32;
        for Color { state, .. } in &targets.colors {
            let align = state.format.target_component_alignment().unwrap_or(1);
            let cost = state.format.target_pixel_byte_cost().unwrap_or(0);
            bytes = bytes.next_multiple_of(align) + cost;
        }
        let (count, most) = (targets.colors.len(), limits.max_color_attachments);
        let most_bytes = limits.max_color_attachment_bytes_per_sample;
        if count <= most as usize && bytes <= most_bytes {
            return Ok(());
        }
        let problem = format!(
            "{count} colours of {bytes} bytes a texel, where the device allows {most} of {most_bytes}"
        );
        Err(self.bad(&problem))
    }

    /// What a pass writes and reads, checked against what the plan has.
    pub(crate) fn touches(
        &self,
        pass: &Pass,
        permutation: Option<&Permutation>,
    ) -> Result<Touches, Error> {
        let mut touches = Touches::default();
        let stores = match pass {
            Pass::Casters(pass) => {
                let depth = pass.depth.iter().map(|depth| &depth.target);
                let colors = pass.colors.iter().map(|color| &color.target);
                for target in depth.chain(colors) {
                    self.sliced(target)?;
                    touches.writes.push(place(target));
                }
                &[][..]
            }
            Pass::Screen(pass) => {
                for target in &pass.targets {
                    self.sliced(target)?;
                    touches.writes.push(place(target));
                }
                &[][..]
            }
            Pass::Compute(pass) => {
                for written in &pass.writes {
                    touches.writes.extend(self.places(written, true)?);
                }
                touches.reads.extend(self.check_workgroups(pass)?);
                &pass.writes[..]
            }
            _ => return Err(self.bad("a pass of a kind that is not known here")),
        };
        let renamed = pass.reads().map_or(&[][..], |reads| &reads.renamed);
        let bindings = permutation.map(|permutation| &permutation.reflection.bindings);
        for binding in bindings.into_iter().flatten() {
            let source = source(renamed, &binding.name);
            self.check_room(&source, &binding.kind)?;
            match binding.kind {
                BindingKind::Texture { .. }
                | BindingKind::Storage {
                    read_only: true, ..
                } => touches.reads.extend(self.places(&source, false)?),
                BindingKind::StorageTexture { .. } | BindingKind::Storage { .. }
                    if !stores.contains(&source) =>
                {
                    let problem = format!(
                        "`{}` stores to `{}`, which is not among what it `writes`",
                        pass.shader(),
                        source.name
                    );
                    return Err(self.bad(&problem));
                }
                _ => {}
            }
        }
        let mut places = (1..).zip(&touches.writes);
        if let Some((_, place)) = places.find(|(next, w)| touches.writes[*next..].contains(w)) {
            let problem = format!("`{}` draws twice into {}", pass.shader(), self.words(place));
            return Err(self.bad(&problem));
        }
        let mut both = touches.writes.iter();
        if let Some(place) = both.find(|place| touches.reads.contains(*place)) {
            let problem = format!(
                "`{}` reads {}, which it writes",
                pass.shader(),
                self.words(place)
            );
            return Err(self.bad(&problem));
        }
        Ok(touches)
    }

    /// Whether a buffer that passes write has room for what a shader binds it as.
    fn check_room(&self, source: &Source, kind: &BindingKind) -> Result<(), Error> {
        let (BindingKind::Storage { layout, .. }, Some(buffer)) =
            (kind, self.resources.written.get(&source.name))
        else {
            return Ok(());
        };
        let (size, needed) = (buffer.size(), u64::from(layout.size));
        if size >= needed {
            return Ok(());
        }
        let problem = format!(
            "the buffer `{}` of {size} bytes, where a shader needs {needed} at the least",
            source.name
        );
        Err(self.bad(&problem))
    }

    /// How many workgroups a pass runs, checked; the buffer that they are read from.
    fn check_workgroups(&self, pass: &ComputePass) -> Result<Option<Place>, Error> {
        let (buffer, offset) = match &pass.workgroups {
            Workgroups::Count(count) => {
                let limits = self.shared.device.limits();
                let limit = limits.max_compute_workgroups_per_dimension;
                if count.iter().all(|n| (1..=limit).contains(n)) {
                    return Ok(None);
                }
                let problem = format!(
                    "{count:?} workgroups of `{}`, where the device allows from 1 to {limit} each way",
                    pass.shader
                );
                return Err(self.bad(&problem));
            }
            Workgroups::Indirect { buffer, offset } => (buffer, *offset),
        };
        let size = self.resources.written.get(buffer).map(wgpu::Buffer::size);
        let problem = match size {
            None => "which is no buffer that its passes write".to_owned(),
            Some(size)
                if offset % 4 != 0 || offset.checked_add(12).is_none_or(|end| end > size) =>
            {
                format!("of {size} bytes, which has no three words from byte {offset} on")
            }
            Some(_) => return Ok(Some((buffer.clone(), 0, 0))),
        };
        let problem = format!(
            "workgroups of `{}` by the buffer `{buffer}`, {problem}",
            pass.shader
        );
        Err(self.bad(&problem))
    }

    /// The places that a binding reads or writes; none where no pass fills what it reads.
    fn places(&self, source: &Source, writes: bool) -> Result<Vec<Place>, Error> {
        let name = &source.name;
        if self.resources.written.contains_key(name) {
            return Ok(vec![(name.clone(), 0, 0)]);
        }
        let Some((desc, _)) = self.texture(name) else {
            if !writes {
                return Ok(Vec::new());
            }
            let problem =
                format!("the target `{name}`, which is none of its textures and written buffers");
            return Err(self.bad(&problem));
        };
        let (layers, levels) = (desc.shape.layers(), desc.levels);
        if source.layer.is_some_and(|n| n >= layers) || source.level.is_some_and(|n| n >= levels) {
            let problem = format!(
                "what reads or writes {source:?}, which has {layers} layers and {levels} levels"
            );
            return Err(self.bad(&problem));
        }
        let one = |n: u32| n..n + 1;
        let layers = source.layer.map_or(0..layers, one);
        let levels = match source.level {
            None if writes => 0..1,
            level => level.map_or(0..levels, one),
        };
        let places = layers.flat_map(|layer| levels.clone().map(move |level| (layer, level)));
        Ok(places
            .map(|(layer, level)| (name.clone(), layer, level))
            .collect())
    }

    /// Whether all that a pass reads is filled before it.
    pub(crate) fn check_reads<'a>(
        &self,
        plan: &ShadowPlan,
        passes: impl Iterator<Item = &'a Touches>,
    ) -> Result<(), Error> {
        let uploaded = plan.contents.iter();
        let uploaded = uploaded.map(|contents| (contents.texture.clone(), 0, 0));
        let mut filled: BTreeSet<Place> = uploaded.collect();
        for (pass, touches) in plan.passes.iter().zip(passes) {
            let mut reads = touches.reads.iter();
            if let Some(place) = reads.find(|place| !filled.contains(*place)) {
                let problem = format!(
                    "`{}` reads {}, which has no contents and no pass before writes",
                    pass.shader(),
                    self.words(place)
                );
                return Err(self.bad(&problem));
            }
            filled.extend(touches.writes.iter().cloned());
        }
        Ok(())
    }

    /// A place as errors call it.
    fn words(&self, (name, layer, level): &Place) -> String {
        match self.texture(name) {
            Some((desc, _)) if desc.levels > 1 || desc.shape != TextureShape::D2 => {
                format!("level {level} of layer {layer} of `{name}`")
            }
            _ => format!("`{name}`"),
        }
    }

    /// Resources of a pass whose shader is `permutation`.
    pub(crate) fn given_to(
        &self,
        reads: &Reads,
        permutation: &Permutation,
    ) -> Result<ShadowResources, Error> {
        let mut given = self.resources.clone();
        given.constants = reads.constants.clone();
        for binding in &permutation.reflection.bindings {
            let (to, source) = (binding.name.clone(), source(&reads.renamed, &binding.name));
            let depth = self.job.camera_depth;
            if let Some(depth) = depth.filter(|_| source.name == Reads::CAMERA_DEPTH) {
                let format = depth.view.texture().format();
                given.textures.insert(to, (format, depth.view.clone()));
            } else if let Some(buffer) = self.resources.written.get(&source.name) {
                given.written.insert(to, buffer.clone());
            } else if let Some(value) = self.resources.buffers.get(&source.name) {
                given.buffers.insert(to, value.clone());
            } else if let Some((desc, texture)) = self.texture(&source.name) {
                let (dimension, stored) = match binding.kind {
                    BindingKind::Texture { dimension, .. } => (dimension, false),
                    BindingKind::StorageTexture { dimension, .. } => (dimension, true),
                    _ => continue,
                };
                let view = self.view((desc, texture), &source, (dimension, stored))?;
                given.textures.insert(to, (desc.format, view));
            }
        }
        Ok(given)
    }

    /// A view of a texture of this shape, as a shader binds it.
    fn view(
        &self,
        (desc, texture): (&TextureDesc, &wgpu::Texture),
        source: &Source,
        (dimension, stored): (TextureDimension, bool),
    ) -> Result<wgpu::TextureView, Error> {
        let layers = desc.shape.layers();
        let (dimension, first, count) = match (dimension, source.layer) {
            (TextureDimension::D2, None) if layers == 1 => (wgpu::TextureViewDimension::D2, 0, 1),
            (TextureDimension::D2, Some(layer)) => (wgpu::TextureViewDimension::D2, layer, 1),
            (TextureDimension::D2Array, layer) => {
                let (first, count) = layer.map_or((0, layers), |layer| (layer, 1));
                (wgpu::TextureViewDimension::D2Array, first, count)
            }
            (TextureDimension::Cube, None) if desc.shape == TextureShape::Cube => {
                (wgpu::TextureViewDimension::Cube, 0, layers)
            }
            (dimension, layer) => {
                let problem = format!(
                    "the texture `{}` of {layers} layers where a shader reads one of shape {dimension:?}, layer {layer:?}",
                    desc.name
                );
                return Err(self.bad(&problem));
            }
        };
        let levels = (stored || source.level.is_some()).then_some(1);
        Ok(texture.create_view(&wgpu::TextureViewDescriptor {
            dimension: Some(dimension),
            base_array_layer: first,
            array_layer_count: Some(count),
            base_mip_level: source.level.unwrap_or(0),
            mip_level_count: levels,
            ..Default::default()
        }))
    }
}

impl Targets {
    const NONE: Self = Self {
        depth: None,
        colors: Vec::new(),
    };
}

/// Whether a pass with this shader reads the camera's depth.
pub(crate) fn reads_camera_depth(pass: &Pass, permutation: &Permutation) -> bool {
    let renamed = pass.reads().map_or(&[][..], |reads| &reads.renamed);
    let mut bindings = permutation.reflection.bindings.iter();
    bindings.any(|binding| source(renamed, &binding.name).name == Reads::CAMERA_DEPTH)
}

/// What a pass has for a binding.
pub(crate) fn source(renamed: &[(String, Source)], binding: &str) -> Source {
    let found = renamed.iter().find(|(from, _)| from == binding);
    found.map_or_else(|| binding.into(), |(_, source)| source.clone())
}

fn place(target: &Slice) -> Place {
    (target.texture.clone(), target.layer, target.level)
}

/// Whether a format is of depth alone.
fn is_depth(format: wgpu::TextureFormat) -> bool {
    format.has_depth_aspect() && !format.has_stencil_aspect()
}

/// Whether a format is of floats that can be drawn into.
fn is_floats(format: wgpu::TextureFormat) -> bool {
    let sample = format.sample_type(None, None);
    let floats = matches!(sample, Some(wgpu::TextureSampleType::Float { .. }));
    floats && format.has_color_aspect()
}

/// The channels that a format has.
fn channels(format: wgpu::TextureFormat) -> wgpu::ColorWrites {
    wgpu::ColorWrites::from_bits_truncate((1 << format.components()) - 1)
}

fn channel_names(channels: wgpu::ColorWrites) -> String {
    let names = [(1, 'r'), (2, 'g'), (4, 'b'), (8, 'a')].into_iter();
    let set = names.filter(|(bit, _)| channels.bits() & bit != 0);
    set.map(|(_, name)| name).collect()
}

pub(crate) fn attachment(color: &Color) -> Option<wgpu::RenderPassColorAttachment<'_>> {
    Some(wgpu::RenderPassColorAttachment {
        view: &color.view,
        depth_slice: None,
        resolve_target: None,
        ops: wgpu::Operations {
            load: color.load,
            store: wgpu::StoreOp::Store,
        },
    })
}

pub(crate) fn depth_attachment(
    (_, view, load): &(wgpu::TextureFormat, wgpu::TextureView, wgpu::LoadOp<f32>),
) -> wgpu::RenderPassDepthStencilAttachment<'_> {
    wgpu::RenderPassDepthStencilAttachment {
        view,
        depth_ops: Some(wgpu::Operations {
            load: *load,
            store: wgpu::StoreOp::Store,
        }),
        stencil_ops: None,
    }
}

pub(crate) fn bad_plan(job: &Job<'_>, problem: &str) -> Error {
    Error::BadPlan {
        light: job.name.to_owned(),
        method: job.shadow.method().name().to_owned(),
        problem: problem.to_owned(),
    }
}

/// Whether regions of view depth follow each other, with axes of the chosen parts.
pub(crate) fn check_regions(job: &Job<'_>, regions: &[Region]) -> Result<(), Error> {
    if regions.len() > MAX_REGIONS {
        let problem = format!(
            "{} regions of view depth: {MAX_REGIONS} at the most",
            regions.len()
        );
        return Err(bad_plan(job, &problem));
    }
    let mut start = 0.0;
    for Region { end, axes } in regions {
        // NaN is not beyond.
        if !(*end > start && end.is_finite()) {
            let problem = format!("a region of view depth from {start} m to {end} m");
            return Err(bad_plan(job, &problem));
        }
        let known = job.shadow.choice.axes();
        if let Some(axis) = axes.keys().find(|axis| !known.contains(&axis.as_str())) {
            let problem = format!("a region with the axis `{axis}`, which is none of its axes");
            return Err(bad_plan(job, &problem));
        }
        start = *end;
    }
    Ok(())
}

//! Targets of passes, checked against the plan's textures.

use umbrage_shadow::{Blend, CasterPass, ColorTarget, ScreenPass, Slice, TextureDesc, Viewport};

use crate::{
    ColorState, DrawState, Error, MAX,
    area::{Area, Empty},
    bind::Part,
    check::bad_plan,
    execute::Execution,
    touches::place,
};

/// Targets of a render pass.
pub(crate) struct Targets {
    /// The depth's format, its view, and how it begins.
    pub(crate) depth: Option<(wgpu::TextureFormat, wgpu::TextureView, wgpu::LoadOp<f32>)>,
    pub(crate) colors: Vec<Color>,
}

impl Targets {
    /// Has all targets begin with what is there; the values that they would have begun with in place of that.
    pub(crate) fn keep(&mut self) -> Option<Empty> {
        let bits = |load: &mut wgpu::LoadOp<wgpu::Color>| match std::mem::replace(
            load,
            wgpu::LoadOp::Load,
        ) {
            wgpu::LoadOp::Clear(color) => Some((color.r as f32).to_bits()),
            _ => None,
        };
        let depth = self.depth.as_mut().and_then(|(_, _, load)| {
            match std::mem::replace(load, wgpu::LoadOp::Load) {
                wgpu::LoadOp::Clear(depth) => Some(depth.to_bits()),
                _ => None,
            }
        });
        let colors: Vec<_> = self
            .colors
            .iter_mut()
            .map(|color| bits(&mut color.load))
            .collect();
        let state = DrawState {
            colors: self.colors.iter().map(|color| color.state).collect(),
            depth: self.depth.as_ref().map(|(format, ..)| *format),
            ..DrawState::NOTHING
        };
        let colors = colors.into_iter().collect::<Option<Vec<_>>>()?;
        (depth.is_some() == state.depth.is_some()).then_some(Empty {
            state,
            depth,
            colors,
        })
    }
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
    pub(crate) fn texture(&self, name: &str) -> Option<&(TextureDesc, wgpu::Texture)> {
        let own = self.resources.textures.contains_key(name);
        self.memory.textures.get(name).filter(|_| own)
    }

    /// The texture that a slice is of.
    pub(crate) fn sliced(&self, target: &Slice) -> Result<&(TextureDesc, wgpu::Texture), Error> {
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
    fn target(&mut self, target: &Slice, area: &Viewport) -> Result<Found, Error> {
        let (desc, texture) = self.sliced(target)?.clone();
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
        let part = Part {
            dimension: wgpu::TextureViewDimension::D2,
            layers: [layer, 1],
            level: (level, Some(1)),
        };
        let view = self.shared.binder.view(&texture, part);
        Ok(Found { desc, view, size })
    }

    /// Targets of a pass of casters.
    pub(crate) fn caster_targets(
        &mut self,
        pass: &CasterPass,
        area: Option<Area>,
    ) -> Result<Targets, Error> {
        let part = area.map(|_| [pass.viewport.x, pass.viewport.y]);
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
            let load = match self.begins(&depth.target, part) || depth.clears {
                true => wgpu::LoadOp::Clear(found.desc.empty),
                false => wgpu::LoadOp::Load,
            };
            targets.depth = Some((found.desc.format, found.view, load));
        }
        for color in &pass.colors {
            let found = self.target(&color.target, &pass.viewport)?;
            self.same_size(&mut first, &found)?;
            targets.colors.push(self.color(color, found, part)?);
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
                targets.colors.push(self.color(&color, found, None)?);
            } else if targets.depth.is_some() {
                return Err(self.bad("a full-screen pass into two textures of depth"));
            } else {
                let load = match self.begins(target, None) {
                    true => wgpu::LoadOp::Clear(found.desc.empty),
                    false => wgpu::LoadOp::Load,
                };
                targets.depth = Some((found.desc.format, found.view, load));
            }
        }
        self.check_colors(&targets)?;
        Ok(targets)
    }

    /// Whether a pass is the plan's first one into a slice, or into `part` of it, known by its corner.
    fn begins(&mut self, target: &Slice, part: Option<[u32; 2]>) -> bool {
        self.filled.insert((place(target), part))
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
    fn color(
        &mut self,
        color: &ColorTarget,
        found: Found,
        part: Option<[u32; 2]>,
    ) -> Result<Color, Error> {
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
        let load = match self.begins(&color.target, part) {
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
}

impl Targets {
    const NONE: Self = Self {
        depth: None,
        colors: Vec::new(),
    };
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

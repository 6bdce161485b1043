//! The mask path: shadow terms found once for each pixel of the picture, before light is added.

use std::collections::BTreeMap;

use glam::{DVec3, Vec2, Vec3};
use umbrage_shadow::{Aabb, Constants, Value, View};
use umbrage_wgpu::{DrawState, ShadowResources};

use super::{
    Path, RenderOptions, Renderer, Shot,
    assets::Vertices,
    draw::record,
    frame::{FrameState, LightInputs, PassInputs, SEEN_PLANES, state, unfiltered},
    passes::NamedPass,
    target::{Target, begin},
};
use crate::{RenderError, scene::Object};

/// The binding of a light's mask.
const MASK: &str = "shadow_mask";

/// A shadow term, in 4 bytes a pixel: what a method found, to the last bit, as the other path has it.
pub(super) const TERM: wgpu::TextureFormat = wgpu::TextureFormat::R32Float;

/// Textures that the mask path keeps for a picture. One mask serves all lights in turn.
pub(super) struct Masks {
    pub(super) mask: wgpu::TextureView,
    /// Each pixel's region, once a light has some.
    pub(super) regions: Option<wgpu::TextureView>,
}

/// A light whose mask is filled.
#[derive(Clone, Copy)]
pub(super) struct Masked<'a> {
    pub(super) shot: &'a Shot<'a>,
    pub(super) reads: LightInputs<'a>,
    /// Objects that may be seen, of those it reaches.
    pub(super) receivers: &'a [&'a Object],
}

/// A triangle around the picture, drawn in a pass of its own for a light's mask.
pub(super) struct MaskPass<'a> {
    /// Name of the pass in the times.
    pub(super) name: &'a str,
    /// The colour texture, and what it is cleared to.
    pub(super) color: (&'a wgpu::TextureView, Option<wgpu::Color>),
    /// The depth texture, and whether it is cleared.
    pub(super) depth: (&'a wgpu::TextureView, bool),
    /// The depth that the triangle lies at.
    pub(super) level: f32,
    /// The pixels to draw: left, top, width, height.
    pub(super) area: [u32; 4],
}

/// The members of the shader's block `rays`.
pub(super) fn rays(view: &View, options: &RenderOptions) -> Constants {
    // A pixel's sides, 1 m before the camera.
    let seen = view.projection.size_at(1.0);
    let (wide, tall) = (
        seen.x / f64::from(options.width),
        seen.y / f64::from(options.height),
    );
    let vector = |v: DVec3| Value::Vec3((view.rotation * v).as_vec3());
    let middle = Vec2::new(options.width as f32, options.height as f32) * 0.5;
    Constants::new()
        .with("forward", vector(DVec3::NEG_Z))
        .with("right", vector(DVec3::X * wide))
        .with("down", vector(DVec3::NEG_Y * tall))
        .with("middle", Value::Vec2(middle))
}

impl Renderer {
    /// The mask of the light that `reads` tells of, where the path asks for one and the light has a method:
    /// what a shader that reads the mask binds in place of what the method gives. `masks` are made when
    /// first needed; `fresh` lays down depth with them, else it is there already.
    pub(super) fn mask(
        &mut self,
        frame: &mut FrameState<'_>,
        shot: &Shot<'_>,
        (target, fresh): (&Target, bool),
        masks: &mut Option<Masks>,
        (reads, lit): (LightInputs<'_>, &[usize]),
    ) -> Result<Option<ShadowResources>, RenderError> {
        if !frame.options.path.has_masks() || reads.shadow.is_none() {
            return Ok(None);
        }
        self.lay_planes(frame, shot, (target, fresh))?;
        let laid = match masks.take() {
            Some(laid) => laid,
            None => self.mask_texture(frame)?,
        };
        let laid = masks.insert(laid);
        let receivers = lit.iter().map(|slot| frame.objects.at(*slot));
        let receivers: Vec<_> = receivers.collect();
        let light = Masked {
            shot,
            reads,
            receivers: &receivers,
        };
        if frame.options.path == Path::MaskBySplit && has_regions(reads.shadow) {
            self.fill_by_region(frame, laid, light)?;
        } else {
            self.fill_at_once(frame, target, laid, light)?;
        }
        let mask = (TERM, laid.mask.clone());
        Ok(Some(ShadowResources {
            textures: BTreeMap::from([(MASK.to_owned(), mask)]),
            ..ShadowResources::default()
        }))
    }

    fn mask_texture(&mut self, frame: &mut FrameState<'_>) -> Result<Masks, RenderError> {
        let usage = wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::TEXTURE_BINDING;
        let mask = self.mask_part(frame, "the shadow mask", TERM, usage)?;
        Ok(Masks {
            mask,
            regions: None,
        })
    }

    /// A texture of the mask path's, as large as the picture.
    pub(super) fn mask_part(
        &mut self,
        frame: &mut FrameState<'_>,
        what: &str,
        format: wgpu::TextureFormat,
        usage: wgpu::TextureUsages,
    ) -> Result<wgpu::TextureView, RenderError> {
        let size = [frame.options.width, frame.options.height];
        let pixels = wgpu::Extent3d {
            width: size[0],
            height: size[1],
            depth_or_array_layers: 1,
        };
        frame.report.mask_bytes += format.theoretical_memory_footprint(pixels);
        Ok(self.targets.take(&self.gpu, what, size, format, usage)?)
    }

    /// Fills the mask where the light's receivers are.
    fn fill_at_once(
        &mut self,
        frame: &mut FrameState<'_>,
        target: &Target,
        masks: &Masks,
        light: Masked<'_>,
    ) -> Result<(), RenderError> {
        let inputs = light.inputs(
            self.pass("mask")?,
            state(TERM, wgpu::CompareFunction::NotEqual),
        );
        let pass = MaskPass {
            name: inputs.pass.name,
            color: (&masks.mask, Some(wgpu::Color::WHITE)),
            depth: (&target.depth, false),
            level: 0.0,
            area: light.area(frame, light.receivers),
        };
        self.draw_mask(frame, light, &inputs, &pass)
    }

    /// Records a pass of one triangle around the picture, for the light's sake.
    pub(super) fn draw_mask(
        &mut self,
        frame: &mut FrameState<'_>,
        light: Masked<'_>,
        inputs: &PassInputs<'_>,
        screen: &MaskPass<'_>,
    ) -> Result<(), RenderError> {
        let mut commands = Vec::new();
        if let Some(first) = light.receivers.first() {
            commands.push(self.prepare_screen(frame, inputs, &first.name)?);
        }
        let mark = frame.timer.mark(
            &self.gpu,
            (screen.name, inputs.pass.purpose),
            inputs.cause,
            false,
        );
        let mut pass = begin(
            &mut frame.encoder,
            screen.color,
            screen.depth,
            mark.as_ref(),
        );
        let [x, y, width, height] = screen.area;
        let (wide, tall) = (frame.options.width as f32, frame.options.height as f32);
        pass.set_viewport(0.0, 0.0, wide, tall, screen.level, screen.level);
        pass.set_scissor_rect(x, y, width, height);
        record(&mut pass, &commands);
        drop(pass);
        frame.report.passes += 1;
        Ok(())
    }
}

impl<'a> Masked<'a> {
    /// Inputs of a pass over the picture.
    pub(super) fn inputs(&self, pass: NamedPass<'a>, mut state: DrawState) -> PassInputs<'a> {
        let lights = vec![self.reads];
        state.unfiltered = unfiltered(&lights);
        state.unfiltered.insert((0, SEEN_PLANES.to_owned()));
        PassInputs {
            pass,
            cause: Some(&self.reads.setup.source.name),
            view_proj: self.shot.view_proj,
            ambient: Vec3::ZERO,
            lights,
            vertices: Vertices::Shared,
            state,
        }
    }

    /// The pixels (left, top, width, height) that some of `objects` may be seen at.
    pub(super) fn area(&self, frame: &FrameState<'_>, objects: &[&Object]) -> [u32; 4] {
        let boxes = objects.iter().map(|object| object.bounds);
        let size = [frame.options.width, frame.options.height];
        area(&self.shot.view, size, boxes)
    }
}

fn has_regions(shadow: Option<&ShadowResources>) -> bool {
    shadow.is_some_and(|shadow| !shadow.regions.is_empty())
}

/// The pixels (left, top, width, height) that what lies in `boxes` can be seen at: all where one of them
/// reaches behind the near plane.
fn area(view: &View, size: [u32; 2], boxes: impl Iterator<Item = Aabb>) -> [u32; 4] {
    let clip = view.view_proj_relative();
    let extent = Vec2::new(size[0] as f32, size[1] as f32).as_dvec2();
    let mut around = None;
    for corner in boxes.flat_map(|b| b.translate(-view.position).corners()) {
        let at = clip * corner.extend(1.0);
        // Before the near plane, where a perspective has none.
        if at.z > at.w {
            return [0, 0, size[0], size[1]];
        }
        let place = glam::DVec2::new(at.w + at.x, at.w - at.y) / (2.0 * at.w) * extent;
        let (least, most) = around.unwrap_or((place, place));
        around = Some((place.min(least), place.max(most)));
    }
    let Some((least, most)) = around else {
        return [0, 0, size[0], size[1]];
    };
    // A pixel more, for what rounding and the rasteriser's grid may add.
    let least = (least.floor() - 1.0)
        .clamp(glam::DVec2::ZERO, extent)
        .as_uvec2();
    let most = (most.ceil() + 1.0)
        .clamp(glam::DVec2::ZERO, extent)
        .as_uvec2();
    let across = most - least;
    [least.x, least.y, across.x, across.y]
}

#[cfg(test)]
mod tests {
    use glam::DQuat;
    use umbrage_shadow::{Field, Projection};

    use super::*;

    fn view() -> View {
        View {
            position: DVec3::new(1e6, 20.0, -3.0),
            rotation: DQuat::from_euler(glam::EulerRot::YXZ, 0.7, -0.4, 0.2),
            projection: Projection {
                field: Field::Perspective { fov_y: 0.9 },
                aspect: 1.6,
                near: 0.1,
                far: 300.0,
            },
            eye: 0.0,
        }
    }

    /// The shader's sum, by the block's own numbers, goes back to where the projection came from.
    #[test]
    fn rays_lead_to_what_is_seen() {
        let view = view();
        let options = RenderOptions {
            width: 400,
            height: 250,
            ..RenderOptions::default()
        };
        let constants = rays(&view, &options);
        let vector = |name: &str| match constants.get(name) {
            Some(Value::Vec3(v)) => v.as_dvec3(),
            other => unreachable!("{name} is {other:?}"),
        };
        let clip = view.view_proj_relative();
        for seen in [[0.3, -0.2, -5.0], [-3.0, 1.0, -9.0], [0.0, 0.0, -200.0]] {
            let point = view.rotation * DVec3::from(seen);
            let ndc = clip.project_point3(point);
            let aside = glam::DVec2::new(ndc.x * 200.0, -ndc.y * 125.0);
            let depth = point.dot(vector("forward"));
            let ray = vector("forward") + aside.x * vector("right") + aside.y * vector("down");
            let error = (ray * depth).distance(point);
            assert!(error < 1e-6 * point.length(), "{seen:?}: {error} m");
        }
    }

    #[test]
    fn an_area_holds_its_boxes_and_little_more() {
        let view = view();
        let cube = |seen: DVec3, half: f64| {
            let middle = view.position + view.rotation * seen;
            Aabb {
                min: middle - half,
                max: middle + half,
            }
        };
        let all = [0, 0, 400, 250];
        let area = |boxes: &[Aabb]| area(&view, [400, 250], boxes.iter().copied());
        let [x, y, width, height] = area(&[cube(DVec3::new(0.0, 0.0, -50.0), 1e-9)]);
        // The middle of the picture lies between pixels, and a pixel around is added.
        assert_eq!([x, y], [198, 123]);
        assert!(width <= 4 && height <= 4, "{width} by {height}");
        // Behind the camera, nothing can be told.
        assert_eq!(area(&[cube(DVec3::Z, 0.5)]), all);
        assert_eq!(area(&[cube(DVec3::ZERO, 50.0)]), all);
        assert_eq!(area(&[]), all);
        // Beside the picture nothing is left.
        let beside = area(&[cube(DVec3::new(90.0, 0.0, -50.0), 1.0)]);
        assert_eq!(beside[2], 0, "{beside:?}");
    }
}

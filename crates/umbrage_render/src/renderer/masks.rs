//! The mask path: shadow terms found once for each pixel of the picture, before light is added.

use std::collections::BTreeMap;

use glam::{DVec3, Vec2, Vec3};
use umbrage_shadow::{Aabb, Constants, Value, View};

use super::{
    Path, RenderOptions, Renderer, Shot,
    assets::Vertices,
    draw::{FrameState, LightInputs, PassInputs, record},
    pipelines::{ColorState, DrawState},
    resources::{ShadowResources, unfiltered},
    target::{DEPTH, Target, begin},
};
use crate::RenderError;

/// The binding of what `linear_depth` lays down.
pub(super) const SEEN_PLANES: &str = "seen_planes";

/// The binding of a light's mask.
const MASK: &str = "shadow_mask";

/// Each pixel's plane: the unit normal and the linear depth, 0 where nothing is seen. In 16 bytes a
/// pixel, all floats: a normal in two halves is 1e-3 radians off, which at the slope of 19 that a
/// method follows a receiver's plane to moves the plane by a third.
const PLANE: wgpu::TextureFormat = wgpu::TextureFormat::Rgba32Float;

/// A shadow term, in 4 bytes a pixel: what a method found, to the last bit, as the other path has it.
const TERM: wgpu::TextureFormat = wgpu::TextureFormat::R32Float;

/// What the mask path keeps for a picture. One mask serves all lights in turn.
pub(super) struct Masks {
    mask: wgpu::TextureView,
}

/// The members of the shader's block `rays`.
pub(super) fn rays(view: &View, options: &RenderOptions) -> Constants {
    let (width, height) = (f64::from(options.width), f64::from(options.height));
    // A pixel's side, 1 m before the camera.
    let tall = 2.0 * (0.5 * view.projection.fov_y).tan() / height;
    let wide = tall * view.projection.aspect * height / width;
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
        if frame.options.path != Path::Mask || reads.shadow.is_none() {
            return Ok(None);
        }
        let laid = match masks.take() {
            Some(laid) => laid,
            None => self.lay_planes(frame, shot, target, fresh)?,
        };
        let laid = masks.insert(laid);
        self.fill_mask(frame, (shot, target), laid, reads, lit)
            .map(Some)
    }

    /// Lays down the planes that are seen.
    fn lay_planes(
        &mut self,
        frame: &mut FrameState<'_>,
        shot: &Shot<'_>,
        target: &Target,
        fresh: bool,
    ) -> Result<Masks, RenderError> {
        use wgpu::TextureUsages as Usage;
        let (width, height) = (frame.options.width, frame.options.height);
        let size = wgpu::Extent3d {
            width,
            height,
            depth_or_array_layers: 1,
        };
        let usage = Usage::RENDER_ATTACHMENT | Usage::TEXTURE_BINDING;
        let planes = self.gpu.texture("the planes seen", size, 1, PLANE, usage)?;
        let mask = self.gpu.texture("the shadow mask", size, 1, TERM, usage)?;
        frame.report.mask_bytes +=
            PLANE.theoretical_memory_footprint(size) + TERM.theoretical_memory_footprint(size);
        let view = |texture: &wgpu::Texture| texture.create_view(&Default::default());
        let (planes, mask) = (view(&planes), view(&mask));
        let inputs = PassInputs {
            pass: "linear_depth",
            cause: None,
            view_proj: shot.view_proj,
            ambient: Vec3::ZERO,
            light: None,
            vertices: Vertices::Shared,
            state: DrawState {
                write_depth: fresh,
                ..state(PLANE, wgpu::CompareFunction::GreaterEqual)
            },
        };
        let commands = self.prepare(frame, &inputs, &shot.visible)?;
        let mark = frame.timer.mark(&self.gpu, inputs.pass, None);
        let nothing = Some(wgpu::Color::TRANSPARENT);
        let mut pass = begin(
            &mut frame.encoder,
            (&planes, nothing),
            (&target.depth, fresh),
            mark.as_ref(),
        );
        record(&mut pass, &commands);
        drop(pass);
        frame.report.passes += 1;
        frame.planes = Some(planes);
        Ok(Masks { mask })
    }

    /// Fills the mask where the light's receivers, at `lit`, are.
    fn fill_mask(
        &mut self,
        frame: &mut FrameState<'_>,
        (shot, target): (&Shot<'_>, &Target),
        masks: &Masks,
        reads: LightInputs<'_>,
        lit: &[usize],
    ) -> Result<ShadowResources, RenderError> {
        let mut state = state(TERM, wgpu::CompareFunction::NotEqual);
        state.unfiltered = unfiltered(reads.shadow);
        state.unfiltered.insert(SEEN_PLANES.to_owned());
        let light = reads.setup.source.name.as_str();
        let inputs = PassInputs {
            pass: "mask",
            cause: Some(light),
            view_proj: shot.view_proj,
            ambient: Vec3::ZERO,
            light: Some(reads),
            vertices: Vertices::Shared,
            state,
        };
        let receivers = frame.objects.iter();
        let receivers: Vec<_> = receivers
            .filter(|(slot, _)| lit.binary_search(slot).is_ok())
            .map(|(_, object)| object)
            .collect();
        let mut commands = Vec::new();
        if let Some(first) = receivers.first() {
            commands.push(self.prepare_screen(frame, &inputs, &first.name)?);
        }
        let boxes = receivers.iter().map(|object| object.bounds);
        let size = [frame.options.width, frame.options.height];
        let area = area(&shot.view, size, boxes);
        let mark = frame.timer.mark(&self.gpu, inputs.pass, Some(light));
        let mut pass = begin(
            &mut frame.encoder,
            (&masks.mask, Some(wgpu::Color::WHITE)),
            (&target.depth, false),
            mark.as_ref(),
        );
        let [x, y, width, height] = area;
        pass.set_scissor_rect(x, y, width, height);
        record(&mut pass, &commands);
        drop(pass);
        frame.report.passes += 1;
        let mask = (TERM, masks.mask.clone());
        Ok(ShadowResources {
            textures: BTreeMap::from([(MASK.to_owned(), mask)]),
            ..ShadowResources::default()
        })
    }
}

/// Depth is only looked at.
fn state(format: wgpu::TextureFormat, compare: wgpu::CompareFunction) -> DrawState {
    DrawState {
        color: Some(ColorState {
            format,
            blend: None,
            channels: wgpu::ColorWrites::ALL,
        }),
        depth: Some(DEPTH),
        compare,
        write_depth: false,
        cull: None,
        front: wgpu::FrontFace::Ccw,
        unfiltered: Default::default(),
    }
}

/// The pixels (left, top, width, height) that what lies in `boxes` can be seen at: all where one of them
/// reaches behind the near plane.
fn area(view: &View, size: [u32; 2], boxes: impl Iterator<Item = Aabb>) -> [u32; 4] {
    let clip = view.view_proj_relative();
    let extent = Vec2::new(size[0] as f32, size[1] as f32).as_dvec2();
    let mut around = None;
    for corner in boxes.flat_map(|b| b.translate(-view.position).corners()) {
        let at = clip * corner.extend(1.0);
        if at.w < view.projection.near {
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
    use umbrage_shadow::Projection;

    use super::*;

    fn view() -> View {
        View {
            position: DVec3::new(1e6, 20.0, -3.0),
            rotation: DQuat::from_euler(glam::EulerRot::YXZ, 0.7, -0.4, 0.2),
            projection: Projection {
                fov_y: 0.9,
                aspect: 1.6,
                near: 0.1,
                far: 300.0,
            },
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

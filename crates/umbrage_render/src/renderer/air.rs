//! A scene's air, where it is a medium: it dims what is seen, and scatters light on the way to the eye.

use glam::{DVec2, DVec3, Vec3};
use umbrage_shadow::{Aabb, Constants, LightKind, Value, View};
use umbrage_wgpu::{ColorState, DrawState};

use super::{
    RenderOptions, Renderer, Shot,
    assets::Vertices,
    draw::record,
    frame::{FrameState, Lamp, LightInputs, PassInputs, unfiltered},
    lights::{LightSetup, Term},
    passes::NamedPass,
    target::Target,
};
use crate::{RenderError, scene::Medium};

/// Passes that draw no object are drawn for its sake.
pub(super) const AIR: &str = "the air";

/// The air that a light reaches, where it is seen and scatters.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct LitAir {
    /// The box in which something may keep the light off, world space; none where nothing may.
    pub(super) shaded: Option<Aabb>,
}

/// Part of the air that `light` reaches; none where nothing of it would be seen.
pub(super) fn lit(shot: &Shot<'_>, light: &LightSetup<'_>) -> Option<LitAir> {
    shot.scene.medium.filter(|air| air.scattering > 0.0)?;
    let corners = shot.view.frustum_relative().corners();
    let seen = Aabb::from_points(corners)?.translate(shot.view.position);
    match light.source.light.kind {
        // Beyond all objects shadows have no end, but no one can say how far it is to where none fall.
        LightKind::Directional { .. } => {
            let objects = shot.scene.objects.iter().map(|object| object.bounds);
            let objects = objects.filter(Aabb::is_finite).reduce(Aabb::union);
            Some(LitAir {
                shaded: objects.and_then(|all| all.intersection(seen)),
            })
        }
        LightKind::Spot {
            position, range, ..
        }
        | LightKind::Point { position, range } => {
            let around = Aabb {
                min: position - DVec3::splat(range),
                max: position + DVec3::splat(range),
            };
            let shaded = around.intersection(seen)?;
            let reached =
                light.source.light.reaches(&shaded) && shot.view.frustum().intersects(&shaded);
            reached.then_some(LitAir {
                shaded: Some(shaded),
            })
        }
    }
}

/// `rays` with what the air's passes read of that block: the medium, and how depth becomes linear.
pub(super) fn constants(
    rays: Constants,
    view: &View,
    medium: &Medium,
    options: &RenderOptions,
) -> Constants {
    let depth_terms = DVec2::from(view.projection.depth_terms()).as_vec2();
    let number = |value: f64| Value::F32(value as f32);
    rays.with("depth_terms", Value::Vec2(depth_terms))
        .with("scattering", number(medium.scattering))
        .with("extinction", number(medium.extinction()))
        .with("anisotropy", number(medium.anisotropy))
        .with("steps", Value::U32(options.shaft_steps))
}

impl Renderer {
    /// Dims the picture by the air before what is seen, and adds what of the `lamps`' light the air scatters.
    pub(super) fn add_air(
        &mut self,
        frame: &mut FrameState<'_>,
        shot: &Shot<'_>,
        target: &Target,
        lamps: &[&Lamp<'_>],
    ) -> Result<(), RenderError> {
        let extinction = shot.scene.medium.map_or(0.0, |air| air.extinction());
        if extinction > 0.0 {
            self.draw_air(frame, shot, target, self.pass("haze")?, None)?;
        }
        for lamp in lamps {
            self.draw_air(frame, shot, target, self.pass("shafts")?, Some(lamp))?;
        }
        Ok(())
    }

    /// Puts in place of the picture how many texture fetches a light's shafts take.
    pub(super) fn count_shafts(
        &mut self,
        frame: &mut FrameState<'_>,
        shot: &Shot<'_>,
        target: &Target,
        lamp: &Lamp<'_>,
    ) -> Result<(), RenderError> {
        let pass = self.pass("shaft_fetches")?;
        self.draw_air(frame, shot, target, pass, Some(lamp))
    }

    /// Draws one of the air's passes over the whole picture, by the depth that `target` has.
    fn draw_air(
        &mut self,
        frame: &mut FrameState<'_>,
        shot: &Shot<'_>,
        target: &Target,
        pass: NamedPass<'_>,
        lamp: Option<&Lamp<'_>>,
    ) -> Result<(), RenderError> {
        let light = lamp.map(|lamp| LightInputs {
            term: Term::Air,
            ..lamp.reads()
        });
        let lights: Vec<_> = light.into_iter().collect();
        let inputs = PassInputs {
            pass,
            cause: light.map(|light| light.setup.source.name.as_str()),
            view_proj: shot.view_proj,
            ambient: Vec3::ZERO,
            vertices: Vertices::Shared,
            state: DrawState {
                colors: vec![ColorState {
                    format: target.format(),
                    blend: pass.blend,
                    channels: wgpu::ColorWrites::ALL,
                }],
                unfiltered: unfiltered(&lights),
                ..DrawState::NOTHING
            },
            lights,
        };
        frame.seen_depth = Some(target.depth.clone());
        let command = self.prepare_screen(frame, &inputs, AIR)?;
        let mark = frame
            .timer
            .mark(&self.gpu, (pass.name, pass.purpose), inputs.cause, false);
        let mut recorded = target.over(&mut frame.encoder, mark.as_ref());
        record(&mut recorded, &[command]);
        drop(recorded);
        frame.report.passes += 1;
        Ok(())
    }
}

//! Small motions of a camera, to see shadows shimmer.

use glam::{DQuat, DVec3};
use umbrage_render::{Camera, RenderError, RenderOptions, Rendered, Scene};
use umbrage_shadow::Field;

use super::{
    Lab, StudyError,
    lab::{Subject, terms},
};
use crate::{
    figures::{FigureError, Frame, Terms, shimmer},
    truth::{Sight, Truth},
};

/// How far a step goes, in pixels: no simple part of one, so that no two steps fall alike.
const STEP: f64 = 0.37;

/// The pictures of a moving camera: the scene from each place, and what is true there.
#[derive(Default)]
pub(super) struct Moving(Vec<(Scene, Truth)>);

/// `frames` cameras: the scene's own, then moved sideways, then turned about the vertical in as many steps,
/// each by less than a pixel. A pixel is taken as wide as it is at the middle depth that `sight` sees; where rays are
/// parallel, it is as wide at all depths, and the points farthest from the camera move most as the camera turns.
/// The pictures are `height` pixels high.
pub(super) fn cameras(scene: &Scene, sight: &Sight, height: u32, frames: usize) -> Vec<Camera> {
    let own = scene.camera;
    let rotation = own.rotation.normalize();
    let mut depths: Vec<f64> = (sight.seen().iter().flatten())
        .map(|seen| seen.position.dot(rotation * DVec3::NEG_Z))
        .collect();
    depths.sort_by(f64::total_cmp);
    // Metres a pixel, and radians, in the picture's middle.
    let (step, turn) = match own.field {
        Field::Perspective { fov_y } => {
            let depth = depths.get(depths.len() / 2).copied().unwrap_or(own.near);
            let pixel = 2.0 * (0.5 * fov_y).tan() / f64::from(height);
            (pixel * depth, pixel)
        }
        Field::Orthographic { height: tall } => {
            let pixel = tall / f64::from(height);
            let ends = depths.first().into_iter().chain(depths.last());
            // Seen from straight above, a turn about the vertical turns the picture, whose corners move most.
            let corner = 0.5 * pixel * f64::from(sight.width()).hypot(f64::from(sight.height()));
            let farthest = ends.fold(corner, |far, depth| far.max(depth.abs()));
            (pixel, pixel / farthest)
        }
    };
    let moves = frames.div_ceil(2);
    (0..frames)
        .map(|frame| {
            let moved = frame.min(moves) as f64;
            let turned = frame.saturating_sub(moves) as f64;
            Camera {
                position: own.position + rotation * DVec3::X * (STEP * step * moved),
                rotation: DQuat::from_rotation_y(STEP * turn * turned) * rotation,
                ..own
            }
        })
        .collect()
}

impl Moving {
    /// The scene seen by each of `cameras`, its truth found by `trace`.
    pub(super) fn new(
        scene: &Scene,
        cameras: &[Camera],
        mut trace: impl FnMut(&Scene) -> Result<Truth, StudyError>,
    ) -> Result<Self, StudyError> {
        let frames = cameras.iter().map(|camera| {
            let scene = Scene {
                camera: *camera,
                ..scene.clone()
            };
            let truth = trace(&scene)?;
            Ok((scene, truth))
        });
        frames.collect::<Result<_, StudyError>>().map(Self)
    }

    /// The same in the light of some of the lights alone, by their places.
    pub(super) fn lit_by(&self, lights: &[usize]) -> Self {
        let frames = self.0.iter().map(|(scene, truth)| {
            let mut scene = scene.clone();
            scene.lights = lights
                .iter()
                .map(|light| scene.lights[*light].clone())
                .collect();
            (scene, truth.lit_by(lights))
        });
        Self(frames.collect())
    }

    /// The pictures, with the triangles that the rasteriser draws in each.
    pub(super) fn subjects(&self, lab: &mut Lab) -> Result<Vec<Subject<'_>>, RenderError> {
        let frames = self.0.iter();
        frames
            .map(|(scene, truth)| lab.subject(scene, truth))
            .collect()
    }
}

/// The shimmer of what `options` make of the pictures of a moving camera.
pub(super) fn shimmer_of(
    lab: &mut Lab,
    subjects: &[Subject<'_>],
    options: &RenderOptions,
) -> Result<Result<Option<f64>, RenderError>, StudyError> {
    let rendered = subjects.iter().map(|subject| lab.terms(subject, options));
    match rendered.collect::<Result<Vec<_>, _>>() {
        Ok(rendered) => Ok(Ok(shimmer_between(subjects, &rendered)?)),
        Err(error) => Ok(Err(error)),
    }
}

/// The shimmer of shadow terms, each of one subject.
pub(super) fn shimmer_between(
    subjects: &[Subject<'_>],
    rendered: &[Rendered],
) -> Result<Option<f64>, FigureError> {
    let frames: Vec<_> = (subjects.iter().zip(rendered))
        .map(|(subject, rendered)| Frame {
            scene: subject.scene,
            sight: &subject.truth.sight,
            raster: &subject.raster,
            lights: subject
                .casting()
                .filter_map(|light| {
                    Some(Terms {
                        light: &subject.scene.lights.get(light)?.light,
                        truth: subject.truth.terms.get(light)?,
                        rendered: terms(rendered).get(light)?,
                    })
                })
                .collect(),
        })
        .collect();
    shimmer(&frames)
}

//! Patterns that keep to the surface, and patterns that follow the camera.

use glam::{DQuat, DVec2, DVec3};
use umbrage_render::Scene;

use super::{DOWN, floor_from, look, same};
use crate::{
    figures::{FigureError, Frame, Terms, shimmer},
    truth::{
        Sight,
        tests::stage::{HERE, ball, scene},
    },
};

const FRAMES: usize = 6;

/// Scenes whose camera moves and turns, by less than a pixel a frame; far from the origin too.
fn motion(from: DVec3) -> Vec<Scene> {
    let still = floor_from(DVec3::new(0.0, 8.0, 5.0), DOWN);
    let frames = (0..FRAMES).map(|frame| {
        let mut scene = still.clone();
        let turn = 7e-4 * frame as f64;
        scene.camera.position += DVec3::new(0.031, 0.004, -0.017) * frame as f64;
        scene.camera.rotation = DQuat::from_axis_angle(DVec3::new(1.0, 2.0, 0.5).normalize(), turn)
            * scene.camera.rotation;
        for object in &mut scene.objects {
            object.transform.translation += from;
        }
        scene.camera.position += from;
        scene
    });
    frames.collect()
}

/// Terms from where each pixel's point is in the world (from `from`) and where the camera is.
fn terms(
    scene: &Scene,
    sight: &Sight,
    from: DVec3,
    lit: impl Fn(DVec2, DVec2) -> bool,
) -> Vec<f32> {
    let eye = scene.camera.position - from;
    let flat = |p: DVec3| DVec2::new(p.x, p.z);
    let term = |p: DVec3| f32::from(u8::from(lit(flat(eye + p), flat(eye))));
    let seen = sight.seen().iter();
    seen.map(|seen| seen.map_or(1.0, |seen| term(seen.position)))
        .collect()
}

fn measured(
    from: DVec3,
    truth: impl Fn(DVec2, DVec2) -> bool + Copy,
    rendered: impl Fn(DVec2, DVec2) -> bool + Copy,
) -> f64 {
    measured_at(1, from, truth, rendered)
}

/// In pictures of `size` · 120 by `size` · 90 pixels.
fn measured_at(
    size: u32,
    from: DVec3,
    truth: impl Fn(DVec2, DVec2) -> bool + Copy,
    rendered: impl Fn(DVec2, DVec2) -> bool + Copy,
) -> f64 {
    let scenes = motion(from);
    let sights: Vec<_> = scenes
        .iter()
        .map(|scene| look(scene, 120 * size, 90 * size))
        .collect();
    let rasters: Vec<_> = sights.iter().map(same).collect();
    let stills = || scenes.iter().zip(&sights);
    let of = |(scene, sight)| terms(scene, sight, from, rendered);
    let rendered: Vec<_> = stills().map(of).collect();
    let of = |(scene, sight)| {
        terms(scene, sight, from, truth)
            .into_iter()
            .map(Some)
            .collect()
    };
    let truths: Vec<Vec<_>> = stills().map(of).collect();
    let frame = |i: usize| Frame {
        scene: &scenes[i],
        sight: &sights[i],
        raster: &rasters[i],
        lights: vec![Terms {
            light: &scenes[i].lights[0].light,
            truth: &truths[i],
            rendered: &rendered[i],
        }],
    };
    let frames: Vec<_> = (0..FRAMES).map(frame).collect();
    shimmer(&frames)
        .expect("of one size")
        .expect("known samples")
}

fn all_lit(_: DVec2, _: DVec2) -> bool {
    true
}

/// Stripes aslant on the floor. Their edges are straight: no corner reaches in between four pixels.
fn pattern(at: DVec2) -> bool {
    (at.dot(DVec2::new(0.8, 0.6)) / 1.4).rem_euclid(1.0) < 0.5
}

/// The same, as a map with texels of a third of a metre has it that moves with the camera.
fn snapped(at: DVec2, eye: DVec2) -> bool {
    let texel = 0.33;
    pattern(((at - eye) / texel).round() * texel + eye)
}

/// As it is in its place on the floor.
fn steady(at: DVec2, _: DVec2) -> bool {
    pattern(at)
}

#[test]
fn what_keeps_its_place_does_not_shimmer() {
    for from in [DVec3::ZERO, DVec3::new(1e6, -1e5, 3e5)] {
        assert_eq!(measured(from, all_lit, steady), 0.0, "at {from}");
        assert_eq!(measured(from, steady, steady), 0.0, "at {from}");
    }
}

#[test]
fn what_follows_the_camera_shimmers() {
    let found = measured(DVec3::ZERO, steady, snapped);
    assert!(found > 1e-3, "{found}");
    // A map that stands still has as many corners, and they stay in their place: where one reaches in
    // between four pixels, it is now seen, now not. That is the picture's doing: four times the pixels, a
    // quarter of the share; what moves on the surface moves however many pixels there are.
    let still = |at: DVec2, _: DVec2| snapped(at, DVec2::ZERO);
    let corners = [1, 2].map(|size| measured_at(size, DVec3::ZERO, steady, still));
    assert!(corners[0] < 0.25 * found, "{corners:?} of {found}");
    assert!(corners[1] < 0.4 * corners[0], "{corners:?} of {found}");
    let finer = measured_at(2, DVec3::ZERO, steady, snapped);
    assert!(finer >= found, "{finer} after {found}");
}

#[test]
fn what_flips_in_truth_is_no_shimmer() {
    assert_eq!(measured(DVec3::ZERO, snapped, snapped), 0.0);
    // Nor is what should flip and does not.
    assert_eq!(measured(DVec3::ZERO, snapped, steady), 0.0);
}

/// Two frames of a floor where all is lit, and then some of it is not.
fn blinking(share: usize) -> Option<f64> {
    let scene = floor_from(DVec3::new(0.0, 8.0, 5.0), DOWN);
    let sight = look(&scene, 40, 30);
    let raster = same(&sight);
    let truth = vec![Some(1.0); 1200];
    let lit = vec![1.0; 1200];
    let rows: Vec<_> = (0..1200)
        .map(|pixel| if pixel / 40 < share { 0.0 } else { 1.0 })
        .collect();
    let frame = |rendered| Frame {
        scene: &scene,
        sight: &sight,
        raster: &raster,
        lights: vec![Terms {
            light: &scene.lights[0].light,
            truth: &truth,
            rendered,
        }],
    };
    shimmer(&[frame(&lit), frame(&rows), frame(&rows)]).expect("of one size")
}

/// All that flips at once is all; the second pair of frames has none.
#[test]
fn a_light_that_blinks_flips_as_much_as_it_blinks() {
    assert_eq!(blinking(0), Some(0.0));
    assert_eq!(blinking(30), Some(0.5));
    let third = blinking(10).expect("known");
    // Known are the samples between four that agree: not those at the new edge.
    assert!((third - 0.5 / 3.0).abs() < 0.02, "{third}");
}

/// A ball before a floor: from beside it, other parts of the floor come into view; whatever is lit on the one
/// and dark on the other, nothing flips.
#[test]
fn what_comes_into_view_does_not_flip() {
    let objects = vec![
        super::floor(),
        HERE.object("ball", ball(1.0, 64), DVec3::new(0.0, 3.0, 0.0)),
    ];
    let scenes: Vec<_> = (0..FRAMES)
        .map(|frame| {
            let eye = DVec3::new(0.6 * frame as f64, 9.0, 0.2);
            let camera = HERE.camera(eye, eye.with_y(0.0), DVec3::NEG_Z);
            scene(objects.clone(), DOWN, camera)
        })
        .collect();
    let sights: Vec<_> = scenes.iter().map(|scene| look(scene, 80, 60)).collect();
    let rasters: Vec<_> = sights.iter().map(same).collect();
    let lit_ball = |sight: &Sight| -> Vec<f32> {
        let seen = sight.seen().iter().flatten();
        seen.map(|seen| seen.object as f32).collect()
    };
    let rendered: Vec<_> = sights.iter().map(lit_ball).collect();
    let truth = vec![Some(1.0); 4800];
    let frame = |i: usize| Frame {
        scene: &scenes[i],
        sight: &sights[i],
        raster: &rasters[i],
        lights: vec![Terms {
            light: &scenes[i].lights[0].light,
            truth: &truth,
            rendered: &rendered[i],
        }],
    };
    let frames: Vec<_> = (0..FRAMES).map(frame).collect();
    assert_eq!(shimmer(&frames), Ok(Some(0.0)));
}

#[test]
fn frames_that_do_not_fit_are_refused_and_too_few_say_nothing() {
    let scene = floor_from(DVec3::new(0.0, 8.0, 5.0), DOWN);
    let sight = look(&scene, 4, 3);
    let (raster, truth, rendered) = (same(&sight), vec![Some(1.0); 12], vec![1.0; 12]);
    let terms = Terms {
        light: &scene.lights[0].light,
        truth: &truth,
        rendered: &rendered,
    };
    let frame = |lights: Vec<Terms<'_>>| {
        shimmer(&[
            Frame {
                scene: &scene,
                sight: &sight,
                raster: &raster,
                lights: vec![terms],
            },
            Frame {
                scene: &scene,
                sight: &sight,
                raster: &raster,
                lights,
            },
        ])
    };
    assert_eq!(frame(vec![terms]), Ok(Some(0.0)));
    assert_eq!(
        frame(Vec::new()),
        Err(FigureError::Lights {
            frame: 1,
            found: 0,
            expected: 1
        })
    );
    let short = Terms {
        rendered: &[],
        ..terms
    };
    let error = frame(vec![short]).expect_err("too short").to_string();
    assert!(
        error.starts_with("the rendered term of frame 1 has 0 pixels"),
        "{error}"
    );
    assert_eq!(shimmer(&[]), Ok(None));
    let unseen = Terms {
        truth: &[None; 12],
        ..terms
    };
    assert_eq!(frame(vec![unseen]), Ok(None));
}

//! The shader's terms with a plan, by its twin.

use std::f64::consts::FRAC_PI_4;

use glam::{DQuat, DVec2, DVec3};
use umbrage_shadow::*;
use umbrage_testkit::twins::BasicTwin;

use crate::common::{Scene, matrix, passes};

/// The shader's constant.
const STEEPEST: f64 = 64.0;

/// A plane does not shade itself at any angle to the light, and is shaded by what lies a few texels above it,
/// for every width.
#[test]
fn planes_are_lit_and_covered() {
    for kind in [
        LightKind::Directional {
            direction: DVec3::NEG_Y,
        },
        LightKind::Spot {
            position: DVec3::new(0.3, 4.0, -6.0),
            direction: DVec3::NEG_Y,
            inner_angle: 0.3,
            outer_angle: FRAC_PI_4,
            range: 30.0,
        },
        LightKind::Point {
            position: DVec3::new(0.3, 4.0, -6.0),
            range: 30.0,
        },
    ] {
        for degrees in [
            0.0, 30.0, 60.0, 80.0, 85.0, 86.5, 88.0, 89.0, 89.5, 89.9, 89.99,
        ] {
            for width in [1, 3, 5, 7, 15] {
                check_plane(kind.clone(), f64::to_radians(degrees), width);
            }
        }
    }
}

fn check_plane(kind: LightKind, tilt: f64, width: u32) {
    let mut scene = Scene::basic(kind.clone());
    let half = DVec3::new(1.0, 1.0, 1.0);
    let middle = DVec3::new(0.0, 0.0, -6.0);
    scene.receivers = vec![Aabb {
        min: middle - half,
        max: middle + half,
    }];
    // Casters of the plane may stand above the box.
    scene.casters = vec![Aabb {
        min: middle - half,
        max: middle + DVec3::new(1.0, 3.0, 1.0),
    }];
    scene.choose("pcf", &width.to_string());
    let plan = scene.plan_with("basic").expect("a plan");
    let twin = BasicTwin::new(&plan, width, true).expect("a plan of basic's");
    // The receiver: a plane through the box's middle, tilted from facing up.
    let normal = DQuat::from_rotation_z(0.4) * DQuat::from_rotation_x(tilt) * DVec3::Y;
    let drawn = passes(&plan);
    let depth = |height: f64| {
        let drawn = &drawn;
        move |layer: u32, x: u32, y: u32| {
            // A layer without a pass is empty.
            let Some(pass) = drawn.iter().find(|pass| {
                pass.depth
                    .as_ref()
                    .is_some_and(|depth| depth.target.layer == layer)
            }) else {
                return 0.0;
            };
            let pass = &pass.view_proj.as_dmat4();
            let uv = (DVec2::new(f64::from(x), f64::from(y)) + 0.5) / 256.0;
            let clip = DVec2::new(2.0 * uv.x - 1.0, 1.0 - 2.0 * uv.y);
            let inverse = pass.inverse();
            let at = |z: f64| inverse.project_point3(clip.extend(z));
            let (near, far) = (at(1.0), at(0.0));
            let to_plane = |p: DVec3| normal.dot(p - middle) - height;
            let t = to_plane(near) / (to_plane(near) - to_plane(far));
            // Hits before the near plane or behind the far one are not drawn.
            let hit = near + t * (far - near);
            let z = pass.project_point3(hit).z;
            if (0.0..=1.0).contains(&t) && (0.0..=1.0).contains(&z) {
                z as f32
            } else {
                0.0
            }
        }
    };
    let right = normal.any_orthonormal_vector();
    let mut checked = 0;
    for (x, y) in [
        (0.0, 0.0),
        (0.31, -0.17),
        (-0.23, 0.41),
        (0.5, 0.5),
        (-0.6, 0.1),
    ] {
        let point = middle + 0.6 * (x * right + y * normal.cross(right));
        let to_light = match &kind {
            LightKind::Directional { direction } => -*direction,
            LightKind::Spot { position, .. } | LightKind::Point { position, .. } => {
                (*position - point).normalize()
            }
        };
        let back_facing = normal.dot(to_light) <= 0.0;
        let facing = normal.dot(to_light).abs();
        let slope = (1.0 - facing * facing).sqrt() / facing;
        if !back_facing {
            let lit = twin.calc_shadow(point, normal, depth(0.0));
            assert!(lit > 0.999, "{kind:?} {tilt} {width} at {point}: {lit}");
        }
        // A fetch lies at most a slope's texel above the plane on each axis, and the plane's texels as
        // much below it; the part of the slope that is not followed differs over the whole filter, so the map is read a
        // step aside. A back-facing plane is followed nowhere.
        let left = if back_facing {
            1.0
        } else {
            (1.0 - STEEPEST / slope).max(0.0)
        };
        let reach = 2.0 + left * f64::from(width);
        let texels = reach * 2f64.sqrt() * slope + 4.0;
        let size = texel(&drawn, point);
        // Only where the filter's taps stay on the part of the plane that is in the box: the map ends with it.
        let drop = (0.5 * f64::from(width) + 1.5) * 2f64.sqrt() * slope * size;
        if drop > 1.0 - (point - middle).y.abs() {
            continue;
        }
        checked += 1;
        let height = texels * size * facing;
        let covered = twin.calc_shadow(point, normal, depth(height));
        assert!(
            covered < 0.001,
            "{kind:?} {tilt} {width} at {point}: {covered} under {texels} texels"
        );
    }
    assert!(
        checked > 0 || width > 3 || tilt > 1.4,
        "{kind:?} {tilt} {width}"
    );
}

/// How wide a texel is at `point`, in the layer that sees it most in its middle.
fn texel(passes: &[CasterPass], point: DVec3) -> f64 {
    let clips = passes.iter().map(|pass| {
        let matrix = pass.view_proj.as_dmat4();
        (matrix, matrix * point.extend(1.0))
    });
    let before = clips.filter(|(_, clip)| clip.w > 0.0);
    let (matrix, clip) = before
        .map(|(matrix, clip)| (matrix, clip / clip.w))
        .min_by(|a, b| {
            let off = |clip: &glam::DVec4| clip.x.abs().max(clip.y.abs());
            off(&a.1).total_cmp(&off(&b.1))
        })
        .expect("some layer sees the point");
    let beside = DVec3::new(clip.x + 2.0 / 256.0, clip.y, clip.z);
    matrix.inverse().project_point3(beside).distance(point)
}

#[test]
fn the_filter_is_a_box_of_bilinear_comparisons() {
    let mut scene = Scene::basic(LightKind::Directional {
        direction: DVec3::NEG_Y,
    });
    scene.receivers = vec![Aabb {
        min: DVec3::new(-1.0, -1.0, -7.0),
        max: DVec3::new(1.0, 0.0, -5.0),
    }];
    scene.casters = scene.receivers.clone();
    for width in [1u32, 3, 5, 15] {
        scene.choose("pcf", &width.to_string());
        let plan = scene.plan_with("basic").expect("a plan");
        let twin = BasicTwin::new(&plan, width, false).expect("a plan of basic's");
        let to_map = matrix(&plan, "world_to_map");
        for shift in [0.0, 0.2, 0.5, 0.9] {
            // A half-plane of shade begins at texel 128: the share beyond is linear in the distance.
            let at = DVec3::new((128.0 + shift) / 256.0, 0.5, 0.1);
            let point = to_map.inverse().project_point3(at);
            let lit = twin.calc_shadow(point, DVec3::ZERO, |_, x, _| f32::from(x >= 128));
            let expected = 0.5 - shift / f64::from(width);
            let expected = expected.clamp(0.0, 1.0);
            assert!(
                (lit - expected).abs() < 1e-4,
                "width {width}, {shift}: {lit} {expected}"
            );
        }
    }
}

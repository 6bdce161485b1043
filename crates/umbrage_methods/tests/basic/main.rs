//! Plans of `basic`, without a GPU: what is fitted, what is drawn, and what its shader makes of it.

#![allow(clippy::panic, reason = "a helper that panics fails its test")]

#[path = "../common/mod.rs"]
mod common;
mod shader;

use glam::{DMat4, DQuat, DVec2, DVec3, DVec4};
use proptest::prelude::*;
use umbrage_methods::registry;
use umbrage_shadow::*;
use umbrage_testkit::twins::BasicTwin;

use crate::common::{Scene, matrix, pair, passes};

fn is_finite(plan: &ShadowPlan) -> bool {
    let constants = [
        "world_to_map",
        "plane_to_map",
        "light_position",
        "projection",
        "bias",
    ];
    constants.iter().all(|name| match plan.constants.get(name) {
        Some(Value::Mat4(value)) => value.is_finite(),
        Some(Value::Vec3(value)) => value.is_finite(),
        Some(Value::Vec2(value)) => value.is_finite(),
        _ => true,
    }) && passes(plan).iter().all(|pass| pass.view_proj.is_finite())
}

fn vector(range: f64) -> impl Strategy<Value = DVec3> {
    [-range..range, -range..range, -range..range].prop_map(DVec3::from)
}

fn boxes() -> impl Strategy<Value = Vec<Aabb>> {
    let one = (vector(20.0), vector(1.0), 0usize..5).prop_map(|(at, size, flat)| {
        let mut half = 4.0 * size.abs().powf(3.0);
        if flat < 3 {
            half[flat] = 0.0;
        }
        Aabb {
            min: at - half,
            max: at + half,
        }
    });
    prop::collection::vec(one, 1..8)
}

fn light() -> impl Strategy<Value = LightKind> {
    let axis = prop_oneof![
        vector(1.0).prop_map(|v| v.normalize_or(DVec3::X)),
        prop::sample::select(DVec3::AXES.map(|axis| -axis).to_vec()),
    ];
    (axis, vector(15.0), 0.05..1.4, 5.0..40.0, 0..3).prop_map(
        |(direction, position, outer_angle, range, kind)| match kind {
            0 => LightKind::Directional { direction },
            1 => LightKind::Spot {
                position,
                direction,
                inner_angle: 0.0,
                outer_angle,
                range,
            },
            _ => LightKind::Point { position, range },
        },
    )
}

fn scene() -> impl Strategy<Value = Scene> {
    let camera = (vector(10.0), -3.0..3.0, -1.5..1.5);
    let size = prop::sample::select(vec![1.0, 2.0, 7.0, 512.0, 2048.0]);
    (light(), boxes(), boxes(), camera, size, 0u32..8).prop_map(
        |(kind, casters, receivers, (position, yaw, pitch), resolution, half)| {
            let mut scene = Scene::basic(kind);
            scene.set("resolution", resolution);
            scene.choose("pcf", &(2 * half + 1).to_string());
            scene.view.position = position;
            scene.view.rotation = DQuat::from_rotation_y(yaw) * DQuat::from_rotation_x(pitch);
            scene.casters = casters;
            scene.receivers = receivers;
            scene
        },
    )
}

/// Points of the receivers that are seen and that the light may reach, camera-relative.
fn seen(scene: &Scene, samples: &[DVec3]) -> Vec<DVec3> {
    let camera = scene.view.frustum();
    let reached = |point: DVec3| match scene.light.kind {
        LightKind::Directional { .. } => true,
        LightKind::Spot {
            position,
            direction,
            outer_angle,
            range,
            ..
        } => {
            let offset = point - position;
            let near = offset.dot(direction) > 1e-4 * range;
            near && offset.length() < range && offset.angle_between(direction) < outer_angle
        }
        LightKind::Point { position, range } => {
            let offset = point - position;
            offset.length() < range && offset.abs().max_element() > 1e-4 * range
        }
    };
    let points = scene.receivers.iter().flat_map(|r| {
        let at = move |t: &DVec3| r.center() + 0.5 * *t * (r.max - r.min);
        samples.iter().map(at).chain(r.corners())
    });
    let seen = points.filter(|p| camera.contains(*p) && reached(*p));
    seen.map(|p| p - scene.view.position).collect()
}

/// The same scene, in which what receives casts as well.
fn casting(mut scene: Scene) -> Scene {
    scene.casters.extend_from_slice(&scene.receivers);
    scene
}

/// Whether a caster's box may be in the way from a camera-relative point to a sun, or behind it.
fn may_be_shaded(scene: &Scene, point: DVec3) -> bool {
    let LightKind::Directional { direction } = scene.light.kind else {
        return true;
    };
    let lens = Lens::directional(direction);
    let origin = scene.view.position;
    let corners = scene.casters.iter().flat_map(Aabb::corners);
    let places = corners.map(|corner| lens.place(corner - origin).0);
    let at = lens.place(point).0;
    Rect::from_points(places).is_some_and(|all| {
        let inside = at.cmpge(all.min) & at.cmple(all.max);
        inside.all()
    })
}

/// Where a pass draws a camera-relative point.
fn draws(pass: &CasterPass, point: DVec3) -> Option<DVec3> {
    let clip = pass.view_proj.as_dmat4() * point.extend(1.0);
    let at = clip.truncate() / clip.w;
    (clip.w > 0.0 && at.truncate().abs().max_element() <= 1.0).then_some(at)
}

proptest! {
    #[test]
    fn a_map_holds_the_receivers_seen(
        scene in scene(), casts in any::<bool>(), samples in prop::collection::vec(vector(1.0), 16),
    ) {
        let scene = if casts { casting(scene) } else { scene };
        let plan = scene.plan_with("basic")?;
        prop_assert!(is_finite(&plan));
        let passes = passes(&plan);
        for point in seen(&scene, &samples) {
            if !may_be_shaded(&scene, point) {
                continue;
            }
            let at = passes.iter().find_map(|pass| draws(pass, point));
            let Some(at) = at else { return Err(TestCaseError::fail("beside the map")) };
            prop_assert!((0.0..=1.0).contains(&at.z), "depth {}", at.z);
            // A cube's faces cannot be fitted, though only one may be drawn.
            if !matches!(scene.light.kind, LightKind::Point { .. }) {
                // The filter's texels are inside too.
                let texels = (0.5 * scene.width() + 1.0).min(0.2 * scene.settings["resolution"]);
                let inner = 1.0 - 2.0 * texels / scene.settings["resolution"];
                prop_assert!(at.truncate().abs().max_element() <= inner, "{at} {inner}");
            }
        }
    }

    /// A caster on the way from a point seen to the light is neither missed nor cut away.
    #[test]
    fn casters_between_are_drawn(
        scene in scene(), samples in prop::collection::vec(vector(1.0), 8), t in 0.0..1.0,
        half in vector(1.0),
    ) {
        let mut scene = scene;
        let origin = scene.view.position;
        let points = seen(&scene, &samples);
        let between = points.iter().map(|point| match scene.light.kind {
            LightKind::Directional { direction } => point - t * 60.0 * direction,
            LightKind::Spot { position, .. } | LightKind::Point { position, .. } => {
                point.lerp(position - origin, 0.99 * t)
            }
        });
        let between: Vec<DVec3> = between.collect();
        // Long leaves among them: only a part of each is in the way.
        let half = DVec3::new(10.0, 1.0, 0.0) * half.abs();
        let around = |p: &DVec3| Aabb { min: origin + p - half, max: origin + p + half };
        scene.casters = between.iter().map(around).collect();
        let plan = scene.plan_with("basic")?;
        for (i, there) in between.iter().enumerate() {
            let drawn = passes(&plan).iter().any(|pass| {
                let at = draws(pass, *there);
                at.is_some_and(|at| (0.0..=1.0).contains(&at.z)) && pass.casters.contains(&i)
            });
            prop_assert!(drawn, "caster {i} at {there}, of {:?}", plan.passes);
        }
    }

    #[test]
    fn far_from_the_origin_nothing_changes(scene in scene()) {
        // A power of two, and coordinates that survive it: what is left is the method's own rounding.
        let snap = |p: DVec3| (p * 1024.0).round() / 1024.0;
        let mut scene = scene;
        scene.view.position = snap(scene.view.position);
        for aabb in scene.casters.iter_mut().chain(&mut scene.receivers) {
            *aabb = Aabb { min: snap(aabb.min), max: snap(aabb.max) };
        }
        if let LightKind::Spot { position, .. } | LightKind::Point { position, .. } =
            &mut scene.light.kind
        {
            *position = snap(*position);
        }
        let moved = scene.transformed(1.0, DVec3::new(1e6, -1e6, 1e6));
        let (near, far) = (scene.plan_with("basic")?, moved.plan_with("basic")?);
        prop_assert_eq!(near.passes.len(), far.passes.len());
        for (a, b) in passes(&near).iter().zip(passes(&far)) {
            let size = a.view_proj.to_cols_array().iter().fold(0f32, |m, x| m.max(x.abs()));
            prop_assert!(a.view_proj.abs_diff_eq(b.view_proj, 1e-5 * size));
            prop_assert_eq!(&a.casters, &b.casters);
        }
    }

    #[test]
    fn any_scale_will_do(scene in scene(), scale in prop::sample::select(vec![1e-3, 1e4])) {
        let scaled = scene.transformed(scale, DVec3::ZERO);
        let (plan, scaled) = (scene.plan_with("basic")?, scaled.plan_with("basic")?);
        prop_assert!(is_finite(&scaled));
        for (a, b) in passes(&plan).iter().zip(passes(&scaled)) {
            let matrix = b.view_proj.as_dmat4() * DMat4::from_scale(DVec3::splat(scale));
            // Rows, each to its own size: only their ratios to w matter.
            let weight = b.view_proj.row(3).length() as f64 * scale.min(1.0);
            prop_assert!(weight > 0.0 && matrix.is_finite());
            prop_assert_eq!(&a.casters, &b.casters);
        }
    }

    #[test]
    fn the_slope_is_the_planes(scene in scene(), normal in vector(1.0), step in vector(1.0)) {
        let scene = casting(scene);
        if matches!(scene.light.kind, LightKind::Point { .. }) {
            return Ok(());
        }
        let plan = scene.plan_with("basic")?;
        let Some(point) = seen(&scene, &[DVec3::ZERO]).first().copied() else { return Ok(()) };
        let normal = normal.normalize_or(DVec3::Y);
        let (to_map, plane_to_map) = (matrix(&plan, "world_to_map"), matrix(&plan, "plane_to_map"));
        let plane = plane_to_map * DVec4::from((normal, -normal.dot(point)));
        let slope = -plane.truncate().truncate() / plane.z;
        prop_assume!(slope.is_finite() && slope.abs().max_element() < 100.0);
        // The point where the plane is a short way off on the map.
        let other = point + 1e-3 * step.cross(normal);
        let (a, b) = (to_map.project_point3(point), to_map.project_point3(other));
        let along = (b - a).truncate();
        prop_assume!(along.length() < 0.5);
        let (rise, expected) = ((b - a).z, slope.dot(along));
        let scale = (1.0 + slope.length()) * (along.length() + 1e-4) + (b - a).z.abs();
        prop_assert!((rise - expected).abs() < 2e-2 * scale, "{rise} {expected} {slope}");
    }

    /// The difference between two biases is what their texels say, in metres.
    #[test]
    fn a_bias_is_a_number_of_texels(scene in scene(), texels in 0.25..4.0) {
        let mut scene = casting(scene);
        scene.set("resolution", 512.0);
        scene.set("depth_bias", 0.0);
        let none = scene.plan_with("basic")?;
        scene.set("depth_bias", texels);
        let some = scene.plan_with("basic")?;
        let Some(point) = seen(&scene, &[DVec3::ZERO]).first().copied() else { return Ok(()) };
        let at = passes(&none).iter().find_map(|pass| Some((pass.clone(), draws(pass, point)?)));
        let Some((pass, at)) = at else { return Err(TestCaseError::fail("beside the map")) };
        let biased = |plan: &ShadowPlan| at.z + pair(plan, "bias").x + pair(plan, "bias").y * at.z;
        let place = |z: f64| pass.view_proj.as_dmat4().inverse().project_point3(at.with_z(z));
        let (from, to) = (place(biased(&none)), place(biased(&some)));
        // A texel's width at the receiver, the larger of across and down.
        let unproject = |xy: DVec2| {
            pass.view_proj.as_dmat4().inverse().project_point3((at.truncate() + xy).extend(at.z))
        };
        let texel = [DVec2::X, DVec2::Y]
            .map(|axis| unproject(axis * 2.0 / 512.0).distance(place(at.z)))
            .into_iter()
            .fold(0.0, f64::max);
        // Along the axis; a ray to the map's side is longer by at most its own slant.
        let (row, w) = (pass.view_proj.as_dmat4().row(2), pass.view_proj.as_dmat4().row(3));
        let axis = if w.truncate().length() > 0.0 { w } else { row };
        let moved = (from - to).dot(axis.truncate().normalize()).abs();
        let expected = texels * texel;
        prop_assert!((moved - expected).abs() < 0.03 * expected + 1e-3 * place(at.z).length(),
            "{moved} m, not {expected} m");
    }
}

#[test]
fn casters_that_cannot_shade_are_not_drawn() {
    let cube = |p: DVec3| Aabb {
        min: p - 0.5,
        max: p + 0.5,
    };
    let receiver = DVec3::new(0.0, 0.0, -6.0);
    let (above, below, aside) = (DVec3::Y * 3.0, DVec3::NEG_Y * 3.0, DVec3::X * 4.0);
    for kind in [
        LightKind::Directional {
            direction: DVec3::NEG_Y,
        },
        LightKind::Point {
            position: receiver + 5.0 * DVec3::Y,
            range: 30.0,
        },
    ] {
        let mut scene = Scene::basic(kind);
        scene.receivers = vec![cube(receiver)];
        scene.casters = [below, above, aside + above]
            .map(|p| cube(receiver + p))
            .to_vec();
        let plan = scene.plan_with("basic").expect("a plan");
        let drawn: Vec<_> = passes(&plan)
            .into_iter()
            .flat_map(|pass| pass.casters)
            .collect();
        assert_eq!(drawn, [1]);
    }
}

#[test]
fn nothing_to_see_is_lit_and_free() {
    for kind in [
        LightKind::Directional {
            direction: DVec3::NEG_Y,
        },
        LightKind::Point {
            position: DVec3::ZERO,
            range: 1.0,
        },
    ] {
        let plan = Scene::basic(kind).plan_with("basic").expect("a plan");
        assert!(plan.passes.is_empty());
        assert_eq!(plan.textures[0].width, 1);
        let twin = BasicTwin::new(&plan, 3, true).expect("a plan of basic's");
        assert_eq!(
            twin.calc_shadow(DVec3::new(1.0, 2.0, 3.0), DVec3::Y, |_, _, _| 1.0),
            1.0
        );
    }
}

#[test]
fn hard_boxes_have_finite_plans() {
    let point = |p: DVec3| Aabb { min: p, max: p };
    let sky = Aabb {
        min: DVec3::splat(-1e6),
        max: DVec3::splat(1e6),
    };
    let seen = DVec3::new(0.0, 0.0, -3.0);
    for kind in [
        LightKind::Directional {
            direction: DVec3::NEG_Z,
        },
        LightKind::Directional {
            direction: DVec3::Z,
        },
        LightKind::Point {
            position: seen,
            range: 10.0,
        },
    ] {
        for receiver in [point(seen), sky] {
            for caster in [point(seen), point(DVec3::ZERO), sky] {
                let mut scene = Scene::basic(kind.clone());
                scene.receivers = vec![receiver];
                scene.casters = vec![caster];
                for resolution in [1.0, 16384.0] {
                    scene.set("resolution", resolution);
                    assert!(is_finite(&scene.plan_with("basic").expect("a plan")));
                }
            }
        }
    }
}

#[test]
fn what_cannot_be_planned_is_named() {
    let mut scene = Scene::basic(LightKind::Directional {
        direction: DVec3::NEG_Y,
    });
    scene.choose("pcf", "4");
    let message = |scene: &Scene| scene.plan_with("basic").err().map(|e| e.to_string());
    assert_eq!(
        message(&scene).as_deref(),
        Some("the axis `pcf` is 4, but must be odd, 1 to 15")
    );
    scene.choose("pcf", "3");
    scene.receivers = vec![Aabb {
        min: DVec3::NAN,
        max: DVec3::ONE,
    }];
    let expected = "the box of receiver 0 is [NaN, NaN, NaN] to [1, 1, 1], \
        but must be finite, and its corners in order";
    assert_eq!(message(&scene).as_deref(), Some(expected));
}

#[test]
fn the_registry_is_whole() {
    let registry = registry().expect("names differ");
    let names = registry.methods.names();
    assert_eq!(names.collect::<Vec<_>>(), ["basic", "pssm"]);
    let names = registry.depths.names().chain(registry.filters.names());
    assert_eq!(
        names.collect::<Vec<_>>(),
        [
            "midpoint",
            "midpoint_sampled",
            "midpoint_two_passes",
            "nearest",
            "esm",
            "esm_half",
            "esm_log",
            "hpsm",
            "hpsm_naive",
            "min_max",
            "min_max_tree",
            "pcf"
        ]
    );
}

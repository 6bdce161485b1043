//! Plans of `pssm`, without a GPU: which splits there are, what their maps hold, where their texels lie, and
//! what each lookup reads of them.

#![allow(clippy::panic, reason = "a helper that panics fails its test")]

#[path = "../common/mod.rs"]
mod common;
mod esm;
mod hpsm;
mod lookups;

use glam::{DQuat, DVec2, DVec3, Vec4Swizzles};
use proptest::prelude::*;
use umbrage_methods::methods::pssm::Pssm;
use umbrage_shadow::*;

use crate::common::{Scene, ground, lamp, passes, post, sun};

fn vector(range: f64) -> impl Strategy<Value = DVec3> {
    [-range..range, -range..range, -range..range].prop_map(DVec3::from)
}

proptest! {
    /// Every point that is seen, shadowed, and in the light falls into its split's map, a filter's reach from its edge,
    /// and lies between its planes; and so does what may shade it, or it lies in front of no pass's casters.
    #[test]
    fn a_map_holds_the_receivers_of_its_split(
        at in prop::collection::vec(vector(1.0), 32), yaw in -3.0..3.0, pitch in -1.2..0.3,
        place in vector(30.0), spot in any::<bool>(), fit in 0usize..2, transition in 0usize..3, splits in 1..=8u32,
        half in 0u32..8, taper in any::<bool>(), ground_casts in any::<bool>(),
    ) {
        let kind = if spot { lamp() } else { sun() };
        let mut scene = Scene::new(kind.clone());
        scene.view.position = place + DVec3::Y * 31.0;
        scene.view.rotation = DQuat::from_rotation_y(yaw) * DQuat::from_rotation_x(pitch);
        scene.hold(vec![ground(60.0), post(DVec3::new(3.0, 0.0, -9.0), 4.0)]);
        if !ground_casts {
            scene.casters.remove(0);
        }
        scene.choose("fit", ["stable", "tight"][fit]);
        scene.choose("transition", ["hard", "blend", "dither"][transition]);
        scene.choose("pcf", &(2 * half + 1).to_string());
        scene.choose("taper", if taper { "on" } else { "off" });
        scene.set("splits", f64::from(splits));
        let plan = scene.plan()?;
        let passes = passes(&plan);
        prop_assert!(passes.len() <= splits as usize);
        for t in at {
            let receiver = &scene.receivers[usize::from(t.x > 0.8)];
            let point = receiver.center() + 0.5 * t * (receiver.max - receiver.min);
            let relative = point - scene.view.position;
            let seen = scene.view.frustum().contains(point) && in_light(&kind, point);
            if !seen || !(spot || is_between(&scene.casters, point)) {
                continue;
            }
            let depth = relative.dot(scene.view.forward());
            let split = passes.iter().position(|pass| depth < pass.receivers.unwrap_or_default()[1]);
            let Some(split) = split else { panic!("{depth} is in no split of {passes:?}") };
            let pass = &passes[split];
            let half = if taper { half.saturating_sub(split as u32) } else { half };
            let margin = f64::from(half) + 1.0;
            let clip = pass.view_proj.as_dmat4().project_point3(relative);
            let size = f64::from(pass.viewport.width);
            let texel = DVec2::new(0.5 + 0.5 * clip.x, 0.5 - 0.5 * clip.y) * size;
            prop_assert!(texel.min_element() > margin && texel.max_element() < size - margin, "{texel}");
            prop_assert!((0.0..=1.0).contains(&clip.z), "{clip}");
        }
    }

    /// The texels of the stable fit lie on one grid of the world's, wherever the camera is and looks.
    #[test]
    fn stable_texels_stay_where_they_are(
        steps in prop::collection::vec((vector(2.0), -3.0..3.0, -0.7..0.0), 4), far_away in any::<bool>(),
    ) {
        let origin = if far_away { DVec3::new(1e6, 0.0, -1e6) } else { DVec3::ZERO };
        let mut grids: Vec<Vec<(f64, DVec2)>> = Vec::new();
        for (place, yaw, pitch) in steps {
            let mut scene = Scene::new(sun());
            scene.view.position = origin + place + DVec3::Y * 5.0;
            scene.view.rotation = DQuat::from_rotation_y(yaw) * DQuat::from_rotation_x(pitch);
            // Around and below, so that the whole range is seen wherever the camera looks.
            scene.hold(vec![Aabb { min: origin - 900.0, max: origin + 900.0 }]);
            let plan = scene.plan()?;
            let grid = crops(&plan).into_iter().map(|(scale, offset)| {
                // The texel that the world's origin, as seen along the light, would have: in f64 again, for what
                // f32 loses is lost in texels near the camera.
                let anchor = Lens::directional(direction()).place(scene.view.position).0;
                (scale, offset - anchor * DVec2::new(scale, -scale))
            });
            grids.push(grid.collect());
        }
        let first = grids[0].clone();
        prop_assert_eq!(first.len(), 4);
        for grid in grids {
            for ((scale, offset), (same, other)) in grid.into_iter().zip(&first) {
                prop_assert_eq!(scale, *same);
                // f32 holds an offset of up to a tile's texels to a 10,000th of one.
                let texels = offset - *other;
                let apart = (texels - texels.round()).abs().max_element();
                prop_assert!(apart < 1e-3, "{apart} of a texel");
            }
        }
    }
}

/// Whether the sun sees a point between the casters' outermost ends.
fn is_between(casters: &[Aabb], point: DVec3) -> bool {
    let lens = Lens::directional(direction());
    let corners = casters.iter().flat_map(Aabb::corners);
    let all = Rect::from_points(corners.map(|corner| lens.place(corner).0));
    let at = Rect::from_points([lens.place(point).0]);
    all.zip(at)
        .is_some_and(|(all, at)| all.intersection(&at).is_some())
}

fn direction() -> DVec3 {
    match sun() {
        LightKind::Directional { direction } => direction,
        _ => DVec3::ZERO,
    }
}

/// Texels a metre, and the place of the light's axis in texels, of each split.
fn crops(plan: &ShadowPlan) -> Vec<(f64, DVec2)> {
    let Some(Value::Array(crops)) = plan.constants.get("crops") else {
        return Vec::new();
    };
    let crop = |value: &Value| match value {
        Value::Struct(members) => match members.get("place") {
            Some(Value::Vec4(place)) => (f64::from(place.x), place.zw().as_dvec2()),
            _ => (0.0, DVec2::ZERO),
        },
        _ => (0.0, DVec2::ZERO),
    };
    crops.iter().take(plan.passes.len()).map(crop).collect()
}

fn in_light(kind: &LightKind, point: DVec3) -> bool {
    match kind {
        LightKind::Spot {
            position,
            direction,
            outer_angle,
            range,
            ..
        } => {
            let offset = point - position;
            offset.length() < *range && offset.angle_between(*direction) < *outer_angle
        }
        _ => true,
    }
}

/// A view of a near and a far group, with nothing between: no split is drawn for the gap, and the atlas has no
/// tile for it.
#[test]
fn a_split_without_receivers_costs_nothing() {
    let mut scene = Scene::new(sun());
    let near = post(DVec3::new(0.0, -0.5, -2.0), 1.0);
    let far = post(DVec3::new(0.0, -0.5, -150.0), 1.0);
    scene.hold(vec![near, far]);
    let plan = scene.plan().expect("a plan");
    let passes = passes(&plan);
    assert_eq!(passes.len(), 2, "{passes:?}");
    assert_eq!(
        (plan.textures[0].width, plan.textures[0].height),
        (2048, 1024)
    );
    // Each map has the one caster that can reach it.
    assert_eq!(passes[0].casters, [0]);
    assert_eq!(passes[1].casters, [1]);
}

/// In a hall of few metres, the ball around a split of a view of tens is more than there is.
#[test]
fn a_stable_map_holds_no_more_than_there_is() {
    let mut scene = Scene::new(sun());
    let hall = Aabb {
        min: DVec3::new(-6.0, 0.0, -10.0),
        max: DVec3::new(6.0, 5.0, 0.0),
    };
    scene.hold(vec![hall]);
    scene.view.position = DVec3::new(0.0, 2.0, -1.0);
    let lens = Lens::directional(direction());
    let places = hall.corners().map(|corner| lens.place(corner).0);
    let size = Rect::from_points(places).expect("corners").size();
    let texels = |scene: &Scene| -> Vec<f64> {
        let scales = crops(&scene.plan().expect("a plan")).into_iter();
        scales.map(|(scale, _)| 1.0 / scale).collect()
    };
    let found = texels(&scene);
    assert_eq!(found.len(), 4);
    // An eighth of an octave more at the most, and what the filter needs at the edges.
    let most = size.max_element() * 8f64.recip().exp2() / (1024.0 - 10.0);
    assert!(found.iter().all(|texel| *texel < most), "{found:?}, {most}");
    assert!(found[3] > size.max_element() / 1024.0);
    // Where the ball is less, it is chosen still.
    assert!(found[0] < 0.5 * found[3]);
    // Objects that move about in the hall change no texel's size, nor do rounding errors.
    let ball = post(DVec3::new(1.0, 1.0, -4.0), 1.0);
    scene.casters.push(ball);
    for step in 0..20 {
        scene.view.position.x = 0.1 * f64::from(step);
        scene.casters[1] = ball.translate(DVec3::X * 0.1 * f64::from(step));
        assert_eq!(texels(&scene), found, "{step}");
    }
}

/// Where nothing casts there is no map, and where little does, no texel is beside it.
#[test]
fn a_map_holds_what_may_be_shaded() {
    let mut scene = Scene::new(sun());
    scene.receivers = vec![ground(100.0)];
    scene.view.position = DVec3::Y * 2.0;
    assert!(passes(&scene.plan().expect("a plan")).is_empty());
    let caster = post(DVec3::new(0.0, 0.0, -20.0), 3.0);
    scene.casters = vec![caster];
    let lens = Lens::directional(direction());
    let places = caster.corners().map(|corner| lens.place(corner).0);
    let size = Rect::from_points(places).expect("corners").size();
    for fit in ["stable", "tight"] {
        scene.choose("fit", fit);
        let plan = scene.plan().expect("a plan");
        let scales = crops(&plan);
        assert!((1..4).contains(&scales.len()), "{fit}: {scales:?}");
        for (scale, _) in scales {
            let most = 1.1 * size.max_element() / (1024.0 - 10.0);
            assert!(1.0 / scale < most, "{fit}: {scale}, {most}");
        }
    }
}

/// A tower beside the view, towards the light, shades what is seen, and is drawn with nothing cut away.
#[test]
fn casters_out_of_sight_are_drawn() {
    let mut scene = Scene::new(sun());
    scene.hold(vec![ground(50.0)]);
    scene.view.position = DVec3::Y * 2.0;
    let tower = Aabb {
        min: DVec3::new(-1.0, 0.0, -11.0) - 200.0 * direction(),
        max: DVec3::new(1.0, 2.0, -9.0) - 200.0 * direction(),
    };
    // Nor is it drawn where its shadow does not fall.
    let beside = tower.translate(DVec3::X * 500.0);
    scene.casters = vec![tower, beside];
    let plan = scene.plan().expect("a plan");
    let holding: Vec<_> = passes(&plan)
        .into_iter()
        .filter(|pass| pass.casters == [0])
        .collect();
    let shaded = |pass: &&CasterPass| pass.receivers.is_some_and(|[a, b]| a < 10.0 && 10.0 < b);
    assert_eq!(holding.iter().filter(shaded).count(), 1);
    let drawn = passes(&plan)
        .into_iter()
        .any(|pass| pass.casters.contains(&1));
    assert!(!drawn);
    for corner in tower.corners() {
        for pass in &holding {
            let relative = corner - scene.view.position;
            let clip = pass.view_proj.as_dmat4().project_point3(relative);
            let beside = clip.truncate().abs().max_element() > 1.0;
            assert!(beside || clip.z < 1.0, "{clip} is cut away");
        }
    }
}

#[test]
fn shadows_end_at_their_distance() {
    let mut scene = Scene::new(sun());
    scene.hold(vec![ground(100.0)]);
    scene.view.position = DVec3::Y * 2.0;
    scene.set("shadow_distance", 20.0);
    let plan = scene.plan().expect("a plan");
    assert_eq!(plan.shadow_distance, Some(20.0));
    assert_eq!(plan.constants.get("reach"), Some(&Value::F32(20.0)));
    let last = passes(&plan).last().and_then(|pass| pass.receivers);
    assert_eq!(last.map(|depths| depths[1]), Some(20.0));
    // All that is seen lies beyond.
    scene.hold(vec![post(DVec3::new(0.0, 0.0, -60.0), 2.0)]);
    let plan = scene.plan().expect("a plan");
    assert!(plan.passes.is_empty());
    assert_eq!(plan.constants.get("reach"), Some(&Value::F32(f32::MIN)));
}

/// The axes of the plan's regions, and where they end.
fn regions(plan: &ShadowPlan) -> Vec<(f64, Vec<(&str, &str)>)> {
    let regions = plan.regions.iter().map(|region| {
        let axes = region.axes.iter();
        let axes = axes.map(|(axis, value)| (axis.as_str(), value.as_str()));
        (region.end, axes.collect())
    });
    regions.collect()
}

#[test]
fn regions_are_splits_and_their_bands() {
    let mut scene = Scene::new(sun());
    scene.hold(vec![ground(100.0)]);
    scene.view.position = DVec3::Y * 2.0;
    scene.choose("pcf", "5");
    let plan = scene.plan().expect("a plan");
    let ends: Vec<_> = passes(&plan)
        .iter()
        .map(|p| p.receivers.unwrap_or_default()[1])
        .collect();
    assert_eq!(ends.len(), 4);
    let even: Vec<_> = ends.iter().map(|end| (*end, vec![])).collect();
    assert_eq!(regions(&plan), even);
    assert_eq!(plan.fetches_per_pixel, 9);
    // Each split's own width.
    scene.choose("taper", "on");
    let widths = ["5", "3", "1", "1"].map(|width| vec![("pcf", width), ("taper", "off")]);
    let narrowed: Vec<_> = ends.iter().copied().zip(widths.clone()).collect();
    let plan = scene.plan().expect("a plan");
    assert_eq!(regions(&plan), narrowed);
    assert_eq!((plan.fetches_per_pixel, plan.filter_radius), (9, 3.0));
    // A band has the light's own permutation, which reads two maps; the last split has none.
    scene.choose("transition", "blend");
    let plan = scene.plan().expect("a plan");
    assert_eq!(plan.fetches_per_pixel, 9 + 4);
    let found = regions(&plan);
    assert_eq!(found.len(), 7);
    let bands: Vec<_> = found.iter().filter(|(_, axes)| axes.is_empty()).collect();
    assert_eq!(
        bands.iter().map(|(end, _)| *end).collect::<Vec<_>>(),
        ends[..3]
    );
    for (i, (_, axes)) in found.iter().step_by(2).enumerate() {
        let mut expected = widths[i].clone();
        expected.push(("transition", "hard"));
        assert_eq!(*axes, expected);
    }
    let start = passes(&plan)[1].receivers.unwrap_or_default()[0];
    let band = ends[1] - 0.1 * (ends[1] - start);
    assert!((found[2].0 - band).abs() < 1e-9);
    // A band as long as its split leaves nothing beside it.
    scene.set("band", 1.0);
    let plan = scene.plan().expect("a plan");
    assert!(regions(&plan).len() < 7);
    assert!(plan.regions.is_sorted_by(|a, b| a.end < b.end));
    // All that is not read as `pcf` fetches: the lookups that do so in ways of their own.
    for (lookup, fetches) in [
        ("weights", 9 + 4 + 1 + 1),
        ("channels", 36),
        ("matrix_texture", 5 + 9),
    ] {
        scene.choose("transition", "hard");
        scene.choose("lookup", lookup);
        let plan = scene.plan().expect("a plan");
        assert_eq!(plan.fetches_per_pixel, fetches, "{lookup}");
    }
    // Nothing seen, nothing to shade.
    scene.receivers.clear();
    assert!(scene.plan().expect("a plan").regions.is_empty());
}

#[test]
fn splits_lie_where_pixels_see_something() {
    let mut scene = Scene::new(sun());
    scene.hold(vec![ground(100.0)]);
    scene.view.position = DVec3::Y * 2.0;
    let range = |scene: &Scene| {
        let plan = scene.plan().expect("a plan");
        let depths: Vec<_> = passes(&plan)
            .iter()
            .map(|pass| pass.receivers.unwrap_or_default())
            .collect();
        (
            depths.len(),
            depths.first().map_or(0.0, |d| d[0]),
            depths.last().map_or(0.0, |d| d[1]),
        )
    };
    // Depths that were not asked for are not heeded.
    let boxes = range(&scene);
    scene.camera_depth = Some([640, 65]);
    scene.answer([5.0, 20.0]);
    assert_eq!(range(&scene), boxes);
    assert!(boxes.1 < 4.0 && boxes.2 > 90.0);
    scene.choose("range", "depths");
    scene.choose("fit", "tight");
    let (count, near, far) = range(&scene);
    assert_eq!(count, 4);
    // Nothing that is seen is left out, and little is added.
    assert!(
        near < 5.0 && near > 4.99 && far > 20.0 && far < 20.01,
        "{near} to {far}"
    );
    // From one quarter of an octave to another, so that they seldom change.
    scene.choose("fit", "stable");
    let (_, near, far) = range(&scene);
    let ends = [9.0, 18.0].map(|quarters: f64| (quarters / 4.0).exp2());
    assert!(
        near < ends[0] && near > 0.999 * ends[0] && far > ends[1] && far < 1.001 * ends[1],
        "{near} to {far}"
    );
    // All at one depth: a wall.
    scene.answer([8.5, 8.5]);
    let (count, near, far) = range(&scene);
    assert!(count > 0 && near < 8.5 && far > 8.5);
    scene.choose("fit", "tight");
    let (count, near, far) = range(&scene);
    assert!(
        count > 0 && near < 8.5 && far > 8.5,
        "{count}: {near} to {far}"
    );
    // No pixel sees anything.
    scene.answer([f64::MAX, 0.0]);
    assert_eq!(range(&scene).0, 0);
    // Air is seen wherever surfaces are, and before them: the first split holds it, and the others are as without.
    scene.air = Some(Aabb::new([-20.0; 3], [20.0; 3]));
    scene.choose("fit", "stable");
    let (count, near, far) = range(&scene);
    assert_eq!((count, far), (boxes.0, boxes.2));
    assert!(near < 0.05 && near > 0.049, "{near}");
    let ends = |scene: &Scene| -> Vec<f64> {
        let passes = passes(&scene.plan().expect("a plan"));
        let receivers = passes.iter().filter_map(|pass| pass.receivers);
        receivers.map(|[_, end]| end).collect()
    };
    let with_air = ends(&scene);
    scene.air = None;
    scene.choose("range", "boxes");
    assert_eq!(with_air, ends(&scene));
    // Nothing but air.
    scene.air = Some(Aabb::new([-20.0; 3], [20.0; 3]));
    scene.receivers.clear();
    assert_eq!(range(&scene).0, 4);
}

/// The question is a pass over the camera's depth, and nothing else; the plan that was answered has it as well, last, so that
/// an engine may ask with the answers of the frame before.
#[test]
fn what_pixels_see_is_asked() {
    let mut scene = Scene::new(sun());
    scene.hold(vec![ground(100.0)]);
    scene.choose("range", "depths");
    let error = scene.plan().expect_err("refused").to_string();
    assert_eq!(
        error,
        "the camera's depth is missing, but must be given, as the axis `range` is `depths`; choose `boxes` where there \
         is none"
    );
    scene.camera_depth = Some([640, 65]);
    let question = scene.plan().expect("a plan");
    assert_eq!(question.asks, ["seen_depths"]);
    let [Pass::Compute(pass)] = &question.passes[..] else {
        panic!("one pass: {:?}", question.passes)
    };
    assert_eq!(pass.workgroups, [10, 2, 1].into());
    assert_eq!(pass.writes, ["seen_depths".into()]);
    scene.answer([5.0, 20.0]);
    let plan = scene.plan().expect("a plan");
    assert!(plan.asks.is_empty());
    assert_eq!(plan.passes.len(), 5);
    assert_eq!(plan.passes.last(), question.passes.last());
    scene.answers = Answers::default().with([("seen_depths".to_owned(), vec![0; 9])]);
    let error = scene.plan().expect_err("refused").to_string();
    assert!(error.contains("is 9 bytes, but must be 8 bytes"), "{error}");
    // Air is seen wherever surfaces are: nothing is asked.
    scene.air = Some(ground(20.0));
    assert!(scene.plan().expect("a plan").asks.is_empty());
}

#[test]
fn what_cannot_be_planned_is_told() {
    let point = LightKind::Point {
        position: DVec3::ZERO,
        range: 3.0,
    };
    let mut scene = Scene::new(point);
    let message = |scene: &Scene| {
        scene
            .plan()
            .map_err(|e| e.to_string())
            .err()
            .unwrap_or_default()
    };
    assert_eq!(
        message(&scene),
        "method `pssm` cannot shadow this light: a cube map has no splits; choose another method for point lights"
    );
    assert!(matches!(Pssm.supports(&scene.light), Support::No(_)));
    scene = Scene::new(sun());
    scene.hold(vec![ground(100.0)]);
    scene.view.position = DVec3::Y * 2.0;
    scene.set("resolution", 8192.0);
    assert!(
        message(&scene).contains("choose smaller tiles or fewer splits"),
        "{}",
        message(&scene)
    );
    scene.set("resolution", 1024.0);
    scene.set("splits", 5.0);
    scene.choose("lookup", "masks");
    assert_eq!(
        message(&scene),
        "the setting `splits` is 5, but must be 4 at the most with the lookup `masks`; `packed`, `storage` and `matrix_texture` hold 8"
    );
    for (axis, value) in [
        ("lookup", "best"),
        ("fit", "loose"),
        ("transition", "slow"),
        ("pcf", "4"),
    ] {
        let mut scene = Scene::new(sun());
        scene.choose(axis, value);
        assert!(message(&scene).contains(&format!("the axis `{axis}` is {value}")));
    }
}

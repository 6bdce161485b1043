//! Properties of each family of cases: it is as hard as its name says.

use std::{collections::BTreeSet, sync::Arc};

use glam::{DMat3, DVec3};
use umbrage_render::Scene;
use umbrage_shadow::{Extent, Lens, LightKind};

use super::{
    Case, all,
    depth::SEAMS,
    direction::GRAZING,
    tests::{case, look, samples},
    wall::WALL_LAMPS,
};

fn forward(scene: &Scene) -> DVec3 {
    scene.camera.rotation * DVec3::NEG_Z
}

fn direction(scene: &Scene) -> DVec3 {
    match scene.lights[0].light.kind {
        LightKind::Directional { direction } | LightKind::Spot { direction, .. } => direction,
        LightKind::Point { .. } => unreachable!("the light has a direction"),
    }
}

fn seen_names(case: &Case) -> BTreeSet<&str> {
    let (_, sight) = look(case);
    let objects = sight.seen().iter().flatten().map(|seen| seen.object);
    objects
        .map(|object| case.scene.objects[object as usize].name.as_str())
        .collect()
}

#[test]
fn depths_of_all_decades_are_lit_and_shaded() {
    let case = case("depth-range");
    let camera = case.scene.camera;
    assert_eq!((camera.near, camera.far), (0.1, 1000.0));
    let samples = samples(&case);
    for (from, to) in [(0.9, 1.2), (9.0, 12.0), (90.0, 120.0), (850.0, 1000.0)] {
        for is_lit in [false, true] {
            let found = samples.iter().filter(|(seen, term)| {
                let depth = seen.position.dot(forward(&case.scene));
                (from..to).contains(&depth) && (*term > 0.5) == is_lit
            });
            let found = found.count();
            assert!(found > 20, "{found} of {is_lit} from {from} to {to} m");
        }
    }
}

/// The nearest caster stands 2 cm before the lamp, what is lit reaches nearly to its end.
#[test]
fn a_spot_light_shades_from_its_bulb_to_its_range() {
    let case = case("depth-range-spot");
    let LightKind::Spot {
        position, range, ..
    } = case.scene.lights[0].light.kind
    else {
        unreachable!("a spot light")
    };
    assert_eq!(range, 100.0);
    let boxes = case.scene.objects.iter().map(|object| &object.bounds);
    let distances = boxes.map(|b| position.clamp(b.min, b.max).distance(position));
    let nearest = distances.fold(f64::INFINITY, f64::min);
    assert!((0.01..0.03).contains(&nearest), "{nearest}");
    let far = samples(&case)
        .into_iter()
        .filter(|(seen, _)| (seen.position + case.scene.camera.position).distance(position) > 75.0);
    let dark = far.filter(|(_, term)| *term < 0.5).count();
    assert!(dark > 50, "{dark}");
}

#[test]
fn duelling_lights_shine_along_the_view() {
    for (name, along) in [
        ("duelling-frusta-along", 1.0),
        ("duelling-frusta-against", -1.0),
    ] {
        let scene = case(name).scene;
        assert!((direction(&scene) - along * forward(&scene)).length() < 1e-12);
    }
}

#[test]
fn overhead_lights_are_straight_above() {
    for name in ["overhead", "overhead-down", "overhead-spot"] {
        let scene = case(name).scene;
        assert_eq!(direction(&scene), DVec3::NEG_Y, "{name}");
    }
    let view = forward(&case("overhead-down").scene);
    assert!((view - DVec3::NEG_Y).length() < 1e-12);
    let spots = case("overhead-spot").scene.lights;
    assert!(
        matches!(spots[1].light.kind, LightKind::Spot { direction, .. } if direction == DVec3::Y)
    );
}

#[test]
fn grazing_angles_are_exact() {
    for (name, _, degrees) in GRAZING {
        let light = direction(&case(name).scene);
        let angle = light.x.hypot(light.z).atan2(-light.y);
        assert!(
            (angle - degrees.to_radians()).abs() < 1e-12,
            "{name}: {angle}"
        );
    }
}

/// Most of the wall lies at more than 87° to the light, some of it in shadow.
#[test]
fn lamps_graze_their_walls() {
    for (name, _, gap) in WALL_LAMPS {
        let case = case(name);
        let (LightKind::Point { position, .. } | LightKind::Spot { position, .. }) =
            case.scene.lights[0].light.kind
        else {
            unreachable!("a lamp")
        };
        assert_eq!(position.z, gap);
        let wall = case.scene.objects.iter().position(|o| o.name == "wall");
        let on_wall: Vec<_> = samples(&case)
            .iter()
            .filter(|(seen, _)| Some(seen.object as usize) == wall)
            .map(|(seen, term)| {
                let offset = seen.position + case.scene.camera.position - position;
                (offset.truncate().length() / gap, *term > 0.5)
            })
            .collect();
        let flat = on_wall.iter().filter(|(slope, _)| *slope > 19.0).count();
        assert!(4 * flat > 3 * on_wall.len(), "{name}: {flat}");
        for is_lit in [false, true] {
            let found = on_wall.iter().filter(|s| s.0 > 19.0 && s.1 == is_lit);
            assert!(found.count() > 2000, "{name}: {is_lit}");
        }
    }
}

#[test]
fn mirrors_mirror() {
    let case = case("open-mesh-mirrored");
    let objects = &case.scene.objects;
    let is_mirrored = |o: &&umbrage_render::Object| o.transform.matrix3.determinant() < 0.0;
    let mirrored: Vec<_> = objects.iter().filter(is_mirrored).collect();
    assert_eq!(mirrored.len(), 3);
    let mirror = DMat3::from_diagonal(DVec3::new(-1.0, 1.0, 1.0));
    for object in mirrored {
        let twin = objects.iter().find(|twin| {
            Arc::ptr_eq(&twin.mesh, &object.mesh)
                && mirror * twin.transform.translation == object.transform.translation
        });
        let twin = twin.expect("a twin under no mirror");
        assert_eq!(mirror * twin.transform.matrix3, object.transform.matrix3);
    }
}

#[test]
fn what_touches_touches() {
    let standing = ["wall", "ball", "cone", "kerb", "plinth", "pillar", "ramp"];
    for (name, count) in [
        ("contact", 3),
        ("contact-lamp", 3),
        ("exponent-contact", 4),
        ("exponent-contact-spot", 4),
    ] {
        let scene = case(name).scene;
        let objects = scene.objects.iter();
        let standing: Vec<_> = objects
            .filter(|object| standing.contains(&object.name.as_str()))
            .collect();
        assert_eq!(standing.len(), count, "{name}");
        for object in standing {
            assert!(object.bounds.min.y.abs() < 1e-7, "{name}: {}", object.name);
        }
    }
}

/// Depths along the light for an exponent to span: 80 m under a sun, a ratio of 80 under a spot light.
#[test]
fn exponents_have_far_to_go() {
    for name in ["exponent", "exponent-contact"] {
        let scene = case(name).scene;
        let beams = scene.objects.iter().filter(|o| o.name == "beam");
        let heights: Vec<_> = beams.map(|beam| beam.bounds.center().y).collect();
        assert!(heights.len() >= 2, "{name}");
        assert!(
            heights.iter().all(|y| (y - 80.0).abs() < 1e-6),
            "{heights:?}"
        );
    }
    let case = case("exponent-contact-spot");
    let LightKind::Spot { position, .. } = case.scene.lights[0].light.kind else {
        unreachable!("a spot light")
    };
    let depth = |at: DVec3| (at - position).dot(direction(&case.scene));
    let bars = case.scene.objects.iter().filter(|o| o.name == "bar");
    let nearest = bars.map(|bar| depth(bar.bounds.center()));
    let nearest = nearest.fold(f64::INFINITY, f64::min);
    let seen = samples(&case).into_iter();
    let farthest = seen.map(|(seen, _)| depth(seen.position + case.scene.camera.position));
    let ratio = farthest.fold(0.0, f64::max) / nearest;
    assert!((70.0..90.0).contains(&ratio), "{ratio}");
}

/// No plane, a plane within a small part of a texel, and one within about a texel.
#[test]
fn blocks_are_more_or_less_planes() {
    for name in ["steep-blocks-7", "steep-blocks-spot-7"] {
        let scene = case(name).scene;
        let span = |name: &str| {
            let found = scene.objects.iter().find(|object| object.name == name);
            let bounds = found.expect("a patch").bounds;
            bounds.max.y - bounds.min.y
        };
        assert!((0.010..0.013).contains(&span("rough")), "{name}");
        assert!((0.10..0.13).contains(&span("rougher")), "{name}");
    }
}

#[test]
fn casters_behind_are_not_seen() {
    let seen = |name: &str| {
        seen_names(&case(name))
            .into_iter()
            .map(str::to_owned)
            .collect::<Vec<_>>()
    };
    assert_eq!(seen("behind"), ["ground"]);
    assert!(!seen("behind-light").contains(&"ring".to_owned()));
    assert!(!seen("behind-spot").contains(&"bar".to_owned()));
    let scene = case("behind-spot").scene;
    let LightKind::Spot { position, .. } = scene.lights[0].light.kind else {
        unreachable!("a spot light")
    };
    assert!((position - scene.camera.position).dot(forward(&scene)) < 0.0);
}

#[test]
fn the_viewers_head_is_not_seen_and_shades() {
    let case = case("empty-head");
    let names = seen_names(&case);
    assert!(
        !names.contains("ball") && !names.contains("body"),
        "{names:?}"
    );
    let head = case
        .scene
        .objects
        .iter()
        .find(|o| o.name == "ball")
        .expect("a head");
    assert_eq!(head.bounds.center(), case.scene.camera.position);
    assert!(head.bounds.max.y - case.scene.camera.position.y < case.scene.camera.near);
}

#[test]
fn casters_keep_to_one_split() {
    let scene = case("empty-split").scene;
    for object in scene.objects.iter().filter(|object| object.material.casts) {
        assert!(object.bounds.max.z <= -28.0 && object.bounds.min.z >= -62.0);
    }
}

#[test]
fn shards_have_triangles_without_area_among_others() {
    let scene = case("empty-degenerate").scene;
    let shard = scene
        .objects
        .iter()
        .find(|o| o.name == "shard")
        .expect("a shard");
    let flat = shard
        .mesh
        .normals
        .chunks(3)
        .filter(|normals| normals[0].length() == 0.0);
    assert_eq!((flat.count(), shard.mesh.normals.len() / 3), (4, 5));
}

/// Where any of three schemes puts a border of 1 to 8 splits (lambda 0 uniform, 1 logarithmic, between
/// them practical: Zhang et al. 2006), there are light and shadow on the ground.
#[test]
fn every_split_border_lies_across_an_edge() {
    let case = case("split-seams");
    let (near, far) = SEAMS;
    assert_eq!((case.scene.camera.near, case.scene.camera.far), SEAMS);
    let ground = case
        .scene
        .objects
        .iter()
        .position(|o| o.name == "valley")
        .expect("a ground");
    let on_ground: Vec<_> = samples(&case)
        .iter()
        .filter(|(seen, _)| seen.object as usize == ground)
        .map(|(seen, term)| (seen.position.dot(forward(&case.scene)), *term > 0.5))
        .collect();
    for splits in 2..=8_u32 {
        for (border, lambda) in (1..splits).flat_map(|i| [0.0, 0.5, 1.0].map(|l| (i, l))) {
            let share = f64::from(border) / f64::from(splits);
            let logarithmic = near * (far / near).powf(share);
            let border = lambda * logarithmic + (1.0 - lambda) * (near + share * (far - near));
            for is_lit in [false, true] {
                let close = |depth: f64| (depth / border - 1.0).abs() < 0.05;
                let found = on_ground
                    .iter()
                    .filter(|s| close(s.0) && s.1 == is_lit)
                    .count();
                assert!(found >= 5, "{splits} splits, {border} m, {is_lit}: {found}");
            }
        }
    }
}

/// Less than a texel of a map of 2048 texels over the ground that is seen, and less than a pixel of what
/// is seen nearest; and never the same offset within a texel.
#[test]
fn motions_are_less_than_a_texel_and_than_a_pixel() {
    for case in all().into_iter().filter(|case| !case.frames.is_empty()) {
        assert_eq!(case.frames.len(), 64, "{}", case.name);
        let scene = &case.scene;
        let view = scene.view(case.size.0, case.size.1);
        let ground = scene.objects[0].bounds.translate(-view.position);
        let lens = Lens::directional(direction(scene));
        let extent = Extent::of(&lens, DVec3::ZERO, &[ground], &[&view.frustum_relative()]);
        let texel = extent
            .expect("the ground is seen")
            .rect
            .size()
            .max_element()
            / 2048.0;
        let (_, sight) = look(&case);
        let depths = sight
            .seen()
            .iter()
            .flatten()
            .map(|s| s.position.dot(forward(scene)));
        let nearest = depths.fold(f64::INFINITY, f64::min);
        let pixel = view.projection.size_at(1.0).y / f64::from(case.size.1);
        let (mut slid, mut turned) = (0, 0);
        for pair in case.frames.windows(2) {
            let step = pair[0].position.distance(pair[1].position);
            let turn = pair[0].rotation.angle_between(pair[1].rotation);
            assert!(
                step < texel && step < pixel * nearest,
                "{step} m, {texel} m a texel"
            );
            assert!(turn < pixel, "{turn}");
            slid += usize::from(step > 0.0);
            turned += usize::from(turn > 1e-6);
        }
        assert_eq!((slid, turned), (31, 32), "{}", case.name);
    }
}

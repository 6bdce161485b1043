//! The generators, and what is true of all cases.

use std::collections::BTreeSet;

use glam::DVec3;
use umbrage_shadow::LightKind;

use super::{Case, all, empty::UNSHADOWED};
use crate::truth::{Seen, Sight, Source, Tracer};

pub(super) fn case(name: &str) -> Case {
    let mut found = all().into_iter().filter(|case| case.name == name);
    found.next().expect("a case of that name")
}

pub(super) fn look(case: &Case) -> (Tracer, Sight) {
    let tracer = Tracer::new(&case.scene).expect("a sound scene");
    let sight = tracer
        .look(case.size.0, case.size.1, &|| ())
        .expect("a size");
    (tracer, sight)
}

/// Points that the pixels see and their shadow terms, where a light reaches; the lights' one after another.
pub(super) fn samples(case: &Case) -> Vec<(Seen, f32)> {
    let (tracer, sight) = look(case);
    let of_light = |light| {
        let terms = tracer.shadow(&sight, light, Source::Sharp, &|| ());
        let pixels = sight.seen().iter().zip(terms.expect("a light"));
        let pairs = pixels.filter_map(|(seen, term)| Some(((*seen)?, term?)));
        pairs.collect::<Vec<_>>()
    };
    (0..case.scene.lights.len()).flat_map(of_light).collect()
}

#[test]
fn every_kind_has_its_cases_each_with_a_name_of_its_own() {
    let cases = all();
    let names: Vec<_> = cases.iter().map(|case| case.name).collect();
    assert_eq!(names.iter().collect::<BTreeSet<_>>().len(), names.len());
    for kind in [
        "depth-range",
        "duelling-frusta",
        "overhead",
        "grazing",
        "far-away",
        "tiny",
        "huge",
        "open-mesh",
        "contact",
        "behind",
        "exponent",
        "steep-blocks",
        "empty",
        "motion",
        "split-seams",
        "wall-lamp",
        "orthographic",
    ] {
        assert!(names.iter().any(|name| name.starts_with(kind)), "{kind}");
    }
    for (index, case) in cases.iter().enumerate() {
        if let Some(twin) = case.same_as {
            assert!(
                names[..index].contains(&twin),
                "{} comes before {twin}",
                case.name
            );
        }
    }
    let kinds = |wanted: fn(&LightKind) -> bool| {
        let lit = |case: &&Case| {
            case.scene
                .lights
                .iter()
                .any(|light| wanted(&light.light.kind))
        };
        cases.iter().filter(lit).count()
    };
    assert!(kinds(|kind| matches!(kind, LightKind::Point { .. })) >= 5);
    assert!(kinds(|kind| matches!(kind, LightKind::Spot { .. })) >= 5);
}

/// Light and shadow in healthy shares, so that neither kind of error can hide.
#[test]
fn the_truth_of_each_case_has_light_and_shadow() {
    for case in all() {
        let samples = samples(&case);
        assert!(
            samples.len() > 4000,
            "{}: {} samples",
            case.name,
            samples.len()
        );
        let dark = samples.iter().filter(|(_, term)| *term < 0.5).count();
        let share = dark as f64 / samples.len() as f64;
        if UNSHADOWED.contains(&case.name) {
            assert_eq!(dark, 0, "{}", case.name);
        } else {
            assert!(
                (0.03..=0.97).contains(&share),
                "{}: {share} in shadow",
                case.name
            );
        }
    }
}

#[test]
fn the_same_cases_come_out_each_time() {
    for (first, second) in all().iter().zip(&all()) {
        assert_eq!(first.frames, second.frames);
        assert_eq!(first.scene.lights, second.scene.lights);
        assert_eq!(first.scene.objects.len(), second.scene.objects.len());
        for (a, b) in first.scene.objects.iter().zip(&second.scene.objects) {
            assert!(a.mesh == b.mesh && a.transform == b.transform && a.bounds == b.bounds);
        }
    }
}

#[test]
fn meshes_are_finite_and_their_normals_unit() {
    for case in all() {
        for object in &case.scene.objects {
            let mesh = &object.mesh;
            assert_eq!(mesh.positions.len(), mesh.normals.len());
            assert!(mesh.positions.iter().all(|place| place.is_finite()));
            let may_be_zero = case.name == "empty-degenerate" && object.name == "shard";
            for normal in &mesh.normals {
                let is_unit = (normal.length() - 1.0).abs() < 1e-5;
                let is_zero = may_be_zero && normal.length() == 0.0;
                assert!(is_unit || is_zero, "{}: {}", case.name, object.name);
            }
        }
    }
}

/// Relative to their cameras, as far as the places' own digits go.
#[test]
fn twins_are_alike() {
    for twin in all() {
        let Some(name) = twin.same_as else { continue };
        let base = case(name);
        let (a, b) = (&base.scene, &twin.scene);
        let scale = b.camera.near / a.camera.near;
        assert!((b.camera.far / a.camera.far - scale).abs() < 1e-12 * scale);
        assert_eq!(a.camera.rotation, b.camera.rotation);
        let farthest = b.camera.position.length() + 20.0 * scale;
        let bound = 8.0 * f64::EPSILON * farthest;
        let alike = |from: DVec3, to: DVec3| {
            let (from, to) = (from - a.camera.position, to - b.camera.position);
            assert!(
                (scale * from - to).length() <= bound,
                "{}: {from} {to}",
                twin.name
            );
        };
        assert_eq!(a.objects.len(), b.objects.len());
        for (from, to) in a.objects.iter().zip(&b.objects) {
            assert_eq!(from.mesh, to.mesh);
            for place in &from.mesh.positions {
                let place = place.as_dvec3();
                alike(
                    from.transform.transform_point3(place),
                    to.transform.transform_point3(place),
                );
            }
        }
        for (from, to) in a.lights.iter().zip(&b.lights) {
            match (&from.light.kind, &to.light.kind) {
                (
                    LightKind::Directional { direction },
                    LightKind::Directional { direction: to },
                ) => {
                    assert_eq!(direction, to);
                }
                (
                    LightKind::Spot {
                        position, range, ..
                    }
                    | LightKind::Point { position, range },
                    LightKind::Spot {
                        position: to,
                        range: to_range,
                        ..
                    }
                    | LightKind::Point {
                        position: to,
                        range: to_range,
                    },
                ) => {
                    alike(*position, *to);
                    assert!((scale * range - to_range).abs() <= bound);
                }
                _ => unreachable!("lights of the same kind"),
            }
        }
    }
    let out = |name: &str| case(name).scene.camera.position.abs().min_element();
    assert!(out("far-away-1e5") > 6e4 && out("far-away-1e6") > 6e5);
}

/// A scene that is far out or scaled has the truth of its twin: but for edges through a pixel's very centre, which rounding
/// may put on either side.
#[test]
fn twins_have_the_same_truth() {
    let base: Vec<_> = samples(&case("far-away-origin"))
        .iter()
        .map(|s| s.1)
        .collect();
    for twin in all().iter().filter(|case| case.same_as.is_some()) {
        let terms: Vec<_> = samples(twin).iter().map(|s| s.1).collect();
        assert_eq!(terms.len(), base.len(), "{}", twin.name);
        let differ = terms.iter().zip(&base).filter(|(a, b)| a != b).count();
        assert!(differ <= 3, "{}: {differ}", twin.name);
    }
}

//! Scenes that cannot be traced.

use std::sync::Arc;

use glam::{DVec3, Vec3};
use umbrage_render::{Mesh, Scene};
use umbrage_shadow::LightKind;

use super::stage::{HERE, scene, square};
use crate::truth::{Source, Tracer, TruthError};

fn sound() -> Scene {
    let floor = HERE.object("floor", square(1.0), DVec3::ZERO);
    let camera = HERE.camera(DVec3::new(0.0, 2.0, 1.0), DVec3::ZERO, DVec3::Y);
    let direction = DVec3::NEG_Y;
    scene(vec![floor], LightKind::Directional { direction }, camera)
}

/// Message about the sound scene after a change.
fn said(change: impl FnOnce(&mut Scene)) -> String {
    let mut scene = sound();
    change(&mut scene);
    let refused = Tracer::new(&scene).err().expect("refused");
    refused.to_string()
}

fn with_mesh(scene: &mut Scene, change: impl FnOnce(&mut Mesh)) {
    change(Arc::make_mut(&mut scene.objects[0].mesh));
}

#[test]
fn scenes_that_cannot_be_traced() {
    assert!(said(|scene| scene.objects.clear()).contains("no triangles; give it a model"));
    assert!(said(|scene| with_mesh(scene, |mesh| mesh.indices.clear())).contains("no triangles"));
    assert!(said(|scene| scene.lights.clear()).contains("no lights; give it one"));
    assert!(
        said(|scene| with_mesh(scene, |mesh| mesh.indices[4] = 4))
            .contains("object `floor` names vertex 4, but its mesh has 4")
    );
    for bad in [f32::NAN, f32::INFINITY, 1e20] {
        let said = said(|scene| with_mesh(scene, |mesh| mesh.positions[2] = Vec3::splat(bad)));
        assert!(said.contains("vertex 2 of object `floor`"), "{said}");
        assert!(said.contains("mend the model"), "{said}");
    }
    assert!(said(|scene| scene.camera.position.x = f64::NAN).contains("the camera cannot be used"));
    assert!(said(|scene| scene.camera.near = 0.0).contains("near distance is 0"));
    let direction = DVec3::ZERO;
    let dark = LightKind::Directional { direction };
    let said = said(|scene| scene.lights[0].light.kind = dark);
    assert!(
        said.starts_with("light 0 cannot be used: the light's direction"),
        "{said}"
    );
}

#[test]
fn questions_that_cannot_be_answered() {
    let tracer = Tracer::new(&sound()).expect("a sound scene");
    for (width, height) in [(0, 5), (5, 0), (u32::MAX, u32::MAX)] {
        let refused = tracer.look(width, height, &|| ());
        assert_eq!(refused, Err(TruthError::Size { width, height }));
    }
    let sight = tracer.look(2, 2, &|| ()).expect("a size");
    let refused = |light, source| {
        tracer
            .shadow(&sight, light, source, &|| ())
            .expect_err("refused")
    };
    let message = refused(1, Source::Sharp).to_string();
    assert_eq!(
        message,
        "there is no light 1; the scene has 1, counted from 0"
    );
    for (size, strata) in [
        (0.0, 4),
        (-1.0, 4),
        (f64::NAN, 4),
        (1.6, 4),
        (0.1, 0),
        (0.1, 65),
    ] {
        let message = refused(0, Source::Round { size, strata }).to_string();
        assert!(message.contains("cannot be traced"), "{message}");
    }
    let mut smaller = sound();
    with_mesh(&mut smaller, |mesh| mesh.indices.truncate(3));
    smaller.objects.push(sound().objects.remove(0));
    let other = Tracer::new(&smaller).expect("a sound scene");
    let foreign = other.look(8, 8, &|| ()).expect("a size");
    let refused = tracer.shadow(&foreign, 0, Source::Sharp, &|| ());
    assert_eq!(refused, Err(TruthError::ForeignSight));
}

#[test]
fn triangles_without_an_area_are_no_surface() {
    let mut scene = sound();
    with_mesh(&mut scene, |mesh| mesh.positions = vec![Vec3::ZERO; 4]);
    let tracer = Tracer::new(&scene).expect("a sound scene");
    let sight = tracer.look(9, 9, &|| ()).expect("a size");
    assert!(sight.seen().iter().all(Option::is_none));
    let terms = tracer.shadow(&sight, 0, Source::Sharp, &|| ());
    assert_eq!(terms.expect("a light"), [None; 81]);
}

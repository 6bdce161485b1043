//! Truths that are kept.

use std::{
    fs,
    path::PathBuf,
    sync::{
        Arc,
        atomic::{AtomicUsize, Ordering},
    },
};

use glam::{DVec3, Vec3};
use tempfile::TempDir;
use umbrage_render::{Material, Scene, Shadow};
use umbrage_shadow::{Field, LightKind};

use super::stage::{HERE, block, scene, square};
use crate::truth::{Source, Truth, TruthStore, content::content};

const SIZE: (u32, u32) = (32, 18);
const SOFT: [Source; 1] = [Source::Round {
    size: 0.1,
    strata: 3,
}];

/// A box on a floor in the sun.
fn stage() -> Scene {
    let floor = HERE.object("floor", square(5.0), DVec3::ZERO);
    let box_on_it = HERE.object("box", block(Vec3::splat(0.5)), DVec3::Y);
    let direction = DVec3::new(1.0, -1.0, 0.5).normalize();
    let camera = HERE.camera(DVec3::new(3.0, 4.0, 5.0), DVec3::ZERO, DVec3::Y);
    scene(
        vec![floor, box_on_it],
        LightKind::Directional { direction },
        camera,
    )
}

fn entries(folder: &TempDir) -> Vec<PathBuf> {
    let entries = fs::read_dir(folder.path()).expect("listed");
    entries
        .map(|entry| entry.expect("an entry").path())
        .collect()
}

#[test]
fn what_is_kept_is_what_was_traced() {
    let folder = TempDir::new().expect("a folder");
    let store = TruthStore::open(folder.path()).expect("a store");
    for sources in [&[][..], &SOFT] {
        let traced = Truth::trace(&stage(), SIZE, sources, &|| ()).expect("traced");
        let get = || {
            store
                .truth(&stage(), SIZE, sources, &|| ())
                .expect("a truth")
        };
        let (first, second) = (get(), get());
        assert!(first.1.is_empty() && second.1.is_empty(), "no warnings");
        assert!(first.0 == traced && second.0 == traced);
    }
    assert_eq!(entries(&folder).len(), 2);
}

#[test]
fn what_is_kept_is_not_traced_again() {
    let folder = TempDir::new().expect("a folder");
    let store = TruthStore::open(folder.path()).expect("a store");
    let rows = || {
        let count = AtomicUsize::new(0);
        let on_row = || {
            count.fetch_add(1, Ordering::Relaxed);
        };
        store.truth(&stage(), SIZE, &[], &on_row).expect("a truth");
        count.into_inner()
    };
    assert_eq!(rows(), Truth::rows(&stage(), SIZE.1));
    assert_eq!(rows(), 0);
}

#[test]
fn damage_is_told_and_mended() {
    let folder = TempDir::new().expect("a folder");
    let store = TruthStore::open(folder.path()).expect("a store");
    let get = || store.truth(&stage(), SIZE, &[], &|| ()).expect("a truth");
    let (whole, _) = get();
    let entry = entries(&folder).remove(0);
    let bytes = fs::read(&entry).expect("read");
    let mut flipped = bytes.clone();
    flipped[200] ^= 1;
    for damaged in [&bytes[..40], &bytes[..bytes.len() - 1], &flipped, b""] {
        fs::write(&entry, damaged).expect("written");
        let (truth, warnings) = get();
        assert!(truth == whole);
        assert!(
            matches!(&warnings[..], [warning] if warning.contains("is no good")),
            "{warnings:?}"
        );
        assert!(get().1.is_empty(), "it was mended");
    }
}

#[test]
fn the_name_follows_what_the_truth_depends_on_and_nothing_else() {
    let name = |scene: &Scene| content(scene, SIZE, &[]);
    let base = name(&stage());
    let changed = |change: &dyn Fn(&mut Scene)| {
        let mut scene = stage();
        change(&mut scene);
        name(&scene)
    };
    let same: [&dyn Fn(&mut Scene); 4] = [
        &|scene| scene.ambient = Vec3::ONE,
        &|scene| scene.lights[0].light.color = Vec3::X,
        &|scene| scene.objects[0].name.push('s'),
        // Without a cut-off no opacity matters.
        &|scene| Arc::make_mut(&mut scene.objects[0].material).base_color.w = 0.5,
    ];
    for (index, change) in same.iter().enumerate() {
        assert_eq!(changed(*change), base, "{index}");
    }
    fn material(scene: &mut Scene) -> &mut Material {
        Arc::make_mut(&mut scene.objects[0].material)
    }
    let other: [&dyn Fn(&mut Scene); 12] = [
        &|scene| {
            scene.lights[0].shadow = Some(Shadow {
                method: Shadow::NONE.to_owned(),
                ..Shadow::default()
            });
        },
        &|scene| scene.camera.position.x += 1e-9,
        &|scene| scene.camera.far += 1.0,
        &|scene| scene.camera.field = Field::Perspective { fov_y: 0.5 },
        &|scene| scene.camera.field = Field::Orthographic { height: 0.5 },
        &|scene| scene.objects[1].transform.translation.y += 1e-9,
        &|scene| Arc::make_mut(&mut scene.objects[1].mesh).positions[3].x += 1e-3,
        &|scene| Arc::make_mut(&mut scene.objects[1].mesh).indices.swap(0, 1),
        &|scene| material(scene).casts = false,
        &|scene| material(scene).alpha_cutoff = Some(0.5),
        &|scene| drop(scene.objects.pop()),
        &|scene| {
            scene.lights[0].light.kind = LightKind::Directional {
                direction: DVec3::NEG_Y,
            };
        },
    ];
    let mut names: Vec<_> = other.iter().map(|change| changed(*change)).collect();
    names.extend([
        base,
        content(&stage(), (18, 32), &[]),
        content(&stage(), SIZE, &SOFT),
    ]);
    let count = names.len();
    names.sort();
    names.dedup();
    assert_eq!(names.len(), count, "all differ");
}

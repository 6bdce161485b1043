//! The scenes look as their pictures do, and need no permutation that the demo's manifest lacks.
//!
//! `UMBRAGE_BLESS=1 cargo test -p umbrage_examples` writes the pictures anew.

use std::{
    collections::BTreeSet,
    fs,
    path::{Path, PathBuf},
    sync::Arc,
};

use umbrage::{
    compose::{Composer, Manifest, Target},
    methods::registry,
    render::{Gpu, RenderOptions, Rendered, Renderer, Scene, Shadow, What},
    shader_library,
};
use umbrage_testkit::pictures::{self, Difference};

const SIZE: (u32, u32) = (480, 320);

fn folder(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join(name)
}

/// The names of the files in a folder that end in `extension`, without it.
fn names(folder: &Path, extension: &str) -> BTreeSet<String> {
    let paths = fs::read_dir(folder)
        .expect("a folder")
        .map(|entry| entry.expect("an entry").path());
    paths
        .filter(|path| path.extension().is_some_and(|found| found == extension))
        .filter_map(|path| Some(path.file_stem()?.to_str()?.to_owned()))
        .collect()
}

fn scenes() -> BTreeSet<String> {
    let scenes = names(&folder("scenes"), "ron");
    assert!(!scenes.is_empty(), "no scenes");
    scenes
}

/// Pictures compared: for each scene its own, and a map's splits where there is most to see of them.
fn pictures() -> Vec<(String, String, What)> {
    let scenes = scenes().into_iter();
    let shaded = scenes.map(|name| (name.clone(), name, What::Shaded));
    let splits = (
        "avenue_splits".to_owned(),
        "avenue".to_owned(),
        What::Splits,
    );
    shaded.chain([splits]).collect()
}

fn renderer() -> Renderer {
    let composer = Composer::new(shader_library().expect("a library"), Target::webgpu());
    let gpu = Gpu::new().expect("an adapter");
    Renderer::new(
        Arc::new(gpu),
        Arc::new(composer),
        registry().expect("a registry"),
    )
}

fn render(
    renderer: &mut Renderer,
    scene: &str,
    (width, height): (u32, u32),
    what: What,
    method: Option<&str>,
) -> Rendered {
    let scene = Scene::load(folder("scenes").join(format!("{scene}.ron"))).expect("a scene");
    let options = RenderOptions {
        width,
        height,
        what,
        shadow: method.map(Shadow::new).unwrap_or_default(),
        ..RenderOptions::default()
    };
    renderer.render(&scene, &options).expect("a picture")
}

#[test]
fn scenes_look_as_their_pictures_do() {
    let mut renderer = renderer();
    let mut wrong = Vec::new();
    for (name, scene, what) in pictures() {
        let rendered = render(&mut renderer, &scene, SIZE, what, None);
        let reference = folder("pictures").join(format!("{name}.png"));
        let picture = rendered.to_image().into_rgb8();
        wrong.extend(pictures::check(&picture, &reference).err());
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn every_picture_is_a_scenes() {
    // The other direction, a scene without a picture, fails where they are compared.
    let known: BTreeSet<_> = pictures().into_iter().map(|(name, ..)| name).collect();
    for picture in names(&folder("pictures"), "png") {
        assert!(
            known.contains(&picture),
            "pictures/{picture}.png has no scene: remove it"
        );
    }
}

#[test]
fn scenes_need_no_permutation_that_the_manifest_lacks() {
    let manifest = Manifest::load(&folder("../permutations/demo.ron")).expect("a manifest");
    let composer = Composer::new(manifest.library().clone(), Target::webgpu());
    let variants = composer.select(manifest.selection());
    let checked: BTreeSet<_> = variants.map(|variant| variant.key()).collect();
    let mut renderer = renderer();
    for name in scenes() {
        for what in [What::Shaded, What::ShadowTerm, What::Splits] {
            let report = render(&mut renderer, &name, (96, 64), what, None).report;
            assert!(!report.permutations.is_empty(), "{name}");
            for used in report.permutations {
                assert!(
                    checked.contains(&used.key),
                    "{name} needs {} for {}, which no key of permutations/demo.ron gives: add it there",
                    used.key,
                    used.object
                );
            }
        }
    }
}

#[test]
fn a_picture_without_shadows_is_told_from_one_with_them() {
    let mut renderer = renderer();
    for name in scenes() {
        let [with, without] = [None, Some("none")].map(|method| {
            let rendered = render(&mut renderer, &name, SIZE, What::Shaded, method);
            rendered.to_image().into_rgb8()
        });
        let difference = Difference::of(&with, &without);
        assert!(!difference.is_small(), "{name}: {difference}");
    }
}

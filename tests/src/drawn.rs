//! Permutations to draw, and to give to other compilers.

use std::{collections::BTreeSet, error::Error, path::Path, sync::Arc};

use umbrage::{
    compose::{self, Composer, Key, ProjectedKey, Selection},
    render::{Gpu, RenderOptions, Renderer, Scene, What},
};
use umbrage_measure::{
    cases::{self, Limits},
    study::{CompareOptions, Config, Lab, compare, stress},
};

use crate::registry;

/// Keys of a [cover](Composer::cover) of the whole space, in which every pair of choices occurs.
///
/// # Errors
/// Faults in our shaders.
pub fn covering(composer: &Composer) -> Result<BTreeSet<ProjectedKey>, compose::Error> {
    Ok(composer.cover(&Selection::all())?.into_iter().collect())
}

/// Projected keys of all that the demo, `compare` and `stress` need: each of our scenes in each kind of picture and with
/// each configuration, and each hard case with each variant of the table of limits. They are run in small, with small
/// maps, by `composer`.
///
/// # Errors
/// A scene that cannot be drawn.
pub fn used(gpu: &Arc<Gpu>, composer: &Arc<Composer>) -> Result<Vec<ProjectedKey>, Box<dyn Error>> {
    let (registry, library) = (umbrage::methods::registry()?, composer.library());
    let methods: Vec<_> = registry.methods.names().map(str::to_owned).collect();
    let scenes = scenes()?;
    let mut renderer = Renderer::new(Arc::clone(gpu), Arc::clone(composer), registry.clone());
    for (_, scene) in &scenes {
        for what in PICTURES {
            let options = RenderOptions {
                width: SIZE.0,
                height: SIZE.1,
                what,
                ..RenderOptions::default()
            };
            renderer.render(scene, &options)?;
        }
    }
    let small = |config: Config| {
        let mut config = config;
        config.shadow = config.shadow.with_setting("resolution", MAP);
        config
    };
    let configs = Config::standard(&methods, &registry, library)?;
    let limits = Limits::built_in()?;
    let variants = limits.variants_of(&methods, &registry, library)?;
    let mut lab = Lab::new(Arc::clone(gpu), Arc::clone(composer), registry);
    let options = CompareOptions {
        size: SIZE,
        most_pairs: 1,
        frames: 0,
        store: None,
        command: String::new(),
    };
    let none = Err("no costs are asked for".to_owned());
    let configs: Vec<_> = configs.into_iter().map(small).collect();
    compare(&mut lab, &scenes, &configs, &options, none, &())?;
    let variants: Vec<_> = variants.into_iter().map(small).collect();
    let mut cases = cases::all();
    for case in &mut cases {
        case.size = SIZE;
        case.settings.remove("resolution");
        case.frames.truncate(1);
    }
    stress(&mut lab, &variants, &cases, &limits, None, &())?;
    Ok(composer.composed())
}

/// Pixels across and down.
const SIZE: (u32, u32) = (16, 9);

/// Texels along a shadow map.
const MAP: f64 = 64.0;

const PICTURES: [What; 7] = [
    What::Shaded,
    What::ShadowTerm,
    What::Triangles,
    What::Fetches,
    What::Decisions,
    What::ShaftFetches,
    What::Splits,
];

/// Our scenes, by their names.
fn scenes() -> Result<Vec<(String, Scene)>, Box<dyn Error>> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../examples/scenes");
    let mut paths = Vec::new();
    for entry in folder.read_dir()? {
        paths.push(entry?.path());
    }
    paths.retain(|path| path.extension().is_some_and(|ending| ending == "ron"));
    paths.sort();
    let scene = |path: &Path| Ok((path.display().to_string(), Scene::load(path)?));
    paths.iter().map(|path| scene(path)).collect()
}

/// `keys`, and beside each that samples a shadow map the same for each other depth that the map may hold: what other passes
/// draw, and no part of the permutation.
///
/// # Errors
/// Faults in our shaders.
pub fn of_each_depth(
    composer: &Composer,
    keys: impl IntoIterator<Item = ProjectedKey>,
) -> Result<BTreeSet<Key>, compose::Error> {
    let library = composer.library();
    let registry = registry();
    let mut all = BTreeSet::new();
    for key in keys {
        let method = library.axes().value(&key, "method").unwrap_or("");
        if registry.methods.get(method).is_ok() {
            let depths = library.axes().get("depth");
            for depth in depths.into_iter().flat_map(|axis| axis.values()) {
                let others = key.choices().filter(|(axis, _)| *axis != "depth");
                // Not every depth goes with every filter.
                let Ok(other) = library.key(others.chain([("depth", depth)])) else {
                    continue;
                };
                if composer.project(&other)? == key {
                    all.insert(other);
                }
            }
        }
        all.insert(key.into());
    }
    Ok(all)
}

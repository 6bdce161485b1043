//! Decisions by the bounds of blocks are what the whole filter finds: maps and receivers of all kinds, made up, read by the
//! shaders themselves, and judged by the comparison's own definition in f64. Not one pixel may differ.
#![allow(
    clippy::panic,
    reason = "a test's helpers may fail it, with the error's own words"
)]

use std::{collections::BTreeMap, path::Path, sync::Arc};

use umbrage::{
    compose::{Composer, Library, Package, Target},
    methods::methods::{basic::Basic, pssm::Pssm},
    render::{
        Decision, Gpu, Path as Way, Picture, RenderOptions, Rendered, Renderer, Scene, Shadow, What,
    },
    shadow::{
        Constants, Contents, Frame, Light, Part, Pass, PlanError, Reads, ScreenPass, Setting,
        ShadowMethod, ShadowPlan, Support, TextureDesc, Value, Viewport, Workgroups,
    },
};
use umbrage_tests::{Maps, Place};
use wgpu_types::TextureFormat;

/// Pixels along a picture: a receiver each, where the scene has a surface.
const SIZE: u32 = 96;

/// A method's own plan, with made-up depths in its maps and a made-up receiver for each pixel.
struct Probe {
    name: &'static str,
    method: Box<dyn ShadowMethod>,
    settings: Vec<Setting>,
}

impl Probe {
    fn new(name: &'static str, method: impl ShadowMethod + 'static) -> Self {
        let seed = Setting {
            name: "seed",
            doc: "which maps and receivers",
            min: 0.0,
            max: 1e9,
            default: 0.0,
            whole: true,
        };
        let settings = method.settings().iter().cloned().chain([seed]).collect();
        let method = Box::new(method);
        Self {
            name,
            method,
            settings,
        }
    }
}

impl Part for Probe {
    fn name(&self) -> &str {
        self.name
    }
    fn settings(&self) -> &[Setting] {
        &self.settings
    }
    fn axes(&self) -> &[&str] {
        self.method.axes()
    }
}

impl ShadowMethod for Probe {
    fn supports(&self, light: &Light) -> Support {
        self.method.supports(light)
    }
    fn plan(&self, frame: &Frame<'_>) -> Result<ShadowPlan, PlanError> {
        let mut plan = self.method.plan(frame)?;
        let tiles = tiles(&plan);
        let size = [plan.textures[0].width, plan.textures[0].height];
        let maps = Maps::new(frame.settings.get("seed") as u64, size, &tiles);
        let places = maps.places(SIZE * SIZE);
        plan.passes.retain(|pass| !matches!(pass, Pass::Casters(_)));
        plan.passes.insert(0, fill(size));
        let pixels = [SIZE; 2];
        let mut add = |name: &str, format, [width, height]: [u32; 2], numbers: Vec<f32>| {
            plan.textures
                .push(TextureDesc::d2(name, format, [width, height]));
            plan.contents.push(Contents {
                texture: name.to_owned(),
                bytes: numbers.into_iter().flat_map(f32::to_le_bytes).collect(),
            });
        };
        add(
            "probe_depths",
            TextureFormat::R32Float,
            size,
            maps.depths.clone(),
        );
        let at = places.iter().flat_map(Place::at).collect();
        add("probe_places", TextureFormat::Rgba32Float, pixels, at);
        let planes = places.iter().flat_map(Place::plane).collect();
        add("probe_planes", TextureFormat::Rgba32Float, pixels, planes);
        let texel = size.map(|texels| 1.0 / texels as f32);
        plan.constants = Constants::new()
            .with("probe_side", Value::F32(tiles[0].width as f32))
            .with("probe_texel", Value::Vec2(texel.into()));
        Ok(plan)
    }
}

/// The maps of a plan.
fn tiles(plan: &ShadowPlan) -> Vec<Viewport> {
    let passes = plan.passes.iter().filter_map(|pass| match pass {
        Pass::Casters(pass) => Some(pass.viewport),
        _ => None,
    });
    passes.collect()
}

/// The pass that draws made-up depths where casters would be.
fn fill([width, height]: [u32; 2]) -> Pass {
    Pass::Screen(ScreenPass {
        shader: "probe_fill".to_owned(),
        targets: vec!["shadow_map".into()],
        viewport: Viewport {
            x: 0,
            y: 0,
            width,
            height,
        },
        reads: Reads::default(),
    })
}

const AXES: &str = r#"(axes: {
    "method": (values: {
        "basic_probe": (bind: { "umbrage::interface::shadow": "package::probe" }),
        "pssm_probe": (bind: { "umbrage::interface::shadow": "package::probe" }),
    }),
    "pass": (values: { "probe_fill": (root: "package::fill") }),
})"#;

const SHADER: &str = "
import umbrage::interface::filter::{filter_map, Tile};
import umbrage::interface::pixel::pixel;
struct Probe { probe_side: f32, probe_texel: vec2f }
@group(1) @binding(0) var<uniform> probe: Probe;
@group(1) @binding(8) var probe_places: texture_2d<f32>;
@group(1) @binding(9) var probe_planes: texture_2d<f32>;
fn calc_shadow(position_ws: vec3f) -> f32 {
    let place = textureLoad(probe_places, pixel(), 0);
    let plane = textureLoad(probe_planes, pixel(), 0);
    return filter_map(place.xy, plane.xyz, Tile(place.zw, probe.probe_side, 0, probe.probe_texel));
}";

const FILL: &str = "
@group(1) @binding(0) var probe_depths: texture_2d<f32>;
@vertex fn vs_fill(@builtin(vertex_index) number: u32) -> @builtin(position) vec4f {
    return vec4f(4.0 * vec2f(f32(number & 1), f32(number >> 1)) - 1.0, 0.0, 1.0);
}
@fragment fn fs_fill(@builtin(position) clip: vec4f) -> @builtin(frag_depth) f32 {
    return textureLoad(probe_depths, vec2u(clip.xy), 0).r;
}";

struct Studio {
    renderer: Renderer,
    scene: Scene,
}

impl Studio {
    fn new() -> Self {
        let files = [
            ("axes.ron", AXES),
            ("probe.wesl", SHADER),
            ("fill.wesl", FILL),
        ];
        let files = files.map(|(path, text)| (path.to_owned(), text.to_owned()));
        let probe = Package::from_sources("probe", "probe", files).expect("a package");
        let ours = umbrage::shader_package().expect("the shader library is sound");
        let library = Library::new([ours, probe]).expect("they fit together");
        let composer = Arc::new(Composer::new(library, Target::webgpu()));
        let mut registry = umbrage::methods::registry().expect("names are unique");
        for probe in [
            Probe::new("basic_probe", Basic),
            Probe::new("pssm_probe", Pssm),
        ] {
            registry.methods.add(probe).expect("names are unique");
        }
        let gpu = Arc::new(Gpu::new().unwrap_or_else(|error| panic!("{error}")));
        // Deep enough that all four splits have a map.
        let scene = Path::new(env!("CARGO_MANIFEST_DIR")).join("../examples/scenes/avenue.ron");
        Self {
            renderer: Renderer::new(gpu, composer, registry),
            scene: Scene::load(scene).unwrap_or_else(|error| panic!("{error}")),
        }
    }

    fn render(&mut self, what: What, trial: &Trial, filter: &str) -> Rendered {
        let shadow = Shadow::new(trial.method)
            .with("filter", filter)
            .with("pcf", trial.width)
            .with("block", trial.block)
            .with_setting("resolution", trial.resolution.into())
            .with_setting("seed", trial.seed.into());
        let shadow = bounded(shadow, filter);
        let options = RenderOptions {
            width: SIZE,
            height: SIZE,
            what,
            shadow,
            ..RenderOptions::default()
        };
        let rendered = self.renderer.render(&self.scene, &options);
        rendered.unwrap_or_else(|error| panic!("{filter}: {error}"))
    }

    /// The decisions in all pixels, each held against the filter.
    fn check(&mut self, trial: &Trial, filter: &str) -> BTreeMap<Decision, u32> {
        let rendered = self.render(What::Decisions, trial, filter);
        let Picture::Decisions(decisions) = &rendered.picture else {
            unreachable!("decisions were asked for")
        };
        let plan = rendered.report.plans[0].as_ref().expect("a plan");
        // As the plan made them up.
        let tiles = trial.tiles(plan);
        let size = [plan.textures[0].width, plan.textures[0].height];
        let maps = Maps::new(u64::from(trial.seed), size, &tiles);
        let width = trial.width.parse().expect("a number");
        let mut counts = BTreeMap::new();
        for (place, decision) in maps.places(SIZE * SIZE).iter().zip(&decisions[0]) {
            *counts.entry(*decision).or_default() += 1;
            let (any_lit, any_dark) = maps.filter(place, width);
            let right = match decision {
                Decision::Unsampled | Decision::Filtered => true,
                Decision::LitByDepth | Decision::LitByPlane => !any_dark,
                Decision::ShadowedByDepth | Decision::ShadowedByPlane => !any_lit,
            };
            assert!(right, "{filter}, {trial:?}: {decision:?} at {place:?}");
        }
        let terms = |rendered: Rendered| match rendered.picture {
            Picture::ShadowTerm(terms) => terms,
            _ => unreachable!("a shadow term was asked for"),
        };
        let whole = terms(self.render(What::ShadowTerm, trial, "pcf"));
        let found = terms(self.render(What::ShadowTerm, trial, filter));
        assert_eq!(whole, found, "{filter}, {trial:?}");
        counts
    }
}

/// Bounds are built, though they do not pay in pictures so small.
fn bounded(shadow: Shadow, filter: &str) -> Shadow {
    match filter {
        "pcf" => shadow,
        _ => shadow.with_setting("always_bounded", 1.0),
    }
}

#[derive(Debug)]
struct Trial {
    method: &'static str,
    width: &'static str,
    block: &'static str,
    resolution: u32,
    seed: u32,
}

impl Trial {
    /// The maps of a plan whose passes of casters were taken out.
    fn tiles(&self, plan: &ShadowPlan) -> Vec<Viewport> {
        let Some(Pass::Compute(built)) = plan.passes.last() else {
            panic!("bounds are built");
        };
        let columns = plan.textures[0].width / self.resolution;
        let tile = |number: u32| Viewport {
            x: number % columns * self.resolution,
            y: number / columns * self.resolution,
            width: self.resolution,
            height: self.resolution,
        };
        let Workgroups::Count([.., tiles]) = built.workgroups else {
            panic!("tiles are counted");
        };
        (0..tiles).map(tile).collect()
    }
}

/// Maps of one texel, of no whole number of blocks, of many workgroups; tiles of an atlas.
const MAPS: [(&str, u32); 8] = [
    ("basic_probe", 1),
    ("basic_probe", 3),
    ("basic_probe", 17),
    ("basic_probe", 64),
    ("basic_probe", 200),
    ("pssm_probe", 64),
    ("pssm_probe", 75),
    ("pssm_probe", 130),
];

fn check(filters: &[&str], widths: &[&'static str], seeds: u32) {
    let mut studio = Studio::new();
    let mut counts = BTreeMap::new();
    for filter in filters {
        for &width in widths {
            for block in ["2", "4", "8"] {
                for seed in 0..seeds {
                    for (method, resolution) in MAPS {
                        let trial = Trial {
                            method,
                            width,
                            block,
                            resolution,
                            seed,
                        };
                        for (decision, count) in studio.check(&trial, filter) {
                            *counts.entry((*filter, decision)).or_insert(0) += count;
                        }
                    }
                }
            }
        }
    }
    // Bounds that decide nothing would never be wrong.
    for filter in filters {
        let share = |decision: Decision| {
            let own = |((of, _), _): &(&(&str, Decision), &u32)| of == filter;
            let all: u32 = counts.iter().filter(own).map(|(_, count)| *count).sum();
            let found = counts.get(&(*filter, decision)).copied().unwrap_or(0);
            f64::from(found) / f64::from(all)
        };
        let all = Decision::ALL.map(share);
        let plain = filter.starts_with("min_max");
        for (decision, share) in Decision::ALL.into_iter().zip(all) {
            let by_plane = matches!(decision, Decision::LitByPlane | Decision::ShadowedByPlane);
            let expected = if by_plane && plain {
                0.0..=0.0
            } else {
                0.005..=0.9
            };
            assert!(
                expected.contains(&share),
                "{filter}: {decision:?} in {share} of {all:?}"
            );
        }
    }
}

#[test]
fn bounds_with_planes_decide_as_the_filter_does() {
    check(&["hpsm"], &["1", "3", "5", "7", "15"], 4);
}

#[test]
fn other_bounds_decide_as_the_filter_does() {
    check(
        &["hpsm_naive", "min_max", "min_max_tree"],
        &["3", "5", "7", "15"],
        1,
    );
}

/// Where a map has fewer texels than a filter reads, no receiver's footprint lies in it.
#[test]
fn bounds_of_maps_smaller_than_the_filter_decide_nothing_wrong() {
    let mut studio = Studio::new();
    for filter in ["hpsm", "hpsm_naive", "min_max", "min_max_tree"] {
        for (width, resolution) in [("5", 3), ("7", 5), ("15", 11)] {
            for seed in 0..12 {
                let trial = Trial {
                    method: "basic_probe",
                    width,
                    block: "2",
                    resolution,
                    seed,
                };
                studio.check(&trial, filter);
            }
        }
    }
}

/// Whatever the depths are, however wide the filter is in each split, and whatever way the terms take.
#[test]
fn bounds_go_with_all_choices_that_they_allow() {
    let mut studio = Studio::new();
    let mut draw = |filter: &str, choices: &[(&str, &str)], path| {
        let shadow = Shadow::default().with("filter", filter).with("pcf", "7");
        let shadow = bounded(shadow, filter);
        let options = RenderOptions {
            width: 160,
            height: 90,
            what: What::ShadowTerm,
            shadow: choices
                .iter()
                .fold(shadow, |shadow, (a, v)| shadow.with(a, v)),
            path,
            ..RenderOptions::default()
        };
        let rendered = studio.renderer.render(&studio.scene, &options);
        match rendered
            .unwrap_or_else(|error| panic!("{filter}, {choices:?}: {error}"))
            .picture
        {
            Picture::ShadowTerm(terms) => terms,
            _ => unreachable!("a shadow term was asked for"),
        }
    };
    for choices in [
        [("taper", "on"), ("transition", "blend")],
        [("depth", "midpoint"), ("lookup", "storage")],
        [("depth", "midpoint_two_passes"), ("lookup", "masks")],
        [("receiver_bias", "constant"), ("lookup", "matrix_texture")],
    ] {
        for path in [Way::Forward, Way::Mask, Way::MaskBySplit] {
            let whole = draw("pcf", &choices, path);
            let dark = whole[0].iter().filter(|term| **term < 0.5).count();
            assert!(dark > 500, "{choices:?}: {dark} are dark");
            for filter in ["hpsm", "hpsm_naive", "min_max", "min_max_tree"] {
                let found = draw(filter, &choices, path);
                let pairs = whole[0].iter().zip(&found[0]);
                let differ = pairs.filter(|(a, b)| a.to_bits() != b.to_bits()).count();
                assert_eq!(differ, 0, "{filter}, {choices:?}, {path:?}");
            }
        }
    }
}

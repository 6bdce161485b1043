//! Costs of a method's variants against each other, and errors of methods at equal memory: ratios taken
//! in one run, on an avenue that one map cannot resolve.
#![allow(
    clippy::print_stdout,
    reason = "a benchmark reports on standard output"
)]

#[path = "methods/bounds.rs"]
mod bounds;
#[path = "methods/exponential.rs"]
mod exponential;
#[path = "methods/shafts.rs"]
mod shafts;
#[path = "methods/still.rs"]
mod still;
#[path = "methods/timing.rs"]
mod timing;

use std::{collections::BTreeMap, error::Error, path::Path, sync::Arc};

use serde::Serialize;
use umbrage_bench::write_report;
use umbrage_compose::{Composer, Library, Stage, Target};
use umbrage_isa::{Compiler, CompilerOptions, PipelineState};
use umbrage_measure::{
    report::{Row, Spread},
    study::{CompareOptions, Config, Lab, compare},
};
use umbrage_render::{Gpu, Renderer, Scene, Shadow};

use crate::timing::Way;

/// The ways in which `pssm` finds a split's map, the naive one first.
const LOOKUPS: [&str; 7] = [
    "branches",
    "weights",
    "matrix_texture",
    "packed",
    "masks",
    "channels",
    "storage",
];

/// The ways to make a midpoint map whose times are compared.
const MIDPOINTS: [&str; 2] = ["midpoint", "midpoint_two_passes"];

/// The way without splits.
const ONE_MAP: &str = "one map";

/// The one that ships as default.
const DEFAULT: &str = "packed";

#[derive(Serialize)]
struct Report {
    adapter: String,
    family: String,
    /// The least inverse throughput of all variants over the naive one's; the bare shadow term, one tap.
    pssm_best_over_naive_throughput: f64,
    /// The same of one map for all depths, where no split is to be found: what no variant gets below.
    one_map_over_naive_throughput: f64,
    /// The time of the default variant's masks over that of the storage buffer's.
    pssm_default_over_storage_time: f64,
    /// Wrong samples of four splits of 1024² over those of one map of 2048².
    pssm4x1024_over_basic2048_error: f64,
    /// Time of one midpoint map of 2048² in one pass and its resolve, over two passes and theirs.
    midpoint_single_over_two: f64,
    variants: BTreeMap<&'static str, Variant>,
    #[serde(flatten)]
    parts: Parts,
}

/// Measurements with files of their own.
#[derive(Serialize)]
struct Parts {
    #[serde(flatten)]
    bounds: bounds::Report,
    #[serde(flatten)]
    exponential: exponential::Report,
    #[serde(flatten)]
    shafts: shafts::Report,
    #[serde(flatten)]
    still: still::Report,
}

#[derive(Serialize)]
struct Variant {
    instructions: u64,
    vgprs: u64,
    latency: u64,
    inverse_throughput: u64,
    throughput_over_naive: f64,
    /// The pass that finds the shadow terms, once for each pixel: 3 × 3 comparisons.
    shading_ms: Spread,
    shading_over_naive: f64,
    fetches_per_pixel: f64,
    error: f64,
}

fn main() -> Result<(), Box<dyn Error>> {
    umbrage_isa::serve_if_asked();
    let library = Library::new([umbrage_shader_lib::package()?])?;
    let composer = Arc::new(Composer::new(library, Target::webgpu()));
    let gpu = Arc::new(Gpu::new()?);
    let methods = umbrage_methods::registry()?;
    let mut renderer = Renderer::new(Arc::clone(&gpu), Arc::clone(&composer), methods.clone());
    let mut lab = Lab::new(gpu, Arc::clone(&composer), methods);
    let scenes = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../examples/scenes");
    let scene = Scene::load(scenes.join("avenue.ron"))?;
    let bounds = bounds::measure(&mut renderer, &scenes)?;
    bounds.print();
    let shafts = shafts::measure(&mut renderer, &scenes)?;
    shafts.print();
    let exponential = exponential::measure(&mut renderer, &scenes)?;
    exponential.print();
    let still = still::measure(&mut renderer, &scenes)?;
    still.print();
    let parts = Parts {
        bounds,
        exponential,
        shafts,
        still,
    };
    let shading = shading(&mut renderer, &scene)?;

    let mut configs: Vec<_> = LOOKUPS.map(|lookup| config("pssm", lookup, lookup)).into();
    configs.push(config("basic", "2048", ""));
    configs.extend(MIDPOINTS.map(midpoint));
    let options = CompareOptions {
        size: (480, 270),
        most_pairs: 15,
        frames: 0,
        store: None,
        command: String::new(),
    };
    let family = CompilerOptions::FAMILY;
    let no_compiler = Err("the bare shadow term is compiled apart".to_owned());
    let scenes = [("avenue".to_owned(), scene)];
    let compared = compare(&mut lab, &scenes, &configs, &options, no_compiler, &())?;
    if let Some(skipped) = compared.report.skipped.first() {
        return Err(format!("{}: {}", skipped.config, skipped.reason).into());
    }
    let rows = &compared.report.rows;
    let mut compiler = Compiler::start(family)?;
    let mut costs = BTreeMap::new();
    for lookup in LOOKUPS {
        let axes = [
            ("method", "pssm"),
            ("lookup", lookup),
            ("transition", "hard"),
        ];
        costs.insert(lookup, cost(&composer, &mut compiler, &axes)?);
    }
    costs.insert(
        ONE_MAP,
        cost(&composer, &mut compiler, &[("method", "basic")])?,
    );
    let report = report(lab.adapter(), family, rows, (&costs, shading), parts)?;
    for (name, variant) in &report.variants {
        println!(
            "{name:15} {:4} instructions, {:3} registers, latency {:5}, throughput {:.2} of naive, shading {:.2} of naive, {:.2} fetches, {:.3} % wrong",
            variant.instructions,
            variant.vgprs,
            variant.latency,
            variant.throughput_over_naive,
            variant.shading_over_naive,
            variant.fetches_per_pixel,
            100.0 * variant.error,
        );
    }
    println!(
        "best over naive, throughput: {:.3} ({:.3} without splits)",
        report.pssm_best_over_naive_throughput, report.one_map_over_naive_throughput
    );
    println!(
        "default over storage, time:  {:.3}",
        report.pssm_default_over_storage_time
    );
    println!(
        "4 x 1024 over basic 2048, error: {:.3}",
        report.pssm4x1024_over_basic2048_error
    );
    println!(
        "midpoint, one pass over two:     {:.3}",
        report.midpoint_single_over_two
    );
    println!("{}", write_report("methods", &report)?.display());
    Ok(())
}

fn config(method: &str, name: &str, lookup: &str) -> Config {
    let shadow = Shadow::new(method).with("pcf", "3");
    let shadow = match method {
        "pssm" => shadow
            .with("lookup", lookup)
            .with_setting("resolution", 1024.0)
            .with_setting("splits", 4.0),
        _ => shadow.with_setting("resolution", 2048.0),
    };
    Config {
        name: name.to_owned(),
        shadow,
        ..Config::default()
    }
}

fn midpoint(depth: &str) -> Config {
    let mut config = config("basic", depth, "");
    config.shadow = config.shadow.with("depth", depth);
    config
}

/// The time of the masks' pass by each lookup.
fn shading(
    renderer: &mut Renderer,
    scene: &Scene,
) -> Result<[Spread; LOOKUPS.len()], Box<dyn Error>> {
    let ways = LOOKUPS.map(|lookup| Way {
        method: Some("pssm"),
        axes: [("lookup", lookup), ("pcf", "3")],
        always_bounded: false,
        path: umbrage_render::Path::Mask,
    });
    let rounds = timing::time(renderer, scene, ways)?;
    Ok(std::array::from_fn(|i| {
        let times = rounds.iter().map(|round| round[i].filtered);
        Spread::of(&times.collect::<Vec<_>>())
    }))
}

/// Cost of the bare shadow term with one tap and no receiver's plane: the lookup alone.
fn cost(
    composer: &Composer,
    compiler: &mut Compiler,
    axes: &[(&str, &str)],
) -> Result<umbrage_isa::Isa, Box<dyn Error>> {
    let bare = [
        ("pass", "shadow_term"),
        ("light", "directional"),
        ("pcf", "1"),
        ("receiver_bias", "constant"),
    ];
    let key = composer.library().key(bare.iter().chain(axes).copied())?;
    let permutation = composer.compose(&key)?.permutation;
    let stages = compiler.cost(&permutation, &PipelineState::of(&permutation))?;
    let fragment = stages
        .into_iter()
        .find(|cost| cost.stage == Stage::Fragment);
    Ok(fragment
        .ok_or("a shadow term without a fragment stage")?
        .isa)
}

fn report(
    adapter: &str,
    family: &str,
    rows: &[Row],
    (costs, times): (&BTreeMap<&str, umbrage_isa::Isa>, [Spread; LOOKUPS.len()]),
    parts: Parts,
) -> Result<Report, Box<dyn Error>> {
    let row = |config: &str| {
        let found = rows.iter().find(|row| row.config == config);
        found.ok_or_else(|| format!("{config} was not drawn"))
    };
    let naive = &costs[LOOKUPS[0]];
    let mut variants = BTreeMap::new();
    for (lookup, shading_ms) in LOOKUPS.into_iter().zip(times) {
        let (row, isa) = (row(lookup)?, &costs[lookup]);
        let variant = Variant {
            instructions: isa.instructions,
            vgprs: isa.vgprs,
            latency: isa.latency,
            inverse_throughput: isa.inverse_throughput,
            throughput_over_naive: isa.inverse_throughput as f64 / naive.inverse_throughput as f64,
            shading_ms,
            shading_over_naive: shading_ms.median / times[0].median,
            fetches_per_pixel: row.fetches_per_pixel,
            error: row.error(),
        };
        variants.insert(lookup, variant);
    }
    let throughputs = variants
        .values()
        .map(|variant| variant.throughput_over_naive);
    let shading = |lookup: &str| variants[lookup].shading_ms.median;
    let [single, two] = MIDPOINTS.map(|config| Ok::<_, String>(row(config)?.casters_ms.median));
    Ok(Report {
        adapter: adapter.to_owned(),
        family: family.to_owned(),
        pssm_best_over_naive_throughput: throughputs.fold(f64::INFINITY, f64::min),
        one_map_over_naive_throughput: costs[ONE_MAP].inverse_throughput as f64
            / naive.inverse_throughput as f64,
        pssm_default_over_storage_time: shading(DEFAULT) / shading("storage"),
        pssm4x1024_over_basic2048_error: row(DEFAULT)?.error() / row("2048")?.error(),
        midpoint_single_over_two: single? / two?,
        variants,
        parts,
    })
}

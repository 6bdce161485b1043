//! Cost of composing, over what cannot be avoided: naga's own parsing and validating of the same
//! shader as one text (the floor), and a `HashMap`'s look-up; and what it costs others: `naga_oil`, with its modules
//! known, up to a validated module, as we do (ours is of parts that were validated before); `wesl`, which keeps nothing,
//! up to a text that naga has yet to parse.
#![allow(
    clippy::print_stdout,
    reason = "a benchmark reports on standard output"
)]

#[path = "compose/packs.rs"]
mod packs;
#[path = "compose/peers.rs"]
mod peers;
#[path = "compose/space.rs"]
mod space;

use std::{collections::HashMap, error::Error, hint::black_box, time::Duration};

use naga::valid::{ValidationFlags, Validator};
use serde::Serialize;
use umbrage_bench::{Spread, time, write_report};
use umbrage_compose::{Composer, Key, Library, Target};

use crate::{
    packs::Packs,
    peers::{NagaOil, Sources, WeslCompiler, face},
    space::Space,
};

/// Turns taken; each times everything once.
const ROUNDS: usize = 101;
/// Look-ups timed together, since one is too short for the clock.
const LOOK_UPS: u32 = 10_000;

/// A permutation of real size: everything on.
const WANTED: &[(&str, &str)] = &[
    ("pass", "illumination"),
    ("surface", "ggx"),
    ("light", "spot"),
    ("method", "basic"),
    ("pcf", "5"),
    ("cookie", "on"),
    ("alpha_test", "on"),
    ("base_color_texture", "on"),
];

#[derive(Serialize)]
struct Report {
    new_over_floor: f64,
    cached_over_hashmap: f64,
    cold_over_floor: f64,
    naga_oil_warm_over_ours: f64,
    wesl_over_ours: f64,
    /// The whole space checked, over composing nothing but parsing and validating each permutation's text on all cores.
    space_over_floor: f64,
    keys_exponent: f64,
    space: Space,
    #[serde(flatten)]
    packs: Packs,
    wgsl_bytes: usize,
    rounds: usize,
    floor_us: Spread,
    validate_us: Spread,
    new_us: Spread,
    cold_us: Spread,
    cached_us: Spread,
    hashmap_us: Spread,
    naga_oil_warm_us: Spread,
    wesl_us: Spread,
}

fn main() -> Result<(), Box<dyn Error>> {
    // First, while the process has taken no memory for anything else.
    let space = Space::measure()?;
    let packs = Packs::measure()?;
    let library = || Library::new([umbrage_shader_lib::package()?]);
    let wanted = library()?.key(WANTED.iter().copied())?;
    let whole = Composer::new(library()?, Target::webgpu()).compose(&wanted)?;
    let text = whole.permutation.wgsl()?;
    // Permutations that between them know every module of the wanted one, under its features.
    let other = |axis: &str, value: &'static str| {
        let choices = WANTED
            .iter()
            .map(|&(known, old)| (known, if known == axis { value } else { old }));
        library()?.key(choices)
    };
    let others = [
        other("surface", "lambert")?,
        other("pcf", "7")?,
        other("alpha_test", "off")?,
    ];
    let sources = Sources::of(&library()?, &wanted)?;
    let mut naga_oil = NagaOil::new(&sources)?;
    let wesl = WeslCompiler::new(&sources)?;
    check(&whole.permutation.module, &naga_oil.compose()?)?;
    let of_wesl = naga::front::wgsl::parse_str(&wesl.compose()?)?;
    check(&whole.permutation.module, &of_wesl)?;

    let [
        mut floor,
        mut validating,
        mut new,
        mut cold,
        mut cached,
        mut hashmap,
        mut warm_naga_oil,
        mut from_wesl,
    ] = [const { Vec::new() }; 8];
    for _ in 0..ROUNDS {
        floor.push(time(|| parse_and_validate(&text)));
        validating.push(time(|| validate(&whole.permutation.module)));
        cold.push(time(|| -> Result<_, umbrage_compose::Error> {
            Composer::new(library()?, Target::webgpu()).compose(&wanted)
        }));
        let composer = Composer::new(library()?, Target::webgpu());
        for key in &others {
            composer.compose(key)?;
        }
        new.push(time(|| composer.compose(&wanted)));
        warm_naga_oil.push(time(|| naga_oil.compose()));
        from_wesl.push(time(|| wesl.compose()));
        cached.push(per_look_up(|| composer.compose(&wanted).map(drop)));
        let map: HashMap<Key, _> = [(wanted.clone(), whole.permutation.clone())].into();
        hashmap.push(per_look_up(|| map.get(black_box(&wanted)).cloned()));
    }
    let spread = |times: &[Duration]| Spread::micros(times);
    let report = Report {
        new_over_floor: spread(&new).median / spread(&floor).median,
        cached_over_hashmap: spread(&cached).median / spread(&hashmap).median,
        cold_over_floor: spread(&cold).median / spread(&floor).median,
        naga_oil_warm_over_ours: spread(&warm_naga_oil).median / spread(&new).median,
        wesl_over_ours: spread(&from_wesl).median / spread(&new).median,
        space_over_floor: space.seconds[1] * 1e6 * space.cores as f64
            / (space.permutations as f64 * spread(&floor).median),
        keys_exponent: space.keys_exponent,
        space,
        packs,
        wgsl_bytes: text.len(),
        rounds: ROUNDS,
        floor_us: spread(&floor),
        validate_us: spread(&validating),
        new_us: spread(&new),
        cold_us: spread(&cold),
        cached_us: spread(&cached),
        hashmap_us: spread(&hashmap),
        naga_oil_warm_us: spread(&warm_naga_oil),
        wesl_us: spread(&from_wesl),
    };
    println!(
        "a permutation of {} bytes of WGSL, {ROUNDS} rounds, microseconds: median (least to most)",
        text.len()
    );
    println!("floor: naga parses and validates it  {}", report.floor_us);
    println!(
        "of which validating alone            {}",
        report.validate_us
    );
    println!("new, its modules known               {}", report.new_us);
    println!("cold, nothing known                  {}", report.cold_us);
    println!("cached, looked up                    {}", report.cached_us);
    println!("the same key in a HashMap            {}", report.hashmap_us);
    println!(
        "naga_oil, its modules known          {}",
        report.naga_oil_warm_us
    );
    println!("wesl, to a text                      {}", report.wesl_us);
    println!(
        "(a) new over floor       {:.3}  (goal 0.05)",
        report.new_over_floor
    );
    println!(
        "(b) cached over HashMap  {:.3}  (goal 1.2)",
        report.cached_over_hashmap
    );
    println!(
        "(c) cold over floor      {:.3}  (goal 2)",
        report.cold_over_floor
    );
    println!(
        "(d) naga_oil over new    {:.3}  (goal 20)",
        report.naga_oil_warm_over_ours
    );
    println!(
        "(e) wesl over new        {:.3}  (goal 60)",
        report.wesl_over_ours
    );
    let Space {
        keys,
        permutations,
        composed,
        cores,
        seconds: [least, median, most],
        peak_mib,
        ..
    } = &report.space;
    println!(
        "the space of {keys:.3e} keys, {permutations} permutations: checked in {median:.1} s ({least:.1} to {most:.1}) on \
         {cores} cores, {composed} composed, {:.0} MiB",
        peak_mib.unwrap_or(f64::NAN)
    );
    for (keys, time) in &report.space.keys_us {
        println!("{keys:.1e} keys, 256 permutations  {time} µs");
    }
    println!(
        "(f) space over floor     {:.4}  (goal 0.02)",
        report.space_over_floor
    );
    println!(
        "(g) keys' exponent       {:.4}  (goal 0)",
        report.keys_exponent
    );
    report.packs.print();
    println!("written to {}", write_report("compose", &report)?.display());
    Ok(())
}

/// Holds a peer's module against ours.
fn check(ours: &naga::Module, theirs: &naga::Module) -> Result<(), Box<dyn Error>> {
    let capabilities = Target::webgpu().capabilities();
    Validator::new(ValidationFlags::all(), capabilities).validate(theirs)?;
    if face(ours) != face(theirs) {
        return Err(format!("ours: {:?}, theirs: {:?}", face(ours), face(theirs)).into());
    }
    Ok(())
}

fn parse_and_validate(text: &str) -> Option<naga::valid::ModuleInfo> {
    let module = naga::front::wgsl::parse_str(text).ok()?;
    validate(&module)
}

fn validate(module: &naga::Module) -> Option<naga::valid::ModuleInfo> {
    let capabilities = Target::webgpu().capabilities();
    Validator::new(ValidationFlags::all(), capabilities)
        .validate(module)
        .ok()
}

fn per_look_up<T>(mut look_up: impl FnMut() -> T) -> Duration {
    time(|| {
        for _ in 0..LOOK_UPS {
            black_box(look_up());
        }
    }) / LOOK_UPS
}

//! What composing costs, over what cannot be avoided: naga's own parsing and validating of the same
//! shader as one text (the floor), and a `HashMap`'s look-up.
#![allow(
    clippy::print_stdout,
    reason = "a benchmark reports on standard output"
)]

use std::{collections::HashMap, error::Error, hint::black_box, time::Duration};

use naga::valid::{ValidationFlags, Validator};
use serde::Serialize;
use umbrage_bench::{Spread, time, write_report};
use umbrage_compose::{Composer, Key, Library, Target};

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
    wgsl_bytes: usize,
    rounds: usize,
    floor_us: Spread,
    validate_us: Spread,
    new_us: Spread,
    cold_us: Spread,
    cached_us: Spread,
    hashmap_us: Spread,
}

fn main() -> Result<(), Box<dyn Error>> {
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

    let [
        mut floor,
        mut validating,
        mut new,
        mut cold,
        mut cached,
        mut hashmap,
    ] = [const { Vec::new() }; 6];
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
        cached.push(per_look_up(|| composer.compose(&wanted).map(drop)));
        let map: HashMap<Key, _> = [(wanted.clone(), whole.permutation.clone())].into();
        hashmap.push(per_look_up(|| map.get(black_box(&wanted)).cloned()));
    }
    let spread = |times: &[Duration]| Spread::of(times);
    let report = Report {
        new_over_floor: spread(&new).median / spread(&floor).median,
        cached_over_hashmap: spread(&cached).median / spread(&hashmap).median,
        cold_over_floor: spread(&cold).median / spread(&floor).median,
        wgsl_bytes: text.len(),
        rounds: ROUNDS,
        floor_us: spread(&floor),
        validate_us: spread(&validating),
        new_us: spread(&new),
        cold_us: spread(&cold),
        cached_us: spread(&cached),
        hashmap_us: spread(&hashmap),
    };
    println!(
        "a permutation of {} bytes of WGSL, {ROUNDS} rounds, median (least to most)",
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
        "(a) new over floor       {:.3}  (goal 0.25, later 0.12)",
        report.new_over_floor
    );
    println!(
        "(b) cached over HashMap  {:.3}  (goal 3)",
        report.cached_over_hashmap
    );
    println!(
        "(c) cold over floor      {:.3}  (goal 4)",
        report.cold_over_floor
    );
    println!("written to {}", write_report("compose", &report)?.display());
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

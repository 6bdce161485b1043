//! The whole space of permutations, checked, and what keys cost that make no other permutation.

use std::{
    error::Error,
    fs,
    sync::atomic::{AtomicUsize, Ordering},
    thread,
    time::{Duration, Instant},
};

use serde::Serialize;
use umbrage_bench::Spread;
use umbrage_compose::{Composer, Library, Package, Target};

/// Turns taken: each checks the whole space anew.
const ROUNDS: usize = 3;

/// Axes with two values each, which no module reads: with the others 2^10 to 2^40 keys.
const UNREAD: [u32; 4] = [2, 12, 22, 32];

/// Axes with two values each that a module reads, in each of the libraries whose keys are counted.
const READ: u32 = 8;

#[derive(Serialize)]
pub(crate) struct Space {
    pub(crate) keys: f64,
    pub(crate) permutations: usize,
    /// How many of them were composed to check them all.
    pub(crate) composed: usize,
    pub(crate) cores: usize,
    pub(crate) seconds: [f64; 3],
    /// Most memory that this process has taken so far; none where the system does not say.
    pub(crate) peak_mib: Option<f64>,
    /// Slope of the logarithm of time over that of the number of keys, at equal permutations.
    pub(crate) keys_exponent: f64,
    /// Microseconds for each number of keys.
    pub(crate) keys_us: Vec<(f64, Spread)>,
}

impl Space {
    pub(crate) fn measure() -> Result<Self, Box<dyn Error>> {
        let library = Library::new([umbrage_shader_lib::package()?])?;
        let cores = thread::available_parallelism().map_or(1, usize::from);
        let mut seconds = Vec::new();
        let (mut permutations, mut composed) = (0, 0);
        for _ in 0..ROUNDS {
            let start = Instant::now();
            (permutations, composed) = check(&library, cores)?;
            seconds.push(start.elapsed().as_secs_f64());
        }
        seconds.sort_by(f64::total_cmp);
        let peak_mib = peak_mib();
        let mut keys_us = Vec::new();
        for unread in UNREAD {
            let library = switches(unread)?;
            let times = (0..21).map(|_| -> Result<Duration, Box<dyn Error>> {
                let start = Instant::now();
                let (found, _) = check(&library, 1)?;
                let time = start.elapsed();
                match found == 1 << READ {
                    true => Ok(time),
                    false => Err(format!("{found} permutations of 2^{READ}").into()),
                }
            });
            let times = times.collect::<Result<Vec<_>, _>>()?;
            keys_us.push((library.legal_keys() as f64, Spread::micros(&times)));
        }
        Ok(Self {
            keys: library.legal_keys() as f64,
            permutations,
            composed,
            cores,
            seconds: [seconds[0], seconds[ROUNDS / 2], seconds[ROUNDS - 1]],
            peak_mib,
            keys_exponent: slope(&keys_us),
            keys_us,
        })
    }
}

/// Checks every permutation of `library`. Returns how many there are, and how many were composed for that.
fn check(library: &Library, threads: usize) -> Result<(usize, usize), Box<dyn Error>> {
    let composer = Composer::new(library.clone(), Target::webgpu());
    let parts = composer.variants().split(64 * threads);
    let [next, permutations, composed, faults] = [const { AtomicUsize::new(0) }; 4];
    let work = || {
        while let Some(part) = parts.get(next.fetch_add(1, Ordering::Relaxed)) {
            let mut counts = [0; 3];
            for variant in part.clone() {
                let checked = composer.check(&variant);
                counts[0] += 1;
                counts[1] += usize::from(checked.composed);
                counts[2] += usize::from(checked.fault.is_some());
            }
            for (all, count) in [&permutations, &composed, &faults].into_iter().zip(counts) {
                all.fetch_add(count, Ordering::Relaxed);
            }
        }
    };
    thread::scope(|scope| {
        for _ in 0..threads {
            scope.spawn(work);
        }
    });
    match faults.into_inner() {
        0 => Ok((permutations.into_inner(), composed.into_inner())),
        faults => Err(format!("{faults} permutations have faults").into()),
    }
}

/// A library of one shader that reads some switches, and axes with `unread` others.
fn switches(unread: u32) -> Result<Library, Box<dyn Error>> {
    let switch = |name: &str| {
        format!(
            r#""{name}": (default: "off", values: {{ "off": (), "on": (features: ["{name}"]) }}),"#
        )
    };
    let axes: String = (0..READ).map(|n| switch(&format!("R{n}"))).collect();
    let more: String = (0..unread).map(|n| switch(&format!("U{n}"))).collect();
    let lines: String = (0..READ)
        .map(|n| format!("    @if(R{n}) {{ x += {n}.0; }}\n"))
        .collect();
    let axes = format!(
        r#"(axes: {{ {axes} {more} "pass": (values: {{ "main": (root: "package::main") }}) }})"#
    );
    let main = format!(
        "@fragment fn main() -> @location(0) vec4f {{\n    var x = 1.0;\n{lines}    return vec4f(x);\n}}\n"
    );
    let files = [("axes.ron", axes), ("main.wesl", main)];
    let files = files.map(|(path, text)| (path.to_owned(), text));
    let package = Package::from_sources("switches", "switches", files)?;
    Ok(Library::new([package])?)
}

/// Slope of the line through the logarithms, by least squares.
fn slope(points: &[(f64, Spread)]) -> f64 {
    let points = points
        .iter()
        .map(|(keys, time)| (keys.ln(), time.median.ln()));
    let points: Vec<_> = points.collect();
    let count = points.len() as f64;
    let mean = |of: fn(&(f64, f64)) -> f64| points.iter().map(of).sum::<f64>() / count;
    let (x, y) = (mean(|point| point.0), mean(|point| point.1));
    let over: f64 = points
        .iter()
        .map(|point| (point.0 - x) * (point.1 - y))
        .sum();
    let under: f64 = points.iter().map(|point| (point.0 - x).powi(2)).sum();
    over / under
}

/// Most memory that this process has taken so far, where Linux says it.
fn peak_mib() -> Option<f64> {
    let status = fs::read_to_string("/proc/self/status").ok()?;
    let line = status
        .lines()
        .find_map(|line| line.strip_prefix("VmHWM:"))?;
    let kib: f64 = line.trim().strip_suffix("kB")?.trim().parse().ok()?;
    Some(kib / 1024.0)
}

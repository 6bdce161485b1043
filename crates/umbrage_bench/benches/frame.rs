//! Cost of frames of a field of boxes in the sun: of all, of what shadows add, of the CPU's part, and of frames in which
//! little or nothing changed over frames in which everything did.
//!
//! `-- --times` prints what shadows add and the CPU's part alone, as JSON: for the same benchmark built at another
//! commit, run in turn with this one (`cargo xtask bench --before`).
#![allow(
    clippy::print_stdout,
    reason = "a benchmark reports on standard output"
)]

#[path = "frame/flight.rs"]
mod flight;
#[path = "frame/view.rs"]
mod view;

use std::{alloc::System, collections::BTreeMap, error::Error};

use serde::Serialize;
use stats_alloc::{INSTRUMENTED_SYSTEM, StatsAlloc};
use umbrage_bench::{
    Spread,
    field::{Order, field, look, nudge},
    write_report,
};
use umbrage_render::Shadow;

use crate::{
    flight::Flight,
    view::{Machine, Shot, View},
};

/// Counts what a frame takes from the heap.
#[global_allocator]
static HEAP: &StatsAlloc<System> = &INSTRUMENTED_SYSTEM;

/// Numbers of boxes, and how many pairs of frames are taken of each.
const BOXES: [(usize, usize); 3] = [(FEW, 41), (1_600, 21), (MANY, 15)];
/// Boxes of the frames in which little changes.
const FEW: usize = 400;
/// Boxes of the frames in which the CPU has much to do.
const MANY: usize = 6_400;

#[derive(Serialize)]
struct Report {
    adapter: String,
    /// The device's time of a frame in which nothing moved, over that of one whose maps are all drawn less its time in
    /// passes into maps: shading with lookups alone. None where the device tells no times.
    still_over_unshadowed: Option<Spread>,
    /// A frame in which one of the boxes moved, over one whose maps are all drawn.
    one_moves_over_all: Spread,
    /// The CPU's part with the list of boxes mixed, over that with the list sorted by mesh and material.
    shuffled_over_ordered: Spread,
    allocations: Allocations,
    /// Permutations made while frames go on.
    #[serde(flatten)]
    flight: Flight,
    /// One map of 2048² in place of four of 1024².
    one_map: Added,
    /// By the number of boxes; four maps of 1024², the camera moving.
    boxes: BTreeMap<usize, Boxes>,
}

/// Allocations on the heap in one frame of a loop that reads nothing back.
#[derive(Serialize)]
struct Allocations {
    still: Spread,
    camera_moves: Spread,
}

/// Milliseconds of frames while the camera moves, pictures read back.
#[derive(Clone, Copy, Serialize)]
struct Added {
    frame: Spread,
    /// The same less a frame without shadows, pair by pair.
    added: Spread,
}

#[derive(Serialize)]
struct Boxes {
    #[serde(flatten)]
    times: Added,
    /// Milliseconds that the calling thread computes, in a loop that reads nothing back.
    own_cpu: Spread,
    /// The same with the picture read back.
    own_cpu_read_back: Spread,
    draws: u32,
    caster_draws: u32,
    shuffled_draws: u32,
    #[serde(skip)]
    shuffled_over_ordered: Spread,
}

/// Figures that are compared with those of another commit; milliseconds.
#[derive(Serialize)]
struct Times {
    added: f64,
    own_cpu_6400: f64,
    /// The same in a loop that reads nothing back; not told by states before there was one.
    steady_cpu_6400: f64,
}

fn main() -> Result<(), Box<dyn Error>> {
    let machine = Machine::new()?;
    if std::env::args().any(|arg| arg == "--times") {
        let many = moving(&machine, MANY, 7, &four_maps())?;
        let times = Times {
            added: moving(&machine, FEW, 15, &four_maps())?.times.added.median,
            own_cpu_6400: many.own_cpu_read_back.median,
            steady_cpu_6400: many.own_cpu.median,
        };
        println!("{}", serde_json::to_string(&times)?);
        return Ok(());
    }
    let mut boxes = BTreeMap::new();
    for (count, rounds) in BOXES {
        boxes.insert(count, moving(&machine, count, rounds, &four_maps())?);
    }
    let (still_over_unshadowed, one_moves_over_all) = changes(&machine)?;
    let report = Report {
        adapter: machine.gpu.adapter().to_owned(),
        still_over_unshadowed,
        one_moves_over_all,
        shuffled_over_ordered: boxes[&MANY].shuffled_over_ordered,
        allocations: allocations(&machine)?,
        flight: flight::measure(&machine)?,
        one_map: moving(&machine, FEW, 41, &one_map())?.times,
        boxes,
    };
    report.print();
    println!("written to {}", write_report("frame", &report)?.display());
    Ok(())
}

/// Four splits of 1024² texels, 3 × 3 comparisons.
fn four_maps() -> Shadow {
    Shadow::new("pssm")
        .with("pcf", "3")
        .with_setting("resolution", 1024.0)
        .with_setting("splits", 4.0)
}

/// One map of 2048² texels, 3 × 3 comparisons.
fn one_map() -> Shadow {
    Shadow::new("basic")
        .with("pcf", "3")
        .with_setting("resolution", 2048.0)
}

/// Frames while the camera moves: with `shadow`, without, and with a list in which meshes and materials are mixed.
fn moving(
    machine: &Machine,
    boxes: usize,
    rounds: usize,
    shadow: &Shadow,
) -> Result<Boxes, Box<dyn Error>> {
    let [sorted, mixed] = [Order::Sorted, Order::Shuffled].map(|order| field(boxes, order));
    let mut with = View::new(machine, sorted.clone(), shadow.clone())?;
    let mut without = View::new(machine, sorted, Shadow::new(Shadow::NONE))?;
    let mut shuffled = View::new(machine, mixed, shadow.clone())?;
    let (mut read_back, mut steady) = (Vec::new(), Vec::new());
    for frame in 0..rounds {
        for view in [&mut with, &mut without, &mut shuffled] {
            look(&mut view.scene, 2 * frame);
        }
        read_back.push([with.read_back(false)?, without.read_back(false)?]);
        for view in [&mut with, &mut shuffled] {
            look(&mut view.scene, 2 * frame + 1);
        }
        steady.push([with.steady()?, shuffled.steady()?]);
    }
    let of =
        |shots: &[[Shot; 2]], figure: fn(&[Shot; 2]) -> f64| Spread::of(shots.iter().map(figure));
    let [last, last_shuffled] = steady.last().ok_or("no rounds")?;
    Ok(Boxes {
        times: Added {
            frame: of(&read_back, |[with, _]| with.frame),
            added: of(&read_back, |[with, without]| with.frame - without.frame),
        },
        own_cpu_read_back: of(&read_back, |[with, _]| with.own_cpu),
        own_cpu: of(&steady, |[with, _]| with.own_cpu),
        draws: last.report.draws,
        caster_draws: last.report.caster_draws,
        shuffled_draws: last_shuffled.report.draws,
        shuffled_over_ordered: of(&steady, |[with, shuffled]| shuffled.own_cpu / with.own_cpu),
    })
}

/// Frames of a camera that stands, each beside one whose maps are all drawn: in which nothing moved, and one box.
fn changes(machine: &Machine) -> Result<(Option<Spread>, Spread), Box<dyn Error>> {
    let mut view = View::new(machine, field(FEW, Order::Sorted), four_maps())?;
    view.options.timed = machine.gpu.has_timestamps();
    let (mut still_over_shaded, mut one_over_all) = (Vec::new(), Vec::new());
    for round in 0..BOXES[0].1 {
        nudge(&mut view.scene, round * 7 % FEW);
        let one = view.read_back(false)?;
        let all = view.read_back(true)?;
        let still = view.read_back(false)?;
        if still.report.caster_passes > 0 {
            return Err("a frame in which nothing moved drew a map".into());
        }
        one_over_all.push(one.frame / all.frame);
        if let Some(maps) = all.in_maps() {
            let shading = all.report.gpu_milliseconds - maps;
            still_over_shaded.push(still.report.gpu_milliseconds / shading);
        }
    }
    let still = (!still_over_shaded.is_empty()).then(|| Spread::of(still_over_shaded));
    Ok((still, Spread::of(one_over_all)))
}

fn allocations(machine: &Machine) -> Result<Allocations, Box<dyn Error>> {
    let mut view = View::new(machine, field(FEW, Order::Sorted), four_maps())?;
    let (mut still, mut camera_moves) = (Vec::new(), Vec::new());
    for frame in 0..9 {
        look(&mut view.scene, frame);
        camera_moves.push(view.steady()?.allocations);
        still.push(view.steady()?.allocations);
    }
    Ok(Allocations {
        still: Spread::of(still),
        camera_moves: Spread::of(camera_moves),
    })
}

impl Report {
    fn print(&self) {
        println!("{}, median (least to most)", self.adapter);
        if let Some(still) = &self.still_over_unshadowed {
            println!("nothing moved, over shading alone   {still}  (goal 1.05)");
        }
        println!(
            "one box moved, over all drawn       {}  (goal 0.35)",
            self.one_moves_over_all
        );
        println!(
            "list mixed, over sorted, own CPU    {}  (goal 1.05)",
            self.shuffled_over_ordered
        );
        let Allocations {
            still,
            camera_moves,
        } = &self.allocations;
        println!("allocations, nothing moved          {still}  (goal 100)");
        println!("allocations, the camera moved       {camera_moves}  (goal 100)");
        let flight = &self.flight;
        println!(
            "54 new permutations in flight, {} frames, worst over median: {:.3}  (goal 1.1); own CPU {:.3}; {:.3} where \
             frames wait",
            flight.frames,
            flight.worst_over_median,
            flight.own_cpu_worst_over_median,
            flight.stalled_worst_over_median
        );
        println!("    ms, frame                       {}", flight.in_flight);
        println!(
            "    first use over the next         {}",
            flight.first_use_over_next
        );
        for (count, boxes) in &self.boxes {
            let Added { frame, added } = boxes.times;
            println!("{count} boxes, camera moving, four maps of 1024²:");
            println!("    ms, frame                       {frame}");
            println!("    ms, added by shadows            {added}");
            println!("    ms, own CPU, steady loop        {}", boxes.own_cpu);
            println!(
                "    ms, own CPU, read back          {}",
                boxes.own_cpu_read_back
            );
            println!(
                "    draws {}, of casters {}; list mixed {}",
                boxes.draws, boxes.caster_draws, boxes.shuffled_draws
            );
        }
        let Added { frame, added } = self.one_map;
        println!("{FEW} boxes, camera moving, one map of 2048²:");
        println!("    ms, frame                       {frame}");
        println!("    ms, added by shadows            {added}");
    }
}

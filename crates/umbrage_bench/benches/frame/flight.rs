//! Frames while permutations are made that they need for the first time.

use std::{collections::BTreeSet, error::Error};

use serde::Serialize;
use umbrage_bench::{
    Spread,
    field::{Order, field, look},
};
use umbrage_render::{Meanwhile, Shadow, StandIn};

use crate::{
    FEW, four_maps,
    view::{Machine, View},
};

/// Filter's widths, transitions and biases: with two surfaces, 54 permutations beside those that stand in.
const WIDTHS: [&str; 7] = ["3", "5", "7", "9", "11", "13", "15"];
const TRANSITIONS: [&str; 2] = ["hard", "dither"];
const BIASES: [&str; 2] = ["plane", "constant"];
/// Frames beyond which workers are taken to hang.
const MOST_FRAMES: usize = 5_000;

#[derive(Serialize)]
pub(crate) struct Flight {
    /// The worst of the frames that were drawn by what stood in, over their median.
    pub(crate) worst_over_median: f64,
    /// Milliseconds of these frames.
    pub(crate) in_flight: Spread,
    /// The same for the part of the calling thread alone.
    pub(crate) own_cpu_worst_over_median: f64,
    /// The worst frame over the median where frames wait for what is new.
    pub(crate) stalled_worst_over_median: f64,
    /// The first frame that draws what workers made, over the next one with it: what the driver does at the first draw.
    pub(crate) first_use_over_next: Spread,
    pub(crate) frames: usize,
}

fn choices() -> Vec<Shadow> {
    let mut all = Vec::new();
    for width in WIDTHS {
        for transition in TRANSITIONS {
            for bias in BIASES {
                let axes = [
                    ("pcf", width),
                    ("transition", transition),
                    ("receiver_bias", bias),
                ];
                all.push(
                    axes.iter()
                        .fold(four_maps(), |shadow, (a, v)| shadow.with(a, v)),
                );
            }
        }
    }
    // The first one stands in.
    all.split_off(1)
}

pub(crate) fn measure(machine: &Machine) -> Result<Flight, Box<dyn Error>> {
    let choices = choices();
    let stand_in = [
        ("pcf", "3"),
        ("transition", "hard"),
        ("receiver_bias", "plane"),
    ];
    let base = stand_in
        .iter()
        .fold(four_maps(), |shadow, (a, v)| shadow.with(a, v));

    let mut view = View::new(machine, field(FEW, Order::Sorted), base.clone())?;
    view.options.meanwhile = Meanwhile::StandIn(StandIn {
        axes: stand_in.map(|(a, v)| (a.to_owned(), v.to_owned())).into(),
        // Not looked at here.
        error: 1.0,
    });
    let (mut in_flight, mut own_cpu, mut first_use) = (Vec::new(), Vec::new(), Vec::new());
    let mut used = BTreeSet::new();
    for frame in 0.. {
        let choice = frame % choices.len();
        view.options.shadow = choices[choice].clone();
        look(&mut view.scene, frame);
        let shot = view.steady()?;
        if let Some(warning) = shot.report.warnings.first() {
            return Err(warning.clone().into());
        }
        if shot.report.waiting > 0 {
            in_flight.push(shot.frame);
            own_cpu.push(shot.own_cpu);
        } else if used.insert(choice) {
            first_use.push(shot.frame / view.steady()?.frame);
        }
        if used.len() == choices.len() {
            break;
        }
        if frame > MOST_FRAMES {
            return Err("workers do not come to an end".into());
        }
    }
    let frames = in_flight.len();

    let mut view = View::new(machine, field(FEW, Order::Sorted), base)?;
    let mut stalled = Vec::new();
    for (frame, choice) in choices.iter().enumerate() {
        view.options.shadow = choice.clone();
        look(&mut view.scene, frame);
        stalled.push(view.steady()?.frame);
    }
    let worst_over_median = |times: Vec<f64>| {
        let spread = Spread::of(times);
        spread.max / spread.median
    };
    Ok(Flight {
        in_flight: Spread::of(in_flight.clone()),
        worst_over_median: worst_over_median(in_flight),
        own_cpu_worst_over_median: worst_over_median(own_cpu),
        stalled_worst_over_median: worst_over_median(stalled),
        first_use_over_next: Spread::of(first_use),
        frames,
    })
}

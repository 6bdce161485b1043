//! Frames in which nothing moved, over frames whose shadow maps are all drawn.

use std::{error::Error, path::Path as FilePath};

use serde::Serialize;
use umbrage_measure::report::Spread;
use umbrage_render::{RenderOptions, Renderer, Shadow, What};

use crate::timing::{ROUNDS, SIZE, load};

/// Scenes, and the filters of their maps: each with its scene's own method.
const STILL: [(&str, &str); 4] = [
    ("avenue", "hpsm"),
    ("avenue", "esm"),
    ("bunny_sun", "pcf"),
    ("room_point", "pcf"),
];

#[derive(Serialize)]
pub(crate) struct Report {
    /// By scene and filter.
    still_over_moving: Vec<Still>,
}

#[derive(Serialize)]
struct Still {
    scene: &'static str,
    filter: &'static str,
    /// The device's time of all that is submitted, pair by pair.
    ratio: Spread,
    /// Passes of plans that a moving frame runs, and that a still one runs.
    passes: [u32; 2],
}

pub(crate) fn measure(
    renderer: &mut Renderer,
    scenes: &FilePath,
) -> Result<Report, Box<dyn Error>> {
    let mut all = Vec::new();
    for (name, filter) in STILL {
        let scene = load(scenes, name)?;
        let options = |fresh| RenderOptions {
            width: SIZE.0,
            height: SIZE.1,
            what: What::Shaded,
            shadow: Shadow::default().with("filter", filter),
            fresh,
            ..RenderOptions::default()
        };
        let mut draw = |fresh| -> Result<(f64, u32), Box<dyn Error>> {
            let report = renderer.render(&scene, &options(fresh))?.report;
            let passes = report.caster_passes + report.derived_passes;
            Ok((report.gpu_milliseconds, passes))
        };
        let (mut ratios, mut passes) = (Vec::new(), [0; 2]);
        for _ in 0..ROUNDS {
            let (moving, run) = draw(true)?;
            let (still, kept) = draw(false)?;
            ratios.push(still / moving);
            passes = [run, kept];
        }
        all.push(Still {
            scene: name,
            filter,
            ratio: Spread::of(&ratios),
            passes,
        });
    }
    Ok(Report {
        still_over_moving: all,
    })
}

impl Report {
    pub(crate) fn print(&self) {
        for Still {
            scene,
            filter,
            ratio,
            passes: [moving, still],
        } in &self.still_over_moving
        {
            println!(
                "a still frame over a moving one, {scene} {filter}: {:.3} ({:.3} to {:.3}), {still} of {moving} passes",
                ratio.median, ratio.min, ratio.max
            );
        }
    }
}

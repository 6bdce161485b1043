//! Ways of drawing and timing that the benchmarks of filters share.

use std::{error::Error, path::Path as FilePath};

use umbrage_compose::Purpose;
use umbrage_measure::report::Spread;
use umbrage_render::{Path, RenderOptions, Rendered, Renderer, Scene, Shadow, What};

/// Each with the scene's own method: splits in the first, one map in the others.
pub(crate) const SCENES: [&str; 4] = ["avenue", "bunny_sun", "leaves", "suzanne_spot"];

pub(crate) const SIZE: (u32, u32) = (1280, 720);

pub(crate) const ROUNDS: usize = 9;

/// Texels along a block: half as long to build as with 4, and up to 4 in 100 receivers more that stay open.
const BLOCK: &str = "8";

/// How a picture is drawn.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Way {
    /// In place of the scene's own.
    pub method: Option<&'static str>,
    pub axes: [(&'static str, &'static str); 2],
    /// Bounds of maps are built even where they do not pay.
    pub always_bounded: bool,
    /// How shadow terms come to the surfaces.
    pub path: Path,
}

/// Milliseconds.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Times {
    /// Of what is built from the maps.
    pub built: f64,
    /// Of the passes in which the filter is called.
    pub filtered: f64,
    /// Of all that is submitted, by the clock on the wall.
    pub frame: f64,
}

impl Times {
    pub(crate) fn whole(self) -> f64 {
        self.built + self.filtered
    }
}

pub(crate) fn load(scenes: &FilePath, name: &str) -> Result<Scene, Box<dyn Error>> {
    Ok(Scene::load(scenes.join(name).with_extension("ron"))?)
}

/// Time of each of `ways`, round by round.
pub(crate) fn time<const N: usize>(
    renderer: &mut Renderer,
    scene: &Scene,
    ways: [Way; N],
) -> Result<Vec<[Times; N]>, Box<dyn Error>> {
    let mut rounds = vec![[Times::default(); N]; ROUNDS];
    for round in &mut rounds {
        for (times, way) in round.iter_mut().zip(ways) {
            // The first one makes the maps, in the place of another's: not counted.
            draw(renderer, scene, way, What::ShadowTerm)?;
            let pass = match way.path {
                Path::Forward | Path::ForwardAll => "shadow_term",
                Path::Mask | Path::MaskBySplit => "mask",
            };
            *times = split(&draw(renderer, scene, way, What::ShadowTerm)?, pass);
        }
    }
    Ok(rounds)
}

pub(crate) fn draw(
    renderer: &mut Renderer,
    scene: &Scene,
    way: Way,
    what: What,
) -> Result<Rendered, Box<dyn Error>> {
    let mut options = options(SIZE, &way.axes, what);
    options.path = way.path;
    if way.always_bounded {
        options.shadow = options.shadow.with_setting("always_bounded", 1.0);
    }
    options.shadow.method = way.method.unwrap_or_default().to_owned();
    Ok(renderer.render(scene, &options)?)
}

/// Timed, with these axes and the blocks of all that is bounded here.
pub(crate) fn options(
    (width, height): (u32, u32),
    axes: &[(&str, &str)],
    what: What,
) -> RenderOptions {
    let axes = axes.iter().chain(&[("block", BLOCK)]);
    RenderOptions {
        width,
        height,
        what,
        shadow: axes.fold(Shadow::default(), |shadow, (a, v)| shadow.with(a, v)),
        // Shadow maps are part of the cost.
        fresh: true,
        timed: true,
        ..RenderOptions::default()
    }
}

/// The filter runs in the passes of this name. All that is submitted counts as theirs where the device has no timestamps.
pub(crate) fn split(rendered: &Rendered, filtering: &str) -> Times {
    let report = &rendered.report;
    if report.times.is_empty() {
        return Times {
            built: 0.0,
            filtered: report.gpu_milliseconds,
            frame: report.gpu_milliseconds,
        };
    }
    let mut times = Times {
        frame: report.gpu_milliseconds,
        ..Times::default()
    };
    for pass in &report.times {
        if pass.pass == filtering {
            times.filtered += pass.milliseconds;
        } else if pass.purpose == Purpose::Maps && pass.pass != "casters" {
            times.built += pass.milliseconds;
        }
    }
    times
}

pub(crate) fn median(numbers: impl Iterator<Item = f64>) -> f64 {
    Spread::of(&numbers.collect::<Vec<_>>()).median
}

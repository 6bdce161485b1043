//! How long pictures take: configurations side by side, round after round, so that what else the machine
//! does falls on all of them alike.

use umbrage_compose::Purpose;
use umbrage_render::{PassTime, Path, RenderError, Rendered, Shadow};

use super::{Config, Lab, Progress, lab::Subject};
use crate::report::Spread;

/// The configuration that times are compared with: the plainest shadow map, one tap wide.
pub(super) fn baseline() -> Config {
    Config {
        name: "1 tap".to_owned(),
        shadow: Shadow::new("basic").with("pcf", "1"),
        path: Path::default(),
    }
}

/// Times of one configuration's rounds, milliseconds.
#[derive(Clone, Debug, Default)]
pub(super) struct Times {
    /// The passes that make shadow maps and what is computed from them, and the passes that shade; empty where the adapter has no timestamps.
    casters: Vec<f64>,
    shading: Vec<f64>,
    /// From the first command to the last pixel, as the clock on the wall has it.
    frame: Vec<f64>,
}

/// Times of a configuration, and as ratios to the baseline's.
pub(super) struct Timing {
    pub(super) casters_ms: Spread,
    pub(super) shading_ms: Spread,
    pub(super) frame_ms: Spread,
    pub(super) ratio: Spread,
}

/// Draws the subject `rounds` times with each of `configs`, the baseline first in each round. Pipelines must
/// have been made. An error names the configuration.
pub(super) fn time(
    lab: &mut Lab,
    subject: &Subject<'_>,
    configs: &[&Config],
    rounds: u32,
    progress: &dyn Progress,
) -> Result<Vec<Timing>, (String, RenderError)> {
    let baseline = baseline();
    let mut times = vec![Times::default(); configs.len() + 1];
    let all = || std::iter::once(&baseline).chain(configs.iter().copied());
    for _ in 0..rounds {
        for (config, times) in all().zip(&mut times) {
            let options = config.options(subject.size());
            // The first one makes the maps, in the place of another configuration's: not counted.
            let shaded = lab
                .shaded(subject, &options)
                .and_then(|_| lab.shaded(subject, &options));
            times.add(&shaded.map_err(|error| (config.label(), error))?);
            progress.step();
        }
    }
    let (baseline, own) = times.split_at(1);
    Ok(own.iter().map(|own| own.against(&baseline[0])).collect())
}

impl Times {
    fn add(&mut self, rendered: &Rendered) {
        let report = &rendered.report;
        self.frame.push(report.gpu_milliseconds);
        if report.times.is_empty() {
            return;
        }
        let sum = |wanted: &dyn Fn(&PassTime) -> bool| {
            let passes = report.times.iter().filter(|time| wanted(time));
            passes.map(|time| time.milliseconds).sum::<f64>()
        };
        self.casters
            .push(sum(&|pass| pass.purpose == Purpose::Maps));
        // A picture's share that no light has counts for none.
        let shades = |pass: &PassTime| matches!(pass.purpose, Purpose::Shadow | Purpose::Light);
        self.shading.push(sum(&shades));
    }

    /// These times beside those of the baseline.
    fn against(&self, baseline: &Self) -> Timing {
        let rounds = self.whole().into_iter().zip(baseline.whole());
        let ratios: Vec<_> = rounds.map(|(own, baseline)| own / baseline).collect();
        Timing {
            casters_ms: Spread::of(&self.casters),
            shading_ms: Spread::of(&self.shading),
            frame_ms: Spread::of(&self.frame),
            ratio: Spread::of(&ratios),
        }
    }

    /// Casters and shading of each round; the time on the wall where there are no timestamps.
    fn whole(&self) -> Vec<f64> {
        if self.casters.is_empty() {
            return self.frame.clone();
        }
        let both = self.casters.iter().zip(&self.shading);
        both.map(|(casters, shading)| casters + shading).collect()
    }
}

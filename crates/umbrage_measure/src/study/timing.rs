//! How long pictures take: pair by pair with the baseline, so that what else the machine does falls on both alike.

use umbrage_compose::Purpose;
use umbrage_render::{PassTime, Path, RenderError, Rendered, Shadow};

use super::{Config, Lab, lab::Subject};
use crate::report::{Ratio, Spread};

/// The configuration that times are compared with: the plainest shadow map, one tap wide.
pub(super) fn baseline() -> Config {
    Config {
        name: "1 tap".to_owned(),
        shadow: Shadow::new("basic").with("pcf", "1"),
        path: Path::default(),
    }
}

/// A configuration's times, and as a ratio to the baseline's.
#[derive(Debug, Default)]
pub(super) struct Timing {
    pub(super) casters_ms: Spread,
    pub(super) shading_ms: Spread,
    pub(super) frame_ms: Spread,
    pub(super) ratio: Ratio,
    /// Each pair's times, the baseline's first; milliseconds.
    pub(super) pairs: Vec<[f64; 2]>,
}

/// Times of one picture, milliseconds.
struct Times {
    /// The passes that make shadow maps and what is computed from them, and the passes that shade; none where the adapter has no
    /// timestamps.
    passes: Option<[f64; 2]>,
    /// From the first command to the last pixel, as the clock on the wall has it.
    frame: f64,
}

/// Draws the subject with the baseline and with `config` in turn, until the interval of their ratio is narrow or there are
/// `most_pairs` of them. Each of the two has a renderer of its own, so that both find their maps and pipelines as they left
/// them; which of the two begins changes from pair to pair. An error names the configuration.
pub(super) fn time(
    lab: &mut Lab,
    subject: &Subject<'_>,
    config: &Config,
    most_pairs: u32,
) -> Result<Timing, (String, RenderError)> {
    let baseline = baseline();
    let mut draw = |is_own: bool| {
        let config = if is_own { config } else { &baseline };
        let shaded = lab.timed(subject, &config.options(subject.size()), is_own);
        let shaded = shaded.map_err(|error| (config.label(), error))?;
        Ok(Times::of(&shaded))
    };
    // Pictures that make pipelines and maps are not counted.
    draw(false)?;
    draw(true)?;
    let (mut own, mut pairs) = (Vec::new(), Vec::new());
    for number in 0..most_pairs {
        let own_first = number % 2 == 1;
        let (first, second) = (draw(own_first)?, draw(!own_first)?);
        let (before, after) = if own_first {
            (second, first)
        } else {
            (first, second)
        };
        pairs.push([before.whole(), after.whole()]);
        own.push(after);
        if ratio(&pairs).is_narrow() {
            break;
        }
    }
    let part = |part: usize| {
        let times = own.iter().filter_map(|times| Some(times.passes?[part]));
        Spread::of(&times.collect::<Vec<_>>())
    };
    let frames: Vec<_> = own.iter().map(|times| times.frame).collect();
    Ok(Timing {
        casters_ms: part(0),
        shading_ms: part(1),
        frame_ms: Spread::of(&frames),
        ratio: ratio(&pairs),
        pairs,
    })
}

/// The ratio that pairs of times come to, the baseline's first in each.
pub(super) fn ratio(pairs: &[[f64; 2]]) -> Ratio {
    let ratios = pairs.iter().map(|[baseline, own]| own / baseline);
    Ratio::of(&ratios.collect::<Vec<_>>())
}

impl Times {
    fn of(rendered: &Rendered) -> Self {
        let report = &rendered.report;
        let sum = |wanted: &dyn Fn(&PassTime) -> bool| {
            let passes = report.times.iter().filter(|time| wanted(time));
            passes.map(|time| time.milliseconds).sum::<f64>()
        };
        let casters = sum(&|pass| pass.purpose == Purpose::Maps);
        // A picture's share that no light has counts for none.
        let shades = |pass: &PassTime| matches!(pass.purpose, Purpose::Shadow | Purpose::Light);
        Self {
            passes: (!report.times.is_empty()).then(|| [casters, sum(&shades)]),
            frame: report.gpu_milliseconds,
        }
    }

    /// Casters and shading; the time on the wall where there are no timestamps.
    fn whole(&self) -> f64 {
        self.passes
            .map_or(self.frame, |[casters, shading]| casters + shading)
    }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeMap;

    use super::*;

    /// Times of `umbrage compare examples/scenes/avenue.ron --size 480x270` on two cores, by llvmpipe, while builds of low
    /// priority ran, and with two endless loops beside it, so that it had a third of the machine before and an eighth then. Each pair
    /// has the baseline's milliseconds first.
    const QUIET: &str = include_str!("recorded/quiet.json");
    const BUSY: &str = include_str!("recorded/busy.json");

    fn recorded(text: &str) -> BTreeMap<String, Vec<[f64; 2]>> {
        serde_json::from_str(text).expect("times")
    }

    /// The ratio as it is measured: until it is narrow.
    fn measured(pairs: &[[f64; 2]]) -> Ratio {
        let mut narrow = (1..=pairs.len()).map(|taken| ratio(&pairs[..taken]));
        let found = narrow.clone().find(Ratio::is_narrow);
        found.or(narrow.next_back()).expect("pairs")
    }

    #[test]
    fn a_busy_machine_tells_less_and_nothing_else() {
        let (quiet, busy) = (recorded(QUIET), recorded(BUSY));
        assert_eq!(quiet.len(), 8);
        let ratios: Vec<_> = quiet
            .iter()
            .map(|(name, pairs)| (name, measured(pairs), measured(&busy[name])))
            .collect();
        let mut told_apart = 0;
        for (index, (name, quiet, busy)) in ratios.iter().enumerate() {
            println!("{name}: {quiet:?} {busy:?}");
            assert!(quiet.is_told() && busy.is_told(), "{name}");
            assert!(quiet.overlaps(busy), "{name}");
            for (other, other_quiet, other_busy) in &ratios[..index] {
                if busy.overlaps(other_busy) {
                    continue;
                }
                told_apart += 1;
                // Nowhere the reverse of what is found alone.
                let is_less = busy.median < other_busy.median;
                assert_eq!(
                    is_less,
                    quiet.median < other_quiet.median,
                    "{name}, {other}"
                );
            }
        }
        // Of 28 pairs most are told apart all the same.
        assert!(told_apart >= 20, "{told_apart}");
    }
}

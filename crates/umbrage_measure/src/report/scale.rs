//! The axes of the plots: from figures to places.

use std::ops::Range;

use plotters::coord::ranged1d::{KeyPointHint, NoDefaultFormatting, Ranged, ValueFormatter};

/// From which ratio of the greatest to the least value on an axis is logarithmic.
const LOG_FROM: f64 = 12.0;

/// The share of a logarithmic axis that lies below its least value, for 0 to have a place.
const ZERO: f64 = 0.09;

/// An axis from 0 up.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Scale {
    /// 0 to `most`.
    Linear { most: f64 },
    /// `least` to `most`, with ticks at powers of `base`; below them 0, where there is such a value.
    Log {
        base: f64,
        least: f64,
        most: f64,
        zero: bool,
    },
}

impl Scale {
    /// Logarithmic, as errors are compared by their ratios, with ticks at powers of ten: the same in all plots. All `values` are
    /// finite and not below 0.
    pub(super) fn for_errors(values: impl Iterator<Item = f64> + Clone) -> Self {
        match span(values.clone()) {
            Some(_) => Self::log(10.0, values),
            None => Self::Linear { most: 0.01 },
        }
    }

    /// From 0 on where the values are alike, else logarithmic, with ticks at powers of two.
    pub(super) fn for_times(values: impl Iterator<Item = f64> + Clone) -> Self {
        match span(values.clone()) {
            Some((least, most)) if most / least > LOG_FROM => Self::log(2.0, values),
            Some((_, most)) => Self::Linear { most: most * 1.1 },
            None => Self::Linear { most: 1.0 },
        }
    }

    /// Logarithmic, with ticks at powers of two: what memory grows by.
    pub(super) fn for_memory(values: impl Iterator<Item = f64> + Clone) -> Self {
        Self::log(2.0, values)
    }

    fn log(base: f64, values: impl Iterator<Item = f64> + Clone) -> Self {
        let Some((least, most)) = span(values.clone()) else {
            return Self::Linear { most: 1.0 };
        };
        // Half a step of air on both sides.
        let air = base.sqrt();
        Self::Log {
            base,
            least: least / air,
            most: most * air,
            zero: values.into_iter().any(|value| value <= 0.0),
        }
    }

    /// Whether the distance on the axis is that of the logarithms.
    pub(super) fn is_log(&self) -> bool {
        matches!(self, Self::Log { .. })
    }

    /// The place of `value`: 0 at the axis' start to 1 at its end.
    fn place(&self, value: f64) -> f64 {
        let place = match *self {
            Self::Linear { most } => value / most,
            Self::Log { zero: true, .. } if value <= 0.0 => 0.0,
            Self::Log {
                least, most, zero, ..
            } => {
                let from = if zero { ZERO } else { 0.0 };
                from + (1.0 - from) * (value / least).ln() / (most / least).ln()
            }
        };
        place.clamp(0.0, 1.0)
    }

    /// At most `most_ticks` of them, as round as can be.
    fn ticks(&self, most_ticks: usize) -> Vec<f64> {
        match *self {
            Self::Linear { most } => linear_ticks(most, most_ticks),
            Self::Log {
                base,
                least,
                most,
                zero,
            } => {
                let ticks = log_ticks(base, least, most, most_ticks);
                zero.then_some(0.0).into_iter().chain(ticks).collect()
            }
        }
    }
}

/// The least and the greatest of those above 0.
fn span(values: impl Iterator<Item = f64>) -> Option<(f64, f64)> {
    values
        .filter(|value| *value > 0.0)
        .fold(None, |span, value| match span {
            None => Some((value, value)),
            Some((least, most)) => Some((value.min(least), value.max(most))),
        })
}

/// From 0 on by 1, 2 or 5 times a power of ten.
fn linear_ticks(most: f64, most_ticks: usize) -> Vec<f64> {
    let step = (0..)
        .map(|index| {
            let decade = 10_f64.powf((most.log10() - 3.0).floor() + f64::from(index / 3));
            decade * [1.0, 2.0, 5.0][index as usize % 3]
        })
        .find(|step| most / step < most_ticks.max(2) as f64)
        .unwrap_or(most);
    (0..)
        .map(|index| f64::from(index) * step)
        .take_while(|tick| *tick <= most)
        .collect()
}

/// Powers of `base`; of ten also their double and fivefold, where there is room; every other where there
/// is not.
fn log_ticks(base: f64, least: f64, most: f64, most_ticks: usize) -> Vec<f64> {
    let power = |value: f64| value.ln() / base.ln();
    let (first, last) = (power(least).floor() as i32, power(most).ceil() as i32);
    let ticks = |factors: &[f64], stride: i32| -> Vec<f64> {
        (first..=last)
            .filter(|exponent| exponent.rem_euclid(stride) == 0)
            .flat_map(|exponent| factors.iter().map(move |f| f * base.powi(exponent)))
            .filter(|tick| (least..=most).contains(tick))
            .collect()
    };
    let fine: &[f64] = if base == 10.0 {
        &[1.0, 2.0, 5.0]
    } else {
        &[1.0]
    };
    let all = ticks(fine, 1);
    if all.len() <= most_ticks {
        return all;
    }
    (1..)
        .map(|stride| ticks(&[1.0], stride))
        .find(|ticks| ticks.len() <= most_ticks.max(1))
        .unwrap_or_default()
}

impl Ranged for Scale {
    type FormatOption = NoDefaultFormatting;
    type ValueType = f64;

    fn map(&self, value: &f64, limit: (i32, i32)) -> i32 {
        let (from, to) = (f64::from(limit.0), f64::from(limit.1));
        (from + (to - from) * self.place(*value)).round() as i32
    }

    fn key_points<Hint: KeyPointHint>(&self, hint: Hint) -> Vec<f64> {
        self.ticks(hint.bold_points())
    }

    fn range(&self) -> Range<f64> {
        match *self {
            Self::Linear { most } => 0.0..most,
            Self::Log {
                least, most, zero, ..
            } => (if zero { 0.0 } else { least })..most,
        }
    }
}

impl ValueFormatter<f64> for Scale {
    fn format(value: &f64) -> String {
        super::format::tick(*value)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn log(values: &[f64]) -> Scale {
        Scale::for_errors(values.iter().copied())
    }

    #[test]
    fn times_are_logarithmic_in_a_wide_range_and_errors_in_any() {
        let times = |values: &[f64]| Scale::for_times(values.iter().copied());
        assert_eq!(times(&[0.25, 0.5]), Scale::Linear { most: 0.5 * 1.1 });
        assert!(times(&[0.001, 0.02]).is_log());
        assert!(log(&[0.25, 0.5]).is_log() && log(&[0.3]).is_log());
        assert_eq!(log(&[0.0, 0.0]), Scale::Linear { most: 0.01 });
        assert_eq!(log(&[]), Scale::Linear { most: 0.01 });
        assert!(Scale::for_memory([4096.0].into_iter()).is_log());
    }

    #[test]
    fn zero_lies_below_every_other_value() {
        let scale = log(&[0.0, 1e-5, 1e-2]);
        assert_eq!(scale.place(0.0), 0.0);
        assert!(scale.place(1e-5) > ZERO);
        assert!(scale.place(1e-2) < 1.0);
        assert_eq!(scale.ticks(6).first(), Some(&0.0));
        assert!(!log(&[1e-5, 1e-2]).ticks(6).contains(&0.0));
    }

    #[test]
    fn equal_ratios_are_equal_distances() {
        let scale = log(&[0.0, 1e-5, 1e-1]);
        let place = |value| scale.place(value);
        let decade = place(1e-4) - place(1e-5);
        for value in [1e-4, 1e-3, 1e-2] {
            assert!((place(10.0 * value) - place(value) - decade).abs() < 1e-12);
        }
        assert_eq!(scale.map(&0.0, (400, 0)), 400);
    }

    #[test]
    fn ticks_are_round_few_and_inside() {
        for values in [&[0.013, 0.04][..], &[1e-4, 0.3], &[1e-9, 0.5], &[0.2, 9.0]] {
            for scale in [
                log(values),
                Scale::for_memory(values.iter().map(|v| v * 1e9)),
                Scale::for_times(values.iter().copied()),
            ] {
                let ticks = scale.ticks(7);
                assert!((2..=7).contains(&ticks.len()), "{scale:?}: {ticks:?}");
                let range = scale.range();
                for tick in &ticks {
                    assert!(
                        *tick >= range.start && *tick <= range.end,
                        "{scale:?}: {tick}"
                    );
                }
                assert!(ticks.is_sorted());
            }
        }
        let ticks = Scale::Linear { most: 0.33 }.ticks(8);
        assert_eq!(ticks.len(), 7, "{ticks:?}");
    }
}

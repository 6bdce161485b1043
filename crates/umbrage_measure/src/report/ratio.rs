//! Ratios of times that hold on a machine which does other things too.

use serde::Serialize;

/// How many times as long as its baseline a configuration takes: the median of ratios, each of one pair of pictures drawn one
/// after the other, and an interval in which the true median lies.
///
/// Other work of the machine lengthens both pictures of a pair, or one of them; the median leaves single mishaps out.
/// The interval is that of order statistics, which asks nothing of how the ratios are distributed (David and Nagaraja 2003,
/// "Order Statistics", section 7.1): as many of n independent ratios lie below the median as coins show heads, so that
/// the k-th least and the k-th greatest have it between them but in two tails of that distribution. The tails are at most
/// `DOUBT` each time; a measurement that goes on until the interval is narrow looks many times, and its interval holds in 95
/// of 100.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Ratio {
    /// The median; no number without pairs.
    pub median: f64,
    /// The interval's lower end; 0 where there are too few pairs to tell.
    pub low: f64,
    /// Its upper end; infinite where there are too few pairs to tell.
    pub high: f64,
    /// How many pairs were drawn.
    pub pairs: usize,
}

/// How often the interval of one look may miss the median.
const DOUBT: f64 = 0.02;

/// How far apart the ends of an interval may be, as a ratio, for it to be narrow: more pairs are of little use.
const NARROW: f64 = 1.05;

/// From which ratio of its ends on an interval tells nothing: the machine was too busy.
const TOO_WIDE: f64 = 1.5;

impl Ratio {
    /// Of ratios in any order.
    pub fn of(ratios: &[f64]) -> Self {
        let mut sorted = ratios.to_vec();
        sorted.sort_by(f64::total_cmp);
        let (pairs, last) = (sorted.len(), sorted.len().saturating_sub(1));
        let at = |place: usize| sorted.get(place).copied().unwrap_or(f64::NAN);
        let (low, high) = match rank(pairs) {
            Some(rank) => (at(rank - 1), at(pairs - rank)),
            None => (0.0, f64::INFINITY),
        };
        Self {
            // The middle of an even number is the mean of two.
            median: 0.5 * (at(last / 2) + at(last.div_ceil(2))),
            low,
            high,
            pairs,
        }
    }

    /// A ratio without doubt.
    #[cfg(test)]
    pub(crate) fn exactly(ratio: f64) -> Self {
        Self {
            median: ratio,
            low: ratio,
            high: ratio,
            pairs: 1,
        }
    }

    /// Whether more pairs would say little more.
    pub(crate) fn is_narrow(&self) -> bool {
        self.high <= NARROW * self.low
    }

    /// Whether it says enough to rank by. Otherwise the machine was too busy, or there are too few pairs.
    pub fn is_told(&self) -> bool {
        self.median.is_finite() && self.low > 0.0 && self.high <= TOO_WIDE * self.low
    }

    /// Whether it may be the same as another, as far as the two measurements tell.
    pub fn overlaps(&self, other: &Self) -> bool {
        self.low <= other.high && other.low <= self.high
    }
}

impl Default for Ratio {
    fn default() -> Self {
        Self::of(&[])
    }
}

/// The greatest k for which the median of n lies between the k-th least and the k-th greatest of them, but for `DOUBT`;
/// none where n is too small, below 7.
fn rank(n: usize) -> Option<usize> {
    // The probability of so many heads among n coins, in the logarithm, as 2^-n is no number of f64 for long.
    let (mut log, mut tail) = (-(n as f64) * std::f64::consts::LN_2, 0.0);
    let mut rank = None;
    for heads in 0..n.div_ceil(2) {
        tail += f64::exp(log);
        if 2.0 * tail > DOUBT {
            break;
        }
        rank = Some(heads + 1);
        log += ((n - heads) as f64 / (heads + 1) as f64).ln();
    }
    rank
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Noise as a busy machine makes it, without a median other than 1: most pairs are a few percent off, some are many times
    /// as far, to either side.
    struct Noise(u64);

    impl Noise {
        fn uniform(&mut self) -> f64 {
            // SplitMix64 (Steele, Lea and Flood 2014).
            self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
            let mut z = self.0;
            z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
            z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
            ((z ^ (z >> 31)) >> 11) as f64 / (1_u64 << 53) as f64
        }

        fn ratio(&mut self, spread: f64) -> f64 {
            let wide = if self.uniform() < 0.15 { 6.0 } else { 1.0 };
            // Near enough to a normal distribution, and symmetric, which is what matters.
            let sum: f64 = (0..6).map(|_| self.uniform() - 0.5).sum();
            (spread * wide * sum).exp()
        }
    }

    #[test]
    fn the_ranks_are_those_of_the_tables() {
        // 1 - 2 · 2^-7 is 0.984; 2^-6 leaves 0.969. Of 40 the tails up to 12 heads are 0.0166, up to 13 are 0.0385.
        for (n, expected) in [
            (0, None),
            (6, None),
            (7, Some(1)),
            (10, Some(1)),
            (11, Some(2)),
            (40, Some(13)),
        ] {
            assert_eq!(rank(n), expected, "{n}");
        }
        // Far beyond 2^-1074: half less 2.33 standard deviations of half a root.
        let many = rank(10_000).expect("enough");
        assert!((4880..=4888).contains(&many), "{many}");
    }

    #[test]
    fn a_ratio_has_its_middle_and_its_ends() {
        let ratio = Ratio::of(&[7.0, 1.0, 3.0, 2.0, 6.0, 5.0, 4.0]);
        assert_eq!(
            (ratio.median, ratio.low, ratio.high, ratio.pairs),
            (4.0, 1.0, 7.0, 7)
        );
        assert!(!ratio.is_told() && !ratio.is_narrow());
        // Too few tell nothing, however alike they are.
        let few = Ratio::of(&[2.0; 6]);
        assert_eq!((few.median, few.low, few.high), (2.0, 0.0, f64::INFINITY));
        assert!(!few.is_told() && !few.is_narrow());
        assert!(Ratio::default().median.is_nan() && !Ratio::default().is_told());
        let alike = Ratio::of(&[2.0; 7]);
        assert!(alike.is_told() && alike.is_narrow());
        assert!(!Ratio::of(&[f64::NAN; 9]).is_told());
    }

    /// A measurement that stops as soon as it likes its interval, as ours does, is right in 95 of 100 all the same.
    #[test]
    fn an_interval_holds_though_it_is_looked_at_until_it_is_narrow() {
        let mut noise = Noise(1);
        for spread in [0.02, 0.05, 0.1, 0.3] {
            let (mut held, mut pairs) = (0, 0);
            for _ in 0..1000 {
                let mut ratios = Vec::new();
                let found = loop {
                    ratios.push(noise.ratio(spread));
                    let found = Ratio::of(&ratios);
                    if found.is_narrow() || ratios.len() == 40 {
                        break found;
                    }
                };
                held += u32::from(found.low <= 1.0 && 1.0 <= found.high);
                pairs += found.pairs;
            }
            assert!(held >= 950, "{spread}: {held} of 1000");
            // Quiet machines are done early.
            assert!(spread > 0.02 || pairs < 20_000, "{pairs}");
        }
    }
}

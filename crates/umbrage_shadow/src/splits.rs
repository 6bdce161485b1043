//! Where a view's depths are split (Zhang et al. 2006, "Parallel-split shadow maps for large-scale
//! virtual environments").

use crate::PlanError;

/// The most splits that a view may have.
pub const MAX_SPLITS: usize = 8;

/// The view depths (metres) at which `count` splits of the range from `near` to `far` begin and end:
/// `count` + 1 of them, ascending, `near` first and `far` last.
///
/// C_i = λ · C_log + (1 − λ) · C_uni, the practical scheme, where C_log = near · (far / near)^(i / count)
/// gives each split the same ratio of depths, and C_uni = near + (far − near) · i / count the same length.
/// λ = 1 shares perspective aliasing evenly between splits, and leaves little to those far away. λ = 0 is for an orthographic
/// view, whose pixels are as large at all depths: there splits of the same length share aliasing evenly, as C_log does of a
/// camera that is infinitely far away.
///
/// # Errors
/// A `near` that is not above 0, where λ is; a `far` that is not above `near`; one of them that is not finite; no split, or
/// more than [`MAX_SPLITS`]; a λ outside 0..1; so many splits in so short a range that two would begin at one
/// number.
pub fn split_depths(near: f64, far: f64, count: usize, lambda: f64) -> Result<Vec<f64>, PlanError> {
    PlanError::check(
        near.is_finite() && (near > 0.0 || lambda == 0.0),
        "the near end of the splits",
        near,
        "finite and above 0",
    )?;
    PlanError::check(
        far > near && far.is_finite(),
        "the far end of the splits",
        far,
        "finite and above the near end",
    )?;
    PlanError::check(
        (1..=MAX_SPLITS).contains(&count),
        "the number of splits",
        count,
        &format!("1 to {MAX_SPLITS}"),
    )?;
    PlanError::check(
        (0.0..=1.0).contains(&lambda),
        "the splits' lambda",
        lambda,
        "0 to 1",
    )?;
    let depth = |i: usize| match i {
        0 => near,
        i if i == count => far,
        i => {
            let share = i as f64 / count as f64;
            let uniform = near + (far - near) * share;
            if lambda == 0.0 {
                return uniform;
            }
            let logarithmic = near * (far / near).powf(share);
            lambda * logarithmic + (1.0 - lambda) * uniform
        }
    };
    let depths: Vec<f64> = (0..=count).map(depth).collect();
    let ascending = depths.is_sorted_by(|a, b| a < b);
    PlanError::check(
        ascending,
        "the range of the splits",
        format!("{near} to {far}"),
        "long enough for its splits to differ",
    )?;
    Ok(depths)
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn message(near: f64, far: f64, count: usize, lambda: f64) -> String {
        let fault = split_depths(near, far, count, lambda).map_err(|error| error.to_string());
        fault.err().unwrap_or_default()
    }

    /// Relative, in what the numbers' size leaves of f64.
    fn near_to(a: f64, b: f64) -> bool {
        (a - b).abs() <= 1e-12 * a.abs().max(b.abs())
    }

    proptest! {
        #[test]
        fn splits_ascend_from_end_to_end(
            near in 1e-6..1e4, ratio in 1.001..1e9, count in 1..=MAX_SPLITS, lambda in 0.0..=1.0,
        ) {
            let far = near * ratio;
            let depths = split_depths(near, far, count, lambda)?;
            prop_assert_eq!(depths.len(), count + 1);
            prop_assert_eq!((depths[0], depths[count]), (near, far));
            prop_assert!(depths.windows(2).all(|pair| pair[0] < pair[1]));
        }

        /// Definitions of the schemes: equal ratios, equal lengths, and the mean of the two.
        #[test]
        fn lambda_mixes_the_pure_schemes(
            near in 1e-3..1e2, ratio in 1.01f64..1e6, count in 1..=MAX_SPLITS, lambda in 0.0..=1.0,
        ) {
            let far = near * ratio;
            let logarithmic = split_depths(near, far, count, 1.0)?;
            let uniform = split_depths(near, far, count, 0.0)?;
            let mixed = split_depths(near, far, count, lambda)?;
            let factor = ratio.powf(1.0 / count as f64);
            let length = (far - near) / count as f64;
            for i in 0..count {
                prop_assert!(near_to(logarithmic[i + 1] / logarithmic[i], factor));
                prop_assert!((uniform[i + 1] - uniform[i] - length).abs() <= 1e-12 * far);
                let mean = lambda * logarithmic[i] + (1.0 - lambda) * uniform[i];
                prop_assert!(near_to(mixed[i], mean));
            }
        }
    }

    #[test]
    fn four_decades_are_four_splits() -> Result<(), PlanError> {
        let depths = split_depths(0.1, 1000.0, 4, 1.0)?;
        for (depth, expected) in depths.iter().zip([0.1, 1.0, 10.0, 100.0, 1000.0]) {
            assert!(near_to(*depth, expected), "{depth} {expected}");
        }
        let depths = split_depths(1.0, 9.0, 4, 0.0)?;
        assert_eq!(depths, [1.0, 3.0, 5.0, 7.0, 9.0]);
        Ok(())
    }

    #[test]
    fn even_splits_may_begin_anywhere() -> Result<(), PlanError> {
        assert_eq!(
            split_depths(-3.0, 1.0, 4, 0.0)?,
            [-3.0, -2.0, -1.0, 0.0, 1.0]
        );
        Ok(())
    }

    /// Splits of equal ratios, seen from far away, have equal lengths: as those of an orthographic view.
    #[test]
    fn equal_ratios_tend_to_equal_lengths_from_far_away() -> Result<(), PlanError> {
        let away = 1e6;
        let far = split_depths(1.0 + away, 9.0 + away, 4, 1.0)?;
        for (depth, expected) in far.iter().zip(split_depths(1.0, 9.0, 4, 0.0)?) {
            assert!((depth - away - expected).abs() < 1e-4, "{depth}");
        }
        Ok(())
    }

    #[test]
    fn what_cannot_be_split_is_named() {
        assert_eq!(
            message(2.0, 2.0, 4, 0.5),
            "the far end of the splits is 2, but must be finite and above the near end"
        );
        assert_eq!(
            message(0.0, 2.0, 4, 0.5),
            "the near end of the splits is 0, but must be finite and above 0"
        );
        assert_eq!(
            message(1.0, 2.0, 0, 0.5),
            "the number of splits is 0, but must be 1 to 8"
        );
        assert_eq!(
            message(1.0, 2.0, 9, 0.5),
            "the number of splits is 9, but must be 1 to 8"
        );
        assert_eq!(
            message(1.0, 2.0, 4, 1.5),
            "the splits' lambda is 1.5, but must be 0 to 1"
        );
        for (near, far, lambda) in [
            (f64::NAN, 2.0, 0.5),
            (f64::INFINITY, 2.0, 0.5),
            (1.0, f64::NAN, 0.5),
            (1.0, f64::INFINITY, 0.5),
            (1.0, 2.0, f64::NAN),
            (1.0, 2.0, -0.1),
            (-1.0, 2.0, 0.5),
            (1.0, 1.0f64.next_up(), 0.5),
        ] {
            assert_ne!(message(near, far, 4, lambda), "", "{near} {far} {lambda}");
        }
    }
}

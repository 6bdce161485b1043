//! Numbers as messages write them.

/// The number `value` as a person writes it: with an exponent only where there would be many zeros.
pub fn plain_number(value: f64) -> String {
    let size = value.abs();
    if size == 0.0 || !value.is_finite() || (1e-4..1e6).contains(&size) {
        format!("{value}")
    } else {
        format!("{value:e}")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exponents_stand_for_zeros_alone() {
        for (value, text) in [
            (0.0, "0"),
            (1.0, "1"),
            (89.0, "89"),
            (-0.5, "-0.5"),
            (0.001, "0.001"),
            (1e-6, "1e-6"),
            (123456.0, "123456"),
            (1e6, "1e6"),
            (1e12, "1e12"),
            (1e30, "1e30"),
            (f64::NAN, "NaN"),
            (f64::INFINITY, "inf"),
        ] {
            assert_eq!(plain_number(value), text);
        }
    }
}

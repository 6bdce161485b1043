//! Numbers as people read them.

use super::Ratio;

/// Stands where a figure is missing.
pub(super) const MISSING: &str = "–";

/// Three significant digits; whole from 100 on.
pub(super) fn number(value: f64) -> String {
    if !value.is_finite() {
        return MISSING.to_owned();
    }
    if value == 0.0 {
        return "0".to_owned();
    }
    if value < 0.0 {
        return format!("−{}", number(-value));
    }
    match value {
        _ if value < 0.000_1 => format!("{value:.1e}"),
        _ if value < 0.001 => format!("{value:.6}"),
        _ if value < 0.01 => format!("{value:.5}"),
        _ if value < 0.1 => format!("{value:.4}"),
        _ if value < 1.0 => format!("{value:.3}"),
        _ if value < 10.0 => format!("{value:.2}"),
        _ if value < 100.0 => format!("{value:.1}"),
        _ => whole(value),
    }
}

/// No fraction, and a thin space between thousands.
pub(super) fn whole(value: f64) -> String {
    if !value.is_finite() {
        return MISSING.to_owned();
    }
    let digits = format!("{:.0}", value.abs());
    let mut text = String::new();
    if value <= -0.5 {
        text.push('−');
    }
    for (index, digit) in digits.chars().enumerate() {
        if index > 0 && (digits.len() - index).is_multiple_of(3) {
            text.push('\u{2009}');
        }
        text.push(digit);
    }
    text
}

/// A share, 0 to 1, as percent.
pub(super) fn percent(share: f64) -> String {
    with_unit(number(share * 100.0), " %")
}

/// How many times as long.
pub(super) fn times(ratio: f64) -> String {
    with_unit(number(ratio), " ×")
}

/// A time with its interval, or why there is none.
pub(super) fn time(ratio: &Ratio) -> String {
    match (ratio.is_told(), doubt(ratio)) {
        (true, Some(doubt)) => format!("{} ({doubt})", times(ratio.median)),
        (false, Some(doubt)) => doubt,
        _ => MISSING.to_owned(),
    }
}

/// The interval of a ratio: `0.98–1.04`; none where nothing was timed.
pub(super) fn doubt(ratio: &Ratio) -> Option<String> {
    let interval = format!("{}–{}", number(ratio.low), number(ratio.high));
    match ratio.pairs {
        0 => None,
        _ if ratio.is_told() => Some(interval),
        _ if ratio.high.is_finite() => Some(format!("{interval}: too noisy to rank")),
        _ => Some("too few pairs to rank".to_owned()),
    }
}

/// Bytes, in the unit that they fill.
pub(super) fn bytes(bytes: f64) -> String {
    const STEP: f64 = 1024.0;
    if bytes < STEP {
        with_unit(whole(bytes), " B")
    } else if bytes < STEP * STEP {
        with_unit(number(bytes / STEP), " KiB")
    } else if bytes < STEP * STEP * STEP {
        with_unit(number(bytes / STEP / STEP), " MiB")
    } else {
        with_unit(number(bytes / STEP / STEP / STEP), " GiB")
    }
}

/// A tick of an axis: without the zeros that three digits would end in.
pub(super) fn tick(value: f64) -> String {
    // Through three digits, so that 0.1 + 0.2 is 0.3.
    let rounded: f64 = format!("{value:.3e}").parse().unwrap_or(value);
    if rounded != 0.0 && rounded.abs() < 0.000_1 {
        format!("{rounded:e}")
    } else {
        format!("{rounded}")
    }
}

fn with_unit(number: String, unit: &str) -> String {
    if number == MISSING {
        return number;
    }
    // A number and its unit stay on one line.
    number + &unit.replace(' ', "\u{202f}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_have_three_digits() {
        for (value, text) in [
            (0.0, "0"),
            (-0.0, "0"),
            (0.000_012_34, "1.2e-5"),
            (0.000_123_4, "0.000123"),
            (0.012_34, "0.0123"),
            (0.5, "0.500"),
            (1.0, "1.00"),
            (12.34, "12.3"),
            (123.4, "123"),
            (12_345.6, "12\u{2009}346"),
            (-1234.0, "−1\u{2009}234"),
            (-44.22, "−44.2"),
            (f64::NAN, MISSING),
            (f64::INFINITY, MISSING),
        ] {
            assert_eq!(number(value), text, "{value}");
        }
        assert_eq!(whole(1_000_000.0), "1\u{2009}000\u{2009}000");
    }

    #[test]
    fn units_follow_the_size() {
        assert_eq!(bytes(0.0), "0\u{202f}B");
        assert_eq!(bytes(1536.0), "1.50\u{202f}KiB");
        assert_eq!(bytes(4.0 * 1024.0 * 1024.0), "4.00\u{202f}MiB");
        assert_eq!(bytes(3.0 * 1024_f64.powi(3)), "3.00\u{202f}GiB");
        assert_eq!(percent(0.012_3), "1.23\u{202f}%");
        assert_eq!(times(1.5), "1.50\u{202f}×");
        assert_eq!(times(f64::NAN), MISSING);
    }

    #[test]
    fn times_have_their_interval() {
        let ratio = |low, high, pairs| Ratio {
            median: 1.0,
            low,
            high,
            pairs,
        };
        assert_eq!(time(&ratio(0.98, 1.04, 20)), "1.00\u{202f}× (0.980–1.04)");
        assert_eq!(time(&ratio(0.5, 2.0, 40)), "0.500–2.00: too noisy to rank");
        assert_eq!(time(&Ratio::of(&[1.0; 3])), "too few pairs to rank");
        assert_eq!(time(&Ratio::default()), MISSING);
    }

    #[test]
    fn ticks_have_no_needless_digits() {
        assert_eq!(tick(0.1 + 0.2), "0.3");
        assert_eq!(tick(20.0), "20");
        assert_eq!(tick(0.00001), "1e-5");
        assert_eq!(tick(0.0), "0");
    }
}

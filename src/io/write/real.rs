//! Numbers in fields of limited width.

/// A number in at most `width` characters, with a decimal point, as exact as
/// fits.
///
/// Readers of solver decks cut what is longer, and some take a number without
/// a point for a whole one. A width of 20 holds nearly every f64 exactly, 16
/// some 13 digits.
pub(super) fn real(x: f64, width: usize) -> String {
    let exact = pointed(format!("{x:?}"));
    if exact.len() <= width {
        return exact;
    }
    let fits = |text: &String| text.len() <= width;
    let fixed = (0..=width).rev().map(|p| pointed(format!("{x:.p$}")));
    let scientific = (0..=width).rev().map(|p| pointed(format!("{x:.p$e}")));
    let candidates = [
        fixed.into_iter().find(fits),
        scientific.into_iter().find(fits),
    ];
    let error = |text: &String| (text.parse::<f64>().unwrap_or(0.0) - x).abs();
    let best = (candidates.into_iter().flatten()).min_by(|a, b| error(a).total_cmp(&error(b)));
    best.unwrap_or_else(|| "0.".to_owned())
}

/// A number's text with a decimal point.
fn pointed(text: String) -> String {
    if text.contains('.') {
        return text;
    }
    match text.split_once('e') {
        Some((mantissa, exponent)) => format!("{mantissa}.e{exponent}"),
        None => format!("{text}."),
    }
}

#[cfg(test)]
mod tests {
    use super::real;

    #[test]
    fn numbers_fit_their_field_and_lose_little() {
        let numbers = [
            0.0,
            1.0,
            -1.0 / 3.0,
            1e-9 / 3.0,
            -2.0 / 3.0 * 1e12,
            123.456_789_012_345_67,
            f64::MIN_POSITIVE,
            -f64::MAX / 3.0,
            0.1 + 0.2,
        ];
        for x in numbers {
            for (width, share) in [(8, 2e-2), (16, 1e-8), (20, 1e-12)] {
                let text = real(x, width);
                assert!(text.len() <= width && text.contains('.'), "{text}");
                let back: f64 = text.parse().unwrap();
                assert!((back - x).abs() <= share * x.abs(), "{x} as {text}");
            }
        }
        assert_eq!(real(2.0, 8), "2.0");
        assert_eq!(real(1e-7, 8), "1.e-7");
        assert_eq!(real(0.1 + 0.2, 20), "0.30000000000000004");
    }
}

//! Paper 5's confidence of a marker, Eqs. (2) and (3).
//!
//! The confidence is computed from grey levels only. It can therefore not follow the error of the estimated pose as closely as the paper's Tables 2
//! and 3 show.

/// Least grey level of a pixel that counts as reflective (section 4.1 of paper 5).
pub const REFLECTIVE_GREY: u8 = 200;

/// Greatest and least value of the histogram [`fitted_count`] of marker dots' grey levels between grey levels 200 and 255, as printed in paper 5.
const H_MAX: f64 = 2730.3;
const H_MIN: f64 = 478.2;

/// Histogram of the grey levels of marker dots, as fitted in paper 5, Eq. (2): f(x) = 2634·e^(−(x − 245.4)²/196.84) + 525·e^(−(x − 208.6)²/791.30).
pub fn fitted_count(grey: f64) -> f64 {
    2634.0 * (-(grey - 245.4).powi(2) / 196.84).exp() + 525.0 * (-(grey - 208.6).powi(2) / 791.30).exp()
}

/// Confidence of a marker by Eq. (3) of paper 5: P(S) = 1/N · Σ (f(x) − H_min)/(H_max − H_min) over the grey levels x of its N reflective pixels,
/// where f is the fitted histogram of grey levels and H its values. Darker pixels are left out; without any reflective pixel the confidence is 0.
pub fn confidence(greys: impl IntoIterator<Item = u8>) -> f64 {
    let shares: Vec<f64> = greys
        .into_iter()
        .filter(|grey| *grey >= REFLECTIVE_GREY)
        .map(|grey| (fitted_count(f64::from(grey)) - H_MIN) / (H_MAX - H_MIN))
        .collect();
    if shares.is_empty() { 0.0 } else { shares.iter().sum::<f64>() / shares.len() as f64 }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_fitted_histogram_has_the_papers_greatest_and_least_value() {
        let values: Vec<f64> = (20000..=25500).map(|x| fitted_count(f64::from(x) / 100.0)).collect();
        let (least, greatest) =
            (values.iter().fold(f64::MAX, |a, &b| a.min(b)), values.iter().fold(0.0, |a: f64, &b| a.max(b)));
        assert!((greatest - 2730.3).abs() < 0.05 && (least - 478.2).abs() < 0.05, "{greatest} {least}");
    }

    #[test]
    fn saturated_dots_are_half_trusted_and_those_at_245_wholly() {
        // A saturated pixel of grey level 255 gets a confidence of 0.535 (erratum I3 of paper 5: the confidence depends on histogram heights only).
        assert!((confidence([255; 9]) - 0.535).abs() < 0.001);
        assert!((confidence([245; 9]) - 1.0).abs() < 0.001);
        assert!((confidence([245, 255, 100, 199]) - 0.7675).abs() < 0.001);
        assert_eq!(confidence([10, 199]), 0.0);
    }
}

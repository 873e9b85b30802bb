//! Constants of a robot from a drive whose true poses are known: quantities on which what a sensor reads depends linearly.
//!
//! Each span of the drive gives rows Σ aₖ·xₖ = b for the constants xₖ. Spans in which something else acted (a slip, a push) are outliers and are
//! set aside. How well the others determine the constants is told by the jackknife over blocks of the drive (B. Efron, *Bootstrap methods: another
//! look at the jackknife*, Annals of Statistics 7, 1979), as errors of spans beside each other are alike and a covariance that takes them for
//! independent would be too small.

use nalgebra::{SMatrix, SVector};

/// Number of blocks of the drive, of which the jackknife leaves out one after the other.
const N_BLOCKS: usize = 10;
/// Least number of spans from which constants are found: two for each block.
pub const LEAST_SPANS: usize = 2 * N_BLOCKS;
/// Steps of the fit that minimises the sum of absolute residuals: each weighs rows by one over their residual before.
const ABSOLUTE_STEPS: usize = 30;
/// Greatest residual of a span that is kept, in standard deviations of the residuals, and the ratio of a normal distribution's standard deviation to
/// its median magnitude.
const KEPT_DEVIATIONS: f64 = 4.0;
const DEVIATION_BY_MEDIAN: f64 = 1.4826;
/// Greatest ratio by which the other constants may raise the variance of one. Beyond it the drive does not tell them apart.
const MOST_INFLATION: f64 = 1e4;

/// The rows of one span, each with its coefficients and its right side.
#[derive(Clone, Debug, PartialEq)]
pub struct Span<const N: usize> {
    /// Time at which the span begins and ends.
    pub span_s: [f64; 2],
    /// Coefficients aₖ and right side b of each row, all rows of all spans in the same unit.
    pub rows: Vec<([f64; N], f64)>,
}

/// Constants of a robot, as a drive tells them.
#[derive(Clone, Debug, PartialEq)]
pub struct Constants<const N: usize> {
    /// The constants that fit the spans that are kept, by least squares.
    pub values: [f64; N],
    /// Standard deviation of each constant, by the jackknife.
    pub deviations: [f64; N],
    /// Root mean square residual of the rows that are kept.
    pub rms: f64,
    /// Spans that were set aside, each as its place in the list of spans and its greatest residual.
    pub set_aside: Vec<(usize, f64)>,
}

/// Why a drive does not tell the constants.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Undetermined {
    /// The drive has only so many spans, fewer than [`LEAST_SPANS`].
    FewSpans(usize),
    /// Other values of this constant, by its place, would do as well.
    Constant(usize),
}

/// The constants that fit most of a drive's spans. Spans whose residuals are at most `never_aside` are kept in any case: so far off may any of them be,
/// as the true poses are no better.
pub fn constants<const N: usize>(spans: &[Span<N>], never_aside: f64) -> Result<Constants<N>, Undetermined> {
    if spans.len() < LEAST_SPANS {
        return Err(Undetermined::FewSpans(spans.len()));
    }
    let residual = |values: &SVector<f64, N>, span: &Span<N>| {
        let off = |(row, right): &([f64; N], f64)| (SVector::from(*row).dot(values) - right).abs();
        span.rows.iter().map(off).fold(0.0, f64::max)
    };
    let everything: Vec<(&Span<N>, f64)> = spans.iter().map(|span| (span, 1.0)).collect();
    let mut values = least_squares(&everything)?;
    // The least sum of magnitudes is hardly moved by a few spans that are far off.
    for _ in 0..ABSOLUTE_STEPS {
        let residuals: Vec<f64> = spans.iter().map(|span| residual(&values, span)).collect();
        let least = 1e-3 * median(&residuals) + f64::MIN_POSITIVE.sqrt();
        let weighted: Vec<(&Span<N>, f64)> =
            spans.iter().zip(&residuals).map(|(span, off)| (span, 1.0 / off.max(least))).collect();
        values = least_squares(&weighted)?;
    }
    let residuals: Vec<f64> = spans.iter().map(|span| residual(&values, span)).collect();
    let greatest = spans.iter().flat_map(|span| &span.rows).map(|(_, right)| right.abs()).fold(0.0, f64::max);
    // Rounding is no residual.
    let most = KEPT_DEVIATIONS * DEVIATION_BY_MEDIAN * median(&residuals) + 1e-12 * greatest;
    let most = most.max(never_aside);
    let (mut kept, mut set_aside) = (Vec::new(), Vec::new());
    for (place, (span, off)) in spans.iter().zip(&residuals).enumerate() {
        if *off <= most { kept.push((span, 1.0)) } else { set_aside.push((place, *off)) }
    }
    if kept.len() < LEAST_SPANS {
        return Err(Undetermined::FewSpans(kept.len()));
    }
    let values = least_squares(&kept)?;
    let without: Vec<SVector<f64, N>> = (0..N_BLOCKS)
        .map(|block| {
            let is_left_out = |place: usize| place * N_BLOCKS / kept.len() == block;
            let others = kept.iter().enumerate().filter(|(place, _)| !is_left_out(*place));
            least_squares(&others.map(|(_, one)| *one).collect::<Vec<_>>())
        })
        .collect::<Result<_, _>>()?;
    let mean = without.iter().sum::<SVector<f64, N>>() / N_BLOCKS as f64;
    let squares: SVector<f64, N> = without.iter().map(|one| (one - mean).map(|off| off * off)).sum();
    let scale = (N_BLOCKS - 1) as f64 / N_BLOCKS as f64;
    let rows = || kept.iter().flat_map(|(span, _)| &span.rows);
    let sum: f64 = rows().map(|(row, right)| (SVector::from(*row).dot(&values) - right).powi(2)).sum();
    Ok(Constants {
        values: values.into(),
        deviations: squares.map(|sum| (scale * sum).sqrt()).into(),
        rms: (sum / rows().count() as f64).sqrt(),
        set_aside,
    })
}

/// The solution by weighted least squares.
fn least_squares<const N: usize>(spans: &[(&Span<N>, f64)]) -> Result<SVector<f64, N>, Undetermined> {
    let (mut normal, mut right) = (SMatrix::<f64, N, N>::zeros(), SVector::<f64, N>::zeros());
    for (span, weight) in spans {
        for (row, value) in &span.rows {
            let row = SVector::from(*row);
            normal += *weight * row * row.transpose();
            right += *weight * *value * row;
        }
    }
    // Constants have different units: each is scaled so that its own part of the matrix is one.
    let scale = normal.diagonal().map(|square| 1.0 / square.sqrt());
    if let Some(place) = (0..N).find(|place| !scale[*place].is_finite()) {
        return Err(Undetermined::Constant(place));
    }
    let scaled = SMatrix::<f64, N, N>::from_fn(|row, column| normal[(row, column)] * scale[row] * scale[column]);
    let inverse = scaled.try_inverse().ok_or(Undetermined::Constant(N - 1))?;
    let inflated = (0..N).max_by(|a, b| inverse[(*a, *a)].abs().total_cmp(&inverse[(*b, *b)].abs()));
    let is_told = |place: &usize| inverse[(*place, *place)].abs() < MOST_INFLATION;
    if let Some(place) = inflated.filter(|place| !is_told(place)) {
        return Err(Undetermined::Constant(place));
    }
    Ok((inverse * right.component_mul(&scale)).component_mul(&scale))
}

fn median(values: &[f64]) -> f64 {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    sorted.get(sorted.len() / 2).copied().unwrap_or_default()
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;
    use crate::vision::synthetic::Random;

    /// Spans of 1 s with one row each: x₀·a + x₁ = b, with noise on b, in the first of which `n_off` rows are far off to one side.
    fn spans(constants: [f64; 2], n_spans: usize, noise: f64, n_off: usize, random: &mut Random) -> Vec<Span<2>> {
        (0..n_spans)
            .map(|place| {
                let a = random.between(-1.0, 1.0);
                let off = if place < n_off { 5.0 } else { 0.0 };
                let right = constants[0] * a + constants[1] + random.between(-noise, noise) + off;
                Span { span_s: [place as f64, place as f64 + 1.0], rows: vec![([a, 1.0], right)] }
            })
            .collect()
    }

    #[test]
    fn constants_lie_within_four_of_their_deviations_in_nearly_all_drives() {
        // For noise that is uniform within ±n, a constant of m rows has the deviation n/√(3m), divided by the root mean square of its coefficients:
        // here 0.01/√300 = 0.00058 for the second one, and √3 of that for the first.
        let mut random = Random::new(3);
        let (mut n_within, mut deviations) = (0, [0.0; 2]);
        for _ in 0..500 {
            let truth = [random.between(-2.0, 2.0), random.between(-2.0, 2.0)];
            let found = constants(&spans(truth, 100, 0.01, 0, &mut random), 0.0).unwrap();
            let is_within = |axis: usize| (found.values[axis] - truth[axis]).abs() < 4.0 * found.deviations[axis];
            n_within += usize::from(is_within(0) && is_within(1));
            deviations = [0, 1].map(|axis| deviations[axis] + found.deviations[axis] / 500.0);
        }
        assert!(n_within >= 490, "{n_within} of 500");
        assert!(
            (deviations[1] / 0.000_577 - 1.0).abs() < 0.1 && (deviations[0] / 0.001 - 1.0).abs() < 0.1,
            "{deviations:?}"
        );
    }

    #[test]
    fn spans_that_are_far_off_are_set_aside_by_name_and_move_nothing() {
        let mut random = Random::new(4);
        for _ in 0..100 {
            let found = constants(&spans([0.7, -0.2], 100, 0.01, 30, &mut random), 0.0).unwrap();
            let places: Vec<usize> = found.set_aside.iter().map(|(place, _)| *place).collect();
            assert_eq!(places, (0..30).collect::<Vec<_>>());
            assert!(found.set_aside.iter().all(|(_, off)| (off - 5.0).abs() < 0.1));
            assert!((found.values[0] - 0.7).abs() < 0.01 && (found.values[1] + 0.2).abs() < 0.01, "{found:?}");
            let kept = constants(&spans([0.7, -0.2], 100, 0.01, 30, &mut random), 5.5).unwrap();
            assert!(kept.set_aside.is_empty() && kept.values[1] > 1.0, "{kept:?}");
            // Noise that is uniform within ±0.01 has a root mean square of 0.01/√3.
            assert!((found.rms / 0.005_77 - 1.0).abs() < 0.2, "{found:?}");
        }
    }

    #[test]
    fn what_a_drive_does_not_tell_is_named() {
        let with = |row: fn(f64) -> [f64; 2]| -> Vec<Span<2>> {
            (0..30).map(|place| Span { span_s: [0.0; 2], rows: vec![(row(f64::from(place)), 1.0)] }).collect()
        };
        assert_eq!(constants(&with(|at| [at, 0.0]), 0.0), Err(Undetermined::Constant(1)));
        assert!(matches!(constants(&with(|at| [at, 2.0 * at]), 0.0), Err(Undetermined::Constant(_))));
        assert!(constants(&with(|at| [at, 1.0]), 0.0).is_ok());
        assert_eq!(constants(&with(|at| [at, 1.0])[..19], 0.0), Err(Undetermined::FewSpans(19)));
    }
}

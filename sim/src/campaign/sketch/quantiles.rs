//! Quantiles of any number of values in memory that does not grow with that number.

use std::collections::BTreeMap;

/// Greatest relative error of a quantile.
pub(super) const ACCURACY: f64 = 0.01;

/// Values below this are counted as zero, so that no rounding error gets a bin of its own.
const LEAST: f64 = 1e-12;

/// A histogram with logarithmic bins: Masson, Rim and Lee, *DDSketch: a fast and fully-mergeable quantile sketch with relative-error guarantees*,
/// PVLDB 12 (2019), section 2.
///
/// A value x > 0 is counted in the bin i = ⌈log_γ x⌉ with γ = (1 + α) / (1 − α) and the accuracy α. The bin is told as 2 γⁱ / (γ + 1), which differs
/// from each of its values by at most α times that value. The counts do not depend on the order of the values.
#[derive(Clone, Debug, Default)]
pub(super) struct Quantiles {
    /// Number of values in each bin, bins of negative values by the negative of their bin's place first: (sign, place).
    counts: BTreeMap<(i8, i32), u64>,
    n: u64,
    extremes: Option<[f64; 2]>,
}

impl Quantiles {
    /// Counts one more value. What is not a number is left out.
    pub(super) fn add(&mut self, value: f64) {
        if !value.is_finite() {
            return;
        }
        let place = || (value.abs().ln() / gamma().ln()).ceil() as i32;
        let bin = match value {
            value if value >= LEAST => (1, place()),
            // The order of the bins is that of their values: of negative values those with the greatest amount come first.
            value if value <= -LEAST => (-1, -place()),
            _ => (0, 0),
        };
        *self.counts.entry(bin).or_default() += 1;
        self.n += 1;
        let [least, greatest] = self.extremes.unwrap_or([value; 2]);
        self.extremes = Some([least.min(value), greatest.max(value)]);
    }

    /// Returns the value that a share `q` of the values does not exceed; the extremes, at 0 and 1, are exact. `None` when there is no value.
    pub(super) fn quantile(&self, q: f64) -> Option<f64> {
        let [least, greatest] = self.extremes?;
        let rank = (q * (self.n - 1) as f64).floor() as u64;
        if rank == 0 {
            return Some(least);
        }
        if rank == self.n - 1 {
            return Some(greatest);
        }
        let mut below = 0;
        let bin = self.counts.iter().find(|(_, count)| {
            below += **count;
            below > rank
        });
        let value = |(sign, place): (i8, i32)| {
            let exponent = if sign < 0 { -place } else { place };
            f64::from(sign) * 2.0 * gamma().powi(exponent) / (gamma() + 1.0)
        };
        // A bin may reach beyond the extremes.
        Some(bin.map_or(greatest, |(bin, _)| value(*bin)).clamp(least, greatest))
    }
}

fn gamma() -> f64 {
    (1.0 + ACCURACY) / (1.0 - ACCURACY)
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;

    /// Asserts that the quantiles of some values are those of the sorted values, within the accuracy.
    fn check(mut values: Vec<f64>) {
        let mut quantiles = Quantiles::default();
        values.iter().for_each(|value| quantiles.add(*value));
        values.sort_by(f64::total_cmp);
        for q in [0.0, 0.01, 0.3, 0.5, 0.77, 0.99, 1.0] {
            let expected = values[(q * (values.len() - 1) as f64).floor() as usize];
            let found = quantiles.quantile(q).unwrap();
            assert!(
                (found - expected).abs() <= 1.000_001 * ACCURACY * expected.abs() + LEAST,
                "{q}: {found} {expected}"
            );
        }
    }

    #[test]
    fn quantiles_are_within_one_percent_over_eighteen_decades() {
        check((0..10_000).map(|step| 10_f64.powf(f64::from(step * 7919 % 10_000) / 555.0 - 9.0)).collect());
    }

    #[test]
    fn negative_values_and_zeros_are_in_order() {
        check((0..1001).map(|step| f64::from(step) - 500.0).collect());
        check(vec![-3.0, 0.0, 0.0, 2.0]);
        check(vec![7.0]);
    }

    #[test]
    fn what_is_no_number_is_not_counted() {
        let mut quantiles = Quantiles::default();
        quantiles.add(f64::NAN);
        assert_eq!(quantiles.quantile(0.5), None);
        quantiles.add(2.0);
        assert_eq!(quantiles.quantile(0.5), Some(2.0));
    }
}

//! Which samples are drawn anew, and how many.

/// Least and greatest number of samples. AMCL's greatest is the same; its least, 100, is too few for the covariance of three quantities.
pub(super) const N_SAMPLES: [usize; 2] = [200, 5000];
/// Sides of the bins of poses by which the spread of the samples is measured: about what the sensors resolve. AMCL's bins of 0.5 m are for range
/// scans; joints and markers tell the pose to a few millimetres and milliradians, and with coarser bins too few samples are near enough to what they
/// tell.
const BIN: [f64; 3] = [0.002, 0.002, 0.002];
/// Greatest Kullback-Leibler distance of the samples from the distribution that they stand for, and the normal quantile of the probability of 99 %
/// with which it is kept; both as in Fox (2003), section 4.
const KLD_ERROR: f64 = 0.05;
const KLD_QUANTILE: f64 = 2.326;

/// Indices of `n_drawn` samples by low-variance resampling: the samples at equal steps along the sum of the weights, from a random share of one step
/// on.
pub(super) fn low_variance(weights: &[f64], total: f64, n_drawn: usize, share: f64) -> Vec<usize> {
    let step = total / n_drawn as f64;
    let (mut index, mut sum) = (0, weights.first().copied().unwrap_or(0.0));
    let draw = |drawn: usize| {
        let at = (drawn as f64 + share) * step;
        while sum < at && index + 1 < weights.len() {
            index += 1;
            sum += weights[index];
        }
        index
    };
    (0..n_drawn).map(draw).collect()
}

/// Number of bins of poses that these poses occupy.
pub(super) fn n_bins(poses: impl Iterator<Item = [f64; 3]>) -> usize {
    let bin = |pose: [f64; 3]| [0, 1, 2].map(|axis: usize| (pose[axis] / BIN[axis]).floor() as i64);
    let mut bins: Vec<[i64; 3]> = poses.map(bin).collect();
    bins.sort_unstable();
    bins.dedup();
    bins.len()
}

/// Number of samples with which their Kullback-Leibler distance from the distribution stays within its bound, for samples in `n_bins` bins: eq. 8 of
/// Fox (2003).
pub(super) fn n_by_kld(n_bins: usize) -> usize {
    let free = n_bins.saturating_sub(1) as f64;
    if free == 0.0 {
        return N_SAMPLES[0];
    }
    let part = 2.0 / (9.0 * free);
    let n_samples = free / (2.0 * KLD_ERROR) * (1.0 - part + part.sqrt() * KLD_QUANTILE).powi(3);
    (n_samples.ceil() as usize).clamp(N_SAMPLES[0], N_SAMPLES[1])
}

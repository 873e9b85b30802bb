//! The samples of the particle filter: how they are moved, weighed and drawn anew.

use localizer::PoseBox;
use nalgebra::{SMatrix, SVector};
use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

use crate::subject::cues::{Mounted, SIGMAS_OF_BOUND};

use super::{
    odometry::{Errors, N_LASTING, Way},
    resampling::{N_SAMPLES, low_variance, n_bins, n_by_kld},
};

/// Samples of the pose, and the random numbers by which they are drawn.
pub(crate) struct Cloud {
    pub(crate) samples: Vec<Sample>,
    rng: ChaCha8Rng,
}

/// Standard deviations of the errors that stay the same all the time.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Constants {
    /// That of the gyroscope's bias; 0 without a gyroscope.
    pub(crate) bias_rad_per_s: f64,
    /// Those of the mounts of the devices of [`Mounted::ALL`]: forward, left and yaw; 0 for a device that there is not.
    pub(crate) mounts: [[f64; 3]; Mounted::ALL.len()],
}

/// One sample of the pose.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Sample {
    pub(crate) pose: [f64; 3],
    /// Errors of the motion since its stamp.
    pub(crate) errors: Errors,
    /// Logarithm of the weight; that of the greatest weight is 0.
    pub(crate) log_weight: f64,
}

/// Share of the samples that have to have a say for the samples to be kept as they are: below half, they are drawn anew (Doucet, *On sequential
/// simulation-based methods for Bayesian filtering*, 1998).
const EFFECTIVE_SHARE: f64 = 0.5;
/// Share of the samples that a measurement may leave with a say before they are drawn anew and weighed by the rest of it.
const LEFT_SHARE: f64 = 0.25;
/// Greatest number of parts in which a measurement is weighed: a start known to half a metre needs four or five until a position to the millimetre.
const MOST_PARTS: usize = 20;
/// Number of halvings by which the part of a measurement is found that leaves enough samples.
const HALVINGS: usize = 30;
/// Half width of a start's heading beyond which the heading is unknown, and its samples are even instead of Gaussian.
const UNKNOWN_RAD: f64 = 1.5;
/// Standard deviation of the kernel with which samples that are drawn anew are spread, over that of all samples, so that a sample drawn many times does
/// not stay one (C. Musso, N. Oudjane, F. Le Gland, *Improving regularised particle filters*, 2001). Errors, and poses of one cluster, are drawn
/// towards their mean by as much, so that their mean and variance stay as they are (J. Liu, M. West, *Combined parameter and state estimation in
/// simulation-based filtering*, 2001). The value belongs to a discount of 0.95, the smaller end of those that Liu and West recommend. With the greater
/// end, 0.99 or a kernel of 0.1, the offspring of the few samples that a first accurate measurement leaves stay apart, and chance decides how wide
/// their errors are spread.
const KERNEL: f64 = 0.228;
/// The same for poses of several clusters, which would be washed out by a wider kernel, as all of them together are spread widely.
const KERNEL_OF_CLUSTERS: f64 = 0.1;
/// Standard deviations of x, y and heading below which the poses form one cluster: about a quarter of a small tile's side, and an eighth of a quarter
/// turn, as poses that are told apart by joints and walls alone may be off by a tile or by a quarter turn.
const ONE_CLUSTER: [f64; POSE] = [0.07, 0.07, 0.2];
/// Share of its variance that each quantity has on its own at the least, so that the covariance of samples of which two quantities are tied is definite.
const LEAST_OWN: f64 = 1e-9;

/// Number of coordinates of the pose, the first quantities of a sample.
const POSE: usize = 3;
/// Number of quantities of a sample: its pose, the gyroscope's bias, the errors that last, and those of the mounts.
const N_QUANTITIES: usize = POSE + 1 + N_LASTING + POSE * Mounted::ALL.len();
type Quantities = SVector<f64, N_QUANTITIES>;

impl Sample {
    fn quantities(&self) -> Quantities {
        let Errors { bias_rad_per_s, lasting, mounts, .. } = &self.errors;
        let all = self.pose.iter().chain([bias_rad_per_s]).chain(lasting).chain(mounts.iter().flatten());
        Quantities::from_iterator(all.copied())
    }

    fn set_quantities(&mut self, quantities: &Quantities) {
        let Errors { bias_rad_per_s, lasting, mounts, .. } = &mut self.errors;
        let all = self.pose.iter_mut().chain([bias_rad_per_s]).chain(lasting).chain(mounts.iter_mut().flatten());
        all.zip(quantities).for_each(|(value, quantity)| *value = *quantity);
    }
}

impl Cloud {
    pub(crate) fn new(rng: ChaCha8Rng) -> Cloud {
        Cloud { samples: Vec::new(), rng }
    }

    /// Draws the samples of a start somewhere in a box, whose half widths are bounds.
    pub(crate) fn draw_start(&mut self, start: &PoseBox, constants: &Constants) {
        let rng = &mut self.rng;
        let draw = |rng: &mut ChaCha8Rng, axis: usize| {
            let (middle, half) = (start[axis].mid(), 0.5 * start[axis].width());
            if axis == 2 && half > UNKNOWN_RAD {
                return middle + half * rng.random_range(-1.0..=1.0);
            }
            let normal: f64 = StandardNormal.sample(rng);
            middle + SIGMAS_OF_BOUND * half * normal
        };
        let sample = |_| {
            let pose = [0, 1, 2].map(|axis| draw(rng, axis));
            Sample { pose, errors: drawn(rng, constants), log_weight: 0.0 }
        };
        self.samples = (0..N_SAMPLES[1]).map(sample).collect();
        self.samples.truncate(n_by_kld(n_bins(self.samples.iter().map(|sample| sample.pose))));
    }

    /// Carries the samples on along a way, each with its own error of it.
    pub(crate) fn carry(&mut self, way: &Way) {
        let rng = &mut self.rng;
        for sample in &mut self.samples {
            sample.pose = way.from(sample.pose, &sample.errors);
            for (index, error) in sample.errors.lasting.iter_mut().enumerate() {
                let kept = way.kept(index);
                if kept < 1.0 {
                    let normal: f64 = StandardNormal.sample(rng);
                    *error = kept * *error + (1.0 - kept * kept).sqrt() * normal;
                }
            }
        }
        self.draw_new_errors();
    }

    /// Weighted mean of a quantity over the samples.
    pub(crate) fn mean_of(&self, of: &dyn Fn(&Sample) -> f64) -> f64 {
        let total: f64 = self.samples.iter().map(|sample| sample.log_weight.exp()).sum();
        self.samples.iter().map(|sample| sample.log_weight.exp() * of(sample)).sum::<f64>() / total
    }

    /// Weighs the samples by a measurement, given the logarithm of its likelihood.
    ///
    /// A measurement that is far more accurate than the samples are dense would leave a few of them by chance. It is therefore weighed in parts, its
    /// likelihood raised to powers that add up to 1, and after each part that leaves too few samples they are drawn anew (progressive correction: Musso,
    /// Oudjane and Le Gland 2001, section 12.4).
    pub(crate) fn weigh(&mut self, log_likelihood: &dyn Fn(&Sample) -> f64) {
        let mut left = 1.0;
        for part in 1..=MOST_PARTS {
            let told: Vec<f64> = self.samples.iter().map(log_likelihood).collect();
            let power = if part == MOST_PARTS { left } else { self.bearable_power(&told, left) };
            left -= power;
            self.samples.iter_mut().zip(&told).for_each(|(sample, told)| sample.log_weight += power * told);
            let most = self.samples.iter().map(|sample| sample.log_weight).fold(f64::NEG_INFINITY, f64::max);
            self.samples.iter_mut().for_each(|sample| sample.log_weight -= most);
            if self.effective_share(&told, 0.0) < EFFECTIVE_SHARE {
                self.resample();
            }
            if left <= 0.0 {
                break;
            }
        }
    }

    /// Puts samples with poses by `draw` and with a bias as at the start in the place of a share of the samples; `forth` is the way since those poses.
    pub(crate) fn replace(
        &mut self,
        share: f64,
        constants: &Constants,
        forth: &Way,
        draw: &dyn Fn(&mut ChaCha8Rng, [f64; 3]) -> [f64; 3],
    ) {
        for sample in &mut self.samples {
            if self.rng.random::<f64>() >= share {
                continue;
            }
            sample.errors = drawn(&mut self.rng, constants);
            sample.pose = forth.from(draw(&mut self.rng, sample.pose), &sample.errors);
        }
    }

    /// Greatest power of a likelihood, up to `most`, that leaves enough samples with a say.
    fn bearable_power(&self, told: &[f64], most: f64) -> f64 {
        if self.effective_share(told, most) >= LEFT_SHARE {
            return most;
        }
        let (mut bearable, mut too_great) = (0.0, most);
        for _ in 0..HALVINGS {
            let middle = 0.5 * (bearable + too_great);
            if self.effective_share(told, middle) >= LEFT_SHARE { bearable = middle } else { too_great = middle }
        }
        too_great
    }

    /// Share of the samples that have a say when they are weighed by a power of a likelihood: (Σw)² / Σw², over their number.
    fn effective_share(&self, told: &[f64], power: f64) -> f64 {
        let logs: Vec<f64> =
            self.samples.iter().zip(told).map(|(sample, told)| sample.log_weight + power * told).collect();
        let most = logs.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let (sum, squares) = logs
            .iter()
            .map(|log| (log - most).exp())
            .fold((0.0, 0.0), |(sum, squares), weight| (sum + weight, squares + weight * weight));
        sum * sum / squares / self.samples.len() as f64
    }

    /// Draws the samples anew by their weights: as many as the number of bins asks for that a first drawing occupies.
    fn resample(&mut self) {
        let weights: Vec<f64> = self.samples.iter().map(|sample| sample.log_weight.exp()).collect();
        let total = weights.iter().sum();
        let trial = low_variance(&weights, total, self.samples.len(), self.rng.random());
        let n_samples = n_by_kld(n_bins(trial.iter().map(|index| self.samples[*index].pose)));
        let drawn = low_variance(&weights, total, n_samples, self.rng.random());
        self.samples = drawn.into_iter().map(|index| Sample { log_weight: 0.0, ..self.samples[index] }).collect();
        self.spread();
        self.draw_new_errors();
    }

    /// Spreads samples that have been drawn anew by a kernel of the shape of the covariance that all their quantities have together, so that what a
    /// pose tells of the errors of mounts and sensors is kept.
    fn spread(&mut self) {
        let n_samples = self.samples.len() as f64;
        let quantities: Vec<Quantities> = self.samples.iter().map(Sample::quantities).collect();
        let mean = quantities.iter().sum::<Quantities>() / n_samples;
        let mut covariance = SMatrix::<f64, N_QUANTITIES, N_QUANTITIES>::zeros();
        for off in quantities.iter().map(|quantities| quantities - mean) {
            covariance.ger(1.0 / n_samples, &off, &off, 1.0);
        }
        // A quantity that no sample varies, such as the mount of a device that there is not, has no kernel and draws no random numbers.
        let varies: [bool; N_QUANTITIES] = std::array::from_fn(|quantity| covariance[(quantity, quantity)] > 0.0);
        for quantity in 0..N_QUANTITIES {
            let variance = covariance[(quantity, quantity)];
            covariance[(quantity, quantity)] = variance * (1.0 + LEAST_OWN) + f64::MIN_POSITIVE;
        }
        let are_one_cluster = (0..POSE).all(|axis| covariance[(axis, axis)] < ONE_CLUSTER[axis].powi(2));
        let Some(root) = covariance.cholesky().map(|root| root.l()) else { return };
        let kernel = if are_one_cluster { KERNEL } else { KERNEL_OF_CLUSTERS };
        let kept = (1.0 - kernel * kernel).sqrt();
        for (sample, quantities) in self.samples.iter_mut().zip(&quantities) {
            let normal = Quantities::from_fn(
                |quantity, _| {
                    if varies[quantity] { StandardNormal.sample(&mut self.rng) } else { 0.0 }
                },
            );
            let off = root * normal * kernel;
            let mut spread = mean + (quantities - mean) * kept + off;
            // Poses that form several clusters are not drawn together.
            if !are_one_cluster {
                (0..POSE).for_each(|axis| spread[axis] = quantities[axis] + off[axis]);
            }
            sample.set_quantities(&spread);
        }
    }

    fn draw_new_errors(&mut self) {
        let rng = &mut self.rng;
        self.samples.iter_mut().for_each(|sample| sample.errors.new = [0; 3].map(|_| StandardNormal.sample(rng)));
    }
}

/// Errors of the motion of a sample of which nothing is known yet.
fn drawn(rng: &mut ChaCha8Rng, constants: &Constants) -> Errors {
    let normal: f64 = StandardNormal.sample(rng);
    Errors {
        bias_rad_per_s: constants.bias_rad_per_s * normal,
        mounts: constants.mounts.map(|sigma| {
            sigma.map(|sigma| {
                // A device that there is not draws no random numbers, so that a new kind of device changes nothing for robots without it.
                let normal: f64 = if sigma > 0.0 { StandardNormal.sample(rng) } else { 0.0 };
                sigma * normal
            })
        }),
        lasting: [0; N_LASTING].map(|_| StandardNormal.sample(rng)),
        new: [0; 3].map(|_| StandardNormal.sample(rng)),
    }
}

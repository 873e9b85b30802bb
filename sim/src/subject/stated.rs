//! What a tested localizer states of the pose when it answers with a distribution: mean, covariance, and the regions that hold given shares.

use std::{f64::consts::PI, sync::LazyLock};

use localizer::Pose;
use nalgebra::{Matrix3, Vector2, Vector3};
use statrs::distribution::{ChiSquared, ContinuousCDF};

use super::{Answer, GaussianPose, WeightedPose, mean_of};

/// Shares of the distribution for which it is judged how often the region that holds the share holds the truth.
pub const SHARES: [f64; 5] = [0.5, 0.9, 0.95, 0.99, 0.997];

/// Index of 95 % in [`SHARES`].
const SHARE_95: usize = 2;

/// Least pivot in the Cholesky decomposition of a correlation matrix that counts as positive: 1 less the squared multiple correlation of a coordinate
/// with those before it. Below it the numbers of a covariance matrix, which have some 16 digits, do not determine its inverse.
const LEAST_PIVOT: f64 = 1e-12;

/// Greatest difference of two correlations that the symmetry of a covariance matrix makes equal; a filter's rounding errors stay far below.
const SYMMETRY: f64 = 1e-6;

/// What an answer states that is a distribution of the pose.
#[derive(Clone, Debug, PartialEq)]
pub struct Stated {
    /// Mean of the distribution.
    pub mean: Pose,
    /// The distribution about its mean; `None` if the covariance is not finite, not symmetric or not positive definite, so that no region follows
    /// from it.
    pub spread: Option<Spread>,
}

/// How a distribution of the pose spreads about its mean.
#[derive(Clone, Debug, PartialEq)]
pub struct Spread {
    /// Covariance of x, y and heading, in m², m·rad and rad².
    pub covariance: Matrix3<f64>,
    /// For each of [`SHARES`] the squared Mahalanobis distance from the mean below which this share of the distribution lies. The region that holds
    /// the share is the ellipsoid of the poses up to this distance.
    pub squared_radii: [f64; 5],
    /// Full widths in x, y and heading of the central intervals that hold 95 % of the distribution along each axis.
    pub width_95: [f64; 3],
    /// Area of the ellipse in the plane that holds 95 % of the distribution of x and y.
    pub area_95_m2: f64,
}

impl Stated {
    /// What an answer states that is a distribution; `None` for boxes and points.
    ///
    /// The regions of a Gaussian are those of its covariance. The regions of a sample are ellipsoids of the shape of the sample's covariance, as
    /// large as needed to hold the share of the sample's weight.
    pub fn of(answer: &Answer) -> Option<Stated> {
        match answer {
            Answer::Boxes(_) | Answer::Point(_) => None,
            Answer::Gaussian(gaussian) => Some(of_gaussian(gaussian)),
            Answer::Samples(samples) => Some(of_samples(samples)),
        }
    }

    /// The mean less `truth`; the heading by the turn of at most half a circle.
    pub fn error(&self, truth: Pose) -> Vector3<f64> {
        deviation(self.mean, truth)
    }
}

impl Spread {
    /// Squared Mahalanobis distance eᵀ P⁻¹ e of an error, the normalised estimation error squared (NEES; Bar-Shalom, Li and Kirubarajan 2001,
    /// eq. 5.4.2-2).
    pub fn squared_distance(&self, error: &Vector3<f64>) -> f64 {
        squared_distance(&self.covariance, error).unwrap_or(f64::INFINITY)
    }

    /// Whether the region that holds 95 % of the distribution holds a pose that is off the mean by this error.
    pub fn holds_at_95(&self, error: &Vector3<f64>) -> bool {
        self.squared_distance(error) <= self.squared_radii[SHARE_95]
    }

    /// Corners of a polygon along the ellipse in the plane that holds 95 % of the distribution of x and y, relative to the mean, in metres.
    pub fn ellipse_95_m(&self) -> Vec<[f64; 2]> {
        const CORNERS: usize = 48;
        // The lower triangular root of a positive definite matrix takes the unit circle to the ellipse of Mahalanobis distance 1.
        let plane = self.covariance.fixed_view::<2, 2>(0, 0).into_owned();
        let root = plane.cholesky().map(|root| root.l()).unwrap_or_default();
        let radius = (self.area_95_m2 / unit_area_m2(&self.covariance)).sqrt();
        let corner = |index: usize| {
            let (sin, cos) = (2.0 * PI * index as f64 / CORNERS as f64).sin_cos();
            let off_m = root * Vector2::new(cos, sin) * radius;
            [off_m.x, off_m.y]
        };
        (0..CORNERS).map(corner).collect()
    }

    /// Full widths of the intervals of three standard deviations to both sides of the mean, in x, y and heading.
    pub fn width_3_sigma(&self) -> [f64; 3] {
        [0, 1, 2].map(|axis| 6.0 * self.covariance[(axis, axis)].sqrt())
    }

    /// Area of the ellipse in the plane up to the Mahalanobis distance 3.
    pub fn area_3_sigma_m2(&self) -> f64 {
        9.0 * unit_area_m2(&self.covariance)
    }
}

/// Quantile of the χ² distribution with `degrees` of freedom, at least 1: the value that a draw stays below with probability `share`, 0 < share < 1.
pub fn chi_squared(share: f64, degrees: f64) -> f64 {
    // The library gives an error only for degrees of freedom that are not above 0, which does not occur here.
    ChiSquared::new(degrees).map_or(f64::NAN, |distribution| distribution.inverse_cdf(share))
}

/// Squared Mahalanobis distances up to which a Gaussian in three dimensions holds each of [`SHARES`].
static GAUSSIAN_SQUARED_RADII: LazyLock<[f64; 5]> = LazyLock::new(|| SHARES.map(|share| chi_squared(share, 3.0)));

/// Squared Mahalanobis distance up to which a Gaussian in two dimensions holds 95 %: −2 ln 0.05.
static PLANE_95: LazyLock<f64> = LazyLock::new(|| -2.0 * 0.05_f64.ln());

/// Half the width, in standard deviations, of the interval about the mean that holds 95 % of a Gaussian.
static SIGMAS_95: LazyLock<f64> = LazyLock::new(|| chi_squared(0.95, 1.0).sqrt());

fn of_gaussian(gaussian: &GaussianPose) -> Stated {
    let covariance = Matrix3::from_fn(|row, column| gaussian.covariance[row][column]);
    let spread = usable(&covariance).map(|covariance| Spread {
        covariance,
        squared_radii: *GAUSSIAN_SQUARED_RADII,
        width_95: [0, 1, 2].map(|axis| 2.0 * *SIGMAS_95 * covariance[(axis, axis)].sqrt()),
        area_95_m2: *PLANE_95 * unit_area_m2(&covariance),
    });
    Stated { mean: gaussian.mean, spread: spread.filter(|_| is_finite(gaussian.mean)) }
}

fn of_samples(samples: &[WeightedPose]) -> Stated {
    let mean = mean_of(samples);
    let are_weights = samples.iter().all(|sample| sample.weight >= 0.0 && sample.weight.is_finite());
    let total: f64 = samples.iter().map(|sample| sample.weight).sum();
    let deviations: Vec<(Vector3<f64>, f64)> =
        samples.iter().map(|sample| (deviation(sample.pose, mean), sample.weight / total)).collect();
    let covariance: Matrix3<f64> = deviations.iter().map(|(off, share)| off * off.transpose() * *share).sum();
    let covariance = usable(&covariance).filter(|_| are_weights && is_finite(mean));
    Stated { mean, spread: covariance.map(|covariance| spread_of_samples(covariance, &deviations)) }
}

fn spread_of_samples(covariance: Matrix3<f64>, deviations: &[(Vector3<f64>, f64)]) -> Spread {
    let plane = covariance.fixed_view::<2, 2>(0, 0).into_owned();
    // The covariance is positive definite, and so is its part for x and y.
    let inverse = covariance.try_inverse().unwrap_or_else(Matrix3::zeros);
    let plane_inverse = plane.try_inverse().unwrap_or_default();
    let squared = |off: &Vector3<f64>| off.dot(&(inverse * off));
    let squared_in_plane = |off: &Vector3<f64>| off.xy().dot(&(plane_inverse * off.xy()));
    let by = |measure: &dyn Fn(&Vector3<f64>) -> f64| {
        let mut sorted: Vec<(f64, f64)> = deviations.iter().map(|(off, share)| (measure(off), *share)).collect();
        sorted.sort_by(|one, other| one.0.total_cmp(&other.0));
        sorted
    };
    let distances = by(&squared);
    let axes = [0, 1, 2].map(|axis: usize| by(&|off: &Vector3<f64>| off[axis]));
    Spread {
        covariance,
        squared_radii: SHARES.map(|share| quantile(&distances, share)),
        width_95: axes.map(|along| quantile(&along, 0.975) - quantile(&along, 0.025)),
        area_95_m2: quantile(&by(&squared_in_plane), SHARES[SHARE_95]) * unit_area_m2(&covariance),
    }
}

/// The least of the sorted values up to which at least `share` of the weight lies.
fn quantile(sorted: &[(f64, f64)], share: f64) -> f64 {
    let mut below = 0.0;
    for (value, weight) in sorted {
        below += weight;
        // A share of the weight is a sum of rounded numbers.
        if below >= share - 1e-12 {
            return *value;
        }
    }
    sorted.last().map_or(f64::NAN, |(value, _)| *value)
}

/// One pose less another, the heading by the turn of at most half a circle.
fn deviation(pose: Pose, from: Pose) -> Vector3<f64> {
    Vector3::new(pose.x_m - from.x_m, pose.y_m - from.y_m, half_turn(pose.heading_rad - from.heading_rad))
}

/// The turn of at most half a circle that ends where this turn does.
pub(crate) fn half_turn(turn_rad: f64) -> f64 {
    turn_rad - 2.0 * PI * (turn_rad / (2.0 * PI)).round()
}

fn is_finite(pose: Pose) -> bool {
    pose.to_array().into_iter().all(f64::is_finite)
}

/// The covariance made exactly symmetric, if it is finite, symmetric but for rounding, and positive definite.
fn usable(covariance: &Matrix3<f64>) -> Option<Matrix3<f64>> {
    let symmetric = (covariance + covariance.transpose()) * 0.5;
    let correlation = correlation(&symmetric)?;
    let sigma = symmetric.diagonal().map(f64::sqrt);
    let is_symmetric = (covariance - symmetric).component_div(&(sigma * sigma.transpose())).amax() <= SYMMETRY;
    let lower = correlation.cholesky()?.unpack();
    (is_symmetric && lower.diagonal().iter().all(|root| root * root > LEAST_PIVOT)).then_some(symmetric)
}

/// The correlation matrix of a covariance matrix; `None` where a variance is not a positive number or anything is not finite.
fn correlation(covariance: &Matrix3<f64>) -> Option<Matrix3<f64>> {
    let sigma = covariance.diagonal().map(f64::sqrt);
    let correlation = covariance.component_div(&(sigma * sigma.transpose()));
    (sigma.iter().all(|sigma| *sigma > 0.0) && correlation.iter().all(|value| value.is_finite())).then_some(correlation)
}

/// eᵀ P⁻¹ e, by way of the correlation matrix, whose numbers are of one size whatever the units are.
fn squared_distance(covariance: &Matrix3<f64>, error: &Vector3<f64>) -> Option<f64> {
    let scaled = error.component_div(&covariance.diagonal().map(f64::sqrt));
    let root = correlation(covariance)?.cholesky()?;
    Some(scaled.dot(&root.solve(&scaled)))
}

/// Area of the ellipse of x and y up to the Mahalanobis distance 1: π √det P.
fn unit_area_m2(covariance: &Matrix3<f64>) -> f64 {
    PI * covariance.fixed_view::<2, 2>(0, 0).determinant().max(0.0).sqrt()
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;

    fn gaussian(covariance: [[f64; 3]; 3]) -> Option<Spread> {
        let mean = Pose { x_m: 1.0, y_m: 2.0, heading_rad: 0.5 };
        of_gaussian(&GaussianPose { mean, covariance }).spread
    }

    #[test]
    fn each_corner_of_the_ellipse_has_the_distance_that_holds_95_percent_in_the_plane() {
        let spread = gaussian([[0.04, 0.012, 0.0], [0.012, 0.01, 0.0], [0.0, 0.0, 1e-4]]).unwrap();
        // The inverse of the covariance of x and y, whose determinant is 0.04 · 0.01 − 0.012² = 0.000256.
        let inverse = [[0.01 / 0.000256, -0.012 / 0.000256], [-0.012 / 0.000256, 0.04 / 0.000256]];
        for [x_m, y_m] in spread.ellipse_95_m() {
            let squared = inverse[0][0] * x_m * x_m + 2.0 * inverse[0][1] * x_m * y_m + inverse[1][1] * y_m * y_m;
            // χ² with two degrees of freedom stays below 5.991 with a probability of 95 %.
            assert!((squared - 5.9915).abs() < 1e-3, "{squared}");
        }
    }

    #[test]
    fn the_region_of_95_percent_reaches_to_the_quantile_of_three_degrees_of_freedom() {
        let spread = gaussian([[0.04, 0.0, 0.0], [0.0, 0.01, 0.0], [0.0, 0.0, 1e-4]]).unwrap();
        // √7.815 = 2.7955 standard deviations.
        assert!(spread.holds_at_95(&Vector3::new(0.2 * 2.79, 0.0, 0.0)));
        assert!(!spread.holds_at_95(&Vector3::new(0.2 * 2.80, 0.0, 0.0)));
        assert!(!spread.holds_at_95(&Vector3::new(0.2 * 2.0, 0.0, 0.01 * 2.0)));
    }
}

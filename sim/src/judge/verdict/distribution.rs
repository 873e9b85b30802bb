//! The figures of distributions that a localizer states.

use serde::Serialize;

use super::AxisWidth;

/// How well the distributions that a localizer states agree with the truth, over all steps at which it stated one.
#[derive(Clone, Debug, Default, Serialize)]
pub struct Distribution {
    /// Number of steps at which a distribution was stated.
    pub checks: usize,
    /// Number of these steps at which the covariance is not finite, not symmetric or not positive definite. They count as steps at which no stated
    /// region holds the truth, and are left out of everything else.
    pub unusable: usize,
    /// How often the truth is in the regions that hold given shares of the distribution.
    pub calibration: Calibration,
    /// Share of the steps with the truth within three standard deviations of the mean along x, y and heading at once: in the box that has the widths of
    /// `region_3_sigma`. For a Gaussian without correlations that is right, it is 99.19 %.
    pub within_3_sigma_share: f64,
    /// Normalised estimation error squared.
    pub nees: Nees,
    /// Size of the region that holds 95 %: along each axis the central interval of that share, in the plane the ellipse.
    pub region_95: Region,
    /// Size of the region of three standard deviations: along each axis three to both sides of the mean, in the plane the ellipse up to the
    /// Mahalanobis distance 3.
    pub region_3_sigma: Region,
}

/// Shares of the steps with the truth in the region that holds 50, 90, 95, 99 and 99.7 % of the stated distribution of x, y and heading.
#[derive(Clone, Debug, Default, Serialize)]
pub struct Calibration {
    /// Share of the steps with the truth in the region of 50 %.
    pub within_50: f64,
    /// Share of the steps with the truth in the region of 90 %.
    pub within_90: f64,
    /// Share of the steps with the truth in the region of 95 %.
    pub within_95: f64,
    /// Share of the steps with the truth in the region of 99 %.
    pub within_99: f64,
    /// Share of the steps with the truth in the region of 99.7 %.
    pub within_99_7: f64,
}

/// Normalised estimation error squared: eᵀ P⁻¹ e for the error e of x, y and heading and the stated covariance P. With the right covariance its mean is
/// 3; above, the localizer is overconfident, below, it states more doubt than it needs to.
#[derive(Clone, Debug, Default, Serialize)]
pub struct Nees {
    /// Mean over the steps.
    pub mean: f64,
    /// Greatest value at any step.
    pub max: f64,
    /// Share of the steps in the corridor that holds 95 % of χ² with 3 degrees of freedom. The errors of neighbouring steps are much the same, so that
    /// the share of one run may be far from 95 % by chance.
    pub in_corridor_share: f64,
    /// Share of the steps above that corridor, where the localizer is overconfident; 2.5 % are right.
    pub above_corridor_share: f64,
}

/// Size of the regions that a localizer states.
#[derive(Clone, Debug, Default, Serialize)]
pub struct Region {
    /// Full width along world x.
    pub x_m: AxisWidth,
    /// Full width along world y.
    pub y_m: AxisWidth,
    /// Full width in heading.
    pub heading_rad: AxisWidth,
    /// Mean area of the region in the plane.
    pub area_m2: f64,
}

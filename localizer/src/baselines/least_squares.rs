//! Rigid motion between two sets of matched points, by least squares.

use nalgebra::{Matrix2, Vector2};

use crate::Pose;

/// The pose (R, t) that minimises Σ |aᵢ − t − R·bᵢ|² over pairs of points (a in the world, b in the robot frame); `None` for fewer than two
/// pairs.
///
/// With both centroids subtracted, R = V·diag(1, det(V·Uᵀ))·Uᵀ by the singular value decomposition H = Σ b·aᵀ = U·Σ·Vᵀ: the determinant keeps a
/// noisy set from being mirrored. Source: D. Eggert, A. Lorusso, R. Fisher, Machine Vision and Applications 9 (1997), section 2.1.
pub fn least_squares(pairs: &[([f64; 2], [f64; 2])]) -> Option<Pose> {
    if pairs.len() < 2 {
        return None;
    }
    let n = pairs.len() as f64;
    let (a_mean, b_mean) = pairs.iter().fold((Vector2::zeros(), Vector2::zeros()), |(a_mean, b_mean), (a, b)| {
        (a_mean + Vector2::from(*a) / n, b_mean + Vector2::from(*b) / n)
    });
    let covariance = pairs.iter().fold(Matrix2::zeros(), |sum, (a, b)| {
        sum + (Vector2::from(*b) - b_mean) * (Vector2::from(*a) - a_mean).transpose()
    });
    let svd = covariance.svd(true, true);
    let (u, v) = (svd.u?, svd.v_t?.transpose());
    let handed = Matrix2::from_diagonal(&Vector2::new(1.0, (v * u.transpose()).determinant().signum()));
    let rotation = v * handed * u.transpose();
    let translation = a_mean - rotation * b_mean;
    Some(Pose { x_m: translation.x, y_m: translation.y, heading_rad: rotation[(1, 0)].atan2(rotation[(0, 0)]) })
}

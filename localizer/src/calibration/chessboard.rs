//! Calibration of a camera's intrinsics from views of a plane (Z. Zhang, *A flexible new technique for camera calibration*, TPAMI 22, 2000).
//!
//! Closed form: each view's homography H = K (r₁ r₂ t) gives h₁ᵀBh₂ = 0 and h₁ᵀBh₁ = h₂ᵀBh₂ for B = K⁻ᵀK⁻¹ (no skew). Then all reprojection errors
//! are minimised over K, the coefficients of Brown's lens model and the views' poses by Levenberg and Marquardt's method.

pub mod corners;
mod deviations;
mod refinement;

use nalgebra::{DMatrix, Matrix3, SMatrix, SVector, Vector3};

pub use deviations::{Deviations, deviations};
use refinement::refine;

/// A corner of the board: `[u, v]` in pixels and `[x, y]` on the board in metres.
pub type Corner = ([f64; 2], [f64; 2]);

/// A pinhole camera with Brown's lens model.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Intrinsics {
    /// Focal lengths along u and v.
    pub focal_px: [f64; 2],
    /// Principal point of the camera.
    pub centre_px: [f64; 2],
    /// Coefficients k1, k2, p1, p2 of the lens.
    pub distortion: [f64; 4],
}

/// Which lens coefficients the calibration solves for; the others are 0.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Bend {
    /// Radial coefficients k1 and k2, as in Zhang's paper. Tangential coefficients have nearly the same effect as a shifted principal point, which
    /// views of a board would then determine less well.
    Radial,
    /// Radial and tangential coefficients k1, k2, p1 and p2, for a lens whose elements are not centred.
    RadialAndTangential,
}

/// The camera that fits the views, and the residual of the fit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Calibration {
    /// The calibrated intrinsics of the camera.
    pub intrinsics: Intrinsics,
    /// Root mean square distance between the corners in the images and where the calibrated camera projects them.
    pub rms_px: f64,
}

/// Pose of a board: `point_in_camera = rotation · point_on_board + translation_m`.
#[derive(Clone, Copy, Debug)]
struct View {
    rotation: Matrix3<f64>,
    translation_m: Vector3<f64>,
}

/// Calibrates a camera from at least three views of at least four corners each, in different directions; `None` if they do not determine a camera.
pub fn calibrate(views: &[Vec<Corner>], bend: Bend) -> Option<Calibration> {
    if views.len() < 3 {
        return None;
    }
    let homographies: Vec<Matrix3<f64>> = views.iter().map(|view| homography(view)).collect::<Option<_>>()?;
    let (focal_px, centre_px) = closed_form(&homographies)?;
    let start = Intrinsics { focal_px, centre_px, distortion: [0.0; 4] };
    let poses = homographies.iter().map(|homography| board_pose(homography, &start)).collect::<Option<Vec<_>>>()?;
    refine(start, poses, views, bend)
}

/// Homography H with pixel ~ H (x, y, 1), by the direct linear transform on coordinates scaled to about one (R. Hartley, TPAMI 19, 1997).
fn homography(corners: &[Corner]) -> Option<Matrix3<f64>> {
    if corners.len() < 4 {
        return None;
    }
    let (to_pixels, to_board) =
        (scaling(corners.iter().map(|corner| corner.0)), scaling(corners.iter().map(|corner| corner.1)));
    let mut normal = SMatrix::<f64, 9, 9>::zeros();
    for (pixel, board) in corners {
        let scaled = |by: &Matrix3<f64>, at: &[f64; 2]| by * Vector3::new(at[0], at[1], 1.0);
        let (p, b) = (scaled(&to_pixels, pixel), scaled(&to_board, board));
        for (axis, at) in [p.x, p.y].into_iter().enumerate() {
            let mut row = SVector::<f64, 9>::zeros();
            for k in 0..3 {
                row[3 * axis + k] = b[k];
                row[6 + k] = -at * b[k];
            }
            normal += row * row.transpose();
        }
    }
    let solution = least_eigenvector(normal);
    let scaled = Matrix3::from_row_slice(solution.as_slice());
    let homography = to_pixels.try_inverse()? * scaled * to_board;
    (homography[(2, 2)].abs() > 1e-12).then(|| homography / homography[(2, 2)])
}

/// Transform that brings image or board points to mean 0 and mean square 2.
fn scaling(points: impl Iterator<Item = [f64; 2]> + Clone) -> Matrix3<f64> {
    let n = points.clone().count() as f64;
    let mean = points.clone().fold([0.0; 2], |sum, point| [sum[0] + point[0] / n, sum[1] + point[1] / n]);
    let square = points.map(|point| (point[0] - mean[0]).powi(2) + (point[1] - mean[1]).powi(2)).sum::<f64>() / n;
    let scale = (2.0 / square).sqrt();
    Matrix3::new(scale, 0.0, -scale * mean[0], 0.0, scale, -scale * mean[1], 0.0, 0.0, 1.0)
}

fn least_eigenvector<const N: usize>(matrix: SMatrix<f64, N, N>) -> SVector<f64, N> {
    let eigen = DMatrix::from_column_slice(N, N, matrix.as_slice()).symmetric_eigen();
    SVector::from_column_slice(eigen.eigenvectors.column(eigen.eigenvalues.imin()).as_slice())
}

/// Focal lengths and principal point from Zhang's two equations for each view.
fn closed_form(homographies: &[Matrix3<f64>]) -> Option<([f64; 2], [f64; 2])> {
    // Pixels are scaled by a unit of the order of the focal length, so that the numbers are of the order of one.
    const UNIT_PX: f64 = 500.0;
    let unit = Matrix3::new(1.0 / UNIT_PX, 0.0, 0.0, 0.0, 1.0 / UNIT_PX, 0.0, 0.0, 0.0, 1.0);
    let mut normal = SMatrix::<f64, 5, 5>::zeros();
    for homography in homographies {
        let h = unit * homography;
        let h = h / h.norm();
        // Row of coefficients of hᵢᵀBhⱼ for the unknowns B₁₁, B₂₂, B₁₃, B₂₃, B₃₃.
        let product = |i: usize, j: usize| {
            let (a, b) = (h.column(i), h.column(j));
            SVector::<f64, 5>::from([
                a[0] * b[0],
                a[1] * b[1],
                a[0] * b[2] + a[2] * b[0],
                a[1] * b[2] + a[2] * b[1],
                a[2] * b[2],
            ])
        };
        for row in [product(0, 1), product(0, 0) - product(1, 1)] {
            normal += row * row.transpose();
        }
    }
    let b = least_eigenvector(normal);
    let centre = [-b[2] / b[0], -b[3] / b[1]];
    let scale = b[4] - b[2] * b[2] / b[0] - b[3] * b[3] / b[1];
    let squares = [scale / b[0], scale / b[1]];
    if squares.iter().any(|square| !square.is_finite() || *square <= 0.0) {
        return None;
    }
    Some((squares.map(|square| UNIT_PX * square.sqrt()), centre.map(|at| UNIT_PX * at)))
}

/// Rotation and translation of a board from its homography.
fn board_pose(homography: &Matrix3<f64>, camera: &Intrinsics) -> Option<View> {
    let ([fx, fy], [cx, cy]) = (camera.focal_px, camera.centre_px);
    let inverse = Matrix3::new(1.0 / fx, 0.0, -cx / fx, 0.0, 1.0 / fy, -cy / fy, 0.0, 0.0, 1.0);
    let columns = inverse * homography;
    let length = 0.5 * (columns.column(0).norm() + columns.column(1).norm());
    // The sign is chosen such that the board is in front of the camera.
    let columns = columns / length.copysign(columns[(2, 2)]);
    let (first, second) = (columns.column(0).into_owned(), columns.column(1).into_owned());
    let near = Matrix3::from_columns(&[first, second, first.cross(&second)]).svd(true, true);
    Some(View { rotation: near.u? * near.v_t?, translation_m: columns.column(2).into_owned() })
}

#[cfg(test)]
#[allow(clippy::expect_used)]
mod tests {
    use nalgebra::Rotation3;

    use super::*;
    use crate::vision::synthetic::Random;

    const TRUE: Intrinsics = Intrinsics {
        focal_px: [755.139, 753.926],
        centre_px: [320.252, 239.661],
        distortion: [-0.12, 0.05, 0.0008, -0.0005],
    };

    /// 20 views of a board of 11 × 8 corners 25 mm apart, leaning by up to 45°, projected by a camera model that the test has for itself.
    fn views(noise_px: f64, random: &mut Random) -> Vec<Vec<Corner>> {
        let mut views = Vec::new();
        while views.len() < 20 {
            let course = random.between(0.0, std::f64::consts::TAU);
            let lean = Vector3::new(course.cos(), course.sin(), 0.0) * random.between(0.3, 0.8);
            let rotation =
                Rotation3::new(lean) * Rotation3::from_axis_angle(&Vector3::z_axis(), random.between(-3.0, 3.0));
            let place =
                Vector3::new(random.between(-0.08, 0.08), random.between(-0.06, 0.06), random.between(0.35, 0.6));
            let mut view: Vec<Corner> = Vec::new();
            for (i, j) in (0..11).flat_map(|i| (0..8).map(move |j| (i, j))) {
                let board = [0.025 * (f64::from(i) - 5.0), 0.025 * (f64::from(j) - 3.5)];
                let seen = rotation * Vector3::new(board[0], board[1], 0.0) + place;
                let (x, y) = (seen.x / seen.z, seen.y / seen.z);
                let ([k1, k2, p1, p2], r2) = (TRUE.distortion, x * x + y * y);
                let radial = 1.0 + k1 * r2 + k2 * r2 * r2;
                let u = x * radial + 2.0 * p1 * x * y + p2 * (r2 + 2.0 * x * x);
                let v = y * radial + p1 * (r2 + 2.0 * y * y) + 2.0 * p2 * x * y;
                let pixel = [TRUE.focal_px[0] * u + TRUE.centre_px[0], TRUE.focal_px[1] * v + TRUE.centre_px[1]];
                if (0.0..640.0).contains(&pixel[0]) && (0.0..480.0).contains(&pixel[1]) {
                    view.push((pixel.map(|at| at + noise_px * random.normal()), board));
                }
            }
            if view.len() >= 60 {
                views.push(view);
            }
        }
        views
    }

    #[test]
    fn twenty_views_give_the_intrinsics_within_a_thousandth() {
        let mut random = Random::new(41);
        for _ in 0..5 {
            // Corners have noise of 0.05 px, as sub-pixel corner finders have.
            let found = calibrate(&views(0.05, &mut random), Bend::RadialAndTangential).expect("20 views");
            let Intrinsics { focal_px, centre_px, distortion } = found.intrinsics;
            for axis in 0..2 {
                assert!((focal_px[axis] / TRUE.focal_px[axis] - 1.0).abs() < 0.001, "{found:?}");
                assert!((centre_px[axis] - TRUE.centre_px[axis]).abs() < 0.001 * TRUE.focal_px[axis], "{found:?}");
            }
            // The root mean square residual is the corner noise, slightly less because the 128 unknowns absorb some of it; the two image axes give
            // the factor √2.
            assert!((found.rms_px - 0.05 * std::f64::consts::SQRT_2).abs() < 0.005, "{found:?}");
            assert!((distortion[0] - TRUE.distortion[0]).abs() < 0.01, "{found:?}");
        }
    }

    #[test]
    fn the_true_camera_lies_within_four_deviations_of_what_is_found() {
        let mut random = Random::new(44);
        let (mut n_within, mut n_wide) = (0, 0);
        for _ in 0..40 {
            let views = views(0.05, &mut random);
            let found = calibrate(&views, Bend::RadialAndTangential).expect("20 views").intrinsics;
            let deviations = deviations(&views, Bend::RadialAndTangential, [640, 480]).expect("19 views");
            let off = |of: fn(&Intrinsics) -> f64| (of(&found) - of(&TRUE)).abs();
            let by_deviation = [
                off(|camera| camera.focal_px[0]) / deviations.focal_px[0],
                off(|camera| camera.focal_px[1]) / deviations.focal_px[1],
                off(|camera| camera.centre_px[0]) / deviations.centre_px[0],
                off(|camera| camera.centre_px[1]) / deviations.centre_px[1],
            ];
            n_within += by_deviation.iter().filter(|share| **share < 4.0).count();
            n_wide += by_deviation.iter().filter(|share| **share < 0.1).count();
        }
        // Of a normal distribution 8 % lie within a tenth of a deviation; deviations that are much too great would hold more.
        assert!(n_within >= 155 && n_wide < 40, "{n_within} and {n_wide} of 160");
    }

    #[test]
    fn perfect_corners_give_the_perfect_camera() {
        let found = calibrate(&views(0.0, &mut Random::new(42)), Bend::RadialAndTangential).expect("20 views");
        let Intrinsics { focal_px, centre_px, distortion } = found.intrinsics;
        for axis in 0..2 {
            assert!((focal_px[axis] - TRUE.focal_px[axis]).abs() < 1e-6, "{found:?}");
            assert!((centre_px[axis] - TRUE.centre_px[axis]).abs() < 1e-6, "{found:?}");
        }
        for (found, truth) in distortion.iter().zip(TRUE.distortion) {
            assert!((found - truth).abs() < 1e-8, "{distortion:?}");
        }
    }

    #[test]
    fn views_in_one_direction_determine_nothing() {
        let mut random = Random::new(43);
        let view = views(0.0, &mut random).swap_remove(0);
        assert!(calibrate(&[view.clone(), view.clone()], Bend::Radial).is_none());
        assert!(calibrate(&[Vec::new(), Vec::new(), Vec::new()], Bend::Radial).is_none());
    }
}

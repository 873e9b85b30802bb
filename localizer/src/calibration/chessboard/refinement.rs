//! Least-squares refinement of intrinsics and board poses together.
//!
//! Each view's pose affects only the view's own corners: with U the block of the normal equations for the intrinsics, Vᵢ that for the pose of view
//! i, Wᵢ the one between them, and a and bᵢ their right-hand sides, the step δ of the intrinsics solves (U − Σ WᵢVᵢ⁻¹Wᵢᵀ) δ = a − Σ WᵢVᵢ⁻¹bᵢ, and
//! the step of each pose follows from δ.

use nalgebra::{Matrix2x3, Matrix3, Rotation3, SMatrix, SVector, Vector2, Vector3};

use super::{Bend, Calibration, Corner, Intrinsics, View};

/// Number of intrinsics: fx, fy, cx, cy, k1, k2, p1, p2.
const N_INTRINSICS: usize = 8;
/// Index of the tangential lens coefficient p1 in the list of intrinsics (fx, fy, cx, cy, k1, k2, p1, p2).
const TANGENTIAL: usize = 6;
/// Parameters of a pose's step: a small turn about the camera's axes, and a shift.
const N_POSE: usize = 6;
const MOST_STEPS: usize = 60;

type Intrinsic = SVector<f64, N_INTRINSICS>;
type Pose = SVector<f64, N_POSE>;

/// Normal equations at a guess of the intrinsics and poses.
struct Normal {
    intrinsic: SMatrix<f64, N_INTRINSICS, N_INTRINSICS>,
    intrinsic_right: Intrinsic,
    views: Vec<(SMatrix<f64, N_POSE, N_POSE>, SMatrix<f64, N_INTRINSICS, N_POSE>, Pose)>,
    cost: f64,
}

/// Refines a first guess of intrinsics and board poses by Levenberg and Marquardt's method.
pub(super) fn refine(
    start: Intrinsics,
    start_views: Vec<View>,
    corners: &[Vec<Corner>],
    bend: Bend,
) -> Option<Calibration> {
    let (mut camera, mut views) = (start, start_views);
    let mut damping = 1e-3;
    let mut normal = Normal::at(&camera, &views, corners, bend);
    for _ in 0..MOST_STEPS {
        let (step, steps) = normal.step(damping)?;
        let next_camera = moved_camera(&camera, &step);
        let next_views: Vec<View> = views.iter().zip(&steps).map(|(view, step)| moved_view(view, step)).collect();
        let next = Normal::at(&next_camera, &next_views, corners, bend);
        if next.cost.is_finite() && next.cost <= normal.cost {
            let gained = normal.cost - next.cost;
            (camera, views, normal) = (next_camera, next_views, next);
            damping = (damping * 0.1).max(1e-12);
            if gained <= 1e-12 * normal.cost {
                break;
            }
        } else {
            damping *= 10.0;
            if damping > 1e12 {
                break;
            }
        }
    }
    let count: usize = corners.iter().map(Vec::len).sum();
    let is_sane = camera.focal_px.iter().all(|focal| focal.is_finite() && *focal > 0.0);
    is_sane.then(|| Calibration { intrinsics: camera, rms_px: (normal.cost / count as f64).sqrt() })
}

impl Normal {
    fn at(camera: &Intrinsics, views: &[View], corners: &[Vec<Corner>], bend: Bend) -> Normal {
        let mut normal = Normal {
            intrinsic: SMatrix::zeros(),
            intrinsic_right: SVector::zeros(),
            views: Vec::with_capacity(views.len()),
            cost: 0.0,
        };
        for (view, corners) in views.iter().zip(corners) {
            let (mut own, mut between, mut right) = (SMatrix::zeros(), SMatrix::zeros(), SVector::zeros());
            for (pixel, board) in corners {
                let turned = view.rotation * Vector3::new(board[0], board[1], 0.0);
                let (image, mut by_camera, by_point) = project(camera, &(turned + view.translation_m));
                if bend == Bend::Radial {
                    by_camera.fixed_columns_mut::<2>(TANGENTIAL).fill(0.0);
                }
                let residual = Vector2::from(*pixel) - image;
                // A small turn by the rotation vector w moves a point of the board by w × turned, where `turned` is the point's rotated position.
                let mut by_pose = SMatrix::<f64, 2, N_POSE>::zeros();
                by_pose.fixed_columns_mut::<3>(0).copy_from(&(by_point * -turned.cross_matrix()));
                by_pose.fixed_columns_mut::<3>(3).copy_from(&by_point);
                normal.intrinsic += by_camera.transpose() * by_camera;
                normal.intrinsic_right += by_camera.transpose() * residual;
                own += by_pose.transpose() * by_pose;
                between += by_camera.transpose() * by_pose;
                right += by_pose.transpose() * residual;
                normal.cost += residual.norm_squared();
            }
            normal.views.push((own, between, right));
        }
        if bend == Bend::Radial {
            // The lens coefficients p1 and p2 are not solved for: their derivatives are set to 0, so that they do not change, and ones on the
            // diagonal keep the equations solvable.
            (TANGENTIAL..N_INTRINSICS).for_each(|k| normal.intrinsic[(k, k)] = 1.0);
        }
        normal
    }

    /// Steps of the intrinsics and of each pose; `None` when the views do not determine them.
    fn step(&self, damping: f64) -> Option<(Intrinsic, Vec<Pose>)> {
        let mut reduced = damped(self.intrinsic, damping);
        let mut right = self.intrinsic_right;
        let mut inverses = Vec::with_capacity(self.views.len());
        for (own, between, own_right) in &self.views {
            let inverse = damped(*own, damping).try_inverse()?;
            reduced -= between * inverse * between.transpose();
            right -= between * inverse * own_right;
            inverses.push(inverse);
        }
        let step = reduced.cholesky()?.solve(&right);
        let poses = self.views.iter().zip(&inverses);
        Some((
            step,
            poses.map(|((_, between, right), inverse)| inverse * (right - between.transpose() * step)).collect(),
        ))
    }
}

fn damped<const N: usize>(mut matrix: SMatrix<f64, N, N>, damping: f64) -> SMatrix<f64, N, N> {
    for k in 0..N {
        matrix[(k, k)] *= 1.0 + damping;
    }
    matrix
}

/// Image of a point, with its derivatives by the intrinsics and by the point.
fn project(camera: &Intrinsics, point: &Vector3<f64>) -> (Vector2<f64>, SMatrix<f64, 2, N_INTRINSICS>, Matrix2x3<f64>) {
    let ([fx, fy], [k1, k2, p1, p2]) = (camera.focal_px, camera.distortion);
    let (x, y) = (point.x / point.z, point.y / point.z);
    let square = x * x + y * y;
    let radial = 1.0 + k1 * square + k2 * square * square;
    let bent = [
        x * radial + 2.0 * p1 * x * y + p2 * (square + 2.0 * x * x),
        y * radial + p1 * (square + 2.0 * y * y) + 2.0 * p2 * x * y,
    ];
    let image = Vector2::new(fx * bent[0] + camera.centre_px[0], fy * bent[1] + camera.centre_px[1]);
    #[rustfmt::skip]
    let by_camera = SMatrix::<f64, 2, N_INTRINSICS>::from_row_slice(&[
        bent[0], 0.0, 1.0, 0.0, fx * x * square, fx * x * square * square, fx * 2.0 * x * y, fx * (square + 2.0 * x * x),
        0.0, bent[1], 0.0, 1.0, fy * y * square, fy * y * square * square, fy * (square + 2.0 * y * y), fy * 2.0 * x * y,
    ]);
    // ∂radial/∂x = 2x·growth.
    let growth = k1 + 2.0 * k2 * square;
    let cross = 2.0 * x * y * growth + 2.0 * p1 * x + 2.0 * p2 * y;
    let (u_x, v_y) = (
        radial + 2.0 * x * x * growth + 2.0 * p1 * y + 6.0 * p2 * x,
        radial + 2.0 * y * y * growth + 6.0 * p1 * y + 2.0 * p2 * x,
    );
    let (dx, dy) = (Vector3::new(1.0, 0.0, -x) / point.z, Vector3::new(0.0, 1.0, -y) / point.z);
    let rows = [(dx * u_x + dy * cross) * fx, (dx * cross + dy * v_y) * fy];
    (image, by_camera, Matrix2x3::from_rows(&[rows[0].transpose(), rows[1].transpose()]))
}

fn moved_camera(camera: &Intrinsics, step: &Intrinsic) -> Intrinsics {
    Intrinsics {
        focal_px: [0, 1].map(|k| camera.focal_px[k] + step[k]),
        centre_px: [0, 1].map(|k| camera.centre_px[k] + step[2 + k]),
        distortion: [0, 1, 2, 3].map(|k| camera.distortion[k] + step[4 + k]),
    }
}

fn moved_view(view: &View, step: &Pose) -> View {
    let turn: Matrix3<f64> = Rotation3::new(step.fixed_rows::<3>(0).into_owned()).into_inner();
    View { rotation: turn * view.rotation, translation_m: view.translation_m + step.fixed_rows::<3>(3) }
}

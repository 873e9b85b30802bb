//! The pose in the plane from image points of which the landmarks are known (resection): least squares of the reprojection errors, and RANSAC.

use nalgebra::{Matrix2, Matrix2x3, Matrix3, Vector2, Vector3};

use crate::{
    Pose,
    map::SpacePoint,
    robot::{BodyModel, ForwardCameraModel},
    vision::distortion::unbent_point,
};

use super::super::weighted_points::{DEVIATION_OF_BOUND, WeightedPose};

/// Standard deviation of a keypoint's position along u and along v, in pixels: that of ORB-SLAM's finest level.
const KEYPOINT_PX: f64 = 1.0;
/// Greatest squared Mahalanobis distance of an image point from where the landmark should be seen: χ² with two degrees of freedom exceeds it once in
/// twenty. R. Mur-Artal, J. D. Tardós, "ORB-SLAM: a versatile and accurate monocular SLAM system", IEEE Transactions on Robotics 31 (2015), uses the
/// same for inliers, and its root for Huber's loss.
const SQUARED_GATE: f64 = 5.991;
/// Greatest number of Gauss-Newton steps.
const MOST_STEPS: usize = 15;
/// Gauss-Newton steps end when every component of a step is smaller than this, in metres and radians.
const SETTLED: f64 = 1e-9;
/// Longest step, in metres and radians: a longer one shows that the points do not determine the pose.
const LONGEST_STEP: f64 = 1.0;
/// Least depth, as a share of the length of a ray, of a point before the camera.
const LEAST_DEPTH: f64 = 0.1;
/// Number of image points, the most alike ones, of which pairs propose a pose: the best matches are tried first in O. Chum, J. Matas, "Matching with
/// PROSAC", CVPR 2005.
const MOST_PROPOSING: usize = 40;
/// Greatest number of times that a fit is repeated from the points that agree with it.
const MOST_REFITS: usize = 5;

/// A camera on a robot with its nominal calibration, on a level floor.
#[derive(Clone, Debug)]
pub(super) struct LevelCamera {
    focal_px: f64,
    centre_px: [f64; 2],
    distortion: [f64; 5],
    /// Turns the robot frame into the frame of the camera: right, down, ahead.
    camera_from_robot: Matrix3<f64>,
    /// Optical centre in the robot frame, with its height.
    eye_m: Vector3<f64>,
    /// Variances along u and along v of a keypoint and of what lean and mount shift.
    noise_px2: Matrix2<f64>,
}

/// An image point of a landmark.
#[derive(Clone, Copy, Debug)]
pub(super) struct Sight {
    pub(super) point: SpacePoint,
    /// Where a pinhole camera would show it.
    pub(super) at_px: Vector2<f64>,
}

/// Where a pinhole camera shows the middle of a landmark's box, with the derivatives by x, y and heading and by α, β and ρ.
#[derive(Clone, Copy, Debug)]
pub(super) struct Shown {
    pub(super) at_px: Vector2<f64>,
    pub(super) by_pose: Matrix2x3<f64>,
    pub(super) by_point: Matrix2x3<f64>,
    /// Distance from the camera as a multiple of that from the landmark's anchor, and the cosine of the angle between both directions.
    pub(super) ratio: f64,
    pub(super) cosine: f64,
}

impl LevelCamera {
    pub(super) fn new(camera: &ForwardCameraModel, body: &BodyModel) -> LevelCamera {
        let (sin_yaw, cos_yaw) = camera.yaw_rad.mid().sin_cos();
        let (sin_up, cos_up) = camera.tilt_up_rad.sin_cos();
        let unyawed = Matrix3::new(cos_yaw, sin_yaw, 0.0, -sin_yaw, cos_yaw, 0.0, 0.0, 0.0, 1.0);
        let looking = Matrix3::new(0.0, -1.0, 0.0, sin_up, 0.0, -cos_up, cos_up, 0.0, sin_up);
        let [forward, left] = camera.position_m.map(|at| at.mid());
        let focal_px = camera.focal_px.mid();
        // A lean of the body or of the mount shifts the picture up or down. Sideways it shifts the heading instead, all points alike.
        let lean_px = DEVIATION_OF_BOUND * focal_px * camera.tilt_error_rad.hypot(body.tilt_rad);
        let variance = |shift_px: f64| KEYPOINT_PX.powi(2) + shift_px.powi(2);
        LevelCamera {
            focal_px,
            centre_px: camera.principal_point_px.map(|at| at.mid()),
            distortion: camera.distortion,
            camera_from_robot: looking * unyawed,
            eye_m: Vector3::new(forward, left, camera.height_m.mid()),
            noise_px2: Matrix2::from_diagonal(&Vector2::new(variance(0.0), variance(lean_px))),
        }
    }

    /// Nominal focal length in pixels.
    pub(super) fn focal_px(&self) -> f64 {
        self.focal_px
    }

    /// Where a pinhole camera would show what the lens shows at a pixel; `None` where the lens folds.
    pub(super) fn straightened(&self, at_px: [f64; 2]) -> Option<Vector2<f64>> {
        let seen = [0, 1].map(|axis| (at_px[axis] - self.centre_px[axis]) / self.focal_px);
        let straight = unbent_point(self.distortion, seen)?;
        Some(Vector2::from([0, 1].map(|axis| self.centre_px[axis] + self.focal_px * straight[axis])))
    }

    /// Where the landmark is seen from a pose; `None` where it is beside the camera or behind it.
    ///
    /// With the ray d(α, β) from the anchor A, the position P, the heading θ and the optical centre a in the robot frame, the vector to the landmark,
    /// times its inverse depth ρ, is C·(Rᵀ(θ)·(d + ρ·(A − P)) − ρ·a) in the frame of the camera, where nothing is divided by ρ.
    pub(super) fn shown(&self, pose: Pose, point: &SpacePoint) -> Option<Shown> {
        let anchor = &point.anchor;
        let [alpha, beta, rho] = point.value.map(|value| value.mid());
        let [i, j] = anchor.sides();
        let mut first = Vector3::repeat(anchor.sign());
        (first[i], first[j]) = (alpha, beta);
        let (sin, cos) = pose.heading_rad.sin_cos();
        let unturned = Matrix3::new(cos, sin, 0.0, -sin, cos, 0.0, 0.0, 0.0, 1.0);
        let by_heading = Matrix3::new(-sin, cos, 0.0, -cos, -sin, 0.0, 0.0, 0.0, 0.0);
        let from_robot = Vector3::from(anchor.from_m) - Vector3::new(pose.x_m, pose.y_m, 0.0);
        let (camera, turned) = (self.camera_from_robot, self.camera_from_robot * unturned);
        let ray = first + rho * from_robot;
        let seen = turned * ray - rho * (camera * self.eye_m);
        if seen.z <= LEAST_DEPTH * seen.norm() {
            return None;
        }
        let scale = self.focal_px / seen.z;
        let project = Matrix2x3::new(scale, 0.0, -scale * seen.x / seen.z, 0.0, scale, -scale * seen.y / seen.z);
        let by_place = -rho * turned;
        let pose_columns = [by_place.column(0).into(), by_place.column(1).into(), camera * by_heading * ray];
        let by_depth: Vector3<f64> = turned * from_robot - camera * self.eye_m;
        let point_columns = [turned.column(i).into(), turned.column(j).into(), by_depth];
        let anchored = turned * first;
        Some(Shown {
            at_px: Vector2::from(self.centre_px) + scale * seen.xy(),
            by_pose: project * Matrix3::from_columns(&pose_columns),
            by_point: project * Matrix3::from_columns(&point_columns),
            ratio: seen.norm() / anchored.norm(),
            cosine: seen.dot(&anchored) / (seen.norm() * anchored.norm()),
        })
    }

    /// Inverse of the covariance of an image point about where the landmark's middle is shown: the keypoint's own, and what is not known of the
    /// landmark.
    fn weight(&self, shown: &Shown, point: &SpacePoint) -> Option<Matrix2<f64>> {
        let variances = Vector3::from(point.value.map(|value| (DEVIATION_OF_BOUND * value.radius()).powi(2)));
        let of_point = shown.by_point * Matrix3::from_diagonal(&variances) * shown.by_point.transpose();
        (of_point + self.noise_px2).try_inverse()
    }

    /// Squared Mahalanobis distance of an image point from where the landmark should be seen from a pose.
    fn squared_distance(&self, pose: Pose, sight: &Sight) -> f64 {
        let distance = || {
            let shown = self.shown(pose, &sight.point)?;
            let off_px = sight.at_px - shown.at_px;
            Some(off_px.dot(&(self.weight(&shown, &sight.point)? * off_px)))
        };
        distance().unwrap_or(f64::INFINITY)
    }

    /// The pose that minimises the reprojection errors of image points, each weighted by its covariance and by Huber's loss, from the pose `start` on
    /// by the Gauss-Newton method. It is `None` for fewer than two points, and where they do not determine the pose.
    ///
    /// Source: P. Huber, "Robust estimation of a location parameter", Annals of Mathematical Statistics 35 (1964).
    pub(super) fn fit(&self, sights: &[&Sight], start: Pose) -> Option<WeightedPose> {
        if sights.len() < 2 {
            return None;
        }
        let mut pose = start;
        let mut covariance = Matrix3::zeros();
        for _ in 0..MOST_STEPS {
            let (mut normal, mut gradient) = (Matrix3::zeros(), Vector3::zeros());
            for sight in sights {
                let shown = self.shown(pose, &sight.point)?;
                let off_px = sight.at_px - shown.at_px;
                let weight = self.weight(&shown, &sight.point)?;
                let loss = (SQUARED_GATE / off_px.dot(&(weight * off_px))).sqrt().min(1.0);
                let slope = shown.by_pose.transpose() * weight * loss;
                normal += slope * shown.by_pose;
                gradient += slope * off_px;
            }
            covariance = normal.try_inverse()?;
            let step = covariance * gradient;
            if step.iter().any(|part| part.is_nan() || part.abs() > LONGEST_STEP) {
                return None;
            }
            pose.x_m += step.x;
            pose.y_m += step.y;
            pose.heading_rad += step.z;
            if step.amax() < SETTLED {
                break;
            }
        }
        Some(WeightedPose { pose, covariance })
    }

    /// The pose near the predicted one that most image points agree with, and which of them do; `None` where no pair gives such a pose. The most
    /// alike come first in `sights`.
    ///
    /// Each pair of image points, four equations for three unknowns, proposes a pose, if the prediction allows for it. All points that agree with a
    /// proposal are fitted together until they stay the same. Sources: M. Fischler, R. Bolles, "Random sample consensus", Communications of the ACM
    /// 24 (1981); O. Chum et al., "Locally optimized RANSAC" (2003).
    pub(super) fn ransac(&self, sights: &[Sight], predicted: &WeightedPose) -> Option<(WeightedPose, Vec<bool>)> {
        let mut best: Option<(usize, WeightedPose, Vec<bool>)> = None;
        let proposing = &sights[..sights.len().min(MOST_PROPOSING)];
        for (index, first) in proposing.iter().enumerate() {
            for second in &proposing[..index] {
                let proposed = self.fit(&[first, second], predicted.pose);
                let Some(proposed) = proposed.filter(|pose| pose.agrees_with(predicted)) else { continue };
                let n_agree = count(&self.agreeing(sights, proposed.pose));
                if n_agree <= best.as_ref().map_or(1, |(n_agree, ..)| *n_agree) {
                    continue;
                }
                let Some((fitted, agree)) = self.refined(sights, proposed) else { continue };
                if best.as_ref().is_none_or(|(n_agree, ..)| count(&agree) > *n_agree) {
                    best = Some((count(&agree), fitted, agree));
                }
            }
        }
        best.map(|(_, pose, agree)| (pose, agree))
    }

    /// The pose by all image points that agree with it, beginning with a pose near it, and which of them do.
    pub(super) fn refined(&self, sights: &[Sight], from: WeightedPose) -> Option<(WeightedPose, Vec<bool>)> {
        let (mut pose, mut agree) = (from, self.agreeing(sights, from.pose));
        for _ in 0..MOST_REFITS {
            let chosen: Vec<&Sight> =
                sights.iter().zip(&agree).filter(|(_, agrees)| **agrees).map(|(sight, _)| sight).collect();
            pose = self.fit(&chosen, pose.pose)?;
            let next = self.agreeing(sights, pose.pose);
            let is_settled = next == agree;
            agree = next;
            if is_settled {
                break;
            }
        }
        Some((pose, agree))
    }

    fn agreeing(&self, sights: &[Sight], pose: Pose) -> Vec<bool> {
        sights.iter().map(|sight| self.squared_distance(pose, sight) <= SQUARED_GATE).collect()
    }
}

/// Number of points that agree.
pub(super) fn count(agree: &[bool]) -> usize {
    agree.iter().filter(|agrees| **agrees).count()
}

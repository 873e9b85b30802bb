//! Points with the covariance that a stereo camera gives them, and the pose that fits many of them best.
//!
//! A stereo camera's error is far greater along the ray than across it, and grows with the square of the distance. Fits that weigh all points
//! alike, or by one number each, lose most of the information in near points and in all bearings: L. Matthies, S. Shafer, "Error modeling in
//! stereo navigation", IEEE Journal of Robotics and Automation 3 (1987).

use nalgebra::{Matrix2, Matrix2x3, Matrix3, Rotation2, Vector2, Vector3};

use interval::Interval;

use crate::{Pose, robot::WheelModel};

use super::{least_squares, pose_graph::Step};

/// Greatest squared Mahalanobis distance of a point from the place to which it is matched: χ² with two degrees of freedom exceeds it once in a
/// thousand.
pub const SQUARED_GATE: f64 = 13.82;

/// Greatest squared Mahalanobis distance of a pose from a prediction of it: χ² with three degrees of freedom exceeds it once in a thousand.
pub const SQUARED_GATE_OF_POSE: f64 = 16.27;

/// Standard deviation of a value per half-width of its bounds, 1/√3: only the bounds are known, and all values between them are taken as equally
/// likely.
pub(super) const DEVIATION_OF_BOUND: f64 = 0.577_350_269_189_625_8;
/// Greatest number of Gauss-Newton steps.
const MOST_STEPS: usize = 20;
/// Gauss-Newton steps end when every component of a step is smaller than this, in metres and radians.
const SETTLED: f64 = 1e-10;

/// A point with the covariance of its position.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WeightedPoint {
    /// Position of the point.
    pub at_m: Vector2<f64>,
    /// Covariance of the point's position.
    pub covariance_m2: Matrix2<f64>,
}

/// A pose with the covariance of its x, y and heading.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WeightedPose {
    /// The pose.
    pub pose: Pose,
    /// Covariance of the pose's x, y and heading.
    pub covariance: Matrix3<f64>,
}

/// A landmark as it is learnt: the running weighted mean of all sightings that agreed with it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LearntPoint {
    mean_m: Vector2<f64>,
    information_per_m2: Matrix2<f64>,
    /// Part of the landmark's covariance that comes from the uncertainty of the robot's pose at the first sighting; no later sighting reduces it.
    inherited_m2: Matrix2<f64>,
    /// Number of sightings of the landmark in the mean.
    pub n_sights: usize,
}

impl WeightedPoint {
    /// A point in the robot frame with its covariance, from the box that a stereo reading claims. The box's diagonal is the error along the ray,
    /// which is f·b/d² times the error of the disparity d, with the focal length f and the baseline b. Across the ray the point's image column errs
    /// by as much as the disparity does, so that the error across is baseline over range times the error along.
    pub fn of_stereo(in_robot_m: [Interval; 2], baseline_m: f64) -> Self {
        let at_m = Vector2::from(in_robot_m.map(Interval::mid));
        let along_m = DEVIATION_OF_BOUND * Vector2::from(in_robot_m.map(Interval::radius)).norm();
        let range_m = at_m.norm().max(baseline_m);
        let across_m = along_m * baseline_m / range_m;
        let ray = Rotation2::new(at_m.y.atan2(at_m.x));
        let covariance_m2 = turned(Matrix2::from_diagonal(&Vector2::new(along_m.powi(2), across_m.powi(2))), &ray);
        WeightedPoint { at_m, covariance_m2 }
    }

    /// This point of the robot frame, carried into the world by `pose`; the covariance is the point's alone, without the pose's.
    pub fn in_world(&self, pose: Pose) -> Self {
        let rotation = Rotation2::new(pose.heading_rad);
        WeightedPoint {
            at_m: Vector2::new(pose.x_m, pose.y_m) + rotation * self.at_m,
            covariance_m2: turned(self.covariance_m2, &rotation),
        }
    }

    /// Squared Mahalanobis distance of this point, seen from the pose `from`, to a place in the world; the covariance of the pose counts too.
    pub fn squared_distance(&self, from: &WeightedPose, place: &WeightedPoint) -> f64 {
        let seen = self.in_world(from.pose);
        let slope = slope(from.pose, self.at_m);
        let covariance = seen.covariance_m2 + place.covariance_m2 + slope * from.covariance * slope.transpose();
        let off_m = place.at_m - seen.at_m;
        covariance.try_inverse().map_or(f64::INFINITY, |inverse| off_m.dot(&(inverse * off_m)))
    }
}

impl WeightedPose {
    /// A pose that is known within bounds, with the covariance of equally likely values between them.
    pub fn of_bounds(pose: Pose, half_widths: [f64; 3]) -> Self {
        let variances = Vector3::from(half_widths.map(|half| (DEVIATION_OF_BOUND * half).powi(2)));
        WeightedPose { pose, covariance: Matrix3::from_diagonal(&variances) }
    }

    /// This pose carried on by the motion between two poses of the odometry. The covariance grows by what slip and unequal wheels can cause
    /// within their declared bounds.
    pub fn carried_on(&self, from: Pose, to: Pose, wheels: &WheelModel) -> Self {
        let step = Step::between(from, to);
        let pose = step.after(self.pose);
        let mut carry = Matrix3::identity();
        carry[(0, 2)] = -(pose.y_m - self.pose.y_m);
        carry[(1, 2)] = pose.x_m - self.pose.x_m;
        let track_m = wheels.track_m.mid();
        let rolled_m = step.travel_m[0].hypot(step.travel_m[1]) + 0.5 * track_m * step.turn_rad.abs();
        let unequal =
            (0..2).map(|wheel| wheels.radius_m[wheel].radius() / wheels.radius_m[wheel].mid()).fold(0.0, f64::max);
        let along_m = (wheels.slip_ratio + unequal) * rolled_m + wheels.slip_floor_m;
        let aside_m = wheels.side_slip_ratio * rolled_m + wheels.side_slip_floor_m;
        let way_m = along_m.max(aside_m);
        let turn_rad = 2.0 * along_m / track_m + step.turn_rad.abs() * wheels.track_m.radius() / track_m;
        let grown = WeightedPose::of_bounds(pose, [way_m, way_m, turn_rad]);
        WeightedPose { pose, covariance: carry * self.covariance * carry.transpose() + grown.covariance }
    }

    /// Whether this pose and another, estimated independently, may be of the same robot at the same time: their difference is within the gate that
    /// true differences exceed once in a thousand.
    pub fn agrees_with(&self, other: &WeightedPose) -> bool {
        let (here, there) = (self.pose.to_array(), other.pose.to_array());
        let off = Vector3::from_fn(|axis, _| here[axis] - there[axis]);
        let inverse = (self.covariance + other.covariance).try_inverse();
        inverse.is_some_and(|inverse| off.dot(&(inverse * off)) <= SQUARED_GATE_OF_POSE)
    }

    /// The mean of this pose and another, estimated independently, weighted by their covariances; this pose alone where both are known exactly. It is
    /// the measurement update of R. Kalman, "A new approach to linear filtering and prediction problems", Journal of Basic Engineering 82 (1960).
    pub fn with(&self, other: &WeightedPose) -> Self {
        let Some(inverse) = (self.covariance + other.covariance).try_inverse() else { return *self };
        let gain = self.covariance * inverse;
        let (here, there) = (self.pose.to_array(), other.pose.to_array());
        let shift = gain * Vector3::from_fn(|axis, _| there[axis] - here[axis]);
        let [x_m, y_m, heading_rad] = [0, 1, 2].map(|axis| here[axis] + shift[axis]);
        WeightedPose { pose: Pose { x_m, y_m, heading_rad }, covariance: self.covariance - gain * self.covariance }
    }

    /// The same pose with its heading shifted by whole turns to be nearest to `heading_rad`: headings are on the real line (not wrapped).
    pub fn near(self, heading_rad: f64) -> Self {
        let turns = ((self.pose.heading_rad - heading_rad) / std::f64::consts::TAU).round();
        let heading_rad = self.pose.heading_rad - turns * std::f64::consts::TAU;
        WeightedPose { pose: Pose { heading_rad, ..self.pose }, ..self }
    }
}

impl LearntPoint {
    /// A landmark after its first sighting; `None` for a point whose covariance is singular.
    pub fn new(seen: &WeightedPoint, from: &WeightedPose) -> Option<Self> {
        let slope = slope(from.pose, seen.at_m);
        let first = seen.in_world(from.pose);
        Some(LearntPoint {
            mean_m: first.at_m,
            information_per_m2: first.covariance_m2.try_inverse()?,
            inherited_m2: slope * from.covariance * slope.transpose(),
            n_sights: 1,
        })
    }

    /// Where the landmark is, and how well that is known.
    pub fn place(&self) -> WeightedPoint {
        let own_m2 = self.information_per_m2.try_inverse().unwrap_or_default();
        WeightedPoint { at_m: self.mean_m, covariance_m2: own_m2 + self.inherited_m2 }
    }

    /// Adds another sighting of the landmark to the mean.
    pub fn learn(&mut self, seen: &WeightedPoint, from: Pose) {
        let again = seen.in_world(from);
        let Some(information) = again.covariance_m2.try_inverse() else { return };
        let all = self.information_per_m2 + information;
        let Some(inverse) = all.try_inverse() else { return };
        self.mean_m += inverse * information * (again.at_m - self.mean_m);
        self.information_per_m2 = all;
        self.n_sights += 1;
    }
}

/// The pose that carries points of the robot frame nearest to their places in the world, each distance weighted by its covariance. The
/// Gauss-Newton method starts from the pose `start` if there is one, otherwise from [`least_squares`]. The result is `None` for fewer than two
/// points, and where the points do not determine the pose.
pub fn weighted_fit(matches: &[(WeightedPoint, WeightedPoint)], start: Option<Pose>) -> Option<WeightedPose> {
    if matches.len() < 2 {
        return None;
    }
    let alike = || {
        let pairs: Vec<_> = matches.iter().map(|(place, seen)| (place.at_m.into(), seen.at_m.into())).collect();
        least_squares(&pairs)
    };
    let mut pose = start.or_else(alike)?;
    let mut covariance = Matrix3::zeros();
    for _ in 0..MOST_STEPS {
        let (mut normal, mut gradient) = (Matrix3::zeros(), Vector3::zeros());
        for (place, seen) in matches {
            let in_world = seen.in_world(pose);
            let weight = (place.covariance_m2 + in_world.covariance_m2).try_inverse()?;
            let slope = slope(pose, seen.at_m);
            normal += slope.transpose() * weight * slope;
            gradient += slope.transpose() * weight * (place.at_m - in_world.at_m);
        }
        covariance = normal.try_inverse()?;
        let change = covariance * gradient;
        pose.x_m += change.x;
        pose.y_m += change.y;
        pose.heading_rad += change.z;
        if change.amax() < SETTLED {
            break;
        }
    }
    Some(WeightedPose { pose, covariance })
}

/// Derivatives of a point's place in the world with respect to the pose's x, y and heading.
fn slope(pose: Pose, at_m: Vector2<f64>) -> Matrix2x3<f64> {
    let arm_m = Rotation2::new(pose.heading_rad) * at_m;
    Matrix2x3::new(1.0, 0.0, -arm_m.y, 0.0, 1.0, arm_m.x)
}

fn turned(covariance: Matrix2<f64>, by: &Rotation2<f64>) -> Matrix2<f64> {
    by.matrix() * covariance * by.matrix().transpose()
}

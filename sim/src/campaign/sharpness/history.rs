//! A history: everything that a run's readings depend on, from the start to an instant.
//!
//! The truth is one history. A history other than the truth that keeps every declared bound on the same readings is a *witness*: nobody who has only
//! the readings and the bounds can tell it from the truth.

use std::collections::BTreeMap;

use interval::Interval;
use localizer::{Pose, markers::GridPlace, reading::Camera};

use super::{SAME_S, number::Number};

/// A device that looks at the robot's surroundings at single instants.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Looker {
    /// One of the cameras.
    Camera(Camera),
    /// The range camera.
    Range,
}

/// A constant of a camera's mount or lens.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum CameraPart {
    /// Position of the optical centre in the robot frame: forward (0), left (1) or up (2), in metres.
    Position(usize),
    /// Turn of the camera about the body's vertical against its nominal direction, in radians.
    Yaw,
    /// Rotation vector of the camera's tilt against its nominal attitude, about robot x (0) or y (1), in radians.
    Tilt(usize),
    /// Focal length along u (0) or v (1), in pixels; for the floor camera the scale of its image on the floor (0), in pixels per metre.
    Focal(usize),
    /// Principal point along u (0) or v (1), in pixels.
    Centre(usize),
}

/// A quantity of a history that is not part of the robot's motion.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Quantity {
    /// Rolling radius of the left (0) or right (1) wheel, in metres.
    WheelRadius(usize),
    /// Distance between the wheels' contact points, in metres.
    Track,
    /// Bias of the gyroscope that is the same over the run, in radians per second.
    GyroBias,
    /// Scale factor of the gyroscope.
    GyroScale,
    /// Position of the place that the flow sensor looks at in the robot frame, forward (0) or left (1), in metres.
    FlowPosition(usize),
    /// Angle of the flow sensor's forward axis from the robot's, in radians.
    FlowYaw,
    /// Counts per metre of the flow sensor at its mounted height, as a share of the nominal number.
    FlowScale,
    /// Position of the range camera's first view in the robot frame, forward (0) or left (1), in metres.
    RangePosition(usize),
    /// Direction of the range camera's optical axis from robot forward, in radians.
    RangeYaw,
    /// Rotation vector of the range camera's vertical against the body's, about robot x (0) or y (1), in radians.
    RangeTilt(usize),
    /// Focal length of the range camera, in pixels.
    RangeFocal,
    /// Distance between the range camera's views, in metres.
    RangeBaseline,
    /// World x (0), y (1) or z (2) of the landmark with this code, in metres.
    Landmark(u32, usize),
    /// A constant of a camera.
    Camera(Camera, CameraPart),
    /// Displacement from the nominal line of the tiles' joint with this grid axis and index, at its first (0) or its last (1) end, in metres.
    JointEnd(usize, i32, usize),
    /// Distance of a joint, given by grid axis and index, from its straight line where it crosses the joint of the other axis with the second index, in
    /// metres.
    JointBend(usize, i32, i32),
    /// Displacement of the marker with this identity from its place on the map, along world x (0) or y (1), in metres.
    Marker(u16, usize),
    /// Angle of a marker against its direction on the map, in radians.
    MarkerTurn(u16),
    /// Height of a marker above the floor, in metres.
    MarkerHeight(u16),
    /// Displacement of a dot from its nominal place on its marker, along the marker's x (0) or y (1), in metres.
    Dot(u16, GridPlace, usize),
    /// Angle by which all walls stand turned against the directions that the scene states, in radians.
    WallsTurn,
    /// True instant at which a device looked, for the look that was truly at the stamp with this index, in seconds.
    Instant(Looker, usize),
    /// Height of the robot's origin above its height at rest, at the look at the stamp with this index, in metres.
    Heave(usize),
    /// Rotation of the body against the floor about robot x (0, roll) or robot y (1, pitch) at the stamp with this index, in radians.
    BodyTilt(usize, usize),
}

impl Quantity {
    /// Whether the quantity takes effect only in products with other unknown quantities: heights of landmarks, with tilts.
    pub(super) fn is_in_products(self) -> bool {
        matches!(self, Quantity::Landmark(_, 2))
    }
}

/// What the flow sensor has counted up to one of its readings.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Counted {
    /// Counts since the start, forward and left, together with where each axis stood within a count then.
    pub(super) counts: [f64; 2],
    /// The varying part of the scale in the period that the reading ends.
    pub(super) change: f64,
    /// How much of the period's counts came of ways forth and back, forward and left.
    pub(super) gained: [f64; 2],
}

/// Motion of the robot and all other quantities that the readings depend on.
#[derive(Clone, Debug)]
pub(super) struct History {
    /// True instants in ascending order, in seconds since the start. Every reading was measured at one of them.
    pub(super) stamps_s: Vec<f64>,
    /// Pose of the robot, `world_from_robot`, at each stamp. Between two stamps speed and turn rate are constant in the robot frame.
    pub(super) poses: Vec<Pose>,
    /// Spin angle of the left and of the right wheel since the start, at each stamp.
    pub(super) wheel_angle_rad: Vec<[f64; 2]>,
    /// What the flow sensor had counted at each of its readings, in their order.
    pub(super) counted: Vec<Counted>,
    /// All other quantities.
    pub(super) quantities: BTreeMap<Quantity, f64>,
}

impl History {
    /// Value of a quantity; NaN, which keeps no bound, where the history has no such quantity.
    pub(super) fn value(&self, quantity: Quantity) -> f64 {
        self.quantities.get(&quantity).copied().unwrap_or(f64::NAN)
    }

    /// Index of the stamp at this instant.
    pub(super) fn stamp_at(&self, time_s: f64) -> Option<usize> {
        let at = self.stamps_s.partition_point(|stamp_s| *stamp_s < time_s - SAME_S);
        self.stamps_s.get(at).filter(|stamp_s| **stamp_s < time_s + SAME_S).map(|_| at)
    }

    /// Stamps at which a device looked at something, in ascending order.
    pub(super) fn looks(&self) -> impl Iterator<Item = usize> {
        self.quantities.keys().filter_map(|quantity| match quantity {
            Quantity::BodyTilt(stamp, 0) => Some(*stamp),
            _ => None,
        })
    }

    /// The history up to the stamp with this index, without quantities.
    pub(super) fn until(&self, stamp: usize) -> History {
        History {
            stamps_s: self.stamps_s[..=stamp].to_vec(),
            poses: self.poses[..=stamp].to_vec(),
            wheel_angle_rad: self.wheel_angle_rad[..=stamp].to_vec(),
            counted: Vec::new(),
            quantities: BTreeMap::new(),
        }
    }

    /// The history that is this far on the way from this one to another with the same stamps: 0 is this one, 1 the other.
    pub(super) fn towards(&self, other: &History, share: f64) -> History {
        let mix = |from: f64, to: f64| from + share * (to - from);
        let mut mixed = self.clone();
        for (pose, to) in mixed.poses.iter_mut().zip(&other.poses) {
            *pose = Pose {
                x_m: mix(pose.x_m, to.x_m),
                y_m: mix(pose.y_m, to.y_m),
                heading_rad: mix(pose.heading_rad, to.heading_rad),
            };
        }
        for (angles_rad, to_rad) in mixed.wheel_angle_rad.iter_mut().zip(&other.wheel_angle_rad) {
            *angles_rad = [0, 1].map(|wheel| mix(angles_rad[wheel], to_rad[wheel]));
        }
        for (counted, to) in mixed.counted.iter_mut().zip(&other.counted) {
            counted.counts = [0, 1].map(|axis| mix(counted.counts[axis], to.counts[axis]));
            counted.change = mix(counted.change, to.change);
            counted.gained = [0, 1].map(|axis| mix(counted.gained[axis], to.gained[axis]));
        }
        for (quantity, value) in &mut mixed.quantities {
            *value = mix(*value, other.value(*quantity));
        }
        mixed
    }

    /// The robot's pose (x, y, heading) at an instant between the first and the last stamp.
    pub(super) fn pose_at<T: Number>(&self, instant_s: f64) -> [T; 3] {
        let after = self.stamps_s.partition_point(|stamp_s| *stamp_s <= instant_s).clamp(1, self.stamps_s.len() - 1);
        let (from, to) = (self.poses[after - 1], self.poses[after]);
        let [from_s, to_s] = [after - 1, after].map(|stamp| T::of(self.stamps_s[stamp]));
        let share = (T::of(instant_s) - from_s).over(to_s - from_s);
        let step: Step<T> = Step::between(from, to);
        // Constant speed and turn rate: the displacement up to there, along the mid heading and across it.
        let half_turn_rad = T::of(0.5) * share * step.turn_rad;
        let heading_rad = T::of(from.heading_rad);
        let middle_rad = heading_rad + half_turn_rad;
        let (sin, cos) = (middle_rad.sin(), middle_rad.cos());
        let chord = share * half_turn_rad.sinc();
        let [along_m, left_m] = [chord * step.along_m, chord * step.left_m];
        [
            T::of(from.x_m) + cos * along_m - sin * left_m,
            T::of(from.y_m) + sin * along_m + cos * left_m,
            heading_rad + half_turn_rad + half_turn_rad,
        ]
    }

    /// The instants of this history that surely differ by at most `most_s` from the stamp that a device gave its reading.
    pub(super) fn instants_s(&self, measured_s: f64, most_s: f64) -> Interval {
        let (least, most) = (Interval::point(measured_s) - most_s, Interval::point(measured_s) + most_s);
        let last_s = self.stamps_s[self.stamps_s.len() - 1];
        Interval::new(least.hi(), most.lo()).intersect(Interval::new(self.stamps_s[0], last_s))
    }

    /// The robot's velocity (x, y, heading) about a stamp.
    pub(super) fn velocity_at(&self, stamp: usize) -> [f64; 3] {
        let (from, to) = (stamp.saturating_sub(1), (stamp + 1).min(self.stamps_s.len() - 1));
        let span_s = self.stamps_s[to] - self.stamps_s[from];
        let [from, to] = [from, to].map(|stamp| self.poses[stamp].to_array());
        [0, 1, 2].map(|axis| (to[axis] - from[axis]) / span_s)
    }

    /// Moves the poses after the first one, so that the robot makes these steps from each stamp to the next.
    pub(super) fn set_steps(&mut self, steps: &[Step<f64>]) {
        for (at, step) in steps.iter().enumerate() {
            let from = self.poses[at];
            let (sin, cos) = (from.heading_rad + 0.5 * step.turn_rad).sin_cos();
            let chord = (0.5 * step.turn_rad).sinc();
            self.poses[at + 1] = Pose {
                x_m: from.x_m + chord * (cos * step.along_m - sin * step.left_m),
                y_m: from.y_m + chord * (sin * step.along_m + cos * step.left_m),
                heading_rad: self.poses[at + 1].heading_rad,
            };
        }
    }

    /// The robot's travel from each stamp to the next.
    pub(super) fn steps<T: Number>(&self) -> impl Iterator<Item = Step<T>> {
        self.poses.windows(2).map(|pair| Step::between(pair[0], pair[1]))
    }
}

/// The robot's travel from one stamp to the next.
#[derive(Clone, Copy, Debug)]
pub(super) struct Step<T> {
    /// Travel of the robot's origin along the robot's x axis.
    pub(super) along_m: T,
    /// Travel of the robot's origin along the robot's y axis.
    pub(super) left_m: T,
    /// Turn of the robot.
    pub(super) turn_rad: T,
}

impl<T: Number> Step<T> {
    /// The step that leads from one pose to another at constant speed and constant turn rate τ over the step. The robot then drives on an arc, whose
    /// chord is shorter than the travel by the factor sin ½τ / ½τ: along the mean β of the two headings the displacement is `along_m` times that
    /// factor, and across β it is `left_m` times that factor.
    fn between(from: Pose, to: Pose) -> Step<T> {
        let (from_rad, to_rad) = (T::of(from.heading_rad), T::of(to.heading_rad));
        let half = T::of(0.5);
        let middle_rad = half * (from_rad + to_rad);
        let turn_rad = to_rad - from_rad;
        let (sin, cos) = (middle_rad.sin(), middle_rad.cos());
        let moved_m = [T::of(to.x_m) - T::of(from.x_m), T::of(to.y_m) - T::of(from.y_m)];
        let chord = (half * turn_rad).sinc();
        Step {
            along_m: (cos * moved_m[0] + sin * moved_m[1]).over(chord),
            left_m: (cos * moved_m[1] - sin * moved_m[0]).over(chord),
            turn_rad,
        }
    }
}

/// Sums of the steps' travel up to each stamp, the first of which is 0.
pub(super) fn sums(values: impl Iterator<Item = Interval>) -> Vec<Interval> {
    let mut all = vec![Interval::ZERO];
    let mut sum = Interval::ZERO;
    for value in values {
        sum += value;
        all.push(sum);
    }
    all
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A quarter circle of radius 2 m to the left: the arc is π m long, and the end is 2 m ahead and 2 m to the left.
    #[test]
    fn a_quarter_circle_is_travel_along_the_robot_alone() {
        let quarter_rad = std::f64::consts::FRAC_PI_2;
        let from = Pose { x_m: 1.0, y_m: -3.0, heading_rad: quarter_rad };
        let to = Pose { x_m: -1.0, y_m: -1.0, heading_rad: 2.0 * quarter_rad };
        let step: Step<f64> = Step::between(from, to);
        assert!((step.along_m - std::f64::consts::PI).abs() < 1e-14 && step.left_m.abs() < 1e-14, "{step:?}");
        let enclosed: Step<Interval> = Step::between(from, to);
        assert!(enclosed.along_m.contains(std::f64::consts::PI) && enclosed.along_m.width() < 1e-13);
    }

    /// Two thirds of that quarter circle, about (1, -1) with radius 2 m: the robot has turned by 60 degrees and is at 60 degrees of the circle.
    #[test]
    fn between_two_stamps_the_robot_is_on_its_arc() {
        let quarter_rad = std::f64::consts::FRAC_PI_2;
        let history = History {
            stamps_s: vec![0.0, 3.0],
            poses: vec![
                Pose { x_m: 1.0, y_m: -3.0, heading_rad: 0.0 },
                Pose { x_m: 3.0, y_m: -1.0, heading_rad: quarter_rad },
            ],
            wheel_angle_rad: vec![[0.0; 2]; 2],
            counted: Vec::new(),
            quantities: BTreeMap::new(),
        };
        let expected = [1.0 + 3.0_f64.sqrt(), -2.0, std::f64::consts::PI / 3.0];
        let number: [f64; 3] = history.pose_at(2.0);
        let enclosed: [Interval; 3] = history.pose_at(2.0);
        for axis in 0..3 {
            assert!((number[axis] - expected[axis]).abs() < 1e-14, "{number:?}");
            assert!(enclosed[axis].inflate(1e-15).contains(expected[axis]) && enclosed[axis].width() < 1e-13);
        }
    }
}

//! The quantities that rows relate: each with a reference value, and the deviations from it that are possible.

use std::collections::BTreeMap;

use interval::Interval;

use crate::{PoseBox, RobotModel, reading::LandmarkId};

/// A quantity that the rows of the graph relate.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Variable {
    /// Coordinate of the robot's pose at a key frame, given by the key frame's number: x (0), y (1) or heading (2).
    Pose(usize, usize),
    /// The gyroscope's mean bias on the way to a key frame from the one before, where the bias drifts.
    GyroBias(usize),
    /// Part of the gyroscope's accumulated angle error at a key frame that is bounded at every instant (the constant part of bound `gyro.angle`).
    GyroAngle(usize),
    /// Error of the flow sensor's place by its counts at a key frame, along world x (0) or y (1).
    FlowPlace(usize, usize),
    /// Coordinate of a landmark in the world: x (0) or y (1).
    Landmark(LandmarkId, usize),
    /// A constant of the robot.
    Constant(Constant),
}

/// A constant of the robot that is known within an interval and has one true value in a run.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Constant {
    /// Distance that the left (0) or right (1) wheel rolls in one encoder tick.
    MetresPerTick(usize),
    /// Distance between the contact points of the two drive wheels.
    Track,
    /// Scale factor of the gyroscope.
    GyroScale,
    /// Bias of the gyroscope, where it is constant or where it means the bias of the whole run.
    GyroBias,
    /// Focal length of the range camera, in pixels.
    RangeFocal,
    /// Distance between the optical centres of the range camera's two views.
    RangeBaseline,
    /// Position of the range camera's first view in the robot frame: forward (0) or left (1).
    RangePosition(usize),
    /// Direction of the range camera's optical axis from robot forward.
    RangeYaw,
    /// Travel per count of the flow sensor at its mounted height.
    FlowMetresPerCount,
    /// Angle of the flow sensor's forward axis from the robot's.
    FlowYaw,
    /// Position of the spot that the flow sensor sees in the robot frame: forward (0) or left (1).
    FlowPosition(usize),
}

/// The reference values and boxes of all quantities.
#[derive(Clone, Debug, Default)]
pub struct Domain {
    values: BTreeMap<Variable, (f64, Interval)>,
}

impl Domain {
    /// The domain that has the constants of a robot, around the middles of their intervals.
    pub fn of_constants(robot: &RobotModel) -> Domain {
        let mut domain = Domain::default();
        let mut put = |constant, value: Interval| domain.put(Variable::Constant(constant), value);
        for wheel in 0..2 {
            put(Constant::MetresPerTick(wheel), robot.wheels.metres_per_tick(wheel));
        }
        put(Constant::Track, robot.wheels.track_m);
        if let Some(gyro) = &robot.gyro {
            put(Constant::GyroScale, gyro.scale);
            put(Constant::GyroBias, gyro.bias_rad_per_s);
        }
        if let Some(camera) = &robot.range_camera {
            put(Constant::RangeFocal, camera.focal_px);
            put(Constant::RangeBaseline, camera.baseline_m);
            (0..2).for_each(|axis| put(Constant::RangePosition(axis), camera.position_m[axis]));
            put(Constant::RangeYaw, camera.yaw_rad);
        }
        if let (Some(flow), Some(_)) = (&robot.flow, &robot.gyro) {
            put(Constant::FlowMetresPerCount, flow.metres_per_count);
            put(Constant::FlowYaw, flow.yaw_rad);
            (0..2).for_each(|axis| put(Constant::FlowPosition(axis), flow.position_m[axis]));
        }
        domain
    }

    /// Sets the interval of a quantity, whose middle becomes the reference value.
    pub fn put(&mut self, variable: Variable, value: Interval) {
        self.values.insert(variable, (value.mid(), value));
    }

    /// Sets the box of a key frame's pose, whose middle becomes the reference pose.
    pub fn put_pose(&mut self, frame: usize, pose: &PoseBox) {
        (0..3).for_each(|axis| self.put(Variable::Pose(frame, axis), pose[axis]));
    }

    /// Interval of a quantity; empty for one that the domain does not have.
    pub fn value(&self, variable: Variable) -> Interval {
        self.values.get(&variable).map_or(Interval::EMPTY, |&(_, value)| value)
    }

    /// Reference value of a quantity; not a number for one that the domain does not have.
    pub fn reference(&self, variable: Variable) -> f64 {
        self.values.get(&variable).map_or(f64::NAN, |&(reference, _)| reference)
    }

    /// Deviations of a quantity from its reference value that are possible.
    pub fn deviation(&self, variable: Variable) -> Interval {
        self.value(variable) - Interval::point(self.reference(variable))
    }

    /// All quantities with their intervals, in the order of the variables.
    pub fn iter(&self) -> impl Iterator<Item = (Variable, Interval)> {
        self.values.iter().map(|(&variable, &(_, value))| (variable, value))
    }
}

//! The quantities that rows relate: each with a reference value, and the deviations from it that are possible.

use std::collections::BTreeMap;

use interval::Interval;

use crate::{
    PoseBox, RobotModel, bounds, bounds::Assumption, markers::MarkerId, reading::LandmarkId, robot::cayley_radius,
};

use super::Stray;

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
    /// What the pose that the reading at a key frame shows is displaced from the pose at its stamp: along world x (0), along y (1), or in heading (2).
    Shift(usize, usize),
    /// Lean of the body at a key frame, as a component of its Cayley vector along x (0) or y (1) of the robot frame.
    BodyTilt(usize, usize),
    /// Coordinate of a landmark in the world: x (0) or y (1).
    Landmark(LandmarkId, usize),
    /// What the tilt of the range camera's mount displaces a landmark by in the robot frame: forward (0) or left (1). It is the landmark's height above
    /// the camera times the tilt, and so the same whenever the landmark is seen.
    TiltedLandmark(LandmarkId, usize),
    /// Coordinate of a landmark in space as seen from its anchor, in homogeneous form: the two slopes of its ray (0 and 1) and its inverse depth (2).
    Point(LandmarkId, usize),
    /// Coordinate of the pose from which a picture of the drive that taught a map was taken, given by the picture's place among those of the map: x (0),
    /// y (1) or heading (2).
    ViewPose(usize, usize),
    /// Constant of the camera of a drive that taught a map, given by the drive's place among those drives, and by the constant as one of this robot's.
    ViewConstant(usize, Constant),
    /// Distance of a ceiling marker from its place on the map, along world x (0) or y (1).
    Marker(MarkerId, usize),
    /// Height of a ceiling marker above the floor.
    MarkerHeight(MarkerId),
    /// Distance of one end of a joint between tiles from its nominal place, along the joint's normal. The joint is given by the axis of the tile
    /// grid that is its normal, and by its number along that axis; its ends are the first (0) and the last (1) one.
    JointEnd(usize, i64, usize),
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
    /// Image scale of the floor camera, in pixels per metre of floor.
    FloorScale,
    /// Rotation of the floor camera about the vertical.
    FloorYaw,
    /// Tilt of the floor camera's mount, which acts before the yaw, as a component of its Cayley vector along forward (0) or left (1) of the picture.
    FloorTilt(usize),
    /// Position of the floor camera in the robot frame: forward (0) or left (1).
    FloorPosition(usize),
    /// Focal length of the ceiling camera along u (0) or v (1), in pixels.
    CeilingFocal(usize),
    /// Principal point of the ceiling camera: u (0) or v (1), in pixels.
    CeilingCentre(usize),
    /// Rotation of the ceiling camera about the vertical.
    CeilingYaw,
    /// Error of the tilt of the ceiling camera's mount, which acts before the yaw, as a component of its Cayley vector along forward (0) or left (1) of
    /// the picture.
    CeilingTilt(usize),
    /// Position of the ceiling camera in the robot frame: forward (0) or left (1).
    CeilingPosition(usize),
    /// Height of the ceiling camera above the floor at rest.
    CeilingHeight,
    /// Position of the satellite navigation receiver's antenna in the robot frame: forward (0) or left (1).
    GnssPosition(usize),
    /// Focal length of the point camera, in pixels.
    PointFocal,
    /// Principal point of the point camera: u (0) or v (1), in pixels.
    PointCentre(usize),
    /// Rotation of the point camera about the vertical.
    PointYaw,
    /// Tilt of the point camera's mount, which acts before the yaw, as a component of its Cayley vector along forward (0) or left (1) of the camera.
    PointTilt(usize),
    /// Position of the point camera in the robot frame: forward (0) or left (1).
    PointPosition(usize),
    /// Height of the point camera above the floor at rest.
    PointHeight,
}

impl Variable {
    /// The same quantity at a given key frame, if it belongs to a key frame.
    pub fn at_frame(self, frame: usize) -> Variable {
        match self {
            Variable::Pose(_, axis) => Variable::Pose(frame, axis),
            Variable::GyroBias(_) => Variable::GyroBias(frame),
            Variable::GyroAngle(_) => Variable::GyroAngle(frame),
            Variable::FlowPlace(_, axis) => Variable::FlowPlace(frame, axis),
            Variable::Shift(_, axis) => Variable::Shift(frame, axis),
            Variable::BodyTilt(_, axis) => Variable::BodyTilt(frame, axis),
            other => other,
        }
    }

    /// The key frame that the quantity belongs to.
    pub fn frame(self) -> Option<usize> {
        match self {
            Variable::Pose(frame, _)
            | Variable::GyroBias(frame)
            | Variable::GyroAngle(frame)
            | Variable::FlowPlace(frame, _)
            | Variable::Shift(frame, _)
            | Variable::BodyTilt(frame, _) => Some(frame),
            _ => None,
        }
    }

    /// The declared bound that makes the quantity's interval; `None` for poses and landmarks, whose boxes come from many readings, and for errors of
    /// counting.
    pub fn bound(self) -> Option<Assumption> {
        match self {
            Variable::GyroBias(_) => Some(bounds::GYRO_BIAS),
            Variable::GyroAngle(_) => Some(bounds::GYRO_ANGLE),
            Variable::BodyTilt(..) => Some(bounds::BODY_TILT),
            Variable::TiltedLandmark(..) => Some(bounds::RANGE_CAMERA_TILT),
            Variable::Marker(..) => Some(bounds::MARKERS_PLACEMENT),
            Variable::MarkerHeight(_) => Some(bounds::MARKERS_HEIGHT),
            Variable::JointEnd(..) => Some(bounds::FLOOR_TILES_LAYING),
            Variable::Constant(constant) => Some(constant.bound()),
            _ => None,
        }
    }
}

impl Constant {
    /// The declared bound that makes the constant's interval.
    pub fn bound(self) -> Assumption {
        match self {
            Constant::MetresPerTick(_) => bounds::WHEELS_RADIUS,
            Constant::Track => bounds::WHEELS_TRACK,
            Constant::GyroScale => bounds::GYRO_SCALE,
            Constant::GyroBias => bounds::GYRO_BIAS,
            Constant::RangeFocal => bounds::RANGE_CAMERA_FOCAL,
            Constant::RangeBaseline => bounds::RANGE_CAMERA_BASELINE,
            Constant::RangePosition(_) => bounds::RANGE_CAMERA_POSITION,
            Constant::RangeYaw => bounds::RANGE_CAMERA_YAW,
            Constant::FlowMetresPerCount => bounds::FLOW_CALIBRATION,
            Constant::FlowYaw => bounds::FLOW_YAW,
            Constant::FlowPosition(_) => bounds::FLOW_POSITION,
            Constant::FloorScale => bounds::FLOOR_CAMERA_SCALE,
            Constant::FloorYaw => bounds::FLOOR_CAMERA_YAW,
            Constant::FloorTilt(_) => bounds::FLOOR_CAMERA_TILT,
            Constant::FloorPosition(_) => bounds::FLOOR_CAMERA_POSITION,
            Constant::CeilingFocal(_) => bounds::CEILING_CAMERA_FOCAL,
            Constant::CeilingCentre(_) => bounds::CEILING_CAMERA_CENTRE,
            Constant::CeilingYaw => bounds::CEILING_CAMERA_YAW,
            Constant::CeilingTilt(_) => bounds::CEILING_CAMERA_TILT,
            Constant::CeilingPosition(_) => bounds::CEILING_CAMERA_POSITION,
            Constant::CeilingHeight => bounds::CEILING_CAMERA_HEIGHT,
            Constant::GnssPosition(_) => bounds::GNSS_ANTENNA,
            Constant::PointFocal => bounds::POINT_CAMERA_FOCAL,
            Constant::PointCentre(_) => bounds::POINT_CAMERA_CENTRE,
            Constant::PointYaw => bounds::POINT_CAMERA_YAW,
            Constant::PointTilt(_) => bounds::POINT_CAMERA_TILT,
            Constant::PointPosition(_) => bounds::POINT_CAMERA_POSITION,
            Constant::PointHeight => bounds::POINT_CAMERA_HEIGHT,
        }
    }
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
        if let Some(camera) = &robot.floor_camera {
            let tilt = cayley_radius(camera.tilt_rad);
            put(Constant::FloorScale, camera.pixels_per_m);
            put(Constant::FloorYaw, camera.yaw_rad);
            (0..2).for_each(|axis| put(Constant::FloorTilt(axis), Interval::new(-tilt, tilt)));
            (0..2).for_each(|axis| put(Constant::FloorPosition(axis), camera.position_m[axis]));
        }
        if let Some(camera) = &robot.ceiling_camera {
            let tilt = cayley_radius(camera.tilt_rad);
            (0..2).for_each(|axis| put(Constant::CeilingFocal(axis), camera.focal_px[axis]));
            (0..2).for_each(|axis| put(Constant::CeilingCentre(axis), camera.centre_px[axis]));
            put(Constant::CeilingYaw, camera.yaw_rad);
            (0..2).for_each(|axis| put(Constant::CeilingTilt(axis), Interval::new(-tilt, tilt)));
            (0..2).for_each(|axis| put(Constant::CeilingPosition(axis), camera.position_m[axis]));
            put(Constant::CeilingHeight, camera.height_m);
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

    /// Adds a pose that is displaced from that at a key frame of another domain by a distance in any direction and by a turn. It has the reference
    /// values of the key frame's pose, and the number that is given after the key frame's.
    pub fn displace(&mut self, from: &Domain, [frame, shown]: [usize; 2], by: &Stray) {
        for axis in 0..3 {
            if let Some(&(reference, value)) = from.values.get(&Variable::Pose(frame, axis)) {
                self.values.insert(Variable::Pose(shown, axis), (reference, value.inflate(by.of_axis(axis))));
            }
        }
    }

    /// Leaves out all quantities but those that the condition holds for.
    pub fn retain(&mut self, condition: impl Fn(Variable) -> bool) {
        self.values.retain(|&variable, _| condition(variable));
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

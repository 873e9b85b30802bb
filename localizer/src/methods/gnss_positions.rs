//! `gnss_positions`: positions of an antenna on the robot, as a receiver of satellite navigation tells them.
//!
//! **Constraint.** a = t + R(θ) b: a is the antenna in the world, within the receiver's declared error of what it tells, b the antenna on the
//! robot, within how well it was measured and how far the body's lean takes it. One position bounds x and y, and with a lever arm b ≠ 0 the
//! heading to an arc; positions from different places tell the heading by the way between them.
//!
//! A receiver says of each position whether its ambiguities are resolved (*fixed*) or not (*floating*), and each of the two has a bound of its own.

use interval::Interval;

use crate::{
    PoseUnion, Reading,
    bounds::{self, Assumption},
    method::{Constraint, Method},
    motion::Twist,
    quota::Quota,
    rigid_motion::RigidPlanar,
    robot::RobotModel,
};

/// The name of the device whose readings these are.
pub const DEVICE: &str = "gnss";

/// The bounds that every constraint stands on, beside that of its grade.
const RELIES_ON: [Assumption; 5] =
    [bounds::GNSS_ANTENNA, bounds::GNSS_STAMP, bounds::BODY_TILT, bounds::REACH_SPEED, bounds::REACH_TURN_RATE];

/// A receiver as the localizer is told of it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ReceiverModel {
    /// The antenna in the robot frame: forward and left, `gnss.antenna`.
    pub position_m: [Interval; 2],
    /// Its height above the floor.
    pub height_m: f64,
    /// Greatest error of either coordinate of a fixed position, `gnss.fixed`.
    pub fixed_m: f64,
    /// Greatest error of either coordinate of a floating position, `gnss.floating`.
    pub floating_m: f64,
    /// Greatest error of a stamp, `gnss.stamp`.
    pub stamp_error_s: f64,
}

/// A position as a receiver tells it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Position {
    /// World x and y of the antenna.
    pub at_m: [f64; 2],
    /// Whether its ambiguities are resolved.
    pub is_fixed: bool,
}

impl Position {
    /// The numbers of a [`Reading::Other`].
    pub fn numbers(&self) -> Vec<f64> {
        vec![self.at_m[0], self.at_m[1], f64::from(u8::from(self.is_fixed))]
    }

    /// The position that numbers tell; `None` if they tell none.
    pub fn of(numbers: &[f64]) -> Option<Position> {
        let &[x_m, y_m, grade] = numbers else { return None };
        let is_told = x_m.is_finite() && y_m.is_finite() && [0.0, 1.0].contains(&grade);
        is_told.then_some(Position { at_m: [x_m, y_m], is_fixed: grade == 1.0 })
    }
}

/// The method; see the module.
#[derive(Clone, Debug)]
pub struct GnssPositions {
    receiver: ReceiverModel,
    robot: RobotModel,
}

impl GnssPositions {
    /// The method for this receiver on this robot.
    pub fn new(receiver: ReceiverModel, robot: &RobotModel) -> Self {
        GnssPositions { receiver, robot: robot.clone() }
    }

    /// The antenna in the robot frame, seen from above: a body that leans by up to φ takes it by up to h·sin φ to any side, and foreshortens
    /// its lever arm b by up to |b|·(1 − cos φ).
    fn antenna_m(&self) -> [Interval; 2] {
        let lean = Interval::new(0.0, self.robot.body.tilt_rad);
        let [forward, left] = self.receiver.position_m;
        let lever = Interval::point(forward.magnitude()) + Interval::point(left.magnitude());
        let shift = Interval::point(self.receiver.height_m) * lean.sin() + lever * (Interval::point(1.0) - lean.cos());
        let beside = Interval::new(-shift.hi(), shift.hi());
        [forward + beside, left + beside]
    }

    /// How far the antenna may get in the time by which a stamp may be wrong.
    fn moved_m(&self) -> Interval {
        let [forward, left] = self.antenna_m();
        let lever = Interval::point(forward.magnitude()) + Interval::point(left.magnitude());
        let (reach, error_s) = (&self.robot.reach, Interval::point(self.receiver.stamp_error_s));
        let far = error_s * (Interval::point(reach.speed_m_per_s) + lever * Interval::point(reach.turn_rate_rad_per_s));
        Interval::new(-far.hi(), far.hi())
    }
}

impl Method for GnssPositions {
    fn name(&self) -> &'static str {
        "gnss_positions"
    }

    fn reads(&self, reading: &Reading) -> bool {
        matches!(reading, Reading::Other { device, .. } if device == DEVICE)
    }

    fn constrain(&mut self, reading: &Reading, _prior: &PoseUnion, _twist: &Twist) -> Option<Constraint> {
        let Reading::Other { measured_s, numbers, .. } = reading else { return None };
        let told = Position::of(numbers)?;
        let (grade, within_m) = if told.is_fixed {
            (bounds::GNSS_FIXED, self.receiver.fixed_m)
        } else {
            (bounds::GNSS_FLOATING, self.receiver.floating_m)
        };
        let in_world_m = told.at_m.map(|at_m| Interval::centred(at_m, within_m) + self.moved_m());
        Some(Constraint {
            method: self.name(),
            stamp_s: *measured_s,
            on_pose: Box::new(RigidPlanar::new(&[(in_world_m, self.antenna_m())])),
            relies_on: RELIES_ON.into_iter().chain([grade]).collect(),
            // A position is no matter of vision: what is wrong of it is beyond its bound.
            claims: Vec::new(),
            quota: Quota::of_each(0),
            // Alone it leaves the heading open, but those of a doubt's many positions do not.
            decides: true,
            rejected_px: Vec::new(),
            alone_heading_rad: None,
        })
    }
}

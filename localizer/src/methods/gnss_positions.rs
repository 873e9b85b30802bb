//! `gnss_positions`: a method that bounds the pose by positions of an antenna on the robot, as a satellite navigation receiver reports
//! them.
//!
//! **Constraint.** a = t + R(θ) b, with t the robot's position and θ its heading. Here a is the antenna in the world, within the receiver's
//! declared error of the reported position, and b is the antenna on the robot, within the accuracy to which it was measured and the shift
//! that the body's lean causes. One position bounds x and y, and with a lever arm b ≠ 0 bounds the heading to an arc.
//!
//! Positions of the last seconds count as well. With the robot's motion since a held position, a displacement m and a turn δ, the antenna of
//! that time lies at R(−δ)(b − m) as seen from the robot at the latest stamp, and in the world where the receiver reported it: another
//! landmark of the same rigid motion. In this way the path between positions tells the heading. Once the heading is known to some degrees, the
//! graph of key frames relates positions over minutes in the same way.
//!
//! A receiver says of each position whether its ambiguities are resolved (*fixed*) or not (*floating*), and each of the two grades has a
//! bound of its own.

mod relate;

use std::sync::Arc;

use interval::Interval;

use crate::{
    Reading,
    bounds::{self, Assumption},
    method::{Constraint, Context, Method},
    motion::Motion,
    rigid_motion::{Landmark, RigidPlanar},
    robot::RobotModel,
};

use relate::AntennaAt;

/// Name of the satellite navigation receiver as a device whose readings the method uses.
pub const DEVICE: &str = "gnss";

/// Declared bounds that every constraint from satellite positions relies on, besides the bound of the position's grade (fixed or floating).
const RELIES_ON: [Assumption; 5] =
    [bounds::GNSS_ANTENNA, bounds::GNSS_STAMP, bounds::BODY_TILT, bounds::REACH_SPEED, bounds::REACH_TURN_RATE];

/// Satellite navigation receiver as the localizer knows it, by declared values.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ReceiverModel {
    /// Position of the antenna in the robot frame: forward and left, `gnss.antenna`.
    pub position_m: [Interval; 2],
    /// Height of the receiver's antenna above the floor.
    pub height_m: f64,
    /// Greatest error of either coordinate of a satellite position with resolved ambiguities (fixed), `gnss.fixed`.
    pub fixed_m: f64,
    /// Greatest error of either coordinate of a satellite position without resolved ambiguities (floating), `gnss.floating`.
    pub floating_m: f64,
    /// Greatest error of a satellite position's stamp, `gnss.stamp`.
    pub stamp_error_s: f64,
}

/// Position that a satellite navigation receiver reports.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Position {
    /// World x and y of the antenna, as the receiver reports them.
    pub at_m: [f64; 2],
    /// Whether the carrier-phase ambiguities of the satellite position are resolved.
    pub is_fixed: bool,
}

impl Position {
    /// Numbers that encode the position in a [`Reading::Other`].
    pub fn numbers(&self) -> Vec<f64> {
        vec![self.at_m[0], self.at_m[1], f64::from(u8::from(self.is_fixed))]
    }

    /// Position that the numbers of a reading encode; `None` if they encode none.
    pub fn of(numbers: &[f64]) -> Option<Position> {
        let &[x_m, y_m, grade] = numbers else { return None };
        let is_told = x_m.is_finite() && y_m.is_finite() && [0.0, 1.0].contains(&grade);
        is_told.then_some(Position { at_m: [x_m, y_m], is_fixed: grade == 1.0 })
    }
}

/// Least time between two satellite positions that are held for use with later ones: positions that are closer in time say the same about
/// the pose.
const APART_S: f64 = 0.3;
/// Greatest number of satellite positions that are held. They are carried by remembered motion readings, which reach back some 3 s.
const MOST_HELD: usize = 10;
/// Time for which the errors of floating positions are similar, by reflections and by the atmosphere, so that two positions within it do
/// not count as two independent pieces of evidence when a doubt is to be ended. The errors wander within seconds to minutes; scenes draw
/// them anew every 5 s.
const FLOATING_ALIKE_S: f64 = 5.0;

/// Method that bounds the pose by positions of a satellite navigation receiver; the module's page says how.
#[derive(Clone, Debug)]
pub struct GnssPositions {
    receiver: ReceiverModel,
    robot: RobotModel,
    /// Stamp of the last floating satellite position that counted as evidence independent of those before it.
    floating_witness_s: f64,
}

/// Satellite position of the last seconds that is held to be used with later ones.
#[derive(Clone, Debug)]
struct Held {
    grade: Assumption,
    in_world_m: [Interval; 2],
}

impl GnssPositions {
    /// Makes the positioning method for a satellite navigation receiver on a robot.
    pub fn new(receiver: ReceiverModel, robot: &RobotModel) -> Self {
        GnssPositions { receiver, robot: robot.clone(), floating_witness_s: f64::NEG_INFINITY }
    }

    /// Interval of the antenna's place in the robot frame, seen from above: a body that leans by up to φ shifts the antenna, at the height
    /// h, by up to h·sin φ to any side, and foreshortens its lever arm b by up to |b|·(1 − cos φ).
    fn antenna_m(&self) -> [Interval; 2] {
        let [forward, left] = self.receiver.position_m;
        let beside = self.lean_m();
        [forward + beside, left + beside]
    }

    /// How far the body's lean may displace the antenna forward or left, as an interval around 0.
    fn lean_m(&self) -> Interval {
        let shift = self.robot.body.most_leant_m(self.receiver.position_m, self.receiver.height_m);
        Interval::new(-shift.hi(), shift.hi())
    }

    /// Position of the antenna before a motion of the robot, in the frame of the robot after it.
    fn antenna_before_m(&self, moved: &Motion) -> [Interval; 2] {
        let antenna_m = self.antenna_m();
        let (sin, cos) = (moved[2].sin(), moved[2].cos());
        let [from_x, from_y] = [antenna_m[0] - moved[0], antenna_m[1] - moved[1]];
        [cos * from_x + sin * from_y, cos * from_y - sin * from_x]
    }

    /// Greatest distance that the antenna may move within the greatest error of a satellite position's stamp, as an interval around 0.
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

    fn n_earlier(&self) -> usize {
        MOST_HELD
    }

    fn constrain(&mut self, reading: &Reading, context: &Context) -> Option<Constraint> {
        let Reading::Other { measured_s, numbers, .. } = reading else { return None };
        let told = Position::of(numbers)?;
        let (grade, within_m) = if told.is_fixed {
            (bounds::GNSS_FIXED, self.receiver.fixed_m)
        } else {
            (bounds::GNSS_FLOATING, self.receiver.floating_m)
        };
        let in_world_m = told.at_m.map(|at_m| Interval::centred(at_m, within_m) + self.moved_m());
        let now = (in_world_m, self.antenna_m());
        let held: Vec<(&Held, &Motion)> =
            context.earlier.iter().filter_map(|earlier| Some((earlier.shown()?, &earlier.moved))).collect();
        let before = held.iter().map(|(held, moved)| (held.in_world_m, self.antenna_before_m(moved)));
        let landmarks: Vec<Landmark> = std::iter::once(now).chain(before).collect();
        let mut relies_on = RELIES_ON.to_vec();
        for grade in std::iter::once(grade).chain(held.iter().map(|(held, _)| held.grade)) {
            if !relies_on.contains(&grade) {
                relies_on.push(grade);
            }
        }
        let is_alike = !told.is_fixed && (measured_s - self.floating_witness_s).abs() < FLOATING_ALIKE_S;
        if !told.is_fixed && !is_alike {
            self.floating_witness_s = *measured_s;
        }
        let is_apart = context.earlier.last().is_none_or(|last| *measured_s >= last.stamp_s + APART_S);
        Some(Constraint {
            by_itself: (landmarks.len() > 1).then(|| Box::new(RigidPlanar::new(&landmarks[..1])) as Box<_>),
            relies_on,
            // A single position leaves the heading open, but the many positions during a doubt about a failed assumption do not. So a
            // position counts as evidence to end the doubt, unless it is floating and soon after another.
            decides: !is_alike,
            shown: Some(Arc::new(Held { grade, in_world_m })),
            is_held: is_apart,
            relations: Some(Arc::new(AntennaAt {
                told_m: told.at_m,
                within: (grade, within_m),
                position_m: self.receiver.position_m,
                lean_m: self.lean_m(),
                stamp_error_s: self.receiver.stamp_error_s,
            })),
            // Claims are assertions of what a camera saw, so that a satellite position has none: it is wrong only where its error exceeds
            // the declared bound.
            ..Constraint::new(self.name(), *measured_s, RigidPlanar::new(&landmarks))
        })
    }
}

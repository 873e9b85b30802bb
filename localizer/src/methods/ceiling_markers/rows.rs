//! Rows of a rolling shutter: a dot is seen from where the robot was when the dot's row was exposed, which is not where it was at the image's stamp.
//!
//! A dot that is at q in the level robot frame at its row's exposure is at t + R(δ) q in that at the stamp, if the robot has moved by t and turned by
//! δ from the stamp to the row. The apparent frame is turned by the error ε of the camera's yaw, in which this is R(−ε) t + R(δ) q.

use interval::Interval;

use crate::{
    method::MotionBetween,
    motion,
    robot::{CeilingCameraModel, Reach, RobotModel},
};

use super::super::rows;
use super::ray::{BODY_TILT, DOT_HEIGHT, SeenDot};

/// Factor that makes up for the rounding of a sum of two numbers.
const ABOVE: f64 = 1.0 + 1e-12;

/// Exposure of the rows of one image, and how the robot moved and leant meanwhile.
pub(super) struct Rows<'a> {
    exposed: rows::Rows<'a>,
    stamp_error_s: f64,
    /// Greatest error of the camera's yaw.
    yaw_error_rad: f64,
    heave_m: f64,
    reach: Reach,
    /// Greatest change of the turn rate in a second.
    turn_change_rad_per_s2: f64,
}

impl<'a> Rows<'a> {
    /// The rows of an image with the stamp `stamp_s`; `None` for a global shutter.
    pub(super) fn of(
        camera: &CeilingCameraModel,
        robot: &RobotModel,
        stamp_s: f64,
        motion: MotionBetween<'a>,
    ) -> Option<Rows<'a>> {
        Some(Rows {
            exposed: rows::Rows::of((camera.row_time_s, camera.height_px), stamp_s, robot.reach, motion)?,
            stamp_error_s: camera.stamp_error_s,
            yaw_error_rad: camera.yaw_rad.radius(),
            heave_m: robot.body.heave_m,
            reach: robot.reach,
            turn_change_rad_per_s2: motion::greatest_change_rad_per_s2(&robot.wheels, &robot.reach),
        })
    }

    /// The dot as it would be seen if its row had been exposed at the image's stamp. What is left of the motion is added to the error of the dot's
    /// place in the world, and so is what the body's lean makes, which may be another one at each row.
    pub(super) fn at_stamp(&self, dot: &SeenDot, [_, v, bound_px]: [f64; 3]) -> SeenDot {
        let [ahead, left, turn] = self.exposed.moved(v, bound_px);
        let (sight, middle_turn) = (&dot.sight, Interval::point(turn.mid()));
        let (cos, sin) = (middle_turn.cos(), middle_turn.sin());
        let turned = |[x, y]: [Interval; 2]| [x * cos - y * sin, x * sin + y * cos];
        let [x, y] = turned(sight.middle_m);
        let mut moved = *dot;
        moved.sight.middle_m = [x + Interval::point(ahead.mid()), y + Interval::point(left.mid())];
        for parameter in 0..sight.deviations.len() {
            let [x, y] = turned([0, 1].map(|axis| sight.slopes[axis][parameter]));
            (moved.sight.slopes[0][parameter], moved.sight.slopes[1][parameter]) = (x, y);
        }
        for tilt in BODY_TILT {
            moved.sight.deviations[tilt] = Interval::ZERO;
            (0..2).for_each(|axis| moved.sight.slopes[axis][tilt] = Interval::ZERO);
        }
        let slack_m = self.slack_m(dot, [ahead, left, turn], self.exposed.after_s(v)).hi();
        moved.in_world_m = moved.in_world_m.map(|side| side.inflate(slack_m));
        moved
    }

    /// Greatest distance by which the dot's place at the stamp may be beside what its middle motion makes of it.
    fn slack_m(&self, dot: &SeenDot, [ahead, left, turn]: [Interval; 3], after_s: f64) -> Interval {
        let sight = &dot.sight;
        let away = [0, 1].map(|axis| {
            let terms = sight.slopes[axis].iter().zip(&sight.deviations);
            terms.fold(sight.middle_m[axis], |sum, (slope, deviation)| sum + *slope * *deviation)
        });
        let away_m = away[0].hypot(away[1]);
        let of_motion = Interval::point(ahead.radius()).hypot(Interval::point(left.radius()))
            + away_m * turn.radius()
            + ahead.hypot(left) * self.yaw_error_rad;
        // The body heaves otherwise at the row's exposure than at the stamp, by up to twice its bound.
        let of_heave = sight.slopes[0][DOT_HEIGHT].hypot(sight.slopes[1][DOT_HEIGHT]) * (2.0 * self.heave_m);
        // Both components of the lean lie in a disc, so that the dot moves by at most its radius times the norm of the slopes' matrix. The square of
        // this norm is at most the greatest sum of a row times the greatest sum of a column.
        let slope = |axis: usize, tilt: usize| sight.slopes[axis][BODY_TILT[tilt]].magnitude();
        let most = |sums: [f64; 2]| Interval::point(sums[0].max(sums[1])) * ABOVE;
        let norm = most([0, 1].map(|axis| slope(axis, 0) + slope(axis, 1)))
            * most([0, 1].map(|tilt| slope(0, tilt) + slope(1, tilt)));
        let of_lean = norm.sqrt() * sight.deviations[BODY_TILT[0]].magnitude();
        // All rows are off by the stamp's error alike, but for what the dot's speed changes meanwhile: by the wheels' acceleration, by the turn of the
        // direction in which the robot drives, and on the arm from the robot to the dot.
        let Reach { speed_m_per_s, turn_rate_rad_per_s, acceleration_m_per_s2 } = self.reach;
        let change_m_per_s2 = away_m * (self.turn_change_rad_per_s2 + turn_rate_rad_per_s * turn_rate_rad_per_s)
            + (acceleration_m_per_s2 + speed_m_per_s * turn_rate_rad_per_s);
        of_motion + of_heave + of_lean + change_m_per_s2 * (self.stamp_error_s * after_s.abs())
    }
}

//! Bounds on the motion that hold without any reading: the start, speed, turn rate, posture and the distance from walls.

use interval::Interval;
use localizer::{PoseBox, bounds, robot::RobotModel};

use super::{
    history::{History, Quantity, Step},
    kind::{Broken, Declared, Kind, Linearised, demand, within},
};

/// What is known of the robot's motion without any reading.
pub(super) struct Motion {
    pub(super) start: PoseBox,
    pub(super) robot: RobotModel,
    /// Ranges of world x and y that the robot's origin does not leave.
    pub(super) room_m: [Interval; 2],
    /// Stamps at which a device looked at something, each once.
    pub(super) looks: Vec<usize>,
}

/// What is broken when a history begins outside the box of start poses. The box is given, and has no name among the bounds.
const START: &str = "start";

impl Motion {
    fn check_speeds(&self, history: &History, slack: f64) -> Result<(), Broken> {
        let reach = &self.robot.reach;
        for (step, pair) in history.steps::<Interval>().zip(history.stamps_s.windows(2)) {
            let span_s = Interval::point(pair[1]) - Interval::point(pair[0]);
            let Step { along_m, left_m, turn_rad } = step;
            let speed = along_m.hypot(left_m) / span_s;
            demand(slack, bounds::REACH_SPEED, pair[1], speed, within(Interval::point(reach.speed_m_per_s)))?;
            let rate = turn_rad / span_s;
            demand(slack, bounds::REACH_TURN_RATE, pair[1], rate, within(Interval::point(reach.turn_rate_rad_per_s)))?;
        }
        Ok(())
    }

    fn check_posture(&self, history: &History, slack: f64) -> Result<(), Broken> {
        let body = &self.robot.body;
        for (quantity, roll_rad) in &history.quantities {
            let Quantity::BodyTilt(stamp, 0) = *quantity else { continue };
            let pitch_rad = Interval::point(history.value(Quantity::BodyTilt(stamp, 1)));
            let tilt_rad = Interval::point(*roll_rad).hypot(pitch_rad);
            let time_s = history.stamps_s.get(stamp).copied().unwrap_or(f64::NAN);
            demand(slack, bounds::BODY_TILT, time_s, tilt_rad, within(Interval::point(body.tilt_rad)))?;
        }
        Ok(())
    }
}

impl Kind for Motion {
    /// Heave and tilt of the body at every look.
    fn declared(&self, _history: &History) -> Vec<Declared> {
        let body = &self.robot.body;
        let tilts_rad = Interval::new(-body.tilt_rad, body.tilt_rad);
        let heaves_m = Interval::new(-body.heave_m, body.heave_m);
        let of_look = |&stamp: &usize| {
            let tilt = |axis: usize| Declared {
                quantity: Quantity::BodyTilt(stamp, axis),
                interval: tilts_rad,
                bound: bounds::BODY_TILT,
            };
            let heave = Declared { quantity: Quantity::Heave(stamp), interval: heaves_m, bound: bounds::BODY_HEAVE };
            [tilt(0), tilt(1), heave]
        };
        self.looks.iter().flat_map(of_look).collect()
    }

    fn check(&self, history: &History, slack: f64) -> Result<(), Broken> {
        let first = history.poses[0].to_array();
        for (axis, value) in first.into_iter().enumerate() {
            demand(slack, START, history.stamps_s[0], Interval::point(value), self.start[axis])?;
        }
        let clearance_m = self.robot.body.clearance_m;
        for (time_s, pose) in history.stamps_s.iter().zip(&history.poses) {
            for (value_m, room_m) in [pose.x_m, pose.y_m].into_iter().zip(self.room_m) {
                let left =
                    Interval::new((room_m.lo() + clearance_m).next_up(), (room_m.hi() - clearance_m).next_down());
                demand(slack, bounds::ROOM_WALLS, *time_s, Interval::point(value_m), left)?;
            }
        }
        self.check_speeds(history, slack)?;
        self.check_posture(history, slack)
    }

    fn add_rows(&self, near: &mut Linearised<'_>) {
        let history = near.history;
        for (axis, value) in history.poses[0].to_array().into_iter().enumerate() {
            near.hold(axis, value, self.start[axis]);
        }
        let clearance_m = self.robot.body.clearance_m;
        for knot in 0..near.knots.len() {
            let pose = history.poses[near.knots[knot]].to_array();
            for (axis, room_m) in self.room_m.into_iter().enumerate() {
                let left = Interval::new(room_m.lo() + clearance_m, room_m.hi() - clearance_m);
                near.add(vec![(near.at_knot(knot, axis), 1.0)], pose[axis], left);
            }
        }
        for stamp in history.looks() {
            near.add_disc([0, 1].map(|axis| Quantity::BodyTilt(stamp, axis)), self.robot.body.tilt_rad);
        }
    }
}

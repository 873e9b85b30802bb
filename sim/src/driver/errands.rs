//! Driver for errands: plans paths to goals and follows them by the estimated pose. When a path is blocked it waits, then looks for another one.

use localizer::{Estimate, Pose, PoseBox, Status};

use crate::{
    base::DriveCommand,
    devices::scanner::Fan,
    place::navigation::{OccupancyGrid, Planner},
    scene::{Navigation, Scene},
};

use super::{CREEP_M_PER_S, Driver, Wish, surroundings::Surroundings, turn_then_drive::bearing};

mod log;
mod patience;
mod way;

pub use log::{ErrandLog, ErrandRecord, Leg, Outcome};
use way::Law;

/// Width in x or y of the estimate's hull (the smallest box around all boxes of the estimate) beyond which a robot on errands does not set out:
/// it stands and looks around.
const LOST_M: f64 = 3.0;
/// Width of the estimate's range of headings beyond which a robot on errands does not set out: it stands and looks around, as for
/// [`LOST_M`].
const LOST_RAD: f64 = std::f64::consts::FRAC_PI_2;

/// Least share of the full speed while the estimate is wide, so that a robot whose pose stays uncertain still gets somewhere.
const LEAST_SHARE: f64 = 0.25;

/// How long a robot stands before it turns about to see something else, while its estimate is too wide or its localizer is recovering from a
/// contradiction.
const DOUBT_S: f64 = 5.0;

/// Turn rate at which a robot that is unsure of its pose looks around, over its greatest turn rate.
const LOOK_AROUND_SHARE: f64 = 0.3;

/// Time without motion after which a robot that wants to drive on is taken to have run into something. It is longer than a start from rest
/// takes.
const STUCK_S: f64 = 3.0;

/// How long the robot stands at the place to which it has moved out of somebody's way.
const YIELDED_S: f64 = 3.0;

/// Driver of a scene's errands, from goal to goal.
#[derive(Clone, Debug)]
pub struct ErrandDriver {
    follower: Driver,
    law: Option<Law>,
    navigation: Navigation,
    planner: Planner,
    keep_away_m: f64,
    surroundings: Surroundings,
    task: Task,
    log: ErrandLog,
    /// `moved` holds where and when the robot last moved, by its estimate, which reveals that it has run into something. `got_on` holds
    /// where and when it last made progress, which reveals a standstill.
    moved: Anchor,
    got_on: Anchor,
    doubts_since_s: Option<f64>,
    /// Time at which something first blocked the way. The robot has made no progress since, though the way may have been free for moments.
    blocked_since_s: Option<f64>,
}

/// What the errand driver is doing at present.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Task {
    Plan,
    Follow,
    /// The robot is moving out of somebody's way.
    Yield,
    /// The robot is waiting, because something blocks its path.
    Wait {
        since_s: f64,
    },
    /// The robot is standing at a place where it is in nobody's way.
    Yielded {
        until_s: f64,
    },
    /// The robot is standing at a goal that it has reached.
    Pause {
        until_s: f64,
    },
    Done {
        since_s: f64,
    },
}

/// A position, and the last time at which the robot was somewhere else.
#[derive(Clone, Copy, Debug)]
struct Anchor {
    place_m: [f64; 2],
    since_s: f64,
}

/// Whether the estimate's hull (the smallest box around all boxes of the estimate) is so wide that its middle is of no use for planning a path.
fn is_lost(hull: &PoseBox) -> bool {
    !hull.is_empty() && (hull.width(0).max(hull.width(1)) > LOST_M || hull.width(2) > LOST_RAD)
}

impl ErrandDriver {
    /// A driver of the errands that the scene states, followed by goals that a seed has drawn at random.
    pub fn new(scene: &Scene, random_goals_m: &[[f64; 2]]) -> ErrandDriver {
        let navigation = scene.navigation();
        let map = OccupancyGrid::of(scene);
        let range_m = scene.robot.scanner.as_ref().map_or(0.0, |scanner| scanner.range_m);
        let keep_away_m = scene.robot.body_radius_m + navigation.margin_m;
        let here = Anchor { place_m: [scene.start.x_m, scene.start.y_m], since_s: 0.0 };
        ErrandDriver {
            follower: Driver::new(scene),
            law: None,
            planner: Planner::new(map.clone(), keep_away_m),
            keep_away_m,
            surroundings: Surroundings::new(map, scene.robot.body_radius_m, range_m),
            task: Task::Plan,
            log: ErrandLog::new(scene, random_goals_m),
            navigation,
            moved: here,
            got_on: here,
            doubts_since_s: None,
            blocked_since_s: None,
        }
    }

    /// The motion that the base is commanded for the next [`PERIOD_S`](super::PERIOD_S), by the localizer's estimate and the scanner's latest scan.
    pub fn command(&mut self, estimate: &Estimate, fan: Option<&Fan>, time_s: f64) -> DriveCommand {
        let hull = estimate.pose.hull();
        if !hull.is_empty() {
            let [x_m, y_m, heading_rad] = hull.midpoint();
            self.follower.pose = Pose { x_m, y_m, heading_rad };
        }
        if let Some(fan) = fan {
            self.surroundings.look(fan, self.follower.pose);
        }
        let is_lost = is_lost(&hull);
        if is_lost && self.task == Task::Follow {
            // The path was planned from a position that proves wrong, so that a new one is needed.
            self.task = Task::Plan;
        }
        let stands = hull.is_empty() || is_lost || (estimate.status != Status::Sound && !self.creeps_in_doubt(time_s));
        let wish = if stands {
            self.doubt(hull.is_empty(), time_s)
        } else {
            self.doubts_since_s = self.doubts_since_s.filter(|_| estimate.status != Status::Sound);
            self.pursue(&hull, time_s)
        };
        self.follower.actuate(wish)
    }

    /// Whether all errands have ended and the robot has stood still for a second since.
    pub fn is_done(&self, time_s: f64) -> bool {
        matches!(self.task, Task::Done { since_s } if time_s - since_s > 1.0)
    }

    /// The log of what became of each errand until `time_s`.
    pub fn into_log(mut self, time_s: f64) -> ErrandLog {
        self.log.end_leg(time_s);
        self.log
    }

    /// Makes the robot stand while its estimate is empty or too wide, or its localizer is recovering from a contradiction. After a while, unless
    /// the estimate is empty, the robot turns about to see more; a round robot that turns in place touches nothing.
    fn doubt(&mut self, is_nowhere: bool, time_s: f64) -> Wish {
        let since_s = *self.doubts_since_s.get_or_insert(time_s);
        self.moved = Anchor { place_m: self.place_m(), since_s: time_s };
        self.hold_progress(time_s);
        if is_nowhere || time_s - since_s < DOUBT_S {
            return Wish::default();
        }
        let turn_rad_per_s = LOOK_AROUND_SHARE * self.follower.scene.robot.max_turn_rate_rad_per_s;
        Wish { speed_m_per_s: 0.0, turn_rad_per_s }
    }

    /// Whether a robot whose localizer has been recovering for a while drives on nevertheless, because its base cannot turn about to see more.
    fn creeps_in_doubt(&self, time_s: f64) -> bool {
        self.follower.circle.is_some() && self.doubts_since_s.is_some_and(|since_s| time_s - since_s >= DOUBT_S)
    }

    fn pursue(&mut self, hull: &PoseBox, time_s: f64) -> Wish {
        self.note_motion(time_s);
        match self.task {
            Task::Plan => {
                // A path with a turning circle begins at a pose, so that the robot first comes to rest.
                if self.follower.circle.is_none() || self.follower.speed.value() == 0.0 {
                    self.plan(time_s);
                }
                Wish::default()
            }
            Task::Follow | Task::Yield => self.follow(hull, time_s),
            Task::Wait { since_s } => {
                self.wait(since_s, time_s);
                Wish::default()
            }
            Task::Yielded { until_s } => {
                if time_s >= until_s {
                    self.task = Task::Plan;
                }
                Wish::default()
            }
            Task::Pause { until_s } => {
                if time_s >= until_s {
                    self.next_errand(time_s);
                }
                Wish::default()
            }
            Task::Done { .. } => Wish::default(),
        }
    }

    fn follow(&mut self, hull: &PoseBox, time_s: f64) -> Wish {
        let wish = self.steer(time_s);
        if self.task == Task::Plan {
            return Wish::default();
        }
        if self.is_at_the_end() {
            if self.task == Task::Yield {
                self.log.end_leg(time_s);
                self.task = Task::Yielded { until_s: time_s + YIELDED_S };
            } else {
                self.arrive(hull, time_s);
            }
            return Wish::default();
        }
        let limit_m_per_s = self.clear_m_per_s(self.follower.speed.value());
        let wants_on = wish.speed_m_per_s != 0.0;
        let is_bumped = wants_on && time_s - self.moved.since_s > STUCK_S;
        if is_bumped {
            let pose = self.follower.pose;
            let behind_rad = if wish.speed_m_per_s < 0.0 { std::f64::consts::PI } else { 0.0 };
            self.surroundings.bump(Pose { heading_rad: pose.heading_rad + behind_rad, ..pose }, time_s);
        }
        if is_bumped || (wants_on && limit_m_per_s < CREEP_M_PER_S) {
            let since_s = *self.blocked_since_s.get_or_insert(time_s);
            // If the path by which the robot moves aside is blocked, it plans a path to its goal again; if the path to the goal is blocked,
            // it waits.
            self.task =
                if self.task == Task::Yield { Task::Yielded { until_s: time_s } } else { Task::Wait { since_s } };
            return Wish::default();
        }
        // The robot drives at full speed as long as half the width of the estimate's hull fits into the margin on either side of the planned
        // path.
        let width_m = hull.width(0).max(hull.width(1));
        let most = if self.doubts_since_s.is_some() { LEAST_SHARE } else { 1.0 };
        let share = (2.0 * self.navigation.margin_m / width_m).clamp(LEAST_SHARE, most);
        let speed_m_per_s = (share * wish.speed_m_per_s.abs()).min(limit_m_per_s).copysign(wish.speed_m_per_s);
        Wish { speed_m_per_s, ..wish }
    }

    /// Ends an errand at the end of a path: the goal counts as reached if the middle of the estimated box is within the tolerance. Otherwise a
    /// new path is planned.
    fn arrive(&mut self, hull: &PoseBox, time_s: f64) {
        let pose = self.follower.pose;
        let Some(errand) = self.log.current_mut() else { return };
        errand.estimated_distance_m = Some(bearing(pose, errand.goal_m).distance_m);
        errand.box_reach_m = Some(0.5 * hull.width(0).hypot(hull.width(1)));
        if errand.estimated_distance_m.is_some_and(|distance_m| distance_m <= errand.tolerance_m) {
            self.end_errand(Outcome::Reached, time_s);
        } else {
            self.task = Task::Plan;
        }
    }

    fn end_errand(&mut self, outcome: Outcome, time_s: f64) {
        self.log.end_leg(time_s);
        let Some(errand) = self.log.current_mut() else { return };
        (errand.outcome, errand.ended_s) = (outcome, Some(time_s));
        self.task = Task::Pause { until_s: time_s + if outcome == Outcome::Reached { errand.pause_s } else { 0.0 } };
    }

    fn next_errand(&mut self, time_s: f64) {
        self.got_on = Anchor { place_m: self.place_m(), since_s: time_s };
        self.log.next(time_s);
        self.task = if self.log.current().is_some() { Task::Plan } else { Task::Done { since_s: time_s } };
    }

    fn place_m(&self) -> [f64; 2] {
        self.follower.place_m()
    }
}

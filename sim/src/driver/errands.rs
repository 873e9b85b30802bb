//! Errands: finds ways to goals, follows them by the estimate, waits and looks for another way when one is blocked.

use localizer::{Estimate, Pose, PoseBox, Status};

use crate::{
    navigation::{OccupancyGrid, Planner, length_m},
    scene::{FollowerName, Navigation, Route, Scene, Waypoint},
    sensors::proximity::Fan,
    world::WheelCommand,
};

use super::{
    CREEP_M_PER_S, Driver, JERK_RISE_S, Path, Progress, Stage, Wish,
    surroundings::Surroundings,
    turn_then_drive::{Limits, TurnThenDrive, bearing},
};

mod log;

pub use log::{ErrandLog, ErrandRecord, Leg, Outcome};

/// Corners sharper than this are turned in place: pure pursuit would cut them by more than the margin.
const SHARP_CORNER_RAD: f64 = 0.5;

/// Wider than this, or with so many headings, a box is no place to set out from: the robot stands and looks around.
const LOST_M: f64 = 3.0;
/// See [`LOST_M`].
const LOST_RAD: f64 = std::f64::consts::FRAC_PI_2;

/// Least share of the speed while the box is wide, so that a robot that is unsure for long still gets somewhere.
const LEAST_SHARE: f64 = 0.25;

/// How long a robot that doubts its place stands before it turns about to see something else.
const DOUBT_S: f64 = 5.0;

/// Turn rate of looking around, over the robot's greatest.
const LOOK_AROUND_SHARE: f64 = 0.3;

/// A robot that wants to get on and has not moved by this much in `STUCK_S` has run into something.
const MOVED_M: f64 = 0.02;

/// See `MOVED_M`; longer than a start from rest takes.
const STUCK_S: f64 = 3.0;

/// A robot gets on when it has moved by this much.
const NOWHERE_M: f64 = 0.2;

/// After so long without getting on the robot makes way: whoever stands before it may be waiting too.
const YIELD_S: f64 = 8.0;

/// How far away it goes then: more than people keep from its way.
const YIELD_M: [f64; 2] = [1.2, 2.5];

/// How long it stands there.
const YIELDED_S: f64 = 3.0;

/// After so many ways, blocked or ended beside the goal as the estimate jumped, an errand is given up.
const MOST_WAYS: usize = 20;

/// Drives a scene's errands.
#[derive(Clone, Debug)]
pub struct ErrandDriver {
    follower: Driver,
    law: Option<TurnThenDrive>,
    navigation: Navigation,
    planner: Planner,
    keep_away_m: f64,
    surroundings: Surroundings,
    task: Task,
    log: ErrandLog,
    /// Where the robot was, by its estimate, when it last moved, and when it last got on: to tell a bump, and a standstill.
    moved: Anchor,
    got_on: Anchor,
    doubts_since_s: Option<f64>,
    /// When something came into the way that has been there, on and off, since the robot last got on.
    blocked_since_s: Option<f64>,
}

/// What the driver is about.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Task {
    Plan,
    Follow,
    /// Out of somebody's way.
    Yield,
    /// Something is in the way.
    Wait {
        since_s: f64,
    },
    /// Where it is in nobody's way.
    Yielded {
        until_s: f64,
    },
    /// At a goal.
    Pause {
        until_s: f64,
    },
    Done {
        since_s: f64,
    },
}

/// A place and the last time at which the robot was elsewhere.
#[derive(Clone, Copy, Debug)]
struct Anchor {
    place_m: [f64; 2],
    since_s: f64,
}

/// Whether the middle of a box says nothing of where to drive.
fn is_lost(hull: &PoseBox) -> bool {
    !hull.is_empty() && (hull.width(0).max(hull.width(1)) > LOST_M || hull.width(2) > LOST_RAD)
}

impl ErrandDriver {
    /// A driver of the scene's errands and then of goals that a seed has drawn.
    pub fn new(scene: &Scene, random_goals_m: &[[f64; 2]]) -> ErrandDriver {
        let navigation = scene.navigation();
        let map = OccupancyGrid::of(scene);
        let range_m = scene.robot.proximity.as_ref().map_or(0.0, |proximity| proximity.range_m);
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

    /// The wheel speeds for the next [`PERIOD_S`](super::PERIOD_S), by an estimate and what the proximity sensor has just read.
    pub fn command(&mut self, estimate: &Estimate, fan: Option<&Fan>, time_s: f64) -> WheelCommand {
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
            // The way was planned from elsewhere.
            self.task = Task::Plan;
        }
        let wish = if hull.is_empty() || is_lost || estimate.status != Status::Sound {
            self.doubt(hull.is_empty(), time_s)
        } else {
            self.doubts_since_s = None;
            self.pursue(&hull, time_s)
        };
        self.follower.actuate(wish)
    }

    /// Whether all errands have ended and the robot has stood since for a second.
    pub fn is_done(&self, time_s: f64) -> bool {
        matches!(self.task, Task::Done { since_s } if time_s - since_s > 1.0)
    }

    /// What became of the errands until `time_s`.
    pub fn into_log(mut self, time_s: f64) -> ErrandLog {
        self.log.end_leg(time_s);
        self.log
    }

    /// Stands, and after a while turns about: a round robot that turns in place touches nothing.
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

    fn pursue(&mut self, hull: &PoseBox, time_s: f64) -> Wish {
        self.note_motion(time_s);
        match self.task {
            Task::Plan => {
                self.plan(time_s);
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

    /// Finds a way to the goal: past what has been seen besides the map, if it has to be.
    fn plan(&mut self, time_s: f64) {
        self.blocked_since_s = None;
        let Some((goal_m, ways)) = self.log.current().map(|errand| (errand.goal_m, errand.ways)) else {
            self.task = Task::Done { since_s: time_s };
            return;
        };
        if ways >= MOST_WAYS {
            self.end_errand(Outcome::Blocked, time_s);
            return;
        }
        let (map, is_changed) = self.surroundings.map();
        let place_m = self.place_m();
        let mut way = None;
        if is_changed {
            way = Planner::new(map, self.keep_away_m).plan(place_m, goal_m);
        }
        // Who stands in the only way may go on: towards there, until the proximity sensor stops the robot.
        if !is_changed || (way.is_none() && !self.log.has_leg()) {
            way = self.planner.plan(place_m, goal_m);
        }
        self.log.add_plan(is_changed);
        match way {
            Some(corners_m) => {
                self.set_out(&corners_m);
                self.log.end_leg(time_s);
                self.log.begin_leg(corners_m, time_s);
                self.moved = Anchor { place_m, since_s: time_s };
                self.task = Task::Follow;
            }
            // The way that was followed may become free again.
            None if is_changed => self.task = Task::Wait { since_s: time_s },
            None => self.end_errand(Outcome::NoWay, time_s),
        }
    }

    fn set_out(&mut self, corners_m: &[[f64; 2]]) {
        if self.navigation.follower == FollowerName::TurnThenDrive {
            self.law = Some(TurnThenDrive::new(corners_m.to_vec()));
            return;
        }
        let waypoint = |index: usize| {
            let [x_m, y_m] = corners_m[index];
            let turn_in_place =
                corner_rad(&corners_m[index - 1..]).is_some_and(|corner_rad| corner_rad > SHARP_CORNER_RAD);
            let is_stop = turn_in_place || index + 1 == corners_m.len();
            let length_m = (x_m - corners_m[index - 1][0]).hypot(y_m - corners_m[index - 1][1]);
            let most_m_per_s = if is_stop { self.reachable_m_per_s(length_m) } else { f64::INFINITY };
            let speed_m_per_s = self.navigation.speed_m_per_s.min(most_m_per_s).max(CREEP_M_PER_S);
            Waypoint { x_m, y_m, speed_m_per_s, turn_in_place, pause_s: 0.0 }
        };
        let route = Route { waypoints: (1..corners_m.len()).map(waypoint).collect(), repeat: false, led: false };
        self.follower.path = Some(Path::new(corners_m[0], &route));
        self.follower.segment_idx = 0;
        self.follower.stage = Stage::Turn;
    }

    /// The speed up to which the robot can rise and from which it can fall again within a length, from standstill to standstill: the root of
    /// v²/a + 2·v·t = length, with t for an acceleration to rise. Faster, it would run over the end.
    fn reachable_m_per_s(&self, length_m: f64) -> f64 {
        let acceleration = self.follower.scene.robot.max_acceleration_m_per_s2;
        acceleration * ((JERK_RISE_S * JERK_RISE_S + length_m / acceleration).sqrt() - JERK_RISE_S)
    }

    fn follow(&mut self, hull: &PoseBox, time_s: f64) -> Wish {
        let wish = self.steer(time_s);
        if self.is_at_the_end() {
            if self.task == Task::Yield {
                self.log.end_leg(time_s);
                self.task = Task::Yielded { until_s: time_s + YIELDED_S };
            } else {
                self.arrive(hull, time_s);
            }
            return Wish::default();
        }
        let acceleration_m_per_s2 = self.follower.scene.robot.max_acceleration_m_per_s2;
        let limit_m_per_s = self.surroundings.speed_limit_m_per_s(self.follower.speed.value(), acceleration_m_per_s2);
        let wants_on = wish.speed_m_per_s > 0.0;
        let is_bumped = wants_on && time_s - self.moved.since_s > STUCK_S;
        if is_bumped {
            self.surroundings.bump(self.follower.pose, time_s);
        }
        if is_bumped || (wants_on && limit_m_per_s < CREEP_M_PER_S) {
            let since_s = *self.blocked_since_s.get_or_insert(time_s);
            // The way aside leads nowhere: one to the goal is looked for again.
            self.task =
                if self.task == Task::Yield { Task::Yielded { until_s: time_s } } else { Task::Wait { since_s } };
            return Wish::default();
        }
        // Full speed while half of the box fits into the margin that the way has to either side.
        let width_m = hull.width(0).max(hull.width(1));
        let share = (2.0 * self.navigation.margin_m / width_m).clamp(LEAST_SHARE, 1.0);
        Wish { speed_m_per_s: (share * wish.speed_m_per_s).min(limit_m_per_s), ..wish }
    }

    /// What the follower would like.
    fn steer(&mut self, time_s: f64) -> Wish {
        let Some(law) = &mut self.law else { return self.follower.wish(time_s) };
        let robot = &self.follower.scene.robot;
        let limits = Limits {
            speed_m_per_s: self.navigation.speed_m_per_s.min(robot.max_speed_m_per_s),
            turn_rad_per_s: self.follower.turn_limit_rad_per_s(),
            braking_m_per_s2: 0.5 * robot.max_acceleration_m_per_s2,
            track_m: robot.track_m,
        };
        law.wish(self.follower.pose, self.follower.turn.value(), &limits)
    }

    fn is_at_the_end(&self) -> bool {
        let is_at_rest = self.follower.speed.value() == 0.0 && self.follower.turn.value() == 0.0;
        match &self.law {
            Some(law) => law.is_finished() && is_at_rest,
            None => self.follower.stage == Stage::Finished,
        }
    }

    /// Waits until the way is free again or patience ends.
    fn wait(&mut self, since_s: f64, time_s: f64) {
        self.log.wait(super::PERIOD_S);
        self.hold_progress(time_s);
        if self.log.current().is_some_and(|errand| errand.waited_s > self.navigation.give_up_s) {
            self.end_errand(Outcome::Blocked, time_s);
            return;
        }
        if time_s - self.got_on.since_s > YIELD_S && self.make_way(time_s) {
            return;
        }
        let acceleration_m_per_s2 = self.follower.scene.robot.max_acceleration_m_per_s2;
        let limit_m_per_s = self.surroundings.speed_limit_m_per_s(0.0, acceleration_m_per_s2);
        if time_s - since_s >= self.navigation.patience_s {
            self.task = Task::Plan;
        } else if limit_m_per_s > 0.5 * self.navigation.speed_m_per_s && self.log.has_leg() {
            self.moved.since_s = time_s;
            self.task = Task::Follow;
        }
    }

    /// Sets out for the place near by that is farthest from what has been seen besides the map, if there is any.
    fn make_way(&mut self, time_s: f64) -> bool {
        let (map, _) = self.surroundings.map();
        let (here_m, planner) = (self.place_m(), Planner::new(map, self.keep_away_m));
        let Some(reach) = planner.reach_near(here_m) else { return false };
        let is_near = |at_m: &[f64; 2]| (YIELD_M[0]..=YIELD_M[1]).contains(&length_m(&[here_m, *at_m]));
        let room_m = |at_m: &[f64; 2]| self.surroundings.distance_m(*at_m);
        let places_m = reach.centres_m().into_iter().filter(is_near);
        let way = places_m
            .max_by(|one, other| room_m(one).total_cmp(&room_m(other)))
            .and_then(|place_m| planner.plan(here_m, place_m));
        let Some(corners_m) = way else { return false };
        self.set_out(&corners_m);
        self.log.end_leg(time_s);
        self.log.begin_leg(corners_m, time_s);
        self.got_on.since_s = time_s;
        self.moved.since_s = time_s;
        self.blocked_since_s = None;
        self.task = Task::Yield;
        true
    }

    /// At the end of a way: the goal is reached if the estimate says so.
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

    fn note_motion(&mut self, time_s: f64) {
        let place_m = self.place_m();
        for (anchor, least_m) in [(&mut self.moved, MOVED_M), (&mut self.got_on, NOWHERE_M)] {
            let moved_m = (place_m[0] - anchor.place_m[0]).hypot(place_m[1] - anchor.place_m[1]);
            if moved_m > least_m {
                *anchor = Anchor { place_m, since_s: time_s };
            }
        }
        if self.got_on.since_s == time_s {
            self.blocked_since_s = None;
        }
        // Turning in place is getting on, as far as bumps are concerned.
        if self.follower.speed.value() < CREEP_M_PER_S {
            self.moved.since_s = time_s;
        }
    }

    /// A robot that stands because it was told to is not stuck.
    fn hold_progress(&mut self, time_s: f64) {
        self.follower.progress = Progress { left_m: f64::INFINITY, at_s: time_s };
    }

    fn place_m(&self) -> [f64; 2] {
        self.follower.place_m()
    }
}

/// Angle by which a way turns at the second of its first three corners, [0, π].
fn corner_rad(corners_m: &[[f64; 2]]) -> Option<f64> {
    let [first, second, third, ..] = corners_m else { return None };
    let before = [second[0] - first[0], second[1] - first[1]];
    let after = [third[0] - second[0], third[1] - second[1]];
    let cross = before[0] * after[1] - before[1] * after[0];
    Some(cross.abs().atan2(before[0] * after[0] + before[1] * after[1]))
}

//! Planned paths on errands: finding a path to a goal, setting out on it, and steering along it.

use crate::{
    driver::{
        CREEP_M_PER_S, JERK_RISE_S, Path, Stage, Wish,
        curve_pursuit::{CurveLimits, CurvePursuit},
        turn_then_drive::{Limits, TurnThenDrive},
    },
    place::navigation::{CurvePlanner, Planner, reeds_shepp::Arc},
    scene::{FollowerName, Route, Waypoint},
};

use super::{Anchor, ErrandDriver, Outcome, Task};

/// A planned path.
#[derive(Clone, Debug)]
pub(super) enum Way {
    /// Straight from corner to corner, for a base that can turn in place.
    Corners(Vec<[f64; 2]>),
    /// By arcs from where the robot stands, for a base with a turning circle.
    Curves(Vec<Arc>),
}

/// Control law for a planned path, where it is not that of a route.
#[derive(Clone, Debug)]
pub(super) enum Law {
    TurnThenDrive(TurnThenDrive),
    Curves(CurvePursuit),
}

/// Corner angle beyond which the robot turns in place on a planned path: pure pursuit would cut such a corner by more than the margin.
const SHARP_CORNER_RAD: f64 = 0.5;

/// Least distance from its path beyond which a car plans a new one.
const LEAST_LOST_PATH_M: f64 = 0.1;

/// Length of a curved path ahead on which the scanner's latest scan is looked at. A car at 1 m/s stops within it.
const SEEN_AHEAD_M: f64 = 3.0;

/// Number of planned paths after which an errand is given up, whether they were blocked or ended beside the goal because the estimate
/// jumped.
const MOST_WAYS: usize = 20;

impl ErrandDriver {
    /// Plans a path to the goal, around obstacles seen that are not on the map.
    pub(super) fn plan(&mut self, time_s: f64) {
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
            way = self.way(&Planner::new(map, self.keep_away_m), goal_m);
        }
        // Whatever blocks the only path may move on. The robot sets out nevertheless, until the scanner stops it.
        if !is_changed || (way.is_none() && !self.log.has_leg()) {
            way = self.way(&self.planner, goal_m);
        }
        self.log.add_plan(is_changed);
        match way {
            Some(way) => {
                self.set_out(way, time_s);
                self.moved = Anchor { place_m, since_s: time_s };
                self.task = Task::Follow;
            }
            // The robot waits, because the path that it followed until then may become free again.
            None if is_changed => self.task = Task::Wait { since_s: time_s },
            None => self.end_errand(Outcome::NoWay, time_s),
        }
    }

    /// The path from where the robot stands to a place, by a planner; `None` when there is no path.
    pub(super) fn way(&self, planner: &Planner, to_m: [f64; 2]) -> Option<Way> {
        match &self.follower.circle {
            Some(circle) => {
                let planner = CurvePlanner::new(planner, circle.planned_radius_m());
                planner.plan(self.follower.pose, to_m).map(Way::Curves)
            }
            None => planner.plan(self.place_m(), to_m).map(Way::Corners),
        }
    }

    /// Begins a path, and its leg in the log.
    pub(super) fn set_out(&mut self, way: Way, time_s: f64) {
        self.log.end_leg(time_s);
        let corners_m = match way {
            Way::Corners(corners_m) => {
                self.set_out_to_corners(&corners_m);
                corners_m
            }
            Way::Curves(arcs) => {
                let law = CurvePursuit::new(self.follower.pose, &arcs);
                let places_m = law.places_m();
                self.law = Some(Law::Curves(law));
                places_m
            }
        };
        self.log.begin_leg(corners_m, time_s);
    }

    fn set_out_to_corners(&mut self, corners_m: &[[f64; 2]]) {
        if self.navigation.follower == FollowerName::TurnThenDrive {
            self.law = Some(Law::TurnThenDrive(TurnThenDrive::new(corners_m.to_vec())));
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
        let route = Route {
            waypoints: (1..corners_m.len()).map(waypoint).collect(),
            begins_s: 0.0,
            repeat: false,
            led: false,
            sure_width_m: Route::SURE_WIDTH_M,
        };
        self.follower.path = Some(Path::new(corners_m[0], &route));
        self.follower.segment_idx = 0;
        self.follower.stage = Stage::Turn;
    }

    /// Greatest speed to which the robot can accelerate, and from which it can brake again, within a length that begins and ends at
    /// standstill: the root of v²/a + 2·v·t = length, with t for the rise time of an acceleration. At a higher speed it would overrun the
    /// end.
    fn reachable_m_per_s(&self, length_m: f64) -> f64 {
        let acceleration = self.follower.scene.robot.max_acceleration_m_per_s2;
        acceleration * ((JERK_RISE_S * JERK_RISE_S + length_m / acceleration).sqrt() - JERK_RISE_S)
    }

    /// Speed and turn rate for following the planned path, by the control law that the scene chooses.
    pub(super) fn steer(&mut self, time_s: f64) -> Wish {
        let law = match self.law.take() {
            None => return self.follower.wish(time_s),
            Some(law) => law,
        };
        let robot = &self.follower.scene.robot;
        let (speed_m_per_s, braking_m_per_s2) =
            (self.navigation.speed_m_per_s.min(robot.max_speed_m_per_s), 0.5 * robot.max_acceleration_m_per_s2);
        let (law, wish) = match law {
            Law::TurnThenDrive(mut law) => {
                let limits = Limits {
                    speed_m_per_s,
                    turn_rad_per_s: self.follower.turn_limit_rad_per_s(),
                    braking_m_per_s2,
                    track_m: robot.base.track_m,
                };
                let wish = law.wish(self.follower.pose, self.follower.turn.value(), &limits);
                (Law::TurnThenDrive(law), wish)
            }
            Law::Curves(mut law) => {
                let limits = CurveLimits {
                    speed_m_per_s,
                    braking_m_per_s2,
                    curve_m_per_s: &|curvature_per_m| self.follower.curve_speed_m_per_s(curvature_per_m),
                    reachable_m_per_s: &|length_m| self.reachable_m_per_s(length_m),
                    radius_m: self.follower.circle.map_or(0.0, |circle| circle.radius_m),
                    lock_to_lock_s: self.follower.circle.map_or(0.0, |circle| circle.lock_to_lock_s),
                    lost_path_m: self.lost_path_m(),
                };
                let pursued = law.pursue(self.follower.pose, self.follower.speed.value(), &limits);
                self.follower.curvature_per_m = pursued.curvature_per_m;
                if pursued.has_lost_path {
                    self.task = Task::Plan;
                }
                let turn_rad_per_s = pursued.curvature_per_m * pursued.speed_m_per_s;
                (Law::Curves(law), Wish { speed_m_per_s: pursued.speed_m_per_s, turn_rad_per_s })
            }
        };
        self.law = Some(law);
        wish
    }

    /// Distance from its path beyond which a car plans a new one: another margin beyond that which the path keeps from obstacles, as the estimate may
    /// jump by its width.
    fn lost_path_m(&self) -> f64 {
        (2.0 * self.navigation.margin_m).max(LEAST_LOST_PATH_M)
    }

    /// Greatest speed from which the robot, braking, stops before anything that its scanner saw ahead: straight ahead, or on its curved path.
    pub(super) fn clear_m_per_s(&self, speed_m_per_s: f64) -> f64 {
        let acceleration_m_per_s2 = self.follower.scene.robot.max_acceleration_m_per_s2;
        match &self.law {
            Some(Law::Curves(law)) => {
                let ahead = law.ahead(SEEN_AHEAD_M);
                self.surroundings.speed_limit_along_m_per_s(
                    self.follower.pose,
                    &ahead,
                    speed_m_per_s.abs(),
                    acceleration_m_per_s2,
                )
            }
            _ => self.surroundings.speed_limit_m_per_s(speed_m_per_s, acceleration_m_per_s2),
        }
    }

    pub(super) fn is_at_the_end(&self) -> bool {
        let is_at_rest = self.follower.speed.value() == 0.0 && self.follower.turn.value() == 0.0;
        match &self.law {
            Some(Law::TurnThenDrive(law)) => law.is_finished() && is_at_rest,
            Some(Law::Curves(law)) => law.is_finished() && is_at_rest,
            None => self.follower.stage == Stage::Finished,
        }
    }
}

/// Angle by which a planned path turns at the second of the given corners, in [0, π].
fn corner_rad(corners_m: &[[f64; 2]]) -> Option<f64> {
    let [first, second, third, ..] = corners_m else { return None };
    let before = [second[0] - first[0], second[1] - first[1]];
    let after = [third[0] - second[0], third[1] - second[1]];
    let cross = before[0] * after[1] - before[1] * after[0];
    Some(cross.abs().atan2(before[0] * after[0] + before[1] * after[1]))
}

//! What a robot on errands does when it makes no progress: it waits, looks for another path, or moves out of the way of people.

use crate::{
    driver::{CREEP_M_PER_S, PERIOD_S, Progress},
    place::navigation::{Planner, length_m},
};

use super::{Anchor, ErrandDriver, Outcome, Task};

/// Distance by which the robot must have moved within a while to count as moving at all, and so as not stuck at an obstacle.
const MOVED_M: f64 = 0.02;

/// Distance by which the robot must have moved within a while to count as making progress on its errand.
const NOWHERE_M: f64 = 0.2;

/// Time without progress after which the robot moves aside: a person who stands before it may be waiting too.
const YIELD_S: f64 = 8.0;

/// Least and greatest distance to which the robot moves aside to let somebody pass; both are more than the distance that people keep from it.
const YIELD_M: [f64; 2] = [1.2, 2.5];

impl ErrandDriver {
    /// Waits until the planned path is free again, or until the robot's patience ends.
    pub(super) fn wait(&mut self, since_s: f64, time_s: f64) {
        self.log.wait(PERIOD_S);
        self.hold_progress(time_s);
        if self.log.current().is_some_and(|errand| errand.waited_s > self.navigation.give_up_s) {
            self.end_errand(Outcome::Blocked, time_s);
            return;
        }
        if time_s - self.got_on.since_s > YIELD_S && self.make_way(time_s) {
            return;
        }
        let limit_m_per_s = self.clear_m_per_s(0.0);
        if time_s - since_s >= self.navigation.patience_s {
            self.task = Task::Plan;
        } else if limit_m_per_s > 0.5 * self.navigation.speed_m_per_s && self.log.has_leg() {
            self.moved.since_s = time_s;
            self.task = Task::Follow;
        }
    }

    /// Sets out for the place nearby that is farthest from all obstacles seen that are not on the map; false if no such place can be reached.
    fn make_way(&mut self, time_s: f64) -> bool {
        let (map, _) = self.surroundings.map();
        let (here_m, planner) = (self.place_m(), Planner::new(map, self.keep_away_m));
        let Some(reach) = planner.reach_near(here_m) else { return false };
        let is_near = |at_m: &[f64; 2]| (YIELD_M[0]..=YIELD_M[1]).contains(&length_m(&[here_m, *at_m]));
        let room_m = |at_m: &[f64; 2]| self.surroundings.distance_m(*at_m);
        let places_m = reach.centres_m().into_iter().filter(is_near);
        let way = places_m
            .max_by(|one, other| room_m(one).total_cmp(&room_m(other)))
            .and_then(|place_m| self.way(&planner, place_m));
        let Some(way) = way else { return false };
        self.set_out(way, time_s);
        self.got_on.since_s = time_s;
        self.moved.since_s = time_s;
        self.blocked_since_s = None;
        self.task = Task::Yield;
        true
    }

    pub(super) fn note_motion(&mut self, time_s: f64) {
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
        // A robot that stands on purpose or turns in place counts as moved, so that it is not taken to have run into something.
        if self.follower.speed.value().abs() < CREEP_M_PER_S {
            self.moved.since_s = time_s;
        }
    }

    /// Restarts the clock for missing progress: a robot that stands on purpose is not stuck.
    pub(super) fn hold_progress(&mut self, time_s: f64) {
        self.follower.progress = Progress { left_m: f64::INFINITY, at_s: time_s };
    }
}

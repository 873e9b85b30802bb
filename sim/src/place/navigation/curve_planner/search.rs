//! Hybrid A*: the search for a path over poses.

use std::{
    cmp::Reverse,
    collections::{BinaryHeap, HashMap},
    f64::consts::TAU,
};

use localizer::Pose;

use crate::place::navigation::reeds_shepp::{Arc, curves};

use super::{BACKWARDS, CHANGE_OVER_RADIUS, Free, cheapest_free, cost, stretches};

/// Greatest length of the arcs by which poses are expanded, and their greatest turn.
const STEP_M: f64 = 0.3;
const STEP_RAD: f64 = 10.0 / 360.0 * TAU;
/// Curvatures of these arcs, over the greatest one.
const STEERED: [f64; 5] = [0.0, 0.5, -0.5, 1.0, -1.0];

/// Number of headings at the goal, evenly around, that are tried for a curve to it.
const GOAL_HEADINGS: usize = 12;

/// Weight of the cost that is left at least. A weight above 1 makes the search go towards the goal; the path then costs at most that many times what
/// the cheapest one does (weighted A*: Pohl 1970). On five ways through a hall 1.15 tries a third of the poses that 1 does.
const TOWARDS_GOAL: f64 = 1.15;

/// Number of poses after which the search ends with the best path found until then. A hall of 30 m by 20 m has eighty times as many for a circle of
/// 1 m, but the search goes towards the goal.
const MOST_POSES: usize = 100_000;

/// A search for a path to a goal.
pub(super) struct Search<'a> {
    free: &'a Free<'a>,
    radius_m: f64,
    goal_m: [f64; 2],
    /// Length of the shortest path to the goal from each cell of the grid, without regard to the turning circle.
    left_m: Vec<f64>,
    poses: Vec<Reached>,
    cheapest: HashMap<Key, f64>,
    queue: BinaryHeap<Reverse<Queued>>,
    /// Cost of the cheapest path to the goal that has been found.
    goal_cost_m: f64,
}

impl<'a> Search<'a> {
    /// A search for a path to a goal, with the length of the shortest way to it from each cell of the grid.
    pub(super) fn new(free: &'a Free<'a>, radius_m: f64, goal_m: [f64; 2], left_m: Vec<f64>) -> Search<'a> {
        let (poses, cheapest, queue) = (Vec::new(), HashMap::new(), BinaryHeap::new());
        Search { free, radius_m, goal_m, left_m, poses, cheapest, queue, goal_cost_m: f64::INFINITY }
    }

    /// The arcs of the cheapest path from a pose to the goal that the search finds.
    pub(super) fn run(mut self, from: Pose) -> Option<Vec<Arc>> {
        self.add(Reached {
            pose: from,
            cost_m: 0.0,
            is_backwards: None,
            before: None,
            arcs: Vec::new(),
            is_goal: false,
        });
        let (mut best, mut until_look) = (None, 0);
        while let Some(Reverse(Queued(_, idx))) = self.queue.pop() {
            if self.poses[idx].is_goal {
                best = Some(idx);
                break;
            }
            let (pose, cost_m, is_backwards) = self.of(idx);
            if self.cheapest.get(&self.key(pose, is_backwards)).is_some_and(|least_m| cost_m > *least_m) {
                continue;
            }
            if until_look == 0 {
                self.look_at_goal(idx);
                // The farther the goal, the less likely is a free curve to it.
                until_look = (self.least_m(pose) / self.radius_m) as usize;
            } else {
                until_look -= 1;
            }
            self.expand(idx);
            if self.poses.len() > MOST_POSES {
                break;
            }
        }
        let by_cost = |one: &usize, other: &usize| self.poses[*one].cost_m.total_cmp(&self.poses[*other].cost_m);
        let mut idx = best.or_else(|| (0..self.poses.len()).filter(|idx| self.poses[*idx].is_goal).min_by(by_cost))?;
        let mut arcs = Vec::new();
        loop {
            arcs.extend(self.poses[idx].arcs.iter().rev());
            let Some(before) = self.poses[idx].before else { break };
            idx = before;
        }
        arcs.reverse();
        Some(arcs)
    }

    fn of(&self, idx: usize) -> (Pose, f64, Option<bool>) {
        let Reached { pose, cost_m, is_backwards, .. } = &self.poses[idx];
        (*pose, *cost_m, *is_backwards)
    }

    /// Adds the poses at the ends of all arcs from a pose that are free.
    fn expand(&mut self, idx: usize) {
        let (pose, cost_m, is_backwards) = self.of(idx);
        for way in [1.0, -1.0] {
            for steered in STEERED {
                let arc = Arc { length_m: way * self.step_m(), curvature_per_m: steered / self.radius_m };
                let next_cost_m = cost_m + cost(&[arc], is_backwards, self.radius_m);
                let (end, next_backwards) = (arc.end(pose), Some(way < 0.0));
                let is_new =
                    self.cheapest.get(&self.key(end, next_backwards)).is_none_or(|least_m| next_cost_m < *least_m);
                if is_new && self.free.has_arc(pose, &arc) {
                    self.add(Reached {
                        pose: end,
                        cost_m: next_cost_m,
                        is_backwards: next_backwards,
                        before: Some(idx),
                        arcs: vec![arc],
                        is_goal: false,
                    });
                }
            }
        }
    }

    /// Adds the goal by the cheapest free Reeds–Shepp curve from a pose, if there is one.
    fn look_at_goal(&mut self, idx: usize) {
        let (pose, cost_m, is_backwards) = self.of(idx);
        let goal = |nth: usize| Pose {
            x_m: self.goal_m[0],
            y_m: self.goal_m[1],
            heading_rad: TAU * nth as f64 / GOAL_HEADINGS as f64,
        };
        let all = (0..GOAL_HEADINGS).flat_map(|nth| curves(pose, goal(nth), self.radius_m));
        let most_m = self.goal_cost_m - cost_m;
        let Some((curve, curve_m)) = cheapest_free(pose, all, is_backwards, most_m, self.radius_m, self.free) else {
            return;
        };
        self.goal_cost_m = cost_m + curve_m;
        let arcs = stretches(&curve);
        let end = arcs.iter().fold(pose, |at, arc| arc.end(at));
        self.add(Reached {
            pose: end,
            cost_m: cost_m + curve_m,
            is_backwards: None,
            before: Some(idx),
            arcs,
            is_goal: true,
        });
    }

    fn add(&mut self, reached: Reached) {
        let left_m = if reached.is_goal { 0.0 } else { self.least_m(reached.pose) };
        if !reached.is_goal {
            self.cheapest.insert(self.key(reached.pose, reached.is_backwards), reached.cost_m);
        }
        self.queue.push(Reverse(Queued(reached.cost_m + TOWARDS_GOAL * left_m, self.poses.len())));
        self.poses.push(reached);
    }

    /// Length of the arcs by which poses are expanded: one leads out of its cell.
    fn step_m(&self) -> f64 {
        STEP_M.min(STEP_RAD * self.radius_m)
    }

    fn key(&self, pose: Pose, is_backwards: Option<bool>) -> Key {
        let (cell_m, cell_rad) = (0.7 * self.step_m(), 0.5 * self.step_m() / self.radius_m);
        let of = |value: f64, size: f64| (value / size).floor() as i64;
        let heading_rad = pose.heading_rad.rem_euclid(TAU);
        (of(pose.x_m, cell_m), of(pose.y_m, cell_m), of(heading_rad, cell_rad), is_backwards == Some(true))
    }

    /// A cost that every path from a pose to the goal has at least: by the paper's two heuristics, the shortest way through the grid without regard
    /// to the turning circle, and the cheapest way in the open with regard to it.
    fn least_m(&self, pose: Pose) -> f64 {
        // A way over cells is longer than the straight line by up to 1/cos(π/8).
        let around_m =
            self.free.planner.index_at([pose.x_m, pose.y_m]).map_or(f64::INFINITY, |index| self.left_m[index]);
        let (x_m, y_m) = (self.goal_m[0] - pose.x_m, self.goal_m[1] - pose.y_m);
        let straight_m = x_m.hypot(y_m);
        let (sin, cos) = pose.heading_rad.sin_cos();
        let (forward_m, aside_m) = (cos * x_m + sin * y_m, (cos * y_m - sin * x_m).abs());
        // Without a change of direction the way is an arc and its tangent, or at least the straight line if the goal is within the circle.
        let in_one_m = |forward_m: f64| {
            let away_m = forward_m.hypot(aside_m - self.radius_m);
            if away_m < self.radius_m {
                return straight_m;
            }
            let around_rad = forward_m.atan2(self.radius_m - aside_m) - (self.radius_m / away_m).acos();
            self.radius_m * around_rad.rem_euclid(TAU) + (away_m * away_m - self.radius_m * self.radius_m).sqrt()
        };
        let turned_m = in_one_m(forward_m)
            .min(BACKWARDS * in_one_m(-forward_m))
            .min(straight_m + CHANGE_OVER_RADIUS * self.radius_m);
        if around_m.is_finite() { turned_m.max((TAU / 16.0).cos() * around_m) } else { turned_m }
    }
}

/// A pose that the search has reached.
struct Reached {
    pose: Pose,
    cost_m: f64,
    is_backwards: Option<bool>,
    /// Index of the pose before, and the arcs from there.
    before: Option<usize>,
    arcs: Vec<Arc>,
    is_goal: bool,
}

/// A pose in the queue by its estimated cost of the whole path; of equal ones, the one found first comes first.
#[derive(PartialEq)]
struct Queued(f64, usize);

impl Eq for Queued {}

impl Ord for Queued {
    fn cmp(&self, other: &Self) -> std::cmp::Ordering {
        self.0.total_cmp(&other.0).then(self.1.cmp(&other.1))
    }
}

impl PartialOrd for Queued {
    fn partial_cmp(&self, other: &Self) -> Option<std::cmp::Ordering> {
        Some(self.cmp(other))
    }
}

/// Cell of position, heading and direction.
type Key = (i64, i64, i64, bool);

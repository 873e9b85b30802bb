//! Paths for a base with a turning circle, through an occupancy grid: hybrid A* over poses, then shortcuts by Reeds–Shepp curves.
//!
//! Hybrid A* (Dolgov, Thrun, Montemerlo and Diebel, "Path planning for autonomous vehicles in unknown semi-structured environments", International
//! Journal of Robotics Research 29 (2010), section 3) expands poses by short arcs, and keeps for each cell of position, heading and direction the
//! pose that was reached at the least cost, as it truly is. From some of the poses it looks for a Reeds–Shepp curve to the goal that is free. The paper
//! smooths the result by gradient descent; here Reeds–Shepp curves between the poses of the path replace what they shorten, so that every piece
//! remains an arc or a straight line.

mod search;

use localizer::Pose;

use super::{
    planner::{GET_AWAY_M, Planner},
    reeds_shepp::{Arc, Curve, curves},
};
use search::Search;

/// Cost of a metre backwards, in metres forwards: the robot's sensors look ahead, and it drives slower backwards.
const BACKWARDS: f64 = 2.0;
/// Cost of a change of direction, over the circle's radius: the robot stops, and steers to the other side.
const CHANGE_OVER_RADIUS: f64 = 1.0;

/// Greatest number of curves between two poses, or from a pose to a goal, that are tried; dearer ones lead far around.
const MOST_TRIED: usize = 40;

/// Greatest number of poses of a path between which shortcuts are looked for.
const MOST_JOINTS: usize = 40;

/// Planner of paths on a grid for a base with a turning circle.
#[derive(Clone, Debug)]
pub struct CurvePlanner<'a> {
    planner: &'a Planner,
    radius_m: f64,
}

impl<'a> CurvePlanner<'a> {
    /// A planner for a base whose smallest circle has a radius, where the base's middle may be where it may be on straight paths.
    pub fn new(planner: &'a Planner, radius_m: f64) -> CurvePlanner<'a> {
        CurvePlanner { planner, radius_m }
    }

    /// A cheap path from a pose to a place, at which the heading is free: its arcs and straight stretches, of which no two neighbours are alike.
    /// `None` when there is no path.
    pub fn plan(&self, from: Pose, to_m: [f64; 2]) -> Option<Vec<Arc>> {
        let left_m = self.planner.lengths_to(to_m)?;
        let start_m = [from.x_m, from.y_m];
        if !self.planner.nearest_open(start_m).is_some_and(|cell| left_m[self.planner.index(cell)].is_finite()) {
            return None;
        }
        let keep_m = self.planner.kept_m(start_m);
        let free = Free { planner: self.planner, start_m, keep_m };
        let path = Search::new(&free, self.radius_m, to_m, left_m).run(from)?;
        Some(joined(&shortened(from, &path, &free, self.radius_m)))
    }
}

/// Where the middle of the base may be: in open cells, and near a start that is too near to an obstacle as near to it as there.
struct Free<'a> {
    planner: &'a Planner,
    start_m: [f64; 2],
    /// Distance from obstacles at the start, if it is too small.
    keep_m: Option<f64>,
}

impl Free<'_> {
    fn has(&self, place_m: [f64; 2]) -> bool {
        self.planner.is_open_at(place_m)
            || self.keep_m.is_some_and(|keep_m| {
                let away_m = (place_m[0] - self.start_m[0]).hypot(place_m[1] - self.start_m[1]);
                away_m <= GET_AWAY_M && !self.planner.grid().is_crowded(place_m, keep_m)
            })
    }

    /// Whether all of an arc is free, looked at in steps of less than half a cell.
    fn has_arc(&self, from: Pose, arc: &Arc) -> bool {
        let n_looks = (arc.length_m.abs() / (0.4 * self.planner.grid().resolution_m)).ceil() as usize;
        (1..=n_looks).all(|look| {
            let at = arc.after(from, arc.length_m * look as f64 / n_looks as f64);
            self.has([at.x_m, at.y_m])
        })
    }

    fn has_curve(&self, from: Pose, arcs: &[Arc]) -> bool {
        let mut at = from;
        arcs.iter().all(|arc| {
            let is_free = self.has_arc(at, arc);
            at = arc.end(at);
            is_free
        })
    }
}

/// The cheapest free one of some curves from a pose, with its cost, of the [`MOST_TRIED`] cheapest that cost less than `most_m`.
fn cheapest_free(
    from: Pose,
    curves: impl Iterator<Item = Curve>,
    is_backwards: Option<bool>,
    most_m: f64,
    radius_m: f64,
    free: &Free,
) -> Option<(Curve, f64)> {
    let with_cost = curves.map(|curve| (curve, cost(&curve, is_backwards, radius_m)));
    let mut by_cost: Vec<(Curve, f64)> = with_cost.filter(|(_, cost_m)| *cost_m < most_m).collect();
    by_cost.sort_by(|one, other| one.1.total_cmp(&other.1));
    by_cost.into_iter().take(MOST_TRIED).find(|(curve, _)| free.has_curve(from, curve))
}

/// Cost of some arcs in metres forwards, after a drive in a direction.
fn cost(arcs: &[Arc], is_backwards: Option<bool>, radius_m: f64) -> f64 {
    let mut before = is_backwards;
    let of_arc = |arc: &Arc| {
        if arc.length_m == 0.0 {
            return 0.0;
        }
        let is_backwards = arc.length_m < 0.0;
        let is_change = before.replace(is_backwards).is_some_and(|before| before != is_backwards);
        let change_m = if is_change { CHANGE_OVER_RADIUS * radius_m } else { 0.0 };
        change_m + arc.length_m.abs() * if is_backwards { BACKWARDS } else { 1.0 }
    };
    arcs.iter().map(of_arc).sum()
}

/// A path in which Reeds–Shepp curves between some of its poses take the place of what is dearer.
fn shortened(from: Pose, path: &[Arc], free: &Free, radius_m: f64) -> Vec<Arc> {
    let size = path.len().div_ceil(MOST_JOINTS).max(1);
    let pieces: Vec<&[Arc]> = path.chunks(size).collect();
    let mut joints = vec![from];
    joints.extend(pieces.iter().scan(from, |at, piece| {
        *at = piece.iter().fold(*at, |at, arc| arc.end(at));
        Some(*at)
    }));
    // For each joint: the cost of the cheapest path to it, its arcs, and the direction in which it ends.
    let mut best: Vec<(f64, Vec<Arc>, Option<bool>)> = vec![(0.0, Vec::new(), None)];
    for to in 1..joints.len() {
        let mut found: Option<(f64, Vec<Arc>)> = None;
        for before in 0..to {
            let (cost_m, arcs, is_backwards) = &best[before];
            let curve = cheapest_free(
                joints[before],
                curves(joints[before], joints[to], radius_m).into_iter(),
                *is_backwards,
                f64::INFINITY,
                radius_m,
                free,
            );
            let direct =
                (before + 1 == to).then(|| (pieces[before].to_vec(), cost(pieces[before], *is_backwards, radius_m)));
            for (more, more_m) in curve.map(|(curve, curve_m)| (stretches(&curve), curve_m)).into_iter().chain(direct) {
                if found.as_ref().is_none_or(|(least_m, _)| cost_m + more_m < *least_m) {
                    found = Some((cost_m + more_m, [&arcs[..], &more[..]].concat()));
                }
            }
        }
        let (cost_m, arcs) = found.unwrap_or_default();
        let is_backwards = arcs.last().map(|arc| arc.length_m < 0.0);
        best.push((cost_m, arcs, is_backwards));
    }
    best.pop().map(|(_, arcs, _)| arcs).unwrap_or_default()
}

/// The arcs of a curve that have a length.
fn stretches(curve: &Curve) -> Vec<Arc> {
    curve.iter().filter(|arc| arc.length_m != 0.0).copied().collect()
}

/// Arcs of a path, of which neighbours that are parts of one arc are made one.
fn joined(arcs: &[Arc]) -> Vec<Arc> {
    let mut all: Vec<Arc> = Vec::new();
    for arc in arcs {
        match all.last_mut() {
            Some(last)
                if (last.curvature_per_m - arc.curvature_per_m).abs() < 1e-9 && last.length_m * arc.length_m > 0.0 =>
            {
                last.length_m += arc.length_m;
            }
            _ => all.push(*arc),
        }
    }
    all
}

//! How the travel of the robot and of its wheels changes with the deviations of a linear program.

use super::{history::Quantity, kind::Linearised};

/// How the travel between two stamps changes with the deviations at the knots, as sums up to each stamp.
///
/// With A = cos θ Δx + sin θ Δy and L = −sin θ Δx + cos θ Δy, dA = cos θ dΔx + sin θ dΔy + L dθ and dL = −sin θ dΔx + cos θ dΔy − A dθ.
pub(super) struct Gains {
    /// For each stamp the sums of cos θ and sin θ, each times the step's share of the time between its knots, and of L·(1 − s), L·s, A·(1 − s), A·s,
    /// where s is the share of the way from one knot to the next.
    sums: Vec<[f64; 6]>,
}

impl Gains {
    pub(super) fn along(near: &Linearised<'_>) -> Gains {
        let history = near.history;
        let mut sums = vec![[0.0; 6]];
        for (at, step) in history.steps::<f64>().enumerate() {
            let (knot, share) = near.place(at);
            let [from_s, to_s] = [near.knots[knot], near.knots[knot + 1]].map(|knot| history.stamps_s[knot]);
            let part = (history.stamps_s[at + 1] - history.stamps_s[at]) / (to_s - from_s);
            let middle = share + 0.5 * part;
            let (sin, cos) = (0.5 * (history.poses[at].heading_rad + history.poses[at + 1].heading_rad)).sin_cos();
            let gained = [
                cos * part,
                sin * part,
                step.left_m * (1.0 - middle),
                step.left_m * middle,
                step.along_m * (1.0 - middle),
                step.along_m * middle,
            ];
            let last = sums[at];
            sums.push([0, 1, 2, 3, 4, 5].map(|part| last[part] + gained[part]));
        }
        Gains { sums }
    }

    /// The parts of a span that lie between two knots each: the knot, and the sums over the part.
    fn parts(&self, near: &Linearised<'_>, from: usize, to: usize) -> Vec<(usize, [f64; 6])> {
        let mut parts = Vec::new();
        let mut at = from;
        while at < to {
            let knot = near.place(at).0;
            let end = near.knots[knot + 1].min(to);
            parts.push((knot, [0, 1, 2, 3, 4, 5].map(|part| self.sums[end][part] - self.sums[at][part])));
            at = end;
        }
        parts
    }

    /// Terms of the travel along the robot's x axis between two stamps.
    pub(super) fn along_of(&self, near: &Linearised<'_>, from: usize, to: usize) -> Vec<(usize, f64)> {
        let parts = self.parts(near, from, to);
        let terms = parts.iter().flat_map(|&(knot, [cos, sin, left_0, left_1, ..])| {
            let (a, b) = (near.at_knot(knot, 0), near.at_knot(knot + 1, 0));
            [(a, -cos), (b, cos), (a + 1, -sin), (b + 1, sin), (a + 2, left_0), (b + 2, left_1)]
        });
        terms.collect()
    }

    /// Terms of the travel of the left (0) or the right (1) wheel's contact point between two stamps.
    pub(super) fn wheel(&self, near: &Linearised<'_>, wheel: usize, from: usize, to: usize) -> Vec<(usize, f64)> {
        let mut terms = self.along_of(near, from, to);
        let side = if wheel == 0 { -0.5 } else { 0.5 };
        let (track_m, poses) = (near.history.value(Quantity::Track), &near.history.poses);
        terms.extend(near.pose(to, 2, side * track_m));
        terms.extend(near.pose(from, 2, -side * track_m));
        terms.push(near.quantity(Quantity::Track, side * (poses[to].heading_rad - poses[from].heading_rad)));
        terms
    }

    /// Terms of the travel along the robot's y axis between two stamps.
    pub(super) fn left(&self, near: &Linearised<'_>, from: usize, to: usize) -> Vec<(usize, f64)> {
        let parts = self.parts(near, from, to);
        let terms = parts.iter().flat_map(|&(knot, [cos, sin, _, _, along_0, along_1])| {
            let (a, b) = (near.at_knot(knot, 0), near.at_knot(knot + 1, 0));
            [(a, sin), (b, -sin), (a + 1, -cos), (b + 1, cos), (a + 2, -along_0), (b + 2, -along_1)]
        });
        terms.collect()
    }
}

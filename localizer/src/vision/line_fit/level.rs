//! Encloses the lines `y = m·x + b` that are near enough to at least K of the given points: slopes are bisected, intercepts are found by a sweep.

use std::cell::RefCell;

/// Points in local coordinates `[x, y, bound]`, and the number `needed` of them that a line must be within the bound of.
pub(super) struct Level<'a> {
    points: &'a [[f64; 3]],
    needed: usize,
    /// Greatest |x| of the points, which is the greatest rate at which the line's allowed intercepts move with its slope.
    reach_px: f64,
    /// Lower and upper ends of the intervals of intercepts, one interval per point, for which a line is within the point's bound; both ascending, as
    /// the last sweep left them.
    ends: RefCell<[Vec<End>; 2]>,
}

/// End of the interval of intercepts that a point allows.
#[derive(Clone, Copy)]
struct End {
    intercept_px: f64,
    /// Index of the point.
    point: usize,
}

/// Moves ends to the intercepts that `at` gives for each point, and puts them in ascending order.
///
/// From one range of slopes to the next one few ends change places, so that sorting by insertion takes hardly more than one step for each of them.
fn move_ends(ends: &mut [End], at: impl Fn(usize) -> f64) {
    for index in 0..ends.len() {
        let end = End { intercept_px: at(ends[index].point), ..ends[index] };
        let mut place = index;
        while place > 0 && ends[place - 1].intercept_px.total_cmp(&end.intercept_px).is_gt() {
            ends[place] = ends[place - 1];
            place -= 1;
        }
        ends[place] = end;
    }
}

/// A leaf of the bisection: a range of slopes `[from, to]` and the range of intercepts `[least, greatest]` of all lines in question with slopes in
/// it.
#[derive(Clone, Copy)]
pub(super) struct Leaf {
    pub(super) slope: [f64; 2],
    pub(super) intercept_px: [f64; 2],
}

impl<'a> Level<'a> {
    pub(super) fn new(points: &'a [[f64; 3]], needed: usize) -> Self {
        let reach_px = points.iter().map(|point| point[0].abs()).fold(0.0, f64::max);
        let ends = |from_px: f64| -> Vec<End> {
            let mut ends: Vec<End> = (0..points.len())
                .map(|point| End { intercept_px: points[point][1] + from_px * points[point][2], point })
                .collect();
            ends.sort_unstable_by(|one, other| one.intercept_px.total_cmp(&other.intercept_px));
            ends
        };
        Level { points, needed, reach_px, ends: RefCell::new([ends(-1.0), ends(1.0)]) }
    }

    /// Divides a range of slopes into small ranges (leaves), by ascending slope, and drops those that no line near enough to the points has. The
    /// leaves are so narrow that each widens the lines' intercepts by no more than `slack_px`.
    pub(super) fn leaves(&self, slope: [f64; 2], slack_px: f64) -> Vec<Leaf> {
        let mut leaves = Vec::with_capacity(64);
        self.bisect(slope, slack_px, &mut leaves);
        if leaves.len() > 1 {
            let end = leaves.len() - 1;
            leaves[0].slope[0] = self.sharpened(leaves[0].slope, false);
            leaves[end].slope[1] = self.sharpened(leaves[end].slope, true);
        }
        leaves
    }

    fn bisect(&self, slope: [f64; 2], slack_px: f64, leaves: &mut Vec<Leaf>) {
        let Some(intercept_px) = self.intercepts(slope) else { return };
        if self.reach_px * (slope[1] - slope[0]) <= slack_px {
            leaves.push(Leaf { slope, intercept_px });
            return;
        }
        let middle = 0.5 * (slope[0] + slope[1]);
        self.bisect([slope[0], middle], slack_px, leaves);
        self.bisect([middle, slope[1]], slack_px, leaves);
    }

    /// Hull of the intercepts that at least `needed` points allow, each point for some slope in the range.
    ///
    /// A point allows a line the intercepts `y − m·x ± bound`; over a range of slopes this is one interval. A sweep over the ends of these intervals
    /// finds where enough of them overlap: the number of intervals that cover `b` is the number that have begun less the number that have ended.
    fn intercepts(&self, slope: [f64; 2]) -> Option<[f64; 2]> {
        let allowed = |point: usize| {
            let [x, y, bound_px] = self.points[point];
            let (a, b) = (y - slope[0] * x, y - slope[1] * x);
            let (least, greatest) = (a.min(b) - bound_px, a.max(b) + bound_px);
            // No line is within a negative bound of a point: its interval goes to the end of both lists, and is left out.
            if least <= greatest { [least, greatest] } else { [f64::INFINITY; 2] }
        };
        let mut ends = self.ends.borrow_mut();
        for (which, ends) in ends.iter_mut().enumerate() {
            move_ends(ends, |point| allowed(point)[which]);
        }
        let [lower, upper] = ends.each_ref().map(|ends| {
            let n_left = ends.partition_point(|end| end.intercept_px < f64::INFINITY);
            &ends[..n_left]
        });
        let mut ended = 0;
        let least = lower.iter().map(|end| end.intercept_px).enumerate().find(|&(begun, b)| {
            ended += upper[ended..].iter().take_while(|end| end.intercept_px < b).count();
            begun + 1 - ended >= self.needed
        });
        let mut not_begun = 0;
        let count = lower.len();
        let greatest = upper.iter().rev().map(|end| end.intercept_px).enumerate().find(|&(not_ended, b)| {
            not_begun += lower[..count - not_begun].iter().rev().take_while(|begin| begin.intercept_px > b).count();
            not_ended + 1 - not_begun >= self.needed
        });
        Some([least?.1, greatest?.1])
    }

    /// Least (or greatest) slope, within a given range, that a line near enough to the points may have, found to an eighth of the range's width.
    fn sharpened(&self, slope: [f64; 2], greatest: bool) -> f64 {
        let [mut from, mut to] = slope;
        for _ in 0..3 {
            let middle = 0.5 * (from + to);
            let outer = if greatest { [middle, to] } else { [from, middle] };
            // The outer half of the range of slopes is cut off if no line near enough to the points has its slope there; otherwise the search
            // continues inside of the outer half.
            if greatest == self.intercepts(outer).is_none() { to = middle } else { from = middle }
        }
        if greatest { to } else { from }
    }
}

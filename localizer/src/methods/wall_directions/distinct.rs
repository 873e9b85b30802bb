//! Which edges of an image are witnesses of their own.

use crate::{Interval, vision::forward::EdgeLine};

/// Edges whose ends lie nearer to another one's line, over the focal length, belong to the same thing: both rims of a frame, the
/// painting within it, a shelf that a chair cuts in two. If it is no level edge of the building, all of them are wrong together.
const SAME_THING: f64 = 0.03;

/// For each edge with its direction whether it is kept: of edges that belong together, the one whose direction is known best.
pub(super) fn distinct(edges: &[(EdgeLine, Option<Interval>)], focal_px: f64) -> Vec<bool> {
    let mut order: Vec<(usize, f64)> =
        edges.iter().enumerate().filter_map(|(at, (_, azimuth))| Some((at, azimuth.as_ref()?.width()))).collect();
    order.sort_by(|a, b| a.1.total_cmp(&b.1));
    let mut kept = vec![false; edges.len()];
    for (at, _) in order {
        let belongs = |other: &EdgeLine| farthest_px(&edges[at].0, other) < SAME_THING * focal_px;
        kept[at] = !edges.iter().zip(&kept).any(|((other, _), kept)| *kept && belongs(other));
    }
    kept
}

/// How far the farther end of `edge` lies from the line through `other`.
fn farthest_px(edge: &EdgeLine, other: &EdgeLine) -> f64 {
    let [[u0, v0], [u1, v1]] = other.ends_px;
    let length_px = (u1 - u0).hypot(v1 - v0);
    let distance_px = |[u, v]: [f64; 2]| ((u - u0) * (v1 - v0) - (v - v0) * (u1 - u0)).abs() / length_px;
    distance_px(edge.ends_px[0]).max(distance_px(edge.ends_px[1]))
}

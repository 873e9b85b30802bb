//! Selection of the edges of an image that are independent witnesses of the heading.

use crate::vision::forward::EdgeLine;

/// Greatest distance, over the focal length, of an edge's ends from another edge's line for the two to belong to the same thing: both rims
/// of a frame, the painting within it, a shelf that a chair cuts in two. If the thing is no edge of the building, all its edges are wrong
/// together.
const SAME_THING: f64 = 0.03;

/// Whether each edge is kept. Every edge comes with the error to which its direction is known: of edges that belong together the best known
/// is kept, and an edge of which nothing is known is not kept.
pub(super) fn distinct(edges: &[(EdgeLine, Option<f64>)], focal_px: f64) -> Vec<bool> {
    let mut order: Vec<(usize, f64)> =
        edges.iter().enumerate().filter_map(|(at, (_, known_to))| Some((at, (*known_to)?))).collect();
    order.sort_by(|a, b| a.1.total_cmp(&b.1));
    let mut kept = vec![false; edges.len()];
    for (at, _) in order {
        let belongs = |other: &EdgeLine| farthest_px(&edges[at].0, other) < SAME_THING * focal_px;
        kept[at] = !edges.iter().zip(&kept).any(|((other, _), kept)| *kept && belongs(other));
    }
    kept
}

/// Distance of the farther end of `edge` from the line through `other`.
fn farthest_px(edge: &EdgeLine, other: &EdgeLine) -> f64 {
    let [[u0, v0], [u1, v1]] = other.ends_px;
    let length_px = (u1 - u0).hypot(v1 - v0);
    let distance_px = |[u, v]: [f64; 2]| ((u - u0) * (v1 - v0) - (v - v0) * (u1 - u0)).abs() / length_px;
    distance_px(edge.ends_px[0]).max(distance_px(edge.ends_px[1]))
}

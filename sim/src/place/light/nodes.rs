//! The nodes of a light map (points with a computed illuminance) on one flat face of a building.

use crate::place::building::Panel;

/// The rectangle of a light map that holds the nodes (points with a computed illuminance) of one flat face of the building. The first node is at
/// the face's first corner, the last at the opposite corner.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Patch {
    /// Column and row of the light map in which the first node of a flat face stands.
    pub first: [usize; 2],
    /// Numbers of light-map nodes (points with a computed illuminance) along both sides of a flat face, at least two each.
    pub count: [usize; 2],
}

impl Patch {
    /// The four nodes around a point of the face, by column and row within the face's rectangle, with their bilinear weights. The point is given by
    /// the shares of the face's sides, from 0 to 1.
    pub(super) fn around(&self, shares: [f64; 2]) -> [([usize; 2], f64); 4] {
        let [(i, a), (j, b)] = [0, 1].map(|axis| {
            let place = shares[axis].clamp(0.0, 1.0) * (self.count[axis] - 1) as f64;
            let low = (place as usize).min(self.count[axis] - 2);
            (low, place - low as f64)
        });
        let (left, below) = (1.0 - a, 1.0 - b);
        [([i, j], left * below), ([i + 1, j], a * below), ([i, j + 1], left * b), ([i + 1, j + 1], a * b)]
    }
}

/// Positions of the light-map nodes of a flat face, as shares of the face's sides, row by row.
pub(super) fn nodes_of(patch: Patch) -> impl Iterator<Item = [f64; 2]> {
    let share = |index: usize, count: usize| index as f64 / (count - 1) as f64;
    (0..patch.count[1])
        .flat_map(move |j| (0..patch.count[0]).map(move |i| [share(i, patch.count[0]), share(j, patch.count[1])]))
}

/// Moves a point of a flat face away from the face's edge by a hair, into its outline if it has one. The edge lies in the planes of the neighbouring
/// faces, where it is undefined whether they hide it.
pub(super) fn inside(panel: &Panel, shares: [f64; 2]) -> [f64; 2] {
    let hair = hair(panel);
    let within = nearest(panel, shares);
    [0, 1].map(|axis| within[axis].clamp(hair[axis], 1.0 - hair[axis]))
}

/// The nearest place within the outline of a flat face, a hair away from its edges; without an outline the point itself.
pub(super) fn nearest(panel: &Panel, shares: [f64; 2]) -> [f64; 2] {
    panel.nearest_within(shares, HAIR_M)
}

/// The width of a hair, by which points of a face keep away from its edges.
const HAIR_M: f64 = 0.002;

/// The width of a hair, as shares of a face's sides.
pub(super) fn hair(panel: &Panel) -> [f64; 2] {
    panel.size_m().map(|side_m| (HAIR_M / side_m).min(0.5))
}

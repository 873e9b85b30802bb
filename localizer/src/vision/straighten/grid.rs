//! Raw positions on a grid of nodes, bilinear in between: the motion of a rolling shutter's rows is another one in each image, and to work out every
//! pixel's raw position anew would take most of the time that vision has.

use std::ops::Range;

/// Distances between nodes that are tried, in pixels, the widest first.
const STEPS_PX: [u32; 3] = [8, 4, 2];
/// Greatest error of a position between nodes: the step to which positions in the raw image are rounded.
const TOLERANCE_PX: f64 = 1.0 / 256.0;
/// Number of cells along each side of the image at whose middles the error is measured.
const PROBES: u32 = 9;

/// What a pixel of the straightened image is taken from.
#[derive(Clone, Copy, Debug)]
pub(super) struct Node {
    /// Position in the raw image.
    pub(super) raw_px: [f64; 2],
    /// Least factor by which the lens shrinks what is shown there.
    pub(super) least_slope: f64,
}

impl Node {
    fn between(&self, other: &Node, share: f64) -> Node {
        let mixed = |one: f64, other: f64| one + (other - one) * share;
        Node {
            raw_px: [0, 1].map(|axis| mixed(self.raw_px[axis], other.raw_px[axis])),
            least_slope: mixed(self.least_slope, other.least_slope),
        }
    }
}

/// Nodes at equal distances over an image, row by row; the last ones may lie beyond its edges.
pub(super) struct Grid {
    size_px: [u32; 2],
    step_px: u32,
    columns: usize,
    nodes: Vec<Node>,
}

impl Grid {
    /// Makes the nodes of an image of this size as far apart as the error in between allows. `node` works out a node at a pixel.
    pub(super) fn new(size_px: [u32; 2], node: impl Fn([f64; 2]) -> Node) -> Grid {
        let at = |u: u32, v: u32| node([f64::from(u), f64::from(v)]);
        let is_fine = |step_px: u32| {
            let cell = |axis: usize, index: u32| (size_px[axis] - 1) / step_px * index / (PROBES - 1) * step_px;
            (0..PROBES * PROBES).all(|index| {
                let (u, v) = (cell(0, index % PROBES), cell(1, index / PROBES));
                let [left, right] = [u, u + step_px].map(|u| at(u, v).between(&at(u, v + step_px), 0.5));
                let (told, exact) = (left.between(&right, 0.5), at(u + step_px / 2, v + step_px / 2));
                (0..2).all(|axis| (told.raw_px[axis] - exact.raw_px[axis]).abs() < TOLERANCE_PX)
            })
        };
        let step_px = STEPS_PX.into_iter().find(|step_px| is_fine(*step_px)).unwrap_or(1);
        let [columns, rows] = size_px.map(|size| (size - 1).div_ceil(step_px) + 1);
        let nodes = (0..rows).flat_map(|row| (0..columns).map(move |column| [column * step_px, row * step_px]));
        Grid { size_px, step_px, columns: columns as usize, nodes: nodes.map(|[u, v]| at(u, v)).collect() }
    }

    /// What each pixel of a part of a row is taken from.
    pub(super) fn row(&self, v: u32, columns: Range<u32>) -> impl Iterator<Item = Node> {
        let first = (v / self.step_px) as usize * self.columns;
        // The last row of pixels may be the last row of nodes, which has none below.
        let below = if v.is_multiple_of(self.step_px) { first } else { first + self.columns };
        let share = f64::from(v % self.step_px) / f64::from(self.step_px);
        let across: Vec<Node> = (0..self.columns)
            .map(|column| self.nodes[first + column].between(&self.nodes[below + column], share))
            .collect();
        let step_px = self.step_px;
        columns.map(move |u| {
            let left = (u / step_px) as usize;
            let right = (left + 1).min(across.len() - 1);
            across[left].between(&across[right], f64::from(u % step_px) / f64::from(step_px))
        })
    }

    /// The pixels that have no source, because they do not show what `is_shown` demands. The demand must hold for all between two nodes for which it
    /// holds.
    pub(super) fn without_source(&self, is_shown: impl Fn(&Node) -> bool) -> Vec<[f64; 2]> {
        let shown: Vec<bool> = self.nodes.iter().map(&is_shown).collect();
        let mut without = Vec::new();
        for v in 0..self.size_px[1] {
            let first = (v / self.step_px) as usize * self.columns;
            let last = (first + 2 * self.columns).min(shown.len());
            if shown[first..last].iter().all(|shown| *shown) {
                continue;
            }
            let hidden = self.row(v, 0..self.size_px[0]).zip(0..).filter(|(node, _)| !is_shown(node));
            without.extend(hidden.map(|(_, u): (Node, u32)| [f64::from(u), f64::from(v)]));
        }
        without
    }
}

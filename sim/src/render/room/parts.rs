//! Parts of a panel (flat face) as triangles: rectangles, or what the panel's outline leaves of them.

use bytemuck::{Pod, Zeroable};
use nalgebra::{Vector2, vector};

use crate::place::building::Panel;

/// Device layout of `Node` of surface.wgsl: a vertex of a flat face (panel) of the building.
#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
pub(super) struct NodeOnDevice {
    surface: u32,
    share: [f32; 2],
}

/// A rectangle as two triangles, each given by the indices of its three vertices. What an outline leaves of a rectangle is pairs of triangles, of
/// which the last may have a second triangle without an area.
pub(super) type Rectangle = [u32; 6];

/// The vertices of one flat face, at the corners of the cells into which it is cut and where its outline crosses their sides.
pub(super) struct Parts<'a> {
    index: usize,
    panel: &'a Panel,
    /// Numbers of cells along the face's sides.
    count: [u32; 2],
    /// Index of the first vertex of the cells.
    first: u32,
    nodes: &'a mut Vec<NodeOnDevice>,
}

impl<'a> Parts<'a> {
    /// The vertices of a face with the given number, cut into `count` cells along its sides. They are appended to `nodes`.
    pub(super) fn new(index: usize, panel: &'a Panel, count: [u32; 2], nodes: &'a mut Vec<NodeOnDevice>) -> Self {
        let (first, [columns, rows]) = (nodes.len() as u32, count);
        if panel.outline.is_none() {
            nodes.extend((0..=rows).flat_map(|j| (0..=columns).map(move |i| (i, j))).map(|(i, j)| NodeOnDevice {
                surface: index as u32,
                share: [i as f32 / columns as f32, j as f32 / rows as f32],
            }));
        }
        Parts { index, panel, count, first, nodes }
    }

    /// The triangles of the whole face.
    pub(super) fn whole(&mut self) -> Vec<Rectangle> {
        self.between([0, 0], self.count)
    }

    /// The triangles of the rectangle between two corners of cells.
    pub(super) fn between(&mut self, low: [u32; 2], high: [u32; 2]) -> Vec<Rectangle> {
        let ([i, j], [right, top]) = (low, high);
        let Some(outline) = &self.panel.outline else {
            let at = |i: u32, j: u32| self.first + j * (self.count[0] + 1) + i;
            return vec![[at(i, j), at(right, j), at(right, top), at(i, j), at(right, top), at(i, top)]];
        };
        let size_m = Vector2::from(self.panel.size_m());
        let at_m = |cell: [u32; 2]| {
            Vector2::from_fn(|axis, _| size_m[axis] * f64::from(cell[axis]) / f64::from(self.count[axis]))
        };
        let (low_m, high_m) = (at_m(low), at_m(high));
        let left = outline.pieces().iter().map(|piece| clipped(&piece.corners, low_m, high_m));
        left.flat_map(|corners| {
            let first = self.nodes.len() as u32;
            self.nodes.extend(corners.iter().map(|corner| NodeOnDevice {
                surface: self.index as u32,
                share: [(corner.x / size_m.x) as f32, (corner.y / size_m.y) as f32],
            }));
            // The triangles around the first corner, in pairs.
            let last = (corners.len() as u32).saturating_sub(1);
            let pair = move |at: u32| {
                let then = (at + 2).min(last);
                [first, first + at, first + at + 1, first, first + at + 1, first + then]
            };
            (1..last).step_by(2).map(pair)
        })
        .collect()
    }
}

/// What of a convex polygon is between the least and the greatest coordinates of a rectangle (Sutherland and Hodgman, Reentrant Polygon Clipping,
/// 1974). A point at which a side is cut is the same for both polygons that have the side in common.
fn clipped(polygon: &[Vector2<f64>], low: Vector2<f64>, high: Vector2<f64>) -> Vec<Vector2<f64>> {
    let mut corners = polygon.to_vec();
    for (axis, limit, sign) in [(0, low.x, 1.0), (0, high.x, -1.0), (1, low.y, 1.0), (1, high.y, -1.0)] {
        let within = |at: &Vector2<f64>| sign * (at[axis] - limit);
        let mut left = Vec::with_capacity(corners.len() + 1);
        for (index, from) in corners.iter().enumerate() {
            let to = &corners[(index + 1) % corners.len()];
            if within(from) >= 0.0 {
                left.push(*from);
            }
            if within(from) * within(to) < 0.0 {
                let [one, other] = if from[axis] < to[axis] { [from, to] } else { [to, from] };
                let other_axis = 1 - axis;
                let share = (limit - one[axis]) / (other[axis] - one[axis]);
                let beside = one[other_axis] + (other[other_axis] - one[other_axis]) * share;
                left.push(if axis == 0 { vector![limit, beside] } else { vector![beside, limit] });
            }
        }
        corners = left;
    }
    if corners.len() < 3 { Vec::new() } else { corners }
}

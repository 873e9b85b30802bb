//! Edges of faces in the image. Faces are drawn with one sample a pixel, which leaves their edges jagged; the edges are drawn once more to make
//! them smooth.

use std::{collections::BTreeMap, ops::Range};

use bytemuck::{Pod, Zeroable};
use nalgebra::{Point3, Vector3};

use super::faces::cells_along;
use crate::place::{
    building::{BodyMesh, Building, Panel},
    light::{Lighting, Shape},
};

/// Length up to which two flat faces may reach into each other and still count as touching. Faces that reach farther into each other cross, and get
/// an edge along the line in which they cross.
const MEETING_M: f64 = 0.002;

/// Device layout of `Edge` of edge.wgsl: one edge of a face.
#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
pub(super) struct EdgeOnDevice {
    start: [f32; 3],
    end: [f32; 3],
    normal: [f32; 3],
    other_normal: [f32; 3],
    start_velocity: [f32; 3],
    end_velocity: [f32; 3],
}

impl EdgeOnDevice {
    fn new(start: Point3<f64>, end: Point3<f64>, normal: Vector3<f64>, other_normal: Vector3<f64>) -> Self {
        let single = |vector: Vector3<f64>| [vector.x as f32, vector.y as f32, vector.z as f32];
        EdgeOnDevice {
            start: single(start.coords),
            end: single(end.coords),
            normal: single(normal),
            other_normal: single(other_normal),
            start_velocity: [0.0; 3],
            end_velocity: [0.0; 3],
        }
    }

    /// This edge with ends that move at the given velocities.
    fn moving(self, velocities_m_per_s: [Vector3<f64>; 2]) -> Self {
        let [start_velocity, end_velocity] = velocities_m_per_s.map(|v| [v.x as f32, v.y as f32, v.z as f32]);
        EdgeOnDevice { start_velocity, end_velocity, ..self }
    }
}

/// Edges of all faces in a building that do not move.
#[derive(Debug)]
pub(super) struct Edges {
    /// Indices of the panels (flat faces, one or two) that each edge of the building belongs to.
    panels: Vec<[Option<usize>; 2]>,
}

impl Edges {
    /// Ranges in the list of edges that are drawn: the edges that belong to no panel (flat face) for which `hidden` is true.
    pub(super) fn runs(&self, hidden: &[bool]) -> Vec<Range<u32>> {
        let is_shown = |panels: &[Option<usize>; 2]| !panels.iter().flatten().any(|panel| hidden[*panel]);
        let mut start = 0;
        let chunks = self.panels.chunk_by(|one, other| is_shown(one) == is_shown(other));
        let runs = chunks.map(|chunk| {
            let run = start..start + chunk.len() as u32;
            start = run.end;
            (is_shown(&chunk[0]), run)
        });
        runs.filter_map(|(shown, run)| shown.then_some(run)).collect()
    }
}

/// A rectangle in space, as a corner and the two sides from it.
type Rectangle = (Point3<f64>, Vector3<f64>, Vector3<f64>);

/// Edges of all panels (flat faces) and rectangular lamps. For a rolling shutter, which bends faces and edges alike, edges are cut into pieces as
/// the faces are; otherwise they are whole. Edges of things that stand out from walls come last, because they hide the edges just behind them.
pub(super) fn of_building(building: &Building, lighting: &Lighting, rolling: bool) -> (Vec<EdgeOnDevice>, Edges) {
    let rectangular = building.panels.iter().enumerate().filter(|(_, panel)| panel.outline.is_none());
    let panels = rectangular.map(|(index, panel)| (Some(index), (panel.corner, panel.along, panel.up)));
    let lamps = lighting.sources.iter().filter_map(|source| match source.shape {
        Shape::Rectangle { centre, half_u, half_v } => {
            Some((None, (centre - half_u - half_v, 2.0 * half_u, 2.0 * half_v)))
        }
        Shape::Point { .. } => None,
    });
    let of_side = move |panel: Option<usize>, normal: Vector3<f64>, start: Point3<f64>, side: Vector3<f64>| {
        let count = if rolling { cells_along(side.norm()) } else { 1 };
        let at = move |index: u32| start + side * (f64::from(index) / f64::from(count));
        (0..count)
            .map(move |index| ([panel, None], EdgeOnDevice::new(at(index), at(index + 1), normal, Vector3::zeros())))
    };
    let of_rectangle = move |(panel, (corner, along, up)): (Option<usize>, Rectangle)| {
        let sides = [(corner, along), (corner + along, up), (corner + along + up, -along), (corner + up, -up)];
        sides.into_iter().flat_map(move |(start, side)| of_side(panel, along.cross(&up), start, side))
    };
    let outlined = building.panels.iter().enumerate().flat_map(move |(index, panel)| {
        let place = |at: nalgebra::Vector2<f64>| panel.place(at.x / panel.along.norm(), at.y / panel.up.norm());
        let sides = panel.outline.iter().flat_map(|outline| outline.sides()).map(move |ends| ends.map(place));
        sides.flat_map(move |[from, to]| of_side(Some(index), panel.normal(), from, to - from))
    });
    let all = meetings(&building.panels).chain(outlined).chain(panels.chain(lamps).flat_map(of_rectangle));
    let (panels, edges): (Vec<_>, Vec<_>) = all.unzip();
    (edges, Edges { panels })
}

/// Edges where two panels (flat faces) run through each other, such as those of door frames that are let into a wall.
fn meetings(panels: &[Panel]) -> impl Iterator<Item = ([Option<usize>; 2], EdgeOnDevice)> + '_ {
    let pairs = (0..panels.len()).flat_map(|one| (0..one).map(move |other| [one, other]));
    pairs.filter_map(|pair| {
        let [one, other] = pair.map(|index| &panels[index]);
        let normals = [one, other].map(|panel| panel.along.cross(&panel.up).normalize());
        let along = normals[0].cross(&normals[1]).try_normalize(1e-3)?;
        // The point nearest to the first face's corner on the line in which the planes of two flat faces meet.
        let down = normals[1] - normals[0] * normals[0].dot(&normals[1]);
        let start = one.corner - down * (normals[1].dot(&(one.corner - other.corner)) / down.norm_squared());
        let within = [(one, one.along), (one, one.up), (other, other.along), (other, other.up)];
        let (mut low_m, mut high_m) = (f64::NEG_INFINITY, f64::INFINITY);
        for (panel, side) in within {
            let (at, slope) = (side.dot(&(start - panel.corner)), side.dot(&along));
            let length = side.norm_squared();
            // Where the other panel's plane meets this panel along its border, there is an edge already, so that no other one is added.
            let border = MEETING_M * side.norm();
            if slope.abs() < 1e-9 * side.norm() {
                if at < border || at > length - border {
                    return None;
                }
            } else {
                let (first, last) = (-at / slope, (length - at) / slope);
                (low_m, high_m) = (low_m.max(first.min(last)), high_m.min(first.max(last)));
            }
        }
        let long = high_m - low_m > MEETING_M;
        let ends = [start + along * low_m, start + along * high_m];
        long.then(|| (pair.map(Some), EdgeOnDevice::new(ends[0], ends[1], normals[0], Vector3::zeros())))
    })
}

/// Edges of the triangles of a person's body, each with the normals of the two triangles that it joins; the ends of an edge move with the
/// body.
pub(super) fn of_body(mesh: &BodyMesh, velocities_m_per_s: &[Vector3<f64>]) -> Vec<EdgeOnDevice> {
    let mut normals: BTreeMap<[usize; 2], Vec<Vector3<f64>>> = BTreeMap::new();
    for triangle in &mesh.triangles {
        let [a, b, c] = triangle.map(|corner| mesh.corners[corner].at);
        let normal = (b - a).cross(&(c - a));
        for side in 0..3 {
            let (one, other) = (triangle[side], triangle[(side + 1) % 3]);
            normals.entry([one.min(other), one.max(other)]).or_default().push(normal);
        }
    }
    let edge = |(ends, normals): (&[usize; 2], &Vec<Vector3<f64>>)| {
        let [start, end] = ends.map(|corner| mesh.corners[corner].at);
        let other = normals.get(1).copied().unwrap_or_else(Vector3::zeros);
        EdgeOnDevice::new(start, end, normals[0], other).moving(ends.map(|corner| velocities_m_per_s[corner]))
    };
    normals.iter().map(edge).collect()
}

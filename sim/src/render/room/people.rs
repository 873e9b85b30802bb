//! The people in a room as they were last placed, in memory of the graphics device.

use std::sync::OnceLock;

use nalgebra::Point3;

use super::frustum::Frustum;
use crate::{place::building::UprightBody, render::device::Graphics};

/// Graphics buffers with all people of the scene: the vertices and edges of one person follow those of another, and the list of triangles, the
/// same for each person, is stored once.
#[derive(Debug)]
pub(super) struct People {
    pub(super) placed: Vec<UprightBody>,
    /// Vertices of all people, as lit in the visible and in the infrared band; of each person once that is lit.
    pub(super) corners: [wgpu::Buffer; 2],
    pub(super) corners_of_each: u32,
    /// For each person whether the vertices are lit.
    pub(super) lit: Vec<OnceLock<()>>,
    /// Triangles of one person's body, as the indices of three vertices each.
    pub(super) triangles: wgpu::Buffer,
    pub(super) indices_of_each: u32,
    /// Edges of all people, used for both bands.
    pub(super) edges: wgpu::Buffer,
    pub(super) edges_of_each: u32,
}

impl People {
    pub(super) fn none(graphics: &Graphics) -> People {
        People {
            placed: Vec::new(),
            corners: [0, 1].map(|_| vertices(graphics, 64)),
            corners_of_each: 0,
            lit: Vec::new(),
            triangles: vertices(graphics, 64),
            indices_of_each: 0,
            edges: vertices(graphics, 128),
            edges_of_each: 0,
        }
    }

    /// Indices of the people who may be visible at some time of an exposure.
    pub(super) fn seen_in(&self, frustum: &Frustum) -> Vec<usize> {
        (0..self.placed.len()).filter(|index| !frustum.hides(&surrounding(&self.placed[*index]))).collect()
    }
}

/// Corners of a box that contains a body during the last two seconds before it is where it was placed; exposures are shorter than that.
fn surrounding(body: &UprightBody) -> Vec<Point3<f64>> {
    const ARMS: f64 = 1.5;
    let reach_m = ARMS * body.radius_m + 0.2 * body.height_m;
    let before = body.later(-2.0);
    let corner = |middle_m: [f64; 2], [x, y, z]: [f64; 3]| {
        Point3::new(middle_m[0] + x * reach_m, middle_m[1] + y * reach_m, z * body.height_m)
    };
    let signs = [[-1.0, -1.0], [1.0, -1.0], [-1.0, 1.0], [1.0, 1.0]];
    let shares = signs.into_iter().flat_map(|[x, y]| [[x, y, 0.0], [x, y, 1.0]]);
    shares.flat_map(|share| [corner(body.middle_m, share), corner(before.middle_m, share)]).collect()
}

/// A graphics buffer for vertices of people, or for the triangles between them.
pub(super) fn vertices(graphics: &Graphics, size: u64) -> wgpu::Buffer {
    graphics.device.create_buffer(&wgpu::BufferDescriptor {
        label: Some("people"),
        size,
        usage: wgpu::BufferUsages::VERTEX | wgpu::BufferUsages::INDEX | wgpu::BufferUsages::COPY_DST,
        mapped_at_creation: false,
    })
}

//! How people are drawn: their surfaces are lit vertex by vertex, and their shadows are added to the light map. Both are computed when
//! people move, not for every view.

use bytemuck::{Pod, Zeroable};
use nalgebra::{Point3, Vector3};

use super::{
    edges::{self, EdgeOnDevice},
    frustum::Frustum,
    motion::SubFrame,
    pipelines::Pipelines,
    world::{RoomWorld, write_light},
};
use crate::{
    place::{
        building::{BodyVertex, UprightBody, body_mesh},
        light::nodes_with_people,
    },
    render::device::Graphics,
};

/// Number of points along each side of a lamp at which its visibility from a vertex of a person is tested; a few hundred vertices are lit each
/// time.
const LAMP_SAMPLES: usize = 2;

/// Distance that the shadows of walking people must move during a picture for their motion to be drawn; with less, shadows stay where they are at
/// the end. It is the distance between the light map's nodes on floors.
const SHADOW_STEP_M: f64 = 0.05;

/// Device layout of `Corner` of body.wgsl: a vertex of a person.
#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
struct CornerOnDevice {
    world: [f32; 3],
    normal: [f32; 3],
    lit: f32,
    albedo: f32,
    velocity_m_per_s: [f32; 3],
}

/// Graphics buffers with all people of the scene: the vertices and edges of one person follow those of another, and the list of triangles, the
/// same for each person, is stored once.
#[derive(Debug)]
pub(super) struct People {
    pub(super) placed: Vec<UprightBody>,
    /// Vertices of all people, as lit in the visible and in the infrared band.
    pub(super) corners: [wgpu::Buffer; 2],
    pub(super) corners_of_each: u32,
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

impl RoomWorld {
    /// Sets where people are in the next pictures. Returns the illuminance at the nodes of the light map with the people's shadows, or `None` if
    /// the people were there already.
    pub(in crate::render) fn place_bodies(
        &mut self,
        graphics: &Graphics,
        bodies: &[UprightBody],
    ) -> Option<Vec<[f32; 2]>> {
        if self.people.placed == bodies {
            return None;
        }
        let nodes = nodes_with_people(&self.lighting, &self.map, &self.building.panels, bodies);
        for (band, texture) in self.light_maps.iter().enumerate() {
            write_light(graphics, texture, &nodes, band);
        }
        let corners = self.lit_corners(bodies);
        for (band, corners) in corners.iter().enumerate() {
            write(graphics, &mut self.people.corners[band], bytemuck::cast_slice(corners));
        }
        let edges: Vec<EdgeOnDevice> =
            bodies.iter().flat_map(|body| edges::of_body(&body_mesh(body), &velocities(body))).collect();
        write(graphics, &mut self.people.edges, bytemuck::cast_slice(&edges));
        let n_bodies = bodies.len().max(1) as u32;
        self.people.edges_of_each = edges.len() as u32 / n_bodies;
        self.people.corners_of_each = corners[0].len() as u32 / n_bodies;
        let triangles = bodies.first().map_or_else(Vec::new, |body| body_mesh(body).triangles);
        let indices: Vec<u32> = triangles.iter().flatten().map(|corner| *corner as u32).collect();
        write(graphics, &mut self.people.triangles, bytemuck::cast_slice(&indices));
        self.people.indices_of_each = indices.len() as u32;
        self.people.placed = bodies.to_vec();
        Some(nodes)
    }

    /// Bindings with the light for several equal runs of an exposure's sub-frames (instants), because the shadows of walking people move from run
    /// to run. The list is empty if the shadows move by less than the distance between nodes of the light map, so that one state of the light
    /// serves for all sub-frames.
    pub(super) fn lit_while_they_walk(
        &self,
        graphics: &Graphics,
        pipelines: &Pipelines,
        frames: &[SubFrame],
        band: usize,
    ) -> Vec<wgpu::BindGroup> {
        let start_s = frames.first().map_or(0.0, |frame| frame.before_end_s);
        let speed = |body: &UprightBody| body.velocity_m_per_s[0].hypot(body.velocity_m_per_s[1]);
        let way_m = self.people.placed.iter().map(speed).fold(0.0, f64::max) * start_s.abs();
        let wanted = (way_m / SHADOW_STEP_M).ceil() as usize;
        if wanted < 2 {
            return Vec::new();
        }
        let runs = wanted.min(frames.len());
        let lit = |run: usize| {
            let of_run: Vec<f64> = (0..frames.len())
                .filter(|index| run_of(*index, frames.len(), runs) == run)
                .map(|index| frames[index].before_end_s)
                .collect();
            let before_end_s = of_run.iter().sum::<f64>() / of_run.len() as f64;
            let bodies: Vec<UprightBody> = self.people.placed.iter().map(|body| body.later(before_end_s)).collect();
            let nodes = nodes_with_people(&self.lighting, &self.map, &self.building.panels, &bodies);
            self.lit_by(graphics, pipelines, band, &nodes)
        };
        (0..runs).map(lit).collect()
    }

    fn lit_corners(&self, bodies: &[UprightBody]) -> [Vec<CornerOnDevice>; 2] {
        let lit = |(vertex, velocity): (&BodyVertex, &Vector3<f64>)| {
            let room = self.building.room_at(vertex.at);
            let light = self.lighting.at(vertex.at, vertex.normal, room, LAMP_SAMPLES).by_band;
            [0, 1].map(|band| CornerOnDevice {
                world: [vertex.at.x as f32, vertex.at.y as f32, vertex.at.z as f32],
                normal: [vertex.normal.x as f32, vertex.normal.y as f32, vertex.normal.z as f32],
                lit: (vertex.albedo[band] * light[band] / self.lighting.dimming.max(1e-30)) as f32,
                albedo: vertex.albedo[band] as f32,
                velocity_m_per_s: [velocity.x as f32, velocity.y as f32, velocity.z as f32],
            })
        };
        let mut corners = [Vec::new(), Vec::new()];
        for body in bodies {
            for both in body_mesh(body).corners.iter().zip(&velocities(body)).map(lit) {
                corners.iter_mut().zip(both).for_each(|(corners, corner)| corners.push(corner));
            }
        }
        corners
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

/// Index of the run that a sub-frame (an instant of the exposure) belongs to, if the sub-frames are divided into the given number of equal runs.
pub(super) fn run_of(index: usize, frames: usize, runs: usize) -> usize {
    index * runs / frames
}

/// Velocities of the vertices of a body's surface, legs and arms included.
fn velocities(body: &UprightBody) -> Vec<Vector3<f64>> {
    const STEP_S: f64 = 0.01;
    let (now, later) = (body_mesh(body), body_mesh(&body.later(STEP_S)));
    now.corners.iter().zip(&later.corners).map(|(corner, later)| (later.at - corner.at) / STEP_S).collect()
}

/// Writes new content into a graphics buffer; the buffer is replaced by a larger one if necessary.
fn write(graphics: &Graphics, buffer: &mut wgpu::Buffer, bytes: &[u8]) {
    if bytes.len() as u64 > buffer.size() {
        *buffer = vertices(graphics, (bytes.len() as u64).next_power_of_two());
    }
    graphics.queue.write_buffer(buffer, 0, bytes);
}

fn vertices(graphics: &Graphics, size: u64) -> wgpu::Buffer {
    graphics.device.create_buffer(&wgpu::BufferDescriptor {
        label: Some("people"),
        size,
        usage: wgpu::BufferUsages::VERTEX | wgpu::BufferUsages::INDEX | wgpu::BufferUsages::COPY_DST,
        mapped_at_creation: false,
    })
}

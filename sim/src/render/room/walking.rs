//! Places people in a room: their surfaces are lit vertex by vertex, and their shadows are added to the light map. Both are computed when
//! people move, not for every view; the surfaces only of people whom a view may show.

use std::sync::OnceLock;

use bytemuck::{Pod, Zeroable};
use nalgebra::Vector3;

use super::{
    edges::{self, EdgeOnDevice},
    motion::SubFrame,
    people::vertices,
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
        let corners_of_each = bodies.first().map_or(0, |body| body_mesh(body).corners.len());
        let n_corners = corners_of_each * bodies.len();
        for corners in &mut self.people.corners {
            reserve(graphics, corners, n_corners * size_of::<CornerOnDevice>());
        }
        self.people.lit = bodies.iter().map(|_| OnceLock::new()).collect();
        let edges: Vec<EdgeOnDevice> =
            bodies.iter().flat_map(|body| edges::of_body(&body_mesh(body), &velocities(body))).collect();
        write(graphics, &mut self.people.edges, bytemuck::cast_slice(&edges));
        let n_bodies = bodies.len().max(1) as u32;
        self.people.edges_of_each = edges.len() as u32 / n_bodies;
        self.people.corners_of_each = corners_of_each as u32;
        let triangles = bodies.first().map_or_else(Vec::new, |body| body_mesh(body).triangles);
        let indices: Vec<u32> = triangles.iter().flatten().map(|corner| *corner as u32).collect();
        write(graphics, &mut self.people.triangles, bytemuck::cast_slice(&indices));
        self.people.indices_of_each = indices.len() as u32;
        self.people.placed = bodies.to_vec();
        self.shade(graphics);
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

    /// Lights the people whom a picture may show, each once for all pictures until people are placed anew. In a hall most people are in no picture,
    /// and a person's vertices take as long to be lit as many thousand nodes of the light map.
    pub(super) fn light_bodies(&self, graphics: &Graphics, seen: &[usize]) {
        for index in seen {
            self.people.lit[*index].get_or_init(|| {
                let first = *index * self.people.corners_of_each as usize * size_of::<CornerOnDevice>();
                let corners = self.lit_corners(&self.people.placed[*index]);
                for (buffer, corners) in self.people.corners.iter().zip(&corners) {
                    graphics.queue.write_buffer(buffer, first as u64, bytemuck::cast_slice(corners));
                }
            });
        }
    }

    fn lit_corners(&self, body: &UprightBody) -> [Vec<CornerOnDevice>; 2] {
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
        for both in body_mesh(body).corners.iter().zip(&velocities(body)).map(lit) {
            corners.iter_mut().zip(both).for_each(|(corners, corner)| corners.push(corner));
        }
        corners
    }
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
    reserve(graphics, buffer, bytes.len());
    graphics.queue.write_buffer(buffer, 0, bytes);
}

/// Replaces a graphics buffer by a larger one if it has no room for so many bytes.
fn reserve(graphics: &Graphics, buffer: &mut wgpu::Buffer, bytes: usize) {
    if bytes as u64 > buffer.size() {
        *buffer = vertices(graphics, (bytes as u64).next_power_of_two());
    }
}

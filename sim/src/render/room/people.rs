//! People as they are drawn: lit corner by corner, and their shadows in the light map. Both are worked out when people move, not for every view.

use bytemuck::{Pod, Zeroable};
use nalgebra::Vector3;

use super::{
    edges::{self, EdgeOnDevice},
    world::{RoomWorld, write_light},
};
use crate::{
    building::{BodyVertex, UprightBody, body_mesh},
    light::nodes_with_people,
    render::device::Graphics,
};

/// Places along each side of a lamp that a corner of a person sees or does not: a few hundred corners are lit each time.
const LAMP_SAMPLES: usize = 2;

/// `Corner` of body.wgsl.
#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
struct CornerOnDevice {
    world: [f32; 3],
    normal: [f32; 3],
    lit: f32,
    albedo: f32,
    velocity_m_per_s: [f32; 3],
}

/// People's corners on the device, three to a triangle.
#[derive(Debug)]
pub(super) struct People {
    pub(super) placed: Vec<UprightBody>,
    /// Visible and infrared.
    pub(super) corners: [wgpu::Buffer; 2],
    pub(super) corner_count: u32,
    /// Of both bands.
    pub(super) edges: wgpu::Buffer,
    pub(super) edge_count: u32,
}

impl People {
    pub(super) fn none(graphics: &Graphics) -> People {
        People {
            placed: Vec::new(),
            corners: [0, 1].map(|_| vertices(graphics, 64)),
            corner_count: 0,
            edges: vertices(graphics, 128),
            edge_count: 0,
        }
    }
}

impl RoomWorld {
    /// Puts people where the next pictures show them.
    pub(in crate::render) fn place_bodies(&mut self, graphics: &Graphics, bodies: &[UprightBody]) {
        if self.people.placed == bodies {
            return;
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
        self.people.edge_count = edges.len() as u32;
        self.people.corner_count = corners[0].len() as u32;
        self.people.placed = bodies.to_vec();
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
            let mesh = body_mesh(body);
            let once: Vec<[CornerOnDevice; 2]> = mesh.corners.iter().zip(&velocities(body)).map(lit).collect();
            for (band, corners) in corners.iter_mut().enumerate() {
                corners.extend(mesh.triangles.iter().flatten().map(|corner| once[*corner][band]));
            }
        }
        corners
    }
}

/// How fast the corners of a body's surface move, legs and arms included.
fn velocities(body: &UprightBody) -> Vec<Vector3<f64>> {
    const STEP_S: f64 = 0.01;
    let (now, later) = (body_mesh(body), body_mesh(&body.later(STEP_S)));
    now.corners.iter().zip(&later.corners).map(|(corner, later)| (later.at - corner.at) / STEP_S).collect()
}

/// Writes a buffer anew, into a larger one where it has to be.
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
        usage: wgpu::BufferUsages::VERTEX | wgpu::BufferUsages::COPY_DST,
        mapped_at_creation: false,
    })
}

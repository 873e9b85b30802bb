//! People as they are drawn: lit corner by corner, and their shadows in the light map. Both are worked out when people move, not for every view.

use bytemuck::{Pod, Zeroable};

use super::world::{RoomWorld, write_light};
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
}

/// People's corners on the device, three to a triangle.
#[derive(Debug)]
pub(super) struct People {
    placed: Vec<UprightBody>,
    /// Visible and infrared.
    pub(super) corners: [wgpu::Buffer; 2],
    pub(super) corner_count: u32,
}

impl People {
    pub(super) fn none(graphics: &Graphics) -> People {
        People { placed: Vec::new(), corners: [0, 1].map(|_| vertices(graphics, 32)), corner_count: 0 }
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
            let bytes: &[u8] = bytemuck::cast_slice(corners);
            if bytes.len() as u64 > self.people.corners[band].size() {
                self.people.corners[band] = vertices(graphics, (bytes.len() as u64).next_power_of_two());
            }
            graphics.queue.write_buffer(&self.people.corners[band], 0, bytes);
        }
        self.people.corner_count = corners[0].len() as u32;
        self.people.placed = bodies.to_vec();
    }

    fn lit_corners(&self, bodies: &[UprightBody]) -> [Vec<CornerOnDevice>; 2] {
        let lit = |vertex: &BodyVertex| {
            let room = self.building.room_at(vertex.at);
            let light = self.lighting.at(vertex.at, vertex.normal, room, LAMP_SAMPLES).by_band;
            [0, 1].map(|band| CornerOnDevice {
                world: [vertex.at.x as f32, vertex.at.y as f32, vertex.at.z as f32],
                normal: [vertex.normal.x as f32, vertex.normal.y as f32, vertex.normal.z as f32],
                lit: (vertex.albedo[band] * light[band] / self.lighting.dimming.max(1e-30)) as f32,
                albedo: vertex.albedo[band] as f32,
            })
        };
        let mut corners = [Vec::new(), Vec::new()];
        for body in bodies {
            let mesh = body_mesh(body);
            let once: Vec<[CornerOnDevice; 2]> = mesh.corners.iter().map(lit).collect();
            for (band, corners) in corners.iter_mut().enumerate() {
                corners.extend(mesh.triangles.iter().flatten().map(|corner| once[*corner][band]));
            }
        }
        corners
    }
}

fn vertices(graphics: &Graphics, size: u64) -> wgpu::Buffer {
    graphics.device.create_buffer(&wgpu::BufferDescriptor {
        label: Some("people"),
        size,
        usage: wgpu::BufferUsages::VERTEX | wgpu::BufferUsages::COPY_DST,
        mapped_at_creation: false,
    })
}

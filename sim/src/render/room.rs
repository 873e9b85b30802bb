//! The room pass: everything that a camera with a lens sees, as luminance averaged over the exposure.
//!
//! ```text
//! for each sub-frame: faces, lamps, bodies, discs ─> plate (a pinhole's image, four samples a pixel)
//!                     plate ─> lens (where each pixel takes its light from) ─> += luminance
//! ```

use super::{RenderError, View, device::Graphics};
use crate::sensors::lens::Lens;

mod faces;
mod layouts;
mod map;
mod motion;
mod pipelines;
mod people;
mod plate;
mod world;

pub(super) use plate::RoomSlot;
pub(super) use world::RoomWorld;

use motion::{SubFrame, sub_frames};
use pipelines::{Pipelines, Use};
use plate::ViewOnDevice;

/// Pipelines and layouts of the room.
pub(super) struct RoomPass {
    pipelines: Pipelines,
}

impl RoomPass {
    pub(super) fn new(device: &wgpu::Device) -> RoomPass {
        RoomPass { pipelines: Pipelines::new(device) }
    }

    /// A scene's building on the device.
    pub(super) fn upload(
        &self,
        graphics: &Graphics,
        scene: &crate::scene::Scene,
        drawn: &crate::drawn::Drawn,
    ) -> RoomWorld {
        RoomWorld::new(graphics, &self.pipelines, scene, drawn)
    }

    /// Draws one view into a luminance target.
    pub(super) fn draw(
        &mut self,
        graphics: &Graphics,
        encoder: &mut wgpu::CommandEncoder,
        world: &RoomWorld,
        (view, lens): (&View, &Lens),
        slot: &mut Option<RoomSlot>,
        luminance: &wgpu::TextureView,
    ) -> Result<(), RenderError> {
        if !slot.as_ref().is_some_and(|slot| slot.lens == *lens) {
            *slot = Some(RoomSlot::new(graphics, &self.pipelines, lens)?);
        }
        let Some(slot) = slot else { return Ok(()) };
        let frames = sub_frames(lens, &view.world_from_camera, view.exposure_s)
            .ok_or(RenderError::BadView("it has no camera pose"))?;
        let turned_up = view.illuminance_at_floor_lux / world.mean_at_floor_lux().max(1e-12);
        for (index, frame) in frames.iter().enumerate() {
            let on_device = ViewOnDevice::new(lens, slot, frame, world, turned_up);
            slot.write_view(graphics, index, &on_device, 1.0 / frames.len() as f32);
        }
        let how = Use::of(lens);
        self.pipelines.prepare(&graphics.device, &how, world.kinds());
        for index in 0..frames.len() {
            self.draw_plate(encoder, world, slot, &how, index);
            self.draw_lens(encoder, slot, &how, index, luminance);
        }
        Ok(())
    }

    fn draw_plate(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        world: &RoomWorld,
        slot: &RoomSlot,
        how: &Use,
        index: usize,
    ) {
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("plate"),
            color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                view: &slot.plate,
                depth_slice: None,
                resolve_target: None,
                ops: wgpu::Operations { load: wgpu::LoadOp::Clear(wgpu::Color::BLACK), store: wgpu::StoreOp::Store },
            })],
            depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
                view: &slot.depth,
                depth_ops: Some(wgpu::Operations { load: wgpu::LoadOp::Clear(0.0), store: wgpu::StoreOp::Discard }),
                stencil_ops: None,
            }),
            ..Default::default()
        });
        pass.set_bind_group(0, &slot.view_bindings, &[plate::view_offset(index)]);
        pass.set_bind_group(1, world.bindings(how.band()), &[]);
        pass.set_vertex_buffer(0, world.nodes.slice(..));
        pass.set_index_buffer(world.indices.slice(..), wgpu::IndexFormat::Uint32);
        for (kind, range) in &world.ranges {
            pass.set_pipeline(self.pipelines.surface(how, *kind));
            pass.draw_indexed(range.clone(), 0, 0..1);
        }
        pass.set_pipeline(self.pipelines.lamps(how));
        pass.draw(0..6, 0..world.first_bulb);
        if world.people.corner_count > 0 {
            pass.set_pipeline(self.pipelines.bodies(how));
            pass.set_vertex_buffer(0, world.people.corners[how.band()].slice(..));
            pass.draw(0..world.people.corner_count, 0..1);
        }
        if world.disc_count > 0 {
            pass.set_pipeline(self.pipelines.discs(how));
            pass.set_vertex_buffer(0, world.discs(how.band()).slice(..));
            pass.draw(0..4, 0..world.disc_count);
        }
    }

    fn draw_lens(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        slot: &RoomSlot,
        how: &Use,
        index: usize,
        luminance: &wgpu::TextureView,
    ) {
        let load = if index == 0 { wgpu::LoadOp::Clear(wgpu::Color::BLACK) } else { wgpu::LoadOp::Load };
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("lens"),
            color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                view: luminance,
                depth_slice: None,
                resolve_target: None,
                ops: wgpu::Operations { load, store: wgpu::StoreOp::Store },
            })],
            ..Default::default()
        });
        pass.set_pipeline(self.pipelines.lens(how));
        pass.set_bind_group(0, &slot.lens_bindings, &[]);
        pass.draw(0..3, 0..1);
    }
}

/// The pose and twist of the camera in a sub-frame, put into the terms of view.wgsl.
fn twist_rows(frame: &SubFrame) -> ([[f32; 4]; 3], [f32; 4], [f32; 4]) {
    let camera_from_world = frame.world_from_camera.inverse().to_homogeneous();
    let rows = std::array::from_fn(|row| std::array::from_fn(|column| camera_from_world[(row, column)] as f32));
    let extended = |vector: nalgebra::Vector3<f64>| [vector.x as f32, vector.y as f32, vector.z as f32, 0.0];
    (rows, extended(frame.turn_rad_per_s), extended(frame.drift_m_per_s))
}

//! The room pass: draws everything that a camera with a lens sees, as luminance averaged over the exposure. A sub-frame is one of the instants by
//! which the exposure is approximated, a strip a face hardly wider than a pixel.
//!
//! ```text
//! for each sub-frame: faces, lamps, bodies ─> edges made smooth, strips, discs ─> its plate, a pinhole's image
//! all plates ─> their mean ─> lens (where each pixel takes its light from), at once with the sensor
//! ```

use std::ops::Range;

use super::{
    RenderError, View,
    device::Graphics,
    lens::{LensLayout, LensSlot},
};
use crate::{
    place::{
        building::{Building, Panel},
        light::{LightMap, Lighting},
    },
    scene::MAX_LAMPS,
};

mod edges;
mod faces;
mod frustum;
mod glints;
pub(super) mod layouts;
mod motion;
mod pipelines;
mod parts;
mod people;
mod plate;
mod strips;
mod sun;
mod walking;
mod world;

pub(super) use plate::RoomSlot;
pub(super) use world::RoomWorld;

use faces::Run;
use frustum::Frustum;
use motion::{SubFrame, sub_frames};
use pipelines::{Pipelines, Use};
use plate::ViewOnDevice;
use strips::{long_side, strips};
use walking::run_of;

/// Luminance that an image holds where no face is visible: slightly less than any true luminance. edge.wgsl recognises cracks between faces
/// by it and closes them; no sensor notices the difference.
const NOTHING: wgpu::Color = wgpu::Color { r: -1e-12, g: 0.0, b: 0.0, a: 1.0 };

/// Number of values that the end of a range of lamps can have, from 0 to the greatest number of lamps; as in surface.wgsl. With it the start and
/// the end of a range are packed into one number for the shader.
const LAMP_ENDS: u32 = MAX_LAMPS as u32 + 1;

/// Graphics pipelines and layouts of the room pass, which draws whole rooms.
pub(super) struct RoomPass {
    pipelines: Pipelines,
}

impl RoomPass {
    pub(super) fn new(device: &wgpu::Device) -> RoomPass {
        RoomPass { pipelines: Pipelines::new(device) }
    }

    /// Makes the buffers and textures of a building and its light on the graphics device.
    pub(super) fn upload(&self, graphics: &Graphics, building: Building, light: (Lighting, LightMap)) -> RoomWorld {
        RoomWorld::new(graphics, &self.pipelines, building, light)
    }

    /// Draws one picture of a room onto the plate of its lens, the pinhole image that the sensor then reads through the lens.
    pub(super) fn draw(
        &mut self,
        graphics: &Graphics,
        encoder: &mut wgpu::CommandEncoder,
        world: &RoomWorld,
        view: &View,
        (layout, seen_by): (&LensLayout, &LensSlot),
        slot: &mut Option<RoomSlot>,
    ) -> Result<(), RenderError> {
        let lens = &seen_by.lens;
        let slot = slot.get_or_insert_with(|| RoomSlot::new(graphics, &self.pipelines, layout, seen_by));
        let things = (world.building.panels.as_slice(), world.people.placed.as_slice());
        let frames = sub_frames(lens, &view.world_from_camera, view.exposure_s, things)
            .ok_or(RenderError::BadView("it has no camera pose"))?;
        let turned_up = view.illuminance_at_floor_lux / world.mean_at_floor_lux().max(1e-12);
        slot.reserve(graphics, &self.pipelines, (layout, seen_by), frames.len());
        for (index, frame) in frames.iter().enumerate() {
            slot.write_view(graphics, index, &ViewOnDevice::new(seen_by, frame, world, turned_up));
        }
        let how = Use::of(lens, world.lighting.daylight.is_some());
        let eyes: Vec<_> = frames.iter().map(|frame| frame.world_from_camera.translation.vector.into()).collect();
        let middle = &frames[frames.len() / 2].world_from_camera;
        let frustum = Frustum::new(&frames, lens.focal_px, seen_by.plate_size_px, seen_by.plate_centre_px);
        let rolling = lens.row_time_s > 0.0;
        let mut narrow = Vec::new();
        let mut hides = |(index, panel): (usize, &Panel)| {
            let hidden = frustum.hides(&panel.corners());
            let long = if hidden { None } else { long_side(panel, middle, lens) };
            narrow.extend(long.into_iter().flat_map(|long| strips((index, panel), long, &eyes, rolling)));
            hidden || long.is_some()
        };
        let hidden: Vec<bool> = world.building.panels.iter().enumerate().map(&mut hides).collect();
        let people = world.people.seen_in(&frustum);
        world.light_bodies(graphics, &people);
        let drawing = world.cells.seen_from(&eyes, &world.lighting, &hidden, rolling);
        let edges = world.edge_lists[usize::from(rolling)].runs(&hidden);
        slot.choose(graphics, &drawing.indices);
        slot.narrow(graphics, &narrow);
        self.pipelines.prepare(&graphics.device, &how, drawing.runs.iter().map(|run| run.kind));
        let walked = world.lit_while_they_walk(graphics, &self.pipelines, &frames, how.band());
        for index in 0..frames.len() {
            let lit = walked.get(run_of(index, frames.len(), walked.len())).unwrap_or(world.bindings(how.band()));
            let behind = behind(world, how.band(), turned_up);
            self.draw_faces(encoder, (world, lit, &people), (&drawing.runs, slot, &seen_by.plate, behind), &how, index);
            encoder.copy_texture_to_texture(
                seen_by.plate.texture().as_image_copy(),
                slot.plate(index),
                seen_by.plate.texture().size(),
            );
            self.draw_edges(encoder, (world, lit, &people), (&edges, narrow.len() as u32, slot), &how, index);
        }
        if frames.len() > 1 {
            self.draw_mean(encoder, slot, &seen_by.plate);
        }
        Ok(())
    }

    /// Draws the mean of the images of all sub-frames (instants of the exposure) onto the lens's plate. It overwrites the image with jagged edges
    /// on the plate, which is no longer needed.
    fn draw_mean(&self, encoder: &mut wgpu::CommandEncoder, slot: &RoomSlot, plate: &wgpu::TextureView) {
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("mean"),
            color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                view: plate,
                depth_slice: None,
                resolve_target: None,
                ops: wgpu::Operations { load: wgpu::LoadOp::Clear(NOTHING), store: wgpu::StoreOp::Store },
            })],
            ..Default::default()
        });
        pass.set_pipeline(&self.pipelines.mean);
        pass.set_bind_group(0, &slot.mean_bindings, &[]);
        pass.draw(0..3, 0..1);
    }

    fn draw_faces(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        (world, lit, people): (&RoomWorld, &wgpu::BindGroup, &[usize]),
        (runs, slot, plate, behind): (&[Run], &RoomSlot, &wgpu::TextureView, wgpu::Color),
        how: &Use,
        index: usize,
    ) {
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("faces"),
            color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                view: plate,
                depth_slice: None,
                resolve_target: None,
                ops: wgpu::Operations { load: wgpu::LoadOp::Clear(behind), store: wgpu::StoreOp::Store },
            })],
            depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
                view: &slot.depth,
                depth_ops: Some(wgpu::Operations { load: wgpu::LoadOp::Clear(0.0), store: wgpu::StoreOp::Store }),
                stencil_ops: None,
            }),
            ..Default::default()
        });
        pass.set_bind_group(0, &slot.view_bindings, &[plate::view_offset(index); 2]);
        pass.set_bind_group(1, lit, &[]);
        // People are drawn first, so that the surfaces behind them need not be shaded.
        if !people.is_empty() {
            pass.set_pipeline(self.pipelines.bodies(how));
            pass.set_vertex_buffer(0, world.people.corners[how.band()].slice(..));
            pass.set_index_buffer(world.people.triangles.slice(..), wgpu::IndexFormat::Uint32);
        }
        for body in people {
            let first = *body as u32 * world.people.corners_of_each;
            pass.draw_indexed(0..world.people.indices_of_each, first as i32, 0..1);
        }
        pass.set_vertex_buffer(0, world.nodes.slice(..));
        pass.set_index_buffer(slot.chosen.slice(..), wgpu::IndexFormat::Uint32);
        for run in runs {
            pass.set_pipeline(self.pipelines.surface(how, run.kind));
            // The number of the drawn instance tells the shader which lamps may be seen reflected in the surface.
            let lamps = run.lamps.start + run.lamps.end * LAMP_ENDS;
            pass.draw_indexed(run.indices.clone(), 0, lamps..lamps + 1);
        }
        pass.set_pipeline(self.pipelines.lamps(how));
        pass.draw(0..6, 0..world.first_bulb);
    }

    fn draw_edges(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        (world, lit, people): (&RoomWorld, &wgpu::BindGroup, &[usize]),
        (runs, n_strips, slot): (&[Range<u32>], u32, &RoomSlot),
        how: &Use,
        index: usize,
    ) {
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("edges"),
            color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                view: slot.plate_view(index),
                depth_slice: None,
                resolve_target: None,
                ops: wgpu::Operations { load: wgpu::LoadOp::Load, store: wgpu::StoreOp::Store },
            })],
            depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
                view: &slot.depth,
                depth_ops: None,
                stencil_ops: None,
            }),
            ..Default::default()
        });
        pass.set_bind_group(0, &slot.view_bindings, &[plate::view_offset(index); 2]);
        pass.set_bind_group(1, lit, &[]);
        pass.set_bind_group(2, &slot.stepped_bindings, &[]);
        pass.set_pipeline(self.pipelines.edges(how));
        pass.set_vertex_buffer(0, world.edges[usize::from(how.rolling())].slice(..));
        for run in runs {
            pass.draw(0..4, run.clone());
        }
        pass.set_vertex_buffer(0, world.people.edges.slice(..));
        for body in people {
            let first = *body as u32 * world.people.edges_of_each;
            pass.draw(0..4, first..first + world.people.edges_of_each);
        }
        if n_strips > 0 {
            pass.set_pipeline(self.pipelines.strips(how));
            pass.set_vertex_buffer(0, slot.strips.slice(..));
            pass.draw(0..4, 0..n_strips);
        }
        if world.disc_count > 0 {
            pass.set_pipeline(self.pipelines.discs(how));
            pass.set_vertex_buffer(0, world.discs(how.band()).slice(..));
            pass.draw(0..4, 0..world.disc_count);
        }
    }
}

/// What is seen where no face is: the sky, or nothing.
fn behind(world: &RoomWorld, band: usize, turned_up: f64) -> wgpu::Color {
    if world.lighting.daylight.is_none() {
        return NOTHING;
    }
    wgpu::Color { r: turned_up * world.lighting.dimming * world.sky_luminance(band), ..NOTHING }
}

/// Pose and twist of the camera in a sub-frame (an instant of the exposure), in the form that view.wgsl reads.
fn twist_rows(frame: &SubFrame) -> ([[f32; 4]; 3], [f32; 4], [f32; 4]) {
    let camera_from_world = frame.world_from_camera.inverse().to_homogeneous();
    let rows = std::array::from_fn(|row| std::array::from_fn(|column| camera_from_world[(row, column)] as f32));
    let extended = |vector: nalgebra::Vector3<f64>| [vector.x as f32, vector.y as f32, vector.z as f32, 0.0];
    (rows, extended(frame.turn_rad_per_s), extended(frame.drift_m_per_s))
}

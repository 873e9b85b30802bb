//! The floor pass: draws faces of tiles, then joints, stray wires and tapes, and walls over them, as luminance averaged over the exposure.

use super::{RenderError, View, device::Graphics, lens::LensSlot};

mod cut;
mod geometry;
mod local;
mod pipelines;

pub(super) use cut::Floor;

use cut::{Cut, ViewOnDevice};
use geometry::{BandInstance, TileInstance};

/// Graphics pipelines that draw the floor. The faces of tiles have one pipeline per pattern, so that a plain tile does not cost what marble does.
pub(super) struct FloorPass {
    of_global_shutter: Pipelines,
    of_rolling_shutter: Pipelines,
    view_layout: wgpu::BindGroupLayout,
}

struct Pipelines {
    faces: [wgpu::RenderPipeline; 4],
    bands: wgpu::RenderPipeline,
}

/// Buffers on the device for one picture (view) of the floor.
pub(super) struct FloorSlot {
    uniform: wgpu::Buffer,
    bindings: wgpu::BindGroup,
    faces: wgpu::Buffer,
    bands: wgpu::Buffer,
}

impl FloorPass {
    pub(super) fn new(device: &wgpu::Device) -> FloorPass {
        let view_layout = device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
            label: Some("floor view"),
            entries: &[wgpu::BufferBindingType::Uniform, wgpu::BufferBindingType::Storage { read_only: true }]
                .map(|ty| wgpu::BindingType::Buffer { ty, has_dynamic_offset: false, min_binding_size: None })
                .into_iter()
                .zip(0..)
                .map(|(ty, binding)| wgpu::BindGroupLayoutEntry {
                    binding,
                    visibility: wgpu::ShaderStages::VERTEX_FRAGMENT,
                    ty,
                    count: None,
                })
                .collect::<Vec<_>>(),
        });
        let layout = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
            label: Some("floor"),
            bind_group_layouts: &[Some(&view_layout)],
            immediate_size: 0,
        });
        let made = |rolling| Pipelines {
            faces: pipelines::faces(device, &layout, rolling),
            bands: pipelines::bands(device, &layout, rolling),
        };
        FloorPass { of_global_shutter: made(false), of_rolling_shutter: made(true), view_layout }
    }

    /// Makes the device buffers for one picture (view) of the floor.
    pub(super) fn slot(&self, device: &wgpu::Device) -> FloorSlot {
        let uniform = device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("floor view"),
            size: size_of::<ViewOnDevice>() as u64,
            usage: wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_DST,
            mapped_at_creation: false,
        });
        let bindings = device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("floor view"),
            layout: &self.view_layout,
            entries: &[0, 1].map(|binding| wgpu::BindGroupEntry { binding, resource: uniform.as_entire_binding() }),
        });
        FloorSlot {
            uniform,
            bindings,
            faces: instances(device, size_of::<TileInstance>() as u64),
            bands: instances(device, size_of::<BandInstance>() as u64),
        }
    }

    /// Draws the floor of one picture (view) onto the plate of its lens, the pinhole image that the sensor then reads through the lens.
    pub(super) fn draw(
        &self,
        graphics: &Graphics,
        encoder: &mut wgpu::CommandEncoder,
        floor: &Floor,
        view: &View,
        slot: &mut FloorSlot,
        seen_by: &LensSlot,
    ) -> Result<(), RenderError> {
        let Cut { uniform, faces, bands } = floor.cut(view, seen_by)?;
        graphics.queue.write_buffer(&slot.uniform, 0, bytemuck::bytes_of(&uniform));
        fill(graphics, &mut slot.faces, bytemuck::cast_slice(&faces));
        fill(graphics, &mut slot.bands, bytemuck::cast_slice(&bands));
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("floor"),
            color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                view: &seen_by.plate,
                depth_slice: None,
                resolve_target: None,
                ops: wgpu::Operations { load: wgpu::LoadOp::Clear(wgpu::Color::BLACK), store: wgpu::StoreOp::Store },
            })],
            ..Default::default()
        });
        let rolling = view.lens.row_time_s > 0.0;
        let pipelines = if rolling { &self.of_rolling_shutter } else { &self.of_global_shutter };
        pass.set_bind_group(0, &slot.bindings, &[]);
        pass.set_pipeline(&pipelines.faces[floor.pattern() as usize]);
        pass.set_vertex_buffer(0, slot.faces.slice(..));
        pass.draw(0..4, 0..faces.len() as u32);
        pass.set_pipeline(&pipelines.bands);
        pass.set_vertex_buffer(0, slot.bands.slice(..));
        pass.draw(0..4, 0..bands.len() as u32);
        Ok(())
    }
}

fn instances(device: &wgpu::Device, size: u64) -> wgpu::Buffer {
    device.create_buffer(&wgpu::BufferDescriptor {
        label: Some("instances"),
        size,
        usage: wgpu::BufferUsages::VERTEX | wgpu::BufferUsages::COPY_DST,
        mapped_at_creation: false,
    })
}

/// Writes instances into a graphics buffer, which grows to hold them.
fn fill(graphics: &Graphics, buffer: &mut wgpu::Buffer, bytes: &[u8]) {
    if bytes.len() as u64 > buffer.size() {
        *buffer = instances(&graphics.device, (bytes.len() as u64).next_power_of_two());
    }
    graphics.queue.write_buffer(buffer, 0, bytes);
}

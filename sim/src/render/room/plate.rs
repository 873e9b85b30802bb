//! Device memory of one view of a room: the plate, its view values, the lens's map.

use bytemuck::{Pod, Zeroable};

use super::{
    map::LensMap,
    motion::{MAX_SUB_FRAMES, SubFrame},
    pipelines::{DEPTH_FORMAT, Pipelines, SAMPLES},
    world::{RoomWorld, buffer},
};
use crate::{
    render::{RenderError, device::Graphics, target::LUMINANCE_FORMAT},
    sensors::lens::Lens,
};

/// Bytes from one sub-frame's values to the next's; every adapter takes offsets of this.
const VIEW_STRIDE: u64 = 512;

/// Where sub-frame `index` has its values.
pub(super) fn view_offset(index: usize) -> u32 {
    (index as u64 * VIEW_STRIDE) as u32
}

/// Buffers and bindings of one view, kept as long as its lens stays the same.
pub(in crate::render) struct RoomSlot {
    pub(super) lens: Lens,
    pub(super) plate: wgpu::TextureView,
    pub(super) depth: wgpu::TextureView,
    pub(super) view_bindings: wgpu::BindGroup,
    pub(super) lens_bindings: wgpu::BindGroup,
    views: wgpu::Buffer,
    sheet: wgpu::Buffer,
    plate_size_px: [u32; 2],
    plate_centre_px: [f64; 2],
}

/// `View` of view.wgsl.
#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
pub(super) struct ViewOnDevice {
    camera_from_world: [[f32; 4]; 3],
    turn: [f32; 4],
    drift: [f32; 4],
    plate_focal_px: [f32; 2],
    plate_centre_px: [f32; 2],
    plate_size_px: [f32; 2],
    sensor_focal_px: f32,
    sensor_centre_px: f32,
    distortion: [f32; 4],
    distortion_k3: f32,
    row_time_s: f32,
    middle_row: f32,
    last_row: f32,
    eye: [f32; 4],
    axis: [f32; 4],
    luminance_per_lux: f32,
    lamp_factor: f32,
    ring_candela: f32,
    first_bulb: u32,
    lamp_count: u32,
    mirrored_count: u32,
    padding: [u32; 2],
}

/// `Sheet` of lens.wgsl.
#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
struct SheetOnDevice {
    focal_px: [f32; 2],
    centre_px: [f32; 2],
    width_px: u32,
    share: f32,
    defocus_radius_px: f32,
    padding: f32,
}

impl ViewOnDevice {
    /// The values of a sub-frame; `turned_up` is a factor on all lamps of the world.
    pub(super) fn new(lens: &Lens, slot: &RoomSlot, frame: &SubFrame, world: &RoomWorld, turned_up: f64) -> Self {
        let (camera_from_world, turn, drift) = super::twist_rows(frame);
        let [k1, k2, p1, p2, k3] = lens.distortion.map(|coefficient| coefficient as f32);
        let (eye, axis) =
            (frame.world_from_camera.translation.vector, frame.world_from_camera.rotation * nalgebra::Vector3::z());
        let last_row = f64::from(lens.size_px[1] - 1);
        let lamp_factor = turned_up * world.lighting.dimming;
        ViewOnDevice {
            camera_from_world,
            turn,
            drift,
            plate_focal_px: lens.focal_px.map(|focal_px| focal_px as f32),
            plate_centre_px: slot.plate_centre_px.map(|at_px| at_px as f32),
            plate_size_px: slot.plate_size_px.map(|size_px| size_px as f32),
            sensor_focal_px: lens.focal_px[1] as f32,
            sensor_centre_px: lens.principal_point_px[1] as f32,
            distortion: [k1, k2, p1, p2],
            distortion_k3: k3,
            row_time_s: lens.row_time_s as f32,
            middle_row: (0.5 * last_row) as f32,
            last_row: last_row as f32,
            eye: [eye.x as f32, eye.y as f32, eye.z as f32, 0.0],
            axis: [axis.x as f32, axis.y as f32, axis.z as f32, 0.0],
            // A matt surface of albedo 1 under E has the luminance E/π.
            luminance_per_lux: (lamp_factor / std::f64::consts::PI) as f32,
            lamp_factor: lamp_factor as f32,
            ring_candela: lens.ring_candela as f32,
            first_bulb: world.first_bulb,
            lamp_count: world.lamp_count,
            mirrored_count: world.mirrored_count,
            padding: [0; 2],
        }
    }
}

impl RoomSlot {
    pub(super) fn new(graphics: &Graphics, pipelines: &Pipelines, lens: &Lens) -> Result<RoomSlot, RenderError> {
        let device = &graphics.device;
        let map = LensMap::new(lens)?;
        let limit_px = device.limits().max_texture_dimension_2d;
        if map.size_px[0].max(map.size_px[1]) > limit_px {
            return Err(RenderError::TooLarge {
                what: "a view before its lens",
                needed: format!("{} × {} px", map.size_px[0], map.size_px[1]),
                limit: format!("{limit_px} px"),
            });
        }
        let plate = attachment(device, map.size_px, LUMINANCE_FORMAT, wgpu::TextureUsages::TEXTURE_BINDING);
        let depth = attachment(device, map.size_px, DEPTH_FORMAT, wgpu::TextureUsages::empty());
        let places = buffer(graphics, "lens map", wgpu::BufferUsages::STORAGE, &map.places_px);
        let empty = |label, size, usage| {
            device.create_buffer(&wgpu::BufferDescriptor { label: Some(label), size, usage, mapped_at_creation: false })
        };
        let written = wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_DST;
        let views = empty("room views", VIEW_STRIDE * MAX_SUB_FRAMES as u64, written);
        let sheet = empty("lens", size_of::<SheetOnDevice>() as u64, written);
        let view_bindings = device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("room view"),
            layout: &pipelines.view_layout,
            entries: &[wgpu::BindGroupEntry {
                binding: 0,
                resource: wgpu::BindingResource::Buffer(wgpu::BufferBinding {
                    buffer: &views,
                    offset: 0,
                    size: std::num::NonZeroU64::new(size_of::<ViewOnDevice>() as u64),
                }),
            }],
        });
        let lens_bindings = device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("lens"),
            layout: &pipelines.lens_layout,
            entries: &[
                wgpu::BindGroupEntry { binding: 0, resource: sheet.as_entire_binding() },
                wgpu::BindGroupEntry { binding: 1, resource: wgpu::BindingResource::TextureView(&plate) },
                wgpu::BindGroupEntry { binding: 2, resource: places.as_entire_binding() },
            ],
        });
        Ok(RoomSlot {
            lens: lens.clone(),
            plate,
            depth,
            view_bindings,
            lens_bindings,
            views,
            sheet,
            plate_size_px: map.size_px,
            plate_centre_px: map.centre_px,
        })
    }

    /// Writes a sub-frame's values; `share` is its part of the exposure.
    pub(super) fn write_view(&self, graphics: &Graphics, index: usize, view: &ViewOnDevice, share: f32) {
        graphics.queue.write_buffer(&self.views, u64::from(view_offset(index)), bytemuck::bytes_of(view));
        if index == 0 {
            let sheet = SheetOnDevice {
                focal_px: view.plate_focal_px,
                centre_px: view.plate_centre_px,
                width_px: self.lens.size_px[0],
                share,
                defocus_radius_px: (self.lens.defocus_px / 2.0) as f32,
                padding: 0.0,
            };
            graphics.queue.write_buffer(&self.sheet, 0, bytemuck::bytes_of(&sheet));
        }
    }
}

fn attachment(
    device: &wgpu::Device,
    size_px: [u32; 2],
    format: wgpu::TextureFormat,
    more: wgpu::TextureUsages,
) -> wgpu::TextureView {
    device
        .create_texture(&wgpu::TextureDescriptor {
            label: Some("plate"),
            size: wgpu::Extent3d { width: size_px[0], height: size_px[1], depth_or_array_layers: 1 },
            mip_level_count: 1,
            sample_count: SAMPLES,
            dimension: wgpu::TextureDimension::D2,
            format,
            usage: wgpu::TextureUsages::RENDER_ATTACHMENT | more,
            view_formats: &[],
        })
        .create_view(&wgpu::TextureViewDescriptor::default())
}

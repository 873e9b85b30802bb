//! Device memory of one view of a room: the plate, its view values, the lens's map.

use bytemuck::{Pod, Zeroable};

use super::{
    frustum::Frustum,
    map::LensMap,
    motion::{MAX_SUB_FRAMES, SubFrame},
    pipelines::{DEPTH_FORMAT, Pipelines},
    strips::StripOnDevice,
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
    /// The plate with edges in steps.
    pub(super) stepped: wgpu::TextureView,
    /// With smooth ones: a layer for each sub-frame, as many as were ever needed.
    plates: wgpu::Texture,
    plate_views: Vec<wgpu::TextureView>,
    pub(super) depth: wgpu::TextureView,
    pub(super) view_bindings: wgpu::BindGroup,
    pub(super) stepped_bindings: wgpu::BindGroup,
    /// What the lens reads where there is one plate, and where there are several.
    lens_bindings: [wgpu::BindGroup; 2],
    /// The plates whose mean is taken.
    pub(super) mean_bindings: wgpu::BindGroup,
    n_plates: usize,
    views: wgpu::Buffer,
    sheet: wgpu::Buffer,
    /// Where its pixels take their light from: instances for lens.wgsl.
    pub(in crate::render) map: wgpu::Buffer,
    pub(in crate::render) n_map_cells: u32,
    /// Which cells of the world's faces are drawn, and how.
    pub(super) chosen: wgpu::Buffer,
    /// What of them is hardly wider than a pixel.
    pub(super) strips: wgpu::Buffer,
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
    ring_candela: [f32; 4],
    luminance_per_lux: f32,
    lamp_factor: f32,
    first_bulb: u32,
    mirrored_count: u32,
    bodies_s: f32,
    padding: [u32; 3],
}

/// `Sheet` of lens.wgsl.
#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
struct SheetOnDevice {
    focal_px: [f32; 2],
    centre_px: [f32; 2],
    per_size: [f32; 2],
    n_plates: u32,
    share: f32,
    defocus_radius_px: f32,
    padding: f32,
}

impl ViewOnDevice {
    /// The values of a sub-frame; `turned_up` is a factor on all lamps of the world.
    pub(super) fn new(lens: &Lens, slot: &RoomSlot, frame: &SubFrame, world: &RoomWorld, turned_up: f64) -> Self {
        let (camera_from_world, turn, drift) = super::twist_rows(frame);
        let [k1, k2, p1, p2, k3] = lens.distortion.map(|coefficient| coefficient as f32);
        let eye = frame.world_from_camera.translation.vector;
        let ring = frame.world_from_camera.rotation * nalgebra::Vector3::z() * lens.ring_candela;
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
            ring_candela: [ring.x as f32, ring.y as f32, ring.z as f32, 0.0],
            // A matt surface of albedo 1 under E has the luminance E/π.
            luminance_per_lux: (lamp_factor / std::f64::consts::PI) as f32,
            lamp_factor: lamp_factor as f32,
            first_bulb: world.first_bulb,
            mirrored_count: world.mirrored_count,
            bodies_s: frame.before_end_s as f32,
            padding: [0; 3],
        }
    }
}

impl RoomSlot {
    pub(super) fn new(
        graphics: &Graphics,
        pipelines: &Pipelines,
        lens_layout: &wgpu::BindGroupLayout,
        lens: &Lens,
    ) -> Result<RoomSlot, RenderError> {
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
        let read = wgpu::TextureUsages::TEXTURE_BINDING;
        let stepped = attachment(device, map.size_px, 1, LUMINANCE_FORMAT, read | wgpu::TextureUsages::COPY_SRC)
            .create_view(&wgpu::TextureViewDescriptor::default());
        let (plates, plate_views) = plates(device, map.size_px, 1);
        let depth = attachment(device, map.size_px, 1, DEPTH_FORMAT, wgpu::TextureUsages::empty())
            .create_view(&wgpu::TextureViewDescriptor::default());
        let cells = buffer(graphics, "lens map", wgpu::BufferUsages::VERTEX, &map.cells);
        let empty = |label, size, usage| {
            device.create_buffer(&wgpu::BufferDescriptor { label: Some(label), size, usage, mapped_at_creation: false })
        };
        let written = wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_DST;
        let views = empty("room views", VIEW_STRIDE * MAX_SUB_FRAMES as u64, wgpu::BufferUsages::UNIFORM | written);
        let sheet = empty("lens", size_of::<SheetOnDevice>() as u64, wgpu::BufferUsages::UNIFORM | written);
        let view_bindings = device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("room view"),
            layout: &pipelines.view_layout,
            entries: &[0, 1].map(|binding| wgpu::BindGroupEntry {
                binding,
                resource: wgpu::BindingResource::Buffer(wgpu::BufferBinding {
                    buffer: &views,
                    offset: 0,
                    size: std::num::NonZeroU64::new(size_of::<ViewOnDevice>() as u64),
                }),
            }),
        });
        let stepped_bindings = device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("stepped"),
            layout: &pipelines.stepped_layout,
            entries: &[wgpu::BindGroupEntry { binding: 0, resource: wgpu::BindingResource::TextureView(&stepped) }],
        });
        let lens_bindings =
            [&plate_views[0], &stepped].map(|plate| bind(device, lens_layout, &sheet, plate, &pipelines.linear));
        let mean_bindings = bind_mean(device, &pipelines.mean_layout, &sheet, &plates);
        Ok(RoomSlot {
            lens: lens.clone(),
            stepped,
            plates,
            plate_views,
            depth,
            view_bindings,
            stepped_bindings,
            lens_bindings,
            mean_bindings,
            n_plates: 1,
            views,
            sheet,
            map: cells,
            n_map_cells: map.cells.len() as u32,
            chosen: buffer::<u32>(graphics, "chosen", wgpu::BufferUsages::INDEX, &[]),
            strips: buffer::<StripOnDevice>(graphics, "strips", wgpu::BufferUsages::VERTEX, &[]),
            plate_size_px: map.size_px,
            plate_centre_px: map.centre_px,
        })
    }

    /// Makes room for the plates of so many sub-frames.
    pub(super) fn reserve(
        &mut self,
        graphics: &Graphics,
        pipelines: &Pipelines,
        lens_layout: &wgpu::BindGroupLayout,
        count: usize,
    ) {
        self.n_plates = count;
        if self.plate_views.len() < count {
            let device = &graphics.device;
            (self.plates, self.plate_views) = plates(device, self.plate_size_px, count as u32);
            let plate = &self.plate_views[0];
            self.lens_bindings[0] = bind(device, lens_layout, &self.sheet, plate, &pipelines.linear);
            self.mean_bindings = bind_mean(device, &pipelines.mean_layout, &self.sheet, &self.plates);
        }
    }

    /// What the lens reads: the only plate, or the mean that was drawn over the stepped one.
    pub(in crate::render) fn lens_bindings(&self) -> &wgpu::BindGroup {
        &self.lens_bindings[usize::from(self.n_plates > 1)]
    }

    /// Where a sub-frame's plate is copied to.
    pub(super) fn plate(&self, index: usize) -> wgpu::TexelCopyTextureInfo<'_> {
        let origin = wgpu::Origin3d { x: 0, y: 0, z: index as u32 };
        wgpu::TexelCopyTextureInfo { origin, ..self.plates.as_image_copy() }
    }

    /// A sub-frame's plate.
    pub(super) fn plate_view(&self, index: usize) -> &wgpu::TextureView {
        &self.plate_views[index]
    }

    /// What its plates show.
    pub(super) fn frustum(&self, frames: &[SubFrame]) -> Frustum {
        Frustum::new(frames, self.lens.focal_px, self.plate_size_px, self.plate_centre_px)
    }

    /// Writes which nodes are drawn, into a larger buffer where it has to be.
    pub(super) fn choose(&mut self, graphics: &Graphics, indices: &[u32]) {
        fill(graphics, &mut self.chosen, ("chosen", wgpu::BufferUsages::INDEX), indices);
    }

    /// Writes what is drawn as strips, into a larger buffer where it has to be.
    pub(super) fn narrow(&mut self, graphics: &Graphics, strips: &[StripOnDevice]) {
        fill(graphics, &mut self.strips, ("strips", wgpu::BufferUsages::VERTEX), strips);
    }

    /// Writes a sub-frame's values.
    pub(super) fn write_view(&self, graphics: &Graphics, index: usize, view: &ViewOnDevice) {
        graphics.queue.write_buffer(&self.views, u64::from(view_offset(index)), bytemuck::bytes_of(view));
    }

    /// Writes what the lens needs for so many sub-frames.
    pub(super) fn write_sheet(&self, graphics: &Graphics, n_plates: usize) {
        let sheet = SheetOnDevice {
            focal_px: self.lens.focal_px.map(|focal_px| focal_px as f32),
            centre_px: self.plate_centre_px.map(|at_px| at_px as f32),
            per_size: self.plate_size_px.map(|size_px| 1.0 / size_px as f32),
            n_plates: n_plates as u32,
            share: 1.0 / n_plates as f32,
            defocus_radius_px: (self.lens.defocus_px / 2.0) as f32,
            padding: 0.0,
        };
        graphics.queue.write_buffer(&self.sheet, 0, bytemuck::bytes_of(&sheet));
    }
}

/// Writes into a buffer, or into a larger one in its place.
fn fill<T: Pod>(
    graphics: &Graphics,
    written: &mut wgpu::Buffer,
    (label, usage): (&str, wgpu::BufferUsages),
    contents: &[T],
) {
    let bytes: &[u8] = bytemuck::cast_slice(contents);
    if bytes.len() as u64 > written.size() {
        *written = buffer(graphics, label, usage, contents);
    } else {
        graphics.queue.write_buffer(written, 0, bytes);
    }
}

/// What the lens reads.
fn bind(
    device: &wgpu::Device,
    layout: &wgpu::BindGroupLayout,
    sheet: &wgpu::Buffer,
    plate: &wgpu::TextureView,
    linear: &wgpu::Sampler,
) -> wgpu::BindGroup {
    device.create_bind_group(&wgpu::BindGroupDescriptor {
        label: Some("lens"),
        layout,
        entries: &[
            wgpu::BindGroupEntry { binding: 0, resource: sheet.as_entire_binding() },
            wgpu::BindGroupEntry { binding: 1, resource: wgpu::BindingResource::TextureView(plate) },
            wgpu::BindGroupEntry { binding: 2, resource: wgpu::BindingResource::Sampler(linear) },
        ],
    })
}

/// All plates, for their mean.
fn bind_mean(
    device: &wgpu::Device,
    layout: &wgpu::BindGroupLayout,
    sheet: &wgpu::Buffer,
    plates: &wgpu::Texture,
) -> wgpu::BindGroup {
    let layers = plates.create_view(&wgpu::TextureViewDescriptor {
        dimension: Some(wgpu::TextureViewDimension::D2Array),
        ..Default::default()
    });
    device.create_bind_group(&wgpu::BindGroupDescriptor {
        label: Some("plates"),
        layout,
        entries: &[
            wgpu::BindGroupEntry { binding: 0, resource: sheet.as_entire_binding() },
            wgpu::BindGroupEntry { binding: 1, resource: wgpu::BindingResource::TextureView(&layers) },
        ],
    })
}

/// Plates in layers, and a view of each.
fn plates(device: &wgpu::Device, size_px: [u32; 2], count: u32) -> (wgpu::Texture, Vec<wgpu::TextureView>) {
    let usage = wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST;
    let plates = attachment(device, size_px, count, LUMINANCE_FORMAT, usage);
    let layer = |base_array_layer| {
        plates.create_view(&wgpu::TextureViewDescriptor {
            dimension: Some(wgpu::TextureViewDimension::D2),
            base_array_layer,
            array_layer_count: Some(1),
            ..Default::default()
        })
    };
    let views = (0..count).map(layer).collect();
    (plates, views)
}

fn attachment(
    device: &wgpu::Device,
    size_px: [u32; 2],
    layers: u32,
    format: wgpu::TextureFormat,
    more: wgpu::TextureUsages,
) -> wgpu::Texture {
    device.create_texture(&wgpu::TextureDescriptor {
        label: Some("plate"),
        size: wgpu::Extent3d { width: size_px[0], height: size_px[1], depth_or_array_layers: layers },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format,
        usage: wgpu::TextureUsages::RENDER_ATTACHMENT | more,
        view_formats: &[],
    })
}

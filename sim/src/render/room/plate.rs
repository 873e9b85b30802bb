//! Device memory for one picture of a room: the camera's values, and an image (plate) for each sub-frame (instant of the exposure).

use bytemuck::{Pod, Zeroable};

use super::{
    motion::{MAX_SUB_FRAMES, SubFrame},
    pipelines::{DEPTH_FORMAT, Pipelines},
    strips::StripOnDevice,
    world::RoomWorld,
};
use crate::{
    render::{
        device::Graphics,
        lens::{LensLayout, LensSlot},
        texels::LUMINANCE_FORMAT,
    },
    scene::Band,
};

/// Number of bytes from the values of one sub-frame (an instant of the exposure) to those of the next in the buffer of the camera's values; every
/// adapter accepts offsets that are multiples of it.
const VIEW_STRIDE: u64 = 512;

/// Offset in bytes at which the camera's values for sub-frame `index` begin in their buffer.
pub(super) fn view_offset(index: usize) -> u32 {
    (index as u64 * VIEW_STRIDE) as u32
}

/// Buffers and bindings for one picture of a room, kept as long as its lens stays the same.
pub(in crate::render) struct RoomSlot {
    /// Texture with the images (plates) on which edges have been made smooth: a layer for each sub-frame (instant of the exposure), as many as
    /// have ever been needed.
    plates: wgpu::Texture,
    plate_views: Vec<wgpu::TextureView>,
    pub(super) depth: wgpu::TextureView,
    pub(super) view_bindings: wgpu::BindGroup,
    /// Bindings for the lens's own plate, the pinhole image on which the edges of faces are still jagged.
    pub(super) stepped_bindings: wgpu::BindGroup,
    /// Bindings with which the lens pass reads the image of the exposure if it has only one sub-frame (instant).
    single_bindings: wgpu::BindGroup,
    /// Bindings with which the images of all sub-frames (instants of the exposure) are read to take their mean.
    pub(super) mean_bindings: wgpu::BindGroup,
    n_plates: usize,
    views: wgpu::Buffer,
    counted: wgpu::Buffer,
    /// Indices of the vertices of those faces of the building that are drawn.
    pub(super) chosen: wgpu::Buffer,
    /// Strips: flat faces in the picture that are hardly wider than a pixel.
    pub(super) strips: wgpu::Buffer,
}

/// Device layout of `View` of view.wgsl: the camera's values in one sub-frame (an instant of the exposure).
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
    sky: f32,
    padding: [u32; 2],
}

/// Device layout of `Plates` of mean.wgsl: the number of images of which the mean is taken, and the share of each.
#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
struct PlatesOnDevice {
    count: u32,
    share: f32,
}

impl ViewOnDevice {
    /// The camera's values in a sub-frame (an instant of the exposure). `turned_up` is a factor on all lamps: the view's illuminance over that
    /// which the lamps give.
    pub(super) fn new(seen_by: &LensSlot, frame: &SubFrame, world: &RoomWorld, turned_up: f64) -> Self {
        let lens = &seen_by.lens;
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
            plate_centre_px: seen_by.plate_centre_px.map(|at_px| at_px as f32),
            plate_size_px: seen_by.plate_size_px.map(|size_px| size_px as f32),
            sensor_focal_px: lens.focal_px[1] as f32,
            sensor_centre_px: lens.principal_point_px[1] as f32,
            distortion: [k1, k2, p1, p2],
            distortion_k3: k3,
            row_time_s: lens.row_time_s as f32,
            middle_row: (0.5 * last_row) as f32,
            last_row: last_row as f32,
            eye: [eye.x as f32, eye.y as f32, eye.z as f32, 0.0],
            ring_candela: [ring.x as f32, ring.y as f32, ring.z as f32, 0.0],
            // A matt surface of albedo 1 under the illuminance E has the luminance E/π.
            luminance_per_lux: (lamp_factor / std::f64::consts::PI) as f32,
            lamp_factor: lamp_factor as f32,
            first_bulb: world.first_bulb,
            mirrored_count: world.mirrored_count,
            bodies_s: frame.before_end_s as f32,
            sky: (lamp_factor * world.sky_luminance(usize::from(lens.band == Band::Infrared))) as f32,
            padding: [0; 2],
        }
    }
}

impl RoomSlot {
    pub(super) fn new(graphics: &Graphics, pipelines: &Pipelines, layout: &LensLayout, lens: &LensSlot) -> RoomSlot {
        let device = &graphics.device;
        let (plates, plate_views) = plates(device, lens.plate_size_px, 1);
        let depth = attachment(device, lens.plate_size_px, 1, DEPTH_FORMAT, wgpu::TextureUsages::empty())
            .create_view(&wgpu::TextureViewDescriptor::default());
        let empty = |label, size, usage| {
            device.create_buffer(&wgpu::BufferDescriptor { label: Some(label), size, usage, mapped_at_creation: false })
        };
        let written = wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_DST;
        let views = empty("room views", VIEW_STRIDE * MAX_SUB_FRAMES as u64, wgpu::BufferUsages::UNIFORM | written);
        let counted = empty("plates", size_of::<PlatesOnDevice>() as u64, written);
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
        let stepped = wgpu::BindingResource::TextureView(&lens.plate);
        let stepped_bindings = device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("stepped"),
            layout: &pipelines.stepped_layout,
            entries: &[wgpu::BindGroupEntry { binding: 0, resource: stepped }],
        });
        RoomSlot {
            single_bindings: lens.reading(device, layout, &plate_views[0]),
            mean_bindings: bind_mean(device, &pipelines.mean_layout, &counted, &plates),
            plates,
            plate_views,
            depth,
            view_bindings,
            stepped_bindings,
            n_plates: 1,
            views,
            counted,
            chosen: graphics.buffer::<u32>("chosen", wgpu::BufferUsages::INDEX, &[]),
            strips: graphics.buffer::<StripOnDevice>("strips", wgpu::BufferUsages::VERTEX, &[]),
        }
    }

    /// Makes room for one image (plate) for each of the given number of sub-frames (instants) of an exposure.
    pub(super) fn reserve(
        &mut self,
        graphics: &Graphics,
        pipelines: &Pipelines,
        (layout, lens): (&LensLayout, &LensSlot),
        count: usize,
    ) {
        self.n_plates = count;
        let device = &graphics.device;
        if self.plate_views.len() < count {
            (self.plates, self.plate_views) = plates(device, lens.plate_size_px, count as u32);
            self.single_bindings = lens.reading(device, layout, &self.plate_views[0]);
            self.mean_bindings = bind_mean(device, &pipelines.mean_layout, &self.counted, &self.plates);
        }
        let counted = PlatesOnDevice { count: count as u32, share: 1.0 / count as f32 };
        graphics.queue.write_buffer(&self.counted, 0, bytemuck::bytes_of(&counted));
    }

    /// Bindings with which the lens pass reads the image of an exposure's only sub-frame; `None` if there are several sub-frames, whose mean is
    /// drawn onto the lens's own plate.
    pub(in crate::render) fn single_plate(&self) -> Option<&wgpu::BindGroup> {
        (self.n_plates == 1).then_some(&self.single_bindings)
    }

    /// Destination to which the image of a sub-frame (an instant of the exposure) is copied.
    pub(super) fn plate(&self, index: usize) -> wgpu::TexelCopyTextureInfo<'_> {
        let origin = wgpu::Origin3d { x: 0, y: 0, z: index as u32 };
        wgpu::TexelCopyTextureInfo { origin, ..self.plates.as_image_copy() }
    }

    /// Texture view of the image of a sub-frame, an instant of the exposure.
    pub(super) fn plate_view(&self, index: usize) -> &wgpu::TextureView {
        &self.plate_views[index]
    }

    /// Writes the indices of the vertices that are drawn; the buffer is replaced by a larger one if necessary.
    pub(super) fn choose(&mut self, graphics: &Graphics, indices: &[u32]) {
        fill(graphics, &mut self.chosen, ("chosen", wgpu::BufferUsages::INDEX), indices);
    }

    /// Writes the list of flat faces that are drawn as strips, because they are hardly wider than a pixel; the buffer is replaced by a larger one
    /// if necessary.
    pub(super) fn narrow(&mut self, graphics: &Graphics, strips: &[StripOnDevice]) {
        fill(graphics, &mut self.strips, ("strips", wgpu::BufferUsages::VERTEX), strips);
    }

    /// Writes the camera's values in one sub-frame, an instant of the exposure.
    pub(super) fn write_view(&self, graphics: &Graphics, index: usize, view: &ViewOnDevice) {
        graphics.queue.write_buffer(&self.views, u64::from(view_offset(index)), bytemuck::bytes_of(view));
    }
}

/// Writes into a graphics buffer; if it is too small, a larger one takes its place.
fn fill<T: Pod>(
    graphics: &Graphics,
    written: &mut wgpu::Buffer,
    (label, usage): (&str, wgpu::BufferUsages),
    contents: &[T],
) {
    let bytes: &[u8] = bytemuck::cast_slice(contents);
    if bytes.len() as u64 > written.size() {
        *written = graphics.buffer(label, usage, contents);
    } else {
        graphics.queue.write_buffer(written, 0, bytes);
    }
}

/// Bindings for the images of all sub-frames (instants) of an exposure, from which their mean is taken.
fn bind_mean(
    device: &wgpu::Device,
    layout: &wgpu::BindGroupLayout,
    counted: &wgpu::Buffer,
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
            wgpu::BindGroupEntry { binding: 0, resource: counted.as_entire_binding() },
            wgpu::BindGroupEntry { binding: 1, resource: wgpu::BindingResource::TextureView(&layers) },
        ],
    })
}

/// A texture whose layers are the images (plates) of all sub-frames, and a texture view of each layer.
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

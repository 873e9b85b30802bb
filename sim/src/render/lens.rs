//! A lens on the graphics device: the plate before it, its map, and the bindings with which the sensor reads through it.
//!
//! The plate is the image that a pinhole camera of the same focal lengths makes, with a margin. The drawing passes write luminance to it;
//! lens.wgsl then looks up the place on the plate from which each pixel of the sensor takes its light.

use bytemuck::{Pod, Zeroable};

use super::{
    RenderError,
    device::Graphics,
    texels::{LUMINANCE_FORMAT, linear},
};
use crate::optics::{Intrinsics, Lens};

mod map;

use map::LensMap;

/// Number of points along each side of a picture at which lamplight is computed; they are 1 cm apart where a floor camera sees half a metre.
pub(super) const LAMPLIGHT_PX: u32 = 65;

/// Layout of the bindings that lens.wgsl reads in addition to those with the values of the sensor.
pub(super) struct LensLayout {
    pub(super) bindings: wgpu::BindGroupLayout,
    linear: wgpu::Sampler,
}

/// A lens with its plate on the device, kept from tick to tick.
pub(super) struct LensSlot {
    pub(super) lens: Lens,
    /// Width and height of the plate, the pinhole image that the sensor reads through the lens.
    pub(super) plate_size_px: [u32; 2],
    /// Principal point on the plate, the pinhole image that the sensor reads through the lens; (0, 0) is the centre of its first pixel.
    pub(super) plate_centre_px: [f64; 2],
    /// The plate, a pinhole image that the sensor reads through the lens: luminance in cd/m², averaged over the exposure.
    pub(super) plate: wgpu::TextureView,
    /// Map of the lens: the place on the plate (the pinhole image) from which each sensor pixel takes its light, as instances for
    /// lens.wgsl.
    pub(super) map: wgpu::Buffer,
    pub(super) n_map_cells: u32,
    /// Bindings with which lens.wgsl reads the plate, the pinhole image before the lens.
    pub(super) bindings: wgpu::BindGroup,
    sheet: wgpu::Buffer,
    /// Texture with the factor by which the scene's lamps light each part of the floor in the picture.
    lamplight: wgpu::TextureView,
}

/// Device layout of `Sheet` of lens.wgsl: the values of a lens and of the plate, the pinhole image before it.
#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
struct SheetOnDevice {
    focal_px: [f32; 2],
    centre_px: [f32; 2],
    size_px: [f32; 2],
    defocus_radius_px: f32,
    padding: f32,
}

impl LensLayout {
    pub(super) fn new(device: &wgpu::Device) -> LensLayout {
        let visibility = wgpu::ShaderStages::VERTEX_FRAGMENT;
        let texture = wgpu::BindingType::Texture {
            sample_type: wgpu::TextureSampleType::Float { filterable: true },
            view_dimension: wgpu::TextureViewDimension::D2,
            multisampled: false,
        };
        let sheet = wgpu::BindingType::Buffer {
            ty: wgpu::BufferBindingType::Uniform,
            has_dynamic_offset: false,
            min_binding_size: None,
        };
        let sampler = wgpu::BindingType::Sampler(wgpu::SamplerBindingType::Filtering);
        let entry = |(ty, binding)| wgpu::BindGroupLayoutEntry { binding, visibility, ty, count: None };
        let entries: Vec<_> = [sheet, texture, sampler, texture].into_iter().zip(0..).map(entry).collect();
        let descriptor = wgpu::BindGroupLayoutDescriptor { label: Some("lens"), entries: &entries };
        LensLayout { bindings: device.create_bind_group_layout(&descriptor), linear: linear(device) }
    }
}

impl LensSlot {
    /// Computes the map of a lens and makes its plate; for a lens with distortion this takes a moment.
    pub(super) fn new(graphics: &Graphics, layout: &LensLayout, lens: &Lens) -> Result<LensSlot, RenderError> {
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
        let drawn = wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::COPY_SRC;
        let plate = luminance(device, "plate", map.size_px, read | drawn);
        let lamplight = luminance(device, "lamplight", [LAMPLIGHT_PX; 2], read | wgpu::TextureUsages::COPY_DST);
        let sheet = SheetOnDevice {
            focal_px: lens.focal_px.map(|focal_px| focal_px as f32),
            centre_px: map.centre_px.map(|at_px| at_px as f32),
            size_px: map.size_px.map(|size_px| size_px as f32),
            defocus_radius_px: (lens.defocus_px / 2.0) as f32,
            padding: 0.0,
        };
        let sheet = graphics.buffer("lens", wgpu::BufferUsages::UNIFORM, &[sheet]);
        let bindings = bind(device, layout, &sheet, &plate, &lamplight);
        Ok(LensSlot {
            lens: lens.clone(),
            plate_size_px: map.size_px,
            plate_centre_px: map.centre_px,
            plate,
            map: graphics.buffer("lens map", wgpu::BufferUsages::VERTEX, &map.cells),
            n_map_cells: map.cells.len() as u32,
            bindings,
            sheet,
            lamplight,
        })
    }

    /// Bindings with which lens.wgsl reads another plate (pinhole image) of the same size.
    pub(super) fn reading(
        &self,
        device: &wgpu::Device,
        layout: &LensLayout,
        plate: &wgpu::TextureView,
    ) -> wgpu::BindGroup {
        bind(device, layout, &self.sheet, plate, &self.lamplight)
    }

    /// Projection of the plate, the pinhole image before the lens. Its focal length is that of the lens along u.
    pub(super) fn pinhole(&self) -> Intrinsics {
        let principal_point_px = self.plate_centre_px;
        Intrinsics { size_px: self.plate_size_px, focal_px: self.lens.focal_px[0], principal_point_px }
    }

    /// Writes the factor for lamplight that is laid over the plate (the pinhole image): [`LAMPLIGHT_PX`] rows of as many places, evenly
    /// spaced from its first pixel to its last.
    pub(super) fn write_lamplight(&self, graphics: &Graphics, lamplight: &[f32]) {
        let texture = self.lamplight.texture();
        let rows = wgpu::TexelCopyBufferLayout {
            offset: 0,
            bytes_per_row: Some(LAMPLIGHT_PX * size_of::<f32>() as u32),
            rows_per_image: None,
        };
        graphics.queue.write_texture(texture.as_image_copy(), bytemuck::cast_slice(lamplight), rows, texture.size());
    }
}

fn bind(
    device: &wgpu::Device,
    layout: &LensLayout,
    sheet: &wgpu::Buffer,
    plate: &wgpu::TextureView,
    lamplight: &wgpu::TextureView,
) -> wgpu::BindGroup {
    let resources = [
        sheet.as_entire_binding(),
        wgpu::BindingResource::TextureView(plate),
        wgpu::BindingResource::Sampler(&layout.linear),
        wgpu::BindingResource::TextureView(lamplight),
    ];
    let entries: Vec<_> =
        (0..).zip(resources).map(|(binding, resource)| wgpu::BindGroupEntry { binding, resource }).collect();
    device.create_bind_group(&wgpu::BindGroupDescriptor {
        label: Some("lens"),
        layout: &layout.bindings,
        entries: &entries,
    })
}

fn luminance(
    device: &wgpu::Device,
    label: &str,
    [width, height]: [u32; 2],
    usage: wgpu::TextureUsages,
) -> wgpu::TextureView {
    device
        .create_texture(&wgpu::TextureDescriptor {
            label: Some(label),
            size: wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format: LUMINANCE_FORMAT,
            usage,
            view_formats: &[],
        })
        .create_view(&wgpu::TextureViewDescriptor::default())
}

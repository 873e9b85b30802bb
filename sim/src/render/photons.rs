//! The sensor pass: luminance, as it is or through a lens, to grey levels with the photons' noise.

use std::collections::BTreeMap;

use bytemuck::{Pod, Zeroable};

use super::{
    View,
    device::Graphics,
    floor::{Floor, LAMPLIGHT_PX},
    room::layouts::{Vertices, vertices},
    target::{LUMINANCE_FORMAT, Target, levels_format, linear},
};
use crate::{scene::BitDepth, sensors::lens::Lens};

/// Of what pixels differ by: two bytes each.
const PATTERN_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Rg8Unorm;

const PATTERN_SHADER: &str = concat!(include_str!("readout.wgsl"), include_str!("pattern.wgsl"));
const IDEAL_SHADER: &str =
    concat!(include_str!("readout.wgsl"), include_str!("photons.wgsl"), include_str!("ideal.wgsl"));
const LENS_SHADER: &str =
    concat!(include_str!("readout.wgsl"), include_str!("photons.wgsl"), include_str!("room/lens.wgsl"));

/// Pipelines of the sensor model, made when first needed.
pub(super) struct PhotonPass {
    made: BTreeMap<Kind, wgpu::RenderPipeline>,
    /// Fills the places between lamplight's.
    linear: wgpu::Sampler,
    lay_pattern: wgpu::RenderPipeline,
    readout_layout: wgpu::BindGroupLayout,
    pattern_layout: wgpu::BindGroupLayout,
    luminance_layout: wgpu::BindGroupLayout,
    pub(super) lens_layout: wgpu::BindGroupLayout,
}

/// A view's bindings.
pub(super) struct PhotonSlot {
    uniform: wgpu::Buffer,
    readout: wgpu::BindGroup,
    pattern: wgpu::TextureView,
    pattern_bindings: wgpu::BindGroup,
    luminance: wgpu::BindGroup,
    /// What the scene's lamps give over the floor that a view sees.
    lamplight: wgpu::TextureView,
    /// The seed whose pattern is laid.
    laid: Option<u64>,
}

/// What a pipeline is made for.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct Kind {
    /// Whether pixels differ, and whether levels take two bytes.
    uneven: bool,
    deep: bool,
    /// Whether lamps light the floor that is seen without a lens.
    lamplit: bool,
    lens: Option<LensKind>,
}

/// What of a lens matters from the plate on.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct LensKind {
    bent: bool,
    defocused: bool,
    vignetting: bool,
}

impl Kind {
    fn of(view: &View, lamplit: bool) -> Kind {
        let sensor = &view.sensor;
        let spreads = [sensor.dsnu_electrons, sensor.prnu, sensor.dark_current_electrons_per_s];
        let of_lens = |lens: &Lens| LensKind {
            bent: lens.bends(),
            defocused: lens.defocus_px > 0.0,
            vignetting: lens.vignetting,
        };
        Kind {
            uneven: spreads.iter().any(|share| *share > 0.0),
            deep: sensor.bits != BitDepth::Eight,
            lamplit,
            lens: view.lens.as_ref().map(of_lens),
        }
    }
}

impl PhotonSlot {
    fn write_lamplight(&self, graphics: &Graphics, lamplight: &[f32]) {
        let texture = self.lamplight.texture();
        let rows = wgpu::TexelCopyBufferLayout {
            offset: 0,
            bytes_per_row: Some(LAMPLIGHT_PX * size_of::<f32>() as u32),
            rows_per_image: None,
        };
        graphics.queue.write_texture(texture.as_image_copy(), bytemuck::cast_slice(lamplight), rows, texture.size());
    }
}

/// `Readout` of photons.wgsl.
#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
struct ReadoutOnDevice {
    size_px: [u32; 2],
    seed: [u32; 2],
    image: u32,
    electrons_per_luminance: f32,
    full_well_electrons: f32,
    read_noise_electrons: f32,
    gain_levels_per_electron: f32,
    dark_electrons: f32,
    offset_electrons: f32,
    sensitivity: f32,
    lifted_levels: f32,
    greatest_level: f32,
}

impl PhotonPass {
    pub(super) fn new(device: &wgpu::Device) -> PhotonPass {
        let layout = |label, visibility, types: &[wgpu::BindingType]| {
            let entry = |(ty, binding): (&wgpu::BindingType, u32)| wgpu::BindGroupLayoutEntry {
                binding,
                visibility,
                ty: *ty,
                count: None,
            };
            let entries: Vec<_> = types.iter().zip(0..).map(entry).collect();
            device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor { label: Some(label), entries: &entries })
        };
        let buffer = |ty| wgpu::BindingType::Buffer { ty, has_dynamic_offset: false, min_binding_size: None };
        let uniform = buffer(wgpu::BufferBindingType::Uniform);
        let view_dimension = wgpu::TextureViewDimension::D2;
        let texture = |filterable| wgpu::BindingType::Texture {
            sample_type: wgpu::TextureSampleType::Float { filterable },
            view_dimension,
            multisampled: false,
        };
        let sampler = wgpu::BindingType::Sampler(wgpu::SamplerBindingType::Filtering);
        let (vertex, fragment) = (wgpu::ShaderStages::VERTEX, wgpu::ShaderStages::FRAGMENT);
        let pattern_layout = layout("pattern", vertex, &[uniform]);
        PhotonPass {
            made: BTreeMap::new(),
            linear: linear(device),
            lay_pattern: pattern_pipeline(device, &pattern_layout),
            readout_layout: layout("readout", vertex | fragment, &[uniform, texture(false)]),
            pattern_layout,
            luminance_layout: layout("luminance", fragment, &[texture(true), texture(true), sampler]),
            lens_layout: layout("lens", vertex | fragment, &[uniform, texture(true), sampler]),
        }
    }

    /// Bindings that read one view's luminance.
    pub(super) fn slot(&self, device: &wgpu::Device, luminance: &wgpu::TextureView) -> PhotonSlot {
        let texture = |label, size, format, usage| {
            device
                .create_texture(&wgpu::TextureDescriptor {
                    label: Some(label),
                    size,
                    mip_level_count: 1,
                    sample_count: 1,
                    dimension: wgpu::TextureDimension::D2,
                    format,
                    usage: wgpu::TextureUsages::TEXTURE_BINDING | usage,
                    view_formats: &[],
                })
                .create_view(&wgpu::TextureViewDescriptor::default())
        };
        let drawn = wgpu::TextureUsages::RENDER_ATTACHMENT;
        let pattern = texture("pattern", luminance.texture().size(), PATTERN_FORMAT, drawn);
        let side = wgpu::Extent3d { width: LAMPLIGHT_PX, height: LAMPLIGHT_PX, depth_or_array_layers: 1 };
        let lamplight = texture("lamplight", side, LUMINANCE_FORMAT, wgpu::TextureUsages::COPY_DST);
        let uniform = device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("readout"),
            size: size_of::<ReadoutOnDevice>() as u64,
            usage: wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST,
            mapped_at_creation: false,
        });
        let bind = |label, layout, resources: Vec<wgpu::BindingResource>| {
            let entries: Vec<_> =
                (0..).zip(resources).map(|(binding, resource)| wgpu::BindGroupEntry { binding, resource }).collect();
            device.create_bind_group(&wgpu::BindGroupDescriptor { label: Some(label), layout, entries: &entries })
        };
        let values = uniform.as_entire_binding();
        let readout =
            bind("readout", &self.readout_layout, vec![values.clone(), wgpu::BindingResource::TextureView(&pattern)]);
        let pattern_bindings = bind("pattern", &self.pattern_layout, vec![values]);
        let sources = vec![
            wgpu::BindingResource::TextureView(luminance),
            wgpu::BindingResource::TextureView(&lamplight),
            wgpu::BindingResource::Sampler(&self.linear),
        ];
        let luminance = bind("luminance", &self.luminance_layout, sources);
        PhotonSlot { uniform, readout, pattern, pattern_bindings, luminance, lamplight, laid: None }
    }

    /// Turns one view's luminance, or its plate, into grey levels.
    pub(super) fn draw(
        &mut self,
        graphics: &Graphics,
        encoder: &mut wgpu::CommandEncoder,
        (floor, view): (&Floor, &View),
        target: &mut Target,
    ) {
        graphics.queue.write_buffer(&target.photons.uniform, 0, bytemuck::bytes_of(&readout(view)));

        let lamplight = if view.lens.is_none() { floor.lamplight_over(view) } else { None };
        if let Some(lamplight) = &lamplight {
            target.photons.write_lamplight(graphics, lamplight);
        }
        let kind = Kind::of(view, lamplight.is_some());
        if kind.uneven && target.photons.laid != Some(view.noise.seed) {
            whole_picture(
                encoder,
                &target.photons.pattern,
                &self.lay_pattern,
                &[&target.photons.pattern_bindings],
                None,
            );
            target.photons.laid = Some(view.noise.seed);
        }
        let (source_layout, source, map) = match (&target.room, &view.lens) {
            (Some(room), Some(_)) => (&self.lens_layout, room.lens_bindings(), Some((&room.map, room.n_map_cells))),
            _ => (&self.luminance_layout, &target.photons.luminance, None),
        };
        let layouts = [&self.readout_layout, source_layout];
        let read_out = self.made.entry(kind).or_insert_with(|| pipeline(&graphics.device, &layouts, kind));
        whole_picture(encoder, &target.levels, read_out, &[&target.photons.readout, source], map);
    }
}

/// Runs a pipeline on every pixel of a picture, all at once or in the cells of a lens's map.
fn whole_picture(
    encoder: &mut wgpu::CommandEncoder,
    picture: &wgpu::TextureView,
    pipeline: &wgpu::RenderPipeline,
    bindings: &[&wgpu::BindGroup],
    map: Option<(&wgpu::Buffer, u32)>,
) {
    let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
        label: Some("sensor"),
        color_attachments: &[Some(wgpu::RenderPassColorAttachment {
            view: picture,
            depth_slice: None,
            resolve_target: None,
            ops: wgpu::Operations { load: wgpu::LoadOp::Clear(wgpu::Color::BLACK), store: wgpu::StoreOp::Store },
        })],
        ..Default::default()
    });
    pass.set_pipeline(pipeline);
    for (bindings, group) in bindings.iter().zip(0..) {
        pass.set_bind_group(group, *bindings, &[]);
    }
    match map {
        Some((cells, count)) => {
            pass.set_vertex_buffer(0, cells.slice(..));
            pass.draw(0..4, 0..count);
        }
        None => pass.draw(0..3, 0..1),
    }
}

/// What the shader knows of a view's sensor.
fn readout(view: &View) -> ReadoutOnDevice {
    let sensor = &view.sensor;
    ReadoutOnDevice {
        size_px: view.intrinsics.size_px,
        seed: [view.noise.seed as u32, (view.noise.seed >> 32) as u32],
        image: view.noise.image,
        electrons_per_luminance: sensor.electrons_per_luminance(view.exposure_s) as f32,
        full_well_electrons: sensor.full_well_electrons as f32,
        read_noise_electrons: sensor.read_noise_electrons as f32,
        gain_levels_per_electron: view.gain_levels_per_electron as f32,
        dark_electrons: (sensor.dark_current_electrons_per_s * view.exposure_s) as f32,
        offset_electrons: sensor.dsnu_electrons as f32,
        sensitivity: sensor.prnu as f32,
        lifted_levels: sensor.black_level as f32 + 0.5,
        greatest_level: sensor.bits.greatest_level() as f32,
    }
}

fn module(device: &wgpu::Device, source: &str) -> wgpu::ShaderModule {
    device.create_shader_module(wgpu::ShaderModuleDescriptor {
        label: Some("photons"),
        source: wgpu::ShaderSource::Wgsl(source.into()),
    })
}

fn pattern_pipeline(device: &wgpu::Device, layout: &wgpu::BindGroupLayout) -> wgpu::RenderPipeline {
    let module = module(device, PATTERN_SHADER);
    let entry_points = ["pattern_corner", "lay_pattern"];
    on_whole_picture(device, &[layout], &module, (entry_points, None), &[], PATTERN_FORMAT)
}

fn pipeline(device: &wgpu::Device, layouts: &[&wgpu::BindGroupLayout], kind: Kind) -> wgpu::RenderPipeline {
    let flag = |on: bool| f64::from(u8::from(on));
    let mut constants = vec![("UNEVEN", flag(kind.uneven))];
    if kind.lamplit {
        constants.push(("LAMPLIT", 1.0));
    }
    if let Some(lens) = kind.lens {
        let of_lens = [("BENT", lens.bent), ("DEFOCUSED", lens.defocused), ("VIGNETTING", lens.vignetting)];
        constants.extend(of_lens.map(|(name, on)| (name, flag(on))));
    }
    let module = module(device, if kind.lens.is_some() { LENS_SHADER } else { IDEAL_SHADER });
    let entry_points = ["picture_corner", "read_out"];
    let cells = kind.lens.map(|_| vertices(wgpu::VertexStepMode::Instance, &[wgpu::VertexFormat::Float32x4; 6]));
    on_whole_picture(device, layouts, &module, (entry_points, cells), &constants, levels_format(kind.deep))
}

/// A pipeline for [`whole_picture`]; entry points of the vertex and of the fragment shader, with the cells that the former reads, `constants` of the
/// latter.
fn on_whole_picture(
    device: &wgpu::Device,
    layouts: &[&wgpu::BindGroupLayout],
    module: &wgpu::ShaderModule,
    (entry_points, cells): ([&str; 2], Option<Vertices>),
    constants: &[(&str, f64)],
    format: wgpu::TextureFormat,
) -> wgpu::RenderPipeline {
    let layouts: Vec<_> = layouts.iter().copied().map(Some).collect();
    let layout = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
        label: Some(entry_points[1]),
        bind_group_layouts: &layouts,
        immediate_size: 0,
    });
    let topology = match cells {
        Some(_) => wgpu::PrimitiveTopology::TriangleStrip,
        None => wgpu::PrimitiveTopology::TriangleList,
    };
    let cells = cells.as_ref().map(Vertices::layout);
    device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
        label: Some(entry_points[1]),
        layout: Some(&layout),
        vertex: wgpu::VertexState {
            module,
            entry_point: Some(entry_points[0]),
            compilation_options: wgpu::PipelineCompilationOptions::default(),
            buffers: if cells.is_some() { std::slice::from_ref(&cells) } else { &[] },
        },
        primitive: wgpu::PrimitiveState { topology, ..Default::default() },
        depth_stencil: None,
        multisample: wgpu::MultisampleState::default(),
        fragment: Some(wgpu::FragmentState {
            module,
            entry_point: Some(entry_points[1]),
            compilation_options: wgpu::PipelineCompilationOptions { constants, ..Default::default() },
            targets: &[Some(format.into())],
        }),
        multiview_mask: None,
        cache: None,
    })
}

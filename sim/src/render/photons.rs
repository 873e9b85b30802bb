//! The sensor pass: turns luminance, seen through a lens, into grey levels with photon noise.

use std::collections::BTreeMap;

use bytemuck::{Pod, Zeroable};

use super::{
    Shows, View,
    device::Graphics,
    floor::Floor,
    lens::{LensLayout, LensSlot},
    room::{
        RoomSlot,
        layouts::{Vertices, vertices},
    },
    texels::levels_format,
};
use crate::scene::BitDepth;

/// Texture format of a sensor's fixed pattern, by which its pixels differ from each other: two bytes for each pixel.
const PATTERN_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Rg8Unorm;

const PATTERN_SHADER: &str = concat!(include_str!("readout.wgsl"), include_str!("pattern.wgsl"));
const LENS_SHADER: &str =
    concat!(include_str!("readout.wgsl"), include_str!("photons.wgsl"), include_str!("lens.wgsl"));

/// Graphics pipelines of the sensor model, each made when it is first needed.
pub(super) struct PhotonPass {
    made: BTreeMap<Kind, wgpu::RenderPipeline>,
    lay_pattern: wgpu::RenderPipeline,
    readout_layout: wgpu::BindGroupLayout,
    pattern_layout: wgpu::BindGroupLayout,
    pub(super) lens_layout: LensLayout,
}

/// Buffers, textures and bindings of one sensor.
pub(super) struct PhotonSlot {
    uniform: wgpu::Buffer,
    readout: wgpu::BindGroup,
    pattern: wgpu::TextureView,
    pattern_bindings: wgpu::BindGroup,
    /// Seed of the fixed pattern that the texture holds; `None` if it holds none.
    laid: Option<u64>,
}

/// Device memory of one picture, as the sensor pass reads and writes it.
pub(super) struct PictureMemory<'a> {
    pub(super) lens: &'a LensSlot,
    /// The plates of a picture of a whole room.
    pub(super) room: Option<&'a RoomSlot>,
    pub(super) photons: &'a mut PhotonSlot,
    /// Texture of grey levels, which the pass writes.
    pub(super) levels: &'a wgpu::TextureView,
}

/// Properties of a picture to take (view) for which a graphics pipeline of the sensor is made.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct Kind {
    /// `uneven` says whether pixels differ by a fixed pattern, `deep` whether grey levels take two bytes.
    uneven: bool,
    deep: bool,
    /// Whether a factor for the unevenness of lamplight is laid over the floor's image.
    lamplit: bool,
    bent: bool,
    defocused: bool,
    vignetting: bool,
}

impl Kind {
    fn of(view: &View, lamplit: bool) -> Kind {
        let (sensor, lens) = (&view.sensor, &view.lens);
        let spreads = [sensor.dsnu_electrons, sensor.prnu, sensor.dark_current_electrons_per_s];
        Kind {
            uneven: spreads.iter().any(|share| *share > 0.0),
            deep: sensor.bits != BitDepth::Eight,
            lamplit,
            bent: lens.bends(),
            defocused: lens.defocus_px > 0.0,
            vignetting: lens.vignetting,
        }
    }
}

/// Device layout of `Readout` of photons.wgsl: the values of a sensor.
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
        let texture = wgpu::BindingType::Texture {
            sample_type: wgpu::TextureSampleType::Float { filterable: false },
            view_dimension: wgpu::TextureViewDimension::D2,
            multisampled: false,
        };
        let (vertex, fragment) = (wgpu::ShaderStages::VERTEX, wgpu::ShaderStages::FRAGMENT);
        let pattern_layout = layout("pattern", vertex, &[uniform]);
        PhotonPass {
            made: BTreeMap::new(),
            lay_pattern: pattern_pipeline(device, &pattern_layout),
            readout_layout: layout("readout", vertex | fragment, &[uniform, texture]),
            pattern_layout,
            lens_layout: LensLayout::new(device),
        }
    }

    /// Makes the bindings for a sensor of the given size in pixels.
    pub(super) fn slot(&self, device: &wgpu::Device, size_px: [u32; 2]) -> PhotonSlot {
        let pattern = device
            .create_texture(&wgpu::TextureDescriptor {
                label: Some("pattern"),
                size: wgpu::Extent3d { width: size_px[0], height: size_px[1], depth_or_array_layers: 1 },
                mip_level_count: 1,
                sample_count: 1,
                dimension: wgpu::TextureDimension::D2,
                format: PATTERN_FORMAT,
                usage: wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::RENDER_ATTACHMENT,
                view_formats: &[],
            })
            .create_view(&wgpu::TextureViewDescriptor::default());
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
        PhotonSlot { uniform, readout, pattern, pattern_bindings, laid: None }
    }

    /// Turns the luminance of one picture, the pinhole image on the plate, into grey levels.
    pub(super) fn draw(
        &mut self,
        graphics: &Graphics,
        encoder: &mut wgpu::CommandEncoder,
        (floor, view): (&Floor, &View),
        of: PictureMemory<'_>,
    ) {
        graphics.queue.write_buffer(&of.photons.uniform, 0, bytemuck::bytes_of(&readout(view)));

        let lamplight = if view.shows == Shows::Floor { floor.lamplight_over(view, of.lens) } else { None };
        if let Some(lamplight) = &lamplight {
            of.lens.write_lamplight(graphics, lamplight);
        }
        let kind = Kind::of(view, lamplight.is_some());
        if kind.uneven && of.photons.laid != Some(view.noise.seed) {
            whole_picture(encoder, &of.photons.pattern, &self.lay_pattern, &[&of.photons.pattern_bindings], None);
            of.photons.laid = Some(view.noise.seed);
        }
        let single = match view.shows {
            Shows::Floor => None,
            Shows::Room => of.room.and_then(RoomSlot::single_plate),
        };
        let lens = single.unwrap_or(&of.lens.bindings);
        let layouts = [&self.readout_layout, &self.lens_layout.bindings];
        let read_out = self.made.entry(kind).or_insert_with(|| pipeline(&graphics.device, &layouts, kind));
        let map = Some((&of.lens.map, of.lens.n_map_cells));
        whole_picture(encoder, of.levels, read_out, &[&of.photons.readout, lens], map);
    }
}

/// Runs a graphics pipeline on every pixel of a picture, either in one go or in the cells of a lens's map.
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

/// The values of the picture's sensor that the shader needs.
fn readout(view: &View) -> ReadoutOnDevice {
    let sensor = &view.sensor;
    ReadoutOnDevice {
        size_px: view.lens.size_px,
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
    let constants = [
        ("UNEVEN", flag(kind.uneven)),
        ("LAMPLIT", flag(kind.lamplit)),
        ("BENT", flag(kind.bent)),
        ("DEFOCUSED", flag(kind.defocused)),
        ("VIGNETTING", flag(kind.vignetting)),
    ];
    let module = module(device, LENS_SHADER);
    let entry_points = ["picture_corner", "read_out"];
    let cells = vertices(wgpu::VertexStepMode::Instance, &[wgpu::VertexFormat::Float32x4; 6]);
    on_whole_picture(device, layouts, &module, (entry_points, Some(cells)), &constants, levels_format(kind.deep))
}

/// A graphics pipeline that runs on every pixel of a picture, for [`whole_picture`]. `entry_points` are those of the vertex and of the fragment
/// shader; the vertex shader reads the cells, the fragment shader has the `constants`.
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

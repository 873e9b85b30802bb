//! The sensor pass: luminance, as it is or through a lens, to grey levels with the photons' noise.

use std::collections::BTreeMap;

use bytemuck::{Pod, Zeroable};

use super::{
    View,
    device::Graphics,
    target::{PAIR_FORMAT, Target, levels_format, pairs},
};
use crate::{scene::BitDepth, sensors::lens::Lens};

/// Invocations of a workgroup, as in pattern.wgsl.
const WORKGROUP: u32 = 64;
/// Workgroups in a row; a picture of any size then stays below the limit of every adapter in both directions.
const WORKGROUPS_IN_ROW: u32 = 1024;

const PATTERN_SHADER: &str = concat!(include_str!("readout.wgsl"), include_str!("pattern.wgsl"));
const IDEAL_SHADER: &str =
    concat!(include_str!("readout.wgsl"), include_str!("photons.wgsl"), include_str!("ideal.wgsl"));
const LENS_SHADER: &str =
    concat!(include_str!("readout.wgsl"), include_str!("photons.wgsl"), include_str!("room/lens.wgsl"));

/// Pipelines of the sensor model, made when first needed.
pub(super) struct PhotonPass {
    made: BTreeMap<Kind, wgpu::RenderPipeline>,
    lay_pattern: wgpu::ComputePipeline,
    readout_layout: wgpu::BindGroupLayout,
    pattern_layout: wgpu::BindGroupLayout,
    luminance_layout: wgpu::BindGroupLayout,
    pub(super) lens_layout: wgpu::BindGroupLayout,
}

/// A view's bindings.
pub(super) struct PhotonSlot {
    uniform: wgpu::Buffer,
    readout: wgpu::BindGroup,
    pattern: wgpu::BindGroup,
    luminance: wgpu::BindGroup,
    /// Which sensor's pattern is laid: its seed, and the spreads of offset and sensitivity.
    laid: Option<(u64, [f64; 2])>,
}

/// What a pipeline is made for.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct Kind {
    /// Whether pixels differ, and whether levels take two bytes.
    uneven: bool,
    deep: bool,
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
    fn of(view: &View) -> Kind {
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
            lens: view.lens.as_ref().map(of_lens),
        }
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
        let laid = wgpu::BindingType::StorageTexture {
            access: wgpu::StorageTextureAccess::WriteOnly,
            format: PAIR_FORMAT,
            view_dimension,
        };
        let sampler = wgpu::BindingType::Sampler(wgpu::SamplerBindingType::Filtering);
        let (fragment, compute) = (wgpu::ShaderStages::FRAGMENT, wgpu::ShaderStages::COMPUTE);
        let pattern_layout = layout("pattern", compute, &[uniform, laid]);
        PhotonPass {
            made: BTreeMap::new(),
            lay_pattern: pattern_pipeline(device, &pattern_layout),
            readout_layout: layout("readout", fragment, &[uniform, texture(false)]),
            pattern_layout,
            luminance_layout: layout("luminance", fragment, &[texture(true)]),
            lens_layout: layout("lens", fragment, &[uniform, texture(true), texture(false), sampler]),
        }
    }

    /// Bindings that read one view's luminance.
    pub(super) fn slot(&self, device: &wgpu::Device, luminance: &wgpu::TextureView) -> PhotonSlot {
        let size = luminance.texture().size();
        let laid = wgpu::TextureUsages::STORAGE_BINDING | wgpu::TextureUsages::TEXTURE_BINDING;
        let pattern = pairs(device, "pattern", [size.width, size.height], laid)
            .create_view(&wgpu::TextureViewDescriptor::default());
        let uniform = device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("readout"),
            size: size_of::<ReadoutOnDevice>() as u64,
            usage: wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST,
            mapped_at_creation: false,
        });
        let both = |layout| {
            device.create_bind_group(&wgpu::BindGroupDescriptor {
                label: Some("readout"),
                layout,
                entries: &[
                    wgpu::BindGroupEntry { binding: 0, resource: uniform.as_entire_binding() },
                    wgpu::BindGroupEntry { binding: 1, resource: wgpu::BindingResource::TextureView(&pattern) },
                ],
            })
        };
        let luminance = device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("luminance"),
            layout: &self.luminance_layout,
            entries: &[wgpu::BindGroupEntry { binding: 0, resource: wgpu::BindingResource::TextureView(luminance) }],
        });
        let (readout, pattern) = (both(&self.readout_layout), both(&self.pattern_layout));
        PhotonSlot { uniform, readout, pattern, luminance, laid: None }
    }

    /// Turns one view's luminance, or its plate, into grey levels.
    pub(super) fn draw(
        &mut self,
        graphics: &Graphics,
        encoder: &mut wgpu::CommandEncoder,
        view: &View,
        target: &mut Target,
    ) {
        let sensor = &view.sensor;
        graphics.queue.write_buffer(&target.photons.uniform, 0, bytemuck::bytes_of(&readout(view)));

        let kind = Kind::of(view);
        let pattern = (view.noise.seed, [sensor.dsnu_electrons, sensor.prnu]);
        if kind.uneven && target.photons.laid != Some(pattern) {
            let workgroups = (target.size_px[0] * target.size_px[1]).div_ceil(WORKGROUP);
            let columns = workgroups.min(WORKGROUPS_IN_ROW);
            let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor::default());
            pass.set_pipeline(&self.lay_pattern);
            pass.set_bind_group(0, &target.photons.pattern, &[]);
            pass.dispatch_workgroups(columns, workgroups.div_ceil(columns), 1);
            target.photons.laid = Some(pattern);
        }
        let (source_layout, source) = match (&target.room, &view.lens) {
            (Some(room), Some(_)) => (&self.lens_layout, room.lens_bindings()),
            _ => (&self.luminance_layout, &target.photons.luminance),
        };
        let layouts = [&self.readout_layout, source_layout];
        let read_out = self.made.entry(kind).or_insert_with(|| pipeline(&graphics.device, &layouts, kind));
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("sensor"),
            color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                view: &target.levels,
                depth_slice: None,
                resolve_target: None,
                ops: wgpu::Operations { load: wgpu::LoadOp::Clear(wgpu::Color::BLACK), store: wgpu::StoreOp::Store },
            })],
            ..Default::default()
        });
        pass.set_pipeline(read_out);
        pass.set_bind_group(0, &target.photons.readout, &[]);
        pass.set_bind_group(1, source, &[]);
        pass.draw(0..3, 0..1);
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

fn pattern_pipeline(device: &wgpu::Device, layout: &wgpu::BindGroupLayout) -> wgpu::ComputePipeline {
    let layout = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
        label: Some("pattern"),
        bind_group_layouts: &[Some(layout)],
        immediate_size: 0,
    });
    device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
        label: Some("pattern"),
        layout: Some(&layout),
        module: &module(device, PATTERN_SHADER),
        entry_point: Some("lay_pattern"),
        compilation_options: wgpu::PipelineCompilationOptions::default(),
        cache: None,
    })
}

fn pipeline(device: &wgpu::Device, layouts: &[&wgpu::BindGroupLayout; 2], kind: Kind) -> wgpu::RenderPipeline {
    let flag = |on: bool| f64::from(u8::from(on));
    let mut constants = vec![("UNEVEN", flag(kind.uneven))];
    if let Some(lens) = kind.lens {
        let of_lens = [("BENT", lens.bent), ("DEFOCUSED", lens.defocused), ("VIGNETTING", lens.vignetting)];
        constants.extend(of_lens.map(|(name, on)| (name, flag(on))));
    }
    let layout = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
        label: Some("sensor"),
        bind_group_layouts: &layouts.map(Some),
        immediate_size: 0,
    });
    let module = module(device, if kind.lens.is_some() { LENS_SHADER } else { IDEAL_SHADER });
    device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
        label: Some("sensor"),
        layout: Some(&layout),
        vertex: wgpu::VertexState {
            module: &module,
            entry_point: Some("whole_picture"),
            compilation_options: wgpu::PipelineCompilationOptions::default(),
            buffers: &[],
        },
        primitive: wgpu::PrimitiveState::default(),
        depth_stencil: None,
        multisample: wgpu::MultisampleState::default(),
        fragment: Some(wgpu::FragmentState {
            module: &module,
            entry_point: Some("read_out"),
            compilation_options: wgpu::PipelineCompilationOptions { constants: &constants, ..Default::default() },
            targets: &[Some(levels_format(kind.deep).into())],
        }),
        multiview_mask: None,
        cache: None,
    })
}

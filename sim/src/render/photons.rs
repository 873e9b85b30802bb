//! The sensor pass: luminance to grey levels, with the photons' noise.

use bytemuck::{Pod, Zeroable};

use super::{View, target::Target};
use crate::scene::BitDepth;

/// Invocations of a workgroup, as in photons.wgsl.
const WORKGROUP: u32 = 64;
/// Workgroups in a row; a picture of any size then stays below the limit of every adapter in both directions.
const WORKGROUPS_IN_ROW: u32 = 1024;

/// Pipeline of the sensor model.
pub(super) struct PhotonPass {
    /// For pixels that are alike or differ, in one byte each, then in two.
    pipelines: [wgpu::ComputePipeline; 4],
    layout: wgpu::BindGroupLayout,
}

/// A view's bindings.
pub(super) struct PhotonSlot {
    uniform: wgpu::Buffer,
    bindings: wgpu::BindGroup,
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
    row: u32,
    row_per_pixel: f32,
    dark_electrons: f32,
    offset_electrons: f32,
    sensitivity: f32,
    lifted_levels: f32,
    greatest_level: f32,
}

impl PhotonPass {
    pub(super) fn new(device: &wgpu::Device) -> PhotonPass {
        let module = device.create_shader_module(wgpu::include_wgsl!("photons.wgsl"));
        let entry = |binding, ty| wgpu::BindGroupLayoutEntry {
            binding,
            visibility: wgpu::ShaderStages::COMPUTE,
            ty,
            count: None,
        };
        let storage = |read_only| wgpu::BindingType::Buffer {
            ty: wgpu::BufferBindingType::Storage { read_only },
            has_dynamic_offset: false,
            min_binding_size: None,
        };
        let luminance = wgpu::BindingType::Texture {
            sample_type: wgpu::TextureSampleType::Float { filterable: false },
            view_dimension: wgpu::TextureViewDimension::D2,
            multisampled: false,
        };
        let layout = device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
            label: Some("readout"),
            entries: &[entry(0, storage(true)), entry(1, luminance), entry(2, storage(false))],
        });
        let pipeline_layout = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
            label: Some("photons"),
            bind_group_layouts: &[Some(&layout)],
            immediate_size: 0,
        });
        let pipeline = |uneven: bool, deep: bool| {
            device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
                label: Some("photons"),
                layout: Some(&pipeline_layout),
                module: &module,
                entry_point: Some("read_out"),
                compilation_options: wgpu::PipelineCompilationOptions {
                    constants: &[("UNEVEN", f64::from(u8::from(uneven))), ("DEEP", f64::from(u8::from(deep)))],
                    ..Default::default()
                },
                cache: None,
            })
        };
        let pipelines = [pipeline(false, false), pipeline(true, false), pipeline(false, true), pipeline(true, true)];
        PhotonPass { pipelines, layout }
    }

    /// Bindings that read one view's luminance and write its grey levels.
    pub(super) fn slot(&self, device: &wgpu::Device, luminance: &wgpu::TextureView, grey: &wgpu::Buffer) -> PhotonSlot {
        let uniform = device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("readout"),
            size: size_of::<ReadoutOnDevice>() as u64,
            usage: wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_DST,
            mapped_at_creation: false,
        });
        let bindings = device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("readout"),
            layout: &self.layout,
            entries: &[
                wgpu::BindGroupEntry { binding: 0, resource: uniform.as_entire_binding() },
                wgpu::BindGroupEntry { binding: 1, resource: wgpu::BindingResource::TextureView(luminance) },
                wgpu::BindGroupEntry { binding: 2, resource: grey.as_entire_binding() },
            ],
        });
        PhotonSlot { uniform, bindings }
    }

    /// Turns one view's luminance into grey levels.
    pub(super) fn draw(&self, queue: &wgpu::Queue, encoder: &mut wgpu::CommandEncoder, view: &View, target: &Target) {
        let sensor = &view.sensor;
        let words = (target.size_px[0] * target.size_px[1]).div_ceil(4);
        let workgroups = words.div_ceil(WORKGROUP);
        let columns = workgroups.min(WORKGROUPS_IN_ROW);
        let uniform = ReadoutOnDevice {
            size_px: target.size_px,
            seed: [view.noise.seed as u32, (view.noise.seed >> 32) as u32],
            image: view.noise.image,
            electrons_per_luminance: sensor.electrons_per_luminance(view.exposure_s) as f32,
            full_well_electrons: sensor.full_well_electrons as f32,
            read_noise_electrons: sensor.read_noise_electrons as f32,
            gain_levels_per_electron: view.gain_levels_per_electron as f32,
            row: columns * WORKGROUP,
            row_per_pixel: 1.0 / target.size_px[0] as f32,
            dark_electrons: (sensor.dark_current_electrons_per_s * view.exposure_s) as f32,
            offset_electrons: sensor.dsnu_electrons as f32,
            sensitivity: sensor.prnu as f32,
            lifted_levels: sensor.black_level as f32 + 0.5,
            greatest_level: sensor.bits.greatest_level() as f32,
        };
        queue.write_buffer(&target.photons.uniform, 0, bytemuck::bytes_of(&uniform));
        let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor::default());
        let uneven =
            [sensor.dsnu_electrons, sensor.prnu, sensor.dark_current_electrons_per_s].iter().any(|share| *share > 0.0);
        let deep = sensor.bits != BitDepth::Eight;
        pass.set_pipeline(&self.pipelines[usize::from(uneven) + 2 * usize::from(deep)]);
        pass.set_bind_group(0, &target.photons.bindings, &[]);
        pass.dispatch_workgroups(columns, workgroups.div_ceil(columns), 1);
    }
}

//! Graphics pipelines that draw the floor: one per pattern for the faces of tiles, and one for the flat bands that lie over them.

use wgpu::{BlendComponent, BlendFactor, BlendOperation, BlendState};

use super::geometry::{BandInstance, TileInstance};
use crate::{render::texels::LUMINANCE_FORMAT, scene::Pattern};

const TILE_SHADER: &str = concat!(
    include_str!("../row.wgsl"),
    include_str!("view.wgsl"),
    include_str!("pattern.wgsl"),
    include_str!("tile.wgsl")
);
const BAND_SHADER: &str = concat!(
    include_str!("../row.wgsl"),
    include_str!("view.wgsl"),
    include_str!("coverage.wgsl"),
    include_str!("band.wgsl")
);

/// Blending that lays the light of a band over the floor drawn before it: `source + (1 − hidden share)·target`, where the band is the source.
const OVER: BlendComponent = BlendComponent {
    src_factor: BlendFactor::One,
    dst_factor: BlendFactor::OneMinusSrcAlpha,
    operation: BlendOperation::Add,
};

/// Graphics pipelines for tile faces, one for each pattern in the order of [`Pattern`], for a rolling shutter or a global one.
pub(super) fn faces(device: &wgpu::Device, layout: &wgpu::PipelineLayout, rolling: bool) -> [wgpu::RenderPipeline; 4] {
    let tile_attributes = wgpu::vertex_attr_array![
        0 => Float32x4, 1 => Float32x4, 2 => Float32x2, 3 => Float32, 4 => Uint32, 5 => Uint32
    ];
    let tile_module = module(device, "tile", TILE_SHADER);
    [Pattern::Plain, Pattern::Speckle, Pattern::Marble, Pattern::Stripes].map(|pattern| {
        let stage = Stage {
            module: &tile_module,
            entry_points: ["tile_corner", "tile_luminance"],
            stride: size_of::<TileInstance>(),
            attributes: &tile_attributes,
            constants: &[("PATTERN", f64::from(pattern as u32)), ("ROLLING", f64::from(u8::from(rolling)))],
            blend: None,
        };
        pipeline(device, layout, &stage)
    })
}

/// The graphics pipeline that draws joints, stray wires and tapes, coverings, and walls over the floor.
pub(super) fn bands(device: &wgpu::Device, layout: &wgpu::PipelineLayout, rolling: bool) -> wgpu::RenderPipeline {
    let band_attributes = wgpu::vertex_attr_array![
        0 => Float32x2, 1 => Float32x2, 2 => Float32, 3 => Float32, 4 => Float32x2,
        5 => Float32, 6 => Float32x3, 7 => Float32, 8 => Float32, 9 => Float32
    ];
    let stage = Stage {
        module: &module(device, "band", BAND_SHADER),
        entry_points: ["band_corner", "band_luminance"],
        stride: size_of::<BandInstance>(),
        attributes: &band_attributes,
        constants: &[("ROLLING", f64::from(u8::from(rolling)))],
        blend: Some(BlendState { color: OVER, alpha: OVER }),
    };
    pipeline(device, layout, &stage)
}

/// Properties by which two pipelines of the floor differ.
struct Stage<'a> {
    module: &'a wgpu::ShaderModule,
    /// Names of the entry points in the vertex and in the fragment shader.
    entry_points: [&'a str; 2],
    stride: usize,
    attributes: &'a [wgpu::VertexAttribute],
    constants: &'a [(&'a str, f64)],
    blend: Option<BlendState>,
}

fn module(device: &wgpu::Device, label: &str, source: &str) -> wgpu::ShaderModule {
    device.create_shader_module(wgpu::ShaderModuleDescriptor {
        label: Some(label),
        source: wgpu::ShaderSource::Wgsl(source.into()),
    })
}

fn pipeline(device: &wgpu::Device, layout: &wgpu::PipelineLayout, stage: &Stage) -> wgpu::RenderPipeline {
    let options = wgpu::PipelineCompilationOptions { constants: stage.constants, ..Default::default() };
    device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
        label: Some(stage.entry_points[1]),
        layout: Some(layout),
        vertex: wgpu::VertexState {
            module: stage.module,
            entry_point: Some(stage.entry_points[0]),
            compilation_options: options.clone(),
            buffers: &[Some(wgpu::VertexBufferLayout {
                array_stride: stage.stride as u64,
                step_mode: wgpu::VertexStepMode::Instance,
                attributes: stage.attributes,
            })],
        },
        primitive: wgpu::PrimitiveState { topology: wgpu::PrimitiveTopology::TriangleStrip, ..Default::default() },
        depth_stencil: None,
        multisample: wgpu::MultisampleState::default(),
        fragment: Some(wgpu::FragmentState {
            module: stage.module,
            entry_point: Some(stage.entry_points[1]),
            compilation_options: options,
            targets: &[Some(wgpu::ColorTargetState {
                format: LUMINANCE_FORMAT,
                blend: stage.blend,
                write_mask: wgpu::ColorWrites::ALL,
            })],
        }),
        multiview_mask: None,
        cache: None,
    })
}

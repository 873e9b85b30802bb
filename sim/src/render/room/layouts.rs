//! Layouts of what the room's pipelines read.

use wgpu::VertexFormat;

/// A vertex buffer's layout.
pub(super) struct Vertices {
    pub(super) stride: u64,
    pub(super) step_mode: wgpu::VertexStepMode,
    pub(super) attributes: Vec<wgpu::VertexAttribute>,
}

/// Attributes one after another, without gaps.
pub(super) fn vertices(stride: u64, step_mode: wgpu::VertexStepMode, formats: &[VertexFormat]) -> Vertices {
    let mut offset = 0;
    let attributes = formats
        .iter()
        .zip(0..)
        .map(|(format, shader_location)| {
            let attribute = wgpu::VertexAttribute { format: *format, offset, shader_location };
            offset += format.size();
            attribute
        })
        .collect();
    Vertices { stride, step_mode, attributes }
}

/// A storage buffer that shaders only read.
pub(super) fn stored(binding: u32, has_dynamic_offset: bool) -> wgpu::BindGroupLayoutEntry {
    wgpu::BindGroupLayoutEntry {
        binding,
        visibility: wgpu::ShaderStages::VERTEX_FRAGMENT,
        ty: wgpu::BindingType::Buffer {
            ty: wgpu::BufferBindingType::Storage { read_only: true },
            has_dynamic_offset,
            min_binding_size: None,
        },
        count: None,
    }
}

/// A texture of one channel that shaders load from.
pub(super) fn texture(binding: u32, multisampled: bool) -> wgpu::BindGroupLayoutEntry {
    wgpu::BindGroupLayoutEntry {
        binding,
        visibility: wgpu::ShaderStages::VERTEX_FRAGMENT,
        ty: wgpu::BindingType::Texture {
            sample_type: wgpu::TextureSampleType::Float { filterable: false },
            view_dimension: wgpu::TextureViewDimension::D2,
            multisampled,
        },
        count: None,
    }
}

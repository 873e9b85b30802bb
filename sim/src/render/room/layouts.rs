//! Layouts of the buffers and textures that the room's pipelines read.

use wgpu::VertexFormat;

/// The layout of a vertex buffer.
pub(in crate::render) struct Vertices {
    stride: u64,
    step_mode: wgpu::VertexStepMode,
    attributes: Vec<wgpu::VertexAttribute>,
}

impl Vertices {
    /// The layout in wgpu's form, for a pipeline with one vertex buffer.
    pub(in crate::render) fn layout(&self) -> wgpu::VertexBufferLayout<'_> {
        wgpu::VertexBufferLayout { array_stride: self.stride, step_mode: self.step_mode, attributes: &self.attributes }
    }
}

/// A vertex layout with the given attributes one after another, without gaps.
pub(in crate::render) fn vertices(step_mode: wgpu::VertexStepMode, formats: &[VertexFormat]) -> Vertices {
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
    Vertices { stride: offset, step_mode, attributes }
}

/// A storage buffer that shaders only read.
pub(super) fn stored(binding: u32, has_dynamic_offset: bool) -> wgpu::BindGroupLayoutEntry {
    read(binding, wgpu::BufferBindingType::Storage { read_only: true }, has_dynamic_offset)
}

/// A uniform buffer whose values are the same for all sub-frames (instants of the exposure).
pub(super) fn constant(binding: u32) -> wgpu::BindGroupLayoutEntry {
    read(binding, wgpu::BufferBindingType::Uniform, false)
}

/// A uniform buffer with the camera's values for one picture, those of each sub-frame (instant of the exposure) at an offset of their own.
pub(super) fn uniform(binding: u32) -> wgpu::BindGroupLayoutEntry {
    read(binding, wgpu::BufferBindingType::Uniform, true)
}

fn read(binding: u32, ty: wgpu::BufferBindingType, has_dynamic_offset: bool) -> wgpu::BindGroupLayoutEntry {
    wgpu::BindGroupLayoutEntry {
        binding,
        visibility: wgpu::ShaderStages::VERTEX_FRAGMENT,
        ty: wgpu::BindingType::Buffer { ty, has_dynamic_offset, min_binding_size: None },
        count: None,
    }
}

/// A texture of floating-point values.
pub(super) fn texture(binding: u32, view_dimension: wgpu::TextureViewDimension) -> wgpu::BindGroupLayoutEntry {
    wgpu::BindGroupLayoutEntry {
        binding,
        visibility: wgpu::ShaderStages::VERTEX_FRAGMENT,
        ty: wgpu::BindingType::Texture {
            sample_type: wgpu::TextureSampleType::Float { filterable: true },
            view_dimension,
            multisampled: false,
        },
        count: None,
    }
}

/// A sampler that interpolates between a texture's texels.
pub(super) fn sampler(binding: u32) -> wgpu::BindGroupLayoutEntry {
    wgpu::BindGroupLayoutEntry {
        binding,
        visibility: wgpu::ShaderStages::FRAGMENT,
        ty: wgpu::BindingType::Sampler(wgpu::SamplerBindingType::Filtering),
        count: None,
    }
}

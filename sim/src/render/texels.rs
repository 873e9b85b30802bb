//! How pictures are kept on the graphics device: formats of their texels, and how values between texels are read.

/// Texture format of luminance in cd/m², averaged over the exposure.
pub(super) const LUMINANCE_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::R32Float;

/// A sampler that interpolates linearly between texels.
pub(super) fn linear(device: &wgpu::Device) -> wgpu::Sampler {
    device.create_sampler(&wgpu::SamplerDescriptor {
        label: Some("linear"),
        mag_filter: wgpu::FilterMode::Linear,
        min_filter: wgpu::FilterMode::Linear,
        ..Default::default()
    })
}

/// Texture format of grey levels: one byte each, or two.
pub(super) fn levels_format(deep: bool) -> wgpu::TextureFormat {
    if deep { wgpu::TextureFormat::R16Uint } else { wgpu::TextureFormat::R8Uint }
}

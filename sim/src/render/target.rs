//! Device memory of one view: luminance as drawn, grey levels as read out.

use std::sync::mpsc::{Receiver, channel};

use super::{
    RenderError, floor::FloorPass, floor::FloorSlot, photons::PhotonPass, photons::PhotonSlot, room::RoomSlot,
};

/// Luminance in cd/m², averaged over the exposure.
pub(super) const LUMINANCE_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::R32Float;

/// Fills the places between texels.
pub(super) fn linear(device: &wgpu::Device) -> wgpu::Sampler {
    device.create_sampler(&wgpu::SamplerDescriptor {
        label: Some("linear"),
        mag_filter: wgpu::FilterMode::Linear,
        min_filter: wgpu::FilterMode::Linear,
        ..Default::default()
    })
}

/// Of grey levels: one byte each, or two.
pub(super) fn levels_format(deep: bool) -> wgpu::TextureFormat {
    if deep { wgpu::TextureFormat::R16Uint } else { wgpu::TextureFormat::R8Uint }
}

/// Buffers and bindings of one view, kept from tick to tick.
pub(super) struct Target {
    pub(super) size_px: [u32; 2],
    /// One byte a level, or two.
    pub(super) deep: bool,
    pub(super) luminance: wgpu::TextureView,
    pub(super) floor: FloorSlot,
    /// Made when first a room is drawn.
    pub(super) room: Option<RoomSlot>,
    pub(super) photons: PhotonSlot,
    /// Grey levels.
    pub(super) levels: wgpu::TextureView,
    staging: wgpu::Buffer,
}

/// Grey levels of one picture.
pub(super) enum Levels {
    /// Of a sensor of eight bits.
    Eight(Vec<u8>),
    /// Of one with more.
    Deep(Vec<u16>),
}

/// Whether a staging buffer could be mapped, answered by the device's poll.
pub(super) type Mapping = Receiver<Result<(), wgpu::BufferAsyncError>>;

impl Target {
    pub(super) fn new(
        device: &wgpu::Device,
        floor_pass: &FloorPass,
        photon_pass: &PhotonPass,
        size_px: [u32; 2],
        deep: bool,
    ) -> Target {
        let attachment = |label, format, usage| {
            let descriptor = wgpu::TextureDescriptor {
                label: Some(label),
                size: wgpu::Extent3d { width: size_px[0], height: size_px[1], depth_or_array_layers: 1 },
                mip_level_count: 1,
                sample_count: 1,
                dimension: wgpu::TextureDimension::D2,
                format,
                usage: wgpu::TextureUsages::RENDER_ATTACHMENT | usage,
                view_formats: &[],
            };
            device.create_texture(&descriptor).create_view(&wgpu::TextureViewDescriptor::default())
        };
        let luminance = attachment("luminance", LUMINANCE_FORMAT, wgpu::TextureUsages::TEXTURE_BINDING);
        let levels = attachment("grey levels", levels_format(deep), wgpu::TextureUsages::COPY_SRC);
        let staging = device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("grey levels staged"),
            size: u64::from(staged_row(size_px, deep)) * u64::from(size_px[1]),
            usage: wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::COPY_DST,
            mapped_at_creation: false,
        });
        let floor = floor_pass.slot(device);
        let photons = photon_pass.slot(device, &luminance);
        Target { size_px, deep, luminance, floor, room: None, photons, levels, staging }
    }

    /// Copies the grey levels to where the processor can read them.
    pub(super) fn stage(&self, encoder: &mut wgpu::CommandEncoder) {
        let layout = wgpu::TexelCopyBufferLayout {
            offset: 0,
            bytes_per_row: Some(staged_row(self.size_px, self.deep)),
            rows_per_image: None,
        };
        let staging = wgpu::TexelCopyBufferInfo { buffer: &self.staging, layout };
        encoder.copy_texture_to_buffer(self.levels.texture().as_image_copy(), staging, self.levels.texture().size());
    }

    /// Asks for the staged grey levels.
    pub(super) fn map(&self) -> Mapping {
        let (sender, mapping) = channel();
        self.staging.slice(..).map_async(wgpu::MapMode::Read, move |outcome| {
            // The receiver is gone only when drawing has already failed.
            let _ = sender.send(outcome);
        });
        mapping
    }

    /// Grey levels in the order of rows, once the mapping has been answered.
    pub(super) fn read(&self) -> Result<Levels, RenderError> {
        let failed = |reason: String| RenderError::Device(reason);
        let levels = {
            let mapped = self.staging.slice(..).get_mapped_range().map_err(|error| failed(error.to_string()))?;
            let rows = mapped.chunks_exact(staged_row(self.size_px, self.deep) as usize);
            let width = self.size_px[0] as usize;
            if self.deep {
                let pairs = rows.flat_map(|row| row[..2 * width].chunks_exact(2));
                Levels::Deep(pairs.map(|pair| u16::from_le_bytes([pair[0], pair[1]])).collect())
            } else {
                let mut levels = Vec::with_capacity(width * self.size_px[1] as usize);
                rows.for_each(|row| levels.extend_from_slice(&row[..width]));
                Levels::Eight(levels)
            }
        };
        self.staging.unmap();
        Ok(levels)
    }
}

/// Bytes from one row of staged levels to the next, as copies want them.
fn staged_row(size_px: [u32; 2], deep: bool) -> u32 {
    let bytes = if deep { 2 * size_px[0] } else { size_px[0] };
    bytes.next_multiple_of(wgpu::COPY_BYTES_PER_ROW_ALIGNMENT)
}

//! Device memory of one view: luminance as drawn, grey levels as read out.

use std::sync::mpsc::{Receiver, channel};

use super::{
    RenderError, device::PATIENCE, floor::FloorPass, floor::FloorSlot, photons::PhotonPass, photons::PhotonSlot,
    room::RoomSlot,
};

/// Luminance in cd/m², averaged over the exposure.
pub(super) const LUMINANCE_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::R32Float;

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
    grey: wgpu::Buffer,
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
        let luminance = device
            .create_texture(&wgpu::TextureDescriptor {
                label: Some("luminance"),
                size: wgpu::Extent3d { width: size_px[0], height: size_px[1], depth_or_array_layers: 1 },
                mip_level_count: 1,
                sample_count: 1,
                dimension: wgpu::TextureDimension::D2,
                format: LUMINANCE_FORMAT,
                usage: wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::TEXTURE_BINDING,
                view_formats: &[],
            })
            .create_view(&wgpu::TextureViewDescriptor::default());
        // Grey levels are packed four or two to a word, without padding at the end of a row; an invocation writes four.
        let pixels = (u64::from(size_px[0]) * u64::from(size_px[1])).next_multiple_of(4);
        let bytes = if deep { 2 * pixels } else { pixels };
        let buffer = |label, usage| {
            device.create_buffer(&wgpu::BufferDescriptor {
                label: Some(label),
                size: bytes,
                usage,
                mapped_at_creation: false,
            })
        };
        let grey = buffer("grey levels", wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_SRC);
        let staging = buffer("grey levels staged", wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::COPY_DST);
        let floor = floor_pass.slot(device);
        let photons = photon_pass.slot(device, &luminance, &grey);
        Target { size_px, deep, luminance, floor, room: None, photons, grey, staging }
    }

    /// Copies the grey levels to where the processor can read them.
    pub(super) fn stage(&self, encoder: &mut wgpu::CommandEncoder) {
        encoder.copy_buffer_to_buffer(&self.grey, 0, &self.staging, 0, self.staging.size());
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

    /// Grey levels in the order of rows, once the device has been waited for. Where threads share the device, the answer may be on
    /// its way in another thread's poll, so that it is waited for as well.
    pub(super) fn read(&self, mapping: &Mapping) -> Result<Levels, RenderError> {
        let failed = |reason: String| RenderError::Device(reason);
        mapping
            .recv_timeout(PATIENCE)
            .map_err(|error| failed(error.to_string()))?
            .map_err(|error| failed(error.to_string()))?;
        let pixels = self.size_px[0] as usize * self.size_px[1] as usize;
        let levels = {
            let mapped = self.staging.slice(..).get_mapped_range().map_err(|error| failed(error.to_string()))?;
            if self.deep {
                let pairs = mapped[..2 * pixels].chunks_exact(2);
                Levels::Deep(pairs.map(|pair| u16::from_le_bytes([pair[0], pair[1]])).collect())
            } else {
                Levels::Eight(mapped[..pixels].to_vec())
            }
        };
        self.staging.unmap();
        Ok(levels)
    }
}

//! Device memory of one picture: luminance as drawn, and grey levels as read out.

use std::sync::mpsc::channel;

use super::{
    RenderError, View,
    device::{Graphics, Mapping},
    floor::{FloorPass, FloorSlot},
    lens::LensSlot,
    photons::{PhotonPass, PhotonSlot},
    room::RoomSlot,
    texels::levels_format,
};
use crate::{optics::Lens, scene::BitDepth};

/// Buffers and bindings on the graphics device for one picture, kept from tick to tick.
pub(super) struct Target {
    /// Whether a grey level takes two bytes instead of one.
    pub(super) deep: bool,
    pub(super) lens: LensSlot,
    pub(super) floor: FloorSlot,
    /// Device memory for pictures of a whole room, made when a room is first drawn.
    pub(super) room: Option<RoomSlot>,
    pub(super) photons: PhotonSlot,
    /// Texture of grey levels.
    pub(super) levels: wgpu::TextureView,
    staging: wgpu::Buffer,
}

/// Grey levels of one picture.
pub(super) enum Levels {
    /// Grey levels from a sensor with eight bits.
    Eight(Vec<u8>),
    /// Grey levels from a sensor with more than eight bits.
    Deep(Vec<u16>),
}

impl Target {
    pub(super) fn new(
        graphics: &Graphics,
        floor_pass: &FloorPass,
        photon_pass: &PhotonPass,
        lens: &Lens,
        deep: bool,
    ) -> Result<Target, RenderError> {
        let device = &graphics.device;
        let size_px = lens.size_px;
        let levels = device
            .create_texture(&wgpu::TextureDescriptor {
                label: Some("grey levels"),
                size: wgpu::Extent3d { width: size_px[0], height: size_px[1], depth_or_array_layers: 1 },
                mip_level_count: 1,
                sample_count: 1,
                dimension: wgpu::TextureDimension::D2,
                format: levels_format(deep),
                usage: wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::COPY_SRC,
                view_formats: &[],
            })
            .create_view(&wgpu::TextureViewDescriptor::default());
        let staging = device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("grey levels staged"),
            size: u64::from(staged_row(size_px, deep)) * u64::from(size_px[1]),
            usage: wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::COPY_DST,
            mapped_at_creation: false,
        });
        let floor = floor_pass.slot(device);
        let photons = photon_pass.slot(device, size_px);
        let lens = LensSlot::new(graphics, &photon_pass.lens_layout, lens)?;
        Ok(Target { deep, lens, floor, room: None, photons, levels, staging })
    }

    /// Whether this target (device memory) is made for the lens and the bit depth of the given view, so that its picture can be drawn with it.
    pub(super) fn suits(&self, view: &View) -> bool {
        self.lens.lens == view.lens && self.deep == (view.sensor.bits != BitDepth::Eight)
    }

    /// Copies the grey levels into a buffer that the processor can read.
    pub(super) fn stage(&self, encoder: &mut wgpu::CommandEncoder) {
        let layout = wgpu::TexelCopyBufferLayout {
            offset: 0,
            bytes_per_row: Some(staged_row(self.lens.lens.size_px, self.deep)),
            rows_per_image: None,
        };
        let staging = wgpu::TexelCopyBufferInfo { buffer: &self.staging, layout };
        encoder.copy_texture_to_buffer(self.levels.texture().as_image_copy(), staging, self.levels.texture().size());
    }

    /// Requests access to the staged grey levels.
    pub(super) fn map(&self) -> Mapping {
        let (sender, mapping) = channel();
        self.staging.slice(..).map_async(wgpu::MapMode::Read, move |outcome| {
            // Sending the outcome of the mapping fails only if the receiver is gone, and then drawing has already failed.
            let _ = sender.send(outcome);
        });
        mapping
    }

    /// Grey levels of the picture row by row, once the mapping has been answered.
    pub(super) fn read(&self) -> Result<Levels, RenderError> {
        let failed = |reason: String| RenderError::Device(reason);
        let levels = {
            let mapped = self.staging.slice(..).get_mapped_range().map_err(|error| failed(error.to_string()))?;
            let rows = mapped.chunks_exact(staged_row(self.lens.lens.size_px, self.deep) as usize);
            let width = self.lens.lens.size_px[0] as usize;
            if self.deep {
                let pairs = rows.flat_map(|row| row[..2 * width].chunks_exact(2));
                Levels::Deep(pairs.map(|pair| u16::from_le_bytes([pair[0], pair[1]])).collect())
            } else {
                let mut levels = Vec::with_capacity(width * self.lens.lens.size_px[1] as usize);
                rows.for_each(|row| levels.extend_from_slice(&row[..width]));
                Levels::Eight(levels)
            }
        };
        self.staging.unmap();
        Ok(levels)
    }
}

/// Bytes from one row of staged levels to the next, with the alignment that copies need.
fn staged_row(size_px: [u32; 2], deep: bool) -> u32 {
    let bytes = if deep { 2 * size_px[0] } else { size_px[0] };
    bytes.next_multiple_of(wgpu::COPY_BYTES_PER_ROW_ALIGNMENT)
}

//! The lens as a map: where on the plate each pixel of the sensor takes its light from.

use crate::{render::RenderError, sensors::lens::Lens};

/// A plate more than this many times as wide as the image would come from a distortion that no real lens has.
const WIDEST_PLATE: f64 = 3.0;

/// The plate's extent, and the places of all pixels on it.
pub(super) struct LensMap {
    /// Width and height of the plate.
    pub(super) size_px: [u32; 2],
    /// Principal point on the plate, (0, 0) the centre of its first pixel.
    pub(super) centre_px: [f64; 2],
    /// Place on the plate of every pixel, row by row; one entry when the plate is the image itself.
    pub(super) places_px: Vec<[f32; 2]>,
    /// Width and height of these.
    pub(super) places_size_px: [u32; 2],
}

impl LensMap {
    /// The map of a lens.
    pub(super) fn new(lens: &Lens) -> Result<LensMap, RenderError> {
        if !lens.bends() && lens.defocus_px == 0.0 {
            return Ok(LensMap {
                size_px: lens.size_px,
                centre_px: lens.principal_point_px,
                places_px: vec![[0.0; 2]],
                places_size_px: [1, 1],
            });
        }
        let [width, height] = lens.size_px;
        let mut places = Vec::with_capacity(width as usize * height as usize);
        let (mut low, mut high) = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
        for (v, u) in (0..height).flat_map(|v| (0..width).map(move |u| (v, u))) {
            let ray = lens
                .ray([f64::from(u), f64::from(v)])
                .ok_or(RenderError::BadView("its lens distorts so much that two directions fall on one pixel"))?;
            let place = [0, 1].map(|axis| ray[axis] * lens.focal_px[axis]);
            for axis in 0..2 {
                low[axis] = low[axis].min(place[axis]);
                high[axis] = high[axis].max(place[axis]);
            }
            places.push(place);
        }
        // Interpolation looks one pixel further, and defocus its radius.
        let margin_px = 2.0 + (0.5 * lens.defocus_px).ceil();
        // At the principal point pixels of the plate lie on pixels of the sensor. What interpolation does where the plate is stretched is then
        // the same on both sides of it, as a lens's own bend is, and not like a lens that is off its centre.
        let centre_px = [0, 1].map(|axis| {
            let at_px = lens.principal_point_px[axis];
            at_px + (margin_px - low[axis] - at_px).ceil()
        });
        let size = [0, 1].map(|axis| (centre_px[axis] + high[axis] + margin_px).ceil() + 1.0);
        if (0..2).any(|axis| size[axis] > WIDEST_PLATE * f64::from(lens.size_px[axis]) + 100.0) {
            return Err(RenderError::BadView("its lens distorts so much that the image's edges look sideways"));
        }
        let on_plate = |place: &[f64; 2]| [0, 1].map(|axis| (place[axis] + centre_px[axis]) as f32);
        Ok(LensMap {
            size_px: size.map(|side| side as u32),
            centre_px,
            places_px: places.iter().map(on_plate).collect(),
            places_size_px: lens.size_px,
        })
    }
}

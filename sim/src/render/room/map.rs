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
    /// Where on the plate the sensor's first pixel lies unless it is bent away.
    pub(super) shift_px: [f64; 2],
    /// How far the lens bends every pixel away, row by row, in steps of `step_px`; one entry when the plate is the image itself.
    pub(super) bends: Vec<[i16; 2]>,
    /// The greatest bend has the greatest number: a lens that bends by 80 px is mapped within 0.0013 px.
    pub(super) step_px: f64,
    /// Width and height of the bends.
    pub(super) bends_size_px: [u32; 2],
}

impl LensMap {
    /// The map of a lens.
    pub(super) fn new(lens: &Lens) -> Result<LensMap, RenderError> {
        if !lens.bends() && lens.defocus_px == 0.0 {
            return Ok(LensMap {
                size_px: lens.size_px,
                centre_px: lens.principal_point_px,
                shift_px: [0.0; 2],
                bends: vec![[0; 2]],
                step_px: 0.0,
                bends_size_px: [1, 1],
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
        let shift_px = [0, 1].map(|axis| centre_px[axis] - lens.principal_point_px[axis]);
        let bend_px = |(index, place): (usize, &[f64; 2])| {
            let pixel = [index % width as usize, index / width as usize];
            [0, 1].map(|axis| place[axis] + lens.principal_point_px[axis] - pixel[axis] as f64)
        };
        let bends_px = || places.iter().enumerate().map(bend_px);
        let step_px =
            bends_px().flatten().fold(f64::MIN_POSITIVE, |most, bend| most.max(bend.abs())) / f64::from(i16::MAX);
        Ok(LensMap {
            size_px: size.map(|side| side as u32),
            centre_px,
            shift_px,
            bends: bends_px().map(|bend| bend.map(|along| (along / step_px).round() as i16)).collect(),
            step_px,
            bends_size_px: lens.size_px,
        })
    }
}

//! The lens as a map: the place on the plate (the pinhole image before the lens) from which each pixel of the sensor takes its light.

use bytemuck::{Pod, Zeroable};
use nalgebra::{DMatrix, Dyn, OMatrix, U2};

use crate::{optics::Lens, render::RenderError};

/// Greatest width and height of a plate, the pinhole image before the lens, over those of the sensor's image. A larger plate would come
/// from a distortion that no real lens has.
const WIDEST_PLATE: f64 = 3.0;
/// Greatest and least side of a cell of the lens's map, in pixels.
const WIDEST_CELL_PX: u32 = 128;
const NARROWEST_CELL_PX: u32 = 8;
/// Greatest error of the polynomials of a cell of the lens's map, which is cut into smaller cells to keep it. It is a fifth of the other errors
/// in the image position of a dot seen through a distorting lens.
const MAP_TOLERANCE_PX: f64 = 2e-3;
/// Number of terms of a polynomial of the third degree in two variables.
const N_TERMS: usize = 10;

/// The map of a lens: the extent of its plate (the pinhole image before the lens), and the places on the plate of the sensor's pixels.
pub(super) struct LensMap {
    /// Width and height of the plate, the pinhole image that the sensor reads through the lens.
    pub(super) size_px: [u32; 2],
    /// Principal point on the plate, the pinhole image that the sensor reads through the lens; (0, 0) is the centre of its first pixel.
    pub(super) centre_px: [f64; 2],
    /// Cells of the lens's map, which together cover the sensor's picture.
    pub(super) cells: Vec<MapCell>,
}

/// A rectangular cell of the lens's map. For each sensor pixel in the cell, the place on the plate (the pinhole image before the lens) is
/// the pixel's own coordinates plus a polynomial of the third degree. A software driver evaluates polynomials faster than it fetches values
/// from a map.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub(super) struct MapCell {
    /// First pixel of the map cell, and the pixel just after its last, along u and v.
    bounds_px: [[f32; 2]; 2],
    /// Coefficients of two polynomials in a sensor pixel's coordinates u and v, counted from the cell's middle, for the terms 1, u, v, u², uv, v²,
    /// u³, u²v, uv², v³. The polynomials give how far, along u and along v, the place from which the pixel takes its light lies from the pixel's
    /// own coordinates; that place is one in the image that a pinhole camera would take.
    terms: [[f32; 2]; N_TERMS],
}

impl LensMap {
    /// Computes the map of a lens.
    pub(super) fn new(lens: &Lens) -> Result<LensMap, RenderError> {
        let [width, height] = lens.size_px;
        if !lens.bends() && lens.defocus_px == 0.0 {
            let bounds_px = [[0.0; 2], [width as f32, height as f32]];
            return Ok(LensMap {
                size_px: lens.size_px,
                centre_px: lens.principal_point_px,
                cells: vec![MapCell { bounds_px, terms: [[0.0; 2]; N_TERMS] }],
            });
        }
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
        // Margin of the plate, the pinhole image before the lens: interpolation reads one pixel further, and defocus reads its radius
        // further.
        let margin_px = 2.0 + (0.5 * lens.defocus_px).ceil();
        // At the principal point, pixels of the plate (the pinhole image before the lens) coincide with pixels of the sensor. Interpolation
        // errors where the plate is stretched are then symmetric about that point, as a lens's own distortion is, and do not look like a
        // lens that is off its centre.
        let centre_px = [0, 1].map(|axis| {
            let at_px = lens.principal_point_px[axis];
            at_px + (margin_px - low[axis] - at_px).ceil()
        });
        let size = [0, 1].map(|axis| (centre_px[axis] + high[axis] + margin_px).ceil() + 1.0);
        if (0..2).any(|axis| size[axis] > WIDEST_PLATE * f64::from(lens.size_px[axis]) + 100.0) {
            return Err(RenderError::BadView("its lens distorts so much that the image's edges look sideways"));
        }
        let moved = places.iter().enumerate().map(|(index, place)| {
            let pixel = [index as u32 % width, index as u32 / width];
            [0, 1].map(|axis| place[axis] + centre_px[axis] - f64::from(pixel[axis]))
        });
        let picture = Moved { width, by_px: moved.collect() };
        let mut cells = Vec::new();
        for v in (0..height).step_by(WIDEST_CELL_PX as usize) {
            for u in (0..width).step_by(WIDEST_CELL_PX as usize) {
                let end = [(u + WIDEST_CELL_PX).min(width), (v + WIDEST_CELL_PX).min(height)];
                picture.cut([u, v], end, WIDEST_CELL_PX, &mut cells);
            }
        }
        Ok(LensMap { size_px: size.map(|side| side as u32), centre_px, cells })
    }
}

/// Difference between each sensor pixel's place on the plate (the pinhole image before the lens) and the pixel's own coordinates, row by
/// row.
struct Moved {
    width: u32,
    by_px: Vec<[f64; 2]>,
}

impl Moved {
    fn at(&self, [u, v]: [u32; 2]) -> [f64; 2] {
        self.by_px[(v * self.width + u) as usize]
    }

    /// Appends map cells for the pixels from `first` to before `end`, cut into smaller ones where a single polynomial is not accurate
    /// enough.
    fn cut(&self, first: [u32; 2], end: [u32; 2], side_px: u32, cells: &mut Vec<MapCell>) {
        let (cell, error_px) = self.fitted(first, end);
        if error_px <= MAP_TOLERANCE_PX || side_px <= NARROWEST_CELL_PX {
            cells.push(cell);
            return;
        }
        let half_px = side_px / 2;
        for v in (first[1]..end[1]).step_by(half_px as usize) {
            for u in (first[0]..end[0]).step_by(half_px as usize) {
                self.cut([u, v], [(u + half_px).min(end[0]), (v + half_px).min(end[1])], half_px, cells);
            }
        }
    }

    /// Fits the polynomials of a map cell to some of its pixels by least squares, and returns them with the greatest error over all of its
    /// pixels.
    fn fitted(&self, first: [u32; 2], end: [u32; 2]) -> (MapCell, f64) {
        let middle = [0, 1].map(|axis| 0.5 * (f64::from(first[axis]) + f64::from(end[axis]) - 1.0));
        let half = [0, 1].map(|axis| 0.5 * f64::from(end[axis] - first[axis]));
        // Coordinates run from −1 to 1 across the map cell, so that all terms of its polynomials are of similar size.
        let terms_at = |pixel: [u32; 2]| {
            let [x, y] = [0, 1].map(|axis| (f64::from(pixel[axis]) - middle[axis]) / half[axis]);
            [1.0, x, y, x * x, x * y, y * y, x * x * x, x * x * y, x * y * y, y * y * y]
        };
        let along = |axis: usize| (0..=8).map(move |step| first[axis] + (end[axis] - 1 - first[axis]) * step / 8);
        let pixels: Vec<[u32; 2]> = along(1).flat_map(|v| along(0).map(move |u| [u, v])).collect();
        let design = DMatrix::from_fn(pixels.len(), N_TERMS, |row, term| terms_at(pixels[row])[term]);
        let wanted = OMatrix::<f64, Dyn, U2>::from_fn(pixels.len(), |row, axis| self.at(pixels[row])[axis]);
        // In a cell one pixel wide some terms cannot be distinguished; the singular value decomposition then gives the smallest solution.
        let found =
            design.svd(true, true).solve(&wanted, 1e-10).unwrap_or_else(|_| OMatrix::<f64, Dyn, U2>::zeros(N_TERMS));
        let powers: [[i32; 2]; N_TERMS] =
            [[0, 0], [1, 0], [0, 1], [2, 0], [1, 1], [0, 2], [3, 0], [2, 1], [1, 2], [0, 3]];
        let terms = std::array::from_fn(|term| {
            let scale = half[0].powi(powers[term][0]) * half[1].powi(powers[term][1]);
            [0, 1].map(|axis| (found[(term, axis)] / scale) as f32)
        });
        let mut error_px: f64 = 0.0;
        for pixel in (first[1]..end[1]).flat_map(|v| (first[0]..end[0]).map(move |u| [u, v])) {
            let (true_px, terms) = (self.at(pixel), terms_at(pixel));
            for axis in 0..2 {
                let fit_px: f64 = terms.iter().enumerate().map(|(term, value)| value * found[(term, axis)]).sum();
                error_px = error_px.max((fit_px - true_px[axis]).abs());
            }
        }
        let bounds_px = [first, end].map(|corner| corner.map(|along| along as f32));
        (MapCell { bounds_px, terms }, error_px)
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;

    /// The place on the plate (the pinhole image before the lens) of a sensor pixel, computed in single precision as lens.wgsl does.
    fn place(cell: &MapCell, pixel: [u32; 2]) -> [f32; 2] {
        let [first, end] = cell.bounds_px;
        let [x, y] = [0, 1].map(|axis| pixel[axis] as f32 - 0.5 * (first[axis] + end[axis] - 1.0));
        let terms = [1.0, x, y, x * x, x * y, y * y, x * x * x, x * x * y, x * y * y, y * y * y];
        [0, 1].map(|axis| {
            let moved: f32 = terms.iter().zip(&cell.terms).map(|(term, by_axis)| term * by_axis[axis]).sum();
            pixel[axis] as f32 + moved
        })
    }

    #[test]
    fn each_pixel_lies_in_one_cell_whose_polynomials_are_true_to_a_four_hundredth_of_a_pixel() {
        let lenses = [
            // Lenses under test: that of a forward camera, one with twice the distortion, one with pincushion distortion, and one with a
            // small picture of odd size.
            ([640, 480], 417.0, [-0.12, 0.02, 0.0005, -0.0003, 0.0]),
            ([640, 480], 380.0, [-0.25, 0.06, -0.002, 0.001, -0.005]),
            ([640, 480], 600.0, [0.3, 0.1, 0.0, 0.002, 0.0]),
            ([131, 9], 90.0, [-0.1, 0.0, 0.001, 0.0, 0.0]),
        ];
        for (size_px, focal_px, distortion) in lenses {
            let lens = Lens { distortion, ..Lens::ideal(size_px, focal_px) };
            let map = LensMap::new(&lens).unwrap();
            let mut times_covered = vec![0; (size_px[0] * size_px[1]) as usize];
            for cell in &map.cells {
                let [first, end] = cell.bounds_px.map(|corner| corner.map(|along| along as u32));
                for pixel in (first[1]..end[1]).flat_map(|v| (first[0]..end[0]).map(move |u| [u, v])) {
                    times_covered[(pixel[1] * size_px[0] + pixel[0]) as usize] += 1;
                    let ray = lens.ray(pixel.map(f64::from)).unwrap();
                    for (axis, place) in place(cell, pixel).into_iter().enumerate() {
                        let true_px = ray[axis] * lens.focal_px[axis] + map.centre_px[axis];
                        assert!(
                            (f64::from(place) - true_px).abs() < 2.5e-3,
                            "{distortion:?} {pixel:?}: {place}, {true_px}"
                        );
                    }
                }
            }
            assert!(times_covered.iter().all(|times| *times == 1), "{distortion:?}");
            assert!(map.cells.len() < 600, "{distortion:?}: {} cells", map.cells.len());
        }
    }
}

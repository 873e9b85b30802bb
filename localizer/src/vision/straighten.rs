//! Straightens an image: resamples an image taken through a distorting lens to the image that a pinhole camera would take.
//!
//! There are two frames, both with u right, v down and (0, 0) the centre of the first pixel: `raw`, that of the image as taken, and `pinhole`, that
//! of a camera of the same size, focal length and principal point without distortion. The raw position of a pinhole's pixel follows directly from
//! Brown and Conrady's formula, and only this direction is used, so that nothing has to be inverted. For a rolling shutter, whose rows are exposed
//! one after the other, the straightened image may also be corrected for motion: to what the pinhole camera would have shown at the time of the
//! image's stamp, if the motion is as estimated.

mod grid;
#[cfg(test)]
#[allow(clippy::expect_used)]
mod tests;

use std::ops::Range;

use image::GrayImage;

use super::{FloorLines, distortion};
use grid::{Grid, Node};
use interval::Interval;

/// Estimated motion of the straightened (pinhole) image during the time from the exposure of one raw row to that of the next.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct RowMotion {
    /// Shift at the middle of the image from one row's exposure to that of the next, to the right and down.
    pub(crate) shift_px: [f64; 2],
    /// Rotation of the robot from one row's exposure to that of the next, counter-clockwise as seen from above; the image turns the opposite way.
    pub(crate) turn_rad: f64,
}

impl RowMotion {
    /// Greatest motion, from row to row, of any pixel of an image of this size.
    fn most_px(&self, size_px: [u32; 2]) -> f64 {
        let reach_px = 0.5 * f64::from(size_px[0]).hypot(f64::from(size_px[1]));
        self.shift_px[0].hypot(self.shift_px[1]) + self.turn_rad.abs() * reach_px
    }
}

/// Straightening of images of one size behind one lens: it knows from which place of the raw image every pixel of the straightened image is taken.
/// The principal point is the middle of the image.
///
/// A lens with pincushion distortion shows less than the pinhole would, and a polynomial may fold back far from the middle. The straightened image is
/// therefore cut, by the same amount on opposite sides, to the greatest rectangle of the same shape that the raw image fills: no pixel is invented,
/// and the border of the straightened image needs no special treatment.
#[derive(Clone, Debug)]
pub(crate) struct Straightening {
    distortion: [f64; 5],
    focal_px: f64,
    rows: RowMotion,
    raw_size_px: [u32; 2],
    /// Number of pixels of the pinhole's image that are left out at the left and at the right, and at the top and at the bottom.
    inset_px: [u32; 2],
    sources: Sources,
}

/// Where the pixels of the straightened image are taken from.
#[derive(Clone, Debug)]
enum Sources {
    /// Source of each pixel, row-major, `height × width`, for a lens whose images are all straightened alike.
    Kept(Vec<Source>),
    /// Positions in the raw image on a grid of nodes, for one image of a rolling shutter: the motion is another one in each image.
    Between(Grid),
}

/// Source of a pixel of the straightened image: a position between four raw pixels.
#[derive(Clone, Copy, Debug)]
struct Source {
    /// Index, in the row-major raw image, of the upper-left one of the four raw pixels from which a pixel of the straightened image is interpolated.
    corner: u32,
    /// Position between four raw pixels from which a pixel is interpolated: distance from the upper-left one towards
    /// its right and its lower neighbour, in 256ths of a pixel.
    towards: [u16; 2],
}

impl Source {
    /// Grey level at the source, interpolated bilinearly between the raw pixels, row-major, with `stride` of them in a row.
    #[inline(always)]
    fn grey(self, pixels: &[u8], stride: usize) -> u8 {
        let corner = self.corner as usize;
        let [right, down] = self.towards.map(u32::from);
        let along = |first: usize| {
            let two = &pixels[first..first + 2];
            u32::from(two[0]) * (256 - right) + u32::from(two[1]) * right
        };
        let sum = along(corner) * (256 - down) + along(corner + stride) * down;
        ((sum + (1 << 15)) >> 16) as u8
    }
}

/// Least factor by which the lens may shrink what the straightened image shows. Below it the polynomial is about to
/// fold back, and one raw pixel would be spread over five.
const LEAST_SLOPE: f64 = 0.2;
/// Greatest image motion from one row of a rolling shutter to the next that is corrected. An image with more motion is not corrected for it, because
/// the correction would stretch the image by as much.
const MOST_ROW_MOTION_PX: f64 = 0.1;

/// Distance from the edges of the raw image within which a place between nodes is looked at by itself.
const SURELY_PX: f64 = 0.5;

/// A position in pixels, in 256ths of a pixel.
fn rounded(at_px: f64) -> u32 {
    (256.0 * at_px.max(0.0) + 0.5) as u32
}

/// A position in 2⁻³² pixels, in 256ths of a pixel.
#[inline(always)]
fn rounded_parts(at: i64) -> u32 {
    ((at + (1 << 23)) >> 24).max(0) as u32
}

impl Straightening {
    /// Prepares the straightening of images of a given size behind a lens with coefficients k1, k2, p1, p2, k3. `rows` is the image motion from the
    /// exposure of one row to that of the next. `None` where nothing needs to be straightened.
    pub(crate) fn new(raw_size_px: [u32; 2], focal_px: f64, distortion: [f64; 5], rows: RowMotion) -> Option<Self> {
        let rows = if rows.most_px(raw_size_px) < MOST_ROW_MOTION_PX { rows } else { RowMotion::default() };
        if distortion == [0.0; 5] && rows == RowMotion::default() {
            return None;
        }
        let inset_px = raw_size_px.map(|size| size / 2);
        let mut lens =
            Straightening { distortion, focal_px, rows, raw_size_px, inset_px, sources: Sources::Kept(Vec::new()) };
        if raw_size_px.iter().any(|&size| size < 2) {
            return Some(lens);
        }
        if rows == RowMotion::default() {
            let whole = Straightening { inset_px: [0, 0], ..lens.clone() };
            lens.inset_px = lens.inset(whole.pixels().filter(|&pixel| !lens.is_shown(&lens.node(pixel), 0.0)));
            lens.sources =
                Sources::Kept(lens.pixels().map(|pixel| lens.source(lens.node(pixel).raw_px.map(rounded))).collect());
        } else {
            let grid = Grid::new(raw_size_px, |pixel| lens.node(pixel));
            lens.inset_px = lens.inset(
                grid.without_source(|node| lens.is_shown(node, 0.0), |node| lens.is_shown(node, SURELY_PX)).into_iter(),
            );
            lens.sources = Sources::Between(grid);
        }
        Some(lens)
    }

    /// Columns and rows of the pinhole's image that are not cut off.
    fn kept_px(&self) -> [Range<u32>; 2] {
        [0, 1].map(|axis| self.inset_px[axis]..self.raw_size_px[axis] - self.inset_px[axis])
    }

    /// Pixels of the straightened image, row by row, in coordinates of the pinhole's image.
    fn pixels(&self) -> impl Iterator<Item = [f64; 2]> + use<> {
        let [columns, rows] = self.kept_px();
        rows.flat_map(move |v| columns.clone().map(move |u| [f64::from(u), f64::from(v)]))
    }

    /// Number of pixels to cut off at each side so that every remaining pixel has a source, given the pixels without one.
    fn inset(&self, without: impl Iterator<Item = [f64; 2]>) -> [u32; 2] {
        let half_px = self.raw_size_px.map(|size| 0.5 * f64::from(size));
        let middle_px = self.middle_px();
        // Distance of a pixel from the middle of the image along one axis, in units of half the image's width or height.
        let share = |axis: usize, at: f64| (at - middle_px[axis]).abs() / half_px[axis];
        let first = without.map(|[u, v]| share(0, u).max(share(1, v))).fold(f64::INFINITY, f64::min);
        [0, 1].map(|axis| {
            let half = self.raw_size_px[axis] / 2;
            (0..half).filter(|&at| share(axis, f64::from(at)) >= first).count() as u32
        })
    }

    /// What a pixel of the pinhole image is taken from.
    fn node(&self, pinhole_px: [f64; 2]) -> Node {
        let pinhole_px = self.at_row(pinhole_px);
        let [a, mixed, b] = distortion::slopes(self.distortion, self.in_focal_lengths(pinhole_px));
        let least_slope = 0.5 * (a + b) - (0.5 * (a - b)).hypot(mixed);
        Node { raw_px: self.raw_px(pinhole_px), least_slope }
    }

    /// Whether the raw image contains the place that a pixel is taken from, at least `inside_px` from its edges, and the lens does not fold (show two
    /// points at one place) there, or anywhere so near.
    fn is_shown(&self, Node { raw_px, least_slope }: &Node, inside_px: f64) -> bool {
        let is_in =
            |axis: usize| (inside_px..=f64::from(self.raw_size_px[axis] - 1) - inside_px).contains(&raw_px[axis]);
        *least_slope > LEAST_SLOPE + 0.1 * inside_px && is_in(0) && is_in(1)
    }

    /// The source at a position in the raw image in 256ths of a pixel. A position on the last raw pixel of a row or column has no neighbour beyond it;
    /// it is interpolated from the pixel before with full weight on the last one.
    #[inline(always)]
    fn source(&self, rounded: [u32; 2]) -> Source {
        let first = [0, 1].map(|axis| (rounded[axis] / 256).min(self.raw_size_px[axis] - 2));
        let towards = [0, 1].map(|axis| (rounded[axis] - 256 * first[axis]).min(256) as u16);
        Source { corner: first[1] * self.raw_size_px[0] + first[0], towards }
    }

    /// The straightened image, interpolated bilinearly; an empty image if the raw image has another size than the one prepared for.
    pub(crate) fn straight(&self, raw: &GrayImage) -> GrayImage {
        if [raw.width(), raw.height()] != self.raw_size_px {
            return GrayImage::default();
        }
        let (pixels, stride) = (raw.as_raw().as_slice(), self.raw_size_px[0] as usize);
        let [columns, rows] = self.kept_px();
        let greys = match &self.sources {
            Sources::Kept(sources) => sources.iter().map(|source| source.grey(pixels, stride)).collect(),
            Sources::Between(grid) => {
                let mut greys = vec![0; columns.len() * rows.len()];
                let mut parts = vec![[0; 2]; columns.len()];
                for (v, row) in rows.clone().zip(greys.chunks_exact_mut(columns.len().max(1))) {
                    grid.places(v, columns.start, &mut parts);
                    for (grey, parts) in row.iter_mut().zip(&parts) {
                        *grey = self.source(parts.map(rounded_parts)).grey(pixels, stride);
                    }
                }
                greys
            }
        };
        GrayImage::from_raw(columns.len() as u32, rows.len() as u32, greys).unwrap_or_default()
    }

    /// Where the pinhole's image shows an object at the time at which the object's row of the raw image is exposed, if it shows the object at
    /// `pinhole_px` at the time of the image's stamp.
    ///
    /// The motion from row to row is much less than a row, so that the result depends little on the row that is assumed at first: three iterations
    /// end below 0.01 px.
    fn at_row(&self, pinhole_px: [f64; 2]) -> [f64; 2] {
        let (RowMotion { shift_px, turn_rad }, mut at) = (self.rows, pinhole_px);
        if self.rows == RowMotion::default() {
            return at;
        }
        let middle_px = self.middle_px();
        // In the frame of a robot that turns by ω, the floor turns by −ω: with v down, a floor point at q from the middle of the image moves by
        // ω·(−v, u).
        let way_px = [
            shift_px[0] - turn_rad * (pinhole_px[1] - middle_px[1]),
            shift_px[1] + turn_rad * (pinhole_px[0] - middle_px[0]),
        ];
        for _ in 0..3 {
            let rows = self.raw_px(at)[1] - middle_px[1];
            at = [0, 1].map(|axis| pinhole_px[axis] + rows * way_px[axis]);
        }
        at
    }

    /// Converts lines found in the straightened image to coordinates of the uncut pinhole image. Each point is placed where the pinhole image shows
    /// it at the time at which its raw row is exposed.
    pub(crate) fn in_pinhole(&self, mut found: FloorLines) -> FloorLines {
        let [left, above] = self.inset_px.map(f64::from);
        let place = |u: f64, v: f64| self.at_row([u + left, v + above]);
        // Undoing the correction of motion stretches the image, row by row, by up to the motion between two rows. Bounds of points are widened by
        // twice that share, because a lens may spread one raw row over more than one row of the straightened image.
        let pull = 1.0 + 2.0 * self.rows.most_px(self.raw_size_px);
        for point in found.lines.iter_mut().flat_map(|line| &mut line.points_px) {
            let [u, v] = place(point[0], point[1]);
            *point = [u, v, point[2] * pull];
        }
        for segment in &mut found.rejected_px {
            let [from, to] = [place(segment[0], segment[1]), place(segment[2], segment[3])];
            *segment = [from[0], from[1], to[0], to[1]];
        }
        found
    }

    /// Pixel of the raw, distorted image that shows what an undistorted image shows at `pinhole_px`.
    pub(crate) fn raw_px(&self, pinhole_px: [f64; 2]) -> [f64; 2] {
        let at = self.in_focal_lengths(pinhole_px);
        let bent = distortion::bend(self.distortion, at);
        let middle_px = self.middle_px();
        [0, 1].map(|axis| self.focal_px * (at[axis] + bent[axis]) + middle_px[axis])
    }

    /// Slopes ∂D/∂x of the lens over a box of the pinhole's image, as [`distortion::slopes`] gives them; `None` where the lens may fold in the box.
    pub(crate) fn slopes_over(&self, pinhole_px: [Interval; 2]) -> Option<[Interval; 3]> {
        let middle_px = self.middle_px();
        let at = [0, 1].map(|axis| (pinhole_px[axis] - middle_px[axis]) / self.focal_px);
        let [a, mixed, b] = distortion::slopes_over(self.distortion, at);
        ((a * b - mixed.sqr()).lo() > 0.0 && a.lo() > 0.0).then_some([a, mixed, b])
    }

    fn middle_px(&self) -> [f64; 2] {
        self.raw_size_px.map(|size| 0.5 * (f64::from(size) - 1.0))
    }

    fn in_focal_lengths(&self, pixel: [f64; 2]) -> [f64; 2] {
        let middle_px = self.middle_px();
        [0, 1].map(|axis| (pixel[axis] - middle_px[axis]) / self.focal_px)
    }
}

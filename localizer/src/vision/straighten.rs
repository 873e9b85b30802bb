//! The picture that a pinhole would take, resampled from the one behind a lens that bends.
//!
//! Frames, both with u right, v down and (0, 0) the centre of the first pixel: `raw`, the picture as taken, and `pinhole`, that of a
//! camera of the same size, focal length and principal point without distortion. Where one is known from the other, it is the
//! raw place of a pinhole's pixel: Brown and Conrady's formula, without any inversion. Where rows are exposed one after the other, the
//! straightened picture may besides be what the pinhole would show at the stamp, if the motion were what it is thought to be.

#[cfg(test)]
#[allow(clippy::expect_used)]
mod tests;

use image::GrayImage;

use super::{FloorLines, distortion};
use interval::Interval;

/// How far the pinhole's picture moves from one raw row's exposure to that of the next, as far as it is known.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct RowMotion {
    /// Right and down, at the middle.
    pub(crate) shift_px: [f64; 2],
    /// Turn of the robot, counter-clockwise seen from above: the picture turns the other way.
    pub(crate) turn_rad: f64,
}

impl RowMotion {
    /// Greatest way of a pixel of a picture of this size.
    fn most_px(&self, size_px: [u32; 2]) -> f64 {
        let reach_px = 0.5 * f64::from(size_px[0]).hypot(f64::from(size_px[1]));
        self.shift_px[0].hypot(self.shift_px[1]) + self.turn_rad.abs() * reach_px
    }
}

/// A lens whose principal point is the middle of the picture, with the source of every pixel of the straightened picture.
///
/// A pincushion shows less than the pinhole would, and a polynomial may fold back far out. The straightened picture is therefore
/// cut, alike on opposite sides, to the greatest rectangle of the same shape that the raw picture fills: no pixel is
/// invented, and its border is a border like any other's.
#[derive(Clone, Debug)]
pub(crate) struct Straightening {
    distortion: [f64; 5],
    focal_px: f64,
    rows: RowMotion,
    raw_size_px: [u32; 2],
    /// Pixels of the pinhole's picture left out at the left and at the right, and above and below.
    inset_px: [u32; 2],
    /// Row-major, `height × width` of the straightened picture.
    sources: Vec<Source>,
}

/// Where a pixel comes from: between four raw ones.
#[derive(Clone, Copy, Debug)]
struct Source {
    /// Index of the upper left one.
    corner: u32,
    /// How far towards its right and its lower neighbour, in 256ths.
    towards: [u16; 2],
}

/// Least factor by which the lens may shrink what the straightened picture shows: beyond it the polynomial is about to fold back,
/// and one raw pixel would be told to be five.
const LEAST_SLOPE: f64 = 0.2;
/// Motion from row to row beyond which a picture is left as its rows took it: taken out, it would stretch the picture by as much.
const MOST_ROW_MOTION_PX: f64 = 0.1;

impl Straightening {
    /// For pictures of a size behind a lens with k1, k2, p1, p2, k3, taken row by row in motion; `None` where nothing is to be straightened.
    pub(crate) fn new(raw_size_px: [u32; 2], focal_px: f64, distortion: [f64; 5], rows: RowMotion) -> Option<Self> {
        let rows = if rows.most_px(raw_size_px) < MOST_ROW_MOTION_PX { rows } else { RowMotion::default() };
        if distortion == [0.0; 5] && rows == RowMotion::default() {
            return None;
        }
        let inset_px = raw_size_px.map(|size| size / 2);
        let mut lens = Straightening { distortion, focal_px, rows, raw_size_px, inset_px, sources: Vec::new() };
        if raw_size_px.iter().all(|&size| size >= 2) {
            lens.inset_px = lens.inset();
            lens.sources = lens.pixels().map(|pixel| lens.source(pixel)).collect();
        }
        Some(lens)
    }

    /// Pixels of the straightened picture row by row, in the pinhole's.
    fn pixels(&self) -> impl Iterator<Item = [f64; 2]> + use<> {
        let [columns, rows] = [0, 1].map(|axis| self.inset_px[axis]..self.raw_size_px[axis] - self.inset_px[axis]);
        rows.flat_map(move |v| columns.clone().map(move |u| [f64::from(u), f64::from(v)]))
    }

    /// What has to be cut so that every pixel left has a source.
    fn inset(&self) -> [u32; 2] {
        let half_px = self.raw_size_px.map(|size| 0.5 * f64::from(size));
        let middle_px = self.middle_px();
        // Distance from the middle in units of the rectangle's own half size.
        let share = |axis: usize, at: f64| (at - middle_px[axis]).abs() / half_px[axis];
        let whole = Straightening { inset_px: [0, 0], sources: Vec::new(), ..*self };
        let without = whole.pixels().filter(|&pixel| !self.is_shown(pixel));
        let first = without.map(|[u, v]| share(0, u).max(share(1, v))).fold(f64::INFINITY, f64::min);
        [0, 1].map(|axis| {
            let half = self.raw_size_px[axis] / 2;
            (0..half).filter(|&at| share(axis, f64::from(at)) >= first).count() as u32
        })
    }

    /// Whether the raw picture shows what a pinhole's pixel would, and the lens does not fold there.
    fn is_shown(&self, pinhole_px: [f64; 2]) -> bool {
        let pinhole_px = self.at_row(pinhole_px);
        let [a, mixed, b] = distortion::slopes(self.distortion, self.in_focal_lengths(pinhole_px));
        let least = 0.5 * (a + b) - (0.5 * (a - b)).hypot(mixed);
        let raw_px = self.raw_px(pinhole_px);
        least > LEAST_SLOPE && (0..2).all(|axis| (0.0..=f64::from(self.raw_size_px[axis] - 1)).contains(&raw_px[axis]))
    }

    fn source(&self, pinhole_px: [f64; 2]) -> Source {
        let raw_px = self.raw_px(self.at_row(pinhole_px));
        // The last pixel has no neighbour beyond it: it is wholly towards that of the one before.
        let first = [0, 1].map(|axis| (raw_px[axis].max(0.0) as u32).min(self.raw_size_px[axis] - 2));
        let towards =
            [0, 1].map(|axis| (256.0 * (raw_px[axis] - f64::from(first[axis]))).round().clamp(0.0, 256.0) as u16);
        Source { corner: first[1] * self.raw_size_px[0] + first[0], towards }
    }

    /// The straightened picture, interpolated bilinearly; an empty one for a picture of another size than the lens is for.
    pub(crate) fn straight(&self, raw: &GrayImage) -> GrayImage {
        if [raw.width(), raw.height()] != self.raw_size_px {
            return GrayImage::default();
        }
        let (pixels, stride) = (raw.as_raw(), self.raw_size_px[0] as usize);
        let grey = |source: &Source| {
            let corner = source.corner as usize;
            let [right, down] = source.towards.map(u32::from);
            let along = |first: usize| u32::from(pixels[first]) * (256 - right) + u32::from(pixels[first + 1]) * right;
            let sum = along(corner) * (256 - down) + along(corner + stride) * down;
            ((sum + (1 << 15)) >> 16) as u8
        };
        let [width, height] = [0, 1].map(|axis| self.raw_size_px[axis] - 2 * self.inset_px[axis]);
        GrayImage::from_raw(width, height, self.sources.iter().map(grey).collect()).unwrap_or_default()
    }

    /// Where the pinhole's picture shows, when the raw row that shows it is exposed, what it shows here at the stamp.
    ///
    /// The motion from row to row is small beside a row, so that the row found for a place hardly moves it: three steps end below 0.01 px.
    fn at_row(&self, pinhole_px: [f64; 2]) -> [f64; 2] {
        let (RowMotion { shift_px, turn_rad }, mut at) = (self.rows, pinhole_px);
        if self.rows == RowMotion::default() {
            return at;
        }
        let middle_px = self.middle_px();
        // The floor turns by −ω in the frame of a robot that turns by ω: with v down, q from the middle moves by ω·(−v, u).
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

    /// Lines found in the straightened picture in the pixels of the whole pinhole's, each point where that shows it when its row is exposed.
    pub(crate) fn in_pinhole(&self, mut found: FloorLines) -> FloorLines {
        let [left, above] = self.inset_px.map(f64::from);
        let place = |u: f64, v: f64| self.at_row([u + left, v + above]);
        // A row's motion is by how much neighbouring rows are pulled apart; twice that, for a lens that shows a row as more than one.
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

    /// The pixel of the raw, distorted picture that shows what a picture without distortion shows at `pinhole_px`.
    pub(crate) fn raw_px(&self, pinhole_px: [f64; 2]) -> [f64; 2] {
        let at = self.in_focal_lengths(pinhole_px);
        let bent = distortion::bend(self.distortion, at);
        let middle_px = self.middle_px();
        [0, 1].map(|axis| self.focal_px * (at[axis] + bent[axis]) + middle_px[axis])
    }

    /// ∂D/∂x over a box of the pinhole's picture, as [`distortion::slopes`] gives it; `None` where the lens may fold in it.
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

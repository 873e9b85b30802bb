//! The picture that a pinhole would take, resampled from the one behind a lens that bends.
//!
//! Frames, both with u right, v down and (0, 0) the centre of the first pixel: `raw`, the picture as taken, and `pinhole`, that of a
//! camera of the same size, focal length and principal point without distortion. Where one is known from the other, it is the
//! raw place of a pinhole's pixel: Brown and Conrady's formula, without any inversion.

use image::GrayImage;

use super::{FloorLines, distortion};

/// A lens whose principal point is the middle of the picture, with the source of every pixel of the straightened picture.
///
/// A pincushion shows less than the pinhole would, and a polynomial may fold back far out. The straightened picture is therefore
/// cut, alike on opposite sides, to the greatest rectangle of the same shape that the raw picture fills: no pixel is
/// invented, and its border is a border like any other's.
#[derive(Clone, Debug)]
pub(crate) struct Straightening {
    distortion: [f64; 5],
    focal_px: f64,
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

impl Straightening {
    /// For pictures of a size behind a lens with k1, k2, p1, p2, k3; `None` for one that does not bend.
    pub(crate) fn new(raw_size_px: [u32; 2], focal_px: f64, distortion: [f64; 5]) -> Option<Self> {
        if distortion == [0.0; 5] {
            return None;
        }
        let mut lens = Straightening {
            distortion,
            focal_px,
            raw_size_px,
            inset_px: raw_size_px.map(|size| size / 2),
            sources: Vec::new(),
        };
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
        let [a, mixed, b] = distortion::slopes(self.distortion, self.in_focal_lengths(pinhole_px));
        let least = 0.5 * (a + b) - (0.5 * (a - b)).hypot(mixed);
        let raw_px = self.raw_px(pinhole_px);
        least > LEAST_SLOPE && (0..2).all(|axis| (0.0..=f64::from(self.raw_size_px[axis] - 1)).contains(&raw_px[axis]))
    }

    fn source(&self, pinhole_px: [f64; 2]) -> Source {
        let raw_px = self.raw_px(pinhole_px);
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

    /// Lines found in the straightened picture in the pixels of the whole pinhole's.
    pub(crate) fn in_pinhole(&self, mut found: FloorLines) -> FloorLines {
        let [left, above] = self.inset_px.map(f64::from);
        for point in found.lines.iter_mut().flat_map(|line| &mut line.points_px) {
            *point = [point[0] + left, point[1] + above, point[2]];
        }
        for [u0, v0, u1, v1] in &mut found.rejected_px {
            (*u0, *v0, *u1, *v1) = (*u0 + left, *v0 + above, *u1 + left, *v1 + above);
        }
        found
    }

    /// Where the raw picture shows what a pinhole's shows here.
    pub(crate) fn raw_px(&self, pinhole_px: [f64; 2]) -> [f64; 2] {
        let at = self.in_focal_lengths(pinhole_px);
        let bent = distortion::bend(self.distortion, at);
        let middle_px = self.middle_px();
        [0, 1].map(|axis| self.focal_px * (at[axis] + bent[axis]) + middle_px[axis])
    }

    /// Pixels of the pinhole's picture across a line with this unit normal that one raw pixel across the line's image is.
    ///
    /// With the symmetric J = ∂D/∂x, a raw step e is the step J⁻¹e, and n·J⁻¹e is at most |J⁻¹n| for |e| = 1.
    pub(crate) fn stretch_across(&self, pinhole_px: [f64; 2], normal: [f64; 2]) -> f64 {
        let [u, v] = self.unbent(self.in_focal_lengths(pinhole_px), normal);
        u.hypot(v)
    }

    /// The way that a point moves in the pinhole's picture, per share of the focal length, when the lens has another focal length than
    /// the straightening believes and the raw picture is the same: with f·D(x) held, ∂(f·x)/∂ln f = f·(x − J⁻¹D(x)).
    pub(crate) fn focal_shift_px(&self, pinhole_px: [f64; 2]) -> [f64; 2] {
        let at = self.in_focal_lengths(pinhole_px);
        let bent = distortion::bend(self.distortion, at);
        let back = self.unbent(at, [at[0] + bent[0], at[1] + bent[1]]);
        [0, 1].map(|axis| self.focal_px * (at[axis] - back[axis]))
    }

    /// J⁻¹ times a vector.
    fn unbent(&self, at: [f64; 2], [u, v]: [f64; 2]) -> [f64; 2] {
        let [a, mixed, b] = distortion::slopes(self.distortion, at);
        let determinant = a * b - mixed * mixed;
        [(b * u - mixed * v) / determinant, (a * v - mixed * u) / determinant]
    }

    fn middle_px(&self) -> [f64; 2] {
        self.raw_size_px.map(|size| 0.5 * (f64::from(size) - 1.0))
    }

    fn in_focal_lengths(&self, pixel: [f64; 2]) -> [f64; 2] {
        let middle_px = self.middle_px();
        [0, 1].map(|axis| (pixel[axis] - middle_px[axis]) / self.focal_px)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SIZE_PX: [u32; 2] = [641, 481];

    fn lens(distortion: [f64; 5]) -> Straightening {
        Straightening::new(SIZE_PX, 400.0, distortion).unwrap_or_else(|| panic!("a lens that bends"))
    }

    fn close(a: [f64; 2], b: [f64; 2]) -> bool {
        (a[0] - b[0]).hypot(a[1] - b[1]) < 1e-9
    }

    #[test]
    fn a_barrel_shows_a_place_nearer_to_the_middle() {
        // By hand, at (x, y) = (0.5, −0.4), r² = 0.41: k1 = −0.2 leaves 1 − 0.082 = 0.918 of the distance.
        assert!(close(
            lens([-0.2, 0.0, 0.0, 0.0, 0.0]).raw_px([520.0, 80.0]),
            [320.0 + 200.0 * 0.918, 240.0 - 160.0 * 0.918]
        ));
        // k2 = 0.1 and k3 = 0.1 add 0.1·(0.1681 + 0.068921) = 0.0237021.
        assert!(close(
            lens([0.0, 0.1, 0.0, 0.0, 0.1]).raw_px([520.0, 80.0]),
            [320.0 + 200.0 * 1.0237021, 240.0 - 160.0 * 1.0237021]
        ));
        // p1 = 0.01: u by 400·0.02·0.5·(−0.4) = −1.6, v by 400·0.01·(0.41 + 2·0.16) = 2.92; p2 = 0.01: u by 400·0.01·(0.41 + 0.5) = 3.64.
        assert!(close(lens([0.0, 0.0, 0.01, 0.0, 0.0]).raw_px([520.0, 80.0]), [518.4, 82.92]));
        assert!(close(lens([0.0, 0.0, 0.0, 0.01, 0.0]).raw_px([520.0, 80.0]), [523.64, 78.4]));
    }

    #[test]
    fn a_straightened_picture_shows_what_the_raw_one_shows_at_its_source() {
        // A ramp along each axis tells where a pixel comes from.
        for (axis, per_px) in [(0, 0.3), (1, 0.5)] {
            let ramp = GrayImage::from_fn(SIZE_PX[0], SIZE_PX[1], |u, v| {
                image::Luma([(5.0 + per_px * f64::from([u, v][axis])).round() as u8])
            });
            let lens = lens([-0.25, 0.06, 0.001, -0.001, 0.0]);
            let straight = lens.straight(&ramp);
            assert_eq!(straight.dimensions(), (641, 481), "a barrel fills the whole picture");
            for (u, v, grey) in straight.enumerate_pixels() {
                let expected = 5.0 + per_px * lens.raw_px([f64::from(u), f64::from(v)])[axis];
                assert!((f64::from(grey[0]) - expected).abs() < 1.01, "{u} {v} {grey:?} {expected}");
            }
        }
    }

    #[test]
    fn a_pincushion_leaves_out_what_the_raw_picture_does_not_show() {
        let lens = lens([0.12, 0.0, 0.0, 0.0, 0.0]);
        let straight = lens.straight(&GrayImage::from_pixel(641, 481, image::Luma([100])));
        let inset = lens.inset_px;
        assert_eq!([straight.width(), straight.height()], [641 - 2 * inset[0], 481 - 2 * inset[1]]);
        // By hand: the corner (0.8, 0.6)·s is cut where s·(1 + 0.12·s²) = 1, s = 0.9041, of which the pixel before is left.
        let kept = [0, 1].map(|axis| 1.0 - f64::from(inset[axis]) / [320.5, 240.5][axis]);
        assert!(kept.iter().all(|kept| (kept - 0.9041).abs() < 0.01), "{kept:?}");
        assert!(lens.pixels().all(|pixel| lens.is_shown(pixel)));
        let point = FloorLines {
            lines: vec![crate::vision::FloorLine { points_px: vec![[1.0, 2.0, 0.3]], share_wrong: 0.0, family: 0 }],
            rejected_px: vec![[0.0, 0.0, 5.0, 6.0]],
        };
        let [left, above] = inset.map(f64::from);
        let moved = lens.in_pinhole(point);
        assert_eq!(moved.lines[0].points_px, [[1.0 + left, 2.0 + above, 0.3]]);
        assert_eq!(moved.rejected_px, [[left, above, 5.0 + left, 6.0 + above]]);
    }

    #[test]
    fn a_lens_that_folds_back_is_cut_before_it_does() {
        // D' = 1 − 1.8·r² is 0.2 at r = 2/3, 267 px: a third of the way to the corner is left out.
        let lens = lens([-0.6, 0.0, 0.0, 0.0, 0.0]);
        assert!(lens.pixels().all(|[u, v]| (u - 320.0).hypot(v - 240.0) <= 267.0));
        assert!(lens.pixels().count() > 400 * 300);
        // Nothing at all is left of a lens that folds in its middle, and of another size than its own it makes nothing.
        assert_eq!(lens.straight(&GrayImage::new(640, 480)).dimensions(), (0, 0));
        assert!(Straightening::new([1, 1], 400.0, [0.1; 5]).is_some());
        assert!(Straightening::new(SIZE_PX, 400.0, [0.0; 5]).is_none());
    }

    #[test]
    fn stretch_is_how_far_apart_two_lines_are_whose_images_are_a_pixel_apart() {
        let lens = lens([-0.25, 0.06, 0.001, -0.002, 0.01]);
        for (at, angle_rad) in
            [([100.0, 50.0], 0.3_f64), ([600.0, 300.0], 1.2), ([320.0, 240.0], 2.0), ([30.0, 470.0], -0.7)]
        {
            let normal: [f64; 2] = [angle_rad.cos(), angle_rad.sin()];
            // Images of a line through the place, and of one a hundredth of a pixel beside it: their distance by points on both.
            let image = |across: f64, along: f64| {
                lens.raw_px([
                    at[0] + across * normal[0] - along * normal[1],
                    at[1] + across * normal[1] + along * normal[0],
                ])
            };
            let nearest = (-4000..4000).map(|step| {
                let [here, there] = [image(0.0, 0.0), image(0.01, f64::from(step) * 1e-5)];
                (there[0] - here[0]).hypot(there[1] - here[1])
            });
            let apart_px = nearest.fold(f64::MAX, f64::min);
            let stretch = lens.stretch_across(at, normal);
            assert!((0.01 / apart_px / stretch - 1.0).abs() < 1e-3, "{at:?}: {} {stretch}", 0.01 / apart_px);
        }
    }

    #[test]
    fn another_focal_length_shifts_a_straightened_point_by_what_is_told() {
        let distortion = [-0.25, 0.06, 0.001, -0.002, 0.01];
        let (believed, share) = (lens(distortion), 1e-4);
        let true_one = Straightening { focal_px: 400.0 * (1.0 + share), ..lens(distortion) };
        for pinhole_px in [[100.0, 50.0], [600.0, 300.0], [400.0, 200.0]] {
            // The believed place with the same raw pixel, by Newton's steps.
            let (raw_px, mut at) = (true_one.raw_px(pinhole_px), pinhole_px);
            for _ in 0..20 {
                let seen = believed.raw_px(at);
                let step = believed.unbent(believed.in_focal_lengths(at), [raw_px[0] - seen[0], raw_px[1] - seen[1]]);
                at = [at[0] + step[0], at[1] + step[1]];
            }
            let told_px = believed.focal_shift_px(pinhole_px).map(|shift| -share * shift);
            let off_px = [0, 1].map(|axis| at[axis] - pinhole_px[axis] - told_px[axis]);
            assert!(off_px[0].hypot(off_px[1]) < 1e-2 * told_px[0].hypot(told_px[1]), "{pinhole_px:?}");
        }
    }
}

//! An upright box of the building: a piece of furniture, a door leaf, a frame.

use nalgebra::{Point3, Vector3, vector};

use super::{Material, Panel, Part, Texture, level, raised};
use crate::scene::Furniture;

/// Distance from a box up to which a panel (a flat rectangle of the building) counts as touching the box.
const TOUCH_M: f64 = 1e-4;

/// A box with vertical sides.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct UprightBox {
    /// World x and y of the middle of the box.
    pub middle_m: [f64; 2],
    /// Direction of the box's length, measured from world x.
    pub heading_rad: f64,
    /// Length of the box along its heading, and width across.
    pub size_m: [f64; 2],
    /// Heights of the lower and the upper face of the box.
    pub between_m: [f64; 2],
    /// Material of the box.
    pub material: Material,
}

impl From<&Furniture> for UprightBox {
    fn from(piece: &Furniture) -> UprightBox {
        let plain = Material::matt(piece.albedo).glossy(piece.gloss, piece.roughness_deg.to_radians());
        UprightBox {
            middle_m: [piece.x_m, piece.y_m],
            heading_rad: piece.rotation_deg.to_radians(),
            size_m: piece.size_m,
            between_m: [0.0, piece.height_m],
            material: piece.books.map_or(plain, |seed| Material { seed, ..plain.with(Texture::Books) }),
        }
    }
}

impl UprightBox {
    /// Middle of the box, world frame.
    pub fn middle(&self) -> Point3<f64> {
        raised(self.middle_m, (self.between_m[0] + self.between_m[1]) / 2.0)
    }

    /// Corners of the upright box: the four of its lower face in order, then those of its upper face.
    pub fn corners(&self) -> [Point3<f64>; 8] {
        let [half_length, half_width] = self.half_sides();
        std::array::from_fn(|index| {
            let (s, t) = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)][index % 4];
            raised(self.middle_m, self.between_m[index / 4]) + half_length * s + half_width * t
        })
    }

    fn half_sides(&self) -> [Vector3<f64>; 2] {
        let ahead = level(self.heading_rad);
        [ahead * (self.size_m[0] / 2.0), vector![-ahead.y, ahead.x, 0.0] * (self.size_m[1] / 2.0)]
    }

    /// Faces of the box. A box that stands on the floor has no lower face.
    pub fn panels(&self, room: usize) -> Vec<Panel> {
        let corners = self.corners();
        let height = vector![0.0, 0.0, self.between_m[1] - self.between_m[0]];
        let face = |corner: Point3<f64>, along: Vector3<f64>, up: Vector3<f64>, material: Material| Panel {
            corner,
            along,
            up,
            material,
            part: Part::Thing,
            room,
            outline: None,
        };
        let upright = |side: usize| corners[(side + 1) % 4] - corners[side];
        let mut faces: Vec<Panel> =
            (0..4).map(|side| face(corners[side], upright(side), height, self.material)).collect();
        // Books stand in upright faces alone.
        let is_of_books = self.material.texture == Texture::Books;
        let level = if is_of_books { self.material.with(Texture::Plain) } else { self.material };
        faces.push(face(corners[4], corners[5] - corners[4], corners[7] - corners[4], level));
        if self.between_m[0] > 0.0 {
            faces.push(face(corners[0], corners[3] - corners[0], corners[1] - corners[0], level));
        }
        faces
    }

    /// The two boxes into which a cut along the middle of its length divides this box, each half as wide.
    pub fn halves(&self) -> [UprightBox; 2] {
        let [_, half_width] = self.half_sides();
        [-0.5, 0.5].map(|share| {
            let aside = half_width * share;
            UprightBox {
                middle_m: [self.middle_m[0] + aside.x, self.middle_m[1] + aside.y],
                size_m: [self.size_m[0], self.size_m[1] / 2.0],
                ..*self
            }
        })
    }

    /// Whether the box hides the whole of a panel (a flat rectangle of the building) that touches it.
    pub fn hides(&self, panel: &Panel) -> bool {
        let before = panel.along.cross(&panel.up).normalize() * TOUCH_M;
        let middle = panel.corner + (panel.along + panel.up) / 2.0;
        panel.corners().iter().all(|corner| {
            let inwards = (middle - corner).normalize() * TOUCH_M;
            self.contains(corner + before + inwards)
        })
    }

    /// Whether a point is inside the box.
    #[inline]
    pub fn contains(&self, at: Point3<f64>) -> bool {
        BoxFrame::of(self).contains(at)
    }
}

/// An upright box with its corners and its own frame, computed once for the many lines of sight that a light map follows.
#[derive(Clone, Copy, Debug)]
pub(crate) struct BoxFrame {
    /// Corners of the box, in the order of [`UprightBox::corners`].
    pub(crate) corners: [Point3<f64>; 8],
    /// Least and greatest coordinates of the corners.
    low: Point3<f64>,
    high: Point3<f64>,
    middle: Point3<f64>,
    /// Half of the box's length, width and height.
    half_m: [f64; 3],
    /// Half of the box's length, and the square of its norm.
    along: (Vector3<f64>, f64),
    /// Half of the box's width, and the square of its norm.
    across: (Vector3<f64>, f64),
    height_m: f64,
    /// Square of a distance from the middle that no point of the box exceeds.
    reach_m2: f64,
}

impl BoxFrame {
    pub(crate) fn of(piece: &UprightBox) -> BoxFrame {
        let [along, across] = piece.half_sides();
        let height_m = piece.between_m[1] - piece.between_m[0];
        let corner_m2 = along.norm_squared() + across.norm_squared() + height_m * height_m / 4.0;
        let corners = piece.corners();
        BoxFrame {
            corners,
            low: corners.iter().fold(corners[0], |low, corner| low.inf(corner)),
            high: corners.iter().fold(corners[0], |high, corner| high.sup(corner)),
            middle: piece.middle(),
            half_m: [0.5 * piece.size_m[0], 0.5 * piece.size_m[1], 0.5 * height_m],
            along: (along, along.norm_squared()),
            across: (across, across.norm_squared()),
            height_m,
            // The share is for rounding: what lies in the box by its coordinates is never farther than this.
            reach_m2: 1.000_001 * corner_m2,
        }
    }

    /// Whether an upright box with the given least and greatest coordinates meets this one's least and greatest coordinates.
    #[inline]
    pub(crate) fn reaches(&self, low: Point3<f64>, high: Point3<f64>) -> bool {
        (0..3).all(|axis| self.low[axis] <= high[axis] && self.high[axis] >= low[axis])
    }

    /// Whether the straight line between two points passes through the box (slab method).
    #[inline]
    pub(crate) fn meets(&self, from: Point3<f64>, to: Point3<f64>) -> bool {
        if self.is_passed_by(from, to) {
            return false;
        }
        self.within(from, to, 0.0).is_some()
    }

    /// Whether a straight line between two points may pass through the box, of which is known only that they are no farther from `ends` than
    /// `radii_m`.
    ///
    /// At each share of its way, such a line is no farther from the line between the ends than the mean of the radii by that share.
    pub(crate) fn may_meet(&self, ends: [Point3<f64>; 2], radii_m: [f64; 2]) -> bool {
        let [from, to] = ends;
        let greatest_m = radii_m[0].max(radii_m[1]);
        if self.square_to(from, to) > (self.reach_m2.sqrt() + greatest_m).powi(2) {
            return false;
        }
        let Some([enter, leave]) = self.within(from, to, greatest_m) else { return false };
        let radius_m = |share: f64| radii_m[0] * (1.0 - share) + radii_m[1] * share;
        self.within(from, to, radius_m(enter).max(radius_m(leave))).is_some()
    }

    /// The part of the straight line between two points that is in the box, or less than `margin_m` outside of its sides, by its share of the way
    /// (slab method).
    #[inline]
    fn within(&self, from: Point3<f64>, to: Point3<f64>, margin_m: f64) -> Option<[f64; 2]> {
        let (start, end) = (self.coordinates(from), self.coordinates(to));
        let (mut enter, mut leave) = (0.0_f64, 1.0_f64);
        for axis in 0..3 {
            let way = end[axis] - start[axis];
            let side = if margin_m > 0.0 { 1.0 + margin_m / self.half_m[axis] } else { 1.0 };
            if way.abs() < 1e-12 {
                if start[axis].abs() >= side {
                    return None;
                }
                continue;
            }
            let (one, other) = ((-side - start[axis]) / way, (side - start[axis]) / way);
            enter = enter.max(one.min(other));
            leave = leave.min(one.max(other));
            if enter >= leave {
                return None;
            }
        }
        Some([enter, leave])
    }

    /// Whether a point is inside the box.
    #[inline]
    pub(crate) fn contains(&self, at: Point3<f64>) -> bool {
        (at - self.middle).norm_squared() <= self.reach_m2
            && self.coordinates(at).iter().all(|coordinate| coordinate.abs() < 1.0)
    }

    /// Whether the straight line between two points keeps out of the ball around the box. Most lines do, and this costs a single division.
    #[inline]
    fn is_passed_by(&self, from: Point3<f64>, to: Point3<f64>) -> bool {
        self.square_to(from, to) > self.reach_m2
    }

    /// Square of the distance of the box's middle from the straight line between two points.
    #[inline]
    fn square_to(&self, from: Point3<f64>, to: Point3<f64>) -> f64 {
        let (way, to_middle) = (to - from, self.middle - from);
        let share = (to_middle.dot(&way) / way.norm_squared()).clamp(0.0, 1.0);
        (to_middle - way * share).norm_squared()
    }

    /// Coordinates of a point in the box's own frame, in which each coordinate runs from −1 to 1 inside the box.
    #[inline]
    fn coordinates(&self, at: Point3<f64>) -> [f64; 3] {
        let from_middle = at - self.middle;
        let (along, along_m2) = &self.along;
        let (across, across_m2) = &self.across;
        [from_middle.dot(along) / along_m2, from_middle.dot(across) / across_m2, from_middle.z * 2.0 / self.height_m]
    }
}

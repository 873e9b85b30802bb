//! Dot-matrix markers in an infrared picture of the ceiling (paper 5, sections 4.1 and 4.2).
//!
//! There are two chains: this project's own reads all markers in view, with an error bound for every dot; that of the paper reads the
//! marker nearest to the middle of the image.
//!
//! ```text
//! dots:    local threshold ──> components ──> area, aspect ──> weighted centroids with bounds ──┐
//!                                                                                               v
//! lens:    where a pinhole would show them <────────────────────────────────────────────────────┤
//!                                                                                               v
//! marker:  corner triples ──> grid ──> every dot on it, every empty place dark ──> identity ──> SeenMarker
//! paper:   threshold 200 ──> area, aspect ──> erosion, dilation ──> nearest ──> AND ──> O, A, B ──> identity
//! ```

mod clipping;
mod components;
pub mod confidence;
pub mod dots;
mod lens;
pub mod marker;
pub mod paper;

#[cfg(test)]
pub(crate) mod synthetic;
#[cfg(test)]
#[allow(clippy::expect_used)]
pub(crate) mod trial;

pub use lens::Lens;

use crate::markers::{DOT_RADIUS_M, GridPlace, MarkerId};
use lens::Bend;

/// What the localizer is given about the ceiling camera and its view of the markers: declared bounds and nominal values, not the true ones.
#[derive(Clone, Debug, PartialEq)]
pub struct CeilingView {
    /// Least and greatest radius of the image of a marker's dot, as a pinhole would show it.
    pub dot_radius_px: [f64; 2],
    /// Focal length of the camera, in pixels.
    pub focal_px: f64,
    /// Tangent of the greatest angle between the ceiling camera's optical axis and the vertical.
    pub lean: f64,
    /// Least number of photoelectrons per grey level; it determines how much shot noise a dot's own light adds.
    pub electrons_per_grey: f64,
    /// The lens; `None` for one that shows what a pinhole shows.
    pub lens: Option<Lens>,
}

/// Share by which a dot's image may be smaller or larger than straight above an upright camera, besides what the camera's lean adds.
const OBLIQUE: f64 = 0.1;

impl CeilingView {
    /// The declared view of a camera with this focal length, whose optical centre is between `distance_m[0]` and `distance_m[1]` below the markers.
    pub fn new(focal_px: f64, distance_m: [f64; 2], lean: f64, electrons_per_grey: f64) -> CeilingView {
        // A dot that is seen obliquely appears a little smaller or larger.
        let radius_px = |distance_m: f64, slack: f64| slack * focal_px * DOT_RADIUS_M / distance_m;
        let slack = OBLIQUE + lean;
        let dot_radius_px = [radius_px(distance_m[1], 1.0 - slack), radius_px(distance_m[0], 1.0 + slack)];
        CeilingView { dot_radius_px, focal_px, lean, electrons_per_grey, lens: None }
    }

    /// The same view through a lens that distorts it.
    pub fn behind(self, lens: Lens) -> CeilingView {
        CeilingView { lens: (lens.distortion != [0.0; 5]).then_some(lens), ..self }
    }

    /// What the lens does about a place of the picture as taken; `None` where the lens folds.
    fn about(&self, raw_px: [f64; 2]) -> Option<Bend> {
        match &self.lens {
            Some(lens) => lens.about(raw_px),
            None => Some(Bend { pinhole_px: raw_px, stretch: [1.0; 2] }),
        }
    }

    /// Where the picture as taken shows what a pinhole would show at a place.
    fn bent_px(&self, pinhole_px: [f64; 2]) -> [f64; 2] {
        self.lens.map_or(pinhole_px, |lens| lens.bent_px(pinhole_px))
    }

    /// Greatest factor by which the lens stretches a short way anywhere in a picture of this size.
    fn greatest_stretch(&self, [width, height]: [f64; 2]) -> f64 {
        const N_SIDE: usize = 9;
        let share = |index: usize| index as f64 / (N_SIDE - 1) as f64;
        let places = (0..N_SIDE * N_SIDE).map(|place| [width * share(place % N_SIDE), height * share(place / N_SIDE)]);
        places.filter_map(|at_px| self.about(at_px)).map(|bend| bend.stretch[1]).fold(1.0, f64::max)
    }

    /// Greatest radius of the image of a dot straight above an upright camera.
    pub fn greatest_upright_radius_px(&self) -> f64 {
        self.dot_radius_px[1] / (1.0 + OBLIQUE + self.lean)
    }
}

/// Motion of the image over the exposure: a shift, and a rotation about a given point of the image.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PictureMotion {
    /// Shift of the image over the exposure, at the point that the rotation leaves in place.
    pub shift_px: [f64; 2],
    /// Rotation of the image over the exposure, positive from u towards −v.
    pub turn_rad: f64,
    /// Point of the image about which the image turns.
    pub about_px: [f64; 2],
}

impl PictureMotion {
    /// Motion of a given point of the image over the exposure.
    pub fn at(&self, [u, v]: [f64; 2]) -> [f64; 2] {
        let (du, dv) = (u - self.about_px[0], v - self.about_px[1]);
        [self.shift_px[0] + self.turn_rad * dv, self.shift_px[1] - self.turn_rad * du]
    }
}

/// A bright dot that was found in the image.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Dot {
    /// Claimed position of the image of a marker dot's centre, `[u, v]`.
    pub centre_px: [f64; 2],
    /// Claimed greatest error of a marker dot's position, along u and along v alike.
    pub bound_px: f64,
    /// Radius of a disc with the same area as the dot in the image.
    pub radius_px: f64,
    /// Grey level of the dot's middle above its surroundings.
    pub level: f64,
    /// Sum of the dot's grey levels above its surroundings.
    pub flux: f64,
    /// Number of the dot's pixels that are clipped at white.
    pub clipped_px: f64,
}

/// A marker that was read from an image.
#[derive(Clone, Debug, PartialEq)]
pub struct SeenMarker {
    /// Identity that the marker's coded dots spell.
    pub id: MarkerId,
    /// All dots of the marker, with their places on its grid.
    pub dots: Vec<(GridPlace, Dot)>,
    /// Confidence P(S) of the marker by Eq. (3) of paper 5, computed from its grey levels.
    pub confidence: f64,
}

/// Markers that were found in one image.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct CeilingMarkers {
    /// Markers that were read and whose identity is one of those in use.
    pub markers: Vec<SeenMarker>,
    /// Dot patterns that looked like a marker's grid and were rejected, for debug frames: each a line `[u0, v0, u1, v1]` from corner dot X to corner
    /// dot Y, the ends of the pattern's diagonal.
    pub rejected_px: Vec<[f64; 4]>,
}

impl SeenMarker {
    /// Middle between the marker's corner dots X and Y, which is the middle of its grid.
    pub fn centre_px(&self) -> [f64; 2] {
        let corner =
            |place: GridPlace| self.dots.iter().find(|(other, _)| *other == place).map(|(_, dot)| dot.centre_px);
        match (corner([3, 0]), corner([0, 3])) {
            (Some(x), Some(y)) => [0, 1].map(|axis| 0.5 * (x[axis] + y[axis])),
            _ => [f64::NAN; 2],
        }
    }
}

/// Of the given markers, the one nearest to a point of the image (Eq. 1 of paper 5).
pub fn nearest(markers: &[SeenMarker], to_px: [f64; 2]) -> Option<&SeenMarker> {
    let distance = |marker: &SeenMarker| {
        let [u, v] = marker.centre_px();
        (u - to_px[0]).hypot(v - to_px[1])
    };
    markers.iter().min_by(|a, b| distance(a).total_cmp(&distance(b)))
}

/// Reads all markers of an image. `is_word` says for each of the 4096 possible identities whether it is in use.
pub fn detect(
    image: &image::GrayImage,
    view: &CeilingView,
    is_word: &[bool],
    motion: &PictureMotion,
) -> CeilingMarkers {
    let dots = dots::detect(image, view, motion);
    marker::read(image, &dots, view, is_word)
}

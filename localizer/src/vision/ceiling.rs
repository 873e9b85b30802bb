//! Dot-matrix markers in an infrared picture of the ceiling (paper 5, sections 4.1 and 4.2).
//!
//! Two chains, as for the floor: ours reads all markers in view, with a bound for every dot; the paper's reads the one nearest to the middle.
//!
//! ```text
//! dots:    local threshold ──> components ──> area, aspect ──> weighted centroids with bounds ──┐
//!                                                                                               v
//! marker:  corner triples ──> grid ──> every dot on it, every empty place dark ──> identity ──> SeenMarker
//! paper:   threshold 200 ──> area, aspect ──> erosion, dilation ──> nearest ──> AND ──> O, A, B ──> identity
//! ```

mod components;
pub mod confidence;
pub mod dots;
pub mod marker;
pub mod paper;

#[cfg(test)]
pub(crate) mod synthetic;
#[cfg(test)]
#[allow(clippy::expect_used)]
pub(crate) mod trial;

use crate::markers::{DOT_RADIUS_M, GridPlace, MarkerId};

/// What is declared of a picture of the ceiling.
#[derive(Clone, Debug, PartialEq)]
pub struct CeilingView {
    /// Radius of a dot's image: least and greatest.
    pub dot_radius_px: [f64; 2],
    /// Focal length.
    pub focal_px: f64,
    /// Tangent of the greatest angle between the optical axis and the vertical.
    pub lean: f64,
    /// Photoelectrons of one step of grey level, at least: how much noise a dot's own light brings.
    pub electrons_per_grey: f64,
}

impl CeilingView {
    /// For a camera of this focal length, whose optical centre is so far below the markers.
    pub fn new(focal_px: f64, distance_m: [f64; 2], lean: f64, electrons_per_grey: f64) -> CeilingView {
        // Seen obliquely a dot is a little smaller or larger.
        let radius_px = |distance_m: f64, slack: f64| slack * focal_px * DOT_RADIUS_M / distance_m;
        let slack = 0.1 + lean;
        let dot_radius_px = [radius_px(distance_m[1], 1.0 - slack), radius_px(distance_m[0], 1.0 + slack)];
        CeilingView { dot_radius_px, focal_px, lean, electrons_per_grey }
    }
}

/// Motion of the picture over the exposure.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PictureMotion {
    /// Shift at the point about which it turns.
    pub shift_px: [f64; 2],
    /// Turn from u towards −v, and the point about which it turns.
    pub turn_rad: f64,
    /// That point.
    pub about_px: [f64; 2],
}

impl PictureMotion {
    /// Motion of one point of the picture.
    pub fn at(&self, [u, v]: [f64; 2]) -> [f64; 2] {
        let (du, dv) = (u - self.about_px[0], v - self.about_px[1]);
        [self.shift_px[0] + self.turn_rad * dv, self.shift_px[1] - self.turn_rad * du]
    }
}

/// One bright dot.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Dot {
    /// Where the image of the dot's centre is claimed to be.
    pub centre_px: [f64; 2],
    /// Greatest error of it, along u and along v.
    pub bound_px: f64,
    /// Radius of a disc of its area.
    pub radius_px: f64,
    /// Grey levels of its middle above its surroundings.
    pub level: f64,
    /// Sum of its grey levels above its surroundings.
    pub flux: f64,
}

/// One marker as read.
#[derive(Clone, Debug, PartialEq)]
pub struct SeenMarker {
    /// What its coded dots spell.
    pub id: MarkerId,
    /// All of its dots.
    pub dots: Vec<(GridPlace, Dot)>,
    /// The paper's confidence P(S), Eq. (3).
    pub confidence: f64,
}

/// What was found in one picture.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct CeilingMarkers {
    /// Markers with an identity of the code.
    pub markers: Vec<SeenMarker>,
    /// Grids that were looked at and refused, as segments `[u0, v0, u1, v1]` from dot X to dot Y, for debug frames.
    pub rejected_px: Vec<[f64; 4]>,
}

impl SeenMarker {
    /// Middle of its corners X and Y.
    pub fn centre_px(&self) -> [f64; 2] {
        let corner =
            |place: GridPlace| self.dots.iter().find(|(other, _)| *other == place).map(|(_, dot)| dot.centre_px);
        match (corner([3, 0]), corner([0, 3])) {
            (Some(x), Some(y)) => [0, 1].map(|axis| 0.5 * (x[axis] + y[axis])),
            _ => [f64::NAN; 2],
        }
    }
}

/// The marker nearest to a point of the picture (Eq. 1).
pub fn nearest(markers: &[SeenMarker], to_px: [f64; 2]) -> Option<&SeenMarker> {
    let distance = |marker: &SeenMarker| {
        let [u, v] = marker.centre_px();
        (u - to_px[0]).hypot(v - to_px[1])
    };
    markers.iter().min_by(|a, b| distance(a).total_cmp(&distance(b)))
}

/// Reads all markers of a picture; `is_word` tells the identities in use (4096 flags).
pub fn detect(
    image: &image::GrayImage,
    view: &CeilingView,
    is_word: &[bool],
    motion: &PictureMotion,
) -> CeilingMarkers {
    let dots = dots::detect(image, view, motion);
    marker::read(image, &dots, view, is_word)
}

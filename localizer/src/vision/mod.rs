//! Image processing: pure functions that turn camera images into features and know neither poses nor the building.
//!
//! Pixel coordinates: u to the right, v down, (0, 0) at the centre of the first pixel. Two processing chains find the joints of a tiled
//! floor (the lines between its tiles); both return the same type, so that one can replace the other:
//!
//! ```text
//! direct: bin ──> ridge points ──> vote ──> profiles across ──> agreement of the grid ──┐
//! paper:  deblur ──> edges ──> thinning ──> pruning ──> Hough ──> clustering ───────────┤
//!                                                                                       v
//!                                                      FloorLines ──> line_fit::enclose ──> LineSet
//! ```

pub mod ceiling;
pub mod direct;
pub(crate) mod distortion;
mod draws;
pub mod forward;
pub mod line_fit;
pub mod p3p;
pub mod paper;
pub mod point_features;
pub(crate) mod straighten;

#[cfg(test)]
mod any_picture;
#[cfg(test)]
pub(crate) mod synthetic;
#[cfg(test)]
mod trial;

/// What the localizer is given about the images of a tiled floor: declared bounds and nominal values, not the true ones.
#[derive(Clone, Debug, PartialEq)]
pub struct FloorView {
    /// Nominal scale of the floor in the image, in pixels per metre.
    pub pixels_per_m: f64,
    /// Distance between neighbouring tile joints of each of the two families of parallel joints. Which family is which in the image is unknown.
    pub edge_px: [f64; 2],
    /// Width of a joint between floor tiles, in pixels.
    pub joint_width_px: f64,
    /// At most this many of the lines found in one image may be no tile joints. Image processing does not use this number; the step that narrows the
    /// box of possible poses by the lines does.
    pub q_items: usize,
}

/// A line in the image that is taken for the centre line of a joint between floor tiles.
#[derive(Clone, Debug, PartialEq)]
pub struct FloorLine {
    /// Points of the line, each `[u, v, bound]` in pixels: at most a share of [`share_wrong`](Self::share_wrong) of the points lies farther than its
    /// bound from the tile joint's centre line.
    pub points_px: Vec<[f64; 3]>,
    /// Share of the line's points that may lie farther than their bound from the tile joint.
    pub share_wrong: f64,
    /// Family of parallel tile joints that the line belongs to, 0 or 1. The two families are orthogonal and are numbered arbitrarily in each image.
    pub family: u8,
}

/// Lines that were found in one image of a tiled floor.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct FloorLines {
    /// Lines found in the image that are taken for tile joints.
    pub lines: Vec<FloorLine>,
    /// Lines that were examined and rejected as tile joints, each a segment `[u0, v0, u1, v1]`; they are drawn in debug frames.
    pub rejected_px: Vec<[f64; 4]>,
}

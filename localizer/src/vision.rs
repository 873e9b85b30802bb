//! Image in, features out: pure functions that know neither poses nor the building.
//!
//! Pixels: u right, v down, (0, 0) the centre of the first pixel. Two chains find the joints of a tiled floor and answer
//! in the same shape, so that one can stand in for the other:
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
pub mod forward;
pub mod line_fit;
pub mod p3p;
pub mod paper;
pub(crate) mod straighten;

#[cfg(test)]
mod any_picture;
#[cfg(test)]
pub(crate) mod synthetic;
#[cfg(test)]
mod trial;

/// What is declared of a picture of a tiled floor.
#[derive(Clone, Debug, PartialEq)]
pub struct FloorView {
    /// Nominal scale on the floor.
    pub pixels_per_m: f64,
    /// Pitch of the two families of joints. Which family is which in the picture is unknown.
    pub edge_px: [f64; 2],
    /// Width of a joint.
    pub joint_width_px: f64,
    /// At most this many of the lines found in one picture may be no joints; with 0, doubtful lines are dropped.
    pub q_items: usize,
}

/// One line taken for the centre line of a joint.
#[derive(Clone, Debug, PartialEq)]
pub struct FloorLine {
    /// `[u, v, bound]`: at most [`share_wrong`](Self::share_wrong) of the points lie farther than their bound from the joint's centre line.
    pub points_px: Vec<[f64; 3]>,
    /// Share of the points that may lie farther away.
    pub share_wrong: f64,
    /// 0 or 1: which of the two orthogonal families, named arbitrarily within the picture.
    pub family: u8,
}

/// What was found in one picture.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct FloorLines {
    /// Lines taken for joints.
    pub lines: Vec<FloorLine>,
    /// Segments `[u0, v0, u1, v1]` that were looked at and rejected, for debug frames.
    pub rejected_px: Vec<[f64; 4]>,
}

//! Headings on which the edges of one image agree, at any lean of robot and camera at which the image's upright edges are upright.
//!
//! A lean of τ turns the direction of a level edge seen at the elevation ε by up to τ/tan ε: five times τ for a skirting, and half of that
//! in the opposite direction for a shelf. One lean holds for all edges of an image, so that together they determine the lean. The disc of
//! leans is cut into squares; in each square, every edge's plane is turned by the lean at the square's middle and widened by the square's
//! extent.

use nalgebra::Vector3;

use super::{
    Quotas, headings,
    sight::{Lean, SightPlane, level_direction},
};
use interval::Interval;

/// Number of squares along a diameter of the disc of leans.
const SQUARES: usize = 24;

/// Agreement of an image's edges: for each count, from one up, the headings at which that many level edges agree on one lean.
pub(super) type Agreement = Vec<Vec<Interval>>;

/// Result of evaluating the edges of one image for the heading.
pub(super) struct Told {
    pub(super) agreement: Agreement,
    /// Whether some declared lean makes enough upright edges upright: otherwise more of them are wrong than declared, or the lean is
    /// greater.
    pub(super) is_upright: bool,
}

/// Values that are common to all edges of an image.
pub(super) struct View<'a> {
    /// Greatest lean of robot and camera together, about any level axis.
    pub(super) tilt_rad: f64,
    /// Whether all edges are seen at one lean that is solved for, instead of each at any lean.
    pub(super) solves_lean: bool,
    /// Quotas of image edges that may be wrong.
    pub(super) quotas: Quotas,
    /// Interval added to every edge's direction: the camera's yaw, and the robot's turn within the stamp's error.
    pub(super) yaw_rad: Interval,
    /// Directions of the building's walls.
    pub(super) directions_rad: &'a [Interval],
    /// Range of headings in which agreement of the image's edges is searched.
    pub(super) about: Interval,
}

/// Headings by the number of level edges that agree on them at a lean that all but a declared share of the upright edges allow; if no lean
/// is allowed by so many upright edges, at any declared lean.
pub(super) fn told(level: &[SightPlane], upright: &[SightPlane], view: &View) -> Told {
    let lean = Lean::of(view.tilt_rad);
    let squares = squares(lean, if view.solves_lean { SQUARES } else { 1 });
    let needed = upright.len() - view.quotas.wrong_of_image(upright.len());
    let allows = |square: &&Square| upright.iter().filter(|plane| square.is_upright(plane)).count() >= needed;
    let mut allowed: Vec<&Square> = squares.iter().filter(allows).collect();
    let is_upright = !allowed.is_empty();
    if !is_upright {
        allowed = squares.iter().collect();
    }
    let mut agreement = vec![Vec::new(); level.len()];
    for square in allowed {
        let sets: Vec<Vec<Interval>> = level
            .iter()
            .map(|plane| match square.direction(plane) {
                Some(azimuth) => {
                    headings::of_line(azimuth.inflate(lean.twist_rad) + view.yaw_rad, view.directions_rad, view.about)
                }
                None => vec![view.about],
            })
            .collect();
        for (count, headings) in agreement.iter_mut().enumerate() {
            headings.extend(headings::agreed(&sets, count + 1));
        }
    }
    Told { agreement: agreement.into_iter().map(headings::joined).collect(), is_upright }
}

/// Square of leans: as vectors about forward and left, those within `half_rad` of `middle_rad` along both axes.
struct Square {
    middle_rad: [f64; 2],
    half_rad: f64,
    lean: Lean,
}

/// Squares that cover the disc of leans.
fn squares(lean: Lean, n_across: usize) -> Vec<Square> {
    let tilt_rad = lean.angle_rad;
    let half_rad = tilt_rad / n_across as f64;
    let middle = |idx: usize| (2 * idx + 1) as f64 * half_rad - tilt_rad;
    let every = (0..n_across).flat_map(|row| (0..n_across).map(move |column| [middle(row), middle(column)]));
    every
        .filter(|[x, y]| (x.abs() - half_rad).max(0.0).hypot((y.abs() - half_rad).max(0.0)) <= tilt_rad)
        .map(|middle_rad| Square { middle_rad, half_rad, lean })
        .collect()
}

impl Square {
    /// Normal of an edge's plane after the lean δ at the middle of the square: n + δ × n.
    fn turned(&self, plane: &SightPlane) -> Vector3<f64> {
        let lean = Vector3::new(self.middle_rad[0], self.middle_rad[1], 0.0);
        plane.normal + lean.cross(&plane.normal)
    }

    /// Greatest shift of the plane's normal along a unit vector, by leans of the square and by errors of the plane itself.
    fn reach(&self, plane: &SightPlane, along: &Vector3<f64>) -> f64 {
        let about = plane.normal.cross(along);
        plane.reach(along) + self.half_rad * (about.x.abs() + about.y.abs()) + self.lean.rest(plane)
    }

    /// Whether an edge's plane may contain the vertical: n·z = 0.
    fn is_upright(&self, plane: &SightPlane) -> bool {
        self.turned(plane).z.abs() <= self.reach(plane, &Vector3::z())
    }

    /// Direction, counter-clockwise from robot forward, of the level line in an edge's plane; `None` when it may be any direction.
    fn direction(&self, plane: &SightPlane) -> Option<Interval> {
        level_direction(&self.turned(plane), |along| self.reach(plane, along))
    }
}

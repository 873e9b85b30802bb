//! The share of an even sky's light that reaches a point of a surface, by the heights up to which walls and furniture hide the sky.

use std::f64::consts::{FRAC_PI_4, PI, TAU};

use nalgebra::{Point2, Point3, Vector3};

use crate::place::building::{BoxFrame, Building, UprightBox};

/// Number of directions around a point in which the height of the horizon is found.
const DIRECTIONS: usize = 72;
/// Distance from the surface of the point from which the sky is looked at.
const BEFORE_M: f64 = 0.002;

/// An upright rectangle that hides the sky behind it up to its upper edge.
#[derive(Debug)]
struct Screen {
    from: Point2<f64>,
    to: Point2<f64>,
    top_m: f64,
    /// Piece of furniture that it is a side of.
    of_box: Option<usize>,
}

/// What hides parts of the sky in a building without ceilings.
#[derive(Debug)]
pub(super) struct Horizon {
    screens: Vec<Screen>,
    boxes: Vec<BoxFrame>,
}

impl Horizon {
    /// The walls and the furniture of a building.
    pub(super) fn new(building: &Building) -> Horizon {
        let plan = |at: Point3<f64>| Point2::new(at.x, at.y);
        let mut screens: Vec<Screen> = building
            .walls()
            .map(|wall| Screen {
                from: plan(wall.corner),
                to: plan(wall.corner + wall.along),
                top_m: wall.corner.z + wall.up.z,
                of_box: None,
            })
            .collect();
        for (index, piece) in building.boxes.iter().enumerate() {
            screens.extend(sides(piece).map(|[from, to]| Screen {
                from,
                to,
                top_m: piece.between_m[1],
                of_box: Some(index),
            }));
        }
        Horizon { screens, boxes: building.boxes.iter().map(BoxFrame::of).collect() }
    }

    /// Illuminance on a surface over that of a level surface in the open. A surface that faces down has none.
    ///
    /// An even sky of luminance 1 gives ∫∫ cos θ·cos e de da, where e is the elevation, a the azimuth, and cos θ that of the angle to the normal.
    /// Over a horizon at elevation h the integral over e is cos²h/2 for a level surface, and (π/4 − h/2 − sin 2h/4)·cos(a − a₀) for an upright one
    /// that faces a₀. Both are divided by π, which a level surface in the open has.
    pub(super) fn share(&self, at: Point3<f64>, normal: Vector3<f64>) -> f64 {
        let from = at + normal * BEFORE_M;
        let slopes = self.slopes(from);
        let step = TAU / DIRECTIONS as f64;
        let mut sum = 0.0;
        for (index, slope) in slopes.iter().enumerate() {
            let (sin, cos) = (azimuth(index)).sin_cos();
            let horizon = slope.atan();
            let facing = (normal.x * cos + normal.y * sin).max(0.0);
            let upright = FRAC_PI_4 - 0.5 * horizon - 0.25 * (2.0 * horizon).sin();
            sum += normal.z.max(0.0) * 0.5 * horizon.cos().powi(2) + facing * upright;
        }
        sum * step / PI
    }

    /// Tangents of the elevations up to which the sky is hidden, in each direction.
    fn slopes(&self, from: Point3<f64>) -> [f64; DIRECTIONS] {
        let mut slopes = [0.0_f64; DIRECTIONS];
        let eye = Point2::new(from.x, from.y);
        for screen in &self.screens {
            let rise_m = screen.top_m - from.z;
            // What stands around the point itself, as a wall's foot or the floor under furniture may be, hides nothing of use.
            if rise_m <= 0.0 || screen.of_box.is_some_and(|index| self.boxes[index].contains(from)) {
                continue;
            }
            let (start, end) = (screen.from - eye, screen.to - eye);
            let turn = start.perp(&end).atan2(start.dot(&end));
            let first = start.y.atan2(start.x);
            let (low, high) = if turn >= 0.0 { (first, first + turn) } else { (first + turn, first) };
            let step = TAU / DIRECTIONS as f64;
            let bins = ((low / step - 0.5).ceil() as i64)..=((high / step - 0.5).floor() as i64);
            let way = end - start;
            let across = start.perp(&way).abs();
            for bin in bins {
                let index = bin.rem_euclid(DIRECTIONS as i64) as usize;
                let (sin, cos) = azimuth(index).sin_cos();
                // The direction meets the screen's line at this distance.
                let distance_m = across / (cos * way.y - sin * way.x).abs().max(1e-12);
                slopes[index] = slopes[index].max(rise_m / distance_m.max(1e-6));
            }
        }
        slopes
    }
}

fn azimuth(index: usize) -> f64 {
    (index as f64 + 0.5) * TAU / DIRECTIONS as f64
}

fn sides(piece: &UprightBox) -> [[Point2<f64>; 2]; 4] {
    let corners = piece.corners();
    std::array::from_fn(|side| [side, (side + 1) % 4].map(|index| Point2::new(corners[index].x, corners[index].y)))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn horizon(screens: Vec<Screen>) -> Horizon {
        Horizon { screens, boxes: Vec::new() }
    }

    #[test]
    fn upright_surfaces_see_half_of_an_open_sky() {
        let open = horizon(Vec::new());
        assert!((open.share(Point3::origin(), Vector3::z()) - 1.0).abs() < 1e-9);
        assert!((open.share(Point3::origin(), Vector3::x()) - 0.5).abs() < 1e-3);
        assert_eq!(open.share(Point3::origin(), -Vector3::z()), 0.0);
    }

    #[test]
    fn a_long_wall_takes_the_share_of_its_height() {
        // From the foot of a street between walls without end, of height h at a distance d on both sides, a level surface sees d/√(d² + h²)
        // of the sky (crossed strings).
        let wall = |y: f64| Screen { from: Point2::new(-1e6, y), to: Point2::new(1e6, y), top_m: 3.0, of_box: None };
        let street = horizon(vec![wall(4.0), wall(-4.0)]);
        let share = street.share(Point3::new(0.0, 0.0, -BEFORE_M), Vector3::z());
        assert!((share - 0.8).abs() < 2e-3, "{share}");
    }
}

//! A claimed edge, and the image line that shows it.

use interval::Interval;

use super::super::{
    eye::Sight,
    number::{Number, Vector},
};

/// What an edge is claimed to be.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in super::super) enum Way {
    Upright,
    /// Along a direction that the scene states, and whether it is turned as all walls are.
    Level {
        stated_rad: f64,
        turns: bool,
    },
}

/// A claimed line that is true.
#[derive(Clone, Copy, Debug)]
pub(in super::super) struct Edge {
    pub(in super::super) ends_px: [[f64; 2]; 2],
    pub(in super::super) bound_px: f64,
    pub(in super::super) way: Way,
}

/// An image line that shows an edge, found to within rounding.
pub(super) struct Shown {
    /// Rays of the two ends in the camera's frame.
    rays: [Vector<f64>; 2],
    /// The greatest part that it uses, of the bound of the ends and of the angle by which furniture may stand askew, with a sign.
    pub(super) used: f64,
    /// Angle of the edge to the wall.
    askew_rad: f64,
}

fn dot(a: Vector<f64>, b: Vector<f64>) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn cross(a: Vector<f64>, b: Vector<f64>) -> Vector<f64> {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

/// Direction of an edge in the world, with walls that are turned and furniture that stands askew.
fn direction<T: Number>(way: Way, turn_rad: T, askew_rad: T) -> Vector<T> {
    match way {
        Way::Upright => [T::of(0.0), T::of(0.0), T::of(1.0)],
        Way::Level { stated_rad, turns } => {
            let turned = if turns { turn_rad } else { T::of(0.0) };
            let angle_rad = T::of(stated_rad) + turned + askew_rad;
            [angle_rad.cos(), angle_rad.sin(), T::of(0.0)]
        }
    }
}

impl Edge {
    /// The image line that shows the edge and is least far from both ends, measured by their bound.
    ///
    /// With the rays r₀ and r₁ of the ends and the direction d, the product (r₀ × r₁)·d is 0 where the line shows the edge. It changes with each end's
    /// move across the line and with the direction; all three move by the same part of what they may.
    pub(super) fn shown(&self, sight: &Sight<f64>, turn_rad: f64, most_askew_rad: f64) -> Shown {
        let [[u0, v0], [u1, v1]] = self.ends_px;
        let length_px = (u1 - u0).hypot(v1 - v0);
        let across_px = [-(v1 - v0) / length_px * self.bound_px, (u1 - u0) / length_px * self.bound_px];
        let moved = |end: usize, by: f64| {
            let [u, v] = self.ends_px[end];
            sight.ray([u + by * across_px[0], v + by * across_px[1]])
        };
        let most_askew_rad = if self.way == Way::Upright { 0.0 } else { most_askew_rad };
        let product = |by: [f64; 3]| {
            let along = sight.in_camera(direction(self.way, turn_rad, by[2] * most_askew_rad));
            dot(cross(moved(0, by[0]), moved(1, by[1])), along)
        };
        let slope = |input: usize| {
            let by = |by: f64| std::array::from_fn(|at| if at == input { by } else { 0.0 });
            0.5 * (product(by(1.0)) - product(by(-1.0)))
        };
        let slopes = [slope(0), slope(1), if most_askew_rad > 0.0 { slope(2) } else { 0.0 }];
        let whole = slopes.iter().map(|slope| slope.abs()).sum::<f64>();
        let mut used = 0.0;
        // The product is nearly linear, so that the second step reaches rounding.
        for _ in 0..3 {
            used -= product(slopes.map(|slope| used * slope.signum())) / whole;
        }
        let by = slopes.map(|slope| used * slope.signum());
        let askew_rad = by[2] * most_askew_rad;
        Shown { rays: [moved(0, by[0]), moved(1, by[1])], used, askew_rad }
    }

    /// Whether an edge is surely seen where it was claimed.
    pub(super) fn holds(
        &self,
        sights: &(Sight<f64>, Sight<Interval>),
        [turn_rad, most_askew_rad]: [f64; 2],
        slack: f64,
    ) -> Result<(), [Interval; 2]> {
        let shown = self.shown(&sights.0, turn_rad, most_askew_rad);
        let askew_rad = shown.askew_rad.clamp(-most_askew_rad, most_askew_rad);
        let [first, last] = shown.rays;
        let along = direction(self.way, Interval::point(turn_rad), Interval::point(askew_rad));
        let along = sights.1.in_camera(along);
        // The second point is a·first + b·along: a point of the plane, whatever a and b are. They are chosen so that it is the last ray, by the products
        // with `first` and with `middle`.
        let middle = along.map(|component| component.mid());
        let (ff, fm, mm) = (dot(first, first), dot(first, middle), dot(middle, middle));
        let (fl, ml) = (dot(first, last), dot(middle, last));
        let determinant = ff * mm - fm * fm;
        let [a, b] = [(fl * mm - ml * fm) / determinant, (ml * ff - fl * fm) / determinant];
        let first = first.map(Interval::point);
        let second = std::array::from_fn(|axis| first[axis] * a + along[axis] * b);
        let allowed = Interval::new(0.0, self.bound_px * (1.0 + slack));
        for (point, [u, v]) in [first, second].into_iter().zip(self.ends_px) {
            let ([at_u, at_v], depth) = sights.1.pixel_of(point);
            let off_px = (at_u - Interval::point(u)).hypot(at_v - Interval::point(v));
            if depth.is_empty() || depth.lo() <= 0.0 || off_px.is_empty() || !off_px.is_subset_of(allowed) {
                return Err([off_px, allowed]);
            }
        }
        Ok(())
    }
}

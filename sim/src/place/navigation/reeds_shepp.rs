//! Reeds–Shepp curves: paths between two poses, without obstacles, of a car that drives forwards and backwards and has a turning circle.
//!
//! Reeds and Shepp, "Optimal paths for a car that goes both forwards and backwards", Pacific Journal of Mathematics 145 (1990), show that the
//! shortest path is among those that their section 8 lists, of at most five arcs and straight stretches each. The formulas below bear the paper's
//! numbers. In them the car starts at the origin along x, ends at (x, y) with heading φ, and its smallest circle has radius 1; the paper's misprints
//! are corrected as in LaValle, *Planning Algorithms* (2006), section 15.3, and in the OMPL library.

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use localizer::Pose;

/// A stretch of a path on which the car keeps its steering angle and its direction.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Arc {
    /// Length of the stretch, negative where the car drives backwards.
    pub length_m: f64,
    /// Curvature of the stretch: turn of the car per length driven forwards, positive to the left.
    pub curvature_per_m: f64,
}

impl Arc {
    /// The pose of a car that has driven a length of this stretch, negative if backwards, from a pose at which the stretch begins.
    pub fn after(&self, from: Pose, length_m: f64) -> Pose {
        let (sin, cos) = from.heading_rad.sin_cos();
        let heading_rad = from.heading_rad + self.curvature_per_m * length_m;
        if self.curvature_per_m.abs() < 1e-9 {
            return Pose { x_m: from.x_m + length_m * cos, y_m: from.y_m + length_m * sin, heading_rad };
        }
        let (sin_after, cos_after) = heading_rad.sin_cos();
        Pose {
            x_m: from.x_m + (sin_after - sin) / self.curvature_per_m,
            y_m: from.y_m - (cos_after - cos) / self.curvature_per_m,
            heading_rad,
        }
    }

    /// The pose at the end of this stretch.
    pub fn end(&self, from: Pose) -> Pose {
        self.after(from, self.length_m)
    }
}

/// A Reeds–Shepp curve: up to five stretches, followed by some of no length.
pub type Curve = [Arc; 5];

/// A side to which the car steers, as the sign of the curvature, and the length of the stretch over the circle's radius.
type Stretch = (f64, f64);
/// A path on a circle of radius 1.
type Word = [Stretch; 5];

const LEFT: f64 = 1.0;
const RIGHT: f64 = -1.0;
const AHEAD: f64 = 0.0;
const NOTHING: Stretch = (AHEAD, 0.0);

/// Length over the circle's radius below which a stretch counts as none; rounding leaves such stretches.
const NO_LENGTH: f64 = 1e-9;

/// All Reeds–Shepp curves between two poses, for a smallest circle of a radius. Headings count modulo one turn.
pub fn curves(from: Pose, to: Pose, radius_m: f64) -> Vec<Curve> {
    let (sin, cos) = from.heading_rad.sin_cos();
    let off = [to.x_m - from.x_m, to.y_m - from.y_m].map(|off_m| off_m / radius_m);
    let (x, y) = (cos * off[0] + sin * off[1], cos * off[1] - sin * off[0]);
    let arc = |(side, length): Stretch| {
        let length_m = if length.abs() < NO_LENGTH { 0.0 } else { length * radius_m };
        Arc { length_m, curvature_per_m: side / radius_m }
    };
    words(x, y, wrapped(to.heading_rad - from.heading_rad)).into_iter().map(|word| word.map(arc)).collect()
}

/// Length of a path.
pub fn length_m(arcs: &[Arc]) -> f64 {
    arcs.iter().map(|arc| arc.length_m.abs()).sum()
}

/// All words that lead to a pose. Each formula gives a word, three more by mirrors in space and in time, and, where its word read from the end is
/// another one, four more.
fn words(x: f64, y: f64, phi: f64) -> Vec<Word> {
    let (sin, cos) = phi.sin_cos();
    let (x_back, y_back) = (x * cos + y * sin, x * sin - y * cos);
    let mut found = Vec::with_capacity(24);
    for (formula, has_reverse) in FORMULAS {
        for (time, space) in [(1.0, 1.0), (-1.0, 1.0), (1.0, -1.0), (-1.0, -1.0)] {
            let mirrored = |word: Word| word.map(|(side, length)| (space * side, time * length));
            found.extend(formula(time * x, space * y, time * space * phi).map(mirrored));
            if has_reverse {
                let word = formula(time * x_back, space * y_back, time * space * phi).map(mirrored);
                found.extend(word.map(|[first, second, third, fourth, _]| match fourth {
                    NOTHING => [third, second, first, NOTHING, NOTHING],
                    _ => [fourth, third, second, first, NOTHING],
                }));
            }
        }
    }
    found
}

type Formula = fn(f64, f64, f64) -> Option<Word>;

/// The formulas, each with whether its word may also be driven from its end to its beginning.
const FORMULAS: [(Formula, bool); 8] = [
    (left_straight_left, false),
    (left_straight_right, false),
    (left_right_left, true),
    (left_right_left_right, false),
    (left_right_left_right_by_two_cusps, false),
    (left_right_straight_left, true),
    (left_right_straight_right, true),
    (left_right_straight_left_right, false),
];

/// Formula 8.1: L⁺ S⁺ L⁺.
fn left_straight_left(x: f64, y: f64, phi: f64) -> Option<Word> {
    let (u, t) = polar(x - phi.sin(), y - 1.0 + phi.cos());
    let v = wrapped(phi - t);
    (is_forward(t) && is_forward(v)).then_some([(LEFT, t), (AHEAD, u), (LEFT, v), NOTHING, NOTHING])
}

/// Formula 8.2: L⁺ S⁺ R⁺.
fn left_straight_right(x: f64, y: f64, phi: f64) -> Option<Word> {
    let (rho, theta) = polar(x + phi.sin(), y - 1.0 - phi.cos());
    let u = root(rho * rho - 4.0)?;
    let t = wrapped(theta + 2.0_f64.atan2(u));
    let v = wrapped(t - phi);
    (is_forward(t) && is_forward(v)).then_some([(LEFT, t), (AHEAD, u), (RIGHT, v), NOTHING, NOTHING])
}

/// Formulas 8.3 and 8.4: L⁺ R⁻ L, where the last arc is driven in either direction.
fn left_right_left(x: f64, y: f64, phi: f64) -> Option<Word> {
    let (rho, theta) = polar(x - phi.sin(), y - 1.0 + phi.cos());
    if rho > 4.0 {
        return None;
    }
    let u = -2.0 * (0.25 * rho).asin();
    let t = wrapped(theta + 0.5 * u + PI);
    let v = wrapped(phi - t + u);
    is_forward(t).then_some([(LEFT, t), (RIGHT, u), (LEFT, v), NOTHING, NOTHING])
}

/// Formula 8.7: L⁺ R⁺ L⁻ R⁻, whose inner arcs are equally long.
fn left_right_left_right(x: f64, y: f64, phi: f64) -> Option<Word> {
    let (xi, eta) = (x + phi.sin(), y - 1.0 - phi.cos());
    let rho = 0.25 * (2.0 + xi.hypot(eta));
    if rho > 1.0 {
        return None;
    }
    let u = rho.acos();
    let (t, v) = outer_arcs(u, -u, xi, eta, phi);
    (is_forward(t) && is_forward(-v)).then_some([(LEFT, t), (RIGHT, u), (LEFT, -u), (RIGHT, v), NOTHING])
}

/// Formula 8.8: L⁺ R⁻ L⁻ R⁺, whose inner arcs are equally long.
fn left_right_left_right_by_two_cusps(x: f64, y: f64, phi: f64) -> Option<Word> {
    let (xi, eta) = (x + phi.sin(), y - 1.0 - phi.cos());
    let rho = (20.0 - xi * xi - eta * eta) / 16.0;
    if !(0.0..=1.0).contains(&rho) {
        return None;
    }
    let u = -rho.acos();
    let (t, v) = outer_arcs(u, u, xi, eta, phi);
    (is_forward(t) && is_forward(v)).then_some([(LEFT, t), (RIGHT, u), (LEFT, u), (RIGHT, v), NOTHING])
}

/// Formula 8.9: L⁺ R⁻ S⁻ L⁻, with a quarter of a circle to the right.
fn left_right_straight_left(x: f64, y: f64, phi: f64) -> Option<Word> {
    let (rho, theta) = polar(x - phi.sin(), y - 1.0 + phi.cos());
    let across = root(rho * rho - 4.0)?;
    let u = 2.0 - across;
    let t = wrapped(theta + across.atan2(-2.0));
    let v = wrapped(phi - FRAC_PI_2 - t);
    let is_word = is_forward(t) && is_forward(-u) && is_forward(-v);
    is_word.then_some([(LEFT, t), (RIGHT, -FRAC_PI_2), (AHEAD, u), (LEFT, v), NOTHING])
}

/// Formula 8.10: L⁺ R⁻ S⁻ R⁻, with a quarter of a circle to the right first.
fn left_right_straight_right(x: f64, y: f64, phi: f64) -> Option<Word> {
    let (rho, t) = polar(1.0 + phi.cos() - y, x + phi.sin());
    let u = 2.0 - rho;
    let v = wrapped(t + FRAC_PI_2 - phi);
    let is_word = is_forward(t) && is_forward(-u) && is_forward(-v);
    is_word.then_some([(LEFT, t), (RIGHT, -FRAC_PI_2), (AHEAD, u), (RIGHT, v), NOTHING])
}

/// Formula 8.11: L⁺ R⁻ S⁻ L⁻ R⁺, whose inner arcs are quarters of a circle.
fn left_right_straight_left_right(x: f64, y: f64, phi: f64) -> Option<Word> {
    let (xi, eta) = (x + phi.sin(), y - 1.0 - phi.cos());
    let u = 4.0 - root(xi * xi + eta * eta - 4.0)?;
    let t = wrapped(((4.0 - u) * xi - 2.0 * eta).atan2(-2.0 * xi + (u - 4.0) * eta));
    let v = wrapped(t - phi);
    let is_word = is_forward(t) && is_forward(-u) && is_forward(v);
    is_word.then_some([(LEFT, t), (RIGHT, -FRAC_PI_2), (AHEAD, u), (LEFT, -FRAC_PI_2), (RIGHT, v)])
}

/// First and last arc of a word with inner arcs `u` and `v` (formula 8.6).
fn outer_arcs(u: f64, v: f64, xi: f64, eta: f64, phi: f64) -> (f64, f64) {
    let delta = wrapped(u - v);
    let (a, b) = (u.sin() - delta.sin(), u.cos() - delta.cos() - 1.0);
    let first = (eta * a - xi * b).atan2(xi * a + eta * b);
    let is_turned = 2.0 * (delta.cos() - v.cos() - u.cos()) + 3.0 < 0.0;
    let tau = wrapped(if is_turned { first + PI } else { first });
    (tau, wrapped(tau - u + v - phi))
}

fn polar(x: f64, y: f64) -> (f64, f64) {
    (x.hypot(y), y.atan2(x))
}

/// Square root of a number that may be negative by rounding; `None` if it is truly negative.
fn root(square: f64) -> Option<f64> {
    (square > -NO_LENGTH).then(|| square.max(0.0).sqrt())
}

fn is_forward(length: f64) -> bool {
    length > -NO_LENGTH
}

/// An angle, by whole turns brought into [−π, π].
fn wrapped(angle_rad: f64) -> f64 {
    angle_rad - TAU * (angle_rad / TAU).round()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn shortest_m(to: [f64; 3], radius_m: f64) -> f64 {
        let to = Pose { x_m: to[0], y_m: to[1], heading_rad: to[2] };
        curves(Pose::default(), to, radius_m).iter().map(|curve| length_m(curve)).fold(f64::INFINITY, f64::min)
    }

    #[test]
    fn lengths_are_those_worked_out_by_hand() {
        for (to, radius_m, expected_m) in [
            ([3.0, 0.0, 0.0], 1.0, 3.0),
            ([-2.0, 0.0, 0.0], 1.0, 2.0),
            // Half a circle, and two quarters of circles of 2 m that lead to a lane 4 m to the left.
            ([0.0, 2.0, PI], 1.0, PI),
            ([4.0, 4.0, 0.0], 2.0, 2.0 * PI),
            // On the spot by half a turn: three arcs of 60° about the corners of an equilateral triangle with sides of twice the radius.
            ([0.0, 0.0, PI], 1.0, PI),
            ([0.0, 0.0, -PI], 0.7, 0.7 * PI),
        ] {
            let found_m = shortest_m(to, radius_m);
            assert!((found_m - expected_m).abs() < 1e-9, "{to:?}: {found_m} m, expected {expected_m} m");
        }
    }

    /// Lengths by `ReedsSheppStateSpace` of the Open Motion Planning Library 2.0.1, for a radius of 1.
    #[test]
    fn lengths_are_those_of_an_outside_library() {
        for (to, expected) in [
            ([0.0, 1.0, 0.0], 2.636232),
            ([0.0, 4.0, 0.0], 5.478121),
            ([0.0, 0.1, 0.0], 0.885526),
            ([-2.1, 0.4, -0.8], 2.186022),
            ([0.8, 1.0, -2.6], 2.600000),
            ([-3.9, 2.7, -1.4], 4.862857),
            ([-2.1, 4.0, -0.2], 4.982533),
            ([2.7, -0.2, 0.8], 2.851870),
            ([-2.8, 1.1, 2.2], 4.136794),
            ([0.2, 1.9, 1.0], 2.711899),
            ([-1.6, -3.8, 2.2], 4.548873),
            ([-0.2, 1.8, 2.3], 2.633910),
            ([1.7, 3.4, -0.6], 4.977591),
            ([2.4, -0.4, 2.6], 3.567956),
            ([3.0, -3.2, -2.2], 4.920224),
            ([1.0, -1.6, 0.0], 2.862748),
            ([-0.9, -1.2, 0.5], 2.024739),
            ([0.7, 3.2, 1.1], 3.810681),
            ([3.4, 2.9, 2.9], 5.535357),
            ([1.4, -2.7, 2.2], 4.015610),
            ([2.8, 3.9, -2.5], 5.824494),
            ([2.4, -0.7, -2.1], 3.369633),
        ] {
            let found = shortest_m(to, 1.0);
            assert!((found - expected).abs() < 1e-6, "{to:?}: {found}, expected {expected}");
        }
    }

    /// Each curve is driven in steps of a hundredth of the radius, by the midpoint rule.
    #[test]
    fn every_curve_ends_at_its_goal_within_the_turning_circle_and_is_no_shorter_than_the_straight_line() {
        let radius_m = 0.8;
        let mut n_words = 0;
        for step in 0..400 {
            let share = |by: usize| ((step * by) % 401) as f64 / 401.0 - 0.5;
            let from = Pose { x_m: 1.0, y_m: -2.0, heading_rad: 9.0 * share(7) };
            let to = Pose {
                x_m: 1.0 + 8.0 * share(37),
                y_m: -2.0 + 8.0 * share(113),
                heading_rad: from.heading_rad + TAU * share(61),
            };
            let found = curves(from, to, radius_m);
            for curve in &found {
                n_words += 1;
                let mut at = from;
                for arc in curve {
                    assert!(arc.curvature_per_m.abs() * radius_m < 1.0 + 1e-12, "{arc:?}");
                    let n_steps = (arc.length_m.abs() / 0.008).ceil();
                    for _ in 0..n_steps as usize {
                        let step_m = arc.length_m / n_steps;
                        let middle_rad = at.heading_rad + 0.5 * arc.curvature_per_m * step_m;
                        at.x_m += step_m * middle_rad.cos();
                        at.y_m += step_m * middle_rad.sin();
                        at.heading_rad += arc.curvature_per_m * step_m;
                    }
                }
                let off_m = (at.x_m - to.x_m).hypot(at.y_m - to.y_m);
                assert!(off_m < 1e-3, "{curve:?} from {from:?} ends at {at:?}, not at {to:?}");
                assert!(
                    wrapped(at.heading_rad - to.heading_rad).abs() < 1e-6,
                    "{curve:?} ends at {at:?}, not at {to:?}"
                );
                assert!(length_m(curve) > (to.x_m - from.x_m).hypot(to.y_m - from.y_m) - 1e-9, "{curve:?}");
            }
            // Driven backwards in time, the way there is the way back.
            let shortest_m = |all: &[Curve]| all.iter().map(|curve| length_m(curve)).fold(f64::INFINITY, f64::min);
            let back_m = shortest_m(&curves(to, from, radius_m));
            assert!((shortest_m(&found) - back_m).abs() < 1e-9, "{from:?} to {to:?}: {back_m} m back");
        }
        assert!(n_words > 2000, "{n_words}");
    }
}

//! Linear rows that relate poses and rays, in the deviations of all quantities from reference values.
//!
//! What is not linear in a row is enclosed over the boxes of the quantities and added to the row's sides, so that the true values satisfy every row.
//! Headings enter by the identity P(θ₀ + δ) = P₀ cos δ − Q₀ sin δ for rotated numbers, so that only sin δ − δ and cos δ − 1 are enclosed.

use interval::Interval;

use crate::boxes::Boxes;
use crate::drive::{Drive, FOCAL_PX, LANDMARKS_M, Step};

/// Index of a pose's coordinate among all quantities: x (0), y (1) or heading (2).
pub(crate) fn pose_index(pose: usize, axis: usize) -> usize {
    3 * pose + axis
}

/// Index of a ray's part among all quantities of a drive with the given number of poses: a (0), b (1) or inverse depth ρ (2).
pub(crate) fn ray_index(n_poses: usize, landmark: usize, part: usize) -> usize {
    3 * (n_poses + landmark) + part
}

/// A row: a linear function of the deviations, and the interval of its value.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Row {
    pub(crate) terms: Vec<(usize, f64)>,
    pub(crate) sides: Interval,
}

impl Row {
    /// The row Σ aⱼ δⱼ ∈ `sides` whose coefficients aⱼ are known as intervals: their middles become the coefficients, and what is left, times the
    /// deviations, is added to the sides.
    fn new(terms: &[(usize, Interval)], sides: Interval, deviations: &[Interval]) -> Row {
        let middle = |&(index, a): &(usize, Interval)| (index, a.mid());
        let rest = terms.iter().map(|&(index, a)| (a - Interval::point(a.mid())) * deviations[index]);
        Row { terms: terms.iter().map(middle).collect(), sides: rest.fold(sides, |sides, rest| sides - rest) }
    }
}

/// Reference values of all quantities, and the deviations from them that are possible.
///
/// Where all deviations are 0 the rows are the plain linearisation at the reference.
#[derive(Clone, Debug)]
pub(crate) struct Surroundings {
    pub(crate) reference: Vec<f64>,
    pub(crate) deviations: Vec<Interval>,
}

impl Surroundings {
    /// The boxes, with their middles as reference.
    pub(crate) fn of_boxes(boxes: &Boxes) -> Surroundings {
        let values: Vec<Interval> = boxes.poses.iter().chain(&boxes.rays).flatten().copied().collect();
        let reference: Vec<f64> = values.iter().map(|value| value.mid()).collect();
        let deviations = values.iter().zip(&reference).map(|(&value, &at)| value - Interval::point(at)).collect();
        Surroundings { reference, deviations }
    }

    fn at<const N: usize>(&self, indices: [usize; N]) -> [Interval; N] {
        indices.map(|index| Interval::point(self.reference[index]))
    }

    fn by<const N: usize>(&self, indices: [usize; N]) -> [Interval; N] {
        indices.map(|index| self.deviations[index])
    }

    /// All rows of a drive.
    pub(crate) fn rows(&self, drive: &Drive) -> Vec<Row> {
        let mut rows = Vec::new();
        for (before, step) in drive.steps.iter().enumerate() {
            rows.extend(self.step_rows(step, before));
        }
        for (pose, picture) in drive.pixels.iter().enumerate() {
            for (landmark, &pixel) in picture.iter().enumerate() {
                rows.extend(self.sight_rows(pixel, pose, drive.n_poses(), landmark));
            }
        }
        rows
    }

    /// Rows of a step from pose number `before` to the next.
    ///
    /// With the chord D and the mean β of both headings, the displacement M is D (cos β, sin β). Along and across the reference of β, which differs
    /// from it by δ, M is D cos δ and D sin δ; the latter is D₀ δ + (D − D₀) δ + D (sin δ − δ).
    fn step_rows(&self, step: &Step, before: usize) -> [Row; 3] {
        let [x, y, heading] = [0, 1, 2].map(|axis| pose_index(before, axis));
        let [next_x, next_y, next_heading] = [0, 1, 2].map(|axis| pose_index(before + 1, axis));
        let [heading_0, next_heading_0] = self.at([heading, next_heading]);
        let [x_0, y_0, next_x_0, next_y_0] = self.at([x, y, next_x, next_y]);
        let middle = (heading_0 + next_heading_0) * 0.5;
        let (cos, sin) = (middle.cos(), middle.sin());
        let [heading_by, next_heading_by] = self.by([heading, next_heading]);
        let delta = (heading_by + next_heading_by) * 0.5;
        let half_turn = Interval::point(step.turn_rad.magnitude()) * 0.5;
        let chord = step.distance_m * (Interval::ONE - half_turn.sqr() / 6.0).hull(Interval::ONE);
        let chord_0 = Interval::point(chord.mid());
        let (along, across) = ([cos, sin], [-sin, cos]);
        let displaced = |direction: [Interval; 2]| {
            let terms =
                [(next_x, direction[0]), (next_y, direction[1]), (x, -direction[0]), (y, -direction[1])].to_vec();
            let reference = (next_x_0 - x_0) * direction[0] + (next_y_0 - y_0) * direction[1];
            (terms, reference)
        };
        let (terms, reference) = displaced(along);
        let ahead = Row::new(&terms, chord + chord * cosine_rest(delta) - reference, &self.deviations);
        let (mut terms, reference) = displaced(across);
        terms.extend([(heading, -chord_0 * 0.5), (next_heading, -chord_0 * 0.5)]);
        let rest = (chord - chord_0) * delta + chord * sine_rest(delta);
        let aside = Row::new(&terms, rest - reference, &self.deviations);
        let turned = Row::new(
            &[(next_heading, Interval::ONE), (heading, -Interval::ONE)],
            step.turn_rad - (next_heading_0 - heading_0),
            &self.deviations,
        );
        [ahead, aside, turned]
    }

    /// Rows of a landmark's sight from a pose: two for each coordinate of the pixel.
    ///
    /// The landmark's direction times its inverse depth is (h_ahead, h_left, h_up), with h_ahead > 0. That the pixel's u is in [lo, hi] means
    /// lo·h_ahead + f·h_left ≤ 0 ≤ hi·h_ahead + f·h_left, because u·h_ahead = −f·h_left; likewise v with h_up. No division, and no interval of the
    /// pixel multiplies an unknown.
    fn sight_rows(&self, pixel: [Interval; 2], pose: usize, n_poses: usize, landmark: usize) -> [Row; 4] {
        let [below, above] = [f64::NEG_INFINITY, f64::INFINITY];
        let [u, v] = pixel;
        let row = |bound: f64, is_across, sides| self.half_plane(bound, is_across, sides, pose, n_poses, landmark);
        [
            row(u.lo(), true, Interval::new(below, 0.0)),
            row(u.hi(), true, Interval::new(0.0, above)),
            row(v.lo(), false, Interval::new(below, 0.0)),
            row(v.hi(), false, Interval::new(0.0, above)),
        ]
    }

    /// The row that w·h_ahead + f·h_left (across) or w·h_ahead + f·h_up is in `sides`, for a number w.
    ///
    /// With A = 1 − ρx and B = a − ρy, h_ahead = A cos θ + B sin θ and h_left = B cos θ − A sin θ. The function is A·P(θ) + B·Q(θ) + K·b with
    /// P = w cos θ − f sin θ, Q = w sin θ + f cos θ, K = 0 across, and P = w cos θ, Q = w sin θ, K = f otherwise. Turned on by δ,
    /// it is (A P₀ + B Q₀) cos δ + (B P₀ − A Q₀) sin δ + K b.
    fn half_plane(
        &self,
        bound: f64,
        is_across: bool,
        sides: Interval,
        pose: usize,
        n_poses: usize,
        landmark: usize,
    ) -> Row {
        let indices @ [x, y, heading] = [0, 1, 2].map(|axis| pose_index(pose, axis));
        let parts @ [a, b, rho] = [0, 1, 2].map(|part| ray_index(n_poses, landmark, part));
        let ([x_0, y_0, heading_0], [a_0, b_0, rho_0]) = (self.at(indices), self.at(parts));
        let ([x_by, y_by, delta], [a_by, _, rho_by]) = (self.by(indices), self.by(parts));
        let (w, focal) = (Interval::point(bound), Interval::point(FOCAL_PX));
        let (across, up) = if is_across { (focal, Interval::ZERO) } else { (Interval::ZERO, focal) };
        let (cos, sin) = (heading_0.cos(), heading_0.sin());
        let (p, q) = (w * cos - across * sin, w * sin + across * cos);
        let (east_0, north_0) = (Interval::ONE - rho_0 * x_0, a_0 - rho_0 * y_0);
        let (east_by, north_by) =
            (-(rho_0 * x_by + x_0 * rho_by + x_by * rho_by), a_by - rho_0 * y_by - y_0 * rho_by - y_by * rho_by);
        let (east, north) = (east_0 + east_by, north_0 + north_by);
        let terms = [
            (x, -rho_0 * p),
            (y, -rho_0 * q),
            (heading, north_0 * p - east_0 * q),
            (a, q),
            (b, up),
            (rho, -(x_0 * p + y_0 * q)),
        ];
        let reference = east_0 * p + north_0 * q + up * b_0;
        let rest = (east * p + north * q) * cosine_rest(delta)
            + (north * p - east * q) * sine_rest(delta)
            + (north_by * p - east_by * q) * delta
            - (p * x_by + q * y_by) * rho_by;
        Row::new(&terms, sides - reference - rest, &self.deviations)
    }
}

/// Enclosure of sin δ − δ, which is at most |δ|³/6 in size.
fn sine_rest(delta: Interval) -> Interval {
    let most = Interval::point(delta.magnitude());
    Interval::centred(0.0, (most * most.sqr() / 6.0).hi())
}

/// Enclosure of cos δ − 1, which is in [−δ²/2, 0].
fn cosine_rest(delta: Interval) -> Interval {
    (-delta.sqr() * 0.5).hull(Interval::ZERO)
}

/// All quantities of poses and rays, in the order of their indices.
pub(crate) fn quantities(poses: &[[f64; 3]], rays: &[[f64; 3]; LANDMARKS_M.len()]) -> Vec<f64> {
    poses.iter().chain(rays).flatten().copied().collect()
}

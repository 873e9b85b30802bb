//! Rows of a landmark's sighting by a range camera.
//!
//! Let P and θ be the robot's position and heading at the exposure, L the landmark, a the place of the camera's first view in the robot frame, φ = θ +
//! yaw the direction of its optical axis, e = (cos φ, sin φ) and r the unit vector to the right of e. With D = L − P − R(θ)·a, the landmark is X =
//! r·D to the right and Z = e·D ahead, but for what tilts move it. The tilt of the camera's mount moves it in the robot frame by a vector t that is
//! the same whenever this landmark is seen, so that D = L − P − R(θ)·(a − t); all other tilts together move it by at most a known distance (`blur`).
//!
//! The sighting says f·X = u·Z and f·(X − b) = w·Z, with columns u and w counted from the optical axis. For a measured column ū the vectors
//! n = (f₀ r − ū e)/N and m = (ū r + f₀ e)/N, N = √(f₀² + ū²), are across the ray and along it. For φ = φ₀ + δ, with n₀ = n at φ₀,
//!
//! n₀·D = (n·D) cos δ − (m·D) sin δ,   e₀·D = (e·D) cos δ + (r·D) sin δ,
//!
//! both exact. N·(n·D) = (u − ū)·Z − (f − f₀)·X is small, and m·D follows from the disparity u − w, Z = f·b/(u − w). So both rows are linear in D and
//! in δ but for (m·D) sin δ − ℓ₀ δ and the like, in which only the sighting's own depth occurs. D is linear in L, P, a and t but for the lever arm,
//! R(θ)·a = R(θ₀)·a₀ + R(θ₀)·(a − a₀) + δθ·J·R(θ₀)·a₀ ± (|a| δθ²/2 + |a − a₀|·|δθ|), and R(θ)·t = R(θ₀)·t ± |t|·|δθ|.

use interval::Interval;

use crate::{
    bounds,
    reading::{LandmarkId, Sighting},
    robot::RangeCameraModel,
};

use super::{
    Constant, Domain, Row, Variable,
    row::{axes, cosine_rest, dot, sine_rest},
};

/// Columns in which a range camera's two views show a landmark, counted from the optical axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Columns {
    /// Column in the first view.
    pub first_px: Interval,
    /// Column in the second view.
    pub second_px: Interval,
    /// Column in the first view less that in the second.
    pub disparity_px: Interval,
}

impl Columns {
    /// The columns at which a sighting truly was.
    pub fn of(camera: &RangeCameraModel, sighting: &Sighting) -> Columns {
        let cell = |read_px: f64, step_px: f64| (Interval::point(read_px) - camera.centre_px).inflate(0.5 * step_px);
        let (first_px, second_px) =
            (cell(sighting.left_px, camera.step_px[0]), cell(sighting.right_px, camera.step_px[1]));
        Columns { first_px, second_px, disparity_px: first_px - second_px }
    }

    /// Hull of the values of a function of the column in the first view and of the disparity. The disparity has to be above 0, and the function monotonic
    /// in either of the two while the other one stays, and in the column while that of the second view stays. Then its extremes are at corners, both of
    /// column and disparity and, where they allow no disparity of 0, of the two columns. The hull is what both have in common.
    pub fn hull_over<const N: usize>(&self, value: impl Fn(Interval, Interval) -> [Interval; N]) -> [Interval; N] {
        let ends = |side: Interval| [side.lo(), side.hi()].map(Interval::point);
        let over = |disparities: &dyn Fn(Interval) -> [Interval; 2]| {
            let mut hull = [Interval::EMPTY; N];
            for first_px in ends(self.first_px) {
                for disparity_px in disparities(first_px) {
                    let corner = value(first_px, disparity_px);
                    hull = std::array::from_fn(|side| hull[side].hull(corner[side]));
                }
            }
            hull
        };
        let by_disparity = over(&|_| ends(self.disparity_px));
        if (self.first_px - self.second_px).lo() <= 0.0 {
            // Between the corners of both columns the depth may be infinite.
            return by_disparity;
        }
        let by_columns = over(&|first_px| ends(self.second_px).map(|second_px| first_px - second_px));
        std::array::from_fn(|side| by_columns[side].intersect(by_disparity[side]))
    }
}

/// The rows of a sighting of a landmark at key frame number `frame`: across the ray of the first view, across that of the second, and in depth. None
/// where the disparity may be 0. `blur_m` is the greatest distance by which tilts move the landmark in the robot frame, beside what the domain has as a
/// quantity of the landmark ([`Variable::TiltedLandmark`]).
pub fn sighting_rows(landmark: LandmarkId, columns: Columns, blur_m: f64, frame: usize, domain: &Domain) -> Vec<Row> {
    Sight::new(landmark, columns, blur_m, frame, domain).map_or_else(Vec::new, |sight| {
        vec![sight.across_ray(View::First), sight.across_ray(View::Second), sight.in_depth()]
    })
}

/// One of the two views of a range camera.
#[derive(Clone, Copy, PartialEq, Eq)]
enum View {
    First,
    Second,
}

/// A sighting at a key frame, with everything that its rows have in common.
struct Sight<'a> {
    domain: &'a Domain,
    /// What D consists of: quantities with the vectors by which D changes with each of them.
    parts: Vec<(Variable, [Interval; 2])>,
    /// D at the reference values, with what of it is not linear.
    at_reference: [Interval; 2],
    /// Unit vectors ahead and to the left at the reference direction φ₀.
    ahead: [Interval; 2],
    left: [Interval; 2],
    heading: Variable,
    /// Possible δ = φ − φ₀.
    delta: Interval,
    columns: Columns,
    baseline_m: Interval,
    /// Depth and place to the right at which the columns put the landmark, without tilts.
    depth_m: Interval,
    right_m: Interval,
    blur_m: Interval,
}

impl<'a> Sight<'a> {
    fn new(landmark: LandmarkId, columns: Columns, blur_m: f64, frame: usize, domain: &'a Domain) -> Option<Sight<'a>> {
        let disparity_px = columns.disparity_px;
        if disparity_px.lo() <= 0.0 {
            return None;
        }
        let constant = |constant| domain.value(Variable::Constant(constant));
        let (focal_px, baseline_m) = (constant(Constant::RangeFocal), constant(Constant::RangeBaseline));
        let heading = Variable::Pose(frame, 2);
        let yaw = Variable::Constant(Constant::RangeYaw);
        let heading_0 = Interval::point(domain.reference(heading));
        let [ahead, left] = axes(heading_0 + Interval::point(domain.reference(yaw)));
        // u·b/(u − w) = b·(1 + w/(u − w)) is monotonic in each column, and in the disparity.
        let [share] = columns.hull_over(|first_px, disparity_px| [first_px / disparity_px]);
        let mut sight = Sight {
            domain,
            parts: Vec::new(),
            at_reference: [Interval::ZERO; 2],
            ahead,
            left,
            heading,
            delta: domain.deviation(heading) + domain.deviation(yaw),
            columns,
            baseline_m,
            depth_m: focal_px * baseline_m / disparity_px,
            right_m: baseline_m * share,
            blur_m: Interval::centred(0.0, blur_m),
        };
        sight.place(landmark, frame, heading_0);
        Some(sight)
    }

    /// Sets D = L − P − R(θ)·(a − t) and how it changes with each quantity.
    fn place(&mut self, landmark: LandmarkId, frame: usize, heading_0: Interval) {
        let domain = self.domain;
        let unit = [[Interval::point(1.0), Interval::ZERO], [Interval::ZERO, Interval::point(1.0)]];
        let reference = |variables: [Variable; 2]| variables.map(|one| Interval::point(domain.reference(one)));
        let length = |vector: [Interval; 2]| vector[0].hypot(vector[1]).hi();
        let body = axes(heading_0);
        let turned = |vector: [Interval; 2]| [0, 1].map(|axis| body[0][axis] * vector[0] + body[1][axis] * vector[1]);
        let position = [0, 1].map(|axis| Variable::Constant(Constant::RangePosition(axis)));
        let lever_0 = turned(reference(position));
        for axis in 0..2 {
            let (place, pose) = (Variable::Landmark(landmark, axis), Variable::Pose(frame, axis));
            self.parts.push((place, unit[axis]));
            self.parts.push((pose, unit[axis].map(|side| -side)));
            self.parts.push((position[axis], body[axis].map(|side| -side)));
            self.at_reference[axis] = Interval::point(domain.reference(place)) - domain.reference(pose) - lever_0[axis];
        }
        self.parts.push((self.heading, [lever_0[1], -lever_0[0]]));
        let turn = Interval::point(domain.deviation(self.heading).magnitude());
        let lever_m = length(position.map(|axis| domain.value(axis)));
        let off_m = length(position.map(|axis| domain.deviation(axis)));
        let mut bent_m = turn * turn * lever_m / 2.0 + turn * off_m;
        let tilted = [0, 1].map(|axis| Variable::TiltedLandmark(landmark, axis));
        if tilted.iter().all(|&side| !domain.value(side).is_empty()) {
            self.parts.extend(tilted.into_iter().zip(body));
            let tilted_0 = turned(reference(tilted));
            (0..2).for_each(|axis| self.at_reference[axis] += tilted_0[axis]);
            bent_m += turn * length(tilted.map(|side| domain.value(side)));
        }
        self.at_reference.iter_mut().for_each(|side| *side += Interval::centred(0.0, bent_m.hi()));
    }

    /// The row that a unit vector's product with D gives: n₀·D + Σ other terms ∈ `sides`.
    fn row(&self, direction: [Interval; 2], others: &[(Variable, Interval)], sides: Interval) -> Row {
        let mut terms: Vec<(Variable, Interval)> =
            self.parts.iter().map(|&(variable, change)| (variable, dot(direction, change))).collect();
        terms.extend_from_slice(others);
        Row::new(self.domain, &terms, sides - dot(direction, self.at_reference)).by_device("range_camera")
    }

    /// The terms of a coefficient times δ = δθ + δyaw.
    fn times_delta(&self, coefficient: Interval) -> [(Variable, Interval); 2] {
        [(self.heading, coefficient), (Variable::Constant(Constant::RangeYaw), coefficient)]
    }

    /// The row across the ray of a view. The second view is one baseline b to the right of the first; with D less b·r in place of D its row is that
    /// of the first, and n₀·(b·r) = b·(f₀ cos δ − ū sin δ)/N.
    fn across_ray(&self, view: View) -> Row {
        let (focal, baseline) = (Variable::Constant(Constant::RangeFocal), Variable::Constant(Constant::RangeBaseline));
        let focal_0 = Interval::point(self.domain.reference(focal));
        let baseline_0 = Interval::point(self.domain.reference(baseline));
        let (column_px, right_m) = match view {
            View::First => (self.columns.first_px, self.right_m),
            View::Second => (self.columns.second_px, self.right_m - self.baseline_m),
        };
        let column_0 = Interval::point(column_px.mid());
        let length = (focal_0 * focal_0 + column_0 * column_0).sqrt();
        let across = [0, 1].map(|axis| -(focal_0 * self.left[axis] + column_0 * self.ahead[axis]) / length);
        let (sine, cosine_rest, sine_rest) = (self.delta.sin(), cosine_rest(self.delta), sine_rest(self.delta));

        let right_0 = Interval::point(right_m.mid());
        let along_m = (focal_0 * self.depth_m + column_0 * right_m) / length + self.blur_m;
        let along_0 = Interval::point(along_m.mid());
        let focal_off = self.domain.deviation(focal);
        // (n·D) cos δ and what the deviation of the focal length leaves of it.
        let cosine = Interval::point(1.0) - cosine_rest;
        let mut sides = ((column_px - column_0) * self.depth_m / length + self.blur_m) * cosine
            + focal_off * (right_0 - right_m * cosine) / length;
        sides -= (along_m - along_0) * sine + along_0 * sine_rest;
        let mut delta_coefficient = along_0;
        let mut others = vec![(focal, right_0 / length)];
        if view == View::Second {
            sides -= self.baseline_m * focal_0 * cosine_rest / length;
            sides -= column_0 * ((self.baseline_m - baseline_0) * sine + baseline_0 * sine_rest) / length;
            sides += baseline_0 * focal_0 / length;
            delta_coefficient += column_0 * baseline_0 / length;
            others.push((baseline, -focal_0 / length));
        }
        others.extend(self.times_delta(delta_coefficient));
        let by_columns_m = (column_px - column_0) * self.depth_m / length;
        self.row(across, &others, sides).with_part(bounds::RANGE_CAMERA_COLUMNS, by_columns_m.magnitude())
    }

    /// The row in depth, with Z = f·b/(u − w) linear in the deviations of f and b but for their product.
    fn in_depth(&self) -> Row {
        let (focal, baseline) = (Variable::Constant(Constant::RangeFocal), Variable::Constant(Constant::RangeBaseline));
        let (focal_0, baseline_0) = (self.domain.reference(focal), self.domain.reference(baseline));
        let (focal_share, baseline_share) =
            (self.domain.deviation(focal) / focal_0, self.domain.deviation(baseline) / baseline_0);
        let by_columns_m = Interval::point(focal_0) * baseline_0 / self.columns.disparity_px;
        let depth_0 = Interval::point(by_columns_m.mid());
        let right_0 = Interval::point(self.right_m.mid());
        let mut sides = by_columns_m
            + (by_columns_m - depth_0) * (focal_share + baseline_share)
            + by_columns_m * focal_share * baseline_share
            + self.blur_m;
        sides -= (self.depth_m + self.blur_m) * cosine_rest(self.delta);
        sides += (self.right_m + self.blur_m - right_0) * self.delta.sin() + right_0 * sine_rest(self.delta);
        let mut others = vec![(focal, -depth_0 / focal_0), (baseline, -depth_0 / baseline_0)];
        others.extend(self.times_delta(-right_0));
        self.row(self.ahead, &others, sides).with_part(bounds::RANGE_CAMERA_COLUMNS, by_columns_m.radius())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::graph::trial::{Draw, camera, rounds};

    #[test]
    fn the_truth_satisfies_every_row_at_the_corners_of_all_bounds() {
        let mut draw = Draw::new(20_261_123);
        for round in 0..rounds(60_000) {
            let mut domain = Domain::default();
            let mut truth = std::collections::BTreeMap::new();
            // Half of the bounds are 0, so that each kind of remainder is sometimes alone.
            let mut put = |variable, middle: f64, half: f64, draw: &mut Draw| {
                let half = draw.or_zero(half);
                let value = Interval::centred(middle, half);
                domain.put(variable, value);
                let at = draw.within(value);
                truth.insert(variable, at);
                at
            };
            let model = RangeCameraModel { step_px: [0.125; 2].map(|step| draw.or_zero(step)), ..camera() };
            let landmark = LandmarkId(7);
            let size = draw.size(1e-4, 0.3);
            let heading = put(Variable::Pose(3, 2), draw.between(-7.0, 7.0), draw.size(1e-4, 0.2), &mut draw);
            let x = put(Variable::Pose(3, 0), draw.between(-9.0, 9.0), size, &mut draw);
            let y = put(Variable::Pose(3, 1), draw.between(-9.0, 9.0), size, &mut draw);
            let constant = Variable::Constant;
            let forward = put(constant(Constant::RangePosition(0)), 0.1, 0.02, &mut draw);
            let left = put(constant(Constant::RangePosition(1)), 0.06, 0.02, &mut draw);
            let yaw = put(constant(Constant::RangeYaw), draw.between(-0.5, 0.5), 0.02, &mut draw);
            let focal = put(constant(Constant::RangeFocal), 400.0, 8.0, &mut draw);
            let baseline = put(constant(Constant::RangeBaseline), 0.12, 0.006, &mut draw);
            let most_tilted_m = draw.size(1e-5, 0.03);
            let tilted =
                [0, 1].map(|axis| put(Variable::TiltedLandmark(landmark, axis), 0.0, most_tilted_m, &mut draw));

            // The true place of the landmark by the columns, turned and moved into the world.
            let (ahead_m, right_m) = (draw.between(0.4, 6.0), draw.between(-0.8, 0.8));
            let columns = [focal * right_m / ahead_m, focal * (right_m - baseline) / ahead_m];
            let most_m = draw.between(0.0, 0.01);
            let blur_m = draw.or_zero(most_m);
            let (away, turn) = (draw.between(0.0, std::f64::consts::TAU), heading + yaw);
            let at = [
                x + (forward - tilted[0]) * heading.cos() - (left - tilted[1]) * heading.sin()
                    + ahead_m * turn.cos()
                    + right_m * turn.sin()
                    + blur_m * away.cos(),
                y + (forward - tilted[0]) * heading.sin() + (left - tilted[1]) * heading.cos() + ahead_m * turn.sin()
                    - right_m * turn.cos()
                    + blur_m * away.sin(),
            ];
            for (axis, at) in at.into_iter().enumerate() {
                let off = draw.between(-0.3, 0.3);
                domain.put(Variable::Landmark(landmark, axis), Interval::centred(at + off, 0.4));
                truth.insert(Variable::Landmark(landmark, axis), at);
            }
            let read = |column: f64, step: f64, draw: &mut Draw| {
                model.centre_px + draw.within(Interval::centred(column, 0.5 * step))
            };
            let left_px = read(columns[0], model.step_px[0], &mut draw);
            let right_px = read(columns[1], model.step_px[1], &mut draw);
            let sighting = Sighting { landmark, left_px, right_px };
            let columns = Columns::of(&model, &sighting);
            for (idx, row) in sighting_rows(landmark, columns, blur_m, 3, &domain).iter().enumerate() {
                let value = row.value_at(|variable| truth[&variable] - domain.reference(variable));
                assert!(row.sides.inflate(1e-12).contains(value), "round {round}, row {idx}: {value}, {}", row.sides);
            }
        }
    }

    #[test]
    fn columns_that_tell_no_disparity_leave_it_to_the_disparity() {
        // The columns alone allow disparities from -1 to 3 px, of which 1 to 2 px are possible: 6 px by them is 2.5 to 6.
        let side = |lo: f64, hi: f64| Interval::new(lo, hi);
        let wide = Columns { first_px: side(5.0, 6.0), second_px: side(3.0, 6.0), disparity_px: side(1.0, 2.0) };
        let [ratio] = wide.hull_over(|first_px, disparity_px| [first_px / disparity_px]);
        assert!(side(2.5, 6.0).is_subset_of(ratio) && ratio.width() < 3.5 + 1e-9, "{ratio}");
    }

    #[test]
    fn a_row_is_hardly_wider_than_the_reading() {
        // Everything is known exactly but the columns: at 2 m the row across the ray is as wide as the cell, 0.125 px of 400 at 2 m.
        let mut domain = Domain::default();
        let exactly = [
            (Variable::Pose(0, 0), 0.0),
            (Variable::Pose(0, 1), 0.0),
            (Variable::Pose(0, 2), 0.0),
            (Variable::Constant(Constant::RangePosition(0)), 0.0),
            (Variable::Constant(Constant::RangePosition(1)), 0.0),
            (Variable::Constant(Constant::RangeYaw), 0.0),
            (Variable::Constant(Constant::RangeFocal), 400.0),
            (Variable::Constant(Constant::RangeBaseline), 0.12),
        ];
        exactly.iter().for_each(|&(variable, value)| domain.put(variable, Interval::point(value)));
        for axis in 0..2 {
            domain.put(Variable::Landmark(LandmarkId(1), axis), Interval::new(-5.0, 5.0));
        }
        let model = camera();
        // Depth 400·0.12/24 = 2 m, on the axis of the first view.
        let sighting = Sighting { landmark: LandmarkId(1), left_px: model.centre_px, right_px: model.centre_px - 24.0 };
        let rows = sighting_rows(LandmarkId(1), Columns::of(&model, &sighting), 0.0, 0, &domain);
        let across_m = rows[0].sides.width();
        assert!((across_m - 0.125 / 400.0 * 2.0).abs() < 1e-5, "{across_m}");
        // The disparity is 24 ± 0.125 px, and the depth 2 m ± 0.125/24.
        let depth_m = rows[2].sides;
        assert!((depth_m.width() - 2.0 * 2.0 * 0.125 / 24.0).abs() < 2e-4, "{depth_m}");
        assert!(depth_m.contains(2.0));
    }
}

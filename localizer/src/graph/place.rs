//! Rows of a point of the world that a camera on the robot sees, or that is on the robot itself and whose place in the world is known, as that of an
//! antenna.
//!
//! Let P and θ be the robot's position and heading at the stamp, W the point in the world, and a the point in the robot frame turned by the error of
//! the camera's yaw, ψ = θ + yaw − nominal yaw. Then W − P = R(ψ)·a. The camera's model gives a to first order: a = a₀ + Σ S·(v − v₀) + noise, with
//! the constants of the camera and the lean of the body as quantities v, and intervals S that enclose the derivatives over the whole box of the
//! quantities (mean value form). With ψ = ψ₀ + δ, any unit vector n of the world, m = R(−ψ₀)·n, and J the quarter turn to the left,
//!
//! n·W − n·P = m·R(δ)·a = (m·a) cos δ + (m·J·a) sin δ,
//!
//! which is linear in a and in δ but for (m·a)(1 − cos δ), (m·J·a − k₀) sin δ and k₀ (sin δ − δ), with k₀ the reference value of m·J·a. These are
//! enclosed over the boxes and added to the sides of the row.

use interval::Interval;

use crate::bounds::Assumption;

use super::{
    Constant, Domain, Row, Variable,
    row::{axes, cosine_rest, dot, sine_rest},
};

/// Place of a point of the building that a camera sees, in the robot frame turned by the error of the camera's yaw.
#[derive(Clone, Debug)]
pub struct SeenPlace {
    /// Name of the camera, as in the names of its bounds.
    pub device: &'static str,
    /// The camera's rotation about the vertical, and its nominal value; `None` where the place is known in the robot frame itself.
    pub yaw: Option<(Constant, f64)>,
    /// The place, forward and left, where every quantity has the value that it is counted from.
    pub middle_m: [Interval; 2],
    /// Quantities that the place depends on, each with the value that it is counted from, and the derivatives of forward and left. A quantity of a
    /// key frame is that of the key frame of the reading, whatever number is given here.
    pub terms: Vec<(Variable, f64, [Interval; 2])>,
    /// Errors of this reading of the point alone: vectors forward and left, each times an unknown number in an interval, with the declared bound that
    /// the number has.
    pub noise_m: Vec<([Interval; 2], Interval, Option<Assumption>)>,
    /// Greatest turn of the picture about the vertical that neither the heading nor the camera's yaw tells.
    pub turn_rad: f64,
}

/// A point that a camera saw at a key frame, with all that its place in the robot's frame is computed from: the pose of the key frame and the other
/// quantities of the graph, each as a reference value and a box around it.
pub struct PlaceAt<'a> {
    seen: &'a SeenPlace,
    domain: &'a Domain,
    frame: usize,
    /// Unit vectors ahead and to the left at the reference ψ₀.
    axes: [[Interval; 2]; 2],
    /// Possible δ = ψ − ψ₀.
    delta: Interval,
    /// The place at the reference values of the quantities, and over their boxes with all noise.
    at_reference_m: [Interval; 2],
    over_box_m: [Interval; 2],
}

impl SeenPlace {
    /// Counts the place from the camera's position and yaw. So far the place depends on the position m of the camera in the robot frame turned by the
    /// error δ of the yaw, m′ = R(−δ)·m, where it is `middle_m` for m′ = `at_m`, and changes by `columns` with the components of m′.
    pub fn mounted(
        &mut self,
        position: [Constant; 2],
        position_m: [Interval; 2],
        yaw_rad: Interval,
        (at_m, columns): ([f64; 2], [[Interval; 2]; 2]),
    ) {
        let nominal_rad = self.yaw.map_or(0.0, |(_, nominal_rad)| nominal_rad);
        let error = yaw_rad - nominal_rad;
        let (cos, sin) = (error.cos(), error.sin());
        let along = |m: [Interval; 2]| [0, 1].map(|axis| columns[0][axis] * m[0] + columns[1][axis] * m[1]);
        let middle_m = position_m.map(Interval::mid);
        let shift = along([0, 1].map(|axis| Interval::point(middle_m[axis]) - at_m[axis]));
        (0..2).for_each(|axis| self.middle_m[axis] += shift[axis]);
        self.terms.push((Variable::Constant(position[0]), middle_m[0], along([cos, -sin])));
        self.terms.push((Variable::Constant(position[1]), middle_m[1], along([sin, cos])));
        let [forward, left] = position_m;
        let by_yaw = along([left * cos - forward * sin, -(forward * cos + left * sin)]);
        self.terms.extend(self.yaw.map(|(yaw, nominal_rad)| (Variable::Constant(yaw), nominal_rad, by_yaw)));
    }

    /// The point at a key frame, whose pose in the domain is that of the picture.
    pub fn at<'a>(&'a self, frame: usize, domain: &'a Domain) -> PlaceAt<'a> {
        let heading = Variable::Pose(frame, 2);
        let (mut psi, mut delta) = (Interval::point(domain.reference(heading)), domain.deviation(heading));
        if let Some((yaw, nominal_rad)) = self.yaw {
            psi = psi + domain.reference(Variable::Constant(yaw)) - nominal_rad;
            delta += domain.deviation(Variable::Constant(yaw));
        }
        let (mut at_reference_m, mut over_box_m) = (self.middle_m, self.middle_m);
        for &(variable, about, slopes) in &self.terms {
            let variable = variable.at_frame(frame);
            let off = Interval::point(domain.reference(variable)) - about;
            let anywhere = domain.value(variable) - about;
            for axis in 0..2 {
                at_reference_m[axis] += slopes[axis] * off;
                over_box_m[axis] += slopes[axis] * anywhere;
            }
        }
        for &(slopes, noise, _) in &self.noise_m {
            (0..2).for_each(|axis| over_box_m[axis] += slopes[axis] * noise);
        }
        PlaceAt { seen: self, domain, frame, axes: axes(psi), delta, at_reference_m, over_box_m }
    }
}

impl PlaceAt<'_> {
    /// Unit vectors of the world ahead of the robot and to its left at the reference heading, turned by the reference error of the camera's yaw.
    pub fn axes(&self) -> [[Interval; 2]; 2] {
        self.axes
    }

    /// Interval of the point's coordinate along a unit vector of the world, over the boxes of the pose and of all other quantities.
    pub fn along(&self, direction: [Interval; 2]) -> Interval {
        let turned = self.turned(direction, self.over_box_m);
        let place = turned[0] * (1.0 - cosine_rest(self.delta)) + turned[1] * self.delta.sin();
        let position = [0, 1].map(|axis| self.domain.value(Variable::Pose(self.frame, axis)));
        (dot(direction, position) + place).inflate(self.blur_m())
    }

    /// The row n·P + … of the point along a unit vector n of the world, where the coordinate n·W of the point is `along_m` plus the sum of the given
    /// coefficients times deviations from reference values.
    pub fn row(&self, direction: [Interval; 2], along_m: Interval, others: &[(Variable, Interval)]) -> Row {
        let (domain, frame) = (self.domain, self.frame);
        let [ahead, left] = self.turned(direction, self.over_box_m);
        let left_0 = Interval::point(left.mid());
        let mut terms = others.to_vec();
        let mut sides = -along_m;
        for (axis, side) in direction.into_iter().enumerate() {
            let position = Variable::Pose(frame, axis);
            terms.push((position, -side));
            sides += side * domain.reference(position);
        }
        let in_picture = [0, 1].map(|axis| dot(direction, self.axes[axis]));
        for &(variable, _, slopes) in &self.seen.terms {
            terms.push((variable.at_frame(frame), -dot(in_picture, slopes)));
        }
        terms.push((Variable::Pose(frame, 2), -left_0));
        terms.extend(self.seen.yaw.map(|(yaw, _)| (Variable::Constant(yaw), -left_0)));
        sides += dot(in_picture, self.at_reference_m);
        let mut parts = Vec::new();
        for &(slopes, noise, bound) in &self.seen.noise_m {
            let error = dot(in_picture, slopes) * noise;
            sides += error;
            parts.extend(bound.map(|bound| (bound, error.radius())));
        }
        sides -= ahead * cosine_rest(self.delta);
        sides += (left - left_0) * self.delta.sin() + left_0 * sine_rest(self.delta);
        Row::new(domain, &terms, sides.inflate(self.blur_m())).by_device(self.seen.device).with_parts(1.0, &parts)
    }

    /// m·a and m·J·a of a place a.
    fn turned(&self, direction: [Interval; 2], place_m: [Interval; 2]) -> [Interval; 2] {
        let m = [0, 1].map(|axis| dot(direction, self.axes[axis]));
        [dot(m, place_m), m[1] * place_m[0] - m[0] * place_m[1]]
    }

    /// Greatest distance by which turns beside ψ move the point: a chord is shorter than its arc.
    fn blur_m(&self) -> f64 {
        (self.over_box_m[0].hypot(self.over_box_m[1]) * self.seen.turn_rad).hi()
    }
}

#[cfg(test)]
mod remainders;

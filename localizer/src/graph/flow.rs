//! Rows of the flow sensor's way from one key frame to the next.
//!
//! The sensor's place is q = P + R(θ)·a, with its position a in the robot frame. With the sums of [`FlowWay`], the metres per count m, and
//! K = 1/(1 − κ²) for a scale that varies by the share κ,
//!
//! q_b − q_a + E_b − E_a = K·m·R(φ_a + yaw)·(turned counts) ± rest,
//!
//! where E is the error of the place by the counts at a key frame ([`Variable::FlowPlace`]). The turned counts are a linear function of the
//! deviations of both headings, of the mount's yaw and of the gyroscope's scale, but for half of the square of the whole deviation times the path.
//! The turns were computed with a middle m₀ of the gyroscope's scale, so that the true ones beyond a uniform turn are ρ times as large, ρ = m₀/scale.
//! The scale may be known better by now, about a reference c other than m₀: ρ = m₀/c − m₀·(scale − c)/c² + m₀·(scale − c)²/(scale·c²).
//! The lever arm R(θ)·a is linear but for |a|·δθ²/2 + |δa|·|δθ|. Where the gyroscope's accumulated angle error is bounded, θ + u/scale takes the
//! place of θ in the turned counts ([`Variable::GyroAngle`]).

use interval::Interval;

use crate::{bounds, motion::FlowWay};

use super::{
    Constant, Domain, Row, Variable,
    row::{axes, dot},
};

/// The rows along world x and y of the flow sensor's way from key frame number `from` to number `to`. `shares_error` says whether the error of the
/// place at the first key frame is the same as in the way before. `scale_change` is the share by which the sensor's scale varies.
pub fn flow_rows(
    way: &FlowWay,
    [from, to]: [usize; 2],
    shares_error: bool,
    scale_change: f64,
    domain: &Domain,
) -> [Row; 2] {
    let flow = Flow::new(way, [from, to], scale_change, domain);
    [0, 1].map(|axis| flow.row(axis, shares_error))
}

/// What both rows of a way have in common.
struct Flow<'a> {
    way: &'a FlowWay,
    frames: [usize; 2],
    domain: &'a Domain,
    /// K·m at the reference of m.
    metres: Interval,
    /// R(φ_a + yaw) at the reference heading and yaw, applied to the sums of counts: all of them, weighted late, and weighted by the bulge.
    counts: [[Interval; 2]; 3],
    /// θ_b − θ_a − Ψ at the reference headings.
    gap: Interval,
    /// What the rows lose by linearisation.
    second_m: f64,
}

impl<'a> Flow<'a> {
    fn new(way: &'a FlowWay, frames: [usize; 2], scale_change: f64, domain: &'a Domain) -> Flow<'a> {
        let constant = Variable::Constant;
        let reference = |variable| Interval::point(domain.reference(variable));
        let heading = frames.map(|frame| Variable::Pose(frame, 2));
        let [ahead, left] = axes(reference(heading[0]) + reference(constant(Constant::FlowYaw)));
        let turned = |counts: [f64; 2]| {
            let counts = counts.map(Interval::point);
            [0, 1].map(|axis| ahead[axis] * counts[0] + left[axis] * counts[1])
        };
        let gap = reference(heading[1]) - reference(heading[0]) - Interval::point(way.turn_rad);
        let varying = Interval::point(scale_change);
        let metres = constant(Constant::FlowMetresPerCount);

        let most = |variable| domain.deviation(variable).magnitude();
        let scale = domain.value(constant(Constant::GyroScale));
        let angle = |frame| {
            let angle = domain.value(Variable::GyroAngle(frame));
            if angle.is_empty() { 0.0 } else { angle.magnitude() / scale.lo() }
        };
        let off =
            [most(heading[0]) + angle(frames[0]), (domain.deviation(heading[1]) + gap).magnitude() + angle(frames[1])];
        let scale_share = Interval::point(most(constant(Constant::GyroScale))) / scale;
        let scale_0 = reference(constant(Constant::GyroScale));
        let bulged = ((Interval::point(way.middle_scale) - scale) / scale).magnitude() * way.bulge_rad;
        let bulge_rest = Interval::point(way.middle_scale) * scale_share * most(constant(Constant::GyroScale))
            / (scale_0 * scale_0)
            * way.bulge_rad;
        let most_off = Interval::point(off[0].max(off[1]))
            + Interval::point(bulged)
            + way.heading_error_rad
            + most(constant(Constant::FlowYaw));
        let share = Interval::point(most(metres)) / domain.value(metres);
        // Second order: of the turn, of the turn with the metres per count, of the gyroscope's scale, and of the middle of the scale with u.
        let angle_off = (angle(frames[0]) + angle(frames[1])) * scale_share.hi();
        let second = most_off * most_off / 2.0 + share * most_off + bulge_rest + angle_off;
        Flow {
            way,
            frames,
            domain,
            metres: reference(metres) / (Interval::ONE - varying * varying),
            counts: [way.counts, way.late_counts, way.turned_counts].map(turned),
            gap,
            second_m: (second * way.path_m).hi(),
        }
    }

    fn row(&self, axis: usize, shares_error: bool) -> Row {
        let (domain, [from, to], way) = (self.domain, self.frames, self.way);
        let one = Interval::ONE;
        let mut terms = Vec::with_capacity(20);
        let mut sides = Interval::centred(0.0, self.second_m + way.error_m[axis]);

        // P_b − P_a + R(θ_b)·a − R(θ_a)·a.
        for (frame, sign) in [(to, one), (from, -one)] {
            let pose = Variable::Pose(frame, axis);
            terms.push((pose, sign));
            sides -= sign * domain.reference(pose);
            sides -= self.lever(frame, sign, axis, &mut terms);
        }
        // E_b − E_a.
        terms.push((Variable::FlowPlace(to, axis), one));
        if shares_error {
            terms.push((Variable::FlowPlace(from, axis), -one));
        } else {
            sides += Interval::centred(0.0, way.end_error_m[0]);
        }

        // −K·m·R(φ_a + yaw)·(turned counts).
        let [all, late, bulge] = self.counts;
        let across = |counts: [Interval; 2]| self.metres * if axis == 0 { -counts[1] } else { counts[0] };
        sides += self.metres * all[axis] + across(late) * self.gap;
        let (early_by, late_by) = (across(all) - across(late), across(late));
        let scale = Variable::Constant(Constant::GyroScale);
        let scale_0 = Interval::point(domain.reference(scale));
        for (frame, by) in [(from, early_by), (to, late_by)] {
            terms.push((Variable::Pose(frame, 2), -by));
            if !domain.value(Variable::GyroAngle(frame)).is_empty() {
                terms.push((Variable::GyroAngle(frame), -by / scale_0));
            }
        }
        let middle = Interval::point(way.middle_scale);
        sides += across(bulge) * (middle - scale_0) / scale_0;
        terms.push((scale, across(bulge) * middle / (scale_0 * scale_0)));
        terms.push((Variable::Constant(Constant::FlowYaw), -across(all)));
        let metres = Variable::Constant(Constant::FlowMetresPerCount);
        terms.push((metres, -self.metres * all[axis] / domain.reference(metres)));
        let angle_is_bounded = !domain.value(Variable::GyroAngle(from)).is_empty();
        let noise = if angle_is_bounded { bounds::GYRO_ANGLE } else { bounds::GYRO_NOISE };
        Row::new(domain, &terms, sides)
            .with_part(bounds::FLOW_SCALE, way.scale_error_m[axis])
            .with_part(noise, way.noise_error_m[axis])
            .by_device("flow")
            .by_device("gyro")
    }

    /// Adds the terms of `sign`·R(θ)·a along an axis of the world, and returns its value at the reference with what is not linear.
    fn lever(&self, frame: usize, sign: Interval, axis: usize, terms: &mut Vec<(Variable, Interval)>) -> Interval {
        let domain = self.domain;
        let heading = Variable::Pose(frame, 2);
        let position = [0, 1].map(|side| Variable::Constant(Constant::FlowPosition(side)));
        let [ahead, left] = axes(Interval::point(domain.reference(heading)));
        let along = [ahead[axis], left[axis]];
        let across = if axis == 0 { [-ahead[1], -left[1]] } else { [ahead[0], left[0]] };
        let arm_0 = position.map(|side| Interval::point(domain.reference(side)));
        terms.push((heading, sign * dot(across, arm_0)));
        (0..2).for_each(|side| terms.push((position[side], sign * along[side])));
        let length = |vector: [Interval; 2]| vector[0].hypot(vector[1]).hi();
        let turn = Interval::point(domain.deviation(heading).magnitude());
        let arm_m = length(position.map(|side| domain.value(side)));
        let off_m = length(position.map(|side| domain.deviation(side)));
        let bent_m = (turn * turn * arm_m / 2.0 + turn * off_m).hi();
        sign * dot(along, arm_0) + Interval::centred(0.0, bent_m)
    }
}

#[cfg(test)]
mod remainders;
#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests;

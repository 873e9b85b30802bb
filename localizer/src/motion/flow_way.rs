//! The way of the flow sensor's place between two stamps, with the relations that a box of the motion loses.
//!
//! **Between two headings.** Let φ(t) be the heading, ψ(t) the turn since the first stamp a that the gyroscope tells with the middles of its
//! bias and scale, Ψ that up to the last stamp b, and s = (t − a)/(b − a). The gyroscope's bias makes an error of the turn in proportion to s, so
//! that it cancels when the heading is interpolated between its true values at both ends:
//!
//! φ(t) = (1 − s)·φ(a) + s·φ(b) + ρ·(ψ(t) − s·Ψ) + β(t),
//!
//! with ρ the middle of the gyroscope's scale over its true scale. What is left, β, comes from noise and from the bias's changes alone. Where the
//! bound `gyro.angle` is declared, the accumulated angle error is u + v with |u| at most half of the bound's constant part (see
//! [`GyroTurn`]); with φ + u/scale in place of φ at both ends, |β| ≤ (|u| + |v(t) − (1 − s)·v(a) − s·v(b)|)/scale.
//!
//! **Displacement.** With the counts Δc of each reading the place of the sensor moves by m′·R(yaw)·Σ R(φ)·Δc and a rest; [`super::flow`] derives
//! m′, the share of the rest by a varying scale, and how quantisation telescopes. To first order in the deviations of φ(a), φ(b) and ρ this sum
//! needs only Σ R(ψ)·Δc, Σ s·R(ψ)·Δc and Σ (ψ − s·Ψ)·R(ψ)·Δc.
//!
//! **Within a step.** The gyroscope is often read several times within a step of the flow sensor. Let f be the turn that is linear between the stamps
//! of its readings, less its mean over the step, and h what is left: |h| ≤ α·τ²/8 for stamps a time τ apart and turn rates that change by at most α.
//! The place's velocity departs from its mean over the step, of length T, by at most A·T/2. As ∫ f dt = 0, f moves the place by at most A·T/2·∫ |f|
//! dt, or by the greatest |f| times the path if that is less.

use interval::Interval;

use crate::robot::{FlowModel, Reach, WheelModel};

use super::{
    FlowHistory, GyroHistory, GyroTurn,
    flow_history::FlowStep,
    gyro::{ProfileStep, greatest_change_rad_per_s2},
};

/// What the flow sensor and the gyroscope tell of the way of the flow sensor's place between two stamps.
#[derive(Clone, Debug, PartialEq)]
pub struct FlowWay {
    /// Length of time between the two stamps.
    pub span_s: f64,
    /// What the gyroscope tells of the turn.
    pub gyro: GyroTurn,
    /// The middle of the gyroscope's scale with which the turns of this way were computed. By the time at which a row is made of the way, the scale may
    /// be known better.
    pub middle_scale: f64,
    /// Ψ: the turn between the stamps by the gyroscope, with the middles of its bias and scale.
    pub turn_rad: f64,
    /// Σ R(ψ)·Δc: the counts of all readings, forward and left, turned into the robot frame at the first stamp but for the mount's yaw.
    pub counts: [f64; 2],
    /// Σ s·R(ψ)·Δc: the same, weighted by the share of the time that has passed.
    pub late_counts: [f64; 2],
    /// Σ (ψ − s·Ψ)·R(ψ)·Δc: the same, weighted by the turn beyond a uniform one.
    pub turned_counts: [f64; 2],
    /// Greatest |ψ − s·Ψ|.
    pub bulge_rad: f64,
    /// Greatest |β|: error of the interpolated heading by the gyroscope's noise.
    pub heading_error_rad: f64,
    /// Greatest length of the place's path.
    pub path_m: f64,
    /// Greatest error of the displacement along world x and y: by a scale that varies, by the gyroscope's noise, by turning within a step, and by
    /// quantisation while turning.
    pub error_m: [f64; 2],
    /// The part of `error_m` that a varying scale makes.
    pub scale_error_m: [f64; 2],
    /// The part of `error_m` that the gyroscope's noise makes.
    pub noise_error_m: [f64; 2],
    /// At either end, the greatest distance of the place by the counts from the true place, along any axis: by quantisation, and where the stamp lies
    /// between two readings by interpolation.
    pub end_error_m: [f64; 2],
    /// Stamps of the two readings beside either end. The error at an end is the same vector in the way before and in the way after, if both know the
    /// same two readings.
    pub end_readings_s: [[f64; 2]; 2],
}

impl FlowHistory {
    /// The way of the flow sensor's place between two stamps. `heading_rad` encloses the heading at the first one, which decides how much of a
    /// varying scale's error goes along world x and y. `None` without readings that cover the time, and where the flow sensor saw nothing for a
    /// period.
    pub(super) fn way(
        &self,
        span_s: [f64; 2],
        heading_rad: Interval,
        gyro: &GyroHistory,
        wheels: &WheelModel,
        reach: &Reach,
    ) -> Option<FlowWay> {
        let change_rad_per_s2 = greatest_change_rad_per_s2(wheels, reach);
        let acceleration_m_per_s2 = self.acceleration_m_per_s2(change_rad_per_s2, reach);
        let steps = self.steps(span_s, acceleration_m_per_s2)?;
        let (first, last) = (steps.first()?, steps.last()?);
        let stamps: Vec<f64> =
            std::iter::once(span_s[0]).chain(steps.iter().flat_map(|step| step.nodes_s(gyro.period_s()))).collect();
        let mut profile = vec![ProfileStep::default()];
        profile.extend(gyro.profile(&stamps, change_rad_per_s2)?);
        let end = *profile.last()?;
        let turn_rad = end.turn_rad;
        let model = self.model();
        let lost_m = model.quantisation_counts * model.metres_per_count.hi() / (1.0 - model.scale_change);
        let quantised_m = std::f64::consts::FRAC_1_SQRT_2 * lost_m * ABOVE;
        let turn_error_rad = gyro.turn(span_s[0], span_s[1], change_rad_per_s2)?.width();
        let mut sum = Sum {
            model,
            change_rad_per_s2,
            acceleration_m_per_s2,
            lasts_s: span_s[1] - span_s[0],
            turn_rad,
            about_rad: heading_rad.mid() + model.yaw_rad.mid(),
            margin_rad: heading_rad.radius() + model.yaw_rad.radius() + turn_error_rad,
            end,
            way: FlowWay {
                span_s: span_s[1] - span_s[0],
                gyro: gyro.turn_read(span_s[0], span_s[1], change_rad_per_s2)?,
                middle_scale: gyro.middle_scale(),
                turn_rad,
                counts: [0.0; 2],
                late_counts: [0.0; 2],
                turned_counts: [0.0; 2],
                bulge_rad: 0.0,
                heading_error_rad: 0.0,
                path_m: 0.0,
                error_m: [0.0; 2],
                scale_error_m: [0.0; 2],
                noise_error_m: [0.0; 2],
                end_error_m: [first.cut_m[0], last.cut_m[1]].map(|cut_m| cut_m + quantised_m),
                end_readings_s: [first.beside_s(0), last.beside_s(1)],
            },
        };
        let mut from = 0;
        for step in &steps {
            let to = from + step.n_nodes(gyro.period_s());
            sum.add(step, &profile[from..=to]);
            from = to;
        }
        let mut way = sum.way;
        way.error_m = way.error_m.map(|error_m| error_m * ABOVE + ROUNDING * way.path_m);
        Some(way)
    }
}

/// The sums over the steps of a way.
struct Sum<'a> {
    model: &'a FlowModel,
    change_rad_per_s2: f64,
    acceleration_m_per_s2: f64,
    lasts_s: f64,
    turn_rad: f64,
    /// Direction of the sensor's forward axis in the world at the first stamp, and how far it may be from that at any time, beside ψ.
    about_rad: f64,
    margin_rad: f64,
    /// What the gyroscope tells up to the last stamp.
    end: ProfileStep,
    way: FlowWay,
}

impl Sum<'_> {
    /// Adds one step of the flow sensor, at whose ends and between which the turn is known at some stamps.
    fn add(&mut self, step: &FlowStep, nodes: &[ProfileStep]) {
        let (model, way) = (self.model, &mut self.way);
        let counts = [0, 1].map(|axis| step.to[axis] - step.from[axis]);
        let (before, after) = (&nodes[0], &nodes[nodes.len() - 1]);
        let n_parts = (nodes.len() - 1) as f64;
        let mean = |of: &dyn Fn(&ProfileStep) -> f64| {
            nodes.windows(2).map(|pair| 0.5 * (of(&pair[0]) + of(&pair[1]))).sum::<f64>() / n_parts
        };
        let middle_rad = mean(&|node| node.turn_rad);
        let (sin, cos) = middle_rad.sin_cos();
        let turned = [cos * counts[0] - sin * counts[1], sin * counts[0] + cos * counts[1]];
        let share = 0.5 * (before.lasts_s + after.lasts_s) / self.lasts_s;
        let bulge_rad = middle_rad - share * self.turn_rad;
        for (axis, counts) in turned.into_iter().enumerate() {
            way.counts[axis] += counts;
            way.late_counts[axis] += share * counts;
            way.turned_counts[axis] += bulge_rad * counts;
        }
        way.bulge_rad = way.bulge_rad.max(bulge_rad.abs());

        // The path of the step, and its parts along the sensor's axes.
        let (metres, change) = (model.metres_per_count.hi(), model.scale_change);
        let lost = std::f64::consts::SQRT_2 * model.quantisation_counts;
        let excess_m = std::f64::consts::SQRT_2 * step.excess_m;
        let path_m = (metres * (counts[0].hypot(counts[1]) + lost) + excess_m) / (1.0 - change);
        way.path_m += path_m;
        let counted_m = counts.map(|counts| (counts.abs() + model.quantisation_counts) * metres);
        let varied_m =
            counted_m.map(|counted_m| change * (counted_m / (1.0 - change * change) + step.excess_m / (1.0 - change)));
        let parts_m = counted_m.map(|counted_m| (counted_m + step.excess_m) / (1.0 - change));

        // Errors of the heading: that of the interpolation, and between two of the stamps what the heading departs from the chord.
        let step_s = after.lasts_s - before.lasts_s;
        let part_s = step_s / n_parts;
        let bend_rad = self.change_rad_per_s2 * part_s * part_s / 8.0;
        let off_rad = nodes.iter().map(|node| node.off_between(&self.end)).fold(0.0, f64::max) + bend_rad;
        way.heading_error_rad = way.heading_error_rad.max(off_rad);
        // Turning within the step, about the mean heading.
        let step_error_rad: f64 = nodes[1..].iter().map(|node| node.step_error_rad).sum();
        let swing = |node: &ProfileStep| (node.turn_rad - middle_rad).abs() + 0.5 * step_error_rad;
        let most_rad = nodes.iter().map(swing).fold(0.0, f64::max);
        let swung_m = (most_rad * path_m).min(
            0.5 * mean(&swing) * self.acceleration_m_per_s2 * step_s * step_s + 0.5 * most_rad * most_rad * path_m,
        );
        let turning_rad =
            (0..nodes.len() - 1).map(|at| (nodes[at + 1].turn_rad - nodes[at].turn_rad).abs()).sum::<f64>()
                + step_error_rad
                + before.bend_rad
                + after.bend_rad
                + 4.0 * n_parts * bend_rad;
        let any_m = swung_m + 0.5 * metres * lost * turning_rad / (1.0 - change);

        // An error of the heading displaces across the direction of motion, a varying scale along it.
        let (sin, cos) = (self.about_rad + middle_rad).sin_cos();
        let [cos, sin] = [cos, sin].map(|part| part.abs() + self.margin_rad + most_rad + bend_rad);
        let along = |forward: f64, left: f64| [cos * forward + sin * left, sin * forward + cos * left];
        let (varied_m, way_m) = (along(varied_m[0], varied_m[1]), along(parts_m[0], parts_m[1]));
        for axis in 0..2 {
            way.error_m[axis] += varied_m[axis] + off_rad * way_m[1 - axis] + any_m;
            way.scale_error_m[axis] += varied_m[axis];
            way.noise_error_m[axis] += off_rad * way_m[1 - axis];
        }
    }
}

impl ProfileStep {
    /// Greatest error of the heading that is interpolated between the first stamp of a profile and its end, at this stamp: by what is bounded at
    /// every instant, and by what grows with time on either side.
    fn off_between(&self, end: &ProfileStep) -> f64 {
        let share = if end.lasts_s > 0.0 { self.lasts_s / end.lasts_s } else { 0.0 };
        let after_rad = (end.grows_rad - self.grows_rad).max(0.0) + end.at_once_rad;
        let grown_rad = (1.0 - share) * (self.grows_rad + self.at_once_rad) + share * after_rad;
        self.floor_rad + grown_rad + self.bend_rad + share * end.bend_rad
    }
}

/// Factor by which a sum of positive error bounds is increased, to make up for the few roundings of the sum.
const ABOVE: f64 = 1.0 + 1e-9;
/// Share of the path by which sums over all steps may be off by rounding: far more than a thousand roundings make.
const ROUNDING: f64 = 1e-12;

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod remainders;

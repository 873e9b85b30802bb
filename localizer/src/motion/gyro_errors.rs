//! The gyroscope's bias and scale, estimated together as a set.
//!
//! Over a span of length T in which the robot turns by Δθ, readings r = scale·ω + bias + noise add up to ∫r dt = scale·Δθ + bias·T ± noise. So a
//! turn that is known from elsewhere leaves a strip of the plane (bias, scale), which is oblique unless the robot was at rest. Laps in one
//! direction of turning leave errors of bias and scale that compensate each other; they compensate again when they are used in such laps, and
//! cost nothing.

use interval::{Interval, contractor::Outcome};

use crate::{bounds, bounds::Assumption, robot::GyroModel};

use super::polygon::Polygon;

/// What is known of the gyroscope's bias and scale, and since which stamps.
#[derive(Clone, Debug)]
pub struct GyroErrors {
    declared: Polygon,
    drift: Drift,
    /// The set of biases and scales that is known, with the stamp at which it is; `None` before anything is learnt.
    known: Option<(f64, Polygon)>,
}

/// How far the gyroscope's bias may depart from the bias that is known.
#[derive(Clone, Copy, Debug)]
enum Drift {
    /// The bias does not depart: what is known is the bias of the whole run, the one from which the declared bound `gyro.angle` on the accumulated
    /// angle error counts.
    None,
    /// The known gyroscope bias is that at one stamp; from there the bias changes by at most this amount per time.
    Wander(f64),
}

impl Drift {
    /// Greatest distance of the gyroscope's bias in a span of time from the bias known at a stamp.
    fn departs(self, known_s: f64, [from_s, to_s]: [f64; 2]) -> f64 {
        match self {
            Drift::None => 0.0,
            Drift::Wander(rad_per_s2) => rad_per_s2 * (to_s - known_s).abs().max((known_s - from_s).abs()),
        }
    }
}

impl GyroErrors {
    /// The gyroscope's declared bias and scale, before anything is learnt.
    pub fn new(model: &GyroModel) -> Self {
        let drift = if model.bounds_angle() { Drift::None } else { Drift::Wander(model.bias_wander_rad_per_s2) };
        GyroErrors { declared: Polygon::rectangle([model.bias_rad_per_s, model.scale]), drift, known: None }
    }

    /// Declared bound on the change of the gyroscope's bias, on which the learnt bias and scale rely.
    pub fn relies_on(&self) -> Assumption {
        match self.drift {
            Drift::None => bounds::GYRO_ANGLE,
            Drift::Wander(_) => bounds::GYRO_WANDER,
        }
    }

    /// Enclosure of the gyroscope's bias over a span of time, or of the whole run's bias where `gyro.angle` is declared.
    pub fn bias_over(&self, span_s: [f64; 2]) -> Interval {
        let (known_s, known) = self.latest(span_s[1]);
        known.side(0).inflate(self.drift.departs(known_s, span_s)).intersect(self.declared.side(0))
    }

    /// Enclosure of the gyroscope's scale.
    pub fn scale(&self) -> Interval {
        self.latest(0.0).1.side(1)
    }

    /// Corners (bias, scale) of a polygon that contains the bias of the whole run and the scale; `None` where what is known is the bias at one time.
    pub fn corners(&self) -> Option<Vec<[f64; 2]>> {
        matches!(self.drift, Drift::None).then(|| self.latest(0.0).1.corners().collect())
    }

    /// Turn of the robot in a span of time in which the gyroscope's readings add up to `read`.
    pub fn turn(&self, span_s: [f64; 2], read: Interval) -> Interval {
        let (known_s, known) = self.latest(span_s[1]);
        let lasts_s = span_s[1] - span_s[0];
        let departs = self.drift.departs(known_s, span_s);
        let declared = self.declared.side(0);
        // The turn is monotonic in the bias for any scale, and in the scale for any bias, so that it is extreme at corners of the set.
        known.corners().fold(Interval::EMPTY, |turn, [bias, scale]| {
            // A corner of the set of biases and scales may lie outside of the declared interval by a rounding error, and counts all the same.
            let bias = Interval::centred(bias, departs).intersect(declared.hull(Interval::point(bias)));
            turn.hull((read - bias * lasts_s) / Interval::point(scale))
        })
    }

    /// Learns bias and scale from a span of time in which the robot turned by `turn` and the gyroscope's readings added up to `read`.
    ///
    /// If no bias and scale agree with both the span and what was known before, an assumption certainly failed; nothing is learnt then.
    pub fn learn(&mut self, span_s: [f64; 2], read: Interval, turn: Interval) -> Outcome {
        let [from_s, to_s] = span_s;
        let lasts_s = Interval::point(to_s) - Interval::point(from_s);
        if lasts_s.lo() <= 0.0 {
            return Outcome::Feasible;
        }
        let (known_s, latest) = self.latest(to_s);
        // A late reading tells of a span that ends before the latest known set of biases and scales. The set learnt from it counts as known from
        // the latest set's stamp on, because it is a part of that set.
        let at_s = known_s.max(to_s);
        let known = match self.drift {
            Drift::None => latest.clone(),
            Drift::Wander(rad_per_s2) => {
                let declared = self.declared.side(0);
                latest.wider(rad_per_s2 * (at_s - known_s)).below(0.0, declared.hi()).above(0.0, declared.lo())
            }
        };
        // The span constrains bias and scale by bias + scale·Δθ/T = R/T, for some turn Δθ and some sum R of readings in their enclosures.
        let mean = (read / lasts_s).inflate(self.drift.departs(at_s, span_s));
        let rate = turn / lasts_s;
        let left = known.below(rate.lo(), mean.hi()).above(rate.hi(), mean.lo());
        if left.is_empty() {
            return Outcome::Empty("the turn known from elsewhere contradicts the gyroscope's bias and scale");
        }
        if left != *latest {
            self.known = Some((at_s, left));
        }
        Outcome::Feasible
    }

    /// The set of biases and scales that is known, and the stamp at which it is. Before anything is learnt it is the declared set, which is valid
    /// at any stamp, so that the caller's stamp `any_s` is returned with it.
    fn latest(&self, any_s: f64) -> (f64, &Polygon) {
        self.known.as_ref().map_or((any_s, &self.declared), |(known_s, known)| (*known_s, known))
    }
}

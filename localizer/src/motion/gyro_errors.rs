//! The gyroscope's bias and scale, known together.
//!
//! Over a span of length T in which the robot turns by Δθ, readings r = scale·ω + bias + noise add up to
//! ∫r dt = scale·Δθ + bias·T ± noise. So a turn that is known from elsewhere leaves a strip of the plane (bias, scale), askew unless the
//! robot was at rest: what laps of one sense hide of the bias in the scale is hidden again when it is used, and costs nothing.

use interval::{Interval, contractor::Outcome};

use crate::{bounds, bounds::Assumption, robot::GyroModel};

use super::polygon::Polygon;

/// What was learnt is taken back stamp by stamp no further back than this; a doubt that goes further back takes back all.
const UNLEARN_S: f64 = 300.0;

/// What is known of bias and scale, and since when.
#[derive(Clone, Debug)]
pub struct GyroErrors {
    declared: Polygon,
    drift: Drift,
    /// Stamp, and what was known at that stamp; the latest last.
    known: Vec<(f64, Polygon)>,
}

/// How far the bias may depart from the one that is known.
#[derive(Clone, Copy, Debug)]
enum Drift {
    /// Known is the bias that `gyro.angle` counts from: it is the same all the run.
    None,
    /// Known is the bias at a stamp: it changes by at most this per time.
    Wander(f64),
}

impl Drift {
    /// Greatest distance of a bias in a span from the one known at a stamp.
    fn departs(self, known_s: f64, [from_s, to_s]: [f64; 2]) -> f64 {
        match self {
            Drift::None => 0.0,
            Drift::Wander(rad_per_s2) => rad_per_s2 * (to_s - known_s).abs().max((known_s - from_s).abs()),
        }
    }
}

impl GyroErrors {
    /// Bias and scale as declared.
    pub fn new(model: &GyroModel) -> Self {
        let drift = if model.bounds_angle() { Drift::None } else { Drift::Wander(model.bias_wander_rad_per_s2) };
        GyroErrors { declared: Polygon::rectangle([model.bias_rad_per_s, model.scale]), drift, known: Vec::new() }
    }

    /// The bound on the bias's change that this stands on.
    pub fn relies_on(&self) -> Assumption {
        match self.drift {
            Drift::None => bounds::GYRO_ANGLE,
            Drift::Wander(_) => bounds::GYRO_WANDER,
        }
    }

    /// Enclosure of the bias over a span, or of that of all the run where `gyro.angle` is declared.
    pub fn bias_over(&self, span_s: [f64; 2]) -> Interval {
        let (known_s, known) = self.latest(span_s[1]);
        known.side(0).inflate(self.drift.departs(known_s, span_s)).intersect(self.declared.side(0))
    }

    /// Enclosure of the scale.
    pub fn scale(&self) -> Interval {
        self.latest(0.0).1.side(1)
    }

    /// Turn in a span whose readings add up to `read`.
    pub fn turn(&self, span_s: [f64; 2], read: Interval) -> Interval {
        let (known_s, known) = self.latest(span_s[1]);
        let lasts_s = span_s[1] - span_s[0];
        let departs = self.drift.departs(known_s, span_s);
        let declared = self.declared.side(0);
        // Monotonic in the bias, and in the scale, wherever the other is: extreme at corners.
        known.corners().fold(Interval::EMPTY, |turn, [bias, scale]| {
            // A corner may lie outside of what is declared by a rounding, and counts all the same.
            let bias = Interval::centred(bias, departs).intersect(declared.hull(Interval::point(bias)));
            turn.hull((read - bias * lasts_s) / Interval::point(scale))
        })
    }

    /// Learns from a span in which the robot turned by `turn` and readings added up to `read`.
    ///
    /// Nothing in common with what was known certifies that an assumption failed; nothing is learnt then.
    pub fn learn(&mut self, span_s: [f64; 2], read: Interval, turn: Interval) -> Outcome {
        let [from_s, to_s] = span_s;
        let lasts_s = Interval::point(to_s) - Interval::point(from_s);
        if lasts_s.lo() <= 0.0 {
            return Outcome::Feasible;
        }
        let (known_s, latest) = self.latest(to_s);
        // What a late reading tells is known from now on, not since its stamp: it is cut from all that was known before it came.
        let at_s = known_s.max(to_s);
        let known = match self.drift {
            Drift::None => latest.clone(),
            Drift::Wander(rad_per_s2) => {
                let declared = self.declared.side(0);
                latest.wider(rad_per_s2 * (at_s - known_s)).below(0.0, declared.hi()).above(0.0, declared.lo())
            }
        };
        // bias + scale·Δθ/T = R/T, for some turn and some sum of their enclosures.
        let mean = (read / lasts_s).inflate(self.drift.departs(at_s, span_s));
        let rate = turn / lasts_s;
        let left = known.below(rate.lo(), mean.hi()).above(rate.hi(), mean.lo());
        if left.is_empty() {
            return Outcome::Empty("the turn known from elsewhere contradicts the gyroscope's bias and scale");
        }
        if left != *latest {
            // One a stamp: what unlearns goes by stamps.
            self.known.pop_if(|(stamp_s, _)| *stamp_s == at_s);
            self.known.push((at_s, left));
            let deepest_s = at_s - UNLEARN_S;
            let first = self.known.iter().rposition(|(stamp_s, _)| *stamp_s <= deepest_s).unwrap_or(0);
            self.known.drain(..first);
        }
        Outcome::Feasible
    }

    /// Unlearns what was learnt later than `since_s`: an assumption failed, perhaps since then.
    pub fn forget_since(&mut self, since_s: f64) {
        self.known.retain(|(stamp_s, _)| *stamp_s <= since_s);
    }

    /// What is known, and at which stamp; as declared, it is known at any.
    fn latest(&self, any_s: f64) -> (f64, &Polygon) {
        self.known.last().map_or((any_s, &self.declared), |(known_s, known)| (*known_s, known))
    }
}

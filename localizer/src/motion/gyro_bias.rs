//! The gyroscope's bias as an interval that shrinks whenever the turn is known from elsewhere.

use crate::{Interval, contractor::Outcome};

/// What is known of the bias, and since when.
#[derive(Clone, Debug)]
pub struct GyroBias {
    declared_rad_per_s: Interval,
    wander_rad_per_s2: f64,
    spread_rad_per_s: f64,
    /// Stamp, and enclosure at that stamp; the latest last.
    known: Vec<(f64, Interval)>,
}

impl GyroBias {
    /// A bias within its declared bound that changes by at most `wander_rad_per_s2` times the time that passes, 0 for a constant, and
    /// never by more than `spread_rad_per_s`.
    pub fn new(declared_rad_per_s: Interval, wander_rad_per_s2: f64, spread_rad_per_s: f64) -> Self {
        GyroBias { declared_rad_per_s, wander_rad_per_s2, spread_rad_per_s, known: Vec::new() }
    }

    /// Greatest change of the bias in as much time.
    fn change(&self, span_s: f64) -> f64 {
        (self.wander_rad_per_s2 * span_s.max(0.0)).min(self.spread_rad_per_s)
    }

    /// Enclosure at a stamp.
    pub fn at(&self, stamp_s: f64) -> Interval {
        self.over(stamp_s, stamp_s)
    }

    /// Enclosure over a span: of the bias that was learnt last, and of what it changed by from there to the span's farther end.
    pub fn over(&self, from_s: f64, to_s: f64) -> Interval {
        let Some(&(since_s, bias)) = self.known.last() else { return self.declared_rad_per_s };
        let away_s = (to_s - since_s).abs().max((since_s - from_s).abs());
        bias.inflate(self.change(away_s)).intersect(self.declared_rad_per_s)
    }

    /// Learns that the mean bias of the span from `from_s` to `to_s` lies in `bias_rad_per_s`, as at rest or between two heading fixes.
    ///
    /// Nothing in common with what was known certifies that an assumption failed; nothing is learnt then.
    pub fn contract(&mut self, from_s: f64, to_s: f64, bias_rad_per_s: Interval) -> Outcome {
        // Somewhere in the span the bias equals its mean, and wanders from there to the span's end.
        let seen = bias_rad_per_s.inflate(self.change(to_s - from_s));
        let left = self.at(to_s).intersect(seen);
        if left.is_empty() {
            return Outcome::Empty("the turn known from elsewhere contradicts the gyroscope's bias");
        }
        // One enclosure a stamp: what unlearns goes by stamps.
        self.known.pop_if(|(stamp_s, _)| *stamp_s == to_s);
        self.known.push((to_s, left));
        Outcome::Feasible
    }

    /// Unlearns what was learnt later than `since_s`: an assumption failed, perhaps since then.
    pub fn forget_since(&mut self, since_s: f64) {
        self.known.retain(|(stamp_s, _)| *stamp_s <= since_s);
    }
}

//! The gyroscope's bias, learnt from headings that methods fix some time apart.

use std::collections::VecDeque;

use crate::{
    Interval,
    motion::{GyroBias, GyroHistory},
    robot::GyroModel,
};

/// Fixes and readings are kept for so long: a bias is known to a heading's width over as much.
const KEEP_S: f64 = 30.0;
/// Fixes nearer to each other than this tell nothing more.
const APART_S: f64 = 1.0;

/// What is known of the bias, and the fixes that it is learnt from.
pub(super) struct BiasLearner {
    bias: GyroBias,
    readings: GyroHistory,
    /// Stamp and heading.
    fixes: VecDeque<(f64, Interval)>,
}

impl BiasLearner {
    /// A bias within the model's bound that changes by at most `wander_rad_per_s2` times the time that passes.
    pub(super) fn new(model: GyroModel, wander_rad_per_s2: f64) -> Self {
        BiasLearner {
            bias: GyroBias::new(model.bias_rad_per_s, wander_rad_per_s2),
            readings: GyroHistory::new(model, KEEP_S),
            fixes: VecDeque::new(),
        }
    }

    pub(super) fn read(&mut self, time_s: f64, rate_rad_per_s: f64) {
        self.readings.push(time_s, rate_rad_per_s);
    }

    /// Learns from a heading fixed at a stamp; turn rates change by at most `change_rad_per_s2`.
    pub(super) fn learn(&mut self, stamp_s: f64, heading: Interval, change_rad_per_s2: f64) {
        self.fixes.retain(|(fixed_s, _)| *fixed_s > stamp_s - KEEP_S);
        for &(fixed_s, before) in &self.fixes {
            // A bias that contradicts what was known is learnt by no one: the doubt that is to come unlearns.
            if let Some(seen) = self.readings.bias(fixed_s, stamp_s, heading - before, change_rad_per_s2) {
                let _contradiction = self.bias.contract(fixed_s, stamp_s, seen);
            }
        }
        if self.fixes.back().is_none_or(|(fixed_s, _)| *fixed_s <= stamp_s - APART_S) {
            self.fixes.push_back((stamp_s, heading));
        }
    }

    /// Enclosure from a little before a time on.
    pub(super) fn at(&self, time_s: f64) -> Interval {
        self.bias.at(time_s)
    }

    /// Unlearns what was learnt later than `since_s`.
    pub(super) fn forget_since(&mut self, since_s: f64) {
        self.bias.forget_since(since_s);
        self.fixes.retain(|(fixed_s, _)| *fixed_s <= since_s);
    }
}

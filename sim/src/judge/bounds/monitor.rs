//! Watches one declared bound over time.

use crate::{devices::BoundCheck, judge::verdict::Violation};

/// Excesses of a bound that are closer together in time than this are one violation, because several windows and images show the same cause.
const JOIN_S: f64 = 0.25;

/// Collects the time ranges in which a value exceeds its declared bound.
pub(super) struct Monitor {
    bound: &'static str,
    found: Vec<Violation>,
}

impl Monitor {
    pub(super) fn new(bound: &'static str) -> Self {
        Monitor { bound, found: Vec::new() }
    }

    /// The bound's name.
    pub(super) fn bound(&self) -> &'static str {
        self.bound
    }

    /// Checks the true value of a quantity over a time span against the declared bound; spans come in the order of their ends.
    pub(super) fn watch(&mut self, span_s: [f64; 2], declared: f64, true_value: f64) {
        if !(BoundCheck { bound: self.bound, span_s, declared, true_value }).is_exceeded() {
            return;
        }
        match self.found.last_mut() {
            Some(last) if span_s[0] <= last.to_s + JOIN_S => {
                last.from_s = last.from_s.min(span_s[0]);
                last.to_s = last.to_s.max(span_s[1]);
                last.deepen(declared, true_value);
            }
            _ => self.found.push(Violation {
                bound: self.bound.to_string(),
                from_s: span_s[0],
                to_s: span_s[1],
                declared,
                true_value,
            }),
        }
    }

    /// Records a greater excess for the latest violation, if `time_s` falls into it, without changing the violation's time range.
    pub(super) fn deepen(&mut self, time_s: f64, declared: f64, true_value: f64) {
        if let Some(last) = self.found.last_mut().filter(|last| time_s <= last.to_s + JOIN_S) {
            last.deepen(declared, true_value);
        }
    }

    pub(super) fn finish(self) -> Vec<Violation> {
        self.found
    }
}

impl Violation {
    /// Keeps the greater of two excesses of a bound, with its declared and its true value.
    fn deepen(&mut self, declared: f64, true_value: f64) {
        if true_value - declared > self.excess() {
            (self.true_value, self.declared) = (true_value, declared);
        }
    }
}

//! Watches one declared bound over time.

use crate::{devices::BoundCheck, judge::verdict::Violation, truth::Truth};

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

/// Checks all windows that end at the step `end`. `measure` gives the declared bound and the true error from one step to another.
///
/// An excess is reported at its greatest over all windows, and dated by the shortest windows that show it: a longer window merely contains
/// such a short one.
pub(super) fn watch_windows(
    monitor: &mut Monitor,
    truths: &[Truth],
    measure: impl Fn(usize, usize) -> (f64, f64),
    starts: std::ops::Range<usize>,
    end: usize,
) {
    let exceeds = |start: usize, end: usize| {
        let (declared, error) = measure(start, end);
        error > declared
    };
    let mut dated = false;
    for start in starts.rev() {
        let (declared, error) = measure(start, end);
        if error <= declared {
            continue;
        }
        let is_shortest = !dated && (end - start == 1 || !exceeds(start, end - 1));
        dated = true;
        if is_shortest {
            monitor.watch([truths[start].time_s, truths[end].time_s], declared, error);
        } else {
            monitor.deepen(truths[end].time_s, declared, error);
        }
    }
}

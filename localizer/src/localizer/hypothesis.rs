//! What may have failed, and what speaks for it and against it.

use interval::contractor::Contractor;

use crate::{Constraint, markers::MarkerId, method::Claim};

/// As many witnesses, of which no two have anything in common, make or break a hypothesis. No reading as a whole is
/// declared to be wrong, so that one may be by an assumption that failed, and two are not by chance.
const WITNESSES: usize = 2;

/// What a hypothesis says has failed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Failed {
    /// Nothing; there is no doubt.
    Nothing,
    /// The reading that contradicted.
    Reading,
    /// The motion of the last second or seconds.
    Motion,
    /// All that was known.
    Memory,
}

/// One explanation of the readings, and what speaks for it and against it.
#[derive(Clone, Debug)]
pub(super) struct Hypothesis {
    pub(super) failed: Failed,
    /// Witnesses that agreed since the last that did not.
    agreeing: Vec<Witness>,
    /// Readings that contradicted, of which no two have a witness in common.
    against: Vec<Vec<Witness>>,
    /// Readings in a row between which the wheels lead from one to the next.
    n_in_a_row: usize,
    /// Since when that is so: whatever failed before, the wheels are trusted again.
    rolls_since_s: f64,
}

impl Hypothesis {
    pub(super) fn new(failed: Failed) -> Self {
        let rolls_since_s = match failed {
            Failed::Nothing | Failed::Reading => f64::NEG_INFINITY,
            Failed::Motion | Failed::Memory => f64::INFINITY,
        };
        Hypothesis { failed, agreeing: Vec::new(), against: Vec::new(), n_in_a_row: 0, rolls_since_s }
    }

    /// Whether the wheels tell the way from a stamp on.
    pub(super) fn trusts_wheels(&self, from_s: f64) -> bool {
        from_s >= self.rolls_since_s
    }

    /// Whether a reading is left out: where one is said to be false, all else that its witnesses tell is.
    pub(super) fn disbelieves(&self, witnesses: &[Witness]) -> bool {
        self.failed == Failed::Reading && self.knows_any(witnesses)
    }

    /// What of a constraint is believed: nothing that stands on motion, where it is the motion that is said to be false.
    pub(super) fn believed<'a>(&self, constraint: &'a Constraint) -> &'a (dyn Contractor<3> + Send + Sync) {
        let by_itself =
            constraint.by_itself.as_ref().filter(|_| matches!(self.failed, Failed::Motion | Failed::Memory));
        by_itself.unwrap_or(&constraint.on_pose).as_ref()
    }

    fn knows_any(&self, witnesses: &[Witness]) -> bool {
        self.against.iter().flatten().any(|known| witnesses.contains(known))
    }

    pub(super) fn is_supported(&self) -> bool {
        self.agreeing.len() >= WITNESSES
    }

    pub(super) fn is_refuted(&self) -> bool {
        self.against.len() >= WITNESSES
    }

    pub(super) fn contradict(&mut self, witnesses: &[Witness]) {
        self.disagree();
        if !self.knows_any(witnesses) {
            self.against.push(witnesses.to_vec());
        }
    }

    /// The wheels do not lead to what a reading allows.
    pub(super) fn disagree(&mut self) {
        self.agreeing.clear();
        self.n_in_a_row = 0;
        if self.failed != Failed::Reading {
            self.rolls_since_s = f64::INFINITY;
        }
    }

    /// The wheels lead to what a reading of `stamp_s` allows.
    pub(super) fn agree(&mut self, witnesses: &[Witness], stamp_s: f64) {
        self.n_in_a_row += 1;
        if self.n_in_a_row >= WITNESSES {
            self.rolls_since_s = self.rolls_since_s.min(stamp_s);
        }
        self.note(witnesses);
    }

    pub(super) fn note(&mut self, witnesses: &[Witness]) {
        for witness in witnesses {
            if !self.agreeing.contains(witness) {
                self.agreeing.push(*witness);
            }
        }
    }
}

/// What a reading bears witness of: things that the map names, which are misplaced for every reading that sees them, or the reading itself.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Witness {
    Marker(MarkerId),
    /// By its stamp.
    Reading(f64),
}

/// The things that a constraint names.
pub(super) fn named(constraint: &Constraint) -> Vec<Witness> {
    let markers = constraint.claims.iter().filter_map(|claim| match claim {
        Claim::Marker { marker, .. } => Some(Witness::Marker(*marker)),
        _ => None,
    });
    markers.collect()
}

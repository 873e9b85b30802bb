//! Hypotheses about which assumption failed, and the readings that support or contradict each.

use interval::contractor::Contractor;

use crate::{Constraint, markers::MarkerId, method::Claim};

/// Number of witnesses, no two of which have anything in common, that confirm or refute a hypothesis. No declared bound
/// lets a whole reading be wrong: one may be because an assumption failed, but two are not by chance.
const WITNESSES: usize = 2;

/// The part of the assumptions that a hypothesis says has failed: a reading, the motion, or everything known.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Failed {
    /// Hypothesis that nothing has failed; there is no doubt.
    Nothing,
    /// Hypothesis that the reading that gave the contradiction is false.
    Reading,
    /// Hypothesis that the bounds on motion were broken in the last second or seconds.
    Motion,
    /// Hypothesis that everything that was known before is false.
    Memory,
}

/// One explanation of the readings, and the readings that support or contradict it.
#[derive(Clone, Debug)]
pub(super) struct Hypothesis {
    pub(super) failed: Failed,
    /// Witnesses that agreed with the hypothesis since the last reading that did not.
    agreeing: Vec<Witness>,
    /// Witnesses of each reading that contradicted the hypothesis. No two of these readings have a witness in common.
    against: Vec<Vec<Witness>>,
    /// Number of consecutive readings such that the motion by the wheels leads from each to the next.
    n_in_a_row: usize,
    /// Stamp from which the wheels are trusted again, whatever failed before, because consecutive readings agreed with them.
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

    /// Whether the hypothesis trusts the wheels for the motion from a given stamp on.
    pub(super) fn trusts_wheels(&self, from_s: f64) -> bool {
        from_s >= self.rolls_since_s
    }

    /// Whether this hypothesis leaves a reading out. If it says that a reading is false, every other reading with one of the same witnesses is
    /// left out too.
    pub(super) fn disbelieves(&self, witnesses: &[Witness]) -> bool {
        self.failed == Failed::Reading && self.knows_any(witnesses)
    }

    /// The part of a constraint that this hypothesis believes: nothing that relies on motion, if it says that the motion or everything known was
    /// false.
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

    /// Notes that the motion by the wheels does not lead to the poses that a reading allows.
    pub(super) fn disagree(&mut self) {
        self.agreeing.clear();
        self.n_in_a_row = 0;
        if self.failed != Failed::Reading {
            self.rolls_since_s = f64::INFINITY;
        }
    }

    /// Notes that the motion by the wheels leads to poses that a reading of `stamp_s` allows.
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

/// A witness for or against a hypothesis: a thing that the map names, whose misplacement affects every reading that sees it, or else the reading
/// itself.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Witness {
    Marker(MarkerId),
    /// The reading itself as a witness, identified by its stamp.
    Reading(f64),
}

/// The markers that a constraint's claims name, as witnesses.
pub(super) fn named(constraint: &Constraint) -> Vec<Witness> {
    let markers = constraint.claims.iter().filter_map(|claim| match claim {
        Claim::Marker { marker, .. } => Some(Witness::Marker(*marker)),
        _ => None,
    });
    markers.collect()
}

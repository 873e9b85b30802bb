//! Hypotheses about which assumption failed after readings contradicted each other, and the readings that support or contradict each hypothesis.

use crate::{Constraint, PoseUnion, markers::MarkerId, method::Claim};

/// Number of witnesses (markers or whole readings) that confirm or refute a hypothesis; no two of them have anything in common. No declared bound
/// lets a whole reading be wrong: one may be because an assumption failed, but two are not by chance.
const WITNESSES: usize = 2;

/// The part of the assumptions that a hypothesis says has failed: a reading, the motion, or everything known.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Failed {
    /// Hypothesis that no assumption has failed; there is no doubt.
    Nothing,
    /// Hypothesis that the reading that contradicted what was known is false.
    Reading,
    /// Hypothesis that some markers are not where the map has them.
    Markers,
    /// Hypothesis that wheels or flow sensor have broken their declared bounds since some time, and perhaps still do.
    Motion,
    /// Hypothesis that wheels or flow sensor broke their declared bounds within a span of time that is over.
    EarlierMotion,
    /// Hypothesis that everything that was known about the pose before the contradiction is false.
    Memory,
}

/// One explanation of why readings contradicted each other, and the readings since then that support or contradict the explanation.
#[derive(Clone, Debug)]
pub(super) struct Hypothesis {
    pub(super) failed: Failed,
    /// The markers that are not where the map has them by this hypothesis; none if it says that something else failed.
    pub(super) misplaced: Vec<MarkerId>,
    /// For each reading that has agreed with the hypothesis since one last disagreed with it, its witnesses: the markers that it shows, or the reading
    /// itself. No two of these readings have a witness in common.
    agreeing: Vec<Vec<Witness>>,
    /// For each reading that contradicted the hypothesis, its witnesses: the markers that it shows, or the reading itself. No two of these readings
    /// have a witness in common.
    against: Vec<Vec<Witness>>,
    /// Number of latest readings in a row for which the motion by the wheels leads from the poses at the reading before to poses that the reading
    /// allows.
    n_in_a_row: usize,
    /// Span of time in which the hypothesis does not take the robot's motion from the wheels, but bounds it by reach alone. It ends where it is over, or
    /// where consecutive readings agreed with the wheels again; until then its end is infinite.
    by_reach_s: [f64; 2],
}

impl Hypothesis {
    pub(super) fn new(failed: Failed) -> Self {
        let by_reach_s = match failed {
            Failed::Nothing | Failed::Reading | Failed::Markers => [f64::NEG_INFINITY; 2],
            Failed::Motion | Failed::EarlierMotion | Failed::Memory => [f64::NEG_INFINITY, f64::INFINITY],
        };
        let (misplaced, agreeing, against) = (Vec::new(), Vec::new(), Vec::new());
        Hypothesis { failed, misplaced, agreeing, against, n_in_a_row: 0, by_reach_s }
    }

    /// The hypothesis that the motion was false within a span of time, which is not over yet if its end is infinite.
    pub(super) fn of_motion(span_s: [f64; 2]) -> Self {
        let failed = if span_s[1].is_finite() { Failed::EarlierMotion } else { Failed::Motion };
        Hypothesis { by_reach_s: span_s, ..Hypothesis::new(failed) }
    }

    /// The hypothesis that the given markers are not where the map has them.
    pub(super) fn of_markers(misplaced: Vec<MarkerId>) -> Self {
        Hypothesis { misplaced, ..Hypothesis::new(Failed::Markers) }
    }

    /// Span of time in which the hypothesis bounds the robot's motion by reach alone.
    pub(super) fn by_reach_s(&self) -> [f64; 2] {
        self.by_reach_s
    }

    /// Whether this hypothesis leaves out a reading with the given witnesses (the markers that it shows, or the reading itself). The hypothesis that
    /// a reading is false leaves out every reading that shares a witness with a reading that contradicted it; the others leave out none.
    pub(super) fn disbelieves(&self, witnesses: &[Witness]) -> bool {
        self.failed == Failed::Reading && self.knows_any(witnesses)
    }

    /// The poses of a union that the part of a constraint allows which this hypothesis believes. A hypothesis that the motion or everything known was
    /// false applies no part that relies on motion, and one that markers are misplaced no part by these markers.
    pub(super) fn contracted(&self, union: &PoseUnion, constraint: &Constraint) -> PoseUnion {
        if named(constraint).iter().any(|marker| self.is_misplaced(marker)) {
            let others = constraint.by_marker.iter().filter(|(marker, _)| !self.misplaced.contains(marker));
            return others.fold(union.clone(), |union, (_, on_pose)| union.contracted(on_pose.as_ref()));
        }
        let is_of_motion = matches!(self.failed, Failed::Motion | Failed::EarlierMotion | Failed::Memory);
        let by_itself = constraint.by_itself.as_ref().filter(|_| is_of_motion);
        union.contracted(by_itself.unwrap_or(&constraint.on_pose).as_ref())
    }

    /// Those of a reading's witnesses that tell something under this hypothesis.
    pub(super) fn heard(&self, witnesses: &[Witness]) -> Vec<Witness> {
        if self.disbelieves(witnesses) {
            return Vec::new();
        }
        witnesses.iter().filter(|witness| !self.is_misplaced(witness)).copied().collect()
    }

    fn is_misplaced(&self, witness: &Witness) -> bool {
        matches!(witness, Witness::Marker(marker) if self.misplaced.contains(marker))
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

    /// Notes that, under this hypothesis, the motion by the wheels does not lead to the poses that a reading allows.
    pub(super) fn disagree(&mut self) {
        self.agreeing.clear();
        self.n_in_a_row = 0;
        if matches!(self.failed, Failed::Motion | Failed::Memory) {
            self.by_reach_s[1] = f64::INFINITY;
        }
    }

    /// Notes that, under this hypothesis, the motion by the wheels leads to poses that a reading with the stamp `stamp_s` allows.
    pub(super) fn agree(&mut self, witnesses: &[Witness], stamp_s: f64) {
        self.n_in_a_row += 1;
        if self.n_in_a_row >= WITNESSES && matches!(self.failed, Failed::Motion | Failed::Memory) {
            self.by_reach_s[1] = self.by_reach_s[1].min(stamp_s);
        }
        self.note(witnesses);
    }

    pub(super) fn note(&mut self, witnesses: &[Witness]) {
        if !self.agreeing.iter().flatten().any(|known| witnesses.contains(known)) {
            self.agreeing.push(witnesses.to_vec());
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

/// The markers that a constraint claims to have seen, as witnesses for or against a hypothesis.
pub(super) fn named(constraint: &Constraint) -> Vec<Witness> {
    let markers = constraint.claims.iter().filter_map(|claim| match claim {
        Claim::Marker { marker, .. } => Some(Witness::Marker(*marker)),
        _ => None,
    });
    markers.collect()
}

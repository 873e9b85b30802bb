//! Hands the readings of a log to a localizer, in the order of their stamps, and keeps what it answers.
//!
//! Readings of wheels and gyroscope come at their stamps. An image or a position comes with the first reading of the wheels that is not before its
//! stamp: only then is it known how the robot got there.

use std::collections::{BTreeMap, VecDeque};

use localizer::{
    Estimate, PoseBox, Reading,
    localizer::{Contradiction, PoseWidth},
    motion::SlipExcess,
};
use sha2::{Digest, Sha256};

use crate::{
    artefacts::recording::exact,
    subject::{Answer, AnswerKind, Failure, Stated, Subject},
};

/// What a method made of the readings that it was given.
#[derive(Clone, Debug, Default)]
pub(super) struct MethodCounts {
    pub(super) readings: usize,
    /// Number of readings that constrained the pose.
    pub(super) constraints: usize,
    /// Number of readings whose constraint left no pose.
    pub(super) empty: usize,
    pub(super) claims: usize,
}

/// What a localizer answered to the readings of a log.
#[derive(Clone, Debug)]
pub(super) struct Played {
    /// Name of the localizer.
    pub(super) subject: String,
    /// Whether the localizer answered with boxes, at every step.
    pub(super) has_boxes: bool,
    pub(super) estimates: Vec<Estimate>,
    /// The distribution that the localizer stated at each estimate, if it did.
    pub(super) stated: Vec<Option<Stated>>,
    pub(super) contradictions: Vec<Contradiction>,
    /// What makes the width of the boxes, at each key frame for which that is known.
    pub(super) widths: Vec<PoseWidth>,
    /// The box around the union just after each reading that constrained the pose.
    pub(super) fixes: Vec<PoseBox>,
    pub(super) methods: BTreeMap<&'static str, MethodCounts>,
    /// Number of images, positions and scans of which no method made anything.
    pub(super) n_unused: usize,
    pub(super) n_readings: usize,
    pub(super) failure: Option<Failure>,
    /// What a localizer in a process of its own wrote for its author.
    pub(super) subject_log: Option<String>,
    pub(super) readings_digest: String,
}

/// A localizer to which a log is being played.
pub(super) struct Player {
    subject: Box<dyn Subject>,
    motion: VecDeque<Reading>,
    /// Readings of devices that need neither motion nor pixels: positions of satellite navigation, and scans.
    others: VecDeque<Reading>,
    step_s: f64,
    /// Stamp of the latest reading of the wheels.
    rolled_s: f64,
    /// Time at which an estimate is to be made, as soon as everything up to there has been handed over.
    due_s: Option<f64>,
    digest: Sha256,
    /// Kind of the answers so far.
    kind: Option<AnswerKind>,
    played: Played,
}

impl Player {
    /// Starts the localizer at time 0 in the box `start`. `motion` and `others` are in the order of their stamps.
    pub(super) fn start(
        mut subject: Box<dyn Subject>,
        start: &PoseBox,
        motion: Vec<Reading>,
        excesses: Vec<SlipExcess>,
        others: Vec<Reading>,
        step_s: f64,
    ) -> Player {
        subject.start(start);
        subject.expect_slip(excesses);
        let played = Played {
            subject: subject.name().to_owned(),
            has_boxes: true,
            estimates: Vec::new(),
            stated: Vec::new(),
            contradictions: Vec::new(),
            widths: Vec::new(),
            fixes: Vec::new(),
            methods: BTreeMap::new(),
            n_unused: 0,
            n_readings: 0,
            failure: None,
            subject_log: None,
            readings_digest: String::new(),
        };
        Player {
            subject,
            motion: motion.into(),
            others: others.into(),
            step_s,
            rolled_s: f64::NEG_INFINITY,
            due_s: None,
            digest: Sha256::new(),
            kind: None,
            played,
        }
    }

    /// Whether the localizer goes on answering.
    pub(super) fn goes_on(&self) -> bool {
        self.played.failure.is_none()
    }

    /// Hands over an image, after all motion up to its stamp.
    pub(super) fn show(&mut self, image: Reading) {
        self.advance_to(image.measured_s());
        if self.goes_on() && self.rolled_s >= image.measured_s() {
            self.see(arriving(image, self.rolled_s));
        } else {
            self.played.n_unused += 1;
        }
    }

    /// Hands over what is left, and returns what the localizer has answered.
    pub(super) fn finish(mut self) -> Played {
        self.advance_to(f64::INFINITY);
        self.answer_if_due();
        self.played.subject_log = self.subject.end();
        self.played.n_unused += self.others.len();
        let digest = self.digest.finalize();
        self.played.readings_digest = digest.iter().map(|byte| format!("{byte:02x}")).collect();
        self.played
    }

    /// Hands over motion until the wheels have been read at `stamp_s` or later.
    fn advance_to(&mut self, stamp_s: f64) {
        while self.rolled_s < stamp_s && self.goes_on() {
            let Some(reading) = self.motion.pop_front() else { return };
            self.answer_if_due();
            let (measured_s, is_wheels) = (reading.measured_s(), matches!(reading, Reading::Wheels { .. }));
            self.hand(&reading);
            if is_wheels {
                self.rolled_s = measured_s;
                while self.others.front().is_some_and(|other| other.measured_s() <= measured_s) {
                    let Some(other) = self.others.pop_front() else { break };
                    self.see(arriving(other, measured_s));
                }
                let last_s = self.played.estimates.last().map_or(f64::NEG_INFINITY, |last| last.time_s);
                // Half a millisecond of slack keeps stamps that are a little early from doubling the time between two estimates.
                if measured_s >= last_s + self.step_s - 0.0005 {
                    self.due_s = Some(measured_s);
                }
            }
        }
    }

    fn see(&mut self, reading: Reading) {
        self.hand(&reading);
        let accounts = self.subject.accounts();
        self.played.n_unused += usize::from(accounts.is_empty() && self.played.has_boxes);
        for account in accounts {
            let counts = self.played.methods.entry(account.method).or_default();
            counts.readings += 1;
            counts.constraints += usize::from(account.constrained);
            counts.empty += usize::from(account.emptied);
            counts.claims += account.claims.len();
            if account.constrained && !account.emptied {
                self.played.fixes.push(account.posterior.hull());
            }
        }
    }

    fn hand(&mut self, reading: &Reading) {
        let (topic, message) = exact::encode(reading);
        self.digest.update(topic);
        self.digest.update(message);
        if let Reading::Camera { image, .. } = reading {
            self.digest.update(image.as_raw());
        }
        self.played.n_readings += 1;
        self.subject.observe(reading);
    }

    fn answer_if_due(&mut self) {
        let Some(time_s) = self.due_s.take() else { return };
        let answer = self.subject.estimate_at(time_s);
        if let Some(failure) = self.subject.failure() {
            self.played.failure = Some(failure.clone());
            return;
        }
        if let Err(reason) = AnswerKind::hold(&mut self.kind, &answer) {
            self.played.failure = Some(Failure { time_s, reading: None, reason: format!("it answered with {reason}") });
            return;
        }
        self.played.stated.push(Stated::of(&answer));
        self.played.has_boxes &= matches!(answer, Answer::Boxes(_));
        let estimate = answer.into_estimate(time_s);
        let found = estimate.contradicting.iter();
        let new: Vec<Contradiction> =
            found.filter(|one| self.played.contradictions.last() != Some(one)).cloned().collect();
        self.played.contradictions.extend(new);
        if let Some(width) = self.subject.width_by_bound()
            && self.played.widths.last().is_none_or(|last| last.stamp_s != width.stamp_s)
        {
            self.played.widths.push(width.clone());
        }
        self.played.estimates.push(estimate);
    }
}

/// The reading with the time at which it reaches the localizer.
fn arriving(mut reading: Reading, at_s: f64) -> Reading {
    let late_s = at_s - reading.arrived_s();
    reading.delay(late_s.max(0.0));
    reading
}

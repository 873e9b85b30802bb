//! Which part of the past motion may have been false after a contradiction: the shortest spans of it without which no stored reading contradicts
//! anything.
//!
//! The motion of the last seconds is covered by spans of about 0.6 s, from one stored slot to another, of which each begins in the middle of the one
//! before it. So false motion of up to 0.3 s lies wholly within one of them, whenever it began. One hypothesis says that the motion has been false
//! since the start of the latest span, and perhaps still is. Another one says that it was false within a single one of the spans before, which is over:
//! before and after that span the wheels are believed, and within it reach alone bounds the motion. If neither leaves a pose, the same is asked of spans
//! twice as long, and so on up to all that is remembered.

use crate::PoseUnion;

use super::{
    Localizer, REMEMBER_S,
    hypothesis::Hypothesis,
    ring::{Explanation, joined},
};

/// Least length of the spans of motion that are set aside at first, which overlap by half. A shove takes some tenths of a second, and within 0.6 s reach
/// keeps the robot to 0.4 m. With a whole second, boxes in doubt were up to a tenth wider in y in the loop of paper 3.
const SPAN_S: f64 = 0.6;

/// The hypotheses that some of the motion was false.
pub(super) struct FalseMotion {
    /// Least length of the spans by which the motion is covered.
    pub(super) span_s: f64,
    /// Start of the latest span.
    pub(super) since_s: f64,
    /// The hypotheses that leave a pose; none if no span explains the readings.
    pub(super) explanations: Vec<Explanation>,
}

impl Localizer {
    /// The hypotheses that the motion was false within one of the shortest spans that explain the readings. `agreed_s` is the stamp of the latest slot
    /// that contradicts nothing, and the spans are no shorter than `least_s`. The slots hold what was believed.
    pub(super) fn motion_that_explains(&mut self, agreed_s: f64, least_s: f64) -> FalseMotion {
        let mut span_s = least_s.max(SPAN_S);
        loop {
            let starts_s = self.starts_of_spans(agreed_s, 0.5 * span_s);
            let since_s = starts_s.get(1).copied().unwrap_or(starts_s[0]);
            let latest = Hypothesis::of_motion([since_s, f64::INFINITY]);
            let replayed_s = self.ring.first_after(since_s).unwrap_or(f64::INFINITY);
            let latest = self.explained_by(latest, replayed_s).filter(|(_, unions)| leaves_a_pose(unions));
            let explanations: Vec<Explanation> = latest.into_iter().chain(self.earlier_motion(&starts_s)).collect();
            if !explanations.is_empty() || span_s >= REMEMBER_S {
                return FalseMotion { span_s, since_s, explanations };
            }
            span_s = (2.0 * span_s).min(REMEMBER_S);
        }
    }

    /// Stamps of the slots at which the spans of motion start, the latest first: each is the last slot at least `half_s` before the next one, or before
    /// `agreed_s`. The first stored slot is the last of them. Each span ends where the next but one starts, the first two of them after `agreed_s`.
    fn starts_of_spans(&self, agreed_s: f64, half_s: f64) -> Vec<f64> {
        let mut starts_s = Vec::new();
        let mut until_s = agreed_s;
        while let Some(slot) = self.ring.before(until_s - half_s) {
            until_s = slot.stamp_s;
            starts_s.push(until_s);
        }
        starts_s
            .extend(self.ring.first().map(|first| first.stamp_s).filter(|first_s| starts_s.last() != Some(first_s)));
        starts_s
    }

    /// The hypothesis that the motion was false within one of the spans that start at `starts_s`, the latest two of them excepted, with its pose unions
    /// in all slots; `None` if the readings since leave no pose.
    ///
    /// After their spans, all of these possibilities are carried on by the wheels. They are followed together, in one pass over the slots, so that each
    /// reading costs as much as under one hypothesis, however many spans there are.
    fn earlier_motion(&self, starts_s: &[f64]) -> Option<Explanation> {
        let over_s = starts_s[0];
        // A span is in its first half until the next one starts.
        let halves_s = &starts_s[..starts_s.len() - 1];
        let hypothesis = Hypothesis::of_motion([f64::NEG_INFINITY, over_s]);
        // The poses within the first half of a span, within the second half of the span before it, and after any of the spans that are over.
        let mut first_half = self.ring[0].unions[0].clone();
        let mut second_half = PoseUnion::default();
        let mut after = PoseUnion::default();
        let mut unions = vec![first_half.clone()];
        for index in 1..self.ring.len() {
            let (before_s, slot) = (self.ring[index - 1].stamp_s, &self.ring[index]);
            let step = |union: &PoseUnion, by_reach_s| {
                let predicted = self.carried_past(union, [before_s, slot.stamp_s], by_reach_s)?;
                Some(match &slot.constraint {
                    Some(constraint) => hypothesis.contracted(&predicted, constraint),
                    None => predicted,
                })
            };
            after = step(&after, [f64::NEG_INFINITY; 2])?;
            if slot.stamp_s > over_s {
                unions.push(after.clone());
                continue;
            }
            first_half = step(&first_half, [f64::NEG_INFINITY, f64::INFINITY])?;
            second_half = step(&second_half, [f64::NEG_INFINITY, f64::INFINITY])?;
            let believed = &slot.unions[0];
            // Of several slots with the same stamp, the last one holds what all of them tell.
            let is_last = index + 1 == self.ring.len() || self.ring[index + 1].stamp_s > slot.stamp_s;
            if is_last && halves_s.contains(&slot.stamp_s) {
                after = joined(&[after, second_half]);
                second_half = first_half;
                first_half = believed.clone();
            }
            // Up to the end of the last of the spans, the false one may still be to come.
            unions.push(joined(&[after.clone(), second_half.clone(), first_half.clone(), believed.clone()]));
        }
        leaves_a_pose(&unions).then_some((hypothesis, unions))
    }

    /// A hypothesis with the pose unions of all slots under it, which are those that were believed before `from_s`; `None` if a stored reading
    /// contradicts it. The slots hold what was believed.
    pub(super) fn explained_by(&mut self, hypothesis: Hypothesis, from_s: f64) -> Option<Explanation> {
        self.hypotheses.push(hypothesis);
        self.ring.iter_mut().for_each(|slot| slot.unions.push(slot.unions[0].clone()));
        let is_contradicted = !self.replay(self.hypotheses.len() - 1, from_s).is_empty();
        let hypothesis = self.hypotheses.pop();
        let unions: Vec<PoseUnion> = self.ring.iter_mut().filter_map(|slot| slot.unions.pop()).collect();
        hypothesis.filter(|_| !is_contradicted).map(|hypothesis| (hypothesis, unions))
    }
}

fn leaves_a_pose(unions: &[PoseUnion]) -> bool {
    unions.last().is_some_and(|latest| !latest.is_empty())
}

#[cfg(test)]
mod tests;

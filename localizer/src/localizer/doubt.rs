//! An assumption failed: how far to go back, what to unlearn, and when to trust the wheels again.

use crate::{Constraint, PoseUnion, motion::moved_union};

use super::{
    Localizer, REMEMBER_S, contract_union,
    moves::{REACH, WHEELS},
    ring::Slot,
};

/// What was unlearnt gets so long to show whether it was enough.
const UNLEARN_PAUSE_S: f64 = 2.0;
/// A contradiction so long after the last one has a cause of its own.
const UNLEARN_CALM_S: f64 = 15.0;
/// A doubt goes back at least so far: what was hung since may already have been cut by the assumption that failed.
const DOUBT_S: f64 = 1.0;

/// A doubt of the wheels: how many images in a row agree with them again.
#[derive(Clone, Copy, Debug)]
pub(super) struct Doubt {
    pub(super) agreeing: usize,
}

impl Localizer {
    /// An assumption failed, perhaps some time ago: goes back and carries on by reach alone, with every image since.
    pub(super) fn begin_doubt(&mut self) {
        self.doubt = Some(Doubt { agreeing: 0 });
        self.relies_on.retain(|assumption| !WHEELS.contains(assumption));
        self.relies_on.extend(
            REACH.iter().filter(|assumption| !self.relies_on.contains(assumption)).copied().collect::<Vec<_>>(),
        );
        let doubtful_s = self.now_s - DOUBT_S;
        self.unlearn_deeper();
        self.ring.drop_anchors_after(doubtful_s);
        self.replay(doubtful_s);
        let growing = self.ring.last().map(|last| {
            moved_union(&last.union, &self.wheels.reach_motion(last.stamp_s, self.now_s, &self.robot.reach))
        });
        self.current = self.inside_room(growing.unwrap_or_default());
        if self.current.is_empty() {
            // Even reach contradicts the walls: the memory is wrong from its beginning, and the room is all that is left.
            self.current = PoseUnion::single(self.whole_room());
            let union = self.current.clone();
            self.ring.restart(Slot { stamp_s: self.now_s, union, constraint: None });
        }
    }

    /// Lets the methods unlearn what they learnt in the last seconds. A push that hid in the width of a box may have been learnt from
    /// long before it showed: when that was not enough, twice as much is taken back.
    fn unlearn_deeper(&mut self) {
        let (latest_s, depth_s) = self.unlearnt;
        let since_s = self.now_s - latest_s;
        if since_s < UNLEARN_PAUSE_S && depth_s > 0.0 {
            return;
        }
        let depth_s = if since_s < UNLEARN_CALM_S { 2.0 * depth_s } else { 0.0 }.max(REMEMBER_S);
        self.unlearnt = (self.now_s, depth_s);
        self.unlearn_since(self.now_s - depth_s);
    }

    /// Lets the methods unlearn, and makes the constraints anew that stood on what they had learnt.
    fn unlearn_since(&mut self, since_s: f64) {
        if let Some(fixes) = &mut self.fixes {
            fixes.forget_since(since_s);
        }
        self.tell_wheels_of_gyro();
        for method in &mut self.methods {
            method.forget_since(since_s);
            for idx in 0..self.ring.len() {
                let slot = &mut self.ring[idx];
                let hung = slot.constraint.as_mut().filter(|hung| hung.method == method.name());
                if let (Some(constraint), Some(on_pose)) = (hung, method.renewed(slot.stamp_s)) {
                    constraint.on_pose = on_pose;
                }
            }
        }
    }

    /// Trusts the wheels again once q + 2 images in a row agree with them: the last slot then stands on reach and images alone.
    pub(super) fn end_doubt_when_supported(&mut self) {
        let groups_needed = 2;
        if self.doubt.is_some_and(|doubt| doubt.agreeing >= groups_needed) {
            self.doubt = None;
            self.relies_on.extend(
                WHEELS.iter().filter(|assumption| !self.relies_on.contains(assumption)).copied().collect::<Vec<_>>(),
            );
        }
    }

    /// Whether the wheels lead from the last image's union to one that this constraint allows.
    pub(super) fn agrees_with_wheels(&self, constraint: &Constraint) -> bool {
        let Some(before) = self.ring.image_before(constraint.stamp_s) else { return false };
        self.carried(&before.union, before.stamp_s, constraint.stamp_s, false)
            .is_some_and(|predicted| !contract_union(&predicted, constraint.on_pose.as_ref()).is_empty())
    }
}

//! Stamped slots in the order of their stamps: the window of the recent past.

use std::{
    collections::VecDeque,
    ops::{Index, IndexMut},
};

use crate::{Constraint, PoseUnion};

use super::hypothesis::Witness;

/// What is known of the pose at one stamp.
pub(super) struct Slot {
    pub(super) stamp_s: f64,
    /// Union at the stamp with the slot's own constraint, for each hypothesis of what failed.
    pub(super) unions: Vec<PoseUnion>,
    /// What an image says of this stamp; none for an anchor.
    pub(super) constraint: Option<Constraint>,
    /// What the image bears witness of.
    pub(super) witnesses: Vec<Witness>,
}

impl Slot {
    /// A slot of no image.
    pub(super) fn anchor(stamp_s: f64, unions: Vec<PoseUnion>) -> Slot {
        Slot { stamp_s, unions, constraint: None, witnesses: Vec::new() }
    }

    /// The pose is in this, if one of the hypotheses is right.
    pub(super) fn merged(&self) -> PoseUnion {
        merged(&self.unions)
    }
}

/// All branches of several unions.
pub(super) fn merged(unions: &[PoseUnion]) -> PoseUnion {
    if let [union] = unions {
        return union.clone();
    }
    PoseUnion { branches: unions.iter().flat_map(|union| union.branches.iter().copied()).collect() }.without_repeats()
}

/// The window.
pub(super) struct Ring {
    slots: VecDeque<Slot>,
    keep_s: f64,
}

impl Ring {
    pub(super) fn new(keep_s: f64) -> Self {
        Ring { slots: VecDeque::new(), keep_s }
    }

    pub(super) fn len(&self) -> usize {
        self.slots.len()
    }

    pub(super) fn last(&self) -> Option<&Slot> {
        self.slots.back()
    }

    /// Last slot strictly before a stamp or at it.
    pub(super) fn before(&self, stamp_s: f64) -> Option<&Slot> {
        self.slots.iter().rev().find(|slot| slot.stamp_s <= stamp_s)
    }

    /// Last image's slot strictly before a stamp or at it; anchors between are passed over.
    pub(super) fn image_before(&self, stamp_s: f64) -> Option<&Slot> {
        self.slots.iter().rev().find(|slot| slot.stamp_s <= stamp_s && slot.constraint.is_some())
    }

    /// Last slot at exactly this stamp.
    pub(super) fn at(&self, stamp_s: f64) -> Option<&Slot> {
        self.slots.iter().rev().find(|slot| slot.stamp_s == stamp_s)
    }

    /// Stamp of the first slot after a time.
    pub(super) fn first_after(&self, time_s: f64) -> Option<f64> {
        self.slots.iter().map(|slot| slot.stamp_s).find(|stamp_s| *stamp_s > time_s)
    }

    /// Every slot, the oldest first, to be changed.
    pub(super) fn iter_mut(&mut self) -> impl Iterator<Item = &mut Slot> {
        self.slots.iter_mut()
    }

    /// Index of the first slot at a stamp or after it.
    pub(super) fn index_at(&self, stamp_s: f64) -> Option<usize> {
        self.slots.iter().position(|slot| slot.stamp_s >= stamp_s)
    }

    pub(super) fn push(&mut self, slot: Slot) {
        self.slots.push_back(slot);
        self.forget();
    }

    /// Puts a slot in its place; anchors after it go, because what they hold is out of date and the slot anchors as well. Nothing is
    /// forgotten yet: what the slot holds is told from the one before it, however old that is.
    pub(super) fn insert(&mut self, slot: Slot) {
        let place = self.slots.iter().rposition(|other| other.stamp_s <= slot.stamp_s).map_or(0, |index| index + 1);
        self.slots.insert(place, slot);
        let mut index = place + 1;
        while index < self.slots.len() {
            if self.slots[index].constraint.is_none() {
                self.slots.remove(index);
            } else {
                index += 1;
            }
        }
    }

    /// Removes the anchors after a stamp, but for the oldest slot, from which all others are told.
    pub(super) fn drop_anchors_after(&mut self, stamp_s: f64) {
        let oldest_s = self.slots.front().map_or(stamp_s, |oldest| oldest.stamp_s);
        self.slots.retain(|slot| slot.stamp_s <= stamp_s.max(oldest_s) || slot.constraint.is_some());
    }

    /// Forgets everything but one slot.
    pub(super) fn restart(&mut self, slot: Slot) {
        self.slots.clear();
        self.slots.push_back(slot);
    }

    /// Forgets what is older than the window, but for two slots: a reading taken before the newest is told from the one before.
    pub(super) fn forget(&mut self) {
        let Some(newest_s) = self.slots.back().map(|slot| slot.stamp_s) else { return };
        while self.slots.len() > 2 && self.slots[0].stamp_s < newest_s - self.keep_s {
            self.slots.pop_front();
        }
    }
}

impl Index<usize> for Ring {
    type Output = Slot;

    fn index(&self, index: usize) -> &Slot {
        &self.slots[index]
    }
}

impl IndexMut<usize> for Ring {
    fn index_mut(&mut self, index: usize) -> &mut Slot {
        &mut self.slots[index]
    }
}

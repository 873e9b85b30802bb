//! Ring of slots in the order of their stamps. A slot is a stored entry with what is known of the robot's pose at one stamp of the recent past.

use std::{
    collections::VecDeque,
    ops::{Index, IndexMut},
};

use crate::{Constraint, PoseBox, PoseUnion};

use super::hypothesis::{Hypothesis, Witness};

/// A hypothesis about what failed, with the pose unions of all slots under it.
pub(super) type Explanation = (Hypothesis, Vec<PoseUnion>);

/// What is known of the robot's pose at one stamp.
pub(super) struct Slot {
    pub(super) stamp_s: f64,
    /// For each hypothesis about what failed, the pose union at the slot's stamp, with the slot's own constraint applied.
    pub(super) unions: Vec<PoseUnion>,
    /// The constraint by an image at this stamp; `None` for an anchor, which is a slot without an image.
    pub(super) constraint: Option<Constraint>,
    /// The poses at the slot's stamp that the graph of key frames leaves, if nothing failed.
    pub(super) related: Option<PoseUnion>,
    /// Witnesses of the slot's image, which are the things by whose fault alone it may be false: markers that it shows, or the image itself.
    pub(super) witnesses: Vec<Witness>,
    /// Name of the device whose reading the constraint is of; empty for an anchor.
    pub(super) device: &'static str,
    /// Whether the constraint made the pose's box narrower along x, along y and in heading.
    pub(super) narrows: [bool; 3],
}

impl Slot {
    /// A slot without an image.
    pub(super) fn anchor(stamp_s: f64, unions: Vec<PoseUnion>) -> Slot {
        Slot {
            stamp_s,
            unions,
            constraint: None,
            related: None,
            witnesses: Vec::new(),
            device: "",
            narrows: [false; 3],
        }
    }

    /// The pose union that holds the true pose if at least one of the hypotheses about what failed is right.
    pub(super) fn merged(&self) -> PoseUnion {
        merged(&self.unions)
    }
}

/// The pose union of all branches of several unions.
pub(super) fn merged(unions: &[PoseUnion]) -> PoseUnion {
    if let [union] = unions {
        return union.clone();
    }
    PoseUnion { branches: unions.iter().flat_map(|union| union.branches.iter().copied()).collect() }.without_repeats()
}

/// The branches of several pose unions, in which branches that overlap are replaced by their hull.
pub(super) fn joined(unions: &[PoseUnion]) -> PoseUnion {
    let branches = merged(unions).branches;
    PoseUnion { branches: if unions.len() == 1 { branches } else { without_overlaps(branches) } }
}

/// Boxes of poses, in which each that overlaps a later one is replaced by the hull of both.
pub(super) fn without_overlaps(mut branches: Vec<PoseBox>) -> Vec<PoseBox> {
    let mut index = 0;
    while index < branches.len() {
        match (index + 1..branches.len()).find(|&other| branches[index].overlaps(&branches[other])) {
            Some(other) => {
                branches[index] = branches[index].hull(&branches[other]);
                branches.remove(other);
            }
            None => index += 1,
        }
    }
    branches
}

/// The slots (stored pose unions) of the last `keep_s` seconds, in the order of their stamps.
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

    pub(super) fn first(&self) -> Option<&Slot> {
        self.slots.front()
    }

    pub(super) fn last(&self) -> Option<&Slot> {
        self.slots.back()
    }

    /// The ring's last slot (stored pose union) whose stamp is at or before the given one.
    pub(super) fn before(&self, stamp_s: f64) -> Option<&Slot> {
        self.slots.iter().rev().find(|slot| slot.stamp_s <= stamp_s)
    }

    /// The ring's last slot (stored pose union) whose stamp is before the given one.
    pub(super) fn earlier_than(&self, stamp_s: f64) -> Option<&Slot> {
        self.slots.iter().rev().find(|slot| slot.stamp_s < stamp_s)
    }

    /// The ring's last slot (stored pose union) of an image whose stamp is at or before the given one; slots without an image are passed over.
    pub(super) fn image_before(&self, stamp_s: f64) -> Option<&Slot> {
        self.slots.iter().rev().find(|slot| slot.stamp_s <= stamp_s && slot.constraint.is_some())
    }

    /// The ring's last slot (stored pose union) whose stamp is exactly the given one.
    pub(super) fn at(&self, stamp_s: f64) -> Option<&Slot> {
        self.slots.iter().rev().find(|slot| slot.stamp_s == stamp_s)
    }

    /// Stamp of the ring's first slot (stored pose union) after a time.
    pub(super) fn first_after(&self, time_s: f64) -> Option<f64> {
        self.slots.iter().map(|slot| slot.stamp_s).find(|stamp_s| *stamp_s > time_s)
    }

    /// Mutable access to every slot of the ring, the oldest first.
    pub(super) fn iter_mut(&mut self) -> impl Iterator<Item = &mut Slot> {
        self.slots.iter_mut()
    }

    /// Index of the ring's first slot (stored pose union) whose stamp is at or after the given one.
    pub(super) fn index_at(&self, stamp_s: f64) -> Option<usize> {
        self.slots.iter().position(|slot| slot.stamp_s >= stamp_s)
    }

    pub(super) fn push(&mut self, slot: Slot) {
        self.slots.push_back(slot);
        self.forget();
    }

    /// Inserts a slot into the ring, in the order of stamps. Later slots without an image are removed: their pose unions are out of date, and the
    /// new slot can be predicted from in their place. No old slot is forgotten here: the new slot is itself predicted from the one before it, however
    /// old that is.
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

    /// Forgets the boxes by the graph of key frames in all slots.
    pub(super) fn forget_relations(&mut self) {
        self.slots.iter_mut().for_each(|slot| slot.related = None);
    }

    /// Replaces all slots of the ring by a single one.
    pub(super) fn restart(&mut self, slot: Slot) {
        self.slots.clear();
        self.slots.push_back(slot);
    }

    /// Forgets slots older than the ring's window, except for the newest two: the pose at a reading that was taken before the newest slot is
    /// predicted from the slot before that.
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

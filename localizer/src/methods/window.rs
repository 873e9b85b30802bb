//! The latest readings that a method holds, each with the robot's motion since.

use std::collections::VecDeque;

use interval::Interval;

use crate::{PoseBox, method::MotionBetween};

/// The latest readings of a method, the oldest first.
#[derive(Clone, Debug)]
pub(super) struct Window<T> {
    held: VecDeque<Held<T>>,
    most: usize,
}

/// A reading that is held.
#[derive(Clone, Debug)]
pub(super) struct Held<T> {
    pub(super) stamp_s: f64,
    /// What the method keeps of the reading.
    pub(super) what: T,
    /// Motion of the robot from the reading's stamp to that to which the window was last carried: forward, left, and turned.
    pub(super) moved: PoseBox,
}

impl<T> Window<T> {
    /// An empty window that holds at most `most` readings.
    pub(super) fn new(most: usize) -> Window<T> {
        Window { held: VecDeque::new(), most }
    }

    /// Adds a reading with the stamp to which the window was last carried. A window that is full drops its oldest reading.
    pub(super) fn push(&mut self, stamp_s: f64, what: T) {
        self.held.push_back(Held { stamp_s, what, moved: PoseBox::from([Interval::ZERO; 3]) });
        if self.held.len() > self.most {
            self.held.pop_front();
        }
    }

    /// Carries each reading by the robot's motion in one step from its own stamp to another. A reading is dropped if the remembered motion does not
    /// reach back to its stamp.
    pub(super) fn carry_to(&mut self, stamp_s: f64, motion: MotionBetween) {
        self.held.retain_mut(|held| {
            let still = (held.stamp_s == stamp_s).then(|| PoseBox::from([Interval::ZERO; 3]));
            let moved = still.or_else(|| motion(held.stamp_s, stamp_s)).filter(|moved| !moved.is_empty());
            held.moved = moved.unwrap_or(held.moved);
            moved.is_some()
        });
    }

    pub(super) fn iter(&self) -> impl Iterator<Item = &Held<T>> {
        self.held.iter()
    }

    /// The reading that was added last.
    pub(super) fn latest(&self) -> Option<&Held<T>> {
        self.held.back()
    }

    pub(super) fn clear(&mut self) {
        self.held.clear();
    }
}

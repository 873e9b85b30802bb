//! The latest readings of a method, each with what it showed, which the localizer holds for the constraints of later readings.
//!
//! What one reading shows may say little, or more of it may be wrong than a quota of one reading can bound. Then a method makes its constraint of several
//! readings together. It does not keep them: the localizer does, carries each of them by the robot's motion since to the stamp of the next reading, and
//! forgets them when that motion, or what was believed when they were read, may be false.

use std::{collections::VecDeque, sync::Arc};

use interval::Interval;

use crate::{motion::Motion, pose::PoseBox, reading::Shown};

use super::MotionBetween;

/// A reading of a method, as seen from the stamp of its latest one.
#[derive(Clone)]
pub struct Earlier {
    /// Stamp of the reading.
    pub stamp_s: f64,
    /// Motion of the robot from the reading's stamp to the latest one, in the frame of the robot at the reading's stamp: forward, left, and turned.
    pub moved: Motion,
    shown: Shown,
}

impl Earlier {
    /// The latest reading itself, since which the robot has not moved.
    pub fn latest(stamp_s: f64, shown: Shown) -> Earlier {
        Earlier { stamp_s, moved: at_rest(), shown }
    }

    /// What the reading showed; `None` if it is of another type.
    pub fn shown<T: 'static>(&self) -> Option<&T> {
        self.shown.downcast_ref()
    }
}

/// The latest readings of a method, the oldest first.
pub struct Window {
    held: VecDeque<(f64, Shown)>,
    most: usize,
}

impl Window {
    /// An empty window that holds at most `most` readings.
    pub fn new(most: usize) -> Window {
        Window { held: VecDeque::new(), most }
    }

    /// The readings held, each carried in one step from its own stamp to `stamp_s` by the robot's motion. A reading to whose stamp the remembered motion
    /// does not reach back is dropped for good.
    pub fn carried_to(&mut self, stamp_s: f64, motion: MotionBetween) -> Vec<Earlier> {
        let mut carried = Vec::with_capacity(self.held.len());
        self.held.retain(|(held_s, shown)| {
            let still = (*held_s == stamp_s).then(at_rest);
            let moved = still.or_else(|| motion(*held_s, stamp_s)).filter(|moved| !moved.is_empty());
            carried.extend(moved.map(|moved| Earlier { stamp_s: *held_s, moved, shown: Arc::clone(shown) }));
            moved.is_some()
        });
        carried
    }

    /// Adds a reading. A window that is full drops its oldest one.
    pub fn hold(&mut self, stamp_s: f64, shown: Shown) {
        self.held.push_back((stamp_s, shown));
        if self.held.len() > self.most {
            self.held.pop_front();
        }
    }

    /// Drops all readings: the motion by which they are carried may be false, or the clock begins anew.
    pub fn clear(&mut self) {
        self.held.clear();
    }
}

fn at_rest() -> Motion {
    PoseBox::from([Interval::ZERO; 3])
}

#[cfg(test)]
mod tests {
    use super::*;

    fn numbers(carried: &[Earlier]) -> Vec<i32> {
        carried.iter().filter_map(|earlier| earlier.shown::<i32>().copied()).collect()
    }

    /// A robot that drives ahead at 1 m/s and is remembered since 2 s.
    fn ahead(from_s: f64, to_s: f64) -> Option<Motion> {
        let way = PoseBox::from([Interval::point(to_s - from_s), Interval::ZERO, Interval::ZERO]);
        (from_s >= 2.0).then_some(way)
    }

    #[test]
    fn a_reading_is_carried_from_its_own_stamp_and_dropped_where_no_motion_reaches_back() {
        let mut window = Window::new(5);
        [1.0, 2.0, 3.0].into_iter().zip(1..).for_each(|(stamp_s, number)| window.hold(stamp_s, Arc::new(number)));
        let carried = window.carried_to(4.0, &ahead);
        assert_eq!(numbers(&carried), [2, 3]);
        assert_eq!([carried[0].moved[0].mid(), carried[1].moved[0].mid()], [2.0, 1.0]);
        // What was dropped once stays away, even if all motion were known.
        assert_eq!(numbers(&window.carried_to(4.0, &|_, _| Some(at_rest()))), [2, 3]);
    }

    #[test]
    fn a_reading_of_the_same_stamp_needs_no_motion_and_the_oldest_gives_way() {
        let mut window = Window::new(2);
        (0..3).for_each(|number: i32| window.hold(1.0, Arc::new(number)));
        let carried = window.carried_to(1.0, &|_, _| None);
        assert_eq!(numbers(&carried), [1, 2]);
        assert!(carried.iter().all(|earlier| earlier.moved == at_rest()));
        assert!(carried[0].shown::<f64>().is_none());
        window.clear();
        assert!(window.carried_to(1.0, &|_, _| None).is_empty());
    }
}

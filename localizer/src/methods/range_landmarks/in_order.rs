//! Readings of landmarks put into the order of measurement, in which consecutive sightings with a landmark's code are counted.
//!
//! Two readings are measured at least a period T apart, and each arrives with a latency in [l, L]. Where L − l < T no reading overtakes
//! another, and they arrive in their order of measurement. Otherwise stamps tell the order, if twice their error e is less than T; all
//! readings stamped up to now − L − e have then arrived, and none will come between them. Where stamps do not tell the order, no two
//! readings are known to be consecutive.

use std::sync::Arc;

use crate::{PoseUnion, robot::RangeCameraModel};

use super::{Seen, codes::RightCodes};

/// Data that landmarks are learnt from: the landmarks seen in a reading, and the pose box at its stamp.
#[derive(Clone, Debug)]
pub(super) struct Learnt {
    pub(super) posterior: PoseUnion,
    pub(super) seen: Vec<Seen>,
    /// Which of the sightings certainly have the right code.
    pub(super) codes: Arc<RightCodes>,
}

/// Stamp of a reading with the data to learn from; `None` if the reading is not learnt from.
pub(super) type Taken = (f64, Option<Learnt>);

/// Queue of landmark readings that wait for readings measured before them.
#[derive(Clone, Debug)]
pub(super) struct InOrder {
    order: Order,
    waiting: Vec<Taken>,
    /// Stamp of the latest reading that was handed on.
    handed_on_s: f64,
}

/// Source of the order in which landmark readings were measured.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Order {
    /// The order of arrival is the order of measurement, or the order is not needed.
    Arrival,
    /// The stamps tell the order; `complete_after_s` after a stamp, all readings stamped up to it have arrived.
    Stamps { complete_after_s: f64 },
    /// The order in which the readings were measured is unknown.
    Unknown,
}

impl InOrder {
    /// Makes an empty queue of readings. If no match can be wrong, the order of the readings does not matter.
    pub(super) fn new(camera: &RangeCameraModel) -> Self {
        let order = if camera.q_items == 0 || camera.latency_s.width() < camera.period_s {
            Order::Arrival
        } else if 2.0 * camera.stamp_error_s < camera.period_s {
            Order::Stamps { complete_after_s: camera.latency_s.hi() + camera.stamp_error_s }
        } else {
            Order::Unknown
        };
        InOrder { order, waiting: Vec::new(), handed_on_s: f64::NEG_INFINITY }
    }

    /// Whether readings arrive in the order in which they were measured.
    pub(super) fn is_by_arrival(&self) -> bool {
        self.order == Order::Arrival
    }

    /// Adds a reading to those that wait; `learnt` is `None` for one that is not learnt from.
    pub(super) fn push(&mut self, stamp_s: f64, learnt: Option<Learnt>) {
        // A reading that arrives later than any should has already been missed at its place in the order, and is not learnt from.
        let is_missed = match self.order {
            Order::Arrival => false,
            Order::Stamps { .. } => stamp_s <= self.handed_on_s,
            Order::Unknown => true,
        };
        let place = match self.order {
            Order::Stamps { .. } => self.waiting.partition_point(|(waiting_s, _)| *waiting_s <= stamp_s),
            _ => self.waiting.len(),
        };
        self.waiting.insert(place, (stamp_s, learnt.filter(|_| !is_missed)));
    }

    /// Takes out, when a reading has just arrived, all readings before which no later arrival can have been measured.
    pub(super) fn take(&mut self, arrived_s: f64) -> Vec<Taken> {
        let n_complete = match self.order {
            Order::Stamps { complete_after_s } => {
                self.waiting.partition_point(|(stamp_s, _)| *stamp_s <= arrived_s - complete_after_s)
            }
            _ => self.waiting.len(),
        };
        let complete: Vec<Taken> = self.waiting.drain(..n_complete).collect();
        let latest_s = complete.last().map_or(f64::NEG_INFINITY, |(stamp_s, _)| *stamp_s);
        self.handed_on_s = self.handed_on_s.max(latest_s);
        complete
    }

    /// Drops what would be learnt from the readings that wait; their places in the order stay.
    pub(super) fn miss_all(&mut self) {
        self.waiting.iter_mut().for_each(|(_, learnt)| *learnt = None);
    }

    /// Empties the queue when the clock is set back to 0: no reading from before is consecutive to one from after.
    pub(super) fn settle(&mut self) {
        self.waiting.clear();
        self.handed_on_s = f64::NEG_INFINITY;
    }
}

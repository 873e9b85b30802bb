//! Readings in the order in which they were taken: what is said of consecutive uses of a code is said in that order.
//!
//! Between two readings lies a period T at least, and each arrives with a latency in [l, L]. Where L − l < T none overtakes another, and they
//! arrive in their order. Otherwise stamps tell the order, if twice their error e is less than T; all readings stamped up to
//! now − L − e have then arrived, and none will come between them. Where stamps do not tell the order, no two are known to be consecutive.

use crate::{PoseUnion, robot::RangeCameraModel};

use super::Seen;

/// What was learnt from a reading.
#[derive(Clone, Debug)]
pub(super) struct Learnt {
    pub(super) posterior: PoseUnion,
    pub(super) seen: Vec<Seen>,
}

/// One reading with its stamp; `None` if it was not learnt from.
pub(super) type Taken = (f64, Option<Learnt>);

/// Readings that wait for those taken before them.
#[derive(Clone, Debug)]
pub(super) struct InOrder {
    order: Order,
    waiting: Vec<Taken>,
    /// Stamp of the latest one that was handed on.
    handed_on_s: f64,
}

/// What tells the order.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Order {
    /// Arrival, or nobody needs the order.
    Arrival,
    /// Stamps; so long after a stamp, all readings up to it have arrived.
    Stamps { complete_after_s: f64 },
    /// Nothing.
    Unknown,
}

impl InOrder {
    /// No reading yet. Without wrong matches the order does not matter.
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

    /// Adds a reading.
    pub(super) fn push(&mut self, stamp_s: f64, learnt: Option<Learnt>) {
        // One that comes later than any should has been missed where it belongs.
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

    /// Takes out what no reading to come was taken before, at the time at which one has just arrived.
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

    /// Takes back what was learnt from readings stamped later than `since_s`.
    pub(super) fn forget_since(&mut self, since_s: f64) {
        self.waiting.iter_mut().filter(|(stamp_s, _)| *stamp_s > since_s).for_each(|(_, learnt)| *learnt = None);
    }

    /// The clock is set back to 0: no reading of before is consecutive to one of after.
    pub(super) fn settle(&mut self) {
        self.waiting.clear();
        self.handed_on_s = f64::NEG_INFINITY;
    }
}

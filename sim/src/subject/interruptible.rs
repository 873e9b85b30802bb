//! A localizer under test whose run a user may end before its time.

use std::{
    cell::OnceCell,
    sync::{
        Arc,
        atomic::{AtomicBool, Ordering},
    },
};

use localizer::{
    Pose, PoseBox, Reading,
    localizer::{Account, PoseWidth, PostLocalized},
    map::{SeenAgain, SpacePoint, Views},
    motion::SlipExcess,
    reading::LandmarkId,
    vision::point_features::Landmark,
};

use super::{Answer, Failure, Subject};

/// A localizer that fails at the next question once `stop` is set, which ends its run, and that is asked nothing more from then on.
pub(super) struct Interruptible {
    inner: Box<dyn Subject>,
    stop: Arc<AtomicBool>,
    failure: OnceCell<Failure>,
}

impl Interruptible {
    pub(super) fn new(inner: Box<dyn Subject>, stop: Arc<AtomicBool>) -> Interruptible {
        Interruptible { inner, stop, failure: OnceCell::new() }
    }

    fn is_stopped(&self) -> bool {
        self.stop.load(Ordering::Relaxed)
    }
}

impl Subject for Interruptible {
    fn name(&self) -> &str {
        self.inner.name()
    }

    fn is_elsewhere(&self) -> bool {
        self.inner.is_elsewhere()
    }

    fn start(&mut self, start: &PoseBox) {
        if !self.is_stopped() {
            self.inner.start(start);
        }
    }

    fn observe(&mut self, reading: &Reading) {
        if !self.is_stopped() {
            self.inner.observe(reading);
        }
    }

    fn estimate_at(&self, time_s: f64) -> Answer {
        if !self.is_stopped() {
            return self.inner.estimate_at(time_s);
        }
        let reason = "the user interrupted the run".to_owned();
        self.failure.get_or_init(|| Failure { time_s, reading: None, reason });
        Answer::Point(Pose::default())
    }

    fn knows_until_s(&self) -> Option<f64> {
        self.inner.knows_until_s()
    }

    fn accounts(&mut self) -> Vec<Account> {
        self.inner.accounts()
    }

    fn width_by_bound(&self) -> Option<&PoseWidth> {
        self.inner.width_by_bound()
    }

    fn space_points(&mut self) -> Vec<(LandmarkId, SpacePoint)> {
        self.inner.space_points()
    }

    fn views(&self) -> Option<Views> {
        self.inner.views()
    }

    fn seen_again(&self) -> Vec<SeenAgain> {
        self.inner.seen_again()
    }

    fn looks(&self) -> Vec<(LandmarkId, Landmark)> {
        self.inner.looks()
    }

    fn post_localized(&mut self) -> Option<PostLocalized> {
        self.inner.post_localized()
    }

    fn failure(&self) -> Option<&Failure> {
        self.inner.failure().or(self.failure.get())
    }

    fn end(&mut self) -> Option<String> {
        self.inner.end()
    }

    fn expect_slip(&mut self, excesses: Vec<SlipExcess>) {
        self.inner.expect_slip(excesses);
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use crate::subject::stepped;

    use super::*;

    #[test]
    fn a_localizer_that_is_stopped_fails_without_being_asked() {
        // A loop that is left fails in its own words as soon as it is asked.
        let (asked, _) = stepped("loop".to_owned());
        let stop = Arc::new(AtomicBool::new(false));
        let subject = Interruptible::new(Box::new(asked), Arc::clone(&stop));
        assert_eq!((subject.name(), subject.failure()), ("loop", None));
        stop.store(true, Ordering::Relaxed);
        subject.estimate_at(0.5);
        let failure = subject.failure().unwrap();
        assert!(failure.time_s == 0.5 && failure.reason.contains("interrupted"), "{failure}");
    }
}

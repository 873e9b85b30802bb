//! Images that are held together, and how many of them have more wrong edges than declared for certain.

use std::collections::VecDeque;

use interval::Interval;

use crate::PoseBox;

use super::posture::Agreement;

/// The edges of one image.
#[derive(Clone, Debug)]
pub(super) struct Seen {
    pub(super) stamp_s: f64,
    /// Headings at the stamp on which one, two, … of them agree.
    pub(super) agreement: Agreement,
    /// How the robot has moved since: forward, left, and turned.
    pub(super) moved: PoseBox,
}

impl Seen {
    /// Headings at the latest stamp on which one, two, … of the edges agree.
    pub(super) fn now(&self) -> impl Iterator<Item = Vec<Interval>> {
        self.agreement.iter().map(|headings| headings.iter().map(|&heading| heading + self.moved[2]).collect())
    }
}

pub(super) fn still() -> PoseBox {
    PoseBox::from([Interval::ZERO; 3])
}

/// Images in a row, and which of them have more wrong edges than declared for certain, if the prior was right: no heading near it and no lean
/// is one on which enough of their edges agree.
#[derive(Clone, Debug, Default)]
pub(super) struct Certificates {
    are_spoilt: VecDeque<bool>,
    /// Whether more were spoilt than ever may be: then the prior is wrong, or a lean or the quotas exceed what was declared.
    pub(super) are_too_many: bool,
}

impl Certificates {
    /// Counts one image; of so many in a row at most so many may be spoilt.
    pub(super) fn note(&mut self, is_spoilt: bool, [of, at_most]: [usize; 2]) {
        self.are_spoilt.push_back(is_spoilt);
        if self.are_spoilt.len() > of {
            self.are_spoilt.pop_front();
        }
        self.are_too_many |= self.are_spoilt.iter().filter(|is_spoilt| **is_spoilt).count() > at_most;
    }
}

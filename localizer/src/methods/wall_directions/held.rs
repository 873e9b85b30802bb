//! Images of walls that are held together, and the count of images that certainly have more wrong edges than declared.

use std::collections::VecDeque;

use interval::Interval;

use crate::PoseBox;

use super::posture::Agreement;

/// Level edges of one image that is held, by the headings that they allow.
#[derive(Clone, Debug)]
pub(super) struct Seen {
    pub(super) stamp_s: f64,
    /// Headings at the image's stamp on which one, two, … of its edges agree.
    pub(super) agreement: Agreement,
    /// Motion of the robot since the image: forward, left, and turned.
    pub(super) moved: PoseBox,
}

impl Seen {
    /// Headings at the latest stamp on which one, two, … of the image's edges agree.
    pub(super) fn now(&self) -> impl Iterator<Item = Vec<Interval>> {
        self.agreement.iter().map(|headings| headings.iter().map(|&heading| heading + self.moved[2]).collect())
    }
}

pub(super) fn still() -> PoseBox {
    PoseBox::from([Interval::ZERO; 3])
}

/// Record of which images in a sequence certainly have more wrong edges than declared, provided that the prior was right: at no heading
/// near the prior and no lean do enough of the image's edges agree.
#[derive(Clone, Debug, Default)]
pub(super) struct Certificates {
    are_spoilt: VecDeque<bool>,
    /// Whether more images had too many wrong edges than may ever have: then the prior is wrong, or a lean or the quotas exceed what was
    /// declared.
    pub(super) are_too_many: bool,
}

impl Certificates {
    /// Counts one image; in a sequence of `of` images at most `at_most` may have too many wrong edges.
    pub(super) fn note(&mut self, is_spoilt: bool, [of, at_most]: [usize; 2]) {
        self.are_spoilt.push_back(is_spoilt);
        if self.are_spoilt.len() > of {
            self.are_spoilt.pop_front();
        }
        self.are_too_many |= self.are_spoilt.iter().filter(|is_spoilt| **is_spoilt).count() > at_most;
    }
}

//! Images of walls that are held together, and the count of images that certainly have more wrong edges than declared.

use std::collections::VecDeque;

use interval::Interval;

use crate::method::Earlier;

use super::{IMAGES, Image};

/// For each count, from one up, the headings at the latest stamp on which so many level edges of an earlier image agree.
pub(super) fn headings_now(image: &Earlier) -> Vec<Vec<Interval>> {
    let by_count = image.shown::<Image>().map(|image| &image.agreement);
    by_count
        .into_iter()
        .flatten()
        .map(|headings| headings.iter().map(|&heading| heading + image.moved[2]).collect())
        .collect()
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

/// Numbers of level edges of the latest images whose edges count together, whether the images are still held or were forgotten since.
#[derive(Clone, Debug, Default)]
pub(super) struct EdgeCounts {
    /// Stamp and number of level edges of each image.
    latest: VecDeque<(f64, usize)>,
}

impl EdgeCounts {
    /// Counts one more image with so many level edges. An image that comes again counts once.
    pub(super) fn note(&mut self, stamp_s: f64, n_edges: usize) {
        self.latest.retain(|(other_s, _)| *other_s != stamp_s);
        self.latest.push_back((stamp_s, n_edges));
        if self.latest.len() > IMAGES {
            self.latest.pop_front();
        }
    }

    /// Number of level edges of all images that count together.
    pub(super) fn sum(&self) -> usize {
        self.latest.iter().map(|(_, n_edges)| n_edges).sum()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_edges_of_the_latest_images_are_counted_and_each_image_once() {
        let mut counts = EdgeCounts::default();
        for image in 0..IMAGES + 5 {
            counts.note(image as f64, image);
        }
        let last = (IMAGES + 4) as f64;
        counts.note(last, IMAGES + 4);
        assert_eq!(counts.sum(), (5..IMAGES + 5).sum());
    }
}

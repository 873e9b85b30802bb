//! What each method read and said, and its part in narrowing the box.

use std::collections::{BTreeMap, VecDeque};

use localizer::methods::wall_directions::{IMAGES, WRONG_IMAGES};

use crate::run::{ImageRecord, RunRecord};

use super::verdict::{Halvings, MethodCounts};

/// By method, what it read, said and halved.
pub(super) fn counts(record: &RunRecord, false_claims: &[usize]) -> BTreeMap<String, MethodCounts> {
    let mut counts: BTreeMap<String, MethodCounts> = BTreeMap::new();
    for (image, &n_false) in record.images.iter().zip(false_claims) {
        let count = counts.entry(image.method.to_string()).or_default();
        count.readings += 1;
        count.constraints += usize::from(image.constrained);
        count.empty += usize::from(image.emptied);
        count.claims += image.claims.len();
        count.false_claims += n_false;
        count.halved.add(image);
    }
    counts
}

impl Halvings {
    /// Adds one reading's; what was unbounded before, or empty after, counts for nothing.
    fn add(&mut self, image: &ImageRecord) {
        let posterior = image.posterior.hull();
        if !image.constrained || posterior.is_empty() {
            return;
        }
        for (axis, sum) in [&mut self.x_m, &mut self.y_m, &mut self.heading_rad].into_iter().enumerate() {
            let halvings = (image.prior.width(axis) / posterior.width(axis)).log2();
            if halvings.is_finite() {
                *sum += halvings.max(0.0);
            }
        }
    }
}

/// For each image whether its method's declaration of wrong claims is broken with it: too many in the image, or for `wall_directions`
/// too many such images of those that it holds together.
pub(super) fn misperceived(record: &RunRecord, false_claims: &[usize]) -> Vec<bool> {
    let too_many = |image: &ImageRecord, n_false: usize| n_false > image.q_items;
    let mut held: VecDeque<bool> = VecDeque::new();
    let judged = record.images.iter().zip(false_claims).map(|(image, &n_false)| {
        if image.method != "wall_directions" {
            return too_many(image, n_false);
        }
        if !image.constrained {
            return false;
        }
        held.push_back(too_many(image, n_false));
        if held.len() > IMAGES {
            held.pop_front();
        }
        held.back() == Some(&true) && held.iter().filter(|wrong| **wrong).count() > WRONG_IMAGES
    });
    judged.collect()
}

//! What each method read and said, and its part in narrowing the box.

use std::collections::BTreeMap;

use localizer::{
    Claim,
    quota::{Counting, Quota, share_of},
};

use crate::{
    run::{ImageRecord, RunRecord},
    scene::Scene,
};

use super::{
    claims::FalseClaims,
    verdict::{Halvings, MethodCounts},
};

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

/// For each image how many of its claims are false.
pub(crate) fn false_claims(scene: &Scene, record: &RunRecord) -> Vec<FalseClaims> {
    record.images.iter().map(|image| FalseClaims::of(scene, record, image)).collect()
}

/// For each image whether the declaration of wrong claims that goes with it is broken: too many in the image itself, in the images that count
/// together with it, or too many of those images.
pub(crate) fn misperceived(record: &RunRecord, judged: &[FalseClaims]) -> Vec<bool> {
    let held = held_claims(record, judged);
    let is_misperceived = record.images.iter().zip(judged).zip(held).map(|((image, judged), held)| {
        let too_many = judged.others > image.quota.items;
        match (image.quota.counting, held) {
            (Counting::Alone, _) => too_many,
            (_, None) => false,
            (Counting::Readings(most), Some(held)) => too_many && held.misread > most,
            (Counting::Together { share, more, readings }, Some(held)) => {
                held.wrong > share_of(share, held.all) + more || held.spoilt > readings
            }
        }
    });
    is_misperceived.collect()
}

/// Claims that count together with those of an image, upright edges apart.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct HeldClaims {
    pub(super) all: usize,
    /// The false ones, and those of images with too many wrong upright edges: they have no right lean.
    pub(super) wrong: usize,
    /// Images with any such.
    pub(super) spoilt: usize,
    /// Images with more false ones than their own quota.
    misread: usize,
}

impl HeldClaims {
    /// An image of so many claims, upright edges apart.
    fn of(all: usize, quota: &Quota, judged: FalseClaims) -> Self {
        let wrong = if judged.upright > quota.upright { all } else { judged.others };
        let [spoilt, misread] = [wrong > 0, judged.others > quota.items].map(usize::from);
        HeldClaims { all, wrong, spoilt, misread }
    }
}

/// The same for each image; `None` where it told nothing, or counts for itself.
pub(super) fn held_claims(record: &RunRecord, judged: &[FalseClaims]) -> Vec<Option<HeldClaims>> {
    let mut seen: BTreeMap<&str, Vec<HeldClaims>> = BTreeMap::new();
    let with_each = record.images.iter().zip(judged).map(|(image, judged)| {
        if image.quota.counting == Counting::Alone {
            return None;
        }
        let seen = seen.entry(image.method).or_default();
        // What tells no heading of its own is not held.
        if image.alone_heading_rad.is_some() {
            let all = image.claims.iter().filter(|claim| !matches!(claim, Claim::UprightLine { .. })).count();
            seen.push(HeldClaims::of(all, &image.quota, *judged));
        }
        let held = seen.iter().rev().take(image.quota.n_held);
        Some(held.fold(HeldClaims::default(), |sum, image| HeldClaims {
            all: sum.all + image.all,
            wrong: sum.wrong + image.wrong,
            spoilt: sum.spoilt + image.spoilt,
            misread: sum.misread + image.misread,
        }))
    });
    with_each.collect()
}

#[cfg(test)]
mod tests {
    use super::{Counting, FalseClaims, HeldClaims, Quota};

    #[test]
    fn without_a_right_lean_no_claim_of_an_image_is_right() {
        // By hand: one upright edge may be wrong.
        let quota = Quota { items: 2, upright: 1, n_held: 1, counting: Counting::Readings(2) };
        for (upright, wrong) in [(0, 2), (1, 2), (2, 6)] {
            assert_eq!(HeldClaims::of(6, &quota, FalseClaims { upright, others: 2 }).wrong, wrong);
        }
    }
}

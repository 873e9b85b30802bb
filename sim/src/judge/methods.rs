//! Counts for each of the localizer's methods: its readings, its claims, and how often it halved the widths of the estimate's box.

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

/// For each of the localizer's methods, counts of its readings and claims, and how often it halved the widths of the estimate's box.
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
    /// Adds how often one reading halved the widths of the estimate's box. A width that was unbounded before the reading, a reading that gave no
    /// constraint, and one that left no pose, count for nothing.
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

/// The number of false claims of each image.
pub(crate) fn false_claims(scene: &Scene, record: &RunRecord) -> Vec<FalseClaims> {
    record.images.iter().map(|image| FalseClaims::of(scene, record, image)).collect()
}

/// What the rules by which false claims are counted need to know of an image.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Quotable {
    /// Name of the method that made the claims.
    pub(crate) method: &'static str,
    /// How many of the claims may be false.
    pub(crate) quota: Quota,
    /// Number of claims, those of upright edges left out.
    pub(crate) n_claims: usize,
    /// Whether the method makes later constraints of this image and of theirs together.
    pub(crate) is_held: bool,
}

impl From<&ImageRecord> for Quotable {
    fn from(image: &ImageRecord) -> Self {
        let n_claims = image.claims.iter().filter(|claim| !matches!(claim, Claim::UprightLine { .. })).count();
        Quotable { method: image.method, quota: image.quota, n_claims, is_held: image.is_held }
    }
}

/// For each image, whether more claims are false than its quota allows.
pub(crate) fn misperceived(record: &RunRecord, judged: &[FalseClaims]) -> Vec<bool> {
    exceeding(&record.images.iter().map(Quotable::from).collect::<Vec<_>>(), judged)
}

/// For each image of a sequence, whether more claims are false than its quota allows. Depending on how the quota counts, these are too many false
/// claims in the image itself, too many in the last images counted together, or too many of those images with false claims.
pub(crate) fn exceeding(images: &[Quotable], judged: &[FalseClaims]) -> Vec<bool> {
    let held = held_together(images, judged);
    let is_misperceived = images.iter().zip(judged).zip(held).map(|((image, judged), held)| {
        let too_many = judged.others - judged.of_things > image.quota.items;
        match (image.quota.counting, held) {
            (Counting::Alone, _) => too_many,
            (_, None) => false,
            (Counting::Readings { most, .. }, Some(held)) => too_many && held.misread > most,
            (Counting::Together { share, more, readings, .. }, Some(held)) => {
                held.wrong > share_of(share, held.all) + more || held.spoilt > readings
            }
        }
    });
    is_misperceived.collect()
}

/// Numbers of claims over the last images of a method, as many as its quota counts together; claims of upright edges are left out.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct HeldClaims {
    pub(super) all: usize,
    /// Number of false claims. Of an image with too many wrong upright edges all claims count as false, because the camera's lean cannot be found
    /// correctly from these edges.
    pub(super) wrong: usize,
    /// Number of the images counted together that have at least one wrong claim.
    pub(super) spoilt: usize,
    /// Number of the images counted together that have more false claims than their own quota allows.
    misread: usize,
}

impl HeldClaims {
    /// Counts for one image alone, which has `all` claims besides those of upright edges.
    fn of(all: usize, quota: &Quota, judged: FalseClaims) -> Self {
        let wrong = if judged.upright > quota.upright { all } else { judged.others };
        let [spoilt, misread] = [wrong > 0, judged.others - judged.of_things > quota.items].map(usize::from);
        HeldClaims { all, wrong, spoilt, misread }
    }
}

/// For each image, the counts over the last images up to it that the method holds, whose claims its quota counts together; `None` for an image whose claims are counted
/// alone.
pub(super) fn held_claims(record: &RunRecord, judged: &[FalseClaims]) -> Vec<Option<HeldClaims>> {
    held_together(&record.images.iter().map(Quotable::from).collect::<Vec<_>>(), judged)
}

fn held_together(images: &[Quotable], judged: &[FalseClaims]) -> Vec<Option<HeldClaims>> {
    let mut seen: BTreeMap<&str, Vec<HeldClaims>> = BTreeMap::new();
    let with_each = images.iter().zip(judged).map(|(image, judged)| {
        let (Counting::Readings { of, .. } | Counting::Together { of, .. }) = image.quota.counting else { return None };
        let seen = seen.entry(image.method).or_default();
        if image.is_held {
            seen.push(HeldClaims::of(image.n_claims, &image.quota, *judged));
        }
        let held = seen.iter().rev().take(of);
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
        // Worked out by hand: the quota allows one wrong upright edge. With two of them wrong all six other claims of the image count as wrong,
        // otherwise only the two that are false.
        let quota = Quota { items: 2, things: 0, upright: 1, counting: Counting::Readings { of: 1, most: 2 } };
        for (upright, wrong) in [(0, 2), (1, 2), (2, 6)] {
            assert_eq!(HeldClaims::of(6, &quota, FalseClaims { upright, others: 2, of_things: 0 }).wrong, wrong);
        }
    }
}

//! What each method read and said, and its part in narrowing the box.

use std::collections::BTreeMap;

use localizer::{Claim, methods::wall_directions::Quotas};

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

/// For each image whether its method's declaration of wrong claims is broken with it: too many in the image; for `wall_directions`
/// too many in the images that it holds together, or too many such images of those.
pub(crate) fn misperceived(scene: &Scene, record: &RunRecord, judged: &[FalseClaims]) -> Vec<bool> {
    let setup = scene.localizer.wall_directions();
    let (solves_lean, quotas) = (setup.solves_lean, setup.quotas());
    let edges = held_edges(scene, record, judged);
    let is_misperceived = record.images.iter().zip(judged).zip(edges).map(|((image, judged), edges)| {
        let too_many = judged.others > image.q_items;
        match edges {
            None => image.method != "wall_directions" && too_many,
            Some(edges) if solves_lean => edges.are_more_than(&quotas),
            Some(edges) => too_many && edges.misread_images > quotas.images,
        }
    });
    is_misperceived.collect()
}

/// Level edges that `wall_directions` holds together with an image.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct HeldEdges {
    pub(super) all: usize,
    /// Those that run along no wall, and those of images with too many wrong upright edges: they have no right lean.
    pub(super) wrong: usize,
    /// Images with any such.
    pub(super) spoilt_images: usize,
    /// Images with more such than their q.
    misread_images: usize,
}

impl HeldEdges {
    /// An image of so many level and upright edges, of which `q_items` and a declared share may be wrong.
    fn of([all, n_upright]: [usize; 2], q_items: usize, judged: FalseClaims, quotas: &Quotas) -> Self {
        let wrong = if judged.upright > quotas.wrong_of_image(n_upright) { all } else { judged.others };
        HeldEdges {
            all,
            wrong,
            spoilt_images: usize::from(wrong > 0),
            misread_images: usize::from(judged.others > q_items),
        }
    }

    fn are_more_than(self, quotas: &Quotas) -> bool {
        self.wrong > quotas.wrong_of_held(self.all) || self.spoilt_images > quotas.spoilt_images
    }
}

/// The same for each image; `None` where it told nothing, and of other methods.
pub(super) fn held_edges(scene: &Scene, record: &RunRecord, judged: &[FalseClaims]) -> Vec<Option<HeldEdges>> {
    let quotas = scene.localizer.wall_directions().quotas();
    let mut seen: Vec<HeldEdges> = Vec::new();
    let with_each = record.images.iter().zip(judged).map(|(image, judged)| {
        if image.method != "wall_directions" || !image.constrained {
            return None;
        }
        // What tells no heading of its own is not held.
        if image.alone_heading_rad.is_some() {
            let is_upright = |claim: &&Claim| matches!(claim, Claim::UprightLine { .. });
            let n_upright = image.claims.iter().filter(is_upright).count();
            seen.push(HeldEdges::of([image.claims.len() - n_upright, n_upright], image.q_items, *judged, &quotas));
        }
        let held = seen.iter().rev().take(image.n_held);
        Some(held.fold(HeldEdges::default(), |sum, image| HeldEdges {
            all: sum.all + image.all,
            wrong: sum.wrong + image.wrong,
            spoilt_images: sum.spoilt_images + image.spoilt_images,
            misread_images: sum.misread_images + image.misread_images,
        }))
    });
    with_each.collect()
}

#[cfg(test)]
mod tests {
    use super::{FalseClaims, HeldEdges, Quotas};

    #[test]
    fn without_a_right_lean_no_edge_of_an_image_is_right() {
        // By hand: of three upright edges one may be wrong.
        for (upright, wrong) in [(0, 2), (1, 2), (2, 6)] {
            assert_eq!(HeldEdges::of([6, 3], 2, FalseClaims { upright, others: 2 }, &Quotas::default()).wrong, wrong);
        }
    }

    #[test]
    fn edges_are_counted_and_so_are_the_images_that_they_spoil() {
        // By hand: of 150 edges 150/6 + 5 = 30, and 14 images.
        for (wrong, spoilt_images, too_many) in [(30, 14, false), (31, 14, true), (15, 15, true), (0, 0, false)] {
            assert_eq!(
                HeldEdges { all: 150, wrong, spoilt_images, misread_images: 0 }.are_more_than(&Quotas::default()),
                too_many
            );
        }
    }
}

//! How many claims about images of the forward camera are false, and how many may be.

use crate::judge::{self, FalseClaims, Quotable};

use super::Way;

/// Number of images before and after one whose counts decide whether one more false claim is allowed. Quotas count at most 20 together; images that
/// are counted with no others may be among them.
const N_AROUND: usize = 60;

/// All images that have arrived, with the number of false claims of each.
#[derive(Clone, Debug, Default)]
pub(in super::super) struct Images {
    measured_s: Vec<f64>,
    images: Vec<Quotable>,
    false_claims: Vec<FalseClaims>,
}

impl Images {
    /// Adds the next image, with its stamp and the number of its claims that are truly false.
    pub(in super::super) fn push(&mut self, measured_s: f64, image: Quotable, false_claims: FalseClaims) {
        self.measured_s.push(measured_s);
        self.images.push(image);
        self.false_claims.push(false_claims);
    }

    /// Counts one more false claim of an image.
    pub(super) fn add_false(&mut self, image: usize, way: Way) {
        *self.count(image, way) += 1;
    }

    fn count(&mut self, image: usize, way: Way) -> &mut usize {
        match way {
            Way::Upright => &mut self.false_claims[image].upright,
            Way::Level { .. } => &mut self.false_claims[image].others,
        }
    }

    /// Stamp of the first image at which more claims are false than the scene's quotas allow.
    pub(super) fn exceeded_s(&self) -> Option<f64> {
        let exceeding = judge::exceeding(&self.images, &self.false_claims);
        exceeding.into_iter().zip(&self.measured_s).find(|(is_exceeding, _)| *is_exceeding).map(|(_, stamp_s)| *stamp_s)
    }

    /// Whether more claims are false than allowed at an image or, counted together with it, at a later one. What is counted together with images long
    /// before and after is left out.
    pub(super) fn is_exceeded_by(&self, image: usize) -> bool {
        let around = image.saturating_sub(N_AROUND)..(image + N_AROUND).min(self.images.len());
        let exceeding = judge::exceeding(&self.images[around.clone()], &self.false_claims[around.clone()]);
        exceeding[image - around.start..].contains(&true)
    }

    /// Counts one more false claim of an image, if the quotas allow it.
    pub(super) fn give_up(&mut self, image: usize, way: Way) -> bool {
        self.add_false(image, way);
        let is_allowed = !self.is_exceeded_by(image);
        if !is_allowed {
            *self.count(image, way) -= 1;
        }
        is_allowed
    }
}

#[cfg(test)]
mod tests {
    use localizer::quota::{Counting, Quota};

    use super::*;

    /// Six images without a quota of their own, of which so many together may have false claims.
    fn images(counting: Counting) -> Images {
        let mut images = Images::default();
        for _ in 0..6 {
            let quota = Quota { counting, ..Quota::of_each(0) };
            images.push(0.0, Quotable { method: "walls", quota, n_claims: 4, is_held: true }, FalseClaims::default());
        }
        images
    }

    fn given_up(images: &mut Images, of: [usize; 5]) -> [bool; 5] {
        let way = Way::Level { stated_rad: 0.0, turns: true };
        of.map(|image| images.give_up(image, way))
    }

    /// Expected by hand: of any three images in a row one may have false claims, so that the second and third after the first stay whole.
    #[test]
    fn images_are_given_up_as_far_as_those_counted_together_allow() {
        let mut images = images(Counting::Readings { of: 3, most: 1 });
        assert_eq!(given_up(&mut images, [0, 1, 2, 3, 0]), [true, false, false, true, true]);
        assert_eq!(images.exceeded_s(), None);
        images.add_false(4, Way::Level { stated_rad: 0.0, turns: true });
        assert!(images.exceeded_s().is_some() && images.is_exceeded_by(3) && !images.is_exceeded_by(5));
    }

    /// Expected by hand: of the eight claims of two images in a row a quarter may be false, two, from either image or both.
    #[test]
    fn claims_counted_together_are_given_up_as_far_as_their_share_allows() {
        let mut images = images(Counting::Together { of: 2, share: 0.25, more: 0, readings: 2 });
        assert_eq!(given_up(&mut images, [2, 3, 2, 3, 4]), [true, true, false, false, true]);
        assert_eq!(images.exceeded_s(), None);
    }
}

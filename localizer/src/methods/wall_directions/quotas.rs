//! Quotas of edges that may be wrong: declared by a person who knows the building, and given to the method and to its judge alike.

use crate::quota::{Counting, Quota, share_of};

use super::{IMAGES, IMAGES_APART};

/// Declared greatest numbers of image edges that run along none of the building's directions.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Quotas {
    /// Share of the level edges of one image that may be wrong, and of its upright edges that may not be upright.
    pub edge_share: f64,
    /// Number of images out of [`IMAGES_APART`](super::IMAGES_APART) that may have more wrong edges than their share, where edges count
    /// image by image.
    pub images: usize,
    /// Share of the level edges of [`IMAGES`](super::IMAGES) images that may be wrong, where the edges of these images count together.
    pub held_share: f64,
    /// Number of wrong edges allowed on top of that share, for clutter that is in view for a while.
    pub held_edges: usize,
    /// Number of images held that may have any wrong edge at all, for clutter and people are in view for a while, and then not.
    pub spoilt_images: usize,
}

impl Quotas {
    /// Quota for the claims of an image with given numbers of level and upright edges.
    pub(super) fn of_image(&self, [n_level, n_upright]: [usize; 2], solves_lean: bool) -> Quota {
        let counting = if solves_lean {
            let Quotas { held_share: share, held_edges: more, spoilt_images: readings, .. } = *self;
            Counting::Together { of: IMAGES, share, more, readings }
        } else {
            Counting::Readings { of: IMAGES_APART, most: self.images }
        };
        Quota { items: self.wrong_of_image(n_level), things: 0, upright: self.wrong_of_image(n_upright), counting }
    }

    /// Greatest number of a single image's edges that may be wrong, given how many it has.
    pub fn wrong_of_image(&self, edges: usize) -> usize {
        share_of(self.edge_share, edges)
    }

    /// Greatest number of the level edges of several images that may be wrong, counted together, given how many there are.
    pub fn wrong_of_held(&self, edges: usize) -> usize {
        share_of(self.held_share, edges) + self.held_edges
    }
}

impl Default for Quotas {
    /// Default quotas, from rendered rooms with people and boxes at odd angles: if no wrong edge at all was allowed, the heading was lost
    /// in a fifth of the images with a fix; with a third of an image's edges, and a sixth and five of the edges of twenty images, it was
    /// lost in none.
    fn default() -> Self {
        Quotas { edge_share: 0.334, images: 2, held_share: 0.167, held_edges: 5, spoilt_images: 14 }
    }
}

#[cfg(test)]
mod tests {
    use super::Quotas;

    #[test]
    fn a_third_of_an_image_and_a_sixth_and_five_of_what_is_held_may_be_wrong_unless_told() {
        // The expected counts were computed by hand.
        let quotas = Quotas::default();
        assert_eq!([0, 2, 3, 5, 6, 30].map(|edges| quotas.wrong_of_image(edges)), [0, 0, 1, 1, 2, 10]);
        assert_eq!([0, 5, 6, 120, 150].map(|edges| quotas.wrong_of_held(edges)), [5, 5, 6, 25, 30]);
        let none = Quotas { edge_share: 0.0, held_share: 0.0, held_edges: 0, ..quotas };
        assert_eq!((none.wrong_of_image(30), none.wrong_of_held(300)), (0, 0));
    }
}

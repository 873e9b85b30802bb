//! Landmarks found again anywhere in an image by their descriptors alone, as feature matching is usually done.
//!
//! [`Frame::find`] aligns the patch of one landmark within a region that a box of poses gives. Here nothing is aligned and no region is known: each
//! landmark is compared with all keypoints. A match has the accuracy of a keypoint, about a pixel, and some matches are wrong.

use super::{
    frame::Frame,
    landmark::Landmark,
    posture::{LEVEL, Posture},
};

/// Levels of scale at which keypoints are described, each a factor of 1.2: up to twice or half the size that the landmark had when it was first seen.
const LEVELS: std::ops::RangeInclusive<i32> = -4..=4;
/// Greatest ratio of a match's distance to that of the next best keypoint. Source: D. Lowe, "Distinctive image features from scale-invariant
/// keypoints", International Journal of Computer Vision 60 (2004), section 7.1.
const MOST_RATIO: f64 = 0.8;

/// A landmark and the keypoint of an image that looks like it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PointMatch {
    /// Index of the landmark among those that were asked for.
    pub landmark: usize,
    /// Position `[u, v]` of the keypoint in pixels.
    pub position_px: [f64; 2],
    /// Number of comparisons, of 256, in which the two descriptors differ.
    pub bits: u32,
}

impl Frame<'_> {
    /// The keypoints that look like some of the landmarks, the most alike first, with at most `most_bits` differing comparisons. `allows` says of a
    /// landmark's index and a keypoint's position in pixels whether the two may belong together.
    ///
    /// Descriptors are those along the image's own axes at nine levels of scale, because a robot on a floor does not roll: H. Bay et al.,
    /// "Speeded-up robust features", Computer Vision and Image Understanding 110 (2008), section 4.1 (U-SURF). A landmark and a keypoint match if
    /// each is the nearest of the other, the landmark's next best keypoint is clearly worse, and their descriptors are alike.
    pub fn matched(
        &mut self,
        looks: &[&Landmark],
        most_bits: u32,
        allows: impl Fn(usize, [f64; 2]) -> bool,
    ) -> Vec<PointMatch> {
        let positions_px: Vec<[f64; 2]> = self.keypoints().iter().map(|keypoint| keypoint.position_px).collect();
        let mut bits = vec![vec![u32::MAX; positions_px.len()]; looks.len()];
        for level in LEVELS {
            for (keypoint, &position_px) in positions_px.iter().enumerate() {
                let Some((_, descriptor)) = self.described(keypoint, Posture { level, turn: Some(0) }) else {
                    continue;
                };
                for (landmark, look) in looks.iter().enumerate() {
                    if allows(landmark, position_px) {
                        let differing = descriptor.hamming_distance(&look.upright);
                        bits[landmark][keypoint] = bits[landmark][keypoint].min(differing);
                    }
                }
            }
        }
        let of = |(landmark, keypoint, bits): (usize, usize, u32)| PointMatch {
            landmark,
            position_px: positions_px[keypoint],
            bits,
        };
        let mut all: Vec<PointMatch> = mutual(&bits, most_bits).into_iter().map(of).collect();
        all.sort_by_key(|one| (one.bits, one.landmark));
        all
    }

    /// Ratio of a landmark's sizes in both images, and its inverse, up to which [`matched`](Self::matched) finds it again.
    pub fn most_matched_ratio() -> f64 {
        LEVEL.powi(*LEVELS.end())
    }
}

/// Pairs of a landmark and a keypoint, each with the number of its differing comparisons, that pass all tests. `bits` has a row for each landmark,
/// with a number for each keypoint.
fn mutual(bits: &[Vec<u32>], most_bits: u32) -> Vec<(usize, usize, u32)> {
    let n_keypoints = bits.first().map_or(0, Vec::len);
    // For each keypoint, the landmark that is nearest to it.
    let nearest: Vec<Option<usize>> =
        (0..n_keypoints).map(|keypoint| (0..bits.len()).min_by_key(|&landmark| bits[landmark][keypoint])).collect();
    let of_landmark = |(landmark, row): (usize, &Vec<u32>)| {
        let (keypoint, &best) = row.iter().enumerate().min_by_key(|(_, bits)| **bits)?;
        let others = row.iter().enumerate().filter(|(other, _)| *other != keypoint).map(|(_, bits)| *bits);
        let is_clear = others.min().is_none_or(|next| f64::from(best) < MOST_RATIO * f64::from(next));
        (best <= most_bits && is_clear && nearest[keypoint] == Some(landmark)).then_some((landmark, keypoint, best))
    };
    bits.iter().enumerate().filter_map(of_landmark).collect()
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::{
        super::{
            ImageBounds,
            synthetic::{Eye, Kind, Texture},
        },
        *,
    };
    use crate::vision::synthetic::Random;

    #[test]
    fn a_poster_is_found_again_from_nearer_and_from_farther_away() {
        let bounds = ImageBounds { focal_px: 500.0, slant: 1.0, dark_noise_grey: 1.0, electrons_per_grey: 20.0 };
        let (texture, mut random) = (Texture { kind: Kind::Poster, seed: 9 }, Random::new(9));
        let first = Eye::straight([320, 240]);
        let image = first.picture(texture, &mut random);
        let landmarks = Frame::new(&image, &bounds).landmarks(60);
        let looks: Vec<&Landmark> = landmarks.iter().collect();
        for scale in [0.7, 1.0, 1.4] {
            let second = Eye { scale, slant_rad: 0.2, shift_px: [6.0, -4.0], ..first };
            let image = second.picture(texture, &mut random);
            let mut frame = Frame::new(&image, &bounds);
            let matched = frame.matched(&looks, 50, |_, _| true);
            let is_right = |one: &&PointMatch| {
                let [u, v] = second.project(first.on_plane(landmarks[one.landmark].position_px()));
                (one.position_px[0] - u).hypot(one.position_px[1] - v) < 3.0
            };
            let n_right = matched.iter().filter(is_right).count();
            assert!(n_right >= 8 && 3 * n_right >= 2 * matched.len(), "{scale}: {n_right} of {}", matched.len());
            assert!(matched.is_sorted_by_key(|one| one.bits));
            // Where only some places are allowed, none is told elsewhere.
            let left = frame.matched(&looks, 50, |_, [u, _]| u < 160.0);
            assert!(!left.is_empty() && left.iter().all(|one| one.position_px[0] < 160.0));
        }
    }

    #[test]
    fn a_match_is_clearly_nearest_on_both_sides() {
        let told = |rows: &[&[u32]]| mutual(&rows.iter().map(|row| row.to_vec()).collect::<Vec<_>>(), 50);
        // 39 is less than 0.8 · 50, and 40 is not.
        assert_eq!(told(&[&[39, 50]]), [(0, 0, 39)]);
        assert_eq!(told(&[&[40, 50]]), []);
        // The second landmark is nearer to the only keypoint that is like both; the third has one of its own.
        assert_eq!(told(&[&[20, 120, 130], &[10, 125, 128], &[129, 124, 30]]), [(1, 0, 10), (2, 2, 30)]);
        // Unlike, though nothing else is more alike; alike enough.
        assert_eq!(told(&[&[51, 128]]), []);
        assert_eq!(told(&[&[50, 128]]), [(0, 0, 50)]);
        // Two keypoints that are the same match nothing; no keypoint matches nothing.
        assert_eq!(told(&[&[0, 0]]), []);
        assert_eq!(told(&[&[], &[]]), []);
        assert_eq!(told(&[]), []);
    }
}

//! A fault of a map of landmarks in pictures that a scene may ask for: some landmarks are confused with a neighbour, so that each of the two is found
//! where the other is. What is seen of them is then wrong in the way of a wrong match: it looks right, and is a claim about another place.

use std::borrow::Cow;

use localizer::map::SpacePoint;
use nalgebra::Vector3;
use rand::seq::SliceRandom;

use crate::{
    scene::{CameraKeys, LandmarkMap, Scene},
    truth::randomness::stream,
};

/// Angle, in pixels in the middle of the picture, between the directions of two landmarks that are confused. The least is larger than the greatest
/// error of a sighting, so that the wrong one is false; with the greatest each is still in the part of a picture in which the other is searched.
const APART_PX: [f64; 2] = [10.0, 30.0];
/// Greatest difference of their elevations, in pixels likewise. A robot's heading and place may be vague, and shift what it sees to the side, but the
/// height of its camera is known, so that a landmark is not searched much higher or lower than it is.
const LEVEL_PX: f64 = 6.0;
/// Greatest distance, in metres, between the places from which both were first seen, and greatest ratio of their distances from there: as patches
/// both have nearly the same size in a picture, as a search asks for.
const ANCHORS_M: f64 = 0.5;
const DISTANCES: f64 = 1.15;

impl Scene {
    /// The scene as the localizer of a run is told it. Where the scene asks for it, landmarks of its map are confused, other ones with each seed.
    pub fn told(&self, seed: u64) -> Cow<'_, Scene> {
        let setup = self.localizer.mapped_landmarks.as_ref().filter(|setup| setup.confuses());
        let known = setup.and_then(|setup| setup.known.as_ref().zip(setup.confused_share));
        let (Some((map, share)), Some(camera)) = (known, &self.robot.forward_camera) else {
            return Cow::Borrowed(self);
        };
        let pairs = confused_pairs(map, share, camera.focal_px()[0], seed);
        let mut told = self.clone();
        if let Some(known) = told.localizer.mapped_landmarks.as_mut().and_then(|setup| setup.known.as_mut()) {
            pairs.into_iter().for_each(|[one, other]| known.exchange_looks(one, other));
        }
        Cow::Owned(told)
    }
}

impl LandmarkMap {
    /// Exchanges the looks of the landmarks at two places of the map's list.
    fn exchange_looks(&mut self, one: usize, other: usize) {
        let [looks, others] = [one, other].map(|at| self.looks[at].1.clone());
        (self.looks[one].1, self.looks[other].1) = (others, looks);
    }
}

/// Pairs of landmarks of a map that are confused with each other, by their places in the map's list: of all pairs that a camera of a focal length
/// sees near each other some that the seed draws, each landmark in one of them at most, until they are a share of the map or no pair is left.
fn confused_pairs(map: &LandmarkMap, share: f64, focal_px: f64, seed: u64) -> Vec<[usize; 2]> {
    let n = map.looks.len().min(map.landmarks.len());
    let point = |at: usize| &map.landmarks[at].1;
    let all = (0..n).flat_map(|one| (one + 1..n).map(move |other| [one, other]));
    let mut possible: Vec<[usize; 2]> = all.filter(|pair| are_neighbours(pair.map(point), focal_px)).collect();
    possible.shuffle(&mut stream(seed, "landmarks.confused"));
    let n_wanted = (share * n as f64 - 1e-9).ceil() as usize;
    let (mut pairs, mut is_taken) = (Vec::new(), vec![false; n]);
    for pair in possible {
        if 2 * pairs.len() >= n_wanted {
            break;
        }
        if pair.iter().all(|&at| !is_taken[at]) {
            pair.iter().for_each(|&at| is_taken[at] = true);
            pairs.push(pair);
        }
    }
    pairs
}

/// Whether each of two landmarks would be searched where the other is seen, and would be false there.
fn are_neighbours([one, other]: [&SpacePoint; 2], focal_px: f64) -> bool {
    let (Some(place), Some(other_place)) = (middle(one), middle(other)) else { return false };
    let anchors = [one, other].map(|point| Vector3::from(point.anchor.from_m));
    // The directions of both boxes do not overlap, so that a sighting of the one is none of the other.
    let vague_px = focal_px * 0.5 * (slope_width(one) + slope_width(other));
    (anchors[0] - anchors[1]).norm() <= ANCHORS_M
        && anchors.into_iter().all(|from| {
            let [to_one, to_other] = [place - from, other_place - from];
            let apart_px = focal_px * to_one.angle(&to_other);
            let ratio = to_one.norm() / to_other.norm();
            let uneven_px = focal_px * (elevation(&to_one) - elevation(&to_other)).abs();
            (APART_PX[0].max(vague_px)..=APART_PX[1]).contains(&apart_px)
                && uneven_px <= LEVEL_PX
                && (1.0 / DISTANCES..=DISTANCES).contains(&ratio)
        })
}

/// Angle of a direction above the horizontal.
fn elevation(direction: &Vector3<f64>) -> f64 {
    direction.z.atan2(direction.xy().norm())
}

/// Point in the middle of a landmark's box; `None` where its depth may be infinite.
fn middle(point: &SpacePoint) -> Option<Vector3<f64>> {
    let [alpha, beta, rho] = point.value.map(|value| value.mid());
    let anchor = &point.anchor;
    let [i, j] = anchor.sides();
    let mut along = Vector3::zeros();
    (along[anchor.axis], along[i], along[j]) = (anchor.sign(), alpha, beta);
    (point.value[2].lo() > 0.0).then(|| Vector3::from(anchor.from_m) + along / rho)
}

/// The greater of the widths of a landmark's two slopes.
fn slope_width(point: &SpacePoint) -> f64 {
    point.value[0].width().max(point.value[1].width())
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use interval::Interval;
    use localizer::{
        map::{Anchor, Views},
        reading::LandmarkId,
    };

    use super::*;

    /// Landmarks on a wall 4 m ahead of one anchor, at its height, in directions that are `apart` radians from each other.
    fn wall(n: usize, apart: f64, half: f64) -> Vec<SpacePoint> {
        let anchor = Anchor { from_m: [1.0, 2.0, 0.3], axis: 0, is_positive: true };
        let at = |index: usize| [(apart * index as f64).tan(), 0.0, 0.25].map(|value| Interval::centred(value, half));
        (0..n).map(|index| SpacePoint { anchor, value: at(index) }).collect()
    }

    #[test]
    fn neighbours_are_apart_by_ten_to_thirty_pixels_to_the_side_from_where_both_were_first_seen() {
        // With 400 px of focal length, 10 px are 25 mrad and 30 px are 75 mrad in the middle of a picture.
        for (apart, is_near) in [(0.0245, false), (0.0255, true), (0.0745, true), (0.0760, false)] {
            let points = wall(2, apart, 1e-6);
            assert_eq!(are_neighbours([&points[0], &points[1]], 400.0), is_near, "{apart}");
        }
        let near = |change: &dyn Fn(&mut SpacePoint)| {
            let mut points = wall(2, 0.05, 1e-6);
            change(&mut points[1]);
            are_neighbours([&points[0], &points[1]], 400.0)
        };
        assert!(near(&|_| ()));
        // Higher by 5 px and by 7 px.
        assert!(near(&|point| point.value[1] += Interval::point(0.0125)));
        assert!(!near(&|point| point.value[1] += Interval::point(0.0175)));
        // Farther behind, first seen from elsewhere, known so vaguely that the one may be where the other is, and at no known depth.
        assert!(!near(&|point| point.value[2] = Interval::point(0.2)));
        assert!(!near(&|point| point.anchor.from_m[1] += 0.6));
        assert!(!near(&|point| point.value[1] = Interval::centred(0.0, 0.06)));
        assert!(!near(&|point| point.value[2] = Interval::new(0.0, 0.5)));
    }

    #[test]
    fn pairs_are_a_share_of_the_map_drawn_by_the_seed_with_each_landmark_once() {
        let picture = image::GrayImage::from_fn(400, 300, |u, v| {
            image::Luma([(u * 7 % 90 + (u / 9 * 37 + v / 11 * 53) % 120) as u8])
        });
        let bounds = localizer::vision::point_features::ImageBounds {
            focal_px: 400.0,
            slant: 1.0,
            dark_noise_grey: 1.0,
            electrons_per_grey: 20.0,
        };
        let found = localizer::vision::point_features::Frame::new(&picture, &bounds).landmarks(5);
        assert!(found.len() > 2, "{}", found.len());
        let n = 30;
        let looks = found.into_iter().cycle().take(n);
        let numbers = || (0..).map(LandmarkId);
        let map = LandmarkMap {
            room_m: [5.0, 4.0],
            relies_on: Vec::new(),
            landmarks: numbers().zip(wall(n, 0.03, 1e-6)).collect(),
            looks: numbers().zip(looks).collect(),
            views: Views::default(),
            true_eyes: Vec::new(),
        };
        for (share, n_pairs) in
            [(0.0, 0), (0.05, (0.05 * n as f64 / 2.0).ceil() as usize), (0.3, (0.3 * n as f64 / 2.0).ceil() as usize)]
        {
            let pairs = confused_pairs(&map, share, 400.0, 7);
            assert_eq!(pairs.len(), n_pairs, "{share}");
            // On this wall landmarks up to two places apart are within 30 px.
            assert!(pairs.iter().all(|[one, other]| (1..=2).contains(&(other - one))), "{pairs:?}");
            let mut all: Vec<usize> = pairs.concat();
            all.sort_unstable();
            all.dedup();
            assert_eq!(all.len(), 2 * n_pairs);
        }
        let drawn = |seed| confused_pairs(&map, 0.3, 400.0, seed);
        assert!(drawn(7) == drawn(7) && drawn(7) != drawn(8));
        // Looks change their places, and nothing else does.
        let mut confused = map.clone();
        confused.exchange_looks(2, 4);
        assert!(confused.looks[2].1 == map.looks[4].1 && confused.looks[4].1 == map.looks[2].1);
        assert!(confused.landmarks == map.landmarks && confused.looks[3] == map.looks[3]);
        assert_eq!(confused.looks[2].0, map.looks[2].0);
    }
}

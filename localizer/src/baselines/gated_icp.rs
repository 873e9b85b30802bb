//! Iterative closest point as an engineer would field it: the pose is predicted by odometry, matches are gated and one-to-one, and the map of
//! landmarks is learnt on the way, without using the codes that identify landmarks.

use super::weighted_points::{LearntPoint, SQUARED_GATE, WeightedPoint, WeightedPose, weighted_fit};

/// Greatest number of rounds, in each of which points are matched to the map and the pose is fitted to the matches.
const MOST_ROUNDS: usize = 50;
/// A map of points that have no names, to which views are matched by iterative closest point.
///
/// Matches are the nearest pairs by Mahalanobis distance, each point is in at most one of them, and none is beyond the gate: Z. Zhang,
/// "Iterative point matching for registration of free-form curves and surfaces", International Journal of Computer Vision 13 (1994), with the
/// gate of Y. Bar-Shalom, T. Fortmann, *Tracking and Data Association* (1988) in place of Zhang's distance threshold. The matching ends when no
/// match changes any more.
#[derive(Clone, Debug, Default)]
pub struct GatedIcp {
    landmarks: Vec<LearntPoint>,
}

impl GatedIcp {
    /// The robot's pose when it sees the points of `view`, estimated by matching them to the map, where odometry predicts the pose `predicted`. The
    /// map is then updated with the points as seen from that pose.
    pub fn fix(&mut self, view: &[WeightedPoint], predicted: WeightedPose) -> WeightedPose {
        if self.landmarks.is_empty() {
            // The first view defines the map's frame, so the pose that it was taken from is known exactly in that frame.
            let first = WeightedPose { covariance: Default::default(), ..predicted };
            self.landmarks.extend(view.iter().filter_map(|seen| LearntPoint::new(seen, &first)));
            return first;
        }
        let places: Vec<WeightedPoint> = self.landmarks.iter().map(LearntPoint::place).collect();
        let (fixed, matches) = closest(&places, view, predicted);
        for &(landmark, seen) in &matches {
            self.landmarks[landmark].learn(&view[seen], fixed.pose);
        }
        for seen in view {
            if places.iter().all(|place| seen.squared_distance(&fixed, place) > SQUARED_GATE) {
                self.landmarks.extend(LearntPoint::new(seen, &fixed));
            }
        }
        fixed
    }

    /// Number of landmarks in the map, as far as this method can tell them apart.
    pub fn n_landmarks(&self) -> usize {
        self.landmarks.len()
    }
}

/// The robot's pose fitted to a view, and the matches between places of the map and points of the view on which the pose is based. Where the fit
/// fails or odometry excludes it, the pose is the predicted one, without matches.
fn closest(
    places: &[WeightedPoint],
    view: &[WeightedPoint],
    predicted: WeightedPose,
) -> (WeightedPose, Vec<(usize, usize)>) {
    let mut fixed = predicted;
    let mut matches = Vec::new();
    for _ in 0..MOST_ROUNDS {
        let next = one_to_one(places, view, &fixed);
        if next == matches {
            break;
        }
        matches = next;
        let pairs: Vec<_> = matches.iter().map(|&(place, seen)| (places[place], view[seen])).collect();
        let Some(found) = weighted_fit(&pairs, Some(fixed.pose)) else { return (predicted, Vec::new()) };
        fixed = found;
    }
    // A fitted pose that odometry excludes is based on wrong matches, so the predicted pose is used instead.
    if fixed.agrees_with(&predicted) { (fixed, matches) } else { (predicted, Vec::new()) }
}

/// Matches places of the map with points of the view, each at most once: the nearest pair within the gate first, then the nearest pair of those
/// that are left, and so on.
fn one_to_one(places: &[WeightedPoint], view: &[WeightedPoint], from: &WeightedPose) -> Vec<(usize, usize)> {
    let mut near: Vec<(f64, usize, usize)> = Vec::new();
    for (seen, point) in view.iter().enumerate() {
        for (place, at) in places.iter().enumerate() {
            let distance = point.squared_distance(from, at);
            if distance <= SQUARED_GATE {
                near.push((distance, place, seen));
            }
        }
    }
    near.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut matches: Vec<(usize, usize)> = Vec::new();
    for (_, place, seen) in near {
        if matches.iter().all(|taken| taken.0 != place && taken.1 != seen) {
            matches.push((place, seen));
        }
    }
    matches.sort_unstable();
    matches
}

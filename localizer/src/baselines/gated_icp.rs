//! Iterative closest point as one would field it: predicted, gated, one to one, on a map that is learnt without any code.

use super::weighted_points::{LearntPoint, SQUARED_GATE, WeightedPoint, WeightedPose, weighted_fit};

/// Rounds of matching at most.
const MOST_ROUNDS: usize = 50;
/// A map of points that have no names.
///
/// Matches are the nearest by Mahalanobis' distance, each point in one of them, none beyond the gate: Z. Zhang, "Iterative point matching
/// for registration of free-form curves and surfaces", International Journal of Computer Vision 13 (1994), with the gate of
/// Y. Bar-Shalom, T. Fortmann, *Tracking and Data Association* (1988) in the place of his distance. It ends when no match changes any more.
#[derive(Clone, Debug, Default)]
pub struct GatedIcp {
    landmarks: Vec<LearntPoint>,
}

impl GatedIcp {
    /// The pose from which `view` is seen, where odometry predicts `predicted`; learns the map from it.
    pub fn fix(&mut self, view: &[WeightedPoint], predicted: WeightedPose) -> WeightedPose {
        if self.landmarks.is_empty() {
            // The first view defines the frame: where it was taken from is known in it.
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

    /// How many landmarks it takes there to be.
    pub fn n_landmarks(&self) -> usize {
        self.landmarks.len()
    }
}

/// The pose, and the matches of places and points of the view that it stands on: none where it is the predicted one.
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
    // What odometry excludes stands on the wrong matches.
    if fixed.agrees_with(&predicted) { (fixed, matches) } else { (predicted, Vec::new()) }
}

/// The nearest pair within the gate, then the nearest of what is left, and so on.
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

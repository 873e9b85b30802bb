//! Least squares as an engineer would field it: weighted, without the correspondences that contradict the others, on a map whose places are
//! running means.

use std::collections::BTreeMap;

use crate::reading::LandmarkId;

use super::weighted_points::{LearntPoint, SQUARED_GATE, WeightedPoint, WeightedPose, weighted_fit};

/// Number of correspondences that may agree on a pose by chance: a pose with no more of them counts only where odometry says the same.
const BY_CHANCE: usize = 3;
/// Greatest number of times that a fit is repeated from the correspondences that agree with it.
const MOST_REFITS: usize = 5;

/// The pose that most correspondences (place in the world, point of the robot frame) agree with, and which of the correspondences do. It is
/// `None` where fewer than three agree, or, of only two correspondences, fewer than both.
///
/// Each pair of correspondences proposes a pose, so that nothing is left to chance. The correspondences within the gate of that pose are fitted
/// together, weighted, until they stay the same. The pose with the most of them wins, and among poses with equally many the one that they agree
/// with best. Source: M. Fischler, R. Bolles, "Random sample consensus", Communications of the ACM 24 (1981); the refits are those of O. Chum et
/// al., "Locally optimized RANSAC" (2003).
pub fn ransac(matches: &[(WeightedPoint, WeightedPoint)]) -> Option<(WeightedPose, Vec<bool>)> {
    let needed = matches.len().clamp(2, 3);
    let mut best: Option<(usize, f64, WeightedPose, Vec<bool>)> = None;
    for first in 0..matches.len() {
        for second in 0..first {
            let mut agree: Vec<bool> = (0..matches.len()).map(|index| index == first || index == second).collect();
            let mut found = None;
            for _ in 0..MOST_REFITS {
                let Some(pose) = weighted_fit(&chosen(matches, &agree), None) else { break };
                let distances: Vec<f64> =
                    matches.iter().map(|(place, seen)| seen.squared_distance(&pose, place)).collect();
                let next: Vec<bool> = distances.iter().map(|distance| *distance <= SQUARED_GATE).collect();
                let misfit: f64 = distances.iter().filter(|distance| **distance <= SQUARED_GATE).sum();
                let is_settled = next == agree;
                found = Some((misfit, pose, next.clone()));
                if is_settled {
                    break;
                }
                agree = next;
            }
            let Some((misfit, pose, agree)) = found else { continue };
            let n_agree = agree.iter().filter(|agrees| **agrees).count();
            let is_better = best.as_ref().is_none_or(|best| n_agree > best.0 || n_agree == best.0 && misfit < best.1);
            if n_agree >= needed && is_better {
                best = Some((n_agree, misfit, pose, agree));
            }
        }
    }
    best.map(|(_, _, pose, agree)| (pose, agree))
}

fn chosen(matches: &[(WeightedPoint, WeightedPoint)], agree: &[bool]) -> Vec<(WeightedPoint, WeightedPoint)> {
    matches.iter().zip(agree).filter(|(_, agrees)| **agrees).map(|(one, _)| *one).collect()
}

/// A map of coded landmarks, for sightings of which some belong to other landmarks than their codes say.
#[derive(Clone, Debug, Default)]
pub struct RansacMap {
    landmarks: BTreeMap<LandmarkId, LearntPoint>,
}

impl RansacMap {
    /// The robot's pose when it sees the coded landmarks of `view`, or the pose `predicted` by odometry where they do not decide on one. The map is
    /// then updated with these landmarks as seen from that pose.
    pub fn fix(&mut self, view: &[(LandmarkId, WeightedPoint)], predicted: WeightedPose) -> WeightedPose {
        // The first view defines the map's frame, so the pose that it was taken from is known exactly in that frame.
        let is_first = self.landmarks.is_empty();
        let known: Vec<_> =
            view.iter().filter_map(|(code, seen)| Some((*code, (self.landmarks.get(code)?.place(), *seen)))).collect();
        let told = ransac(&known.iter().map(|(_, pair)| *pair).collect::<Vec<_>>())
            .map(|(pose, agree)| (pose.near(predicted.pose.heading_rad), agree))
            .filter(|(pose, agree)| {
                let n_agree = agree.iter().filter(|agrees| **agrees).count();
                n_agree > BY_CHANCE || pose.agrees_with(&predicted)
            });
        let fixed = match &told {
            Some((pose, _)) => *pose,
            None if is_first => WeightedPose { covariance: Default::default(), ..predicted },
            None => predicted,
        };
        if let Some((_, agree)) = told {
            for ((code, (_, seen)), agrees) in known.into_iter().zip(agree) {
                let Some(landmark) = self.landmarks.get_mut(&code) else { continue };
                if agrees {
                    landmark.learn(&seen, fixed.pose);
                } else if landmark.n_sights == 1
                    && let Some(again) = LearntPoint::new(&seen, &fixed)
                {
                    // The only earlier sighting with this landmark's code contradicts the new one, so one of the two is a sighting of another
                    // landmark. The new one is kept; if it is the wrong one, the next sighting corrects that.
                    *landmark = again;
                }
            }
        }
        for (code, seen) in view {
            if !self.landmarks.contains_key(code)
                && let Some(landmark) = LearntPoint::new(seen, &fixed)
            {
                self.landmarks.insert(*code, landmark);
            }
        }
        fixed
    }
}

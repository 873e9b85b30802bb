//! The landmarks that are known: those of the map, and those that are learnt from images at poses that are known well enough.

use std::collections::BTreeMap;

use interval::Interval;

use crate::{
    PoseBox,
    graph::{Variable, is_linear_over},
    map::SpacePoint,
    reading::LandmarkId,
};

use super::{camera::SeenPoint, ray::Optics};

/// All landmarks that are known, by their numbers.
#[derive(Clone, Debug, Default)]
pub(super) struct Atlas {
    points: BTreeMap<LandmarkId, SpacePoint>,
}

impl Atlas {
    /// The atlas of a map's landmarks.
    pub(super) fn of(points: &[(LandmarkId, SpacePoint)]) -> Atlas {
        Atlas { points: points.iter().copied().collect() }
    }

    /// What is known of a landmark.
    pub(super) fn point(&self, landmark: LandmarkId) -> Option<SpacePoint> {
        self.points.get(&landmark).copied()
    }

    /// All landmarks, in the order of their numbers.
    pub(super) fn points(&self) -> impl Iterator<Item = (LandmarkId, SpacePoint)> {
        self.points.iter().map(|(&landmark, &point)| (landmark, point))
    }

    /// Adds the landmarks that an image shows for the first time, from a pose within the given box: as rays of unknown depth.
    pub(super) fn learn(&mut self, pose: &PoseBox, seen: &[SeenPoint], optics: &Optics) {
        if !is_linear_over(pose) {
            return;
        }
        for one in seen {
            if !self.points.contains_key(&one.landmark)
                && let Some(point) = optics.first_seen(pose, one.at_px, [optics.camera.error_px; 2])
            {
                self.points.insert(one.landmark, point);
            }
        }
    }

    /// Narrows landmarks by bounds that follow from images. Returns whether something is left of all of them; where nothing is, a landmark stays as it
    /// was.
    pub(super) fn narrow(&mut self, bounds: &[(Variable, Interval)]) -> bool {
        let mut agrees = true;
        for &(variable, bound) in bounds {
            if let Variable::Point(landmark, k) = variable
                && let Some(point) = self.points.get_mut(&landmark)
            {
                let narrower = point.value[k].intersect(bound);
                agrees &= !narrower.is_empty();
                point.value[k] = if narrower.is_empty() { point.value[k] } else { narrower };
            }
        }
        agrees
    }
}

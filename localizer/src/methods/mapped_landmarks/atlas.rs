//! The landmarks that are known: those of the map, and those that are learnt from a window of images at poses that are known well enough.

use std::{
    collections::{BTreeMap, VecDeque},
    sync::Arc,
};

use interval::Interval;

use crate::{
    PoseBox,
    graph::{Relations, Variable, bounds_over, is_linear_over},
    map::SpacePoint,
    reading::LandmarkId,
};

use super::{
    camera::SeenPoint,
    ray::Optics,
    relate::{Points, Sight},
};

/// Greatest number of images in the window: a program of eight has some 80 quantities.
const MOST_IMAGES: usize = 8;
/// Greatest number of landmarks that the images of the window relate.
const MOST_LANDMARKS: usize = 20;
/// Least distance, in metres, or turn, in radians, of the robot between two images of the window.
const APART_M: f64 = 0.3;
const APART_RAD: f64 = 0.15;
/// Number of coordinates, of poses or of landmarks, that are bounded after one image: work is spread over the images.
const BOUNDED_AT_ONCE: usize = 6;

/// All landmarks that are known, by their numbers, and the window of images.
#[derive(Clone, Debug, Default)]
pub(super) struct Atlas {
    points: BTreeMap<LandmarkId, SpacePoint>,
    window: VecDeque<Image>,
    /// Number of coordinates that were bounded so far, by which all take turns.
    n_bounded: usize,
}

/// An image of the window.
#[derive(Clone, Debug)]
struct Image {
    /// Box of the pose that the image shows.
    pose: PoseBox,
    seen: Vec<SeenPoint>,
}

impl Atlas {
    /// The atlas of a map's landmarks.
    pub(super) fn of(points: &[(LandmarkId, SpacePoint)]) -> Atlas {
        Atlas { points: points.iter().copied().collect(), ..Atlas::default() }
    }

    /// What is known of a landmark.
    pub(super) fn point(&self, landmark: LandmarkId) -> Option<SpacePoint> {
        self.points.get(&landmark).copied()
    }

    /// All landmarks, in the order of their numbers.
    pub(super) fn points(&self) -> impl Iterator<Item = (LandmarkId, SpacePoint)> {
        self.points.iter().map(|(&landmark, &point)| (landmark, point))
    }

    /// Learns from the image points of an image that shows a pose within the given box. Returns whether the images of the window agree with each other
    /// and with what was known; where they do not, no landmark becomes narrower, and the window begins anew.
    pub(super) fn learn(&mut self, pose: &PoseBox, seen: &[SeenPoint], optics: &Arc<Optics>) -> bool {
        if !is_linear_over(pose) {
            return true;
        }
        for one in seen {
            if !self.points.contains_key(&one.landmark)
                && let Some(point) = optics.first_seen(pose, one.at_px, [optics.camera.error_px; 2])
            {
                self.points.insert(one.landmark, point);
            }
        }
        if self.window.iter().all(|image| is_apart(&image.pose, pose)) {
            self.window.push_back(Image { pose: *pose, seen: seen.to_vec() });
            if self.window.len() > MOST_IMAGES {
                self.window.pop_front();
            }
        }
        let mut window = std::mem::take(&mut self.window);
        let n_bounded = self.narrow(window.make_contiguous(), optics);
        let agrees = n_bounded.is_some();
        if let Some(n_bounded) = n_bounded {
            self.window = window;
            self.n_bounded += n_bounded;
        }
        agrees
    }

    /// Bounds some coordinates of the images' poses and of the landmarks that they show, whose turn it is. Returns how many were bounded; `None` where
    /// no values are left, and then nothing has changed.
    fn narrow(&mut self, window: &mut [Image], optics: &Arc<Optics>) -> Option<usize> {
        let landmarks = self.related(window);
        if landmarks.is_empty() {
            return Some(0);
        }
        let poses = (0..window.len()).flat_map(|image| (0..3).map(move |axis| Variable::Pose(image, axis)));
        let points = landmarks.iter().flat_map(|&landmark| (0..3).map(move |k| Variable::Point(landmark, k)));
        let all: Vec<Variable> = poses.chain(points).collect();
        let n_wanted = BOUNDED_AT_ONCE.min(all.len());
        let wanted: Vec<Variable> = (0..n_wanted).map(|at| all[(self.n_bounded + at) % all.len()]).collect();
        let images: Vec<(PoseBox, Points)> = window
            .iter()
            .map(|image| {
                let related = image.seen.iter().filter(|one| landmarks.binary_search(&one.landmark).is_ok());
                let known = |one: &SeenPoint| Some(Sight::told(one, self.point(one.landmark)?, optics));
                (image.pose, Points { optics: Arc::clone(optics), seen: related.filter_map(known).collect() })
            })
            .collect();
        let readings: Vec<(PoseBox, &dyn Relations)> =
            images.iter().map(|(pose, points)| (*pose, points as &dyn Relations)).collect();
        let bounds = bounds_over(&readings, &wanted)?;
        let bounds: Vec<(Variable, Interval)> = wanted.into_iter().zip(bounds).collect();
        for &(variable, bound) in &bounds {
            if let Variable::Pose(image, axis) = variable {
                let pose = &mut window[image].pose;
                pose[axis] = pose[axis].intersect(bound);
            }
        }
        self.narrow_points(&bounds);
        Some(n_wanted)
    }

    /// Narrows landmarks by bounds that follow from images.
    pub(super) fn narrow_points(&mut self, bounds: &[(Variable, Interval)]) {
        for &(variable, bound) in bounds {
            if let Variable::Point(landmark, k) = variable
                && let Some(point) = self.points.get_mut(&landmark)
            {
                point.value[k] = point.value[k].intersect(bound);
            }
        }
    }

    /// The landmarks that at least two images show, those that most show first where there are too many; in the order of their numbers.
    fn related(&self, window: &[Image]) -> Vec<LandmarkId> {
        let mut shown: BTreeMap<LandmarkId, usize> = BTreeMap::new();
        for one in window.iter().flat_map(|image| &image.seen) {
            *shown.entry(one.landmark).or_default() += 1;
        }
        let mut often: Vec<(usize, LandmarkId)> = shown
            .into_iter()
            .filter(|(landmark, n_shown)| *n_shown > 1 && self.points.contains_key(landmark))
            .map(|(landmark, n_shown)| (n_shown, landmark))
            .collect();
        often.sort_by_key(|&(n_shown, landmark)| (std::cmp::Reverse(n_shown), landmark));
        let mut landmarks: Vec<LandmarkId> =
            often.into_iter().map(|(_, landmark)| landmark).take(MOST_LANDMARKS).collect();
        landmarks.sort_unstable();
        landmarks
    }

    /// Begins the window of images anew: the next image does not follow those before.
    pub(super) fn interrupt(&mut self) {
        self.window.clear();
    }
}

/// Whether two poses are so far apart that two images tell more than one.
fn is_apart(a: &PoseBox, b: &PoseBox) -> bool {
    let apart = [0, 1, 2].map(|axis| a[axis].mid() - b[axis].mid());
    apart[0].hypot(apart[1]) >= APART_M || apart[2].abs() >= APART_RAD
}

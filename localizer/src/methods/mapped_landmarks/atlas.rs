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
/// Least time between two earlier states of a landmark that are kept, and their greatest number.
const FORMER_S: f64 = 1.0;
const MOST_FORMER: usize = 8;

/// All landmarks that are known, by their numbers, and the window of images.
#[derive(Clone, Debug, Default)]
pub(super) struct Atlas {
    entries: BTreeMap<LandmarkId, Entry>,
    window: VecDeque<Image>,
    /// Number of coordinates that were bounded so far, by which all take turns.
    n_bounded: usize,
}

#[derive(Clone, Debug)]
struct Entry {
    point: SpacePoint,
    /// The landmark of the map, to which it falls back; `None` for a landmark that is on no map.
    of_map: Option<SpacePoint>,
    /// Earlier states of the landmark, each with the stamp of the latest image that it follows from.
    former: VecDeque<(f64, SpacePoint)>,
    /// Stamp of the latest image that the landmark's box follows from.
    since_s: f64,
}

/// An image of the window.
#[derive(Clone, Debug)]
struct Image {
    stamp_s: f64,
    /// Box of the pose that the image shows.
    pose: PoseBox,
    seen: Vec<SeenPoint>,
}

impl Atlas {
    /// The atlas of a map's landmarks.
    pub(super) fn of(points: &[(LandmarkId, SpacePoint)]) -> Atlas {
        let entry = |&(landmark, point): &(LandmarkId, SpacePoint)| {
            (landmark, Entry { of_map: Some(point), ..Entry::new(point, f64::NEG_INFINITY) })
        };
        Atlas { entries: points.iter().map(entry).collect(), ..Atlas::default() }
    }

    /// What is known of a landmark.
    pub(super) fn point(&self, landmark: LandmarkId) -> Option<SpacePoint> {
        Some(self.entries.get(&landmark)?.point)
    }

    /// All landmarks, in the order of their numbers.
    pub(super) fn points(&self) -> impl Iterator<Item = (LandmarkId, SpacePoint)> {
        self.entries.iter().map(|(&landmark, entry)| (landmark, entry.point))
    }

    /// Learns from the image points of an image that shows a pose within the given box. Returns whether the images of the window agree with each other
    /// and with what was known; where they do not, no landmark becomes narrower, and the window begins anew.
    pub(super) fn learn(&mut self, stamp_s: f64, pose: &PoseBox, seen: &[SeenPoint], optics: &Arc<Optics>) -> bool {
        if !is_linear_over(pose) {
            return true;
        }
        for one in seen {
            if !self.entries.contains_key(&one.landmark)
                && let Some(point) = optics.first_seen(pose, one.at_px, [optics.camera.error_px; 2])
            {
                self.entries.insert(one.landmark, Entry::new(point, stamp_s));
            }
        }
        if self.window.iter().all(|image| is_apart(&image.pose, pose)) {
            self.window.push_back(Image { stamp_s, pose: *pose, seen: seen.to_vec() });
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
        let newest_s = window.iter().map(|image| image.stamp_s).fold(f64::NEG_INFINITY, f64::max);
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
        self.narrow_points(&bounds, newest_s);
        Some(n_wanted)
    }

    /// Narrows landmarks by bounds that follow from images up to a stamp.
    pub(super) fn narrow_points(&mut self, bounds: &[(Variable, Interval)], stamp_s: f64) {
        for &(variable, bound) in bounds {
            if let Variable::Point(landmark, k) = variable
                && let Some(entry) = self.entries.get_mut(&landmark)
            {
                entry.narrow(k, bound, stamp_s);
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
            .filter(|(landmark, n_shown)| *n_shown > 1 && self.entries.contains_key(landmark))
            .map(|(landmark, n_shown)| (n_shown, landmark))
            .collect();
        often.sort_by_key(|&(n_shown, landmark)| (std::cmp::Reverse(n_shown), landmark));
        let mut landmarks: Vec<LandmarkId> =
            often.into_iter().map(|(_, landmark)| landmark).take(MOST_LANDMARKS).collect();
        landmarks.sort_unstable();
        landmarks
    }

    /// Takes back everything that was learnt from images stamped later than the given time, and what cannot be told from it.
    pub(super) fn forget_since(&mut self, since_s: f64) {
        // The poses of the window follow from each other.
        self.window.clear();
        self.entries.retain(|_, entry| {
            if entry.since_s <= since_s {
                return true;
            }
            entry.former.retain(|&(stamp_s, _)| stamp_s <= since_s);
            let before = entry.former.back().copied();
            let Some((stamp_s, point)) = before.or(entry.of_map.map(|point| (f64::NEG_INFINITY, point))) else {
                return false;
            };
            (entry.since_s, entry.point) = (stamp_s, point);
            true
        });
    }

    /// Makes all that is known the knowledge with which a new drive begins.
    pub(super) fn begin_anew(&mut self) {
        self.window.clear();
        for entry in self.entries.values_mut() {
            *entry = Entry { of_map: Some(entry.point), ..Entry::new(entry.point, f64::NEG_INFINITY) };
        }
    }
}

impl Entry {
    fn new(point: SpacePoint, since_s: f64) -> Entry {
        Entry { point, of_map: None, former: VecDeque::new(), since_s }
    }

    /// Narrows a coordinate by what follows from images up to a stamp.
    fn narrow(&mut self, coordinate: usize, bound: Interval, stamp_s: f64) {
        if self.former.back().is_none_or(|&(former_s, _)| self.since_s >= former_s + FORMER_S) {
            self.former.push_back((self.since_s, self.point));
            if self.former.len() > MOST_FORMER {
                self.former.pop_front();
            }
        }
        let value = &mut self.point.value[coordinate];
        *value = value.intersect(bound);
        self.since_s = self.since_s.max(stamp_s);
    }
}

/// Whether two poses are so far apart that two images tell more than one.
fn is_apart(a: &PoseBox, b: &PoseBox) -> bool {
    let apart = [0, 1, 2].map(|axis| a[axis].mid() - b[axis].mid());
    apart[0].hypot(apart[1]) >= APART_M || apart[2].abs() >= APART_RAD
}

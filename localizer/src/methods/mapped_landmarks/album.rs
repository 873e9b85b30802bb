//! Landmarks that are known by their looks: those of a map, and those that pictures have shown since.
//!
//! A new landmark is a ray of unknown depth from the first picture that shows it. Each later sighting, from a pose that is known to a box, contracts
//! the landmark's box by its rows. The box that is believed is the q-relaxed intersection of what the sightings leave, so that a few wrong ones do no
//! harm. Where a map is taught, a window of pictures from different places is also solved together, as a linear program of their poses and of the
//! landmarks that they show: landmarks tell how the robot turned from picture to picture, better than most teachers. Sightings that contradict their
//! landmark's box are left out of it.
//!
//! Whether a box holds its landmark is claimed with every later sighting, and counts for the quota: nothing else relies on it.

use std::{
    collections::{BTreeMap, VecDeque},
    sync::Arc,
};

use interval::{Interval, IntervalBox, contractor::q_intersection};

use crate::{
    PoseBox,
    graph::{Relations, Variable, bounds_over},
    map::{SpacePoint, ViewCamera, ViewPicture, ViewSight, Views, things},
    reading::LandmarkId,
    vision::point_features::{Landmark, Record, Refusal, Sighting},
};

use super::{
    ray::Optics,
    relate::{Points, Sight},
    view::choose,
};

/// Number of the sightings of a landmark that may be wrong without harm to its box.
const MOST_WRONG: usize = 2;
/// Greatest number of sightings of a landmark that are kept; those that tell most of its depth are.
const MOST_TOLD: usize = 16;
/// Greatest number of times that a sighting's rows are made anew about what is left of a landmark's box.
const MOST_PASSES: usize = 5;
/// Rows are made anew where a coordinate has become narrower than this share of its width.
const WORTHWHILE: f64 = 0.7;
/// Least number of times that a landmark has been found for it to be worth a place on a map.
const OFTEN: usize = 8;
/// Greatest number of landmarks that are known.
const MOST_KNOWN: usize = 1500;
/// Time after which a landmark that was not found often has its place taken where too many are known: longer than one is in view of a robot that passes.
const PASSING_S: f64 = 8.0;

/// Number of pictures that are solved together, and number of them from one program to the next.
const WINDOW: usize = 12;
const STRIDE: usize = 3;
/// Numbers of groups of landmarks that are solved apart, so that a wrong sighting harms its own group alone, and of landmarks of a group.
const GROUPS: u32 = 2;
const MOST_OF_GROUP: usize = 14;
/// Least number of pictures of a window that show a landmark of its program.
const FEWEST_SHOWN: usize = 3;

/// All landmarks that are known by their looks, by their numbers.
#[derive(Clone, Debug, Default)]
pub(super) struct Album {
    entries: BTreeMap<LandmarkId, Arc<Entry>>,
    n_numbers: u32,
    /// The latest pictures from different places.
    window: VecDeque<Picture>,
    /// Number of pictures since some were solved together.
    n_since: usize,
    /// Pictures of the drives that taught the map.
    views: Arc<Views>,
}

/// A picture of the window.
#[derive(Clone, Debug)]
struct Picture {
    /// Box of the pose that the picture shows.
    pose: PoseBox,
    /// Sightings that do not contradict their landmarks' boxes.
    sights: Vec<Sight>,
}

/// A landmark that is known by its looks.
#[derive(Clone, Debug)]
pub(super) struct Entry {
    pub(super) look: Arc<Landmark>,
    /// What is known of its place.
    pub(super) point: SpacePoint,
    pub(super) record: Record,
    /// The thing that it is on, if it is one of a map that tells.
    pub(super) thing: Option<u32>,
    /// What was known of its place at first, and the stamp of the picture that showed it; before all time for a landmark of the map.
    first: SpacePoint,
    since_s: f64,
    /// What each sighting that tells something of its place leaves of the box; `None` where it contradicts what was known.
    told: Vec<Option<[Interval; 3]>>,
    /// What all programs that bounded its place leave of it.
    related: [Interval; 3],
}

impl Album {
    /// The album of a map's landmarks whose looks are known.
    pub(super) fn of(
        points: &[(LandmarkId, SpacePoint)],
        looks: &[(LandmarkId, Landmark)],
        views: Option<&Views>,
    ) -> Album {
        let mut album = Album { views: Arc::new(views.cloned().unwrap_or_default()), ..Album::default() };
        let things = things(points);
        for (landmark, look) in looks {
            let of_it = |(known, _): &&(LandmarkId, SpacePoint)| known == landmark;
            if let Some(&(_, point)) = points.iter().find(of_it) {
                let entry = Entry::new(Arc::new(look.clone()), point, f64::NEG_INFINITY);
                let thing = things.get(landmark).copied();
                album.entries.insert(*landmark, Arc::new(Entry { thing, ..entry }));
            }
        }
        album.n_numbers = points.iter().map(|(landmark, _)| landmark.0.saturating_add(1)).max().unwrap_or(0);
        album
    }

    /// The landmarks that are still searched, in the order of their numbers.
    pub(super) fn searched(&self) -> impl Iterator<Item = (LandmarkId, &Entry)> {
        self.entries.iter().filter(|(_, entry)| entry.is_searched()).map(|(landmark, entry)| (*landmark, &**entry))
    }

    /// Whether a landmark is one of the map.
    pub(super) fn is_of_map(&self, landmark: LandmarkId) -> bool {
        self.entries.get(&landmark).is_some_and(|entry| entry.since_s == f64::NEG_INFINITY)
    }

    pub(super) fn point(&self, landmark: LandmarkId) -> Option<SpacePoint> {
        Some(self.entries.get(&landmark)?.point)
    }

    /// Chooses for each sighting a picture of the drives that taught the map.
    pub(super) fn choose_views(&self, sights: &mut [Sight], pose: &PoseBox) {
        let all = &self.views.sights;
        let views_of = |landmark: LandmarkId| {
            let first = all.partition_point(|(of, _)| *of < landmark);
            all[first..].iter().take_while(|(of, _)| *of == landmark).map(|(_, view)| *view).collect()
        };
        choose(sights, &self.views, views_of, pose);
    }

    /// A picture of the drives that taught the map.
    pub(super) fn picture(&self, index: usize) -> Option<&ViewPicture> {
        self.views.pictures.get(index)
    }

    /// The views of the map, and then those of this drive: for each picture the stamp, the box of the pose that it shows, and its sightings.
    pub(super) fn views(&self, camera: ViewCamera, pictures: &[(f64, PoseBox, &[Sight])]) -> Views {
        let mut views = Views::clone(&self.views);
        let drive = views.cameras.len();
        views.cameras.push(camera);
        for &(stamp_s, pose, sights) in pictures {
            let picture = views.pictures.len();
            views.pictures.push(ViewPicture { stamp_s, camera: drive, pose, turned_since: Vec::new() });
            let is_kept = |sight: &&Sight| self.entries.get(&sight.landmark).is_some_and(|entry| entry.is_kept());
            views.sights.extend(
                sights
                    .iter()
                    .filter(is_kept)
                    .map(|sight| (sight.landmark, ViewSight { picture, at_px: sight.at_px, error_px: sight.error_px })),
            );
        }
        views.sights.sort_by_key(|(landmark, view)| (*landmark, view.picture));
        views
    }

    /// Landmarks that are worth a place on a map: those of the map, and those that were found often enough.
    pub(super) fn kept(&self) -> impl Iterator<Item = (LandmarkId, &Entry)> {
        self.entries.iter().filter(|(_, entry)| entry.is_kept()).map(|(landmark, entry)| (*landmark, &**entry))
    }

    /// Notes the result of a search for a landmark in a picture that should show it.
    pub(super) fn note(&mut self, landmark: LandmarkId, result: &Result<Sighting, Refusal>) {
        if let Some(entry) = self.entries.get_mut(&landmark) {
            Arc::make_mut(entry).record.note(result);
        }
    }

    /// Adds a landmark that a picture has shown for the first time, and returns its number; `None` where too many are known.
    pub(super) fn add(&mut self, look: Landmark, point: SpacePoint, stamp_s: f64) -> Option<LandmarkId> {
        if self.entries.len() >= MOST_KNOWN {
            // Those that pictures have left behind before they were found often are worth no place.
            let is_kept = |entry: &Entry| entry.is_kept() || entry.since_s > stamp_s - PASSING_S;
            self.entries.retain(|_, entry| is_kept(entry));
            if self.entries.len() >= MOST_KNOWN {
                return None;
            }
        }
        let landmark = LandmarkId(self.n_numbers);
        self.n_numbers = self.n_numbers.checked_add(1)?;
        self.entries.insert(landmark, Arc::new(Entry::new(Arc::new(look), point, stamp_s)));
        Some(landmark)
    }

    /// Learns from a picture that shows a pose within a box: from sightings of known landmarks, and from the first ones of new landmarks. A landmark
    /// on whose place its sightings do not agree is dropped. Where asked for, the pictures of the window are solved together from time to time.
    pub(super) fn learn(&mut self, pose: &PoseBox, [found, first]: [&[Sight]; 2], optics: &Arc<Optics>, solves: bool) {
        let agrees = |sight: &&Sight| self.learn_one(pose, **sight, optics);
        let mut agreeing: Vec<Sight> = found.iter().filter(agrees).copied().collect();
        agreeing.extend(first);
        if !solves {
            return;
        }
        self.window.push_back(Picture { pose: *pose, sights: agreeing });
        if self.window.len() > WINDOW {
            self.window.pop_front();
        }
        self.n_since += 1;
        if self.n_since >= STRIDE && self.window.len() == WINDOW {
            self.n_since = 0;
            // Rows that are made anew about narrower boxes lose less.
            (0..2 * GROUPS).for_each(|turn| self.solve(turn % GROUPS, optics));
        }
    }

    /// Learns from one sighting. Returns whether it agrees with what was known of its landmark.
    fn learn_one(&mut self, pose: &PoseBox, sight: Sight, optics: &Arc<Optics>) -> bool {
        let Some(entry) = self.entries.get_mut(&sight.landmark) else { return false };
        let left = left_of(Sight { point: entry.point, ..sight }, pose, optics);
        if left == Some(entry.point.value) {
            return true;
        }
        let entry = Arc::make_mut(entry);
        entry.told.push(left);
        if entry.told.len() > MOST_TOLD {
            let width = |at: &usize| entry.told[*at].map_or(0.0, |value| value[2].width());
            if let Some(widest) = (0..entry.told.len()).max_by(|a, b| width(a).total_cmp(&width(b))) {
                entry.told.remove(widest);
            }
        }
        if !entry.agrees() {
            self.entries.remove(&sight.landmark);
        }
        left.is_some()
    }

    /// Bounds the landmarks of a group by all pictures of the window together. Where these contradict each other, nothing is learnt.
    fn solve(&mut self, group: u32, optics: &Arc<Optics>) {
        let mut shown: BTreeMap<LandmarkId, usize> = BTreeMap::new();
        for sight in self.window.iter().flat_map(|picture| &picture.sights) {
            let is_known = sight.landmark.0 % GROUPS == group && self.entries.contains_key(&sight.landmark);
            *shown.entry(sight.landmark).or_default() += usize::from(is_known);
        }
        let mut often: Vec<(usize, LandmarkId)> =
            shown.into_iter().filter(|(_, n)| *n >= FEWEST_SHOWN).map(|(landmark, n)| (n, landmark)).collect();
        often.sort_by_key(|&(n, landmark)| (std::cmp::Reverse(n), landmark));
        often.truncate(MOST_OF_GROUP);
        if often.is_empty() {
            return;
        }
        let related: Vec<(PoseBox, Points)> = self
            .window
            .iter()
            .map(|picture| {
                let is_of_group = |sight: &&Sight| often.iter().any(|(_, landmark)| *landmark == sight.landmark);
                let known = |sight: &Sight| Some(Sight { point: self.point(sight.landmark)?, ..*sight });
                let seen = picture.sights.iter().filter(is_of_group).filter_map(known).collect();
                (picture.pose, Points { optics: Arc::clone(optics), seen })
            })
            .collect();
        let readings: Vec<(PoseBox, &dyn Relations)> =
            related.iter().map(|(pose, points)| (*pose, points as &dyn Relations)).collect();
        let wanted: Vec<Variable> =
            often.iter().flat_map(|(_, landmark)| (0..3).map(|k| Variable::Point(*landmark, k))).collect();
        let Some(bounds) = bounds_over(&readings, &wanted) else { return };
        let bounds: Vec<(Variable, Interval)> = wanted.into_iter().zip(bounds).collect();
        self.narrow(&bounds);
    }

    /// Narrows landmarks by bounds that follow from pictures. Those of which nothing is left are dropped.
    pub(super) fn narrow(&mut self, bounds: &[(Variable, Interval)]) {
        let mut narrower: BTreeMap<LandmarkId, [Interval; 3]> = BTreeMap::new();
        for &(variable, bound) in bounds {
            if let Variable::Point(landmark, k) = variable {
                narrower.entry(landmark).or_insert([Interval::ENTIRE; 3])[k] = bound;
            }
        }
        for (landmark, value) in narrower {
            let Some(entry) = self.entries.get_mut(&landmark) else { continue };
            let entry = Arc::make_mut(entry);
            entry.related = [0, 1, 2].map(|k| entry.related[k].intersect(value[k]));
            if !entry.agrees() {
                self.entries.remove(&landmark);
            }
        }
    }

    /// Begins the window of pictures anew: the next picture does not follow those before.
    pub(super) fn interrupt(&mut self) {
        self.window.clear();
    }

    /// Makes all that is known the knowledge with which a new drive begins.
    pub(super) fn begin_anew(&mut self) {
        self.window.clear();
        for entry in self.entries.values_mut() {
            let anew = Entry::new(Arc::clone(&entry.look), entry.point, f64::NEG_INFINITY);
            *entry = Arc::new(Entry { thing: entry.thing, ..anew });
        }
    }
}

impl Entry {
    fn new(look: Arc<Landmark>, point: SpacePoint, since_s: f64) -> Entry {
        Entry {
            look,
            point,
            record: Record::default(),
            thing: None,
            first: point,
            since_s,
            told: Vec::new(),
            related: [Interval::ENTIRE; 3],
        }
    }

    /// Whether the landmark is worth a place on a map.
    fn is_kept(&self) -> bool {
        self.since_s == f64::NEG_INFINITY || self.record.n_found >= OFTEN
    }

    /// Whether the landmark has not been missed too often. One that was found for long may be hidden for long.
    fn is_searched(&self) -> bool {
        !self.record.is_retired() || self.record.n_failures < self.record.n_found
    }

    /// Computes anew what is known of the place. Returns whether anything is left.
    fn agrees(&mut self) -> bool {
        let boxes: Vec<IntervalBox<3>> =
            self.told.iter().map(|left| left.map_or(IntervalBox::EMPTY, IntervalBox::new)).collect();
        let told = q_intersection(&boxes, MOST_WRONG);
        self.point.value = [0, 1, 2].map(|k| self.first.value[k].intersect(self.related[k]).intersect(told[k]));
        self.point.value.iter().all(|value| !value.is_empty())
    }
}

/// What a sighting from a pose within a box leaves of a landmark's box; `None` where nothing is left.
fn left_of(sight: Sight, pose: &PoseBox, optics: &Arc<Optics>) -> Option<[Interval; 3]> {
    let wanted = [0, 1, 2].map(|k| Variable::Point(sight.landmark, k));
    let mut left = sight.point;
    for _ in 0..MOST_PASSES {
        let points = Points { optics: Arc::clone(optics), seen: vec![Sight { point: left, ..sight }] };
        let bounds = bounds_over(&[(*pose, &points)], &wanted)?;
        let before = left.value;
        left.value = [0, 1, 2].map(|k| before[k].intersect(bounds[k]));
        if left.value.iter().any(|value| value.is_empty()) {
            return None;
        }
        if (0..3).all(|k| left.value[k].width() >= WORTHWHILE * before[k].width()) {
            break;
        }
    }
    Some(left.value)
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
pub(super) mod tests;

//! The search for known landmarks in a picture, where the boxes of the pose and of each landmark allow them to be.
//!
//! What is searched where matters to what is found, and not to whether a sighting is true.

use std::{collections::BTreeMap, sync::Arc};

use interval::Interval;

use crate::{
    PoseBox,
    map::SpacePoint,
    method::Claim,
    reading::LandmarkId,
    vision::point_features::{Frame, Landmark, Refusal, Search, Sighting, Templates},
};

use super::{
    album::{Album, Entry},
    lens::PictureLens,
    ray::Optics,
    relate::Sight,
    whereabouts::Wanted,
};

/// Greatest number of landmarks that are searched in a picture: about 0.1 ms each.
const MOST_SEARCHED: usize = 60;
/// Greatest side, in pixels, of the part of a picture in which a landmark is searched: everywhere, much looks alike.
const WIDEST_SEARCH_PX: f64 = 300.0;
/// Share by which the apparent size of a landmark may differ from what distances and focal lengths make it, as for slanted surfaces, and the turn in
/// the picture, in radians.
const SIZE_SLACK: f64 = 0.15;
const TURN_RAD: f64 = 0.15;
/// Least cosine of the angle between the directions from which a landmark was first seen and is searched, and greatest ratio of its sizes in both
/// pictures: beyond them a patch is not aligned.
const LEAST_COSINE: f64 = 0.75;
const GREATEST_RATIO: f64 = 2.0;
/// Greatest distance, in metres, from the place from which a landmark was first seen at which it counts as missed.
const FIRST_SEEN_M: f64 = 0.5;
/// Distance from the picture's border, in pixels, within which a landmark is not missed: its patch is not wholly in view.
const BORDER_PX: f64 = 24.0;

/// Where a landmark is searched in a picture.
struct Expected {
    landmark: LandmarkId,
    look: Arc<Landmark>,
    point: SpacePoint,
    thing: Option<u32>,
    region_px: [Interval; 2],
    scale: Interval,
    n_failures: usize,
}

/// What has been found in a picture so far.
#[derive(Default)]
pub(super) struct Searched {
    pub(super) sights: Vec<Sight>,
    /// For each sighting, its claim.
    pub(super) claims: Vec<Claim>,
    /// Places in the picture at or near which landmarks are.
    pub(super) near_px: Vec<[f64; 2]>,
    /// Landmarks that should be wholly in view, near where they were first seen from, and were not found.
    pub(super) missed: Vec<LandmarkId>,
    /// The same from wherever, those included.
    pub(super) absent: Vec<LandmarkId>,
}

impl Searched {
    /// Keeps some of the sightings, given by their places in increasing order.
    pub(super) fn keep(&mut self, kept: &[usize]) {
        self.sights = kept.iter().map(|&at| self.sights[at]).collect();
        self.claims = kept.iter().map(|&at| self.claims[at].clone()).collect();
    }
}

/// Whether a pose is near the place from which a landmark was first seen.
fn is_where_first_seen(point: &SpacePoint, pose: &PoseBox) -> bool {
    let [x_m, y_m] = [0, 1].map(|axis| pose[axis].mid() - point.anchor.from_m[axis]);
    x_m.hypot(y_m) <= FIRST_SEEN_M
}

/// The camera by which landmarks are searched.
pub(super) struct Finder {
    pub(super) lens: PictureLens,
    pub(super) optics: Arc<Optics>,
    /// Templates of the landmarks that were searched last, of [`MOST_SEARCHED`] at most: about 32 kB for each level of scale that a search covers.
    templates: BTreeMap<LandmarkId, Templates>,
}

impl Finder {
    pub(super) fn new(lens: PictureLens, optics: Arc<Optics>) -> Finder {
        Finder { lens, optics, templates: BTreeMap::new() }
    }

    /// Searches the landmarks that a picture from a pose within a box may show and that have not been found yet. Where asked for, it is noted of
    /// those that should be wholly in view whether they were found.
    pub(super) fn search(
        &mut self,
        album: &mut Album,
        frame: &mut Frame,
        pose: &PoseBox,
        size_px: [f64; 2],
        searched: &mut Searched,
        notes: bool,
    ) {
        let expected = self.expected(album, pose, size_px);
        self.templates.retain(|landmark, _| expected.iter().any(|one| one.landmark == *landmark));
        for one in expected {
            if searched.sights.iter().any(|sight| sight.landmark == one.landmark) {
                continue;
            }
            let search = Search::in_box(one.region_px, one.scale, Interval::centred(0.0, TURN_RAD));
            let result = frame.find_by(self.templates.entry(one.landmark).or_default(), &one.look, &search);
            let is_in_view = |axis: usize| {
                one.region_px[axis].lo() > BORDER_PX && one.region_px[axis].hi() < size_px[axis] - BORDER_PX
            };
            if result.is_ok() || notes && (0..2).all(is_in_view) {
                album.note(one.landmark, &result);
                // Where more than one place looks alike, it may well be there; and from elsewhere something may always have hidden it.
                let is_missed = matches!(&result, Err(refusal) if !matches!(refusal, Refusal::Ambiguous { .. }));
                if is_missed {
                    searched.absent.push(one.landmark);
                    if is_where_first_seen(&one.point, pose) {
                        searched.missed.push(one.landmark);
                    }
                }
            }
            searched.near_px.push(one.region_px.map(Interval::mid));
            if let Ok(sighting) = result {
                self.take(one.landmark, (one.point, one.thing), &sighting, searched);
            }
        }
    }

    /// Searches landmarks whose depth is known in the whole picture: it may have been taken from anywhere. Whether they were found is not noted.
    pub(super) fn search_everywhere(
        &self,
        album: &Album,
        frame: &mut Frame,
        size_px: [f64; 2],
        searched: &mut Searched,
    ) {
        let whole_px = size_px.map(|size| Interval::new(0.0, size));
        let scale = Interval::new(1.0 / GREATEST_RATIO, GREATEST_RATIO);
        let search = Search::in_box(whole_px, scale, Interval::centred(0.0, TURN_RAD));
        for (landmark, entry) in album.searched().filter(|(_, entry)| entry.point.place_m().is_some()) {
            if let Ok(sighting) = frame.find(&entry.look, &search) {
                self.take(landmark, (entry.point, entry.thing), &sighting, searched);
            }
        }
    }

    /// Searches some landmarks in the whole picture, each at one size: where each of them is seen that is found.
    pub(super) fn search_whole(&self, frame: &mut Frame, size_px: [f64; 2], wanted: &[Wanted]) -> Vec<Sight> {
        let whole_px = size_px.map(|size| Interval::new(0.0, size));
        let mut searched = Searched::default();
        for one in wanted {
            let scale = Interval::point(one.size * one.look.enlargement(self.optics.camera.focal_px.mid()));
            let search = Search::in_box(whole_px, scale, Interval::centred(0.0, TURN_RAD));
            if let Ok(sighting) = frame.find(&one.look, &search) {
                self.take(one.landmark, (one.point, None), &sighting, &mut searched);
            }
        }
        searched.sights
    }

    /// Takes a landmark that was found among the sightings.
    fn take(
        &self,
        landmark: LandmarkId,
        (point, thing): (SpacePoint, Option<u32>),
        sighting: &Sighting,
        searched: &mut Searched,
    ) {
        searched.near_px.push(sighting.position_px);
        let Some((at_px, error_px)) = self.lens.straightened(sighting.position_px, sighting.half_width_px) else {
            return;
        };
        searched.sights.push(Sight { landmark, point, at_px, error_px, view: None, thing });
        searched.claims.push(Claim::SpacePoint {
            landmark,
            point,
            at_px: sighting.position_px,
            half_width_px: sighting.half_width_px,
            view: None,
            thing,
        });
    }

    /// The landmarks that a picture from a pose within a box may show, the most promising ones first.
    fn expected(&self, album: &Album, pose: &PoseBox, size_px: [f64; 2]) -> Vec<Expected> {
        let expected = |(landmark, entry): (LandmarkId, &Entry)| {
            let point = entry.point;
            let enlargement = entry.look.enlargement(self.optics.camera.focal_px.mid());
            if !self.is_seen_alike(&entry.point, enlargement, pose) {
                return None;
            }
            let is_in_picture = |region_px: [Interval; 2]| {
                (0..2).all(|axis| region_px[axis].hi() > 0.0 && region_px[axis].lo() < size_px[axis])
            };
            // Where a wider enclosure, which costs little, is out of the picture, the narrower one within it is, too.
            if self.lens.shown(self.optics.wide_ray(pose, &point)).is_some_and(|region_px| !is_in_picture(region_px)) {
                return None;
            }
            let ray = self.optics.ray(pose, &point);
            let region_px = self.lens.shown(ray)?;
            let is_in_view = is_in_picture(region_px) && region_px.iter().all(|side| side.width() <= WIDEST_SEARCH_PX);
            let length = |[a, b, c]: [Interval; 3]| (a.sqr() + b.sqr() + c.sqr()).sqrt();
            let ratio = length([Interval::ONE, point.value[0], point.value[1]]) / length(ray);
            let slack = Interval::new((1.0 - SIZE_SLACK) * enlargement, (1.0 + SIZE_SLACK) * enlargement);
            let scale = (ratio * slack).intersect(Interval::new(1.0 / GREATEST_RATIO, GREATEST_RATIO));
            let (look, n_failures) = (Arc::clone(&entry.look), entry.record.n_failures);
            (is_in_view && !scale.is_empty()).then_some(Expected {
                landmark,
                look,
                point,
                thing: entry.thing,
                region_px,
                scale,
                n_failures,
            })
        };
        let mut all: Vec<Expected> = album.searched().filter_map(expected).collect();
        let area = |one: &Expected| one.region_px[0].width() * one.region_px[1].width();
        let failing = |one: &Expected| one.n_failures / 5;
        all.sort_by(|a, b| {
            failing(a).cmp(&failing(b)).then(area(a).total_cmp(&area(b))).then(a.landmark.cmp(&b.landmark))
        });
        all.truncate(MOST_SEARCHED);
        all
    }

    /// Whether a landmark is seen from nearly the direction from which it was first seen and at nearly the size, if it is as far away as it may be or
    /// as the middle of its box. The middle alone would be too near for a landmark of which little is known. From the same place this camera shows
    /// the landmark at `enlargement` times the size.
    fn is_seen_alike(&self, point: &SpacePoint, enlargement: f64, pose: &PoseBox) -> bool {
        let [alpha, beta, rho] = point.value;
        let [i, j] = point.anchor.sides();
        let mut first = [point.anchor.sign(); 3];
        (first[i], first[j]) = (alpha.mid(), beta.mid());
        let eye_m = [pose[0].mid(), pose[1].mid(), self.optics.camera.height_m.mid()];
        let (sin, cos) = (pose[2].mid() + self.optics.camera.yaw_rad.mid()).sin_cos();
        let dot = |a: [f64; 3], b: [f64; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
        [rho.lo(), rho.mid()].into_iter().any(|rho| {
            let now = [0, 1, 2].map(|k| first[k] + rho * (point.anchor.from_m[k] - eye_m[k]));
            let lengths = [dot(first, first).sqrt(), dot(now, now).sqrt()];
            let is_ahead = cos * now[0] + sin * now[1] > 0.0;
            let size = enlargement * (lengths[0] / lengths[1].max(1e-9));
            let is_near = (1.0 / GREATEST_RATIO..=GREATEST_RATIO).contains(&size);
            is_ahead && is_near && dot(first, now) >= LEAST_COSINE * lengths[0] * lengths[1]
        })
    }
}

#[cfg(test)]
pub(super) mod tests;

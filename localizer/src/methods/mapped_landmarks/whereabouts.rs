//! Where the landmarks of the map are now that are not found any more where the map has them.
//!
//! Such a landmark is searched in whole pictures, a few of them in each picture by turns. Much looks alike in a whole picture, so that a sighting alone
//! tells nothing. A landmark has moved if nearly all of its sightings agree on one new place, as seen from different places, and if a neighbour on the map
//! has moved with it. All that is used for is what the drive tells of the map: no pose, no claim and no box of a landmark relies on it.

use std::{collections::BTreeMap, sync::Arc};

use interval::Interval;
use nalgebra::{Matrix3, Vector3};

use crate::{
    PoseBox,
    map::{SeenAgain, SpacePoint},
    reading::LandmarkId,
    vision::point_features::Landmark,
};

use super::{album::Album, ray::Optics, relate::Sight};

/// Width of a landmark's box, in metres along any axis, from which on it is not searched elsewhere: it cannot be told from where it would have moved, and
/// what is known so vaguely is seldom a point of a surface.
const VAGUE_M: f64 = 1.0;
/// Least number of pictures in which a landmark was not found for it to be searched elsewhere, and number of them for each in which it was found: what is
/// only hidden now and then is found in between.
const OFTEN_ABSENT: usize = 4;
const ABSENT_PER_FOUND: usize = 4;
/// Greatest number of landmarks that are searched in the whole of one picture. Each takes some hundredths of a millisecond.
const MOST_SEARCHED: usize = 10;
/// Sizes, as multiples of that in a landmark's own picture from its own distance, at which landmarks are searched in one picture after the other. Each
/// covers about a fifth more and less.
const SIZES: [f64; 4] = [1.0, 1.2, 1.44, 0.83];
/// Number of vain searches for a landmark until it is searched by turns again, after a neighbour was found elsewhere: one for each size.
const MOST_VAIN: usize = SIZES.len();
/// Greatest number of sightings of a landmark that are kept, and least distance, in metres, between the places from which they were seen: those from
/// one place are wrong or right together.
const MOST_KEPT: usize = 12;
const APART_M: f64 = 0.1;
/// Part of the bounds of a pose within which the lines of sight pass the landmark's place: the middle of a pose's box is much nearer to the truth than
/// its bounds. In `scenes/landmarks/room_repeat.toml` the root mean square of its error is a sixth of half a width.
pub(super) const PART_OF_BOUNDS: f64 = 0.5;
/// Least angle, in radians, between two lines of sight that tell a place, and least distance, in metres, of that place from where it was seen.
const LEAST_PARALLAX_RAD: f64 = 0.1;
const NEAREST_M: f64 = 0.3;
/// Least number of sightings that agree on a place, and least share of a landmark's sightings. Of the sightings of landmarks that had moved all agreed; of
/// corners of picture frames, which look like those of others, six tenths at most.
const FEWEST_AGREEING: usize = 3;
const LEAST_SHARE: f64 = 0.8;
/// Least distance, in metres, by which a landmark has moved: nearer to its old place it is a wrong box of the map that is seen.
const LEAST_MOVE_M: f64 = 0.2;
/// Distances on the map, in metres, between which a landmark is a neighbour: nearer ones are the same corner twice, which looks like the same
/// other corner. And greatest change of the distance of neighbours that have moved together: places are told to some decimetres where
/// the lines of sight are nearly parallel.
const NEIGHBOUR_M: std::ops::RangeInclusive<f64> = 0.1..=0.8;
const GREATEST_CHANGE_M: f64 = 0.4;

/// A landmark of the map that is searched elsewhere once it is not found any more.
struct Missing {
    look: Arc<Landmark>,
    point: SpacePoint,
    /// Middle of its box on the map.
    at_m: Vector3<f64>,
    /// Sightings elsewhere.
    bearings: Vec<Bearing>,
    /// Number of the latest picture in which it was searched.
    searched_in: usize,
    /// Number of searches in which it comes first, since it or a neighbour was found elsewhere.
    n_first: usize,
}

/// The line along which a landmark was seen, from a pose that is known within bounds.
#[derive(Clone, Copy, Debug)]
struct Bearing {
    eye_m: Vector3<f64>,
    /// Of length 1.
    direction: Vector3<f64>,
    /// Distance by which the line may pass the landmark: this, and this for each metre of its distance.
    off_m: f64,
    off_per_m: f64,
}

/// What one whole picture is searched for.
pub(super) struct Wanted {
    pub(super) landmark: LandmarkId,
    pub(super) look: Arc<Landmark>,
    pub(super) point: SpacePoint,
    /// Size as a multiple of that in its own picture, for a camera with the same focal length.
    pub(super) size: f64,
}

/// The landmarks of the map whose places the map knows.
pub(super) struct Whereabouts {
    missing: BTreeMap<LandmarkId, Missing>,
    n_pictures: usize,
}

impl Whereabouts {
    /// The landmarks of an album that holds those of a map and no others.
    pub(super) fn of(album: &Album) -> Whereabouts {
        let missing = album.searched().filter_map(|(landmark, entry)| {
            let place_m = entry.point.place_m().filter(|sides| sides.iter().all(|side| side.width() <= VAGUE_M))?;
            let at_m = Vector3::from(place_m.map(Interval::mid));
            let (look, bearings) = (Arc::clone(&entry.look), Vec::new());
            Some((landmark, Missing { look, point: entry.point, at_m, bearings, searched_in: 0, n_first: 0 }))
        });
        Whereabouts { missing: missing.collect(), n_pictures: 0 }
    }

    /// The landmarks that the next picture, from about a pose, is to be searched for: of those that are often not found, the ones beside which others
    /// were found elsewhere lately come first, and then those that were not searched for longest.
    pub(super) fn wanted(&mut self, pose: &PoseBox, seen: impl Fn(LandmarkId) -> Option<SeenAgain>) -> Vec<Wanted> {
        self.n_pictures += 1;
        let is_absent = |landmark: LandmarkId| {
            seen(landmark)
                .is_some_and(|seen| seen.n_absent >= OFTEN_ABSENT && seen.n_absent >= ABSENT_PER_FOUND * seen.n_found)
        };
        let at_m = [0, 1].map(|axis| pose[axis].mid());
        let is_wanted = |(landmark, one): &(&LandmarkId, &mut Missing)| one.takes_from(at_m) && is_absent(**landmark);
        let mut wanted: Vec<(&LandmarkId, &mut Missing)> = self.missing.iter_mut().filter(is_wanted).collect();
        wanted.sort_by_key(|(landmark, one)| (one.n_first == 0, one.searched_in, **landmark));
        wanted.truncate(MOST_SEARCHED);
        let (n_pictures, size) = (self.n_pictures, SIZES[self.n_pictures % SIZES.len()]);
        let search = |(landmark, one): (&LandmarkId, &mut Missing)| {
            one.searched_in = n_pictures;
            one.n_first = one.n_first.saturating_sub(1);
            Wanted { landmark: *landmark, look: Arc::clone(&one.look), point: one.point, size }
        };
        wanted.into_iter().map(search).collect()
    }

    /// Keeps sightings where no pose of a box shows their landmarks.
    pub(super) fn keep(&mut self, sights: &[&Sight], pose: &PoseBox, optics: &Optics) {
        for sight in sights {
            let bearing = Bearing::of(sight, pose, optics);
            let missing = self.missing.get_mut(&sight.landmark);
            if let Some(one) = missing.filter(|one| one.takes_from([bearing.eye_m.x, bearing.eye_m.y])) {
                one.bearings.push(bearing);
                let at_m = one.at_m;
                let is_near = |other: &&mut Missing| (other.at_m - at_m).norm() <= *NEIGHBOUR_M.end();
                self.missing.values_mut().filter(is_near).for_each(|other| other.n_first = MOST_VAIN);
            }
        }
    }

    /// The landmarks that have moved: where they are now, and in how many pictures they were found there.
    pub(super) fn moved(&self) -> BTreeMap<LandmarkId, ([f64; 3], usize)> {
        let found = |(landmark, one): (&LandmarkId, &Missing)| {
            let (now_m, n_agreeing) = met(&one.bearings)?;
            let is_told = n_agreeing >= FEWEST_AGREEING && n_agreeing as f64 >= LEAST_SHARE * one.bearings.len() as f64;
            let is_elsewhere = (now_m - one.at_m).norm() >= LEAST_MOVE_M;
            (is_told && is_elsewhere).then_some((*landmark, one.at_m, now_m, n_agreeing))
        };
        let found: Vec<(LandmarkId, Vector3<f64>, Vector3<f64>, usize)> =
            self.missing.iter().filter_map(found).collect();
        let is_with_neighbour = |(_, at_m, now_m, _): &&(LandmarkId, Vector3<f64>, Vector3<f64>, usize)| {
            found.iter().any(|(_, other_at_m, other_now_m, _)| {
                let [before_m, now_m] = [(at_m - other_at_m).norm(), (now_m - other_now_m).norm()];
                NEIGHBOUR_M.contains(&before_m) && (now_m - before_m).abs() <= GREATEST_CHANGE_M
            })
        };
        let told = found.iter().filter(is_with_neighbour);
        told.map(|&(landmark, _, now_m, n_agreeing)| (landmark, (now_m.into(), n_agreeing))).collect()
    }
}

impl Missing {
    /// Whether a sighting from about a place of the floor plan tells more.
    fn takes_from(&self, [x_m, y_m]: [f64; 2]) -> bool {
        let is_apart = |last: &Bearing| (x_m - last.eye_m.x).hypot(y_m - last.eye_m.y) >= APART_M;
        self.bearings.len() < MOST_KEPT && self.bearings.last().is_none_or(is_apart)
    }
}

impl Bearing {
    /// The line of sight from the middle of a pose's box, with the camera at its nominal place.
    fn of(sight: &Sight, pose: &PoseBox, optics: &Optics) -> Bearing {
        let camera = &optics.camera;
        let focal_px = camera.focal_px.mid();
        let [right, down] = [0, 1].map(|k| (sight.at_px[k] - camera.centre_px[k].mid()) / focal_px);
        let (sin, cos) = camera.tilt_up_rad.sin_cos();
        let in_robot = |[forward, left]: [f64; 2], angle_rad: f64| {
            let (sin, cos) = angle_rad.sin_cos();
            [cos * forward - sin * left, sin * forward + cos * left]
        };
        let heading_rad = pose[2].mid();
        let [x, y] = in_robot([cos + down * sin, -right], heading_rad + camera.yaw_rad.mid());
        let [east_m, north_m] = in_robot(camera.position_m.map(Interval::mid), heading_rad);
        let error_px = sight.error_px[0].max(sight.error_px[1]);
        Bearing {
            eye_m: Vector3::new(pose[0].mid() + east_m, pose[1].mid() + north_m, camera.height_m.mid()),
            direction: Vector3::new(x, y, sin - down * cos).normalize(),
            off_m: PART_OF_BOUNDS * pose[0].radius().hypot(pose[1].radius()),
            off_per_m: PART_OF_BOUNDS * (pose[2].radius() + camera.yaw_rad.radius()) + error_px / focal_px,
        }
    }

    /// Whether the line passes a place within what is known.
    fn agrees(&self, place_m: &Vector3<f64>) -> bool {
        let from_eye_m = place_m - self.eye_m;
        let along_m = from_eye_m.dot(&self.direction);
        let off_m = (from_eye_m - along_m * self.direction).norm();
        along_m >= NEAREST_M && off_m <= self.off_m + self.off_per_m * along_m
    }
}

/// The place on which the most lines of sight agree, and how many do; `None` where no two of them are far enough from parallel to tell a place. Each
/// pair tells a place; of the pairs on whose place as many agree, the one with the widest angle counts, and all that agree on it tell the place together.
fn met(bearings: &[Bearing]) -> Option<(Vector3<f64>, usize)> {
    let agreeing = |place_m: &Vector3<f64>| -> Vec<Bearing> {
        bearings.iter().filter(|one| one.agrees(place_m)).copied().collect()
    };
    let mut best: Option<(usize, f64, Vec<Bearing>)> = None;
    for (at, one) in bearings.iter().enumerate() {
        for other in &bearings[at + 1..] {
            let parallax_rad = one.direction.cross(&other.direction).norm();
            if parallax_rad < LEAST_PARALLAX_RAD {
                continue;
            }
            let Some(agreeing) = nearest(&[*one, *other]).map(|place_m| agreeing(&place_m)) else { continue };
            let is_better = best.as_ref().is_none_or(|(n, widest_rad, _)| {
                (agreeing.len(), parallax_rad).partial_cmp(&(*n, *widest_rad)) == Some(std::cmp::Ordering::Greater)
            });
            if is_better {
                best = Some((agreeing.len(), parallax_rad, agreeing));
            }
        }
    }
    let place_m = nearest(&best?.2)?;
    Some((place_m, agreeing(&place_m).len()))
}

/// The place with the least sum of squared distances from lines of sight; `None` where they are parallel.
fn nearest(bearings: &[Bearing]) -> Option<Vector3<f64>> {
    let (mut of_place, mut of_eyes) = (Matrix3::zeros(), Vector3::zeros());
    for one in bearings {
        let across = Matrix3::identity() - one.direction * one.direction.transpose();
        of_place += across;
        of_eyes += across * one.eye_m;
    }
    Some(of_place.cholesky()?.solve(&of_eyes))
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests;

//! The method by pictures of the camera that looks ahead: landmarks are surface points that are known by their looks.
//!
//! **Seeing.** In each picture the known landmarks are searched ([`point_features`](crate::vision::point_features)) where the box of the pose and the
//! landmark's box allow them to be. A sighting is an image point with a claimed greatest error. Image points are straightened by the calibrated lens
//! and make the same rows as those of a point camera.
//!
//! **Wrong sightings.** A sighting is true if a point of the landmark's box is seen within the claimed error, and false otherwise: where something
//! else looks like the landmark, where the landmark is no point of a surface, as where one edge passes behind another, and where its box is wrong. Of
//! the sightings of a picture a declared number may be false ([`Declared`]), and all of a number of things that may have moved. Poses stay on which all
//! others agree (`few_wrong`). No sighting is certain by itself; what all of them together say of the pose becomes rows of the graph of key frames
//! (`pose_rows`).
//!
//! **Anywhere.** Where the pose is known vaguely or not at all, landmarks are searched in the whole picture. Much is found then that only looks like
//! them, so that those sightings are claimed which agree on one pose (`consensus`). By them the poses of a wide box are searched (`anywhere`).
//!
//! **Learning.** Where few landmarks are seen, new ones are made of the picture's corners (`album`).

use std::sync::Arc;

use interval::Interval;

use crate::{
    PoseBox, Reading,
    bounds::{self, Assumption},
    graph::{Relations, Stray},
    map::{SpacePoint, Views},
    method::{Claim, Constraint, Context, Memory, Method},
    quota::{Quota, share_of},
    reading::{Camera, LandmarkId},
    robot::{ForwardCameraModel, RobotModel},
    vision::point_features::{Frame, ImageBounds, Landmark},
};

use super::{
    Learning, PointCameraModel,
    album::Album,
    anywhere::{is_vague, may_be_seen},
    consensus::agreeing,
    few_wrong::{FewWrong, MostWrong, things_of},
    finding::{Finder, Searched},
    lens::PictureLens,
    pose_rows::{NearView, PoseRows},
    ray::Optics,
    relate::{Sight, best_known_apart},
    seen_again::Sought,
    spread::Spread,
    telling::most_telling,
    view,
    whereabouts::{PART_OF_BOUNDS, Whereabouts},
    whole_drive::WholeDrive,
};

mod memory;

/// Declared bounds that a constraint from landmarks in pictures relies on.
const RELIES_ON: [Assumption; 12] = [
    bounds::FORWARD_CAMERA_FOCAL,
    bounds::FORWARD_CAMERA_PRINCIPAL_POINT,
    bounds::FORWARD_CAMERA_DISTORTION,
    bounds::FORWARD_CAMERA_POSITION,
    bounds::FORWARD_CAMERA_HEIGHT,
    bounds::FORWARD_CAMERA_YAW,
    bounds::FORWARD_CAMERA_TILT,
    bounds::FORWARD_CAMERA_STAMP,
    bounds::BODY_TILT,
    bounds::BODY_HEAVE,
    bounds::REACH_SPEED,
    bounds::REACH_TURN_RATE,
];

/// Greatest number of sightings of a picture that are used.
const MOST_USED: usize = 18;
/// Widths of the box of a pose, in metres and in radians, above which some landmarks are searched before the others, and the least number of them
/// that tells where the others are.
const VAGUE_M: f64 = 0.08;
const VAGUE_RAD: f64 = 0.03;
const FEWEST_FIRST: usize = 4;
/// Number of things up to which the sightings that are used are spread evenly over those that a picture shows, where things may be wrong.
const EVEN_THINGS: usize = 3;
/// Greatest number of new landmarks that one picture is asked for.
const MOST_NEW: usize = 30;
/// Least distance, in pixels, of a new landmark from known ones, and of sightings that are used from each other: about the radius of a patch.
const APART_PX: f64 = 14.0;
/// Least distance of the robot, in metres, and least turn, in radians, between two pictures from which landmarks are learnt.
const NEW_PLACE_M: f64 = 0.12;
const NEW_PLACE_RAD: f64 = 0.08;
/// Greatest width of the box of a pose, in metres and in radians, from which landmarks are learnt.
const KNOWN_M: f64 = 0.25;
const KNOWN_RAD: f64 = 0.06;
/// Tangent of the greatest slant of surfaces that show landmarks, 50°.
const SLANT: f64 = 1.2;
/// Noise of a camera of a home robot in a room: standard deviation in darkness, in grey levels, and electrons per grey level.
const DARK_NOISE_GREY: f64 = 1.0;
const ELECTRONS_PER_GREY: f64 = 20.0;

/// What is declared of the sightings of landmarks in pictures.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Declared {
    /// Share of a picture's sightings that may be false.
    pub wrong_share: f64,
    /// Number of a picture's sightings that may be false in addition.
    pub wrong_items: usize,
    /// Number of things of the map, such as paintings or shelves, of which all sightings of a picture may be false in addition, since they have moved.
    pub wrong_things: usize,
    /// Least depth, in metres, with which a new landmark begins. A nearer one is outside of its box, and its sightings are false.
    pub least_depth_m: f64,
}

impl Default for Declared {
    /// Defaults for a furnished room. Of the sightings of `scenes/landmarks/room_repeat.toml` a few in a thousand are false at most. Up to eighteen
    /// sightings of a picture are used, so that the share, which is rounded down, adds none to the one that is declared.
    fn default() -> Self {
        Declared { wrong_share: 0.05, wrong_items: 1, wrong_things: 0, least_depth_m: 0.4 }
    }
}

impl Declared {
    /// How many of so many sightings may be false.
    fn wrong_of(&self, n_sightings: usize) -> MostWrong {
        MostWrong { items: share_of(self.wrong_share, n_sightings) + self.wrong_items, things: self.wrong_things }
    }

    /// Greatest number of sightings of one thing that are used of a picture that shows so many things. Where things may be wrong, enough is to be left
    /// without any of them.
    fn most_of_thing(&self, n_things: usize) -> usize {
        if self.wrong_things == 0 { MOST_USED } else { MOST_USED.div_ceil(n_things.clamp(1, EVEN_THINGS)) }
    }
}

/// What is known from earlier drives: landmarks in space, and how they look.
#[derive(Clone, Copy, Debug, Default)]
pub struct KnownLandmarks<'a> {
    /// Landmarks in space.
    pub points: &'a [(LandmarkId, SpacePoint)],
    /// How they look.
    pub looks: &'a [(LandmarkId, Landmark)],
    /// Pictures of the drives that taught them, if these are known.
    pub views: Option<&'a Views>,
}

/// Method that localizes the robot by landmarks in pictures of the camera that looks ahead.
pub struct PicturedLandmarks {
    finder: Finder,
    images: ImageBounds,
    stray: Stray,
    declared: Declared,
    learning: Learning,
    album: Album,
    /// All pictures of a drive that teaches.
    drive: WholeDrive,
    /// Middle of the box of the pose from whose picture landmarks were learnt last.
    learnt_at: Option<[f64; 3]>,
    /// What the drive tells of the landmarks of the map, and of where some of them are now.
    sought: Sought,
    whereabouts: Whereabouts,
}

/// What one picture showed.
struct Shows {
    stamp_s: f64,
    /// The sightings that tell the pose, and how many of them may be false; `None` where none does.
    used: Option<(FewWrong, Vec<Sight>, MostWrong)>,
    /// What was looked for; `None` where the pose was known too vaguely to tell what the picture should show.
    looked_for: Option<LookedFor>,
    /// Looks of what may become new landmarks; `None` where nothing is learnt from the picture.
    new: Option<Vec<Landmark>>,
}

/// What a picture shows of the landmarks that it should show.
struct LookedFor {
    /// Sightings where landmarks were expected, and of landmarks that were searched in the whole picture.
    sights: Vec<Sight>,
    in_whole: Vec<Sight>,
    /// Landmarks that the picture should show and does not, near where they were first seen from and from wherever.
    missed: Vec<LandmarkId>,
    absent: Vec<LandmarkId>,
}

impl Shows {
    /// A picture that shows nothing so far.
    fn nothing(stamp_s: f64) -> Shows {
        Shows { stamp_s, used: None, looked_for: None, new: None }
    }
}

impl PicturedLandmarks {
    /// Makes the method for a robot with a camera.
    pub fn new(
        camera: ForwardCameraModel,
        robot: &RobotModel,
        known: KnownLandmarks,
        learning: Learning,
        declared: Declared,
    ) -> PicturedLandmarks {
        let pinhole = PointCameraModel {
            focal_px: camera.focal_px,
            centre_px: camera.principal_point_px,
            tilt_up_rad: camera.tilt_up_rad,
            yaw_rad: camera.yaw_rad,
            tilt_rad: camera.tilt_error_rad,
            position_m: camera.position_m,
            height_m: camera.height_m,
            error_px: 0.0,
            least_depth_m: declared.least_depth_m,
            stamp_error_s: camera.stamp_error_s,
        };
        let album = Album::of(known.points, known.looks, known.views);
        let taught = known.views.map_or_else(Vec::new, |views| views.cameras.iter().map(view::optics).collect());
        let mut optics = Optics::new(pinhole, robot.body);
        optics.taught = taught;
        PicturedLandmarks {
            finder: Finder::new(PictureLens::new(&camera), Arc::new(optics)),
            images: ImageBounds {
                focal_px: camera.focal_px.mid(),
                slant: SLANT,
                dark_noise_grey: DARK_NOISE_GREY,
                electrons_per_grey: ELECTRONS_PER_GREY,
            },
            stray: Stray::by_reach(camera.stamp_error_s, &robot.reach),
            declared,
            learning,
            whereabouts: Whereabouts::of(&album),
            album,
            drive: WholeDrive::default(),
            learnt_at: None,
            sought: Sought::default(),
        }
    }

    /// Whether the robot has moved or turned far enough since landmarks were learnt last.
    fn is_new_place(&self, pose: &PoseBox) -> bool {
        self.learnt_at.is_none_or(|last| {
            let [x_m, y_m, turned_rad] = [0, 1, 2].map(|axis| pose[axis].mid() - last[axis]);
            x_m.hypot(y_m) >= NEW_PLACE_M || turned_rad.abs() >= NEW_PLACE_RAD
        })
    }

    /// Counts which landmarks of the map a picture shows, if its pose is within a box.
    fn count(&mut self, picture: &Shows, shown: &PoseBox) {
        let Some(looked_for) = picture.looked_for.as_ref().filter(|_| !shown.is_empty()) else { return };
        let of_map = |landmark: &LandmarkId| self.album.is_of_map(*landmark);
        let contradicting = picture.used.as_ref().map_or_else(Vec::new, |(used, ..)| used.contradicting(shown));
        let is_contradicting = |sight: &Sight| sight.thing.is_some_and(|thing| contradicting.contains(&thing));
        // Whether a landmark is seen where it should be is told by the poses near the middle of the box, which are nearly always nearer to the truth.
        let likely = PoseBox::from(
            [0, 1, 2].map(|axis| Interval::centred(shown[axis].mid(), PART_OF_BOUNDS * shown[axis].radius())),
        );
        let seen = looked_for.sights.iter().filter(|sight| of_map(&sight.landmark)).chain(&looked_for.in_whole);
        let (found, elsewhere): (Vec<&Sight>, Vec<&Sight>) =
            seen.partition(|sight| !is_contradicting(sight) && may_be_seen(&self.finder.optics, sight, &likely));
        self.whereabouts.keep(&elsewhere, shown, &self.finder.optics);
        let displaced = elsewhere.iter().filter(|sight| is_contradicting(sight)).map(|sight| sight.landmark);
        self.sought.count_displaced(displaced);
        let found: Vec<LandmarkId> = found.iter().map(|sight| sight.landmark).collect();
        // What was found in the whole picture where it should be was not absent.
        let is_absent = |landmark: &LandmarkId| of_map(landmark) && !found.contains(landmark);
        let missed: Vec<LandmarkId> = looked_for.missed.iter().copied().filter(is_absent).collect();
        let at_m = [shown[0].mid(), shown[1].mid()];
        let from = |landmark: &LandmarkId| {
            let place_m = self.album.point(*landmark)?.place_m()?;
            Some((*landmark, (at_m[1] - place_m[1].mid()).atan2(at_m[0] - place_m[0].mid())))
        };
        let absent: Vec<(LandmarkId, f64)> =
            looked_for.absent.iter().filter(|one| is_absent(one)).filter_map(from).collect();
        self.sought.count(&found, &missed, &absent);
    }

    /// Searches the landmarks that a picture from a pose within a box may show. Returns what is found, and what is left of the box where some landmarks
    /// had to be found before the others.
    fn search(&mut self, frame: &mut Frame, size_px: [f64; 2], prior: PoseBox) -> (Searched, PoseBox) {
        let (mut searched, mut pose) = (Searched::default(), prior);
        // Where little is known, some landmarks tell where the others are. That matters to what is found, and not to whether it is right.
        if pose.width(0).max(pose.width(1)) > VAGUE_M || pose.width(2) > VAGUE_RAD {
            self.finder.search(&mut self.album, frame, &pose, size_px, &mut searched, false);
            if searched.sights.len() >= FEWEST_FIRST {
                let most_wrong = self.declared.wrong_of(searched.sights.len());
                let known = self.by_sights(&searched.sights, most_wrong).pass(&pose);
                pose = if known.is_empty() { pose } else { known };
            }
        }
        self.finder.search(&mut self.album, frame, &pose, size_px, &mut searched, true);
        (searched, pose)
    }

    /// Searches all landmarks in a picture from anywhere. Of what is found that is returned which agrees on a pose; `None` where that is little: it says
    /// nothing of where the robot is, and so claims nothing.
    fn search_everywhere(&self, frame: &mut Frame, size_px: [f64; 2]) -> Option<Searched> {
        let mut searched = Searched::default();
        self.finder.search_everywhere(&self.album, frame, size_px, &mut searched);
        searched.keep(&agreeing(&searched.sights, &self.finder.optics));
        let most_wrong = self.declared.wrong_of(searched.sights.len());
        self.by_sights(&searched.sights, most_wrong).tells_anywhere().then_some(searched)
    }

    /// The constraint of those sightings of a picture, with their claims, that are used, each compared with a picture of the teacher where there is one.
    fn constraint(
        &self,
        shows: Shows,
        (mut sights, mut claims): (Vec<Sight>, Vec<Claim>),
        pose: &PoseBox,
        used: impl FnOnce(&[Sight]) -> Vec<usize>,
    ) -> Constraint {
        self.album.choose_views(&mut sights, pose);
        for (claim, sight) in claims.iter_mut().zip(&sights) {
            if let Claim::SpacePoint { view, .. } = claim {
                *view = sight.view.map(|view| view.sight);
            }
        }
        let used = used(&sights);
        let (sights, claims): (Vec<Sight>, Vec<Claim>) =
            used.into_iter().map(|at| (sights[at], claims[at].clone())).unzip();
        let most_wrong = self.declared.wrong_of(sights.len());
        let on_pose = self.by_sights(&sights, most_wrong);
        let shows = Shows { used: Some((on_pose.clone(), sights, most_wrong)), ..shows };
        Constraint {
            relies_on: RELIES_ON.to_vec(),
            decides: on_pose.says_something(),
            claims,
            quota: Quota { things: most_wrong.things, ..Quota::of_each(most_wrong.items) },
            relations: Some(self.relations(&on_pose)),
            ..Constraint::new(self.name(), shows.stamp_s, on_pose).showing(shows)
        }
    }

    /// What sightings relate.
    fn relations(&self, sightings: &FewWrong) -> Arc<dyn Relations> {
        let stamp_error_s = self.finder.optics.camera.stamp_error_s;
        Arc::new(PoseRows::new(sightings.clone(), stamp_error_s, !self.keeps_drive(), self.near_view(sightings)))
    }

    /// The picture of the drive that taught the map with which sightings are compared.
    fn near_view(&self, sightings: &FewWrong) -> Option<NearView> {
        let picture = sightings.view()?;
        let view = self.album.picture(picture)?;
        Some(NearView { picture, pose: view.pose, turned_since: view.turned_since.clone() })
    }

    /// The contractor of sightings of which a number may be false.
    fn by_sights(&self, sights: &[Sight], most_wrong: MostWrong) -> FewWrong {
        FewWrong::new(&self.finder.optics, self.stray, sights, most_wrong)
    }
}

impl Method for PicturedLandmarks {
    fn name(&self) -> &'static str {
        "mapped_landmarks"
    }

    fn reads(&self, reading: &Reading) -> bool {
        matches!(reading, Reading::Camera { camera: Camera::Forward, .. })
    }

    fn constrain(&mut self, reading: &Reading, context: &Context) -> Option<Constraint> {
        let Reading::Camera { measured_s, camera: Camera::Forward, image, .. } = reading else { return None };
        let prior = self.stray.around(&context.prior.hull());
        let size_px = [image.width(), image.height()].map(f64::from);
        let images = self.images;
        let mut frame = Frame::new(image, &images);
        if is_vague(&prior) {
            let Searched { sights, claims, .. } = self.search_everywhere(&mut frame, size_px)?;
            let best_known = |sights: &[Sight]| best_known_apart(sights, MOST_USED, APART_PX);
            return Some(self.constraint(Shows::nothing(*measured_s), (sights, claims), &prior, best_known));
        }
        let (Searched { sights, claims, near_px, missed, absent }, pose) = self.search(&mut frame, size_px, prior);
        if self.keeps_drive() {
            self.drive.note(*measured_s, &sights);
        }
        let is_found = |landmark: LandmarkId| sights.iter().any(|sight| sight.landmark == landmark);
        let so_far = |landmark| self.sought.so_far(landmark).filter(|_| !is_found(landmark));
        let wanted = self.whereabouts.wanted(&pose, so_far);
        let in_whole = self.finder.search_whole(&mut frame, size_px, &wanted);
        let looked_for = Some(LookedFor { sights: sights.clone(), in_whole, missed, absent });
        let learns = self.learning != Learning::Never && self.is_new_place(&pose);
        let new = learns.then(|| {
            let mut spread = Spread::new(size_px, sights.iter().map(|sight| sight.at_px));
            let is_apart =
                |[u, v]: [f64; 2]| near_px.iter().all(|[near_u, near_v]| (u - near_u).hypot(v - near_v) >= APART_PX);
            frame.landmarks_where(MOST_NEW, |at_px| is_apart(at_px) && spread.takes(at_px))
        });
        let shows = Shows { looked_for, new, ..Shows::nothing(*measured_s) };
        if sights.is_empty() {
            // Learning follows a constraint, though one that says nothing.
            let nothing = self.by_sights(&[], MostWrong::from(1));
            return learns.then(|| Constraint {
                decides: false,
                relations: self.keeps_drive().then(|| self.relations(&nothing)),
                ..Constraint::new(self.name(), *measured_s, nothing).showing(shows)
            });
        }
        let most = (MOST_USED, self.declared.most_of_thing(things_of(sights.iter()).len()));
        let optics = Arc::clone(&self.finder.optics);
        let telling = |sights: &[Sight]| most_telling(sights, &pose, &optics, most, APART_PX);
        Some(self.constraint(shows, (sights, claims), &pose, telling))
    }

    fn memory(&self) -> Option<&dyn Memory> {
        Some(self)
    }

    fn memory_mut(&mut self) -> Option<&mut dyn Memory> {
        Some(self)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn where_things_may_be_wrong_the_sightings_of_one_of_them_are_a_third_of_all_at_most() {
        let of = |wrong_things| Declared { wrong_things, ..Declared::default() };
        assert_eq!([1, 2, 3, 5].map(|n_things| of(1).most_of_thing(n_things)), [18, 9, 6, 6]);
        assert_eq!([1, 3].map(|n_things| of(0).most_of_thing(n_things)), [18, 18]);
        assert_eq!(of(2).wrong_of(18), MostWrong { items: 1, things: 2 });
    }
}

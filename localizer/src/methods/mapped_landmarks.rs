//! `mapped_landmarks`, after paper 4 (Wang, Lambert and Zhang, Computers 2019; landmarks are learnt once with an accurate position and used later
//! without it):
//! bounds the pose by image points of landmarks in space, and learns where the landmarks are.
//!
//! **Constraint.** A landmark is a ray with a bounded inverse depth from an anchor in the world ([`SpacePoint`]), so that it is of use from its first
//! sighting on, and may be infinitely far. An image point gives two equations between the landmark, the pose, the lean of the body and the camera's
//! mount and lens (`ray`), none of which divides by a depth. They are rows of the graph of key frames, and rows of a program for the pose at the
//! image's own stamp.
//!
//! **Learning.** A landmark that an image shows for the first time is a ray of unknown depth. The graph of key frames bounds the landmarks together with
//! the poses and the constants of the camera, which have one value: what parallax tells. With every program the boxes become narrower, so that rows that
//! are made anew lose less. Boxes only ever shrink, except when what was learnt is taken back. To teach a map, the key frames of the whole drive are
//! kept, and the graph bounds all landmarks by them once more at its end.
//!
//! A point camera tells which landmark is where in the image; [`pictures`] finds landmarks in real pictures.
//!
//! **Source.** Paper 4's sections 2 and 3, with relations in place of its boxes: the paper contracts boxes of poses and landmarks in a sliding window
//! (DIGO). Its text has errors; the book's page on the five papers lists them.

mod album;
mod anywhere;
mod atlas;
mod camera;
mod consensus;
mod few_wrong;
mod finding;
mod lens;
pub mod pictures;
mod pose_rows;
mod ray;
mod relate;
mod seen_again;
mod spread;
mod telling;
mod view;
mod whereabouts;
mod whole_drive;

use std::sync::Arc;

use interval::Interval;

use crate::{
    PoseUnion, Reading, RobotModel,
    bounds::{self, Assumption},
    graph::{PoseByRows, Relations, Stray, Variable},
    map::SpacePoint,
    method::{Constraint, Context, Knowledge, Memory, Method, OnPose, Shown},
    reading::LandmarkId,
};

use atlas::Atlas;
pub use camera::{DEVICE, PointCameraModel, SeenPoint};
use ray::Optics;
use relate::{Points, Sight};

/// Greatest number of landmarks of an image of which rows are made. Those whose direction from the robot is known best are taken.
const MOST_RELATED: usize = 12;
/// The same for an image of a drive that is over.
const MOST_RELATED_AFTER: usize = 20;

/// Declared bounds that a constraint from image points of landmarks relies on.
const RELIES_ON: [Assumption; 13] = [
    bounds::POINT_CAMERA_POSITION,
    bounds::POINT_CAMERA_HEIGHT,
    bounds::POINT_CAMERA_YAW,
    bounds::POINT_CAMERA_TILT,
    bounds::POINT_CAMERA_FOCAL,
    bounds::POINT_CAMERA_CENTRE,
    bounds::POINT_CAMERA_POINTS,
    bounds::POINT_CAMERA_LEAST_DEPTH,
    bounds::POINT_CAMERA_STAMP,
    bounds::BODY_TILT,
    bounds::BODY_HEAVE,
    bounds::REACH_SPEED,
    bounds::REACH_TURN_RATE,
];

/// Whether the method learns where landmarks are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Learning {
    /// It uses the landmarks of the map as they are.
    Never,
    /// It learns as it drives, from the latest key frames.
    Drives,
    /// It also keeps the images of the whole drive, by which all landmarks are bounded at its end. Their number grows with the length of the drive.
    Teaches,
}

/// Method that localizes the robot by landmarks in space, which it takes from a map or learns.
pub struct MappedLandmarks {
    optics: Arc<Optics>,
    stray: Stray,
    atlas: Atlas,
    /// Whether landmarks are learnt, beside those of the map.
    learning: Learning,
    contradicts: bool,
}

impl MappedLandmarks {
    /// Makes the method for a point camera on a robot. `map` are the landmarks that are known from an earlier drive.
    pub fn new(
        camera: PointCameraModel,
        robot: &RobotModel,
        map: &[(LandmarkId, SpacePoint)],
        learning: Learning,
    ) -> MappedLandmarks {
        MappedLandmarks {
            stray: Stray::by_reach(camera.stamp_error_s, &robot.reach),
            optics: Arc::new(Optics::new(camera, robot.body)),
            atlas: Atlas::of(map),
            learning,
            contradicts: false,
        }
    }

    /// What the image points relate, as far as their landmarks are known.
    fn related(&self, seen: &[SeenPoint], most: usize) -> Points {
        let known = |one: &SeenPoint| Some(Sight::told(one, self.atlas.point(one.landmark)?, &self.optics));
        let mut seen: Vec<Sight> = seen.iter().filter_map(known).collect();
        seen.sort_by(Sight::better_known_first);
        seen.truncate(most);
        Points { optics: Arc::clone(&self.optics), seen }
    }
}

impl Method for MappedLandmarks {
    fn name(&self) -> &'static str {
        "mapped_landmarks"
    }

    fn reads(&self, reading: &Reading) -> bool {
        matches!(reading, Reading::Other { device, .. } if device == DEVICE)
    }

    fn constrain(&mut self, reading: &Reading, _context: &Context) -> Option<Constraint> {
        let Reading::Other { measured_s, numbers, .. } = reading else { return None };
        let seen = SeenPoint::of(numbers)?;
        let points = self.related(&seen, MOST_RELATED);
        let relations = Arc::new(points);
        let n_known = relations.seen.len();
        let on_pose = PoseByRows { relations: Arc::clone(&relations) as Arc<_>, stray: self.stray };
        Some(Constraint {
            relies_on: if n_known > 0 { RELIES_ON.to_vec() } else { Vec::new() },
            // Two landmarks give four equations for three coordinates of the pose.
            decides: n_known > 1,
            relations: (n_known > 0).then_some(relations as Arc<_>),
            shown: (self.learning != Learning::Never).then(|| Arc::new(seen) as _),
            ..Constraint::new(self.name(), *measured_s, on_pose)
        })
    }

    fn memory(&self) -> Option<&dyn Memory> {
        Some(self)
    }

    fn memory_mut(&mut self) -> Option<&mut dyn Memory> {
        Some(self)
    }
}

impl Memory for MappedLandmarks {
    /// The constraint of an image by what is known of its landmarks now: they may have been unlearnt since.
    fn on_pose_again(&self, shown: &Shown) -> Option<OnPose> {
        let relations = Arc::new(self.related(shown.downcast_ref::<Vec<SeenPoint>>()?, MOST_RELATED));
        Some(Box::new(PoseByRows { relations, stray: self.stray }))
    }

    fn relations_again(&self, shown: &Shown) -> Option<Arc<dyn Relations>> {
        Some(Arc::new(self.related(shown.downcast_ref::<Vec<SeenPoint>>()?, MOST_RELATED_AFTER)))
    }

    fn keeps_drive(&self) -> bool {
        self.learning == Learning::Teaches
    }

    fn learns_landmarks(&self) -> bool {
        self.learning != Learning::Never
    }

    fn narrow(&mut self, bounds: &[(Variable, Interval)]) {
        self.contradicts |= !self.atlas.narrow(bounds);
    }

    fn knowledge(&self) -> Option<Knowledge> {
        (self.learning != Learning::Never).then(|| Arc::new(self.atlas.clone()) as _)
    }

    fn go_back(&mut self, known: &Knowledge) {
        if let Some(atlas) = known.downcast_ref::<Atlas>() {
            self.atlas.clone_from(atlas);
        }
    }

    fn learn(&mut self, shown: &Shown, posterior: Option<&PoseUnion>) {
        let (Some(seen), Some(posterior)) = (shown.downcast_ref::<Vec<SeenPoint>>(), posterior) else { return };
        // The pose that the image shows.
        let pose = self.stray.around(&posterior.hull());
        self.atlas.learn(&pose, seen, &self.optics);
    }

    fn take_contradiction(&mut self) -> bool {
        std::mem::take(&mut self.contradicts)
    }

    /// Landmarks whose depth is bounded, seen from above.
    fn landmarks(&self) -> Vec<(LandmarkId, [Interval; 2])> {
        let above = |(landmark, point): (LandmarkId, SpacePoint)| {
            let [x, y, _] = point.place_m()?;
            Some((landmark, [x, y]))
        };
        self.atlas.points().filter_map(above).collect()
    }

    fn space_points(&self) -> Vec<(LandmarkId, SpacePoint)> {
        self.atlas.points().collect()
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests;
#[cfg(test)]
pub(crate) mod trial;

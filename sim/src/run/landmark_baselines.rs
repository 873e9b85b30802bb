//! Point matching on a map of landmarks, to compare with the method `mapped_landmarks` by pictures.

use localizer::{
    Pose, PoseBox, Reading,
    baselines::{MatchedPicture, PointMatching},
    methods::mapped_landmarks::pictures::KnownLandmarks,
    reading::Camera,
};

use crate::{
    scene::{MethodName, Scene},
    truth::Truth,
};

/// Name of point matching in the manner of ORB-SLAM, with least squares.
pub(super) const POINT_MATCHING: &str = "point_matching";

/// Poses by point matching at every step of the record. There are none without a map of landmarks in pictures, which the method `mapped_landmarks`
/// uses, nor for a robot without a gyroscope.
#[derive(Default)]
pub struct LandmarkBaselines {
    matching: Option<PointMatching>,
    /// Poses at every step.
    pub poses: Vec<Pose>,
    /// What each picture was matched with, and the true state at the picture.
    pub pictures: Vec<(MatchedPicture, Truth)>,
}

impl LandmarkBaselines {
    /// Names of the figures of point matching in a summary: mean number of matches of a picture, share of the pictures that gave a pose, share of all
    /// matches that are wrong, and share of those wrong that agreed with the pose that their picture gave.
    pub const FIGURES: [&str; 4] = [
        "point_matches_mean",
        "point_matches_fix_share",
        "point_matches_wrong_share",
        "point_matches_agreeing_wrong_share",
    ];

    /// Point matching for a scene, from a start in a box of poses.
    pub(super) fn new(scene: &Scene, start: &PoseBox) -> Self {
        LandmarkBaselines { matching: Self::matching(scene, start), ..LandmarkBaselines::default() }
    }

    /// Begins anew at a station.
    pub(super) fn restart(&mut self, scene: &Scene, start: &PoseBox) {
        self.matching = Self::matching(scene, start);
    }

    fn matching(scene: &Scene, start: &PoseBox) -> Option<PointMatching> {
        let map = scene.localizer.mapped_landmarks().known?;
        let is_used = scene.localizer.methods.contains(&MethodName::MappedLandmarks);
        let known = KnownLandmarks { points: &map.landmarks, looks: &map.looks, views: None };
        PointMatching::new(&scene.robot_model(), known, start).filter(|_| is_used)
    }

    /// Takes in a reading of wheels, gyroscope or forward camera; other readings are ignored.
    pub(super) fn sense(&mut self, reading: &Reading, truth: &Truth) {
        let Some(matching) = &mut self.matching else { return };
        match reading {
            Reading::Wheels { measured_s, ticks, .. } => matching.roll(*measured_s, *ticks),
            Reading::Gyro { rate_rad_per_s, .. } => matching.turn(*rate_rad_per_s),
            Reading::Camera { camera: Camera::Forward, measured_s, image, .. } => {
                self.pictures.push((matching.see(*measured_s, image), *truth));
            }
            _ => {}
        }
    }

    /// Adds the pose at a step.
    pub(super) fn step(&mut self) {
        self.poses.extend(self.matching.as_ref().map(PointMatching::pose));
    }
}

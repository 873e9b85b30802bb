//! A map of landmarks used as a careful engineer would use it: binary features matched over the whole picture, a pose by RANSAC and least squares,
//! and odometry in between.
//!
//! It sees the pictures and the map of the method [`mapped_landmarks`](crate::methods::mapped_landmarks::pictures), and tells a pose without bounds.
//! The chain is that of ORB-SLAM's tracking by a known map (R. Mur-Artal, J. D. Tardós, "ORB-SLAM: a versatile and accurate monocular SLAM system",
//! IEEE Transactions on Robotics 31 (2015), section V), in the plane: the robot stands on a level floor, so that x, y and heading are all there is.
//!
//! 1. Wheels and gyroscope, less its bias at rest, predict the pose at the picture's stamp, with a covariance.
//! 2. Landmarks that the camera may see from there are matched with the picture's keypoints by their descriptors alone.
//! 3. RANSAC finds the pose near the predicted one that most matches agree with.
//! 4. Near where landmarks should be seen from there, they are matched once more; least squares give the pose by all matches that agree.
//! 5. The prediction and this pose are averaged by their covariances, as in a Kalman filter. Where too few agree, odometry carries on.

mod resection;

use std::collections::VecDeque;

use image::GrayImage;

use crate::{
    Pose, PoseBox, RobotModel,
    map::SpacePoint,
    methods::mapped_landmarks::pictures::KnownLandmarks,
    reading::LandmarkId,
    robot::WheelModel,
    vision::point_features::{Frame, ImageBounds, Landmark, PointMatch},
};

use super::{DeadReckoning, Way, WeightedPose, pose_graph::Step};
use resection::{LevelCamera, Sight, count};

/// Greatest number of differing comparisons of a match, of 256, anywhere in a picture and near where the landmark should be seen: `TH_LOW` and
/// `TH_HIGH` of ORB-SLAM's code.
const MOST_BITS_ANYWHERE: u32 = 50;
const MOST_BITS_NEAR: u32 = 100;
/// Radius, in pixels, within which a landmark is sought about where it should be seen: that of ORB-SLAM's code for a camera that moves steadily.
const WINDOW_PX: f64 = 15.0;
/// Least number of matches that agree on a pose about which landmarks are sought: two of them propose it, and two more have no part in that.
const LEAST_ROUGHLY: usize = 4;
/// Least number of matches that agree on a pose which is believed: ORB-SLAM's for a picture whose pose is sought on the map.
const LEAST_AGREE: usize = 10;
/// Distance from the picture's border, in pixels, up to which a landmark is matched that should be seen beyond it.
const BEYOND_PX: f64 = 60.0;
/// Least cosine of the angle between the directions from which a landmark was first seen and is seen: ORB-SLAM's, 60°.
const LEAST_COSINE: f64 = 0.5;
/// What is declared of images, of which descriptors use nothing.
const UNBOUNDED: ImageBounds = ImageBounds { focal_px: 1.0, slant: 0.0, dark_noise_grey: 0.0, electrons_per_grey: 1.0 };
/// Time for which poses of odometry are kept: longer than a picture is under way.
const TRACK_S: f64 = 2.0;

/// An image point of a landmark, and the position `[u, v]` of its keypoint in pixels.
type Seen = (Sight, [f64; 2]);

/// A pose by point matching on a map of landmarks.
pub struct PointMatching {
    camera: LevelCamera,
    landmarks: Vec<(SpacePoint, Landmark)>,
    wheels: WheelModel,
    reckoning: DeadReckoning,
    /// Recent poses of odometry with their stamps.
    track: VecDeque<(f64, Pose)>,
    /// The latest pose by a picture, and the pose of odometry at its stamp.
    fixed: WeightedPose,
    fixed_at: Pose,
}

/// What a picture was matched with.
#[derive(Clone, Debug, Default)]
pub struct MatchedPicture {
    /// For each match the landmark, the position `[u, v]` of the keypoint in pixels, and whether it agrees with the pose that the picture gave.
    pub matches: Vec<(SpacePoint, [f64; 2], bool)>,
    /// Whether the picture gave a pose.
    pub is_localized: bool,
}

impl PointMatching {
    /// Point matching that starts in a box of poses; `None` for a robot without forward camera or gyroscope, and for a map without looks.
    pub fn new(robot: &RobotModel, known: KnownLandmarks, start: &PoseBox) -> Option<PointMatching> {
        let look = |landmark: LandmarkId| known.looks.iter().find(|(of, _)| *of == landmark);
        let landmarks: Vec<(SpacePoint, Landmark)> =
            known.points.iter().filter_map(|&(landmark, point)| Some((point, look(landmark)?.1.clone()))).collect();
        let camera = LevelCamera::new(robot.forward_camera.as_ref()?, &robot.body);
        let [x, y, heading] = [0, 1, 2].map(|axis| start[axis]);
        let middle = Pose { x_m: x.mid(), y_m: y.mid(), heading_rad: heading.mid() };
        let reckoning = DeadReckoning::new(middle, robot.wheels.clone(), robot.gyro?, Way::Wheels).with_gyro_at_rest();
        (!landmarks.is_empty()).then(|| PointMatching {
            camera,
            landmarks,
            wheels: robot.wheels.clone(),
            reckoning,
            track: VecDeque::new(),
            fixed: WeightedPose::of_bounds(middle, [x.radius(), y.radius(), heading.radius()]),
            fixed_at: middle,
        })
    }

    /// Adds a turn rate of the gyroscope.
    pub fn turn(&mut self, rate_rad_per_s: f64) {
        self.reckoning.turn(rate_rad_per_s);
    }

    /// Carries the pose on to a reading of the wheels.
    pub fn roll(&mut self, measured_s: f64, ticks: [i64; 2]) {
        self.reckoning.roll(ticks);
        self.track.push_back((measured_s, self.reckoning.pose()));
        self.track.retain(|(stamp_s, _)| *stamp_s > measured_s - TRACK_S);
    }

    /// Localizes by a picture. It shows the robot at its stamp, which is before the latest pose of odometry.
    pub fn see(&mut self, measured_s: f64, image: &GrayImage) -> MatchedPicture {
        let at = self.reckoned_at(measured_s);
        let predicted = self.fixed.carried_on(self.fixed_at, at, &self.wheels);
        let (seen, found) = self.found(image, &predicted);
        let is_localized = found.is_some();
        let agree = found.map_or_else(
            || vec![false; seen.len()],
            |(pose, agree)| {
                // The places of neighbouring landmarks have much the same error, so that many of them tell the pose no better than one.
                let covariance = pose.covariance * count(&agree) as f64;
                self.fixed = predicted.with(&WeightedPose { covariance, ..pose });
                self.fixed_at = at;
                agree
            },
        );
        let told = seen.into_iter().zip(agree);
        let matches = told.map(|((sight, position_px), agrees)| (sight.point, position_px, agrees)).collect();
        MatchedPicture { matches, is_localized }
    }

    /// The matches of a picture, each with the position of its keypoint in pixels, and the pose that enough of them agree on near the predicted one.
    fn found(&self, image: &GrayImage, predicted: &WeightedPose) -> (Vec<Seen>, Option<(WeightedPose, Vec<bool>)>) {
        let size_px = [image.width(), image.height()].map(f64::from);
        let in_view: Vec<&(SpacePoint, Landmark)> = self
            .landmarks
            .iter()
            .filter(|(point, look)| self.may_be_seen(predicted.pose, point, look, size_px))
            .collect();
        let looks: Vec<&Landmark> = in_view.iter().map(|(_, look)| look).collect();
        let seen = |matched: Vec<PointMatch>| -> Vec<Seen> {
            let seen = |one: PointMatch| {
                let at_px = self.camera.straightened(one.position_px)?;
                Some((Sight { point: in_view[one.landmark].0, at_px }, one.position_px))
            };
            matched.into_iter().filter_map(seen).collect()
        };
        let sights = |seen: &[Seen]| -> Vec<Sight> { seen.iter().map(|(sight, _)| *sight).collect() };
        let mut frame = Frame::new(image, &UNBOUNDED);
        let anywhere = seen(frame.matched(&looks, MOST_BITS_ANYWHERE, |_, _| true));
        let rough = self.camera.ransac(&sights(&anywhere), predicted);
        let Some((rough, _)) = rough.filter(|(_, agree)| count(agree) >= LEAST_ROUGHLY) else {
            return (anywhere, None);
        };
        // Near where the landmarks should be seen then, less alike keypoints are theirs.
        let expected_px: Vec<_> =
            in_view.iter().map(|(point, _)| Some(self.camera.shown(rough.pose, point)?.at_px)).collect();
        let is_near = |landmark: usize, position_px: [f64; 2]| {
            let off_px = expected_px[landmark].zip(self.camera.straightened(position_px)).map(|(a, b)| (a - b).norm());
            off_px.is_some_and(|off_px| off_px <= WINDOW_PX)
        };
        let near = seen(frame.matched(&looks, MOST_BITS_NEAR, is_near));
        let found = self.camera.refined(&sights(&near), rough);
        let found = found.filter(|(pose, agree)| count(agree) >= LEAST_AGREE && pose.agrees_with(predicted));
        (near, found)
    }

    /// The pose at the latest reading of the wheels.
    pub fn pose(&self) -> Pose {
        Step::between(self.fixed_at, self.reckoning.pose()).after(self.fixed.pose)
    }

    /// Whether the camera may see a landmark from about a pose, from a direction and a distance from which it looks much the same.
    fn may_be_seen(&self, pose: Pose, point: &SpacePoint, look: &Landmark, size_px: [f64; 2]) -> bool {
        let most_ratio = Frame::most_matched_ratio();
        let enlargement = look.enlargement(self.camera.focal_px());
        self.camera.shown(pose, point).is_some_and(|shown| {
            (0..2).all(|axis| (-BEYOND_PX..size_px[axis] + BEYOND_PX).contains(&shown.at_px[axis]))
                && shown.cosine >= LEAST_COSINE
                && (1.0 / most_ratio..=most_ratio).contains(&(shown.ratio / enlargement))
        })
    }

    /// The pose of odometry at a stamp, between its poses at the wheels' readings.
    fn reckoned_at(&self, stamp_s: f64) -> Pose {
        let after = self.track.iter().position(|(track_s, _)| *track_s >= stamp_s);
        let Some(after) = after else { return self.reckoning.pose() };
        let (after_s, after) = self.track[after];
        let before = self.track.iter().rev().find(|(track_s, _)| *track_s < stamp_s);
        let &(before_s, before) = before.unwrap_or(&(after_s, after));
        let share = if after_s > before_s { (stamp_s - before_s) / (after_s - before_s) } else { 1.0 };
        let between = |from: f64, to: f64| from + share * (to - from);
        Pose {
            x_m: between(before.x_m, after.x_m),
            y_m: between(before.y_m, after.y_m),
            heading_rad: between(before.heading_rad, after.heading_rad),
        }
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests;

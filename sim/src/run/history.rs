//! The record of a run, for the judge (which checks the estimates against the truth) and for the files of the run.

use std::collections::BTreeMap;

use interval::Interval;
use localizer::{
    Claim, Estimate, Pose, PoseBox, PoseUnion, Reading, Status,
    bounds::Assumption,
    localizer::{Contradiction, PoseWidth, PostLocalized},
    map::{SeenAgain, SpacePoint, Views},
    quota::Quota,
    reading::{Camera, LandmarkId},
    vision::point_features::Landmark,
};

use crate::{
    base::DriveCommand,
    devices::BoundCheck,
    driver::ErrandLog,
    subject::{Failure, Stated},
    truth::Truth,
    world::Drawn,
};

use super::{Clearance, ForwardBaselines, LandmarkBaselines, MarkerBaselines, MotionBaselines, RangeBaselines};

/// Record of a run, for the judge and for the files of the run. True state and estimate are kept apart, one of each for every step of 10 ms.
pub struct RunRecord {
    /// Seed of the run.
    pub seed: u64,
    /// Name of the localizer under test, for the results alone.
    pub subject: String,
    /// Whether that localizer lives in another program, so that the option `--subject` cannot start it again by its name.
    pub subject_is_elsewhere: bool,
    /// Graphics adapter that rendered the images, if any image was rendered.
    pub adapter: Option<String>,
    /// True values that were drawn at random before the start of the run.
    pub drawn: Drawn,
    /// The true state of the robot at each step.
    pub truths: Vec<Truth>,
    /// Drive commands: for each step but the first of a drive, the command during the 10 ms before the step.
    pub commands: Vec<DriveCommand>,
    /// Indices of the steps at which the robot was put at a station, one of the poses at which the scene makes it stand still. Nothing carries
    /// over from the step before.
    pub restarts: Vec<usize>,
    /// The estimate at each step, at the same times as `truths`.
    pub estimates: Vec<Estimate>,
    /// What the localizer stated at each step, at the same times as `truths`; `None` where it answered with boxes or a point.
    pub stated: Vec<Option<Stated>>,
    /// Age at each step of the newest reading that the answer takes into account, at the same times as `truths`; `None` where it is not told.
    pub ages_s: Vec<Option<f64>>,
    /// Number of readings that the localizer under test was given.
    pub n_readings: usize,
    /// The contradictions between readings for which the localizer found names, in the order in which it did.
    pub contradictions: Vec<Contradiction>,
    /// What makes the width of the pose's box at each key frame of the localizer for which that is known.
    pub widths: Vec<PoseWidth>,
    /// Landmarks in space that the localizer knew at the end, from a map or learnt, in the order of their numbers.
    pub space_points: Vec<(LandmarkId, SpacePoint)>,
    /// How often the localizer found the landmarks of its map that it looked for, in the order of their numbers.
    pub seen_again: Vec<SeenAgain>,
    /// How the landmarks in space look that the localizer knew by their looks at the end, in the order of their numbers.
    pub looks: Vec<(LandmarkId, Landmark)>,
    /// Where pictures show landmarks in space that the localizer knew at the end, if it keeps that.
    pub views: Option<Views>,
    /// The poses of the drive as the localizer told them at its end, by what was read after them as well as before, if it did.
    pub post_localized: Option<PostLocalized>,
    /// What the localizer under test did wrong so that the run ended, if anything.
    pub subject_failure: Option<Failure>,
    /// What the localizer under test wrote for its author.
    pub subject_log: Option<String>,
    /// Whether the localizer under test answers with boxes. Otherwise its estimates are points, stored as boxes without width, of which
    /// only the error is meaningful.
    pub has_boxes: bool,
    /// Record of each image that a method read, with the method's claims and the robot's true state at the middle of the exposure.
    pub images: Vec<ImageRecord>,
    /// Index in `images` of the image that left the widest box, with its reading. It illustrates a failed run in which no estimate missed the
    /// true pose. Kept with [`FramesPolicy::Failures`](crate::run::FramesPolicy) only.
    pub widest_image: Option<(usize, Reading)>,
    /// Poses by wheel odometry alone, at the same times as `truths`.
    pub odometry: Vec<Pose>,
    /// Log of the errands; none for a scene with a route.
    pub errands: Option<ErrandLog>,
    /// Distances of the robot from walls, furniture and people at each step, at the same times as `truths`; empty for a scene with a route.
    pub clearances: Vec<Clearance>,
    /// Results of point methods (which give a pose without bounds) and of interval solvers on the readings of the range camera, for comparison.
    pub range_baselines: RangeBaselines,
    /// Results of paper 5's localization pipeline on the pictures of the ceiling camera, for comparison.
    pub marker_baselines: MarkerBaselines,
    /// Poses by paper 2's dead reckoning on the readings of the run, for comparison.
    pub motion_baselines: MotionBaselines,
    /// The declared bounds that were compared with true values at every reading, and where these bounds were exceeded.
    pub bounds: CheckedBounds,
    /// Results of paper 2's vision chain and image features on the pictures of the forward camera.
    pub forward_baselines: ForwardBaselines,
    /// Poses by point matching on a map of landmarks, and what its pictures were matched with, for comparison.
    pub landmark_baselines: LandmarkBaselines,
    /// Wall-clock time that each stage of the run took.
    pub timing: Timing,
    /// SHA-256 over all readings, in the order of their arrival.
    pub readings_digest: String,
}

/// Record of one image: the claims that a method made about what it shows, and what they did to the estimate.
pub struct ImageRecord {
    /// Number of the image since the start of the run.
    pub number: usize,
    /// Stamp that the camera gave the image.
    pub measured_s: f64,
    /// Time at which the localizer received the image.
    pub arrived_s: f64,
    /// True state of the robot at the true middle of the exposure.
    pub truth: Truth,
    /// Camera that took the image; none for a reading of a range camera.
    pub camera: Option<Camera>,
    /// Name of the method that read the image.
    pub method: &'static str,
    /// Claims that the method made about what the image shows; none when the image did not show what the method looks for.
    pub claims: Vec<Claim>,
    /// How many of the method's claims about the image may be false.
    pub quota: Quota,
    /// Line segments that the method looked at and rejected: `[u0, v0, u1, v1]` in pixels.
    pub rejected_px: Vec<[f64; 4]>,
    /// Box of the poses that this image allows on its own, without the images before it; none where the method does not tell.
    pub alone: Option<PoseBox>,
    /// Whether the method makes later constraints of this image and of theirs together.
    pub is_held: bool,
    /// Whether the method made a constraint on the robot's pose from the image.
    pub constrained: bool,
    /// Whether the constraint left the union of boxes empty.
    pub emptied: bool,
    /// Smallest box around the estimate's boxes at the image's stamp, before the image was used.
    pub prior: PoseBox,
    /// Union of boxes at the image's stamp, just after the constraint.
    pub posterior: PoseUnion,
    /// Landmarks as the method knew them after the image: the landmark's code, and the box of world x and y in which it stands.
    pub landmarks: Vec<(LandmarkId, [Interval; 2])>,
    /// Codes of landmarks that the sensor reported, and for each whether it is the true code of the landmark seen.
    pub codes: Vec<(LandmarkId, bool)>,
    /// The reading itself, kept when the user wants debug frames.
    pub reading: Option<Reading>,
}

/// Wall-clock seconds that each stage of a run took.
#[derive(Clone, Copy, Debug, Default)]
pub struct Timing {
    /// Time of the whole run, without that of the methods to compare with.
    pub wall_s: f64,
    /// Time of the physics.
    pub world_s: f64,
    /// Time of rendering and of the cameras' sensor model.
    pub render_s: f64,
    /// Time of the localizer on all readings but those of cameras.
    pub localizer_s: f64,
    /// Time of the localizer on camera readings, which is mostly vision.
    pub vision_s: f64,
    /// Greatest time of the localizer on one reading of any kind.
    pub slowest_reading_s: f64,
    /// Time of the methods to compare with (baselines); `None` where they were not asked for.
    pub baselines_s: Option<f64>,
}

/// The declared bounds that were compared with true values at every reading.
#[derive(Clone, Debug, Default)]
pub struct CheckedBounds {
    /// For each declared bound, the greatest true value that was found of what it limits.
    pub greatest: BTreeMap<Assumption, f64>,
    /// Each occasion on which a bound was exceeded, in the order in which the readings arrived.
    pub exceeded: Vec<BoundCheck>,
}

impl CheckedBounds {
    /// Adds the checks of one reading: true values compared with declared bounds. The reading is of a drive that began at `offset_s`.
    pub(super) fn note(&mut self, checks: &[BoundCheck], offset_s: f64) {
        for check in checks {
            let greatest = self.greatest.entry(check.bound).or_insert(check.true_value);
            *greatest = greatest.max(check.true_value);
            if check.is_exceeded() {
                let span_s = check.span_s.map(|time_s| time_s + offset_s);
                self.exceeded.push(BoundCheck { span_s, ..*check });
            }
        }
    }
}

impl RunRecord {
    /// Returns the true states of each uninterrupted drive.
    pub fn drives(&self) -> impl Iterator<Item = &[Truth]> {
        let mut bounds = vec![0];
        bounds.extend(self.restarts.iter().copied().filter(|&index| index > 0));
        bounds.push(self.truths.len());
        (1..bounds.len()).map(move |index| &self.truths[bounds[index - 1]..bounds[index]])
    }

    /// Whether, at the last recorded step, the true pose is outside the estimate or the localizer is recovering from a contradiction.
    pub fn lost_at_last_step(&self) -> bool {
        let last = self.truths.last().zip(self.estimates.last());
        last.is_some_and(|(truth, estimate)| {
            estimate.status == Status::Recovering || !estimate.pose.contains(truth.pose)
        })
    }

    /// Keeps the reading of the image that is added to `images` next, if the image leaves a wider box than every image before it.
    pub(super) fn keep_widest(&mut self, reading: &Reading, posterior: &PoseUnion) {
        let widest = self.widest_image.as_ref().and_then(|(index, _)| self.images.get(*index));
        let is_widest = widest.is_none_or(|widest| widest_m(posterior) > widest_m(&widest.posterior));
        if is_widest && matches!(reading, Reading::Camera { .. } | Reading::Range { .. } | Reading::Other { .. }) {
            self.widest_image = Some((self.images.len(), reading.clone()));
        }
    }

    /// Creates the record of a run that has not begun.
    pub fn new(seed: u64, adapter: Option<String>, drawn: Drawn) -> Self {
        RunRecord {
            seed,
            subject: String::new(),
            subject_is_elsewhere: false,
            adapter,
            drawn,
            truths: Vec::new(),
            commands: Vec::new(),
            restarts: Vec::new(),
            estimates: Vec::new(),
            stated: Vec::new(),
            ages_s: Vec::new(),
            n_readings: 0,
            contradictions: Vec::new(),
            widths: Vec::new(),
            space_points: Vec::new(),
            seen_again: Vec::new(),
            looks: Vec::new(),
            views: None,
            post_localized: None,
            subject_failure: None,
            subject_log: None,
            has_boxes: true,
            images: Vec::new(),
            widest_image: None,
            odometry: Vec::new(),
            errands: None,
            clearances: Vec::new(),
            range_baselines: RangeBaselines::default(),
            marker_baselines: MarkerBaselines::default(),
            motion_baselines: MotionBaselines::default(),
            bounds: CheckedBounds::default(),
            forward_baselines: ForwardBaselines::default(),
            landmark_baselines: LandmarkBaselines::default(),
            timing: Timing::default(),
            readings_digest: String::new(),
        }
    }
}

/// Returns the width along x or y, whichever is greater, of the smallest box around a union of boxes.
fn widest_m(union: &PoseUnion) -> f64 {
    let hull = union.hull();
    hull.width(0).max(hull.width(1))
}

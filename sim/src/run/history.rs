//! What a run leaves for the check and the record.

use std::collections::BTreeMap;

use interval::Interval;
use localizer::{
    Claim, Estimate, Pose, PoseBox, PoseUnion, Reading, Status,
    bounds::Assumption,
    quota::Quota,
    reading::{Camera, LandmarkId},
};

use crate::{devices::BoundCheck, drawn::Drawn, driver::ErrandLog, truth::Truth, world::WheelCommand};

use super::{Clearance, ForwardBaselines, MarkerBaselines, MotionBaselines, RangeBaselines};

/// What a run leaves for the check and the record: truth and estimate at every 10 ms step, apart from each other.
pub struct RunRecord {
    /// The run's seed.
    pub seed: u64,
    /// Graphics adapter that rendered the images, if any were rendered.
    pub adapter: Option<String>,
    /// True values drawn before the start.
    pub drawn: Drawn,
    /// Truth at each step.
    pub truths: Vec<Truth>,
    /// The command over the 10 ms before each step but the first of a drive.
    pub commands: Vec<WheelCommand>,
    /// Indices of the steps at which the robot was put at a station: nothing carries over from the step before.
    pub restarts: Vec<usize>,
    /// Estimate at each step, same times.
    pub estimates: Vec<Estimate>,
    /// Whether the subject has answered with boxes; else estimates are points, boxes without width, of which only the error says anything.
    pub has_boxes: bool,
    /// What each image claimed, with the truth at its mid-exposure.
    pub images: Vec<ImageRecord>,
    /// Which of `images` left the widest box, with its reading: what shows a failed run that never lost the truth. Kept with
    /// [`FramesPolicy::Failures`](crate::run::FramesPolicy).
    pub widest_image: Option<(usize, Reading)>,
    /// Poses that odometry alone gives, same times.
    pub odometry: Vec<Pose>,
    /// What became of the errands; none of a route.
    pub errands: Option<ErrandLog>,
    /// How much room the robot had at each step, same times; none of a route.
    pub clearances: Vec<Clearance>,
    /// What point methods and solvers made of the range readings.
    pub range_baselines: RangeBaselines,
    /// What paper 5's pipeline made of the pictures of the ceiling.
    pub marker_baselines: MarkerBaselines,
    /// Where dead reckoning by paper 2 has it.
    pub motion_baselines: MotionBaselines,
    /// The declared bounds that readings had a part in, and where they were exceeded.
    pub bounds: CheckedBounds,
    /// What paper 2's chain and features made of the pictures ahead.
    pub forward_baselines: ForwardBaselines,
    /// Wall-clock time spent, by stage.
    pub timing: Timing,
    /// SHA-256 over all readings, in order of arrival.
    pub readings_digest: String,
}

/// One image's part in the run.
pub struct ImageRecord {
    /// Number of the image since the start.
    pub number: usize,
    /// The stamp the camera gave it.
    pub measured_s: f64,
    /// When the localizer got it.
    pub arrived_s: f64,
    /// Truth at the true middle of the exposure.
    pub truth: Truth,
    /// Camera that took it; none of a range camera's reading.
    pub camera: Option<Camera>,
    /// Method that read it.
    pub method: &'static str,
    /// Claims made; none when the cue was absent.
    pub claims: Vec<Claim>,
    /// How many of them may be false.
    pub quota: Quota,
    /// Segments looked at and rejected: `[u0, v0, u1, v1]` in pixels.
    pub rejected_px: Vec<[f64; 4]>,
    /// Heading that it told without those before it.
    pub alone_heading_rad: Option<Interval>,
    /// Whether a constraint was made of it.
    pub constrained: bool,
    /// Whether the constraint emptied the union.
    pub emptied: bool,
    /// Hull at the stamp without it.
    pub prior: PoseBox,
    /// Union at the stamp just after the constraint.
    pub posterior: PoseUnion,
    /// Landmarks as the method knew them then: code, and box of world x and y.
    pub landmarks: Vec<(LandmarkId, [Interval; 2])>,
    /// Codes that the sensor gave, and whether each is its landmark's own.
    pub codes: Vec<(LandmarkId, bool)>,
    /// The reading itself, kept when frames are asked for.
    pub reading: Option<Reading>,
}

/// Wall-clock seconds spent in each stage.
#[derive(Clone, Copy, Debug, Default)]
pub struct Timing {
    /// Whole run.
    pub wall_s: f64,
    /// Physics.
    pub world_s: f64,
    /// Rendering and sensor model of cameras.
    pub render_s: f64,
    /// Localizer without its methods' vision.
    pub localizer_s: f64,
    /// Vision of methods.
    pub vision_s: f64,
}

/// Bounds that readings had a part in.
#[derive(Clone, Debug, Default)]
pub struct CheckedBounds {
    /// Each of them with the greatest true value behind it.
    pub greatest: BTreeMap<Assumption, f64>,
    /// Where one was exceeded, in the order in which its readings arrived.
    pub exceeded: Vec<BoundCheck>,
}

impl CheckedBounds {
    /// Notes what was behind a reading of a drive that began at `offset_s`.
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
    /// The steps of each uninterrupted drive.
    pub fn drives(&self) -> impl Iterator<Item = &[Truth]> {
        let mut bounds = vec![0];
        bounds.extend(self.restarts.iter().copied().filter(|&index| index > 0));
        bounds.push(self.truths.len());
        (1..bounds.len()).map(move |index| &self.truths[bounds[index - 1]..bounds[index]])
    }

    /// Whether the truth is outside at the last step so far, or an assumption doubted.
    pub fn lost_at_last_step(&self) -> bool {
        let last = self.truths.last().zip(self.estimates.last());
        last.is_some_and(|(truth, estimate)| {
            estimate.status == Status::Recovering || !estimate.pose.contains(truth.pose)
        })
    }

    /// Keeps the next image of `images` if it leaves a wider box than all before it.
    pub(super) fn keep_widest(&mut self, reading: &Reading, posterior: &PoseUnion) {
        let widest = self.widest_image.as_ref().and_then(|(index, _)| self.images.get(*index));
        let is_widest = widest.is_none_or(|widest| widest_m(posterior) > widest_m(&widest.posterior));
        if is_widest && matches!(reading, Reading::Camera { .. } | Reading::Range { .. } | Reading::Other { .. }) {
            self.widest_image = Some((self.images.len(), reading.clone()));
        }
    }

    /// The record of a run that has not begun.
    pub fn new(seed: u64, adapter: Option<String>, drawn: Drawn) -> Self {
        RunRecord {
            seed,
            adapter,
            drawn,
            truths: Vec::new(),
            commands: Vec::new(),
            restarts: Vec::new(),
            estimates: Vec::new(),
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
            timing: Timing::default(),
            readings_digest: String::new(),
        }
    }
}

/// The wider of a union's hull along x and y.
fn widest_m(union: &PoseUnion) -> f64 {
    let hull = union.hull();
    hull.width(0).max(hull.width(1))
}

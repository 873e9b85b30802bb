//! Poses of a drive by what was read after them as well as before, beside the truth and beside what was known when they were passed.

use localizer::{Pose, PoseBox, PoseUnion};

use crate::run::RunRecord;

use super::{statistics::fix_width, verdict::PostLocalization};

/// A key frame of a drive that was looked back at.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PostStep {
    /// Its time.
    pub time_s: f64,
    /// The true pose.
    pub truth: Pose,
    /// The box by post-localization.
    pub pose: PoseBox,
    /// The smallest box around the boxes of the estimate at the step just after, as it was known then.
    pub real_time: PoseBox,
}

/// The key frames of a run's last drive that were looked back at; empty if none were. The truth between two steps of 10 ms is interpolated linearly,
/// which is off by less than 0.02 mm at accelerations of up to 1.6 m/s².
pub fn post_steps(record: &RunRecord) -> Vec<PostStep> {
    let poses = record.post_localized.iter().filter_map(|post| post.poses.as_ref()).flatten();
    let first = record.restarts.last().copied().unwrap_or(0);
    let steps = &record.truths[first..];
    let Some(begin_s) = steps.first().map(|truth| truth.time_s) else { return Vec::new() };
    let step = |&(stamp_s, pose): &(f64, PoseBox)| {
        let time_s = begin_s + stamp_s;
        let after = steps.partition_point(|truth| truth.time_s < time_s);
        let truth = steps.get(after.saturating_sub(1))?.interpolated(steps.get(after)?, time_s);
        Some(PostStep { time_s, truth: truth.pose, pose, real_time: record.estimates.get(first + after)?.pose.hull() })
    };
    poses.filter_map(step).collect()
}

/// What the judge says of the post-localization of a run; `None` for a run without.
pub(super) fn post_localization(record: &RunRecord) -> Option<PostLocalization> {
    let post = record.post_localized.as_ref()?;
    let steps = post_steps(record);
    let contained = steps.iter().filter(|step| PoseUnion::single(step.pose).contains(step.truth)).count();
    let hulls = |of: fn(&PostStep) -> PoseBox| fix_width(&steps.iter().map(of).collect::<Vec<_>>());
    Some(PostLocalization {
        window: post.window,
        checks: steps.len(),
        contained,
        outside: steps.len() - contained,
        contradictory: post.poses.is_none(),
        width: hulls(|step| step.pose),
        real_time_width: hulls(|step| step.real_time),
    })
}

//! Trajectories and boxes as text that other tools read.

use std::fmt::Write;

use localizer::{Estimate, Pose, Status};

use crate::{
    judge::{Verdict, post_steps},
    run::RunRecord,
};

/// True poses in the TUM format, `time x y z qx qy qz qw` on each line. The body's small tilt is left out.
pub(super) fn truth_tum(record: &RunRecord) -> String {
    let poses = record.truths.iter().map(|truth| (truth.time_s, truth.pose, truth.heave_m));
    tum(poses)
}

/// Poses with their times in the TUM format.
pub(crate) fn poses_tum(poses: &[(f64, Pose)]) -> String {
    tum(poses.iter().map(|(time_s, pose)| (*time_s, *pose, 0.0)))
}

/// Midpoints of the estimates' hulls in the TUM format; a hull is the smallest box around an estimate's boxes. A time at which no pose is left has no
/// line.
pub(super) fn estimate_tum(estimates: &[Estimate]) -> String {
    let answered = estimates.iter().filter(|estimate| !estimate.pose.is_empty());
    tum(answered.map(|estimate| {
        let [x_m, y_m, heading_rad] = estimate.pose.hull().midpoint();
        (estimate.time_s, Pose { x_m, y_m, heading_rad }, 0.0)
    }))
}

/// Every box of every estimate, one on each line; a time at which no pose is left has no line.
pub(super) fn boxes_csv(estimates: &[Estimate]) -> String {
    let mut text = "time_s,status,branch,x_min_m,x_max_m,y_min_m,y_max_m,heading_min_rad,heading_max_rad\n".to_owned();
    for estimate in estimates {
        let status = match estimate.status {
            Status::Sound => "sound",
            Status::Recovering => "recovering",
        };
        for (index, branch) in estimate.pose.branches.iter().enumerate() {
            let _ = write!(text, "{:.3},{status},{index}", estimate.time_s);
            for side in branch.components() {
                // Bounds are written with all digits, because a rounded bound might exclude the truth.
                let _ = write!(text, ",{},{}", side.lo(), side.hi());
            }
            text.push('\n');
        }
    }
    text
}

/// Error of the midpoint and full width of the estimate's hull (the smallest box around its boxes), and the judge's judgement, one step on each line;
/// at a step without a pose the fields of error and width are empty.
///
/// The truth is within the hull along an axis when the error there is at most half the width. The truth may lie in the hull but in none of the boxes,
/// so that only `judgement` says whether the union of boxes holds the truth.
pub(super) fn steps_csv(record: &RunRecord, verdict: &Verdict) -> String {
    let mut text =
        "time_s,judgement,error_x_m,error_y_m,error_heading_rad,width_x_m,width_y_m,width_heading_rad\n".to_owned();
    let steps = record.truths.iter().zip(&record.estimates).zip(&verdict.judgements);
    for ((truth, estimate), judgement) in steps {
        let _ = write!(text, "{:.3},{}", truth.time_s, judgement.name());
        let hull = estimate.pose.hull();
        if hull.is_empty() {
            text.push_str(",,,,,,\n");
            continue;
        }
        let (midpoint, truth) = (hull.midpoint(), truth.pose.to_array());
        for axis in 0..3 {
            let _ = write!(text, ",{:.9}", midpoint[axis] - truth[axis]);
        }
        for axis in 0..3 {
            let _ = write!(text, ",{:.9}", hull[axis].width());
        }
        text.push('\n');
    }
    text
}

/// The interval errors, box minus truth, at the key frames that were looked back at at the end of the drive, one on each line: by post-localization and
/// as they were known in real time. They contain 0 where the box holds the truth. `None` if the scene does not ask for them.
pub(super) fn post_localization_csv(record: &RunRecord) -> Option<String> {
    record.post_localized.as_ref()?;
    let mut text = "time_s".to_owned();
    for kind in ["post", "real_time"] {
        for axis in ["x_m", "y_m", "heading_rad"] {
            let _ = write!(text, ",{kind}_{axis}_min,{kind}_{axis}_max");
        }
    }
    text.push('\n');
    for step in post_steps(record) {
        let _ = write!(text, "{:.6}", step.time_s);
        for side in [step.pose, step.real_time] {
            for (side, truth) in side.components().into_iter().zip(step.truth.to_array()) {
                let _ = write!(text, ",{:.9},{:.9}", side.lo() - truth, side.hi() - truth);
            }
        }
        text.push('\n');
    }
    Some(text)
}

/// Mean, covariance and normalised error (NEES) of every distribution that the localizer stated, one step on each line; `None` if it stated none. The
/// fields of covariance and normalised error are empty where the covariance is not finite, not symmetric or not positive definite.
pub(super) fn distribution_csv(record: &RunRecord) -> Option<String> {
    record.stated.iter().flatten().next()?;
    let mut text = "time_s,mean_x_m,mean_y_m,mean_heading_rad,error_x_m,error_y_m,error_heading_rad,\
                    cov_x_x,cov_x_y,cov_x_heading,cov_y_y,cov_y_heading,cov_heading_heading,nees\n"
        .to_owned();
    for (truth, stated) in record.truths.iter().zip(&record.stated) {
        let Some(stated) = stated else { continue };
        let error = stated.error(truth.pose);
        let _ = write!(text, "{:.3}", truth.time_s);
        for number in stated.mean.to_array().iter().chain(error.iter()) {
            let _ = write!(text, ",{number:.9}");
        }
        match &stated.spread {
            None => text.push_str(",,,,,,,\n"),
            Some(spread) => {
                for (row, column) in [(0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2)] {
                    let _ = write!(text, ",{:.9e}", spread.covariance[(row, column)]);
                }
                let _ = writeln!(text, ",{:.6}", spread.squared_distance(&error));
            }
        }
    }
    Some(text)
}

/// Poses in the TUM format; a rotation by ψ about z is the quaternion (0, 0, sin ψ/2, cos ψ/2).
fn tum(poses: impl Iterator<Item = (f64, Pose, f64)>) -> String {
    poses.fold(String::new(), |mut text, (time_s, pose, z_m)| {
        let (sin, cos) = (pose.heading_rad / 2.0).sin_cos();
        // Writing to a `String` cannot fail.
        let _ = writeln!(text, "{time_s:.3} {} {} {z_m} 0 0 {sin} {cos}", pose.x_m, pose.y_m);
        text
    })
}

//! Whether the boxes of a log's estimates hold the true poses, and how far off their middles are.

use interval::Interval;
use localizer::{Estimate, Pose, PoseBox, PoseUnion};
use serde_json::{Value, json};

use super::truth::TruePath;
use crate::{
    judge::{ErrorTable, errors, midpoint},
    scene::LoggedTruth,
    subject::half_turn,
};

/// The estimates of a log compared with its true poses.
#[derive(Clone, Debug)]
pub(super) struct Compared {
    /// Number of estimates at whose times the true pose is known.
    pub(super) checks: usize,
    /// Number of these whose boxes hold the true pose, give or take its own error.
    pub(super) contained: usize,
    /// The first estimate whose boxes do not.
    pub(super) first_outside: Option<Outside>,
    pub(super) error: ErrorTable,
    /// The true poses at the times of estimates.
    pub(super) truths: Vec<(f64, Pose)>,
}

/// An estimate whose boxes do not hold the true pose.
#[derive(Clone, Copy, Debug)]
pub(super) struct Outside {
    pub(super) time_s: f64,
    /// The axis along which the true pose is farthest from the box around the union, and that distance beyond the true pose's own error.
    pub(super) axis: &'static str,
    pub(super) margin: f64,
}

/// Compares estimates with the true poses.
pub(super) fn compare(estimates: &[Estimate], truth: &TruePath, keys: &LoggedTruth) -> Compared {
    let within = [keys.tolerance_m, keys.tolerance_m, keys.tolerance_deg.to_radians()];
    let (mut middles, mut truths, mut contained, mut first_outside) = (Vec::new(), Vec::new(), 0, None);
    for estimate in estimates {
        let Some(pose) = truth.at(estimate.time_s) else { continue };
        let hull = estimate.pose.hull();
        let middle = midpoint(&hull);
        // The localizer counts the robot's turns; the source of the true poses may count them from anywhere.
        let off_rad = half_turn(middle.heading_rad - pose.heading_rad);
        let pose = if off_rad.is_finite() { Pose { heading_rad: middle.heading_rad - off_rad, ..pose } } else { pose };
        let grown = grown(&estimate.pose, within);
        if grown.contains_modulo_turn(pose) {
            contained += 1;
        } else if first_outside.is_none() {
            first_outside = Some(outside(estimate.time_s, &grown.hull(), pose));
        }
        middles.push(middle);
        truths.push((estimate.time_s, pose));
    }
    let poses: Vec<Pose> = truths.iter().map(|(_, pose)| *pose).collect();
    Compared { checks: truths.len(), contained, first_outside, error: errors(&middles, &poses), truths }
}

/// How far the true pose at the beginning is outside of the box in which the robot is declared to begin; `None` where it is inside or not known.
pub(super) fn start_outside(start: &PoseBox, truth: &TruePath, keys: &LoggedTruth) -> Option<Outside> {
    let (begun_s, pose) = (0.0, truth.at(0.0)?);
    let within = [keys.tolerance_m, keys.tolerance_m, keys.tolerance_deg.to_radians()];
    let grown = grown(&PoseUnion::single(*start), within);
    (!grown.contains_modulo_turn(pose)).then(|| outside(begun_s, &grown.hull(), pose))
}

/// The union with every box wider by the error that the true pose may have.
fn grown(union: &PoseUnion, within: [f64; 3]) -> PoseUnion {
    let grow = |branch: &PoseBox| PoseBox::from([0, 1, 2].map(|axis| branch[axis].inflate(within[axis])));
    PoseUnion { branches: union.branches.iter().map(grow).collect() }
}

fn outside(time_s: f64, hull: &PoseBox, pose: Pose) -> Outside {
    let distance = |axis: usize| (hull[axis] - Interval::point(pose.to_array()[axis])).mignitude();
    let far = [("x_m", distance(0)), ("y_m", distance(1)), ("heading_rad", distance(2))];
    let (axis, margin) = far.into_iter().fold(("x_m", 0.0), |most, one| if one.1 > most.1 { one } else { most });
    Outside { time_s, axis, margin }
}

impl Compared {
    /// The entry `containment` of the summary.
    pub(super) fn to_json(&self) -> Value {
        json!({
            "checks": self.checks,
            "contained": self.contained,
            "outside": self.checks - self.contained,
            "first_outside": self.first_outside.map(|first| {
                json!({ "time_s": first.time_s, "axis": first.axis, "margin": first.margin })
            }),
        })
    }
}

//! The methods to compare with (baselines) by their names in a summary, and what each of them answered in a run.

use localizer::Pose;

use super::{Answers, ForwardBaselines, LandmarkBaselines, MarkerBaselines, RunRecord};

/// Name of wheel odometry alone.
const ODOMETRY: &str = "odometry";

/// Names of all methods to compare with, but for the interval solvers of [`SOLVERS`](localizer::baselines::SOLVERS).
pub const BASELINES: [&str; 14] = [
    ODOMETRY,
    super::motion_baselines::WHEELS_AND_GYRO,
    super::motion_baselines::SLIP_DECISION,
    super::motion_baselines::GYRO_AT_REST,
    super::motion_baselines::FLOW_AND_GYRO,
    super::motion_baselines::POSE_GRAPH,
    super::range_baselines::LEAST_SQUARES,
    super::range_baselines::CLOSEST_POINTS,
    super::range_baselines::RANSAC,
    super::range_baselines::GATED_ICP,
    super::range_baselines::TABLE_IV_PRINTED,
    super::marker_baselines::NEAREST_MARKER,
    super::marker_baselines::VERTICAL_KNOWN,
    super::landmark_baselines::POINT_MATCHING,
];

/// Whether a run measures this figure of its summary only when the methods to compare with are run, too.
pub fn needs_baselines(figure: &str) -> bool {
    let of_metrics = [MarkerBaselines::FIGURES, ForwardBaselines::FIGURES, LandmarkBaselines::FIGURES];
    let of_metrics = |name: &str| of_metrics.iter().flatten().any(|one| *one == name);
    match figure.split_once('.') {
        Some(("baselines", rest)) => rest.split('.').next() != Some(ODOMETRY),
        Some(("metrics", name)) => of_metrics(name),
        _ => false,
    }
}

/// What a method to compare with answered in a run.
pub struct BaselineAnswers<'a> {
    /// Name of the method in a summary.
    pub name: &'static str,
    /// Its answers.
    pub told: Told<'a>,
}

/// Answers of a method to compare with.
pub enum Told<'a> {
    /// Poses without bounds, and the true poses at the same times.
    Poses(Vec<Pose>, Vec<Pose>),
    /// Boxes that answer pose problems of the run.
    Boxes(&'a Answers),
}

impl RunRecord {
    /// What each of the methods to compare with answered. A method that was given nothing is left out.
    pub fn baselines(&self) -> Vec<BaselineAnswers<'_>> {
        let truths: Vec<Pose> = self.truths.iter().map(|truth| truth.pose).collect();
        // A method that begins with the first reading has poses for the last steps of the run only.
        let of_steps = |(name, poses): (&'static str, &Vec<Pose>)| {
            let known = truths.get(truths.len().saturating_sub(poses.len())..).unwrap_or_default();
            BaselineAnswers { name, told: Told::Poses(poses.clone(), known.to_vec()) }
        };
        let motion = self.motion_baselines.poses.iter().map(|(name, poses)| (*name, poses));
        let mut all: Vec<BaselineAnswers<'_>> =
            std::iter::once((ODOMETRY, &self.odometry)).chain(motion).map(of_steps).collect();
        let matching = Some(&self.landmark_baselines.poses).filter(|poses| !poses.is_empty());
        all.extend(matching.map(|poses| (super::landmark_baselines::POINT_MATCHING, poses)).map(of_steps));
        all.extend(self.range_baselines.named().into_iter().map(of_steps));
        all.extend(self.marker_baselines.named().into_iter().map(|(name, fixes)| {
            let (poses, truths) = fixes.into_iter().unzip();
            BaselineAnswers { name, told: Told::Poses(poses, truths) }
        }));
        let solvers = self.range_baselines.solvers.iter();
        all.extend(solvers.map(|(name, answers)| BaselineAnswers { name, told: Told::Boxes(answers) }));
        all
    }
}

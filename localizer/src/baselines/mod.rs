//! Baselines to compare the interval localizer with: the point methods that the papers compare themselves with, the contractor that a paper
//! prints, and the point methods of a careful engineer, which a comparison has to beat to be worth anything.

mod corrected_reckoning;
mod dead_reckoning;
mod direction_database;
mod gated_icp;
mod gyro_at_rest;
mod icp;
mod least_squares;
#[cfg(feature = "vision")]
mod point_matching;
pub mod pose_graph;
mod printed_table_iv;
mod ransac;
mod slip_decision;
#[cfg(feature = "vision")]
mod vertical_known;
mod weighted_points;

use interval::contractor::Contractor;

use crate::{
    PoseBox,
    methods::range_landmarks::{Freedom, PoseFromLandmarks, Solver},
    rigid_motion::Landmark,
};

pub use corrected_reckoning::CorrectedReckoning;
pub use dead_reckoning::{DeadReckoning, Way};
pub use direction_database::DirectionDatabase;
pub use gated_icp::GatedIcp;
pub use gyro_at_rest::GyroAtRest;
pub use icp::closest_points;
pub use least_squares::least_squares;
#[cfg(feature = "vision")]
pub use point_matching::{MatchedPicture, PointMatching};
pub use printed_table_iv::printed_table_iv;
pub use ransac::{RansacMap, ransac};
pub use slip_decision::SlipDecision;
#[cfg(feature = "vision")]
pub use vertical_known::{dot_pairs, locate_upright, vertical_known};
pub use weighted_points::{LearntPoint, SQUARED_GATE, SQUARED_GATE_OF_POSE, WeightedPoint, WeightedPose, weighted_fit};

/// Names of the interval solvers (of the planar pose from landmarks) whose results a run writes into a table for comparison, each with its solver.
pub const SOLVERS: [(&str, Solver); 4] = [
    ("table_iv", Solver::TableIv),
    ("polar", Solver::Polar),
    ("one_shot", Solver::OneShot),
    ("sivia", Solver::Sivia { resolution: 0.05 }),
];

/// Boxes of all poses in `prior` that carry each landmark's box in the robot frame into its box in the world, by one solver.
pub fn solve(solver: Solver, landmarks: &[Landmark], prior: &PoseBox) -> Vec<PoseBox> {
    PoseFromLandmarks::new(landmarks.to_vec(), 0, Freedom::Full, solver).branches(prior)
}

//! The whole system of paper 2 (Yi, Lee and Cho 2018) as a point method: dead reckoning, headings from vanishing points by way of the database
//! of directions, and the pose graph.

use std::collections::VecDeque;

use crate::Pose;

use super::{
    DirectionDatabase,
    pose_graph::{Step, Weights, optimised},
};

/// Number of pictures whose poses the pose graph holds; the paper keeps all of them and optimises at the end.
const HELD: usize = 20;
/// Standard deviations for the pose graph, of which the paper states none: 1 % of half a metre of travel, a quarter degree of turn by the
/// gyroscope, and for a heading as much as the paper's vanishing points are off at 0.1 lx.
const WEIGHTS: Weights = Weights { travel_m: 0.005, turn_rad: 0.005, heading_rad: 0.01 };
/// Greatest delay, in seconds, from the taking of a picture to the arrival of the heading read from it; dead-reckoned poses are kept for that long,
/// so that the pose at the picture can be found.
const LATEST_S: f64 = 1.0;

/// Dead reckoning that is corrected by headings from pictures.
#[derive(Clone, Debug)]
pub struct CorrectedReckoning {
    database: DirectionDatabase,
    /// The pose from which the pose graph's first step starts.
    first: Pose,
    steps: VecDeque<Step>,
    /// Pose at the latest picture by the pose graph, and the pose at the same picture by dead reckoning.
    latest: (Pose, Pose),
    /// Poses by dead reckoning at the times of the last second or so (`LATEST_S`), each with its time.
    way: VecDeque<(f64, Pose)>,
}

impl CorrectedReckoning {
    /// Corrected dead reckoning that starts at the pose `start`.
    pub fn new(start: Pose) -> Self {
        CorrectedReckoning {
            database: DirectionDatabase::default(),
            first: start,
            steps: VecDeque::new(),
            latest: (start, start),
            way: VecDeque::new(),
        }
    }

    /// Adds the current pose by dead reckoning.
    pub fn reckon(&mut self, time_s: f64, reckoned: Pose) {
        self.way.push_back((time_s, reckoned));
        while self.way.front().is_some_and(|(since_s, _)| *since_s < time_s - LATEST_S) {
            self.way.pop_front();
        }
    }

    /// Adds the direction of the walls relative to robot forward, seen in a picture that was taken at `measured_s`.
    pub fn see(&mut self, measured_s: f64, seen_rad: f64) {
        let before = self.way.iter().rev().find(|(time_s, _)| *time_s <= measured_s);
        let Some(&(_, reckoned)) = before.or(self.way.front()) else { return };
        let (graph, at) = self.latest;
        let step = Step::between(at, reckoned);
        let here = step.after(graph);
        let heading_rad = self.database.correct(seen_rad, here.heading_rad);
        self.steps.push_back(Step { heading_rad, ..step });
        let poses = optimised(self.first, self.steps.make_contiguous(), &WEIGHTS);
        if self.steps.len() > HELD
            && let Some(first) = poses.first()
        {
            self.first = *first;
            self.steps.pop_front();
        }
        self.latest = (poses.last().copied().unwrap_or(here), reckoned);
    }

    /// The current pose: that of the latest picture by the pose graph, carried on by dead reckoning.
    pub fn pose(&self) -> Pose {
        let (graph, at) = self.latest;
        self.way.back().map_or(graph, |(_, reckoned)| Step::between(at, *reckoned).after(graph))
    }
}

//! Paper 2's whole system as a point: dead reckoning, headings of vanishing points by way of the database, and the pose graph.

use std::collections::VecDeque;

use crate::Pose;

use super::{
    DirectionDatabase,
    pose_graph::{Step, Weights, optimised},
};

/// Pictures whose poses the graph holds; the paper keeps all of them and optimises at the end.
const HELD: usize = 20;
/// The paper states none: 1 % of half a metre, a quarter degree of gyroscope, and as much as its vanishing points are off at 0.1 lx.
const WEIGHTS: Weights = Weights { travel_m: 0.005, turn_rad: 0.005, heading_rad: 0.01 };
/// Pictures are no later than this.
const LATEST_S: f64 = 1.0;

/// Dead reckoning that headings correct.
#[derive(Clone, Debug)]
pub struct CorrectedReckoning {
    database: DirectionDatabase,
    /// The pose before the graph's first step.
    first: Pose,
    steps: VecDeque<Step>,
    /// Pose of the latest picture by the graph, and by dead reckoning.
    latest: (Pose, Pose),
    /// Dead reckoning of the last while, by time.
    way: VecDeque<(f64, Pose)>,
}

impl CorrectedReckoning {
    /// Starts at a pose.
    pub fn new(start: Pose) -> Self {
        CorrectedReckoning {
            database: DirectionDatabase::default(),
            first: start,
            steps: VecDeque::new(),
            latest: (start, start),
            way: VecDeque::new(),
        }
    }

    /// Takes in where dead reckoning is now.
    pub fn reckon(&mut self, time_s: f64, reckoned: Pose) {
        self.way.push_back((time_s, reckoned));
        while self.way.front().is_some_and(|(since_s, _)| *since_s < time_s - LATEST_S) {
            self.way.pop_front();
        }
    }

    /// Takes in the direction of the walls from robot forward, seen in a picture of `measured_s`.
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

    /// The pose now.
    pub fn pose(&self) -> Pose {
        let (graph, at) = self.latest;
        self.way.back().map_or(graph, |(_, reckoned)| Step::between(at, *reckoned).after(graph))
    }
}

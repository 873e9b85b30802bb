//! What became of the errands (drives to a goal), as the robot's driver saw it.

use crate::scene::Scene;

/// Log of what became of all errands of a run.
#[derive(Clone, Debug, Default)]
pub struct ErrandLog {
    /// Records of the errands, in the order in which they are done.
    pub errands: Vec<ErrandRecord>,
    /// Planned paths that the robot has followed on its errands, or parts of such paths.
    pub legs: Vec<Leg>,
    current: usize,
}

/// Record of a single errand.
#[derive(Clone, Debug)]
pub struct ErrandRecord {
    /// Name of the errand (a drive to a goal) in the scene; empty for a goal drawn at random.
    pub name: String,
    /// Goal of the errand, world frame.
    pub goal_m: [f64; 2],
    /// Distance from the errand's goal within which the middle of the estimated box must be for the goal to count as reached.
    pub tolerance_m: f64,
    /// How long the robot stands at the goal.
    pub pause_s: f64,
    /// Time at which the errand began; `None` if it has not begun.
    pub began_s: Option<f64>,
    /// Time at which the errand ended, before its pause; `None` if the run ended first.
    pub ended_s: Option<f64>,
    /// How the errand ended.
    pub outcome: Outcome,
    /// Distance from the goal to the middle of the estimated box when the robot last stood at the end of a planned path.
    pub estimated_distance_m: Option<f64>,
    /// Half the diagonal, in x and y, of the estimate's hull (the smallest box around all boxes of the estimate) when the robot last stood at the
    /// end of a planned path.
    pub box_reach_m: Option<f64>,
    /// Number of times that a path to the errand's goal was searched.
    pub plans: usize,
    /// Number of times that a path to the errand's goal was found and taken.
    pub ways: usize,
    /// Number of searches for a path to the goal during which obstacles that are not on the map were known.
    pub detours: usize,
    /// Total time of the errand that was spent waiting for something that blocked the path.
    pub waited_s: f64,
}

/// How an errand ended.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Outcome {
    /// The run ended before the errand did.
    #[default]
    Unfinished,
    /// The goal was reached: the middle of the estimated box was within the tolerance.
    Reached,
    /// The errand was given up, because what blocked the path did not go away.
    Blocked,
    /// No path leads to the goal.
    NoWay,
}

/// A planned path that the robot followed, or a part of one.
#[derive(Clone, Debug)]
pub struct Leg {
    /// Time at which the robot set out on the planned path.
    pub from_s: f64,
    /// Time at which the robot left the planned path; infinite while it still follows it.
    pub until_s: f64,
    /// Corners of the planned path, world frame.
    pub corners_m: Vec<[f64; 2]>,
}

impl Outcome {
    /// Name of an errand's outcome in all output files.
    pub fn name(self) -> &'static str {
        match self {
            Outcome::Unfinished => "unfinished",
            Outcome::Reached => "reached",
            Outcome::Blocked => "blocked",
            Outcome::NoWay => "no_way",
        }
    }
}

impl ErrandLog {
    /// A log of the errands (drives to a goal) that the scene states, followed by goals that a seed has drawn at random.
    pub(super) fn new(scene: &Scene, random_goals_m: &[[f64; 2]]) -> Self {
        let navigation = scene.navigation();
        let record = |name: &str, goal_m: [f64; 2], tolerance_m: Option<f64>, pause_s: f64| ErrandRecord {
            name: name.to_owned(),
            goal_m,
            tolerance_m: tolerance_m.unwrap_or(navigation.tolerance_m),
            pause_s,
            began_s: None,
            ended_s: None,
            outcome: Outcome::Unfinished,
            estimated_distance_m: None,
            box_reach_m: None,
            plans: 0,
            ways: 0,
            detours: 0,
            waited_s: 0.0,
        };
        let stated = scene
            .errands
            .iter()
            .map(|errand| record(&errand.name, [errand.x_m, errand.y_m], errand.tolerance_m, errand.pause_s));
        let drawn = random_goals_m.iter().map(|goal_m| record("", *goal_m, None, 0.0));
        let mut log = ErrandLog { errands: stated.chain(drawn).collect(), ..ErrandLog::default() };
        log.begin(0.0);
        log
    }

    pub(super) fn current(&self) -> Option<&ErrandRecord> {
        self.errands.get(self.current)
    }

    pub(super) fn current_mut(&mut self) -> Option<&mut ErrandRecord> {
        self.errands.get_mut(self.current)
    }

    pub(super) fn next(&mut self, time_s: f64) {
        self.current += 1;
        self.begin(time_s);
    }

    pub(super) fn add_plan(&mut self, is_detour: bool) {
        if let Some(errand) = self.current_mut() {
            errand.plans += 1;
            errand.detours += usize::from(is_detour);
        }
    }

    pub(super) fn wait(&mut self, for_s: f64) {
        if let Some(errand) = self.current_mut() {
            errand.waited_s += for_s;
        }
    }

    pub(super) fn begin_leg(&mut self, corners_m: Vec<[f64; 2]>, time_s: f64) {
        if let Some(errand) = self.current_mut() {
            errand.ways += 1;
        }
        self.legs.push(Leg { from_s: time_s, until_s: f64::INFINITY, corners_m });
    }

    pub(super) fn end_leg(&mut self, time_s: f64) {
        if let Some(leg) = self.legs.last_mut() {
            leg.until_s = leg.until_s.min(time_s);
        }
    }

    /// Whether the robot is following a planned path at present.
    pub(super) fn has_leg(&self) -> bool {
        self.legs.last().is_some_and(|leg| leg.until_s == f64::INFINITY)
    }

    fn begin(&mut self, time_s: f64) {
        if let Some(errand) = self.current_mut() {
            errand.began_s = Some(time_s);
        }
    }
}

//! What became of the errands, as their driver saw it.

use crate::scene::Scene;

/// What became of the errands of a run.
#[derive(Clone, Debug, Default)]
pub struct ErrandLog {
    /// In the order in which they are done.
    pub errands: Vec<ErrandRecord>,
    /// Ways that were followed.
    pub legs: Vec<Leg>,
    current: usize,
}

/// One errand.
#[derive(Clone, Debug)]
pub struct ErrandRecord {
    /// What the scene calls it.
    pub name: String,
    /// Where to, world.
    pub goal_m: [f64; 2],
    /// How near the middle of the estimate has to be.
    pub tolerance_m: f64,
    /// How long to stand there.
    pub pause_s: f64,
    /// When it began; none when it has not.
    pub began_s: Option<f64>,
    /// When it ended, before the pause; none when the run ended before it.
    pub ended_s: Option<f64>,
    /// How it ended.
    pub outcome: Outcome,
    /// Distance of the estimate's middle from the goal when the robot last stood at the end of a way.
    pub estimated_distance_m: Option<f64>,
    /// Half the diagonal of the hull then.
    pub box_reach_m: Option<f64>,
    /// How often a way was looked for.
    pub plans: usize,
    /// How often one was found.
    pub ways: usize,
    /// How many of those times something that the map does not show was known.
    pub detours: usize,
    /// How long something in the way was waited for.
    pub waited_s: f64,
}

/// How an errand ended.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Outcome {
    /// The run ended before it.
    #[default]
    Unfinished,
    /// The estimate was within the tolerance.
    Reached,
    /// What stood in the way did not go.
    Blocked,
    /// No way leads there.
    NoWay,
}

/// A way that was followed, or a part of it.
#[derive(Clone, Debug)]
pub struct Leg {
    /// From when.
    pub from_s: f64,
    /// Until when; infinite while it is followed.
    pub until_s: f64,
    /// Its corners, world.
    pub corners_m: Vec<[f64; 2]>,
}

impl Outcome {
    /// Its name in every file.
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
    /// The scene's errands, then goals that a seed has drawn.
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

    /// Whether a way is being followed.
    pub(super) fn has_leg(&self) -> bool {
        self.legs.last().is_some_and(|leg| leg.until_s == f64::INFINITY)
    }

    fn begin(&mut self, time_s: f64) {
        if let Some(errand) = self.current_mut() {
            errand.began_s = Some(time_s);
        }
    }
}

//! Draws a run's true errors within the tolerances that its scene declares, each quantity from a random stream of its own.

use localizer::Pose;
use rand::seq::IndexedRandom;

use crate::{
    base::DrawnBase,
    devices::DrawnDevices,
    navigation::Planner,
    randomness::{Repeated, draw_within, stream},
    scene::Scene,
};

use super::{Drawn, DrawnMarker, LaidTiles, walls::draw_walls};

impl Drawn {
    /// Draws everything that a seed decides before the run starts.
    pub fn draw(scene: &Scene, seed: u64) -> Drawn {
        let (robot, errors) = (&scene.robot, scene.robot.errors);
        Drawn {
            start: draw_start(scene, seed),
            base: DrawnBase::draw(robot, seed),
            devices: DrawnDevices::draw(robot, seed),
            tiles: scene.floor.tiles.as_ref().map(|tiles| LaidTiles::draw(tiles, &scene.room, errors, seed)),
            furniture_turn_deg: draw_furniture(scene, seed),
            walls_turn_deg: draw_walls(scene, seed),
            goals_m: draw_goals(scene, seed),
            markers: DrawnMarker::draw_all(scene, seed),
        }
    }
}

impl Scene {
    /// The scene with walls and furniture as they truly stand, for the physics and the cameras. The scene's keys, the map and the localizer
    /// keep the stated ones.
    pub fn as_built(&self, drawn: &Drawn) -> Scene {
        let mut built = self.clone();
        for (piece, turn_deg) in built.furniture.iter_mut().zip(&drawn.furniture_turn_deg) {
            piece.rotation_deg += turn_deg;
        }
        built.turn_walls(drawn.walls_turn_deg);
        built
    }
}

fn draw_furniture(scene: &Scene, seed: u64) -> Vec<f64> {
    let (tolerance_deg, errors) = (scene.building.furniture_tolerance_deg, scene.robot.errors);
    // With the distribution `Drift` all pieces of furniture are askew by the same angle, so that they agree with each other.
    let mut turn = Repeated::new(errors, stream(seed, "furniture"));
    scene.furniture.iter().map(|_| turn.one_way(tolerance_deg)).collect()
}

fn draw_start(scene: &Scene, seed: u64) -> Pose {
    let (nominal, start, errors) = (scene.nominal_start(), &scene.start, scene.robot.errors);
    let mut rng = stream(seed, "start");
    Pose {
        x_m: nominal.x_m + draw_within(start.tolerance_m, errors, &mut rng),
        y_m: nominal.y_m + draw_within(start.tolerance_m, errors, &mut rng),
        heading_rad: nominal.heading_rad + draw_within(start.tolerance_deg.to_radians(), errors, &mut rng),
    }
}

/// Least distance of a random goal from the goal before; with a smaller one there would be nothing to drive.
const LEAST_LEG_M: f64 = 1.0;

/// Draws the random goals of errands, each in the middle of a grid cell that the robot can reach.
fn draw_goals(scene: &Scene, seed: u64) -> Vec<[f64; 2]> {
    let n_goals = scene.navigation.as_ref().map_or(0, |navigation| navigation.random_goals);
    let mut from_m = scene.errands.last().map_or([scene.start.x_m, scene.start.y_m], |errand| [errand.x_m, errand.y_m]);
    if n_goals == 0 {
        return Vec::new();
    }
    let centres_m = Planner::of(scene).reach(from_m).map(|reach| reach.centres_m()).unwrap_or_default();
    let mut rng = stream(seed, "navigation.goals");
    let mut goals_m = Vec::new();
    for _ in 0..n_goals {
        let is_far = |at_m: &&[f64; 2]| (at_m[0] - from_m[0]).hypot(at_m[1] - from_m[1]) >= LEAST_LEG_M;
        let far_m: Vec<&[f64; 2]> = centres_m.iter().filter(is_far).collect();
        // In a room too small for the least distance between goals, any place that the robot can reach may be drawn.
        let Some(goal_m) = far_m.choose(&mut rng).copied().or_else(|| centres_m.choose(&mut rng)) else { break };
        goals_m.push(*goal_m);
        from_m = *goal_m;
    }
    goals_m
}

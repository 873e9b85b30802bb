//! Draws at random, within the declared tolerances, how building and floor truly are.

use crate::{
    scene::Scene,
    truth::randomness::{Repeated, draw_within, stream},
};

use super::{
    building::GroundPlan,
    drawn::{DrawnMarker, DrawnPlace, LaidTiles},
};

/// Step, in per cent of the drawn turn, by which the walls' turn is reduced until the turned walls leave room for the robot's body wherever the
/// scene puts the robot.
const STEP_PERCENT: i32 = 5;

impl DrawnPlace {
    /// Draws the errors of floor, walls, furniture and markers for a run, each quantity from a random stream of its own.
    pub fn draw(scene: &Scene, seed: u64) -> DrawnPlace {
        let errors = scene.robot.errors;
        DrawnPlace {
            tiles: scene
                .floor
                .tiles
                .as_ref()
                .map(|tiles| LaidTiles::draw(tiles, GroundPlan::of(scene).extents_m(), errors, seed)),
            furniture_turn_deg: draw_furniture(scene, seed),
            walls_turn_deg: draw_walls(scene, seed),
            markers: DrawnMarker::draw_all(scene, seed),
        }
    }
}

fn draw_furniture(scene: &Scene, seed: u64) -> Vec<f64> {
    let (tolerance_deg, errors) = (scene.building.furniture_tolerance_deg, scene.robot.errors);
    // With the distribution `Drift` all pieces of furniture are askew by the same angle, so that they agree with each other.
    let mut turn = Repeated::new(errors, stream(seed, "furniture"));
    let drawn_deg = scene.furniture.iter().map(|piece| (piece.wall, turn.one_way(tolerance_deg)));
    drawn_deg.map(|(is_wall, turn_deg)| if is_wall { 0.0 } else { turn_deg }).collect()
}

/// Draws at random one angle by which all walls are turned. The walls agree with each other, so that no image of them can distinguish this turn
/// from a turn of the robot.
fn draw_walls(scene: &Scene, seed: u64) -> f64 {
    let drawn_deg = draw_within(scene.walls_askew_deg(), scene.robot.errors, &mut stream(seed, "walls"));
    let lesser = (0..=100 / STEP_PERCENT).map(|step| drawn_deg * f64::from(100 - STEP_PERCENT * step) / 100.0);
    lesser.into_iter().find(|turn_deg| leaves_places(scene, *turn_deg)).unwrap_or(0.0)
}

/// Whether walls turned by `turn_deg` leave enough room for the robot's body at every position at which the scene puts the robot.
fn leaves_places(scene: &Scene, turn_deg: f64) -> bool {
    let mut turned = scene.clone();
    turned.turn_walls(turn_deg);
    let ground_plan = GroundPlan::of(&turned);
    // A true position is drawn at random within a square around the stated one.
    scene.places().into_iter().all(|(at_m, tolerance_m)| {
        ground_plan.wall_distance_from_square_m(at_m, tolerance_m) >= scene.robot.body_radius_m
    })
}

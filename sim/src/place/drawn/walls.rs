//! Walls as they truly stand: all turned by the same angle against the map.

use crate::{
    scene::{Furniture, Scene},
    truth::randomness::{draw_within, stream},
};

use super::DrawnPlace;
use crate::place::building::GroundPlan;

/// Step, in per cent of the drawn turn, by which the walls' turn is reduced until the turned walls leave room for the robot's body wherever the
/// scene puts the robot.
const STEP_PERCENT: i32 = 5;

/// Angle against every wall beyond which a piece of furniture counts as placed across the walls on purpose. Its edges are then outliers, which
/// are covered by the number of false readings that the localizer allows for in an image (the quota). Furniture that people place along a wall
/// ends up askew by 1 to 3°.
const ON_PURPOSE_DEG: f64 = 5.0;

/// Draws at random one angle by which all walls are turned. The walls agree with each other, so that no image of them can distinguish this turn
/// from a turn of the robot.
pub(super) fn draw_walls(scene: &Scene, seed: u64) -> f64 {
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

/// A direction along which level edges in the building run, measured from world x.
pub(crate) struct LevelEdges {
    /// The direction of a wall, or at right angles to it.
    pub(crate) direction_deg: f64,
    /// Least and greatest direction of an edge of furniture that stands along the wall.
    pub(crate) within_deg: [f64; 2],
}

impl Scene {
    /// Directions of the walls as they truly stand, measured from world x, modulo 90°: those of the robot's room, then those of each
    /// further room.
    pub fn true_wall_directions_deg(&self, drawn: &DrawnPlace) -> Vec<f64> {
        self.stated_wall_directions_deg().into_iter().map(|stated_deg| stated_deg + drawn.walls_turn_deg).collect()
    }

    /// The directions along which level edges in the building may truly run: along walls and at right angles to them, up to the angle by which
    /// furniture may stand askew. Directions of walls are the true ones; those of furniture and of what is laid on the floor are as the scene states
    /// them.
    pub(crate) fn level_edges(&self, drawn: &DrawnPlace) -> Vec<LevelEdges> {
        let askew_deg = self.localizer.wall_directions().askew_deg;
        let stands_deg = self.true_wall_directions_deg(drawn).into_iter().chain(self.stated_wall_directions_deg());
        let edges = |direction_deg: f64| LevelEdges {
            direction_deg,
            within_deg: [direction_deg - askew_deg, direction_deg + askew_deg],
        };
        stands_deg.flat_map(|along_deg| [along_deg, along_deg + 90.0]).map(edges).collect()
    }

    /// Angle of each piece of furniture, as it truly stands, to the nearest wall direction, stated or true, modulo quarter turns. It is
    /// zero for furniture that stands across the walls on purpose.
    pub(crate) fn furniture_askew_deg(&self, drawn: &DrawnPlace) -> Vec<f64> {
        let stated_deg = self.stated_wall_directions_deg();
        let stands_deg = [self.true_wall_directions_deg(drawn), stated_deg.clone()].concat();
        let askew_deg = |(piece, turn_deg): (&Furniture, &f64)| {
            let off_deg = |deg: f64, walls_deg: &[f64]| turn_from_nearest_deg(deg, walls_deg).unwrap_or(0.0);
            let is_on_purpose = off_deg(piece.rotation_deg, &stated_deg).abs() > ON_PURPOSE_DEG;
            if is_on_purpose { 0.0 } else { off_deg(piece.rotation_deg + turn_deg, &stands_deg) }
        };
        self.furniture.iter().zip(&drawn.furniture_turn_deg).map(askew_deg).collect()
    }
}

/// Signed angle from the nearest of several directions to a given direction, modulo quarter turns, from −45 to 45 degrees; `None` if `others_deg`
/// is empty.
pub(crate) fn turn_from_nearest_deg(direction_deg: f64, others_deg: &[f64]) -> Option<f64> {
    let turns_deg = others_deg.iter().map(|other_deg| (direction_deg - other_deg + 45.0).rem_euclid(90.0) - 45.0);
    turns_deg.min_by(|a, b| a.abs().total_cmp(&b.abs()))
}

//! Walls as they truly stand: all turned alike against the map.

use crate::{randomness::stream, scene::Scene};

use super::{Drawn, draw_within};

/// Where walls turned as drawn would leave the robot no place, they are turned by so many hundredths less, and so on.
const STEP_PERCENT: i32 = 5;

/// One turn for all walls: they agree with each other, so that no image of them tells it from a turn of the robot.
pub(super) fn draw_walls(scene: &Scene, seed: u64) -> f64 {
    let drawn_deg = draw_within(scene.walls_askew_deg(), scene.robot.errors, &mut stream(seed, "walls"));
    let lesser = (0..=100 / STEP_PERCENT).map(|step| drawn_deg * f64::from(100 - STEP_PERCENT * step) / 100.0);
    let leaves_places = |turn_deg: &f64| scene.leaves_places(turn_deg.to_radians());
    lesser.into_iter().find(leaves_places).unwrap_or(0.0)
}

impl Scene {
    /// Directions of the walls from world x as they truly stand, modulo 90: the room's, then each further room's.
    pub fn true_wall_directions_deg(&self, drawn: &Drawn) -> Vec<f64> {
        self.stated_wall_directions_deg().into_iter().map(|stated_deg| stated_deg + drawn.walls_turn_deg).collect()
    }
}

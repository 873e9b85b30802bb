//! Walls as they truly stand: all turned alike against the map.

use crate::{
    randomness::{draw_within, stream},
    scene::{Furniture, Scene},
};

use super::Drawn;

/// Where walls turned as drawn would leave the robot no place, they are turned by so many hundredths less, and so on.
const STEP_PERCENT: i32 = 5;

/// A piece of furniture that a scene turns by more than this against every wall stands across them on purpose: its edges are strays, which quotas
/// count. Whoever puts furniture along a wall leaves it askew by 1 to 3°.
const ON_PURPOSE_DEG: f64 = 5.0;

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

    /// How far each piece of furniture, as it truly stands, is turned against the nearest direction of a wall, as stated or as it truly is, modulo
    /// quarter turns. Zero for what stands across the walls on purpose.
    pub(crate) fn furniture_askew_deg(&self, drawn: &Drawn) -> Vec<f64> {
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

/// The turn to a direction from the nearest of some, modulo quarter turns: from -45 to 45 degrees. None if there are none.
pub(crate) fn turn_from_nearest_deg(direction_deg: f64, others_deg: &[f64]) -> Option<f64> {
    let turns_deg = others_deg.iter().map(|other_deg| (direction_deg - other_deg + 45.0).rem_euclid(90.0) - 45.0);
    turns_deg.min_by(|a, b| a.abs().total_cmp(&b.abs()))
}

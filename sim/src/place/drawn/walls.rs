//! Walls as they truly stand: all turned by the same angle against the map.

use crate::scene::{Furniture, Scene};

use super::DrawnPlace;

/// Angle against every wall beyond which a piece of furniture counts as placed across the walls on purpose. Its edges are then outliers, which
/// are covered by the number of false readings that the localizer allows for in an image (the quota). Furniture that people place along a wall
/// ends up askew by 1 to 3°.
const ON_PURPOSE_DEG: f64 = 5.0;

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
            let turn_deg = if piece.wall { drawn.walls_turn_deg } else { *turn_deg };
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

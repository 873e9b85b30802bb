//! The building and its floor as they truly are: errors of floor, walls, furniture and markers that a seed draws at random within their declared
//! tolerances. The localizer never sees them.

use localizer::bounds::{self, Assumption};

use crate::scene::Scene;

mod clip;
pub mod markers;
pub mod tiles;
mod walls;

pub use markers::{DrawnDot, DrawnMarker};
pub use tiles::LaidTiles;
pub(crate) use walls::turn_from_nearest_deg;

/// Declared bounds on floor, markers, furniture and walls that the true values may exceed, because they may be drawn or placed outside. A run can
/// be repeated with the values moved back to the bound.
pub(crate) const CLIPPED: [Assumption; 8] = [
    bounds::FLOOR_TILES_LAYING,
    bounds::FLOOR_TILES_STRAIGHTNESS,
    bounds::MARKERS_PLACEMENT,
    bounds::MARKERS_ROTATION,
    bounds::MARKERS_PRINT,
    bounds::MARKERS_HEIGHT,
    bounds::WALL_DIRECTIONS_DIRECTION,
    bounds::WALL_DIRECTIONS_ASKEW,
];

/// Everything about building and floor that is drawn at random once, before a run starts.
#[derive(Clone, Debug)]
pub struct DrawnPlace {
    /// The floor's tiles as they were truly laid; `None` if the floor has none.
    pub tiles: Option<LaidTiles>,
    /// Angle by which each piece of furniture is turned away from where the scene states it.
    pub furniture_turn_deg: Vec<f64>,
    /// Angle by which all walls and the things that hang on them are turned about the middle of the robot's room, away from where the scene
    /// states them.
    pub walls_turn_deg: f64,
    /// Markers on the ceiling as they were truly printed and pasted.
    pub markers: Vec<DrawnMarker>,
}

impl Scene {
    /// A copy of the scene with walls and furniture as they truly stand, for the physics and the cameras. The scene itself, the map and the
    /// localizer keep the stated positions.
    pub fn as_built(&self, drawn: &DrawnPlace) -> Scene {
        let mut built = self.clone();
        for (piece, turn_deg) in built.furniture.iter_mut().zip(&drawn.furniture_turn_deg) {
            piece.rotation_deg += turn_deg;
        }
        built.turn_walls(drawn.walls_turn_deg);
        built
    }
}

//! The map by which errands are planned.

use crate::scene::{Cell, OccupancyGrid, Scene};

/// Edge of a cell (paper 5, section IV-C).
const RESOLUTION_M: f64 = 0.05;

impl OccupancyGrid {
    /// The map by which a scene's errands are planned: the file that it names, or else what stands in it.
    pub fn of(scene: &Scene) -> OccupancyGrid {
        let surveyed = scene.navigation.as_ref().and_then(|navigation| navigation.surveyed.clone());
        surveyed.unwrap_or_else(|| OccupancyGrid::from_scene(scene))
    }

    /// The room of a scene with a border of wall, and its mapped furniture. A cell is occupied when something reaches into
    /// the circle about it, so that nothing is mapped smaller than it is.
    ///
    /// Rooms of `[building]` are left out: the robot's own room has no way into them.
    pub fn from_scene(scene: &Scene) -> OccupancyGrid {
        let room_m = [scene.room.width_m, scene.room.depth_m];
        let mut grid = OccupancyGrid {
            resolution_m: RESOLUTION_M,
            origin_m: [-RESOLUTION_M; 2],
            size: room_m.map(|extent_m| (extent_m / RESOLUTION_M - 1e-9).ceil() as usize + 2),
            cells: Vec::new(),
        };
        let reach_m = RESOLUTION_M * std::f64::consts::FRAC_1_SQRT_2;
        for row in 0..grid.size[1] {
            for column in 0..grid.size[0] {
                let centre_m = grid.centre_m([column, row]);
                let in_wall = (0..2).any(|axis| {
                    // Sums of twentieths are not exact.
                    centre_m[axis] < 0.0 || centre_m[axis] + 0.5 * RESOLUTION_M > room_m[axis] + 1e-9
                });
                let in_furniture =
                    scene.furniture.iter().any(|piece| piece.is_mapped() && piece.distance_m(centre_m) < reach_m);
                grid.cells.push(if in_wall || in_furniture { Cell::Occupied } else { Cell::Free });
            }
        }
        grid
    }
}

//! The occupancy grid on which paths for the robot's errands (drives to a goal) are planned.

use crate::{
    place::building::GroundPlan,
    scene::{Cell, OccupancyGrid, Scene},
};

/// Edge length of a grid cell (paper 5, section IV-C).
const RESOLUTION_M: f64 = 0.05;

impl OccupancyGrid {
    /// Returns the grid on which paths for a scene's errands (drives to a goal) are planned: the map file that the scene names, or else a grid of
    /// what the scene's room contains.
    pub fn of(scene: &Scene) -> OccupancyGrid {
        let surveyed = scene.navigation.as_ref().and_then(|navigation| navigation.surveyed.clone());
        surveyed.unwrap_or_else(|| OccupancyGrid::from_scene(scene))
    }

    /// Creates a grid of a scene's rooms, with a border of wall, and of its mapped furniture. A cell is occupied when a part of it lies outside of
    /// all rooms and open doors, when a wall along one of its sides parts it from a cell of another room, or when a piece of furniture reaches into
    /// the circle through the cell's corners, so that nothing is mapped smaller than it is.
    pub fn from_scene(scene: &Scene) -> OccupancyGrid {
        let ground_plan = GroundPlan::of(scene);
        let [low_m, high_m] = ground_plan.extents_m();
        // Multiples of the 5 cm cell edge are not exact in floating point, so that the comparison has a margin of 1e-9 cells.
        let first = low_m.map(|at_m| (at_m / RESOLUTION_M + 1e-9).floor());
        let mut grid = OccupancyGrid {
            resolution_m: RESOLUTION_M,
            origin_m: first.map(|cells| (cells - 1.0) * RESOLUTION_M),
            size: [0, 1].map(|axis| ((high_m[axis] / RESOLUTION_M - 1e-9).ceil() - first[axis]) as usize + 2),
            cells: Vec::new(),
        };
        let reach_m = RESOLUTION_M * std::f64::consts::FRAC_1_SQRT_2;
        for row in 0..grid.size[1] {
            for column in 0..grid.size[0] {
                let centre_m = grid.centre_m([column, row]);
                let in_wall = !ground_plan.leaves_square_free(centre_m, 0.5 * RESOLUTION_M);
                let in_furniture =
                    scene.furniture.iter().any(|piece| piece.is_mapped() && piece.distance_m(centre_m) < reach_m);
                grid.cells.push(if in_wall || in_furniture { Cell::Occupied } else { Cell::Free });
            }
        }
        grid
    }
}

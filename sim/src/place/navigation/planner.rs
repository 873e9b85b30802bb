//! The shortest path of a round robot through an occupancy grid: A* over cells, then a polyline with few corners.

use pathfinding::prelude::{astar, bfs_reach, dijkstra_reach};

use crate::scene::Scene;

use super::OccupancyGrid;

/// Cost of a step to a neighbouring cell along a row or a column, in ten-thousandths of a cell. Costs are whole numbers, as these add up
/// to the same sum in any order.
const STRAIGHT: u32 = 10_000;
/// Cost of a diagonal step: √2 times [`STRAIGHT`], rounded up. The heuristic of A* uses the same rounded cost, so that it never
/// overestimates the cost of the path that remains.
const ACROSS: u32 = 14_143;

/// Length that a corner adds to a path: nothing against a real length, but enough to prefer the path with fewer corners among equally long ones.
const CORNER_M: f64 = 1e-6;

/// Greatest distance to a free cell at which a path may begin when the robot itself stands too near to an obstacle.
pub(super) const GET_AWAY_M: f64 = 0.3;

/// Planner of paths on a grid, for a robot of a given radius.
#[derive(Clone, Debug)]
pub struct Planner {
    grid: OccupancyGrid,
    keep_away_m: f64,
    /// For each cell, whether the robot's centre may be there.
    open: Vec<bool>,
}

/// The set of cells that a robot can reach from one position.
#[derive(Clone, Debug)]
pub struct Reach {
    grid: OccupancyGrid,
    is_reached: Vec<bool>,
}

impl Planner {
    /// Creates the planner for the robot of a scene, on the scene's map and with the scene's safety margin.
    pub fn of(scene: &Scene) -> Planner {
        Planner::new(OccupancyGrid::of(scene), scene.robot.body_radius_m + scene.navigation().margin_m)
    }

    /// Creates a planner that keeps the robot's centre `keep_away_m` away from every cell that is not free.
    pub fn new(grid: OccupancyGrid, keep_away_m: f64) -> Planner {
        let cells = (0..grid.size[1]).flat_map(|row| (0..grid.size[0]).map(move |column| [column, row]));
        let open = cells.map(|cell| !grid.is_crowded(grid.centre_m(cell), keep_away_m)).collect();
        Planner { grid, keep_away_m, open }
    }

    /// Returns the grid that the planner works on.
    pub fn grid(&self) -> &OccupancyGrid {
        &self.grid
    }

    /// Returns the corners of the path from one place to another, both places included, or `None` when there is no path.
    ///
    /// A* (Hart, Nilsson and Raphael 1968) with the octile distance finds the cells; the result is the shortest polyline through the
    /// turns of their path that passes only cells where the robot's centre may be.
    pub fn plan(&self, from_m: [f64; 2], to_m: [f64; 2]) -> Option<Vec<[f64; 2]>> {
        let start = self.nearest_open(from_m)?;
        let goal = self.grid.cell_at(to_m).filter(|&cell| self.is_open(cell))?;
        let (cells, _) =
            astar(&start, |&cell| self.neighbours(cell), |&cell| octile(cell, goal), |&cell| cell == goal)?;
        let mut places_m: Vec<[f64; 2]> = cells.iter().map(|&cell| self.grid.centre_m(cell)).collect();
        let is_start_open = self.grid.cell_at(from_m) == Some(start);
        if is_start_open {
            places_m[0] = from_m;
        } else {
            places_m.insert(0, from_m);
        }
        let last = places_m.len() - 1;
        places_m[last] = to_m;
        if last == 0 {
            return Some(vec![from_m, to_m]);
        }
        Some(self.straighten(&places_m))
    }

    /// Returns the cells that can be reached from a position, or `None` when the position itself is too near to an obstacle.
    pub fn reach(&self, from_m: [f64; 2]) -> Option<Reach> {
        self.grid.cell_at(from_m).filter(|&cell| self.is_open(cell)).map(|start| self.reach_of(start))
    }

    /// Returns the cells that can be reached from the free cell nearest to a position, or `None` when no free cell is near it.
    pub fn reach_near(&self, from_m: [f64; 2]) -> Option<Reach> {
        self.nearest_open(from_m).map(|start| self.reach_of(start))
    }

    /// For each cell, the length of the shortest path over cells from it to a place, infinite where there is none; `None` when the place itself is
    /// too near to an obstacle.
    pub(super) fn lengths_to(&self, to_m: [f64; 2]) -> Option<Vec<f64>> {
        let goal = self.grid.cell_at(to_m).filter(|&cell| self.is_open(cell))?;
        let mut lengths_m = vec![f64::INFINITY; self.open.len()];
        for reached in dijkstra_reach(&goal, |&cell| self.neighbours(cell)) {
            lengths_m[self.index(reached.node)] =
                f64::from(reached.total_cost) / f64::from(STRAIGHT) * self.grid.resolution_m;
        }
        Some(lengths_m)
    }

    /// Distance that a place has from every obstacle, rounded down, where it is less than the planner keeps; `None` where it is not.
    pub(super) fn kept_m(&self, place_m: [f64; 2]) -> Option<f64> {
        let steps = (0..20).rev().map(|step| self.keep_away_m * f64::from(step) / 20.0);
        let mut kept_m = steps.skip_while(|distance_m| self.grid.is_crowded(place_m, *distance_m));
        (!self.is_open_at(place_m)).then(|| kept_m.next().unwrap_or(0.0))
    }

    /// Whether the robot's centre may be at a place.
    pub(super) fn is_open_at(&self, place_m: [f64; 2]) -> bool {
        self.index_at(place_m).is_some_and(|index| self.open[index])
    }

    /// Index of the cell at a place, `None` beyond the map.
    pub(super) fn index_at(&self, place_m: [f64; 2]) -> Option<usize> {
        self.grid.cell_at(place_m).map(|cell| self.index(cell))
    }

    /// Index of a cell, row by row.
    pub(super) fn index(&self, [column, row]: [usize; 2]) -> usize {
        row * self.grid.size[0] + column
    }

    fn reach_of(&self, start: [usize; 2]) -> Reach {
        let mut is_reached = vec![false; self.open.len()];
        for [column, row] in bfs_reach(start, |&cell| self.neighbours(cell).into_iter().map(|(next, _)| next)) {
            is_reached[row * self.grid.size[0] + column] = true;
        }
        Reach { grid: self.grid.clone(), is_reached }
    }

    fn is_open(&self, [column, row]: [usize; 2]) -> bool {
        column < self.grid.size[0] && row < self.grid.size[1] && self.open[row * self.grid.size[0] + column]
    }

    /// The cell nearest to a place in which the robot's centre may be; `None` if there is none close by.
    pub(super) fn nearest_open(&self, place_m: [f64; 2]) -> Option<[usize; 2]> {
        let middle = self.grid.cell_at(place_m)?;
        if self.is_open(middle) {
            return Some(middle);
        }
        let reach = (GET_AWAY_M / self.grid.resolution_m).ceil() as usize;
        let rows = middle[1].saturating_sub(reach)..=middle[1] + reach;
        let cells =
            rows.flat_map(|row| (middle[0].saturating_sub(reach)..=middle[0] + reach).map(move |column| [column, row]));
        let distance_m = |cell: [usize; 2]| {
            let centre_m = self.grid.centre_m(cell);
            (centre_m[0] - place_m[0]).hypot(centre_m[1] - place_m[1])
        };
        cells
            .filter(|&cell| self.is_open(cell) && distance_m(cell) <= GET_AWAY_M)
            .min_by(|&one, &other| distance_m(one).total_cmp(&distance_m(other)))
    }

    /// Returns the steps to the eight neighbours of a cell, with their costs. A diagonal step is possible only when both cells beside it
    /// are open too.
    fn neighbours(&self, [column, row]: [usize; 2]) -> Vec<([usize; 2], u32)> {
        let mut steps = Vec::with_capacity(8);
        for (right, up) in [(-1, -1), (0, -1), (1, -1), (-1, 0), (1, 0), (-1, 1), (0, 1), (1, 1)] {
            let (Some(x), Some(y)) = (column.checked_add_signed(right), row.checked_add_signed(up)) else { continue };
            let is_across = right != 0 && up != 0;
            let is_free = self.is_open([x, y]) && (!is_across || (self.is_open([column, y]) && self.is_open([x, row])));
            if is_free {
                steps.push(([x, y], if is_across { ACROSS } else { STRAIGHT }));
            }
        }
        steps
    }

    /// Returns the shortest polyline through some of the turns of a path over cells; of equally short ones, the one with the fewest corners.
    fn straighten(&self, places_m: &[[f64; 2]]) -> Vec<[f64; 2]> {
        let turns_m = turns(places_m);
        // For each turn of the path: the length of the shortest polyline to it, and the index of the turn before it on that polyline.
        let mut best = vec![(0.0_f64, 0_usize)];
        for to in 1..turns_m.len() {
            let through = (0..to).rev().filter(|&from| from + 1 == to || self.sees(turns_m[from], turns_m[to]));
            let lines = through.map(|from| (best[from].0 + length_m(&[turns_m[from], turns_m[to]]) + CORNER_M, from));
            best.push(lines.min_by(|one, other| one.0.total_cmp(&other.0)).unwrap_or((f64::INFINITY, to - 1)));
        }
        let mut corners_m = Vec::new();
        let mut here = turns_m.len() - 1;
        while here > 0 {
            corners_m.push(turns_m[here]);
            here = best[here].1;
        }
        corners_m.push(turns_m[0]);
        corners_m.reverse();
        corners_m
    }

    /// Whether a straight line passes only cells where the robot's centre may be. The line is sampled ten times a cell, and a twentieth
    /// of a cell is kept clear around each sample for what lies between two samples.
    fn sees(&self, from_m: [f64; 2], to_m: [f64; 2]) -> bool {
        let resolution_m = self.grid.resolution_m;
        let n_looks = (length_m(&[from_m, to_m]) / (0.1 * resolution_m)).ceil().max(1.0) as usize;
        (0..=n_looks).all(|look| {
            let share = look as f64 / n_looks as f64;
            let at_m = [0, 1].map(|axis| from_m[axis] + share * (to_m[axis] - from_m[axis]));
            let spare_m = 0.05 * resolution_m;
            [[-1.0, -1.0], [1.0, -1.0], [-1.0, 1.0], [1.0, 1.0]].into_iter().all(|[right, up]| {
                let place_m = [at_m[0] + right * spare_m, at_m[1] + up * spare_m];
                self.grid.cell_at(place_m).is_some_and(|cell| self.is_open(cell))
            })
        })
    }
}

/// Returns the two ends of a path over cells and the places at which the path turns.
fn turns(places_m: &[[f64; 2]]) -> Vec<[f64; 2]> {
    let is_turn = |three: &[[f64; 2]]| {
        let cross = (three[1][0] - three[0][0]) * (three[2][1] - three[1][1])
            - (three[1][1] - three[0][1]) * (three[2][0] - three[1][0]);
        cross.abs() > 1e-9
    };
    let inner = places_m.windows(3).filter(|three| is_turn(three)).map(|three| three[1]);
    let (first, last) = (places_m.first().copied(), places_m.last().copied());
    first.into_iter().chain(inner).chain(last).collect()
}

impl Reach {
    /// Whether a position in the world lies in a cell that can be reached.
    pub fn contains(&self, place_m: [f64; 2]) -> bool {
        self.grid.cell_at(place_m).is_some_and(|[column, row]| self.is_reached[row * self.grid.size[0] + column])
    }

    /// Returns the number of cells that can be reached.
    pub fn n_cells(&self) -> usize {
        self.is_reached.iter().filter(|is_reached| **is_reached).count()
    }

    /// Returns the centres of the cells that can be reached, row by row.
    pub fn centres_m(&self) -> Vec<[f64; 2]> {
        let cells = (0..self.grid.size[1]).flat_map(|row| (0..self.grid.size[0]).map(move |column| [column, row]));
        cells
            .zip(&self.is_reached)
            .filter(|(_, is_reached)| **is_reached)
            .map(|(cell, _)| self.grid.centre_m(cell))
            .collect()
    }
}

/// Returns the length of the polyline through the given points.
pub fn length_m(places_m: &[[f64; 2]]) -> f64 {
    places_m.windows(2).map(|pair| (pair[1][0] - pair[0][0]).hypot(pair[1][1] - pair[0][1])).sum()
}

fn octile(from: [usize; 2], to: [usize; 2]) -> u32 {
    let (x, y) = (from[0].abs_diff(to[0]) as u32, from[1].abs_diff(to[1]) as u32);
    STRAIGHT * (x.max(y) - x.min(y)) + ACROSS * x.min(y)
}

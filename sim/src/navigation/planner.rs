//! The shortest way of a round robot through a grid: A* over cells, then a line with few corners.

use pathfinding::prelude::{astar, bfs_reach};

use crate::scene::Scene;

use super::OccupancyGrid;

/// Cost of a step to the side and of one across, in ten-thousandths of a cell: whole numbers add up the same in any order.
const STRAIGHT: u32 = 10_000;
/// √2 of it, rounded up so that the estimate of the way left, rounded like it, is never too long.
const ACROSS: u32 = 14_143;

/// What a corner counts for: nothing against a length, but enough to tell equal ones apart.
const CORNER_M: f64 = 1e-6;

/// From a place that is too near to something the robot may get away to a free cell this near.
const GET_AWAY_M: f64 = 0.3;

/// Ways on a grid for a robot of some radius.
#[derive(Clone, Debug)]
pub struct Planner {
    grid: OccupancyGrid,
    /// For each cell whether the robot's middle may be there.
    open: Vec<bool>,
}

/// The cells that can be got to from a place.
#[derive(Clone, Debug)]
pub struct Reach {
    grid: OccupancyGrid,
    is_reached: Vec<bool>,
}

impl Planner {
    /// Ways for the robot of a scene on its map, with its margin.
    pub fn of(scene: &Scene) -> Planner {
        Planner::new(OccupancyGrid::of(scene), scene.robot.body_radius_m + scene.navigation().margin_m)
    }

    /// Keeps the robot's middle `keep_away_m` from everything that is not free.
    pub fn new(grid: OccupancyGrid, keep_away_m: f64) -> Planner {
        let cells = (0..grid.size[1]).flat_map(|row| (0..grid.size[0]).map(move |column| [column, row]));
        let open = cells.map(|cell| !grid.is_crowded(grid.centre_m(cell), keep_away_m)).collect();
        Planner { grid, open }
    }

    /// The grid that it plans on.
    pub fn grid(&self) -> &OccupancyGrid {
        &self.grid
    }

    /// Corners of the way from a place to another, both included, or `None` when there is none.
    ///
    /// A* (Hart, Nilsson and Raphael 1968) with the octile distance, then the shortest line through its turns that passes open cells
    /// only.
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

    /// Where one can get to from a place, or `None` when that place itself is too near to something.
    pub fn reach(&self, from_m: [f64; 2]) -> Option<Reach> {
        self.grid.cell_at(from_m).filter(|&cell| self.is_open(cell)).map(|start| self.reach_of(start))
    }

    /// The same from the nearest place that is not too near to anything.
    pub fn reach_near(&self, from_m: [f64; 2]) -> Option<Reach> {
        self.nearest_open(from_m).map(|start| self.reach_of(start))
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

    fn nearest_open(&self, place_m: [f64; 2]) -> Option<[usize; 2]> {
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

    /// Steps to the eight cells around; across a corner only when both cells beside it are open.
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

    /// The shortest line from turn to turn of a way over cells, of equally short ones that with the fewest corners.
    fn straighten(&self, places_m: &[[f64; 2]]) -> Vec<[f64; 2]> {
        let turns_m = turns(places_m);
        // By turn, the length of the shortest line to it and the turn before it.
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

    /// Whether a straight line passes open cells only, with a twentieth of a cell to spare for what lies between two looks.
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

/// The ends of a way over cells, and the places at which it turns.
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
    /// Whether a world place lies in a cell that can be got to.
    pub fn contains(&self, place_m: [f64; 2]) -> bool {
        self.grid.cell_at(place_m).is_some_and(|[column, row]| self.is_reached[row * self.grid.size[0] + column])
    }

    /// How many cells can be got to.
    pub fn n_cells(&self) -> usize {
        self.is_reached.iter().filter(|is_reached| **is_reached).count()
    }

    /// Centres of the cells that can be got to, row by row.
    pub fn centres_m(&self) -> Vec<[f64; 2]> {
        let cells = (0..self.grid.size[1]).flat_map(|row| (0..self.grid.size[0]).map(move |column| [column, row]));
        cells
            .zip(&self.is_reached)
            .filter(|(_, is_reached)| **is_reached)
            .map(|(cell, _)| self.grid.centre_m(cell))
            .collect()
    }
}

/// Length of a line through places.
pub fn length_m(places_m: &[[f64; 2]]) -> f64 {
    places_m.windows(2).map(|pair| (pair[1][0] - pair[0][0]).hypot(pair[1][1] - pair[0][1])).sum()
}

fn octile(from: [usize; 2], to: [usize; 2]) -> u32 {
    let (x, y) = (from[0].abs_diff(to[0]) as u32, from[1].abs_diff(to[1]) as u32);
    STRAIGHT * (x.max(y) - x.min(y)) + ACROSS * x.min(y)
}

//! A map of the floor in square cells, each free, occupied or unknown: the contents of the map file that a scene names.

/// State of a cell of the map.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Cell {
    /// Nothing stands in the cell.
    Free,
    /// Something stands in the cell, or in a part of it.
    Occupied,
    /// Nobody has surveyed the cell.
    Unknown,
}

/// A map of square cells along the world's axes.
#[derive(Clone, Debug, PartialEq)]
pub struct OccupancyGrid {
    /// Length of a cell's edges.
    pub resolution_m: f64,
    /// World x and y of the first cell's corner with the least x and y.
    pub origin_m: [f64; 2],
    /// Number of columns along world x and of rows along world y.
    pub size: [usize; 2],
    /// Cells row by row from the least y, and within a row from the least x.
    pub cells: Vec<Cell>,
}

impl OccupancyGrid {
    /// State of the cell at a column and a row; `Cell::Unknown` beyond the map.
    pub fn at(&self, [column, row]: [usize; 2]) -> Cell {
        if column >= self.size[0] || row >= self.size[1] {
            return Cell::Unknown;
        }
        self.cells[row * self.size[0] + column]
    }

    /// Column and row of the cell in which a position in the world lies, or `None` beyond the map.
    pub fn cell_at(&self, place_m: [f64; 2]) -> Option<[usize; 2]> {
        let index = [0, 1].map(|axis| ((place_m[axis] - self.origin_m[axis]) / self.resolution_m).floor());
        let is_inside = (0..2).all(|axis| index[axis] >= 0.0 && index[axis] < self.size[axis] as f64);
        is_inside.then(|| index.map(|index| index as usize))
    }

    /// World x and y of the centre of a cell.
    pub fn centre_m(&self, cell: [usize; 2]) -> [f64; 2] {
        [0, 1].map(|axis| self.origin_m[axis] + (cell[axis] as f64 + 0.5) * self.resolution_m)
    }

    /// Marks the cell in which a position in the world lies as occupied. A position beyond the map changes nothing.
    pub fn occupy(&mut self, place_m: [f64; 2]) {
        if let Some([column, row]) = self.cell_at(place_m) {
            self.cells[row * self.size[0] + column] = Cell::Occupied;
        }
    }

    /// Whether any cell that is not free lies within `within_m` of a position in the world, measured to the cells' edges. True for a position beyond
    /// the map.
    pub fn is_crowded(&self, place_m: [f64; 2], within_m: f64) -> bool {
        let reach = (within_m / self.resolution_m).ceil() as i64 + 1;
        let Some(middle) = self.cell_at(place_m) else { return true };
        let half_m = 0.5 * self.resolution_m;
        for row in middle[1] as i64 - reach..=middle[1] as i64 + reach {
            for column in middle[0] as i64 - reach..=middle[0] as i64 + reach {
                let (Ok(cell_x), Ok(cell_y)) = (usize::try_from(column), usize::try_from(row)) else { continue };
                let is_inside = cell_x < self.size[0] && cell_y < self.size[1];
                if !is_inside || self.at([cell_x, cell_y]) == Cell::Free {
                    continue;
                }
                let centre_m = self.centre_m([cell_x, cell_y]);
                let beyond = |axis: usize| ((place_m[axis] - centre_m[axis]).abs() - half_m).max(0.0);
                if beyond(0).hypot(beyond(1)) < within_m {
                    return true;
                }
            }
        }
        false
    }
}

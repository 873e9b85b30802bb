//! Raw positions on a grid of nodes, biquadratic in between: the motion of a rolling shutter's rows is another one in each image, and to work out
//! every pixel's raw position anew would take most of the time that vision has.

/// Distances between nodes that are tried, in pixels, the widest first. A cell is twice as wide.
const STEPS_PX: [u32; 3] = [8, 4, 2];
/// Greatest error of a position between nodes: the step to which positions in the raw image are rounded.
const TOLERANCE_PX: f64 = 1.0 / 256.0;
/// Number of cells along each side of the image in which the error is measured, at the places where that of a quadratic is greatest.
const PROBES: u32 = 9;
/// Places in a cell, as shares of its width, at which the error is measured: the error of a quadratic through the middle and both ends is greatest at
/// (1 ± 1/√3)/2.
const PROBED: [f64; 2] = [0.211, 0.789];
/// Number of parts of a pixel in which a position is stated: 2³².
const PARTS: f64 = (1_u64 << 32) as f64;

/// What a pixel of the straightened image is taken from.
#[derive(Clone, Copy, Debug)]
pub(super) struct Node {
    /// Position in the raw image.
    pub(super) raw_px: [f64; 2],
    /// Least factor by which the lens shrinks what is shown there.
    pub(super) least_slope: f64,
}

impl Node {
    /// The quadratic through nodes at the start, in the middle and at the end of a cell, at a share of the way through it.
    fn within([start, middle, end]: [&Node; 3], share: f64) -> Node {
        let weights = [(1.0 - share) * (1.0 - 2.0 * share), 4.0 * share * (1.0 - share), share * (2.0 * share - 1.0)];
        let mixed = |of: &dyn Fn(&Node) -> f64| weights[0] * of(start) + weights[1] * of(middle) + weights[2] * of(end);
        Node {
            raw_px: [0, 1].map(|axis| mixed(&|node| node.raw_px[axis])),
            least_slope: mixed(&|node| node.least_slope),
        }
    }
}

/// Nodes at equal distances over an image, row by row, which span cells of 3 × 3 nodes; the last ones may lie beyond the image's edges.
#[derive(Clone, Debug)]
pub(super) struct Grid {
    size_px: [u32; 2],
    cell_px: u32,
    columns: usize,
    nodes: Vec<Node>,
}

impl Grid {
    /// Makes the nodes of an image of this size as far apart as the error in between allows. `node` works out a node at a pixel.
    pub(super) fn new(size_px: [u32; 2], node: impl Fn([f64; 2]) -> Node) -> Grid {
        let is_fine = |step_px: u32| {
            let cell_px = 2 * step_px;
            let first = |axis: usize, index: u32| (size_px[axis] - 1) / cell_px * index / (PROBES - 1) * cell_px;
            (0..PROBES * PROBES).all(|index| {
                let from = [first(0, index % PROBES), first(1, index / PROBES)];
                let cell = Grid::over(from, cell_px, [3, 3], &node);
                PROBED.into_iter().all(|share| {
                    let at = from.map(|from| f64::from(from) + share * f64::from(cell_px));
                    let (told, exact) = (cell.within([0, 0], [share, share]), node(at));
                    (0..2).all(|axis| (told.raw_px[axis] - exact.raw_px[axis]).abs() < TOLERANCE_PX)
                })
            })
        };
        let step_px = STEPS_PX.into_iter().find(|step_px| is_fine(*step_px)).unwrap_or(1);
        let n_nodes = size_px.map(|size| 2 * (size - 1).div_ceil(2 * step_px).max(1) as usize + 1);
        Grid { size_px, ..Grid::over([0, 0], 2 * step_px, n_nodes, &node) }
    }

    fn over(from: [u32; 2], cell_px: u32, [columns, rows]: [usize; 2], node: &impl Fn([f64; 2]) -> Node) -> Grid {
        let at = |axis: usize, index: usize| f64::from(from[axis]) + 0.5 * f64::from(cell_px) * index as f64;
        let places = (0..rows).flat_map(|row| (0..columns).map(move |column| [column, row]));
        let nodes = places.map(|[column, row]| node([at(0, column), at(1, row)])).collect();
        Grid { size_px: [0, 0], cell_px, columns, nodes }
    }

    /// Cell of a pixel along an axis, and the share of the way through the cell at which the pixel is. The image's last pixel may be at the end of the
    /// last cell.
    fn place(&self, axis: usize, at_px: u32) -> (usize, f64) {
        let last = (self.size_px[axis] - 1).div_ceil(self.cell_px).max(1) - 1;
        let cell = (at_px / self.cell_px).min(last);
        (cell as usize, f64::from(at_px - cell * self.cell_px) / f64::from(self.cell_px))
    }

    /// The nodes along a row of pixels.
    fn across(&self, v: u32) -> impl Iterator<Item = Node> + '_ {
        let (cell, share) = self.place(1, v);
        let rows = [0, 1, 2].map(|row| &self.nodes[(2 * cell + row) * self.columns..][..self.columns]);
        (0..self.columns).map(move |column| Node::within(rows.map(|row| &row[column]), share))
    }

    /// The nodes of a cell along a row of pixels, given the share of the way through the cell at which the row is.
    fn across_cell(&self, [column, row]: [usize; 2], share: f64) -> [Node; 3] {
        [0, 1, 2].map(|right| {
            let nodes = [0, 1, 2].map(|down| &self.nodes[(2 * row + down) * self.columns + 2 * column + right]);
            Node::within(nodes, share)
        })
    }

    /// What is at shares of the way through a cell, along a row and along a column.
    fn within(&self, cell: [usize; 2], [along, down]: [f64; 2]) -> Node {
        Node::within(self.across_cell(cell, down).each_ref(), along)
    }

    /// What a pixel is taken from.
    #[cfg(test)]
    pub(super) fn node(&self, [u, v]: [u32; 2]) -> Node {
        let ((column, along), (row, down)) = (self.place(0, u), self.place(1, v));
        self.within([column, row], [along, down])
    }

    /// Where the pixels of a row from a column on are taken from: positions in the raw image, in 2⁻³² pixels.
    ///
    /// This is done for every pixel of every image of a rolling shutter, so that it has to be quick: a quadratic is summed up by its differences.
    pub(super) fn places(&self, v: u32, first: u32, places: &mut [[i64; 2]]) {
        let across: Vec<[f64; 2]> = self.across(v).map(|node| node.raw_px.map(|at| at * PARTS)).collect();
        let width = f64::from(self.cell_px);
        let (mut from, mut rest) = (first, places);
        while !rest.is_empty() {
            let (cell, share) = self.place(0, from);
            // The image's last pixel may be at the end of the last cell.
            let n_left = ((cell as u32 + 1) * self.cell_px).saturating_sub(from).max(1) as usize;
            let (of_cell, others) = rest.split_at_mut(n_left.min(rest.len()));
            let nodes: [[f64; 2]; 3] = [0, 1, 2].map(|node| across[2 * cell + node]);
            // Of a + b·k + c·k² at the pixel k of the cell: the value at the first pixel, the step to the next one, and how the step changes.
            let at = share * width;
            let [x, y] = [0, 1].map(|axis| {
                let [a, middle, end] = nodes.map(|node| node[axis]);
                let (b, c) = ((4.0 * middle - 3.0 * a - end) / width, 2.0 * (a - 2.0 * middle + end) / (width * width));
                [a + at * (b + at * c), b + c * (2.0 * at + 1.0), 2.0 * c].map(|value| value as i64)
            });
            let ([mut at_x, mut step_x, more_x], [mut at_y, mut step_y, more_y]) = (x, y);
            for place in &mut *of_cell {
                *place = [at_x, at_y];
                (at_x, at_y) = (at_x + step_x, at_y + step_y);
                (step_x, step_y) = (step_x + more_x, step_y + more_y);
            }
            from += of_cell.len() as u32;
            rest = others;
        }
    }

    /// The pixels that have no source, because they do not show what `is_shown` demands. Only cells are looked through that have a node which is not
    /// `surely` shown: so much that all is shown between nodes that are.
    pub(super) fn without_source(
        &self,
        is_shown: impl Fn(&Node) -> bool,
        surely: impl Fn(&Node) -> bool,
    ) -> Vec<[f64; 2]> {
        let shown: Vec<bool> = self.nodes.iter().map(surely).collect();
        let cells = self.size_px.map(|size| (size - 1).div_ceil(self.cell_px).max(1));
        let mut without = Vec::new();
        for (row, column) in (0..cells[1]).flat_map(|row| (0..cells[0]).map(move |column| (row, column))) {
            let of_row = |down: usize| &shown[(2 * row as usize + down) * self.columns + 2 * column as usize..][..3];
            if (0..3).all(|down| of_row(down).iter().all(|shown| *shown)) {
                continue;
            }
            let [us, vs] = [(0, column), (1, row)].map(|(axis, cell)| {
                let is_last = cell + 1 == cells[axis];
                cell * self.cell_px..if is_last { self.size_px[axis] } else { (cell + 1) * self.cell_px }
            });
            for v in vs {
                let across = self.across_cell([column as usize, row as usize], self.place(1, v).1);
                let is_hidden = |&u: &u32| !is_shown(&Node::within(across.each_ref(), self.place(0, u).1));
                without.extend(us.clone().filter(is_hidden).map(|u| [u, v].map(f64::from)));
            }
        }
        without
    }
}

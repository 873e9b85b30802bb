//! Factorisation of a sparse, symmetric, positive definite matrix: M = P·L·D·Lᵀ·Pᵀ with a permutation P, unit lower triangular L and diagonal D.
//!
//! The positions of all numbers are found once for a structure; then matrices of that structure are factorised again and again. Rows are eliminated
//! in an order of minimum degree, which keeps L sparse, and in a postorder of its elimination tree, which leaves L as sparse and puts rows that depend on
//! each other beside each other. Neighbouring columns of L with the same rows below them are a *block* (a fundamental supernode). Blocks are computed one
//! after the other, each from the blocks before that have numbers in its rows (the *left-looking* way). The numbers of a column stand beside each other
//! in memory, so that the processor works on several at a time, and what a block does to a column is added up before it is put in its places.
//!
//! Source: T. A. Davis, "Direct Methods for Sparse Linear Systems", SIAM 2006, sections 4.1 to 4.3, 4.10 and 7.1; E. G. Ng and B. W. Peyton, "Block
//! sparse Cholesky algorithms on advanced uniprocessor computers", SIAM Journal on Scientific Computing 14 (1993).

mod order;

use std::ops::Range;

use order::{minimum_degree, neighbours, postorder, row_structure, upper_columns};

/// A matrix with a fixed structure, and its factors.
#[derive(Clone, Debug)]
pub(super) struct Factor {
    /// Place of each row of M in the order of elimination.
    place: Vec<usize>,
    /// Columns of the upper triangle of the permuted matrix: where each begins, the row of each number, and the numbers.
    upper: Sparse,
    /// Where the numbers of M have their places in the columns of L, in the order of `upper`: for a number on the diagonal its row, else the place.
    places: Vec<usize>,
    /// The blocks of L, in the order of their columns.
    blocks: Vec<Block>,
    /// Where the numbers of each column of L below its diagonal begin: first those within its block, then those of the block's rows.
    starts: Vec<usize>,
    numbers: Vec<f64>,
    diagonal: Vec<f64>,
    /// Inverses of the numbers on the diagonal; 0 for a lost pivot.
    inverses: Vec<f64>,
}

/// Neighbouring columns of L that have numbers in the same rows below them, and in all rows between their diagonals.
#[derive(Clone, Debug)]
struct Block {
    columns: Range<usize>,
    /// The rows below the last column in which the columns have numbers, in ascending order.
    rows: Vec<usize>,
    /// The earlier blocks with numbers in rows of these columns.
    sources: Vec<Source>,
}

/// A block that has numbers in rows of a later block's columns.
#[derive(Clone, Debug)]
struct Source {
    block: usize,
    /// Which of its rows are columns of the later block.
    rows: Range<usize>,
    /// Where each of its rows from the first of these on is counted among the columns and rows of the later block.
    counted: Vec<u32>,
}

/// Lists of indices and numbers, one after the other.
#[derive(Clone, Debug, Default)]
struct Sparse {
    starts: Vec<usize>,
    indices: Vec<u32>,
    values: Vec<f64>,
}

impl Sparse {
    /// Lists of the given indices, whose numbers are 0.
    fn of(lists: &[Vec<u32>]) -> Sparse {
        let mut sparse = Sparse { starts: vec![0], ..Sparse::default() };
        for list in lists {
            sparse.indices.extend_from_slice(list);
            sparse.starts.push(sparse.indices.len());
        }
        sparse.values = vec![0.0; sparse.indices.len()];
        sparse
    }

    fn span(&self, list: usize) -> Range<usize> {
        self.starts[list]..self.starts[list + 1]
    }
}

impl Factor {
    /// The structure of a matrix of `size` rows with non-zero numbers on the diagonal and between any two members of each group.
    pub(super) fn new<'a>(size: usize, groups: impl Iterator<Item = &'a [u32]>) -> Factor {
        let neighbours = neighbours(size, groups);
        let by_degree = minimum_degree(neighbours.clone());
        let (_, parents) = row_structure(&upper_columns(&neighbours, &by_degree));
        let order: Vec<usize> = postorder(&parents).into_iter().map(|at| by_degree[at]).collect();
        let mut place = vec![0; size];
        order.iter().enumerate().for_each(|(at, &row)| place[row] = at);
        let columns = upper_columns(&neighbours, &order);
        let (row_columns, _) = row_structure(&columns);
        let mut below = vec![Vec::new(); size];
        for (row, columns) in row_columns.iter().enumerate() {
            columns.iter().for_each(|&column| below[column as usize].push(row));
        }
        let blocks = blocks(&below);
        let mut starts = vec![0];
        below.iter().for_each(|rows| starts.push(starts[starts.len() - 1] + rows.len()));
        let upper = Sparse::of(&columns);
        let place_of = |(column, row): (usize, usize)| match row == column {
            true => row,
            false => starts[row] + below[row].partition_point(|&other| other < column),
        };
        let all =
            columns.iter().enumerate().flat_map(|(column, rows)| rows.iter().map(move |&row| (column, row as usize)));
        let places = all.map(place_of).collect();
        let numbers = vec![0.0; starts[size]];
        Factor { place, upper, places, blocks, starts, numbers, diagonal: vec![0.0; size], inverses: vec![0.0; size] }
    }

    /// Where the number in row `a` and column `b` of M is kept, for [`Factor::factorise`]; the rows must be members of one group. It is looked for at
    /// `guess` first.
    pub(super) fn position(&self, a: usize, b: usize, guess: usize) -> usize {
        let (row, column) = (self.place[a].min(self.place[b]), self.place[a].max(self.place[b]));
        let span = self.upper.span(column);
        if span.contains(&guess) && self.upper.indices[guess] as usize == row {
            return guess;
        }
        span.start + self.upper.indices[span].partition_point(|&other| (other as usize) < row)
    }

    /// The numbers of M, to be set before [`Factor::factorise`].
    pub(super) fn numbers(&mut self) -> &mut [f64] {
        &mut self.upper.values
    }

    /// Computes the factors. A pivot that rounding has made 0 or negative counts as infinite, which makes its unknown 0 and its column of L 0.
    pub(super) fn factorise(&mut self) {
        self.numbers.fill(0.0);
        for column in 0..self.diagonal.len() {
            let span = self.upper.span(column);
            let last = span.end - 1;
            for at in span.start..last {
                self.numbers[self.places[at]] = self.upper.values[at];
            }
            self.diagonal[column] = self.upper.values[last];
        }
        let mut sum = Vec::new();
        for at in 0..self.blocks.len() {
            let columns = self.blocks[at].columns.clone();
            let largest: Vec<f64> = self.diagonal[columns.clone()].to_vec();
            // What stands before the block's columns is known by now, and is only read.
            let (before, own) = self.numbers.split_at_mut(self.starts[columns.start]);
            let (diagonal_before, diagonal) = self.diagonal.split_at_mut(columns.start);
            let inverses = &mut self.inverses[columns.start..];
            let own_starts = &self.starts[columns.start..];
            let start = |column: usize| own_starts[column] - own_starts[0];
            for source in &self.blocks[at].sources {
                let from = &self.blocks[source.block];
                let (n_columns, n_rows) = (from.columns.len(), from.rows.len());
                for row in source.rows.clone() {
                    sum.clear();
                    sum.resize(n_rows - row, 0.0);
                    for (idx, column) in from.columns.clone().enumerate() {
                        let numbers = &before[self.starts[column] + n_columns - 1 - idx..][..n_rows];
                        add(&mut sum, &numbers[row..], numbers[row] * diagonal_before[column]);
                    }
                    let counted = &source.counted[row - source.rows.start..];
                    let column = counted[0] as usize;
                    diagonal[column] -= sum[0];
                    let target = &mut own[start(column)..start(column + 1)];
                    for (&counted, value) in counted[1..].iter().zip(&sum[1..]) {
                        target[counted as usize - column - 1] -= value;
                    }
                }
            }
            for column in 0..columns.len() {
                let (left, this) = own.split_at_mut(start(column));
                let this = &mut this[..start(column + 1) - start(column)];
                let mut pivot = diagonal[column];
                for earlier in 0..column {
                    let numbers = &left[start(earlier)..start(earlier + 1)];
                    let factor = numbers[column - earlier - 1];
                    let value = factor * diagonal[earlier];
                    pivot -= factor * value;
                    add(this, &numbers[column - earlier..], -value);
                }
                let is_lost = pivot.is_nan() || pivot <= 1e-14 * largest[column];
                // 0 in place of infinity: it is multiplied by the column's zeros alone.
                diagonal[column] = if is_lost { 0.0 } else { pivot };
                let inverse = if is_lost { 0.0 } else { 1.0 / pivot };
                inverses[column] = inverse;
                this.iter_mut().for_each(|number| *number *= inverse);
            }
        }
    }

    /// The numbers of a column of L: those within its block, and those in the block's rows.
    fn column(&self, block: &Block, column: usize) -> (&[f64], &[f64]) {
        self.numbers[self.starts[column]..self.starts[column + 1]].split_at(block.columns.end - 1 - column)
    }

    /// Replaces b by the solution x of M·x = b.
    pub(super) fn solve(&self, b: &mut [f64]) {
        let mut x = vec![0.0; self.diagonal.len()];
        self.place.iter().zip(b.iter()).for_each(|(&at, &value)| x[at] = value);
        let mut gathered = Vec::new();
        for block in &self.blocks {
            gathered.clear();
            gathered.resize(block.rows.len(), 0.0);
            for column in block.columns.clone() {
                let (within, below) = self.column(block, column);
                let value = x[column];
                add(&mut x[column + 1..], within, -value);
                add(&mut gathered, below, value);
            }
            block.rows.iter().zip(&gathered).for_each(|(&row, value)| x[row] -= value);
        }
        for block in self.blocks.iter().rev() {
            gathered.clear();
            gathered.extend(block.rows.iter().map(|&row| x[row]));
            for column in block.columns.clone().rev() {
                let (within, below) = self.column(block, column);
                x[column] =
                    x[column] * self.inverses[column] - product(within, &x[column + 1..]) - product(below, &gathered);
            }
        }
        self.place.iter().zip(b.iter_mut()).for_each(|(&at, value)| *value = x[at]);
    }
}

/// Adds a multiple of numbers to the first ones of a vector.
fn add(vector: &mut [f64], numbers: &[f64], times: f64) {
    vector.iter_mut().zip(numbers).for_each(|(value, number)| *value += number * times);
}

/// Sum of the products of numbers with the first ones of others, in four sums that do not wait for each other.
fn product(one: &[f64], other: &[f64]) -> f64 {
    let mut sums = [0.0; 4];
    let (ones, others) = (one.chunks_exact(4), other[..one.len()].chunks_exact(4));
    let rest: f64 = ones.remainder().iter().zip(others.remainder()).map(|(a, b)| a * b).sum();
    for (ones, others) in ones.zip(others) {
        sums.iter_mut().zip(ones.iter().zip(others)).for_each(|(sum, (a, b))| *sum += a * b);
    }
    sums.iter().sum::<f64>() + rest
}

/// The blocks of L, whose columns have numbers in the rows given.
fn blocks(below: &[Vec<usize>]) -> Vec<Block> {
    let mut blocks: Vec<Block> = Vec::new();
    for (column, rows) in below.iter().enumerate() {
        let continues = |last: &Block| last.rows.first() == Some(&column) && last.rows[1..] == rows[..];
        match blocks.last_mut().filter(|last| continues(last)) {
            Some(last) => {
                last.columns.end += 1;
                last.rows.remove(0);
            }
            None => blocks.push(Block { columns: column..column + 1, rows: rows.clone(), sources: Vec::new() }),
        }
    }
    for at in 0..blocks.len() {
        let mut first = 0;
        while let Some(&row) = blocks[at].rows.get(first) {
            let later = blocks.partition_point(|block| block.columns.end <= row);
            let (columns, rows) = (&blocks[later].columns, &blocks[later].rows);
            let n_in = blocks[at].rows[first..].partition_point(|&row| row < columns.end);
            let counted = blocks[at].rows[first..].iter().map(|&row| match row < columns.end {
                true => row - columns.start,
                false => columns.len() + rows.partition_point(|&other| other < row),
            });
            let counted = counted.map(|counted| counted as u32).collect();
            blocks[later].sources.push(Source { block: at, rows: first..first + n_in, counted });
            first += n_in;
        }
    }
    blocks
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Checks that the solution of a system with the given groups, each with random weights, is found.
    fn undo(size: usize, groups: &[Vec<u32>], mut random: impl FnMut() -> f64) {
        let mut factor = Factor::new(size, groups.iter().map(Vec::as_slice));
        let mut dense = vec![vec![0.0; size]; size];
        for group in groups {
            let weights: Vec<f64> = group.iter().map(|_| random()).collect();
            for (&a, wa) in group.iter().zip(&weights) {
                for (&b, wb) in group.iter().zip(&weights) {
                    dense[a as usize][b as usize] += wa * wb;
                }
            }
        }
        for (row, numbers) in dense.iter_mut().enumerate() {
            numbers[row] += 0.01;
            for (column, &number) in numbers.iter().enumerate().take(row + 1).filter(|(_, number)| **number != 0.0) {
                let at = factor.position(row, column, 0);
                factor.numbers()[at] = number;
            }
        }
        // What an earlier matrix left does not matter.
        factor.factorise();
        factor.factorise();
        let x: Vec<f64> = (0..size).map(|at| (at as f64).sin()).collect();
        let mut b: Vec<f64> = dense.iter().map(|row| row.iter().zip(&x).map(|(a, x)| a * x).sum()).collect();
        factor.solve(&mut b);
        b.iter().zip(&x).for_each(|(got, x)| assert!((got - x).abs() < 1e-9, "{got} instead of {x}: {groups:?}"));
    }

    #[test]
    fn a_product_is_undone() {
        // A chain of seven unknowns with a border that all share, as a pose graph with one constant has.
        let mut weights = [1.0, -2.0, 0.5].into_iter().cycle();
        let groups: Vec<Vec<u32>> = (0..6).map(|at| vec![at, at + 1, 7]).collect();
        undo(8, &groups, || weights.next().unwrap_or_default());
        // Groups of all sizes, in many orders of elimination: blocks of many columns, and of one.
        let mut state = 20_261_129_u64;
        let mut random = move || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 33) as f64 / (1u64 << 31) as f64
        };
        for round in 0..200 {
            let size = 1 + (random() * 60.0) as usize;
            let groups: Vec<Vec<u32>> = (0..size)
                .map(|_| {
                    let mut group: Vec<u32> = (0..1 + round % 7).map(|_| (random() * size as f64) as u32).collect();
                    group.sort_unstable();
                    group.dedup();
                    group
                })
                .collect();
            undo(size, &groups, &mut random);
        }
    }

    #[test]
    fn an_unknown_that_no_number_tells_is_0_and_spoils_no_other() {
        // Two unknowns of which only the sum is told, beside others, all in one block.
        for others in 1..5_u32 {
            let size = 2 + others as usize;
            let everything: Vec<u32> = (0..size as u32).collect();
            let mut factor = Factor::new(size, std::iter::once(everything.as_slice()));
            let mut put = |row: usize, column: usize, number: f64| {
                let at = factor.position(row, column, 0);
                factor.numbers()[at] = number;
            };
            [(0, 0), (1, 0), (1, 1)].into_iter().for_each(|(row, column)| put(row, column, 1.0));
            (2..size).for_each(|row| put(row, row, 2.0));
            factor.factorise();
            let mut b = vec![3.0; size];
            factor.solve(&mut b);
            assert!((b[0] + b[1] - 3.0).abs() < 1e-12 && b[0] * b[1] == 0.0, "{b:?}");
            assert!(b[2..].iter().all(|x| (x - 1.5).abs() < 1e-12), "{b:?}");
        }
    }

    #[test]
    fn a_border_is_eliminated_last() {
        // A star: one unknown that all others share. Eliminated first, it would make all others neighbours.
        let groups: Vec<[u32; 2]> = (1..9).map(|leaf| [0, leaf]).collect();
        let factor = Factor::new(9, groups.iter().map(|group| group.as_slice()));
        assert!(factor.place[0] >= 7 && factor.numbers.len() == 8, "{factor:?}");
    }
}

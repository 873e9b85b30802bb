//! Factorisation of a sparse, symmetric, positive definite matrix: M = P·L·D·Lᵀ·Pᵀ with a permutation P, unit lower triangular L and diagonal D.
//!
//! The positions of all numbers are found once for a structure; then matrices of that structure are factorised again and again. Rows are eliminated
//! in an order of minimum degree, which keeps L sparse, and computed one after the other, each from the rows before (the *up-looking* way).
//!
//! Source: T. A. Davis, "Direct Methods for Sparse Linear Systems", SIAM 2006, sections 4.8 and 7.1.

/// A matrix with a fixed structure, and its factors.
#[derive(Clone, Debug)]
pub(super) struct Factor {
    /// Place of each row of M in the order of elimination.
    place: Vec<usize>,
    /// Columns of the upper triangle of the permuted matrix: where each begins, the row of each number, and the numbers.
    upper: Sparse,
    /// For each row of L, the columns of its numbers, in an order in which they can be computed.
    row_columns: Sparse,
    /// Columns of L below its diagonal.
    lower: Sparse,
    diagonal: Vec<f64>,
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

    fn span(&self, list: usize) -> std::ops::Range<usize> {
        self.starts[list]..self.starts[list + 1]
    }
}

impl Factor {
    /// The structure of a matrix of `size` rows with non-zero numbers on the diagonal and between any two members of each group.
    pub(super) fn new<'a>(size: usize, groups: impl Iterator<Item = &'a [u32]>) -> Factor {
        let neighbours = neighbours(size, groups);
        let order = minimum_degree(neighbours.clone());
        let mut place = vec![0; size];
        order.iter().enumerate().for_each(|(at, &row)| place[row] = at);
        let columns: Vec<Vec<u32>> = order
            .iter()
            .enumerate()
            .map(|(column, &row)| {
                let places = members(&neighbours[row]).map(|other| place[other]).filter(|&other| other <= column);
                let mut rows: Vec<u32> = places.map(|other| other as u32).collect();
                rows.sort_unstable();
                rows
            })
            .collect();
        let row_columns = row_structure(&columns);
        let mut below = vec![Vec::new(); size];
        for (row, columns) in row_columns.iter().enumerate() {
            columns.iter().for_each(|&column| below[column as usize].push(row as u32));
        }
        Factor {
            place,
            upper: Sparse::of(&columns),
            row_columns: Sparse::of(&row_columns),
            lower: Sparse::of(&below),
            diagonal: vec![0.0; size],
        }
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

    /// Computes the factors. A pivot that rounding has made 0 or negative is replaced by infinity, which makes its unknown 0.
    pub(super) fn factorise(&mut self) {
        let size = self.diagonal.len();
        let mut row = vec![0.0; size];
        let mut ends: Vec<usize> = self.lower.starts[..size].to_vec();
        for k in 0..size {
            let mut largest = 0.0;
            for at in self.upper.span(k) {
                row[self.upper.indices[at] as usize] = self.upper.values[at];
                largest = self.upper.values[at];
            }
            let mut pivot = std::mem::take(&mut row[k]);
            for at in self.row_columns.span(k) {
                let column = self.row_columns.indices[at] as usize;
                let value = std::mem::take(&mut row[column]);
                let (from, to) = (self.lower.starts[column], ends[column]);
                subtract(&mut row, &self.lower.indices[from..to], &self.lower.values[from..to], value);
                let factor = value / self.diagonal[column];
                pivot -= factor * value;
                self.lower.values[to] = factor;
                ends[column] = to + 1;
            }
            self.diagonal[k] = if pivot > 1e-14 * largest { pivot } else { f64::INFINITY };
        }
    }

    /// Replaces b by the solution x of M·x = b.
    pub(super) fn solve(&self, b: &mut [f64]) {
        let size = self.diagonal.len();
        let mut x = vec![0.0; size];
        self.place.iter().zip(b.iter()).for_each(|(&at, &value)| x[at] = value);
        for column in 0..size {
            let value = x[column];
            let span = self.lower.span(column);
            subtract(&mut x, &self.lower.indices[span.clone()], &self.lower.values[span], value);
        }
        for column in (0..size).rev() {
            let mut value = x[column] / self.diagonal[column];
            let span = self.lower.span(column);
            for (&row, number) in self.lower.indices[span.clone()].iter().zip(&self.lower.values[span]) {
                value -= number * x[row as usize];
            }
            x[column] = value;
        }
        self.place.iter().zip(b.iter_mut()).for_each(|(&at, value)| *value = x[at]);
    }
}

/// Subtracts a multiple of some numbers from those of a vector that have the given indices, in ascending order. Where no index is left out between them,
/// as is usual where most quantities occur in most rows, the compiler makes vector instructions of that.
fn subtract(vector: &mut [f64], indices: &[u32], numbers: &[f64], times: f64) {
    let (Some(&first), Some(&last)) = (indices.first(), indices.last()) else { return };
    let span = first as usize..last as usize + 1;
    if span.len() == indices.len() {
        vector[span].iter_mut().zip(numbers).for_each(|(value, number)| *value -= number * times);
    } else {
        indices.iter().zip(numbers).for_each(|(&at, number)| vector[at as usize] -= number * times);
    }
}

/// For each row its neighbours and itself: all members of its groups, as bits.
fn neighbours<'a>(size: usize, groups: impl Iterator<Item = &'a [u32]>) -> Vec<Vec<u64>> {
    let mut neighbours = vec![vec![0u64; size.div_ceil(64)]; size];
    for group in groups {
        for &a in group {
            group.iter().for_each(|&b| neighbours[a as usize][b as usize / 64] |= 1 << (b % 64));
        }
    }
    for (row, set) in neighbours.iter_mut().enumerate() {
        set[row / 64] |= 1 << (row % 64);
    }
    neighbours
}

/// The numbers of the bits of a set.
fn members(set: &[u64]) -> impl Iterator<Item = usize> {
    let of_word = |(at, &word): (usize, &u64)| {
        let rests = std::iter::successors(Some(word), |rest| Some(rest & rest.wrapping_sub(1)));
        rests.take_while(|rest| *rest != 0).map(move |rest| 64 * at + rest.trailing_zeros() as usize)
    };
    set.iter().enumerate().flat_map(of_word)
}

/// An order of the rows in which each has the fewest neighbours among those after it, once the neighbours of the rows before have become neighbours
/// of each other; the first row where several have equally many.
fn minimum_degree(mut neighbours: Vec<Vec<u64>>) -> Vec<usize> {
    let size = neighbours.len();
    let mut degrees: Vec<u32> = neighbours.iter().map(|set| degree(set)).collect();
    let mut order = Vec::with_capacity(size);
    let mut left: Vec<usize> = (0..size).collect();
    while let Some((at, &row)) = left.iter().enumerate().min_by_key(|&(_, &row)| degrees[row]) {
        left.remove(at);
        order.push(row);
        let set = std::mem::take(&mut neighbours[row]);
        for &other in left.iter().filter(|&&other| set[other / 64] >> (other % 64) & 1 == 1) {
            neighbours[other].iter_mut().zip(&set).for_each(|(word, more)| *word |= more);
            neighbours[other][row / 64] &= !(1 << (row % 64));
            degrees[other] = degree(&neighbours[other]);
        }
    }
    order
}

fn degree(set: &[u64]) -> u32 {
    set.iter().map(|word| word.count_ones()).sum()
}

/// The columns of the numbers in each row of L, in ascending order, by the elimination tree: where row k has a number in column i, it has one in the
/// column of i's first number below the diagonal, too.
fn row_structure(columns: &[Vec<u32>]) -> Vec<Vec<u32>> {
    let mut parent = vec![usize::MAX; columns.len()];
    let mut seen_by = vec![usize::MAX; columns.len()];
    let mut rows = Vec::with_capacity(columns.len());
    for (k, column) in columns.iter().enumerate() {
        let mut row = Vec::new();
        seen_by[k] = k;
        for &from in column {
            let mut at = from as usize;
            while seen_by[at] != k {
                seen_by[at] = k;
                row.push(at as u32);
                if parent[at] == usize::MAX {
                    parent[at] = k;
                }
                at = parent[at];
            }
        }
        row.sort_unstable();
        rows.push(row);
    }
    rows
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_product_is_undone() {
        // A chain of seven unknowns with a border that all share, as a pose graph with one constant has.
        let size = 8;
        let groups: Vec<Vec<u32>> = (0..6).map(|at| vec![at, at + 1, 7]).collect();
        let mut factor = Factor::new(size, groups.iter().map(Vec::as_slice));
        let mut dense = vec![vec![0.0; size]; size];
        for (idx, group) in groups.iter().enumerate() {
            let weights = [1.0, -2.0 - idx as f64, 0.5];
            for (&a, wa) in group.iter().zip(weights) {
                for (&b, wb) in group.iter().zip(weights) {
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
        factor.factorise();
        let x: Vec<f64> = (0..size).map(|at| (at as f64).sin()).collect();
        let mut b: Vec<f64> = dense.iter().map(|row| row.iter().zip(&x).map(|(a, x)| a * x).sum()).collect();
        factor.solve(&mut b);
        b.iter().zip(&x).for_each(|(got, x)| assert!((got - x).abs() < 1e-9, "{got} instead of {x}"));
    }

    #[test]
    fn a_border_is_eliminated_last() {
        // A star: one unknown that all others share. Eliminated first, it would make all others neighbours.
        let groups: Vec<[u32; 2]> = (1..9).map(|leaf| [0, leaf]).collect();
        let factor = Factor::new(9, groups.iter().map(|group| group.as_slice()));
        assert!(factor.place[0] >= 7 && factor.lower.indices.len() == 8, "{factor:?}");
    }
}

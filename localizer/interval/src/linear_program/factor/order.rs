//! The order in which the rows of a sparse, symmetric matrix are eliminated, and the structure of its factor in that order.

/// Columns of the upper triangle of a matrix whose rows are taken in the given order: for each column, the places of its rows.
pub(super) fn upper_columns(neighbours: &[Vec<u64>], order: &[usize]) -> Vec<Vec<u32>> {
    let mut place = vec![0; order.len()];
    order.iter().enumerate().for_each(|(at, &row)| place[row] = at);
    let column = |(column, &row): (usize, &usize)| {
        let places = members(&neighbours[row]).map(|other| place[other]).filter(|&other| other <= column);
        let mut rows: Vec<u32> = places.map(|other| other as u32).collect();
        rows.sort_unstable();
        rows
    };
    order.iter().enumerate().map(column).collect()
}

/// The nodes of a forest in which each one's parent is later: every node after all nodes below it, and these without others between them.
pub(super) fn postorder(parents: &[usize]) -> Vec<usize> {
    let size = parents.len();
    let mut children = vec![Vec::new(); size];
    (0..size).rev().filter(|&node| parents[node] < size).for_each(|node| children[parents[node]].push(node));
    let mut order = Vec::with_capacity(size);
    for root in (0..size).filter(|&node| parents[node] >= size) {
        let mut path = vec![root];
        while let Some(&node) = path.last() {
            match children[node].pop() {
                Some(child) => path.push(child),
                None => {
                    order.push(node);
                    path.pop();
                }
            }
        }
    }
    order
}

/// For each row its neighbours and itself: all members of its groups, as bits.
pub(super) fn neighbours<'a>(size: usize, groups: impl Iterator<Item = &'a [u32]>) -> Vec<Vec<u64>> {
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
pub(super) fn minimum_degree(mut neighbours: Vec<Vec<u64>>) -> Vec<usize> {
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
/// column of i's first number below the diagonal, too, which is i's parent. The parents are returned as well, `usize::MAX` for a row without one.
pub(super) fn row_structure(columns: &[Vec<u32>]) -> (Vec<Vec<u32>>, Vec<usize>) {
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
    (rows, parent)
}

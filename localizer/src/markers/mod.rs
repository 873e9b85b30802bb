//! Dot-matrix markers on the ceiling (paper 5, section 3): the printed pattern and the identity that it encodes.
//!
//! Frame `marker`: origin at the middle of the 4 × 4 grid, x from dot O to dot X, y from dot O to dot Y, as on the ceiling seen with world z up; a
//! camera that looks up sees X → Y turn clockwise. Grid coordinates `[i, j]` count from O along x and y, 0 to 3:
//!
//! ```text
//!   Y 0x020 0x200  .        Y, O, X: direction dots, always there
//! 0x002 0x010 0x100 0x800   . : never there
//! 0x001 0x008 0x080 0x400   the others: coded dots with their weights (matrix Q of Eq. 9)
//!   O 0x004 0x040  X
//! ```

mod coding;

pub use coding::Coding;

/// Number of dots along each side of a marker's grid.
pub const GRID: u8 = 4;
/// Distance between the centres of neighbouring dots in a marker's grid.
pub const PITCH_M: f64 = 0.04;
/// Radius of a marker's dot.
pub const DOT_RADIUS_M: f64 = 0.01;
/// Number of places of a marker's grid that encode its identity, by having a dot (a coded dot) or none.
pub const N_CODED: u32 = 12;

/// Place of a dot in a marker's grid, `[along x, along y]`, each 0 to 3.
pub type GridPlace = [u8; 2];

/// Grid places of the direction dots O, X and Y, which every marker has.
pub const DIRECTION_DOTS: [GridPlace; 3] = [[0, 0], [3, 0], [0, 3]];
/// Grid place of the marker's fourth corner, where no dot is ever printed.
pub const EMPTY_CORNER: GridPlace = [3, 3];

/// Identity of a marker: the sum of the weights of its coded dots (Eq. 9 with the printed Q), 0 to 4095.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct MarkerId(pub u16);

/// Weight of the coded dot at a grid place in the marker's identity, matrix Q of Eq. (9); `None` for the four corners and outside of the grid.
///
/// Weights rise along y, column by column, over the places that are not corners.
pub fn weight([i, j]: GridPlace) -> Option<u16> {
    let bit = match (i, j) {
        (0, 1 | 2) => j - 1,
        (1 | 2, 0..=3) => 4 * i - 2 + j,
        (3, 1 | 2) => 9 + j,
        _ => return None,
    };
    Some(1 << bit)
}

impl MarkerId {
    /// Whether a marker with this identity has a dot printed at this place of the grid.
    pub fn has_dot(self, place: GridPlace) -> bool {
        DIRECTION_DOTS.contains(&place) || weight(place).is_some_and(|weight| self.0 & weight != 0)
    }

    /// Places of all printed dots of the marker, direction dots included, by rising `i`, then by rising `j`.
    pub fn dots(self) -> impl Iterator<Item = GridPlace> {
        (0..GRID).flat_map(|i| (0..GRID).map(move |j| [i, j])).filter(move |place| self.has_dot(*place))
    }

    /// The marker identity that coded dots at these places of the grid encode; direction dots among them add nothing.
    pub fn from_dots(places: impl IntoIterator<Item = GridPlace>) -> MarkerId {
        MarkerId(places.into_iter().filter_map(weight).fold(0, |id, weight| id | weight))
    }
}

/// Position of a dot's centre in the marker frame.
pub fn dot_in_marker_m(place: GridPlace) -> [f64; 2] {
    place.map(|index| (f64::from(index) - 1.5) * PITCH_M)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Identity encoded by a weight matrix W as the paper prints it: its first row is at the top, and its columns begin at O's side.
    fn printed(rows: [[u8; 4]; 4]) -> MarkerId {
        let place = |row: usize, column: usize| [column as u8, 3 - row as u8];
        let set = (0..4).flat_map(|row| (0..4).map(move |column| (row, column)));
        MarkerId::from_dots(set.filter(|&(row, column)| rows[row][column] == 1).map(|(row, column)| place(row, column)))
    }

    #[test]
    fn the_papers_sample_spells_447_and_not_1782() {
        // Erratum I1 of paper 5: the sum of W·Q with the matrix W as printed is 0x1BF = 447; the printed sum 1782 needs another W.
        assert_eq!(printed([[0, 1, 0, 0], [1, 1, 1, 0], [1, 1, 1, 0], [0, 1, 0, 0]]), MarkerId(447));
        assert_eq!(printed([[0, 1, 1, 0], [1, 1, 0, 0], [0, 0, 1, 1], [0, 1, 1, 0]]), MarkerId(1782));
    }

    #[test]
    fn the_weights_are_those_of_the_printed_matrix() {
        let q =
            [[0, 0x020, 0x200, 0], [0x002, 0x010, 0x100, 0x800], [0x001, 0x008, 0x080, 0x400], [0, 0x004, 0x040, 0]];
        for (row, weights) in q.iter().enumerate() {
            for (column, &expected) in weights.iter().enumerate() {
                assert_eq!(weight([column as u8, 3 - row as u8]).unwrap_or(0), expected);
            }
        }
        assert_eq!(weight([4, 0]), None);
    }

    #[test]
    fn a_marker_has_three_to_fifteen_dots_and_never_the_fourth_corner() {
        assert_eq!(MarkerId(0).dots().count(), 3);
        assert_eq!(MarkerId(4095).dots().count(), 15);
        for id in 0..4096 {
            let id = MarkerId(id);
            assert!(!id.has_dot(EMPTY_CORNER));
            assert_eq!(MarkerId::from_dots(id.dots()), id);
        }
    }

    #[test]
    fn direction_dots_lie_twelve_centimetres_apart() {
        let [o, x, y] = DIRECTION_DOTS.map(dot_in_marker_m);
        assert!((x[0] - o[0] - 0.12).abs() < 1e-15 && (y[1] - o[1] - 0.12).abs() < 1e-15);
        assert_eq!((x[1], y[0]), (o[1], o[0]));
    }
}

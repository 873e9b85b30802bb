//! Stretches of a way on which no picture bounds the robot's position.

use localizer::Pose;
use serde::Serialize;

/// What the pictures from one place tell of the pose, the least first.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Told {
    /// Nothing.
    Nothing,
    /// The heading alone.
    Heading,
    /// The position, modulo a tile where it is by the joints of a tiled floor.
    Position,
}

/// A stretch of the way on which no picture bounds the position.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Stretch {
    /// Distances along the way of the first and of the last place on it.
    pub along_way_m: [f64; 2],
    /// Positions of the first and of the last place on it.
    pub ends_m: [[f64; 2]; 2],
    /// Number of places on it at which pictures were taken.
    pub n_places: usize,
    /// Number of these at which a picture tells the heading.
    pub n_with_heading: usize,
}

/// The stretches of at least two places in a row from which no picture bounds the position, for places that are evenly along a way of this length.
pub(super) fn stretches(places: &[Pose], told: &[Told], way_m: f64) -> Vec<Stretch> {
    let apart_m = way_m / places.len().saturating_sub(1).max(1) as f64;
    let mut first = 0;
    let runs = told.chunk_by(|one, next| (*one == Told::Position) == (*next == Told::Position));
    let stretch = |run: &[Told]| {
        let (begin, end) = (first, first + run.len());
        first = end;
        let is_without = run.len() > 1 && run[0] != Told::Position;
        let at_m = |nth: usize| places.get(nth).map(|pose| [pose.x_m, pose.y_m]);
        Some(Stretch {
            along_way_m: [begin, end - 1].map(|nth| nth as f64 * apart_m),
            ends_m: [at_m(begin)?, at_m(end - 1)?],
            n_places: run.len(),
            n_with_heading: run.iter().filter(|told| **told == Told::Heading).count(),
        })
        .filter(|_| is_without)
    };
    runs.filter_map(stretch).collect()
}

#[cfg(test)]
mod tests {
    use super::Told::{Heading, Nothing, Position};
    use super::*;

    #[test]
    fn stretches_are_of_at_least_two_places_in_a_row_without_position() {
        let place = |nth: i32| Pose { x_m: 0.5 * f64::from(nth), y_m: 2.0, heading_rad: 0.0 };
        let places: Vec<Pose> = (0..8).map(place).collect();
        let told = [Nothing, Heading, Position, Nothing, Position, Heading, Heading, Nothing];
        let found = stretches(&places, &told, 3.5);
        let expected = [
            Stretch { along_way_m: [0.0, 0.5], ends_m: [[0.0, 2.0], [0.5, 2.0]], n_places: 2, n_with_heading: 1 },
            Stretch { along_way_m: [2.5, 3.5], ends_m: [[2.5, 2.0], [3.5, 2.0]], n_places: 3, n_with_heading: 2 },
        ];
        assert_eq!(found, expected);
        assert_eq!(stretches(&places, &[Position; 8], 3.5), []);
    }
}

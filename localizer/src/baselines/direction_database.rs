//! Paper 2's database of directions, Eqs. (2) and (3), with points: each remembered direction inherits the heading's error.

use std::f64::consts::FRAC_PI_2;

/// Directions of the building modulo quarter turns, each the mean of its observations.
#[derive(Clone, Debug, Default)]
pub struct DirectionDatabase {
    /// Mean direction in the world, and the number of observations in it.
    directions: Vec<(f64, f64)>,
}

/// A direction farther from all others is a new one; the paper states no value.
const NEW_RAD: f64 = 0.17;

impl DirectionDatabase {
    /// The heading, corrected by the direction that is seen at `seen_rad` from robot forward; `None` when the direction was new.
    ///
    /// Eq. (2): direction in the world = seen + heading. Eq. (3) as printed would return only the innovation; meant is heading = mean direction − seen.
    pub fn correct(&mut self, seen_rad: f64, heading_rad: f64) -> Option<f64> {
        let in_world_rad = seen_rad + heading_rad;
        let off = |mean: f64| {
            let turn = in_world_rad - mean;
            turn - (turn / FRAC_PI_2).round() * FRAC_PI_2
        };
        let near = self.directions.iter_mut().min_by(|a, b| off(a.0).abs().total_cmp(&off(b.0).abs()));
        match near.filter(|(mean, _)| off(*mean).abs() < NEW_RAD) {
            Some((mean, count)) => {
                let innovation = off(*mean);
                *count += 1.0;
                *mean += innovation / *count;
                Some(heading_rad - innovation)
            }
            None => {
                self.directions.push((in_world_rad, 1.0));
                None
            }
        }
    }
}

//! The database of directions of paper 2 (Yi, Lee and Cho 2018), Eqs. (2) and (3), with points in place of intervals: each remembered direction
//! inherits the error of the heading at which it was seen.

use std::f64::consts::FRAC_PI_2;

/// Directions of the building's walls in the world frame, modulo quarter turns, each the mean of its observations.
#[derive(Clone, Debug, Default)]
pub struct DirectionDatabase {
    /// For each known wall direction the mean of its observations in the world frame, and their number.
    directions: Vec<(f64, f64)>,
}

/// A wall direction that is seen farther than this from all known ones counts as new; the paper states no value.
const NEW_RAD: f64 = 0.17;

impl DirectionDatabase {
    /// The robot's heading, corrected by the wall direction that is seen at `seen_rad` from robot forward; `None` when that wall direction was new.
    ///
    /// Eq. (2): direction in the world = seen + heading. Eq. (3) as printed would return only the innovation; what it means is heading = mean
    /// direction − seen.
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

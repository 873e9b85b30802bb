//! Errors that are drawn at random anew for every reading: for example the error of a time stamp, of the delay of a reading's delivery, or of a range
//! camera's image column.

use rand::RngExt;
use rand_chacha::ChaCha8Rng;

use super::draw_within;
use crate::scene::Distribution;

/// Random errors from one random stream, drawn anew for each reading. If the scene chooses the distribution `Drift`, they are not random but those
/// errors within the tolerance that add up worst; the seed chooses the side.
#[derive(Clone, Debug)]
pub struct Repeated {
    errors: Distribution,
    rng: ChaCha8Rng,
    /// With the distribution `Drift`, the end of the tolerance at which the errors lie: 1 or −1. Other distributions do not use it.
    side: f64,
    n_alternations: u64,
}

impl Repeated {
    /// Errors for successive readings, drawn from the random stream `rng`, which must not serve anything else.
    pub fn new(errors: Distribution, mut rng: ChaCha8Rng) -> Self {
        // The side is drawn only for the distribution `Drift`, so that for the other distributions no number of the stream is used up and their
        // errors stay the same.
        let side = if errors == Distribution::Drift { draw_within(1.0, errors, &mut rng) } else { 1.0 };
        Repeated { errors, rng, side, n_alternations: 0 }
    }

    /// Draws an error within ±tolerance. With the distribution `Drift` it is always the same end of the tolerance.
    pub fn one_way(&mut self, tolerance: f64) -> f64 {
        match self.errors {
            Distribution::Drift => self.side * tolerance,
            errors => draw_within(tolerance, errors, &mut self.rng),
        }
    }

    /// Draws an error within ±tolerance. With the distribution `Drift` it alternates between both ends of the tolerance, so that successive errors
    /// differ by as much as they can.
    pub fn in_turn(&mut self, tolerance: f64) -> f64 {
        match self.errors {
            Distribution::Drift => {
                self.n_alternations += 1;
                if self.n_alternations.is_multiple_of(2) { -self.side * tolerance } else { self.side * tolerance }
            }
            errors => draw_within(tolerance, errors, &mut self.rng),
        }
    }
}

/// Draws a wheel encoder's phase at the start, from 0 to 1, 1 excluded: how far within a tick the wheel stands. It is uniform, unless the scene
/// chooses another distribution of errors.
pub(crate) fn draw_phase(errors: Distribution, rng: &mut ChaCha8Rng) -> f64 {
    /// The greatest number below 1.
    const LAST: f64 = 1.0 - f64::EPSILON / 2.0;
    match errors {
        Distribution::Uniform => rng.random_range(0.0..1.0),
        errors => (0.5 + draw_within(0.5, errors, rng)).clamp(0.0, LAST),
    }
}

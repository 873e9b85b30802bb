//! Errors that are drawn anew for every reading: of a stamp, a delivery, an image column.

use rand::RngExt;
use rand_chacha::ChaCha8Rng;

use super::draw_within;
use crate::scene::Distribution;

/// Draws from one random stream, a new one for each reading. With the distribution `Drift` they are not random but the errors that add up
/// worst, to a side that the seed chooses.
#[derive(Clone, Debug)]
pub struct Repeated {
    errors: Distribution,
    rng: ChaCha8Rng,
    /// Side of the tolerance for errors of the distribution `Drift`: 1 or −1. Other distributions do not use it.
    side: f64,
    n_alternations: u64,
}

impl Repeated {
    /// Repeated errors from a stream that nothing else draws from.
    pub fn new(errors: Distribution, mut rng: ChaCha8Rng) -> Self {
        // The side is drawn only for the distribution `Drift`, so that it changes the sequence of draws for no other distribution.
        let side = if errors == Distribution::Drift { draw_within(1.0, errors, &mut rng) } else { 1.0 };
        Repeated { errors, rng, side, n_alternations: 0 }
    }

    /// Draws an error within ±tolerance; with `Drift` it is always the same end of the tolerance.
    pub fn one_way(&mut self, tolerance: f64) -> f64 {
        match self.errors {
            Distribution::Drift => self.side * tolerance,
            errors => draw_within(tolerance, errors, &mut self.rng),
        }
    }

    /// Draws an error within ±tolerance; with `Drift` it alternates between both ends, so that successive errors differ by as much as they
    /// can.
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

/// Draws a phase from 0 to 1, 1 excluded: where within an encoder tick a wheel stands at the start. It is uniform, unless the scene chooses
/// another distribution of errors.
pub(crate) fn draw_phase(errors: Distribution, rng: &mut ChaCha8Rng) -> f64 {
    /// The greatest number below 1.
    const LAST: f64 = 1.0 - f64::EPSILON / 2.0;
    match errors {
        Distribution::Uniform => rng.random_range(0.0..1.0),
        errors => (0.5 + draw_within(0.5, errors, rng)).clamp(0.0, LAST),
    }
}

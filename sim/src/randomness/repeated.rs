//! Errors that every reading has anew: a stamp's, a delivery's, a column's.

use rand::RngExt;
use rand_chacha::ChaCha8Rng;

use super::draw_within;
use crate::scene::Distribution;

/// Draws of one stream, reading by reading. In a drift they are no draws but what adds up worst, from a side that the seed chooses.
#[derive(Clone, Debug)]
pub struct Repeated {
    errors: Distribution,
    rng: ChaCha8Rng,
    /// 1 or −1; without a meaning unless in a drift.
    side: f64,
    n_alternations: u64,
}

impl Repeated {
    /// Errors of a stream that nothing else draws from.
    pub fn new(errors: Distribution, mut rng: ChaCha8Rng) -> Self {
        // Drawn in a drift alone, so that the draws of other runs are what they were before there were drifts.
        let side = if errors == Distribution::Drift { draw_within(1.0, errors, &mut rng) } else { 1.0 };
        Repeated { errors, rng, side, n_alternations: 0 }
    }

    /// Within ±tolerance; in a drift always at the same end of it.
    pub fn one_way(&mut self, tolerance: f64) -> f64 {
        match self.errors {
            Distribution::Drift => self.side * tolerance,
            errors => draw_within(tolerance, errors, &mut self.rng),
        }
    }

    /// Within ±tolerance; in a drift at one end and at the other in turn, so that what follows each other is as far apart as it can be.
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

/// A share from 0 to 1, the end left out, as even as the uniform draw unless errors are said to be distributed otherwise: where in a tick a
/// wheel stands at the start.
pub(crate) fn draw_phase(errors: Distribution, rng: &mut ChaCha8Rng) -> f64 {
    /// The greatest number below 1.
    const LAST: f64 = 1.0 - f64::EPSILON / 2.0;
    match errors {
        Distribution::Uniform => rng.random_range(0.0..1.0),
        errors => (0.5 + draw_within(0.5, errors, rng)).clamp(0.0, LAST),
    }
}

//! Random draws for random scenes. Every key of a scene has a random stream of its own, so that a key that is added to the schema of scenes does not
//! change the values drawn for other keys.

use rand::{Rng, RngExt};
use rand_chacha::ChaCha8Rng;

use crate::truth::randomness::stream;

/// Source of all random draws of one case.
#[derive(Clone, Copy, Debug)]
pub(super) struct Draws {
    seed: u64,
}

impl Draws {
    /// Creates the source of random draws for case `number` of the search with `seed`. `attempt` counts from 0: a scene that is refused is drawn
    /// again with the next attempt.
    pub(super) fn of(seed: u64, number: u64, attempt: u64) -> Draws {
        Draws { seed: stream(seed, &format!("falsify case {number} attempt {attempt}")).next_u64() }
    }

    /// Returns the random stream that belongs to `name`, such as the path of a key.
    pub(super) fn dice(&self, name: &str) -> Dice {
        Dice(stream(self.seed, name))
    }
}

/// A stream of random draws.
pub(super) struct Dice(ChaCha8Rng);

impl Dice {
    /// Draws true with probability `share`.
    pub(super) fn chance(&mut self, share: f64) -> bool {
        self.0.random::<f64>() < share
    }

    /// Draws a number from `least` to `most`, uniformly.
    pub(super) fn uniform(&mut self, least: f64, most: f64) -> f64 {
        least + (most - least) * self.0.random::<f64>()
    }

    /// Draws a number from `least`, which is positive, to `most`, with every order of magnitude equally likely.
    pub(super) fn log_uniform(&mut self, least: f64, most: f64) -> f64 {
        (self.uniform(least.ln(), most.ln())).exp().clamp(least, most)
    }

    /// Draws a whole number from `least` to `most`, both included.
    pub(super) fn whole(&mut self, least: i64, most: i64) -> i64 {
        if least >= most { least } else { self.0.random_range(least..=most) }
    }

    /// Draws one of `options`, which must not be empty.
    pub(super) fn choose<'a, T>(&mut self, options: &'a [T]) -> &'a T {
        &options[self.0.random_range(0..options.len())]
    }
}

/// Rounds `value` to a number of significant digits, as people read the scenes that a search finds.
pub(super) fn rounded(value: f64, digits: i32) -> f64 {
    if value == 0.0 || !value.is_finite() {
        return value;
    }
    // The value is written as decimal text and parsed again, so that it prints with few digits. Arithmetic such as 0.1 + 0.2, or multiplying by
    // powers of ten, gives numbers with many digits.
    format!("{value:.*e}", (digits - 1).max(0) as usize).parse().unwrap_or(value)
}

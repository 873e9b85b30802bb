//! Random draws by name, so that a key that scenes come to have moves no other draw.

use rand::{Rng, RngExt};
use rand_chacha::ChaCha8Rng;

use crate::randomness::stream;

/// All that one case draws.
#[derive(Clone, Copy, Debug)]
pub(super) struct Draws {
    seed: u64,
}

impl Draws {
    /// What case `number` of the search of `seed` draws at its `attempt`, counted from 0: a scene that is refused is drawn again.
    pub(super) fn of(seed: u64, number: u64, attempt: u64) -> Draws {
        Draws { seed: stream(seed, &format!("falsify case {number} attempt {attempt}")).next_u64() }
    }

    /// The draws that belong to `name`, such as the path of a key.
    pub(super) fn dice(&self, name: &str) -> Dice {
        Dice(stream(self.seed, name))
    }
}

/// A stream of draws.
pub(super) struct Dice(ChaCha8Rng);

impl Dice {
    /// True with probability `share`.
    pub(super) fn chance(&mut self, share: f64) -> bool {
        self.0.random::<f64>() < share
    }

    /// A number from `least` to `most`.
    pub(super) fn uniform(&mut self, least: f64, most: f64) -> f64 {
        least + (most - least) * self.0.random::<f64>()
    }

    /// A number from `least`, which is positive, to `most`, each order of magnitude as likely.
    pub(super) fn log_uniform(&mut self, least: f64, most: f64) -> f64 {
        (self.uniform(least.ln(), most.ln())).exp().clamp(least, most)
    }

    /// A whole number from `least` to `most`.
    pub(super) fn whole(&mut self, least: i64, most: i64) -> i64 {
        if least >= most { least } else { self.0.random_range(least..=most) }
    }

    /// One of `options`, which are not empty.
    pub(super) fn choose<'a, T>(&mut self, options: &'a [T]) -> &'a T {
        &options[self.0.random_range(0..options.len())]
    }
}

/// `value` with so many significant digits: shrunk scenes are read by people.
pub(super) fn rounded(value: f64, digits: i32) -> f64 {
    if value == 0.0 || !value.is_finite() {
        return value;
    }
    // Through decimal text, as 0.1 + 0.2 has no short one and products of powers of ten have none either.
    format!("{value:.*e}", (digits - 1).max(0) as usize).parse().unwrap_or(value)
}

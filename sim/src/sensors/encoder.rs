//! Incremental encoders: whole ticks of each wheel since the start.

use std::f64::consts::TAU;

use crate::{
    drawn::draw_phase,
    randomness::stream,
    scene::{Distribution, Encoders},
    truth::Truth,
};

/// Counters of both wheels.
#[derive(Clone, Debug)]
pub struct Encoder {
    ticks_per_turn: f64,
    /// Where in a tick each wheel stood at the start, `[0, 1)`.
    phase: [f64; 2],
}

impl Encoder {
    /// Encoders whose wheels stand anywhere within a tick at the start, or at its very begin or end where errors are drawn at corners.
    pub fn new(encoders: &Encoders, errors: Distribution, seed: u64) -> Self {
        let mut rng = stream(seed, "encoder.phase");
        let phase = [draw_phase(errors, &mut rng), draw_phase(errors, &mut rng)];
        Encoder { ticks_per_turn: f64::from(encoders.ticks_per_turn), phase }
    }

    /// Cumulative ticks of the left and of the right wheel: `⌊angle/2π·ticks_per_turn + phase⌋`, 0 at the start.
    pub fn latch(&self, truth: &Truth) -> [i64; 2] {
        [0, 1]
            .map(|wheel| (truth.wheel_angle_rad[wheel] / TAU * self.ticks_per_turn + self.phase[wheel]).floor() as i64)
    }
}

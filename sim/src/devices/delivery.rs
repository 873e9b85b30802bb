//! The way of readings from the sensor to the localizer: late, lost or doubled.

use rand::RngExt;
use rand_chacha::ChaCha8Rng;

use crate::{
    randomness::stream,
    scene::{self, Distribution},
};

use super::Observation;

/// The bus that readings of what moves the robot take.
pub struct Delivery {
    keys: scene::Delivery,
    /// By how much stamps are late.
    clock_s: f64,
    errors: Distribution,
    n_late: u64,
    luck: ChaCha8Rng,
}

impl Delivery {
    /// The scene's.
    pub fn new(keys: &scene::Delivery, clock_s: f64, errors: Distribution, seed: u64) -> Self {
        Delivery { keys: keys.clone(), clock_s, errors, n_late: 0, luck: stream(seed, "delivery") }
    }

    /// What becomes of a reading: none of it, one, or two.
    pub fn send(&mut self, mut observation: Observation) -> Vec<Observation> {
        if self.keys.stamp_tolerance_s > 0.0 {
            let taken_s = observation.truth.time_s;
            // The robot stood still before the start, so that what is read first was so at the clock's own 0 as well.
            let stamp_s = if taken_s == 0.0 { self.clock_s.min(0.0) } else { taken_s + self.clock_s };
            observation.reading.stamp_anew(stamp_s);
            // Nothing arrives before its stamp, however late that is.
            observation.reading.delay(self.keys.stamp_tolerance_s);
        }
        if self.keys.is_perfect() {
            return vec![observation];
        }
        // Always as many draws, so that the fate of one reading does not move that of the next.
        let mut draw = || self.luck.random_range(0.0..1.0);
        let (dropped, doubled, lateness): (f64, f64, [f64; 2]) = (draw(), draw(), [draw(), draw()]);
        if dropped < self.keys.dropped_share {
            return Vec::new();
        }
        let n_copies = 1 + usize::from(doubled < self.keys.duplicated_share);
        let late_s = self.keys.late_s;
        lateness.into_iter().take(n_copies).map(|share| late(&observation, self.lateness(share) * late_s)).collect()
    }

    /// How late a reading is, as a share of the most: as drawn, or at an end of what may be; in a drift at one end and the other in turn.
    fn lateness(&mut self, drawn: f64) -> f64 {
        self.n_late += 1;
        match self.errors {
            Distribution::Uniform | Distribution::TruncatedGaussian => drawn,
            Distribution::Corner => drawn.round(),
            Distribution::Drift => (self.n_late % 2) as f64,
        }
    }
}

fn late(observation: &Observation, by_s: f64) -> Observation {
    let mut late = observation.clone();
    late.reading.delay(by_s);
    late
}

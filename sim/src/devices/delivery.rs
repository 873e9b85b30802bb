//! The path of readings from the sensor to the localizer, on which they are delayed, lost or duplicated.

use rand::RngExt;
use rand_chacha::ChaCha8Rng;

use crate::{
    scene::{self, Distribution},
    truth::randomness::stream,
};

use super::Observation;

/// The bus over which the base sends the readings of its motion sensors: wheels, gyroscope, flow sensor and steering encoder.
pub struct Delivery {
    keys: scene::Delivery,
    /// By how much the base's clock, and with it every stamp, is late.
    clock_s: f64,
    errors: Distribution,
    n_late: u64,
    luck: ChaCha8Rng,
}

impl Delivery {
    /// The base's bus for readings, with the settings that the scene states.
    pub fn new(keys: &scene::Delivery, clock_s: f64, errors: Distribution, seed: u64) -> Self {
        Delivery { keys: keys.clone(), clock_s, errors, n_late: 0, luck: stream(seed, "delivery") }
    }

    /// Sends a reading over the bus; what arrives is no reading, one, or two copies.
    pub fn send(&mut self, mut observation: Observation) -> Vec<Observation> {
        if self.keys.stamp_tolerance_s > 0.0 {
            let taken_s = observation.truth.time_s;
            // The robot stands still before the start, so that the first reading is also true at time 0 of the base's clock.
            let stamp_s = if taken_s == 0.0 { self.clock_s.min(0.0) } else { taken_s + self.clock_s };
            observation.reading.stamp_anew(stamp_s);
            // A delay by the tolerance of the stamp ensures that no reading arrives before its stamp, however late the stamp is.
            observation.reading.delay(self.keys.stamp_tolerance_s);
        }
        if self.keys.is_perfect() {
            return vec![observation];
        }
        // The number of draws is the same for every reading, so that the fate of one reading does not change that of the next.
        let mut draw = || self.luck.random_range(0.0..1.0);
        let (dropped, doubled, lateness): (f64, f64, [f64; 2]) = (draw(), draw(), [draw(), draw()]);
        if dropped < self.keys.dropped_share {
            return Vec::new();
        }
        let n_copies = 1 + usize::from(doubled < self.keys.duplicated_share);
        let late_s = self.keys.late_s;
        lateness.into_iter().take(n_copies).map(|share| late(&observation, self.lateness(share) * late_s)).collect()
    }

    /// Delay of a reading as a share of the greatest delay: the value drawn at random or, with the error distribution `corner`, this value rounded to
    /// 0 or 1; with `drift` 0 and 1 in turn.
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

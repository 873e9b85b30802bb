//! The gyroscope's bias as anybody takes it who has a robot that stops: the mean rate while it stands.

use std::collections::VecDeque;

use crate::robot::GyroModel;

/// The encoders have counted nothing for so long before a robot counts as standing: springs and tyres have come to rest by then.
const STANDS_S: f64 = 0.3;
/// The latest rates are held back for so long: a robot that starts turns before its encoders count.
const HELD_BACK_S: f64 = 0.1;
/// Older standing is forgotten. A mean over longer follows a bias that wanders worse than it averages noise: with an angle random walk of
/// 0.15°/√h and a bias instability of 2°/h the Allan deviation is least near (0.15 / (0.664·2))² h, about 45 s.
const REMEMBERED_S: f64 = 45.0;

/// A running mean of the rate at rest.
///
/// Source of the mean: B. Welford, "Note on a method for calculating corrected sums of squares and products", Technometrics 4 (1962); of
/// using rest for it: I. Skog et al., "Zero-velocity detection", IEEE Transactions on Biomedical Engineering 57 (2010).
#[derive(Clone, Debug)]
pub struct GyroAtRest {
    model: GyroModel,
    bias_rad_per_s: f64,
    /// Rates that the mean is of.
    n_rates: f64,
    /// Time since the encoders last counted or the robot was turned.
    still_s: f64,
    held_back: VecDeque<f64>,
}

impl GyroAtRest {
    /// Knows the nominal bias until the robot has stood.
    pub fn new(model: GyroModel) -> Self {
        let bias_rad_per_s = model.bias_rad_per_s.mid();
        GyroAtRest { model, bias_rad_per_s, n_rates: 0.0, still_s: 0.0, held_back: VecDeque::new() }
    }

    /// The best guess of the bias.
    pub fn bias_rad_per_s(&self) -> f64 {
        self.bias_rad_per_s
    }

    /// Takes in a rate. One that bias and noise cannot explain is of a robot that somebody turns on its standing wheels.
    pub fn rate(&mut self, rate_rad_per_s: f64) {
        self.still_s += self.model.period_s;
        let bias = self.model.bias_rad_per_s;
        if !bias.inflate(self.model.noise_rad_per_s).contains(rate_rad_per_s) {
            self.moved();
        } else if self.still_s > STANDS_S {
            self.held_back.push_back(rate_rad_per_s);
        }
        while self.held_back.len() as f64 * self.model.period_s > HELD_BACK_S {
            let Some(rate_rad_per_s) = self.held_back.pop_front() else { break };
            self.n_rates = (self.n_rates + 1.0).min(REMEMBERED_S / self.model.period_s);
            // Before the first rest the mean is of nothing, and the first rate replaces it.
            self.bias_rad_per_s += (rate_rad_per_s - self.bias_rad_per_s) / self.n_rates.max(1.0);
        }
    }

    /// The encoders counted.
    pub fn moved(&mut self) {
        self.still_s = 0.0;
        self.held_back.clear();
    }
}

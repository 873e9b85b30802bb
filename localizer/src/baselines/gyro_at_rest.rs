//! The gyroscope's bias as anybody would estimate it whose robot stops now and then: the mean rate while the robot stands.

use std::collections::VecDeque;

use crate::robot::GyroModel;

/// Time without encoder counts after which a robot counts as standing: springs and tyres have come to rest by then.
const STANDS_S: f64 = 0.3;
/// Time for which the latest rates are held back from the mean, because a robot that starts turns before its encoders count.
const HELD_BACK_S: f64 = 0.1;
/// Time at rest that the mean remembers. A mean over a longer time follows a wandering bias worse than it averages noise: with an angle random
/// walk of 0.15°/√h and a bias instability of 2°/h the Allan deviation is least near (0.15 / (0.664·2))² h, about 45 s.
const REMEMBERED_S: f64 = 45.0;

/// A running mean of the gyroscope's rate while the robot is at rest.
///
/// Source of the mean: B. Welford, "Note on a method for calculating corrected sums of squares and products", Technometrics 4 (1962). Source of
/// using rest for it: I. Skog et al., "Zero-velocity detection", IEEE Transactions on Biomedical Engineering 57 (2010).
#[derive(Clone, Debug)]
pub struct GyroAtRest {
    model: GyroModel,
    bias_rad_per_s: f64,
    /// Number of gyroscope rates that the running mean consists of.
    n_rates: f64,
    /// Time since the encoders last counted or the robot was turned.
    still_s: f64,
    held_back: VecDeque<f64>,
}

impl GyroAtRest {
    /// A bias estimate that is the nominal bias until the robot has stood still.
    pub fn new(model: GyroModel) -> Self {
        let bias_rad_per_s = model.bias_rad_per_s.mid();
        GyroAtRest { model, bias_rad_per_s, n_rates: 0.0, still_s: 0.0, held_back: VecDeque::new() }
    }

    /// The best estimate of the gyroscope's bias.
    pub fn bias_rad_per_s(&self) -> f64 {
        self.bias_rad_per_s
    }

    /// Adds a rate of the gyroscope. A rate that bias and noise cannot explain means that somebody turns the robot on its standing wheels.
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
            // Before the first rest the mean contains no rate, and the first rate replaces the nominal bias.
            self.bias_rad_per_s += (rate_rad_per_s - self.bias_rad_per_s) / self.n_rates.max(1.0);
        }
    }

    /// Notes that the encoders counted, so that the robot does not stand still.
    pub fn moved(&mut self) {
        self.still_s = 0.0;
        self.held_back.clear();
    }
}

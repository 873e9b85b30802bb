//! The wandering bias of a gyroscope: flicker and random walk, cut to the declared bounds.

use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution as _, StandardNormal};

use crate::{
    scene::{Distribution, Gyro},
    truth::randomness::draw_within,
};

/// Time between two drawn values (nodes) of the gyroscope's bias, which changes linearly from one to the next.
const NODE_S: f64 = 1.0;

/// Correlation times of the processes whose sum is the flicker noise, each four times the one before: from 1 s to over an hour.
const FLICKER_S: [f64; 7] = [1.0, 4.0, 16.0, 64.0, 256.0, 1024.0, 4096.0];

/// Seconds in an hour, for quantities that data sheets state per hour.
const HOUR_S: f64 = 3600.0;

/// A gyroscope's bias over time.
#[derive(Clone, Debug)]
pub struct WanderingBias {
    rng: ChaCha8Rng,
    errors: Distribution,
    /// Side to which the bias moves with the error distribution `drift`: 1 or −1. It turns back at the ends of its range.
    side: f64,
    drawn_rad_per_s: f64,
    /// Range that the bias never leaves: its tolerance and, where the bound `gyro.angle` on the sum of errors is declared, the bias drawn for time 0
    /// plus or minus the rate of that bound. A bias that stayed farther away for long enough would exceed `gyro.angle` without any noise.
    within_rad_per_s: [f64; 2],
    wander_rad_per_s2: f64,
    walk_per_node_rad_per_s: f64,
    flicker_deviation_rad_per_s: f64,
    walk_rad_per_s: f64,
    flicker_rad_per_s: [f64; FLICKER_S.len()],
    n_nodes: u64,
    /// Values of the bias at the drawn instants (nodes) before and after the latest time.
    around_rad_per_s: [f64; 2],
}

impl WanderingBias {
    /// A bias that has the value `drawn_rad_per_s` at time 0.
    pub fn new(gyro: &Gyro, drawn_rad_per_s: f64, errors: Distribution, mut rng: ChaCha8Rng) -> Self {
        let instability_rad_per_s = gyro.bias_instability_deg_per_h.to_radians() / HOUR_S;
        let walk_rad_per_s_per_sqrt_s =
            gyro.rate_random_walk_deg_per_h_per_sqrt_h.to_radians() / (HOUR_S * HOUR_S.sqrt());
        // B is the bias instability. IEEE Std 952 eq. (C.11) gives the two-sided spectrum S(f) = B²/(2πf) of flicker noise. Processes of variance s²
        // whose correlation times τ are spread evenly over ln τ, one per ln 4, have ∫ 2s²τ/(1 + (2πfτ)²) d ln τ/ln 4 = s²/(2·ln 4·f), so that s² =
        // B²·ln 4/π.
        let flicker_deviation_rad_per_s = instability_rad_per_s * (4.0_f64.ln() / std::f64::consts::PI).sqrt();
        let flicker_rad_per_s = [0; FLICKER_S.len()].map(|_| flicker_deviation_rad_per_s * normal(&mut rng));
        WanderingBias {
            rng,
            errors,
            side: -drawn_rad_per_s.signum(),
            drawn_rad_per_s,
            within_rad_per_s: within_rad_per_s(gyro, drawn_rad_per_s),
            wander_rad_per_s2: gyro.bias_wander_deg_per_s2.to_radians(),
            walk_per_node_rad_per_s: walk_rad_per_s_per_sqrt_s * NODE_S.sqrt(),
            flicker_deviation_rad_per_s,
            walk_rad_per_s: 0.0,
            // The initial value of the flicker is part of the drawn bias.
            flicker_rad_per_s,
            n_nodes: 0,
            around_rad_per_s: [drawn_rad_per_s; 2],
        }
        .beginning()
    }

    /// The gyroscope's bias at a time that is not earlier than the time of the call before.
    pub fn at(&mut self, time_s: f64) -> f64 {
        while time_s > self.n_nodes as f64 * NODE_S {
            self.next_node();
        }
        let share = time_s / NODE_S - (self.n_nodes as f64 - 1.0);
        self.around_rad_per_s[0] + share * (self.around_rad_per_s[1] - self.around_rad_per_s[0])
    }

    fn beginning(mut self) -> Self {
        self.drawn_rad_per_s -= self.flicker_rad_per_s.iter().sum::<f64>();
        self
    }

    fn next_node(&mut self) {
        self.n_nodes += 1;
        self.walk_rad_per_s += self.walk_per_node_rad_per_s * normal(&mut self.rng);
        for (flicker, correlation_s) in self.flicker_rad_per_s.iter_mut().zip(FLICKER_S) {
            // Each part of the flicker noise is an Ornstein–Uhlenbeck process, exact at the instants (nodes) at which it is drawn.
            let kept = (-NODE_S / correlation_s).exp();
            let fresh = self.flicker_deviation_rad_per_s * (1.0 - kept * kept).sqrt();
            *flicker = kept * *flicker + fresh * normal(&mut self.rng);
        }
        let before = self.around_rad_per_s[1];
        if let Distribution::Corner | Distribution::Drift = self.errors {
            self.around_rad_per_s = [before, self.farthest_from(before)];
            return;
        }
        let wanted = self.drawn_rad_per_s + self.walk_rad_per_s + self.flicker_rad_per_s.iter().sum::<f64>();
        let step = (wanted - before).clamp(-self.wander_rad_per_s2 * NODE_S, self.wander_rad_per_s2 * NODE_S);
        let [least, greatest] = self.within_rad_per_s;
        let after = (before + step).clamp(least, greatest);
        self.around_rad_per_s = [before, after];
    }
}

/// Range of the gyroscope's bias: |bias| ≤ tolerance, and the bias differs from the one drawn for time 0 by at most the rate of the bound
/// `gyro.angle`. Within this range the difference adds up to at most rate·T over any time span T, so that noise of 0 is always allowed.
fn within_rad_per_s(gyro: &Gyro, drawn_rad_per_s: f64) -> [f64; 2] {
    let tolerance_rad_per_s = gyro.bias_tolerance_deg_per_s.to_radians();
    let departs_rad_per_s = gyro.angle_floor_deg.map_or(f64::INFINITY, |_| gyro.angle_deg_per_s.to_radians());
    // The rate of the bound `gyro.angle` is reduced slightly, so that rounded sums of many readings keep to the bound.
    let departs_rad_per_s = departs_rad_per_s * (1.0 - 1e-9);
    // The drawn bias is within both limits of the bias's range, whatever the rounding.
    [
        (drawn_rad_per_s - departs_rad_per_s).max(-tolerance_rad_per_s).min(drawn_rad_per_s),
        (drawn_rad_per_s + departs_rad_per_s).min(tolerance_rad_per_s).max(drawn_rad_per_s),
    ]
}

impl WanderingBias {
    /// Farthest value that the bias may reach from one of its drawn instants (nodes) to the next: with the error distribution `corner` to a side
    /// drawn anew, with `drift` to the same side until the end of its range.
    fn farthest_from(&mut self, before_rad_per_s: f64) -> f64 {
        let step_rad_per_s = self.wander_rad_per_s2 * NODE_S;
        if self.errors == Distribution::Corner {
            self.side = draw_within(1.0, self.errors, &mut self.rng);
        }
        let [least, greatest] = self.within_rad_per_s;
        let wanted = before_rad_per_s + self.side * step_rad_per_s;
        if wanted <= least || wanted >= greatest {
            self.side = -self.side;
        }
        wanted.clamp(least, greatest)
    }
}

fn normal(rng: &mut ChaCha8Rng) -> f64 {
    StandardNormal.sample(rng)
}

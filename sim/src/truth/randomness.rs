//! Random draws: one named random stream per sensor and subsystem, so that a change to one never changes the draws of another, and functions that
//! draw errors within their tolerances.

mod repeated;

use rand::{Rng, RngExt};
use rand_chacha::{ChaCha8Rng, rand_core::SeedableRng};
use rand_distr::{Distribution as _, StandardNormal};
use sha2::{Digest, Sha256};

use crate::scene::Distribution;

pub use repeated::Repeated;
pub(crate) use repeated::draw_phase;

/// The random stream that belongs to this name in the run with this seed.
pub fn stream(seed: u64, name: &str) -> ChaCha8Rng {
    let digest = Sha256::digest(name.as_bytes());
    let mut number = [0_u8; 8];
    number.copy_from_slice(&digest[..8]);
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    rng.set_stream(u64::from_le_bytes(number));
    rng
}

/// Draws an error within ±tolerance that stays the same during the whole run.
pub fn draw_within(tolerance: f64, distribution: Distribution, rng: &mut impl Rng) -> f64 {
    match distribution {
        Distribution::Uniform => tolerance * rng.random_range(-1.0..=1.0),
        Distribution::TruncatedGaussian => loop {
            // The standard deviation of the normal distribution is half the tolerance; one draw in 22 falls outside the tolerance and is repeated.
            let deviations: f64 = StandardNormal.sample(rng);
            if deviations.abs() <= 2.0 {
                return tolerance * deviations / 2.0;
            }
        },
        Distribution::Corner | Distribution::Drift => {
            if rng.random() {
                tolerance
            } else {
                -tolerance
            }
        }
    }
}

/// Draws at random the tilt of an axis, as a rotation vector about x and y. The tolerance bounds the angle of the tilt, so that an angle and a
/// direction are drawn.
pub fn draw_tilt(tolerance_deg: f64, errors: Distribution, rng: &mut ChaCha8Rng) -> [f64; 2] {
    let tilt_rad = draw_within(tolerance_deg.to_radians(), errors, rng);
    let direction_rad = draw_within(std::f64::consts::FRAC_PI_2, Distribution::Uniform, rng);
    let (sin, cos) = direction_rad.sin_cos();
    [tilt_rad * cos, tilt_rad * sin]
}

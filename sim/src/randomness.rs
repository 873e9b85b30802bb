//! One named random stream per sensor and subsystem, so that a change to one never moves the draws of another.

use rand_chacha::{ChaCha8Rng, rand_core::SeedableRng};
use sha2::{Digest, Sha256};

/// The stream of `name` in the run of `seed`.
pub fn stream(seed: u64, name: &str) -> ChaCha8Rng {
    let digest = Sha256::digest(name.as_bytes());
    let mut number = [0_u8; 8];
    number.copy_from_slice(&digest[..8]);
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    rng.set_stream(u64::from_le_bytes(number));
    rng
}

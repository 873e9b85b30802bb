//! Attempts to make the rigid-motion contractors lose the truth: random landmarks and poses, errors at the corners of their boxes half of the
//! time, radii from millimetres to decimetres, all headings.
//!
//! The environment variable `WHEREIN_RIGID_TRIALS` sets the number of problems; the experiments set it to 10⁸.

use interval::{Interval, IntervalBox, contractor::Contractor};
use localizer::rigid_motion::{LinearPose, RigidPlanar};

fn n_trials() -> u64 {
    std::env::var("WHEREIN_RIGID_TRIALS").ok().and_then(|text| text.parse().ok()).unwrap_or(100_000)
}

/// The random number generator SplitMix64.
struct Random(u64);

impl Random {
    fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut mixed = self.0;
        mixed = (mixed ^ (mixed >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        mixed = (mixed ^ (mixed >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        mixed ^ (mixed >> 31)
    }

    /// A random number in [−1, 1].
    fn signed(&mut self) -> f64 {
        (self.bits() >> 11) as f64 / (1u64 << 52) as f64 - 1.0
    }

    /// A random error as a share of its bound: −1 or 1 half of the time.
    fn error(&mut self) -> f64 {
        match self.bits() % 4 {
            0 => -1.0,
            1 => 1.0,
            _ => self.signed(),
        }
    }

    /// An interval of the given radius around a value with a random error, wider by the rounding of the value itself.
    fn measured(&mut self, value: f64, radius: f64) -> Interval {
        Interval::centred(value + radius * self.error(), radius).inflate(1e-14 * (1.0 + value.abs()))
    }
}

#[test]
fn rigid_contractors_never_lose_the_truth() {
    let mut random = Random(3);
    let (mut n_ambiguous, mut n_decided) = (0u64, 0u64);
    for trial in 0..n_trials() {
        let n_landmarks = 1 + (random.bits() % 7) as usize;
        let radius = [0.1, 0.01, 0.001][(random.bits() % 3) as usize];
        let truth = [3.0 * random.signed(), 3.0 * random.signed(), 7.0 * random.signed()];
        let [x, y, heading] = truth;
        let landmarks: Vec<_> = (0..n_landmarks)
            .map(|_| {
                let (a_x, a_y) = (5.0 * random.signed(), 5.0 * random.signed());
                let (across, along) = (a_x - x, a_y - y);
                let b_x = heading.cos() * across + heading.sin() * along;
                let b_y = heading.cos() * along - heading.sin() * across;
                (
                    [random.measured(a_x, radius), random.measured(a_y, radius)],
                    [random.measured(b_x, radius), random.measured(b_y, radius)],
                )
            })
            .collect();
        let prior_radius = [[3.0, 3.0, 3.2], [0.3, 0.3, 0.2], [0.02, 0.02, 0.01]][(random.bits() % 3) as usize];
        let prior = IntervalBox::new(std::array::from_fn(|axis| random.measured(truth[axis], prior_radius[axis])));
        let motion = RigidPlanar::new(&landmarks);
        if trial % 10_000_000 == 9_999_999 {
            println!("rigid contractors: {} problems so far", trial + 1);
        }
        let mut domain = prior;
        for _ in 0..2 {
            motion.contract(&mut domain);
            assert!(domain.contains(&truth), "trial {trial}: pass lost {truth:?}, left {domain:?} of {prior:?}");
        }
        // The solver that divides the heading into slices repeats the same computation for each slice and costs the most, so that slices are tested
        // on every eighth problem only.
        for n_slices in if trial % 8 == 0 { [0, 3].as_slice() } else { &[0] } {
            let n_slices = *n_slices;
            let branches = LinearPose { motion: motion.clone(), n_slices }.branches(&prior);
            assert!(
                branches.iter().any(|branch| branch.contains(&truth)),
                "trial {trial}: one shot with {n_slices} slices lost {truth:?}, left {branches:?} of {prior:?}"
            );
            assert!(branches.iter().all(|branch| branch.is_subset_of(&prior)));
            if branches.len() > 1 {
                n_ambiguous += 1;
            } else {
                n_decided += 1;
            }
        }
    }
    println!(
        "rigid contractors: 0 of {} truths lost, {n_decided} answers of one branch, {n_ambiguous} unions",
        n_trials()
    );
    assert!(n_ambiguous > 0 && n_decided > n_ambiguous);
}

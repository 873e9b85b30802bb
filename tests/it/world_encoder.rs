//! Simulated wheel encoders against the definition of a tick.

use std::f64::consts::TAU;

use sim::{
    devices::encoders::Encoder,
    scene::{Distribution, Encoders},
    truth::Truth,
};

#[test]
fn ticks_are_the_floor_of_the_turned_angle() {
    let encoders = Encoders { ticks_per_turn: 1000, period_s: 0.01 };
    for seed in 0..20 {
        let encoder = Encoder::new(&encoders, Distribution::Uniform, seed);
        let ticks_at =
            |turns: f64| encoder.latch(&Truth { wheel_angle_rad: [turns * TAU, -turns * TAU], ..Truth::default() });
        assert_eq!(ticks_at(0.0), [0, 0]);
        // Each wheel starts at some place within a tick, and has counted exactly a turn's ticks one turn later.
        for tenth in -50..50 {
            let turns = f64::from(tenth) * 0.00013;
            let [left, right] = ticks_at(turns);
            assert!((left as f64 - turns * 1000.0).abs() < 1.0 && (right as f64 + turns * 1000.0).abs() < 1.0);
            assert_eq!(ticks_at(turns + 3.0), [left + 3000, right - 3000]);
        }
        let steps: Vec<i64> = (0..1000).map(|share| ticks_at(f64::from(share) * 1e-6)[0]).collect();
        let counted_at = steps.iter().position(|ticks| *ticks == 1).expect("a tick within a thousandth of a turn");
        assert!(
            steps[..counted_at].iter().all(|ticks| *ticks == 0) && steps[counted_at..].iter().all(|ticks| *ticks == 1)
        );
    }
}

#[test]
fn each_wheel_and_each_seed_starts_elsewhere_within_a_tick() {
    let encoders = Encoders { ticks_per_turn: 1000, period_s: 0.01 };
    let half_tick = Truth { wheel_angle_rad: [0.0005 * TAU; 2], ..Truth::default() };
    let counts: Vec<[i64; 2]> =
        (0..40).map(|seed| Encoder::new(&encoders, Distribution::Uniform, seed).latch(&half_tick)).collect();
    for pattern in [[0, 0], [0, 1], [1, 0], [1, 1]] {
        assert!(counts.contains(&pattern), "no seed of forty counts {pattern:?} in half a tick");
    }
}

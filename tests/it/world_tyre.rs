//! The simulated tyre's law against the brush model's own integral and closed form.

use sim::world::tyre::{Contact, Patch, Tyre};

const LOAD_N: f64 = 37.5;
const ROLLING_M_PER_S: f64 = 0.4;

/// Force of a tyre's contact patch that slips steadily for 3 s, long after its bristles have relaxed.
fn steady_force_n(slip: [f64; 2], friction: f64) -> [f64; 2] {
    let tyre = Tyre::default();
    let mut patch = Patch::default();
    let velocity_m_per_s = [ROLLING_M_PER_S * (1.0 - slip[0]), -ROLLING_M_PER_S * slip[1]];
    let contact = Contact { velocity_m_per_s, load_n: LOAD_N, friction, ..Contact::default() };
    (0..12_000).for_each(|_| patch.advance(&tyre, &contact, ROLLING_M_PER_S, 0.00025));
    patch.force_n(&tyre, &contact)
}

#[test]
fn steady_force_is_the_closed_form_of_the_combined_slip_brush() {
    for friction in [0.05, 0.8] {
        let full_slip = 3.0 * friction / Tyre::default().slip_stiffness;
        for share in [0.01, 0.3, 0.7, 0.99, 1.5, 6.0] {
            for direction_rad in [0.0_f64, 0.7, 1.571, 2.5, -2.0] {
                let slip = [share * full_slip * direction_rad.cos(), share * full_slip * direction_rad.sin()];
                let force_n = steady_force_n(slip, friction);
                // The force along the slip is F = μN·(1 − λ³), with λ the share of the patch that still grips.
                let gripping: f64 = (1.0 - share).max(0.0);
                let expected_n = friction * LOAD_N * (1.0 - gripping.powi(3));
                for (component_n, along) in force_n.into_iter().zip([direction_rad.cos(), direction_rad.sin()]) {
                    let off_n = (component_n - expected_n * along).abs();
                    assert!(off_n <= 1e-9 * friction * LOAD_N, "slip {slip:?}, friction {friction}: off by {off_n} N");
                }
            }
        }
    }
}

#[test]
fn steady_force_is_the_integral_of_bristles_under_parabolic_pressure() {
    let (friction, length_m) = (0.8, 0.03);
    let half_m = 0.5 * length_m;
    // The bristle stiffness c per length follows from the slope of the force curve at zero slip, C = 2·c·a².
    let bristle_n_per_m2 = Tyre::default().slip_stiffness * LOAD_N / (2.0 * half_m * half_m);
    let pressure_n_per_m = |x_m: f64| 0.75 * LOAD_N / half_m * (1.0 - ((x_m - half_m) / half_m).powi(2));
    // Simpson's rule is exact for the polynomials of this integral.
    let simpson =
        |f: &dyn Fn(f64) -> f64, from: f64, to: f64| (to - from) / 6.0 * (f(from) + 4.0 * f(0.5 * (from + to)) + f(to));
    for slip in [0.002, 0.02, 0.05, 0.09] {
        let held = |x_m: f64| bristle_n_per_m2 * slip * x_m;
        let sliding = |x_m: f64| friction * pressure_n_per_m(x_m);
        // A bristle at x starts to slide where its shear force c·σ·x reaches the friction μ·q(x) under the pressure q.
        let lets_go_m = length_m - 4.0 * half_m.powi(3) * bristle_n_per_m2 * slip / (3.0 * friction * LOAD_N);
        let expected_n = simpson(&held, 0.0, lets_go_m) + simpson(&sliding, lets_go_m, length_m);
        let force_n = steady_force_n([slip, 0.0], friction)[0];
        assert!(
            (force_n - expected_n).abs() < 1e-9 * friction * LOAD_N,
            "slip {slip}: {force_n} N, integral {expected_n} N"
        );
    }
}

#[test]
fn a_deflection_relaxes_within_the_relaxation_length() {
    let tyre = Tyre::default();
    let mut patch = Patch::default();
    let sideways = Contact { velocity_m_per_s: [0.0, 0.1], load_n: LOAD_N, friction: 0.8, ..Contact::default() };
    (0..40).for_each(|_| patch.advance(&tyre, &sideways, 0.0, 0.00025));
    let before_m = patch.deflection_m()[1];
    assert!((before_m + 0.001).abs() < 1e-12, "a wheel that stands holds the whole displacement, not {before_m} m");
    // The wheel rolls 20 mm, one relaxation length.
    let onward = Contact { velocity_m_per_s: [ROLLING_M_PER_S, 0.0], ..sideways };
    (0..200).for_each(|_| patch.advance(&tyre, &onward, ROLLING_M_PER_S, 0.00025));
    let left = patch.deflection_m()[1] / before_m;
    assert!((left - (-1.0_f64).exp()).abs() < 0.002, "{left} of the deflection is left after one relaxation length");
}

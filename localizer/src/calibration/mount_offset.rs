//! Position of a sensor on a robot, from the sensor's positions and the robot's headings while the robot spins on the spot.
//!
//! The paper fits a circle to the positions, which gives the sensor's distance from the robot's axis and not its direction (erratum I8 of paper 5).
//! With the headings the problem is linear in centre and mount position m: as complex numbers position = centre + e^{iθ}·m, so that m = Σ c̄ d / Σ
//! |c|² with c and d the deviations of e^{iθ} and of the position from their means over a spin.

use std::f64::consts::TAU;

/// Sample of a spin: world x and y of the sensor, and the heading of the robot at that moment.
pub type Stop = [f64; 3];

/// Least spread of headings, as mean |c|², for which the offset is solved: a tenth of the spread over a whole turn.
const LEAST_SPREAD: f64 = 0.1;

/// Offset of a sensor from the robot origin.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MountOffset {
    /// Position of the sensor in the robot frame: forward and left.
    pub position_m: [f64; 2],
    /// Root mean square distance between the measured positions and those that the offset predicts.
    pub rms_m: f64,
}

impl MountOffset {
    /// Distance of the sensor from the robot origin.
    pub fn radius_m(&self) -> f64 {
        self.position_m[0].hypot(self.position_m[1])
    }

    /// Direction of the sensor from robot forward, counter-clockwise, in [0, 2π).
    pub fn direction_rad(&self) -> f64 {
        self.position_m[1].atan2(self.position_m[0]).rem_euclid(TAU)
    }
}

/// The sensor's offset from one or more spins on the spot, each around a point of its own; `None` if the headings hardly differ.
pub fn solve(spins: &[Vec<Stop>]) -> Option<MountOffset> {
    let deviations: Vec<[f64; 4]> = spins.iter().flat_map(|spin| deviations(spin)).collect();
    let spread: f64 = deviations.iter().map(|[c, s, _, _]| c * c + s * s).sum();
    if deviations.is_empty() || spread < LEAST_SPREAD * deviations.len() as f64 {
        return None;
    }
    let position_m = [
        deviations.iter().map(|[c, s, x, y]| c * x + s * y).sum::<f64>() / spread,
        deviations.iter().map(|[c, s, x, y]| c * y - s * x).sum::<f64>() / spread,
    ];
    let [forward, left] = position_m;
    let squares = deviations
        .iter()
        .map(|[c, s, x, y]| (x - (c * forward - s * left)).powi(2) + (y - (s * forward + c * left)).powi(2));
    let rms_m = (squares.sum::<f64>() / deviations.len() as f64).sqrt();
    Some(MountOffset { position_m, rms_m })
}

/// cos θ, sin θ, x, y of each stop of a spin, less their means over the spin.
fn deviations(spin: &[Stop]) -> Vec<[f64; 4]> {
    let rows: Vec<[f64; 4]> = spin.iter().map(|[x, y, heading]| [heading.cos(), heading.sin(), *x, *y]).collect();
    let mean: [f64; 4] = std::array::from_fn(|k| rows.iter().map(|row| row[k]).sum::<f64>() / rows.len().max(1) as f64);
    rows.into_iter().map(|row| std::array::from_fn(|k| row[k] - mean[k])).collect()
}

#[cfg(test)]
#[allow(clippy::expect_used)]
mod tests {
    use super::*;
    use crate::vision::synthetic::Random;

    fn spins(offset: [f64; 2], n_stops: usize, noise_m: f64, noise_rad: f64, random: &mut Random) -> Vec<Vec<Stop>> {
        (0..5)
            .map(|_| {
                let centre = [random.between(-0.01, 0.01) + 3.0, random.between(-0.01, 0.01) - 2.0];
                let start = random.between(0.0, TAU);
                let stop = |step: usize, random: &mut Random| {
                    let heading = start + TAU * step as f64 / n_stops as f64;
                    let (sin, cos) = heading.sin_cos();
                    [
                        centre[0] + cos * offset[0] - sin * offset[1] + random.between(-noise_m, noise_m),
                        centre[1] + sin * offset[0] + cos * offset[1] + random.between(-noise_m, noise_m),
                        heading + random.between(-noise_rad, noise_rad),
                    ]
                };
                (0..n_stops).map(|step| stop(step, random)).collect()
            })
            .collect()
    }

    #[test]
    fn five_noisy_spins_give_radius_to_half_a_millimetre_and_direction_to_a_fifth_of_a_degree() {
        let mut random = Random::new(17);
        for _ in 0..300 {
            let (radius, direction) = (random.between(0.15, 0.4), random.between(0.0, TAU));
            let offset = [radius * direction.cos(), radius * direction.sin()];
            // Each position in the spin has the errors of a marker fix at 2.6 m distance: 3 mm and 0.2°.
            let found = solve(&spins(offset, 72, 0.003, 0.0035, &mut random)).expect("headings all around");
            assert!((found.radius_m() - radius).abs() < 0.0005, "{found:?} {offset:?}");
            let turn = (found.direction_rad() - direction + 3.0 * TAU / 2.0).rem_euclid(TAU) - TAU / 2.0;
            assert!(turn.abs() < 0.2f64.to_radians(), "{found:?} {offset:?}");
        }
    }

    #[test]
    fn a_sensor_at_the_back_is_found_at_the_back() {
        // Computed by hand: on a robot that spins about (1, 2), a sensor 0.2 m behind and 0.1 m left is at (0.8, 2.1) at heading 0, at (0.9, 1.8)
        // at 90°.
        let quarter = TAU / 4.0;
        let found =
            solve(&[vec![[0.8, 2.1, 0.0], [0.9, 1.8, quarter], [1.2, 1.9, 2.0 * quarter]]]).expect("half a turn");
        assert!((found.position_m[0] + 0.2).abs() < 1e-12 && (found.position_m[1] - 0.1).abs() < 1e-12, "{found:?}");
        assert!(found.rms_m < 1e-12);
    }

    #[test]
    fn a_robot_that_hardly_turns_tells_nothing() {
        assert_eq!(solve(&[vec![[0.0, 0.0, 0.0], [0.001, 0.0, 0.1], [0.0, 0.001, 0.2]]]), None);
        assert_eq!(solve(&[]), None);
    }
}

//! The data: a vehicle that drives straight ahead and looks at five landmarks whose depth it does not know, as a seed draws it.
//!
//! World and vehicle frames: x forward, y left, z up; both coincide at the start. The camera is at the vehicle's origin and looks ahead, level.
//! Pixels (u, v) are relative to the principal point, u to the right and v down.

use interval::Interval;
use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;

/// Focal length of the paper's camera, in both directions.
pub(crate) const FOCAL_PX: f64 = 320.0;
/// Bound of a pixel's error, as in the paper.
pub(crate) const PIXEL_ERROR_PX: f64 = 1.0;
/// Speed of the paper's vehicle.
const SPEED_M_PER_S: f64 = 0.1;
/// Nearest that a landmark may be to the start, measured along the vehicle's axis: our assumption, because the paper has none. Any value below the
/// landmarks' depths will do; after a few steps the pictures tell more.
pub(crate) const LEAST_DEPTH_M: f64 = 0.1;
/// Where the landmarks are. The paper does not say. We have placed four of them 2.2 to 2.7 m ahead, to both sides, above and below the camera, so
/// that the mean widths in x, y and z have about the paper's ratio. The fifth is almost on the axis, where driving ahead tells little of its depth:
/// the paper has five landmarks of which four converge.
pub(crate) const LANDMARKS_M: [[f64; 3]; 5] =
    [[2.2, 0.9, 0.3], [2.4, -1.0, -0.25], [2.7, 1.2, -0.35], [2.5, -1.05, 0.4], [4.0, 0.06, 0.03]];
/// How many of the landmarks, from the first, the paper's means are over.
pub(crate) const N_CONVERGING: usize = 4;

/// What the paper leaves open and the result depends on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Settings {
    /// Number of steps of the drive; one more picture than that.
    pub(crate) n_steps: usize,
    /// Duration of a step.
    pub(crate) step_s: f64,
    /// Bound of the odometer's error of the distance driven in a step, as a share of that distance.
    pub(crate) distance_error: f64,
    /// Bound of the error of the turn in a step.
    pub(crate) turn_error_rad: f64,
}

impl Settings {
    /// The settings whose results are on the book's page of the papers. The odometer's scale is known to 0.2 % and its gyroscope's bias to 0.03°/s
    /// (10⁻⁴ rad in 0.2 s). The drive is so long that LIC's mean widths are like those in the paper; seeds 100 to 102 were used for that, and no
    /// others.
    pub(crate) const OURS: Settings =
        Settings { n_steps: 60, step_s: 0.2, distance_error: 0.002, turn_error_rad: 1e-4 };

    /// Distance driven in a step.
    pub(crate) fn step_m(&self) -> f64 {
        SPEED_M_PER_S * self.step_s
    }
}

/// What is known of the motion in one step. Between two pictures the speed and the rate of turn are constant, as the vehicle's are.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Step {
    /// Length of the arc.
    pub(crate) distance_m: Interval,
    /// Change of the heading.
    pub(crate) turn_rad: Interval,
}

/// A drive's data. True values are kept aside, for checks.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Drive {
    pub(crate) steps: Vec<Step>,
    /// For each picture, the first being taken at the start, and each landmark: the intervals of its u and v.
    pub(crate) pixels: Vec<[[Interval; 2]; LANDMARKS_M.len()]>,
    pub(crate) truth: Motion,
}

/// A drive and landmarks without errors: the true ones, or others that agree with the same data.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Motion {
    /// Distance and turn of each step.
    pub(crate) steps: Vec<[f64; 2]>,
    pub(crate) landmarks: [Ray; LANDMARKS_M.len()],
}

/// A landmark by the ray on which it is seen from the start: the point (1, a, b)/ρ. At ρ = 0 it is infinitely far away.
pub(crate) type Ray = [f64; 3];

impl Drive {
    /// The drive of a seed. Errors are uniform within their bounds.
    pub(crate) fn new(settings: &Settings, seed: u64) -> Drive {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let mut known = |value: f64, bound: f64| Interval::centred(value + random.random_range(-bound..=bound), bound);
        let landmarks = LANDMARKS_M.map(|[x, y, z]| [1.0 / x, y / x, z / x]).map(|[rho, a, b]| [a, b, rho]);
        let truth = Motion { steps: vec![[settings.step_m(), 0.0]; settings.n_steps], landmarks };
        let distance_error_m = settings.distance_error * settings.step_m();
        let steps = truth.steps.iter().map(|&[distance_m, turn_rad]| Step {
            distance_m: known(distance_m, distance_error_m),
            turn_rad: known(turn_rad, settings.turn_error_rad),
        });
        let steps = steps.collect();
        let pixels = truth.poses().into_iter().map(|pose| {
            landmarks.map(|landmark| projected(pose, landmark).map(|value_px| known(value_px, PIXEL_ERROR_PX)))
        });
        Drive { steps, pixels: pixels.collect(), truth }
    }

    /// Number of pictures.
    pub(crate) fn n_poses(&self) -> usize {
        self.pixels.len()
    }

    /// Whether a motion agrees with all readings, each by at least the share `margin` of its interval's half width.
    pub(crate) fn admits(&self, motion: &Motion, margin: f64) -> bool {
        let is_inside =
            |known: Interval, value: f64| (value - known.mid()).abs() <= (1.0 - margin) * 0.5 * known.width();
        let poses = motion.poses();
        self.steps.iter().zip(&motion.steps).all(|(step, &[distance_m, turn_rad])| {
            is_inside(step.distance_m, distance_m) && is_inside(step.turn_rad, turn_rad)
        }) && self.pixels.iter().zip(poses).all(|(picture, pose)| {
            picture.iter().zip(&motion.landmarks).all(|(known, &landmark)| {
                let [u_px, v_px] = projected(pose, landmark);
                is_inside(known[0], u_px) && is_inside(known[1], v_px)
            })
        })
    }
}

impl Motion {
    /// Poses (x, y, heading) at all pictures, along arcs of constant curvature from the origin.
    pub(crate) fn poses(&self) -> Vec<[f64; 3]> {
        let mut poses = vec![[0.0; 3]];
        let [mut x_m, mut y_m, mut heading_rad] = [0.0; 3];
        for &[distance_m, turn_rad] in &self.steps {
            // The chord of an arc has the direction of its middle, and is shorter by the factor sin(half)/half.
            let half_rad = 0.5 * turn_rad;
            let chord_m = if half_rad == 0.0 { distance_m } else { distance_m * half_rad.sin() / half_rad };
            x_m += chord_m * (heading_rad + half_rad).cos();
            y_m += chord_m * (heading_rad + half_rad).sin();
            heading_rad += turn_rad;
            poses.push([x_m, y_m, heading_rad]);
        }
        poses
    }

    /// Place of a landmark in the world.
    pub(crate) fn place_m(&self, landmark: usize) -> [f64; 3] {
        let [a, b, rho] = self.landmarks[landmark];
        [1.0, a, b].map(|part| part / rho)
    }
}

/// Pixel at which a landmark is seen from a pose; NaN for one that is not in front of the camera.
pub(crate) fn projected([x_m, y_m, heading_rad]: [f64; 3], [a, b, rho]: Ray) -> [f64; 2] {
    let (sin, cos) = heading_rad.sin_cos();
    let (east, north) = (1.0 - rho * x_m, a - rho * y_m);
    let (ahead, left) = (cos * east + sin * north, cos * north - sin * east);
    if ahead > 0.0 { [-FOCAL_PX * left / ahead, -FOCAL_PX * b / ahead] } else { [f64::NAN; 2] }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Greatest |u| and |v| in the paper's image of 640 × 480 pixels with the principal point (320, 240).
    const HALF_IMAGE_PX: [f64; 2] = [320.0, 240.0];

    #[test]
    fn all_landmarks_are_in_every_picture_and_at_the_pixels_worked_out_by_hand() {
        let drive = Drive::new(&Settings::OURS, 0);
        for (known, half_px) in drive.pixels.iter().flatten().flat_map(|pixel| pixel.iter().zip(HALF_IMAGE_PX)) {
            assert!(known.magnitude() < half_px, "{known}");
        }
        // From (1, 0.2), turned left by a right angle, the landmark at (1.5, 4.2, −1) is 4 m ahead, 0.5 m to the right and 1 m below.
        let pixel = projected([1.0, 0.2, std::f64::consts::FRAC_PI_2], [4.2 / 1.5, -1.0 / 1.5, 1.0 / 1.5]);
        assert!((pixel[0] - 40.0).abs() < 1e-9 && (pixel[1] - 80.0).abs() < 1e-9, "{pixel:?}");
        assert!(projected([2.0, 0.0, 0.0], [0.0, 0.0, 1.0])[0].is_nan(), "behind the camera");
    }

    #[test]
    fn four_arcs_of_a_quarter_turn_close_a_circle() {
        let quarter = std::f64::consts::FRAC_PI_2;
        let truth = Drive::new(&Settings::OURS, 0).truth;
        let poses = Motion { steps: vec![[quarter, quarter]; 4], ..truth }.poses();
        // By hand: the circle has the radius 1 m and its centre at (0, 1).
        for (pose, expected) in poses.iter().zip([[0.0, 0.0], [1.0, 1.0], [0.0, 2.0], [-1.0, 1.0], [0.0, 0.0]]) {
            assert!((pose[0] - expected[0]).abs() < 1e-12 && (pose[1] - expected[1]).abs() < 1e-12, "{pose:?}");
        }
    }

    #[test]
    fn the_data_admit_the_truth_and_no_motion_that_is_two_pixels_off() {
        for seed in 0..20 {
            let drive = Drive::new(&Settings::OURS, seed);
            assert!(drive.admits(&drive.truth, 0.0), "seed {seed}");
            let mut other = drive.truth.clone();
            other.landmarks[1][0] += 2.1 / FOCAL_PX;
            assert!(!drive.admits(&other, 0.0), "seed {seed}");
            let mut faster = drive.truth.clone();
            faster.steps[7][0] *= 1.0 + 2.1 * Settings::OURS.distance_error;
            assert!(!drive.admits(&faster, 0.0), "seed {seed}");
        }
    }
}

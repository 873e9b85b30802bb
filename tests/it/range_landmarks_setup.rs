//! A simulated range camera and its landmarks, written for the tests: true geometry in three dimensions, with every error drawn inside its bound.

use interval::Interval;
use interval::contractor::{Contractor, Outcome};
use localizer::{
    Constraint, PoseBox, Reading, RobotModel,
    reading::{LandmarkId, Sighting},
    robot::{BodyModel, RangeCameraModel, Reach, WheelModel},
};
use nalgebra::{Isometry3, Point3, Translation3, UnitQuaternion, Vector3};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

pub(crate) const TILT_RAD: f64 = 0.004;
pub(crate) const HEIGHT_M: f64 = 0.3;
pub(crate) const HEIGHT_SPAN_M: f64 = 0.2;
pub(crate) const REACH: Reach = Reach { speed_m_per_s: 0.7, turn_rate_rad_per_s: 1.6, acceleration_m_per_s2: 2.0 };

pub(crate) fn random(seed: u64) -> ChaCha8Rng {
    ChaCha8Rng::seed_from_u64(seed)
}

/// Random number in [−1, 1] that is one of the two ends in half of the draws.
pub(crate) fn corner(rng: &mut ChaCha8Rng) -> f64 {
    if rng.random::<f64>() < 0.5 { [-1.0, 1.0][rng.random_range(0..2)] } else { rng.random_range(-1.0..1.0) }
}

/// Model of the robot that the localizer is given, with a Kinect's optics (paper 3: b = 7.5 cm, f = 580 px).
pub(crate) fn robot(q_items: usize, wrong_spacing: usize) -> RobotModel {
    RobotModel {
        wheels: WheelModel {
            radius_m: [Interval::centred(0.0975, 0.0002); 2],
            track_m: Interval::centred(0.33, 0.001),
            ticks_per_turn: 19_150.0,
            slip_ratio: 0.005,
            slip_floor_m: 0.0001,
            side_slip_ratio: 0.003,
            side_slip_floor_m: 0.00005,
            slip_window_s: 0.2,
        },
        reach: REACH,
        body: BodyModel { tilt_rad: TILT_RAD, heave_m: 0.0, clearance_m: 0.0 },
        floor_camera: None,
        ceiling_camera: None,
        forward_camera: None,
        gyro: None,
        flow: None,
        steering: None,
        range_camera: Some(RangeCameraModel {
            focal_px: Interval::centred(580.0, 0.6),
            baseline_m: Interval::centred(0.075, 0.0001),
            centre_px: 319.5,
            step_px: [0.5, 0.125],
            height_m: HEIGHT_M,
            position_m: [Interval::centred(0.1, 0.001), Interval::centred(-0.03, 0.001)],
            yaw_rad: Interval::centred(0.3, 0.002),
            tilt_rad: TILT_RAD,
            height_span_m: HEIGHT_SPAN_M,
            stamp_error_s: 0.001,
            latency_s: Interval::ZERO,
            period_s: 0.099,
            q_items,
            wrong_spacing,
        }),
    }
}

/// The range camera as it truly is, with its drawn errors.
pub(crate) struct TrueCamera {
    focal_px: f64,
    baseline_m: f64,
    body_from_sensor: Isometry3<f64>,
    step_px: [f64; 2],
}

impl TrueCamera {
    pub(crate) fn drawn(rng: &mut ChaCha8Rng) -> Self {
        let position = Translation3::new(0.1 + 0.001 * corner(rng), -0.03 + 0.001 * corner(rng), HEIGHT_M);
        let yaw = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), 0.3 + 0.002 * corner(rng));
        TrueCamera {
            focal_px: 580.0 + 0.6 * corner(rng),
            baseline_m: 0.075 + 0.0001 * corner(rng),
            body_from_sensor: Isometry3::from_parts(position, tilted(rng) * yaw),
            step_px: [0.5, 0.125],
        }
    }

    /// The same range camera, whose two measured columns are rounded to multiples of these steps, in pixels.
    pub(crate) fn with_steps(self, step_px: [f64; 2]) -> Self {
        TrueCamera { step_px, ..self }
    }

    /// Columns at which the two views of the range camera see a landmark from a robot's pose, with a tilt of the body drawn for this sighting; `None`
    /// when the landmark is outside the picture.
    pub(crate) fn sight(&self, pose: [f64; 3], landmark: &Landmark, rng: &mut ChaCha8Rng) -> Option<Sighting> {
        let seen = self.world_from_sensor(pose, rng).inverse_transform_point(&landmark.place);
        // The mount has x forward, y left and z up, so that a distance to the right is −y.
        let (forward_m, right_m) = (seen.x, -seen.y);
        if forward_m < 0.3 || (right_m / forward_m).abs() > 0.55 {
            return None;
        }
        let rounded = |column_px: f64, step_px: f64| (column_px / step_px).round() * step_px;
        Some(Sighting {
            landmark: landmark.code,
            left_px: rounded(319.5 + self.focal_px * right_m / forward_m, self.step_px[0]),
            right_px: rounded(319.5 + self.focal_px * (right_m - self.baseline_m) / forward_m, self.step_px[1]),
        })
    }

    fn world_from_sensor(&self, [x_m, y_m, heading_rad]: [f64; 3], rng: &mut ChaCha8Rng) -> Isometry3<f64> {
        // The heading is that of the body's forward axis: yaw is applied first, then pitch, then roll.
        let (angle, size) = (rng.random_range(0.0..std::f64::consts::TAU), TILT_RAD * corner(rng));
        let posture = UnitQuaternion::from_euler_angles(size * angle.cos(), size * angle.sin(), 0.0);
        let turned = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), heading_rad) * posture;
        Isometry3::from_parts(Translation3::new(x_m, y_m, 0.0), turned) * self.body_from_sensor
    }
}

fn tilted(rng: &mut ChaCha8Rng) -> UnitQuaternion<f64> {
    let (angle, size) = (rng.random_range(0.0..std::f64::consts::TAU), TILT_RAD * corner(rng));
    UnitQuaternion::from_scaled_axis(Vector3::new(angle.cos(), angle.sin(), 0.0) * size)
}

/// A landmark at its true place.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Landmark {
    pub(crate) code: LandmarkId,
    pub(crate) place: Point3<f64>,
}

impl Landmark {
    pub(crate) fn xy(&self) -> [f64; 2] {
        [self.place.x, self.place.y]
    }
}

/// Landmarks drawn over a square of ±`half_m` about the origin.
pub(crate) fn landmarks(n: u32, half_m: f64, rng: &mut ChaCha8Rng) -> Vec<Landmark> {
    (0..n)
        .map(|code| Landmark {
            code: LandmarkId(code),
            place: Point3::new(half_m * corner_free(rng), half_m * corner_free(rng), height(rng)),
        })
        .collect()
}

/// Landmarks drawn inside the picture that is seen from a pose, at distances of 0.5 to 5 m.
pub(crate) fn landmarks_in_view(n: u32, pose: [f64; 3], rng: &mut ChaCha8Rng) -> Vec<Landmark> {
    (0..n)
        .map(|code| {
            let (range_m, bearing) = (rng.random_range(0.5..5.0), pose[2] + 0.3 + rng.random_range(-0.4..0.4));
            let place = Point3::new(pose[0] + range_m * bearing.cos(), pose[1] + range_m * bearing.sin(), height(rng));
            Landmark { code: LandmarkId(code), place }
        })
        .collect()
}

fn height(rng: &mut ChaCha8Rng) -> f64 {
    // Heights of landmarks use only 99 % of the declared span about the sensor's height, because the sensor itself rises when the body tilts.
    HEIGHT_M + 0.99 * HEIGHT_SPAN_M * corner(rng)
}

fn corner_free(rng: &mut ChaCha8Rng) -> f64 {
    rng.random_range(-1.0..1.0)
}

/// Simulated measurement: an interval of this radius around a value plus an error within that radius.
pub(crate) fn measured(value: f64, radius: f64, rng: &mut ChaCha8Rng) -> Interval {
    Interval::centred(value + radius * corner(rng), radius).inflate(1e-13 * (1.0 + value.abs()))
}

pub(crate) fn box_around(pose: [f64; 3], radius: [f64; 3], rng: &mut ChaCha8Rng) -> PoseBox {
    PoseBox::from(std::array::from_fn(|axis| measured(pose[axis], radius[axis], rng)))
}

/// Rule by which the test gives sightings the code of a wrong landmark: at most `q_items` in a reading, and at least `wrong_spacing` right
/// sightings between two wrong ones given to the same code.
pub(crate) struct Confusion {
    q_items: usize,
    wrong_spacing: usize,
    right_since: std::collections::BTreeMap<LandmarkId, usize>,
}

impl Confusion {
    pub(crate) fn new(q_items: usize, wrong_spacing: usize) -> Self {
        Confusion { q_items, wrong_spacing, right_since: Default::default() }
    }

    /// Gives sightings wrong codes with the given chance, as often as the rule allows; returns how many are wrong.
    pub(crate) fn confuse(
        &mut self,
        sightings: &mut [Sighting],
        codes: &[LandmarkId],
        chance: f64,
        rng: &mut ChaCha8Rng,
    ) -> usize {
        let mut n_wrong = 0;
        for sighting in sightings.iter_mut() {
            let other = codes[rng.random_range(0..codes.len())];
            let is_allowed = other != sighting.landmark
                && n_wrong < self.q_items
                && self.right_since.get(&other).is_none_or(|right| *right >= self.wrong_spacing);
            if is_allowed && rng.random::<f64>() < chance {
                sighting.landmark = other;
                self.right_since.insert(other, 0);
                n_wrong += 1;
            } else if let Some(right) = self.right_since.get_mut(&sighting.landmark) {
                *right += 1;
            }
        }
        n_wrong
    }
}

/// Contractor that keeps one component of the pose, chosen by its index, in an interval.
pub(crate) struct Only(pub(crate) usize, pub(crate) Interval);

impl Contractor<3> for Only {
    fn contract(&self, domain: &mut PoseBox) -> Outcome {
        domain[self.0] = domain[self.0].intersect(self.1);
        if domain.is_empty() { Outcome::Empty("elsewhere") } else { Outcome::Feasible }
    }
}

/// Constraint of a test's stand-in for a method: one component of the pose is within an interval at the reading's stamp. It makes no claims and
/// relies on no declared bound.
pub(crate) fn says(method: &'static str, reading: &Reading, component: usize, within: Interval) -> Constraint {
    Constraint::new(method, reading.measured_s(), Only(component, within))
}

//! The range camera (a stereo camera) as a sensor: which landmarks both of its views see, at which image columns, and which landmarks they are taken
//! for.

use localizer::{Reading, bounds, reading::LandmarkId};
use nalgebra::{Isometry3, Matrix3, Point3, Rotation3, Translation3, UnitQuaternion, Vector3, vector};

use crate::{
    devices::{BoundCheck, Observation, Sensor},
    place::{Bystander, sight::Obstacles},
    scene::{RangeCamera, Scene},
    truth::{
        Truth,
        randomness::{self, Repeated},
    },
};

use super::{
    DrawnRangeCamera, FIRST_S,
    codes::{CodeBounds, Confusion},
};

/// Allowance for rounding of times: the difference of two times that are minutes long has lost some digits.
const ROUNDING_S: f64 = 1e-9;

/// A range camera that takes a reading every period.
pub struct RangeCameraSensor {
    camera: RangeCamera,
    mount: DrawnRangeCamera,
    landmarks: Vec<Point3<f64>>,
    obstacles: Obstacles,
    confusion: Confusion,
    code_bounds: CodeBounds,
    clock: Repeated,
    /// Errors of the landmarks' image columns in the first and in the second view of the range camera. With the error distribution `drift` the errors
    /// of the two views go to opposite sides, so that all distances are wrong in the same direction.
    noise: Repeated,
    n_readings: u64,
}

impl RangeCameraSensor {
    /// The range camera with its mount as drawn at random.
    pub fn new(camera: &RangeCamera, mount: &DrawnRangeCamera, scene: &Scene, seed: u64) -> Self {
        let landmarks: Vec<Point3<f64>> =
            scene.landmarks.iter().map(|landmark| Point3::new(landmark.x_m, landmark.y_m, landmark.height_m)).collect();
        RangeCameraSensor {
            confusion: Confusion::new(camera, landmarks.len(), randomness::stream(seed, "range_camera.confusion")),
            obstacles: Obstacles::new(scene),
            clock: Repeated::new(scene.robot.errors, randomness::stream(seed, "range_camera.clock")),
            noise: Repeated::new(scene.robot.errors, randomness::stream(seed, "range_camera.columns")),
            code_bounds: CodeBounds::new(camera),
            n_readings: 0,
            landmarks,
            camera: camera.clone(),
            mount: *mount,
        }
    }
}

impl Sensor for RangeCameraSensor {
    /// Returns a reading when one is due.
    fn observe(&mut self, truth: &Truth, people: &[Bystander]) -> Option<Observation> {
        // Half a physics step of slack makes the reading due at the intended physics step, however times in decimal seconds are rounded.
        if truth.time_s + 0.0005 < FIRST_S + self.n_readings as f64 * self.camera.period_s {
            return None;
        }
        self.n_readings += 1;
        let world_from_sensor = world_from_range_camera(truth, &self.mount, self.camera.height_m);
        let exact: Vec<(u32, [f64; 2])> = self
            .landmarks
            .iter()
            .zip(0..)
            .filter_map(|(landmark, code)| Some((code, self.columns(landmark, &world_from_sensor, people)?)))
            .collect();
        let (mut seen, mut greatest_noise_px) = (Vec::with_capacity(exact.len()), 0.0);
        for (code, columns_px) in exact {
            let noise_px = [1.0, -1.0].map(|side| side * self.noise.one_way(self.camera.column_noise_px));
            greatest_noise_px = noise_px.iter().fold(greatest_noise_px, |most: f64, noise_px| most.max(noise_px.abs()));
            seen.push((code, self.rounded([0, 1].map(|view| columns_px[view] + noise_px[view]))));
        }
        let mut sightings = self.confusion.name(&seen);
        let is_own = |(truly, given): (&(u32, _), LandmarkId)| (given, given.0 == truly.0);
        let mut codes: Vec<(LandmarkId, bool)> =
            seen.iter().zip(sightings.iter().map(|sighting| sighting.landmark)).map(is_own).collect();
        self.mount.cuts.cut(&mut sightings, &mut codes, self.camera.q_items);
        let measured_s = truth.time_s + self.clock.one_way(self.camera.stamp_tolerance_s);
        let late_s = self.camera.latency_s + self.clock.in_turn(self.camera.latency_tolerance_s);
        let arrived_s = truth.time_s + late_s.max(0.0);
        let (camera, span_s) = (&self.camera, [truth.time_s, arrived_s]);
        let check = |bound, declared, true_value| BoundCheck { bound, span_s, declared, true_value };
        let off_s = (arrived_s - truth.time_s - camera.latency_s).abs();
        let mut checks = vec![
            check(bounds::RANGE_CAMERA_STAMP, camera.stamp_tolerance_s, (measured_s - truth.time_s).abs()),
            check(bounds::RANGE_CAMERA_LATENCY, camera.latency_tolerance_s + ROUNDING_S, off_s),
            check(bounds::RANGE_CAMERA_COLUMNS, camera.column_noise_px, greatest_noise_px),
        ];
        let of_codes = self.code_bounds.after(&codes);
        checks.extend(of_codes.into_iter().map(|(bound, declared, true_value)| check(bound, declared, true_value)));
        let reading = Reading::Range { measured_s, arrived_s, sightings };
        Some(Observation { codes, checks, ..Observation::new(reading, *truth) })
    }
}

impl RangeCameraSensor {
    /// A landmark's image columns in the two views, each rounded to the rounding step of its view.
    fn rounded(&self, columns_px: [f64; 2]) -> [f64; 2] {
        [rounded(columns_px[0], self.camera.column_step_px), rounded(columns_px[1], self.camera.match_step_px)]
    }

    /// Exact columns of a landmark in both views; `None` when one of the views does not see it.
    fn columns(
        &self,
        landmark: &Point3<f64>,
        world_from_sensor: &Isometry3<f64>,
        people: &[Bystander],
    ) -> Option<[f64; 2]> {
        let camera = &self.camera;
        let in_sensor = world_from_sensor.inverse_transform_point(landmark);
        let range_m = in_sensor.coords.norm();
        if in_sensor.z <= 0.0 || range_m < camera.least_range_m || range_m > camera.greatest_range_m {
            return None;
        }
        let views = [0.0, self.mount.baseline_m].map(|x_m| Point3::new(x_m, 0.0, 0.0));
        let columns = views.map(|view| camera.centre_px() + self.mount.focal_px * (in_sensor.x - view.x) / in_sensor.z);
        let is_in_image = |column_px: f64| (-0.5..=f64::from(camera.width_px) - 0.5).contains(&column_px);
        let is_free = |view: &Point3<f64>| self.obstacles.leave_free(world_from_sensor * view, *landmark, people);
        if !columns.into_iter().all(is_in_image) || !views.iter().all(is_free) {
            return None;
        }
        Some(columns)
    }
}

/// The multiple of the rounding step that is nearest to the image column.
fn rounded(column_px: f64, step_px: f64) -> f64 {
    (column_px / step_px).round() * step_px
}

/// Pose in the world of the range camera's first view, at the true state `truth`: sensor x right, y down, z forward.
pub fn world_from_range_camera(truth: &Truth, mount: &DrawnRangeCamera, height_m: f64) -> Isometry3<f64> {
    let [forward_m, left_m] = mount.position_m;
    let tilt = vector![mount.tilt_rad[0], mount.tilt_rad[1], 0.0];
    let body_from_mount = Isometry3::from_parts(
        Translation3::new(forward_m, left_m, height_m),
        UnitQuaternion::from_scaled_axis(tilt) * UnitQuaternion::from_axis_angle(&Vector3::z_axis(), mount.yaw_rad),
    );
    // The columns of the matrix are the sensor's axes in the robot frame: x (right) is −y, y (down) is −z, and z (forward) is x.
    let columns = Matrix3::new(0.0, 0.0, 1.0, -1.0, 0.0, 0.0, 0.0, -1.0, 0.0);
    let ahead = UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(columns));
    truth.world_from_body() * body_from_mount * ahead
}

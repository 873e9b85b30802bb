//! The point camera as a sensor: which landmarks are in view, and where in the image they are found.

use localizer::{
    Reading, bounds,
    methods::mapped_landmarks::{DEVICE, SeenPoint},
    reading::LandmarkId,
};
use nalgebra::{Isometry3, Matrix3, Point3, Rotation3, Translation3, UnitQuaternion, Vector3, vector};

use crate::{
    devices::{BoundCheck, Observation, Sensor},
    place::{Bystander, sight::Obstacles},
    scene::{PointCamera, Scene},
    truth::{
        Truth,
        randomness::{Repeated, stream},
    },
};

use super::{DrawnPointCamera, FIRST_S};

/// A point camera that takes an image every period.
pub struct PointCameraSensor {
    camera: PointCamera,
    mount: DrawnPointCamera,
    landmarks: Vec<Point3<f64>>,
    obstacles: Obstacles,
    clock: Repeated,
    /// Errors of image points along u and along v, in turn.
    noise: Repeated,
    n_readings: u64,
}

impl PointCameraSensor {
    /// The point camera with its mount and optics as drawn at random.
    pub fn new(camera: &PointCamera, mount: &DrawnPointCamera, scene: &Scene, seed: u64) -> Self {
        let landmarks =
            scene.landmarks.iter().map(|landmark| Point3::new(landmark.x_m, landmark.y_m, landmark.height_m)).collect();
        PointCameraSensor {
            camera: camera.clone(),
            mount: *mount,
            landmarks,
            obstacles: Obstacles::new(scene),
            clock: Repeated::new(scene.robot.errors, stream(seed, "point_camera.clock")),
            noise: Repeated::new(scene.robot.errors, stream(seed, "point_camera.points")),
            n_readings: 0,
        }
    }

    /// Image point of a landmark without error; `None` for one that is not in view.
    fn seen_at(&self, landmark: &Point3<f64>, eye: &Isometry3<f64>, people: &[Bystander]) -> Option<[f64; 2]> {
        let camera = &self.camera;
        let seen = eye.inverse_transform_point(landmark);
        if !(camera.least_depth_m..=camera.greatest_depth_m).contains(&seen.z) {
            return None;
        }
        let at_px = [0, 1].map(|k| self.mount.centre_px[k] + self.mount.focal_px * seen[k] / seen.z);
        let sizes_px = [camera.width_px, camera.height_px].map(f64::from);
        let is_inside = (0..2).all(|k| (-0.5..=sizes_px[k] - 0.5).contains(&at_px[k]));
        let from = Point3::from(eye.translation.vector);
        (is_inside && self.obstacles.leave_free(from, *landmark, people)).then_some(at_px)
    }
}

impl Sensor for PointCameraSensor {
    /// Returns the points of an image when one is due.
    fn observe(&mut self, truth: &Truth, people: &[Bystander]) -> Option<Observation> {
        // Half a physics step of slack makes the reading due at the intended physics step, however times in decimal seconds are rounded.
        if truth.time_s + 0.0005 < FIRST_S + self.n_readings as f64 * self.camera.period_s {
            return None;
        }
        self.n_readings += 1;
        let eye = world_from_point_camera(truth, &self.mount, self.camera.tilt_up_deg.to_radians());
        let in_view: Vec<(u32, [f64; 2])> = (0..)
            .zip(&self.landmarks)
            .filter_map(|(number, landmark)| Some((number, self.seen_at(landmark, &eye, people)?)))
            .take(self.camera.most_points)
            .collect();
        let mut greatest_px: f64 = 0.0;
        let mut points = Vec::with_capacity(in_view.len());
        for (number, exact_px) in in_view {
            let off_px = [0; 2].map(|_| self.noise.one_way(self.camera.point_tolerance_px));
            greatest_px = greatest_px.max(off_px[0].abs()).max(off_px[1].abs());
            points.push(SeenPoint { landmark: LandmarkId(number), at_px: [0, 1].map(|k| exact_px[k] + off_px[k]) });
        }
        let measured_s = truth.time_s + self.clock.one_way(self.camera.stamp_tolerance_s);
        let arrived_s = truth.time_s + self.camera.latency_s;
        let check =
            |bound, declared, true_value| BoundCheck { bound, span_s: [truth.time_s, arrived_s], declared, true_value };
        let checks = vec![
            check(bounds::POINT_CAMERA_POINTS, self.camera.point_tolerance_px, greatest_px),
            check(bounds::POINT_CAMERA_STAMP, self.camera.stamp_tolerance_s, (measured_s - truth.time_s).abs()),
            // The front end finds nothing that is nearer.
            check(bounds::POINT_CAMERA_LEAST_DEPTH, 0.0, 0.0),
        ];
        let numbers = SeenPoint::numbers(&points);
        let reading = Reading::Other { measured_s, arrived_s, device: DEVICE.to_owned(), numbers };
        Some(Observation { checks, ..Observation::new(reading, *truth) })
    }
}

/// Pose of the point camera in the world: x to the right of its image, y down, z along the optical axis.
fn world_from_point_camera(truth: &Truth, mount: &DrawnPointCamera, tilt_up_rad: f64) -> Isometry3<f64> {
    let [forward_m, left_m, up_m] = mount.position_m;
    let lean = UnitQuaternion::from_scaled_axis(vector![mount.tilt_rad[0], mount.tilt_rad[1], 0.0]);
    let yaw = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), mount.yaw_rad);
    let up = UnitQuaternion::from_axis_angle(&Vector3::y_axis(), -tilt_up_rad);
    // The columns of the matrix are the axes of a level camera in the robot frame: x (right) is −y, y (down) is −z, and z (ahead) is x.
    let columns = Matrix3::new(0.0, 0.0, 1.0, -1.0, 0.0, 0.0, 0.0, -1.0, 0.0);
    let level = UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(columns));
    let body_from_camera = Isometry3::from_parts(Translation3::new(forward_m, left_m, up_m), yaw * lean * up * level);
    truth.world_from_body() * body_from_camera
}

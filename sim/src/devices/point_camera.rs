//! The point camera: a camera whose front end tells where in the image it sees which landmark.

mod sensor;

use interval::Interval;
use localizer::{
    Map, Method, RobotModel,
    bounds::{self, Assumption},
    methods::mapped_landmarks::{MappedLandmarks, PointCameraModel},
};

use crate::{
    scene::{Distribution, MethodName, PointCamera, Scene},
    truth::randomness::{draw_tilt, draw_within, stream},
};

use super::{Device, Sensor, ToldKey, farthest, relative};

pub use sensor::PointCameraSensor;

/// Time of the first image. It is late enough that no stamp lies before the start of the clock, whatever the stamp's error.
const FIRST_S: f64 = 0.1;

/// True mount and optics of the point camera.
#[derive(Clone, Copy, Debug)]
pub struct DrawnPointCamera {
    /// Position of the optical centre in the robot frame: forward, left and up.
    pub position_m: [f64; 3],
    /// Direction of the point camera's optical axis from robot forward, counter-clockwise.
    pub yaw_rad: f64,
    /// Rotation vector by which the point camera leans from its nominal attitude, about level axes along its own forward and left.
    pub tilt_rad: [f64; 2],
    /// Focal length of the point camera in pixels.
    pub focal_px: f64,
    /// Principal point of the point camera: u and v.
    pub centre_px: [f64; 2],
}

impl Device for PointCamera {
    type Drawn = DrawnPointCamera;

    fn draw(&self, errors: Distribution, seed: u64) -> DrawnPointCamera {
        let mut rng = stream(seed, "point_camera.mount");
        let mut around = |nominal: f64, tolerance: f64| nominal + draw_within(tolerance, errors, &mut rng);
        let position_m =
            [self.forward_m, self.left_m, self.height_m].map(|nominal_m| around(nominal_m, self.position_tolerance_m));
        let yaw_rad = around(self.yaw_deg.to_radians(), self.angle_tolerance_deg.to_radians());
        let focal_px = around(self.focal_px, self.focal_px * self.focal_tolerance);
        let centre_px = self.centre_px().map(|at_px| around(at_px, self.centre_tolerance_px));
        let tilt_rad = draw_tilt(self.angle_tolerance_deg, errors, &mut rng);
        DrawnPointCamera { position_m, yaw_rad, tilt_rad, focal_px, centre_px }
    }

    fn sensor(&self, drawn: &DrawnPointCamera, scene: &Scene, seed: u64) -> Option<Box<dyn Sensor>> {
        Some(Box::new(PointCameraSensor::new(self, drawn, scene, seed)))
    }

    fn method(&self, _name: MethodName, scene: &Scene, _map: &Map, robot: &RobotModel) -> Option<Box<dyn Method>> {
        let setup = scene.localizer.mapped_landmarks();
        let learning = setup.learning();
        let known = setup.known.map_or_else(Vec::new, |map| map.landmarks);
        Some(Box::new(MappedLandmarks::new(self.model(scene), robot, &known, learning)))
    }

    fn first_arrival_s(&self) -> f64 {
        FIRST_S + self.latency_s
    }

    fn is_relied_on(&self, scene: &Scene) -> bool {
        scene.localizer.methods.contains(&MethodName::MappedLandmarks)
    }

    fn constants(&self, drawn: &DrawnPointCamera, _scene: &Scene) -> Vec<(Assumption, f64, f64)> {
        let [forward_m, left_m, up_m] = drawn.position_m;
        let angle_rad = self.angle_tolerance_deg.to_radians();
        vec![
            (
                bounds::POINT_CAMERA_POSITION,
                self.position_tolerance_m,
                farthest([forward_m, left_m], [self.forward_m, self.left_m]),
            ),
            (bounds::POINT_CAMERA_HEIGHT, self.position_tolerance_m, (up_m - self.height_m).abs()),
            (bounds::POINT_CAMERA_YAW, angle_rad, (drawn.yaw_rad - self.yaw_deg.to_radians()).abs()),
            (bounds::POINT_CAMERA_TILT, angle_rad, drawn.tilt_rad[0].hypot(drawn.tilt_rad[1])),
            (bounds::POINT_CAMERA_FOCAL, self.focal_tolerance, (drawn.focal_px / self.focal_px - 1.0).abs()),
            (bounds::POINT_CAMERA_CENTRE, self.centre_tolerance_px, farthest(drawn.centre_px, self.centre_px())),
        ]
    }

    fn told_keys(&mut self) -> Vec<ToldKey<'_>> {
        vec![
            ToldKey::is(&[bounds::POINT_CAMERA_POSITION, bounds::POINT_CAMERA_HEIGHT], &mut self.position_tolerance_m),
            ToldKey::is_in_deg(&[bounds::POINT_CAMERA_YAW, bounds::POINT_CAMERA_TILT], &mut self.angle_tolerance_deg),
            ToldKey::is(&[bounds::POINT_CAMERA_FOCAL], &mut self.focal_tolerance),
            ToldKey::is(&[bounds::POINT_CAMERA_CENTRE], &mut self.centre_tolerance_px),
            ToldKey::is(&[bounds::POINT_CAMERA_POINTS], &mut self.point_tolerance_px),
            ToldKey::is(&[bounds::POINT_CAMERA_STAMP], &mut self.stamp_tolerance_s),
        ]
    }

    fn contradictions(&self) -> Vec<(String, String)> {
        let is_empty = self.least_depth_m >= self.greatest_depth_m;
        let expected = format!("expected less than `greatest_depth_m`, {}", self.greatest_depth_m);
        is_empty.then(|| ("least_depth_m".to_owned(), expected)).into_iter().collect()
    }
}

impl PointCamera {
    /// The model of the point camera that the localizer is given. Where the base has another clock, the bound on the error of stamps grows by the bound
    /// on that clock.
    pub(crate) fn model(&self, scene: &Scene) -> PointCameraModel {
        let place = |nominal_m: f64| Interval::centred(nominal_m, self.position_tolerance_m);
        let angle_rad = self.angle_tolerance_deg.to_radians();
        PointCameraModel {
            focal_px: relative(self.focal_px, self.focal_tolerance),
            centre_px: self.centre_px().map(|at_px| Interval::centred(at_px, self.centre_tolerance_px)),
            tilt_up_rad: self.tilt_up_deg.to_radians(),
            yaw_rad: Interval::centred(self.yaw_deg.to_radians(), angle_rad),
            tilt_rad: angle_rad,
            position_m: [self.forward_m, self.left_m].map(place),
            height_m: place(self.height_m),
            error_px: self.point_tolerance_px,
            least_depth_m: self.least_depth_m,
            stamp_error_s: self.stamp_tolerance_s + scene.robot.delivery.stamp_tolerance_s,
        }
    }
}

//! The ceiling camera: an infrared camera that looks up at markers.

use interval::Interval;
use localizer::{
    Map, Method, RobotModel,
    bounds::{self, Assumption},
    methods::ceiling_markers::CeilingMarkers,
    robot::CeilingCameraModel,
};

use crate::{
    optics::AutoExposure,
    scene::{CameraKeys, CeilingCamera, Distribution, MethodName, Scene},
};

use super::{
    Device, ToldKey,
    camera::{CalibrationBounds, DrawnCamera},
    relative,
};

const BOUNDS: CalibrationBounds = CalibrationBounds {
    position: &[bounds::CEILING_CAMERA_POSITION, bounds::CEILING_CAMERA_HEIGHT],
    angles: &[bounds::CEILING_CAMERA_YAW, bounds::CEILING_CAMERA_TILT],
    focal: &[bounds::CEILING_CAMERA_FOCAL],
    principal_point: &[bounds::CEILING_CAMERA_CENTRE],
    distortion: &[bounds::CEILING_CAMERA_DISTORTION],
};

impl Device for CeilingCamera {
    type Drawn = DrawnCamera;

    fn draw(&self, errors: Distribution, seed: u64) -> DrawnCamera {
        DrawnCamera::draw(self, &self.calibration, errors, seed)
    }

    fn method(&self, _name: MethodName, _scene: &Scene, map: &Map, robot: &RobotModel) -> Option<Box<dyn Method>> {
        Some(Box::new(CeilingMarkers::new(map, robot)?))
    }

    fn first_arrival_s(&self) -> f64 {
        self.timing().first_arrival_s()
    }

    fn is_relied_on(&self, scene: &Scene) -> bool {
        scene.localizer.methods.contains(&MethodName::CeilingMarkers)
    }

    fn constants(&self, drawn: &DrawnCamera, _scene: &Scene) -> Vec<(Assumption, f64, f64)> {
        BOUNDS.constants(&self.calibration, self, drawn)
    }

    fn told_keys(&mut self) -> Vec<ToldKey<'_>> {
        let mut keys = BOUNDS.told_keys(&mut self.calibration);
        keys.push(ToldKey::is(&[bounds::CEILING_CAMERA_STAMP], &mut self.stamp_tolerance_s));
        keys
    }
}

impl CeilingCamera {
    /// The model of the ceiling camera that the localizer is given.
    pub(crate) fn model(&self) -> CeilingCameraModel {
        let (calibration, sensor) = (&self.calibration, self.sensor_model());
        let angle_rad = calibration.angle_tolerance_deg.to_radians();
        let place = |nominal_m: f64| Interval::centred(nominal_m, calibration.position_tolerance_m);
        let around = |at_px: f64| Interval::centred(at_px, calibration.principal_point_tolerance_px);
        // The greatest gain of the automatic exposure is an upper bound for any image: automatic exposure uses at most this gain, and a fixed
        // exposure the least.
        let gain = AutoExposure::new(&sensor).greatest_gain_levels_per_electron();
        CeilingCameraModel {
            width_px: self.width_px,
            height_px: self.height_px,
            focal_px: self.focal_px.map(|focal_px| relative(focal_px, calibration.focal_tolerance)),
            centre_px: self.principal_point_px.map(around),
            distortion: self.lens.distortion,
            distortion_px: calibration.distortion_tolerance_px,
            height_m: place(self.height_m),
            position_m: [place(self.forward_m), place(self.left_m)],
            // Without yaw, the localizer's model of a camera that looks up has the robot's left at the right of the image; a yaw of half a turn turns
            // that into the image of this camera.
            yaw_rad: Interval::centred(std::f64::consts::PI, angle_rad),
            lean_rad: [-self.lean_forward_deg.to_radians(), -self.lean_left_deg.to_radians()],
            tilt_rad: angle_rad,
            stamp_error_s: self.stamp_tolerance_s,
            electrons_per_grey: sensor.bits.levels_per_byte_level() / gain,
            q_items: self.q_items,
        }
    }
}

//! The ceiling camera: an infrared camera that looks up at markers.

use interval::Interval;
use localizer::{
    Claim, Map, Method, RobotModel,
    bounds::{self, Assumption},
    markers::dot_in_marker_m,
    methods::ceiling_markers::CeilingMarkers,
    reading::Camera,
    robot::CeilingCameraModel,
};

use crate::{
    optics::AutoExposure,
    place::drawn::DrawnMarker,
    scene::{CameraKeys, CeilingCamera, Distribution, Marker, MethodName, Scene},
};

use super::{
    Device, Surroundings, ToldKey, WatchedBound,
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

    /// Where the markers that are claimed in a picture were pasted, how they were rotated, how they were printed, and how high they hang.
    fn surroundings(&self, _drawn: &DrawnCamera, scene: &Scene, surroundings: &Surroundings<'_>) -> Vec<WatchedBound> {
        let Some(markers) = &scene.markers else { return Vec::new() };
        let names =
            [bounds::MARKERS_PLACEMENT, bounds::MARKERS_ROTATION, bounds::MARKERS_PRINT, bounds::MARKERS_HEIGHT];
        let mut all = names.map(WatchedBound::new);
        let declared = [
            markers.placement_tolerance_m,
            markers.rotation_tolerance_deg.to_radians(),
            markers.print_tolerance_m,
            markers.height_tolerance_m,
        ];
        for look in surroundings.looks_of(Camera::Ceiling) {
            for claim in look.claims {
                let Claim::Marker { marker: id, .. } = claim else { continue };
                let pasted = surroundings.place.markers.iter().filter(|drawn| drawn.id == *id);
                let stated = pasted.filter_map(|drawn| Some((markers.all().get(drawn.index)?, drawn)));
                for (marker, drawn) in stated.filter(|(marker, _)| marker.on_map) {
                    let errors = errors_of(marker, drawn, markers.height_m(marker, scene));
                    for ((watched, declared), error) in all.iter_mut().zip(declared).zip(errors) {
                        watched.compare(look.span_s(), declared, error);
                    }
                }
            }
        }
        all.into()
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
            row_time_s: self.lens.row_time_s,
            q_items: self.q_items,
        }
    }
}

/// Errors of a marker: distance of its centre, its angle, the greatest distance of a dot from its place in the grid, and its height.
fn errors_of(marker: &Marker, drawn: &DrawnMarker, nominal_height_m: f64) -> [f64; 4] {
    let [x_m, y_m] = drawn.centre_m;
    let turned = drawn.rotation_rad - marker.rotation_deg.to_radians();
    let (sin, cos) = drawn.rotation_rad.sin_cos();
    let off_m = drawn.dots.iter().map(|dot| {
        let [along_m, across_m] = dot_in_marker_m(dot.place);
        let [dot_x_m, dot_y_m] = [x_m + cos * along_m - sin * across_m, y_m + sin * along_m + cos * across_m];
        (dot.centre_in_world.x - dot_x_m).hypot(dot.centre_in_world.y - dot_y_m)
    });
    // A tolerance of 0 is valid: an error that comes from rounding must not exceed it.
    const ROUNDING: f64 = 1e-12;
    let errors = [
        (x_m - marker.x_m).hypot(y_m - marker.y_m),
        turned.sin().atan2(turned.cos()).abs(),
        off_m.fold(0.0, f64::max),
        (drawn.height_m - nominal_height_m).abs(),
    ];
    errors.map(|error| (error - ROUNDING).max(0.0))
}

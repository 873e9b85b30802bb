//! The forward camera, which looks ahead at walls.

use interval::Interval;
use localizer::{
    Map, Method, RobotModel,
    bounds::{self, Assumption},
    methods::wall_directions::{self, WallDirections},
    robot::ForwardCameraModel,
};

use crate::scene::{CameraKeys, Distribution, ForwardCamera, MethodName, Scene, WallDirectionsChain};

use super::{
    Device, Surroundings, ToldKey, WatchedBound,
    camera::{CalibrationBounds, DrawnCamera},
    relative,
};

/// Names of the forward camera's calibration bounds; none for its position, because a heading from walls does not depend on where the camera is.
const BOUNDS: CalibrationBounds = CalibrationBounds {
    position: &[],
    angles: &[bounds::FORWARD_CAMERA_YAW, bounds::FORWARD_CAMERA_TILT],
    focal: &[bounds::FORWARD_CAMERA_FOCAL],
    principal_point: &[bounds::FORWARD_CAMERA_PRINCIPAL_POINT],
    distortion: &[bounds::FORWARD_CAMERA_DISTORTION],
};

impl Device for ForwardCamera {
    type Drawn = DrawnCamera;

    fn draw(&self, errors: Distribution, seed: u64) -> DrawnCamera {
        DrawnCamera::draw(self, &self.calibration, errors, seed)
    }

    fn method(&self, _name: MethodName, scene: &Scene, map: &Map, robot: &RobotModel) -> Option<Box<dyn Method>> {
        let keys = scene.localizer.wall_directions();
        let setup = wall_directions::Setup {
            chain: match keys.chain {
                WallDirectionsChain::Direct => wall_directions::Chain::Direct,
                WallDirectionsChain::Paper => wall_directions::Chain::Paper,
                WallDirectionsChain::PaperByTiles => wall_directions::Chain::PaperByTiles,
            },
            solves_lean: keys.solves_lean,
            floor_edges: keys.floor_edges,
            learns: keys.learns,
            decides: scene.localizer.methods == [MethodName::WallDirections],
            quotas: keys.quotas(),
        };
        Some(Box::new(WallDirections::new(map, robot, setup)?))
    }

    fn first_arrival_s(&self) -> f64 {
        self.timing().first_arrival_s()
    }

    fn is_relied_on(&self, scene: &Scene) -> bool {
        scene.localizer.methods.contains(&MethodName::WallDirections)
    }

    fn constants(&self, drawn: &DrawnCamera, _scene: &Scene) -> Vec<(Assumption, f64, f64)> {
        BOUNDS.constants(&self.calibration, self, drawn)
    }

    /// The angle between the directions of walls on the map and the true ones, and the angle by which the piece of furniture that stands most askew
    /// is turned.
    fn surroundings(&self, _drawn: &DrawnCamera, scene: &Scene, surroundings: &Surroundings<'_>) -> Vec<WatchedBound> {
        let (place, setup) = (surroundings.place, scene.localizer.wall_directions());
        let off_deg = scene.wall_directions_off_deg(&scene.true_wall_directions_deg(place));
        let askew_deg = scene.furniture_askew_deg(place).into_iter().map(f64::abs).fold(0.0, f64::max);
        let degrees = [
            (bounds::WALL_DIRECTIONS_DIRECTION, setup.tolerance_deg, off_deg),
            (bounds::WALL_DIRECTIONS_ASKEW, setup.askew_deg, askew_deg),
        ];
        let watched = |(bound, declared_deg, true_deg): (_, f64, f64)| {
            WatchedBound::throughout(bound, declared_deg.to_radians(), true_deg.to_radians(), surroundings)
        };
        degrees.map(watched).into()
    }

    fn told_keys(&mut self) -> Vec<ToldKey<'_>> {
        let mut keys = BOUNDS.told_keys(&mut self.calibration);
        keys.push(ToldKey::is(&[bounds::FORWARD_CAMERA_STAMP], &mut self.stamp_tolerance_s));
        keys
    }
}

impl ForwardCamera {
    /// The model of the forward camera that the localizer is given.
    pub(crate) fn model(&self) -> ForwardCameraModel {
        let calibration = &self.calibration;
        let angle_rad = calibration.angle_tolerance_deg.to_radians();
        let around = |at_px: f64| Interval::centred(at_px, calibration.principal_point_tolerance_px);
        ForwardCameraModel {
            focal_px: relative(self.focal_px()[0], calibration.focal_tolerance),
            principal_point_px: self.principal_point_px().map(around),
            distortion: self.lens.distortion,
            distortion_px: calibration.distortion_tolerance_px,
            tilt_up_rad: self.tilt_up_deg.to_radians(),
            yaw_rad: Interval::centred(self.yaw_deg.to_radians(), angle_rad),
            tilt_error_rad: angle_rad,
            stamp_error_s: self.stamp_tolerance_s,
        }
    }
}

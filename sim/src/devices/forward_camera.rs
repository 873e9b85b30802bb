//! The forward camera, which looks ahead at walls.

use interval::Interval;
use localizer::{
    Map, Method, RobotModel,
    bounds::{self, Assumption},
    methods::{
        mapped_landmarks::pictures::{KnownLandmarks, PicturedLandmarks},
        wall_bearings::WallBearings,
        wall_directions::{self, WallDirections},
    },
    robot::ForwardCameraModel,
};

use crate::scene::{CameraKeys, Distribution, ForwardCamera, MethodName, Scene, WallDirectionsChain};

use super::{
    Device, Surroundings, ToldKey, WatchedBound,
    camera::{CalibrationBounds, DrawnCamera},
    relative,
};

/// Names of the forward camera's calibration bounds. Those of its position matter to the methods `wall_bearings` and `mapped_landmarks` alone, because
/// a heading from walls does not depend on where the camera is.
const BOUNDS: CalibrationBounds = CalibrationBounds {
    position: &[bounds::FORWARD_CAMERA_POSITION, bounds::FORWARD_CAMERA_HEIGHT],
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

    fn method(&self, name: MethodName, scene: &Scene, map: &Map, robot: &RobotModel) -> Option<Box<dyn Method>> {
        if name == MethodName::WallBearings {
            let setup = scene.localizer.wall_bearings().method();
            let (camera, walls) = (robot.forward_camera?, map.walls.as_ref()?);
            return Some(Box::new(WallBearings::new(camera, walls, setup, robot)));
        }
        if name == MethodName::MappedLandmarks {
            let setup = scene.localizer.mapped_landmarks();
            let (learning, declared) = (setup.learning(), setup.declared());
            let known = setup.known.as_ref().map_or_else(KnownLandmarks::default, |map| KnownLandmarks {
                points: &map.landmarks,
                looks: &map.looks,
                views: Some(&map.views),
            });
            let camera = robot.forward_camera?;
            return Some(Box::new(PicturedLandmarks::new(camera, robot, known, learning, declared)));
        }
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
        let methods = &scene.localizer.methods;
        let is_read_by = |name: &MethodName| methods.contains(name);
        [MethodName::WallDirections, MethodName::WallBearings].iter().any(is_read_by)
            || methods.iter().any(|name| scene.robot.shows_landmarks(*name))
    }

    fn constants(&self, drawn: &DrawnCamera, scene: &Scene) -> Vec<(Assumption, f64, f64)> {
        let mut constants = BOUNDS.constants(&self.calibration, self, drawn);
        let is_of_place = |name: &MethodName| *name == MethodName::WallBearings || scene.robot.shows_landmarks(*name);
        if !scene.localizer.methods.iter().any(is_of_place) {
            constants.retain(|(name, _, _)| !BOUNDS.position.contains(name));
        }
        constants
    }

    /// The angle between the directions of walls on the map and the true ones, and the angle by which the piece of furniture that stands most askew
    /// is turned. For the method `wall_bearings` the distance of the walls from their places on the map.
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
        let uses = |name| scene.localizer.methods.contains(&name);
        let mut all: Vec<WatchedBound> = degrees.map(watched).into();
        if !uses(MethodName::WallDirections) {
            all.clear();
        }
        // Where a scanner is used as well, the places of walls are watched with it.
        let is_watched_elsewhere = scene.robot.scanner.is_some() && uses(MethodName::WallRanges);
        if uses(MethodName::WallBearings) && !is_watched_elsewhere {
            let (declared_m, off_m) = (scene.localizer.wall_ranges().placement_tolerance_m, scene.walls_off_m(place));
            all.push(WatchedBound::throughout(bounds::WALLS_PLACEMENT, declared_m, off_m, surroundings));
        }
        all
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
        let at = |nominal_m: f64| Interval::centred(nominal_m, calibration.position_tolerance_m);
        let [forward, left, height_m] = self.shared().position_m.map(at);
        ForwardCameraModel {
            focal_px: relative(self.focal_px()[0], calibration.focal_tolerance),
            principal_point_px: self.principal_point_px().map(around),
            distortion: self.lens.distortion,
            distortion_px: calibration.distortion_tolerance_px,
            tilt_up_rad: self.tilt_up_deg.to_radians(),
            yaw_rad: Interval::centred(self.yaw_deg.to_radians(), angle_rad),
            tilt_error_rad: angle_rad,
            stamp_error_s: self.stamp_tolerance_s,
            position_m: [forward, left],
            height_m,
            height_px: self.height_px,
            row_time_s: self.lens.row_time_s,
        }
    }
}

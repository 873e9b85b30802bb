//! The floor camera, which looks straight down at the floor.

use interval::Interval;
use localizer::{
    Map, Method, RobotModel,
    bounds::{self, Assumption},
    methods::floor_tiles::{Chain, FloorTiles},
    robot::FloorCameraModel,
};

use crate::{
    optics::Lens,
    scene::{Distribution, FloorCamera, FloorTilesChain, MethodName, Scene},
    truth::randomness::{draw_tilt, draw_within, stream},
};

use super::{
    Device, ToldKey,
    camera::{DrawnFloorCamera, bent_px},
    farthest, relative,
};

impl Device for FloorCamera {
    type Drawn = DrawnFloorCamera;

    fn draw(&self, errors: Distribution, seed: u64) -> DrawnFloorCamera {
        let mut rng = stream(seed, "floor_camera.mount");
        let position_m = [self.forward_m, self.left_m]
            .map(|nominal_m| nominal_m + draw_within(self.position_tolerance_m, errors, &mut rng));
        let px_per_m = self.nominal_px_per_m() * (1.0 + draw_within(self.scale_tolerance, errors, &mut rng));
        let tilt_rad = draw_tilt(self.tilt_tolerance_deg, errors, &mut rng);
        let drawn = DrawnFloorCamera {
            position_m,
            height_m: self.height_m,
            focal_px: px_per_m * self.height_m,
            yaw_rad: draw_within(self.yaw_tolerance_deg.to_radians(), errors, &mut rng),
            tilt_rad,
            distortion: self.lens.distortion,
        };
        let off_px = draw_within(self.distortion_tolerance_px, errors, &mut stream(seed, "floor_camera.distortion"));
        DrawnFloorCamera { distortion: Lens::floor(self, &drawn).bent_further(off_px), ..drawn }
    }

    fn method(&self, _name: MethodName, scene: &Scene, map: &Map, robot: &RobotModel) -> Option<Box<dyn Method>> {
        let chain = match scene.localizer.floor_tiles_chain {
            FloorTilesChain::Direct => Chain::Direct,
            FloorTilesChain::Paper => Chain::Paper,
        };
        Some(Box::new(FloorTiles::new(map, robot, chain)?))
    }

    fn first_arrival_s(&self) -> f64 {
        self.timing().first_arrival_s()
    }

    fn is_relied_on(&self, scene: &Scene) -> bool {
        scene.localizer.methods.contains(&MethodName::FloorTiles)
    }

    fn constants(&self, drawn: &DrawnFloorCamera, _scene: &Scene) -> Vec<(Assumption, f64, f64)> {
        let (nominal, true_px_per_m) = (self.nominal_px_per_m(), drawn.focal_px / drawn.height_m);
        vec![
            (
                bounds::FLOOR_CAMERA_POSITION,
                self.position_tolerance_m,
                farthest(drawn.position_m, [self.forward_m, self.left_m]),
            ),
            (bounds::FLOOR_CAMERA_YAW, self.yaw_tolerance_deg.to_radians(), drawn.yaw_rad.abs()),
            (
                bounds::FLOOR_CAMERA_TILT,
                self.tilt_tolerance_deg.to_radians(),
                drawn.tilt_rad[0].hypot(drawn.tilt_rad[1]),
            ),
            (bounds::FLOOR_CAMERA_SCALE, nominal * self.scale_tolerance, (true_px_per_m - nominal).abs()),
            (
                bounds::FLOOR_CAMERA_DISTORTION,
                self.distortion_tolerance_px,
                bent_px(&Lens::floor(self, drawn), self.lens.distortion),
            ),
        ]
    }

    fn told_keys(&mut self) -> Vec<ToldKey<'_>> {
        let nominal_px_per_m = self.nominal_px_per_m();
        vec![
            ToldKey::is(&[bounds::FLOOR_CAMERA_POSITION], &mut self.position_tolerance_m),
            ToldKey::is_in_deg(&[bounds::FLOOR_CAMERA_YAW], &mut self.yaw_tolerance_deg),
            ToldKey::is_in_deg(&[bounds::FLOOR_CAMERA_TILT], &mut self.tilt_tolerance_deg),
            ToldKey::is_share_of(&[bounds::FLOOR_CAMERA_SCALE], &mut self.scale_tolerance, nominal_px_per_m),
            ToldKey::is(&[bounds::FLOOR_CAMERA_DISTORTION], &mut self.distortion_tolerance_px),
            ToldKey::is(&[bounds::FLOOR_CAMERA_STAMP], &mut self.stamp_tolerance_s),
        ]
    }
}

impl FloorCamera {
    /// The model of the floor camera that the localizer is given.
    pub(crate) fn model(&self) -> FloorCameraModel {
        let place = |nominal_m: f64| Interval::centred(nominal_m, self.position_tolerance_m);
        FloorCameraModel {
            width_px: self.width_px,
            height_px: self.height_px,
            pixels_per_m: relative(self.nominal_px_per_m(), self.scale_tolerance),
            height_m: self.height_m,
            distortion: self.lens.distortion,
            distortion_px: self.distortion_tolerance_px,
            row_time_s: self.lens.row_time_s,
            position_m: [place(self.forward_m), place(self.left_m)],
            yaw_rad: Interval::centred(0.0, self.yaw_tolerance_deg.to_radians()),
            tilt_rad: self.tilt_tolerance_deg.to_radians(),
            stamp_error_s: self.stamp_tolerance_s,
            q_items: self.q_items,
        }
    }

    /// Pixels per metre of floor with the body at rest, according to the calibration.
    fn nominal_px_per_m(&self) -> f64 {
        f64::from(self.width_px) / self.footprint_width_m
    }
}

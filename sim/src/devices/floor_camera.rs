//! The floor camera, which looks straight down at the floor.

use interval::Interval;
use localizer::{
    Map, Method, RobotModel,
    bounds::{self, Assumption},
    methods::floor_tiles::{Chain, FloorTiles},
    reading::Camera,
    robot::FloorCameraModel,
};
use nalgebra::{Isometry3, Translation3, UnitQuaternion, Vector3, vector};

use crate::{
    place::building::GroundPlan,
    scene::{CameraKeys, Distribution, FloorCamera, FloorTilesChain, MethodName, Scene},
    truth::randomness::{draw_tilt, draw_within, stream},
};

use super::{
    Device, Surroundings, ToldKey, WatchedBound,
    camera::{DrawnCamera, Off, world_from_camera},
    relative,
};

impl Device for FloorCamera {
    type Drawn = DrawnCamera;

    /// A floor camera is calibrated on the floor: errors are those of its position over the floor and of the scale of its image there. Its height is
    /// the nominal one, and the error of the scale is one of the focal length.
    fn draw(&self, errors: Distribution, seed: u64) -> DrawnCamera {
        let rng = &mut stream(seed, "floor_camera.mount");
        let [forward_m, left_m] = [self.forward_m, self.left_m]
            .map(|nominal_m| nominal_m + draw_within(self.position_tolerance_m, errors, rng));
        let pixels_per_m = self.pixels_per_m() * (1.0 + draw_within(self.scale_tolerance, errors, rng));
        let [about_x_rad, about_y_rad] = draw_tilt(self.tilt_tolerance_deg, errors, rng);
        let yaw_rad = draw_within(self.yaw_tolerance_deg.to_radians(), errors, rng);
        let nominal = DrawnCamera::nominal(self);
        let turn = UnitQuaternion::from_scaled_axis(vector![about_x_rad, about_y_rad, 0.0])
            * UnitQuaternion::from_axis_angle(&Vector3::z_axis(), yaw_rad);
        let body_from_camera = Isometry3::from_parts(
            Translation3::new(forward_m, left_m, self.height_m),
            turn * nominal.body_from_camera.rotation,
        );
        let drawn = DrawnCamera { body_from_camera, focal_px: [pixels_per_m * self.height_m; 2], ..nominal };
        drawn.bent(self, self.distortion_tolerance_px, errors, seed)
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

    fn constants(&self, drawn: &DrawnCamera, _scene: &Scene) -> Vec<(Assumption, f64, f64)> {
        let (off, nominal) = (Off::of(drawn, self), self.pixels_per_m());
        let true_pixels_per_m = drawn.focal_px[0] / self.height_m;
        vec![
            (bounds::FLOOR_CAMERA_POSITION, self.position_tolerance_m, off.place_m[0]),
            (bounds::FLOOR_CAMERA_YAW, self.yaw_tolerance_deg.to_radians(), off.yaw_rad),
            (bounds::FLOOR_CAMERA_TILT, self.tilt_tolerance_deg.to_radians(), off.tilt_rad),
            (bounds::FLOOR_CAMERA_SCALE, nominal * self.scale_tolerance, (true_pixels_per_m - nominal).abs()),
            (bounds::FLOOR_CAMERA_DISTORTION, self.distortion_tolerance_px, off.bent_px),
        ]
    }

    /// Offset of the joints in view from their nominal places, their angle and their bend.
    fn surroundings(&self, drawn: &DrawnCamera, scene: &Scene, surroundings: &Surroundings<'_>) -> Vec<WatchedBound> {
        let (Some(tiles), Some(laid)) = (&scene.floor.tiles, &surroundings.place.tiles) else { return Vec::new() };
        let names = [bounds::FLOOR_TILES_LAYING, bounds::FLOOR_TILES_LAYING_ANGLE, bounds::FLOOR_TILES_STRAIGHTNESS];
        let mut all = names.map(WatchedBound::new);
        let shortest_m = scene.room.width_m.min(scene.room.depth_m);
        let floor_m = GroundPlan::of(scene).extents_m();
        let declared = [
            tiles.laying_tolerance_m + tiles.corner_tolerance_m,
            2.0 * tiles.laying_tolerance_m / shortest_m,
            tiles.corner_tolerance_m,
        ];
        for look in surroundings.looks_of(Camera::Floor) {
            // The point on the floor below the camera.
            let below_m = world_from_camera(look.truth, drawn).translation.vector;
            let errors = laid.errors_near(tiles, floor_m, [below_m.x, below_m.y], self.half_diagonal_m());
            let off = [errors.offset_m, errors.angle_rad, errors.bend_m];
            for ((watched, declared), off) in all.iter_mut().zip(declared).zip(off) {
                watched.compare(look.span_s(), declared, off);
            }
        }
        all.into()
    }

    fn told_keys(&mut self) -> Vec<ToldKey<'_>> {
        let nominal_pixels_per_m = self.pixels_per_m();
        vec![
            ToldKey::is(&[bounds::FLOOR_CAMERA_POSITION], &mut self.position_tolerance_m),
            ToldKey::is_in_deg(&[bounds::FLOOR_CAMERA_YAW], &mut self.yaw_tolerance_deg),
            ToldKey::is_in_deg(&[bounds::FLOOR_CAMERA_TILT], &mut self.tilt_tolerance_deg),
            ToldKey::is_share_of(&[bounds::FLOOR_CAMERA_SCALE], &mut self.scale_tolerance, nominal_pixels_per_m),
            ToldKey::is(&[bounds::FLOOR_CAMERA_DISTORTION], &mut self.distortion_tolerance_px),
            ToldKey::is(&[bounds::FLOOR_CAMERA_STAMP], &mut self.stamp_tolerance_s),
        ]
    }
}

impl FloorCamera {
    /// Half of the diagonal of the floor that a picture shows.
    fn half_diagonal_m(&self) -> f64 {
        let height_m = self.footprint_width_m * f64::from(self.height_px) / f64::from(self.width_px);
        0.5 * self.footprint_width_m.hypot(height_m)
    }

    /// The model of the floor camera that the localizer is given.
    pub(crate) fn model(&self) -> FloorCameraModel {
        let place = |nominal_m: f64| Interval::centred(nominal_m, self.position_tolerance_m);
        FloorCameraModel {
            width_px: self.width_px,
            height_px: self.height_px,
            pixels_per_m: relative(self.pixels_per_m(), self.scale_tolerance),
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
}

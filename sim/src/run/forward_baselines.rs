//! Beside `wall_directions`: paper 2's vanishing points, and the features of its Fig. 1, on the same pictures.

use image::GrayImage;
use localizer::{
    Map, RobotModel,
    methods::wall_directions::ray,
    vision::forward::{
        Picture, features,
        vanishing::{Equalisation, azimuth_rad, segments_in, vanishing_points},
    },
};

/// Every so many pictures are looked at, and the one before each: the paper's chain takes several times as long as ours.
const EVERY: usize = 10;

/// What paper 2's chain and features made of a run's pictures.
#[derive(Clone, Debug, Default)]
pub struct ForwardBaselines {
    /// Pictures given to the paper's chain.
    pub n_asked: usize,
    /// Error of each heading that it told, quarter turns forgiven.
    pub errors_rad: Vec<f64>,
    /// Features matched between two successive pictures.
    pub matches: Vec<usize>,
    n_pictures: usize,
    before: Option<GrayImage>,
}

impl ForwardBaselines {
    /// Takes note of a picture that was taken at this heading; answers with the direction of walls that the paper's chain saw in it.
    pub(super) fn observe(
        &mut self,
        image: &GrayImage,
        map: &Map,
        robot: &RobotModel,
        true_heading_rad: f64,
    ) -> Option<f64> {
        let camera = robot.forward_camera?;
        self.n_pictures += 1;
        if (self.n_pictures + 1).is_multiple_of(EVERY) {
            self.before = Some(image.clone());
        }
        if !self.n_pictures.is_multiple_of(EVERY) {
            return None;
        }
        if let Some(before) = self.before.take() {
            self.matches.push(features::matches(&before, image).len());
        }
        self.n_asked += 1;
        let segments = segments_in(&Picture::from(image), Equalisation::Whole);
        let points = vanishing_points(&segments, |pixel| ray(pixel, &camera))?;
        let told_rad = azimuth_rad(&points, camera.tilt_up_rad) - camera.yaw_rad.mid();
        let turn_rad = told_rad - true_heading_rad;
        let quarter = std::f64::consts::FRAC_PI_2;
        let off = |direction_rad: f64| {
            let off_rad = turn_rad + direction_rad;
            (off_rad - (off_rad / quarter).round() * quarter).abs()
        };
        let nearest_rad =
            map.wall_directions_rad.iter().map(|direction| off(direction.mid())).fold(f64::INFINITY, f64::min);
        self.errors_rad.push(nearest_rad);
        // The robot's azimuth among the walls is theirs from the robot, with the other sign.
        Some(-told_rad)
    }
}

//! Baselines for the method `wall_directions` on the same pictures: paper 2's vanishing points, and the image features of the paper's Fig. 1.

use image::GrayImage;
use localizer::{
    Map, RobotModel,
    methods::wall_directions::ray,
    vision::forward::{
        Picture, features,
        vanishing::{Equalisation, azimuth_rad, segments_in, vanishing_points},
    },
};

/// Interval, in pictures, at which a picture is evaluated together with the one before it. Paper 2's vision chain takes several times as long as
/// the project's own method, so that it does not read every picture.
const EVERY: usize = 10;

/// Results of paper 2's vision chain, which finds the directions of walls, and of its image features on the pictures of one run.
#[derive(Clone, Debug, Default)]
pub struct ForwardBaselines {
    /// Number of pictures given to paper 2's vision chain.
    pub n_asked: usize,
    /// Error of each heading that paper 2's vision chain found, against the nearest wall direction and modulo a quarter turn.
    pub errors_rad: Vec<f64>,
    /// Number of image features matched between two successive pictures, for each pair that was evaluated.
    pub matches: Vec<usize>,
    n_pictures: usize,
    before: Option<GrayImage>,
}

impl ForwardBaselines {
    /// Names of the figures of paper 2's vision in a summary: median number of features matched between two pictures, share of the pictures of
    /// which a vanishing point gave a heading, and the median and 95 % quantile of that heading's error.
    pub const FIGURES: [&str; 4] = [
        "feature_matches_median",
        "vanishing_point_share",
        "vanishing_point_error_median_deg",
        "vanishing_point_error_p95_deg",
    ];

    /// Takes in a picture from the forward camera, taken at the given true heading. Returns the direction of the walls in the robot's frame as
    /// paper 2's vision chain found it, if the picture is one of those evaluated.
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
        // The heading of the robot relative to the walls, with the opposite sign, is the direction of the walls in the robot's frame.
        Some(-told_rad)
    }
}

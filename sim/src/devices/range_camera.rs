//! The range camera: a stereo camera that recognises landmarks by their codes and measures at which image column each of its two views sees them.

mod codes;
mod sensor;

use interval::Interval;
use localizer::{
    Map, Method, RobotModel,
    bounds::{self, Assumption},
    methods::range_landmarks::{Freedom, RangeLandmarks, Solver},
    robot::RangeCameraModel,
};

use crate::{
    scene::{Distribution, MethodName, RangeCamera, RangeLandmarksFreedom, RangeLandmarksSolver, Scene},
    truth::{
        STEP_S,
        randomness::{draw_tilt, draw_within, stream},
    },
};

use super::{Device, Sensor, ToldKey, farthest, relative};

pub use codes::CodeCuts;
pub use sensor::{RangeCameraSensor, world_from_range_camera};

/// Time of the first reading. It is late enough that no stamp lies before the start of the clock, whatever the stamp's error.
const FIRST_S: f64 = 0.1;

/// True mount and optics of the range camera.
#[derive(Clone, Copy, Debug)]
pub struct DrawnRangeCamera {
    /// Position of the first view's optical centre in the robot frame: forward and left.
    pub position_m: [f64; 2],
    /// Direction of the range camera's optical axis from robot forward, counter-clockwise.
    pub yaw_rad: f64,
    /// Rotation vector by which the sensor's vertical deviates from the body's, about robot x and robot y; its norm is within the tolerance.
    pub tilt_rad: [f64; 2],
    /// Focal length in pixels.
    pub focal_px: f64,
    /// Distance between the optical centres of the range camera's two views.
    pub baseline_m: f64,
    /// Bounds to which wrong landmark codes are cut in a counterfactual run, one that is simulated again with bounds kept to find what was to blame.
    pub cuts: CodeCuts,
}

impl Device for RangeCamera {
    type Drawn = DrawnRangeCamera;

    fn draw(&self, errors: Distribution, seed: u64) -> DrawnRangeCamera {
        let mut rng = stream(seed, "range_camera.mount");
        let mut around = |nominal: f64, tolerance: f64| nominal + draw_within(tolerance, errors, &mut rng);
        let position_m = [self.forward_m, self.left_m].map(|nominal_m| around(nominal_m, self.position_tolerance_m));
        let yaw_rad = around(self.yaw_deg.to_radians(), self.yaw_tolerance_deg.to_radians());
        let focal_px = around(self.focal_px, self.focal_px * self.focal_tolerance);
        let baseline_m = around(self.baseline_m, self.baseline_m * self.baseline_tolerance);
        let tilt_rad = draw_tilt(self.tilt_tolerance_deg, errors, &mut rng);
        DrawnRangeCamera { position_m, yaw_rad, tilt_rad, focal_px, baseline_m, cuts: CodeCuts::default() }
    }

    fn sensor(&self, drawn: &DrawnRangeCamera, scene: &Scene, seed: u64) -> Option<Box<dyn Sensor>> {
        Some(Box::new(RangeCameraSensor::new(self, drawn, scene, seed)))
    }

    fn method(&self, _name: MethodName, scene: &Scene, _map: &Map, robot: &RobotModel) -> Option<Box<dyn Method>> {
        let freedom = match scene.localizer.range_landmarks_freedom {
            RangeLandmarksFreedom::Line => Freedom::Line,
            RangeLandmarksFreedom::Translation => Freedom::Translation,
            RangeLandmarksFreedom::Full => Freedom::Full,
        };
        let solver = match scene.localizer.range_landmarks_solver {
            RangeLandmarksSolver::OneShot => Solver::OneShot,
            RangeLandmarksSolver::Polar => Solver::Polar,
            RangeLandmarksSolver::TableIv => Solver::TableIv,
            RangeLandmarksSolver::Sivia => Solver::Sivia { resolution: 0.05 },
        };
        Some(Box::new(RangeLandmarks::new(robot, freedom, solver)?))
    }

    fn first_arrival_s(&self) -> f64 {
        FIRST_S + self.latency_s + self.latency_tolerance_s
    }

    fn is_relied_on(&self, scene: &Scene) -> bool {
        scene.localizer.methods.contains(&MethodName::RangeLandmarks)
    }

    fn constants(&self, drawn: &DrawnRangeCamera, scene: &Scene) -> Vec<(Assumption, f64, f64)> {
        let off_m = farthest(drawn.position_m, [self.forward_m, self.left_m]);
        let highest_m =
            scene.landmarks.iter().map(|landmark| (landmark.height_m - self.height_m).abs()).fold(0.0, f64::max);
        vec![
            (bounds::RANGE_CAMERA_FOCAL, self.focal_px * self.focal_tolerance, (drawn.focal_px - self.focal_px).abs()),
            (
                bounds::RANGE_CAMERA_BASELINE,
                self.baseline_m * self.baseline_tolerance,
                (drawn.baseline_m - self.baseline_m).abs(),
            ),
            (bounds::RANGE_CAMERA_POSITION, self.position_tolerance_m, off_m),
            (
                bounds::RANGE_CAMERA_YAW,
                self.yaw_tolerance_deg.to_radians(),
                (drawn.yaw_rad - self.yaw_deg.to_radians()).abs(),
            ),
            (
                bounds::RANGE_CAMERA_TILT,
                self.tilt_tolerance_deg.to_radians(),
                drawn.tilt_rad[0].hypot(drawn.tilt_rad[1]),
            ),
            (bounds::RANGE_CAMERA_HEIGHT_SPAN, self.height_span_m, highest_m),
        ]
    }

    fn told_keys(&mut self) -> Vec<ToldKey<'_>> {
        vec![
            ToldKey::is_share_of(&[bounds::RANGE_CAMERA_FOCAL], &mut self.focal_tolerance, self.focal_px),
            ToldKey::is_share_of(&[bounds::RANGE_CAMERA_BASELINE], &mut self.baseline_tolerance, self.baseline_m),
            ToldKey::is(&[bounds::RANGE_CAMERA_POSITION], &mut self.position_tolerance_m),
            ToldKey::is_in_deg(&[bounds::RANGE_CAMERA_YAW], &mut self.yaw_tolerance_deg),
            ToldKey::is_in_deg(&[bounds::RANGE_CAMERA_TILT], &mut self.tilt_tolerance_deg),
            ToldKey::is(&[bounds::RANGE_CAMERA_HEIGHT_SPAN], &mut self.height_span_m),
            ToldKey::is(&[bounds::RANGE_CAMERA_STAMP], &mut self.stamp_tolerance_s),
            ToldKey::is(&[bounds::RANGE_CAMERA_LATENCY], &mut self.latency_tolerance_s),
            ToldKey::is(&[bounds::RANGE_CAMERA_COLUMNS], &mut self.column_noise_px),
        ]
    }

    /// Codes are drawn reading by reading, so that the sensor itself leaves out codes that are wrong beyond what is declared.
    const CLIPPED: &'static [Assumption] =
        &[bounds::RANGE_CAMERA_HEIGHT_SPAN, bounds::RANGE_LANDMARKS_Q_ITEMS, bounds::RANGE_LANDMARKS_WRONG_SPACING];

    fn clip(&self, drawn: &mut DrawnRangeCamera, bound: &str) {
        drawn.cuts.items |= bound == bounds::RANGE_LANDMARKS_Q_ITEMS;
        drawn.cuts.spacing |= bound == bounds::RANGE_LANDMARKS_WRONG_SPACING;
    }
}

impl RangeCamera {
    /// The model of the range camera that the localizer is given.
    pub(crate) fn model(&self) -> RangeCameraModel {
        let place = |nominal_m: f64| Interval::centred(nominal_m, self.position_tolerance_m);
        RangeCameraModel {
            focal_px: relative(self.focal_px, self.focal_tolerance),
            baseline_m: relative(self.baseline_m, self.baseline_tolerance),
            centre_px: self.centre_px(),
            // The model's step is twice the greatest error of an image column. A rounding step is already twice the greatest error that rounding
            // causes; noise before rounding adds to the error on both sides.
            step_px: [self.column_step_px, self.match_step_px].map(|step_px| step_px + 2.0 * self.column_noise_px),
            position_m: [place(self.forward_m), place(self.left_m)],
            height_m: self.height_m,
            yaw_rad: Interval::centred(self.yaw_deg.to_radians(), self.yaw_tolerance_deg.to_radians()),
            tilt_rad: self.tilt_tolerance_deg.to_radians(),
            height_span_m: self.height_span_m,
            stamp_error_s: self.stamp_tolerance_s,
            latency_s: Interval::centred(self.latency_s, self.latency_tolerance_s)
                .intersect(Interval::new(0.0, f64::INFINITY)),
            // The camera measures at the first physics step after each period, so that the time between two readings may be one step shorter than the
            // period.
            period_s: self.period_s - STEP_S,
            q_items: self.q_items,
            wrong_spacing: self.wrong_spacing,
        }
    }
}

//! The true values that a seed draws inside the declared bounds. The localizer never sees them.

use localizer::Pose;
use nalgebra::Isometry3;
use rand::{Rng, RngExt};
use rand_distr::{Distribution as _, StandardNormal};

use crate::scene::Distribution;

pub mod cameras;
mod clip;
mod draw;
pub mod markers;
mod repeated;
pub mod tiles;
mod walls;

pub use markers::{DrawnDot, DrawnMarker};
pub use repeated::Repeated;
pub(crate) use repeated::draw_phase;
pub use tiles::LaidTiles;
pub(crate) use walls::turn_from_nearest_deg;

/// Everything about a run that is drawn once, before it starts.
#[derive(Clone, Debug)]
pub struct Drawn {
    /// True pose at time 0.
    pub start: Pose,
    /// True rolling radius of the left and of the right wheel.
    pub wheel_radius_m: [f64; 2],
    /// True distance between the contact points.
    pub track_m: f64,
    /// By how much the stamps of wheels, gyroscope and flow sensor are late.
    pub base_clock_s: f64,
    /// True mount and lens of the floor camera.
    pub floor_camera: Option<DrawnFloorCamera>,
    /// True mount and lens of the forward camera.
    pub forward_camera: Option<DrawnCamera>,
    /// True mount and lens of the ceiling camera.
    pub ceiling_camera: Option<DrawnCamera>,
    /// True mount and optics of the range camera.
    pub range_camera: Option<DrawnRangeCamera>,
    /// True bias and scale of the gyroscope.
    pub gyro: Option<DrawnGyro>,
    /// True mount and scale of the flow sensor.
    pub flow: Option<DrawnFlow>,
    /// The tiles as they were laid.
    pub tiles: Option<LaidTiles>,
    /// By how much each piece of furniture is turned against where the scene has it.
    pub furniture_turn_deg: Vec<f64>,
    /// By how much all walls, with what hangs on them, are turned about the middle of the robot's room against where the scene has them.
    pub walls_turn_deg: f64,
    /// Goals of random errands, world; nothing secret, and the driver is told.
    pub goals_m: Vec<[f64; 2]>,
    /// The markers that are on the ceiling, as they were pasted.
    pub markers: Vec<DrawnMarker>,
}

/// True mount and lens of the floor camera.
#[derive(Clone, Copy, Debug)]
pub struct DrawnFloorCamera {
    /// Optical centre in the robot frame: forward and left.
    pub position_m: [f64; 2],
    /// Optical centre above the floor with the body at rest.
    pub height_m: f64,
    /// Focal length, so that `focal_px / height_m` is the true scale at rest.
    pub focal_px: f64,
    /// Rotation of the image about the body's vertical, counter-clockwise seen from above.
    pub yaw_rad: f64,
    /// Rotation vector of the optical axis off the body's vertical, about robot x and robot y; its norm is within the tolerance.
    pub tilt_rad: [f64; 2],
    /// Brown and Conrady's k1, k2, p1, p2, k3.
    pub distortion: [f64; 5],
}

/// True mount and lens of a camera that looks ahead or up.
#[derive(Clone, Copy, Debug)]
pub struct DrawnCamera {
    /// Pose in the robot frame.
    pub body_from_camera: Isometry3<f64>,
    /// Focal lengths along u and v.
    pub focal_px: [f64; 2],
    /// Where the optical axis meets the image.
    pub principal_point_px: [f64; 2],
    /// Brown and Conrady's k1, k2, p1, p2, k3.
    pub distortion: [f64; 5],
}

/// True mount and optics of the range camera.
#[derive(Clone, Copy, Debug)]
pub struct DrawnRangeCamera {
    /// Optical centre of the first view in the robot frame: forward and left.
    pub position_m: [f64; 2],
    /// Direction of the optical axis from robot forward, counter-clockwise.
    pub yaw_rad: f64,
    /// Rotation vector of the sensor's vertical off the body's, about robot x and robot y; its norm is within the tolerance.
    pub tilt_rad: [f64; 2],
    /// Focal length.
    pub focal_px: f64,
    /// Distance between the optical centres.
    pub baseline_m: f64,
}

/// True mount and scale of the flow sensor.
#[derive(Clone, Copy, Debug)]
pub struct DrawnFlow {
    /// Where it looks in the robot frame: forward and left.
    pub position_m: [f64; 2],
    /// Turn of its forward axis from the robot's, counter-clockwise.
    pub yaw_rad: f64,
    /// Counts per metre over nominal, at the mounted height.
    pub scale: f64,
}

/// True bias and scale of the gyroscope.
#[derive(Clone, Copy, Debug)]
pub struct DrawnGyro {
    /// At time 0; constant over a run unless it is said to wander.
    pub bias_rad_per_s: f64,
    /// Constant over a run.
    pub scale: f64,
    /// Which bounds its noise is cut to, in a run as it should have been.
    pub cuts: GyroCuts,
}

/// Bounds of a gyroscope beyond which nothing of its noise is left; none of them in a run as a seed draws it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct GyroCuts {
    /// `gyro.noise`, of each reading.
    pub noise: bool,
    /// `gyro.angle`, of what errors of readings add up to.
    pub angle: bool,
}

/// Draws an error within ±tolerance that stays the same all the run.
pub fn draw_within(tolerance: f64, distribution: Distribution, rng: &mut impl Rng) -> f64 {
    match distribution {
        Distribution::Uniform => tolerance * rng.random_range(-1.0..=1.0),
        Distribution::TruncatedGaussian => loop {
            // Half the tolerance is one standard deviation; one draw in 22 is outside and drawn again.
            let deviations: f64 = StandardNormal.sample(rng);
            if deviations.abs() <= 2.0 {
                return tolerance * deviations / 2.0;
            }
        },
        Distribution::Corner | Distribution::Drift => {
            if rng.random() {
                tolerance
            } else {
                -tolerance
            }
        }
    }
}

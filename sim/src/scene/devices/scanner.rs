//! Keys of a planar range scanner.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use serde_json::json;

use super::Careful;

/// A planar range scanner: beams in one plane, each of which measures the distance of what it meets, such as the laser scanner of a vacuum cleaner or
/// a forklift. All beams of a scan measure at the same instant. The program that drives the robot to its goals stops before what a scan shows, and
/// the method `wall_ranges` locates the robot by it.
#[derive(Clone, Debug, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Scanner {
    /// Angle that the scanner's beams cover, half of it to either side of the scanner's forward axis.
    #[schemars(range(min = 1.0, max = 360.0))]
    pub field_deg: f64,
    /// Number of the scanner's beams. The outermost ones lie at the edges of the field.
    #[schemars(range(min = 2, max = 2000))]
    pub beams: usize,
    /// Range of the beams. Things farther away are not noticed.
    #[schemars(range(min = 0.1, max = 50.0))]
    pub range_m: f64,
    /// Height of the scanner above the floor. Things lower than this are not noticed.
    #[schemars(range(min = 0.01, max = 2.0))]
    pub height_m: f64,
    /// Distance of the scanner forward of the wheel axle, in the robot frame.
    #[schemars(range(min = -2.0, max = 2.0))]
    pub forward_m: f64,
    /// Distance of the scanner to the left of the robot's middle, in the robot frame.
    #[schemars(range(min = -2.0, max = 2.0))]
    pub left_m: f64,
    /// Direction of the scanner's forward axis, counter-clockwise from robot forward.
    #[schemars(range(min = -180.0, max = 180.0))]
    pub yaw_deg: f64,
    /// Time between two scans.
    #[schemars(range(min = 0.01, max = 1.0))]
    pub period_s: f64,
    /// Time from the measurement of a scan to its delivery.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub latency_s: f64,
    /// Bound `scanner.range`: greatest error of a measured distance, drawn at random for each beam.
    #[schemars(range(min = 0.0, max = 0.5))]
    pub tolerance_m: f64,
    /// Bound `scanner.position`: greatest error of the scanner's mounted position, forward and left each; drawn at random.
    #[schemars(range(min = 0.0, max = 0.1))]
    pub position_tolerance_m: f64,
    /// Bounds `scanner.yaw` and `scanner.tilt`: greatest error of the scanner's mounted direction, and greatest angle between the plane of its beams
    /// and the body's level plane; drawn at random.
    #[schemars(range(min = 0.0, max = 10.0))]
    pub angle_tolerance_deg: f64,
    /// Bound `scanner.stamp`: greatest error of a scan's stamp against the true time, drawn at random for each scan.
    #[schemars(range(min = 0.0, max = 0.1))]
    pub stamp_tolerance_s: f64,
}

impl Scanner {
    /// Bounds on the scanner that a careful user can know from a data sheet and an afternoon of measuring.
    pub(super) fn careful() -> Careful {
        Careful::each(json!({
            "tolerance_m": 0.03, "position_tolerance_m": 0.003, "angle_tolerance_deg": 0.5, "stamp_tolerance_s": 0.001,
        }))
    }
}

impl Default for Scanner {
    /// A small scanner for service robots over the middle of the robot: 240 degrees in steps of 3.
    fn default() -> Self {
        Scanner {
            field_deg: 240.0,
            beams: 81,
            range_m: 2.5,
            height_m: 0.2,
            forward_m: 0.0,
            left_m: 0.0,
            yaw_deg: 0.0,
            period_s: 0.05,
            latency_s: 0.0,
            tolerance_m: 0.01,
            position_tolerance_m: 0.001,
            angle_tolerance_deg: 0.1,
            stamp_tolerance_s: 0.0005,
        }
    }
}

//! The range camera for coded landmarks, with the tolerance of its errors.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use serde_json::json;

use super::Careful;

/// A stereo or structured-light camera that measures coded landmarks, looking forward over the floor.
///
/// A stereo camera rounds the column of both views to a pixel; a structured-light one knows the projector's stripe much more finely.
#[derive(Clone, Debug, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct RangeCamera {
    /// Columns of each view.
    #[schemars(range(min = 16, max = 10000))]
    pub width_px: u32,
    /// Nominal focal length.
    #[schemars(range(min = 10.0, max = 10000.0))]
    pub focal_px: f64,
    /// The focal length is drawn within this share of nominal.
    #[schemars(range(min = 0.0, max = 0.1))]
    pub focal_tolerance: f64,
    /// Nominal distance between the two views.
    #[schemars(range(min = 0.005, max = 2.0))]
    pub baseline_m: f64,
    /// The baseline is drawn within this share of nominal.
    #[schemars(range(min = 0.0, max = 0.1))]
    pub baseline_tolerance: f64,
    /// Step to which the column in the first (left) view is rounded.
    #[schemars(range(min = 0.001, max = 10.0))]
    pub column_step_px: f64,
    /// Step to which the column in the second view, or the projector's stripe, is rounded.
    #[schemars(range(min = 0.001, max = 10.0))]
    pub match_step_px: f64,
    /// `range_camera.columns`: before it is rounded, the column in either view is off by up to this, drawn anew for each.
    #[schemars(range(min = 0.0, max = 10.0))]
    pub column_noise_px: f64,
    /// Optical centre of the first view in the robot frame, forward of the axle.
    #[schemars(range(min = -2.0, max = 2.0))]
    pub forward_m: f64,
    /// Optical centre of the first view in the robot frame, left of the middle.
    #[schemars(range(min = -2.0, max = 2.0))]
    pub left_m: f64,
    /// Height of the optical centres above the floor.
    #[schemars(range(min = 0.02, max = 5.0))]
    pub height_m: f64,
    /// Nominal direction of the optical axis from robot forward, counter-clockwise. Any angle.
    pub yaw_deg: f64,
    /// Nearer landmarks are not measured.
    #[schemars(range(min = 0.0, max = 100.0))]
    pub least_range_m: f64,
    /// Farther landmarks are not measured.
    #[schemars(range(max = 100.0), extend("exclusiveMinimum" = 0.0))]
    pub greatest_range_m: f64,
    /// Time between two readings.
    #[schemars(range(min = 0.01, max = 100.0))]
    pub period_s: f64,
    /// Measurement to delivery.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub latency_s: f64,
    /// `range_camera.latency`: each delivery is drawn within this of the latency. Readings overtake one another where it is half of the period
    /// and more: landmarks are then learnt only from readings before which none can come any more.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub latency_tolerance_s: f64,
    /// Each stamp is drawn within this of the true time.
    #[schemars(range(min = 0.0, max = 0.1))]
    pub stamp_tolerance_s: f64,
    /// The mount is drawn within this of its nominal place, forward and left each.
    #[schemars(range(min = 0.0, max = 0.1))]
    pub position_tolerance_m: f64,
    /// The mount's yaw is drawn within this.
    #[schemars(range(min = 0.0, max = 10.0))]
    pub yaw_tolerance_deg: f64,
    /// The angle of the sensor's vertical to the body's is drawn within this, in any direction.
    #[schemars(range(min = 0.0, max = 10.0))]
    pub tilt_tolerance_deg: f64,
    /// Landmarks are declared to be within this of the sensor's height.
    #[schemars(range(min = 0.0, max = 10.0))]
    pub height_span_m: f64,
    /// Share of sightings that are given the code of another landmark.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub wrong_share: f64,
    /// At most this many of them in one reading, whatever the share.
    #[schemars(range(min = 0, max = 100))]
    pub wrong_items_max: usize,
    /// At least so many right uses of a code lie between two wrong ones, in the order in which they were measured. With 0 any may be wrong,
    /// and where `q_items` is more than 0, no landmark is ever learnt.
    #[schemars(range(min = 0, max = 100))]
    pub wrong_spacing: usize,
    /// At most this many wrong correspondences are assumed in one reading.
    #[schemars(range(min = 0, max = 100))]
    pub q_items: usize,
}

impl RangeCamera {
    /// Column of the optical axis; (0, 0) is the centre of the first pixel.
    pub fn centre_px(&self) -> f64 {
        0.5 * (f64::from(self.width_px) - 1.0)
    }
}

impl Default for RangeCamera {
    /// The geometry of the first Kinect, matched to whole pixels.
    fn default() -> Self {
        RangeCamera {
            width_px: 640,
            focal_px: 580.0,
            focal_tolerance: 0.002,
            baseline_m: 0.075,
            baseline_tolerance: 0.002,
            column_step_px: 1.0,
            match_step_px: 1.0,
            column_noise_px: 0.0,
            forward_m: 0.10,
            left_m: 0.0375,
            height_m: 0.5,
            yaw_deg: 0.0,
            least_range_m: 0.5,
            greatest_range_m: 5.0,
            period_s: 0.2,
            latency_s: 0.05,
            latency_tolerance_s: 0.005,
            stamp_tolerance_s: 0.0005,
            position_tolerance_m: 0.002,
            yaw_tolerance_deg: 0.2,
            tilt_tolerance_deg: 0.2,
            height_span_m: 0.3,
            wrong_share: 0.0,
            wrong_items_max: 2,
            wrong_spacing: 4,
            q_items: 0,
        }
    }
}

impl RangeCamera {
    /// What a careful user can know of it.
    pub(super) fn careful() -> Careful {
        Careful::each(json!({
            "stamp_tolerance_s": 0.001, "position_tolerance_m": 0.002, "yaw_tolerance_deg": 0.3, "tilt_tolerance_deg": 0.3,
            "focal_tolerance": 0.003, "baseline_tolerance": 0.003, "column_noise_px": 0.3,
        }))
    }
}

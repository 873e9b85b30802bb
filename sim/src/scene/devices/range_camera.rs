//! Keys of the range camera, which measures where landmarks with a code are, and the tolerances of its errors.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use serde_json::json;

use super::Careful;

/// A stereo or structured-light camera that looks forward over the floor and measures the direction and distance of landmarks, which it tells apart
/// by a code on them.
///
/// It sees each landmark at one pixel column in each of two views. A stereo camera rounds both columns to a pixel. In a structured-light camera a
/// projector takes the place of the second view, and the column of the projected stripe is known much more finely.
#[derive(Clone, Debug, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct RangeCamera {
    /// Number of pixel columns in each view of the range camera.
    #[schemars(range(min = 16, max = 10000))]
    pub width_px: u32,
    /// Nominal focal length.
    #[schemars(range(min = 10.0, max = 10000.0))]
    pub focal_px: f64,
    /// Greatest error of the focal length, as a share of its nominal value; drawn at random.
    #[schemars(range(min = 0.0, max = 0.1))]
    pub focal_tolerance: f64,
    /// Nominal distance between the two views.
    #[schemars(range(min = 0.005, max = 2.0))]
    pub baseline_m: f64,
    /// Greatest error of the baseline, as a share of its nominal value; drawn at random.
    #[schemars(range(min = 0.0, max = 0.1))]
    pub baseline_tolerance: f64,
    /// Step to which a landmark's pixel column in the first (left) view is rounded.
    #[schemars(range(min = 0.001, max = 10.0))]
    pub column_step_px: f64,
    /// Step to which a landmark's pixel column in the second view, or the column of the projector's stripe, is rounded.
    #[schemars(range(min = 0.001, max = 10.0))]
    pub match_step_px: f64,
    /// Bound `range_camera.columns`: greatest error of a landmark's column in either view, before the column is rounded; drawn at random for each.
    #[schemars(range(min = 0.0, max = 10.0))]
    pub column_noise_px: f64,
    /// Distance of the optical centre of the range camera's first view forward of the wheel axle, in the robot frame.
    #[schemars(range(min = -2.0, max = 2.0))]
    pub forward_m: f64,
    /// Distance of the optical centre of the range camera's first view to the left of the robot's middle, in the robot frame.
    #[schemars(range(min = -2.0, max = 2.0))]
    pub left_m: f64,
    /// Height of the optical centres of both views above the floor.
    #[schemars(range(min = 0.02, max = 5.0))]
    pub height_m: f64,
    /// Nominal direction of the optical axis, counter-clockwise from robot forward. Any angle.
    pub yaw_deg: f64,
    /// Least distance at which the range camera measures landmarks.
    #[schemars(range(min = 0.0, max = 100.0))]
    pub least_range_m: f64,
    /// Greatest distance at which the range camera measures landmarks.
    #[schemars(range(max = 100.0), extend("exclusiveMinimum" = 0.0))]
    pub greatest_range_m: f64,
    /// Time between two readings.
    #[schemars(range(min = 0.01, max = 100.0))]
    pub period_s: f64,
    /// Time from a measurement to the delivery of its reading.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub latency_s: f64,
    /// Bound `range_camera.latency`: greatest difference of a reading's actual latency from `latency_s`, drawn at random for each reading. If this is
    /// half of `period_s` or more, readings overtake one another; with `q_items` above 0, the positions of landmarks are then learnt from a reading
    /// only once no reading measured before it can still arrive.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub latency_tolerance_s: f64,
    /// Greatest error of a reading's stamp against the true time, drawn at random for each reading.
    #[schemars(range(min = 0.0, max = 0.1))]
    pub stamp_tolerance_s: f64,
    /// Greatest error of the range camera's mounted position, forward and left each; drawn at random.
    #[schemars(range(min = 0.0, max = 0.1))]
    pub position_tolerance_m: f64,
    /// Greatest error of the range camera's yaw on its mount; drawn at random.
    #[schemars(range(min = 0.0, max = 10.0))]
    pub yaw_tolerance_deg: f64,
    /// Greatest angle of the range camera's vertical to the body's, in any direction; drawn at random.
    #[schemars(range(min = 0.0, max = 10.0))]
    pub tilt_tolerance_deg: f64,
    /// Greatest difference between the height of a landmark and that of the range camera, as declared to the localizer.
    #[schemars(range(min = 0.0, max = 10.0))]
    pub height_span_m: f64,
    /// Share of the sightings of landmarks that the range camera reports with the code of another landmark.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub wrong_share: f64,
    /// Greatest number of landmarks in one reading that are reported with a wrong code, whatever `wrong_share` is.
    #[schemars(range(min = 0, max = 100))]
    pub wrong_items_max: usize,
    /// Least number of times that a landmark's code is reported rightly between two times that it is reported for another landmark, in the order of
    /// measurement. With 0 any report of a code may be wrong, and if `q_items` is more than 0 the localizer never learns the position of a landmark.
    #[schemars(range(min = 0, max = 100))]
    pub wrong_spacing: usize,
    /// Greatest number of landmarks in one reading that the localizer assumes to be reported with a wrong code.
    #[schemars(range(min = 0, max = 100))]
    pub q_items: usize,
}

impl RangeCamera {
    /// Column of the optical axis in each view; 0 is the centre of the first pixel.
    pub fn centre_px(&self) -> f64 {
        0.5 * (f64::from(self.width_px) - 1.0)
    }
}

impl Default for RangeCamera {
    /// The geometry of the first Kinect, with columns rounded to whole pixels.
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
    /// Bounds on the range camera that a careful user can know from a data sheet and an afternoon of measuring.
    pub(super) fn careful() -> Careful {
        Careful::each(json!({
            "stamp_tolerance_s": 0.001, "position_tolerance_m": 0.002, "yaw_tolerance_deg": 0.3, "tilt_tolerance_deg": 0.3,
            "focal_tolerance": 0.003, "baseline_tolerance": 0.003, "column_noise_px": 0.3,
        }))
    }
}

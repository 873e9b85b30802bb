//! Keys of the optical flow sensor.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use serde_json::json;

use super::Careful;

/// A sensor that follows the texture of the floor below it and counts its own travel along two axes, as an optical mouse does.
#[derive(Clone, Debug, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Flow {
    /// Optics of the flow sensor, which decide how its counts per metre change with the height above the floor.
    pub optics: FlowOptics,
    /// Counts per metre of travel at the height at which the flow sensor is mounted.
    #[schemars(range(min = 100.0, max = 1000000.0))]
    pub counts_per_m: f64,
    /// Time between two readings of the flow sensor; a multiple of 0.001.
    #[schemars(range(min = 0.001, max = 1.0))]
    pub period_s: f64,
    /// Distance, forward of the wheel axle in the robot frame, of the place that the flow sensor looks at.
    #[schemars(range(min = -2.0, max = 2.0))]
    pub forward_m: f64,
    /// Distance, to the left of the robot's middle in the robot frame, of the place that the flow sensor looks at.
    #[schemars(range(min = -2.0, max = 2.0))]
    pub left_m: f64,
    /// Greatest error of the flow sensor's mounted position, forward and left each; drawn at random.
    #[schemars(range(min = 0.0, max = 0.1))]
    pub position_tolerance_m: f64,
    /// Greatest error of the flow sensor's yaw on its mount; drawn at random.
    #[schemars(range(min = 0.0, max = 10.0))]
    pub yaw_tolerance_deg: f64,
    /// Bound `flow.calibration`: greatest relative error of the flow sensor's counts per metre at its mounted height. The error is drawn at random
    /// and stays the same all the run.
    #[schemars(range(min = 0.0, max = 0.5))]
    pub calibration_tolerance: f64,
    /// Greatest declared relative error of the flow sensor's counts per metre, from all causes and at any height. Bound `flow.scale`: what is left of
    /// it after `calibration_tolerance` is subtracted. By this much the counts per metre may vary from period to period, as the height does.
    #[schemars(range(min = 0.0, max = 0.9))]
    pub scale_tolerance: f64,
    /// Greatest relative error of the flow sensor's counts per metre that a surface causes; drawn at random for every region of the floor and for the
    /// floor around them. Together with `noise_tolerance` it may be at most `scale_tolerance` minus `calibration_tolerance`.
    #[schemars(range(min = 0.0, max = 0.5))]
    pub surface_tolerance: f64,
    /// Greatest further relative error of the flow sensor's counts per metre in one period; drawn at random for each period. Together with
    /// `surface_tolerance` it may be at most `scale_tolerance` minus `calibration_tolerance`.
    #[schemars(range(min = 0.0, max = 0.5))]
    pub noise_tolerance: f64,
    /// Bound `flow.back_and_forth`: greatest difference, in one period and along each axis of the flow sensor, between the length of the path
    /// travelled to and fro and the net travel, which is all that the counts show.
    #[schemars(range(min = 0.0, max = 0.1))]
    pub back_and_forth_m: f64,
    /// Greatest speed over the floor that the flow sensor can follow.
    #[schemars(range(max = 20.0), extend("exclusiveMinimum" = 0.0))]
    pub greatest_speed_m_per_s: f64,
    /// Greatest difference between the flow sensor's actual and mounted height above the floor at which it still sees the floor.
    #[schemars(range(max = 1.0), extend("exclusiveMinimum" = 0.0))]
    pub focus_range_m: f64,
}

/// Optics of the flow sensor, which decide how its counts per metre change with the height above the floor.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum FlowOptics {
    /// Afocal optics: the image keeps its size to 0.1 % per millimetre of height.
    #[default]
    Afocal,
    /// One lens at a fixed distance, as in a mouse: the image changes its size by 14.7 % per millimetre of height.
    FixedFocus,
}

impl Flow {
    /// Greatest relative error of the flow sensor's counts per metre at its mounted height.
    pub fn calibration_share(&self) -> f64 {
        self.calibration_tolerance.min(self.scale_tolerance)
    }

    /// Greatest change of the flow sensor's counts per metre from those at its mounted height, as a share of their nominal number.
    pub fn varying_share(&self) -> f64 {
        self.scale_tolerance - self.calibration_share()
    }
}

impl FlowOptics {
    /// Share by which the flow sensor's counts per metre grow for each metre by which the floor comes closer. From the abstract of Yi et al. 2015, as
    /// paper 2 cites it.
    pub fn share_per_m(self) -> f64 {
        match self {
            FlowOptics::Afocal => 1.0,
            FlowOptics::FixedFocus => 147.0,
        }
    }
}

impl Default for Flow {
    /// An afocal sensor with 508 counts per inch, 60 mm behind the axle.
    fn default() -> Self {
        Flow {
            optics: FlowOptics::Afocal,
            counts_per_m: 20_000.0,
            period_s: 0.01,
            forward_m: -0.06,
            left_m: 0.0,
            position_tolerance_m: 0.0005,
            yaw_tolerance_deg: 0.1,
            calibration_tolerance: 0.001,
            scale_tolerance: 0.003,
            surface_tolerance: 0.0,
            noise_tolerance: 0.0,
            back_and_forth_m: 0.0001,
            greatest_speed_m_per_s: 1.0,
            focus_range_m: 0.01,
        }
    }
}

impl Flow {
    /// Bounds on the flow sensor that a careful user can know from a data sheet and an afternoon of measuring.
    pub(super) fn careful() -> Careful {
        Careful {
            keys: json!({
                "position_tolerance_m": 0.002, "yaw_tolerance_deg": 0.3, "calibration_tolerance": 0.01,
                "surface_tolerance": 0.01, "noise_tolerance": 0.005, "scale_tolerance": 0.03,
            }),
            together: &["calibration_tolerance", "surface_tolerance", "noise_tolerance", "scale_tolerance"],
        }
    }
}

//! The optical flow sensor.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use serde_json::json;

use super::Careful;

/// A sensor that follows the floor's texture below it and counts its own travel along two axes, as an optical mouse does.
#[derive(Clone, Debug, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Flow {
    /// What its counts make of a change of height.
    pub optics: FlowOptics,
    /// Counts in a metre, at the height that it is mounted at.
    #[schemars(range(min = 100.0, max = 1000000.0))]
    pub counts_per_m: f64,
    /// Time between two readings; a multiple of 0.001.
    #[schemars(range(min = 0.001, max = 1.0))]
    pub period_s: f64,
    /// Where it looks in the robot frame, forward of the axle.
    #[schemars(range(min = -2.0, max = 2.0))]
    pub forward_m: f64,
    /// Where it looks in the robot frame, left of the middle.
    #[schemars(range(min = -2.0, max = 2.0))]
    pub left_m: f64,
    /// The mount is drawn within this of its nominal place, forward and left each.
    #[schemars(range(min = 0.0, max = 0.1))]
    pub position_tolerance_m: f64,
    /// The mount's yaw is drawn within this.
    #[schemars(range(min = 0.0, max = 10.0))]
    pub yaw_tolerance_deg: f64,
    /// `flow.calibration`: counts per metre at the mounted height are drawn within this share of nominal, and stay so all the run.
    #[schemars(range(min = 0.0, max = 0.5))]
    pub calibration_tolerance: f64,
    /// Counts per metre are declared to be within this share of nominal, whatever the height. `flow.scale`: of it, what
    /// `calibration_tolerance` leaves may vary from period to period, as the height does.
    #[schemars(range(min = 0.0, max = 0.9))]
    pub scale_tolerance: f64,
    /// Each surface, which is every region of the floor and what is around them, has its own counts per metre, drawn within this share: part
    /// of what `scale_tolerance` leaves beside the calibration.
    #[schemars(range(min = 0.0, max = 0.5))]
    pub surface_tolerance: f64,
    /// In each period counts per metre are besides off by up to this share, drawn anew: part of it too.
    #[schemars(range(min = 0.0, max = 0.5))]
    pub noise_tolerance: f64,
    /// `flow.back_and_forth`: how much longer than its counts the way within one period is declared to be at most.
    #[schemars(range(min = 0.0, max = 0.1))]
    pub back_and_forth_m: f64,
    /// It follows nothing that passes faster.
    #[schemars(range(max = 20.0), extend("exclusiveMinimum" = 0.0))]
    pub greatest_speed_m_per_s: f64,
    /// It sees nothing that is farther than this above or below the height that it is mounted for.
    #[schemars(range(max = 1.0), extend("exclusiveMinimum" = 0.0))]
    pub focus_range_m: f64,
}

/// Optics of a flow sensor.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum FlowOptics {
    /// Afocal: the image keeps its size, 0.1 % per millimetre of height.
    #[default]
    Afocal,
    /// One lens at a fixed distance, as in a mouse: 14.7 % per millimetre of height.
    FixedFocus,
}

impl Flow {
    /// Share of nominal by which counts per metre at the mounted height are off at most.
    pub fn calibration_share(&self) -> f64 {
        self.calibration_tolerance.min(self.scale_tolerance)
    }

    /// Share of nominal by which counts per metre depart at most from those at the mounted height.
    pub fn varying_share(&self) -> f64 {
        self.scale_tolerance - self.calibration_share()
    }
}

impl FlowOptics {
    /// Share of counts gained per metre that the floor comes closer: Yi et al. 2015, abstract, as paper 2 cites it.
    pub fn share_per_m(self) -> f64 {
        match self {
            FlowOptics::Afocal => 1.0,
            FlowOptics::FixedFocus => 147.0,
        }
    }
}

impl Default for Flow {
    /// An afocal sensor of 508 counts an inch, 60 mm behind the axle.
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
    /// What a careful user can know of it.
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

//! The robot: dimensions, encoders, floor camera, each with the tolerance of its errors.

use schemars::JsonSchema;
use serde::{Deserialize, Deserializer, Serialize};

use super::{
    CameraTiming, CeilingCamera, Delivery, Flow, ForwardCamera, Gyro, LensKeys, Proximity, RangeCamera, Sensor,
    SensorModel, SensorPreset,
};

/// A differential-drive robot. Frame `robot`: x forward, y left, z up, origin under the middle of the wheel axle. The defaults of its
/// keys are the P3-DX's unless another preset is stated.
#[derive(Clone, Debug, Deserialize, Serialize, JsonSchema)]
// `Robot` deserialises by way of its preset; what is derived here is the last step of that.
#[serde(deny_unknown_fields, default, remote = "Self")]
#[schemars(rename = "Robot")]
pub struct Robot {
    /// Which robot it is where no key says otherwise.
    pub preset: RobotPreset,
    /// Mass.
    #[schemars(range(min = 0.5, max = 200.0))]
    pub mass_kg: f64,
    /// Radius of the body about the robot origin; walls keep it out.
    #[schemars(range(min = 0.05, max = 2.0))]
    pub body_radius_m: f64,
    /// Nominal wheel radius.
    #[schemars(range(min = 0.005, max = 0.5))]
    pub wheel_radius_m: f64,
    /// Each wheel's radius is drawn within this share of the nominal one.
    #[schemars(range(min = 0.0, max = 0.1))]
    pub wheel_radius_tolerance: f64,
    /// Share by which the left and the right wheel are worn off beyond what was drawn, undeclared to the localizer.
    #[schemars(inner(range(min = 0.0, max = 0.5)))]
    pub wheel_wear: [f64; 2],
    /// Nominal distance between the wheels' contact points.
    #[schemars(range(min = 0.05, max = 2.0))]
    pub track_m: f64,
    /// The track is drawn within this share of the nominal one.
    #[schemars(range(min = 0.0, max = 0.1))]
    pub track_tolerance: f64,
    /// Stiffness of the casters' springs over that of the wheels' supports. Soft ones leave the wheels their load where the floor rises
    /// under a caster.
    #[schemars(range(min = 0.01, max = 1.0))]
    pub caster_stiffness: f64,
    /// Greatest commanded speed.
    #[schemars(range(max = 5.0), extend("exclusiveMinimum" = 0.0))]
    pub max_speed_m_per_s: f64,
    /// Greatest commanded turn rate.
    #[schemars(range(max = 20.0), extend("exclusiveMinimum" = 0.0))]
    pub max_turn_rate_rad_per_s: f64,
    /// Greatest commanded acceleration.
    #[schemars(range(max = 20.0), extend("exclusiveMinimum" = 0.0))]
    pub max_acceleration_m_per_s2: f64,
    /// How every drawn error of this robot and its floor is distributed within its tolerance.
    pub errors: Distribution,
    /// Encoders of the wheels.
    pub encoders: Encoders,
    /// Camera that looks straight down: a table of its keys, or `false` for none, which leaves the wheels alone.
    #[serde(deserialize_with = "Fitted::into_option")]
    #[schemars(with = "Fitted<FloorCamera>")]
    pub floor_camera: Option<FloorCamera>,
    /// Camera that looks ahead: a table of its keys, `true` for the default one, or `false` for none.
    #[serde(deserialize_with = "Fitted::into_option")]
    #[schemars(with = "Fitted<ForwardCamera>")]
    pub forward_camera: Option<ForwardCamera>,
    /// Camera that looks up: a table of its keys, `true` for the default one, or `false` for none.
    #[serde(deserialize_with = "Fitted::into_option")]
    #[schemars(with = "Fitted<CeilingCamera>")]
    pub ceiling_camera: Option<CeilingCamera>,
    /// Range camera for coded landmarks: a table of its keys, `true` for the default one, or `false` for none.
    #[serde(deserialize_with = "Fitted::into_option")]
    #[schemars(with = "Fitted<RangeCamera>")]
    pub range_camera: Option<RangeCamera>,
    /// Gyroscope about the vertical: a table of its keys, `true` for the default one, or `false` for none.
    #[serde(deserialize_with = "Fitted::into_option")]
    #[schemars(with = "Fitted<Gyro>")]
    pub gyro: Option<Gyro>,
    /// Optical flow sensor that looks at the floor: a table of its keys, `true` for the default one, or `false` for none.
    #[serde(deserialize_with = "Fitted::into_option")]
    #[schemars(with = "Fitted<Flow>")]
    pub flow: Option<Flow>,
    /// How readings of wheels, gyroscope and flow sensor reach the localizer.
    pub delivery: Delivery,
    /// Rangefinders that look out for what is in the way of errands: a table of their keys, `true` for the default ones, or `false`.
    #[serde(deserialize_with = "Fitted::into_option", skip_serializing_if = "Option::is_none")]
    #[schemars(with = "Fitted<Proximity>")]
    pub proximity: Option<Proximity>,
}

/// Robots to start from.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum RobotPreset {
    /// Pioneer P3-DX with a floor camera behind its axle: 9 kg, track 0.33 m, wheels of 97.5 mm.
    #[default]
    P3dx,
    /// Robot vacuum: 3 kg, track 0.23 m, wheels of 35 mm, gyroscope and flow sensor, no floor camera.
    Vacuum,
}

/// Distribution of drawn errors, always inside the tolerance.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Distribution {
    /// Every value within the tolerance is as likely.
    #[default]
    Uniform,
    /// Normal with half the tolerance as standard deviation, redrawn when outside.
    TruncatedGaussian,
    /// One end of the tolerance or the other: the adversarial corner.
    Corner,
    /// What stays the same at a corner, and what may change goes the worst way: noise and stamps always to one side, delays from end to
    /// end, scales that turn with the robot, joints and markers all off alike.
    Drift,
}

/// Wheel encoders.
#[derive(Clone, Debug, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Encoders {
    /// Ticks in one turn of the wheel.
    #[schemars(range(min = 10, max = 10000000))]
    pub ticks_per_turn: u32,
    /// Time between two readings, a multiple of 0.001.
    #[schemars(range(min = 0.001, max = 1.0))]
    pub period_s: f64,
}

/// A global-shutter camera that looks straight down. Image up is robot forward, image right is robot right.
#[derive(Clone, Debug, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct FloorCamera {
    /// Image width.
    #[schemars(range(min = 64, max = 4096))]
    pub width_px: u32,
    /// Image height.
    #[schemars(range(min = 64, max = 4096))]
    pub height_px: u32,
    /// Width of the floor that the image shows.
    #[schemars(range(min = 0.05, max = 5.0))]
    pub footprint_width_m: f64,
    /// Height of the optical centre above the floor.
    #[schemars(range(min = 0.02, max = 5.0))]
    pub height_m: f64,
    /// Optical centre in the robot frame, forward of the axle.
    #[schemars(range(min = -2.0, max = 2.0))]
    pub forward_m: f64,
    /// Optical centre in the robot frame, left of the middle.
    #[schemars(range(min = -2.0, max = 2.0))]
    pub left_m: f64,
    /// Time between two images.
    #[schemars(range(min = 0.01, max = 100.0))]
    pub period_s: f64,
    /// Mid-exposure to delivery.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub latency_s: f64,
    /// Each delivery is drawn within this of the latency.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub latency_tolerance_s: f64,
    /// Each stamp is drawn within this of the true middle of the exposure.
    #[schemars(range(min = 0.0, max = 0.1))]
    pub stamp_tolerance_s: f64,
    /// The mount is drawn within this of its nominal place, forward and left each.
    #[schemars(range(min = 0.0, max = 0.1))]
    pub position_tolerance_m: f64,
    /// The mount's yaw is drawn within this.
    #[schemars(range(min = 0.0, max = 10.0))]
    pub yaw_tolerance_deg: f64,
    /// The angle of the optical axis to the body's vertical is drawn within this, in any direction.
    #[schemars(range(min = 0.0, max = 10.0))]
    pub tilt_tolerance_deg: f64,
    /// Pixels per metre are drawn within this share of nominal.
    #[schemars(range(min = 0.0, max = 0.1))]
    pub scale_tolerance: f64,
    /// Anywhere in the image, the place of a pixel by the lens's coefficients is within this: the true k1 is drawn.
    #[schemars(range(min = 0.0, max = 10.0))]
    pub distortion_tolerance_px: f64,
    /// What the lens does besides projecting.
    pub lens: LensKeys,
    /// What turns light into grey levels.
    pub sensor: Sensor,
    /// At most this many wrong lines are assumed in one image.
    #[schemars(range(min = 0, max = 20))]
    pub q_items: usize,
}

impl FloorCamera {
    /// Its sensor, nothing left open.
    pub fn sensor_model(&self) -> SensorModel {
        self.sensor.model(SensorPreset::GlobalShutter)
    }

    /// When it exposes, stamps and delivers.
    pub fn timing(&self) -> CameraTiming {
        CameraTiming {
            period_s: self.period_s,
            latency_s: self.latency_s,
            latency_tolerance_s: self.latency_tolerance_s,
            stamp_tolerance_s: self.stamp_tolerance_s,
            longest_s: self.sensor_model().longest_exposure_s + self.lens.row_time_s * f64::from(self.height_px - 1),
        }
    }
}

/// A device as a scene states it. TOML has no null, so `false` says that the robot has none.
#[derive(Deserialize, JsonSchema)]
#[serde(untagged)]
enum Fitted<T> {
    /// Fitted, with these keys.
    With(T),
    /// `true`: fitted as by default. `false`: not fitted.
    Whether(bool),
}

impl<T: Default> Fitted<T> {
    fn into_option<'de, D>(deserializer: D) -> Result<Option<T>, D::Error>
    where
        D: Deserializer<'de>,
        T: Deserialize<'de>,
    {
        Ok(match Fitted::deserialize(deserializer)? {
            Fitted::With(device) => Some(device),
            Fitted::Whether(true) => Some(T::default()),
            Fitted::Whether(false) => None,
        })
    }
}

impl Default for Robot {
    /// Pioneer P3-DX with a floor camera behind its axle.
    fn default() -> Self {
        Robot {
            preset: RobotPreset::P3dx,
            mass_kg: 9.0,
            body_radius_m: 0.25,
            wheel_radius_m: 0.0975,
            wheel_radius_tolerance: 0.002,
            wheel_wear: [0.0; 2],
            track_m: 0.33,
            track_tolerance: 0.003,
            caster_stiffness: 1.0,
            max_speed_m_per_s: 0.51,
            max_turn_rate_rad_per_s: 1.0,
            max_acceleration_m_per_s2: 0.5,
            errors: Distribution::Uniform,
            encoders: Encoders::default(),
            floor_camera: Some(FloorCamera::default()),
            forward_camera: None,
            ceiling_camera: None,
            range_camera: None,
            gyro: None,
            flow: None,
            delivery: Delivery::default(),
            proximity: None,
        }
    }
}

impl Default for Encoders {
    fn default() -> Self {
        // P3-DX: 500 counts a motor turn through a gear of 38.3.
        Encoders { ticks_per_turn: 19_150, period_s: 0.01 }
    }
}

impl Default for FloorCamera {
    fn default() -> Self {
        FloorCamera {
            width_px: 640,
            height_px: 480,
            footprint_width_m: 0.48,
            height_m: 0.25,
            forward_m: -0.15,
            left_m: 0.0,
            period_s: 0.2,
            latency_s: 0.030,
            latency_tolerance_s: 0.002,
            stamp_tolerance_s: 0.0001,
            position_tolerance_m: 0.0005,
            yaw_tolerance_deg: 0.1,
            tilt_tolerance_deg: 0.1,
            scale_tolerance: 0.001,
            distortion_tolerance_px: 0.0,
            lens: LensKeys::default(),
            sensor: Sensor::default(),
            q_items: 0,
        }
    }
}

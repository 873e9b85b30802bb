//! The robot: its dimensions with the tolerance of their errors, and what is fitted to it.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

// Every kind of device is named by the list.
use super::devices::*;

/// Defines the robot with a table for every kind of device.
macro_rules! define {
    ($($(#[$doc:meta])+ $name:ident: $keys:ident as $fitted:literal ;)+) => {
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
            $(
                $(#[$doc])+
                #[serde(deserialize_with = "Fitted::into_option")]
                #[schemars(with = $fitted)]
                pub $name: Option<$keys>,
            )+
            /// How readings of wheels, gyroscope and flow sensor reach the localizer.
            pub delivery: Delivery,
            /// Rangefinders that look out for what is in the way of errands: a table of their keys, `true` for the default ones, or `false`.
            #[serde(deserialize_with = "Fitted::into_option", skip_serializing_if = "Option::is_none")]
            #[schemars(with = "Fitted<Proximity>")]
            pub proximity: Option<Proximity>,
        }

        impl Default for Robot {
            /// Pioneer P3-DX with a floor camera behind its axle.
            fn default() -> Self {
                let bare = Robot {
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
                    delivery: Delivery::default(),
                    proximity: None,
                    $($name: None,)+
                };
                Robot { floor_camera: Some(FloorCamera::default()), ..bare }
            }
        }
    };
}

with_every_kind!(define);

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

//! Keys of the robot's base: the axle that every base has, and the keys of each kind of base.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// List of all kinds of bases for a macro: for each kind its description, its name, and the key of its table under `[robot.base]`.
macro_rules! with_every_base {
    ($define:ident) => {
        $define! {
            /// Differential drive: the two wheels of the axle are driven, each by a motor of its own, and two casters keep the body level.
            Differential: differential,
        }
    };
}
pub(crate) use with_every_base;

macro_rules! define {
    ($($(#[$doc:meta])+ $kind:ident: $table:ident,)+) => {
        /// An axle with two wheels, whose turns the encoders count, and what else the robot stands on and is driven by. The origin of the robot frame is
        /// under the middle of the axle. The defaults are those of the robot's `preset`.
        #[derive(Clone, Debug, Deserialize, Serialize, JsonSchema)]
        #[serde(deny_unknown_fields, default)]
        pub struct Base {
            /// How the base is driven, and what the robot stands on besides the wheels of the axle.
            pub kind: BaseKind,
            /// Nominal radius of the axle's wheels.
            #[schemars(range(min = 0.005, max = 0.5))]
            pub wheel_radius_m: f64,
            /// Greatest error of each wheel's radius, drawn at random, as a share of the nominal radius.
            #[schemars(range(min = 0.0, max = 0.1))]
            pub wheel_radius_tolerance: f64,
            /// Shares of their nominal radius by which the left and the right wheel are worn off, in addition to the random error of the radius. The
            /// localizer is not given them.
            #[schemars(inner(range(min = 0.0, max = 0.5)))]
            pub wheel_wear: [f64; 2],
            /// Nominal distance between the wheels' contact points.
            #[schemars(range(min = 0.05, max = 2.0))]
            pub track_m: f64,
            /// Greatest error of the track, drawn at random, as a share of the nominal track.
            #[schemars(range(min = 0.0, max = 0.1))]
            pub track_tolerance: f64,
            $(
                #[doc = concat!("Keys that only a base of the kind `", stringify!($table), "` has.")]
                pub $table: $kind,
            )+
        }

        /// The kinds of bases that there are.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
        #[serde(rename_all = "snake_case")]
        pub enum BaseKind {
            $($(#[$doc])+ $kind,)+
        }

        impl Default for Base {
            /// The base of the P3-DX.
            fn default() -> Self {
                Base {
                    kind: BaseKind::Differential,
                    wheel_radius_m: 0.0975,
                    wheel_radius_tolerance: 0.002,
                    wheel_wear: [0.0; 2],
                    track_m: 0.33,
                    track_tolerance: 0.003,
                    $($table: $kind::default(),)+
                }
            }
        }
    };
}

with_every_base!(define);

/// The two wheels of the axle are driven, each by a motor of its own, and two casters keep the body level.
#[derive(Clone, Debug, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Differential {
    /// Stiffness of the casters' springs over that of the wheels' supports. Soft springs leave the wheels their load where the floor rises
    /// under a caster.
    #[schemars(range(min = 0.01, max = 1.0))]
    pub caster_stiffness: f64,
}

impl Default for Differential {
    fn default() -> Self {
        Differential { caster_stiffness: 1.0 }
    }
}

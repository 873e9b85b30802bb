//! Keys of the robot's base: the axle that every base has, and the keys of each kind of base.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// List of all kinds of bases for a macro: for each kind its description, its name, and the key of its table under `[robot.base]`. A scene that is
/// written out leaves the table of a kind out where the function named after `unless` says so.
macro_rules! with_every_base {
    ($define:ident) => {
        $define! {
            /// Differential drive: the two wheels of the axle are driven, each by a motor of its own, and two casters keep the body level.
            Differential: differential,
            /// Car: the two wheels of the axle are its rear wheels, each driven by a motor of its own; the two front wheels roll freely and are steered.
            /// It cannot turn in place: routes that do not fit its turning circle are refused, and on errands it drives in curves, forwards and
            /// backwards.
            Ackermann: ackermann unless "Ackermann::is_usual",
        }
    };
}
pub(crate) use with_every_base;

macro_rules! define {
    ($($(#[$doc:meta])+ $kind:ident: $table:ident $(unless $omitted:literal)?,)+) => {
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
                $(#[serde(skip_serializing_if = $omitted)])?
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

/// The two wheels of the axle are the rear wheels of a car. Each is driven by a motor of its own, as by an electronic differential: its commanded
/// speed follows from the commanded speed and from the steering angle that has been reached, by the nominal dimensions. The two front wheels roll
/// freely. They are steered such that the axes of all four wheels meet in one point, the centre of the turn (Ackermann geometry).
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Ackermann {
    /// Distance from the rear axle, above which the origin of the robot frame is, to the front axle.
    #[schemars(range(min = 0.05, max = 5.0))]
    pub wheelbase_m: f64,
    /// Bound `wheels.wheelbase`: greatest error of the wheelbase, drawn at random, as a share of the nominal wheelbase. Only a car with a steering
    /// encoder relies on it.
    #[serde(skip_serializing_if = "is_zero")]
    #[schemars(range(min = 0.0, max = 0.1))]
    pub wheelbase_tolerance: f64,
    /// Distance between the contact points of the front wheels. Unless stated, it is the nominal `track_m` of the rear axle.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 0.05, max = 2.0))]
    pub front_track_m: Option<f64>,
    /// Share of the robot's weight that the front wheels bear at rest on level floor. The fewer the rear wheels bear, the more they slip.
    #[schemars(range(min = 0.1, max = 0.9))]
    pub front_share: f64,
    /// Greatest steering angle to either side, that of a wheel in the middle of the front axle. The smallest circle that the middle of the rear axle
    /// can drive has the radius wheelbase / tan(greatest steering angle).
    #[schemars(range(min = 1.0, max = 60.0))]
    pub max_steering_deg: f64,
    /// Greatest rate of the steering angle, at which it follows the command.
    #[schemars(range(max = 1000.0), extend("exclusiveMinimum" = 0.0))]
    pub steering_rate_deg_per_s: f64,
}

impl Default for Ackermann {
    /// A car of half a metre, which carries its battery in the middle. Servos of model cars turn by 60° in 0.1 s to 0.2 s without load; the rate is a
    /// fifth of that.
    fn default() -> Self {
        Ackermann {
            wheelbase_m: 0.5,
            wheelbase_tolerance: 0.0,
            front_track_m: None,
            front_share: 0.5,
            max_steering_deg: 30.0,
            steering_rate_deg_per_s: 90.0,
        }
    }
}

fn is_zero(value: &f64) -> bool {
    *value == 0.0
}

impl Ackermann {
    /// Whether all keys have their default values.
    fn is_usual(&self) -> bool {
        *self == Ackermann::default()
    }
}

//! Events during a run, such as pushes, switched lamps and stuck wheels.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// An event at a stated time. Its key `kind` selects what happens.
#[derive(Clone, Debug, Deserialize, Serialize, JsonSchema)]
#[serde(tag = "kind", rename_all = "snake_case", deny_unknown_fields)]
pub enum Event {
    /// A hand displaces the robot's body at a steady speed, while its wheels go on rolling.
    Push {
        /// Time at which the push begins.
        #[schemars(range(min = 0.0, max = 36000.0))]
        at_s: f64,
        /// Displacement of the robot by the push, forward and left in the robot frame as the push begins.
        #[schemars(inner(range(min = -5.0, max = 5.0)))]
        displacement_m: [f64; 2],
        /// Duration of the push.
        #[schemars(range(min = 0.02, max = 60.0))]
        lasts_s: f64,
    },
    /// All lamps are dimmed or brightened alike, to another mean illuminance at the floor.
    Light {
        /// Time at which the lamps are switched.
        #[schemars(range(min = 0.0, max = 36000.0))]
        at_s: f64,
        /// New mean illuminance at the floor. Where events of `kind = "lamp"` switch some of the lamps, that with all of them on.
        #[schemars(range(min = 0.0, max = 100000.0))]
        illuminance_at_floor_lux: f64,
    },
    /// The lamps of one name are switched on or off, or dimmed.
    Lamp {
        /// Time at which the lamps of this name are switched.
        #[schemars(range(min = 0.0, max = 36000.0))]
        at_s: f64,
        /// Name of the lamps that are switched, which is that of at least one `[[lamp]]`.
        lamp: String,
        /// Light that the lamps of this name give from then on, as a share of what they give when they are on: 0 switches them off, 1 on. All lamps
        /// are on at the start.
        #[schemars(range(min = 0.0, max = 1.0))]
        share: f64,
    },
    /// The friction of a floor region, or of the whole floor outside regions, changes.
    Friction {
        /// Time at which the friction changes.
        #[schemars(range(min = 0.0, max = 36000.0))]
        at_s: f64,
        /// Name of the region whose friction changes; the floor outside all regions unless stated.
        #[serde(default)]
        region: Option<String>,
        /// New friction coefficient between tyre and floor.
        #[schemars(range(min = 0.01, max = 2.0))]
        friction: f64,
    },
    /// Hands lift the robot off the floor, displace and turn it, and put it down again.
    Lift {
        /// Time at which the hands lift the robot.
        #[schemars(range(min = 0.0, max = 36000.0))]
        at_s: f64,
        /// Displacement of the robot by the hands that lift it, forward and left in the robot frame as they begin.
        #[serde(default)]
        #[schemars(inner(range(min = -5.0, max = 5.0)))]
        displacement_m: [f64; 2],
        /// Angle by which the hands turn the robot, counter-clockwise.
        #[serde(default)]
        #[schemars(range(min = -180.0, max = 180.0))]
        turn_deg: f64,
        /// Time for which the hands hold the robot.
        #[schemars(range(min = 0.2, max = 60.0))]
        lasts_s: f64,
    },
    /// One wheel is stuck: it is blocked, or it spins without grip on the floor.
    StuckWheel {
        /// Time at which the wheel gets stuck.
        #[schemars(range(min = 0.0, max = 36000.0))]
        at_s: f64,
        /// Wheel that gets stuck.
        wheel: Side,
        /// Whether the wheel is held fast or spins without grip on the floor.
        #[serde(default)]
        how: Stuck,
        /// Time for which the wheel stays stuck.
        #[schemars(range(min = 0.02, max = 60.0))]
        lasts_s: f64,
    },
    /// The flow sensor finds nothing on the floor to follow.
    FlowBlind {
        /// Time at which the flow sensor loses the floor.
        #[schemars(range(min = 0.0, max = 36000.0))]
        at_s: f64,
        /// Time for which the flow sensor finds nothing.
        #[schemars(range(min = 0.02, max = 60.0))]
        lasts_s: f64,
    },
}

/// Side of the robot.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Side {
    /// Left.
    Left,
    /// Right.
    Right,
}

/// Ways in which a wheel is stuck.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Stuck {
    /// Hair or a cable holds the wheel, which does not turn.
    #[default]
    Blocked,
    /// The wheel hangs over a cable or an edge, and turns without grip on the floor.
    Spinning,
}

impl Event {
    /// Time at which the event begins.
    pub fn at_s(&self) -> f64 {
        match self {
            Event::Push { at_s, .. }
            | Event::Light { at_s, .. }
            | Event::Lamp { at_s, .. }
            | Event::Friction { at_s, .. }
            | Event::Lift { at_s, .. }
            | Event::StuckWheel { at_s, .. }
            | Event::FlowBlind { at_s, .. } => *at_s,
        }
    }

    /// Duration of the event; 0 for a switch of lamps and a change of friction.
    pub fn lasts_s(&self) -> f64 {
        match self {
            Event::Light { .. } | Event::Lamp { .. } | Event::Friction { .. } => 0.0,
            Event::Push { lasts_s, .. }
            | Event::Lift { lasts_s, .. }
            | Event::StuckWheel { lasts_s, .. }
            | Event::FlowBlind { lasts_s, .. } => *lasts_s,
        }
    }

    /// Whether the event is in progress at a given instant.
    pub fn is_on(&self, time_s: f64) -> bool {
        self.at_s() <= time_s && time_s < self.at_s() + self.lasts_s()
    }
}

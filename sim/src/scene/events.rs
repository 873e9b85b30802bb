//! What happens during a run.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Something that happens at a stated time, told apart by its key `kind`.
#[derive(Clone, Debug, Deserialize, Serialize, JsonSchema)]
#[serde(tag = "kind", rename_all = "snake_case", deny_unknown_fields)]
pub enum Event {
    /// A hand displaces the robot's body at a steady speed, while its wheels go on.
    Push {
        /// When it begins.
        #[schemars(range(min = 0.0, max = 36000.0))]
        at_s: f64,
        /// How far, in the robot frame at that moment: forward and left.
        #[schemars(inner(range(min = -5.0, max = 5.0)))]
        displacement_m: [f64; 2],
        /// How long the push takes.
        #[schemars(range(min = 0.02, max = 60.0))]
        lasts_s: f64,
    },
    /// The lamps are switched to another mean illuminance at the floor.
    Light {
        /// When it happens.
        #[schemars(range(min = 0.0, max = 36000.0))]
        at_s: f64,
        /// New mean illuminance at the floor.
        #[schemars(range(min = 0.0, max = 100000.0))]
        illuminance_at_floor_lux: f64,
    },
    /// A floor region, or the whole floor outside regions, changes its friction.
    Friction {
        /// When it happens.
        #[schemars(range(min = 0.0, max = 36000.0))]
        at_s: f64,
        /// Name of a region; the floor outside regions when absent.
        #[serde(default)]
        region: Option<String>,
        /// New friction coefficient.
        #[schemars(range(min = 0.01, max = 2.0))]
        friction: f64,
    },
    /// Hands lift the robot off the floor, displace and turn it, and put it down again.
    Lift {
        /// When it begins.
        #[schemars(range(min = 0.0, max = 36000.0))]
        at_s: f64,
        /// How far, in the robot frame at that moment: forward and left.
        #[serde(default)]
        #[schemars(inner(range(min = -5.0, max = 5.0)))]
        displacement_m: [f64; 2],
        /// How far it is turned, counter-clockwise.
        #[serde(default)]
        #[schemars(range(min = -180.0, max = 180.0))]
        turn_deg: f64,
        /// How long the hands hold it.
        #[schemars(range(min = 0.2, max = 60.0))]
        lasts_s: f64,
    },
    /// One wheel does not do what its motor wants.
    StuckWheel {
        /// When it begins.
        #[schemars(range(min = 0.0, max = 36000.0))]
        at_s: f64,
        /// Which wheel.
        wheel: Side,
        /// Held fast, or without hold on the floor.
        #[serde(default)]
        how: Stuck,
        /// How long it lasts.
        #[schemars(range(min = 0.02, max = 60.0))]
        lasts_s: f64,
    },
    /// The flow sensor finds nothing to follow.
    FlowBlind {
        /// When it begins.
        #[schemars(range(min = 0.0, max = 36000.0))]
        at_s: f64,
        /// How long it lasts.
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

/// What holds a wheel up.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Stuck {
    /// Hair or a cable holds it: it does not turn.
    #[default]
    Blocked,
    /// It hangs over a cable or an edge: it turns without hold on the floor.
    Spinning,
}

impl Event {
    /// When the event begins.
    pub fn at_s(&self) -> f64 {
        match self {
            Event::Push { at_s, .. }
            | Event::Light { at_s, .. }
            | Event::Friction { at_s, .. }
            | Event::Lift { at_s, .. }
            | Event::StuckWheel { at_s, .. }
            | Event::FlowBlind { at_s, .. } => *at_s,
        }
    }

    /// How long the event lasts; 0 for a change.
    pub fn lasts_s(&self) -> f64 {
        match self {
            Event::Light { .. } | Event::Friction { .. } => 0.0,
            Event::Push { lasts_s, .. }
            | Event::Lift { lasts_s, .. }
            | Event::StuckWheel { lasts_s, .. }
            | Event::FlowBlind { lasts_s, .. } => *lasts_s,
        }
    }

    /// Whether it goes on at an instant.
    pub fn is_on(&self, time_s: f64) -> bool {
        self.at_s() <= time_s && time_s < self.at_s() + self.lasts_s()
    }
}

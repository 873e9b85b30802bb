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
}

impl Event {
    /// When the event begins.
    pub fn at_s(&self) -> f64 {
        match self {
            Event::Push { at_s, .. } | Event::Light { at_s, .. } | Event::Friction { at_s, .. } => *at_s,
        }
    }
}

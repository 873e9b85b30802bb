//! What happens during a run.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Something that happens at a stated time, told apart by its key `kind`.
#[derive(Clone, Debug, Deserialize, Serialize, JsonSchema)]
#[serde(tag = "kind", rename_all = "snake_case", deny_unknown_fields)]
pub enum Event {
    /// A hand displaces the robot's body at a steady speed, while its wheels go on.
    Push {
        /// When it begins. Range [0, 36000].
        at_s: f64,
        /// How far, in the robot frame at that moment: forward and left. Range [-5, 5].
        displacement_m: [f64; 2],
        /// How long the push takes. Range [0.02, 60].
        lasts_s: f64,
    },
    /// The lamps are switched to another mean illuminance at the floor.
    Light {
        /// When it happens. Range [0, 36000].
        at_s: f64,
        /// New mean illuminance at the floor. Range [0, 100000].
        illuminance_at_floor_lux: f64,
    },
    /// A floor region, or the whole floor outside regions, changes its friction.
    Friction {
        /// When it happens. Range [0, 36000].
        at_s: f64,
        /// Name of a region; the floor outside regions when absent.
        #[serde(default)]
        region: Option<String>,
        /// New friction coefficient. Range [0.01, 2].
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

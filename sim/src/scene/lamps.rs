//! Lamps: what gives light, how much, and with which spectrum.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::{Event, Scene};

/// Greatest number of lamps in a scene: as many as fit into uniform memory of the size that every graphics adapter has.
pub const MAX_LAMPS: usize = 1024;

/// A lamp or window. A scene without any is lit by matt panels in a grid under the ceiling, which give what `[light]` states.
///
/// If every lamp states its output, each gives just that. Otherwise outputs are only proportions, 1000 lm for a lamp that states none, and all lamps
/// are dimmed alike to give what `[light]` states.
#[derive(Clone, Debug, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Lamp {
    /// Kind of the lamp.
    pub kind: LampKind,
    /// Name by which an event of `kind = "lamp"` switches the lamp. Lamps of the same name are switched together.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub name: Option<String>,
    /// World x of the lamp's middle; for a window, of a point of its wall.
    pub x_m: f64,
    /// World y of the lamp's middle; for a window, of a point of its wall.
    pub y_m: f64,
    /// Height of the lamp's middle above the floor. Unless stated, 0.03 m below the ceiling, or 1.5 m above the floor for a window.
    #[serde(default)]
    #[schemars(range(min = 0.05, max = 20.0))]
    pub height_m: Option<f64>,
    /// Direction of the lamp's first side, measured from world x; for a window, the direction in which it shines into the room.
    #[serde(default)]
    #[schemars(range(min = -360.0, max = 360.0))]
    pub heading_deg: f64,
    /// Lengths of the lamp's two sides. Unless stated, 0.6 m by 0.6 m for a panel and 1.2 m by 0.08 m for a tube. For a window they are width and
    /// height, 1.4 m by 1.2 m unless stated. For a point lamp the first number is the diameter, 0.1 m unless stated, and the second has no effect.
    #[serde(default)]
    #[schemars(inner(range(min = 0.005, max = 50.0)))]
    pub size_m: Option<[f64; 2]>,
    /// Luminous flux that the lamp gives into the room.
    #[serde(default)]
    #[schemars(range(min = 0.0, max = 1e6))]
    pub lumens: Option<f64>,
    /// Illuminance that the lamp's own direct light gives at the floor straight below it, or for a window 1 m in front of its wall. Stated in place
    /// of `lumens`.
    #[serde(default)]
    #[schemars(range(min = 0.0, max = 100000.0))]
    pub illuminance_at_floor_lux: Option<f64>,
    /// Spectrum of the lamp. Unless stated, `daylight` for a window, `tube` for a tube and `led` for the other kinds.
    #[serde(default)]
    pub spectrum: Option<Spectrum>,
}

/// Kinds of lamps. Panels, tubes and windows are matt rectangles that shine to one side.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum LampKind {
    /// A flat panel that shines downwards.
    Panel,
    /// A fluorescent tube in its trough, a narrow rectangle that shines downwards.
    Tube,
    /// A small bulb that shines equally in all directions.
    Point,
    /// A window with an evenly bright sky behind it.
    Window,
}

/// Spectra of lamps. The spectrum decides how many photons a lumen has and what an infrared camera sees.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Spectrum {
    /// All light at 555 nm, where the eye is most sensitive: 683 lm/W.
    Monochrome,
    /// Daylight, as the CIE's standard illuminant D65.
    Daylight,
    /// White light-emitting diode, with a blue line and the broad band of a phosphor.
    Led,
    /// Fluorescent tube with three narrow bands.
    Tube,
    /// Black body of 2800 K, whose light is mostly infrared.
    Incandescent,
}

impl Scene {
    /// Whether every lamp states its output, so that each gives just that; false for a scene without lamps.
    pub fn lamps_state_outputs(&self) -> bool {
        let states_output = |lamp: &Lamp| lamp.lumens.is_some() || lamp.illuminance_at_floor_lux.is_some();
        !self.lamps.is_empty() && self.lamps.iter().all(states_output)
    }

    /// Names of the lamps that the scene's events switch, each once, in the order of the events.
    pub fn switched_lamps(&self) -> Vec<&str> {
        let mut names: Vec<&str> = Vec::new();
        for event in &self.events {
            if let Event::Lamp { lamp, .. } = event
                && !names.contains(&lamp.as_str())
            {
                names.push(lamp);
            }
        }
        names
    }
}

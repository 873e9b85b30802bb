//! Lamps: what gives light, how much of it, and of which spectrum.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// As many as uniform memory of the size that every adapter has can hold.
pub const MAX_LAMPS: usize = 1024;

/// Something that gives light. Without any lamp, matt panels in a grid under the ceiling give what `[light]` states.
///
/// When each lamp states its output, that is what it gives. Otherwise outputs are proportions only, 1000 lm for a lamp that
/// states none, and all lamps are dimmed alike to give what `[light]` states.
#[derive(Clone, Debug, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Lamp {
    /// What it is.
    pub kind: LampKind,
    /// World x of its middle; of a window, of a place on its wall.
    pub x_m: f64,
    /// World y of its middle; of a window, of a place on its wall.
    pub y_m: f64,
    /// Height of its middle above the floor: below the ceiling by 0.03 m unless stated, of a window 1.5 m.
    #[serde(default)]
    #[schemars(range(min = 0.05, max = 20.0))]
    pub height_m: Option<f64>,
    /// Direction of its first side from world x; of a window, the direction in which it shines into the room.
    #[serde(default)]
    #[schemars(range(min = -360.0, max = 360.0))]
    pub heading_deg: f64,
    /// Sides: 0.6 m by 0.6 m for a panel, 1.2 m by 0.08 m for a tube; width and height of a window, 1.4 m by 1.2 m. Of a
    /// point the first number is the diameter, 0.1 m, and the second says nothing.
    #[serde(default)]
    #[schemars(inner(range(min = 0.005, max = 50.0)))]
    pub size_m: Option<[f64; 2]>,
    /// Luminous flux into the room.
    #[serde(default)]
    #[schemars(range(min = 0.0, max = 1e6))]
    pub lumens: Option<f64>,
    /// Instead of the flux: illuminance at the floor straight below the lamp (of a window, 1 m before its wall), by its
    /// own direct light.
    #[serde(default)]
    #[schemars(range(min = 0.0, max = 100000.0))]
    pub illuminance_at_floor_lux: Option<f64>,
    /// Spectrum: `daylight` for a window, `tube` for a tube and `led` for others, unless stated.
    #[serde(default)]
    pub spectrum: Option<Spectrum>,
}

/// Kinds of lamps. Panels, tubes and windows shine as matt rectangles, on one side.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum LampKind {
    /// A flat panel that shines downwards.
    Panel,
    /// A fluorescent tube in its trough, a narrow rectangle that shines downwards.
    Tube,
    /// A small bulb that shines alike in all directions.
    Point,
    /// A window with an even sky behind it.
    Window,
}

/// Spectra of lamps, which decide how many photons a lumen has and what an infrared camera sees.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Spectrum {
    /// All at 555 nm, where the eye is best: 683 lm/W.
    Monochrome,
    /// CIE's D65.
    Daylight,
    /// White light-emitting diode: a blue line and a broad phosphor.
    Led,
    /// Fluorescent tube of three narrow bands.
    Tube,
    /// Black body of 2800 K: mostly infrared.
    Incandescent,
}

//! Dot-matrix markers on the ceiling (paper 5): what is printed on them, where they are pasted, and how they are damaged.

use interval::Interval;
use localizer::{
    map::{MarkerMap, PlacedMarker},
    markers::{self, MarkerId},
};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::{Scene, building::default_retroreflection};

/// Markers of retro-reflective dots on the ceiling, for a camera that looks up.
#[derive(Clone, Debug, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Markers {
    /// Set of codewords from which the markers get their identities.
    pub coding: Coding,
    /// Greatest distance of a marker's true centre from its stated position; drawn at random.
    #[schemars(range(min = 0.0, max = 0.1))]
    pub placement_tolerance_m: f64,
    /// Greatest angle by which a marker is turned against its stated direction; drawn at random.
    #[schemars(range(min = 0.0, max = 45.0))]
    pub rotation_tolerance_deg: f64,
    /// Greatest distance of a printed dot from its nominal position on the marker; drawn at random.
    #[schemars(range(min = 0.0, max = 0.01))]
    pub print_tolerance_m: f64,
    /// Greatest difference of a marker's true height from its stated height; drawn at random.
    #[schemars(range(min = 0.0, max = 0.5))]
    pub height_tolerance_m: f64,
    /// Coefficient of retroreflection of the dots: luminous intensity per illuminance and area. Glass beads have 70, microprisms 400.
    #[schemars(range(min = 0.0, max = 2000.0))]
    pub retroreflection_cd_per_lux_m2: f64,
    /// Share of all markers that have fallen off without the localizer's knowledge. Each seed draws at random which ones.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub share_missing: f64,
    /// Ceiling markers, stated one by one.
    #[serde(rename = "marker")]
    pub markers: Vec<Marker>,
    /// Lets the program lay out the markers, in place of stating single ones. It lays out as few as are proven to be enough for the
    /// ceiling camera, in the room and in each further room that is a rectangle, with the identities of `coding` in their order.
    pub layout: Option<Layout>,
    #[serde(skip)]
    pub(crate) laid_out: Vec<Marker>,
}

/// Markers laid out over the room such that the ceiling camera has enough of them wholly in its image from wherever the robot can be, whatever the
/// errors are within their tolerances.
#[derive(Clone, Debug, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Layout {
    /// Least number of markers that the ceiling camera has wholly in its image at once.
    #[schemars(range(min = 1, max = 4))]
    pub seen_at_once: usize,
    /// Least distance of a marker from the edges of the ceiling camera's image at which it counts as seen.
    #[schemars(range(min = 0.0, max = 200.0))]
    pub margin_px: f64,
}

/// One marker: a grid of 4 × 4 places, 4 cm apart, for dots of 1 cm radius. Dot O at the grid's `[0, 0]`, dot X at `[3, 0]` and dot Y at `[0, 3]`
/// show the marker's direction, the corner `[3, 3]` stays empty, and which of the other twelve dots are there gives the marker's identity.
#[derive(Clone, Debug, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Marker {
    /// Identity printed on the marker: the sum of the weights of its coded dots.
    #[schemars(range(min = 0, max = 4095))]
    pub id: u16,
    /// World x of the middle of the marker's grid.
    pub x_m: f64,
    /// World y of the middle of the marker's grid.
    pub y_m: f64,
    /// Angle from world x to the direction from dot O to dot X, counter-clockwise seen from above.
    #[serde(default, skip_serializing_if = "is_zero")]
    #[schemars(range(min = -360.0, max = 360.0))]
    pub rotation_deg: f64,
    /// Height of the marker above the floor. Unless stated, the marker is just under the ceiling, lower by `height_tolerance_m`.
    #[serde(default)]
    #[schemars(range(min = 0.1, max = 20.0))]
    pub height_m: Option<f64>,
    /// Whether the marker is on the localizer's map.
    #[serde(default = "yes", skip_serializing_if = "is_true")]
    pub on_map: bool,
    /// Whether the marker is on the ceiling; false for one that has fallen off.
    #[serde(default = "yes", skip_serializing_if = "is_true")]
    pub pasted: bool,
    /// Displacement of the marker along world x and y since it was put on the localizer's map.
    #[serde(default, skip_serializing_if = "is_nowhere_else")]
    #[schemars(inner(range(min = -200.0, max = 200.0)))]
    pub misplaced_m: [f64; 2],
    /// Places `[i, j]` of the marker's grid whose printed dots have come off; `i` counts from O towards X, `j` from O towards Y.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub missing_dots: Vec<[u8; 2]>,
    /// Places `[i, j]` of the marker's grid at which something shines that is not printed.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub extra_dots: Vec<[u8; 2]>,
    /// Share of the marker's width that is covered, from the side of dot X. A dot is visible while its middle is not covered.
    #[serde(default, skip_serializing_if = "is_zero")]
    #[schemars(range(min = 0.0, max = 1.0))]
    pub covered_share: f64,
    /// Whether the marker's film is pasted the wrong way round, so that dots X and Y have changed places.
    #[serde(default, skip_serializing_if = "is_false")]
    pub mirrored: bool,
}

/// Sets of marker identities. The fewer there are, the less easily a damaged marker is taken for another one.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Coding {
    /// All 4096 identities, as in paper 5: no wrong dot is detected.
    Plain,
    /// 128 identities that differ in at least 4 dots: up to 3 wrong dots are detected.
    Lexicode,
    /// 118 identities of six dots each that differ in at least 4 dots. Besides up to 3 wrong dots, any number of missing dots and mirror images are
    /// detected.
    #[default]
    Hexads,
}

impl Coding {
    /// Name of the coding as scene files state it.
    pub fn as_str(self) -> &'static str {
        match self {
            Coding::Plain => "plain",
            Coding::Lexicode => "lexicode",
            Coding::Hexads => "hexads",
        }
    }
}

impl From<Coding> for markers::Coding {
    fn from(coding: Coding) -> markers::Coding {
        match coding {
            Coding::Plain => markers::Coding::Plain,
            Coding::Lexicode => markers::Coding::Lexicode,
            Coding::Hexads => markers::Coding::Hexads,
        }
    }
}

impl Markers {
    /// All markers of the scene, whether stated one by one or laid out by the program.
    pub fn all(&self) -> &[Marker] {
        if self.layout.is_some() { &self.laid_out } else { &self.markers }
    }

    /// Nominal height of a marker above the floor.
    pub fn height_m(&self, marker: &Marker, scene: &Scene) -> f64 {
        marker.height_m.unwrap_or(scene.building.ceiling_height_m - UNDER_CEILING_M - self.height_tolerance_m)
    }

    /// States every marker's nominal height as a key, so that the height stays the same when the tolerance changes.
    pub(crate) fn state_heights(&mut self, scene: &Scene) {
        let nominal = self.clone();
        for marker in self.markers.iter_mut().chain(&mut self.laid_out) {
            marker.height_m = Some(nominal.height_m(marker, scene));
        }
    }

    /// Text of the keys of a scene that state all markers of its map one by one.
    pub fn keys(&self) -> Result<String, toml::ser::Error> {
        #[derive(Serialize)]
        struct Keys {
            markers: Markers,
        }
        let markers = self.all().iter().filter(|marker| marker.on_map).cloned().collect();
        toml::to_string(&Keys { markers: Markers { markers, layout: None, laid_out: Vec::new(), ..self.clone() } })
    }

    /// Marker map that the localizer is given.
    pub(crate) fn map(&self, scene: &Scene) -> MarkerMap {
        let placed = |marker: &Marker| PlacedMarker {
            id: MarkerId(marker.id),
            centre_m: [marker.x_m, marker.y_m],
            rotation_rad: marker.rotation_deg.to_radians(),
            height_m: Interval::centred(self.height_m(marker, scene), self.height_tolerance_m),
        };
        MarkerMap {
            coding: self.coding.into(),
            markers: self.all().iter().filter(|marker| marker.on_map).map(placed).collect(),
            placement_m: self.placement_tolerance_m,
            rotation_tolerance_rad: self.rotation_tolerance_deg.to_radians(),
            print_m: self.print_tolerance_m,
        }
    }
}

impl Marker {
    /// An undamaged marker just under the ceiling, with the direction from its dot O to its dot X along world x.
    pub(crate) fn new(id: u16, x_m: f64, y_m: f64) -> Marker {
        Marker {
            id,
            x_m,
            y_m,
            rotation_deg: 0.0,
            height_m: None,
            on_map: true,
            pasted: true,
            missing_dots: Vec::new(),
            extra_dots: Vec::new(),
            misplaced_m: [0.0; 2],
            covered_share: 0.0,
            mirrored: false,
        }
    }
}

/// Distance below the ceiling at which things stuck to the ceiling are placed. Above this the ceiling would hide them.
pub(crate) const UNDER_CEILING_M: f64 = 0.001;

impl Default for Markers {
    fn default() -> Self {
        Markers {
            coding: Coding::Hexads,
            placement_tolerance_m: 0.002,
            rotation_tolerance_deg: 0.2,
            print_tolerance_m: 0.0003,
            height_tolerance_m: 0.005,
            retroreflection_cd_per_lux_m2: default_retroreflection(),
            share_missing: 0.0,
            markers: Vec::new(),
            layout: None,
            laid_out: Vec::new(),
        }
    }
}

impl Default for Layout {
    fn default() -> Self {
        // The image processing compares a dot with its surroundings, for which a margin of a few pixels is left.
        Layout { seen_at_once: 1, margin_px: 3.0 }
    }
}

fn yes() -> bool {
    true
}

fn is_true(is: &bool) -> bool {
    *is
}

fn is_false(is: &bool) -> bool {
    !*is
}

pub(super) fn is_zero(number: &f64) -> bool {
    *number == 0.0
}

fn is_nowhere_else(moved_m: &[f64; 2]) -> bool {
    *moved_m == [0.0; 2]
}

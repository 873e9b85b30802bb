//! Dot-matrix markers on the ceiling (paper 5): what is printed, where it is pasted, and what is wrong with it.

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
    /// The set from which identities are given out.
    pub coding: Coding,
    /// Each centre is drawn within this distance of its place.
    #[schemars(range(min = 0.0, max = 0.1))]
    pub placement_tolerance_m: f64,
    /// Each marker is turned by up to this against its direction.
    #[schemars(range(min = 0.0, max = 45.0))]
    pub rotation_tolerance_deg: f64,
    /// Each dot is drawn within this distance of its place on the marker.
    #[schemars(range(min = 0.0, max = 0.01))]
    pub print_tolerance_m: f64,
    /// Each marker is up to this higher or lower than its height.
    #[schemars(range(min = 0.0, max = 0.5))]
    pub height_tolerance_m: f64,
    /// Coefficient of retroreflection of the dots: luminous intensity per illuminance and area. Glass beads 70, microprisms 400.
    #[schemars(range(min = 0.0, max = 2000.0))]
    pub retroreflection_cd_per_lux_m2: f64,
    /// Share of all markers that has fallen off, without the localizer's knowledge. Each seed draws which.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub share_missing: f64,
    /// The markers, one by one.
    #[serde(rename = "marker")]
    pub markers: Vec<Marker>,
    /// Instead: as few as are proven to be enough for the room and the ceiling camera, with the coding's identities in their order.
    pub layout: Option<Layout>,
    #[serde(skip)]
    pub(crate) laid_out: Vec<Marker>,
}

/// Markers laid out over the room so that some are wholly in the image of the ceiling camera from wherever the robot can be, whatever the errors
/// are within their tolerances.
#[derive(Clone, Debug, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Layout {
    /// Markers in the image at once, at least.
    #[schemars(range(min = 1, max = 4))]
    pub seen_at_once: usize,
    /// Their distance from the edges of the image, at least.
    #[schemars(range(min = 0.0, max = 200.0))]
    pub margin_px: f64,
}

/// One marker: a grid of 4 × 4 places, 4 cm apart, for dots of 1 cm radius. O, at the grid's `[0, 0]`, X at `[3, 0]` and Y at `[0, 3]` tell
/// its direction, the corner `[3, 3]` stays empty, and which of the other twelve dots are there tells its identity.
#[derive(Clone, Debug, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Marker {
    /// What is printed on it: the sum of its coded dots' weights.
    #[schemars(range(min = 0, max = 4095))]
    pub id: u16,
    /// World x of the middle of its grid.
    pub x_m: f64,
    /// World y of the middle of its grid.
    pub y_m: f64,
    /// Angle from world x to the direction from O to X, counter-clockwise seen from above.
    #[serde(default, skip_serializing_if = "is_zero")]
    #[schemars(range(min = -360.0, max = 360.0))]
    pub rotation_deg: f64,
    /// Height above the floor: just under the ceiling, tolerance included, unless stated.
    #[serde(default)]
    #[schemars(range(min = 0.1, max = 20.0))]
    pub height_m: Option<f64>,
    /// Whether the localizer knows of it.
    #[serde(default = "yes", skip_serializing_if = "is_true")]
    pub on_map: bool,
    /// Whether it is on the ceiling; false for one that has fallen off.
    #[serde(default = "yes", skip_serializing_if = "is_true")]
    pub pasted: bool,
    /// How far it has been moved since the map was made, world x and y.
    #[serde(default, skip_serializing_if = "is_nowhere_else")]
    #[schemars(inner(range(min = -200.0, max = 200.0)))]
    pub misplaced_m: [f64; 2],
    /// Places `[i, j]` of the grid whose printed dots have come off, counted from O towards X and towards Y.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub missing_dots: Vec<[u8; 2]>,
    /// Places of the grid at which something else shines that is no print.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub extra_dots: Vec<[u8; 2]>,
    /// Share of its width that is covered, from the side of X. A dot shows while its middle does.
    #[serde(default, skip_serializing_if = "is_zero")]
    #[schemars(range(min = 0.0, max = 1.0))]
    pub covered_share: f64,
    /// Whether the film is pasted the wrong way round, so that X and Y have changed places.
    #[serde(default, skip_serializing_if = "is_false")]
    pub mirrored: bool,
}

/// Which identities are given out, so that a damaged marker is not taken for another one.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Coding {
    /// All 4096, as in paper 5: no error is detected.
    Plain,
    /// 128 words at distance 4: up to 3 wrong dots are detected.
    Lexicode,
    /// 118 words of six dots each at distance 4: besides, any number of missing dots, and mirror images.
    #[default]
    Hexads,
}

impl Coding {
    /// As scenes call it.
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
    /// All markers, stated or laid out.
    pub fn all(&self) -> &[Marker] {
        if self.layout.is_some() { &self.laid_out } else { &self.markers }
    }

    /// Nominal height of a marker above the floor.
    pub fn height_m(&self, marker: &Marker, scene: &Scene) -> f64 {
        marker.height_m.unwrap_or(scene.building.ceiling_height_m - UNDER_CEILING_M - self.height_tolerance_m)
    }

    /// States every marker's nominal height, so that it stays whatever becomes of the tolerance.
    pub(crate) fn state_heights(&mut self, scene: &Scene) {
        let nominal = self.clone();
        for marker in self.markers.iter_mut().chain(&mut self.laid_out) {
            marker.height_m = Some(nominal.height_m(marker, scene));
        }
    }

    /// The keys that state all markers of the map one by one, as a scene has them.
    pub fn keys(&self) -> Result<String, toml::ser::Error> {
        #[derive(Serialize)]
        struct Keys {
            markers: Markers,
        }
        let markers = self.all().iter().filter(|marker| marker.on_map).cloned().collect();
        toml::to_string(&Keys { markers: Markers { markers, layout: None, laid_out: Vec::new(), ..self.clone() } })
    }

    /// What the localizer is told.
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
    /// A whole one along world x.
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

/// What is stuck on the ceiling is seen this far below it; above, the ceiling would hide it.
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
        // Vision compares a dot with its surroundings, which need a few pixels.
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

fn is_zero(number: &f64) -> bool {
    *number == 0.0
}

fn is_nowhere_else(moved_m: &[f64; 2]) -> bool {
    *moved_m == [0.0; 2]
}

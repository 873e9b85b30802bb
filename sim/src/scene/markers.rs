//! Dot-matrix markers on the ceiling (paper 5): what is printed, where it is pasted, and what is wrong with it.

use localizer::{
    Interval,
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
    /// The markers, one by one.
    #[serde(rename = "marker")]
    pub markers: Vec<Marker>,
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
    #[serde(default)]
    #[schemars(range(min = -360.0, max = 360.0))]
    pub rotation_deg: f64,
    /// Height above the floor: just under the ceiling, tolerance included, unless stated.
    #[serde(default)]
    #[schemars(range(min = 0.1, max = 20.0))]
    pub height_m: Option<f64>,
    /// Whether the localizer knows of it.
    #[serde(default = "yes")]
    pub on_map: bool,
    /// Whether it is on the ceiling; false for one that has fallen off.
    #[serde(default = "yes")]
    pub pasted: bool,
    /// Places `[i, j]` of the grid whose printed dots have come off, counted from O towards X and towards Y.
    #[serde(default)]
    pub missing_dots: Vec<[u8; 2]>,
    /// Places of the grid at which something else shines that is no print.
    #[serde(default)]
    pub extra_dots: Vec<[u8; 2]>,
    /// Share of its width that is covered, from the side of X. A dot shows while its middle does.
    #[serde(default)]
    #[schemars(range(min = 0.0, max = 1.0))]
    pub covered_share: f64,
    /// Whether the film is pasted the wrong way round, so that X and Y have changed places.
    #[serde(default)]
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
    /// Nominal height of a marker above the floor.
    pub fn height_m(&self, marker: &Marker, scene: &Scene) -> f64 {
        marker.height_m.unwrap_or(scene.building.ceiling_height_m - UNDER_CEILING_M - self.height_tolerance_m)
    }

    /// What the localizer is told.
    pub(super) fn map(&self, scene: &Scene) -> MarkerMap {
        let placed = |marker: &Marker| PlacedMarker {
            id: MarkerId(marker.id),
            centre_m: [marker.x_m, marker.y_m],
            rotation_rad: marker.rotation_deg.to_radians(),
            height_m: Interval::centred(self.height_m(marker, scene), self.height_tolerance_m),
        };
        MarkerMap {
            coding: self.coding.into(),
            markers: self.markers.iter().filter(|marker| marker.on_map).map(placed).collect(),
            placement_m: self.placement_tolerance_m,
            rotation_tolerance_rad: self.rotation_tolerance_deg.to_radians(),
            print_m: self.print_tolerance_m,
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
            markers: Vec::new(),
        }
    }
}

fn yes() -> bool {
    true
}

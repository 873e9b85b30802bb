//! A scene: the situation of a run as its TOML file states it. A `Scene` that exists is valid.
//!
//! Every key has a default that a user would expect, and a unit in its name where it has one. `scenes/schema.json` is made
//! from these structs, so that their doc comments are what an editor shows. Ranges stand once, in the `schemars`
//! attributes: the schema carries them, and `parse` holds each file against that same schema.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

mod bounds;
mod building;
mod careful;
pub(crate) mod conform;
mod devices;
pub(crate) mod error;
mod events;
mod expect;
mod extend;
mod floor;
mod lamps;
mod markers;
mod navigation;
mod occupancy_grid;
mod plan;
mod robot;
mod robot_preset;
mod route;
mod keys_page;
pub(crate) mod schema;
mod sensor;
mod things;
mod wall_directions;

pub use bounds::Bounds;
pub use building::{Building, Covering, Door, Dot, FurtherRoom, Picture};
pub use careful::BoundsFrom;
pub use devices::*;
pub use error::SceneError;
pub use events::{Event, Side, Stuck};
pub use expect::Expect;
pub use extend::Sources;
pub use floor::{Floor, Misplaced, Pattern, Region, Stray, Tiles};
pub use keys_page::keys_markdown;
pub use lamps::{Lamp, LampKind, MAX_LAMPS, Spectrum};
pub(crate) use markers::UNDER_CEILING_M;
pub use markers::{Coding, Layout, Marker, Markers};
pub use navigation::{Errand, FollowerName, Navigation};
pub use occupancy_grid::{Cell, OccupancyGrid};
pub(crate) use plan::Plan;
pub use robot::{Distribution, Robot, RobotPreset};
pub use route::{Route, Spread, Start, Station, Waypoint};
pub use schema::schema_text;
pub use sensor::{BitDepth, Sensor, SensorModel, SensorPreset};
pub use things::{Furniture, Landmark, Person};
pub use wall_directions::{WallDirectionsChain, WallDirectionsSetup};

/// One situation: room, floor, light, robot, route, what happens, what is declared and what is expected.
#[derive(Clone, Debug, Deserialize, Serialize, JsonSchema)]
// `Scene` deserialises by way of the bounds that it does not state; what is derived here is the last step of that.
#[serde(deny_unknown_fields, remote = "Self")]
#[schemars(rename = "Scene")]
pub struct Scene {
    /// One sentence for the result table.
    #[serde(default)]
    pub description: String,
    /// From where tolerances and bounds come that the scene does not state.
    #[serde(default)]
    pub bounds_from: BoundsFrom,
    /// Length of a run of a route. Ignored when stations are given.
    #[serde(default = "default_duration_s")]
    #[schemars(range(max = 36000.0), extend("exclusiveMinimum" = 0.0))]
    pub duration_s: f64,
    /// The room, an axis-aligned rectangle with a corner at the world origin.
    pub room: Room,
    /// What the robot drives on.
    #[serde(default)]
    pub floor: Floor,
    /// How bright it is.
    #[serde(default)]
    pub light: Light,
    /// What stands about and above the floor.
    #[serde(default)]
    pub building: Building,
    /// Markers on the ceiling.
    #[serde(default)]
    pub markers: Option<Markers>,
    /// Where the light comes from.
    #[serde(default, rename = "lamp")]
    pub lamps: Vec<Lamp>,
    /// What stands in the room.
    #[serde(default)]
    pub furniture: Vec<Furniture>,
    /// Who walks in it.
    #[serde(default, rename = "person")]
    pub people: Vec<Person>,
    /// Coded landmarks for a range camera, numbered from 0 in the order of the file.
    #[serde(default, rename = "landmark")]
    pub landmarks: Vec<Landmark>,
    /// The robot: a Pioneer P3-DX unless stated otherwise, key by key or by its `preset`.
    #[serde(default)]
    pub robot: Robot,
    /// Where the robot stands at time 0, and how well the localizer knows it.
    pub start: Start,
    /// The drive; a scene has a route, errands or stations.
    #[serde(default)]
    pub route: Option<Route>,
    /// How errands are planned and driven.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub navigation: Option<Navigation>,
    /// Places to find a way to, one after the other, instead of a route.
    #[serde(default, rename = "errand", skip_serializing_if = "Vec::is_empty")]
    pub errands: Vec<Errand>,
    /// Still poses for accuracy tables, instead of a drive.
    #[serde(default, rename = "station")]
    pub stations: Vec<Station>,
    /// More still poses, spread over the room.
    #[serde(default)]
    pub station_spread: Option<Spread>,
    /// What happens during the run.
    #[serde(default, rename = "event")]
    pub events: Vec<Event>,
    /// Bounds of emergent quantities, declared to the localizer.
    #[serde(default)]
    pub bounds: Bounds,
    /// How the localizer is set up.
    #[serde(default)]
    pub localizer: LocalizerSetup,
    /// What the verdict asks of each run.
    #[serde(default)]
    pub expect: Expect,
}

impl Scene {
    /// Whether the scene's robot has a camera whose pictures have to be rendered, so that a run needs a graphics adapter.
    pub fn has_camera(&self) -> bool {
        !self.robot.cameras().is_empty()
    }

    /// Whether the robot is led along its route, whatever it believes.
    pub fn is_led(&self) -> bool {
        self.route.as_ref().is_some_and(|route| route.led)
    }

    /// How errands are driven, as by default unless stated.
    pub fn navigation(&self) -> Navigation {
        self.navigation.clone().unwrap_or_default()
    }

    /// Whether the robot finds its own way to goals.
    pub fn has_errands(&self) -> bool {
        !self.errands.is_empty() || self.navigation.as_ref().is_some_and(|navigation| navigation.random_goals > 0)
    }
}

/// An axis-aligned rectangular room, `0 ≤ x ≤ width_m`, `0 ≤ y ≤ depth_m` between the inner faces of its walls.
#[derive(Clone, Debug, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Room {
    /// Extent along world x.
    #[schemars(range(min = 0.5, max = 200.0))]
    pub width_m: f64,
    /// Extent along world y.
    #[schemars(range(min = 0.5, max = 200.0))]
    pub depth_m: f64,
}

/// Light on the floor.
#[derive(Clone, Debug, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Light {
    /// Mean illuminance at the floor. Without effect when each `[[lamp]]` states its own output.
    #[schemars(range(min = 0.0, max = 100000.0))]
    pub illuminance_at_floor_lux: f64,
    /// Instead: illuminance on an upright plane at the forward camera's lens, facing as the camera does, with the robot at
    /// its start. Dims all lamps alike.
    #[schemars(range(min = 0.0, max = 100000.0))]
    pub illuminance_at_camera_lux: Option<f64>,
    /// Brightest over darkest place of the room's floor, when there is no `[[lamp]]`.
    #[schemars(range(min = 1.0, max = 1000.0))]
    pub unevenness_ratio: f64,
    /// Direction in which the floor grows brighter, from world x. Any angle.
    pub unevenness_direction_deg: f64,
}

impl Default for Light {
    fn default() -> Self {
        Light {
            illuminance_at_floor_lux: 300.0,
            illuminance_at_camera_lux: None,
            unevenness_ratio: 1.5,
            unevenness_direction_deg: 30.0,
        }
    }
}

/// How the localizer is set up.
#[derive(Clone, Debug, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct LocalizerSetup {
    /// The methods that read the sensors besides the wheels.
    pub methods: Vec<MethodName>,
    /// Vision chain of `floor_tiles`.
    pub floor_tiles_chain: FloorTilesChain,
    /// What `range_landmarks` solves for.
    pub range_landmarks_freedom: RangeLandmarksFreedom,
    /// How `range_landmarks` solves it.
    pub range_landmarks_solver: RangeLandmarksSolver,
    /// What `wall_directions` knows and how it looks.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub wall_directions: Option<WallDirectionsSetup>,
    /// Learn the gyroscope's bias and scale between fixes of the heading, and at rest where `bounds.rest_turn_deg` is stated.
    pub learns_gyro: bool,
    /// An estimate counts as available while it is sound, holds the truth, and its hull is narrower than this in x and y. Less than the walls
    /// leave to the middle of the robot's body.
    #[schemars(range(max = 100.0), extend("exclusiveMinimum" = 0.0))]
    pub declared_width_m: f64,
    /// An estimate counts as available while it is sound, holds the truth, and its hull is narrower than this in heading. Less than 360.
    #[schemars(range(max = 360.0), extend("exclusiveMinimum" = 0.0))]
    pub declared_width_deg: f64,
}

impl Default for LocalizerSetup {
    fn default() -> Self {
        LocalizerSetup {
            methods: vec![MethodName::FloorTiles],
            floor_tiles_chain: FloorTilesChain::Direct,
            range_landmarks_freedom: RangeLandmarksFreedom::Full,
            range_landmarks_solver: RangeLandmarksSolver::OneShot,
            wall_directions: None,
            learns_gyro: false,
            declared_width_m: 0.05,
            declared_width_deg: 5.0,
        }
    }
}

impl LocalizerSetup {
    /// How `wall_directions` is set up, as by default unless stated.
    pub fn wall_directions(&self) -> WallDirectionsSetup {
        self.wall_directions.clone().unwrap_or_default()
    }
}

/// What `range_landmarks` solves for; the rest it takes from what is known besides.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum RangeLandmarksFreedom {
    /// World x (paper 3, Table II).
    Line,
    /// World x and y (Table III).
    Translation,
    /// World x, y and heading (Table IV).
    #[default]
    Full,
}

/// How `range_landmarks` solves the pose when all three of it are free.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum RangeLandmarksSolver {
    /// Linear elimination, no bisection.
    #[default]
    OneShot,
    /// The polar contractor to its fixpoint.
    Polar,
    /// Paper 3's Table IV with correct branches, to its fixpoint.
    TableIv,
    /// Paper 3's set inversion with a resolution of 0.05 m and 0.05 rad.
    Sivia,
}

/// How `floor_tiles` finds joints in an image.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum FloorTilesChain {
    /// Ridge points, one vote for both families, matched filters across each line.
    #[default]
    Direct,
    /// Paper 1: deconvolution, Canny, skeleton, pruning, Hough, clustering.
    Paper,
}

fn default_duration_s() -> f64 {
    60.0
}

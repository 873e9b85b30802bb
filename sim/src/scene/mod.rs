//! A scene: the description of one run's situation, as its TOML file states it. A `Scene` value is always valid.
//!
//! Every key has a default that a user would expect, and a unit in its name where it has one. `scenes/schema.json` is generated from these structs,
//! so an editor shows their doc comments. Each range is stated once, in the `schemars` attributes: the schema carries it, and `parse` checks every
//! file against that same schema.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

mod base;
mod bounds;
mod building;
mod careful;
pub(crate) mod conform;
mod devices;
mod error;
mod events;
mod expect;
mod extend;
mod filters;
mod floor;
mod further_room;
mod lamps;
mod landmark_map;
mod log;
mod mapped_landmarks;
mod markers;
pub(crate) mod moved;
mod navigation;
mod occupancy_grid;
mod outdoors;
mod plan;
pub(crate) mod problem;
mod robot;
mod robot_preset;
mod route;
mod keys_page;
pub(crate) mod schema;
mod sensor;
mod sources;
mod things;
mod wall_bearings;
mod wall_directions;
mod wall_ranges;

pub(crate) use base::with_every_base;
pub use base::{Ackermann, Base, BaseKind, Differential};
pub use bounds::Bounds;
pub use building::{Building, Covering, Door, Dot, Facade, Picture};
pub use careful::BoundsFrom;
pub use devices::*;
pub use error::SceneError;
pub use events::{Event, Side, Stuck};
pub use expect::Expect;
pub(crate) use extend::text_of;
pub(crate) use filters::FACTORS;
pub use filters::{FilterNoise, Filters};
pub use floor::{Floor, Misplaced, Pattern, Region, Stray, Tiles};
pub use further_room::FurtherRoom;
pub(crate) use further_room::RoomShape;
pub use keys_page::keys_markdown;
pub use lamps::{Lamp, LampKind, MAX_LAMPS, Spectrum};
pub use landmark_map::{LandmarkMap, TrueEye};
pub use log::{Datum, ImuMount, Joints, Log, LoggedTruth, OdometryLaw, Stamps, Topics, UpAxis};
pub use mapped_landmarks::MappedLandmarksSetup;
pub(crate) use markers::UNDER_CEILING_M;
pub use markers::{Coding, Layout, Marker, Markers};
pub use navigation::{Errand, FollowerName, Navigation};
pub use occupancy_grid::{Cell, OccupancyGrid};
pub use outdoors::{Outdoors, Sky};
pub(crate) use plan::Plan;
pub use robot::{Distribution, Robot, RobotPreset};
pub use route::{Route, Spread, Start, Station, Waypoint};
pub use schema::schema_text;
pub use sensor::{BitDepth, Sensor, SensorModel, SensorPreset};
pub use sources::Sources;
pub use things::{Furniture, Landmark, Person};
pub use wall_bearings::WallBearingsSetup;
pub use wall_directions::{WallDirectionsChain, WallDirectionsSetup};
pub use wall_ranges::WallRangesSetup;

/// One situation to simulate: room, floor, light, robot, route, events, declared bounds and expected results.
#[derive(Clone, Debug, Deserialize, Serialize, JsonSchema)]
// `Scene` is deserialised in two steps: bounds that the file does not state are filled in first, and the function derived here does the rest.
#[serde(deny_unknown_fields, remote = "Self")]
#[schemars(rename = "Scene")]
pub struct Scene {
    /// Description of the scene in one sentence, for the table of results.
    #[serde(default)]
    pub description: String,
    /// Where those tolerances and bounds come from that the scene itself does not state.
    #[serde(default)]
    pub bounds_from: BoundsFrom,
    /// Length of the run. Without effect when the robot stands at stations instead of driving.
    #[serde(default = "default_duration_s")]
    #[schemars(range(max = 36000.0), extend("exclusiveMinimum" = 0.0))]
    pub duration_s: f64,
    /// Room that the robot drives in, with one corner at the world origin.
    pub room: Room,
    /// Floor of the room: tiles or covering, friction, regions with properties of their own, and things that lie on the floor.
    #[serde(default)]
    pub floor: Floor,
    /// Brightness of the light, and how evenly it falls on the floor.
    #[serde(default)]
    pub light: Light,
    /// Open sky in place of ceilings and lamps, if the scene has this table.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub outdoors: Option<Outdoors>,
    /// Everything around and above the floor that cameras looking ahead or up can see: ceilings, walls, doors, pictures, further rooms.
    #[serde(default)]
    pub building: Building,
    /// Markers of retro-reflective dots on the ceiling, for a camera that looks up.
    #[serde(default)]
    pub markers: Option<Markers>,
    /// Lamps and windows that light the room.
    #[serde(default, rename = "lamp")]
    pub lamps: Vec<Lamp>,
    /// Pieces of furniture in the building.
    #[serde(default)]
    pub furniture: Vec<Furniture>,
    /// People who walk about in the building.
    #[serde(default, rename = "person")]
    pub people: Vec<Person>,
    /// Coded landmarks for a range camera, numbered from 0 in the order of the file.
    #[serde(default, rename = "landmark")]
    pub landmarks: Vec<Landmark>,
    /// Robot of the scene: a Pioneer P3-DX unless its `preset` or single keys state otherwise.
    #[serde(default)]
    pub robot: Robot,
    /// Pose of the robot at time 0, and the tolerances within which the localizer knows it.
    pub start: Start,
    /// Drive along given waypoints. A scene has one of three: a route, errands (goals to drive to) or stations (poses to stand at).
    #[serde(default)]
    pub route: Option<Route>,
    /// Settings for errands, which are goals to which the robot finds its own path.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub navigation: Option<Navigation>,
    /// Errands: goals to which the robot finds its own path, one after the other, instead of a route.
    #[serde(default, rename = "errand", skip_serializing_if = "Vec::is_empty")]
    pub errands: Vec<Errand>,
    /// Stations: poses at which the robot is put and stands still, for tables of accuracy, instead of a drive.
    #[serde(default, rename = "station")]
    pub stations: Vec<Station>,
    /// Further stations (poses at which the robot stands still), spread over the room.
    #[serde(default)]
    pub station_spread: Option<Spread>,
    /// Events during the run.
    #[serde(default, rename = "event")]
    pub events: Vec<Event>,
    /// Bounds on slip, speed, tilt and the like.
    #[serde(default)]
    pub bounds: Bounds,
    /// Setup of the localizer: its methods, and when its estimate counts as available.
    #[serde(default)]
    pub localizer: LocalizerSetup,
    /// Noise settings of the built-in filters, `--subject ekf` and `--subject particles`.
    #[serde(default, skip_serializing_if = "Filters::is_usual")]
    pub filters: Filters,
    /// How a log that another program recorded is read, for `wherein replay --robot`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub log: Option<Log>,
    /// Limits that the results of every run must keep for its verdict to pass.
    #[serde(default)]
    pub expect: Expect,
}

impl Scene {
    /// Whether the scene's robot has a camera whose pictures have to be rendered, so that a run needs a graphics adapter.
    pub fn has_camera(&self) -> bool {
        !self.robot.cameras().is_empty()
    }

    /// Whether the robot is steered along its route by its true pose instead of its estimated pose.
    pub fn is_led(&self) -> bool {
        self.route.as_ref().is_some_and(|route| route.led)
    }

    /// Settings for errands (goals to which the robot finds its own path): those of the scene, or the defaults if the scene states none.
    pub fn navigation(&self) -> Navigation {
        self.navigation.clone().unwrap_or_default()
    }

    /// Whether the robot is given goals and finds its own path to them.
    pub fn has_errands(&self) -> bool {
        !self.errands.is_empty() || self.navigation.as_ref().is_some_and(|navigation| navigation.random_goals > 0)
    }
}

/// An axis-aligned rectangular room: `0 ≤ x ≤ width_m` and `0 ≤ y ≤ depth_m` between the inner faces of its walls.
#[derive(Clone, Debug, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Room {
    /// Extent of the room along world x.
    #[schemars(range(min = 0.5, max = 200.0))]
    pub width_m: f64,
    /// Extent of the room along world y.
    #[schemars(range(min = 0.5, max = 200.0))]
    pub depth_m: f64,
}

/// Brightness of the light, and how evenly it falls on the floor.
#[derive(Clone, Debug, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Light {
    /// Mean illuminance at the floor. Without effect when every `[[lamp]]` states its own output.
    #[schemars(range(min = 0.0, max = 100000.0))]
    pub illuminance_at_floor_lux: f64,
    /// Illuminance at the forward camera's lens, on an upright plane that faces as the camera does, with the robot at its start. Stated in place of
    /// `illuminance_at_floor_lux`; all lamps are dimmed alike to reach it.
    #[schemars(range(min = 0.0, max = 100000.0))]
    pub illuminance_at_camera_lux: Option<f64>,
    /// Ratio of the brightest to the darkest place of the room's floor, when there is no `[[lamp]]`.
    #[schemars(range(min = 1.0, max = 1000.0))]
    pub unevenness_ratio: f64,
    /// Direction in which the floor grows brighter, measured from world x. Any angle.
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

/// Setup of the localizer: its methods, and when its estimate counts as available.
#[derive(Clone, Debug, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct LocalizerSetup {
    /// Methods by which the localizer reads sensors other than the wheel encoders.
    pub methods: Vec<MethodName>,
    /// Whether the scene states the methods. Those that it does not state may be without anything to read.
    #[serde(skip)]
    pub(crate) states_methods: bool,
    /// Image processing by which the method `floor_tiles` finds joints between tiles.
    pub floor_tiles_chain: FloorTilesChain,
    /// Components of the pose for which the method `range_landmarks` solves. The other components stay as they were estimated before.
    pub range_landmarks_freedom: RangeLandmarksFreedom,
    /// Algorithm by which the method `range_landmarks` solves for the pose when x, y and heading are all free.
    pub range_landmarks_solver: RangeLandmarksSolver,
    /// Setup of the method `wall_directions`, which finds the heading by level edges in images: what it knows of the building's walls, and how it
    /// finds the edges.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub wall_directions: Option<WallDirectionsSetup>,
    /// Setup of the method `mapped_landmarks`, which locates the robot by landmarks in space: what it knows of them beforehand, and whether it learns
    /// more.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub mapped_landmarks: Option<MappedLandmarksSetup>,
    /// Setup of the method `wall_ranges`, which locates the robot by the distances of walls: what it knows of the building's walls.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub wall_ranges: Option<WallRangesSetup>,
    /// Setup of the method `wall_bearings`, which locates the robot by upright edges of walls: how many sightings of them may be false.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub wall_bearings: Option<WallBearingsSetup>,
    /// Whether the localizer learns the gyroscope's bias and scale: from the turns between fixes of the heading by other sensors, and, where
    /// `bounds.rest_turn_deg` is stated, also while the robot rests.
    pub learns_gyro: bool,
    /// Number of key frames of a window in which the poses of a drive are bounded once more at its end, by what was read after them as well as before
    /// (post-localization, paper 4's PL). A key frame is kept about each second; none is dropped on the way, so that estimates differ a little from
    /// those without this key. Of a drive with a doubt only what follows is bounded. Unless given, that is not done.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 2, max = 1000))]
    pub post_window: Option<usize>,
    /// An estimate counts as available while its status is sound, its boxes contain the truth, and their hull is narrower than this in x and in y.
    /// Must be less than the width, in x and in y, that the walls leave to the middle of the robot's body.
    #[schemars(range(max = 100.0), extend("exclusiveMinimum" = 0.0))]
    pub declared_width_m: f64,
    /// An estimate counts as available while its status is sound, its boxes contain the truth, and their hull is narrower than this in heading. Must
    /// be less than 360.
    #[schemars(range(max = 360.0), extend("exclusiveMinimum" = 0.0))]
    pub declared_width_deg: f64,
}

impl Default for LocalizerSetup {
    fn default() -> Self {
        LocalizerSetup {
            methods: vec![MethodName::FloorTiles],
            states_methods: false,
            floor_tiles_chain: FloorTilesChain::Direct,
            range_landmarks_freedom: RangeLandmarksFreedom::Full,
            range_landmarks_solver: RangeLandmarksSolver::OneShot,
            wall_directions: None,
            mapped_landmarks: None,
            wall_ranges: None,
            wall_bearings: None,
            learns_gyro: false,
            post_window: None,
            declared_width_m: 0.05,
            declared_width_deg: 5.0,
        }
    }
}

impl LocalizerSetup {
    /// Setup of the method `wall_directions`, which finds the heading by level edges in images: the scene's, or the default if the scene states none.
    pub fn wall_directions(&self) -> WallDirectionsSetup {
        self.wall_directions.clone().unwrap_or_default()
    }

    /// Setup of the method `mapped_landmarks`, which locates the robot by landmarks in space: the scene's, or the default if the scene states none.
    pub fn mapped_landmarks(&self) -> MappedLandmarksSetup {
        self.mapped_landmarks.clone().unwrap_or_default()
    }

    /// The camera that truly took a picture of the drives that taught the scene's map, given by the picture's place on the map, if the map tells it.
    pub fn true_eye(&self, picture: usize) -> Option<&TrueEye> {
        self.mapped_landmarks.as_ref()?.known.as_ref()?.true_eyes.get(picture)
    }

    /// Makes a map known, as if a file of it had been read.
    #[cfg(test)]
    pub(crate) fn know(&mut self, map: LandmarkMap) {
        self.mapped_landmarks.get_or_insert_default().known = Some(map);
    }

    /// Whether the drive is to teach a map of landmarks in space.
    pub fn teaches_map(&self) -> bool {
        self.mapped_landmarks.as_ref().is_some_and(|setup| setup.teaches)
    }

    /// Setup of the method `wall_ranges`, which locates the robot by the distances of walls: the scene's, or the default if the scene states none.
    pub fn wall_ranges(&self) -> WallRangesSetup {
        self.wall_ranges.clone().unwrap_or_default()
    }

    /// Setup of the method `wall_bearings`, which locates the robot by upright edges of walls: the scene's, or the default if the scene states none.
    pub fn wall_bearings(&self) -> WallBearingsSetup {
        self.wall_bearings.clone().unwrap_or_default()
    }
}

/// Components of the pose for which the method `range_landmarks` solves. The other components stay as they were estimated before.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum RangeLandmarksFreedom {
    /// Solves for the robot's world x only (paper 3, Table II).
    Line,
    /// Solves for the robot's world x and y (paper 3, Table III).
    Translation,
    /// Solves for the robot's world x, y and heading (paper 3, Table IV).
    #[default]
    Full,
}

/// Algorithm by which the method `range_landmarks` solves for the pose when x, y and heading are all free.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum RangeLandmarksSolver {
    /// Linear elimination over all landmarks at once, without bisecting boxes of poses.
    #[default]
    OneShot,
    /// Contraction of the box of poses by each landmark in polar coordinates, until it shrinks no further.
    Polar,
    /// Contraction of the box of poses by paper 3's Table IV, with all branches of its inverse functions, until it shrinks no further.
    TableIv,
    /// Bisection of boxes of poses by paper 3's set inversion, with a resolution of 0.05 m and 0.05 rad.
    Sivia,
}

/// Image processing by which the method `floor_tiles` finds joints between tiles.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum FloorTilesChain {
    /// Direct processing chain for finding joints: ridge points, one vote for both families of joints, then matched filters across each line.
    #[default]
    Direct,
    /// Paper 1's processing chain for finding joints: deconvolution, Canny edges, skeleton, pruning, Hough transform, clustering.
    Paper,
}

fn default_duration_s() -> f64 {
    60.0
}

//! What stands and walks in the room: furniture, people, coded landmarks.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// A piece of furniture: an upright box on the floor, such as a cupboard, a table with a cloth or a partition wall. It stops robots and blocks light
/// and sight.
#[derive(Clone, Debug, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Furniture {
    /// Name of the piece of furniture, for messages and maps.
    #[serde(default)]
    pub name: String,
    /// World x of the middle of the piece of furniture.
    pub x_m: f64,
    /// World y of the middle of the piece of furniture.
    pub y_m: f64,
    /// Length and width of the piece of furniture.
    #[schemars(inner(range(min = 0.01, max = 100.0)))]
    pub size_m: [f64; 2],
    /// Height of the piece of furniture.
    #[serde(default = "default_furniture_height_m")]
    #[schemars(range(max = 10.0), extend("exclusiveMinimum" = 0.0))]
    pub height_m: f64,
    /// Direction of the furniture's length, counter-clockwise from world x. Any angle.
    #[serde(default)]
    pub rotation_deg: f64,
    /// Whether the map on which the robot plans its paths shows the piece of furniture; true unless stated. One that is not on the map stands
    /// unforeseen in the robot's way.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub mapped: Option<bool>,
    /// Whether the piece of furniture is a wall of the building, such as a partition: it stands as the building does, is never askew by itself, and
    /// is on the localizer's map.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub wall: bool,
    /// Share of the light that the piece of furniture throws back, as a matt surface.
    #[serde(default = "default_furniture_albedo")]
    #[schemars(range(min = 0.0, max = 1.0))]
    pub albedo: f64,
    /// Share of the light that the faces of the furniture mirror at perpendicular incidence, as a varnish does, so that lamps glint in them. 0.04 for
    /// most varnishes, 0 for matt faces.
    #[serde(default)]
    #[schemars(range(min = 0.0, max = 0.2))]
    pub gloss: f64,
    /// Blur of what the furniture's faces mirror: standard deviation of the direction of mirrored light, about each axis.
    #[serde(default = "default_furniture_roughness_deg")]
    #[schemars(range(min = 0.1, max = 20.0))]
    pub roughness_deg: f64,
    /// Number of the books that stand in the furniture's upright faces, as in open shelves; each number shows others. Plain faces unless stated.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(range(max = 65535))]
    pub books: Option<u32>,
}

/// A person who walks to and fro along a polyline and stands still while the robot is in the way.
#[derive(Clone, Debug, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Person {
    /// World x and y of the points that the person walks to, one after the other and back again.
    #[schemars(length(min = 1))]
    pub waypoints_m: Vec<[f64; 2]>,
    /// Walking speed of the person.
    #[serde(default = "default_walking_speed")]
    #[schemars(range(min = 0.0, max = 3.0))]
    pub speed_m_per_s: f64,
    /// Radius of the upright cylinder that stands for the person's body.
    #[serde(default = "default_person_radius_m")]
    #[schemars(range(min = 0.05, max = 1.0))]
    pub radius_m: f64,
    /// Height of the person.
    #[serde(default = "default_person_height_m")]
    #[schemars(range(min = 0.2, max = 2.5))]
    pub height_m: f64,
}

/// A landmark with a code on it, for a range camera. The localizer is not given its position.
#[derive(Clone, Debug, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Landmark {
    /// World x of the landmark.
    pub x_m: f64,
    /// World y of the landmark.
    pub y_m: f64,
    /// Height of the landmark above the floor.
    #[serde(default = "default_landmark_height_m")]
    #[schemars(range(min = 0.0, max = 10.0))]
    pub height_m: f64,
}

impl Furniture {
    /// The piece in a message: its key in the scene's list, where it has the given number, and its name if it has one.
    pub(crate) fn told(&self, number: usize) -> String {
        if self.name.is_empty() {
            format!("furniture[{number}]")
        } else {
            format!("furniture[{number}] ({})", self.name)
        }
    }

    /// Whether the map on which the robot plans its paths shows this piece of furniture; true unless the scene states otherwise.
    pub fn is_mapped(&self) -> bool {
        self.mapped.unwrap_or(true)
    }

    /// Distance on the floor from a position to the furniture's footprint; 0 inside the footprint.
    pub fn distance_m(&self, place_m: [f64; 2]) -> f64 {
        let (sin, cos) = self.rotation_deg.to_radians().sin_cos();
        let (x_m, y_m) = (place_m[0] - self.x_m, place_m[1] - self.y_m);
        let beyond = |along_m: f64, extent_m: f64| (along_m.abs() - 0.5 * extent_m).max(0.0);
        beyond(cos * x_m + sin * y_m, self.size_m[0]).hypot(beyond(cos * y_m - sin * x_m, self.size_m[1]))
    }
}

fn default_furniture_height_m() -> f64 {
    0.75
}

fn default_furniture_albedo() -> f64 {
    0.4
}

fn default_furniture_roughness_deg() -> f64 {
    5.0
}

fn default_walking_speed() -> f64 {
    0.8
}

fn default_person_radius_m() -> f64 {
    0.25
}

fn default_person_height_m() -> f64 {
    1.7
}

fn default_landmark_height_m() -> f64 {
    0.5
}

//! Rooms beside the room that the robot drives in: rectangles or any simple polygons.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize, Serializer};

/// A room beside the room that the robot drives in: a rectangle at any angle by `x_m`, `y_m`, `heading_deg`, `width_m` and `depth_m`, or any polygon
/// by `corners_m`.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct FurtherRoom {
    /// World x of one corner of a further room that is a rectangle. Such a room states `y_m`, `width_m` and `depth_m`, too, and no `corners_m`.
    #[serde(default)]
    pub x_m: Option<f64>,
    /// World y of the further room's corner at `x_m`.
    #[serde(default)]
    pub y_m: Option<f64>,
    /// Direction, measured from world x, of the further room's side that begins at its corner at `x_m` and `y_m` and is `width_m` long; 0 unless
    /// stated. The side of length `depth_m` begins at the same corner, at a right angle to the left.
    #[serde(default)]
    #[schemars(range(min = -360.0, max = 360.0))]
    pub heading_deg: Option<f64>,
    /// Length of the further room's side along `heading_deg`.
    #[serde(default)]
    #[schemars(range(min = 0.5, max = 200.0))]
    pub width_m: Option<f64>,
    /// Length of the further room's side at a right angle to `heading_deg`.
    #[serde(default)]
    #[schemars(range(min = 0.5, max = 200.0))]
    pub depth_m: Option<f64>,
    /// World x and y of the corners of a further room that is a polygon, convex or not, in order either way round, in place of the keys of a
    /// rectangle. Its sides are at least 5 cm long and touch each other only at the corners, and it has 0.25 m² or more.
    #[serde(default)]
    #[schemars(length(min = 3, max = 64))]
    pub corners_m: Option<Vec<[f64; 2]>>,
}

/// What a further room is on the floor plan.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum RoomShape<'a> {
    /// A rectangle.
    Rectangle {
        /// One corner, world frame.
        corner_m: [f64; 2],
        /// Direction of the side of length `width_m`, measured from world x; that of length `depth_m` is a quarter turn to its left.
        heading_deg: f64,
        width_m: f64,
        depth_m: f64,
    },
    /// A simple polygon.
    Polygon {
        /// Corners in order, either way round, world frame.
        corners_m: &'a [[f64; 2]],
    },
}

impl FurtherRoom {
    /// What the room is on the floor plan.
    pub(crate) fn shape(&self) -> RoomShape<'_> {
        let rectangle = self.x_m.zip(self.y_m).zip(self.width_m.zip(self.depth_m));
        match (&self.corners_m, rectangle) {
            (None, Some(((x_m, y_m), (width_m, depth_m)))) => {
                let heading_deg = self.heading_deg.unwrap_or(0.0);
                RoomShape::Rectangle { corner_m: [x_m, y_m], heading_deg, width_m, depth_m }
            }
            (corners_m, _) => RoomShape::Polygon { corners_m: corners_m.as_deref().unwrap_or_default() },
        }
    }

    /// Turns the room by an angle about a point, whose turn of a position is `stands`.
    pub(super) fn turn(&mut self, turn_deg: f64, stands: impl Fn([f64; 2]) -> [f64; 2]) {
        match (&mut self.corners_m, self.x_m.zip(self.y_m)) {
            (Some(corners_m), _) => corners_m.iter_mut().for_each(|corner_m| *corner_m = stands(*corner_m)),
            (None, Some((x_m, y_m))) => {
                let [x_m, y_m] = stands([x_m, y_m]);
                (self.x_m, self.y_m) = (Some(x_m), Some(y_m));
                self.heading_deg = Some(self.heading_deg.unwrap_or(0.0) + turn_deg);
            }
            (None, None) => {}
        }
    }

    /// Directions of the room's walls, measured from world x, modulo 90: that of a rectangle's first side, or those of all sides of a polygon, each
    /// once.
    pub(super) fn wall_directions_deg(&self) -> Vec<f64> {
        // Angle below which two sides have the same direction: no map states directions more finely.
        const SAME_DEG: f64 = 1e-6;
        let corners_m = match self.shape() {
            RoomShape::Rectangle { heading_deg, .. } => return vec![heading_deg],
            RoomShape::Polygon { corners_m } => corners_m,
        };
        let mut found: Vec<f64> = Vec::new();
        for (index, from_m) in corners_m.iter().enumerate() {
            let to_m = corners_m[(index + 1) % corners_m.len()];
            let deg = (to_m[1] - from_m[1]).atan2(to_m[0] - from_m[0]).to_degrees().rem_euclid(90.0);
            let is_same = |other: &f64| {
                let apart_deg = (deg - other).rem_euclid(90.0);
                apart_deg.min(90.0 - apart_deg) < SAME_DEG
            };
            if !found.iter().any(is_same) {
                found.push(deg);
            }
        }
        found
    }
}

impl Serialize for FurtherRoom {
    /// Writes the keys of the room's shape, and those alone: a scene with rectangles has the same text as before there were polygons.
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        #[derive(Serialize)]
        struct Rectangle {
            x_m: f64,
            y_m: f64,
            heading_deg: f64,
            width_m: f64,
            depth_m: f64,
        }
        #[derive(Serialize)]
        struct Polygon<'a> {
            corners_m: &'a [[f64; 2]],
        }
        match self.shape() {
            RoomShape::Rectangle { corner_m: [x_m, y_m], heading_deg, width_m, depth_m } => {
                Rectangle { x_m, y_m, heading_deg, width_m, depth_m }.serialize(serializer)
            }
            RoomShape::Polygon { corners_m } => Polygon { corners_m }.serialize(serializer),
        }
    }
}

//! Proof that the ceiling camera surely sees enough markers from every pose that the robot can take.
//!
//! ```text
//! keys ──> Field: edges of the image as planes, all tolerances ──> boxes of poses, halved until enough markers are surely in view ──> Coverage
//! ```
//!
//! A point is in the image if it lies on the inner side of the four planes through the optical centre and the image's edges. The camera's
//! attitude is a turn about the vertical, known with the heading, times an error rotation of at most the tilts of body and mount together.
//! A rotation turns a direction by at most its own angle, so that a direction that lies farther than that inside all planes stays inside.

mod field;
mod kept;
mod lattice;

use std::{
    collections::VecDeque,
    f64::consts::{PI, TAU},
    rc::Rc,
};

use localizer::Pose;

use crate::scene::{Layout, Markers, RoomShape, Scene};

pub use field::Field;
pub use kept::smallest_kept;
pub use lattice::{Ceiling, Unlaid, smallest};

/// The goal of a marker coverage: what the ceiling camera has to see from every pose.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Goal {
    /// Least number of markers that must lie wholly in the ceiling camera's image at once.
    pub seen_at_once: usize,
    /// Least distance from the edges of the ceiling camera's image that a marker must have to count as seen.
    pub margin_px: f64,
}

impl Default for Goal {
    fn default() -> Self {
        let Layout { seen_at_once, margin_px } = Layout::default();
        Goal { seen_at_once, margin_px }
    }
}

impl Markers {
    /// Goal for the scene's ceiling markers: how many of them the ceiling camera has to see from everywhere. It is that of the layout that
    /// the scene demands, or the default.
    pub fn goal(&self) -> Goal {
        self.layout.as_ref().map_or_else(Goal::default, |layout| Goal {
            seen_at_once: layout.seen_at_once,
            margin_px: layout.margin_px,
        })
    }
}

/// Position of a marker on the map: world x and y of its middle, and its height.
pub type Place = [f64; 3];

/// Result of a coverage proof: whether enough markers are surely seen from every pose.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Coverage {
    /// Enough markers are seen from every pose that the robot can take, whatever the errors are within their tolerances.
    Covered,
    /// From the given pose too few markers are seen, or not surely enough.
    Uncovered {
        /// A robot pose from which it is not sure that the ceiling camera sees enough markers.
        pose: Pose,
        /// Number of markers whose middle is in the ceiling camera's image from this pose, if there are no errors at all.
        seen: usize,
    },
}

/// A room that is a rectangle, in which markers can be laid out and their coverage proven.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hall {
    /// Corner of the room at which its sides begin, world frame.
    pub corner_m: [f64; 2],
    /// Direction of the first side from world x; the second side is a quarter turn to its left.
    pub heading_deg: f64,
    /// Lengths of the two sides.
    pub size_m: [f64; 2],
}

impl Hall {
    /// The robot's room, and then the further rooms of a scene that are rectangles.
    pub fn all(scene: &Scene) -> Vec<Hall> {
        let own = Hall { corner_m: [0.0; 2], heading_deg: 0.0, size_m: [scene.room.width_m, scene.room.depth_m] };
        let further = scene.building.rooms.iter().filter_map(|room| match room.shape() {
            RoomShape::Rectangle { corner_m, heading_deg, width_m, depth_m } => {
                Some(Hall { corner_m, heading_deg, size_m: [width_m, depth_m] })
            }
            RoomShape::Polygon { .. } => None,
        });
        [own].into_iter().chain(further).collect()
    }

    /// Ranges along both sides in which the robot's origin stays, because its body cannot come closer to the walls.
    pub fn reach_m(&self, scene: &Scene) -> [[f64; 2]; 2] {
        let clearance_m = scene.robot_model().body.clearance_m;
        self.size_m.map(|extent_m| [clearance_m, extent_m - clearance_m])
    }

    /// The place in the world of a place that is given by its distances along both sides.
    pub fn in_world(&self, [along_m, across_m]: [f64; 2]) -> [f64; 2] {
        if self.heading_deg == 0.0 {
            return [self.corner_m[0] + along_m, self.corner_m[1] + across_m];
        }
        let (sin, cos) = self.heading_deg.to_radians().sin_cos();
        [self.corner_m[0] + cos * along_m - sin * across_m, self.corner_m[1] + sin * along_m + cos * across_m]
    }

    /// Distances along both sides of a place in the world.
    pub fn in_hall(&self, [x_m, y_m]: [f64; 2]) -> [f64; 2] {
        let (sin, cos) = self.heading_deg.to_radians().sin_cos();
        let [x_m, y_m] = [x_m - self.corner_m[0], y_m - self.corner_m[1]];
        [cos * x_m + sin * y_m, cos * y_m - sin * x_m]
    }
}

/// Checks whether the ceiling camera sees enough of the markers on the scene's map from every pose in each room that is a rectangle, by the markers
/// in that room; `None` if there is no ceiling camera or no marker.
pub fn coverage(scene: &Scene) -> Option<Coverage> {
    let markers = scene.markers.as_ref()?;
    let goal = markers.goal();
    let field = Field::new(scene, goal.margin_px)?;
    let on_map = markers.all().iter().filter(|marker| marker.on_map);
    let on_map: Vec<Place> = on_map.map(|marker| [marker.x_m, marker.y_m, markers.height_m(marker, scene)]).collect();
    let of_hall = |hall: Hall| {
        let here = on_map.iter().filter_map(|&[x_m, y_m, height_m]| {
            let [along_m, across_m] = hall.in_hall([x_m, y_m]);
            let is_here = (0.0..=hall.size_m[0]).contains(&along_m) && (0.0..=hall.size_m[1]).contains(&across_m);
            is_here.then_some([along_m, across_m, height_m])
        });
        let places: Vec<Place> = here.collect();
        match covered(&field, &places, &hall.reach_m(scene), goal.seen_at_once) {
            Coverage::Covered => Coverage::Covered,
            Coverage::Uncovered { pose, seen } => {
                let [x_m, y_m] = hall.in_world([pose.x_m, pose.y_m]);
                let heading_rad = pose.heading_rad + hall.heading_deg.to_radians();
                Coverage::Uncovered { pose: Pose { x_m, y_m, heading_rad }, seen }
            }
        }
    };
    let uncovered = Hall::all(scene).into_iter().map(of_hall).find(|coverage| *coverage != Coverage::Covered);
    Some(uncovered.unwrap_or(Coverage::Covered))
}

/// A box of robot poses, given by its middle and half of each of its sides.
#[derive(Clone, Debug)]
pub(crate) struct Poses {
    pub(crate) middle: Pose,
    pub(crate) half_m: [f64; 2],
    pub(crate) half_rad: f64,
    /// Markers that may be in the ceiling camera's image from some pose of the box.
    near: Rc<[Place]>,
}

/// Half sides below which a box of robot poses is not halved further. If it is then not proven that enough markers are seen from all of its
/// poses, its middle is reported as uncovered.
const LEAST_M: f64 = 0.002;
const LEAST_RAD: f64 = 0.004;
/// Number of boxes of robot poses that are still searched after a pose was found from which it is not sure that enough markers are seen.
/// The search is for a pose from which too few markers are seen even without errors.
const MORE_BOXES: usize = 20_000;

/// Proves by branch and bound that the ceiling camera sees enough markers from everywhere in a room: a box of robot poses is done when
/// enough markers are surely in the image from all of its poses.
pub fn covered(field: &Field, places: &[Place], reach_m: &[[f64; 2]; 2], seen_at_once: usize) -> Coverage {
    match search(field, places, reach_m, seen_at_once, MORE_BOXES) {
        None => Coverage::Covered,
        Some(pose) => {
            let seen = places.iter().filter(|place| field.sees_without_errors(&pose, place)).count();
            Coverage::Uncovered { pose, seen }
        }
    }
}

/// Finds a robot pose from which it is not sure that enough markers are in the image. Among `more_boxes` boxes of poses after the first
/// such pose, it prefers one that sees too few markers even without errors.
fn search(
    field: &Field,
    places: &[Place],
    reach_m: &[[f64; 2]; 2],
    seen_at_once: usize,
    more_boxes: usize,
) -> Option<Pose> {
    let [x_m, y_m] = *reach_m;
    if x_m[0] > x_m[1] || y_m[0] > y_m[1] {
        return None;
    }
    let middle = Pose { x_m: 0.5 * (x_m[0] + x_m[1]), y_m: 0.5 * (y_m[0] + y_m[1]), heading_rad: 0.0 };
    let half_m = [0.5 * (x_m[1] - x_m[0]), 0.5 * (y_m[1] - y_m[0])];
    let mut boxes = VecDeque::from([Poses { middle, half_m, half_rad: PI, near: places.into() }]);
    let (mut found, mut left) = (None, usize::MAX);
    // With `more_boxes` at 0 the first pose found is enough, and a depth-first search finds one sooner than a breadth-first search.
    let next = if more_boxes == 0 { VecDeque::pop_back } else { VecDeque::pop_front };
    while left > 0
        && let Some(poses) = next(&mut boxes)
    {
        left -= 1;
        let view = field.view_from(&poses);
        let near: Rc<[Place]> = poses.near.iter().filter(|place| view.may_see(place)).copied().collect();
        let sure = |poses: &Poses| {
            let view = field.view_from(poses);
            near.iter().filter(|place| view.surely_sees(place)).count()
        };
        if sure(&poses) >= seen_at_once {
            continue;
        }
        let is_least = poses.half_m[0].max(poses.half_m[1]) < LEAST_M && poses.half_rad < LEAST_RAD;
        if is_least || sure(&poses.only_middle()) < seen_at_once {
            let seen = near.iter().filter(|place| view.sees_without_errors(place)).count();
            if seen < seen_at_once {
                return Some(poses.middle);
            }
            if found.is_none() {
                (found, left) = (Some(poses.middle), more_boxes);
            }
            if is_least {
                continue;
            }
        }
        boxes.extend(poses.halves(near.clone()));
    }
    found
}

impl Poses {
    fn only_middle(&self) -> Poses {
        Poses { half_m: [0.0; 2], half_rad: 0.0, ..self.clone() }
    }

    /// The two halves of a box of robot poses, cut along the coordinate that moves markers in the image most.
    fn halves(&self, near: Rc<[Place]>) -> [Poses; 2] {
        // Distance over which a turn of the robot is taken to move what is at the rim of the image. On a ceiling the rim is about a metre
        // away; half of that is used, so that the heading is not cut first where no cut of it is needed.
        const RIM_M: f64 = 0.5;
        let [x_m, y_m] = self.half_m;
        let turn_m = RIM_M * self.half_rad;
        [-1.0, 1.0].map(|side| {
            let mut half = Poses { near: near.clone(), ..self.clone() };
            if turn_m >= x_m.max(y_m) {
                half.half_rad = 0.5 * self.half_rad;
                half.middle.heading_rad += side * half.half_rad;
            } else if x_m >= y_m {
                half.half_m[0] = 0.5 * x_m;
                half.middle.x_m += side * half.half_m[0];
            } else {
                half.half_m[1] = 0.5 * y_m;
                half.middle.y_m += side * half.half_m[1];
            }
            half
        })
    }

    /// A box of robot poses that holds a single pose.
    pub(crate) fn at(middle: Pose) -> Poses {
        Poses { middle, half_m: [0.0; 2], half_rad: 0.0, near: Rc::new([]) }
    }

    /// Whether a box of robot poses holds poses of all headings.
    pub(crate) fn has_all_headings(&self) -> bool {
        2.0 * self.half_rad >= TAU
    }
}

//! Whether the ceiling camera surely sees a marker from wherever the robot can stand.
//!
//! ```text
//! keys ──> Field: edges of the image as planes, all tolerances ──> boxes of poses, halved until one of the markers is surely in view ──> Coverage
//! ```
//!
//! A point is in the image if it lies on the inner side of the four planes through the optical centre and the image's edges. The camera's
//! attitude is a turn about the vertical, known with the heading, times an error of at most the tilts of body and mount; such an error turns a
//! direction by at most its own angle, so that a direction that far within all planes stays within.

mod field;
mod lattice;

use std::{
    collections::VecDeque,
    f64::consts::{PI, TAU},
    rc::Rc,
};

use localizer::Pose;

use crate::scene::{Layout, Markers, Scene};

pub use field::Field;
pub use lattice::{Ceiling, Unlaid, smallest};

/// What a coverage is asked for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Goal {
    /// Markers that lie wholly in the image, at least.
    pub seen_at_once: usize,
    /// Their least distance from its edges.
    pub margin_px: f64,
}

impl Default for Goal {
    fn default() -> Self {
        let Layout { seen_at_once, margin_px } = Layout::default();
        Goal { seen_at_once, margin_px }
    }
}

impl Markers {
    /// What their coverage is asked for.
    pub fn goal(&self) -> Goal {
        self.layout.as_ref().map_or_else(Goal::default, |layout| Goal {
            seen_at_once: layout.seen_at_once,
            margin_px: layout.margin_px,
        })
    }
}

/// A marker as surveyed: world x and y of its middle, and its height.
pub type Place = [f64; 3];

/// Whether the goal is met.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Coverage {
    /// From every pose that the robot can take, whatever the errors are within their tolerances.
    Covered,
    /// Not from this pose, or not surely from it.
    Uncovered {
        /// Where the robot stands.
        pose: Pose,
        /// Markers whose middle is in the image without any error.
        seen: usize,
    },
}

/// Whether the markers that the scene's map names cover its room; `None` without a ceiling camera or markers.
pub fn coverage(scene: &Scene) -> Option<Coverage> {
    let markers = scene.markers.as_ref()?;
    let goal = markers.goal();
    let field = Field::new(scene, goal.margin_px)?;
    let on_map = markers.all().iter().filter(|marker| marker.on_map);
    let places: Vec<Place> = on_map.map(|marker| [marker.x_m, marker.y_m, markers.height_m(marker, scene)]).collect();
    Some(covered(&field, &places, &reach(scene), goal.seen_at_once))
}

/// World x and y between which the robot's origin stays, as its body keeps it from the walls.
pub fn reach(scene: &Scene) -> [[f64; 2]; 2] {
    let clearance_m = scene.robot_model().body.clearance_m;
    [scene.room.width_m, scene.room.depth_m].map(|extent_m| [clearance_m, extent_m - clearance_m])
}

/// A box of poses: its middle and half its sides.
#[derive(Clone, Debug)]
pub(crate) struct Poses {
    pub(crate) middle: Pose,
    pub(crate) half_m: [f64; 2],
    pub(crate) half_rad: f64,
    /// Markers that may be in view from it.
    near: Rc<[Place]>,
}

/// Boxes smaller than this, in which some poses are covered and others are not told, are named as they are.
const LEAST_M: f64 = 0.002;
const LEAST_RAD: f64 = 0.004;
/// After a pose that is not surely covered was found, so many boxes are searched for one that sees too few even without any error.
const MORE_BOXES: usize = 20_000;

/// Branch and bound over the poses: a box is done when enough markers are surely in the image from all of it.
pub fn covered(field: &Field, places: &[Place], reach_m: &[[f64; 2]; 2], seen_at_once: usize) -> Coverage {
    match search(field, places, reach_m, seen_at_once, MORE_BOXES) {
        None => Coverage::Covered,
        Some(pose) => {
            let seen = places.iter().filter(|place| field.sees_without_errors(&pose, place)).count();
            Coverage::Uncovered { pose, seen }
        }
    }
}

/// A pose that is not surely covered: of `more_boxes` after the first one found, the first that sees too few even without errors.
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
    // Whoever asks for no more boxes asks for no better pose either: depth first comes upon some pose soon, breadth first upon it late.
    let next = if more_boxes == 0 { VecDeque::pop_back } else { VecDeque::pop_front };
    while left > 0
        && let Some(poses) = next(&mut boxes)
    {
        left -= 1;
        let near: Rc<[Place]> = poses.near.iter().filter(|place| field.may_see(&poses, place)).copied().collect();
        let sure = |poses: &Poses| near.iter().filter(|place| field.surely_sees(poses, place)).count();
        if sure(&poses) >= seen_at_once {
            continue;
        }
        let is_least = poses.half_m[0].max(poses.half_m[1]) < LEAST_M && poses.half_rad < LEAST_RAD;
        if is_least || sure(&poses.only_middle()) < seen_at_once {
            let seen = near.iter().filter(|place| field.sees_without_errors(&poses.middle, place)).count();
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

    /// Both halves of it, cut where it matters most to what is in the image.
    fn halves(&self, near: Rc<[Place]>) -> [Poses; 2] {
        // A turn moves what is at the rim of the image, about a metre away on a ceiling; where it is not needed at all it is not cut first.
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

    /// One pose.
    pub(crate) fn at(middle: Pose) -> Poses {
        Poses { middle, half_m: [0.0; 2], half_rad: 0.0, near: Rc::new([]) }
    }

    /// Whether it holds poses of all headings.
    pub(crate) fn has_all_headings(&self) -> bool {
        2.0 * self.half_rad >= TAU
    }
}

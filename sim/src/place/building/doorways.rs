//! The insides of walls at open doors as geometry: the floor between two rooms, both jambs, and the underside of the lintel.

use nalgebra::{Point3, Vector2, Vector3};

use super::{Building, Doorway, GroundPlan, LAYER_M, Material, Panel, Part, Texture, coverings, raised, walls::layers};
use crate::scene::Scene;

/// Least thickness of the walls at a door for which the inside of the door is drawn. Rooms that stand wall to wall have no inside.
const LEAST_DEPTH_M: f64 = 0.001;
/// Distance by which a strip of the lintel's underside may stand out into a room: hardly visible.
const STEP_M: f64 = 0.01;
/// Greatest number of strips of a lintel's underside.
const MOST_STRIPS: f64 = 32.0;

/// Flat faces (panels) of the building's geometry inside the open doors between rooms.
pub(super) fn panels(scene: &Scene, building: &Building) -> Vec<Panel> {
    let plan = GroundPlan::of(scene);
    plan.doorways().iter().flat_map(|door| inside(scene, building, door)).collect()
}

fn inside(scene: &Scene, building: &Building, door: &Doorway) -> Vec<Panel> {
    let [left, right, back_right, back_left] = door.corners_m;
    let sill = right - left;
    let inward = Vector2::new(-sill.y, sill.x).normalize();
    let depths_m = [back_left - left, back_right - right].map(|way| inward.dot(&way));
    let deeper = |a: f64, b: f64| if a.abs() > b.abs() { a } else { b };
    let depth_m = deeper(depths_m[0], depths_m[1]);
    if depth_m.abs() < LEAST_DEPTH_M {
        return Vec::new();
    }
    let level = |way: Vector2<f64>| Vector3::new(way.x, way.y, 0.0);
    let raised = |at: Vector2<f64>, height_m: f64| raised([at.x, at.y], height_m);
    let room = building.room_at(raised(left - inward * depth_m.signum() * LEAST_DEPTH_M, 0.5));
    let paint = Material::matt(scene.building.wall_albedo).with(Texture::Plaster);
    let panel = |corner: Point3<f64>, along, up, material| Panel {
        corner,
        along,
        up,
        material,
        part: Part::Thing,
        room,
        outline: None,
    };
    // Two level sides at a right angle, the second to the left of the first, so that their product points up.
    let sides = |across: Vector2<f64>, depth_m: f64| {
        let (across, deep) = (level(across), level(inward * depth_m));
        if depth_m > 0.0 { [across, deep] } else { [deep, across] }
    };
    // Where the two rooms are at an angle, the passage is a trapezium on the floor plan. A rectangle as deep as its deeper side is drawn for its floor;
    // what of that lies within a room is under the room's floor. The lintel would stand out into the room, and is drawn in strips.
    let (layer, beyond_m) = under_floors(building);
    let under_floors_m = -LAYER_M * layer as f64;
    let [aside, deep] = [sill.normalize() * beyond_m, inward * (beyond_m * depth_m.signum())];
    let [first, second] = sides(sill + aside * 2.0, depth_m + 2.0 * deep.dot(&inward));
    let n_strips = ((depths_m[1] - depths_m[0]).abs() / STEP_M).ceil().clamp(1.0, MOST_STRIPS);
    let lintel = (0..n_strips as usize).map(|strip| {
        let at = |idx: usize| idx as f64 / n_strips;
        let depth_at = |idx: usize| depths_m[0] + (depths_m[1] - depths_m[0]) * at(idx);
        let [first, second] = sides(sill / n_strips, deeper(depth_at(strip), depth_at(strip + 1)));
        panel(raised(left + sill * at(strip), door.height_m), second, first, paint)
    });
    let up = Vector3::z() * door.height_m;
    let jamb = |from: Vector2<f64>, to: Vector2<f64>| {
        // Seen from the side to which along × up points, which must be the one of the passage.
        let middle = (left + right) * 0.5 - from;
        let way = to - from;
        if way.perp(&middle) < 0.0 {
            panel(raised(from, 0.0), level(way), up, paint)
        } else {
            panel(raised(to, 0.0), level(-way), up, paint)
        }
    };
    let floor = panel(raised(left - aside - deep, under_floors_m), first, second, coverings::usual(scene));
    [floor, jamb(left, back_left), jamb(right, back_right)].into_iter().chain(lintel).collect()
}

/// Layer in which the floor of a passage is drawn, below those of all rooms, and how far it goes on below the floors and walls around. In a building
/// with a polygonal room it does, so that no gap shows at the step to the floors and at the jambs.
fn under_floors(building: &Building) -> (usize, f64) {
    const BEYOND_M: f64 = 0.05;
    if building.rooms.iter().all(|room| room.outline.is_none()) {
        return (building.rooms.len(), 0.0);
    }
    (layers(&building.rooms).into_iter().max().unwrap_or(0) + 1, BEYOND_M)
}

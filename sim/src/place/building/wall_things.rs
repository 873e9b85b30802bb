//! Things on the walls: doors with their frames, pictures, and the bars of windows.

use nalgebra::{Point3, Vector3, vector};

use super::{Building, Material, Panel, Part, Texture, UprightBox, raised};
use crate::scene::{Door, LampKind, Picture, Scene};

/// Width of a door frame on the wall, and the length by which it stands out of the wall.
const FRAME_M: [f64; 2] = [0.07, 0.03];
/// Least distance between an open door and another door in the same wall: the widths of both frames.
pub(crate) const LEAST_BETWEEN_DOORS_M: f64 = 2.0 * FRAME_M[0];

/// Thin boxes on the walls: frames and leaves of doors, and bars of windows. A box that is let into a wall is halved along the wall, and only the
/// half that stands out into a room is kept.
pub(super) fn trim(scene: &Scene, building: &Building) -> Vec<UprightBox> {
    let mut boxes: Vec<UprightBox> = scene.building.doors.iter().flat_map(door).collect();
    for lamp in scene.lamps.iter().filter(|lamp| lamp.kind == LampKind::Window) {
        let [width_m, height_m] = lamp.size_m.unwrap_or([1.4, 1.2]);
        let middle_m = lamp.height_m.unwrap_or(1.5);
        let facing = super::level(lamp.heading_deg.to_radians());
        let on_wall = building.on_wall(Point3::new(lamp.x_m, lamp.y_m, middle_m), facing);
        boxes.extend(window(on_wall, facing, [width_m, height_m]));
    }
    let stands_out = |half: &UprightBox| building.rooms.iter().any(|room| room.contains(half.middle()));
    boxes.iter().flat_map(UprightBox::halves).filter(stands_out).collect()
}

fn painted(albedo: f64) -> Material {
    Material::matt(albedo).glossy(0.03, 0.08)
}

/// A box on a wall between two points of the floor plan.
fn between(from_m: [f64; 2], to_m: [f64; 2], depth_m: f64, between_m: [f64; 2], material: Material) -> UprightBox {
    let way = [to_m[0] - from_m[0], to_m[1] - from_m[1]];
    UprightBox {
        middle_m: [0, 1].map(|axis| (from_m[axis] + to_m[axis]) / 2.0),
        heading_rad: way[1].atan2(way[0]),
        size_m: [way[0].hypot(way[1]), depth_m],
        between_m,
        material,
    }
}

fn door(door: &Door) -> Vec<UprightBox> {
    let (from, to) = (raised(door.from_m, 0.0), raised(door.to_m, 0.0));
    let along = (to - from).normalize();
    let foot = |way_m: f64| {
        let at = from + along * way_m;
        [at.x, at.y]
    };
    let (width_m, [frame_m, out_m]) = ((to - from).norm(), FRAME_M);
    let paint = painted(door.albedo);
    let top_m = [door.height_m, door.height_m + frame_m];
    let mut boxes = vec![
        between(foot(-frame_m), foot(0.0), 2.0 * out_m, [0.0, top_m[1]], paint),
        between(foot(width_m), foot(width_m + frame_m), 2.0 * out_m, [0.0, top_m[1]], paint),
        between(foot(0.0), foot(width_m), 2.0 * out_m, top_m, paint),
    ];
    if !door.open {
        let metal = Material::matt(0.25).glossy(0.4, 0.15);
        boxes.push(between(foot(0.0), foot(width_m), 0.02, [0.0, door.height_m], painted(door.albedo * 0.92)));
        boxes.push(between(foot(width_m - 0.16), foot(width_m - 0.05), 0.12, [1.0, 1.025], metal));
    }
    boxes
}

/// Boxes for the frame, the cross and the sill of a window.
fn window(middle: Point3<f64>, facing: Vector3<f64>, size_m: [f64; 2]) -> Vec<UprightBox> {
    let left = vector![-facing.y, facing.x, 0.0];
    let half_m = size_m.map(|side_m| side_m / 2.0);
    let foot = |way_m: f64| {
        let at = middle + left * way_m;
        [at.x, at.y]
    };
    let bar = |from_m: f64, to_m: f64, low_m: f64, high_m: f64, out_m: f64| {
        between(foot(from_m), foot(to_m), 2.0 * out_m, [middle.z + low_m, middle.z + high_m], painted(0.7))
    };
    let w = 0.05;
    vec![
        bar(-half_m[0] - w, -half_m[0], -half_m[1] - w, half_m[1] + w, 0.03),
        bar(half_m[0], half_m[0] + w, -half_m[1] - w, half_m[1] + w, 0.03),
        bar(-half_m[0], half_m[0], half_m[1], half_m[1] + w, 0.03),
        bar(-half_m[0] - w, half_m[0] + w, -half_m[1] - w, -half_m[1], 0.12),
        bar(-w / 2.0, w / 2.0, -half_m[1], half_m[1], 0.02),
        bar(-half_m[0], half_m[0], 0.25 * size_m[1] - w / 2.0, 0.25 * size_m[1] + w / 2.0, 0.02),
    ]
}

/// Flat faces (panels) for the pictures on the walls, each turned towards the room that the picture hangs in.
pub(super) fn pictures(scene: &Scene, building: &Building) -> Vec<Panel> {
    scene.building.pictures.iter().map(|picture| hung(picture, building)).collect()
}

/// Material of a picture. The mean albedo of a chessboard is that of its black and its white squares together, as in texture.wgsl.
fn painting(picture: &Picture) -> Material {
    let material = Material::matt(0.45);
    match picture.chessboard {
        None => Material { seed: picture.number, ..material.with(Texture::Picture) },
        Some([columns, rows]) => Material { seed: 256 * columns + rows, ..material.with(Texture::Chessboard) },
    }
}

fn hung(picture: &Picture, building: &Building) -> Panel {
    let (from, to) = (raised(picture.from_m, picture.bottom_m), raised(picture.to_m, picture.bottom_m));
    let along = to - from;
    let out = along.cross(&Vector3::z()).normalize();
    // A picture faces the side on which there is a room: on one side a point 0.3 m before the picture lies in a room, on the other side it
    // does not.
    let middle = from + along / 2.0;
    let faces_out = building.rooms.iter().any(|room| room.contains(middle + out * 0.3));
    let (corner, along, out) = if faces_out { (from, along, out) } else { (to, -along, -out) };
    Panel {
        corner: corner + out * 0.02,
        along,
        up: vector![0.0, 0.0, picture.height_m],
        material: painting(picture),
        part: Part::Thing,
        room: building.room_at(middle + out * 0.3),
        outline: None,
    }
}

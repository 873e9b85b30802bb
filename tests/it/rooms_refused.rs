//! Tests that buildings whose rooms and doors cannot be are refused by the key that is wrong.

use crate::{
    command::{blind_scene, folder, outcome, wherein},
    scene_refusals::assert_refused,
};

/// A room of 3 m by 2 m with another one of the same size 10 cm beside it, and doors in the wall between them, given by the y of both jambs, the x
/// and whether the door is open.
fn with_doors(doors: &[([f64; 2], f64, bool)]) -> String {
    let door = |([from_m, to_m], x_m, open): &([f64; 2], f64, bool)| {
        format!("[[building.door]]\nfrom_m = [{x_m:?}, {from_m:?}]\nto_m = [{x_m:?}, {to_m:?}]\nopen = {open}\n")
    };
    let room = "[[building.room]]\nx_m = 3.1\ny_m = 0.0\nwidth_m = 3.0\ndepth_m = 2.0\n";
    blind_scene(0.1, &(room.to_owned() + &doors.iter().map(door).collect::<String>()))
}

#[test]
fn an_open_door_that_runs_into_another_door_is_refused() {
    let cases = [
        ("one jamb for two doors", [([0.2, 1.0], 3.0, true), ([1.0, 1.8], 3.0, true)]),
        ("less wall than two frames", [([0.2, 0.9], 3.0, true), ([1.03, 1.8], 3.0, true)]),
        ("stated on both faces of the wall", [([0.2, 1.0], 3.0, true), ([0.6, 1.4], 3.1, true)]),
        ("stated from the other jamb", [([0.2, 1.0], 3.0, true), ([1.4, 0.6], 3.0, true)]),
        ("a leaf in the hole", [([0.2, 1.0], 3.0, false), ([0.2, 1.0], 3.0, true)]),
    ];
    for (name, doors) in cases {
        let place = name.replace(' ', "_");
        let parts = ["`building.door[1].from_m = ", "in or by building.door[0], expected 0.14 m of wall between"];
        assert_refused(&place, with_doors(&doors), &parts);
    }
}

#[test]
fn doors_with_wall_for_their_frames_between_them_are_accepted() {
    let cases = [
        ("frame_to_frame", with_doors(&[([0.2, 0.9], 3.0, true), ([1.04, 1.8], 3.0, true)])),
        ("two_leaves", with_doors(&[([0.2, 1.0], 3.0, false), ([1.0, 1.8], 3.0, false)])),
    ];
    for (name, scene) in cases {
        let folder = folder(name);
        std::fs::write(folder.join("scene.toml"), scene).unwrap();
        let (code, _, stderr) = outcome(&mut wherein(&folder, &["run", "scene.toml"]));
        assert!(code != 2, "{name}: {stderr}");
    }
}

#[test]
fn rooms_so_far_apart_that_the_building_is_longer_than_a_site_are_refused() {
    let room =
        |x_m: f64, y_m: f64| format!("[[building.room]]\nx_m = {x_m:?}\ny_m = {y_m:?}\nwidth_m = 3.0\ndepth_m = 2.0\n");
    // From the far end of each room to the robot's, which is 3 m by 2 m with a corner at the origin: 5003 m, 10¹² m, and 198 + 3 m.
    let cases = [
        (room(5000.0, 0.0), "`building.room[0].x_m = 5000.0`: the building is 5003.0 m long"),
        (room(0.0, -1e12), "`building.room[0].y_m = -1000000000000.0`"),
        (room(100.0, 0.0) + &room(-98.0, 0.0), "`building.room[1].x_m = -98.0`: the building is 201.0 m long"),
    ];
    for (index, (rooms, part)) in cases.into_iter().enumerate() {
        assert_refused(&format!("far_{index}"), blind_scene(0.1, &rooms), &[part, "expected at most 200 m"]);
    }
    let folder = folder("far_enough");
    std::fs::write(folder.join("scene.toml"), blind_scene(0.1, &(room(100.0, 0.0) + &room(-97.0, 0.0)))).unwrap();
    let (code, _, stderr) = outcome(&mut wherein(&folder, &["run", "scene.toml"]));
    assert!(code != 2, "{stderr}");
}

#[test]
fn things_and_people_may_be_in_an_open_door_but_not_in_the_wall_beside_it() {
    // The wall is 10 cm thick, from x = 3 to 3.1 m, and its door is open from y = 0.2 to 1.2 m.
    let with = |keys: String| with_doors(&[([0.2, 1.2], 3.0, true)]) + &keys;
    let piece = |y_m: f64| with(format!("[[furniture]]\nx_m = 3.05\ny_m = {y_m:?}\nsize_m = [0.2, 0.2]\n"));
    let walk = |y_m: f64| with(format!("[[person]]\nradius_m = 0.2\nwaypoints_m = [[3.05, {y_m:?}], [4.5, 1.5]]\n"));
    for (name, scene) in [("piece_in_door", piece(0.7)), ("person_in_door", walk(0.7))] {
        let folder = folder(name);
        std::fs::write(folder.join("scene.toml"), scene).unwrap();
        let (code, _, stderr) = outcome(&mut wherein(&folder, &["run", "scene.toml"]));
        assert!(code != 2, "{name}: {stderr}");
    }
    let told =
        ["`furniture[0].x_m = 3.05`", "outside the room, expected a number from 0 to 3, or a place in a further room"];
    assert_refused("piece_in_wall", piece(1.6), &told);
    assert_refused(
        "person_in_wall",
        walk(1.6),
        &["`person[0].waypoints_m", "[3.05, 1.6] is in no room and no open door"],
    );
    // The jamb at y = 1.2 m is 19 cm away from this place, which is in the middle of the wall's thickness.
    assert_refused(
        "person_by_jamb",
        walk(1.01),
        &["[3.05, 1.01] is a place too near to a wall, expected 0.2 m of distance"],
    );
}

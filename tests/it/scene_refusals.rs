use std::{
    fs,
    time::{Duration, Instant},
};

use sim::scene::Scene;

use crate::command::{blind_scene, folder, outcome, wherein};

/// Asserts that a scene is refused with exit code 2 and a message that contains each of `parts`.
pub(crate) fn assert_refused(test: &str, scene: impl AsRef<[u8]>, parts: &[&str]) {
    let folder = folder(test);
    fs::write(folder.join("scene.toml"), scene).unwrap();
    let (code, stdout, stderr) = outcome(&mut wherein(&folder, &["run", "scene.toml"]));
    let message = stderr.lines().next().unwrap();
    assert_eq!(code, 2, "{stderr}");
    assert!(stdout.is_empty(), "{stdout}");
    assert!(message.starts_with("wherein: failed to read scene scene.toml: "), "{message}");
    for part in parts {
        assert!(message.contains(part), "`{part}` is missing in: {message}");
    }
    assert!(!folder.join("renders").exists(), "a refused scene left a folder behind");
}

fn edited(from: &str, to: &str) -> String {
    let scene = blind_scene(10.0, "");
    assert!(scene.contains(from));
    scene.replacen(from, to, 1)
}

#[test]
fn an_unknown_key_is_refused_with_the_nearest_right_one() {
    let scene = edited("width_m", "widht_m");
    assert_refused("unknown_key", scene, &["`room.widht_m`", "unknown key", "`width_m`"]);
}

#[test]
fn a_wrong_type_is_refused() {
    let scene = edited("depth_m = 2.0", "depth_m = \"wide\"");
    assert_refused("wrong_type", scene, &["`room.depth_m = \"wide\"`", "a text", "expected a number from 0.5 to 200"]);
}

#[test]
fn a_negative_length_is_refused() {
    let scene = blind_scene(10.0, "[floor.tiles]\nedge_x_m = -0.3\n");
    assert_refused("negative", scene, &["`floor.tiles.edge_x_m = -0.3`", "expected a number from 0.05 to 5"]);
}

#[test]
fn not_a_number_and_infinity_are_refused() {
    for value in ["nan", "-nan", "inf", "-inf"] {
        let scene = edited("width_m = 3.0", &format!("width_m = {value}"));
        assert_refused(
            "not_a_number",
            scene,
            &[&format!("`room.width_m = {value}`"), "expected a number from 0.5 to 200"],
        );
    }
}

#[test]
fn the_open_end_of_a_range_is_refused() {
    let scene = edited("duration_s = 10", "duration_s = 0");
    assert_refused("open_end", scene, &["`duration_s = 0`", "expected a number above 0, at most 36000"]);
}

#[test]
fn a_fraction_where_things_are_counted_is_refused() {
    let scene = edited("floor_camera = false", "encoders = { ticks_per_turn = 99.5 }");
    assert_refused("fraction", scene, &["`robot.encoders.ticks_per_turn = 99.5`", "expected a whole number"]);
}

#[test]
fn a_wrong_choice_is_refused_with_the_right_ones() {
    let scene = blind_scene(10.0, "[floor.tiles]\npattern = \"marbel\"\n");
    assert_refused("choice", scene, &["`floor.tiles.pattern = \"marbel\"`", "plain, speckle, marble, stripes"]);
}

#[test]
fn a_list_of_the_wrong_length_is_refused() {
    let scene = blind_scene(10.0, "[[floor.stray]]\nfrom_m = [1]\nto_m = [1, 1]\nwidth_m = 0.01\nalbedo = 0.5\n");
    assert_refused("length", scene, &["`floor.stray[0].from_m = [1]`", "a list of 1", "2"]);
}

#[test]
fn a_waypoint_outside_the_room_is_refused() {
    // The room is 3 m wide and the body reaches 0.25 m, so that the robot's origin may be at 2.75 m at most.
    let scene = edited("x_m = 2.4", "x_m = 2.8");
    assert_refused("outside", scene, &["`route.waypoint[0].x_m = 2.8`", "outside the room", "from 0.25 to 2.75"]);
}

#[test]
fn a_start_that_may_be_drawn_into_a_wall_is_refused() {
    // The robot's start must be 0.25 m away from each wall for its body, and 0.4 m more, because the start is drawn at random within that tolerance.
    let scene = edited("y_m = 0.6", "y_m = 0.6\ntolerance_m = 0.4");
    assert_refused("start", scene, &["`start.x_m = 0.6`", "from 0.65 to 2.35", "drawn within 0.4 m"]);
}

#[test]
fn a_station_outside_the_room_is_refused() {
    let scene = edited("[[route.waypoint]]", "[[station]]\nheading_deg = 0").replace("y_m = 1.2", "y_m = 1.9");
    assert_refused("station", scene, &["`station[0].y_m = 1.9`", "from 0.26 to 1.74"]);
}

#[test]
fn a_station_that_may_be_drawn_into_a_wall_by_the_starts_tolerance_is_refused() {
    let scene = edited("[[route.waypoint]]", "[[station]]\nheading_deg = 0").replace("y_m = 1.2", "y_m = 1.6");
    let scene = scene.replace("y_m = 0.6", "y_m = 0.6\ntolerance_m = 0.3");
    assert_refused("station_drawn", scene, &["`station[0].y_m = 1.6`", "from 0.55 to 1.45", "drawn within 0.3 m"]);
}

#[test]
fn a_stray_thing_outside_the_room_is_refused() {
    let scene = blind_scene(10.0, "[[floor.stray]]\nfrom_m = [1, 1]\nto_m = [1, 2.1]\nwidth_m = 0.01\nalbedo = 0.5\n");
    assert_refused("stray", scene, &["`floor.stray[0].to_m = [1, 2.1]`", "outside the room", "[3, 2]"]);
}

#[test]
fn a_scene_without_route_and_stations_is_refused() {
    let scene = blind_scene(10.0, "").split("[[route").next().unwrap().to_owned();
    assert_refused("no_route", scene, &["`route`: missing", "`[route]`", "`[[station]]`"]);
}

#[test]
fn a_scene_with_both_route_and_stations_is_refused() {
    let scene = blind_scene(10.0, "[[station]]\nx_m = 1\ny_m = 1\nheading_deg = 0\n");
    assert_refused("both", scene, &["`route`", "beside `[[station]]`", "one of the two"]);
}

#[test]
fn an_event_after_the_end_is_refused() {
    let push = "[[event]]\nkind = \"push\"\nat_s = 9.5\nlasts_s = 1\ndisplacement_m = [0.1, 0]\n";
    assert_refused("event", blind_scene(10.0, push), &["`event[0].at_s = 9.5`", "expected at most 9", "10 s"]);
}

#[test]
fn an_unknown_kind_of_event_is_refused_with_the_right_ones() {
    let scene = blind_scene(10.0, "[[event]]\nkind = \"pusch\"\nat_s = 1\n");
    assert_refused("kind", scene, &["`event[0].kind = \"pusch\"`", "push, light, lamp, friction"]);
}

#[test]
fn an_unknown_region_is_refused_with_the_nearest_right_one() {
    let more = "[[floor.region]]\nname = \"carpet\"\nx_m = [0, 1]\ny_m = [0, 1]\nfriction = 0.4\n\
                [[event]]\nkind = \"friction\"\nat_s = 1\nregion = \"carpt\"\nfriction = 0.2\n";
    assert_refused("region", blind_scene(10.0, more), &["`event[0].region = \"carpt\"`", "\"carpet\""]);
}

#[test]
fn a_region_that_is_turned_out_of_the_room_is_refused() {
    let region = |deg: f64| {
        let more = format!(
            "[[floor.region]]\nname = \"rug\"\nx_m = [0.1, 1.1]\ny_m = [0.1, 0.3]\nrotation_deg = {deg}\nfriction = 0.4\n"
        );
        blind_scene(10.0, &more)
    };
    // The middle is at (0.6, 0.2). Turned by a right angle, the rug reaches from y = −0.3 to 0.7 m.
    let expected = ["`floor.region[0].rotation_deg = 90", "outside the room", "[0, 0] to [3, "];
    assert_refused("turned", region(90.0), &expected);
    assert!(sim::scene::Scene::parse(&region(180.0), "scene.toml").is_ok());
}

#[test]
fn an_unknown_figure_in_expect_is_refused_with_the_nearest_right_one() {
    let scene = blind_scene(10.0, "[expect]\navailabilty_min = 0.9\n");
    assert_refused("figure", scene, &["`expect.availabilty_min = 0.9`", "unknown figure", "`availability_min`"]);
    let scene = blind_scene(10.0, "[expect]\nmetrics.colisions = 0\n");
    assert_refused("metric", scene, &["`expect.metrics.colisions = 0`", "unknown figure", "`metrics.collisions`"]);
    let scene = blind_scene(10.0, "[expect]\nunsoundd = 0\n");
    assert_refused("judgement", scene, &["`expect.unsoundd = 0`", "unknown figure", "`unsound`"]);
}

#[test]
fn several_mistakes_are_told_at_once() {
    let scene = edited("width_m = 3.0", "width_m = -3.0").replace("depth_m", "deepth_m");
    assert_refused("several", scene, &["`room.width_m = -3.0`", "`room.deepth_m`", "`room.depth_m`: missing"]);
}

#[test]
fn an_empty_file_is_refused_with_what_is_missing() {
    assert_refused("empty", "", &["`room`: missing, expected a table", "`start`: missing, expected a table"]);
}

#[test]
fn text_that_is_not_toml_is_refused() {
    assert_refused("not_toml", "[room\nwidth_m = 3\n", &["not a scene in TOML"]);
}

#[test]
fn bytes_that_are_not_text_are_refused_at_the_first_wrong_byte() {
    assert_refused("bytes", b"[room]\n\xff\xfe\x00\x80", &["byte 7 is not UTF-8"]);
}

#[test]
fn whatever_bytes_a_file_holds_it_is_refused_without_a_crash() {
    // A linear congruential generator gives bytes without a pattern that are the same in every run.
    let mut state = 1_u32;
    for round in 0..20 {
        let bytes: Vec<u8> = (0..200)
            .map(|_| {
                state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
                // In half of the rounds the bytes are ASCII, so that they get as far as the TOML parser.
                (state >> 24) as u8 & if round % 2 == 0 { 0x7f } else { 0xff }
            })
            .collect();
        assert_refused("random", bytes, &[]);
    }
}

#[test]
fn the_place_of_a_mistake_is_underlined() {
    let folder = folder("underlined");
    fs::write(folder.join("scene.toml"), edited("depth_m = 2.0", "depth_m = -2.0")).unwrap();
    let (_, _, stderr) = outcome(&mut wherein(&folder, &["run", "scene.toml"]));
    assert!(stderr.contains("[scene.toml:4:11]"), "{stderr}");
    assert!(stderr.contains("depth_m = -2.0"), "{stderr}");
    assert!(stderr.contains("Extent of the room along world y"), "{stderr}");
}

#[test]
fn a_folder_without_scenes_is_refused() {
    let folder = folder("no_scenes");
    fs::create_dir(folder.join("nothing")).unwrap();
    let (code, _, stderr) = outcome(&mut wherein(&folder, &["run", "nothing"]));
    assert_eq!(code, 2);
    assert!(
        stderr.contains("failed to find a scene in nothing: expected at least one file that ends in .toml"),
        "{stderr}"
    );
}

#[test]
fn a_file_that_does_not_exist_is_refused() {
    let (code, _, stderr) = outcome(&mut wherein(&folder("no_file"), &["run", "missing.toml"]));
    assert_eq!(code, 2);
    assert!(stderr.contains("failed to read scene missing.toml: "), "{stderr}");
}

#[test]
fn a_file_larger_than_any_scene_is_refused_at_once_by_every_command() {
    let folder = folder("huge_scene");
    // 117 MB of zero bytes, which take no place on the disk.
    fs::File::create(folder.join("huge.toml")).unwrap().set_len(117_000_000).unwrap();
    let expected = "failed to read scene huge.toml: it has 117.0 MB, expected a scene in TOML of at most 4 MB";
    for command in [&["run"][..], &["sweep"], &["scene"], &["upgrade"]] {
        let began = Instant::now();
        let (code, _, stderr) = outcome(&mut wherein(&folder, &[command, &["huge.toml"]].concat()));
        assert!(code == 2 && stderr.contains(expected), "{command:?}: {stderr}");
        assert!(began.elapsed() < Duration::from_secs(5), "{command:?} took {:?}", began.elapsed());
    }
    fs::write(folder.join("scene.toml"), "extends = \"huge.toml\"\n").unwrap();
    let (code, _, stderr) = outcome(&mut wherein(&folder, &["run", "scene.toml"]));
    assert!(
        code == 2 && stderr.contains("`extends = \"huge.toml\"`: failed to read scene huge.toml: it has"),
        "{stderr}"
    );
    if cfg!(unix) {
        let (code, _, stderr) = outcome(&mut wherein(&folder, &["run", "/dev/zero"]));
        assert!(code == 2 && stderr.contains("failed to read scene /dev/zero: it has no end"), "{stderr}");
    }
}

#[test]
fn an_output_folder_that_cannot_be_is_refused_before_anything_runs() {
    let folder = folder("no_out");
    fs::write(folder.join("scene.toml"), blind_scene(3600.0, "")).unwrap();
    fs::write(folder.join("taken"), "a file").unwrap();
    let (code, _, stderr) = outcome(&mut wherein(&folder, &["run", "scene.toml", "--out", "taken/below"]));
    assert_eq!(code, 2);
    assert!(stderr.contains("failed to create the folder taken/below: "), "{stderr}");
}

#[test]
fn a_camera_without_an_adapter_is_refused_with_what_to_do() {
    let folder = folder("no_adapter");
    fs::write(folder.join("scene.toml"), blind_scene(1.0, "").replace("floor_camera = false", "floor_camera = true"))
        .unwrap();
    let mut command = wherein(&folder, &["run", "scene.toml"]);
    let (code, _, stderr) = outcome(command.env("WHEREIN_ADAPTER", "an adapter that nobody built"));
    assert_eq!(code, 2, "{stderr}");
    assert!(stderr.contains("failed to find a graphics adapter") && stderr.contains("make driver"), "{stderr}");
}

#[test]
fn seeds_that_are_no_range_are_refused() {
    for seeds in ["5", "3..3", "7..2", "a..b", "-1..2"] {
        let (code, _, stderr) =
            outcome(&mut wherein(&folder("seeds"), &["run", "x.toml", &format!("--seeds={seeds}")]));
        assert_eq!(code, 2);
        assert!(stderr.contains("expected A..B"), "{stderr}");
    }
}

#[test]
fn a_heading_beyond_counting_is_refused() {
    let scene = edited("x_m = 0.6", "heading_deg = 1e300\nx_m = 0.6");
    assert_refused(
        "far_heading",
        scene,
        &["`start.heading_deg = 1e300`", "expected a number from -1000000 to 1000000"],
    );
}

#[test]
fn joints_wider_than_half_a_tile_are_refused() {
    let scene = blind_scene(10.0, "[floor.tiles]\nedge_x_m = 0.06\njoint_width_m = 0.05\n");
    assert_refused("all_joint", scene, &["`floor.tiles.joint_width_m = 0.05`", "expected at most 0.03"]);
}

#[test]
fn lamps_doors_and_lenses_that_cannot_be_are_refused() {
    let lamp = "[[lamp]]\nkind = \"panel\"\nx_m = 1.0\ny_m = 1.0\n";
    let window = "[[lamp]]\nkind = \"window\"\nx_m = 1.0\ny_m = 0.0\n";
    let cases = [
        (format!("{lamp}lumens = 100\nilluminance_at_floor_lux = 10\n"), "`lamp[0].illuminance_at_floor_lux = 10`"),
        (format!("{lamp}height_m = 2.7\n"), "expected less than the ceiling's height, 2.6 m"),
        (format!("{window}height_m = 2.2\n"), "the window reaches beyond its wall"),
        (lamp.replace("x_m = 1.0", "x_m = 3.5"), "outside the building, expected a number from 0 to 3"),
        (
            format!("{lamp}name = \"desk\"\n[[event]]\nkind = \"lamp\"\nat_s = 1\nlamp = \"dsk\"\nshare = 0\n"),
            "`event[0].lamp = \"dsk\"`: unknown lamp, expected one of desk",
        ),
        (
            format!("{lamp}[[event]]\nkind = \"lamp\"\nat_s = 1\nlamp = \"desk\"\nshare = 0\n"),
            "unknown lamp, expected a `[[lamp]]` of that `name`, of which the scene has none",
        ),
        (
            format!("{lamp}name = \"desk\"\n[[event]]\nkind = \"lamp\"\nat_s = 1\nlamp = \"desk\"\nshare = 1.5\n"),
            "`event[0].share = 1.5`",
        ),
        (lamp.repeat(1025), "1025 of them, expected at most 1024"),
        (lamp.replace("panel", "candle"), "expected one of panel, tube, point, window"),
        ("[light]\nilluminance_at_camera_lux = 0.1\n".to_owned(), "stands without `[robot.forward_camera]`"),
        (
            "[[building.door]]\nfrom_m = [1.0, 0.0]\nto_m = [1.0, 0.0]\n".to_owned(),
            "`building.door[0].to_m = [1.0, 0.0]`",
        ),
        (
            "[robot.forward_camera]\nlens.distortion = [-1.5, 0.0, 0.0, 0.0, 0.0]\n".to_owned(),
            "folds the image over within its edges",
        ),
        ("[robot.ceiling_camera]\nfocal_px = [700.0]\n".to_owned(), "a list of 1"),
        (
            "[robot.forward_camera]\n[light]\nilluminance_at_floor_lux = 80\nilluminance_at_camera_lux = 5\n"
                .to_owned(),
            "`light.illuminance_at_floor_lux = 80`: stands beside `illuminance_at_camera_lux`, expected one of the two",
        ),
        // An open door in an outer wall leads into no room: neither where there is no further room, nor where that room lies elsewhere.
        (
            "[[building.door]]\nfrom_m = [1.0, 0.0]\nto_m = [1.8, 0.0]\nopen = true\n".to_owned(),
            "`building.door[0].open = true`: leads into no room, expected a `[[building.room]]`",
        ),
        (
            "[[building.room]]\nx_m = 3.0\ny_m = 0.0\nwidth_m = 2.0\ndepth_m = 2.0\n\
             [[building.door]]\nfrom_m = [1.0, 0.0]\nto_m = [1.8, 0.0]\nopen = true\n"
                .to_owned(),
            "`building.door[0].open = true`",
        ),
    ];
    for (index, (keys, part)) in cases.into_iter().enumerate() {
        assert_refused(&format!("building_{index}"), blind_scene(10.0, &keys), &[part]);
    }
}

#[test]
fn open_doors_between_rooms_are_accepted_however_thick_the_wall() {
    for gap_m in [0.0, 0.1, 0.3] {
        let folder = folder("open_door");
        let (behind_m, jamb_m) = (3.0 + gap_m, 3.0 + gap_m / 2.0);
        let keys = format!(
            "[[building.room]]\nx_m = {behind_m:?}\ny_m = 0.0\nwidth_m = 2.0\ndepth_m = 2.0\n\
             [[building.door]]\nfrom_m = [{jamb_m:?}, 0.5]\nto_m = [{jamb_m:?}, 1.3]\nopen = true\n"
        );
        fs::write(folder.join("scene.toml"), blind_scene(0.1, &keys)).unwrap();
        let (code, _, stderr) = outcome(&mut wherein(&folder, &["run", "scene.toml"]));
        assert!(code != 2, "{gap_m} m: {stderr}");
    }
}

#[test]
fn what_hangs_in_the_air_or_above_the_ceiling_is_refused() {
    // The room is 3 m by 2 m in each of these scenes.
    let cases = [
        (
            "[[lamp]]\nkind = \"window\"\nx_m = 1.0\ny_m = 1.0\nheading_deg = 90\n",
            "no wall within 0.3 m faces that way",
        ),
        ("[[lamp]]\nkind = \"window\"\nx_m = 1.0\ny_m = 0.0\nheading_deg = -90\n", "`lamp[0].heading_deg = -90`"),
        (
            "[[lamp]]\nkind = \"tube\"\nx_m = 1.0\ny_m = 1.0\nsize_m = [50.0, 0.1]\n",
            "larger than the widest room, expected at most 3 m",
        ),
        (
            "[[building.room]]\nx_m = 3.0\ny_m = 0.0\nwidth_m = 2.0\ndepth_m = 2.0\n[[lamp]]\nkind = \"point\"\nx_m = 9.0\ny_m = 1.0\n",
            "`lamp[0].x_m = 9.0`: lies in no room",
        ),
        (
            "[[building.door]]\nfrom_m = [1.0, 0.0]\nto_m = [1.5, 1.0]\n",
            "`building.door[0].to_m = [1.5, 1.0]`: stands on no wall",
        ),
        (
            "[[building.picture]]\nfrom_m = [1.0, 1.0]\nto_m = [1.0, 0.0]\n",
            "`building.picture[0].from_m = [1.0, 1.0]`: hangs on no wall",
        ),
        (
            "[[building.picture]]\nfrom_m = [1.0, 0.0]\nto_m = [2.0, 0.0]\nbottom_m = 2.2\n",
            "reaches above the ceiling, expected at most 0.400",
        ),
        (
            "[[building.picture]]\nfrom_m = [1.0, 0.0]\nto_m = [2.0, 0.0]\nbottom_m = 5.0\n",
            "`building.picture[0].bottom_m = 5.0`",
        ),
        ("[[building.dot]]\nx_m = 5.0\ny_m = 1.0\n", "`building.dot[0].x_m = 5.0`: lies in no room"),
        ("[[building.dot]]\nx_m = 1.0\ny_m = 1.0\nheight_m = 10.0\n", "`building.dot[0].height_m = 10.0`"),
        (
            "[building]\nceiling_height_m = 2.0\n[robot.forward_camera]\nheight_m = 2.5\n",
            "`robot.forward_camera.height_m = 2.5`",
        ),
        (
            "[robot.ceiling_camera]\nprincipal_point_px = [900.0, 100.0]\n",
            "lies outside the image, expected a place within 640 × 480",
        ),
    ];
    for (index, (keys, part)) in cases.into_iter().enumerate() {
        assert_refused(&format!("in_the_air_{index}"), blind_scene(10.0, keys), &[part]);
    }
}

#[test]
fn doors_pictures_and_windows_on_walls_that_another_room_leaves_out_are_refused() {
    // A further room lies within the room of 3 m by 2 m, away from its walls. Where rooms overlap there is no wall between them, so that doors,
    // pictures and windows there must be refused.
    let inner = "[[building.room]]\nx_m = 0.6\ny_m = 0.6\nwidth_m = 1.8\ndepth_m = 0.8\n";
    let door = "[[building.door]]\nfrom_m = [1.0, 0.6]\nto_m = [1.8, 0.6]\n";
    let picture = "[[building.picture]]\nfrom_m = [1.0, 0.6]\nto_m = [1.8, 0.6]\n";
    let window = "[[lamp]]\nkind = \"window\"\nx_m = 1.4\ny_m = 0.6\nheading_deg = 90\nsize_m = [0.5, 0.5]\n";
    let none = ": within another room a room has none, expected a place within 0.3 m of one";
    let cases = [
        (door.to_owned(), vec!["`building.door[0].from_m = [1.0, 0.6]`: stands on no wall", none]),
        (format!("{door}open = true\n"), vec!["`building.door[0].to_m = [1.8, 0.6]`: stands on no wall", none]),
        (picture.to_owned(), vec!["`building.picture[0].from_m = [1.0, 0.6]`: hangs on no wall", none]),
        (window.to_owned(), vec!["`lamp[0].heading_deg = 90`", "no wall within 0.3 m faces that way"]),
    ];
    for (index, (keys, parts)) in cases.iter().enumerate() {
        assert_refused(&format!("room_within_{index}"), blind_scene(10.0, &format!("{inner}{keys}")), parts);
        // The same door, picture or window is accepted when it is moved to y = 0, where the room has a wall.
        let keys = keys.replace("0.6", "0.0");
        Scene::parse(&blind_scene(10.0, &keys.replace("open = true", "")), "wall.toml")
            .unwrap_or_else(|error| panic!("failed to {error}"));
    }
}

#[test]
fn furniture_and_people_may_be_in_further_rooms_but_not_in_walls() {
    // Behind the wall at x = 3 is a room of 3 m by 3 m, with an open door of 0.9 m in that wall.
    let rooms = "[[building.room]]\nx_m = 3.0\ny_m = 0.0\nwidth_m = 3.0\ndepth_m = 3.0\n\
                 [[building.door]]\nfrom_m = [3.0, 0.5]\nto_m = [3.0, 1.4]\nopen = true\n";
    let scene = |more: &str| blind_scene(10.0, &format!("{rooms}{more}"));
    let fine = "[[furniture]]\nx_m = 5.0\ny_m = 2.5\nsize_m = [0.5, 0.5]\n\
                [[person]]\nwaypoints_m = [[5.0, 0.95], [2.0, 0.95]]\n";
    Scene::parse(&scene(fine), "rooms.toml").unwrap_or_else(|error| panic!("failed to {error}"));
    let cases = [
        (
            "[[furniture]]\nx_m = 6.5\ny_m = 1.0\nsize_m = [0.5, 0.5]\n",
            ["`furniture[0].x_m", "or a place in a further"],
        ),
        ("[[landmark]]\nx_m = 6.5\ny_m = 1.0\n", ["`landmark[0].x_m", "or a place in a further"]),
        (
            "[[person]]\nwaypoints_m = [[5.0, 0.95], [7.0, 0.95]]\n",
            ["`person[0].waypoints_m", "[7, 0.95] is in no room"],
        ),
        (
            "[[person]]\nwaypoints_m = [[5.0, 2.9]]\n",
            ["`person[0].waypoints_m", "[5, 2.9] is a place too near to a wall"],
        ),
        (
            "[[person]]\nwaypoints_m = [[5.0, 0.6], [2.0, 0.6]]\n",
            ["`person[0].waypoints_m", "comes too near to a wall"],
        ),
        (
            "[[person]]\nwaypoints_m = [[5.0, 1.8], [2.0, 1.7]]\n",
            ["`person[0].waypoints_m", "the way from [5, 1.8] to [2, 1.7]"],
        ),
    ];
    for (index, (more, parts)) in cases.into_iter().enumerate() {
        assert_refused(&format!("further_rooms_{index}"), scene(more), &parts);
    }
}

#[test]
fn things_in_impossible_places_are_refused() {
    let cases = [
        (
            "[[landmark]]\nx_m = 3.5\ny_m = 1.0\n",
            ["`landmark[0].x_m", "outside the room, expected a number from 0 to 3"],
        ),
        ("[[furniture]]\nx_m = 1.0\ny_m = -0.5\nsize_m = [0.3, 0.3]\n", ["`furniture[0].y_m", "outside the room"]),
        ("[[furniture]]\nx_m = 2.3\ny_m = 1.1\nsize_m = [0.4, 0.4]\n", ["`route.waypoint[0]", "furniture"]),
        ("[[furniture]]\nx_m = 0.8\ny_m = 0.6\nsize_m = [0.2, 0.2]\n", ["`start", "furniture"]),
        ("[[person]]\nwaypoints_m = [[1.5, 1.95]]\n", ["`person[0].waypoints_m", "too near to a wall"]),
        ("[[person]]\nwaypoints_m = []\n", ["`person[0].waypoints_m", "expected"]),
        (
            "[[person]]\nwaypoints_m = [[1.0, 0.6], [2.0, 0.6]]\n",
            ["`person[0].waypoints_m", "[1, 0.6] is in the robot's start, expected 0.5 m of distance from [0.6, 0.6]"],
        ),
    ];
    for (index, (more, parts)) in cases.into_iter().enumerate() {
        assert_refused(&format!("impossible_things_{index}"), blind_scene(10.0, more), &parts);
    }
    // A person is accepted who starts as far from the robot's start, drawn within 0.01 m, as the radii of both add up to, 0.5 m, even if the person
    // walks through the robot's start later on.
    let beside = blind_scene(10.0, "[[person]]\nwaypoints_m = [[1.11, 0.6], [0.6, 0.6]]\n");
    Scene::parse(&beside, "beside.toml").unwrap_or_else(|error| panic!("failed to {error}"));
}

#[test]
fn people_and_furniture_where_the_robot_may_be_drawn_are_refused() {
    // The radii of person and robot add up to 0.5 m. A start at (0.6, 0.6) that is drawn within 0.2 m along each axis may lie at (0.8, 0.8), which is
    // 0.48 m from (1.14, 1.14) and 0.51 m from (1.16, 1.16).
    let person = |at_m: f64| format!("[[person]]\nwaypoints_m = [[{at_m}, {at_m}]]\n");
    let drawn = |more: &str| blind_scene(10.0, more).replace("[start]", "[start]\ntolerance_m = 0.2");
    let expected = ["`person[0].waypoints_m", "is in the robot's start", "the start is drawn within 0.2 m"];
    assert_refused("person_drawn", drawn(&person(1.14)), &expected);
    // Furniture with a corner at (0.96, 0.96) is 0.23 m from (0.8, 0.8), and the robot's radius is 0.25 m.
    let furniture = drawn("[[furniture]]\nx_m = 1.06\ny_m = 1.06\nsize_m = [0.2, 0.2]\n");
    assert_refused(
        "furniture_drawn",
        furniture,
        &["`start.x_m", "furniture[0]", "expected 0.5328", "drawn within 0.2 m"],
    );
    let apart = drawn(&person(1.16));
    Scene::parse(&apart, "apart.toml").unwrap_or_else(|error| panic!("failed to {error}"));
    let station = "[[station]]\nx_m = 1.5\ny_m = 1.0\nheading_deg = 0\ntolerance_m = 0.1\n";
    let at_station = blind_scene(10.0, &format!("{station}[[person]]\nwaypoints_m = [[2.0, 1.3]]\n"))
        .replace("[[route.waypoint]]\nx_m = 2.4\ny_m = 1.2\n", "");
    let expected = ["`person[0].waypoints_m", "is in the robot's station", "the station is drawn within 0.1 m"];
    assert_refused("person_at_station", at_station, &expected);
}

#[test]
fn a_range_camera_that_cannot_be_is_refused() {
    let with =
        |keys: &str| edited("floor_camera = false\n", &format!("floor_camera = false\n[robot.range_camera]\n{keys}"));
    let cases = [
        (with("least_range_m = 4.0\ngreatest_range_m = 3.0\n"), ["`robot.range_camera.greatest_range_m", "more than"]),
        (with("wrong_share = 1.5\n"), ["`robot.range_camera.wrong_share = 1.5`", "expected a number from 0"]),
        (with("baseline_m = 0.0\n"), ["`robot.range_camera.baseline_m = 0.0`", "expected a number"]),
        (
            edited("[robot]", "[localizer]\nmethods = [\"range_landmarks\"]\n[robot]"),
            ["`localizer.methods", "robot.range_camera"],
        ),
        (
            edited("floor_camera = false\n", "floor_camera = false\n[robot.gyro]\nperiod_s = 0.0015\n"),
            ["`robot.gyro.period_s", "expected"],
        ),
    ];
    for (index, (scene, parts)) in cases.into_iter().enumerate() {
        assert_refused(&format!("impossible_range_camera_{index}"), scene, &parts);
    }
}

#[test]
fn a_declared_width_that_the_room_itself_implies_is_refused() {
    // The room is 3 m by 2 m. A body of radius 0.25 m, which at contact counts a millimetre less, can have its origin only within 2 - 2 * 0.249 =
    // 1.502 m of the room along y.
    let scene = |key: &str| blind_scene(10.0, &format!("[localizer]\n{key}\n"));
    assert_refused(
        "declared_width",
        scene("declared_width_m = 1.99"),
        &["`localizer.declared_width_m = 1.99`", "expected less than the 1.502 m"],
    );
    assert_refused(
        "declared_heading",
        scene("declared_width_deg = 360"),
        &["`localizer.declared_width_deg = 360`", "expected less than 360"],
    );
    Scene::parse(&scene("declared_width_m = 1.501\ndeclared_width_deg = 359.0"), "scene.toml").unwrap();
}

#[test]
fn draws_of_a_flow_sensor_beyond_what_is_declared_of_its_scale_are_refused() {
    let scene = |keys: &str| blind_scene(10.0, &format!("[robot.flow]\nscale_tolerance = 0.01\n{keys}\n"));
    for (index, (keys, parts)) in [
        (
            "calibration_tolerance = 0.4",
            ["`robot.flow.calibration_tolerance = 0.4`", "expected at most `scale_tolerance`"],
        ),
        ("surface_tolerance = 0.4", ["`robot.flow.surface_tolerance = 0.4`", "at most 0.009"]),
        (
            "noise_tolerance = 0.006\nsurface_tolerance = 0.004",
            ["`robot.flow.noise_tolerance = 0.006`", "at most 0.009"],
        ),
    ]
    .into_iter()
    .enumerate()
    {
        assert_refused(&format!("impossible_flow_{index}"), scene(keys), &parts);
    }
    Scene::parse(&scene("noise_tolerance = 0.005\nsurface_tolerance = 0.004"), "scene.toml").unwrap();
}

#[test]
fn a_sensor_that_cannot_be_is_refused() {
    let with = |keys: &str| edited("floor_camera = false\n", &format!("[robot.floor_camera]\n{keys}\n"));
    let cases = [
        ("sensor.bits = 9", ["`robot.floor_camera.sensor.bits = 9`", "expected one of 8, 10, 12"]),
        ("sensor.preset = \"low_ligth\"", ["`robot.floor_camera.sensor.preset = \"low_ligth\"`", "low_light"]),
        ("sensor.f_number = 0", ["`robot.floor_camera.sensor.f_number = 0`", "from 0.7 to 32"]),
        ("sensor.prnu = -0.1", ["`robot.floor_camera.sensor.prnu = -0.1`", "from 0 to 0.2"]),
        (
            "sensor.exposure_s = 0.02\nsensor.longest_exposure_s = 0.01",
            ["`robot.floor_camera.sensor.exposure_s = 0.02`", "expected at most `longest_exposure_s`, which is 0.01"],
        ),
        ("sensor.gain = 2", ["`robot.floor_camera.sensor.gain`", "unknown key"]),
        (
            "lens.distortion = [-0.5, 0.0, 0.0, 0.0, 0.0]",
            ["`robot.floor_camera.lens.distortion", "folds the image over within its edges"],
        ),
        ("lens.row_time_s = 0.1", ["`robot.floor_camera.lens.row_time_s = 0.1`", "from 0 to 0.001"]),
        (
            "[robot.forward_camera]\nturning_exposure_s = 0.5",
            [
                "`robot.forward_camera.turning_exposure_s = 0.5`",
                "expected at most the longest exposure, which is 0.033",
            ],
        ),
    ];
    for (index, (keys, parts)) in cases.into_iter().enumerate() {
        assert_refused(&format!("impossible_sensor_{index}"), with(keys), &parts);
    }
}

#[test]
fn black_levels_without_a_level_for_light_are_refused() {
    let with = |keys: &str| edited("floor_camera = false\n", &format!("[robot.floor_camera]\n{keys}\n"));
    let cases = [
        ("sensor.black_level = 255", "expected less than 255, the greatest level of 8 bits"),
        ("sensor.bits = 8\nsensor.black_level = 300.5", "expected less than 255, the greatest level of 8 bits"),
    ];
    for (index, (keys, part)) in cases.into_iter().enumerate() {
        let parts = ["`robot.floor_camera.sensor.black_level = ", part];
        assert_refused(&format!("black_level_{index}"), with(keys), &parts);
    }
    for keys in ["sensor.black_level = 254.5", "sensor.bits = 10\nsensor.black_level = 1000"] {
        Scene::parse(&with(keys), "black.toml").unwrap_or_else(|error| panic!("failed to {error}"));
    }
}

#[test]
fn exposures_and_rows_that_take_longer_than_a_period_are_refused() {
    let with = |keys: &str| edited("floor_camera = false\n", &format!("floor_camera = false\n{keys}\n"));
    let cases = [
        (
            "[robot.floor_camera]\nperiod_s = 0.05\nsensor.exposure_s = 0.06",
            ["`robot.floor_camera.sensor.exposure_s = 0.06`", "`period_s`, expected at most 0.05"],
        ),
        (
            "[robot.forward_camera]\nperiod_s = 0.05\nsensor.longest_exposure_s = 0.06",
            ["`robot.forward_camera.sensor.longest_exposure_s = 0.06`", "`period_s`, expected at most 0.05"],
        ),
        // This scene states no longest exposure, so that the message names that of the sensor's preset.
        (
            "[robot.forward_camera]\nperiod_s = 0.02",
            ["`robot.forward_camera.sensor.longest_exposure_s", "0.033 s is longer"],
        ),
        // The ceiling camera's exposure of up to 0.02 s and the readout of 479 further rows, 0.2 ms each, take longer together than its period.
        (
            "[robot.ceiling_camera]\nlens.row_time_s = 0.0002",
            ["`robot.ceiling_camera.lens.row_time_s = 0.0002`", "480 rows after an exposure of up to 0.02 s"],
        ),
    ];
    for (index, (keys, parts)) in cases.into_iter().enumerate() {
        let scene = with(keys).replacen("floor_camera = false\n[robot.floor", "[robot.floor", 1);
        assert_refused(&format!("period_{index}"), scene, &parts);
    }
    // An exposure and readout exactly as long as the period are accepted.
    let fits = with("[robot.forward_camera]\nsensor.exposure_s = 0.0521\nlens.row_time_s = 0.0001");
    Scene::parse(&fits, "fits.toml").unwrap_or_else(|error| panic!("failed to {error}"));
}

#[test]
fn a_route_through_mapped_furniture_and_a_person_through_a_shelf_are_refused() {
    // The way from (0.6, 0.6) to (2.4, 1.2) passes the piece's middle; the body's radius is that of the default robot.
    let piece = "[[furniture]]\nx_m = 1.5\ny_m = 0.9\nsize_m = [0.2, 0.2]\n";
    let parts = ["`route.waypoint[0].x_m", "[0.6, 0.6] to [2.4, 1.2]", "furniture[0]", "`mapped = false`"];
    assert_refused("route_through_furniture", blind_scene(1.0, piece), &parts);
    // The same piece beside the way, and one that the robot is to run into.
    for fine in [piece.replace("y_m = 0.9", "y_m = 1.7"), format!("{piece}mapped = false\n")] {
        let scene = Scene::parse(&blind_scene(1.0, &fine), "scene.toml");
        assert!(scene.is_ok(), "{fine}: {:?}", scene.err());
    }
    let shelf = "[[furniture]]\nx_m = 1.5\ny_m = 1.7\nsize_m = [0.2, 0.2]\n";
    let person = |ways: &str| format!("{shelf}[[person]]\nwaypoints_m = {ways}\n");
    let through = blind_scene(1.0, &person("[[0.6, 1.65], [2.4, 1.65]]"));
    let parts = ["`person[0].waypoints_m", "[0.6, 1.65] to [2.4, 1.65]", "through furniture[0]"];
    assert_refused("person_through_shelf", through, &parts);
    let named = blind_scene(1.0, &person("[[0.6, 1.65], [2.4, 1.65]]").replacen("x_m", "name = \"shelf\"\nx_m", 1));
    assert_refused("person_through_named_shelf", named, &["through furniture[0] (shelf), expected"]);
    assert_refused("person_in_shelf", blind_scene(1.0, &person("[[1.5, 1.7]]")), &["furniture[0]"]);
    assert!(Scene::parse(&blind_scene(1.0, &person("[[0.6, 1.5], [2.4, 1.5]]")), "scene.toml").is_ok());
}

#[test]
fn a_listed_method_without_its_device_is_refused() {
    let scene = blind_scene(
        1.0,
        "[markers]\n[robot.ceiling_camera]\n[localizer]\nmethods = [\"ceiling_markers\", \"floor_tiles\"]\n",
    );
    assert_refused(
        "unfitted_method",
        scene,
        &["`localizer.methods", "`floor_tiles` among them", "`robot.floor_camera`"],
    );
    // Alone it is refused, too, though it is what a scene has that states no methods.
    assert_refused(
        "unfitted_method_alone",
        blind_scene(1.0, "[localizer]\nmethods = [\"floor_tiles\"]\n"),
        &["`floor_tiles` among them", "`robot.floor_camera`"],
    );
    assert!(Scene::parse(&blind_scene(1.0, ""), "scene.toml").is_ok());
}

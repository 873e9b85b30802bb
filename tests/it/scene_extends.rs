use std::{fs, path::Path};

use sim::{
    artefacts::run_files::scene_digest,
    loading::SceneFile,
    scene::{Scene, schema_text},
};

use crate::command::{blind_scene, folder_of, outcome, root, wherein};

/// Writes files into a folder for this test, whose name `test` is part of the folder's name.
fn files(test: &str, texts: &[(&str, &str)]) -> std::path::PathBuf {
    folder_of(&format!("extends_{test}"), texts)
}

fn loaded(path: &Path) -> Scene {
    Scene::load(path).unwrap_or_else(|error| panic!("failed to {error}"))
}

/// Asserts that `wherein run scene.toml` ends with code 2 and a message that contains each of `parts`; returns everything that the command wrote
/// to stderr.
fn assert_refused(test: &str, texts: &[(&str, &str)], parts: &[&str]) -> String {
    let folder = files(test, texts);
    let (code, stdout, stderr) = outcome(&mut wherein(&folder, &["run", "scene.toml"]));
    let message = stderr.lines().next().unwrap();
    assert_eq!((code, stdout.as_str()), (2, ""), "{test}: {stderr}");
    assert!(message.starts_with("wherein: failed to read scene scene.toml: "), "{test}: {message}");
    for part in parts {
        assert!(message.contains(part), "{test}: `{part}` is missing in: {message}");
    }
    assert!(!folder.join("renders").exists(), "a refused scene left a folder behind");
    stderr
}

#[test]
fn tables_merge_key_by_key_and_any_other_value_replaces_the_whole() {
    let base = blind_scene(
        10.0,
        "[[event]]\nkind = \"light\"\nat_s = 1\nilluminance_at_floor_lux = 5\n[floor.tiles]\nedge_x_m = 0.5\nedge_y_m = 0.4\n",
    );
    let scene = "extends = \"base.toml\"\nduration_s = 20\nevent = []\n[room]\nwidth_m = 4.0\n[floor.tiles]\nedge_x_m = 0.25\n\
                 [robot.floor_camera]\nperiod_s = 0.5\n[[route.waypoint]]\nx_m = 3.5\ny_m = 1.0\n[[route.waypoint]]\nx_m = 1\ny_m = 1\n";
    let folder = files("merge", &[("base.toml", &base), ("scene.toml", scene)]);
    let scene = loaded(&folder.join("scene.toml"));
    assert_eq!((scene.duration_s, scene.room.width_m, scene.room.depth_m), (20.0, 4.0, 2.0));
    let tiles = scene.floor.tiles.unwrap();
    assert_eq!((tiles.edge_x_m, tiles.edge_y_m), (0.25, 0.4));
    assert!(scene.events.is_empty());
    let places: Vec<f64> = scene.route.unwrap().waypoints.iter().map(|waypoint| waypoint.x_m).collect();
    assert_eq!(places, [3.5, 1.0]);
    // The base says `floor_camera = false`, which is not a table, so that the extending file's table replaces it as a whole.
    assert_eq!(scene.robot.floor_camera.unwrap().period_s, 0.5);
}

#[test]
fn added_entries_come_after_those_of_all_files_below() {
    let crate_at =
        |list: &str, x_m: f64| format!("[[{list}]]\nx_m = {x_m:?}\ny_m = 1.5\nsize_m = [0.1, 0.1]\nheight_m = 0.2\n");
    let base = blind_scene(10.0, &crate_at("furniture", 1.5));
    let wide = format!("extends = \"base.toml\"\n{}", crate_at("adds.furniture", 2.0));
    let far = "adds.route.waypoint = [{ x_m = 3.5, y_m = 1.0 }]\n";
    let scene = format!("extends = \"wide.toml\"\nroom.width_m = 4.0\n{far}{}", crate_at("adds.furniture", 2.5));
    let own = format!("extends = \"wide.toml\"\n{}{}", crate_at("furniture", 1.8), crate_at("adds.furniture", 2.2));
    let texts = [("base.toml", &base), ("wide.toml", &wide), ("scene.toml", &scene), ("own.toml", &own)];
    let folder = files("adds", &texts.map(|(name, text)| (name, text.as_str())));
    let places = |scene: &Scene| scene.furniture.iter().map(|piece| piece.x_m).collect::<Vec<f64>>();
    let added = loaded(&folder.join("scene.toml"));
    assert_eq!(places(&added), [1.5, 2.0, 2.5]);
    assert_eq!(added.route.unwrap().waypoints.last().unwrap().x_m, 3.5);
    assert_eq!(places(&loaded(&folder.join("own.toml"))), [1.8, 2.2]);
}

#[test]
fn what_is_added_to_no_list_is_refused() {
    let folder = files("adds_no_list", &[("base.toml", &blind_scene(1.0, "")), ("scene.toml", "")]);
    for (adds, refused) in [
        ("adds = 3", "`adds = 3`: a whole number, expected entries of a list"),
        ("adds.duration_s = 3", "`adds.duration_s = 3`: a whole number, expected entries of a list"),
        ("adds.mass = 3", "`adds.mass = 3`: a whole number, expected entries of a list"),
    ] {
        fs::write(folder.join("scene.toml"), format!("extends = \"base.toml\"\n{adds}\n")).unwrap();
        let error = Scene::load(&folder.join("scene.toml")).unwrap_err().to_string();
        assert!(error.contains(refused), "{error}");
    }
}

#[test]
fn a_description_is_a_files_own_and_expectations_are_taken_over_as_a_whole_or_not_at_all() {
    let base = format!("description = \"base\"\n{}", blind_scene(1.0, "[expect]\nunsound = 0\nperception = 0\n"));
    let inherits = "extends = \"base.toml\"\n";
    let states = "extends = \"inherits.toml\"\ndescription = \"own\"\n[expect]\nbound_broken = 0\n";
    let folder = files("own", &[("base.toml", &base), ("inherits.toml", inherits), ("states.toml", states)]);
    let inherits = loaded(&folder.join("inherits.toml"));
    assert_eq!(inherits.description, "");
    assert_eq!(inherits.expect.limits.len(), 2);
    let states = loaded(&folder.join("states.toml"));
    assert_eq!(states.description, "own");
    assert_eq!(states.expect.limits.len(), 1);
}

#[test]
fn each_file_names_the_next_one_from_its_own_folder() {
    let texts = [
        ("rooms/deep/plain.base.toml", &*blind_scene(3.0, "")),
        ("rooms/wide.toml", "extends = \"deep/plain.base.toml\"\n[room]\nwidth_m = 5\n"),
        ("mine/scene.toml", "extends = \"../rooms/wide.toml\"\n[room]\ndepth_m = 6\n"),
    ];
    let scene = loaded(&files("chain", &texts).join("mine/scene.toml"));
    assert_eq!((scene.duration_s, scene.room.width_m, scene.room.depth_m), (3.0, 5.0, 6.0));
}

#[test]
fn a_map_lies_beside_the_file_that_names_it() {
    let lab = blind_scene(1.0, "").replace("[[route.waypoint]]", "[[errand]]");
    let folder = files("map", &[("lab/plain.toml", &lab)]);
    let (code, _, errors) = outcome(&mut wherein(&folder, &["map", "lab/plain.toml", "--out", "."]));
    assert_eq!(code, 0, "{errors}");
    fs::rename(folder.join("plain"), folder.join("lab/maps")).unwrap();
    fs::write(folder.join("lab/lab.toml"), format!("{lab}[navigation]\nmap = \"maps/map.yaml\"\n")).unwrap();
    fs::create_dir(folder.join("mine")).unwrap();
    let scene = folder.join("mine/scene.toml");
    fs::write(&scene, "extends = \"../lab/lab.toml\"\n").unwrap();
    assert_eq!(loaded(&scene).navigation.unwrap().surveyed, loaded(&folder.join("lab/lab.toml")).navigation().surveyed);
    // When a scene is run with `--set`, its text is written anew; the path of the map must still be found.
    let run = ["run", "mine/scene.toml", "--set", "duration_s=0.5"];
    let (code, _, errors) = outcome(&mut wherein(&folder, &run));
    assert_eq!(code, 0, "{errors}");
}

#[test]
fn a_mistake_is_named_and_underlined_in_the_file_in_which_it_stands() {
    let base = blind_scene(10.0, "").replace("depth_m = 2.0", "depth_m = -2.0");
    let scene = "extends = \"base.toml\"\n\n[start]\nheading = 3\n";
    let parts =
        ["`start.heading`: unknown key", "in base.toml, `room.depth_m = -2.0`: expected a number from 0.5 to 200"];
    let shown = assert_refused("places", &[("base.toml", &base), ("scene.toml", scene)], &parts);
    for part in
        ["[scene.toml:4:1]", "heading = 3", "[base.toml:4:11]", "depth_m = -2.0", "Extent of the room along world y"]
    {
        assert!(shown.contains(part), "{part}: {shown}");
    }
}

#[test]
fn a_value_that_is_overridden_may_be_wrong_in_the_base() {
    let base = blind_scene(10.0, "").replace("depth_m = 2.0", "depth_m = -2.0");
    let folder =
        files("overridden", &[("base.toml", &base), ("scene.toml", "extends = \"base.toml\"\nroom.depth_m = 2\n")]);
    assert_eq!(loaded(&folder.join("scene.toml")).room.depth_m, 2.0);
}

#[test]
fn what_neither_file_states_is_missing_in_the_extending_one() {
    let texts = [("base.toml", "[room]\nwidth_m = 3\n"), ("scene.toml", "extends = \"base.toml\"\n")];
    let parts = ["`start`: missing, expected a table", "in base.toml, `room.depth_m`: missing, expected a number"];
    assert_refused("missing_keys", &texts, &parts);
}

#[test]
fn values_of_two_files_that_contradict_each_other_are_refused_in_the_name_of_the_extending_one() {
    let base = blind_scene(10.0, "[light]\nilluminance_at_floor_lux = 5\n");
    let scene = "extends = \"base.toml\"\n[room]\nwidth_m = 2.5\n[light]\nilluminance_at_camera_lux = 5\n";
    // The extending file makes the room 2.5 m wide and the body reaches 0.25 m, but the base's waypoint is at x = 2.4 m.
    let parts = [
        "in base.toml, `route.waypoint[0].x_m = 2.4`: outside the room, expected a number from 0.25 to 2.25",
        "in base.toml, `light.illuminance_at_floor_lux = 5`: stands beside `illuminance_at_camera_lux`",
    ];
    assert_refused("contradiction", &[("base.toml", &base), ("scene.toml", scene)], &parts);
}

#[test]
fn a_base_that_cannot_be_read_is_refused_at_the_key_that_names_it() {
    let missing = ["`extends = \"gone.toml\"`", "failed to read scene gone.toml: ", "expected the path of a file"];
    let shown = assert_refused("gone", &[("scene.toml", "duration_s = 1\nextends = \"gone.toml\"\n")], &missing);
    assert!(shown.contains("[scene.toml:2:11]") && shown.contains("extends = \"gone.toml\""), "{shown}");

    let folder = ["`extends = \"rooms\"`", "failed to read scene rooms: "];
    assert_refused("folder", &[("rooms/x.toml", ""), ("scene.toml", "extends = \"rooms\"\n")], &folder);

    let deep = [("base.toml", "extends = \"no/lab.toml\"\n"), ("scene.toml", "extends = \"base.toml\"\n")];
    let shown =
        assert_refused("deep", &deep, &["in base.toml, `extends = \"no/lab.toml\"`", "read scene no/lab.toml: "]);
    assert!(shown.contains("[base.toml:1:11]"), "{shown}");

    let texts = [("base.toml", "[room\n"), ("scene.toml", "extends = \"base.toml\"\n")];
    let shown = assert_refused("not_toml", &texts, &["in base.toml, not a scene in TOML"]);
    assert!(shown.contains("[base.toml:1:6]"), "{shown}");

    let place = files("bytes", &[("scene.toml", "extends = \"base.toml\"\n")]);
    fs::write(place.join("base.toml"), b"[room]\n\xff").unwrap();
    let (code, _, errors) = outcome(&mut wherein(&place, &["run", "scene.toml"]));
    assert!(
        code == 2 && errors.contains("`extends = \"base.toml\"`: failed to read scene base.toml: byte 7"),
        "{errors}"
    );
}

#[test]
fn a_circle_is_refused_with_the_way_round() {
    let round = [
        ("a.toml", "extends = \"b/b.toml\"\n"),
        ("b/b.toml", "extends = \"../scene.toml\"\n"),
        ("scene.toml", "extends = \"a.toml\"\n"),
    ];
    let parts = [
        "in b/b.toml, `extends = \"../scene.toml\"`",
        "circle (scene.toml, then a.toml, then b/b.toml, and ",
        "expected a file that does not build on this one",
    ];
    assert_refused("circle", &round, &parts);
    assert_refused(
        "itself",
        &[("scene.toml", "extends = \"./scene.toml\"\n")],
        &["`extends = \"./scene.toml\"`", "circle"],
    );
}

#[test]
fn a_base_that_is_no_relative_path_is_refused() {
    let absolute = ["`extends = \"/lab.toml\"`", "an absolute path, expected one from this file's folder"];
    assert_refused("absolute", &[("scene.toml", "extends = \"/lab.toml\"\n")], &absolute);
    for (value, found) in [("3", "a whole number"), ("[\"a.toml\"]", "a list"), ("{ file = \"a.toml\" }", "a table")] {
        let parts = [&format!("`extends = {value}`: {found}, expected a text in quotes") as &str];
        assert_refused("no_text", &[("scene.toml", &format!("extends = {value}\n"))], &parts);
    }
}

#[test]
fn a_text_without_a_file_extends_nothing() {
    let text = format!("extends = \"base.toml\"\n{}", blind_scene(1.0, ""));
    let error = Scene::parse(&text, "a text").unwrap_err().to_string();
    for part in
        ["read scene a text: `extends = \"base.toml\"`", "without a file", "expected all keys in the text itself"]
    {
        assert!(error.contains(part), "{error}");
    }
}

#[test]
fn another_base_cannot_be_set() {
    let folder = files("set", &[("scene.toml", &blind_scene(1.0, ""))]);
    for arguments in
        [["run", "scene.toml", "--set", "extends=b.toml"], ["sweep", "scene.toml", "--vary", "extends=b.toml"]]
    {
        let (code, _, errors) = outcome(&mut wherein(&folder, &arguments));
        assert_eq!(code, 2, "{errors}");
        assert!(errors.contains("failed to set `extends = b.toml` of scene scene.toml: "), "{errors}");
        assert!(errors.contains("expected a key of the scene itself"), "{errors}");
    }
}

#[test]
fn keys_of_a_base_can_be_set() {
    let folder =
        files("set_base", &[("lab.base.toml", &blind_scene(1.0, "")), ("scene.toml", "extends = \"lab.base.toml\"\n")]);
    let (code, printed, errors) = outcome(&mut wherein(&folder, &["scene", "scene.toml", "--set", "room.depth_m=2.5"]));
    assert_eq!(code, 0, "{errors}");
    assert_eq!(Scene::parse(&printed, "printed").unwrap().room.depth_m, 2.5);
}

#[test]
fn files_that_end_in_base_toml_are_no_scenes_of_a_folder() {
    let folder =
        files("folder_of", &[("all/lab.base.toml", "duration_s = 0.1\n"), ("all/x.toml", &blind_scene(0.1, ""))]);
    let found = SceneFile::load_all(&[folder.join("all")]).unwrap();
    assert_eq!(found.len(), 1);
    fs::remove_file(folder.join("all/x.toml")).unwrap();
    let (code, _, errors) = outcome(&mut wherein(&folder, &["run", "all"]));
    assert!(
        code == 2 && errors.contains("failed to find a scene in all: ") && errors.contains(".base.toml"),
        "{errors}"
    );
}

#[test]
fn results_of_another_base_are_not_taken_for_ones_own() {
    let base = blind_scene(0.3, "");
    let folder = files("resume", &[("lab.base.toml", &base), ("scene.toml", "extends = \"lab.base.toml\"\n")]);
    let run = || {
        let (code, _, errors) = outcome(&mut wherein(&folder, &["run", "scene.toml", "--resume"]));
        assert_eq!(code, 0, "{errors}");
        fs::read_to_string(folder.join("renders/scene/0/summary.json")).unwrap()
    };
    let sweep = || {
        let (code, _, errors) = outcome(&mut wherein(&folder, &["sweep", "scene.toml", "--out", "out"]));
        assert_eq!(code, 0, "{errors}");
        fs::read_to_string(folder.join("out/sweep.json")).unwrap()
    };
    let (first_run, first_plan) = (run(), sweep());
    assert!(run() == first_run && sweep() == first_plan);
    fs::write(folder.join("lab.base.toml"), base.replace("duration_s = 0.3", "duration_s = 0.4")).unwrap();
    assert!(run() != first_run && sweep() != first_plan);
}

#[test]
fn a_recording_replays_when_the_base_is_gone() {
    let folder = files(
        "recording",
        &[("lab.base.toml", &blind_scene(0.5, "")), ("scene.toml", "extends = \"lab.base.toml\"\n")],
    );
    let (code, _, errors) = outcome(&mut wherein(&folder, &["run", "scene.toml", "--record"]));
    assert_eq!(code, 0, "{errors}");
    fs::remove_file(folder.join("lab.base.toml")).unwrap();
    let (code, output, errors) = outcome(&mut wherein(&folder, &["replay", "renders/scene/0/recording.mcap"]));
    assert_eq!(code, 0, "{output}{errors}");
}

#[test]
fn every_scene_states_the_same_as_one_text() {
    for file in SceneFile::load_all(&[root().join("scenes")]).unwrap() {
        let whole = Scene::parse(&file.text, &file.name).unwrap_or_else(|error| panic!("failed to {error}"));
        assert_eq!(scene_digest(&whole), scene_digest(&file.scene), "{}", file.name);
    }
}

#[test]
fn the_schema_knows_the_key_and_asks_for_nothing_that_may_stand_in_another_file() {
    let schema: serde_json::Value = serde_json::from_str(&schema_text()).unwrap();
    assert_eq!(schema["properties"]["extends"]["type"], "string");
    for table in ["", "/$defs/Room", "/$defs/Start", "/$defs/Route", "/$defs/Spread"] {
        assert!(schema.pointer(table).unwrap().get("required").is_none(), "{table}");
    }
    // A scene file that extends another one may leave out keys, but not within list items such as waypoints: lists of two files are never merged, so
    // that each item must be complete.
    for item in ["/$defs/Waypoint", "/$defs/Marker", "/$defs/Region"] {
        assert!(schema.pointer(item).unwrap().get("required").is_some(), "{item}");
    }
}

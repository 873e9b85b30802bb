use std::collections::BTreeSet;

use sim::{
    campaign::falsify::{Profile, drawn, keys},
    scene::{Scene, SceneError},
};

/// Collects the keys of a scene's table as dotted paths without indices.
fn stated(table: &toml::Table, path: &str, found: &mut BTreeSet<String>) {
    for (key, value) in table {
        let path = if path.is_empty() { key.clone() } else { format!("{path}.{key}") };
        found.insert(path.clone());
        let tables = value.as_table().into_iter();
        let items = value.as_array().into_iter().flatten().filter_map(toml::Value::as_table);
        tables.chain(items).for_each(|table| stated(table, &path, found));
    }
}

#[test]
fn every_key_that_scenes_have_is_drawn_but_those_without_effect_on_a_run() {
    // Keys of scenes that are never drawn: texts for people, files that do not exist and what is confused in one, a scene's own expectations, a
    // chessboard that only calibrations use, what is said about logs, which no run reads, the settings of filters, which the search does not test,
    // and what is outdoors, where random rooms are not.
    const NEVER: [&str; 6] = [
        "description",
        "expect",
        "navigation.map",
        "localizer.mapped_landmarks.map",
        "localizer.mapped_landmarks.confused_share",
        "building.picture.chessboard",
    ];
    // Keys of scenes that are drawn and then removed again, because drawn dots and markers are at their default height.
    const BY_DEFAULT: [&str; 2] = ["building.dot.height_m", "markers.marker.height_m"];
    let mut found = BTreeSet::new();
    for number in 0..1500 {
        stated(&drawn(1, Profile::WithCameras, number, 0).0, "", &mut found);
        stated(&drawn(1, Profile::WithoutCameras, number, 0).0, "", &mut found);
    }
    let wanted: BTreeSet<String> = keys().into_iter().collect();
    let is_not_read = |key: &str| {
        ["log", "filters", "outdoors"].contains(&key.split('.').next().unwrap_or(key))
            || key.starts_with("building.facade")
    };
    let missing: Vec<&String> = wanted.iter().filter(|key| !found.contains(*key) && !is_not_read(key)).collect();
    let known: BTreeSet<&str> = NEVER.into_iter().chain(BY_DEFAULT).collect();
    assert!(missing.iter().all(|key| known.contains(key.as_str())), "never drawn: {missing:?}");
    let unknown: Vec<&String> = found.iter().filter(|key| !wanted.contains(*key)).collect();
    assert!(unknown.is_empty(), "drawn, but no key: {unknown:?}");
}

#[test]
fn a_case_is_determined_by_seed_and_number_alone() {
    let case = |seed, number| drawn(seed, Profile::Mixed, number, 0);
    assert_eq!(case(3, 5), case(3, 5));
    assert_ne!(case(3, 5), case(3, 6));
    assert_ne!(case(3, 5), case(4, 5));
}

#[test]
fn few_of_the_scenes_that_are_drawn_are_refused() {
    for (profile, cases) in [(Profile::WithoutCameras, 200), (Profile::WithCameras, 60)] {
        let mut refused = Vec::new();
        for number in 0..cases {
            let text = drawn(2, profile, number, 0).0.to_string();
            if let Err(SceneError::Invalid { problems, .. }) = Scene::parse(&text, "drawn.toml") {
                refused.push(problems.0[0].key.clone());
            }
        }
        assert!(4 * refused.len() < cases as usize, "{} of {cases} refused: {refused:?}", refused.len());
    }
}

#[test]
fn some_scenes_lead_through_an_open_door_into_another_room() {
    let leads_out = |number: u32| {
        let (scene, _) = drawn(1, Profile::WithoutCameras, number.into(), 0);
        let width_m = scene["room"]["width_m"].as_float().unwrap();
        let waypoints = scene.get("route").and_then(|route| route["waypoint"].as_array()).into_iter().flatten();
        let goes_out = waypoints.filter_map(|waypoint| waypoint.get("x_m")?.as_float()).any(|x_m| x_m > width_m);
        let is_valid = Scene::parse(&scene.to_string(), "drawn.toml").is_ok();
        let is_polygon = goes_out && scene["building"]["room"][0].get("corners_m").is_some();
        (goes_out, goes_out && is_valid, is_polygon && is_valid)
    };
    let drawn: Vec<(bool, bool, bool)> = (0..400).map(leads_out).collect();
    let (out, valid) =
        (drawn.iter().filter(|(out, ..)| *out).count(), drawn.iter().filter(|(_, valid, _)| *valid).count());
    assert!(out > 8 && 10 * valid > 7 * out, "{valid} of {out} are valid");
    let polygons = drawn.iter().filter(|(.., is_polygon)| *is_polygon).count();
    assert!(polygons > 3 && valid - polygons > 3, "{polygons} of {valid} are polygons");
}

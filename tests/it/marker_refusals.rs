//! Tests of scenes whose markers must be refused, and of the error messages.

use sim::scene::Scene;

/// Parses a scene with a room of 3 m by 2 m and the given lines after `[markers]`.
fn parse(markers: &str) -> Result<Scene, String> {
    let text = format!(
        "[room]\nwidth_m = 3.0\ndepth_m = 2.0\n[start]\nx_m = 1.0\ny_m = 1.0\n[[route.waypoint]]\nx_m = 1.0\ny_m = 1.0\n\
         [robot.ceiling_camera]\n[markers]\n{markers}"
    );
    Scene::parse(&text, "room.toml").map_err(|error| error.to_string())
}

fn assert_refused(markers: &str, parts: &[&str]) {
    let message = parse(markers).map(|_| ()).unwrap_err();
    for part in parts {
        assert!(message.contains(part), "`{part}` is missing in: {message}");
    }
}

const ONE: &str = "[[markers.marker]]\nid = 125\nx_m = 1.0\ny_m = 1.0\n";

#[test]
fn an_identity_that_is_no_word_is_refused_with_the_nearest_ones() {
    // By the code called hexads, identities are words with six coded dots. 125 is such a word; 124 lacks one of its dots.
    assert!(parse(ONE).is_ok());
    assert_refused(
        &ONE.replace("125", "124"),
        &["`markers.marker[0].id = 124`", "no word of the hexads", "125", "(1 dot away)"],
    );
    assert!(parse(&format!("coding = \"plain\"\n{}", ONE.replace("125", "124"))).is_ok());
    assert_refused(&ONE.replace("125", "4096"), &["`markers.marker[0].id = 4096`", "a whole number from 0 to 4095"]);
    assert_refused(&format!("coding = \"hexad\"\n{ONE}"), &["`markers.coding = \"hexad\"`", "plain, lexicode, hexads"]);
}

#[test]
fn the_same_identity_twice_on_the_map_is_refused_and_off_it_is_not() {
    let other = ONE.replace("x_m = 1.0", "x_m = 2.0");
    assert_refused(
        &format!("{ONE}{other}"),
        &["`markers.marker[1].id = 125`", "that of markers.marker[0] too", "`on_map = false`"],
    );
    assert!(parse(&format!("{ONE}{other}on_map = false\n")).is_ok());
}

#[test]
fn a_marker_that_reaches_out_of_the_room_is_refused() {
    assert_refused(&ONE.replace("x_m = 1.0", "x_m = 2.93"), &["`markers.marker[0].x_m = 2.93`", "from 0.08 to 2.92"]);
    // The square of a marker has sides of 0.16 m: turned by 45°, its corner reaches 0.08·√2 m from its middle.
    let turned = ONE.replace("y_m = 1.0", "y_m = 0.1\nrotation_deg = 45");
    assert_refused(&turned, &["`markers.marker[0].y_m = 0.1`", "from 0.113137 to 1.886863"]);
    assert!(parse(&turned.replace("rotation_deg = 45", "rotation_deg = 90")).is_ok());
}

#[test]
fn markers_on_top_of_each_other_are_refused() {
    let beside = |x_m: f64, more: &str| format!("{ONE}[[markers.marker]]\nid = 183\nx_m = {x_m:?}\ny_m = 1.0\n{more}");
    assert_refused(
        &beside(1.15, ""),
        &["`markers.marker[1].x_m = 1.15`", "on top of markers.marker[0]", "0.16 m wide"],
    );
    assert!(parse(&beside(1.161, "")).is_ok());
    // Two markers are 0.16 m wide each. If one of them is turned by 45°, its corner reaches 0.113 m towards the other one, whose side is 0.08 m from
    // its own middle: the middles must be 0.193 m apart.
    assert_refused(&beside(1.19, "rotation_deg = 45"), &["on top of markers.marker[0]"]);
    assert!(parse(&beside(1.194, "rotation_deg = 45")).is_ok());
    assert!(parse(&beside(1.0, "pasted = false")).is_ok(), "one that has fallen off is in nobody's way");
}

#[test]
fn a_marker_in_the_ceiling_is_refused() {
    assert_refused(
        &format!("{ONE}height_m = 2.6\n"),
        &["`markers.marker[0].height_m = 2.6`", "expected at most 2.594", "drawn within 0.005 m"],
    );
    assert!(parse(&format!("{ONE}height_m = 2.594\n")).is_ok());
}

#[test]
fn a_marker_at_or_below_the_camera_is_refused() {
    let low = &format!("{ONE}height_m = 0.2\n");
    assert_refused(low, &["`markers.marker[0].height_m = 0.2`", "too near to the ceiling camera at 0.3 m"]);
}

#[test]
fn a_marker_cannot_have_been_moved_out_of_the_room() {
    assert_refused(
        &format!("{ONE}misplaced_m = [9.0, 0.0]\n"),
        &["`markers.marker[0].misplaced_m = [9.0, 0.0]`", "moves it out of the room"],
    );
    assert!(parse(&format!("{ONE}misplaced_m = [1.0, 0.0]\n")).is_ok());
}

#[test]
fn damage_to_what_is_not_there_is_refused() {
    // Marker 125 has coded dots at the grid places [0, 1], [1, 0] to [1, 3] and [2, 0]; a place counts steps from dot O towards dot X and towards dot
    // Y.
    assert_refused(&format!("{ONE}missing_dots = [[2, 1]]\n"), &["missing_dots", "no dot is printed at [2, 1]"]);
    assert_refused(&format!("{ONE}missing_dots = [[4, 1]]\n"), &["missing_dots", "[4, 1]"]);
    assert_refused(&format!("{ONE}extra_dots = [[0, 0]]\n"), &["extra_dots", "[0, 0] cannot be one", "without a dot"]);
    assert!(parse(&format!("{ONE}missing_dots = [[1, 3]]\nextra_dots = [[3, 3], [2, 1]]\n")).is_ok());
}

#[test]
fn two_errands_of_one_name_are_refused() {
    let errands =
        "[[errand]]\nname = \"desk\"\nx_m = 1.0\ny_m = 1.0\n[[errand]]\nname = \"NAME\"\nx_m = 2.0\ny_m = 1.0\n";
    let text = format!("[room]\nwidth_m = 3.0\ndepth_m = 2.0\n[start]\nx_m = 1.0\ny_m = 1.0\n{errands}");
    let message = Scene::parse(&text.replace("NAME", "desk"), "room.toml").map(|_| ()).unwrap_err().to_string();
    assert!(message.contains("`errand[1].name = \"desk\"`") && message.contains("errand[0] too"), "{message}");
    assert!(Scene::parse(&text.replace("NAME", "door"), "room.toml").is_ok());
    assert!(Scene::parse(&text.replace("name = \"desk\"\n", "").replace("NAME", "door"), "room.toml").is_ok());
}

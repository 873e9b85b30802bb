//! Tests of the command `wherein markers`: the map that it writes, the sheet that it prints, and what it refuses.

use std::fs;

use sim::scene::Scene;

use crate::command::{blind_scene, folder, outcome, wherein};

const KEYS: &str = "[robot.ceiling_camera]\nfocal_px = [480.0, 480.0]\n";

#[test]
fn the_map_written_is_the_map_when_pasted() {
    let folder = folder("markers_map");
    let text = blind_scene(
        1.0,
        &format!("{KEYS}[markers]\nplacement_tolerance_m = 0.003\nshare_missing = 0.5\n[markers.layout]\n"),
    );
    fs::write(folder.join("hall.toml"), &text).unwrap();
    let (code, printed, error) = outcome(&mut wherein(&folder, &["markers", "hall.toml", "--out", "out"]));
    assert_eq!(code, 0, "{error}");
    assert!(
        printed.contains("Covered: at least 1 wholly in the image") && printed.contains("markers.pdf"),
        "{printed}"
    );
    let map = fs::read_to_string(folder.join("out/hall/markers.toml")).unwrap();
    let pasted = Scene::parse(&blind_scene(1.0, &format!("{KEYS}{map}")), "pasted.toml").unwrap();
    let stated = Scene::parse(&text, "hall.toml").unwrap();
    assert_eq!(pasted.map(), stated.map());
    assert!(pasted.map().markers.unwrap().placement_m == 0.003);
    // A second run must not overwrite the files of the first.
    let (code, _, error) = outcome(&mut wherein(&folder, &["markers", "hall.toml", "--out", "out"]));
    assert_eq!(code, 2);
    assert!(error.contains("markers.pdf: it exists already"), "{error}");
}

#[test]
fn a_scene_without_markers_or_without_cover_says_so() {
    let folder = folder("markers_none");
    fs::write(folder.join("bare.toml"), blind_scene(1.0, "")).unwrap();
    let (code, _, error) = outcome(&mut wherein(&folder, &["markers", "bare.toml"]));
    assert_eq!(code, 2);
    assert!(error.contains("find markers in bare.toml: expected a table `[markers]`"), "{error}");
    let one = "[[markers.marker]]\nid = 125\nx_m = 0.2\ny_m = 0.2\n";
    fs::write(folder.join("one.toml"), blind_scene(1.0, &format!("{KEYS}{one}"))).unwrap();
    let (code, printed, _) = outcome(&mut wherein(&folder, &["markers", "one.toml"]));
    assert_eq!(code, 0);
    assert!(printed.contains("Not covered: fewer than 1 surely in the image at x "), "{printed}");
}

#[test]
fn a_sheet_has_a_page_a_marker_at_true_scale_as_seen_from_below() {
    let folder = folder("markers_sheet");
    let two =
        "[[markers.marker]]\nid = 125\nx_m = 0.6\ny_m = 0.6\n[[markers.marker]]\nid = 183\nx_m = 1.6\ny_m = 0.6\n";
    fs::write(folder.join("two.toml"), blind_scene(1.0, &format!("{KEYS}{two}"))).unwrap();
    let (code, _, error) = outcome(&mut wherein(&folder, &["markers", "two.toml", "--out", "."]));
    assert_eq!(code, 0, "{error}");
    let bytes = fs::read(folder.join("two/markers.pdf")).unwrap();
    let sheet = String::from_utf8_lossy(&bytes);
    assert!(sheet.contains("/Count 2") && sheet.contains("(Marker 125)") && sheet.contains("(Marker 183)"));
    // A4 is 210 mm by 297 mm, in points of 1/72 inch.
    assert!(sheet.contains("/MediaBox [0 0 595.27") && sheet.contains(" 841.88"), "A4");
    // The path of a disc begins at the disc's right end. Each marker has the dots O, X, Y and six coded dots: O is at
    // the upper left, X 120 mm to its right, Y 120 mm below it.
    let page = sheet.split("(Marker 125)").next().unwrap();
    let lines: Vec<&str> = page.lines().collect();
    // The start of a disc's path is followed by curves, the start of other paths by lines.
    let starts: Vec<[f64; 2]> = lines
        .windows(2)
        .filter(|pair| pair[1].ends_with(" c"))
        .filter_map(|pair| pair[0].strip_suffix(" m"))
        .map(|line| line.split(' ').map(|number| number.parse().unwrap()).collect::<Vec<f64>>())
        .map(|numbers| [numbers[0] - 10.0, numbers[1]])
        .collect();
    assert_eq!(starts.len(), 9);
    let at = |dx: f64, dy: f64| starts.iter().any(|[x, y]| (x - 45.0 - dx).hypot(y - 65.0 - dy) < 1e-6);
    // Marker 125 has coded dots at the grid places [0, 1], [1, 0] to [1, 3] and [2, 0], which count steps of 40 mm from dot O towards dot X and
    // towards dot Y.
    for [i, j] in [[0, 0], [3, 0], [0, 3], [0, 1], [1, 0], [1, 1], [1, 2], [1, 3], [2, 0]] {
        assert!(at(40.0 * f64::from(i), 40.0 * f64::from(j)), "[{i}, {j}] is not at its place");
    }
}

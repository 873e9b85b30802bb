use std::{collections::BTreeMap, fs, path::Path};

use serde_json::Value;
use sim::campaign::sweep::write_whole;

use crate::command::{blind_scene, folder, outcome, wherein};

/// Numbers of a text file, one list for each line, without the first `skipped` lines.
fn rows(path: &Path, skipped: usize) -> Vec<Vec<f64>> {
    let text = fs::read_to_string(path).unwrap();
    let numbers = |line: &str| line.split([' ', ',']).map(|field| field.parse().unwrap_or(f64::NAN)).collect();
    text.lines().skip(skipped).map(numbers).collect()
}

/// Pose on a line in TUM format: time in whole steps of 10 ms, then x, y and heading.
fn pose(row: &[f64]) -> (i64, [f64; 3]) {
    let &[time_s, x_m, y_m, _, qx, qy, qz, qw] = row else { panic!("a TUM line has eight fields") };
    assert!(qx == 0.0 && qy == 0.0 && (qz.hypot(qw) - 1.0).abs() < 1e-12, "a unit quaternion about z");
    ((time_s * 100.0).round() as i64, [x_m, y_m, 2.0 * qz.atan2(qw)])
}

#[test]
fn boxes_and_trajectories_tell_what_the_summary_tells() {
    let folder = folder("tell");
    fs::write(folder.join("scene.toml"), blind_scene(5.0, "")).unwrap();
    assert_eq!(outcome(&mut wherein(&folder, &["run", "scene.toml"])).0, 0);
    let run = folder.join("renders/scene/0");
    let summary: Value = serde_json::from_str(&fs::read_to_string(run.join("summary.json")).unwrap()).unwrap();
    let truths: Vec<(i64, [f64; 3])> = rows(&run.join("truth.tum"), 0).iter().map(|row| pose(row)).collect();
    let estimates: Vec<(i64, [f64; 3])> = rows(&run.join("estimate.tum"), 0).iter().map(|row| pose(row)).collect();
    assert_eq!(truths.len() as u64, summary["containment"]["checks"].as_u64().unwrap());

    let mut boxes: BTreeMap<i64, Vec<Vec<f64>>> = BTreeMap::new();
    for row in rows(&run.join("boxes.csv"), 1) {
        boxes.entry((row[0] * 100.0).round() as i64).or_default().push(row);
    }
    let is_inside = |(step, place): &&(i64, [f64; 3])| {
        boxes[step]
            .iter()
            .any(|row| (0..3).all(|axis| row[3 + 2 * axis] <= place[axis] && place[axis] <= row[4 + 2 * axis]))
    };
    assert_eq!(truths.iter().filter(is_inside).count() as u64, summary["containment"]["contained"].as_u64().unwrap());

    for (axis, name) in ["x_m", "y_m"].into_iter().enumerate() {
        let squares: f64 =
            truths.iter().zip(&estimates).map(|(truth, estimate)| (truth.1[axis] - estimate.1[axis]).powi(2)).sum();
        let rmse = (squares / truths.len() as f64).sqrt();
        assert!((rmse - summary["error"][name]["rmse"].as_f64().unwrap()).abs() < 1e-9, "{name}");
    }
}

#[test]
fn a_summary_lists_its_parts_in_the_order_of_the_contract() {
    let folder = folder("order");
    fs::write(folder.join("scene.toml"), blind_scene(1.0, "")).unwrap();
    assert_eq!(outcome(&mut wherein(&folder, &["run", "scene.toml"])).0, 0);
    let text = fs::read_to_string(folder.join("renders/scene/0/summary.json")).unwrap();
    let parts = [
        "scene",
        "seed",
        "subject",
        "version",
        "adapter",
        "duration_s",
        "containment",
        "violations",
        "error",
        "width",
        "power",
        "availability",
        "distribution",
        "latency_s",
        "methods",
        "baselines",
        "metrics",
        "verdict",
        "events",
        "contradictions",
        "width_by_bound",
        "digest",
    ];
    let listed: Vec<&str> =
        text.lines().filter_map(|line| line.strip_prefix("  \"")).filter_map(|line| line.split('"').next()).collect();
    assert_eq!(listed, parts);
}

#[test]
fn frames_show_the_image_as_the_sensor_gave_it_and_a_larger_figure() {
    let folder = folder("frames");
    let scene = blind_scene(1.3, "[floor.tiles]\n").replace("floor_camera = false", "floor_camera = true");
    fs::write(folder.join("scene.toml"), scene).unwrap();
    let (code, _, stderr) = outcome(&mut wherein(&folder, &["run", "scene.toml", "--frames", "every=4"]));
    assert_eq!(code, 0, "{stderr}");
    let run = folder.join("renders/scene/0");
    for number in [0, 4] {
        let sensed = image::open(run.join(format!("image_{number:05}.png"))).unwrap();
        assert_eq!((sensed.width(), sensed.height(), sensed.color()), (640, 480, image::ColorType::L8));
        let figure = image::open(run.join(format!("figure_{number:05}.png"))).unwrap();
        assert!(figure.width() > 1000 && figure.color() == image::ColorType::Rgb8);
    }
    assert!(!run.join("image_00001.png").exists());
}

#[test]
fn a_reading_of_the_range_camera_is_drawn_where_the_landmark_is() {
    let folder = folder("range_frames");
    // The robot stands at (0.6, 0.6) and looks along x; the only landmark is 2 m ahead of it and 0.5 m to its left.
    let scene = blind_scene(1.0, "[localizer]\nmethods = [\"range_landmarks\"]\n[[landmark]]\nx_m = 2.6\ny_m = 1.1\n")
        .replace("floor_camera = false", "floor_camera = false\nrange_camera = true")
        .replace("y_m = 0.6\n", "y_m = 0.6\ntolerance_m = 0\ntolerance_deg = 0\n")
        .replace("[[route.waypoint]]\nx_m = 2.4\ny_m = 1.2", "[[route.waypoint]]\nx_m = 0.6\ny_m = 0.6");
    fs::write(folder.join("scene.toml"), scene).unwrap();
    let (code, _, stderr) = outcome(&mut wherein(&folder, &["run", "scene.toml", "--frames", "every=2"]));
    assert_eq!(code, 0, "{stderr}");
    let run = folder.join("renders/scene/0");
    assert!(!run.join("image_00000.png").exists(), "a range camera takes no picture");
    let figure = image::open(run.join("figure_00002.png")).unwrap().into_rgb8();
    // In the figure that is drawn for a reading, the bird's-eye view of the surroundings is 720 px high and begins 84 px below the top and 20 px from
    // the left; 5.3 m ahead of the robot fill 88 % of its height.
    let pixels_per_m = 720.0 * 0.88 / 5.3;
    let at = |forward_m: f64, left_m: f64| {
        [20.0 + 480.0 - left_m * pixels_per_m, 84.0 + 720.0 * 0.88 - forward_m * pixels_per_m].map(|place| place as u32)
    };
    let [u, v] = at(2.0, 0.5);
    assert_eq!(figure.get_pixel(u, v).0, [0, 128, 92], "no green dot at {u}, {v}");
    // At 2 m a change of the disparity by one column is worth 0.1 m of depth, so that the figure shows the landmark's blue box before and behind the
    // green dot at its true place.
    let is_blue = |[u, v]: [u32; 2]| {
        let [red, _, blue] = figure.get_pixel(u, v).0;
        blue > red.saturating_add(20)
    };
    assert!(is_blue(at(2.03, 0.5)) && is_blue(at(1.97, 0.5)) && !is_blue(at(2.4, 0.5)) && !is_blue(at(2.0, -0.5)));
}

#[cfg(unix)]
#[test]
fn what_is_no_file_is_never_replaced_and_a_link_stays_a_link() {
    use std::os::unix::{fs::FileTypeExt, fs::symlink, net::UnixListener};

    let folder = folder("no_file");
    let (socket, file, link) = (folder.join("socket"), folder.join("file.txt"), folder.join("link.txt"));
    // A socket stands for a device: it exists, is no file, and cannot be written to.
    let _listener = UnixListener::bind(&socket).unwrap();
    assert!(write_whole(&socket, b"text").is_err());
    assert!(fs::metadata(&socket).unwrap().file_type().is_socket());
    fs::write(&file, "before").unwrap();
    symlink(&file, &link).unwrap();
    write_whole(&link, b"after").unwrap();
    assert!(fs::symlink_metadata(&link).unwrap().is_symlink());
    assert_eq!(fs::read_to_string(&file).unwrap(), "after");
    assert_eq!(fs::read_dir(&folder).unwrap().count(), 3, "nothing half-written is left");
}

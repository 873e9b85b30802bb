//! What a newcomer meets in the first hour: default exposures, coarse encoders, scenes whose methods have nothing to read.

use std::fs;

use localizer::reading::Camera;
use sim::{scene::Scene, world::Drawn};

use crate::{
    command::{blind_scene, folder, outcome, root, rounds, wherein},
    render_studio::judged,
};

fn scene(text: &str) -> Scene {
    Scene::parse(text, "scene.toml").unwrap_or_else(|error| panic!("failed to {error}"))
}

#[test]
fn the_tutorials_hall_reads_its_markers_by_the_default_exposure() {
    let page = fs::read_to_string(root().join("docs/src/ci.md")).unwrap();
    let hall = page.split("```toml\n").nth(1).and_then(|rest| rest.split("```").next()).unwrap();
    assert!(hall.contains("[robot.ceiling_camera]") && !hall.contains("exposure"), "{hall}");
    let (_, verdict) = judged(&scene(hall), 0);
    // Every marker in view is read, and the estimate is available for as much of the drive as tutorials have to show.
    assert!(verdict.metrics["markers_read_share"] > 0.99, "{:?}", verdict.metrics);
    assert!(verdict.availability.unwrap() > 0.95, "{:?}", verdict.availability);
    assert!(verdict.verdict.passed, "{:?}", verdict.verdict.failed);
}

#[test]
fn the_scene_of_the_readme_knows_where_it_is() {
    let readme = fs::read_to_string(root().join("README.md")).unwrap();
    let text = readme.split("```toml\n").nth(1).and_then(|rest| rest.split("```").next()).unwrap();
    let (_, verdict) = judged(&Scene { duration_s: rounds(8.0, 30.0), ..scene(text) }, 0);
    assert!(verdict.availability.unwrap() > 0.95, "{:?}", verdict.availability);
    assert!(verdict.verdict.passed, "{:?}", verdict.verdict.failed);
}

/// A robot with a track of 0.18 m, wheels of 33 mm and coarse encoders that rests for 5 s before it drives.
fn hobby(ticks_per_turn: u32, more: &str) -> Scene {
    scene(&format!(
        "duration_s = 8.0\n[room]\nwidth_m = 6.0\ndepth_m = 4.0\n[robot]\nfloor_camera = false\n\
         [robot.base]\ntrack_m = 0.18\nwheel_radius_m = 0.033\n[robot.encoders]\nticks_per_turn = {ticks_per_turn}\n{more}\
         [localizer]\nmethods = []\n[start]\nx_m = 2.0\ny_m = 2.0\n\
         [route]\nbegins_s = 5.0\nled = true\n[[route.waypoint]]\nx_m = 4.0\ny_m = 2.0\n"
    ))
}

#[test]
fn a_robot_at_rest_pays_for_a_coarse_encoders_tick_every_two_seconds_at_most() {
    // A tick is 2π·33 mm / 20 = 10.4 mm, and the pose is off by up to one tick forth and one back in each span that the encoders are counted over. In
    // 5 s there are at most three spans of 2 s. Slip and sideways slip double that at most. Without a gyroscope the robot may have turned to and fro
    // by 1.6 rad/s for 2 s, and the tick may count in any direction for each radian.
    let tick_m = 2.0 * std::f64::consts::PI * 0.033 / 20.0;
    for (more, turning_rad) in [("[robot.gyro]\n", 0.0), ("", 3.2)] {
        let (record, verdict) = judged(&hobby(20, more), 0);
        let contained = verdict.containment.as_ref().unwrap();
        assert_eq!(contained.contained, contained.checks);
        let width_m = |time_s: f64| {
            let estimate =
                record.estimates.iter().min_by(|a, b| (a.time_s - time_s).abs().total_cmp(&(b.time_s - time_s).abs()));
            estimate.unwrap().pose.hull()[0].width()
        };
        let grown_m = width_m(5.0) - width_m(0.0);
        assert!(grown_m < 3.0 * 2.0 * tick_m * (1.0 + turning_rad) * 2.0, "{more}: {grown_m} m");
    }
}

#[test]
fn a_hobby_robot_put_down_anywhere_finds_itself_and_drives_its_errands() {
    let text = fs::read_to_string(root().join("scenes/navigation/anywhere.toml")).unwrap();
    // All errands take two minutes; without `make test-long` only the search for the place is driven.
    let searches = |mut scene: Scene| {
        scene.duration_s = rounds(25.0, scene.duration_s);
        scene
    };
    for seed in 0..rounds(2, 20) {
        let (record, verdict) = judged(&searches(scene(&text)), seed);
        let contained = verdict.containment.as_ref().unwrap();
        assert_eq!(contained.contained, contained.checks, "seed {seed}: {contained:?}");
        assert!(!rounds(false, true) || verdict.verdict.passed, "seed {seed}: {:?}", verdict.verdict.failed);
        // The localizer begins with all of the flat and every heading, and is sure of its place within 20 s.
        let width_m = |at: usize| record.estimates[at].pose.hull()[0].width();
        assert!(width_m(0) > 7.0 && record.estimates[0].pose.hull()[2].width() > 6.25, "seed {seed}");
        let found = record.estimates.iter().find(|estimate| estimate.pose.hull()[0].width() < 0.2);
        assert!(found.is_some_and(|found| found.time_s < 20.0), "seed {seed}: {:?}", found.map(|found| found.time_s));
    }
    let starts = [0, 1].map(|seed| Drawn::draw(&scene(&text), seed).start);
    assert!((starts[0].x_m - starts[1].x_m).abs() > 0.1 || (starts[0].y_m - starts[1].y_m).abs() > 0.1, "{starts:?}");
    // Without errands the robot would have nowhere to go from wherever it is.
    let idle = text.split("[[errand]]").next().unwrap();
    let refused = Scene::parse(idle, "scene.toml").unwrap_err().to_string();
    assert!(refused.contains("`start.anywhere") && refused.contains("errands"), "{refused}");
}

#[test]
fn tiles_larger_than_the_view_are_located_by_one_joint_at_a_time() {
    let text = "duration_s = 20.0\n[room]\nwidth_m = 6.0\ndepth_m = 4.0\n[floor.tiles]\nedge_x_m = 1.0\nedge_y_m = 1.0\n\
                [start]\nx_m = 2.0\ny_m = 2.0\n[route]\nled = true\n[[route.waypoint]]\nx_m = 4.0\ny_m = 2.3\n\
                [[route.waypoint]]\nx_m = 2.0\ny_m = 1.2\n";
    let (record, verdict) = judged(&scene(text), 0);
    let contained = verdict.containment.as_ref().unwrap();
    assert_eq!(contained.contained, contained.checks);
    assert_eq!(verdict.methods["floor_tiles"].false_claims, 0);
    let claims =
        record.images.iter().filter(|image| image.camera == Some(Camera::Floor)).map(|image| image.claims.len());
    let counted: Vec<usize> = claims.collect();
    assert!(counted.iter().filter(|count| **count == 1).count() > 5, "{counted:?}");
}

/// A ceiling camera that sees a marker's dots, of 10 mm radius and 2.3 m above it, with a radius of 1.3 px.
const COARSE_CEILING_CAMERA: &str = "[localizer]\nmethods = [\"ceiling_markers\"]\n[robot.ceiling_camera]\nwidth_px = 320\nheight_px = 240\n\
                                     focal_px = [300.0, 300.0]\nprincipal_point_px = [159.5, 119.5]\n[[markers.marker]]\nid = 125\nx_m = 1.0\n\
                                     y_m = 1.0\n";

#[test]
fn a_scene_whose_methods_have_nothing_to_read_is_told_so() {
    let place = folder("nothing_to_read");
    for (name, more, part) in [
        ("none", "[localizer]\nmethods = []\n", "`localizer.methods = []`"),
        ("unfitted", "", "`floor_tiles` has nothing to read, expected `robot.floor_camera`"),
        (
            "coarse",
            COARSE_CEILING_CAMERA,
            "`robot.ceiling_camera.focal_px`: the dots of the markers have a radius of less than 1.5 px",
        ),
    ] {
        let file = format!("{name}.toml");
        fs::write(place.join(&file), blind_scene(0.5, more)).unwrap();
        let (code, _, stderr) = outcome(&mut wherein(&place, &["run", &file]));
        assert_eq!(code, 0, "{stderr}");
        assert!(stderr.contains(&format!("wherein: {file}: ")) && stderr.contains(part), "{stderr}");
    }
}

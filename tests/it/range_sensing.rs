//! The simulated range camera, gyroscope and people, compared with geometry worked out by hand.

use std::collections::BTreeMap;

use localizer::{
    Pose, Reading,
    reading::{LandmarkId, Sighting},
};
use sim::{
    devices::{Sensor, range_camera::RangeCameraSensor},
    place::Bystander,
    scene::Scene,
    truth::Truth,
    world::{Drawn, World},
};

use crate::world_setup::{command, gyro_sensor, nominal, range_sensor, scene};

/// Scene with a robot at (1, 3) that looks along world x with a range camera without errors: 500 px, two views 0.1 m apart, the first above the
/// axle.
fn watching(more: serde_json::Value) -> Scene {
    let mut camera = serde_json::json!({
        "focal_px": 500.0, "baseline_m": 0.1, "forward_m": 0.0, "left_m": 0.0, "height_m": 0.5,
        "focal_tolerance": 0.0, "baseline_tolerance": 0.0, "position_tolerance_m": 0.0, "yaw_tolerance_deg": 0.0,
        "tilt_tolerance_deg": 0.0, "column_step_px": 0.5, "match_step_px": 0.25,
    });
    for (key, value) in more["camera"].as_object().into_iter().flatten() {
        camera[key] = value.clone();
    }
    let mut keys = more;
    keys["robot"] = serde_json::json!({ "range_camera": camera });
    keys.as_object_mut().unwrap().remove("camera");
    scene(keys)
}

fn at(x_m: f64, y_m: f64, heading_rad: f64, time_s: f64) -> Truth {
    Truth { time_s, pose: Pose { x_m, y_m, heading_rad }, ..Truth::default() }
}

/// Sightings of the range camera from (1, 3) along world x.
fn seen(scene: &Scene, people: &[Bystander]) -> Vec<Sighting> {
    sightings(&mut camera(scene, 0), &at(1.0, 3.0, 0.0, 0.1), people)
}

fn camera(scene: &Scene, seed: u64) -> RangeCameraSensor {
    range_sensor(scene, seed)
}

fn sightings(camera: &mut RangeCameraSensor, truth: &Truth, people: &[Bystander]) -> Vec<Sighting> {
    match camera.observe(truth, people).unwrap().reading {
        Reading::Range { sightings, .. } => sightings,
        other => panic!("{other:?}"),
    }
}

fn codes(sightings: &[Sighting]) -> Vec<u32> {
    sightings.iter().map(|sighting| sighting.landmark.0).collect()
}

#[test]
fn columns_are_those_of_two_pinholes() {
    let scene = watching(serde_json::json!({ "landmark": [
        { "x_m": 3.0, "y_m": 3.0 }, { "x_m": 3.0, "y_m": 3.4 }, { "x_m": 5.0, "y_m": 2.5, "height_m": 0.9 },
    ] }));
    // Expected columns by hand: 319.5 is the middle of 640 columns, and right is −y. A landmark at 2 m: 0, and −0.1 m for the second view. At 2 m
    // and 0.4 m to the left: −100 and −125 px. At 4 m and 0.5 m to the right: 62.5 and 50 px. The columns are rounded to halves and quarters of a
    // pixel.
    let expected = [[319.5, 294.5], [219.5, 194.5], [382.0, 369.5]];
    let seen = seen(&scene, &[]);
    assert_eq!(codes(&seen), [0, 1, 2]);
    for (sighting, [left_px, right_px]) in seen.iter().zip(expected) {
        assert!(
            (sighting.left_px - left_px).abs() < 1e-9 && (sighting.right_px - right_px).abs() < 1e-9,
            "{sighting:?}"
        );
    }
    // At 2 m a pixel is 4 mm wide: a landmark 3 mm to the side shifts both views by 0.75 px; the left view's column is then rounded to the steps of
    // that view, the right view's column to finer ones.
    let scene = watching(serde_json::json!({ "landmark": [{ "x_m": 3.0, "y_m": 3.003 }] }));
    let moved = &self::seen(&scene, &[])[0];
    assert_eq!([moved.left_px, moved.right_px], [319.0, 293.75]);
}

#[test]
fn a_turned_robot_and_a_turned_mount_see_to_their_side() {
    // A heading of 90° and a mount turned by −90° make the camera look along x again; the lens is 0.2 m ahead of the axle, hence at y = 3.2.
    let camera_keys = serde_json::json!({ "yaw_deg": -90.0, "forward_m": 0.2 });
    let scene = watching(serde_json::json!({ "camera": camera_keys, "landmark": [{ "x_m": 3.0, "y_m": 3.2 }] }));
    let seen = sightings(&mut camera(&scene, 0), &at(1.0, 3.0, std::f64::consts::FRAC_PI_2, 0.1), &[]);
    assert!((seen[0].left_px - 319.5).abs() < 1e-9 && (seen[0].right_px - 294.5).abs() < 1e-9, "{seen:?}");
}

#[test]
fn what_one_of_the_views_does_not_see_is_not_measured() {
    let keys = |x_m: f64, y_m: f64| serde_json::json!({ "landmark": [{ "x_m": x_m, "y_m": y_m }] });
    let is_seen = |x_m: f64, y_m: f64| !seen(&watching(keys(x_m, y_m)), &[]).is_empty();
    // Landmarks are seen only at the range camera's distances, from 0.5 m to 5 m; the camera is at x = 1.
    assert!(!is_seen(1.45, 3.0) && is_seen(1.55, 3.0) && is_seen(5.95, 3.0) && !is_seen(6.05, 3.0));
    assert!(!is_seen(0.2, 3.0), "seen behind the robot");
    // Both views of the range camera must see a landmark. At 2 m the image reaches 320 px = 1.28 m to each side; the right view misses the last 0.1 m
    // on the left.
    assert!(is_seen(3.0, 4.17) && !is_seen(3.0, 4.19) && is_seen(3.0, 1.73) && !is_seen(3.0, 1.71));
}

#[test]
fn furniture_hides_what_is_behind_it_and_not_what_is_above_or_on_it() {
    let is_seen = |piece: serde_json::Value, height_m: f64| {
        let landmark = serde_json::json!([{ "x_m": 4.0, "y_m": 3.0, "height_m": height_m }]);
        !seen(&watching(serde_json::json!({ "furniture": [piece], "landmark": landmark })), &[]).is_empty()
    };
    let piece = |y_m: f64, height_m: f64, rotation_deg: f64| serde_json::json!({ "x_m": 2.5, "y_m": y_m, "size_m": [1.0, 0.2], "height_m": height_m, "rotation_deg": rotation_deg });
    assert!(!is_seen(piece(3.0, 1.0, 0.0), 0.5));
    // The near side of this piece of furniture is at y = 3.12. It hides nothing, because the camera's two views look from y = 3 and y = 2.9 at a
    // landmark at y = 3.
    assert!(is_seen(piece(3.22, 1.0, 0.0), 0.5));
    // This piece of furniture, 1 m long, is turned by 90°, so that it lies across the lines of sight from the camera to the landmark and hides it.
    assert!(!is_seen(piece(3.4, 1.0, 90.0), 0.5));
    // The landmark is 0.9 m high, and a board stands between it and the camera, 1 m to 2 m away. The line of sight is 0.63 m high at the board's near
    // edge: a board of 0.6 m lies below it, one of 0.7 m hides the landmark.
    assert!(is_seen(piece(3.0, 0.6, 0.0), 0.9) && !is_seen(piece(3.0, 0.7, 0.0), 0.9));
    // A landmark on a wall's face towards the camera is not hidden by the wall that it is stuck to.
    let wall = serde_json::json!({ "x_m": 4.1, "y_m": 3.0, "size_m": [0.2, 1.0], "height_m": 1.0 });
    assert!(is_seen(wall, 0.5));
}

#[test]
fn a_person_hides_what_is_behind() {
    let scene = watching(serde_json::json!({ "landmark": [{ "x_m": 4.0, "y_m": 3.0 }] }));
    let person = |y_m: f64, height_m: f64| Bystander {
        place_m: [2.5, y_m],
        radius_m: 0.25,
        height_m,
        heading_rad: 0.0,
        walked_m: 0.0,
        velocity_m_per_s: [0.0; 2],
    };
    assert!(seen(&scene, &[person(3.1, 1.7)]).is_empty());
    assert!(!seen(&scene, &[person(3.26, 1.7)]).is_empty());
    assert!(seen(&scene, &[person(2.75, 1.7)]).is_empty(), "only the second view is blocked");
    assert!(!seen(&scene, &[person(3.1, 0.45)]).is_empty(), "a child below the way hides nothing");
}

#[test]
fn codes_are_confused_as_often_as_stated_and_never_beyond_the_bounds() {
    let landmarks: Vec<_> = (0..12)
        .map(|index| serde_json::json!({ "x_m": 3.0 + 0.2 * f64::from(index), "y_m": 2.5 + 0.08 * f64::from(index) }))
        .collect();
    let camera_keys = serde_json::json!({ "wrong_share": 0.05, "wrong_items_max": 2, "wrong_spacing": 4 });
    let scene = watching(serde_json::json!({ "camera": camera_keys, "landmark": landmarks }));
    let mut camera = camera(&scene, 3);
    let (mut n_wrong, mut n_all) = (0, 0);
    let mut right_since: BTreeMap<LandmarkId, usize> = BTreeMap::new();
    for reading in 0..4000 {
        let sightings = sightings(&mut camera, &at(1.0, 3.0, 0.0, 0.1 + 0.2 * f64::from(reading)), &[]);
        assert_eq!(sightings.len(), 12);
        let mut n_here = 0;
        // The sightings of a reading come in the order of the landmarks that were truly seen, so that a wrong code shows as a difference from that
        // order.
        for (sighting, truly) in sightings.iter().zip(0..) {
            if sighting.landmark.0 == truly {
                right_since.entry(sighting.landmark).and_modify(|count| *count += 1);
            } else {
                n_here += 1;
                let since = right_since.insert(sighting.landmark, 0);
                assert!(since.is_none_or(|count| count >= 4), "{since:?} right uses between two wrong ones");
            }
        }
        assert!(n_here <= 2);
        n_wrong += n_here;
        n_all += 12;
    }
    // The scene demands that 5 % of the sightings get a wrong code, and the declared bounds allow nearly all of them. The standard deviation of the
    // share is 0.1 %.
    let share = f64::from(n_wrong) / f64::from(n_all);
    assert!((0.035..0.052).contains(&share), "{share}");
}

#[test]
fn a_gyroscope_reads_scale_times_turn_plus_bias_plus_bounded_noise() {
    let keys = serde_json::json!({ "robot": { "gyro": {
        "bias_tolerance_deg_per_s": 0.5, "scale_tolerance": 0.01, "noise_deg_per_s": 0.3, "period_s": 0.01,
    } } });
    let scene = scene(keys);
    let drawn = Drawn::draw(&scene, 5);
    let truly = drawn.devices.gyro.unwrap();
    let mut gyro = gyro_sensor(&scene, 5, &drawn);
    let (mut rates, mut odd) = (Vec::new(), 0);
    for step in 0..=40_000 {
        let time_s = f64::from(step) * 0.001;
        let observed = gyro.observe(&at(1.0, 3.0, 0.8 * time_s, time_s), &[]);
        if let Some(Reading::Gyro { rate_rad_per_s, measured_s, .. }) = observed.map(|observed| observed.reading) {
            rates.push(rate_rad_per_s);
            odd += usize::from((measured_s * 100.0 - (measured_s * 100.0).round()).abs() > 1e-6);
        }
    }
    assert_eq!((rates.len(), odd), (4000, 0));
    let expected = truly.scale * 0.8 + truly.bias_rad_per_s;
    let noise = |rate: &f64| (rate - expected).to_degrees();
    let mean = rates.iter().map(noise).sum::<f64>() / 4000.0;
    let deviation = (rates.iter().map(|rate| noise(rate).powi(2)).sum::<f64>() / 4000.0).sqrt();
    assert!(rates.iter().all(|rate| noise(rate).abs() <= 0.3 + 1e-9));
    // The noise of the gyroscope is normal with a standard deviation of 0.1 °/s, cut at three deviations, which leaves a deviation of 0.0987 °/s. The
    // mean of 4000 readings is within 0.005 °/s of the expected rate.
    assert!(mean.abs() < 0.006 && (deviation - 0.0987).abs() < 0.004, "{mean} ± {deviation} °/s");
}

/// Places of the scene's only person at every tenth of a second while the robot stands still.
fn walk(scene: &Scene, lasts_s: f64) -> Vec<[f64; 2]> {
    let mut world = World::new(scene, &nominal(scene));
    let mut places = vec![world.people()[0].place_m];
    for step in 1..=(lasts_s * 1000.0) as usize {
        world.step(command(0.0, 0.0));
        if step.is_multiple_of(100) {
            places.push(world.people()[0].place_m);
        }
    }
    places
}

#[test]
fn a_person_walks_to_and_fro_at_the_stated_speed() {
    let person = serde_json::json!({ "waypoints_m": [[5.0, 1.0], [5.0, 3.0], [6.0, 3.0]], "speed_m_per_s": 0.5 });
    let places = walk(&scene(serde_json::json!({ "person": [person] })), 13.0);
    let near = |time_s: f64, place: [f64; 2]| {
        let at = places[(time_s * 10.0) as usize];
        assert!((at[0] - place[0]).hypot(at[1] - place[1]) < 0.02, "at {at:?} after {time_s} s, expected {place:?}");
    };
    // The person walks 3 m in 6 s, and then 3 m back.
    for (time_s, place) in [
        (0.0, [5.0, 1.0]),
        (2.0, [5.0, 2.0]),
        (5.0, [5.5, 3.0]),
        (6.0, [6.0, 3.0]),
        (7.0, [5.5, 3.0]),
        (12.0, [5.0, 1.0]),
    ] {
        near(time_s, place);
    }
}

#[test]
fn a_person_stands_while_the_robot_is_in_the_way() {
    // The robot stands at (1.5, 3). A person who walks from (1.5, 5) to (1.5, 1) stops before reaching the robot and stays there.
    let person = serde_json::json!({ "waypoints_m": [[1.5, 5.0], [1.5, 1.0]], "speed_m_per_s": 1.0 });
    let places = walk(&scene(serde_json::json!({ "person": [person] })), 20.0);
    let nearest_m = places.iter().map(|place| place[1] - 3.0).fold(f64::INFINITY, f64::min);
    assert!((0.5..1.9).contains(&nearest_m), "{nearest_m} m");
    assert_eq!(places[100], places[200]);
}

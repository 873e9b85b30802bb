//! Scenes under the open sky: light and shadows against geometry worked out by hand, and scenes that are refused.

use image::GrayImage;
use localizer::{Pose, reading::Camera};
use nalgebra::{Point3, Vector3};
use sim::{
    place::{
        building::Building,
        light::{Lighting, bake},
    },
    run::sensors::still::take,
    scene::{Scene, SceneError},
    world::Drawn,
};

use crate::render_studio::renderer;

/// A yard of 40 m by 30 m between low walls, at noon of the equinox at 45° north: the sun is 45° high and stands against world x, as north is along
/// it.
fn yard(more: &str) -> Scene {
    let text = format!(
        "duration_s = 1.0
        room = {{ width_m = 40.0, depth_m = 30.0 }}
        start = {{ x_m = 16.0, y_m = 11.0, heading_deg = 90.0 }}
        route.waypoint = [{{ x_m = 16.0, y_m = 11.5 }}]
        outdoors = {{ latitude_deg = 45.0, day_of_year = 81, solar_hour = 12.0, north_deg = 0.0 }}
        localizer.methods = []
        [building]\nceiling_height_m = 1.6\nwall_albedo = 0.0\nskirting_albedo = 0.0\n
        [robot]\nfloor_camera = false
        [robot.forward_camera]\nforward_m = 0.0\nheight_m = 1.0\ntilt_up_deg = -10.0
        sensor.preset = \"global_shutter\"
        lens.vignetting = false
        [robot.forward_camera.calibration]\nposition_tolerance_m = 0.0\nangle_tolerance_deg = 0.0
        focal_tolerance = 0.0\nprincipal_point_tolerance_px = 0.0
        {more}"
    );
    Scene::parse(&text, "yard.toml").unwrap_or_else(|error| panic!("failed to {error}"))
}

const POST: &str = "[[furniture]]\nname = \"post\"\nx_m = 15.0\ny_m = 15.0\nsize_m = [0.2, 0.2]\nheight_m = 1.0\n";

fn picture(scene: &Scene, pose: Pose) -> GrayImage {
    let drawn = Drawn::draw(scene, 0);
    let mut renderer = renderer();
    let world = renderer.upload_room(scene, &drawn).unwrap();
    let lux = world.illuminance_at_floor_lux().unwrap();
    take(&mut renderer, &world, scene, &drawn, pose, lux, (&[Camera::Forward], 0)).unwrap().remove(0).image
}

/// Where the camera of [`yard`], 1 m above the ground at `pose` with a heading of 90°, sees a point of the ground.
fn seen(pose: Pose, [x_m, y_m]: [f64; 2]) -> [f64; 2] {
    let focal_px = 320.0 / 37.5_f64.to_radians().tan();
    let (sin, cos) = (-10.0_f64).to_radians().sin_cos();
    let [right_m, ahead_m, up_m] = [x_m - pose.x_m, y_m - pose.y_m, -1.0];
    let depth_m = ahead_m * cos + up_m * sin;
    let down_m = ahead_m * sin - up_m * cos;
    [319.5 + focal_px * right_m / depth_m, 239.5 + focal_px * down_m / depth_m]
}

/// Mean level of three rows around `row`, between two columns.
fn level(image: &GrayImage, columns: std::ops::Range<u32>, row: u32) -> f64 {
    let all: Vec<f64> = columns
        .flat_map(|column| (row - 1..=row + 1).map(move |row| (column, row)))
        .map(|(column, row)| f64::from(image.get_pixel(column, row).0[0]))
        .collect();
    all.iter().sum::<f64>() / all.len() as f64
}

#[test]
fn the_shadow_of_a_post_ends_where_the_height_of_the_sun_puts_it() {
    let pose = Pose { x_m: 16.0, y_m: 11.0, heading_rad: std::f64::consts::FRAC_PI_2 };
    let image = picture(&yard(POST), pose);
    // The shadow of the post's far upper edge, at x = 15.1 m, is its height over the tangent of 45° farther: at 16.1 m.
    let [column, row] = seen(pose, [16.1, 15.0]);
    let row = row.round() as u32;
    let at = |column: f64| column.round() as u32;
    let shade = level(&image, at(column) - 30..at(column) - 10, row);
    let light = level(&image, at(column) + 10..at(column) + 30, row);
    assert!(light > 2.0 * shade, "{light} {shade}");
    let middle = 0.5 * (light + shade);
    let found = (at(column) - 10..at(column) + 10).find(|column| level(&image, *column..*column + 1, row) > middle);
    let found = found.expect("no edge of the shadow") as f64;
    assert!((found - column).abs() < 2.0, "found at {found}, expected at {column}");
    // On a level surface there is direct·sin 45° + diffuse in the sun and the diffuse light in the shadow; the post takes a little of it.
    let sun_and_sky = yard("").outdoors.map(|outdoors| {
        let sun_lux = outdoors.direct_normal_lux() * 45.0_f64.to_radians().sin();
        (sun_lux + outdoors.diffuse_horizontal_lux()) / outdoors.diffuse_horizontal_lux()
    });
    let ratio = light / shade;
    assert!((ratio / sun_and_sky.unwrap() - 1.0).abs() < 0.1, "{ratio} {sun_and_sky:?}");
}

#[test]
fn a_level_plane_in_the_open_has_direct_light_by_the_sine_of_the_elevation_and_the_skys() {
    let scene = yard("");
    let outdoors = scene.outdoors.clone().unwrap();
    let building = Building::new(&scene, &Drawn::draw(&scene, 0).place);
    let (lighting, map) = bake(&scene, &building);
    let expected_lux = outdoors.direct_normal_lux() * 0.5_f64.sqrt() + outdoors.diffuse_horizontal_lux();
    let lux = lighting.at(Point3::new(20.0, 15.0, 0.0), Vector3::z(), 0, 1).lux;
    assert!((lux / expected_lux - 1.0).abs() < 0.02, "{lux} {expected_lux}");
    // The shadow of the wall of 1.6 m is as long, which is a twenty-fifth of the yard's 40 m.
    let mean_lux = expected_lux - outdoors.direct_normal_lux() * 0.5_f64.sqrt() / 25.0;
    let mean = map.mean_at_floor.lux;
    assert!((mean / mean_lux - 1.0).abs() < 0.03, "{mean} {mean_lux}");
    assert_eq!(lighting.dimming, 1.0);
}

#[test]
fn a_wall_that_faces_away_from_the_sun_has_the_light_of_sky_and_ground_alone() {
    let scene = yard("");
    let outdoors = scene.outdoors.clone().unwrap();
    let building = Building::new(&scene, &Drawn::draw(&scene, 0).place);
    let direct = Lighting::direct(&scene, &building);
    let (sunny, away) = (Point3::new(40.0, 15.0, 1.0), Point3::new(0.0, 15.0, 1.0));
    let sun_lux = direct.direct_at(sunny, -Vector3::x(), 1).lux - direct.direct_at(away, Vector3::x(), 1).lux;
    assert!((sun_lux / (outdoors.direct_normal_lux() * 0.5_f64.sqrt()) - 1.0).abs() < 0.01, "{sun_lux}");
    let sky_lux = direct.direct_at(away, Vector3::x(), 1).lux;
    assert!((sky_lux / (0.5 * outdoors.diffuse_horizontal_lux()) - 1.0).abs() < 0.05, "{sky_lux}");
}

#[test]
fn the_sky_is_as_bright_as_its_light_on_the_ground_says() {
    let pose = Pose { x_m: 16.0, y_m: 11.0, heading_rad: std::f64::consts::FRAC_PI_2 };
    // Under clouds a ground of albedo 0.4 has 0.4 of the luminance of an even sky.
    let mut scene = yard("");
    scene.outdoors.as_mut().unwrap().sky = sim::scene::Sky::Overcast;
    let image = picture(&scene, pose);
    let ratio = level(&image, 300..340, 470) / level(&image, 300..340, 10);
    assert!((ratio - 0.4).abs() < 0.03, "{ratio}");
}

#[test]
fn the_same_scene_outdoors_gives_the_same_bytes() {
    let more =
        "[[building.facade]]\nfrom_m = [0.0, 30.0]\nto_m = [40.0, 30.0]\nnumber = 4\n[floor]\ncovering = \"asphalt\"\n";
    let pose = Pose { x_m: 16.0, y_m: 22.0, heading_rad: std::f64::consts::FRAC_PI_2 };
    assert_eq!(picture(&yard(more), pose), picture(&yard(more), pose));
}

#[test]
fn what_does_not_go_under_the_sky_is_refused_by_key_and_value() {
    let refused = |more: &str, from: &str, to: &str| -> String {
        let text = format!(
            "room = {{ width_m = 8.0, depth_m = 6.0 }}\nstart = {{ x_m = 2.0, y_m = 2.0 }}
            route.waypoint = [{{ x_m = 3.0, y_m = 2.0 }}]\nlocalizer.methods = []
            [outdoors]\nsolar_hour = 10.0\n[robot]\nfloor_camera = false\n{more}"
        );
        match Scene::parse(&text.replace(from, to), "night.toml") {
            Err(error @ SceneError::Invalid { .. }) => error.to_string(),
            other => panic!("{other:?}"),
        }
    };
    let night = refused("", "solar_hour = 10.0", "solar_hour = 23.0");
    for part in ["night.toml", "outdoors.solar_hour", "23.0", "below the horizon"] {
        assert!(night.contains(part), "{night}");
    }
    let lamp = "[[lamp]]\nkind = \"panel\"\nx_m = 2.0\ny_m = 2.0\n";
    for (more, from, to, key) in [
        (lamp, "", "", "lamp"),
        ("", "floor_camera = false", "floor_camera = true", "robot.floor_camera"),
        ("", "floor_camera = false", "floor_camera = false\nceiling_camera = true", "robot.ceiling_camera"),
        ("[[building.facade]]\nfrom_m = [2.0, 2.0]\nto_m = [4.0, 0.0]\n", "", "", "building.facade[0].from_m"),
    ] {
        let message = refused(more, if from.is_empty() { "\u{0}" } else { from }, to);
        assert!(message.contains(key), "{key}: {message}");
    }
}

//! Pictures of a room compared with pictures that a person has approved; `make golden` takes the approved pictures anew.

use std::{env, fs};

use image::GrayImage;
use localizer::{Pose, reading::Camera};
use sim::{loading::SceneFile, run::sensors::still::take, world::Drawn};

use crate::{command::root, render_studio::renderer};

/// Tolerances for comparing a rendered image with the approved one. Graphics drivers differ in the last bits of luminance, which now and then changes
/// a count of photons by one: a hundredth of the pixels may be off by more than two grey levels, and the mean of an image by no more than a tenth of
/// a level.
const SHARE_OFF: f64 = 0.01;
const LEVELS_OFF: i32 = 2;
const MEAN_OFF: f64 = 0.1;

#[test]
fn rooms_look_as_they_did_when_somebody_looked() {
    let folder = root().join("tests/golden");
    for (name, pose, lux) in [
        ("living_room", Pose { x_m: 0.8, y_m: 0.9, heading_rad: 0.5 }, 100.0),
        ("living_room", Pose { x_m: 0.8, y_m: 0.9, heading_rad: 0.5 }, 0.1),
        ("hall", Pose { x_m: 2.0, y_m: 3.9, heading_rad: 0.0 }, 250.0),
    ] {
        let file = SceneFile::load_all(&[root().join(format!("scenes/rooms/{name}.toml"))]).unwrap().remove(0);
        let mut scene = file.scene;
        // Images of a quarter of the size keep the repository small.
        let forward = scene.robot.forward_camera.as_mut().unwrap();
        (forward.width_px, forward.height_px) = (160, 120);
        let ceiling = scene.robot.ceiling_camera.as_mut().unwrap();
        (ceiling.width_px, ceiling.height_px) = (160, 120);
        ceiling.focal_px = [188.0, 188.0];
        ceiling.principal_point_px = [79.5, 59.5];
        // By its own exposure this camera sees the markers alone; the pictures are to show the ceiling as well.
        ceiling.sensor.highlight_share = Some(0.005);
        let drawn = Drawn::draw(&scene, 0);
        let mut renderer = renderer();
        let world = renderer.upload_room(&scene, &drawn).unwrap();
        let cameras = [Camera::Forward, Camera::Ceiling];
        let stills = take(&mut renderer, &world, &scene, &drawn, pose, lux, (&cameras, 0)).unwrap();
        for still in stills {
            let path = folder.join(format!("{name}_{lux}_lx_{}.png", still.camera.as_str()));
            if env::var_os("WHEREIN_GOLDEN").is_some() {
                fs::create_dir_all(&folder).unwrap();
                still.image.save(&path).unwrap();
            }
            let golden = image::open(&path).unwrap().into_luma8();
            let (share, mean) = differences(&still.image, &golden);
            assert!(share <= SHARE_OFF && mean.abs() <= MEAN_OFF, "{}: {share}, {mean}", path.display());
        }
    }
}

/// Share of the pixels that differ by more than the tolerance, and the difference of the mean grey levels.
fn differences(image: &GrayImage, golden: &GrayImage) -> (f64, f64) {
    assert_eq!(image.dimensions(), golden.dimensions());
    let pairs = image.as_raw().iter().zip(golden.as_raw());
    let by: Vec<i32> = pairs.map(|(level, golden)| i32::from(*level) - i32::from(*golden)).collect();
    let off = by.iter().filter(|levels| levels.abs() > LEVELS_OFF).count();
    (off as f64 / by.len() as f64, f64::from(by.iter().sum::<i32>()) / by.len() as f64)
}

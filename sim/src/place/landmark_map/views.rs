//! The pictures of a map's file: cameras and poses of the drives that taught it, and where the pictures show landmarks.

use interval::Interval;
use localizer::{
    PoseBox,
    map::{ViewCamera, ViewPicture, ViewSight, Views},
    reading::LandmarkId,
};
use nalgebra::{Isometry3, Quaternion, Translation3, UnitQuaternion};
use serde::{Deserialize, Serialize};

use crate::scene::TrueEye;

use super::{FARTHEST_M, File, VERSION_WITHOUT_VIEWS, interval, written};

/// Greatest coordinate of an image point: far beyond any picture.
const FARTHEST_PX: f64 = 1e5;

/// The camera of a drive, as it is written.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct CameraEntry {
    focal_px: [f64; 2],
    centre_px: [[f64; 2]; 2],
    tilt_up_rad: f64,
    yaw_rad: [f64; 2],
    tilt_rad: f64,
    position_m: [[f64; 2]; 2],
    height_m: [f64; 2],
    body_tilt_rad: f64,
    heave_m: f64,
}

/// A picture, as it is written.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct PictureEntry {
    stamp_s: f64,
    /// Place of the camera among those of the file, from 0 on.
    camera: usize,
    x_m: [f64; 2],
    y_m: [f64; 2],
    heading_rad: [f64; 2],
    /// Earlier pictures, each with the least and the greatest turn since.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    turned_since: Vec<(usize, f64, f64)>,
    /// The camera that truly took the picture in the simulator, for its judge.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    truly: Option<TrueEntry>,
}

/// The camera that truly took a picture, as it is written.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct TrueEntry {
    at_m: [f64; 3],
    /// Quaternion of the rotation from the camera to the world: i, j, k and w.
    turned: [f64; 4],
    focal_px: f64,
    centre_px: [f64; 2],
}

/// Where a picture shows a landmark, as it is written: the picture, column and row, and the greatest errors of both.
pub(super) type SightEntry = (usize, f64, f64, f64, f64);

/// The cameras of a map.
pub(super) fn cameras(views: &Views) -> Vec<CameraEntry> {
    let entry = |camera: &ViewCamera| CameraEntry {
        focal_px: written(camera.focal_px),
        centre_px: camera.centre_px.map(written),
        tilt_up_rad: camera.tilt_up_rad,
        yaw_rad: written(camera.yaw_rad),
        tilt_rad: camera.tilt_rad,
        position_m: camera.position_m.map(written),
        height_m: written(camera.height_m),
        body_tilt_rad: camera.body_tilt_rad,
        heave_m: camera.heave_m,
    };
    views.cameras.iter().map(entry).collect()
}

/// The pictures of a map, with the cameras that truly took them.
pub(super) fn pictures(views: &Views, true_eyes: &[TrueEye]) -> Vec<PictureEntry> {
    let entry = |(at, picture): (usize, &ViewPicture)| {
        let [x_m, y_m, heading_rad] = [0, 1, 2].map(|axis| written(picture.pose[axis]));
        let truly = true_eyes.get(at).map(|eye| TrueEntry {
            at_m: eye.world_from_camera.translation.vector.into(),
            turned: eye.world_from_camera.rotation.coords.into(),
            focal_px: eye.focal_px,
            centre_px: eye.centre_px,
        });
        let turn = |&(since, turn): &(usize, Interval)| {
            let [least_rad, greatest_rad] = written(turn);
            (since, least_rad, greatest_rad)
        };
        let (stamp_s, camera) = (picture.stamp_s, picture.camera);
        let turned_since = picture.turned_since.iter().map(turn).collect();
        PictureEntry { stamp_s, camera, x_m, y_m, heading_rad, turned_since, truly }
    };
    views.pictures.iter().enumerate().map(entry).collect()
}

/// Where the pictures of a map show a landmark.
pub(super) fn sights(views: &Views, landmark: LandmarkId) -> Vec<SightEntry> {
    let first = views.sights.partition_point(|(of, _)| *of < landmark);
    let own = views.sights[first..].iter().take_while(|(of, _)| *of == landmark);
    // Places are rounded to a millionth of a pixel, and errors up by as much.
    let rounded = |px: f64| (px * 1e6).round() / 1e6;
    let wider = |px: f64| (px * 1e6 + 1.0).ceil() / 1e6;
    own.map(|(_, sight)| {
        let ([u_px, v_px], [error_u_px, error_v_px]) = (sight.at_px.map(rounded), sight.error_px.map(wider));
        (sight.picture, u_px, v_px, error_u_px, error_v_px)
    })
    .collect()
}

/// The views of a file, with the cameras that truly took the pictures, or what was expected instead.
pub(super) fn read(file: &File) -> Result<(Views, Vec<TrueEye>), String> {
    let has_views = !file.cameras.is_empty() || file.landmarks.iter().any(|entry| !entry.seen_in.is_empty());
    if has_views && file.version <= VERSION_WITHOUT_VIEWS {
        return Err(format!("`cameras` are not possible in version {}, expected none", file.version));
    }
    let mut views = Views::default();
    for (index, entry) in file.cameras.iter().enumerate() {
        let camera = camera_of(entry);
        views.cameras.push(
            camera
                .map_err(|(key, expected)| format!("`cameras[{index}].{key}` is not possible, expected {expected}"))?,
        );
    }
    for (index, entry) in file.pictures.iter().enumerate() {
        let picture = picture_of(entry, index, file.cameras.len());
        views
            .pictures
            .push(picture.map_err(|(key, expected)| {
                format!("`pictures[{index}].{key}` is not possible, expected {expected}")
            })?);
    }
    for (index, entry) in file.landmarks.iter().enumerate() {
        let mut before = None;
        for (at, &(picture, u_px, v_px, error_u_px, error_v_px)) in entry.seen_in.iter().enumerate() {
            let (at_px, error_px) = ([u_px, v_px], [error_u_px, error_v_px]);
            let is_place = at_px.iter().all(|px| px.abs() <= FARTHEST_PX);
            let is_error = error_px.iter().all(|px| (0.0..=FARTHEST_PX).contains(px));
            if picture >= file.pictures.len() || before >= Some(picture) || !is_place || !is_error {
                return Err(format!(
                    "`landmarks[{index}].seen_in[{at}]` is not possible, expected a later picture below {}, column and row, and \
                     the greatest error of both from 0 on",
                    file.pictures.len()
                ));
            }
            before = Some(picture);
            views.sights.push((LandmarkId(entry.number), ViewSight { picture, at_px, error_px }));
        }
    }
    let eyes: Option<Vec<TrueEye>> = file.pictures.iter().map(|entry| entry.truly.as_ref().map(eye_of)).collect();
    // Without all of them the judge goes by the boxes of landmarks alone.
    Ok((views, eyes.unwrap_or_default()))
}

type Wrong = (&'static str, String);

/// The interval of a key.
fn pair(key: &'static str, ends: [f64; 2]) -> Result<Interval, Wrong> {
    let fits = |value: &Interval| value.magnitude() <= FARTHEST_M;
    let expected = || (key, "a pair of numbers from -1e6 to 1e6, the lesser first".to_owned());
    interval(ends).filter(fits).ok_or_else(expected)
}

fn camera_of(entry: &CameraEntry) -> Result<ViewCamera, Wrong> {
    let error =
        |key, value: f64| (0.0..=1.0).contains(&value).then_some(value).ok_or((key, "a number from 0 to 1".to_owned()));
    let focal_px = pair("focal_px", entry.focal_px)?;
    if focal_px.lo() <= 0.0 {
        return Err(("focal_px", "numbers greater than 0".to_owned()));
    }
    if entry.tilt_up_rad.abs() > std::f64::consts::FRAC_PI_2 {
        return Err(("tilt_up_rad", "a number from -1.6 to 1.6".to_owned()));
    }
    let [[u, v], [forward, left]] = [("centre_px", entry.centre_px), ("position_m", entry.position_m)]
        .map(|(key, pairs)| pairs.map(|ends| pair(key, ends)));
    Ok(ViewCamera {
        focal_px,
        centre_px: [u?, v?],
        tilt_up_rad: entry.tilt_up_rad,
        yaw_rad: pair("yaw_rad", entry.yaw_rad)?,
        tilt_rad: error("tilt_rad", entry.tilt_rad)?,
        position_m: [forward?, left?],
        height_m: pair("height_m", entry.height_m)?,
        body_tilt_rad: error("body_tilt_rad", entry.body_tilt_rad)?,
        heave_m: error("heave_m", entry.heave_m)?,
    })
}

fn picture_of(entry: &PictureEntry, index: usize, n_cameras: usize) -> Result<ViewPicture, Wrong> {
    if entry.camera >= n_cameras {
        return Err(("camera", format!("a number below {n_cameras}")));
    }
    let pose =
        PoseBox::from([pair("x_m", entry.x_m)?, pair("y_m", entry.y_m)?, pair("heading_rad", entry.heading_rad)?]);
    let turn = |&(since, least_rad, greatest_rad): &(usize, f64, f64)| {
        let turn = interval([least_rad, greatest_rad]).filter(|_| since < index);
        turn.map(|turn| (since, turn))
            .ok_or(("turned_since", "earlier pictures, each with the least and the greatest turn".to_owned()))
    };
    let turned_since = entry.turned_since.iter().map(turn).collect::<Result<_, Wrong>>()?;
    Ok(ViewPicture { stamp_s: entry.stamp_s, camera: entry.camera, pose, turned_since })
}

fn eye_of(entry: &TrueEntry) -> TrueEye {
    let rotation = UnitQuaternion::from_quaternion(Quaternion::from(entry.turned));
    let world_from_camera = Isometry3::from_parts(Translation3::from(entry.at_m), rotation);
    TrueEye { world_from_camera, focal_px: entry.focal_px, centre_px: entry.centre_px }
}

//! What a picture of the drive that taught the map says of a landmark that is seen again.

use std::collections::BTreeMap;

use crate::{
    PoseBox,
    map::{ViewCamera, ViewSight, Views},
    reading::LandmarkId,
    robot::BodyModel,
};

use super::{
    PointCameraModel,
    ray::Optics,
    relate::{Sight, View},
};

/// Share of the greatest number of sightings that a picture of the teaching drive shows, too, from which on it shows enough of them: the nearest such
/// picture is taken.
const MANY: f64 = 0.6;
/// Distance, in metres, that counts as much as a radian of turn where the nearest picture is searched.
const METRES_PER_RADIAN: f64 = 1.0;

/// The camera and the body of a drive that taught a map.
pub(super) fn optics(camera: &ViewCamera) -> Optics {
    let pinhole = PointCameraModel {
        focal_px: camera.focal_px,
        centre_px: camera.centre_px,
        tilt_up_rad: camera.tilt_up_rad,
        yaw_rad: camera.yaw_rad,
        tilt_rad: camera.tilt_rad,
        position_m: camera.position_m,
        height_m: camera.height_m,
        error_px: 0.0,
        least_depth_m: 0.0,
        stamp_error_s: 0.0,
    };
    let body = BodyModel { tilt_rad: camera.body_tilt_rad, heave_m: camera.heave_m, clearance_m: 0.0 };
    Optics::new(pinhole, body)
}

/// The camera and the body as a map keeps them.
pub(super) fn kept(optics: &Optics) -> ViewCamera {
    let (camera, body) = (&optics.camera, &optics.body);
    ViewCamera {
        focal_px: camera.focal_px,
        centre_px: camera.centre_px,
        tilt_up_rad: camera.tilt_up_rad,
        yaw_rad: camera.yaw_rad,
        tilt_rad: camera.tilt_rad,
        position_m: camera.position_m,
        height_m: camera.height_m,
        body_tilt_rad: body.tilt_rad,
        heave_m: body.heave_m,
    }
}

/// Chooses a picture of the teaching drive near the pose for all sightings whose landmarks it shows. These have the picture's errors in common, so that
/// two pictures would tell less than one.
pub(super) fn choose(
    sights: &mut [Sight],
    views: &Views,
    views_of: impl Fn(LandmarkId) -> Vec<ViewSight>,
    pose: &PoseBox,
) {
    let of_sights: Vec<Vec<ViewSight>> = sights.iter().map(|sight| views_of(sight.landmark)).collect();
    let mut n_shown: BTreeMap<usize, usize> = BTreeMap::new();
    for view in of_sights.iter().flatten() {
        *n_shown.entry(view.picture).or_default() += 1;
    }
    let Some(most) = n_shown.values().max().copied() else { return };
    let far = |picture: usize| {
        let [x_m, y_m, turned] = [0, 1, 2].map(|axis| views.pictures[picture].pose[axis].mid() - pose[axis].mid());
        x_m.hypot(y_m) + METRES_PER_RADIAN * turned.sin().atan2(turned.cos()).abs()
    };
    let many = n_shown.iter().filter(|(_, n)| **n as f64 >= MANY * most as f64).map(|(picture, _)| *picture);
    let common = many.min_by(|a, b| far(*a).total_cmp(&far(*b)).then(a.cmp(b)));
    for (sight, own) in sights.iter_mut().zip(of_sights) {
        let view = own.into_iter().find(|view| Some(view.picture) == common);
        sight.view = view.map(|sight| {
            let picture = &views.pictures[sight.picture];
            View { sight, camera: picture.camera, pose: picture.pose }
        });
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests;

//! Landmarks whose true places are known, seen from a way by a camera that is projected with rotation matrices of `nalgebra`.

use super::*;
use crate::{
    graph::trial::{Draw, rounds},
    methods::mapped_landmarks::trial::{True, boxed, homogeneous},
    vision::point_features::{Frame, ImageBounds},
};
use image::{GrayImage, Luma};
use nalgebra::Vector3;

/// Any look: learning does not use it.
pub(in crate::methods::mapped_landmarks) fn any_look() -> Landmark {
    let picture = GrayImage::from_fn(200, 160, |u, v| Luma([(u * 7 % 90 + (u / 9 * 37 + v / 11 * 53) % 120) as u8]));
    let bounds = ImageBounds { focal_px: 400.0, slant: 1.0, dark_noise_grey: 1.0, electrons_per_grey: 20.0 };
    Frame::new(&picture, &bounds).landmarks(1).remove(0)
}

/// An album with a landmark that was seen from ten places along a way, in `n_wrong` of them as something else; its true place.
fn learnt(draw: &mut Draw, n_wrong: usize, solves: bool) -> (Album, Vector3<f64>) {
    let truth = True::new(draw, 0.1);
    let optics = Arc::new(Optics::new(truth.camera, truth.body));
    // The camera is turned by 0.4 to the left of a robot that drives along x.
    let landmark = Vector3::new(draw.between(2.5, 4.0), draw.between(1.2, 2.0), draw.between(0.3, 1.2));
    let mut album = Album::default();
    let mut n_seen = 0;
    for step in 0..12 {
        let at = truth.turned(draw, [0.12 * f64::from(step), 0.0], 0.0);
        let pose = boxed(draw, at.pose, [0.005, 0.005, 0.002]);
        let (exact_px, _) = truth.project(&at, landmark);
        let mut at_px = truth.with_error(draw, exact_px);
        let error_px = [truth.camera.error_px; 2];
        if step == 0 {
            let point = optics.first_seen(&pose, exact_px, [0.0; 2]).unwrap();
            album.add(any_look(), point, 0.0);
            continue;
        }
        if n_seen < n_wrong {
            at_px = at_px.map(|at| at + draw.between(5.0, 30.0));
        }
        n_seen += 1;
        let Some(point) = album.point(LandmarkId(0)) else { break };
        let sight = Sight { landmark: LandmarkId(0), point, at_px, error_px, view: None, thing: None };
        album.learn(&pose, [&[sight], &[]], &optics, solves);
    }
    (album, landmark)
}

#[test]
fn a_landmark_stays_in_its_box_and_its_depth_is_learnt_though_two_sightings_are_wrong() {
    let mut draw = Draw::new(20_261_203);
    for round in 0..rounds(12) {
        let (album, landmark) = learnt(&mut draw, round % 3, round % 3 == 0 && round % 2 == 0);
        let point = album.point(LandmarkId(0)).unwrap();
        let expected = homogeneous(&point.anchor, landmark);
        for (value, truly) in point.value.into_iter().zip(expected) {
            assert!(value.inflate(1e-12).contains(truly), "round {round}: {truly} {value}");
        }
        assert!(point.value[2].lo() > 0.0 && point.value[2].width() < 0.3, "round {round}: {}", point.value[2]);
    }
}

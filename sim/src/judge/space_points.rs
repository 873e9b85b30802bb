//! Decides whether a point in space is where a method claims to have seen it, or where a baseline matched it.

use std::collections::BTreeMap;

use localizer::map::{SpacePoint, ViewSight};
use nalgebra::{Matrix3, Point3, Vector3};

use crate::{
    devices::camera::world_from_camera,
    optics::Lens,
    run::{LandmarkBaselines, RunRecord},
    scene::Scene,
    truth::Truth,
    world::Drawn,
};

use super::share;

/// Half width, along u and along v, within which a matched corner shows some point of its landmark's box: corners are found again to a pixel or two.
const CORNER_PX: [f64; 2] = [3.0; 2];

/// Rounding errors that are allowed for, in the unit of the numbers that describe a landmark.
const ROUNDING: f64 = 1e-9;

/// A half-space of the three numbers that describe a landmark: those at which the scalar product with `slopes` is at least `least`.
struct Half {
    slopes: Vector3<f64>,
    least: f64,
}

/// Whether the true forward camera shows some point of a landmark's box within a half width of a pixel along u and along v; `None` where there is no
/// forward camera, or the lens shows no such pixel.
///
/// The box is one of the slopes α and β and the inverse depth ρ from an anchor A. With C the optical centre, the direction from the camera to the
/// point, times ρ, is d(α, β) + ρ·(A − C), which is linear in the three. The pixels within the half widths are a cone of four planes through the
/// optical centre: those planes and the sides of the box are half-spaces of (α, β, ρ), and the claim holds if they have a point in common. If they
/// have, then also a corner, which is on three of the planes.
///
/// Where a picture of the drive that taught the map is claimed to show the same point, the point in common has to be in the cone of that picture, too.
pub(super) fn is_seen(
    point: &SpacePoint,
    view: Option<&ViewSight>,
    (at_px, half_width_px): ([f64; 2], [f64; 2]),
    scene: &Scene,
    drawn: &Drawn,
    truth: &Truth,
) -> Option<bool> {
    let (camera, mount) = (scene.robot.forward_camera.as_ref()?, drawn.devices.forward_camera.as_ref()?);
    let (lens, world_from_camera) = (Lens::of(camera, mount), world_from_camera(truth, mount));
    let ray = |[du, dv]: [f64; 2]| {
        let [x, y] = lens.ray([at_px[0] + du * half_width_px[0], at_px[1] + dv * half_width_px[1]])?;
        Some(world_from_camera.rotation * Vector3::new(x, y, 1.0))
    };
    let corners = [ray([-1.0, -1.0])?, ray([1.0, -1.0])?, ray([1.0, 1.0])?, ray([-1.0, 1.0])?];
    let mut halves = cone(corners, ray([0.0, 0.0])?, world_from_camera * Point3::origin(), point);
    if let Some((view, eye)) = view.and_then(|view| Some((view, scene.localizer.true_eye(view.picture)?))) {
        let ray = |[du, dv]: [f64; 2]| {
            let [x, y] = [(0, du), (1, dv)]
                .map(|(axis, d)| (view.at_px[axis] + d * view.error_px[axis] - eye.centre_px[axis]) / eye.focal_px);
            eye.world_from_camera.rotation * Vector3::new(x, y, 1.0)
        };
        let corners = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]].map(ray);
        halves.extend(cone(corners, ray([0.0, 0.0]), eye.world_from_camera * Point3::origin(), point));
    }
    for (k, value) in point.value.iter().enumerate() {
        let along = Vector3::ith(k, 1.0);
        halves.push(Half { slopes: along, least: value.lo() });
        halves.push(Half { slopes: -along, least: -value.hi() });
    }
    Some(have_common_point(&halves))
}

/// The half-spaces of a cone with given corners and middle, from an eye.
fn cone(corners: [Vector3<f64>; 4], middle: Vector3<f64>, eye: Point3<f64>, point: &SpacePoint) -> Vec<Half> {
    let anchor = &point.anchor;
    let from_eye = Point3::from(anchor.from_m) - eye;
    let [i, j] = anchor.sides();
    let side = |k: usize| {
        let across = corners[k].cross(&corners[(k + 1) % 4]);
        let inward = across.normalize() * across.dot(&middle).signum();
        let slopes = Vector3::new(inward[i], inward[j], inward.dot(&from_eye));
        Half { slopes, least: -inward[anchor.axis] * anchor.sign() }
    };
    (0..4).map(side).collect()
}

/// Greatest distance in the picture, in pixels, that is measured: beyond it a landmark is not where the camera looks.
const FARTHEST_PX: f64 = 4096.0;
/// Difference, in pixels, to which a distance is measured.
const FINEST_PX: f64 = 0.01;

/// How far, along u or along v, a pixel is from the nearest one at which the true forward camera shows some point of a landmark's box: the half width
/// of the least square about the pixel in which one is seen. `None` where the camera shows none, or there is no such camera.
pub(super) fn off_px(
    point: &SpacePoint,
    view: Option<&ViewSight>,
    at_px: [f64; 2],
    scene: &Scene,
    drawn: &Drawn,
    truth: &Truth,
) -> Option<f64> {
    let is_within = |half_px: f64| is_seen(point, view, (at_px, [half_px; 2]), scene, drawn, truth) == Some(true);
    let doubled = std::iter::successors(Some(1.0), |half_px| Some(2.0 * half_px));
    let mut far_px = doubled.take_while(|half_px| *half_px <= FARTHEST_PX).find(|half_px| is_within(*half_px))?;
    let mut near_px = 0.0;
    while far_px - near_px > FINEST_PX {
        let half_px = 0.5 * (near_px + far_px);
        if is_within(half_px) { far_px = half_px } else { near_px = half_px }
    }
    Some(far_px)
}

/// Figures of landmarks that a baseline matched with corners of pictures; empty for a run without such a picture.
pub(super) fn metrics(scene: &Scene, record: &RunRecord) -> BTreeMap<String, f64> {
    let pictures = &record.landmark_baselines.pictures;
    if pictures.is_empty() {
        return BTreeMap::new();
    }
    // Of all matches and of those that agree with the pose of their picture: how many there are, and how many of them are wrong.
    let (mut n_matches, mut n_wrong) = ([0; 2], [0; 2]);
    for (picture, truth) in pictures {
        for (point, at_px, agrees) in &picture.matches {
            let is_wrong = is_seen(point, None, (*at_px, CORNER_PX), scene, &record.drawn, truth) == Some(false);
            for kind in 0..=usize::from(*agrees) {
                n_matches[kind] += 1;
                n_wrong[kind] += usize::from(is_wrong);
            }
        }
    }
    let n_fixes = pictures.iter().filter(|(picture, _)| picture.is_localized).count();
    let figures = [
        n_matches[0] as f64 / pictures.len() as f64,
        share(n_fixes, pictures.len()),
        share(n_wrong[0], n_matches[0]),
        share(n_wrong[1], n_matches[1]),
    ];
    LandmarkBaselines::FIGURES.into_iter().map(str::to_owned).zip(figures).collect()
}

/// Whether some half-spaces that together are bounded have a point in common.
fn have_common_point(halves: &[Half]) -> bool {
    let n = halves.len();
    let is_common = |at: Vector3<f64>| {
        halves.iter().all(|half| half.slopes.dot(&at) >= half.least - ROUNDING * (1.0 + half.slopes.norm()))
    };
    let corner = |a: usize, b: usize, c: usize| {
        let rows = [a, b, c].map(|k| halves[k].slopes.transpose());
        let sides = Vector3::from([a, b, c].map(|k| halves[k].least));
        Some(Matrix3::from_rows(&rows).try_inverse()? * sides)
    };
    let triples = (0..n).flat_map(|a| (a + 1..n).flat_map(move |b| (b + 1..n).map(move |c| [a, b, c])));
    triples.filter_map(|[a, b, c]| corner(a, b, c)).any(is_common)
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
pub(super) mod tests {
    use interval::Interval;
    use localizer::map::Anchor;

    use super::*;
    use crate::scene::{LandmarkMap, TrueEye};

    /// A robot at the origin that looks along x with a camera of 400 px focal length, 0.3 m above the floor and level.
    pub(in super::super) fn scene() -> Scene {
        let text = "
            description = \"a camera\"
            duration_s = 1.0
            room = { width_m = 6.0, depth_m = 6.0 }
            start = { x_m = 3.0, y_m = 3.0 }
            localizer.methods = []
            [route]
            waypoint = [{ x_m = 4.0, y_m = 3.0 }]
            [robot]
            floor_camera = false
            [robot.forward_camera]
            width_px = 640
            height_px = 480
            horizontal_view_deg = 77.31961650818018
            tilt_up_deg = 0.0
            forward_m = 0.0
            height_m = 0.3
            calibration = { position_tolerance_m = 0.0, angle_tolerance_deg = 0.0, focal_tolerance = 0.0, \
                            principal_point_tolerance_px = 0.0, distortion_tolerance_px = 0.0 }
        ";
        Scene::parse(text, "scene.toml").unwrap_or_else(|error| panic!("failed to {error}"))
    }

    #[test]
    fn a_box_is_seen_where_a_point_of_it_is_projected_and_nowhere_else() {
        let scene = scene();
        let drawn = Drawn::draw(&scene, 0);
        let truth = Truth::default();
        // From (0, 0, 0.3) the landmark is 2 m ahead, 0.2 m to the left and 0.1 m up: 400 px · 0.1 to the left, and 400 px · 0.05 up.
        let anchor = Anchor { from_m: [0.0, 0.0, 0.3], axis: 0, is_positive: true };
        let point = |half: f64| SpacePoint { anchor, value: [0.1, 0.05, 0.5].map(|at| Interval::centred(at, half)) };
        let seen = |half: f64, at_px: [f64; 2]| {
            is_seen(&point(half), None, (at_px, [0.5, 0.5]), &scene, &drawn, &truth).unwrap()
        };
        let middle = [319.5 - 40.0, 239.5 - 20.0];
        assert!(seen(1e-9, middle) && seen(1e-9, [middle[0] + 0.49, middle[1] - 0.49]));
        assert!(!seen(1e-9, [middle[0] + 0.51, middle[1]]) && !seen(1e-9, [middle[0], middle[1] - 0.51]));
        // A slope that is known to 0.01 moves it by 4 px at most.
        assert!(seen(0.01, [middle[0] + 4.4, middle[1]]) && !seen(0.01, [middle[0] + 4.6, middle[1]]));
        // How far off a pixel is that does not show it, along the axis on which it is farther off.
        let off = |half: f64, at_px: [f64; 2]| off_px(&point(half), None, at_px, &scene, &drawn, &truth).unwrap();
        assert!((off(1e-9, [middle[0] + 23.0, middle[1] - 7.0]) - 23.0).abs() < 0.02, "23 px");
        assert!((off(0.01, [middle[0] - 23.0, middle[1]]) - 19.0).abs() < 0.2, "4 px of them are the box's");
        // What is behind the camera is not seen, though its image would be there.
        let behind =
            SpacePoint { anchor: Anchor { is_positive: false, ..anchor }, value: point(1e-9).value.map(|at| -at) };
        let behind = SpacePoint { value: [behind.value[0], behind.value[1], -behind.value[2]], ..behind };
        assert_eq!(is_seen(&behind, None, (middle, [0.5, 0.5]), &scene, &drawn, &truth), Some(false));
        assert_eq!(off_px(&behind, None, middle, &scene, &drawn, &truth), None);
    }

    #[test]
    fn from_another_place_the_depth_counts() {
        let scene = scene();
        let drawn = Drawn::draw(&scene, 0);
        // 1 m further left, the landmark is 0.8 m to the right of a camera 2 m away: 160 px to the right.
        let mut truth = Truth::default();
        truth.pose.y_m = 1.0;
        let anchor = Anchor { from_m: [0.0, 0.0, 0.3], axis: 0, is_positive: true };
        let point = |rho: Interval| SpacePoint { anchor, value: [Interval::point(0.1), Interval::point(0.05), rho] };
        let seen = |rho, at_px| is_seen(&point(rho), None, (at_px, [0.5, 0.5]), &scene, &drawn, &truth).unwrap();
        let at_px = [319.5 + 160.0, 239.5 - 20.0];
        assert!(seen(Interval::point(0.5), at_px) && !seen(Interval::point(0.51), at_px));
        assert!(seen(Interval::new(0.0, 0.6), at_px) && seen(Interval::new(0.0, 0.6), [319.5 - 40.0, at_px[1]]));
        assert!(!seen(Interval::new(0.0, 0.4), at_px));
    }

    #[test]
    fn a_view_of_the_map_has_to_show_the_same_point() {
        let mut scene = scene();
        let drawn = Drawn::draw(&scene, 0);
        let truth = Truth::default();
        // The teacher's camera was 1 m further left, with a focal length of 200 px and its principal point at (100, 80): the landmark 2 m ahead and 0.2 m to
        // the left was 0.8 m to its right, 80 px.
        let mut taught = Truth::default();
        taught.pose.y_m = 1.0;
        let world_from_camera = world_from_camera(&taught, drawn.devices.forward_camera.as_ref().unwrap());
        let eye = TrueEye { world_from_camera, focal_px: 200.0, centre_px: [100.0, 80.0] };
        let known = LandmarkMap {
            room_m: [6.0; 2],
            relies_on: Vec::new(),
            landmarks: Vec::new(),
            looks: Vec::new(),
            views: Default::default(),
            true_eyes: vec![eye],
        };
        scene.localizer.know(known);
        let anchor = Anchor { from_m: [0.0, 0.0, 0.3], axis: 0, is_positive: true };
        let value = [Interval::point(0.1), Interval::point(0.05), Interval::new(0.0, 1.0)];
        let point = SpacePoint { anchor, value };
        let at_px = [319.5 - 40.0, 239.5 - 20.0];
        let seen = |picture: usize, u_px: f64| {
            let view = ViewSight { picture, at_px: [u_px, 80.0 - 10.0], error_px: [0.5; 2] };
            is_seen(&point, Some(&view), (at_px, [0.5; 2]), &scene, &drawn, &truth).unwrap()
        };
        assert!(seen(0, 180.0));
        // At no depth is it there, though the box alone would be seen; and a picture whose camera is not known says nothing.
        assert!(!seen(0, 300.0) && is_seen(&point, None, (at_px, [0.5; 2]), &scene, &drawn, &truth).unwrap());
        assert!(seen(1, 300.0));
    }
}

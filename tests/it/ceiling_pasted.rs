//! Tests of markers on rendered ceilings: their images against computations by hand, and what the localizer reads from intact and from damaged
//! markers.

use interval::Interval;
use localizer::{
    Pose, PoseBox, PoseUnion, Reading,
    map::MarkerMap,
    markers::{GridPlace, MarkerId, dot_in_marker_m},
    method::{Claim, Context, Method},
    methods::ceiling_markers::CeilingMarkers,
    reading::Camera,
    vision::ceiling::{self, CeilingView, PictureMotion, SeenMarker},
};
use sim::{run::sensors::still::Still, scene::Scene, world::Drawn};

use crate::render_studio::renderer;

/// A room of 5 m by 4 m and a robot with a camera that looks up; `more` holds the keys of the scene's table `[markers]` and what follows it.
fn room(more: &str) -> Scene {
    let text = format!(
        "[room]\nwidth_m = 5.0\ndepth_m = 4.0\n[start]\nx_m = 2.0\ny_m = 1.5\n[[route.waypoint]]\nx_m = 2.0\ny_m = 1.5\n\
         [light]\nilluminance_at_floor_lux = 20\n[robot]\nfloor_camera = false\n[robot.ceiling_camera]\nq_items = 0\n[robot.ceiling_camera.sensor]\nexposure_s = 0.0003\n[markers]\n{more}"
    );
    Scene::parse(&text, "room.toml").unwrap_or_else(|error| panic!("failed to {error}"))
}

/// Keys of a scene's markers that set the tolerances of placement, rotation, print and height to 0.
const EXACT: &str =
    "placement_tolerance_m = 0\nrotation_tolerance_deg = 0\nprint_tolerance_m = 0\nheight_tolerance_m = 0\n";
const EXACT_CAMERA: &str = "[robot.ceiling_camera.calibration]\nposition_tolerance_m = 0\nangle_tolerance_deg = 0\n\
                            focal_tolerance = 0\nprincipal_point_tolerance_px = 0\n";

fn marker(id: u16, [x, y]: [f64; 2], rotation_deg: f64, more: &str) -> String {
    format!("[[markers.marker]]\nid = {id}\nx_m = {x:?}\ny_m = {y:?}\nrotation_deg = {rotation_deg:?}\n{more}\n")
}

fn picture(scene: &Scene, drawn: &Drawn, pose: Pose) -> Still {
    let mut renderer = renderer();
    let world = renderer.upload_room(scene, drawn).unwrap();
    let lux = scene.light.illuminance_at_floor_lux;
    sim::run::sensors::still::take(&mut renderer, &world, scene, drawn, pose, lux, (&[Camera::Ceiling], 7))
        .unwrap()
        .remove(0)
}

/// Reads markers in an image. Returns the markers that were identified, and the number of candidates, groups of dots on a marker's grid, that were
/// rejected.
fn read(scene: &Scene, still: &Still) -> (Vec<SeenMarker>, usize) {
    let (camera, map) = (scene.robot_model().ceiling_camera.unwrap(), scene.map().markers.unwrap());
    let view = CeilingView::new(755.0, [2.28, 2.31], 0.005, camera.electrons_per_grey);
    let found = ceiling::detect(&still.image, &view, &map.coding.table(), &PictureMotion::default());
    (found.markers, found.rejected_px.len())
}

fn ids(seen: &[SeenMarker]) -> Vec<u16> {
    let mut ids: Vec<u16> = seen.iter().map(|marker| marker.id.0).collect();
    ids.sort_unstable();
    ids
}

#[test]
fn markers_are_seen_where_and_how_a_hand_puts_them() {
    // In an image of a camera that looks up, image down is robot forward and image right is robot right. The dots are 2.299 m above the camera, so
    // that 328 px of the image show a metre of the ceiling (focal length over depth).
    let scene = room(&format!(
        "{EXACT}{}{}{}{EXACT_CAMERA}",
        marker(125, [2.3, 1.5], 0.0, ""),
        marker(183, [2.0, 1.9], 90.0, ""),
        marker(366, [1.7, 1.3], 30.0, "")
    ));
    let still = picture(&scene, &Drawn::draw(&scene, 0), Pose { x_m: 2.0, y_m: 1.5, heading_rad: 0.0 });
    let (seen, _) = read(&scene, &still);
    let [fu, fv] = [755.139 / 2.299, 753.926 / 2.299];
    let (sin, cos) = 30f64.to_radians().sin_cos();
    // For each marker its identity, its position, and the directions of the steps from dot O to X and from O to Y, 0.12 m each.
    let expected = [
        (125, [0.0, 0.3], [0.0, 1.0], [-1.0, 0.0]),
        (183, [-0.4, 0.0], [-1.0, 0.0], [0.0, -1.0]),
        (366, [0.2, -0.3], [-sin, cos], [-cos, -sin]),
    ];
    assert_eq!(seen.len(), 3, "{:?}", ids(&seen));
    for (id, [right_m, ahead_m], along_x, along_y) in expected {
        let marker = seen.iter().find(|marker| marker.id == MarkerId(id)).unwrap();
        let dot = |place: GridPlace| marker.dots.iter().find(|(at, _)| *at == place).unwrap().1.centre_px;
        let place = [320.252 + fu * right_m, 239.661 + fv * ahead_m];
        let ([o, x, y], centre) = ([[0, 0], [3, 0], [0, 3]].map(dot), marker.centre_px());
        for axis in 0..2 {
            let scale = [fu, fv][axis];
            assert!((centre[axis] - place[axis]).abs() < 0.1, "{id}: {centre:?}, expected {place:?}");
            assert!((x[axis] - o[axis] - 0.12 * scale * along_x[axis]).abs() < 0.25, "{id}: {o:?} to {x:?}");
            assert!((y[axis] - o[axis] - 0.12 * scale * along_y[axis]).abs() < 0.25, "{id}: {o:?} to {y:?}");
        }
    }
}

#[test]
fn the_pose_read_from_a_rendered_ceiling_holds_the_truth() {
    let scene = room(
        &[(125, [1.8, 1.2], 20.0), (183, [2.5, 1.6], -70.0), (366, [2.1, 2.1], 160.0), (414, [3.0, 2.2], 5.0)]
            .map(|(id, at, rotation_deg)| marker(id, at, rotation_deg, ""))
            .concat(),
    );
    let (map, robot) = (scene.map(), scene.robot_model());
    for (seed, [x_m, y_m], heading_deg) in [(1, [2.0, 1.5], 0.0), (2, [2.4, 1.9], 130.0), (3, [2.2, 1.7], -75.0)] {
        let drawn = Drawn::draw(&scene, seed);
        let pose = Pose { x_m, y_m, heading_rad: f64::to_radians(heading_deg) };
        let still = picture(&scene, &drawn, pose);
        let reading = Reading::Camera {
            measured_s: 1.0,
            arrived_s: 1.03,
            camera: Camera::Ceiling,
            exposure_s: still.exposure.exposure_s,
            image: still.image.into(),
        };
        let mut box_ = PoseBox::from([
            Interval::centred(x_m + 0.1, 0.3),
            Interval::centred(y_m - 0.1, 0.3),
            Interval::centred(pose.heading_rad + 0.1, 0.3),
        ]);
        let mut method = CeilingMarkers::new(&map, &robot).unwrap();
        let constraint = method.constrain(&reading, &Context::at_rest(&PoseUnion::single(box_))).unwrap();
        for _ in 0..3 {
            constraint.on_pose.contract(&mut box_);
        }
        let seen = constraint.claims.iter().filter(|claim| matches!(claim, Claim::Marker { .. })).count();
        assert!(seen >= 2, "seed {seed}: {seen} markers");
        let truth = [x_m, y_m, pose.heading_rad];
        for (axis, most) in [(0, 0.06), (1, 0.06), (2, 0.06)] {
            let side = box_[axis];
            assert!(side.contains(truth[axis]), "seed {seed}: {side:?}, truth {}", truth[axis]);
            assert!(side.width() < most, "seed {seed}: {side:?} is {} wide", side.width());
        }
    }
}

#[test]
fn no_damaged_hexad_is_read_as_another() {
    let scene = room(&format!(
        "{EXACT}{}{}{}{}{}{}{}{EXACT_CAMERA}",
        marker(125, [2.2, 1.5], 0.0, ""),
        marker(183, [1.8, 1.5], 0.0, "missing_dots = [[1, 0]]"),
        marker(366, [2.0, 1.8], 40.0, "extra_dots = [[3, 1]]"),
        marker(414, [2.4, 1.8], 0.0, "covered_share = 0.5"),
        marker(429, [1.6, 1.8], 0.0, "mirrored = true"),
        marker(125, [2.2, 1.2], 0.0, "on_map = false"),
        marker(483, [1.8, 1.2], 0.0, "pasted = false"),
    ));
    let drawn = Drawn::draw(&scene, 0);
    let still = picture(&scene, &drawn, Pose { x_m: 2.0, y_m: 1.5, heading_rad: 0.4 });
    let (seen, refused) = read(&scene, &still);
    // Two markers on the ceiling have the identity 125, and image processing must report both as 125; it is the localization method that has to
    // notice the duplicate.
    assert_eq!(ids(&seen), [125, 125], "refused {refused}");
    assert!(refused >= 2, "{refused} refused");
    let on_ceiling: Vec<usize> = drawn.place.markers.iter().map(|marker| marker.index).collect();
    assert_eq!(on_ceiling, [0, 1, 2, 3, 4, 5]);
    let MarkerMap { markers, .. } = scene.map().markers.unwrap();
    assert_eq!(markers.iter().map(|placed| placed.id.0).collect::<Vec<_>>(), [125, 183, 366, 414, 429, 483]);
}

#[test]
fn what_is_printed_is_what_the_localizer_spells() {
    for id in [0u16, 1, 2, 4, 8, 16, 32, 64, 128, 256, 512, 1024, 2048, 447, 1782, 4095] {
        let scene = room(&format!("coding = \"plain\"\n{EXACT}{}", marker(id, [2.0, 1.5], 0.0, "")));
        let drawn = Drawn::draw(&scene, 0);
        let dots = &drawn.place.markers[0].dots;
        assert_eq!(MarkerId::from_dots(dots.iter().map(|dot| dot.place)), MarkerId(id));
        assert_eq!(dots.len(), 3 + id.count_ones() as usize);
        for dot in dots {
            let [x, y] = dot_in_marker_m(dot.place);
            assert!((dot.centre_in_world.x - 2.0 - x).hypot(dot.centre_in_world.y - 1.5 - y) < 1e-12);
            assert!((dot.centre_in_world.z - 2.599).abs() < 1e-12);
        }
    }
}

#[test]
fn markers_are_pasted_within_their_tolerances_and_all_over_them() {
    let scene = room(&marker(125, [2.0, 1.5], 33.0, ""));
    let mut greatest = [0.0_f64; 4];
    for seed in 0..400 {
        let drawn = &Drawn::draw(&scene, seed).place.markers[0];
        let (sin, cos) = drawn.rotation_rad.sin_cos();
        let shares = [
            (drawn.centre_m[0] - 2.0).hypot(drawn.centre_m[1] - 1.5) / 0.002,
            (drawn.rotation_rad.to_degrees() - 33.0).abs() / 0.2,
            (drawn.height_m - (2.599 - 0.005)).abs() / 0.005,
            drawn
                .dots
                .iter()
                .map(|dot| {
                    let [x, y] = dot_in_marker_m(dot.place);
                    let expected = [drawn.centre_m[0] + cos * x - sin * y, drawn.centre_m[1] + sin * x + cos * y];
                    (dot.centre_in_world.x - expected[0]).hypot(dot.centre_in_world.y - expected[1]) / 0.0003
                })
                .fold(0.0, f64::max),
        ];
        assert!(shares.iter().all(|share| *share <= 1.0 + 1e-9), "seed {seed}: {shares:?}");
        greatest = [0, 1, 2, 3].map(|error| greatest[error].max(shares[error]));
    }
    assert!(greatest.iter().all(|share| *share > 0.9), "{greatest:?}");
}

#[test]
fn damage_to_one_marker_moves_no_other() {
    let scene = |more: &str| room(&[marker(125, [2.0, 1.5], 0.0, more), marker(183, [3.0, 1.5], 0.0, "")].concat());
    let whole = Drawn::draw(&scene(""), 3).place.markers[1].clone();
    for more in ["pasted = false", "missing_dots = [[0, 0]]", "covered_share = 1.0", "mirrored = true"] {
        assert_eq!(Drawn::draw(&scene(more), 3).place.markers.last(), Some(&whole), "{more}");
    }
}

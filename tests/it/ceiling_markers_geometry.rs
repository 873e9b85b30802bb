//! Tests of the step from dots in an image to the pose, with a pinhole camera and a ceiling that the tests model for themselves.

use interval::Interval;
use localizer::{
    Constraint, Map, PoseBox, PoseUnion, RobotModel,
    map::{MarkerMap, PlacedMarker},
    markers::{Coding, GridPlace, MarkerId},
    methods::ceiling_markers::CeilingMarkers,
    robot::{BodyModel, CeilingCameraModel, Reach, WheelModel},
    vision::ceiling::{CeilingMarkers as Seen, Dot, SeenMarker},
};
use nalgebra::{Isometry3, Point3, Rotation3, Translation3, UnitQuaternion, Vector3};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// Declared tilt of the body, and of the camera's mount: 0.05° each.
const TILT_RAD: f64 = 0.05 * std::f64::consts::PI / 180.0;
const HEAVE_M: f64 = 0.0002;
const CEILING_M: f64 = 2.8;

/// A random factor from −1 to 1 for an error bound; half of the time it is −1 or 1, so that the error is as great as the bound allows.
fn corner(rng: &mut ChaCha8Rng) -> f64 {
    if rng.random::<f64>() < 0.5 { [-1.0, 1.0][rng.random_range(0..2)] } else { rng.random_range(-1.0..1.0) }
}

fn drawn(rng: &mut ChaCha8Rng, interval: Interval) -> f64 {
    (interval.mid() + corner(rng) * interval.radius()).clamp(interval.lo(), interval.hi())
}

/// A random rotation by at most `size` radians about a horizontal axis.
fn tilt(rng: &mut ChaCha8Rng, size: f64) -> UnitQuaternion<f64> {
    let (angle, size) = (rng.random_range(0.0..std::f64::consts::TAU), size * corner(rng));
    UnitQuaternion::from_scaled_axis(Vector3::new(angle.cos(), angle.sin(), 0.0) * size)
}

fn camera() -> CeilingCameraModel {
    CeilingCameraModel {
        width_px: 640,
        height_px: 480,
        focal_px: [Interval::centred(755.139, 0.4), Interval::centred(753.926, 0.4)],
        centre_px: [Interval::centred(320.252, 0.4), Interval::centred(239.661, 0.4)],
        distortion: [0.0; 5],
        distortion_px: 0.0,
        height_m: Interval::centred(0.2, 0.001),
        position_m: [Interval::centred(-0.15, 0.0003), Interval::centred(0.02, 0.0003)],
        yaw_rad: Interval::centred(0.0, TILT_RAD),
        lean_rad: [0.0; 2],
        tilt_rad: TILT_RAD,
        stamp_error_s: 0.0,
        electrons_per_grey: 40.0,
        row_time_s: 0.0,
        q_items: 0,
    }
}

fn robot(camera: CeilingCameraModel, body_tilt_rad: f64) -> RobotModel {
    let radius = Interval::point(0.1);
    RobotModel {
        wheels: WheelModel {
            radius_m: [radius, radius],
            track_m: Interval::point(0.33),
            ticks_per_turn: 1000.0,
            slip_ratio: 0.0,
            slip_floor_m: 0.0,
            side_slip_ratio: 0.0,
            side_slip_floor_m: 0.0,
            slip_window_s: 0.2,
        },
        reach: Reach { speed_m_per_s: 0.7, turn_rate_rad_per_s: 1.6, acceleration_m_per_s2: 2.0 },
        body: BodyModel { tilt_rad: body_tilt_rad, heave_m: HEAVE_M, clearance_m: 0.0 },
        floor_camera: None,
        forward_camera: None,
        gyro: None,
        flow: None,
        ceiling_camera: Some(camera),
        range_camera: None,
        steering: None,
    }
}

/// A true situation of robot, camera and markers, with every error drawn inside its bound.
struct Situation {
    pose: [f64; 3],
    map: MarkerMap,
    camera: CeilingCameraModel,
    /// Centre, angle and height of each marker as pasted.
    pasted: Vec<([f64; 2], f64, f64)>,
    /// Pose at the exposure of the row that the stamp belongs to.
    at_exposure: [f64; 3],
    /// The camera as seen from the pose.
    world_from_camera: Isometry3<f64>,
    /// The same with the body's lean at the rows that are exposed after the stamp.
    leant_later: Isometry3<f64>,
    /// Speed ahead and to the left, and turn rate, which stay the same while the rows are exposed.
    twist: [f64; 3],
    /// How exactly the motion is known; `None` where it is not.
    known_within: Option<f64>,
    focal_px: [f64; 2],
    centre_px: [f64; 2],
    body_tilt_rad: f64,
}

/// Motion of a robot with a steady twist after a time, seen from where it was.
fn moved_by([ahead, left, turn]: [f64; 3], after_s: f64) -> [f64; 3] {
    let (rad, half) = (turn * after_s, 0.5 * turn * after_s);
    // The chord of the arc.
    let chord = if half.abs() > 1e-12 { half.sin() / half } else { 1.0 };
    let [x, y] = [ahead, left].map(|speed| speed * after_s * chord);
    [x * half.cos() - y * half.sin(), x * half.sin() + y * half.cos(), rad]
}

fn planar([x, y, turn]: [f64; 3]) -> Isometry3<f64> {
    Isometry3::from_parts(Translation3::new(x, y, 0.0), UnitQuaternion::from_axis_angle(&Vector3::z_axis(), turn))
}

impl Situation {
    /// A situation of random markers around a robot at a random pose, whose true camera is drawn within the bounds of `camera`.
    fn new(rng: &mut ChaCha8Rng, camera: CeilingCameraModel, n_markers: usize) -> Situation {
        Situation::leaning(rng, camera, n_markers, TILT_RAD)
    }

    /// A situation of random markers around a robot whose body leans by up to `body_tilt_rad`.
    fn leaning(rng: &mut ChaCha8Rng, camera: CeilingCameraModel, n_markers: usize, body_tilt_rad: f64) -> Situation {
        let pose = [rng.random_range(-8.0..8.0), rng.random_range(-8.0..8.0), rng.random_range(-20.0..20.0f64)];
        let words = Coding::Hexads.identities();
        let lean = Vector3::new(-camera.lean_rad[1], camera.lean_rad[0], 0.0);
        let marker = |idx: usize, rng: &mut ChaCha8Rng| PlacedMarker {
            id: words[idx * 7 % words.len()],
            // The markers lie about where the leaning camera looks.
            centre_m: {
                let (sin, cos) = pose[2].sin_cos();
                let ahead = [CEILING_M * camera.lean_rad[0].tan(), CEILING_M * camera.lean_rad[1].tan()];
                let spread = [rng.random_range(-0.7..0.7), rng.random_range(-0.7..0.7)];
                [
                    pose[0] + cos * ahead[0] - sin * ahead[1] + spread[0],
                    pose[1] + sin * ahead[0] + cos * ahead[1] + spread[1],
                ]
            },
            rotation_rad: rng.random_range(-4.0..4.0),
            height_m: Interval::centred(CEILING_M + rng.random_range(-0.1..0.1), 0.002),
        };
        let markers: Vec<PlacedMarker> = (0..n_markers).map(|idx| marker(idx, rng)).collect();
        let map = MarkerMap {
            coding: Coding::Hexads,
            markers,
            placement_m: 0.0005,
            rotation_tolerance_rad: 0.0005,
            print_m: 0.00005,
        };
        let pasted = map.markers.iter().map(|placed| {
            let course: f64 = rng.random_range(0.0..std::f64::consts::TAU);
            let off = map.placement_m * corner(rng);
            let centre = [placed.centre_m[0] + off * course.cos(), placed.centre_m[1] + off * course.sin()];
            let angle = placed.rotation_rad + map.rotation_tolerance_rad * corner(rng);
            (centre, angle, drawn(rng, placed.height_m))
        });
        let pasted = pasted.collect();
        let stamp_error_s = camera.stamp_error_s * corner(rng);
        let course: f64 = rng.random_range(0.0..std::f64::consts::TAU);
        let at_exposure = [
            pose[0] + 0.7 * stamp_error_s * course.cos(),
            pose[1] + 0.7 * stamp_error_s * course.sin(),
            pose[2] + 1.6 * stamp_error_s * corner(rng),
        ];
        let upwards = UnitQuaternion::from_rotation_matrix(&Rotation3::from_basis_unchecked(&[
            Vector3::new(0.0, 1.0, 0.0),
            Vector3::new(-1.0, 0.0, 0.0),
            Vector3::new(0.0, 0.0, 1.0),
        ]));
        let yaw = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), drawn(rng, camera.yaw_rad));
        let (lean, error) = (UnitQuaternion::from_scaled_axis(lean), tilt(rng, camera.tilt_rad));
        // The camera is mounted with a lean and a small error of that lean. The error is applied at random before or after the lean, because the
        // declared bound limits the angle of the optical axis in either order.
        let posture = if rng.random::<bool>() { error * lean } else { lean * error };
        let place = [drawn(rng, camera.position_m[0]), drawn(rng, camera.position_m[1]), drawn(rng, camera.height_m)];
        let body_from_camera =
            Isometry3::from_parts(Translation3::new(place[0], place[1], place[2]), yaw * posture * upwards);
        // The body is turned about the vertical so that its forward axis, seen from above, has the pose's heading, as with roll, pitch and yaw.
        let mut world_from_body = || {
            let lean_of_body = tilt(rng, body_tilt_rad);
            let forward = lean_of_body * Vector3::x();
            let heading =
                UnitQuaternion::from_axis_angle(&Vector3::z_axis(), at_exposure[2] - forward.y.atan2(forward.x));
            let place = Translation3::new(at_exposure[0], at_exposure[1], HEAVE_M * corner(rng));
            Isometry3::from_parts(place, heading * lean_of_body)
        };
        let (world_from_body, later) = (world_from_body(), world_from_body());
        let twist = [0.7 * corner(rng), 0.0, 1.6 * corner(rng)];
        let known_within = [Some(0.0), Some(0.001), None][rng.random_range(0..3)];
        let (focal_px, centre_px) = (
            [0, 1].map(|axis| drawn(rng, camera.focal_px[axis])),
            [0, 1].map(|axis| drawn(rng, camera.centre_px[axis])),
        );
        // A planar motion is one about the place and the heading at the exposure.
        let level = planar(at_exposure).inverse();
        let [world_from_camera, leant_later] = [world_from_body, later].map(|body| level * body * body_from_camera);
        Situation {
            pose,
            at_exposure,
            map,
            camera,
            pasted,
            world_from_camera,
            leant_later,
            twist,
            known_within,
            focal_px,
            centre_px,
            body_tilt_rad,
        }
    }

    /// Image of a point by the pinhole model and Brown's lens model, at the time at which its row is exposed.
    fn project(&self, point: Point3<f64>) -> [f64; 2] {
        let middle_row = 0.5 * (f64::from(self.camera.height_px) - 1.0);
        let mut at = [0.0, middle_row];
        // The picture moves by much less than a row from row to row.
        let is_later = self.seen_after(point, 0.0, false)[1] > middle_row;
        for _ in 0..if self.camera.row_time_s > 0.0 { 12 } else { 1 } {
            at = self.seen_after(point, (at[1] - middle_row) * self.camera.row_time_s, is_later);
        }
        at
    }

    /// Image of a point at a time after the stamp. `is_later` says which of the two leans the body has then, where the shutter is a rolling one.
    fn seen_after(&self, point: Point3<f64>, after_s: f64, is_later: bool) -> [f64; 2] {
        let pose = planar(self.at_exposure) * planar(moved_by(self.twist, after_s));
        let is_later = is_later && self.camera.row_time_s > 0.0;
        let camera = pose * if is_later { self.leant_later } else { self.world_from_camera };
        let seen = camera.inverse_transform_point(&point);
        let (x, y) = (seen.x / seen.z, seen.y / seen.z);
        let ([k1, k2, p1, p2, k3], r2) = (self.camera.distortion, x * x + y * y);
        let radial = 1.0 + k1 * r2 + k2 * r2 * r2 + k3 * r2 * r2 * r2;
        let bent = [
            x * radial + 2.0 * p1 * x * y + p2 * (r2 + 2.0 * x * x),
            y * radial + p1 * (r2 + 2.0 * y * y) + 2.0 * p2 * x * y,
        ];
        [0, 1].map(|axis| self.centre_px[axis] + self.focal_px[axis] * bent[axis])
    }

    /// Position of one dot of the marker with index `idx` as printed and pasted.
    fn dot(&self, rng: &mut ChaCha8Rng, idx: usize, place: GridPlace) -> Point3<f64> {
        let (centre, angle, height) = self.pasted[idx];
        let at = [0, 1].map(|axis| (f64::from(place[axis]) - 1.5) * 0.04);
        let course: f64 = rng.random_range(0.0..std::f64::consts::TAU);
        let off = self.map.print_m * corner(rng);
        Point3::new(
            centre[0] + angle.cos() * at[0] - angle.sin() * at[1] + off * course.cos(),
            centre[1] + angle.sin() * at[0] + angle.cos() * at[1] + off * course.sin(),
            height,
        )
    }

    /// What a perfect reader would see of the markers: each dot is off by at most `bound_px` along both axes, often by exactly the bound.
    fn seen(&self, rng: &mut ChaCha8Rng, bound_px: f64) -> Seen {
        let ids: Vec<MarkerId> = self.map.markers.iter().map(|placed| placed.id).collect();
        let mut markers = Vec::new();
        for (idx, id) in ids.into_iter().enumerate() {
            let mut dots = Vec::new();
            for place in id.dots() {
                let image = self.project(self.dot(rng, idx, place));
                let off = self.camera.distortion_px;
                let centre_px = image.map(|at| at + (bound_px + off) * corner(rng) * 0.999_999);
                dots.push((
                    place,
                    Dot { centre_px, bound_px, radius_px: 2.9, level: 200.0, flux: 5000.0, clipped_px: 0.0 },
                ));
            }
            markers.push(SeenMarker { id, dots, confidence: 1.0 });
        }
        Seen { markers, rejected_px: Vec::new() }
    }

    fn method(&self) -> CeilingMarkers {
        let room = Interval::new(-50.0, 50.0);
        let map = Map {
            room_m: [room, room],
            tiles: None,
            markers: Some(self.map.clone()),
            wall_directions_rad: Vec::new(),
            walls: None,
        };
        CeilingMarkers::new(&map, &robot(self.camera.clone(), self.body_tilt_rad))
            .expect("a ceiling camera and markers")
    }

    fn constraint(&self, seen: Seen) -> Option<Constraint> {
        let motion = |from_s: f64, to_s: f64| {
            let (within, truth) = (self.known_within?, moved_by(self.twist, to_s - from_s));
            // The motion is at a corner of what is known of it.
            Some(PoseBox::new(truth.map(|value| Interval::centred(value + within, within))))
        };
        self.method().constraint(0.0, seen, &motion)
    }

    /// The poses of a prior box that are left once the constraint from the seen markers has been applied.
    fn located(&self, seen: Seen, prior: &PoseBox) -> PoseUnion {
        let constraint = self.constraint(seen).expect("markers on the map");
        PoseUnion { branches: constraint.on_pose.branches(prior) }
    }

    fn prior(&self, rng: &mut ChaCha8Rng, half_m: f64, half_rad: f64) -> PoseBox {
        let half = [half_m, half_m, half_rad];
        PoseBox::new(std::array::from_fn(|axis| {
            Interval::centred(self.pose[axis] + rng.random_range(-0.9..0.9) * half[axis], half[axis])
        }))
    }

    fn holds(&self, union: &PoseUnion) -> bool {
        union.branches.iter().any(|branch| branch.contains(&self.pose))
    }
}

/// A camera of random kind: each of the following is present or absent at random: a lean by up to 10° that is declared to within 0.05°, lens
/// distortion, an error of the images' time stamps, a rolling shutter while the robot moves, a turned mount.
fn any_camera(rng: &mut ChaCha8Rng) -> CeilingCameraModel {
    let mut camera = camera();
    if rng.random::<bool>() {
        let course: f64 = rng.random_range(0.0..std::f64::consts::TAU);
        let lean = 10f64.to_radians() * rng.random_range(0.0..1.0);
        camera.lean_rad = [lean * course.cos(), lean * course.sin()];
    }
    if rng.random::<bool>() {
        camera.distortion = [rng.random_range(-0.2..0.1), rng.random_range(-0.05..0.05), 0.001, -0.0008, 0.02];
        camera.distortion_px = 0.02;
    }
    if rng.random::<bool>() {
        camera.stamp_error_s = 0.001;
    }
    if rng.random::<bool>() {
        camera.row_time_s = 5e-5;
    }
    if rng.random::<bool>() {
        camera.yaw_rad = Interval::centred(rng.random_range(-3.0..3.0), TILT_RAD);
    }
    camera
}

#[test]
fn no_pose_is_lost_whatever_the_mount_and_the_errors() {
    let mut rng = ChaCha8Rng::seed_from_u64(51);
    let rounds = std::env::var("WHEREIN_CEILING_POSES").ok().and_then(|text| text.parse().ok()).unwrap_or(2500);
    for round in 0..rounds {
        let camera = any_camera(&mut rng);
        let n_markers = rng.random_range(1..5);
        let situation = Situation::new(&mut rng, camera, n_markers);
        let bound_px = [0.0, 0.03, 0.1, 0.4][rng.random_range(0..4)];
        let seen = situation.seen(&mut rng, bound_px);
        let (half_m, half_rad) = [(0.02, 0.02), (0.5, 0.3), (20.0, 7.0)][rng.random_range(0..3)];
        let prior = situation.prior(&mut rng, half_m, half_rad);
        let union = situation.located(seen, &prior);
        assert!(situation.holds(&union), "round {round}: {:?} not in {union:?}", situation.pose);
    }
}

#[test]
fn no_tilt_of_body_and_mount_loses_the_pose_however_great() {
    let mut rng = ChaCha8Rng::seed_from_u64(57);
    let rounds = std::env::var("WHEREIN_CEILING_POSES").ok().and_then(|text| text.parse().ok()).unwrap_or(300);
    for [body_deg, mount_deg] in [[0.5, 0.5], [1.0, 1.0], [3.0, 3.0], [10.0, 1.0], [30.0, 1.0], [1.0, 10.0]] {
        let mut n_told = 0;
        for round in 0..rounds {
            let camera = CeilingCameraModel { tilt_rad: f64::to_radians(mount_deg), ..any_camera(&mut rng) };
            let situation = Situation::leaning(&mut rng, camera, 2, f64::to_radians(body_deg));
            let seen = situation.seen(&mut rng, 0.1);
            let prior = situation.prior(&mut rng, 1.0, 0.3);
            // If the declared tilts allow the ray through a dot to be level, the dot gives no information.
            let Some(constraint) = situation.constraint(seen) else { continue };
            let union = PoseUnion { branches: constraint.on_pose.branches(&prior) };
            assert!(situation.holds(&union), "{body_deg} and {mount_deg} deg, round {round}: not in {union:?}");
            n_told += 1;
        }
        assert!(n_told > rounds / 2 || body_deg > 3.0, "{body_deg} and {mount_deg} deg: {n_told}");
    }
}

#[test]
fn behind_a_bent_lens_no_error_of_its_optics_loses_the_pose() {
    let mut rng = ChaCha8Rng::seed_from_u64(58);
    for round in 0..1000 {
        let lens = CeilingCameraModel {
            focal_px: [480.0, 480.0].map(|focal| Interval::centred(focal, 0.01 * focal)),
            centre_px: [319.5, 239.5].map(|at| Interval::centred(at, 5.0)),
            distortion: [-0.25, 0.06, 0.001, -0.002, 0.0],
            distortion_px: [0.0, 0.5][round % 2],
            ..any_camera(&mut rng)
        };
        let situation = Situation::new(&mut rng, lens, 2);
        let seen = situation.seen(&mut rng, 0.03);
        let prior = situation.prior(&mut rng, 0.5, 0.3);
        let Some(constraint) = situation.constraint(seen) else { continue };
        let union = PoseUnion { branches: constraint.on_pose.branches(&prior) };
        assert!(situation.holds(&union), "round {round}: {:?} not in {union:?}", situation.pose);
    }
}

#[test]
fn one_marker_overhead_gives_position_to_the_tilts_and_heading_to_a_fraction_of_a_degree() {
    let mut rng = ChaCha8Rng::seed_from_u64(52);
    let mut widths = [0.0; 3];
    for _ in 0..200 {
        let mut situation = Situation::new(&mut rng, camera(), 1);
        let pose = situation.pose;
        situation.map.markers[0].centre_m = [pose[0], pose[1]];
        situation.pasted[0].0 = [pose[0], pose[1]];
        let seen = situation.seen(&mut rng, 0.03);
        let union = situation.located(seen, &situation.prior(&mut rng, 1.0, 1.0));
        assert!(situation.holds(&union));
        let hull = union.hull();
        (0..3).for_each(|axis| widths[axis] += hull.width(axis) / 200.0);
    }
    // Expected half-widths of the position's box in mm, computed by hand: tilts of body and mount by 0.05° over 2.8 m and 2.6 m give 4.72, marker
    // placement gives 0.5. The mount's position (0.3) and the principal point (1.38) are known within squares that are turned by any angle, wider by
    // 4/π on average: 2.1. A dot's print and pixel bound give 0.15. The sum is 7.5, less what is gained at the corners of the squares.
    println!("widths {:.2} mm {:.2} mm {:.3} deg", 1e3 * widths[0], 1e3 * widths[1], widths[2].to_degrees());
    assert!(widths[..2].iter().all(|width| (0.0142..0.0162).contains(width)), "{widths:?}");
    assert!(widths[2].to_degrees() < 0.6, "{widths:?}");
}

#[test]
fn a_marker_that_is_not_where_the_map_says_costs_nothing_when_one_may_be_wrong() {
    let mut rng = ChaCha8Rng::seed_from_u64(53);
    let mut emptied = 0;
    for round in 0..100 {
        let camera = CeilingCameraModel { q_items: 1, ..any_camera(&mut rng) };
        let mut situation = Situation::new(&mut rng, camera, 3);
        // Marker 0 hangs 5 to 40 cm away from its place on the map.
        situation.pasted[0].0[0] += rng.random_range(0.05..0.4) * [-1.0, 1.0][rng.random_range(0..2)];
        let seen = situation.seen(&mut rng, 0.05);
        let prior = situation.prior(&mut rng, 2.0, 0.5);
        assert!(situation.holds(&situation.located(seen.clone(), &prior)), "round {round}");
        situation.camera.q_items = 0;
        let union = situation.located(seen, &prior);
        assert!(!situation.holds(&union), "round {round}");
        emptied += usize::from(union.branches.is_empty());
    }
    // If it is declared that no marker hangs at a wrong place, the misplaced marker contradicts the other two, and no pose is left in nearly all
    // rounds.
    assert!(emptied >= 95, "{emptied} of 100");
}

#[test]
fn one_marker_alone_says_nothing_when_one_may_be_wrong() {
    let mut rng = ChaCha8Rng::seed_from_u64(54);
    let situation = Situation::new(&mut rng, CeilingCameraModel { q_items: 1, ..camera() }, 1);
    let seen = situation.seen(&mut rng, 0.05);
    assert!(situation.constraint(seen).is_none());
}

#[test]
fn a_stranger_is_ignored_and_doubles_are_both_refused() {
    let mut rng = ChaCha8Rng::seed_from_u64(55);
    let situation = Situation::new(&mut rng, camera(), 2);
    let seen = situation.seen(&mut rng, 0.05);
    let prior = situation.prior(&mut rng, 1.0, 0.5);
    let alone = Seen { markers: vec![seen.markers[1].clone()], rejected_px: Vec::new() };
    let expected = situation.located(alone, &prior);

    let mut stranger = seen.clone();
    stranger.markers[0].id = MarkerId(0xFFF);
    assert_eq!(situation.located(stranger, &prior), expected);

    let mut doubled = seen.clone();
    doubled.markers.push(doubled.markers[0].clone());
    let constraint = situation.constraint(doubled).expect("marker 1 is left");
    assert_eq!(constraint.on_pose.branches(&prior), expected.branches);
    assert_eq!((constraint.claims.len(), constraint.rejected_px.len()), (1, 2));

    let strangers =
        Seen { markers: vec![SeenMarker { id: MarkerId(0xFFF), ..seen.markers[0].clone() }], rejected_px: Vec::new() };
    assert!(situation.constraint(strangers).is_none());
}

#[test]
fn a_prior_of_several_turns_keeps_one_branch_for_each() {
    let mut rng = ChaCha8Rng::seed_from_u64(56);
    let situation = Situation::new(&mut rng, camera(), 1);
    let seen = situation.seen(&mut rng, 0.05);
    let turn = std::f64::consts::TAU;
    let prior = PoseBox::new([
        Interval::new(-50.0, 50.0),
        Interval::new(-50.0, 50.0),
        Interval::centred(situation.pose[2], 1.5 * turn - 0.1),
    ]);
    let union = situation.located(seen, &prior);
    assert_eq!(union.branches.len(), 3, "{union:?}");
    for branch in &union.branches {
        let turns = ((branch[2].mid() - situation.pose[2]) / turn).round();
        assert!(branch.contains(&[situation.pose[0], situation.pose[1], situation.pose[2] + turns * turn]));
        assert!(branch.width(0) < 0.03 && branch.width(2) < 0.03);
    }
}

#[test]
fn a_marker_pasted_askew_by_its_tolerance_still_holds_the_heading() {
    let mut rng = ChaCha8Rng::seed_from_u64(57);
    for round in 0..100 {
        let mut situation = Situation::new(&mut rng, camera(), 1);
        situation.map.rotation_tolerance_rad = 0.01;
        situation.pasted[0].1 = situation.map.markers[0].rotation_rad + [-0.01, 0.01][round % 2];
        let seen = situation.seen(&mut rng, 0.02);
        let union = situation.located(seen, &situation.prior(&mut rng, 0.5, 0.3));
        assert!(situation.holds(&union), "round {round}");
    }
}

//! The method that takes the heading from level edges of walls, against a camera, rooms and edges simulated by the tests themselves.

use interval::Interval;
use localizer::{
    Claim, Constraint, Map, PoseBox, PoseUnion, RobotModel,
    method::{Memory, Method, MotionBetween, Window},
    methods::wall_directions::{Chain, IMAGES, Quotas, Setup, WallDirections},
    robot::{BodyModel, ErrorLaw, ForwardCameraModel, Reach, WheelModel},
    vision::forward::EdgeLine,
};
use nalgebra::{Rotation3, Vector3};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use crate::command::rounds;

const FOCAL_PX: f64 = 417.0;
const CENTRE_PX: [f64; 2] = [319.5, 239.5];
const TILT_UP_RAD: f64 = 0.15;
const YAW_ERROR_RAD: f64 = 0.002;
const TILT_ERROR_RAD: f64 = 0.003;
const BOUND_PX: f64 = 0.4;

fn camera(distortion: [f64; 5]) -> ForwardCameraModel {
    ForwardCameraModel {
        focal_px: Interval::centred(FOCAL_PX, 0.4),
        principal_point_px: CENTRE_PX.map(|at| Interval::centred(at, 0.5)),
        distortion,
        distortion_px: 0.0,
        tilt_up_rad: TILT_UP_RAD,
        yaw_rad: Interval::centred(0.0, YAW_ERROR_RAD),
        tilt_error_rad: TILT_ERROR_RAD,
        stamp_error_s: 0.0,
        position_m: [Interval::ZERO; 2],
        height_m: Interval::point(0.25),
        height_px: 480,
        row_time_s: 0.0,
    }
}

/// A robot of which nothing is asked but how it leans and moves.
fn robot(body: BodyModel, reach: Reach) -> RobotModel {
    let none = ErrorLaw { floor_m: 0.0, share: 0.0, m_per_s: 0.0 };
    RobotModel { body, ..RobotModel::new(WheelModel::of_odometry(Interval::point(0.3), none, none), reach) }
}

/// The method with the images that are held for it, as the localizer does.
struct Walls {
    method: WallDirections,
    held: Window,
}

impl Walls {
    fn of(method: WallDirections) -> Walls {
        Walls { held: Window::new(method.n_earlier()), method }
    }

    /// The constraint from the edges of an image with a stamp, to which the images before are carried by a motion.
    fn carried(
        &mut self,
        stamp_s: f64,
        edges: &[EdgeLine],
        prior: &PoseUnion,
        motion: MotionBetween,
    ) -> Option<Constraint> {
        let earlier = self.held.carried_to(stamp_s, motion);
        let constraint = self.method.constraint(stamp_s, edges, prior, &earlier)?;
        constraint.shown.iter().filter(|_| constraint.is_held).for_each(|one| self.held.hold(stamp_s, one.clone()));
        Some(constraint)
    }

    /// The same for a robot that stands, with all images at one stamp.
    fn constraint(&mut self, stamp_s: f64, edges: &[EdgeLine], prior: &PoseUnion) -> Option<Constraint> {
        self.carried(stamp_s, edges, prior, &|_, _| None)
    }
}

/// The method for a building where long edges on the floor run along walls; it solves for the lean of robot and camera. By the chain of the paper,
/// whose edges are not refitted, it uses edges up to the greater width of their direction.
fn setup(learns: bool) -> Setup {
    Setup { chain: Chain::Paper, solves_lean: true, floor_edges: true, learns, ..Setup::default() }
}

/// The same, where none of the edges may be wrong.
fn without_wrong_edges() -> Setup {
    let quotas = Quotas { edge_share: 0.0, images: 0, held_share: 0.0, held_edges: 0, spoilt_images: 0 };
    Setup { quotas, ..setup(false) }
}

fn method(directions_rad: &[f64], learns: bool) -> Walls {
    let body = BodyModel { tilt_rad: 0.0, heave_m: 0.0, clearance_m: 0.1 };
    let reach = Reach { speed_m_per_s: 1.0, turn_rate_rad_per_s: 3.0, acceleration_m_per_s2: 3.0 };
    let directions: Vec<Interval> = directions_rad.iter().map(|&direction| Interval::point(direction)).collect();
    Walls::of(WallDirections::with(camera([0.0; 5]), &robot(body, reach), &directions, setup(learns)))
}

/// A camera as it truly is: focal length, principal point, distortion, and the rotation from the robot's frame (x forward, y left, z up).
struct TrueCamera {
    focal_px: f64,
    centre_px: [f64; 2],
    distortion: [f64; 5],
    camera_from_robot: Rotation3<f64>,
}

impl TrueCamera {
    fn draw(rng: &mut ChaCha8Rng) -> TrueCamera {
        let mut within = |bound: f64| rng.random_range(-bound..=bound);
        // Rows of the matrix from the robot's frame (x forward, y left, z up) to a level camera's frame: image right, image down and the optical
        // axis.
        let level =
            Rotation3::from_matrix_unchecked(nalgebra::Matrix3::new(0.0, -1.0, 0.0, 0.0, 0.0, -1.0, 1.0, 0.0, 0.0));
        // The robot's y axis points to its left. A positive (counter-clockwise) rotation about it would make the camera's optical axis dip, so that
        // tilting the camera up is a negative rotation.
        let tilt = Rotation3::from_axis_angle(&Vector3::y_axis(), -TILT_UP_RAD);
        let (axis, yaw) = (within(std::f64::consts::PI), within(YAW_ERROR_RAD));
        let lean = Rotation3::from_scaled_axis(Vector3::new(axis.cos(), axis.sin(), 0.0) * within(TILT_ERROR_RAD));
        let turn = Rotation3::from_axis_angle(&Vector3::z_axis(), yaw);
        TrueCamera {
            focal_px: FOCAL_PX + within(0.4),
            centre_px: CENTRE_PX.map(|at| at + within(0.5)),
            distortion: [0.0; 5],
            camera_from_robot: level * (turn * lean * tilt).inverse(),
        }
    }

    fn pixel(&self, place: Vector3<f64>) -> Option<[f64; 2]> {
        let seen = self.camera_from_robot * place;
        // The lens bends rays by Brown and Conrady's distortion formula, in powers of the ray's distance from the optical axis.
        let ([k1, k2, p1, p2, k3], [x, y]) = (self.distortion, [seen.x / seen.z, seen.y / seen.z]);
        let r = x.hypot(y);
        let radial = 1.0 + k1 * r.powi(2) + k2 * r.powi(4) + k3 * r.powi(6);
        let bent = [
            x * radial + 2.0 * p1 * x * y + p2 * (3.0 * x * x + y * y),
            y * radial + p1 * (x * x + 3.0 * y * y) + 2.0 * p2 * x * y,
        ];
        let pixel = [0, 1].map(|axis| self.centre_px[axis] + self.focal_px * bent[axis]);
        // The distortion polynomials of the tested lenses fold the image back beyond twice the focal length from the axis, far outside the picture.
        let inside = seen.z > 0.1 && r < 2.0 && (0.0..640.0).contains(&pixel[0]) && (0.0..480.0).contains(&pixel[1]);
        inside.then_some(pixel)
    }

    /// Image of a level edge that runs along `direction_rad` in the world, seen by a robot with the heading `heading_rad`; the edge's ends are
    /// shifted at random by up to their bound.
    fn edge(&self, direction_rad: f64, heading_rad: f64, rng: &mut ChaCha8Rng) -> EdgeLine {
        loop {
            let azimuth = direction_rad - heading_rad;
            let along = Vector3::new(azimuth.cos(), azimuth.sin(), 0.0);
            let from = Vector3::new(
                rng.random_range(0.5..4.0),
                rng.random_range(-3.0..3.0),
                [-0.2, 0.9, 1.8, 2.2][rng.random_range(0..4)],
            );
            let ends = [from, from + along * rng.random_range(0.5..2.5)].map(|place| self.pixel(place));
            let [Some(a), Some(b)] = ends else { continue };
            let length = (b[0] - a[0]).hypot(b[1] - a[1]);
            if length < 45.0 {
                continue;
            }
            let across = [-(b[1] - a[1]) / length, (b[0] - a[0]) / length];
            let moved = [a, b].map(|end| {
                let by = BOUND_PX * [-1.0, 1.0, rng.random_range(-1.0..1.0)][rng.random_range(0..3)];
                [end[0] + by * across[0], end[1] + by * across[1]]
            });
            return EdgeLine { ends_px: moved, bound_px: BOUND_PX };
        }
    }
}

fn union(heading_rad: f64, radius_rad: f64) -> PoseUnion {
    PoseUnion::single(PoseBox::from([Interval::ZERO, Interval::ZERO, Interval::centred(heading_rad, radius_rad)]))
}

/// Number of images of the same edges that make a heading fix. The method also limits how many of its last images may have any wrong edge at all;
/// twelve images are too few for that limit to matter.
const FIX_IMAGES: usize = 12;

/// Headings that remain possible after `FIX_IMAGES` images that show the same edges, while the robot stands still; `None` if the method gives no
/// constraint.
fn fixed(method: &mut Walls, edges: &[EdgeLine], prior: &PoseUnion) -> Option<Vec<Interval>> {
    let mut left = None;
    for _ in 0..FIX_IMAGES {
        left = method
            .constraint(0.0, edges, prior)
            .map(|constraint| constraint.on_pose.branches(&prior.hull()).iter().map(|branch| branch[2]).collect());
    }
    left
}

fn holds(headings: &[Interval], heading_rad: f64) -> bool {
    headings.iter().any(|set| set.contains(heading_rad))
}

#[test]
fn walls_of_two_directions_keep_the_true_heading_with_as_many_edges_wrong_as_declared() {
    let mut rng = ChaCha8Rng::seed_from_u64(1);
    let (mut widths, n_rooms) = (Vec::new(), rounds(200, 600));
    for _ in 0..n_rooms {
        let truth = TrueCamera::draw(&mut rng);
        let heading_rad = rng.random_range(-20.0..20.0);
        let directions = [0.0, 0.35];
        let n_lines = rng.random_range(3..12);
        let n_wrong = rng.random_range(0..=Quotas::default().wrong_of_image(n_lines));
        let edges: Vec<EdgeLine> = (0..n_lines)
            .map(|line| {
                let direction =
                    if line < n_wrong { rng.random_range(0.0..3.2) } else { directions[rng.random_range(0..2)] };
                let quarter = f64::from(rng.random_range(0..2)) * std::f64::consts::FRAC_PI_2;
                truth.edge(direction + quarter, heading_rad, &mut rng)
            })
            .collect();
        let prior = union(heading_rad + rng.random_range(-0.15..0.15), 0.17);
        let mut walls = method(&directions, false);
        // The method uses only a part of the edges, of which more may be wrong than its declared share even where that share of all edges is kept;
        // such rooms are skipped. This image is held and counted by the method in addition to the `FIX_IMAGES` later ones.
        let used = walls.constraint(0.0, &edges, &prior).map_or(Vec::new(), |constraint| constraint.claims);
        let is_wrong = |claim: &&Claim| {
            let Claim::WallLine { ends_px, .. } = claim else { return false };
            edges[..n_wrong].iter().any(|edge| edge.ends_px == *ends_px)
        };
        let n_wrong_used = used.iter().filter(is_wrong).count();
        if n_wrong_used > Quotas::default().wrong_of_image(used.len())
            || (1 + FIX_IMAGES) * n_wrong_used > Quotas::default().wrong_of_held((1 + FIX_IMAGES) * used.len())
        {
            continue;
        }
        let Some(headings) = fixed(&mut walls, &edges, &prior) else { continue };
        assert!(holds(&headings, heading_rad), "heading {heading_rad} is not in {headings:?}");
        widths.push(headings.iter().map(|set| set.width()).sum::<f64>());
    }
    widths.sort_by(f64::total_cmp);
    assert!(widths.len() > n_rooms / 2, "only {} of {n_rooms} rooms gave a heading", widths.len());
    let median_deg = widths[widths.len() / 2].to_degrees();
    assert!(median_deg < 6.0, "the median width is {median_deg}°");
}

#[test]
fn any_quarter_turn_of_the_prior_is_kept_and_none_is_gated() {
    let mut rng = ChaCha8Rng::seed_from_u64(2);
    let truth = TrueCamera::draw(&mut rng);
    let heading_rad = 0.7;
    let edges: Vec<EdgeLine> = (0..6).map(|_| truth.edge(0.0, heading_rad, &mut rng)).collect();
    // The known heading (prior) is 40° off: farther than the 20° within which paper 2 accepts headings, and on the other side of that paper's
    // boundary between quarter turns, at 45°.
    let headings = fixed(&mut method(&[0.0], false), &edges, &union(heading_rad + 0.7, 0.75)).unwrap();
    assert!(holds(&headings, heading_rad), "{headings:?}");
    // Walls repeat every quarter turn, so that a prior heading known to a little more than half a turn leaves three possible headings.
    let headings = fixed(&mut method(&[0.0], false), &edges, &union(heading_rad, 1.6)).unwrap();
    assert!(holds(&headings, heading_rad) && headings.len() >= 3, "{headings:?}");
}

#[test]
fn a_sixth_of_all_edges_and_five_may_be_wrong_and_no_more() {
    let mut rng = ChaCha8Rng::seed_from_u64(3);
    let truth = TrueCamera::draw(&mut rng);
    let good: Vec<EdgeLine> = (0..8).map(|_| truth.edge(0.0, 0.2, &mut rng)).collect();
    // Wrong edges for this test: they appear as edges of the wall would if the robot were turned by another 8.6°.
    let bad: Vec<EdgeLine> = (0..8).map(|_| truth.edge(0.0, 0.35, &mut rng)).collect();
    let prior = union(0.2, 0.3);
    let claimed = |edges: &[EdgeLine]| method(&[0.0], false).constraint(0.0, edges, &prior).unwrap().claims.len();
    let n_images = 12;
    for n_bad in 0..n_images {
        let mut walls = method(&[0.0], false);
        let mut last = None;
        for image in 0..n_images {
            last = walls.constraint(0.0, if image < n_bad { &bad } else { &good }, &prior);
        }
        let (n_wrong, n_right) = (n_bad * claimed(&bad), (n_images - n_bad) * claimed(&good));
        let branches = last.unwrap().on_pose.branches(&prior.hull());
        let is_kept = branches.iter().any(|branch| branch[2].contains(0.2));
        // By hand: of all N edges of the images that the method holds, N/6 + 5 may be wrong; the true heading must be kept just as long as that is
        // so.
        assert_eq!(is_kept, n_wrong <= (n_wrong + n_right) / 6 + 5, "{n_wrong} wrong edges and {n_right} right ones");
    }
}

#[test]
fn each_edge_of_each_image_counts_once() {
    let truth = leaning([0.0; 2]);
    // Six images show the four edges of a wall. Some of these edges are wrong: they appear as if the robot were turned by another 4.6°. By hand: of
    // 24 edges, 24/6 + 5 may be wrong.
    let image = |n_right: usize| -> Vec<EdgeLine> {
        let seen_at = |idx: usize| if idx < n_right { 0.0 } else { 0.08 };
        let rails = [0.8, 1.1, 1.4, 1.7].into_iter().enumerate();
        rails.map(|(idx, z)| sharp(rail(&truth, seen_at(idx), [3.0, 1.3, z], [3.0, -1.3]))).collect()
    };
    for (right, is_enough) in [([4, 4, 3, 3, 0, 0], false), ([4, 4, 4, 3, 0, 0], true)] {
        let prior = union(0.04, 0.08);
        let (mut walls, mut last) = (on_a_body_that_leans(0.0005), None);
        for n_right in right {
            last = walls.constraint(0.0, &image(n_right), &prior);
        }
        let branches = last.unwrap().on_pose.branches(&prior.hull());
        assert_eq!(branches.iter().any(|branch| branch[2].contains(0.0)), is_enough, "{right:?}: {branches:?}");
    }
}

#[test]
fn of_twenty_images_six_have_no_wrong_edge() {
    let truth = leaning([0.0; 2]);
    // The images show six edges of a wall, of which the last one is wrong in some of the images (spoilt images): it appears as if the robot were
    // turned by another 4.6°. The wrong edges are far fewer than the 120/6 + 5 allowed ones, so that only the allowed number of spoilt images
    // matters.
    let image = |is_spoilt: bool| -> Vec<EdgeLine> {
        let rails = [0.8, 1.0, 1.2, 1.4, 1.6, 1.8].into_iter().enumerate();
        let seen_at = |idx: usize| if is_spoilt && idx == 5 { 0.08 } else { 0.0 };
        rails.map(|(idx, z)| sharp(rail(&truth, seen_at(idx), [3.0, 1.3, z], [3.0, -1.3]))).collect()
    };
    for n_spoilt in [0, 14, 15] {
        let prior = union(0.04, 0.08);
        let (mut walls, mut last) = (on_a_body_that_leans(0.0005), None);
        for idx in 0..IMAGES {
            last = walls.constraint(0.0, &image(idx < n_spoilt), &prior);
        }
        let branches = last.unwrap().on_pose.branches(&prior.hull());
        let is_kept = branches.iter().any(|branch| branch[2].contains(0.0));
        assert_eq!(is_kept, IMAGES - n_spoilt >= 6, "{n_spoilt}: {branches:?}");
    }
}

#[test]
fn more_images_in_a_row_that_refute_themselves_than_may_be_spoilt_are_a_contradiction() {
    let truth = leaning([0.0; 2]);
    // One kind of image shows three edges of a wall, each as if the robot had another heading; the other kind shows three edges that agree. Of three
    // edges one may be wrong, and 14 of twenty images may have more wrong edges than that: the 15th must be reported as a contradiction.
    let image = |headings_rad: [f64; 3]| -> Vec<EdgeLine> {
        let rails = [0.8, 1.2, 1.6].into_iter().zip(headings_rad);
        rails.map(|(z, heading_rad)| sharp(rail(&truth, heading_rad, [3.0, 1.3, z], [3.0, -1.3]))).collect()
    };
    let (refuted, sane) = (image([0.0, 0.045, -0.045]), image([0.0; 3]));
    let prior = union(0.0, 0.06);
    let mut walls = on_a_body_that_leans(0.0005);
    for _ in 0..30 {
        assert!(walls.constraint(0.0, &sane, &prior).is_some() && !walls.method.take_contradiction());
    }
    for n_refuted in 1..=15 {
        let told = walls.constraint(0.0, &refuted, &prior);
        assert_eq!(told.is_some(), n_refuted == 15, "{n_refuted}");
        // The method returns a constraint only to report the contradiction: it makes no claims, relies on no declared bounds, and is of the kind that
        // cannot end a doubt.
        assert!(told.is_none_or(|told| told.claims.is_empty() && !told.decides && told.relies_on.is_empty()));
        assert_eq!(walls.method.take_contradiction(), n_refuted == 15, "{n_refuted}");
    }
    assert!(walls.constraint(0.0, &refuted, &prior).is_none() && !walls.method.take_contradiction());
}

#[test]
fn edges_on_the_floor_count_where_they_are_said_to_run_along_walls_and_are_long() {
    let truth = leaning([0.0; 2]);
    let n_claims = |walls: Walls, half_m: f64| {
        let joint = sharp(rail(&truth, 0.0, [2.0, half_m, -0.4], [2.0, -half_m]));
        let edges = [wall(&truth, &[1.2, 1.5, 1.8]), vec![joint]].concat();
        let mut walls = walls;
        walls.constraint(0.0, &edges, &union(0.0, 0.05)).unwrap().claims.len()
    };
    // A joint between floor tiles, seen as an edge 2 m ahead with a focal length of 417 px: 0.4 m take 83 px, too short to be used, and 1 m takes 209
    // px.
    assert_eq!(n_claims(on_a_body_that_leans(0.001), 0.5), 4);
    assert_eq!(n_claims(on_a_body_that_leans(0.001), 0.2), 3);
    let (body, reach) = (
        BodyModel { tilt_rad: 0.001, heave_m: 0.0, clearance_m: 0.1 },
        Reach { speed_m_per_s: 1.0, turn_rate_rad_per_s: 3.0, acceleration_m_per_s2: 3.0 },
    );
    assert_eq!(
        n_claims(
            Walls::of(WallDirections::with(camera([0.0; 5]), &robot(body, reach), &[Interval::ZERO], Setup::default())),
            0.5
        ),
        3
    );
}

#[test]
fn a_level_edge_that_runs_straight_ahead_is_no_upright_one() {
    let truth = leaning([0.0; 2]);
    // The edges run along world x, 5 cm to the left of the camera, on the ceiling and on the floor. The plane through such an edge and the eye is
    // almost upright, so that the edge looks like an upright one.
    let straight = |z: f64| sharp(rail(&truth, 0.0, [1.9, 0.05, z], [4.0, 0.05]));
    let edges = [wall(&truth, &[1.2, 1.5, 1.8]), vec![straight(1.0), straight(-0.4)]].concat();
    let claims = on_a_body_that_leans(0.03).constraint(0.0, &edges, &union(0.0, 0.05)).unwrap().claims;
    assert!(claims.iter().all(|claim| matches!(claim, Claim::WallLine { .. })), "{claims:?}");
}

#[test]
fn no_lean_falls_between_two_squares() {
    let mut rng = ChaCha8Rng::seed_from_u64(10);
    for _ in 0..300 {
        let (about, lean_rad) =
            (rng.random_range(0.0..std::f64::consts::TAU), 0.012 * rng.random_range(0.0..=1.0_f64).sqrt());
        let truth = leaning([lean_rad * about.cos(), lean_rad * about.sin()]);
        let exact = |edge: EdgeLine| EdgeLine { bound_px: 0.001, ..edge };
        let edges: Vec<EdgeLine> = wall(&truth, &[-0.5, 0.8, 1.2, 1.6]).into_iter().map(exact).collect();
        let headings = fixed(&mut on_a_body_that_leans(0.012), &edges, &union(0.0, 0.05)).unwrap();
        assert!(holds(&headings, 0.0), "lean {lean_rad} about {about}: {headings:?}");
    }
}

#[test]
fn images_that_hold_too_few_edges_to_say_anything_end_no_doubt() {
    let mut rng = ChaCha8Rng::seed_from_u64(11);
    let truth = TrueCamera::draw(&mut rng);
    let map = Map {
        room_m: [Interval::new(-2.0, 2.0); 2],
        tiles: None,
        markers: None,
        wall_directions_rad: vec![Interval::ZERO],
        walls: None,
    };
    let robot = RobotModel { forward_camera: Some(camera([0.0; 5])), ..crate::range_landmarks_setup::robot(0, 0) };
    let setup = Setup { solves_lean: true, decides: true, ..Setup::default() };
    let mut walls = Walls::of(WallDirections::new(&map, &robot, setup).unwrap());
    let mut n_held = 0;
    let edges: Vec<EdgeLine> = (0..12).map(|_| truth.edge(0.0, 0.2, &mut rng)).collect();
    for _ in 0..8 {
        let constraint = walls.constraint(0.0, &edges, &union(0.2, 0.1)).unwrap();
        n_held += constraint.claims.iter().filter(|claim| matches!(claim, Claim::WallLine { .. })).count();
        assert_eq!(constraint.decides, n_held >= 20, "{n_held} edges held");
    }
    assert!(n_held > 24, "{n_held}");
}

#[test]
fn images_older_than_those_held_are_forgotten() {
    let mut rng = ChaCha8Rng::seed_from_u64(8);
    let truth = TrueCamera::draw(&mut rng);
    let good: Vec<EdgeLine> = (0..8).map(|_| truth.edge(0.0, 0.2, &mut rng)).collect();
    let bad: Vec<EdgeLine> = (0..8).map(|_| truth.edge(0.0, 0.35, &mut rng)).collect();
    let prior = union(0.2, 0.3);
    let mut walls = method(&[0.0], false);
    let mut last = None;
    for image in 0..2 * IMAGES {
        last = walls.constraint(0.0, if image < IMAGES { &bad } else { &good }, &prior);
    }
    let branches = last.unwrap().on_pose.branches(&prior.hull());
    assert!(branches.iter().any(|branch| branch[2].contains(0.2)), "{branches:?}");
    assert!(!branches.iter().any(|branch| branch[2].contains(0.35)), "{branches:?}");
}

/// A camera without errors of its own, on a robot whose body leans by this rotation about the forward axis and about the left axis.
fn leaning(lean_rad: [f64; 2]) -> TrueCamera {
    let level = Rotation3::from_matrix_unchecked(nalgebra::Matrix3::new(0.0, -1.0, 0.0, 0.0, 0.0, -1.0, 1.0, 0.0, 0.0));
    let tilt = Rotation3::from_axis_angle(&Vector3::y_axis(), -TILT_UP_RAD);
    let lean = Rotation3::from_scaled_axis(Vector3::new(lean_rad[0], lean_rad[1], 0.0));
    TrueCamera {
        focal_px: FOCAL_PX,
        centre_px: CENTRE_PX,
        distortion: [0.0; 5],
        camera_from_robot: level * (lean * tilt).inverse(),
    }
}

fn on_a_body_that_leans(tilt_rad: f64) -> Walls {
    with_mount_error(tilt_rad, 0.0, setup(false))
}

fn with_mount_error(tilt_rad: f64, tilt_error_rad: f64, setup: Setup) -> Walls {
    let body = BodyModel { tilt_rad, heave_m: 0.0, clearance_m: 0.1 };
    let reach = Reach { speed_m_per_s: 1.0, turn_rate_rad_per_s: 3.0, acceleration_m_per_s2: 3.0 };
    let exact = ForwardCameraModel {
        focal_px: Interval::point(FOCAL_PX),
        principal_point_px: CENTRE_PX.map(Interval::point),
        yaw_rad: Interval::ZERO,
        tilt_error_rad,
        ..camera([0.0; 5])
    };
    Walls::of(WallDirections::with(exact, &robot(body, reach), &[Interval::ZERO], setup))
}

fn sharp(edge: EdgeLine) -> EdgeLine {
    EdgeLine { bound_px: 0.1, ..edge }
}

/// Edges of a wall 3 m ahead, at these heights over the camera, seen over the whole width of the image.
fn wall(truth: &TrueCamera, heights_m: &[f64]) -> Vec<EdgeLine> {
    heights_m.iter().map(|&z| sharp(rail(truth, 0.0, [3.0, 1.6, z], [3.0, -1.6]))).collect()
}

#[test]
fn a_lean_is_told_by_low_and_high_edges_together() {
    let width = |heights_m: &[f64]| {
        let edges = wall(&leaning([0.008, -0.004]), heights_m);
        let headings = fixed(&mut on_a_body_that_leans(0.01), &edges, &union(0.0, 0.15)).unwrap();
        assert!(holds(&headings, 0.0), "{headings:?}");
        headings.iter().map(|set| set.width()).sum::<f64>()
    };
    // By hand: for an edge seen at elevation ε, with tan ε = z/3, a roll of ±0.01 turns the edge by ±0.01/tan ε: low edges at −0.6 m by 0.05, and
    // high edges at 1.6 m by 0.019 the other way. Together they leave hardly any room for a roll.
    let (low, high) = (width(&[-0.45, -0.6, -0.75]), width(&[1.4, 1.6, 1.8]));
    let both = width(&[-0.45, -0.6, -0.75, 1.4, 1.6, 1.8]);
    assert!(low > 0.025 && high > 0.015 && both < 0.25 * low.min(high), "{both} of {low} and {high}");
}

#[test]
fn upright_edges_tell_a_lean() {
    let truth = leaning([0.008, -0.004]);
    let level = wall(&truth, &[1.4, 1.6, 1.8]);
    let post = |y: f64| {
        let ends_px = [-0.6, 1.6].map(|z| truth.pixel(Vector3::new(3.0, y, z)).unwrap());
        sharp(EdgeLine { ends_px, bound_px: 0.0 })
    };
    let width = |edges: &[EdgeLine]| {
        let headings = fixed(&mut on_a_body_that_leans(0.01), edges, &union(0.0, 0.15)).unwrap();
        assert!(holds(&headings, 0.0), "{headings:?}");
        headings.iter().map(|set| set.width()).sum::<f64>()
    };
    let (alone, with_posts) = (width(&level), width(&[&level[..], &[post(1.3), post(-1.2), post(0.1)]].concat()));
    assert!(with_posts < 0.5 * alone, "{with_posts} of {alone}");
}

/// Total width of the headings on which all edges of one image agree, by a method for which none of them may be wrong; `None` if the edges give no constraint. Asserts
/// that these headings contain the true one.
fn heading_of_image(mut walls: Walls, edges: &[EdgeLine], heading_rad: f64, prior: &PoseUnion) -> Option<f64> {
    let constraint = walls.constraint(0.0, edges, prior)?;
    let branches = constraint.on_pose.branches(&prior.hull());
    let headings: Vec<Interval> = branches.iter().map(|branch| branch[2]).collect();
    assert!(holds(&headings, heading_rad), "heading {heading_rad} is not in {headings:?}");
    Some(headings.iter().map(|set| set.width()).sum())
}

#[test]
fn behind_a_bent_lens_no_error_of_its_optics_loses_the_heading() {
    let mut rng = ChaCha8Rng::seed_from_u64(13);
    let lenses = [[-0.25, 0.06, 0.0, 0.0, 0.0], [-0.2, 0.05, 0.001, -0.002, 0.0], [0.12, -0.02, 0.0, 0.0, 0.0]];
    let reach = Reach { speed_m_per_s: 1.0, turn_rate_rad_per_s: 3.0, acceleration_m_per_s2: 3.0 };
    let body = BodyModel { tilt_rad: 0.0, heave_m: 0.0, clearance_m: 0.1 };
    let mut n_told = 0;
    for round in 0..rounds(3000, 10_000) {
        let distortion = lenses[round % 3];
        let [centre_off_px, focal_share] = [[5.0, 0.0], [0.2, 0.01], [10.0, 0.02]][round / 3 % 3];
        let told = ForwardCameraModel {
            focal_px: Interval::centred(FOCAL_PX, focal_share * FOCAL_PX),
            principal_point_px: CENTRE_PX.map(|at| Interval::centred(at, centre_off_px)),
            yaw_rad: Interval::ZERO,
            tilt_error_rad: 0.0,
            distortion_px: 1e-9,
            ..camera(distortion)
        };
        let corner = |rng: &mut ChaCha8Rng| [-1.0, 1.0][rng.random_range(0..2)];
        let truth = TrueCamera {
            focal_px: FOCAL_PX * (1.0 + focal_share * corner(&mut rng)),
            centre_px: CENTRE_PX.map(|at| at + centre_off_px * corner(&mut rng)),
            distortion,
            ..leaning([0.0; 2])
        };
        let heading_rad = rng.random_range(-3.0..3.0);
        let edges: Vec<EdgeLine> = (0..6)
            .map(|_| {
                let quarter = f64::from(rng.random_range(0..2)) * std::f64::consts::FRAC_PI_2;
                truth.edge(quarter, heading_rad, &mut rng)
            })
            .collect();
        let prior = union(heading_rad + rng.random_range(-0.1..0.1), 0.12);
        let method = WallDirections::with(told, &robot(body, reach), &[Interval::ZERO], without_wrong_edges());
        let walls = Walls::of(method);
        n_told += usize::from(heading_of_image(walls, &edges, heading_rad, &prior).is_some());
    }
    assert!(n_told > rounds(600, 2000), "{n_told}");
}

#[test]
fn no_lean_of_body_and_mount_loses_the_heading_however_great() {
    let mut rng = ChaCha8Rng::seed_from_u64(14);
    for lean_deg in [0.5_f64, 1.0, 3.0, 10.0, 30.0] {
        let (lean_rad, mut n_told, mut widths) = (lean_deg.to_radians(), 0, 0.0);
        for _ in 0..600 {
            // Half of the robot's lean belongs to the camera's mount, half to the body. The heading is the direction of the body's forward axis, seen
            // from above.
            let mut lean = || {
                let about = rng.random_range(0.0..std::f64::consts::TAU);
                Rotation3::from_scaled_axis(Vector3::new(about.cos(), about.sin(), 0.0) * 0.5 * lean_rad)
            };
            let (body, mount) = (lean(), lean());
            let forward = body * Vector3::x();
            let twist = Rotation3::from_axis_angle(&Vector3::z_axis(), -forward.y.atan2(forward.x));
            let upright = leaning([0.0; 2]);
            let truth = TrueCamera {
                camera_from_robot: upright.camera_from_robot * (twist * body * mount).inverse(),
                ..upright
            };
            let edges: Vec<EdgeLine> = (0..4).map(|_| truth.edge(0.0, 0.3, &mut rng)).collect();
            let walls = with_mount_error(0.5 * lean_rad, 0.5 * lean_rad, without_wrong_edges());
            if let Some(width) = heading_of_image(walls, &edges, 0.3, &union(0.3 + rng.random_range(-0.1..0.1), 0.12)) {
                (n_told, widths) = (n_told + 1, widths + width);
            }
        }
        println!(
            "{lean_deg} deg: {n_told} told, mean width {:.3} deg",
            f64::to_degrees(widths / f64::from(n_told.max(1)))
        );
        assert!(n_told > 200 || lean_deg > 3.0, "{lean_deg} deg: {n_told}");
    }
}

#[test]
fn any_lean_within_its_bound_keeps_the_true_heading() {
    let mut rng = ChaCha8Rng::seed_from_u64(9);
    let mut n_fixes = 0;
    for _ in 0..400 {
        let (about, lean_rad) =
            (rng.random_range(0.0..std::f64::consts::TAU), 0.012 * rng.random_range(0.0..=1.0_f64).sqrt());
        let truth = leaning([lean_rad * about.cos(), lean_rad * about.sin()]);
        let heading_rad = rng.random_range(-3.0..3.0);
        let quarter = |rng: &mut ChaCha8Rng| f64::from(rng.random_range(0..2)) * std::f64::consts::FRAC_PI_2;
        let edges: Vec<EdgeLine> = (0..rng.random_range(3..9))
            .map(|_| {
                let along = quarter(&mut rng);
                truth.edge(along, heading_rad, &mut rng)
            })
            .collect();
        let prior = union(heading_rad + rng.random_range(-0.05..0.05), 0.06);
        if let Some(headings) = fixed(&mut on_a_body_that_leans(0.012), &edges, &prior) {
            assert!(holds(&headings, heading_rad), "heading {heading_rad} is not in {headings:?}");
            n_fixes += 1;
        }
    }
    assert!(n_fixes > 200, "{n_fixes}");
}

#[test]
fn a_direction_is_learnt_no_better_than_the_heading_was_known_and_goes_with_a_doubt() {
    let mut rng = ChaCha8Rng::seed_from_u64(4);
    let truth = TrueCamera::draw(&mut rng);
    let (heading_rad, wall_rad) = (0.1, 0.5);
    let edges: Vec<EdgeLine> = (0..8).map(|_| truth.edge(wall_rad, heading_rad, &mut rng)).collect();
    let mut walls = method(&[0.0], true);
    let known = union(heading_rad + 0.01, 0.015);
    let before = walls.method.knowledge().unwrap();
    let constraint = walls.constraint(2.0, &edges, &known).unwrap();
    walls.method.learn(&constraint.shown.unwrap(), Some(&known));
    let learnt = walls.method.directions_rad().to_vec();
    assert_eq!(learnt.len(), 2, "{learnt:?}");
    let quarters = ((wall_rad - learnt[1].mid()) / std::f64::consts::FRAC_PI_2).round();
    assert!((learnt[1] + Interval::PI * 0.5 * quarters).contains(wall_rad), "{learnt:?}");
    assert!(learnt[1].width() >= 0.03, "narrower than the heading: {learnt:?}");
    walls.method.go_back(&before);
    assert_eq!(walls.method.directions_rad().len(), 1);
}

#[test]
fn of_directions_that_the_edges_leave_open_none_is_learnt() {
    let mut rng = ChaCha8Rng::seed_from_u64(12);
    let (heading_rad, wall_rad) = (0.1, 0.5);
    let mut n_learnt = 0;
    for _ in 0..600 {
        let truth = TrueCamera::draw(&mut rng);
        // Five edges of a direction that is not in the map are the fewest from which it is learnt, and one of them may be wrong. The wrong edge
        // is only a little askew, so that it agrees with some of the others.
        let n_wrong = rng.random_range(0..=1);
        let edges: Vec<EdgeLine> = (0..6)
            .map(|line| {
                let askew_rad = if line < n_wrong { rng.random_range(-0.05..0.05) } else { 0.0 };
                truth.edge(wall_rad + askew_rad, heading_rad, &mut rng)
            })
            .collect();
        let mut walls = method(&[0.0], true);
        let known = union(heading_rad + rng.random_range(-0.004..0.004), 0.005);
        let Some(constraint) = walls.constraint(2.0, &edges, &known) else { continue };
        walls.method.learn(&constraint.shown.unwrap(), Some(&known));
        if let [_, learnt] = *walls.method.directions_rad() {
            n_learnt += 1;
            let quarters = ((wall_rad - learnt.mid()) / std::f64::consts::FRAC_PI_2).round();
            let turned = wall_rad - quarters * std::f64::consts::FRAC_PI_2;
            assert!(learnt.contains(turned), "{turned} is not in {learnt:?}");
        }
    }
    assert!(n_learnt > 150, "{n_learnt}");
}

#[test]
fn images_are_carried_by_the_turn_between_them() {
    let mut rng = ChaCha8Rng::seed_from_u64(5);
    let truth = TrueCamera::draw(&mut rng);
    let mut walls = method(&[0.0], false);
    let mut last = None;
    for image in 0..16 {
        let (stamp_s, heading_rad) = (f64::from(image), 0.2 * f64::from(image));
        let motion = |from_s: f64, to_s: f64| {
            Some(PoseBox::from([Interval::ZERO, Interval::ZERO, Interval::centred(0.2 * (to_s - from_s), 0.001)]))
        };
        let edges: Vec<EdgeLine> = (0..6).map(|_| truth.edge(0.0, heading_rad, &mut rng)).collect();
        last = walls.carried(stamp_s, &edges, &union(heading_rad, 0.1), &motion);
    }
    let constraint = last.unwrap();
    assert!(constraint.claims.iter().all(|claim| matches!(claim, Claim::WallLine { .. })));
    let branches = constraint.on_pose.branches(&union(3.0, 0.1).hull());
    assert!(branches.iter().any(|branch| branch[2].contains(3.0)), "{branches:?}");
    assert!(branches.iter().map(|branch| branch[2].width()).sum::<f64>() < 0.06, "{branches:?}");
}

/// Image of a level edge of the world from one place to another, seen without error.
fn rail(truth: &TrueCamera, heading_rad: f64, from: [f64; 3], to: [f64; 2]) -> EdgeLine {
    let seen = |[x, y, z]: [f64; 3]| {
        let in_robot = Rotation3::from_axis_angle(&Vector3::z_axis(), -heading_rad) * Vector3::new(x, y, z);
        truth.pixel(in_robot).unwrap()
    };
    EdgeLine { ends_px: [seen(from), seen([to[0], to[1], from[2]])], bound_px: BOUND_PX }
}

#[test]
fn both_rims_of_a_board_that_hangs_askew_are_one_wrong_edge_not_two() {
    let truth = TrueCamera::draw(&mut ChaCha8Rng::seed_from_u64(6));
    // The edges are the foot and the head of a wall 3 m ahead, a shelf at the wall's right end, and the two rims of a board in the wall's middle
    // that hangs 2 degrees askew.
    let wall = |z: f64| rail(&truth, 0.0, [3.0, 1.2, z], [3.0, -1.2]);
    let shelf = rail(&truth, 0.0, [2.0, -0.9, 0.9], [3.0, -0.9]);
    let rim = |z: f64| rail(&truth, 0.0, [2.95 - 0.6 * 0.035, 0.6, z], [2.95 + 0.6 * 0.035, -0.6]);
    let edges = [wall(1.9), wall(1.3), shelf, rim(0.66), rim(0.70)];
    let mut walls = method(&[0.0], false);
    let constraint = walls.constraint(0.0, &edges, &union(0.0, 0.05)).unwrap();
    let claimed = |edge: &EdgeLine| {
        let is_it = |claim: &Claim| matches!(claim, Claim::WallLine { ends_px, .. } if *ends_px == edge.ends_px);
        constraint.claims.iter().any(is_it)
    };
    assert_eq!(edges.map(|edge| claimed(&edge))[..3], [true; 3], "{:?}", constraint.claims);
    assert_eq!(usize::from(claimed(&edges[3])) + usize::from(claimed(&edges[4])), 1, "{:?}", constraint.claims);
    // If the method used both rims of the crooked board, two of five edges would be wrong, where only one is declared.
    let headings = fixed(&mut method(&[0.0], false), &edges, &union(0.0, 0.05)).unwrap();
    assert!(holds(&headings, 0.0), "{headings:?}");
}

#[test]
fn edges_a_little_askew_are_clutter_unless_hardly_any_other_is_there() {
    let mut rng = ChaCha8Rng::seed_from_u64(7);
    let truth = TrueCamera::draw(&mut rng);
    let ahead =
        |heading_rad: f64, heights: [f64; 5]| heights.map(|z| rail(&truth, heading_rad, [4.0, 1.0, z], [4.0, -1.0]));
    let (straight, askew) = (ahead(0.0, [0.7, 1.1, 1.5, 1.9, 2.3]), ahead(0.13, [0.9, 1.3, 1.7, 2.1, 2.5]));
    let n_claims = |edges: &[EdgeLine]| {
        let claims = method(&[0.0], false).constraint(0.0, edges, &union(0.0, 0.01)).map(|found| found.claims);
        claims.map_or(0, |claims| claims.len())
    };
    assert_eq!(n_claims(&straight), 5);
    assert_eq!(n_claims(&[&straight[..], &askew[..2]].concat()), 5);
    // Where all five edges in view are seven degrees off the known heading and none agrees with it, that heading may be wrong instead of the edges,
    // so that the edges are used.
    assert_eq!(n_claims(&askew[..4]), 0, "four are too few");
    assert_eq!(n_claims(&askew), 5);
}

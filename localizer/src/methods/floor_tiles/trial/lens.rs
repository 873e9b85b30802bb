//! Tests on pictures of the floor taken through a lens: which lines are found and claimed, and what they say about the pose.

use image::GrayImage;

use super::{
    BARREL, Eye, HEIGHT_M, MIDDLE_PX, PINCUSHION, ROW_TIME_S, SCALE, contracted, known_robot, method, random_pose,
    robot,
};
use interval::{Interval, contractor::Contractor};

use crate::{
    Claim, Method, PoseBox, PoseUnion, Reading, RobotModel,
    method::Context,
    methods::floor_tiles::Chain,
    motion::Twist,
    reading::Camera,
    vision::{self, FloorLine, synthetic::Random},
};

/// Results of the method over a number of pictures.
#[derive(Default)]
struct Tally {
    frames: usize,
    claims: usize,
    false_claims: usize,
    missed: usize,
    /// Number of points of claimed lines that lie beyond the middles of the picture's outermost pixels.
    outside: usize,
    /// Full widths in x, y and heading of each picture's box; `None` for a picture in which no line was found.
    widths: Vec<Option<[f64; 3]>>,
}

impl Tally {
    fn found(&self) -> usize {
        self.widths.iter().flatten().count()
    }

    /// Mean widths of this tally over those of another, from the pictures that have a box in both tallies.
    fn width_over(&self, other: &Tally) -> [f64; 3] {
        let both = || self.widths.iter().zip(&other.widths).filter_map(|(ours, theirs)| Some(((*ours)?, (*theirs)?)));
        [0, 1, 2].map(|axis| {
            both().map(|(ours, _)| ours[axis]).sum::<f64>() / both().map(|(_, theirs)| theirs[axis]).sum::<f64>()
        })
    }

    fn print(&self, name: &str) {
        let mean = [0, 1, 2].map(|axis| {
            self.widths.iter().flatten().map(|width| width[axis]).sum::<f64>() / self.found().max(1) as f64
        });
        println!(
            "{name:28} frames {}  with lines {}  claims {}  false {}  missed {}  outside {}  widths {:.2} mm {:.2} mm {:.2} mrad",
            self.frames,
            self.found(),
            self.claims,
            self.false_claims,
            self.missed,
            self.outside,
            1e3 * mean[0],
            1e3 * mean[1],
            1e3 * mean[2],
        );
    }
}

/// Tallies what the method makes of pictures at random poses; the poses are the same for every lens.
fn trial(name: &str, eye: &Eye, robot: &RobotModel, chain: Chain, frames: usize) -> Tally {
    let (mut method, mut random) = (method(robot, chain), Random::new(5));
    let (rays, mut tally) = (eye.rays(), Tally { frames, ..Tally::default() });
    for frame in 0..frames {
        let (pose, prior) = random_pose(&mut random);
        let image = eye.picture(&rays, pose, &mut Random::new(1000 + frame as u64));
        let reading = floor_reading(image);
        let constraint =
            method.constrain(&reading, &Context { twist: &eye.twist, ..Context::at_rest(&PoseUnion::single(prior)) });
        let width = constraint.map(|constraint| {
            let pose_box = contracted(&constraint, prior);
            tally.missed += usize::from(!pose_box.contains(&pose));
            for claim in &constraint.claims {
                let Claim::FloorJoint { points_px, share_wrong } = claim else { continue };
                tally.claims += 1;
                tally.false_claims += usize::from(!eye.is_true(points_px, *share_wrong, pose));
                let is_outside =
                    |point: &&[f64; 3]| (0..2).any(|axis| (point[axis] - MIDDLE_PX[axis]).abs() > MIDDLE_PX[axis]);
                tally.outside += points_px.iter().filter(is_outside).count();
            }
            [0, 1, 2].map(|axis| pose_box[axis].width())
        });
        tally.widths.push(width);
    }
    tally.print(name);
    tally
}

fn floor_reading(image: GrayImage) -> Reading {
    let (camera, image) = (Camera::Floor, image.into());
    Reading::Camera { measured_s: 0.0, arrived_s: 0.0, camera, exposure_s: 0.0, image }
}

/// Lens coefficients with the first of them changed so that a corner of the image is `off_px` pixels farther out: f·Δk1·1.54³.
fn off_calibration(lens: [f64; 5], off_px: f64) -> [f64; 5] {
    [lens[0] + off_px / (SCALE * HEIGHT_M * 1.54_f64.powi(3)), lens[1], lens[2], lens[3], lens[4]]
}

fn frames(usual: usize) -> usize {
    std::env::var("WHEREIN_VISION_FRAMES").ok().and_then(|text| text.parse().ok()).unwrap_or(usual)
}

#[test]
fn a_lens_that_bends_costs_neither_lines_nor_truth_nor_much_width() {
    for (name, off_px) in [("known", 0.0), ("known to 0.2 px", 0.2)] {
        let run = |title: &str, lens: [f64; 5]| {
            let eye = Eye::with(off_calibration(lens, off_px));
            trial(&format!("{title} {name}"), &eye, &robot(lens, off_px, 0.0), Chain::Direct, frames(12))
        };
        let (plain, barrel) = (run("no lens", [0.0; 5]), run("barrel", BARREL));
        for tally in [&plain, &barrel] {
            assert_eq!((tally.missed, tally.false_claims, tally.outside), (0, 0, 0));
        }
        assert!(barrel.found() * 10 >= plain.found() * 9);
        let ratios = barrel.width_over(&plain);
        println!("widths over those without a lens: {ratios:.3?}");
        assert!(ratios.iter().all(|ratio| *ratio < 1.15), "{ratios:?}");
    }
}

#[test]
fn nothing_but_the_declared_error_of_the_lens_keeps_the_truth_in_the_box() {
    // The true lens differs from its calibration by about a pixel at the corners of the straightened picture; the robot knows everything
    // else.
    let eye = Eye::exact(off_calibration(BARREL, 3.0));
    let run = |name: &str, lens: [f64; 5], off_px: f64| {
        trial(name, &eye, &known_robot(0.0, lens, off_px, 0.0), Chain::Direct, frames(12))
    };
    let declared = run("3 px off, declared", BARREL, 3.0);
    assert_eq!((declared.missed, declared.false_claims), (0, 0));
    assert!(declared.found() >= 11);
    assert!(run("3 px off", BARREL, 0.0).missed > 0);
    // A lens that is not known leaves the joints bent, and a bent line does not count as a joint.
    assert_eq!(run("no lens known", [0.0; 5], 0.0).found(), 0);
}

#[test]
fn a_lens_that_the_model_does_not_know_is_found_out() {
    let pinhole = |factor: f64| known_robot(factor, [0.0; 5], 0.0, 0.0);
    let weak = Eye::exact([0.1 * BARREL[0], 0.0, 0.0, 0.0, 0.0]);
    assert!(trial("weak barrel, unknown", &weak, &pinhole(0.0), Chain::Direct, frames(12)).missed > 0);
    let tally = trial("paper, barrel unknown", &Eye::with(BARREL), &pinhole(1.0), Chain::Paper, frames(8));
    assert!(tally.missed + tally.false_claims > 0);
}

#[test]
fn nothing_is_claimed_beyond_what_a_pincushion_shows() {
    let tally = trial("pincushion", &Eye::with(PINCUSHION), &robot(PINCUSHION, 0.0, 0.0), Chain::Direct, frames(12));
    assert_eq!((tally.missed, tally.false_claims, tally.outside), (0, 0, 0));
    assert!(tally.found() * 10 >= tally.frames * 8);
}

#[test]
fn the_papers_chain_sees_through_a_lens_as_well() {
    for (name, lens) in [("paper, barrel", BARREL), ("paper, pincushion", PINCUSHION)] {
        let tally = trial(name, &Eye::with(lens), &robot(lens, 0.0, 0.0), Chain::Paper, frames(8));
        assert_eq!((tally.missed, tally.false_claims), (0, 0));
        assert!(tally.found() * 10 >= tally.frames * 8);
    }
}

#[test]
fn a_lens_that_does_not_bend_leaves_the_picture_and_its_claims_alone() {
    let (eye, mut random) = (Eye::with([0.0; 5]), Random::new(6));
    let mut method = method(&robot([0.0; 5], 0.0, 0.0), Chain::Direct);
    let (pose, prior) = random_pose(&mut random);
    let image = eye.picture(&eye.rays(), pose, &mut random);
    let lines = vision::direct::detect(&image, &method.view, [0.0; 2], 0.0);
    let constraint = method.constrain(&floor_reading(image), &Context::at_rest(&PoseUnion::single(prior)));
    let constraint = constraint.unwrap_or_else(|| panic!("joints in view"));
    let claimed: Vec<Claim> = lines
        .lines
        .into_iter()
        .map(|FloorLine { points_px, share_wrong, .. }| Claim::FloorJoint { points_px, share_wrong })
        .collect();
    assert_eq!(constraint.claims, claimed);
    assert_eq!(constraint.rejected_px, lines.rejected_px);
}

#[test]
fn rows_taken_one_after_the_other_cost_no_lines_and_no_truth() {
    for (name, speed) in [("rows at 0.5 m/s", [0.5, 0.0, 0.0]), ("rows at 1 rad/s", [0.3, 0.0, 1.0])] {
        let twist = Twist { forward_m_per_s: speed[0], turn_rad_per_s: speed[2] };
        for (lens, twist, least) in [([0.0; 5], twist, 11), (BARREL, twist, 11), (BARREL, Twist::default(), 0)] {
            // In the last case the wheels report no motion: that costs detected lines but makes no claim false.
            let eye = Eye { speed, row_time_s: ROW_TIME_S, twist, ..Eye::with(lens) };
            let tally = trial(name, &eye, &robot(lens, 0.0, ROW_TIME_S), Chain::Direct, frames(12));
            assert_eq!((tally.missed, tally.false_claims), (0, 0));
            assert!(tally.found() >= least);
        }
    }
}

#[test]
fn joints_answer_headings_without_bounds_and_places_far_away_promptly() {
    let (robot, eye) = (robot([0.0; 5], 0.0, 0.0), Eye::with([0.0; 5]));
    let (mut method, mut random) = (method(&robot, Chain::Direct), Random::new(7));
    let (pose, prior) = random_pose(&mut random);
    let image = eye.picture(&eye.rays(), pose, &mut Random::new(1));
    let constraint = method.constrain(
        &floor_reading(image),
        &Context { twist: &eye.twist, ..Context::at_rest(&PoseUnion::single(prior)) },
    );
    let Some(constraint) = constraint else { panic!("no joint is in view") };
    let extremes = |at: f64| {
        [
            Interval::ENTIRE,
            Interval::new(at, f64::INFINITY),
            Interval::new(f64::MIN, f64::MAX),
            Interval::new(at - 500.0, at + 500.0),
            Interval::centred(at, 0.02),
            Interval::new(1e17, 1e17 + 64.0),
            Interval::new(1e300, 1e300),
        ]
    };
    for x in extremes(pose[0]) {
        for y in extremes(pose[1]) {
            for heading in extremes(pose[2]) {
                let domain = PoseBox::from([x, y, heading]);
                let branches = constraint.on_pose.branches(&domain);
                assert!(branches.len() < 100_000 && branches.iter().all(|branch| branch.is_subset_of(&domain)));
                let is_kept = branches.iter().any(|branch| branch.contains(&pose));
                assert!(is_kept || !domain.contains(&pose), "{pose:?} lost of {domain:?}");
            }
        }
    }
}

//! `wall_directions`: heading modulo quarter turns from level edges of walls, ceilings, doors and shelves, seen by a camera that looks ahead.
//!
//! After Yi, Lee and Cho, *A new localization system … using afocal optical flow sensor based sensor fusion* (2018), with sets in place
//! of points. An edge whose ends are claimed to a bound and whose level direction is seen at φ says θ ∈ α + k·π/2 − φ for
//! one of the building's directions α and some k: nearest-k without a gate, as every k that the prior allows stays. At most q of
//! an image's edges may run along none of the directions, and few of the last [`IMAGES_APART`] images may have more such edges: how many
//! is declared ([`Quotas`]). How robot and camera lean turns all edges of an image, each by another angle: where the building's edges are sharp
//! the lean is solved for with them, and the edges of the last [`IMAGES`] images count together, so many of them wrong and in so many images.
//! Directions that no map tells of are learnt as intervals, as wide as the heading was when they were seen.

mod agreement;
mod distinct;
mod edges;
mod headings;
mod held;
mod posture;
mod quotas;
mod sight;

pub use quotas::Quotas;
pub use sight::ray;

use agreement::WallHeadings;
use held::{Certificates, Seen, still};
use posture::{Told, View};
use sight::SightPlane;

use std::collections::VecDeque;

use interval::Interval;

use crate::{
    Map, PoseUnion, Reading, RobotModel, bounds,
    bounds::Assumption,
    method::{Claim, Constraint, Method, MotionBetween},
    motion::Twist,
    quota::Quota,
    reading::Camera,
    robot::{BodyModel, ForwardCameraModel, Reach},
    vision::forward::{self, EdgeLine, Picture, vanishing::Equalisation},
};

/// The declared bounds that a constraint stands on.
pub const RELIES_ON: [Assumption; 9] = [
    bounds::FORWARD_CAMERA_FOCAL,
    bounds::FORWARD_CAMERA_PRINCIPAL_POINT,
    bounds::FORWARD_CAMERA_DISTORTION,
    bounds::FORWARD_CAMERA_YAW,
    bounds::FORWARD_CAMERA_TILT,
    bounds::FORWARD_CAMERA_STAMP,
    bounds::BODY_TILT,
    bounds::WALL_DIRECTIONS_DIRECTION,
    bounds::WALL_DIRECTIONS_ASKEW,
];
/// Images that are held together, carried by the motion between them.
pub const IMAGES: usize = 20;
/// Where an image's edges do not tell the lean together, so many are held.
pub const IMAGES_APART: usize = 10;
/// Fewer level edges of an image say nothing: where a view shows one or two, it shows them for many images, and if they are wrong, all
/// are wrong together.
const FEWEST_LINES: usize = 3;
/// Fewer edges of all images held say nothing together.
const FEWEST_HELD: usize = 20;
/// Where edges count image by image fewer of them may be wrong: their ends are claimed to as many times their bound, 0.12 px and 3 σ.
const APART_BOUNDS: f64 = 1.2;
/// Share of an edge's motion across itself during the exposure by which its ends may be off: other edges blur into it.
const BLUR_SHARE: f64 = 0.25;
/// An edge that would turn the robot by more beyond what the prior allows is clutter: no claim is made of it.
const CLUTTER_RAD: f64 = 0.0524;
/// Where fewer than [`FEWEST_LINES`] edges are as near as that, a prior that is wrong itself shows in edges up to this far off,
const FAR_RAD: f64 = 0.1745;
/// if they are so many.
const FEWEST_FAR: usize = 5;
/// An image from where the last one held was taken shows the same edges, the wrong ones too, and says nothing new: the robot has to
/// have moved so far,
const NEW_PLACE_M: f64 = 0.03;
/// or to have turned so far.
const NEW_PLACE_RAD: f64 = 0.05;
/// A new direction needs as many edges that agree.
const FEWEST_TO_LEARN: usize = 5;
/// A direction is learnt when it is known so well, and no known one is as near.
const NEW_DIRECTION_RAD: f64 = 0.087;
/// A direction that no map tells is surely learnt where it is farther from every known one than this: than how well it has to be known, and how far
/// apart from others. A nearer one may be taken for the known one.
pub const LEARNT_APART_RAD: f64 = 2.0 * NEW_DIRECTION_RAD;

/// How the method looks at images, and whether it learns.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Setup {
    /// What finds level edges.
    pub chain: Chain,
    /// Whether an image's edges tell the body's lean together.
    pub solves_lean: bool,
    /// Whether long edges on the floor run along walls.
    pub floor_edges: bool,
    /// Whether the building may have directions that the map does not tell.
    pub learns: bool,
    /// Whether images end a doubt, as when no other method tells more than they do.
    pub decides: bool,
    /// How many edges may be wrong.
    pub quotas: Quotas,
}

/// What finds level edges in an image.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Chain {
    /// Ours: [`forward::detect`].
    #[default]
    Direct,
    /// The paper's, up to the segments that agree with its vanishing points.
    Paper,
    /// The same with CLAHE.
    PaperByTiles,
}

/// The method; see the module.
#[derive(Clone, Debug)]
pub struct WallDirections {
    camera: ForwardCameraModel,
    chain: Chain,
    decides: bool,
    solves_lean: bool,
    floor_edges: bool,
    quotas: Quotas,
    /// An edge whose direction is known no better, were the lean known, says nothing.
    widest_rad: f64,
    body_tilt_rad: f64,
    stamp_turn_rad: f64,
    directions: Vec<Direction>,
    learns: bool,
    seen: VecDeque<Seen>,
    certificates: Certificates,
    /// Directions from robot forward, in the latest image, of edges that run along no wall known.
    strange_rad: Vec<Interval>,
    /// When that was.
    latest_s: f64,
}

/// One direction of the building modulo quarter turns, from world x counter-clockwise.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Direction {
    direction_rad: Interval,
    /// Stamp of the image that it was learnt from; the map's are known from the beginning.
    since_s: f64,
}

impl WallDirections {
    /// The method for this robot on this map; `None` without a camera that looks ahead.
    pub fn new(map: &Map, robot: &RobotModel, setup: Setup) -> Option<Self> {
        let directions_rad = &map.wall_directions_rad;
        let walls = Self::with(robot.forward_camera?, &robot.body, &robot.reach, directions_rad, setup.learns);
        let Setup { chain, solves_lean, floor_edges, decides, quotas, .. } = setup;
        let is_refitted = solves_lean && chain == Chain::Direct;
        let widest_rad = if is_refitted { sight::WIDEST_REFITTED_RAD } else { sight::WIDEST_RAD };
        Some(WallDirections { chain, solves_lean, floor_edges, quotas, widest_rad, decides, ..walls })
    }

    /// The method for a camera, with the directions that the map tells; `learns` says whether the building may have more.
    pub fn with(
        camera: ForwardCameraModel,
        body: &BodyModel,
        reach: &Reach,
        directions_rad: &[Interval],
        learns: bool,
    ) -> Self {
        let known = |&direction_rad: &Interval| Direction { direction_rad, since_s: f64::NEG_INFINITY };
        WallDirections {
            camera,
            chain: Chain::Direct,
            decides: false,
            solves_lean: false,
            floor_edges: false,
            quotas: Quotas::default(),
            widest_rad: sight::WIDEST_RAD,
            body_tilt_rad: body.tilt_rad,
            stamp_turn_rad: camera.stamp_error_s * reach.turn_rate_rad_per_s,
            directions: directions_rad.iter().map(known).collect(),
            learns,
            seen: VecDeque::new(),
            certificates: Certificates::default(),
            strange_rad: Vec::new(),
            latest_s: f64::NEG_INFINITY,
        }
    }

    /// The same for a building where long edges on the floor run along walls, with a lean that an image's edges tell together.
    pub fn with_floor_edges_and_lean(self) -> Self {
        WallDirections { floor_edges: true, solves_lean: true, ..self }
    }

    /// The same where other numbers of edges may be wrong.
    pub fn with_quotas(self, quotas: Quotas) -> Self {
        WallDirections { quotas, ..self }
    }

    /// What edges found in an image of `stamp_s` say of the pose; `None` when they are too few.
    pub fn constraint(&mut self, stamp_s: f64, lines: &[EdgeLine], prior: &PoseUnion) -> Option<Constraint> {
        let directions_rad = self.directions_rad();
        let edges = self.sorted(lines, prior.hull()[2], &directions_rad);
        self.latest_s = stamp_s;
        self.strange_rad = edges.strange_rad;
        let view = View {
            tilt_rad: self.camera.tilt_error_rad + self.body_tilt_rad,
            yaw_rad: self.camera.yaw_rad.inflate(self.stamp_turn_rad),
            solves_lean: self.solves_lean,
            quotas: self.quotas,
            directions_rad: &directions_rad,
            about: edges.about,
        };
        let planes = |lines: &[EdgeLine]| -> Vec<SightPlane> {
            lines.iter().filter_map(|line| SightPlane::of(line, &self.camera)).collect()
        };
        let Told { agreement, is_upright } = posture::told(&planes(&edges.level), &planes(&edges.upright), &view);
        let n_level = agreement.len();
        // Headings that all but q of the image's own edges allow.
        let own =
            agreement.get((n_level - self.quotas.wrong_of_image(n_level)).saturating_sub(1)).into_iter().flatten();
        let alone = if n_level < FEWEST_LINES { Interval::EMPTY } else { own.fold(Interval::EMPTY, |a, b| a.hull(*b)) };
        if n_level >= FEWEST_LINES {
            let is_spoilt = alone.is_empty() || (self.solves_lean && !is_upright);
            self.certificates.note(is_spoilt, self.most_spoilt());
        }
        if !alone.is_empty() {
            self.seen.push_back(Seen { stamp_s, agreement, moved: still() });
        } else if !(self.learns && self.strange_rad.len() >= FEWEST_TO_LEARN) {
            // Too few edges, or edges that agree on no heading near the prior's: more of them are wrong than declared, and it shows.
            return self.certificates.are_too_many.then(|| self.silent(stamp_s, edges.rejected_px));
        }
        if self.seen.len() > if self.solves_lean { IMAGES } else { IMAGES_APART } {
            self.seen.pop_front();
        }
        let level = edges.level.iter().map(|line| Claim::WallLine { ends_px: line.ends_px, bound_px: line.bound_px });
        let upright =
            edges.upright.iter().map(|line| Claim::UprightLine { ends_px: line.ends_px, bound_px: line.bound_px });
        let held = self.headings_held();
        Some(Constraint {
            method: self.name(),
            stamp_s,
            // Images that say nothing yet agree with anything: they end no doubt.
            decides: self.decides && held.says_something(),
            on_pose: Box::new(held),
            // One image may be spoilt.
            by_itself: Some(Box::new(WallHeadings::silent())),
            relies_on: RELIES_ON.to_vec(),
            claims: level.chain(upright).collect(),
            quota: self.quotas.of_image([n_level, edges.upright.len()], self.seen.len(), self.solves_lean),
            rejected_px: edges.rejected_px,
            alone_heading_rad: (!alone.is_empty()).then_some(alone),
        })
    }

    /// Of so many images in a row at most so many have too many wrong edges.
    fn most_spoilt(&self) -> [usize; 2] {
        if self.solves_lean { [IMAGES, self.quotas.spoilt_images] } else { [IMAGES_APART, self.quotas.images] }
    }

    /// A constraint that says nothing, so that a contradiction is asked for.
    fn silent(&self, stamp_s: f64, rejected_px: Vec<[f64; 4]>) -> Constraint {
        Constraint {
            method: self.name(),
            stamp_s,
            on_pose: Box::new(WallHeadings::silent()),
            by_itself: None,
            relies_on: Vec::new(),
            claims: Vec::new(),
            quota: Quota::of_each(0),
            decides: false,
            rejected_px,
            alone_heading_rad: None,
        }
    }

    /// What the images held say together.
    fn headings_held(&self) -> WallHeadings {
        if self.solves_lean {
            return WallHeadings::of_edges(self.seen.iter().map(|seen| seen.now().collect()).collect(), &self.quotas);
        }
        let of_image = |seen: &Seen| {
            let n_level = seen.agreement.len();
            seen.now().nth((n_level - self.quotas.wrong_of_image(n_level)).saturating_sub(1)).unwrap_or_default()
        };
        WallHeadings::of_images(self.seen.iter().map(of_image).collect(), &self.quotas)
    }

    /// Whether the robot stands elsewhere than at the last image held.
    fn is_new_place(&self) -> bool {
        self.seen.back().is_none_or(|last| {
            let [forward_m, left_m, turned_rad] = [0, 1, 2].map(|axis| last.moved[axis].mid());
            forward_m.hypot(left_m) >= NEW_PLACE_M || turned_rad.abs() >= NEW_PLACE_RAD
        })
    }

    /// The building's directions as known now, modulo quarter turns.
    pub fn directions_rad(&self) -> Vec<Interval> {
        self.directions.iter().map(|direction| direction.direction_rad).collect()
    }
}

impl Method for WallDirections {
    fn name(&self) -> &'static str {
        "wall_directions"
    }

    fn tells_heading_only(&self) -> bool {
        true
    }

    fn reads(&self, reading: &Reading) -> bool {
        matches!(reading, Reading::Camera { camera: Camera::Forward, .. })
    }

    fn carry_to(&mut self, stamp_s: f64, motion: MotionBetween) {
        // Each is carried at once from where it was taken; one that the memory of motion does not reach is given up.
        self.seen.retain_mut(|seen| {
            let moved = if seen.stamp_s == stamp_s { Some(still()) } else { motion(seen.stamp_s, stamp_s) };
            let is_known = moved.is_some_and(|moved| !moved.is_empty());
            seen.moved = moved.filter(|_| is_known).unwrap_or(seen.moved);
            is_known
        });
    }

    fn constrain(&mut self, reading: &Reading, prior: &PoseUnion, twist: &Twist) -> Option<Constraint> {
        let Reading::Camera { measured_s, camera: Camera::Forward, exposure_s, image, .. } = reading else {
            return None;
        };
        if !self.is_new_place() {
            return None;
        }
        let picture = Picture::from(image);
        let by_paper =
            |equalisation| forward::detect_as_printed(&picture, equalisation, |pixel| sight::ray(pixel, &self.camera));
        let mut lines = match self.chain {
            Chain::Direct => forward::detect(&picture),
            Chain::Paper => by_paper(Equalisation::Whole),
            Chain::PaperByTiles => by_paper(Equalisation::ByTiles),
        };
        // Turning moves the image sideways, by the focal length times the angle in its middle.
        let moved_px = self.camera.focal_px.mid() * (twist.turn_rad_per_s * exposure_s).abs();
        for line in &mut lines {
            let [[_, v0], [_, v1]] = line.ends_px;
            line.bound_px *= if self.solves_lean { 1.0 } else { APART_BOUNDS };
            line.bound_px += BLUR_SHARE * moved_px * (v1 - v0).abs() / sight::length_px(line);
        }
        self.constraint(*measured_s, &lines, prior)
    }

    fn learn(&mut self, posterior: &PoseUnion, _motion: MotionBetween) {
        let heading = posterior.hull()[2];
        if !self.learns || self.strange_rad.len() < FEWEST_TO_LEARN || heading.is_empty() {
            return;
        }
        // α = θ + φ up to quarter turns: as wide as the heading and the edges together, never less.
        let quarter = Interval::PI * 0.5;
        let any = Interval::new(-0.1, quarter.hi() + 0.1);
        let turned: Vec<Vec<Interval>> =
            self.strange_rad.iter().map(|&azimuth| headings::of_line(azimuth * -1.0, &[Interval::ZERO], any)).collect();
        let agreed = headings::agreed(&turned, turned.len() - self.quotas.wrong_of_image(turned.len()));
        let Some(azimuth) = one_direction(&agreed) else { return };
        let direction_rad = azimuth + heading;
        let near = |known: Interval| {
            let quarters = ((known.mid() - direction_rad.mid()) / quarter.mid()).round();
            !(direction_rad + quarter * quarters).inflate(NEW_DIRECTION_RAD).is_disjoint_from(known)
        };
        if direction_rad.width() <= NEW_DIRECTION_RAD && !self.directions_rad().into_iter().any(near) {
            self.directions.push(Direction { direction_rad, since_s: self.latest_s });
        }
    }

    fn forget_since(&mut self, since_s: f64) {
        self.directions.retain(|direction| direction.since_s <= since_s);
        // What was carried by motion that is doubted now is where nobody knows.
        self.seen.clear();
        self.certificates = Certificates::default();
    }

    fn take_contradiction(&mut self) -> bool {
        let are_too_many = self.certificates.are_too_many;
        if are_too_many {
            self.certificates = Certificates::default();
        }
        are_too_many
    }

    fn clock_set_back(&mut self) {
        self.seen.clear();
        self.directions.iter_mut().for_each(|direction| direction.since_s = f64::NEG_INFINITY);
    }
}

/// The direction that all sets are, but for quarter turns; `None` where they are several, and nobody knows which.
fn one_direction(sets: &[Interval]) -> Option<Interval> {
    let quarter = Interval::PI * 0.5;
    let (&first, others) = sets.split_first()?;
    others.iter().try_fold(first, |direction, &set| {
        let again = set - quarter;
        (!again.is_disjoint_from(first)).then(|| direction.hull(again))
    })
}

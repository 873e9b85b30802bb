//! `wall_bearings`: a method that bounds the pose by upright edges of mapped walls, seen by a camera that looks ahead.
//!
//! **Constraint.** Corners of walls that stand out into a room, as at the ends of free walls, are upright. The image of one tells its bearing, that
//! is, the direction in which it is seen from robot forward, whatever the lean. With the edge at P on the map, within the walls' placement, and the
//! bearing β, the pose (t, θ) obeys P = t + R(θ)·a + s·(cos(θ + β), sin(θ + β)) for some distance s > 0, where a is the place of the camera on the
//! robot. Nothing in the image says which edge of the map it shows, or that it shows any: it may be a bookcase, the frame of a picture, a person.
//! Therefore:
//!
//! 1. Image edges that would end lower than the tallest thing in the room, if they were the edge of the map, are left out.
//! 2. Before an image is used, the pose is known to a box, or to several. Each pair of an image edge and an edge of the map that is possible from
//!    there is listed. Pairs that have an edge in common form one *sighting*. The claim of a sighting is that at least one of its pairs is right.
//! 3. The sightings of the last [`IMAGES`] images, carried by the robot's motion between them, are counted together. Of them a declared share, and
//!    a declared number in addition, may be false ([`Quotas`]). Poses stay that all others allow, whichever they are (a q-relaxed intersection).
//!
//! **Sound.** Each strip of poses encloses every pose at which its pair is right, while the declared bounds hold. The truth is in a strip of each
//! true sighting, hence in what is left, if no more sightings are false than declared. Which pairs are listed matters to whether a sighting is
//! true, and not to that.
//!
//! **Source.** M. Kieffer, L. Jaulin, É. Walter, D. Meizel, "Robust autonomous robot localization using interval analysis", Reliable Computing 6
//! (2000), match sonar distances to walls of a map without knowing which is which, with outliers. The q-relaxed intersection is that of L. Jaulin,
//! "Robust set-membership state estimation", Automatica 45 (2009).

mod bearing;
mod matches;
mod posts;
mod strips;

use std::sync::Arc;

use interval::{
    Interval, IntervalBox,
    contractor::{Contractor, Outcome, settle},
};

use crate::{
    PoseBox, PoseUnion, Reading,
    bounds::{self, Assumption},
    map::{Wall, WallMap},
    method::{Claim, Constraint, Context, Earlier, Method},
    quota::{Counting, Quota, share_of},
    reading::Camera,
    robot::{ForwardCameraModel, RobotModel},
    vision::forward::{self, EdgeLine, Picture},
};

use super::{
    readout::{Readout, Tells},
    sight::elevation_of,
    wall_directions::{BLUR_SHARE, is_new_place},
};

use matches::{Atlas, ImageEdge, Sighting};
use posts::{Post, posts};
use strips::{Sightings, Strip};

/// Declared bounds that every constraint from upright edges relies on.
pub const RELIES_ON: [Assumption; 12] = [
    bounds::FORWARD_CAMERA_FOCAL,
    bounds::FORWARD_CAMERA_PRINCIPAL_POINT,
    bounds::FORWARD_CAMERA_DISTORTION,
    bounds::FORWARD_CAMERA_POSITION,
    bounds::FORWARD_CAMERA_HEIGHT,
    bounds::FORWARD_CAMERA_YAW,
    bounds::FORWARD_CAMERA_TILT,
    bounds::FORWARD_CAMERA_STAMP,
    bounds::WALLS_PLACEMENT,
    bounds::BODY_TILT,
    bounds::REACH_SPEED,
    bounds::REACH_TURN_RATE,
];
/// Number of latest images with sightings that are counted together.
pub const IMAGES: usize = 12;
/// Least number of sightings held for them to be counted: of few, all may show the same thing, and be wrong together.
const FEWEST_HELD: usize = 6;
/// Factor on the bound of an image edge's ends: an image has few upright edges, so that they are claimed with a wider bound than level ones.
const UPRIGHT_BOUNDS: f64 = 1.5;
/// Greatest width in x and y, and in heading, of a box of poses for which edges are matched: from a wider one nearly all may be any.
const WIDEST: [f64; 3] = [1.0, 1.0, 0.2];
/// Greatest number of branches of a union for which edges are matched.
const MOST_BRANCHES: usize = 16;

/// Declared greatest numbers of sightings that may be false, so that no image edge in them shows the edge of the map that it may be.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Quotas {
    /// Share of the sightings of [`IMAGES`] images that may be false.
    pub held_share: f64,
    /// Number of sightings that may be false in addition, for clutter that is in view for a while.
    pub held_more: usize,
}

impl Default for Quotas {
    /// Default quotas, about twice the false sightings of rendered rooms: in drives of `scenes/home_bearings.toml` 2 to 8 % of the sightings were
    /// false, and of those of a room with two partitions and a free wall 0 to 3 of 46.
    fn default() -> Self {
        Quotas { held_share: 0.15, held_more: 1 }
    }
}

impl Quotas {
    /// Greatest number of sightings, of so many in all images held, that may be false.
    fn wrong_of(&self, held: usize) -> usize {
        share_of(self.held_share, held) + self.held_more
    }
}

/// Settings of the method: which image edges are used, and how many sightings may be false.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Setup {
    /// Height above the floor up to which things in the room have upright edges: lower edges are not taken for edges of walls.
    pub tallest_thing_m: f64,
    /// Declared quotas of false sightings.
    pub quotas: Quotas,
}

impl Default for Setup {
    fn default() -> Self {
        Setup { tallest_thing_m: 2.0, quotas: Quotas::default() }
    }
}

/// The sightings of one image, each with its pairs.
type Pairs = Vec<Vec<Pair>>;

/// A pair of an image edge and an edge of the map: the edge's bearing and the place on the map.
#[derive(Clone, Copy, Debug)]
struct Pair {
    bearing: Interval,
    post_m: [f64; 2],
}

/// Method that bounds the pose by upright edges of walls; the module's page says how.
#[derive(Clone, Debug)]
pub struct WallBearings {
    camera: ForwardCameraModel,
    /// Place from which the camera sees, in the robot frame, at any lean and at any time within the error of the stamp.
    eye_m: [Interval; 2],
    height_m: f64,
    stamp_turn_rad: f64,
    readout: Readout,
    body_tilt_rad: f64,
    walls: Arc<[Wall]>,
    posts: Arc<[Post]>,
    placement_m: f64,
    setup: Setup,
}

impl WallBearings {
    /// Makes the method for a robot with a camera, among the walls of a map.
    pub fn new(camera: ForwardCameraModel, walls: &WallMap, setup: Setup, robot: &RobotModel) -> Self {
        let late = Interval::point(camera.stamp_error_s);
        let moved = late * Interval::point(robot.reach.speed_m_per_s);
        let shifted = robot.body.most_leant_m(camera.position_m, camera.height_m.magnitude()) + moved;
        let turned = late * Interval::point(robot.reach.turn_rate_rad_per_s);
        // The place of the camera turns with the robot within the error of the stamp.
        let lever =
            Interval::point(camera.position_m[0].magnitude()) + Interval::point(camera.position_m[1].magnitude());
        let shifted = shifted + lever * turned;
        WallBearings {
            camera,
            eye_m: camera.position_m.map(|side| side.inflate(shifted.hi())),
            height_m: camera.height_m.mid(),
            stamp_turn_rad: turned.hi(),
            readout: Readout::of(&camera, robot),
            body_tilt_rad: robot.body.tilt_rad,
            walls: walls.walls.clone().into(),
            posts: posts(&walls.walls).into(),
            placement_m: walls.placement_m,
            setup,
        }
    }

    /// Constraint on the pose by the edges of an image with the given stamp, and by the earlier images; `None` when no edge may be one of the map.
    pub fn constraint(
        &self,
        stamp_s: f64,
        lines: &[EdgeLine],
        prior: &PoseUnion,
        earlier: &[Earlier],
    ) -> Option<Constraint> {
        let is_known = |branch: &PoseBox| (0..3).all(|axis| branch.width(axis) <= WIDEST[axis]);
        if prior.branches.len() > MOST_BRANCHES || !prior.branches.iter().all(is_known) {
            return None;
        }
        let bearing = |line: &EdgeLine| {
            let line = EdgeLine { bound_px: UPRIGHT_BOUNDS * line.bound_px, ..*line };
            let bearing = bearing::bearing(&line, &self.camera, self.body_tilt_rad)?;
            Some((line, ImageEdge { bearing: bearing.inflate(self.stamp_turn_rad), ends_at: self.ends_at(&line) }))
        };
        let (upright, edges): (Vec<EdgeLine>, Vec<ImageEdge>) = lines.iter().filter_map(bearing).unzip();
        let atlas = Atlas {
            posts: &self.posts,
            walls: &self.walls,
            placement_m: self.placement_m,
            eye_m: self.eye_m,
            height_m: self.height_m,
            tallest_thing_m: self.setup.tallest_thing_m,
        };
        let sightings = atlas.sightings(&edges, prior);
        if sightings.is_empty() {
            return None;
        }
        let pairs = |sighting: &Sighting| -> Vec<Pair> {
            let pair =
                |&[edge, post]: &[usize; 2]| Pair { bearing: edges[edge].bearing, post_m: self.posts[post].at_m };
            sighting.pairs.iter().map(pair).collect()
        };
        let shown = Arc::new(sightings.iter().map(pairs).collect::<Pairs>());
        let latest = Earlier::latest(stamp_s, Arc::clone(&shown) as _);
        let is_used = |edge: usize| sightings.iter().any(|sighting| sighting.edges.contains(&edge));
        let rejected = upright.iter().enumerate().filter(|(edge, _)| !is_used(*edge));
        let claim = |sighting: &Sighting| Claim::WallUpright {
            lines: sighting.edges.iter().map(|&edge| (upright[edge].ends_px, upright[edge].bound_px)).collect(),
            posts_m: sighting.posts.iter().map(|&post| self.posts[post].at_m).collect(),
        };
        let quotas = self.setup.quotas;
        let Quotas { held_share: share, held_more: more } = quotas;
        Some(Constraint {
            relies_on: RELIES_ON.to_vec(),
            claims: sightings.iter().map(claim).collect(),
            quota: Quota {
                items: quotas.wrong_of(sightings.len()),
                things: 0,
                upright: 0,
                counting: Counting::Together { of: IMAGES, share, more, readings: IMAGES },
            },
            rejected_px: rejected.map(|(_, line)| segment_px(line)).collect(),
            // Without the images before, more sightings of an image may be false than its share, so that it says nothing by itself.
            by_itself: Some(Box::new(ByEdges::default())),
            decides: false,
            shown: Some(shown),
            is_held: true,
            ..Constraint::new(NAME, stamp_s, self.by_edges(earlier.iter().chain([&latest]), prior.branches.len()))
        })
    }

    /// The contractor by the sightings of several images, for a union of so many boxes.
    fn by_edges<'a>(&self, images: impl Iterator<Item = &'a Earlier>, n_boxes: usize) -> ByEdges {
        let mut each = Vec::new();
        for image in images {
            // The robot has moved since: the eye of the image as seen from where the robot is now.
            let turned = image.moved[2];
            let [forward, left] = [0, 1].map(|axis| self.eye_m[axis] - image.moved[axis]);
            let (sin, cos) = (turned.sin(), turned.cos());
            let eye_m = [cos * forward + sin * left, cos * left - sin * forward];
            let strip = |pair: &Pair| Strip {
                bearing: pair.bearing - turned,
                eye_m,
                post_m: pair.post_m,
                placement_m: self.placement_m,
            };
            let sightings = image.shown::<Pairs>().into_iter().flatten();
            each.extend(sightings.map(|pairs| pairs.iter().map(strip).collect::<Vec<Strip>>()));
        }
        if each.len() < FEWEST_HELD {
            return ByEdges::default();
        }
        let most_wrong = self.setup.quotas.wrong_of(each.len());
        ByEdges { sightings: Sightings { each, most_wrong }, n_boxes }
    }

    /// Tangent of the elevation at which the upper end of an image edge is seen; `None` where the edge may go on beyond the image's upper border.
    fn ends_at(&self, line: &EdgeLine) -> Option<f64> {
        let [a, b] = line.ends_px;
        let upper = if a[1] <= b[1] { a } else { b };
        if upper[1] <= forward::GOES_ON_PX { None } else { elevation_of(upper, &self.camera) }
    }
}

/// The method's name in scenes, summaries and tables.
const NAME: &str = "wall_bearings";

impl Method for WallBearings {
    fn name(&self) -> &'static str {
        NAME
    }

    fn reads(&self, reading: &Reading) -> bool {
        matches!(reading, Reading::Camera { camera: Camera::Forward, .. })
    }

    fn n_earlier(&self) -> usize {
        IMAGES - 1
    }

    fn constrain(&mut self, reading: &Reading, context: &Context) -> Option<Constraint> {
        let Reading::Camera { measured_s, camera: Camera::Forward, exposure_s, image, .. } = reading else {
            return None;
        };
        if self.posts.is_empty() || !is_new_place(context.earlier) {
            return None;
        }
        let mut lines = forward::detect(&Picture::from(&**image));
        // A turn of the robot during the exposure moves upright edges sideways, in the image's middle by the focal length times the angle turned.
        let moved_px = self.camera.focal_px.mid() * (context.twist.turn_rad_per_s * exposure_s).abs();
        lines.iter_mut().for_each(|line| line.bound_px += BLUR_SHARE * moved_px);
        let lines = self.readout.at_stamp(lines, Tells::Bearing, *measured_s, context.motion);
        self.constraint(*measured_s, &lines, context.prior, context.earlier)
    }
}

/// Contractor by the sightings of several images; without sightings it rules nothing out.
#[derive(Clone, Debug, Default)]
struct ByEdges {
    sightings: Sightings,
    n_boxes: usize,
}

impl Contractor<3> for ByEdges {
    fn contract(&self, domain: &mut IntervalBox<3>) -> Outcome {
        let is_known = |axis: usize| domain[axis].is_bounded() && domain.width(axis) <= WIDEST[axis];
        let left = if !domain.is_empty() && (0..3).all(is_known) {
            self.sightings.contracted(domain, self.n_boxes)
        } else {
            *domain
        };
        settle(domain, left, "too few upright edges of the image are edges of walls")
    }
}

fn segment_px(line: &EdgeLine) -> [f64; 4] {
    let [[u0, v0], [u1, v1]] = line.ends_px;
    [u0, v0, u1, v1]
}

#[cfg(test)]
mod trial;

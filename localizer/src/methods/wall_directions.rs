//! `wall_directions`: a method that bounds the heading modulo quarter turns by level edges of walls, ceilings, doors and shelves, seen by a camera
//! that looks ahead.
//!
//! The method follows Yi, Lee and Cho, *A new localization system … using afocal optical flow sensor based sensor fusion* (2018), with sets in place
//! of points. An edge whose ends in the image are claimed within a bound, and whose level direction is seen at the angle φ from robot forward,
//! implies for the heading θ ∈ α + k·π/2 − φ, for one of the building's directions α and some whole number k. The paper takes the nearest k within a
//! gate; here every k is kept that the prior, the pose known before the image, allows.
//!
//! At most q of an image's edges may run along none of the directions, and only few of the last [`IMAGES_APART`] images may have more such edges: how
//! many is declared ([`Quotas`]). The lean of robot and camera turns the directions of all edges of an image, each by another angle. Where the
//! building's edges are sharp, the lean is solved for together with the heading, and the edges of the last [`IMAGES`] images are counted together: a
//! declared number of them may be wrong, in a declared number of images. Directions that no map gives are learnt as intervals, as wide as the
//! interval of the heading was when they were seen.

mod agreement;
mod distinct;
mod edges;
mod headings;
mod held;
mod learnt;
mod posture;
mod quotas;

pub use super::sight::ray;
pub use quotas::Quotas;

use agreement::WallHeadings;
use held::{Certificates, EdgeCounts, headings_now};
use posture::{Agreement, Told, View};

use std::sync::Arc;

use super::{
    readout::{Readout, Tells},
    sight::{self, SightPlane},
};

use interval::Interval;

use crate::{
    Map, PoseBox, PoseUnion, Reading, RobotModel, bounds,
    bounds::Assumption,
    method::{Claim, Constraint, Context, Earlier, Memory, Method, Restricts},
    reading::Camera,
    robot::ForwardCameraModel,
    vision::forward::{self, EdgeLine, Picture, vanishing::Equalisation},
};

/// Declared bounds that a constraint from wall directions relies on.
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
/// Number of latest images whose edges are evaluated together; they are carried by the robot's motion between the images.
pub const IMAGES: usize = 20;
/// Number of latest images that are held where the edges of one image are not used to solve for the lean of robot and camera.
pub const IMAGES_APART: usize = 10;
/// Least number of level edges for an image to be used: where a view shows one or two edges, it shows them for many images, and if they run along no
/// direction of the building, all those images are wrong together.
const FEWEST_LINES: usize = 3;
/// Least number of edges in all images held for the edges to be counted together.
const FEWEST_HELD: usize = 20;
/// Factor on the bound of an edge's ends where wrong edges are counted image by image. Fewer edges may then be wrong, so that the bound is wider:
/// 0.12 px plus 3 standard deviations of the error that image noise gives the ends.
const APART_BOUNDS: f64 = 1.2;
/// Share of an edge's motion across itself during the exposure that is added to the bound on its ends, because other edges blur into the edge.
pub(super) const BLUR_SHARE: f64 = 0.25;
/// Greatest angle between the headings that the prior (the pose known before the image) allows and the heading that an edge implies. An edge that
/// implies a heading farther off is taken for clutter, which runs along no wall, and no claim is made of it.
const CLUTTER_RAD: f64 = 0.0524;
/// Greatest angle between the headings that the prior (the pose known before the image) allows and those that edges may imply, where fewer than
/// [`FEWEST_LINES`] edges imply headings within [`CLUTTER_RAD`]: there the prior itself may be wrong.
const FAR_RAD: f64 = 0.1745;
/// Least number of edges that imply headings within [`FAR_RAD`] of the prior's (those known before the image) for these edges to be used.
const FEWEST_FAR: usize = 5;
/// Distance that the robot must have moved since the last image that is held for a new image to be used: an image from the same place shows the same
/// edges, the wrong ones too, and says nothing new.
const NEW_PLACE_M: f64 = 0.03;
/// Angle that the robot must have turned since the last image that is held for a new image to be used, if it has not moved far enough.
const NEW_PLACE_RAD: f64 = 0.05;
/// Least number of agreeing edges from which a new direction of the building is learnt.
const FEWEST_TO_LEARN: usize = 5;
/// Greatest width of the interval for a building's direction that is learnt, and least angle between it and every direction that is known.
const NEW_DIRECTION_RAD: f64 = 0.087;
/// Angle from every known direction of the building beyond which a direction that no map gives is surely learnt: the greatest width of its interval
/// for it to be learnt, plus the least angle to known directions. A direction nearer than that may be taken for the known one.
pub const LEARNT_APART_RAD: f64 = 2.0 * NEW_DIRECTION_RAD;

/// Settings of the wall-direction method: how images are evaluated, and whether directions are learnt.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Setup {
    /// Chain of image operations that finds level edges.
    pub chain: Chain,
    /// Whether the lean of robot and camera is solved for from all edges of an image together.
    pub solves_lean: bool,
    /// Whether the method may assume that long edges on the floor run along walls of this building.
    pub floor_edges: bool,
    /// Whether the building may have directions that the map does not give.
    pub learns: bool,
    /// Whether images of walls may end a doubt about a failed assumption; meant for a localizer in which no other method says more about the pose
    /// than these images.
    pub decides: bool,
    /// Declared quotas: how many image edges may be wrong, running along none of the building's directions.
    pub quotas: Quotas,
}

/// Chain of image operations that finds level edges in an image.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Chain {
    /// The project's own chain to find level edges: [`forward::detect`].
    #[default]
    Direct,
    /// The chain of Yi, Lee and Cho (2018), which equalises the histogram of the whole picture, up to the segments that agree with the vanishing
    /// points that it finds.
    Paper,
    /// The chain of Yi, Lee and Cho (2018) with CLAHE, which equalises the histogram tile by tile instead of over the whole picture.
    PaperByTiles,
}

/// What one image showed.
struct Image {
    /// The headings on which its level edges agree.
    agreement: Agreement,
    /// Directions from robot forward of edges that run along no known wall.
    strange_rad: Vec<Interval>,
}

/// Method that bounds the heading by directions of walls; the module's page says how.
#[derive(Clone, Debug)]
pub struct WallDirections {
    camera: ForwardCameraModel,
    chain: Chain,
    decides: bool,
    solves_lean: bool,
    floor_edges: bool,
    quotas: Quotas,
    /// Greatest width of the interval of an image edge's direction with which the edge is used. The interval is computed for a known lean of robot
    /// and camera, from the errors of the edge's ends alone.
    widest_rad: f64,
    body_tilt_rad: f64,
    stamp_turn_rad: f64,
    readout: Readout,
    /// Directions of the building modulo quarter turns, from world x counter-clockwise: those of the map, and those that were learnt.
    directions_rad: Vec<Interval>,
    learns: bool,
    certificates: Certificates,
    n_edges: EdgeCounts,
}

impl WallDirections {
    /// Makes the wall-direction method for a robot and a map; `None` without a camera that looks ahead.
    pub fn new(map: &Map, robot: &RobotModel, setup: Setup) -> Option<Self> {
        Some(Self::with(robot.forward_camera?, robot, &map.wall_directions_rad, setup))
    }

    /// Makes the wall-direction method for a robot with a camera, with the directions that the map gives.
    pub fn with(camera: ForwardCameraModel, robot: &RobotModel, directions_rad: &[Interval], setup: Setup) -> Self {
        let Setup { chain, solves_lean, floor_edges, learns, decides, quotas } = setup;
        let is_refitted = solves_lean && chain == Chain::Direct;
        WallDirections {
            camera,
            chain,
            decides,
            solves_lean,
            floor_edges,
            quotas,
            widest_rad: if is_refitted { sight::WIDEST_REFITTED_RAD } else { sight::WIDEST_RAD },
            body_tilt_rad: robot.body.tilt_rad,
            stamp_turn_rad: camera.stamp_error_s * robot.reach.turn_rate_rad_per_s,
            readout: Readout::of(&camera, robot),
            directions_rad: directions_rad.to_vec(),
            learns,
            certificates: Certificates::default(),
            n_edges: EdgeCounts::default(),
        }
    }

    /// Constraint on the heading from the edges found in an image with the stamp `stamp_s`, and from the earlier images; `None` when the edges are too
    /// few.
    pub fn constraint(
        &mut self,
        stamp_s: f64,
        lines: &[EdgeLine],
        prior: &PoseUnion,
        earlier: &[Earlier],
    ) -> Option<Constraint> {
        let directions_rad = self.directions_rad.clone();
        let edges = self.sorted(lines, prior.hull()[2], &directions_rad);
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
        // Headings that this image's own edges allow when as many of the edges are wrong as the quota of one image declares.
        let own =
            agreement.get((n_level - self.quotas.wrong_of_image(n_level)).saturating_sub(1)).into_iter().flatten();
        let alone = if n_level < FEWEST_LINES { Interval::EMPTY } else { own.fold(Interval::EMPTY, |a, b| a.hull(*b)) };
        if n_level >= FEWEST_LINES {
            let is_spoilt = alone.is_empty() || (self.solves_lean && !is_upright);
            self.certificates.note(is_spoilt, self.most_spoilt());
        }
        if alone.is_empty() && !(self.learns && edges.strange_rad.len() >= FEWEST_TO_LEARN) {
            // The edges are too few, or agree on no heading near those known before the image. In the second case more edges are wrong than the quota
            // declares, and it is counted in how many of the latest images that is so.
            return self.certificates.are_too_many.then(|| self.silent(stamp_s, edges.rejected_px));
        }
        let level = edges.level.iter().map(|line| Claim::WallLine { ends_px: line.ends_px, bound_px: line.bound_px });
        let upright =
            edges.upright.iter().map(|line| Claim::UprightLine { ends_px: line.ends_px, bound_px: line.bound_px });
        let is_held = !alone.is_empty();
        if is_held {
            self.n_edges.note(stamp_s, n_level);
        }
        let shown = Arc::new(Image { agreement, strange_rad: edges.strange_rad });
        let latest = is_held.then(|| Earlier::latest(stamp_s, Arc::clone(&shown) as _));
        let images: Vec<&Earlier> = earlier.iter().chain(&latest).collect();
        let together = self.headings_together(&images);
        Some(Constraint {
            // Images whose edges rule out no heading agree with any pose, so they are no evidence to end a doubt about a failed assumption.
            decides: self.decides && together.says_something(),
            // In a single image more edges may be wrong than its quota declares, so that it says nothing without the other images held.
            by_itself: Some(Box::new(WallHeadings::silent())),
            restricts: Restricts::Heading,
            relies_on: RELIES_ON.to_vec(),
            claims: level.chain(upright).collect(),
            quota: self.quotas.of_image([n_level, edges.upright.len()], self.solves_lean),
            rejected_px: edges.rejected_px,
            alone: is_held.then(|| PoseBox::from([Interval::ENTIRE, Interval::ENTIRE, alone])),
            shown: Some(shown),
            is_held,
            ..Constraint::new(self.name(), stamp_s, together)
        })
    }

    /// Length of the sequence of latest images, and the greatest number of them that may have more wrong edges than the quota of one image.
    fn most_spoilt(&self) -> [usize; 2] {
        if self.solves_lean { [IMAGES, self.quotas.spoilt_images] } else { [IMAGES_APART, self.quotas.images] }
    }

    /// A constraint that rules out no pose. It is returned instead of `None` so that the localizer checks whether the method has met a contradiction.
    fn silent(&self, stamp_s: f64, rejected_px: Vec<[f64; 4]>) -> Constraint {
        Constraint {
            restricts: Restricts::Heading,
            decides: false,
            rejected_px,
            ..Constraint::new(self.name(), stamp_s, WallHeadings::silent())
        }
    }

    /// Headings that the edges of several images allow together, within the declared quotas of wrong edges.
    fn headings_together(&self, images: &[&Earlier]) -> WallHeadings {
        let by_count = images.iter().map(|image| headings_now(image));
        if self.solves_lean {
            return WallHeadings::of_edges(by_count.collect(), self.n_edges.sum(), &self.quotas);
        }
        let of_image = |by_count: Vec<Vec<Interval>>| {
            let n_level = by_count.len();
            let needed = n_level - self.quotas.wrong_of_image(n_level);
            by_count.into_iter().nth(needed.saturating_sub(1)).unwrap_or_default()
        };
        WallHeadings::of_images(by_count.map(of_image).collect(), &self.quotas)
    }

    /// Directions of the building that the map gives or that were learnt, modulo quarter turns.
    pub fn directions_rad(&self) -> &[Interval] {
        &self.directions_rad
    }
}

impl Method for WallDirections {
    fn name(&self) -> &'static str {
        "wall_directions"
    }

    fn reads(&self, reading: &Reading) -> bool {
        matches!(reading, Reading::Camera { camera: Camera::Forward, .. })
    }

    fn n_earlier(&self) -> usize {
        if self.solves_lean { IMAGES - 1 } else { IMAGES_APART - 1 }
    }

    fn constrain(&mut self, reading: &Reading, context: &Context) -> Option<Constraint> {
        let Reading::Camera { measured_s, camera: Camera::Forward, exposure_s, image, .. } = reading else {
            return None;
        };
        if !is_new_place(context.earlier) {
            return None;
        }
        let picture = Picture::from(&**image);
        let by_paper =
            |equalisation| forward::detect_as_printed(&picture, equalisation, |pixel| sight::ray(pixel, &self.camera));
        let mut lines = match self.chain {
            Chain::Direct => forward::detect(&picture),
            Chain::Paper => by_paper(Equalisation::Whole),
            Chain::PaperByTiles => by_paper(Equalisation::ByTiles),
        };
        // A turn of the robot during the exposure moves the image sideways, in its middle by the focal length times the angle turned.
        let moved_px = self.camera.focal_px.mid() * (context.twist.turn_rad_per_s * exposure_s).abs();
        for line in &mut lines {
            let [[_, v0], [_, v1]] = line.ends_px;
            line.bound_px *= if self.solves_lean { 1.0 } else { APART_BOUNDS };
            line.bound_px += BLUR_SHARE * moved_px * (v1 - v0).abs() / sight::length_px(line);
        }
        let lines = self.readout.at_stamp(lines, Tells::Direction, *measured_s, context.motion);
        self.constraint(*measured_s, &lines, context.prior, context.earlier)
    }

    fn memory(&self) -> Option<&dyn Memory> {
        Some(self)
    }

    fn memory_mut(&mut self) -> Option<&mut dyn Memory> {
        Some(self)
    }
}

/// Whether the robot has moved or turned far enough since the last of the earlier images for a new image to be used.
pub(super) fn is_new_place(earlier: &[Earlier]) -> bool {
    earlier.last().is_none_or(|last| {
        let [forward_m, left_m, turned_rad] = [0, 1, 2].map(|axis| last.moved[axis].mid());
        forward_m.hypot(left_m) >= NEW_PLACE_M || turned_rad.abs() >= NEW_PLACE_RAD
    })
}

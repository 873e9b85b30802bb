//! `wall_ranges`: a method that bounds the pose by the distances that a planar range scanner measures, and by the walls on the map.
//!
//! **Constraint.** A beam leaves the scanner at e = t + R(θ) s and ends at p = e + r·(cos α, sin α) with α = θ + ψ + β. Here t and θ are the
//! robot's position and heading, s and ψ the place and the direction of the scanner on the robot, β the beam's bearing from the scanner's forward
//! axis, and r the distance that it measures. All of them but β are known within declared bounds. Of each beam that meets something, two things
//! may be known:
//!
//! 1. *No beam passes through a wall.* Whatever a beam meets, be it furniture or a person, no wall of the map stands between e and p. So this
//!    holds for every beam, needs no count of outliers, and bounds the position from both sides wherever the scanner sees two opposite walls.
//! 2. *Most beams end at walls.* Where a share of beams that may end elsewhere is declared, p lies on the front of a mapped wall for all other
//!    beams, whichever they are (a q-relaxed intersection).
//!
//! A beam that meets nothing within the scanner's range says nothing, since glass and dark surfaces send nothing back.
//!
//! **Source.** R. Guyonneau et al., "Guaranteed interval analysis localization for mobile robots", Advanced Robotics 28 (2014), locate a robot
//! by q-relaxed scans on a grid map. Here walls are line segments, and the first constraint is added, which no furniture can break.

mod beams;
mod face;

use std::sync::Arc;

use interval::{Interval, IntervalBox, contractor::Contractor, contractor::Outcome, contractor::settle, paving};

use crate::{
    PoseBox, Reading,
    bounds::{self, Assumption},
    map::WallMap,
    method::{Claim, Constraint, Context, Method},
    quota::{Quota, share_of},
    robot::RobotModel,
};

use beams::{Beam, Beams};
use face::Face;

/// Name of the planar range scanner as a device whose readings the method uses.
pub const DEVICE: &str = "scanner";

/// Declared bounds that every constraint from a scan relies on.
const RELIES_ON: [Assumption; 9] = [
    bounds::SCANNER_RANGE,
    bounds::SCANNER_POSITION,
    bounds::SCANNER_YAW,
    bounds::SCANNER_TILT,
    bounds::SCANNER_STAMP,
    bounds::WALLS_PLACEMENT,
    bounds::BODY_TILT,
    bounds::REACH_SPEED,
    bounds::REACH_TURN_RATE,
];

/// Greatest number of beams of one scan that are used where no share of wrong beams is declared. Of a scan with more, only every second, third and so
/// on is: neighbouring beams of a fine scan end at the same wall and say nearly the same, and computing time grows with their number.
const MOST_BEAMS: usize = 200;

/// Least time between two scans that are used: scans that are closer in time say nearly the same about the pose.
const APART_S: f64 = 0.18;

/// Planar range scanner as the localizer knows it, by declared values. Its beams leave in one plane, which is level where nothing leans.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ScannerModel {
    /// Position of the scanner in the robot frame: forward and left (bound `scanner.position`).
    pub position_m: [Interval; 2],
    /// Height of the scanner above the floor.
    pub height_m: f64,
    /// Direction of the scanner's forward axis from robot forward, counter-clockwise (bound `scanner.yaw`).
    pub yaw_rad: Interval,
    /// Greatest angle between the scanner's plane and the body's level plane (bound `scanner.tilt`).
    pub tilt_rad: f64,
    /// Greatest error of a measured distance (bound `scanner.range`).
    pub range_error_m: f64,
    /// Greatest error of a scan's stamp (bound `scanner.stamp`).
    pub stamp_error_s: f64,
}

/// What a planar range scanner reports: distances along beams at equal angles.
#[derive(Clone, Debug, PartialEq)]
pub struct Scan {
    /// Bearing of the first beam from the scanner's forward axis, counter-clockwise.
    pub first_rad: f64,
    /// Angle from one beam to the next, counter-clockwise.
    pub step_rad: f64,
    /// Distance that each beam measured; `None` for a beam that met nothing.
    pub distances_m: Vec<Option<f64>>,
}

impl Scan {
    /// Numbers that encode the scan in a [`Reading::Other`]: the first bearing, the step, and the distances, with −1 for a beam that met nothing.
    pub fn numbers(&self) -> Vec<f64> {
        let distances_m = self.distances_m.iter().map(|distance_m| distance_m.unwrap_or(-1.0));
        [self.first_rad, self.step_rad].into_iter().chain(distances_m).collect()
    }

    /// Scan that the numbers of a reading encode; `None` if they encode none.
    pub fn of(numbers: &[f64]) -> Option<Scan> {
        let (&[first_rad, step_rad], distances_m) = numbers.split_first_chunk()?;
        let is_told = numbers.iter().all(|number| number.is_finite());
        let distances_m = distances_m.iter().map(|&distance_m| (distance_m >= 0.0).then_some(distance_m)).collect();
        is_told.then_some(Scan { first_rad, step_rad, distances_m })
    }

    /// The beams that met something: bearing from the scanner's forward axis, and distance.
    pub fn echoes(&self) -> impl Iterator<Item = (f64, f64)> {
        let bearing_rad = |index: usize| self.first_rad + index as f64 * self.step_rad;
        self.distances_m.iter().enumerate().filter_map(move |(index, at_m)| Some((bearing_rad(index), (*at_m)?)))
    }
}

/// Method that bounds the pose by the scans of a planar range scanner; the module's page says how.
#[derive(Clone, Debug)]
pub struct WallRanges {
    scanner: ScannerModel,
    faces: Arc<[Face]>,
    placement_m: f64,
    /// Greatest share of the beams that meet something which may end elsewhere than at a mapped wall; `None` where no share is declared.
    wrong_share: Option<f64>,
    robot: RobotModel,
    /// Stamp of the scan that was used last.
    used_s: f64,
}

impl WallRanges {
    /// Makes the method for a scanner on a robot among the walls of a map. Of the beams of a scan that meet something, at most the share
    /// `wrong_share` ends elsewhere than at one of these walls; `None` if nothing is known of that share, so that only the rule is used that no beam
    /// passes through a wall.
    pub fn new(scanner: ScannerModel, walls: &WallMap, wrong_share: Option<f64>, robot: &RobotModel) -> Self {
        WallRanges {
            scanner,
            faces: walls.walls.iter().filter_map(Face::of).collect(),
            placement_m: walls.placement_m,
            wrong_share,
            robot: robot.clone(),
            used_s: f64::NEG_INFINITY,
        }
    }

    /// The contractor by the beams of a scan, each with its bearing and its distance, for a union of so many boxes.
    fn by_scan(&self, echoes: &[(f64, f64)], n_boxes: usize) -> ByScan {
        let (scanner, reach) = (&self.scanner, &self.robot.reach);
        let point = Interval::point;
        let shortened = |tilt_rad: f64| point(1.0) - Interval::new(0.0, tilt_rad).cos();
        let mount_m = scanner.position_m.map(Interval::mid);
        let nominal_rad = scanner.yaw_rad.mid();
        // The true direction of the scanner's axis differs from the nominal one by the error of its mount, and by what the robot turns within the
        // error of the stamp.
        let error_s = point(scanner.stamp_error_s);
        let turned =
            point((scanner.yaw_rad - point(nominal_rad)).magnitude()) + error_s * point(reach.turn_rate_rad_per_s);
        // The true place of the scanner differs from the nominal one by the error of its mount; by the lean of the body; by the way within the error
        // of the stamp; and because the nominal lever arm is turned with the scanner.
        let lever = mount_m.iter().fold(Interval::ZERO, |sum, side_m| sum + point(side_m.abs()));
        let mounted = [0, 1].map(|axis| (scanner.position_m[axis] - point(mount_m[axis])).magnitude());
        let body_rad = self.robot.body.tilt_rad;
        let leans = self.robot.body.most_leant_m(scanner.position_m, scanner.height_m);
        let moved =
            point(mounted[0]).hypot(point(mounted[1])) + leans + error_s * point(reach.speed_m_per_s) + lever * turned;
        let by_metre = shortened(body_rad + scanner.tilt_rad);
        let beam = |&(bearing_rad, distance_m): &(f64, f64)| {
            let distance = Interval::centred(distance_m, scanner.range_error_m).max(Interval::ZERO);
            Beam {
                bearing: point(bearing_rad) + point(nominal_rad),
                distance,
                shortened_m: (point(distance.hi()) * by_metre).hi(),
            }
        };
        let beams = |each: usize, most_wrong: Option<usize>| Beams {
            faces: self.faces.clone(),
            placement_m: self.placement_m,
            mount_m,
            beams: echoes.iter().step_by(each).map(beam).collect(),
            most_wrong,
        };
        ByScan {
            beams: beams(1, self.wrong_share.map(|share| share_of(share, echoes.len()))),
            few: beams(echoes.len().div_ceil(FEW_BEAMS), None),
            is_sharp: n_boxes <= MOST_SHARP,
            most_parts: MOST_PARTS / n_boxes.max(1),
            off: [moved.hi(), moved.hi(), turned.hi()],
        }
    }
}

impl Method for WallRanges {
    fn name(&self) -> &'static str {
        "wall_ranges"
    }

    fn reads(&self, reading: &Reading) -> bool {
        matches!(reading, Reading::Other { device, .. } if device == DEVICE)
    }

    fn constrain(&mut self, reading: &Reading, context: &Context) -> Option<Constraint> {
        let Reading::Other { measured_s, numbers, .. } = reading else { return None };
        let echoes: Vec<(f64, f64)> = Scan::of(numbers)?.echoes().collect();
        // A new drive may begin with an earlier stamp.
        if (measured_s - self.used_s).abs() < APART_S || echoes.is_empty() || self.faces.is_empty() {
            return None;
        }
        self.used_s = *measured_s;
        // A declared share of wrong beams is one of all beams of a scan; among some of them the share may be greater.
        let each = if self.wrong_share.is_some() { 1 } else { echoes.len().div_ceil(MOST_BEAMS) };
        let used: Vec<(f64, f64)> = echoes.iter().copied().step_by(each).collect();
        let by_scan = self.by_scan(&used, context.prior.branches.len());
        let most_wrong = by_scan.beams.most_wrong;
        // Only where a share of wrong beams is declared does the constraint rest on what a beam has met.
        let claim = |&(bearing_rad, distance_m): &(f64, f64)| Claim::WallPoint {
            bearing_rad,
            distance_m,
            range_error_m: self.scanner.range_error_m,
            placement_m: self.placement_m,
        };
        let claims = if most_wrong.is_some() { used.iter().map(claim).collect() } else { Vec::new() };
        Some(Constraint {
            relies_on: RELIES_ON.to_vec(),
            claims,
            quota: Quota::of_each(most_wrong.unwrap_or(0)),
            ..Constraint::new(self.name(), *measured_s, by_scan)
        })
    }
}

/// Width in metres and radians up to which a box of poses is contracted as a whole. A wider one is cut into parts.
const WIDEST: f64 = 0.25;
/// Greatest width in metres and radians of a part of a wide box that is contracted.
const WIDEST_PART: f64 = 1.0;
/// Greatest number of parts, of all boxes of a union together, that wide boxes are cut into.
const MOST_PARTS: usize = 64;
/// Greatest number of boxes of a union that are contracted by all beams, repeatedly and by linear programs. Of more boxes each is contracted once by
/// few beams, so that a lost robot does not wait for its localizer.
const MOST_SHARP: usize = 4;
/// Greatest number of beams by which parts of wide boxes and the boxes of large unions are contracted.
const FEW_BEAMS: usize = 40;
/// Width of a heading interval up to which a beam's end is linearised in the heading at once.
const WIDEST_HEADING_RAD: f64 = 0.06;

/// Contractor by all beams of a scan.
///
/// What displaces all beams of a scan in common, such as the error of the scanner's mount, is the same as another pose of the robot. So the beams
/// contract the box of the poses that the robot would have with the nominal mount, and each pose of the robot is within `off` of one of these.
struct ByScan {
    beams: Beams,
    /// Some of the beams, of which only the rule is used that they pass through no wall.
    few: Beams,
    /// Whether the union has so few boxes that each is contracted by all beams.
    is_sharp: bool,
    /// Greatest number of parts that a wide box is cut into.
    most_parts: usize,
    /// Greatest difference of x, y and heading between the robot's pose and the pose that the robot would have with the nominal mount.
    off: [f64; 3],
}

impl ByScan {
    /// A box with every pose that is within the common errors of a pose of the given box.
    fn widened(&self, domain: &PoseBox) -> PoseBox {
        IntervalBox::new([0, 1, 2].map(|axis| domain[axis].inflate(self.off[axis])))
    }
}

impl Beams {
    /// Contracts a box by slices of its heading.
    fn contracted_by_slices(&self, domain: &PoseBox) -> PoseBox {
        if domain.is_empty() || domain.width(2) <= WIDEST_HEADING_RAD {
            return self.contracted(domain);
        }
        let (left, right) = domain.bisect(2);
        self.contracted_by_slices(&left).hull(&self.contracted_by_slices(&right))
    }
}

/// Cause of an empty box.
const CAUSE: &str = "a beam would pass through a wall, or too few beams would end at walls";

/// The contractor on a box that is not too wide, for the paving of wide ones.
struct Narrow<'a>(&'a Beams);

impl Contractor<3> for Narrow<'_> {
    fn contract(&self, domain: &mut IntervalBox<3>) -> Outcome {
        // In a wider box no beam's end is known well enough to say anything.
        let left = if domain.max_width() <= WIDEST_PART { self.0.pass(domain) } else { *domain };
        settle(domain, left, CAUSE)
    }
}

impl Contractor<3> for ByScan {
    fn contract(&self, domain: &mut IntervalBox<3>) -> Outcome {
        let left = paving::hull(&self.branches(domain));
        settle(domain, left, CAUSE)
    }

    fn branches(&self, domain: &IntervalBox<3>) -> Vec<IntervalBox<3>> {
        if domain.is_empty() || !domain.iter().all(|side| side.is_bounded()) {
            return if domain.is_empty() { Vec::new() } else { vec![*domain] };
        }
        let nominal = self.widened(domain);
        let parts = if domain.max_width() <= WIDEST {
            vec![if self.is_sharp { self.beams.contracted_by_slices(&nominal) } else { self.few.pass(&nominal) }]
        } else if self.most_parts > 1 {
            clusters(paving::cover_at_most(&Narrow(&self.few), nominal, &[0, 1, 2], WIDEST, self.most_parts))
        } else {
            vec![nominal]
        };
        let back = |part: &PoseBox| self.widened(part).intersect(domain);
        parts.iter().filter(|part| !part.is_empty()).map(back).filter(|part| !part.is_empty()).collect()
    }
}

/// Boxes around the given ones, of which no two meet.
fn clusters(parts: Vec<PoseBox>) -> Vec<PoseBox> {
    let mut apart: Vec<PoseBox> = Vec::new();
    for part in parts {
        let mut joined = part;
        // A hull may meet boxes that none of its members meets.
        while let Some(index) = apart.iter().position(|other| other.overlaps(&joined)) {
            joined = joined.hull(&apart.swap_remove(index));
        }
        apart.push(joined);
    }
    apart
}

#[cfg(test)]
mod trial;

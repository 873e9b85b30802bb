//! Group of marker dots that share errors: a contractor for a rigid motion with a common shift.
//!
//! An error that shifts all dots of a group alike says nothing about the heading. Each first-order model of a dot is therefore split into
//! the group's common part c = Σ Ḡₖ φₖ and the part by which the dot differs from it: `dot = z + R(θ) bᵢ` with z = (x, y) + R(θ) c. A tilt
//! of 0.1° shifts a marker at 2.6 m by 4.5 mm and turns it by less than 0.05°.

use interval::{Interval, IntervalBox, contractor::Contractor};

use crate::rigid_motion::{LinearPose, RigidPlanar};

use super::pairs;
use super::ray::{BODY_TILT, MOUNT_TILT, N_PARAMETERS, SeenDot, Sight, is_own};

/// Group of dots with a common shift.
#[derive(Clone, Debug)]
pub(super) struct Group {
    motion: RigidPlanar,
    /// Apparent headings (robot heading plus camera yaw error), up to whole turns, that the pairs of dots allow.
    heading: Option<Interval>,
    /// Derivatives of the dots' places by the shared error parameters, averaged over the group, with the parameters' half-widths: `boxes`
    /// holds parameters that vary each for itself, `discs` pairs of parameters (a tilt's two components) that lie together in a disc.
    boxes: Vec<([f64; 2], f64)>,
    discs: Vec<([[f64; 2]; 2], f64)>,
    /// Radius of the marker's placement error: a shift in any direction of the world frame.
    placement_m: f64,
}

impl Group {
    /// Makes a group of the dots of one marker when `is_one_marker`, otherwise of several markers. The dots of one marker share the error
    /// of their height and, as a disc, the error of the marker's placement.
    pub(super) fn new(dots: &[SeenDot], is_one_marker: bool, placement_m: f64) -> Group {
        let own = |parameter: usize| is_own(parameter, is_one_marker);
        let mut common = [[0.0; 2]; N_PARAMETERS];
        for (parameter, slopes) in common.iter_mut().enumerate().filter(|(parameter, _)| !own(*parameter)) {
            for (axis, slope) in slopes.iter_mut().enumerate() {
                let sum: f64 = dots.iter().map(|dot| dot.sight.slopes[axis][parameter].mid()).sum();
                *slope = sum / dots.len() as f64;
                debug_assert!(slope.is_finite(), "parameter {parameter}");
            }
        }
        let landmarks: Vec<([Interval; 2], [Interval; 2])> =
            dots.iter().map(|dot| (dot.in_world_m, differing(&dot.sight, &common))).collect();
        let deviation = |parameter: usize| dots[0].sight.deviations[parameter].magnitude();
        let in_disc = |parameter: &usize| BODY_TILT.contains(parameter) || MOUNT_TILT.contains(parameter);
        let boxes = (0..N_PARAMETERS).filter(|k| !own(*k) && !in_disc(k)).map(|k| (common[k], deviation(k))).collect();
        let disc = |tilt: [usize; 2]| (tilt.map(|k| common[k]), deviation(tilt[0]));
        Group {
            motion: RigidPlanar::new(&landmarks),
            heading: pairs::heading(dots, is_one_marker),
            boxes,
            discs: vec![disc(BODY_TILT), disc(MOUNT_TILT)],
            placement_m: if is_one_marker { placement_m } else { 0.0 },
        }
    }

    /// Half-widths of the dots' common shift along world x and y, for any apparent heading in the interval.
    fn shift_m(&self, heading: Interval) -> [f64; 2] {
        let (cos, sin) = (heading.cos(), heading.sin());
        // The two rows of the rotation matrix R(θ) give the shift along world x and along world y.
        [[cos, -sin], [sin, cos]].map(|row| {
            let along = |slope: &[f64; 2]| row[0] * slope[0] + row[1] * slope[1];
            let mut shift = Interval::point(self.placement_m);
            for (slope, half_width) in &self.boxes {
                shift += along(slope).abs() * *half_width;
            }
            for ([first, second], radius) in &self.discs {
                shift += along(first).hypot(along(second)) * *radius;
            }
            shift.hi()
        })
    }

    /// Boxes of (x, y, apparent heading) that remain of a given box when the group's dots are used; one box for each whole turn of the
    /// heading.
    pub(super) fn branches(&self, pose: &IntervalBox<3>) -> Vec<IntervalBox<3>> {
        let pose_contractor = LinearPose { motion: self.motion.clone(), n_slices: 0 };
        let shifted = self.shifted(pose, pose[2]);
        let found = pose_contractor.branches(&shifted);
        let turned = found.into_iter().map(|mut branch| {
            if let Some(heading) = self.heading.filter(|_| branch[2].width() < std::f64::consts::PI) {
                branch[2] = pairs::same_turn(branch[2], heading);
            }
            branch
        });
        let kept = turned.filter(|branch| !branch[2].is_empty()).map(|branch| self.unshifted(&branch, pose));
        kept.filter(|branch| !branch.is_empty()).collect()
    }

    /// Contracts a box of (x, y, apparent heading) by the group's dots in a single pass, for a thin slice of heading.
    pub(super) fn pass(&self, pose: &IntervalBox<3>) -> IntervalBox<3> {
        let mut shifted = self.shifted(pose, pose[2]);
        self.motion.contract(&mut shifted);
        if shifted.is_empty() { IntervalBox::EMPTY } else { self.unshifted(&shifted, pose) }
    }

    fn shifted(&self, pose: &IntervalBox<3>, heading: Interval) -> IntervalBox<3> {
        let [x, y] = self.shift_m(heading);
        IntervalBox::new([pose[0].inflate(x), pose[1].inflate(y), pose[2]])
    }

    fn unshifted(&self, shifted: &IntervalBox<3>, pose: &IntervalBox<3>) -> IntervalBox<3> {
        self.shifted(shifted, shifted[2]).intersect(pose)
    }
}

/// Place of a dot in the apparent frame, without the common part of the error parameters' effects.
fn differing(sight: &Sight, common: &[[f64; 2]; N_PARAMETERS]) -> [Interval; 2] {
    [0, 1].map(|axis| {
        let slope = |k: usize| sight.slopes[axis][k] - common[k][axis];
        let in_box = |k: &usize| !BODY_TILT.contains(k) && !MOUNT_TILT.contains(k);
        let place =
            (0..N_PARAMETERS).filter(in_box).fold(sight.middle_m[axis], |sum, k| sum + slope(k) * sight.deviations[k]);
        // The two components of a tilt lie in a disc: along one axis they shift the dot by at most the disc's radius times the length of
        // the slopes.
        [BODY_TILT, MOUNT_TILT].into_iter().fold(place, |sum, [a, b]| {
            let reach = slope(a).hypot(slope(b)) * sight.deviations[a].magnitude();
            sum.inflate(reach.hi())
        })
    })
}

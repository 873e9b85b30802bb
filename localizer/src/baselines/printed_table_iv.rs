//! The forward-backward contractor of paper 3 (Mustafa et al., CSCS 2015) as its Table IV prints it, for the comparison only: **it loses
//! solutions**.
//!
//! Rows 31 and 32 contract the heading by arcsin and arccos, whose values lie in [−π/2, π/2] and [0, π], so that one of the two cuts away a
//! heading outside of [0, π/2]. The rows are in the order of the print, and a and b have its names; its t and θ are the pose.

use interval::{Interval, IntervalBox};

use crate::{PoseBox, rigid_motion::Landmark};

/// Passes over the landmarks end when no width of the pose shrinks by more than this fraction; the paper says "while contraction is significant".
const SIGNIFICANT: f64 = 0.01;

/// Greatest number of passes.
const MOST_PASSES: usize = 100;

/// The pose box that is left when the forward-backward contractor of paper 3 is applied to the landmarks as its Table IV is printed; empty when the
/// table leaves no pose at all.
pub fn printed_table_iv(landmarks: &[Landmark], prior: &PoseBox) -> PoseBox {
    let mut places: Vec<[Interval; 2]> = landmarks.iter().map(|(a, _)| *a).collect();
    let mut pose = *prior;
    for _ in 0..MOST_PASSES {
        let before = pose;
        for ((_, b), a) in landmarks.iter().zip(&mut places) {
            pass(&mut pose, a, b);
            if pose.is_empty() || a.iter().any(|axis| axis.is_empty()) {
                return IntervalBox::EMPTY;
            }
        }
        if (0..3).all(|axis| pose.width(axis) > (1.0 - SIGNIFICANT) * before.width(axis)) {
            break;
        }
    }
    pose
}

/// Applies rows 03 to 32 of paper 3's printed Table IV to the pose and one landmark.
fn pass(pose: &mut PoseBox, a: &mut [Interval; 2], b: &[Interval; 2]) {
    let mut z1 = pose[2].cos();
    let mut z2 = pose[2].sin();
    let mut z3 = a[0] - pose[0];
    let mut z4 = a[1] - pose[1];
    let mut z5 = z1 * z3;
    let mut z6 = z2 * z4;
    let mut z7 = z2 * z3;
    let mut z8 = z1 * z4;
    let z9 = (z5 + z6).intersect(b[0]);
    let z10 = (z8 - z7).intersect(b[1]);
    z7 = z7.intersect(z8 - z10);
    z8 = z8.intersect(z10 + z7);
    z5 = z5.intersect(z9 - z6);
    z6 = z6.intersect(z9 - z5);
    z1 = z1.intersect(z8 / z4);
    z4 = z4.intersect(z8 / z1);
    z2 = z2.intersect(z7 / z3);
    z3 = z3.intersect(z7 / z2);
    z2 = z2.intersect(z6 / z4);
    z4 = z4.intersect(z6 / z2);
    z1 = z1.intersect(z5 / z3);
    z3 = z3.intersect(z5 / z1);
    a[1] = a[1].intersect(z4 + pose[1]);
    pose[1] = pose[1].intersect(a[1] - z4);
    a[0] = a[0].intersect(z3 + pose[0]);
    pose[0] = pose[0].intersect(a[0] - z3);
    pose[2] = pose[2].intersect(z2.asin());
    pose[2] = pose[2].intersect(z1.acos());
}

//! Headings on which the edges of one image agree, at any lean of robot and camera at which its upright edges are upright.
//!
//! A lean of τ turns the direction of a level edge seen at elevation ε by up to τ/tan ε, five times τ for a skirting and half of it the
//! other way for a shelf: one lean serves all edges of an image, so that together they tell it. The disc of leans is cut into squares;
//! in each, every edge's plane is turned by the square's middle and widened by its extent.

use std::f64::consts::FRAC_PI_2;

use nalgebra::Vector3;

use super::{headings, sight::SightPlane, wrong_lines};
use crate::Interval;

/// Squares on a diameter of the disc of leans.
const SQUARES: usize = 24;

/// What an image's edges say: for each count, from one up, the headings at which as many level edges agree on one lean.
pub(super) type Agreement = Vec<Vec<Interval>>;

/// What is common to an image's edges.
pub(super) struct View<'a> {
    /// Greatest lean of robot and camera together, about any level axis.
    pub(super) tilt_rad: f64,
    /// Whether all edges are seen at one lean, and not each at any.
    pub(super) solves_lean: bool,
    /// Added to every edge's direction: the camera's yaw and what the robot turned within the stamp's error.
    pub(super) yaw_rad: Interval,
    /// Directions of walls.
    pub(super) directions_rad: &'a [Interval],
    /// Headings that are asked about.
    pub(super) about: Interval,
}

/// Headings by how many of the level edges agree at some lean that all but [`wrong_lines`] of the upright edges allow; at any lean where
/// no lean does, for then more of them are wrong than declared.
pub(super) fn agreement(level: &[SightPlane], upright: &[SightPlane], view: &View) -> Agreement {
    let squares = squares(view.tilt_rad, if view.solves_lean { SQUARES } else { 1 });
    let needed = upright.len() - wrong_lines(upright.len());
    let allows = |square: &&Square| upright.iter().filter(|plane| square.is_upright(plane)).count() >= needed;
    let mut allowed: Vec<&Square> = squares.iter().filter(allows).collect();
    if allowed.is_empty() {
        allowed = squares.iter().collect();
    }
    let mut agreement = vec![Vec::new(); level.len()];
    for square in allowed {
        let sets: Vec<Vec<Interval>> = level
            .iter()
            .map(|plane| match square.direction(plane) {
                Some(azimuth) => headings::of_line(azimuth + view.yaw_rad, view.directions_rad, view.about),
                None => vec![view.about],
            })
            .collect();
        for (count, headings) in agreement.iter_mut().enumerate() {
            headings.extend(headings::agreed(&sets, count + 1));
        }
    }
    agreement.into_iter().map(headings::joined).collect()
}

/// Some of the leans: as vectors about forward and left, those within `half_rad` of `middle_rad` along both.
struct Square {
    middle_rad: [f64; 2],
    half_rad: f64,
    /// What a turn departs from what is linear in it, of a vector of length one.
    bent: f64,
}

/// Squares that cover the disc of leans.
fn squares(tilt_rad: f64, n_across: usize) -> Vec<Square> {
    let half_rad = tilt_rad / n_across as f64;
    let middle = |idx: usize| (2 * idx + 1) as f64 * half_rad - tilt_rad;
    let every = (0..n_across).flat_map(|row| (0..n_across).map(move |column| [middle(row), middle(column)]));
    every
        .filter(|[x, y]| (x.abs() - half_rad).max(0.0).hypot((y.abs() - half_rad).max(0.0)) <= tilt_rad)
        // Two turns about level axes make one about their sum, and less than as much again about the vertical.
        .map(|middle_rad| Square { middle_rad, half_rad, bent: tilt_rad * tilt_rad })
        .collect()
}

impl Square {
    /// The plane's normal at the middle of the square: n + δ × n.
    fn turned(&self, plane: &SightPlane) -> Vector3<f64> {
        let lean = Vector3::new(self.middle_rad[0], self.middle_rad[1], 0.0);
        plane.normal + lean.cross(&plane.normal)
    }

    /// How far leans of the square and what the plane itself allows move its normal along a unit vector, at most.
    fn reach(&self, plane: &SightPlane, along: &Vector3<f64>) -> f64 {
        let about = plane.normal.cross(along);
        plane.reach(along) + self.half_rad * (about.x.abs() + about.y.abs()) + self.bent
    }

    /// Whether the plane may hold the vertical: n·z = 0.
    fn is_upright(&self, plane: &SightPlane) -> bool {
        self.turned(plane).z.abs() <= self.reach(plane, &Vector3::z())
    }

    /// Direction, counter-clockwise from robot forward, of the level line in the plane; `None` when it may be any.
    ///
    /// With n of level length m and Δ what may be added, a direction turned by γ from the middle one is in the plane when
    /// m·sin γ = |d·Δ| ≤ cos γ·|d₀·Δ| + sin γ·|n̂·Δ|, hence tan γ ≤ |d₀·Δ| / (m − |n̂·Δ|).
    fn direction(&self, plane: &SightPlane) -> Option<Interval> {
        let normal = self.turned(plane);
        let level = normal.x.hypot(normal.y);
        let across = Vector3::new(normal.x, normal.y, 0.0) / level;
        let along = Vector3::new(-across.y, across.x, 0.0);
        let room = level - self.reach(plane, &across);
        if room <= 0.0 {
            return None;
        }
        let turn_rad = (self.reach(plane, &along) / room).atan() + self.bent;
        Some(Interval::centred(across.y.atan2(across.x) + FRAC_PI_2, turn_rad))
    }
}

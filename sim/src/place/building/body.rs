//! People in the building, as simple bodies of human proportions.

use nalgebra::{Point3, Vector3, vector};

use super::level;
use crate::scene::Person;

/// The body of a person who stands or walks.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct UprightBody {
    /// World x and y of the middle of the person's body.
    pub middle_m: [f64; 2],
    /// Direction that the person faces, measured from world x.
    pub heading_rad: f64,
    /// Height of the person.
    pub height_m: f64,
    /// Half of the person's width over the shoulders.
    pub radius_m: f64,
    /// Phase of the legs within a pair of steps, from 0 to 1; at 0 both legs are side by side.
    pub stride: f64,
    /// Velocity of the middle of the person's body along world x and y.
    pub velocity_m_per_s: [f64; 2],
}

/// Length of two steps of a walking person.
pub const STRIDE_M: f64 = 1.4;

impl UprightBody {
    /// A person at the first waypoint of the walk who faces the second one and already walks at full speed; without a second waypoint the person
    /// stands.
    pub fn setting_out(person: &Person) -> Option<UprightBody> {
        let stands = UprightBody::at_start(person)?;
        let speed_m_per_s = if person.waypoints_m.len() > 1 { person.speed_m_per_s } else { 0.0 };
        let ahead = level(stands.heading_rad) * speed_m_per_s;
        Some(UprightBody { velocity_m_per_s: [ahead.x, ahead.y], ..stands })
    }

    /// The person's body after the given time, if the person walks on at the present velocity.
    pub fn later(&self, by_s: f64) -> UprightBody {
        let [x, y] = self.velocity_m_per_s;
        UprightBody {
            middle_m: [self.middle_m[0] + x * by_s, self.middle_m[1] + y * by_s],
            stride: self.stride + x.hypot(y) * by_s / STRIDE_M,
            ..*self
        }
    }

    /// A person who stands at the first waypoint of the walk and faces the second one.
    pub fn at_start(person: &Person) -> Option<UprightBody> {
        let [x_m, y_m] = *person.waypoints_m.first()?;
        let next_m = person.waypoints_m.get(1).copied().unwrap_or([x_m + 1.0, y_m]);
        Some(UprightBody {
            middle_m: [x_m, y_m],
            heading_rad: (next_m[1] - y_m).atan2(next_m[0] - x_m),
            height_m: person.height_m,
            radius_m: person.radius_m,
            stride: 0.0,
            velocity_m_per_s: [0.0; 2],
        })
    }
}

/// One vertex of the triangulated surface of a person's body.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BodyVertex {
    /// Position of a vertex of a person's body, world frame.
    pub at: Point3<f64>,
    /// Outward normal of a person's body at a vertex of its surface.
    pub normal: Vector3<f64>,
    /// Albedo of a person's body at a vertex of its surface, in the visible and in the infrared band.
    pub albedo: [f64; 2],
}

/// The surface of a person's body, as triangles.
#[derive(Clone, Debug, Default)]
pub struct BodyMesh {
    /// Vertices of the surface of a person's body.
    pub corners: Vec<BodyVertex>,
    /// Indices of the three vertices of each triangle of a person's body, counter-clockwise as seen from outside.
    pub triangles: Vec<[usize; 3]>,
}

/// Horizontal elliptic rings that a limb or the trunk is made of. Each has its height as a share of the person's height, then its half width
/// across and its half depth along the person's heading, both as shares of half the width over the shoulders.
type Rings<'a> = &'a [[f64; 3]];

/// Number of vertices on each ring of a limb or of the trunk.
const AROUND: usize = 12;

/// Makes the surface of a person's body.
pub fn body_mesh(body: &UprightBody) -> BodyMesh {
    const TROUSERS: [f64; 2] = [0.12, 0.35];
    const SHIRT: [f64; 2] = [0.35, 0.55];
    const SKIN: [f64; 2] = [0.35, 0.5];
    const HAIR: [f64; 2] = [0.06, 0.2];
    let swing = (body.stride * std::f64::consts::TAU).sin();
    // Heights of the parts of the body are given as shares of the whole height, widths as shares of half the width over the shoulders.
    let leg: Rings = &[[0.0, 0.26, 0.5], [0.04, 0.2, 0.3], [0.27, 0.26, 0.32], [0.49, 0.26, 0.3]];
    // The shirt hangs over the trousers, so that the legs come through it nowhere.
    let trunk: Rings = &[
        [0.45, 0.74, 0.5],
        [0.56, 0.68, 0.45],
        [0.7, 0.8, 0.5],
        [0.8, 0.92, 0.48],
        [0.83, 0.5, 0.35],
        [0.85, 0.22, 0.24],
    ];
    let arm: Rings = &[[0.43, 0.13, 0.15], [0.6, 0.17, 0.18], [0.8, 0.2, 0.22], [0.83, 0.1, 0.1]];
    let hand: Rings = &[[0.37, 0.02, 0.04], [0.38, 0.09, 0.14], [0.43, 0.09, 0.13]];
    let neck: Rings = &[[0.84, 0.22, 0.24], [0.88, 0.22, 0.24]];
    let head: Rings = &[[0.87, 0.2, 0.25], [0.9, 0.3, 0.38], [0.94, 0.34, 0.44]];
    let hair: Rings = &[[0.94, 0.35, 0.45], [0.97, 0.32, 0.42], [0.99, 0.2, 0.28], [1.0, 0.02, 0.02]];
    let mut mesh = BodyMesh::default();
    let mut part = |rings: Rings, across: f64, lean: f64, pivot: f64, albedo: [f64; 2]| {
        limb(&mut mesh, body, rings, across, lean, pivot, albedo);
    };
    for side in [-1.0, 1.0] {
        part(leg, 0.36 * side, 0.35 * swing * side, 0.5, TROUSERS);
        part(arm, 0.9 * side, -0.25 * swing * side, 0.82, SHIRT);
        part(hand, 0.9 * side, -0.25 * swing * side, 0.82, SKIN);
    }
    part(trunk, 0.0, 0.0, 0.5, SHIRT);
    part(neck, 0.0, 0.0, 0.5, SKIN);
    part(head, 0.0, 0.0, 0.5, SKIN);
    part(hair, 0.0, 0.0, 0.5, HAIR);
    mesh
}

/// Adds a limb, a stack of elliptic rings. It is moved sideways by `across` and leans: each ring is moved forward in proportion to its distance
/// below the height `pivot`.
fn limb(mesh: &mut BodyMesh, body: &UprightBody, rings: Rings, across: f64, lean: f64, pivot: f64, albedo: [f64; 2]) {
    let ahead = level(body.heading_rad);
    let left = vector![-ahead.y, ahead.x, 0.0];
    let corner = |ring: &[f64; 3], index: usize| {
        let (sin, cos) = (index as f64 / AROUND as f64 * std::f64::consts::TAU).sin_cos();
        let forward_m = (pivot - ring[0]) * lean * body.height_m + ring[2] * cos * body.radius_m;
        let left_m = (across + ring[1] * sin) * body.radius_m;
        let at = super::raised(body.middle_m, ring[0] * body.height_m) + ahead * forward_m + left * left_m;
        // At its point (a·cos, b·sin) an ellipse with the half axes a and b has a normal of the direction (cos/a, sin/b).
        let normal = (ahead * (cos / ring[2]) + left * (sin / ring[1])).normalize();
        BodyVertex { at, normal, albedo }
    };
    let first = mesh.corners.len();
    mesh.corners.extend(
        rings
            .iter()
            .flat_map(|ring| (0..AROUND).map(move |index| (ring, index)))
            .map(|(ring, index)| corner(ring, index)),
    );
    for (ring, index) in (1..rings.len()).flat_map(|ring| (0..AROUND).map(move |index| (ring, index))) {
        let at = |ring: usize, index: usize| first + ring * AROUND + index % AROUND;
        let (a, b) = (at(ring - 1, index), at(ring - 1, index + 1));
        let (c, d) = (at(ring, index + 1), at(ring, index));
        mesh.triangles.extend([[a, b, c], [a, c, d]]);
    }
}

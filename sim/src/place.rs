//! The place that the robot is in, as its wheels and its sensors find it: the floor under a point, what stands between two points, and who is
//! about.

pub(crate) mod floor;
pub(crate) mod sight;

/// A person at an instant, as an upright cylinder on the floor.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bystander {
    /// Where the person stands, world.
    pub place_m: [f64; 2],
    /// Radius of the cylinder.
    pub radius_m: f64,
    /// Its height.
    pub height_m: f64,
    /// Direction of the face from world x.
    pub heading_rad: f64,
    /// Way walked since the start.
    pub walked_m: f64,
    /// Of the last step, along world x and y.
    pub velocity_m_per_s: [f64; 2],
}

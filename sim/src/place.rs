//! The surroundings of the robot as its wheels and sensors meet them: the floor under a point, what stands between two points, and people
//! nearby.

pub(crate) mod floor;
pub(crate) mod sight;

/// A person at an instant, as an upright cylinder on the floor.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bystander {
    /// Place where the person stands, world frame.
    pub place_m: [f64; 2],
    /// Radius of the cylinder that stands for the person.
    pub radius_m: f64,
    /// Height of the person.
    pub height_m: f64,
    /// Direction that the person faces, measured from world x.
    pub heading_rad: f64,
    /// Distance that the person has walked since the start.
    pub walked_m: f64,
    /// Velocity of the person in the last time step, along world x and y.
    pub velocity_m_per_s: [f64; 2],
}

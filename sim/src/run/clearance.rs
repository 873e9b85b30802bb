//! Distances from the true robot to the things that it may run into.

use crate::{
    place::{Bystander, building::GroundPlan},
    scene::Scene,
    truth::Truth,
};

/// Distances of the robot's round body from the walls, the furniture and the people that it may run into. A distance is infinite where
/// there is nothing of the kind.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Clearance {
    /// Distance from the nearest wall.
    pub walls_m: f64,
    /// Distance from the nearest furniture.
    pub furniture_m: f64,
    /// Distance from the nearest person.
    pub people_m: f64,
}

impl Clearance {
    /// Computes the robot's distances from walls, furniture and people at one instant.
    pub fn of(scene: &Scene, truth: &Truth, people: &[Bystander]) -> Clearance {
        let (radius_m, place_m) = (scene.robot.body_radius_m, [truth.pose.x_m, truth.pose.y_m]);
        let furniture = scene.furniture.iter().map(|piece| piece.distance_m(place_m));
        let people = people
            .iter()
            .map(|person| (person.place_m[0] - place_m[0]).hypot(person.place_m[1] - place_m[1]) - person.radius_m);
        Clearance {
            walls_m: GroundPlan::of(scene).wall_distance_m(place_m) - radius_m,
            furniture_m: furniture.fold(f64::INFINITY, f64::min) - radius_m,
            people_m: people.fold(f64::INFINITY, f64::min) - radius_m,
        }
    }

    /// Returns the least of the distances from walls, furniture and people.
    pub fn least_m(&self) -> f64 {
        self.walls_m.min(self.furniture_m).min(self.people_m)
    }
}

//! What stands between two points: walls, furniture, people.

use nalgebra::{Point3, Vector3};
use rapier3d_f64::{
    parry::{
        query::{Ray, RayCast},
        shape::{Cuboid, Cylinder, SharedShape},
    },
    prelude::{Pose, Vector},
};

use crate::scene::Scene;

use super::{Bystander, building::GroundPlan};

/// Distance from a landmark within which nothing hides it, because a landmark is fixed to a surface.
const ON_SURFACE_M: f64 = 0.005;

/// Everything in a scene that does not move and hides what is behind it.
pub(crate) struct Obstacles {
    ground_plan: GroundPlan,
    boxes: Vec<(Pose, SharedShape)>,
}

impl Obstacles {
    /// The walls and the furniture of a scene.
    pub(crate) fn new(scene: &Scene) -> Self {
        let boxes = scene
            .furniture
            .iter()
            .map(|piece| {
                let half = Vector::new(0.5 * piece.size_m[0], 0.5 * piece.size_m[1], 0.5 * piece.height_m);
                let place = Vector::new(piece.x_m, piece.y_m, half.z);
                let pose = Pose::new(place, Vector::new(0.0, 0.0, piece.rotation_deg.to_radians()));
                (pose, SharedShape::new(Cuboid::new(half)))
            })
            .collect();
        Obstacles { ground_plan: GroundPlan::of(scene), boxes }
    }

    /// Whether nothing stands on the line from a sensor to a landmark.
    pub(crate) fn leave_free(&self, eye: Point3<f64>, landmark: Point3<f64>, people: &[Bystander]) -> bool {
        if self.ground_plan.separates(eye, landmark, ON_SURFACE_M) {
            return false;
        }
        let way = landmark - eye;
        let ray = Ray::new(vector(eye), vector(Point3::from(way)));
        let reach = (1.0 - ON_SURFACE_M / way.norm().max(ON_SURFACE_M)).max(0.0);
        let person = |person: &Bystander| person_at(person, &ray, reach).is_some();
        let piece = |(pose, shape): &(Pose, SharedShape)| shape.cast_ray(pose, &ray, reach, true).is_some();
        !self.boxes.iter().any(piece) && !people.iter().any(person)
    }

    /// Distance from a sensor to the nearest surface along a direction that is nearly level, given as a unit vector; `None` if it is beyond
    /// `range_m`.
    pub(crate) fn nearest_m(
        &self,
        eye: Point3<f64>,
        direction: Vector3<f64>,
        range_m: f64,
        people: &[Bystander],
    ) -> Option<f64> {
        let ray = Ray::new(vector(eye), vector(Point3::from(direction)));
        // Walls and floor are met by the share of the way that is level and by that which goes down.
        let wall_m = self.ground_plan.wall_ahead_m(eye, direction.y.atan2(direction.x)) / direction.xy().norm();
        let floor_m = if direction.z < 0.0 { -eye.z / direction.z } else { f64::INFINITY };
        let boxes = self.boxes.iter().filter_map(|(pose, shape)| shape.cast_ray(pose, &ray, range_m, true));
        let people = people.iter().filter_map(|person| person_at(person, &ray, range_m));
        let nearest_m = boxes.chain(people).fold(wall_m.min(floor_m), f64::min);
        (nearest_m <= range_m).then_some(nearest_m)
    }
}

fn person_at(person: &Bystander, ray: &Ray, reach: f64) -> Option<f64> {
    let half_m = 0.5 * person.height_m;
    // parry's cylinders stand along y, so that the person's cylinder is turned to stand along z.
    let pose = Pose::new(
        Vector::new(person.place_m[0], person.place_m[1], half_m),
        Vector::new(std::f64::consts::FRAC_PI_2, 0.0, 0.0),
    );
    Cylinder::new(half_m, person.radius_m).cast_ray(&pose, ray, reach, true)
}

fn vector(point: Point3<f64>) -> Vector {
    Vector::new(point.x, point.y, point.z)
}

//! The floor plan of the building as it truly stands: turned as a whole about the middle of the robot's room.

use super::{LampKind, Scene};

/// The robot's room, and the angle by which the true building is turned against the building that the scene states.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Plan {
    /// Extents of the robot's room along its own sides.
    pub(crate) size_m: [f64; 2],
    /// Counter-clockwise turn of all walls about the middle of the robot's room.
    pub(crate) turn_rad: f64,
}

impl Plan {
    /// True position of a point of the building, given the position that the scene states.
    pub(crate) fn stands(&self, stated_m: [f64; 2]) -> [f64; 2] {
        self.turned(stated_m, self.turn_rad)
    }

    /// Position that the scene states for a point of the building, given its true position. In the scene the walls of the robot's room are along the
    /// world's axes.
    pub(crate) fn stated(&self, stands_m: [f64; 2]) -> [f64; 2] {
        self.turned(stands_m, -self.turn_rad)
    }

    /// Distance of a position from the nearest wall of the robot's room; negative outside the room.
    pub(crate) fn wall_distance_m(&self, at_m: [f64; 2]) -> f64 {
        let stated_m = self.stated(at_m);
        let to_wall_m = |axis: usize| stated_m[axis].min(self.size_m[axis] - stated_m[axis]);
        to_wall_m(0).min(to_wall_m(1))
    }

    /// Distance along each world axis by which the corners of the robot's room may lie beyond its stated extent when the room is turned by up to
    /// `most_rad` either way.
    pub(crate) fn beyond_m(&self, most_rad: f64) -> [f64; 2] {
        [0, 1].map(|axis| {
            let (half_m, other_m) = (0.5 * self.size_m[axis], 0.5 * self.size_m[1 - axis]);
            // A corner of the room reaches farthest along an axis when the turn puts it onto the line through the room's middle along this axis.
            let (sin, cos) = most_rad.min(other_m.atan2(half_m)).sin_cos();
            (half_m * (cos - 1.0) + other_m * sin).max(0.0)
        })
    }

    /// Turns a position about the middle of the robot's room. The change is added to the position, so that without a turn it stays the same to the
    /// last bit.
    fn turned(&self, at_m: [f64; 2], turn_rad: f64) -> [f64; 2] {
        let (sin, cos) = turn_rad.sin_cos();
        let [x_m, y_m] = [0, 1].map(|axis| at_m[axis] - 0.5 * self.size_m[axis]);
        [at_m[0] + ((cos - 1.0) * x_m - sin * y_m), at_m[1] + (sin * x_m + (cos - 1.0) * y_m)]
    }
}

impl Scene {
    /// The robot's room, and the angle by which it and all other rooms are turned.
    pub(crate) fn plan(&self) -> Plan {
        Plan { size_m: [self.room.width_m, self.room.depth_m], turn_rad: self.building.turned_rad }
    }

    /// Turns all walls, with the doors, pictures and windows in them, and the pieces of furniture that are walls. Other things that stand on the
    /// floor, lie in the floor or are under the ceiling stay in place.
    pub(crate) fn turn_walls(&mut self, turn_deg: f64) {
        self.building.turned_rad = turn_deg.to_radians();
        let plan = self.plan();
        for room in &mut self.building.rooms {
            room.turn(turn_deg, |stated_m| plan.stands(stated_m));
        }
        for piece in self.furniture.iter_mut().filter(|piece| piece.wall) {
            [piece.x_m, piece.y_m] = plan.stands([piece.x_m, piece.y_m]);
            piece.rotation_deg += turn_deg;
        }
        for door in &mut self.building.doors {
            (door.from_m, door.to_m) = (plan.stands(door.from_m), plan.stands(door.to_m));
        }
        for facade in &mut self.building.facades {
            (facade.from_m, facade.to_m) = (plan.stands(facade.from_m), plan.stands(facade.to_m));
        }
        for picture in &mut self.building.pictures {
            (picture.from_m, picture.to_m) = (plan.stands(picture.from_m), plan.stands(picture.to_m));
        }
        for window in self.lamps.iter_mut().filter(|lamp| lamp.kind == LampKind::Window) {
            [window.x_m, window.y_m] = plan.stands([window.x_m, window.y_m]);
            window.heading_deg += turn_deg;
        }
    }

    /// Every position at which the scene puts the robot: start, waypoints, goals of errands and stations, each with the tolerance within which the
    /// true position is drawn at random along x and along y.
    pub(crate) fn places(&self) -> Vec<([f64; 2], f64)> {
        let ways = self.route.iter().flat_map(|route| &route.waypoints).map(|at| ([at.x_m, at.y_m], 0.0));
        let goals = self.errands.iter().map(|errand| ([errand.x_m, errand.y_m], 0.0));
        let drawn_m = self.start.tolerance_m;
        let stations =
            self.stations.iter().map(|station| ([station.x_m, station.y_m], station.tolerance_m.unwrap_or(drawn_m)));
        let start = std::iter::once(([self.start.x_m, self.start.y_m], drawn_m));
        start.chain(ways).chain(goals).chain(stations).collect()
    }
}

//! The walls of the localizer's map, and how far the true walls are from them.

use localizer::map::Wall;

use super::{UprightBox, walls};
use crate::{
    place::drawn::DrawnPlace,
    scene::{MethodName, Plan, Scene},
};

impl Scene {
    /// Fronts of the walls as the scene states them: the sides of all rooms without the doors in them, whether these are open or closed, and the
    /// sides of the pieces of furniture that are walls.
    pub(crate) fn mapped_walls(&self) -> Vec<Wall> {
        let sides = walls::standing_walls(&walls::enclosures(self));
        let parts = sides.iter().flat_map(|side| {
            let gaps = self.building.doors.iter().filter_map(|door| walls::on_side(door, side)).collect();
            let at = |share: f64| {
                let at = side.from + (side.to - side.from) * share;
                [at.x, at.y]
            };
            walls::remaining(gaps).into_iter().map(move |shares| Wall { ends_m: shares.map(at) })
        });
        let pieces = self.furniture.iter().filter(|piece| piece.wall).flat_map(|piece| {
            let corners = UprightBox::from(piece).corners();
            // The corners go round counter-clockwise, so that the way back from each to the one before has the outside on its left.
            let at = move |index: usize| [corners[index % 4].x, corners[index % 4].y];
            (0..4).map(move |index| Wall { ends_m: [at(index + 1), at(index)] })
        });
        parts.chain(pieces).collect()
    }

    /// Greatest distance of an end of a true wall from its place on the map.
    pub(crate) fn walls_off_m(&self, drawn: &DrawnPlace) -> f64 {
        let off_m = |end_m: [f64; 2]| {
            let [x_m, y_m] = self.wall_stands_m(end_m, drawn);
            (x_m - end_m[0]).hypot(y_m - end_m[1])
        };
        self.mapped_walls().into_iter().flat_map(|wall| wall.ends_m).map(off_m).fold(0.0, f64::max)
    }

    /// Where a point of a wall truly stands, given its place on the map.
    pub(crate) fn wall_stands_m(&self, mapped_m: [f64; 2], drawn: &DrawnPlace) -> [f64; 2] {
        Plan { turn_rad: drawn.walls_turn_deg.to_radians(), ..self.plan() }.stands(mapped_m)
    }

    /// Whether a method of the localizer relies on the places of walls.
    fn relies_on_places_of_walls(&self) -> bool {
        [MethodName::WallRanges, MethodName::WallBearings].iter().any(|name| self.localizer.methods.contains(name))
    }

    /// Greatest turn of all walls, about the middle of the robot's room, that the declared bounds on them allow; 0 where no method relies on walls.
    pub(crate) fn most_walls_turn_deg(&self) -> f64 {
        let methods = &self.localizer.methods;
        let by_direction_deg = self.localizer.wall_directions().tolerance_deg;
        match (methods.contains(&MethodName::WallDirections), self.relies_on_places_of_walls()) {
            (false, false) => 0.0,
            (true, false) => by_direction_deg,
            (false, true) => self.turn_by_placement_deg(),
            (true, true) => by_direction_deg.min(self.turn_by_placement_deg()),
        }
    }

    /// Greatest random turn of the walls against the scene: what the declared bounds allow, less the error of the directions that the map states.
    pub(crate) fn walls_askew_deg(&self) -> f64 {
        if !self.localizer.methods.contains(&MethodName::WallDirections) {
            return self.most_walls_turn_deg();
        }
        let off_deg = self.wall_directions_off_deg(&self.stated_wall_directions_deg());
        let by_direction_deg = (self.localizer.wall_directions().tolerance_deg - off_deg).max(0.0);
        by_direction_deg.min(self.most_walls_turn_deg())
    }

    /// The turn that moves the end of a wall that is farthest from the middle of the robot's room by the tolerance of the walls' places.
    fn turn_by_placement_deg(&self) -> f64 {
        let middle_m = [0.5 * self.room.width_m, 0.5 * self.room.depth_m];
        let ends_m = self.mapped_walls().into_iter().flat_map(|wall| wall.ends_m);
        let farthest_m = ends_m.map(|[x_m, y_m]| (x_m - middle_m[0]).hypot(y_m - middle_m[1])).fold(0.0, f64::max);
        let share = 0.5 * self.localizer.wall_ranges().placement_tolerance_m / farthest_m.max(f64::MIN_POSITIVE);
        2.0 * share.min(1.0).asin().to_degrees()
    }
}

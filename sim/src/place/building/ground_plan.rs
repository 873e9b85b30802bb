//! Ground plan of the building: the walls that bodies, rays and paths meet, with holes where doors stand open and where rooms run into each other.

use nalgebra::{Point3, Vector2, vector};

use super::{
    leads_into_a_room,
    walls::{Enclosure, covered, enclosures, on_side, remaining},
};
use crate::scene::{Door, Plan, Scene};

mod blocks;
mod wall;

use wall::{Wall, feet};

/// Thickness of the walls of a building with a single room, and the greatest thickness of walls between rooms. A body that was driven deeper than half
/// of it would come out behind.
pub(crate) const WALL_THICKNESS_M: f64 = 1.0;

/// The walls of a building as bodies, rays and paths meet them.
#[derive(Clone, Debug)]
pub(crate) struct GroundPlan {
    plan: Plan,
    /// All rooms, where there are further ones beside the robot's own.
    rooms: Option<Rooms>,
}

/// Several rooms with the walls between them.
#[derive(Clone, Debug)]
struct Rooms {
    rooms: Vec<Enclosure>,
    walls: Vec<Wall>,
    doorways: Vec<Doorway>,
}

/// A wall that hides the floor behind it. It faces the left of the way from its start to its end.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Face {
    /// Ends of the wall on the floor plan, world frame.
    pub(crate) ends_m: [Vector2<f64>; 2],
    /// How far beyond the start and beyond the end of the wall the floor behind its line is hidden, too, as it is at the corners of a room.
    pub(crate) goes_on_m: [f64; 2],
}

/// The passage of an open door, between the two rooms that it connects.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Doorway {
    /// Corners of the passage's floor in order, world frame: both jambs in the one room, then both in the other.
    pub(crate) corners_m: [Vector2<f64>; 4],
    /// Height of the door's upper edge above the floor.
    pub(crate) height_m: f64,
}

impl GroundPlan {
    /// The ground plan of a scene's building: as the scene states it, or as it truly stands if the scene's walls have been turned.
    pub(crate) fn of(scene: &Scene) -> GroundPlan {
        let rooms = enclosures(scene);
        GroundPlan { plan: scene.plan(), rooms: (rooms.len() > 1).then(|| Rooms::of(scene, rooms)) }
    }

    /// Whether the building has further rooms beside the robot's own.
    pub(crate) fn has_further_rooms(&self) -> bool {
        self.rooms.is_some()
    }

    /// The passages of open doors between rooms.
    pub(crate) fn doorways(&self) -> &[Doorway] {
        self.rooms.as_ref().map_or(&[], |rooms| &rooms.doorways)
    }

    /// Distance of a position on the floor from the nearest wall that reaches the floor; negative where there is no floor.
    pub(crate) fn wall_distance_m(&self, at_m: [f64; 2]) -> f64 {
        match &self.rooms {
            None => self.plan.wall_distance_m(at_m),
            Some(rooms) => {
                let at = Vector2::from(at_m);
                let nearest_m = rooms.feet().map(|wall| wall.distance_m(at)).fold(f64::INFINITY, f64::min);
                if rooms.contains(at) { nearest_m } else { -nearest_m }
            }
        }
    }

    /// Distance of a square on the floor, with sides along the world's axes, from the nearest wall that reaches the floor; negative where the middle of
    /// the square is on no floor. The square is where the robot may be drawn about a stated place.
    pub(crate) fn wall_distance_from_square_m(&self, centre_m: [f64; 2], half_m: f64) -> f64 {
        match &self.rooms {
            None => {
                // The square reaches this far towards a turned wall.
                let (sin, cos) = self.plan.turn_rad.sin_cos();
                self.plan.wall_distance_m(centre_m) - half_m * (cos + sin.abs())
            }
            Some(rooms) => {
                let centre = Vector2::from(centre_m);
                let distances_m = rooms.feet().map(|wall| wall.distance_from_square_m(centre, half_m));
                let nearest_m = distances_m.fold(f64::INFINITY, f64::min);
                if rooms.contains(centre) { nearest_m } else { -nearest_m }
            }
        }
    }

    /// Whether a wall stands between two points, of which the second is on or near a surface: nothing counts within `margin_m` of it. A point farther
    /// than `margin_m` outside of all rooms is behind a wall.
    pub(crate) fn separates(&self, from: Point3<f64>, to: Point3<f64>, margin_m: f64) -> bool {
        // A point that is stated on a wall counts as inside, even if the wall is turned away from where it is stated.
        let Some(rooms) = &self.rooms else {
            let stated = Plan { turn_rad: 0.0, ..self.plan };
            let inside = |point: &Point3<f64>| {
                [self.plan, stated].iter().any(|plan| plan.wall_distance_m([point.x, point.y]) >= -margin_m)
            };
            // A room is convex, so that no wall stands between two points inside it.
            return !inside(&from) || !inside(&to);
        };
        let [x_m, y_m] = self.plan.stands([to.x, to.y]);
        let places = [to, Point3::new(x_m, y_m, to.z)];
        let sees = |to: &Point3<f64>| {
            let inside = [from, *to].iter().all(|at| self.wall_distance_m([at.x, at.y]) >= -margin_m);
            inside && !rooms.walls.iter().any(|wall| wall.separates(from, *to, margin_m))
        };
        !places.iter().any(sees)
    }

    /// Distance from a point to the nearest wall along a level direction; infinite where there is none.
    pub(crate) fn wall_ahead_m(&self, eye: Point3<f64>, direction_rad: f64) -> f64 {
        if let Some(rooms) = &self.rooms {
            let (sin, cos) = direction_rad.sin_cos();
            let stands = rooms.walls.iter().filter(|wall| wall.between_m[0] <= eye.z && eye.z <= wall.between_m[1]);
            return stands
                .filter_map(|wall| wall.met_at_m(eye.xy().coords, vector![cos, sin]))
                .fold(f64::INFINITY, f64::min);
        }
        // The ray is intersected with the walls in the frame in which they stand along the axes.
        let stated_m = self.plan.stated([eye.x, eye.y]);
        let wall_m = |axis: usize, along: f64| {
            let face_m = if along > 0.0 { self.plan.size_m[axis] } else { 0.0 };
            if along == 0.0 { f64::INFINITY } else { ((face_m - stated_m[axis]) / along).max(0.0) }
        };
        let (sin, cos) = (direction_rad - self.plan.turn_rad).sin_cos();
        wall_m(0, cos).min(wall_m(1, sin))
    }

    /// The least and the greatest coordinates of all floors, world frame.
    pub(crate) fn extents_m(&self) -> [[f64; 2]; 2] {
        self.floors_m().into_iter().flatten().fold([[f64::INFINITY; 2], [f64::NEG_INFINITY; 2]], |[low, high], at| {
            [[0, 1].map(|axis| low[axis].min(at[axis])), [0, 1].map(|axis| high[axis].max(at[axis]))]
        })
    }

    /// Whether a square on the floor, with sides along the axes, is floor everywhere and goes over into the squares beside it: its middle is on a
    /// floor, no wall passes through it, and no wall along one of its sides parts it from another such square.
    pub(crate) fn leaves_square_free(&self, centre_m: [f64; 2], half_m: f64) -> bool {
        // Sums of decimal fractions are not exact, so that a wall along a side of the square does not pass through it by rounding alone.
        const ROUNDING_M: f64 = 1e-9;
        let Some(rooms) = &self.rooms else {
            return (0..2)
                .all(|axis| centre_m[axis] >= 0.0 && centre_m[axis] + half_m <= self.plan.size_m[axis] + ROUNDING_M);
        };
        let inside = Vector2::repeat(half_m - ROUNDING_M);
        let is_floor =
            |centre: Vector2<f64>| rooms.contains(centre) && !rooms.feet().any(|wall| wall.crosses_box(centre, inside));
        // The square longer by rounding along one axis and shorter along the other: a wall that touches only a corner of the square is in neither.
        let with_sides = [Vector2::x(), Vector2::y()].map(|axis| inside + axis * (2.0 * ROUNDING_M));
        let centre = Vector2::from(centre_m);
        let parts_floors = |wall: &Wall| {
            with_sides.iter().any(|half| wall.crosses_box(centre, *half)) && is_floor(wall.mirrored(centre))
        };
        is_floor(centre) && !rooms.feet().any(parts_floors)
    }

    /// The floors of rooms and of open doors, in convex parts, each by its corners in order, world frame.
    pub(crate) fn floors_m(&self) -> Vec<Vec<[f64; 2]>> {
        match &self.rooms {
            None => vec![self.corners_m().to_vec()],
            Some(rooms) => rooms.floors().map(|corners| corners.into_iter().map(Into::into).collect()).collect(),
        }
    }

    /// The feet of all walls, each by its ends, world frame.
    pub(crate) fn walls_m(&self) -> Vec<[[f64; 2]; 2]> {
        match &self.rooms {
            None => (0..4).map(|side| [side, (side + 1) % 4].map(|corner| self.corners_m()[corner])).collect(),
            Some(rooms) => rooms.feet().map(|wall| wall.ends_m.map(Into::into)).collect(),
        }
    }

    /// Corners of the robot's room, in order, world frame.
    fn corners_m(&self) -> [[f64; 2]; 4] {
        let [width, depth] = self.plan.size_m;
        [[0.0, 0.0], [width, 0.0], [width, depth], [0.0, depth]].map(|corner| self.plan.stands(corner))
    }

    /// The walls that hide the floor behind them from a place above the floor: those that show it their faces.
    pub(crate) fn faces_seen_from(&self, place_m: [f64; 2]) -> Vec<Face> {
        let at = Vector2::from(place_m);
        match &self.rooms {
            None => {
                let face =
                    |ends_m: [[f64; 2]; 2]| Face { ends_m: ends_m.map(Vector2::from), goes_on_m: [f64::INFINITY; 2] };
                self.walls_m().into_iter().map(face).collect()
            }
            Some(rooms) => rooms.faces_seen_from(at),
        }
    }
}

impl Rooms {
    fn of(scene: &Scene, rooms: Vec<Enclosure>) -> Rooms {
        // An open door behind which there is no room is seen as a hole, but nothing goes through it.
        let doors: Vec<&Door> =
            scene.building.doors.iter().filter(|door| door.open && leads_into_a_room(door, &rooms)).collect();
        let mut walls = Vec::new();
        for (index, room) in rooms.iter().enumerate() {
            for side in room.sides() {
                let free_m = room.free_beyond_m(&side);
                let mut gaps = covered(&rooms, index, &side);
                let holes = doors.iter().filter_map(|door| Some((door.height_m, on_side(door, &side)?)));
                for (height_m, shares) in holes {
                    walls.push(Wall::on(&side, (index, free_m), shares, [height_m, room.height_m]));
                    gaps.push(shares);
                }
                let stand = remaining(gaps).into_iter();
                walls.extend(stand.map(|at| Wall::on(&side, (index, free_m), at, [0.0, room.height_m])));
            }
        }
        let mut doorways = Vec::new();
        for door in doors {
            let of_room = |room: &Enclosure| -> Vec<[Vector2<f64>; 2]> {
                let mut sides = room.sides().filter_map(|side| Some((side.inward, feet(&side, on_side(door, &side)?))));
                let Some((inward, sill)) = sides.next() else { return Vec::new() };
                // A door may lead from one part of a room that is not convex into another part.
                let behind = sides.find(|(other, _)| other.dot(&inward) < 0.0);
                std::iter::once(sill).chain(behind.map(|(_, sill)| sill)).collect()
            };
            let sills: Vec<[Vector2<f64>; 2]> = rooms.iter().flat_map(of_room).collect();
            if let [[left, right], [back_right, back_left], ..] = sills[..] {
                let doorway = Doorway { corners_m: [left, right, back_right, back_left], height_m: door.height_m };
                walls.extend(doorway.jambs().map(|ends_m| Wall {
                    ends_m,
                    between_m: [0.0, door.height_m],
                    room: None,
                    free_beyond_m: [0.0; 2],
                }));
                doorways.push(doorway);
            }
        }
        Rooms { rooms, walls, doorways }
    }

    fn contains(&self, at: Vector2<f64>) -> bool {
        let on_floor = Point3::new(at.x, at.y, 0.0);
        self.rooms.iter().any(|room| room.contains(on_floor)) || self.doorways.iter().any(|door| door.contains(at))
    }

    fn faces_seen_from(&self, at: Vector2<f64>) -> Vec<Face> {
        let on_floor = Point3::new(at.x, at.y, 0.0);
        let is_here: Vec<bool> = self.rooms.iter().map(|room| room.contains(on_floor)).collect();
        let face = |wall: &Wall| {
            let [from, to] = wall.ends_m;
            let is_before = (to - from).perp(&(at - from)) >= 0.0;
            let is_here = wall.room.is_some_and(|room| is_here[room]);
            let goes_on_m = wall.free_beyond_m.map(|free_m| if is_here { free_m } else { 0.0 });
            is_before.then_some(Face { ends_m: wall.ends_m, goes_on_m })
        };
        self.feet().filter_map(face).collect()
    }

    /// The floors of rooms and of open doors, in convex parts, each by its corners in order.
    fn floors(&self) -> impl Iterator<Item = Vec<Vector2<f64>>> {
        let of_doors = self.doorways.iter().map(|door| door.corners_m.to_vec());
        self.rooms.iter().flat_map(Enclosure::floors).chain(of_doors)
    }

    /// The parts of walls that reach the floor.
    fn feet(&self) -> impl Iterator<Item = &Wall> {
        self.walls.iter().filter(|wall| wall.between_m[0] == 0.0)
    }
}

impl Doorway {
    /// The feet of the door's two jambs, each by its ends in the one room and in the other.
    pub(crate) fn jambs(&self) -> [[Vector2<f64>; 2]; 2] {
        let [left, right, back_right, back_left] = self.corners_m;
        [[left, back_left], [back_right, right]]
    }

    /// Whether a position is in the doorway, whose corners go round either way.
    pub(crate) fn contains(&self, at: Vector2<f64>) -> bool {
        let turns = (0..4).map(|index| {
            let (from, to) = (self.corners_m[index], self.corners_m[(index + 1) % 4]);
            (to - from).perp(&(at - from))
        });
        // The corners of rooms that stand wall to wall enclose nothing.
        let turns: Vec<f64> = turns.collect();
        turns.iter().all(|turn| *turn >= 0.0) && turns.iter().any(|turn| *turn > 0.0)
            || turns.iter().all(|turn| *turn <= 0.0) && turns.iter().any(|turn| *turn < 0.0)
    }
}

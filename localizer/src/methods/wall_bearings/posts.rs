//! The upright edges of mapped walls that are sharp in an image: corners that stand out into a room, such as those of free walls and partitions.
//!
//! The inner corners of rooms are left out: where two walls meet, the light changes over some centimetres, so that no edge is seen at the corner
//! itself. So are places at which a single wall ends: there is a door, whose frame has edges of its own some centimetres beside.

use crate::map::Wall;

/// Greatest distance between the ends of two walls that meet, on the map.
const SAME_M: f64 = 1e-6;
/// Sine of the least angle by which a corner stands out.
const STANDS_OUT: f64 = 1e-3;
/// Distance from another wall within which a wall's end counts as joined to it.
const JOINED_M: f64 = 0.02;
/// Share of the way to an edge beyond which a wall that crosses it hides nothing: it meets the edge there.
const NEAR_SHARE: f64 = 0.99;

/// An upright edge of one or several walls.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Post {
    /// Place on the floor plan, world x and y.
    pub(super) at_m: [f64; 2],
    /// Numbers of the walls that end here.
    walls: Vec<usize>,
}

/// The upright edges of walls.
pub(super) fn posts(walls: &[Wall]) -> Vec<Post> {
    let mut posts: Vec<Post> = Vec::new();
    for (number, wall) in walls.iter().enumerate() {
        for end_m in wall.ends_m {
            match posts.iter_mut().find(|post| length_m(minus(post.at_m, end_m)) < SAME_M) {
                Some(post) => post.walls.push(number),
                None => posts.push(Post { at_m: end_m, walls: vec![number] }),
            }
        }
    }
    posts.retain(|post| stands_out(post, walls));
    posts
}

/// Whether two walls, and no other one, meet at a place in a corner that stands out towards their fronts.
fn stands_out(post: &Post, walls: &[Wall]) -> bool {
    let is_joined =
        |(number, wall): (usize, &Wall)| !post.walls.contains(&number) && distance_m(post.at_m, wall) < JOINED_M;
    if walls.iter().enumerate().any(is_joined) {
        return false;
    }
    let way = |number: usize| minus(walls[number].ends_m[1], walls[number].ends_m[0]);
    let [a, b] = *post.walls.as_slice() else { return false };
    // The front of a wall is to its left: a corner at which the way turns to the right stands out.
    let a_comes_first = length_m(minus(walls[a].ends_m[1], post.at_m)) < SAME_M;
    let [first, second] = if a_comes_first { [a, b] } else { [b, a] };
    cross(way(first), way(second)) < -STANDS_OUT * length_m(way(first)) * length_m(way(second))
}

/// Distance of a place from a wall.
fn distance_m(at_m: [f64; 2], wall: &Wall) -> f64 {
    let [start, end] = wall.ends_m;
    let (way, off) = (minus(end, start), minus(at_m, start));
    let square = way[0] * way[0] + way[1] * way[1];
    let share = if square > 0.0 { ((off[0] * way[0] + off[1] * way[1]) / square).clamp(0.0, 1.0) } else { 0.0 };
    length_m(minus(at_m, [start[0] + share * way[0], start[1] + share * way[1]]))
}

/// Whether an upright edge is in view from a place: one of its walls shows its front, and no other wall stands before it.
pub(super) fn is_in_view(post: &Post, from_m: [f64; 2], walls: &[Wall]) -> bool {
    let shows_front = |number: &usize| {
        let [start, end] = walls[*number].ends_m;
        cross(minus(end, start), minus(from_m, start)) > 0.0
    };
    let hides = |(number, wall): (usize, &Wall)| {
        !post.walls.contains(&number) && share_to(from_m, post.at_m, wall).is_some_and(|share| share < NEAR_SHARE)
    };
    post.walls.iter().any(shows_front) && !walls.iter().enumerate().any(hides)
}

/// Share of the way from one place to another at which a wall crosses it; `None` where it does not.
fn share_to(from_m: [f64; 2], to_m: [f64; 2], wall: &Wall) -> Option<f64> {
    let [start, end] = wall.ends_m;
    let (way, along, off) = (minus(to_m, from_m), minus(end, start), minus(start, from_m));
    let across = cross(way, along);
    let (share, on_wall) = (cross(off, along) / across, cross(off, way) / across);
    (across != 0.0 && share > 0.0 && (0.0..=1.0).contains(&on_wall)).then_some(share)
}

fn minus(a: [f64; 2], b: [f64; 2]) -> [f64; 2] {
    [a[0] - b[0], a[1] - b[1]]
}

fn cross(a: [f64; 2], b: [f64; 2]) -> f64 {
    a[0] * b[1] - a[1] * b[0]
}

fn length_m(way_m: [f64; 2]) -> f64 {
    way_m[0].hypot(way_m[1])
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A room of 4 m by 3 m whose wall at y = 0 has a door from x = 1 to x = 2 and goes on in two pieces, and a free wall in its middle.
    fn walls() -> Vec<Wall> {
        let corners = [[2.0, 0.0], [3.0, 0.0], [4.0, 0.0], [4.0, 3.0], [0.0, 3.0], [0.0, 0.0], [1.0, 0.0]];
        let sides = corners.windows(2).map(|ends| Wall { ends_m: [ends[0], ends[1]] });
        let free = [[1.8, 1.4], [2.2, 1.4], [2.2, 1.6], [1.8, 1.6]];
        // Walls of free pieces run clockwise, with their fronts outside.
        let pieces = (0..4).map(|index| Wall { ends_m: [free[(index + 1) % 4], free[index]] });
        sides.chain(pieces).collect()
    }

    fn sorted(found: impl Iterator<Item = Post>) -> Vec<[f64; 2]> {
        let mut found: Vec<[f64; 2]> = found.map(|post| post.at_m).collect();
        found.sort_by(|a, b| a[0].total_cmp(&b[0]).then(a[1].total_cmp(&b[1])));
        found
    }

    #[test]
    fn corners_that_stand_out_are_used_and_inner_corners_doors_and_joins_are_not() {
        // By hand: four corners of the free wall. At (1, 0) and (2, 0) a door begins and ends, and at (3, 0) the wall goes straight on.
        assert_eq!(sorted(posts(&walls()).into_iter()), [[1.8, 1.4], [1.8, 1.6], [2.2, 1.4], [2.2, 1.6]]);
        // A free wall that stands with one end at the wall at y = 3 has two edges, at its other end.
        let joined = [[1.8, 1.4], [2.2, 1.4], [2.2, 3.0], [1.8, 3.0]];
        let mut walls = walls();
        walls.truncate(6);
        walls.extend((0..4).map(|index| Wall { ends_m: [joined[(index + 1) % 4], joined[index]] }));
        assert_eq!(sorted(posts(&walls).into_iter()), [[1.8, 1.4], [2.2, 1.4]]);
    }

    #[test]
    fn an_edge_behind_a_wall_or_at_the_backs_of_walls_is_out_of_view() {
        let walls = walls();
        let seen = |from_m: [f64; 2]| sorted(posts(&walls).into_iter().filter(|post| is_in_view(post, from_m, &walls)));
        // From (2, 0.5) the near edges of the free wall are in view, the far ones are behind it, as both of their walls show their backs.
        assert_eq!(seen([2.0, 0.5]), [[1.8, 1.4], [2.2, 1.4]]);
        // Beside its end, at x = 2.5, three of its edges are in view.
        assert_eq!(seen([2.5, 2.8]), [[1.8, 1.6], [2.2, 1.4], [2.2, 1.6]]);
        // From below the room the wall at y = 0 hides them all at (0.1, −1), where the ways to them cross it at x from 0.75 to 0.98, and none of the
        // three that show a front at (1.5, −0.2), before the door.
        assert_eq!(seen([0.1, -1.0]), Vec::<[f64; 2]>::new());
        assert_eq!(seen([1.5, -0.2]), [[1.8, 1.4], [1.8, 1.6], [2.2, 1.4]]);
    }
}

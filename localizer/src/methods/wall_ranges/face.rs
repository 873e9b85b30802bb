//! The front of a mapped wall as a directed line segment.

use interval::Interval;

use crate::map::Wall;

/// The front of a wall: the side to the left of the way from its start to its end.
#[derive(Clone, Copy, Debug)]
pub(super) struct Face {
    /// Unit vector from the wall's start to its end.
    pub(super) along: [Interval; 2],
    /// Unit vector out of the wall's front.
    pub(super) normal: [Interval; 2],
    /// Signed distance of the wall's line from the world's origin, along the normal.
    pub(super) offset: Interval,
    /// Distances along the wall's direction at which the wall begins and ends, measured from the world's origin.
    pub(super) ends: [Interval; 2],
}

impl Face {
    /// The front of a mapped wall; `None` for a wall of no length or with an end that is not finite.
    pub(super) fn of(wall: &Wall) -> Option<Face> {
        let [from, to] = wall.ends_m.map(|end_m| end_m.map(Interval::point));
        let way = [to[0] - from[0], to[1] - from[1]];
        let length = way[0].hypot(way[1]);
        if !length.is_bounded() || length.lo() <= 0.0 {
            return None;
        }
        let along = way.map(|side| side / length);
        let normal = [-along[1], along[0]];
        let start = dot(along, from);
        Some(Face { along, normal, offset: dot(normal, from), ends: [start, start + length] })
    }
}

pub(super) fn dot(a: [Interval; 2], b: [Interval; 2]) -> Interval {
    a[0] * b[0] + a[1] * b[1]
}

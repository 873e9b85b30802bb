//! Which upright edges of the map the upright edges of an image may be.

use interval::Interval;

use crate::{PoseBox, PoseUnion, map::Wall};

use super::{
    posts::{Post, is_in_view},
    strips::Strip,
};

/// Image edges and edges of the map that may belong together: at least one pair of them does, if the sighting is true.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Sighting {
    /// Numbers of the image edges.
    pub(super) edges: Vec<usize>,
    /// Numbers of the edges of the map.
    pub(super) posts: Vec<usize>,
    /// Pairs of an image edge and an edge of the map.
    pub(super) pairs: Vec<[usize; 2]>,
}

/// An upright edge of an image, as it is compared with edges of the map.
#[derive(Clone, Copy, Debug)]
pub(super) struct ImageEdge {
    /// Direction in which the edge is seen, counter-clockwise from robot forward.
    pub(super) bearing: Interval,
    /// Tangent of the elevation at which its upper end is seen; `None` where the edge may go on beyond the image's border.
    pub(super) ends_at: Option<f64>,
}

/// What an image edge is compared with: edges of the map as seen from a place on the robot.
pub(super) struct Atlas<'a> {
    pub(super) posts: &'a [Post],
    pub(super) walls: &'a [Wall],
    pub(super) placement_m: f64,
    /// Place from which the image was taken, in the robot frame.
    pub(super) eye_m: [Interval; 2],
    /// Height of that place above the floor.
    pub(super) height_m: f64,
    /// Height from which on an edge is one of a wall rather than of a thing in the room.
    pub(super) tallest_thing_m: f64,
}

impl Atlas<'_> {
    /// Sightings of an image with the given upright edges, from any pose of a union. Pairs that have an image edge or an edge
    /// of the map in common belong to one sighting.
    pub(super) fn sightings(&self, edges: &[ImageEdge], prior: &PoseUnion) -> Vec<Sighting> {
        let mut found: Vec<Sighting> = Vec::new();
        let shown: Vec<Vec<bool>> = prior.branches.iter().map(|branch| self.in_view(branch)).collect();
        for (number, image_edge) in edges.iter().enumerate() {
            for (post_number, post) in self.posts.iter().enumerate() {
                let strip = Strip {
                    bearing: image_edge.bearing,
                    eye_m: self.eye_m,
                    post_m: post.at_m,
                    placement_m: self.placement_m,
                };
                let may_be = |(branch, shown): (&PoseBox, &Vec<bool>)| {
                    shown[post_number] && self.is_tall(image_edge, post, branch) && strip.is_possible(branch)
                };
                if prior.branches.iter().zip(&shown).any(may_be) {
                    join(&mut found, number, post_number);
                }
            }
        }
        found
    }

    /// Whether an image edge would be higher than things in the room if it were the given edge of the map, seen from the middle of a box.
    fn is_tall(&self, edge: &ImageEdge, post: &Post, branch: &PoseBox) -> bool {
        let far_m = (post.at_m[0] - branch[0].mid()).hypot(post.at_m[1] - branch[1].mid());
        edge.ends_at.is_none_or(|tangent| self.height_m + far_m * tangent >= self.tallest_thing_m)
    }

    /// For each edge of the map, whether it is in view from the middle of a box or from one of its corners.
    fn in_view(&self, branch: &PoseBox) -> Vec<bool> {
        let [x, y] = [branch[0], branch[1]];
        let from_m = [[x.mid(), y.mid()], [x.lo(), y.lo()], [x.lo(), y.hi()], [x.hi(), y.lo()], [x.hi(), y.hi()]];
        self.posts.iter().map(|post| from_m.iter().any(|from| is_in_view(post, *from, self.walls))).collect()
    }
}

/// Adds a pair, and makes one of all sightings that it belongs to.
fn join(found: &mut Vec<Sighting>, edge: usize, post: usize) {
    let mut joined = Sighting { edges: vec![edge], posts: vec![post], pairs: vec![[edge, post]] };
    found.retain(|other| {
        let belongs = other.edges.contains(&edge) || other.posts.contains(&post);
        if belongs {
            let new = |all: &[usize], more: &[usize]| more.iter().copied().filter(|one| !all.contains(one)).collect();
            let (edges, posts): (Vec<usize>, Vec<usize>) =
                (new(&joined.edges, &other.edges), new(&joined.posts, &other.posts));
            joined.edges.extend(edges);
            joined.posts.extend(posts);
            joined.pairs.extend(&other.pairs);
        }
        !belongs
    });
    found.push(joined);
}

#[cfg(test)]
mod tests {
    use super::{super::posts::posts, *};

    /// Sightings of a wall's end at (3, 0) and another's at (3, 0.6), seen from the origin by a robot that faces x.
    fn seen(edges: &[ImageEdge], half_m: f64) -> Vec<Sighting> {
        let piece = |from: f64, to: f64| {
            let corners = [[3.0, from], [3.0, to], [3.5, to], [3.5, from]];
            (0..4).map(move |index| Wall { ends_m: [corners[index], corners[(index + 1) % 4]] })
        };
        let walls: Vec<Wall> = piece(-1.0, 0.0).chain(piece(0.6, 1.6)).collect();
        let mut posts = posts(&walls);
        posts.retain(|post| post.at_m[0] == 3.0);
        assert_eq!(posts.iter().map(|post| post.at_m[1]).collect::<Vec<_>>(), [-1.0, 0.0, 0.6, 1.6]);
        let atlas = Atlas {
            posts: &posts,
            walls: &walls,
            placement_m: 0.01,
            eye_m: [Interval::ZERO; 2],
            height_m: 0.25,
            tallest_thing_m: 2.0,
        };
        let within = Interval::new(-half_m, half_m);
        atlas.sightings(edges, &PoseUnion::single(PoseBox::from([within, within, Interval::ZERO])))
    }

    fn edge(bearing_rad: f64, ends_at: Option<f64>) -> ImageEdge {
        ImageEdge { bearing: Interval::centred(bearing_rad, 0.001), ends_at }
    }

    #[test]
    fn edges_lower_than_things_in_the_room_are_left_out_unless_they_leave_the_picture() {
        // 3 m away, an edge whose upper end is seen at the tangent 0.55 is 1.9 m high, one at 0.6 is 2.05 m high.
        let n_seen = |ends_at: Option<f64>| seen(&[edge(0.0, ends_at)], 0.01).len();
        assert_eq!([Some(0.55), Some(0.6), None].map(n_seen), [0, 1, 1]);
    }

    #[test]
    fn pairs_with_an_edge_in_common_make_one_sighting() {
        // The ends at y = 0 and y = 0.6 are seen at 0 and at 0.197 rad.
        let edges = [edge(0.0, None), edge(0.197, None), edge(0.1, None)];
        let near: Vec<Vec<[usize; 2]>> = seen(&edges, 0.02).into_iter().map(|sighting| sighting.pairs).collect();
        assert_eq!(near, [vec![[0, 1]], vec![[1, 2]]]);
        // From anywhere within 0.4 m the edge between may be either end, so that all of them belong together.
        let far = seen(&edges, 0.4);
        assert_eq!(far.len(), 1, "{far:?}");
        assert!(far[0].edges.len() == 3 && far[0].posts.len() >= 2, "{far:?}");
    }
}

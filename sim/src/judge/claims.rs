//! Decides whether what a method claims to have seen is true, by the simulator's own camera model and the floor as it was laid.

use std::collections::BTreeMap;

use interval::Interval;
use localizer::{Claim, map::Wall, reading::LandmarkId};
use nalgebra::{Point2, Point3, Vector3};

use super::{markers, space_points};
use crate::{
    devices::camera::{DrawnCamera, world_from_camera},
    optics::Lens,
    run::{ImageRecord, RunRecord},
    scene::Scene,
    truth::Truth,
    world::Drawn,
};

/// Number of an image's claims that are false.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct FalseClaims {
    /// False claims of upright edges.
    pub(crate) upright: usize,
    /// False claims of all kinds but upright edges.
    pub(crate) others: usize,
    /// Those of them that are about landmarks on things of which the image's quota allows all claims to be false.
    pub(crate) of_things: usize,
}

impl FalseClaims {
    pub(super) fn of(scene: &Scene, record: &RunRecord, image: &ImageRecord) -> Self {
        let is_false = |claim: &&Claim| !is_true(claim, scene, &record.drawn, &image.truth);
        let all: Vec<&Claim> = image.claims.iter().filter(is_false).collect();
        let of_things = of_most_things(all.iter().copied(), image.quota.things);
        let mut found = FalseClaims { of_things, ..FalseClaims::default() };
        for claim in all {
            match claim {
                Claim::UprightLine { .. } => found.upright += 1,
                _ => found.others += 1,
            }
        }
        found
    }

    pub(super) fn total(self) -> usize {
        self.upright + self.others
    }
}

/// Number of some claims about so many things: about those of which most are.
pub(crate) fn of_most_things<'a>(claims: impl Iterator<Item = &'a Claim>, n_things: usize) -> usize {
    let mut counts: BTreeMap<u32, usize> = BTreeMap::new();
    for claim in claims {
        if let Claim::SpacePoint { thing: Some(thing), .. } = claim {
            *counts.entry(*thing).or_default() += 1;
        }
    }
    let mut counts: Vec<usize> = counts.into_values().collect();
    counts.sort_unstable_by(|a, b| b.cmp(a));
    counts.iter().take(n_things).sum()
}

/// Whether a claim about an image taken at the true state `truth` holds.
pub fn is_true(claim: &Claim, scene: &Scene, drawn: &Drawn, truth: &Truth) -> bool {
    match claim {
        Claim::FloorJoint { points_px, share_wrong } => {
            joint_claimed(points_px, *share_wrong, scene, drawn, truth).is_some()
        }
        Claim::WallLine { ends_px, bound_px } => wall_line_deg(*ends_px, *bound_px, scene, drawn, truth).is_some(),
        Claim::UprightLine { ends_px, bound_px } => sight_planes(*ends_px, *bound_px, scene, drawn, truth)
            .is_some_and(|planes| may_hold(&planes, &[Vector3::z()])),
        Claim::Marker { marker, dots_px } => markers::is_marker(*marker, dots_px, scene, drawn, truth),
        Claim::Landmark { landmark, in_robot_m } => landmark_in_box(*landmark, in_robot_m, scene, truth),
        Claim::WallPoint { bearing_rad, distance_m, range_error_m, placement_m } => {
            let distances_m = [distance_m - range_error_m, distance_m + range_error_m].map(|end_m| end_m.max(0.0));
            ends_at_a_wall(*bearing_rad, distances_m, *placement_m, scene, drawn, truth).unwrap_or(false)
        }
        Claim::SpacePoint { point, at_px, half_width_px, view, .. } => {
            let seen = (*at_px, *half_width_px);
            space_points::is_seen(point, view.as_ref(), seen, scene, drawn, truth).unwrap_or(false)
        }
        Claim::WallUpright { lines, posts_m } => lines.iter().any(|(ends_px, bound_px)| {
            let shows = |post_m: &[f64; 2]| shows_post(*ends_px, *bound_px, *post_m, scene, drawn, truth);
            posts_m.iter().any(|post_m| shows(post_m).unwrap_or(false))
        }),
    }
}

/// Whether the image of the upright edge of a wall, which is at `post_m` on the map and where it truly stands, passes both ends of a claimed line
/// within the claim's bound; `None` where there is no forward camera, or the lens shows no such pixel.
fn shows_post(
    ends_px: [[f64; 2]; 2],
    bound_px: f64,
    post_m: [f64; 2],
    scene: &Scene,
    drawn: &Drawn,
    truth: &Truth,
) -> Option<bool> {
    let (camera, mount) = (scene.robot.forward_camera.as_ref()?, drawn.devices.forward_camera.as_ref()?);
    let (lens, world_from_camera) = (Lens::of(camera, mount), world_from_camera(truth, mount));
    let [x_m, y_m] = scene.wall_stands_m(post_m, &drawn.place);
    let eye = world_from_camera * Point3::origin();
    let to_post = Vector3::new(x_m - eye.x, y_m - eye.y, 0.0);
    let plane = Vector3::z().cross(&to_post);
    let [[u0, v0], [u1, v1]] = ends_px;
    let length_px = (u1 - u0).hypot(v1 - v0);
    let across_px = [-(v1 - v0) / length_px * bound_px, (u1 - u0) / length_px * bound_px];
    let ray = |[u, v]: [f64; 2], side: f64| {
        let [x, y] = lens.ray([u + side * across_px[0], v + side * across_px[1]])?;
        Some(world_from_camera.rotation * Vector3::new(x, y, 1.0))
    };
    for end_px in ends_px {
        let [one, other] = [ray(end_px, -1.0)?, ray(end_px, 1.0)?];
        // The edge is between both sides of the end, and before the camera.
        if plane.dot(&one) * plane.dot(&other) > 0.0 || to_post.dot(&(one + other)) <= 0.0 {
            return Some(false);
        }
    }
    Some(true)
}

/// The true floor joint along which the claimed points lie, by its family and index: all but the share `share_wrong` of them are within their own
/// bounds of the joint's centre line. `None` where there is no such joint.
pub(crate) fn joint_claimed(
    points_px: &[[f64; 3]],
    share_wrong: f64,
    scene: &Scene,
    drawn: &Drawn,
    truth: &Truth,
) -> Option<(usize, i32)> {
    let camera = scene.robot.floor_camera.as_ref()?;
    let (tiles, laid) = (scene.floor.tiles.as_ref()?, drawn.place.tiles.as_ref()?);
    let mount = drawn.devices.floor_camera.as_ref()?;
    let lens = Lens::of(camera, mount);
    let mut near: BTreeMap<(usize, i32), usize> = BTreeMap::new();
    for &[u_px, v_px, bound_px] in points_px {
        let look = |du_px: f64, dv_px: f64| on_floor([u_px + du_px, v_px + dv_px], &lens, truth, mount);
        let (Some(place_m), Some([along_u, along_v])) = (look(0.0, 0.0), slopes(&look)) else { continue };
        // The claimed point's bound in pixels as a distance on the floor, measured at right angles to the joints of each of the tile grid's two
        // directions.
        let distance_m = [0.0, 90.0].map(|turn_deg| {
            let (sin, cos) = f64::to_radians(tiles.rotation_deg + turn_deg).sin_cos();
            let across = |slope: [f64; 2]| cos * slope[0] + sin * slope[1];
            bound_px * across(along_u).hypot(across(along_v))
        });
        for joint in laid.joints_within(tiles, place_m.into(), distance_m) {
            *near.entry(joint).or_default() += 1;
        }
    }
    let needed = ((1.0 - share_wrong) * points_px.len() as f64).ceil() as usize;
    near.into_iter().find(|(_, count)| *count >= needed).map(|(joint, _)| joint)
}

/// Direction (angle from world x) along which a claimed level (horizontal) line may truly run: that of a wall or at right angles to it, up to the
/// angle by which furniture may stand askew. The line passes within `bound_px` of both claimed image points `ends_px`; `None` when there is no such
/// direction. Directions of walls are the true ones; those of furniture and of what is laid on the floor are as the scene states them.
pub fn wall_line_deg(
    ends_px: [[f64; 2]; 2],
    bound_px: f64,
    scene: &Scene,
    drawn: &Drawn,
    truth: &Truth,
) -> Option<f64> {
    let planes = sight_planes(ends_px, bound_px, scene, drawn, truth)?;
    let edges = scene.level_edges(&drawn.place).into_iter().find(|edges| {
        let directions = edges.within_deg.map(|direction_deg| {
            let (sin, cos) = direction_deg.to_radians().sin_cos();
            Vector3::new(cos, sin, 0.0)
        });
        may_hold(&planes, &directions)
    });
    edges.map(|edges| edges.direction_deg)
}

/// Normals, in the world frame, of four planes through the forward camera. Each plane contains an image line that passes each end of the claimed line
/// at a distance of the claim's bound, on one side of the end or the other.
fn sight_planes(
    ends_px: [[f64; 2]; 2],
    bound_px: f64,
    scene: &Scene,
    drawn: &Drawn,
    truth: &Truth,
) -> Option<[Vector3<f64>; 4]> {
    let (camera, mount) = (scene.robot.forward_camera.as_ref()?, drawn.devices.forward_camera.as_ref()?);
    let lens = Lens::of(camera, mount);
    let camera_in_world = world_from_camera(truth, mount).rotation;
    let [[u0, v0], [u1, v1]] = ends_px;
    let length_px = (u1 - u0).hypot(v1 - v0);
    let across_px = [-(v1 - v0) / length_px * bound_px, (u1 - u0) / length_px * bound_px];
    let ray = |[u, v]: [f64; 2], side: f64| {
        let [x, y] = lens.ray([u + side * across_px[0], v + side * across_px[1]])?;
        Some(camera_in_world * Vector3::new(x, y, 1.0))
    };
    let plane = |first: f64, last: f64| Some(ray(ends_px[0], first)?.cross(&ray(ends_px[1], last)?));
    Some([plane(-1.0, -1.0)?, plane(-1.0, 1.0)?, plane(1.0, -1.0)?, plane(1.0, 1.0)?])
}

/// Whether a line in space that is seen within the bound of both claimed ends may have one of the given directions, or a direction between two of
/// them. `corners` holds the normals of the planes of sight for the four extreme image lines. Plane normals are bilinear in the image line's offsets
/// from the two ends, and their scalar products with a direction change steadily from one direction to another, so that some normal is at right
/// angles to the line exactly when the products are not all of one sign.
fn may_hold(corners: &[Vector3<f64>; 4], directions: &[Vector3<f64>]) -> bool {
    let mut sides = directions.iter().flat_map(|direction| corners.map(|normal| normal.dot(direction) > 0.0));
    let first = sides.next();
    sides.any(|side| Some(side) != first)
}

/// Whether the claimed landmark truly lies in the claimed box, which is given in the frame of the robot's true pose.
fn landmark_in_box(landmark: LandmarkId, in_robot_m: &[Interval; 2], scene: &Scene, truth: &Truth) -> bool {
    let Some(landmark) = scene.landmarks.get(landmark.0 as usize) else { return false };
    let (x_m, y_m) = (landmark.x_m - truth.pose.x_m, landmark.y_m - truth.pose.y_m);
    let (sin, cos) = truth.pose.heading_rad.sin_cos();
    in_robot_m[0].contains(cos * x_m + sin * y_m) && in_robot_m[1].contains(cos * y_m - sin * x_m)
}

/// Whether a beam of the scanner, from where the scanner truly is, may have ended at the front of a mapped wall: between the two distances it comes
/// within `placement_m` of one, seen from above, whose true front may face the scanner; `None` where there is no scanner.
fn ends_at_a_wall(
    bearing_rad: f64,
    distances_m: [f64; 2],
    placement_m: f64,
    scene: &Scene,
    drawn: &Drawn,
    truth: &Truth,
) -> Option<bool> {
    let (keys, mount) = (scene.robot.scanner.as_ref()?, drawn.devices.scanner.as_ref()?);
    let (sin, cos) = bearing_rad.sin_cos();
    let world_from_scanner = truth.world_from_body() * mount.body_from_scanner(keys);
    let at = |distance_m: f64| (world_from_scanner * Point3::new(distance_m * cos, distance_m * sin, 0.0)).xy();
    let (eye, ends) = (at(0.0), distances_m.map(at));
    let is_it = |wall: Wall| {
        let [from, to] = wall.ends_m.map(Point2::from);
        let way = to - from;
        // Both ends of the straight true wall are within the placement, so that beyond an end its line departs from the mapped one by more.
        let share = (eye - from).dot(&way) / way.norm_squared();
        let departs_m = placement_m * (1.0 + 2.0 * (share - 1.0).max(-share).max(0.0));
        let before_m = way.perp(&(eye - from)) / way.norm();
        before_m >= -departs_m && apart_m(ends, [from, to]) <= placement_m
    };
    Some(scene.mapped_walls().into_iter().any(is_it))
}

/// Distance between two line segments, each from one point to another.
fn apart_m(one: [Point2<f64>; 2], other: [Point2<f64>; 2]) -> f64 {
    let side = |[from, to]: [Point2<f64>; 2], point: Point2<f64>| (to - from).perp(&(point - from));
    let are_beside = |line, [a, b]: [Point2<f64>; 2]| side(line, a) * side(line, b) >= 0.0;
    if !are_beside(one, other) && !are_beside(other, one) {
        return 0.0;
    }
    let to_segment_m = |point: Point2<f64>, [from, to]: [Point2<f64>; 2]| {
        let way = to - from;
        let length_2 = way.norm_squared();
        let share = if length_2 > 0.0 { ((point - from).dot(&way) / length_2).clamp(0.0, 1.0) } else { 0.0 };
        (from + way * share - point).norm()
    };
    let of_one = one.map(|point| to_segment_m(point, other));
    let of_other = other.map(|point| to_segment_m(point, one));
    of_one.into_iter().chain(of_other).fold(f64::INFINITY, f64::min)
}

/// How far the point on the floor that a pixel of the floor camera sees moves for one pixel to the right, and for one pixel down.
fn slopes(look: &dyn Fn(f64, f64) -> Option<Point2<f64>>) -> Option<[[f64; 2]; 2]> {
    let between = |from: Point2<f64>, to: Point2<f64>| (to - from).into();
    Some([between(look(-0.5, 0.0)?, look(0.5, 0.0)?), between(look(0.0, -0.5)?, look(0.0, 0.5)?)])
}

/// Point on the floor that a pixel of the floor camera sees when its row is exposed; `None` if the pixel's ray does not meet the floor.
fn on_floor([u_px, v_px]: [f64; 2], lens: &Lens, truth: &Truth, mount: &DrawnCamera) -> Option<Point2<f64>> {
    let [x, y] = lens.ray([u_px, v_px])?;
    let world_from_camera = world_from_camera(&truth.moved_on(lens.after_stamp_s(v_px)), mount);
    let direction = world_from_camera * Vector3::new(x, y, 1.0);
    let origin = world_from_camera * Point3::origin();
    let place = origin - direction * (origin.z / direction.z);
    (direction.z < 0.0).then(|| place.xy())
}

#[cfg(test)]
mod tests {
    use localizer::map::{Anchor, SpacePoint};

    use super::*;

    #[test]
    fn of_claims_about_things_those_about_the_most_claimed_ones_are_counted() {
        let anchor = Anchor { from_m: [0.0; 3], axis: 0, is_positive: true };
        let on = |thing: Option<u32>| Claim::SpacePoint {
            landmark: LandmarkId(1),
            point: SpacePoint { anchor, value: [Interval::ZERO; 3] },
            at_px: [0.0; 2],
            half_width_px: [0.5; 2],
            view: None,
            thing,
        };
        let claims = [Some(7), None, Some(2), Some(7), Some(4), Some(2), Some(7), None].map(on);
        assert_eq!([0, 1, 2, 3, 4].map(|n| of_most_things(claims.iter(), n)), [0, 3, 5, 6, 6]);
    }
}

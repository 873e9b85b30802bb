//! What the joints of an image relate: the pose, the constants of the camera, the lean of the body, and where each joint truly lies.
//!
//! A line of the image is taken at two points, near its ends. Every line that fits crosses the normal there within an interval, so that the joint passes
//! the floor point that the camera sees there, and the floor point's coordinate along the normal of the joint's family is that of the joint:
//! E·i + phase + d, with d between the distances by which the joint's two ends are off their nominal places.

use std::sync::{Arc, OnceLock};

use interval::Interval;

use crate::{
    PoseBox,
    bounds::{self, Assumption},
    graph::{Domain, Relations, Row, SeenPlace, Stray, Variable},
    vision::line_fit::LineSet,
};

use super::{
    Geometry,
    floor_point::{body_radius, floor_place},
    joint::Joint,
};

/// The joints of an image as relations. Few images become key frames, so that what the lines tell is computed only when one does.
pub(super) struct Joints {
    geometry: Arc<Geometry>,
    lines: Vec<Line>,
    /// The lines of which the pose tells which joint they are: set when the image becomes a key frame.
    named: OnceLock<Vec<NamedJoint>>,
}

/// A fitted line of the image with the least and the greatest coordinate of its points along itself, in pixels.
struct Line {
    joint: Joint,
    set: LineSet,
    along_px: [f64; 2],
}

/// A joint that the camera sees at two of its points.
struct NamedJoint {
    /// The axis of the tile grid that is the joint's normal.
    axis: usize,
    /// The joint's number along that axis.
    number: i64,
    ends: [SeenPlace; 2],
}

impl Joints {
    pub(super) fn new(geometry: &Arc<Geometry>) -> Joints {
        Joints { geometry: geometry.clone(), lines: Vec::new(), named: OnceLock::new() }
    }

    /// Adds a fitted line with its points, `[u, v, bound]` in the pinhole's picture.
    pub(super) fn add(&mut self, joint: &Joint, set: LineSet, points_px: &[[f64; 3]]) {
        let along_px = points_px.iter().map(|&[u, v, _]| set.along_px([u, v]));
        let (first, last) =
            along_px.fold((f64::INFINITY, f64::NEG_INFINITY), |(least, most), at| (least.min(at), most.max(at)));
        self.lines.push(Line { joint: joint.clone(), set, along_px: [first, last] });
    }

    /// The lines of which a box of poses tells which joint they are.
    fn name(&self, pose: &PoseBox) -> Vec<NamedJoint> {
        let (geometry, frame) = (&*self.geometry, 0);
        let stray = Stray::by_reach(geometry.camera.stamp_error_s, &geometry.robot.reach);
        let mut domain = Domain::of_constants(&geometry.robot);
        domain.put_pose(frame, pose);
        let at_stamp = domain.clone();
        domain.displace(&at_stamp, [frame; 2], &stray);
        let tilt = Interval::centred(0.0, body_radius(geometry));
        (0..2).for_each(|axis| domain.put(Variable::BodyTilt(frame, axis), tilt));
        let name = |line: &Line| {
            let (first, last) = line.joint.families(pose[2], geometry);
            let axis = (first == last).then(|| first.rem_euclid(2) as usize)?;
            let ends = line.along_px.map(|at_px| floor_place(&line.set, at_px, geometry));
            let [Some(first_end), Some(last_end)] = ends else { return None };
            let number = |end: &SeenPlace| {
                let along_m = end.at(frame, &domain).along(geometry.normal(axis));
                let grid = &geometry.grid;
                let number = (along_m.inflate(grid.laying_m) - grid.phase_m[axis]) / grid.edge_m[axis];
                let (least, most) = (number.lo().ceil(), number.hi().floor());
                (least == most && least.abs() < MOST_NUMBER).then_some(least as i64)
            };
            let [first, last] = [number(&first_end)?, number(&last_end)?];
            (first == last).then_some(NamedJoint { axis, number: first, ends: [first_end, last_end] })
        };
        self.lines.iter().filter_map(name).collect()
    }
}

/// Greatest number of a joint that is counted.
const MOST_NUMBER: f64 = 1e9;

impl Relations for Joints {
    fn quantities(&self, frame: usize, pose: &PoseBox) -> Vec<(Variable, Interval)> {
        let named = self.named.get_or_init(|| self.name(pose));
        let tilt = Interval::centred(0.0, body_radius(&self.geometry));
        let mut quantities: Vec<(Variable, Interval)> =
            (0..2).map(|axis| (Variable::BodyTilt(frame, axis), tilt)).collect();
        for &NamedJoint { axis, number, .. } in named {
            let off = Interval::centred(0.0, self.geometry.end_off_m(axis));
            quantities.extend([0, 1].map(|end| (Variable::JointEnd(axis, number, end), off)));
        }
        quantities
    }

    fn discs(&self, frame: usize) -> Vec<crate::graph::Disc> {
        vec![([0, 1].map(|axis| Variable::BodyTilt(frame, axis)), body_radius(&self.geometry))]
    }

    fn is_of_the_map(&self) -> bool {
        true
    }

    fn stamp_error_s(&self) -> f64 {
        self.geometry.camera.stamp_error_s
    }

    fn shift_m(&self, stray: &Stray) -> f64 {
        stray.metres
    }

    fn shift_parts(&self, stray: &Stray) -> Vec<(Assumption, f64)> {
        [bounds::FLOOR_CAMERA_STAMP, bounds::REACH_SPEED].map(|bound| (bound, stray.metres)).to_vec()
    }

    fn stamp_bound(&self) -> Assumption {
        bounds::FLOOR_CAMERA_STAMP
    }

    fn rows(&self, frame: usize, domain: &Domain) -> Vec<Row> {
        let grid = &self.geometry.grid;
        let mut rows = Vec::new();
        for &NamedJoint { axis, number, ref ends } in self.named.get().into_iter().flatten() {
            let normal = self.geometry.normal(axis);
            let place_m = Interval::point(grid.edge_m[axis]) * (number as f64) + grid.phase_m[axis];
            for end in ends {
                let seen = end.at(frame, domain);
                // Share of the way from the joint's first end to its last one at which the point lies.
                let share = self.geometry.share_of_joint(axis, seen.along(self.geometry.normal(1 - axis)));
                let ends = [0, 1].map(|end| Variable::JointEnd(axis, number, end));
                let shares = [1.0 - share, share];
                let off_m = shares[0] * domain.reference(ends[0]) + shares[1] * domain.reference(ends[1]);
                rows.push(seen.row(normal, place_m + off_m, &[(ends[0], shares[0]), (ends[1], shares[1])]));
            }
        }
        rows
    }
}

impl Geometry {
    /// Unit vector of the world along an axis of the tile grid.
    fn normal(&self, axis: usize) -> [Interval; 2] {
        let angle = Interval::point(self.grid.rotation_rad);
        let (cos, sin) = (angle.cos(), angle.sin());
        if axis == 0 { [cos, sin] } else { [-sin, cos] }
    }

    /// Least and greatest coordinate of the room along an axis of the tile grid.
    fn extent_m(&self, axis: usize) -> Interval {
        let normal = self.normal(axis);
        normal[0] * self.room_m[0] + normal[1] * self.room_m[1]
    }

    /// Greatest distance of a joint's end from its nominal place. The ends are where the joint meets the room's extent along the grid. Of a grid that is
    /// turned, joints end before, and what they are off there goes on at the greatest angle between a joint and its nominal direction.
    fn end_off_m(&self, axis: usize) -> f64 {
        let grid = &self.grid;
        let beyond_m = if grid.rotation_rad == 0.0 { 0.0 } else { self.extent_m(1 - axis).width() };
        (Interval::point(grid.laying_angle_rad).tan() * beyond_m + grid.laying_m).hi()
    }

    /// Share of the way along a joint whose normal is an axis of the grid, for a coordinate along the other axis.
    fn share_of_joint(&self, axis: usize, along_m: Interval) -> Interval {
        let extent = self.extent_m(1 - axis);
        (along_m - extent.lo()) / (Interval::point(extent.hi()) - extent.lo())
    }
}

#[cfg(test)]
#[allow(clippy::expect_used)]
mod tests {
    use std::{collections::BTreeMap, f64::consts::PI};

    use nalgebra::{Rotation3, Vector3};

    use super::{
        super::{
            Chain,
            trial::{HEIGHT_M, known_robot, method},
        },
        *,
    };
    use crate::{
        graph::{
            Constant,
            trial::{Draw, rounds, tilt},
        },
        vision::{FloorLine, line_fit},
    };

    #[test]
    fn the_truth_satisfies_the_rows_of_joints_at_the_corners_of_all_bounds() {
        let mut draw = Draw::new(20_261_130);
        let (mut nearest, mut n_rows): (f64, usize) = (0.0, 0);
        for round in 0..rounds(20_000) {
            let mut robot = known_robot(draw.or_zero(1.0) + 1e-6, [0.0; 5], 0.0, 0.0);
            robot.body.tilt_rad = draw.or_zero(0.006);
            robot.body.heave_m = draw.or_zero(0.0008);
            if let Some(camera) = &mut robot.floor_camera {
                camera.tilt_rad = draw.or_zero(0.005);
                camera.yaw_rad = Interval::centred(0.1, draw.or_zero(0.005));
            }
            let mut geometry = (*method(&robot, Chain::Direct).geometry).clone();
            geometry.grid.laying_m = draw.or_zero(0.003);
            geometry.grid.rotation_rad = draw.or_zero(0.4);
            geometry.grid.laying_angle_rad = geometry.grid.laying_m / 10.0;
            let camera = geometry.camera.clone();

            // The truth.
            let mut truth = BTreeMap::new();
            let mut set = |variable, value: f64| {
                truth.insert(variable, value);
                value
            };
            let constant = Variable::Constant;
            let scale = set(constant(Constant::FloorScale), draw.within(camera.pixels_per_m));
            let yaw = set(constant(Constant::FloorYaw), draw.within(camera.yaw_rad));
            let mount = [0, 1].map(|k| set(constant(Constant::FloorPosition(k)), draw.within(camera.position_m[k])));
            let (mount_tilt, cayley) = tilt(&mut draw, camera.tilt_rad);
            (0..2).for_each(|k| {
                set(constant(Constant::FloorTilt(k)), cayley[k]);
            });
            let (body, cayley) = tilt(&mut draw, robot.body.tilt_rad);
            let (sin, cos) = (yaw - camera.yaw_rad.mid()).sin_cos();
            set(Variable::BodyTilt(4, 0), cos * cayley[0] + sin * cayley[1]);
            set(Variable::BodyTilt(4, 1), cos * cayley[1] - sin * cayley[0]);
            let turned = Rotation3::from_axis_angle(&Vector3::z_axis(), draw.between(-PI, PI)) * body;
            let forward = turned * Vector3::x();
            set(Variable::Pose(4, 2), forward.y.atan2(forward.x));
            let at = [0, 1].map(|k| set(Variable::Pose(4, k), draw.between(-3.0, 3.0)));
            let heave = draw.within(Interval::centred(0.0, robot.body.heave_m));
            let eye = Vector3::new(at[0], at[1], heave) + turned * Vector3::new(mount[0], mount[1], HEIGHT_M);
            let world_from_camera = turned * Rotation3::from_axis_angle(&Vector3::z_axis(), yaw) * mount_tilt;

            // A joint near the camera, from one end of the room to the other, each end off its place.
            let (axis, (sin, cos)) = (usize::from(draw.unit() < 0.5), geometry.grid.rotation_rad.sin_cos());
            let [normal, along] = if axis == 0 { [[cos, sin], [-sin, cos]] } else { [[-sin, cos], [cos, sin]] };
            let dot = |a: [f64; 2], b: [f64; 2]| a[0] * b[0] + a[1] * b[1];
            let number = (dot(normal, [eye.x, eye.y]) / 0.3).round();
            let extent = geometry.extent_m(1 - axis);
            let ends = [0, 1].map(|end| {
                let off = draw.within(Interval::centred(0.0, geometry.grid.laying_m));
                set(Variable::JointEnd(axis, number as i64, end), off)
            });
            let middle = dot(along, [eye.x, eye.y]);
            // The points of the line in the picture, each with an error at its bound.
            let bound_px = draw.or_zero(0.4) + 1e-9;
            let shift_px = draw.within(Interval::centred(0.0, bound_px));
            let slope_px = draw.within(Interval::centred(0.0, bound_px - shift_px.abs()));
            let points: Vec<[f64; 3]> = (-4..=4)
                .map(|step| {
                    let share = f64::from(step) / 4.0;
                    let t = middle + 0.12 * share;
                    let s = (t - extent.lo()) / extent.width();
                    let n = 0.3 * number + ends[0] * (1.0 - s) + ends[1] * s;
                    let on_floor = [0, 1].map(|k| normal[k] * n + along[k] * t);
                    let ray = world_from_camera.inverse() * (Vector3::new(on_floor[0], on_floor[1], 0.0) - eye);
                    let [forward, left] = [ray.x / -ray.z, ray.y / -ray.z].map(|slope| slope * scale * HEIGHT_M);
                    let [u, v] = [319.5 - left, 239.5 - forward];
                    // Across the line in the picture, which runs along or across it to some degrees.
                    let across = shift_px + slope_px * share;
                    let turn = (world_from_camera.inverse() * Vector3::new(normal[0], normal[1], 0.0)).normalize();
                    [u - across * turn.y * 0.99, v - across * turn.x * 0.99, bound_px]
                })
                .collect();
            let line = FloorLine { points_px: points.clone(), share_wrong: 0.0, family: 0 };
            let Some(set) = line_fit::enclose(&points, 0.0) else { continue };
            let Some(joint) = Joint::new(set.clone(), &line, 0.0, &geometry) else { continue };
            let mut joints = Joints::new(&Arc::new(geometry.clone()));
            joints.add(&joint, set, &points);

            let mut domain = Domain::of_constants(&robot);
            for (axis, half) in [(0, 0.01), (1, 0.02), (2, 0.02)] {
                let variable = Variable::Pose(4, axis);
                let around = truth[&variable] + draw.within(Interval::centred(0.0, half));
                domain.put(variable, Interval::centred(around, half + 1e-12));
            }
            let pose = PoseBox::new([0, 1, 2].map(|axis| domain.value(Variable::Pose(4, axis))));
            joints.quantities(4, &pose).into_iter().for_each(|(variable, value)| domain.put(variable, value));
            for (variable, value) in domain.iter() {
                let is_of_wheels = matches!(variable, Variable::Constant(Constant::MetresPerTick(_) | Constant::Track));
                let true_value = if is_of_wheels { value.mid() } else { truth[&variable] };
                assert!(value.inflate(1e-12).contains(true_value), "{variable:?}: {true_value} {value}");
            }
            for row in joints.rows(4, &domain) {
                let value = row.value_at(|variable| truth[&variable] - domain.reference(variable));
                assert!(row.sides.inflate(1e-9).contains(value), "round {round}: {value} {}", row.sides);
                nearest = nearest.max((value - row.sides.mid()).abs() / row.sides.radius());
                n_rows += 1;
            }
        }
        assert!(n_rows > 8_000 && nearest > 0.95, "{n_rows} rows, {nearest}");
    }

    #[test]
    fn a_short_joint_of_a_turned_grid_is_as_far_off_at_the_rooms_extent_as_its_angle_takes_it() {
        // A room of 4 m by 4 m, with a grid at 45° from a corner. A joint that is 0.25 m from the corner ends at walls, 0.25 m on either side of the
        // diagonal. There it is 3 mm off its place, at one end to one side, at the other to the other: it lies at 12 mrad to its nominal direction.
        // The extent of the room along it goes to 2.83 m on either side, where that makes 33.9 mm.
        let mut geometry = (*method(&known_robot(1.0, [0.0; 5], 0.0, 0.0), Chain::Direct).geometry).clone();
        geometry.room_m = [Interval::new(0.0, 4.0); 2];
        geometry.grid.rotation_rad = PI / 4.0;
        geometry.grid.laying_m = 0.003;
        geometry.grid.laying_angle_rad = 0.012;
        let extent = geometry.extent_m(1);
        assert!((extent.hi() - 8.0_f64.sqrt()).abs() < 1e-9 && (extent.lo() + extent.hi()).abs() < 1e-9, "{extent}");
        let off_m = 0.003 / 0.25 * extent.hi();
        assert!(geometry.end_off_m(0) >= off_m && geometry.end_off_m(1) >= off_m, "{off_m}");
        // Of a grid along the walls, joints end at the extent.
        geometry.grid.rotation_rad = 0.0;
        assert!((geometry.end_off_m(0) - 0.003).abs() < 1e-12);
    }
}

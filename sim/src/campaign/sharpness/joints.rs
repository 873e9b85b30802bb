//! Images of a tiled floor: what the method claims of the joints that it saw, and how joints may lie.
//!
//! Each claimed point is checked by a point of the joint whose image is near enough.

use std::collections::{BTreeMap, BTreeSet};

use interval::Interval;
use localizer::{Claim, Map, bounds, reading::Camera};

use crate::{run::RunRecord, scene::Scene};

use super::{
    eye::{Eye, Sight},
    floor::{Course, Floor, Joint},
    history::{History, Quantity},
    kind::{Broken, Declared, Kind, Linearised, demand, within},
    outline::outline,
};

/// What is broken when more lines of an image are false than the scene's `robot.floor_camera.q_items` allows.
pub(super) const FALSE_LINES: &str = "floor_tiles.q_items";

/// One claimed line of an image.
pub(super) struct Line {
    /// The joint that was truly seen.
    pub(super) joint: Joint,
    /// Claimed points, each with the bound on its distance from the joint's image.
    pub(super) points_px: Vec<[f64; 3]>,
    /// Number of points that have to be within their bounds.
    pub(super) n_needed: usize,
}

/// What was claimed of one image.
pub(super) struct Look {
    pub(super) stamp: usize,
    pub(super) measured_s: f64,
    /// The claimed lines that are joints.
    pub(super) lines: Vec<Line>,
    /// Number of the lines that may be false.
    pub(super) n_false: usize,
}

/// All images of the floor that have arrived by an instant.
pub(super) struct Joints {
    pub(super) eye: Eye,
    pub(super) floor: Floor,
    pub(super) looks: Vec<Look>,
}

/// Where the image of a joint is nearest to a pixel.
#[derive(Clone, Copy)]
struct Nearest {
    along_m: f64,
    /// Direction of the image at right angles to the joint.
    normal: [f64; 2],
    /// Distance of the pixel from the joint's image along that direction.
    off_px: f64,
}

impl Nearest {
    /// For each claimed point the nearest point of the joint, by Newton's method along the joint's image.
    fn of_each(points_px: &[[f64; 3]], course: &Course<f64>, sight: &Sight<f64>) -> Vec<Nearest> {
        // The next point is sought from where the last one was found, the first one from below the camera.
        let mut from_m = course.along_m(sight.centre_m);
        let near = points_px.iter().map(|&[u, v, _]| {
            let nearest = Nearest::to([u, v], course, sight, from_m);
            from_m = nearest.along_m;
            nearest
        });
        near.collect()
    }

    fn to([u, v]: [f64; 2], course: &Course<f64>, sight: &Sight<f64>, from_m: f64) -> Nearest {
        /// Length along the joint over which the direction of its image is taken.
        const ALONG_M: f64 = 1e-3;
        /// Number of steps: the image of a joint is nearly straight and evenly stretched, so that three reach rounding.
        const N_STEPS: usize = 4;
        let mut along_m = from_m;
        let mut nearest = Nearest { along_m, normal: [0.0; 2], off_px: f64::INFINITY };
        for _ in 0..N_STEPS {
            let [[u0, v0], [u1, v1]] =
                [along_m, along_m + ALONG_M].map(|along_m| sight.pixel(course.point_m(along_m)).0);
            let (du, dv) = (u1 - u0, v1 - v0);
            let length_px = du.hypot(dv);
            let normal = [-dv / length_px, du / length_px];
            nearest = Nearest { along_m, normal, off_px: normal[0] * (u - u0) + normal[1] * (v - v0) };
            let along_px = ((u - u0) * du + (v - v0) * dv) / length_px;
            if along_px.abs() < 1e-3 {
                break;
            }
            along_m += along_px / length_px * ALONG_M;
        }
        nearest
    }
}

impl Joints {
    /// What the method claimed of the images of the floor that have arrived by an instant. A line is taken for the joint that it truly is.
    pub(super) fn of(
        scene: &Scene,
        record: &RunRecord,
        map: &Map,
        eye: Eye,
        history: &History,
        time_s: f64,
    ) -> Option<Joints> {
        let (grid, laid) = (map.tiles.as_ref()?, record.drawn.place.tiles.as_ref()?);
        let mut joints = Joints { eye, floor: Floor::of(map, grid), looks: Vec::new() };
        let images = record.images.iter().filter(|image| image.camera == Some(Camera::Floor));
        for image in images.filter(|image| image.arrived_s <= time_s) {
            let Some(stamp) = history.stamp_at(image.truth.time_s) else { continue };
            let mut look = Look { stamp, measured_s: image.measured_s, lines: Vec::new(), n_false: image.quota.items };
            for claim in &image.claims {
                let Claim::FloorJoint { points_px, share_wrong } = claim else { continue };
                let n_needed = ((1.0 - share_wrong) * points_px.len() as f64).ceil() as usize;
                match crate::judge::joint_claimed(points_px, *share_wrong, scene, &record.drawn, &image.truth) {
                    Some(joint) => {
                        joints.floor.add(laid, joint);
                        look.lines.push(Line { joint, points_px: points_px.clone(), n_needed });
                    }
                    // A false line bounds nothing, and uses up a part of the quota.
                    None => look.n_false = look.n_false.saturating_sub(1),
                }
            }
            if !look.lines.is_empty() {
                joints.looks.push(look);
            }
        }
        (!joints.looks.is_empty()).then_some(joints)
    }

    /// Whether a claimed line is true: as many points as needed are surely within their bounds of the joint's image.
    fn holds(
        &self,
        history: &History,
        sights: &(Sight<f64>, Sight<Interval>),
        line: &Line,
    ) -> Result<(), [Interval; 2]> {
        let mut n_left = line.points_px.len() - line.n_needed.min(line.points_px.len());
        let course: Course<f64> = self.floor.course(history, line.joint);
        let exact: Course<Interval> = self.floor.course(history, line.joint);
        let near = Nearest::of_each(&line.points_px, &course, &sights.0);
        for (&[u, v, bound_px], nearest) in line.points_px.iter().zip(near) {
            // Any point of the joint shows that the claimed point is true if its image is near enough.
            let point_m = exact.point_m(nearest.along_m);
            let is_in_room = (0..2).all(|axis| point_m[axis].is_subset_of(self.floor.room_m[axis]));
            let ([at_u, at_v], depth_m) = sights.1.pixel(point_m);
            let off_px = (at_u - Interval::point(u)).hypot(at_v - Interval::point(v));
            let allowed = Interval::new(0.0, bound_px);
            let is_near = depth_m.lo() > 0.0 && !off_px.is_empty() && off_px.is_subset_of(allowed);
            if !(is_near && is_in_room) {
                n_left = n_left.checked_sub(1).ok_or([off_px, allowed])?;
            }
        }
        Ok(())
    }

    fn seen(&self) -> BTreeSet<Joint> {
        self.looks.iter().flat_map(|look| look.lines.iter().map(|line| line.joint)).collect()
    }
}

impl Kind for Joints {
    fn declared(&self, history: &History) -> Vec<Declared> {
        let mut all = self.eye.declared(history, self.looks.iter().map(|look| (look.stamp, look.measured_s)));
        let grid = &self.floor.grid;
        let [off, bend] = [grid.laying_m, grid.straightness_m].map(|most_m| Interval::new(-most_m, most_m));
        for (axis, index) in self.seen() {
            for end in 0..2 {
                let quantity = Quantity::JointEnd(axis, index, end);
                all.push(Declared { quantity, interval: off, bound: bounds::FLOOR_TILES_LAYING });
            }
            for crossing in self.floor.crossings_m.get(&(axis, index)).into_iter().flat_map(BTreeMap::keys) {
                let quantity = Quantity::JointBend(axis, index, *crossing);
                all.push(Declared { quantity, interval: bend, bound: bounds::FLOOR_TILES_STRAIGHTNESS });
            }
        }
        all
    }

    fn check(&self, history: &History, slack: f64) -> Result<(), Broken> {
        self.eye.check_tilt(history, slack)?;
        let most_rad = within(Interval::point(self.floor.grid.laying_angle_rad));
        for (axis, index) in self.seen() {
            let [first_m, last_m] =
                [0, 1].map(|end| Interval::point(history.value(Quantity::JointEnd(axis, index, end))));
            let [from_m, to_m] = self.floor.extents_m[1 - axis].map(Interval::point);
            let angle_rad = ((last_m - first_m) / (to_m - from_m)).atan();
            demand(slack, bounds::FLOOR_TILES_LAYING_ANGLE, history.stamps_s[0], angle_rad, most_rad)?;
        }
        for look in &self.looks {
            let sights = (self.eye.sight(history, look.stamp), self.eye.sight(history, look.stamp));
            let mut n_left = look.n_false;
            for line in &look.lines {
                if let Err([value, allowed]) = self.holds(history, &sights, line) {
                    let time_s = history.stamps_s[look.stamp];
                    let broken = Broken { bound: FALSE_LINES, time_s, value, allowed };
                    n_left = n_left.checked_sub(1).ok_or(broken)?;
                }
            }
        }
        Ok(())
    }

    fn add_rows(&self, near: &mut Linearised<'_>) {
        let history = near.history;
        self.eye.add_tilt_rows(near);
        for (axis, index) in self.seen() {
            let [first, last] = [0, 1].map(|end| Quantity::JointEnd(axis, index, end));
            let [from_m, to_m] = self.floor.extents_m[1 - axis];
            let most_m = self.floor.grid.laying_angle_rad.tan() * (to_m - from_m);
            let terms = vec![near.quantity(last, 1.0), near.quantity(first, -1.0)];
            near.add(terms, history.value(last) - history.value(first), Interval::new(-most_m, most_m));
        }
        for look in &self.looks {
            let slopes = self.eye.slopes(history, look.stamp);
            for line in &look.lines {
                let course: Course<f64> = self.floor.course(history, line.joint);
                let nearest = Nearest::of_each(&line.points_px, &course, &slopes.sight);
                let bounds_px = line.points_px.iter().map(|point| point[2]);
                let offs: Vec<[f64; 3]> =
                    nearest.iter().zip(bounds_px).map(|(at, bound_px)| [at.along_m, at.off_px, bound_px]).collect();
                for at in outline(&offs, line.n_needed) {
                    let Nearest { along_m, normal, off_px } = nearest[at];
                    let point_m = course.point_m(along_m);
                    // What the pixel of the joint's point moves along the normal, the claimed point's distance from it falls.
                    let mut terms = slopes.terms(near, point_m, normal);
                    let [nx, ny] = self.floor.normal(line.joint.0);
                    let [by_x, by_y, _] = slopes.by_point(point_m, normal);
                    for (quantity, share) in self.floor.shares(line.joint, along_m) {
                        terms.push(near.quantity(quantity, share * (nx * by_x + ny * by_y)));
                    }
                    let bound_px = line.points_px[at][2];
                    near.add(terms, -off_px, Interval::new(-bound_px, bound_px));
                }
            }
        }
    }
}

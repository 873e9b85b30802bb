//! How each kind of measurement changes the filter's belief.

use localizer::map::TileGrid;
use nalgebra::{DMatrix, DVector, Matrix2, Matrix3};

use crate::{
    scene::FilterNoise,
    subject::{
        cues::{Edge, FloorPlan, Joint, Landmark, Line, Mounted, Seen, heading_of, turned},
        half_turn,
    },
};

use super::{
    belief::{Belief, Row, Thing},
    layout::Layout,
};

/// What is known beforehand that measurements are compared with.
pub(crate) struct Known<'a> {
    pub(crate) layout: &'a Layout,
    pub(crate) tiles: Option<&'a TileGrid>,
    pub(crate) wall_directions_rad: &'a [f64],
    pub(crate) floor_plan: Option<&'a FloorPlan>,
    pub(crate) tuning: &'a FilterNoise,
}

/// Standard deviations of a predicted place of a joint, or wall, that half the distance to the next one must hold for the nearest one to be taken for
/// the one that is seen: with fewer, the filter may follow the wrong tile for ever.
const UNAMBIGUOUS_SIGMAS: f64 = 3.0;

/// The pose at which a device would be seen to be that has its mount's errors, with the derivatives of its x, y and heading.
struct Apparent {
    pose: [f64; 3],
    rows: [Row; 3],
}

impl Apparent {
    fn of(belief: &Belief, layout: &Layout, mounted: Mounted) -> Apparent {
        let [x_m, y_m, heading_rad] = [0, 1, 2].map(|axis| belief.mean[axis]);
        let Some(mount) = layout.mount(mounted) else {
            let rows = [vec![(0, 1.0)], vec![(1, 1.0)], vec![(2, 1.0)]];
            return Apparent { pose: [x_m, y_m, heading_rad], rows };
        };
        let off = [belief.mean[mount], belief.mean[mount + 1]];
        let [dx, dy] = turned(off, heading_rad);
        let (sin, cos) = heading_rad.sin_cos();
        Apparent {
            pose: [x_m + dx, y_m + dy, heading_rad + belief.mean[mount + 2]],
            rows: [
                vec![(0, 1.0), (2, -dy), (mount, cos), (mount + 1, -sin)],
                vec![(1, 1.0), (2, dx), (mount, sin), (mount + 1, cos)],
                vec![(2, 1.0), (mount + 2, 1.0)],
            ],
        }
    }

    /// The pose from which the device would see the walls where the map has them, on a floor plan that lies askew.
    fn on(self, plan: &FloorPlan, belief: &Belief, layout: &Layout) -> Apparent {
        let Some(at) = layout.floor_plan else { return self };
        let [x_m, y_m, _] = self.pose;
        let turn_rad = belief.mean[at + 2];
        let [dx, dy] = plan.about_middle([x_m, y_m]);
        let [by_x, by_y, by_turn] = self.rows;
        let with = |row: &Row, other: &Row, by_other: f64, own: [(usize, f64); 2]| {
            let turned = other.iter().map(|(place, slope)| (*place, slope * by_other));
            row.iter().copied().chain(turned).chain(own).collect::<Row>()
        };
        Apparent {
            pose: plan.seen_from(self.pose, [0, 1, 2].map(|axis| belief.mean[at + axis])),
            rows: [
                with(&by_x, &by_y, turn_rad, [(at, -1.0), (at + 2, dy)]),
                with(&by_y, &by_x, -turn_rad, [(at + 1, -1.0), (at + 2, -dx)]),
                by_turn.into_iter().chain([(at + 2, -1.0)]).collect(),
            ],
        }
    }

    /// The place in the world of a point of the robot frame, with its derivatives by the state.
    fn place(&self, in_robot_m: [f64; 2]) -> ([f64; 2], [Row; 2]) {
        let [dx, dy] = turned(in_robot_m, self.pose[2]);
        let with = |axis: usize, by_turn: f64| {
            let turning = self.rows[2].iter().map(|(place, slope)| (*place, slope * by_turn));
            self.rows[axis].iter().copied().chain(turning).collect::<Row>()
        };
        ([self.pose[0] + dx, self.pose[1] + dy], [with(0, -dy), with(1, dx)])
    }
}

/// Updates the belief by a measurement.
pub(crate) fn measure(belief: &mut Belief, mounted: Mounted, seen: &Seen, known: &Known<'_>) {
    let scale = known.tuning.cues.powi(2);
    match seen {
        Seen::Pose { pose, covariance } => {
            let apparent = Apparent::of(belief, known.layout, mounted);
            let off = [0, 1, 2].map(|axis| pose[axis] - apparent.pose[axis]);
            let residual = DVector::from_column_slice(&[off[0], off[1], half_turn(off[2])]);
            let noise: Matrix3<f64> = covariance * scale;
            belief.update(&apparent.rows, &residual, &DMatrix::from_iterator(3, 3, noise.iter().copied()));
        }
        Seen::Joints(joints) => {
            for joint in joints {
                see_joint(belief, mounted, joint, known);
            }
        }
        Seen::Edges(edges) => see_edges(belief, mounted, edges, known),
        Seen::Lines(lines) => {
            for line in lines {
                see_line(belief, mounted, line, known);
            }
        }
        Seen::Landmarks(landmarks) => {
            for landmark in landmarks {
                see_landmark(belief, mounted, landmark, known);
            }
        }
        Seen::Position { in_robot_m, in_world_m, sigma_m } => {
            let (place, rows) = Apparent::of(belief, known.layout, mounted).place(*in_robot_m);
            let residual = DVector::from_column_slice(&[in_world_m[0] - place[0], in_world_m[1] - place[1]]);
            belief.update(&rows, &residual, &(DMatrix::identity(2, 2) * sigma_m.powi(2) * scale));
        }
    }
}

fn see_joint(belief: &mut Belief, mounted: Mounted, joint: &Joint, known: &Known<'_>) {
    let Some(grid) = known.tiles else { return };
    let scale = known.tuning.cues.powi(2);
    let apparent = Apparent::of(belief, known.layout, mounted);
    let agreement = joint.agreement(apparent.pose, grid);
    let along = agreement.along;
    let weighted = |axis: usize| apparent.rows[axis].iter().map(move |(place, slope)| (*place, slope * along[axis]));
    let row: Row = weighted(0).chain(weighted(1)).collect();
    let variance = belief.variance(&row);
    if UNAMBIGUOUS_SIGMAS * (variance + joint.sigma[1].powi(2) * scale).sqrt() > agreement.half_edge_m {
        return;
    }
    let residual = DVector::from_column_slice(&[agreement.turn_rad, agreement.off_m]);
    let noise = DVector::from_column_slice(&joint.sigma.map(|sigma| sigma.powi(2) * scale));
    belief.update(&[apparent.rows[2].clone(), row], &residual, &DMatrix::from_diagonal(&noise));
}

fn see_edges(belief: &mut Belief, mounted: Mounted, edges: &[Edge], known: &Known<'_>) {
    let apparent = Apparent::of(belief, known.layout, mounted);
    let row = &apparent.rows[2];
    let variance = belief.variance(row);
    let told = heading_of(edges, known.wall_directions_rad, apparent.pose[2], variance.max(0.0).sqrt());
    let Some((residual_rad, noise_rad2)) = told else { return };
    let noise = DMatrix::from_element(1, 1, noise_rad2 * known.tuning.cues.powi(2));
    belief.update(std::slice::from_ref(row), &DVector::from_element(1, residual_rad), &noise);
}

/// Compares a line of a scan with the nearest wall of the floor plan: its direction with the wall's, and its middle with the wall's place. The line is
/// left out where it may as well be another wall, or stands farther from the wall than the errors allow, as furniture does. A wall that is met for the
/// first time is added to the state, with nothing known of it but how far its ends may be displaced.
fn see_line(belief: &mut Belief, mounted: Mounted, line: &Line, known: &Known<'_>) {
    let Some(plan) = known.floor_plan else { return };
    let apparent = Apparent::of(belief, known.layout, mounted).on(plan, belief, known.layout);
    let Some(met) = plan.met(line, apparent.pose) else { return };
    let (_, rows) = apparent.place(line.middle_m);
    let weighted = |axis: usize| rows[axis].iter().map(move |(place, slope)| (*place, slope * met.normal[axis]));
    let mut across: Row = weighted(0).chain(weighted(1)).collect();
    let own_m2 = plan.placement_sigma_m.powi(2) + (line.sigma[1] * known.tuning.cues).powi(2);
    let most_m = UNAMBIGUOUS_SIGMAS * (belief.variance(&across) + own_m2).sqrt();
    if most_m > plan.half_way_m(line, apparent.pose, &met) || met.off_m.abs() > most_m {
        return;
    }
    let wall = belief.place_of(Thing::Wall(met.wall));
    let wall = wall.unwrap_or_else(|| belief.add_wall(met.wall, plan.placement_sigma_m));
    // A wall whose ends are in front of their places is nearer, and turned by their difference over its length.
    let [at_from, at_to] = met.shares;
    let ends_m = [belief.mean[wall], belief.mean[wall + 1]];
    let off_m = met.off_m + at_from * ends_m[0] + at_to * ends_m[1];
    let turn_rad = met.turn_rad + (ends_m[1] - ends_m[0]) / met.length_m;
    across.extend([(wall, -at_from), (wall + 1, -at_to)]);
    let mut turning = apparent.rows[2].clone();
    turning.extend([(wall, met.length_m.recip()), (wall + 1, -met.length_m.recip())]);
    let noise = DVector::from_column_slice(&line.sigma.map(|sigma| (sigma * known.tuning.cues).powi(2)));
    let residual = DVector::from_column_slice(&[turn_rad, off_m]);
    belief.update(&[turning, across], &residual, &DMatrix::from_diagonal(&noise));
}

fn see_landmark(belief: &mut Belief, mounted: Mounted, landmark: &Landmark, known: &Known<'_>) {
    let apparent = Apparent::of(belief, known.layout, mounted);
    let scale = known.layout.range_scale.map_or(0.0, |at| belief.mean[at]);
    let (place, mut rows) = apparent.place((landmark.in_robot_m - landmark.ray_m * scale).into());
    let (sin, cos) = apparent.pose[2].sin_cos();
    let turn = Matrix2::new(cos, -sin, sin, cos);
    if let Some(at) = known.layout.range_scale {
        let by_scale = turn * -landmark.ray_m;
        rows.iter_mut().zip(by_scale.iter()).for_each(|(row, slope)| row.push((at, *slope)));
    }
    let noise = turn * landmark.covariance * turn.transpose() * known.tuning.cues.powi(2);
    let Some(at) = belief.place_of(Thing::Landmark(landmark.code)) else {
        belief.add_landmark(landmark.code, place, &rows, &noise);
        return;
    };
    // The landmark is compared in the world: where it is believed to be, less where it is seen.
    let residual = DVector::from_column_slice(&[belief.mean[at] - place[0], belief.mean[at + 1] - place[1]]);
    for (axis, row) in rows.iter_mut().enumerate() {
        row.push((at + axis, -1.0));
    }
    belief.update(&rows, &residual, &DMatrix::from_iterator(2, 2, noise.iter().copied()));
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests;

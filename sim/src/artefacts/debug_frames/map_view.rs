//! The floor seen from above: room, floor joints as they were truly laid, route, driven trail, the localizer's boxes and the robot's true pose.

use image::Rgb;
use localizer::{Pose, PoseUnion};

use crate::{
    driver::Outcome,
    place::{
        building::GroundPlan,
        drawn::LaidTiles,
        navigation::{Cell, OccupancyGrid},
    },
    run::RunRecord,
    scene::{Scene, Tiles},
};

use super::{
    canvas::{Canvas, Panel},
    palette,
};

mod beacons;

pub(super) use beacons::learnt_by;

/// A part of the floor shown in a panel; the world's x axis points to the right, its y axis upwards.
pub(super) struct MapView {
    panel: Panel,
    centre_m: [f64; 2],
    pixels_per_m: f64,
}

impl MapView {
    /// A map view of all rooms, with a margin and with space for the scale bar below them.
    pub(super) fn rooms(panel: Panel, scene: &Scene) -> MapView {
        const MARGIN_PX: f64 = 14.0;
        const SCALE_PX: f64 = 34.0;
        let [low_m, high_m] = GroundPlan::of(scene).extents_m();
        let [width_m, depth_m] = [0, 1].map(|axis| high_m[axis] - low_m[axis]);
        let fit = |extent_px: f64, extent_m: f64| (extent_px - 2.0 * MARGIN_PX) / extent_m;
        let pixels_per_m = fit(panel.width_px, width_m).min(fit(panel.height_px - SCALE_PX, depth_m));
        let [middle_x_m, middle_y_m] = [0, 1].map(|axis| (low_m[axis] + high_m[axis]) / 2.0);
        MapView { panel, centre_m: [middle_x_m, middle_y_m - SCALE_PX / 2.0 / pixels_per_m], pixels_per_m }
    }

    /// A close map view around the robot's true position, which shows the floor up to this distance to each side of it.
    pub(super) fn close_up(panel: Panel, truth: Pose, shown_m: f64) -> MapView {
        let centre_m = [truth.x_m, truth.y_m];
        MapView { panel, centre_m, pixels_per_m: panel.width_px.min(panel.height_px) / 2.0 / shown_m }
    }

    /// Draws the room, the joints between floor tiles, the floor's regions, wires and tapes that lie on the floor, and the route.
    pub(super) fn draw_floor(&self, canvas: &mut Canvas, scene: &Scene, laid: Option<&LaidTiles>) {
        canvas.clipped(self.panel, |canvas| {
            let ground_plan = GroundPlan::of(scene);
            let placed = |corners: &Vec<[f64; 2]>| corners.iter().map(|at_m| self.place(*at_m)).collect();
            let floors: Vec<Vec<[f64; 2]>> = ground_plan.floors_m().iter().map(placed).collect();
            floors.iter().for_each(|floor| canvas.fill(floor, palette::ROOM, 1.0));
            let has_polygons = scene.building.rooms.iter().any(|room| room.corners_m.is_some());
            if has_polygons {
                // No seam shows where the parts of a polygon meet.
                floors.iter().for_each(|floor| canvas.outline(floor, 1.5, palette::ROOM));
            }
            for region in &scene.floor.regions {
                canvas.fill(&region.corners_m().map(|corner| self.place(corner)), palette::REGION, 1.0);
            }
            if let (Some(tiles), Some(laid)) = (&scene.floor.tiles, laid) {
                // Joints between tiles are also laid beyond the walls, so the drawing of them is clipped to the floors.
                // The drawing of a polygon's parts is clipped to these, and not just to the rectangles around them.
                for floor in &floors {
                    let within = has_polygons.then_some(floor.as_slice());
                    canvas.clipped(self.visible(floor), |canvas| self.draw_joints(canvas, tiles, laid, within));
                }
            }
            // A floor covering hides the joints below it.
            for region in scene.floor.regions.iter().filter(|region| region.covering.is_some()) {
                canvas.fill(&region.corners_m().map(|corner| self.place(corner)), palette::REGION, 1.0);
            }
            for stray in &scene.floor.strays {
                let width_px = (stray.width_m * self.pixels_per_m).max(1.0);
                canvas.line(self.place(stray.from_m), self.place(stray.to_m), width_px, palette::FAINT_INK);
            }
            let waypoints: Vec<[f64; 2]> =
                scene.route.iter().flat_map(|route| &route.waypoints).map(|at| self.place([at.x_m, at.y_m])).collect();
            waypoints.windows(2).for_each(|pair| canvas.line(pair[0], pair[1], 1.0, palette::ROUTE));
            waypoints.iter().for_each(|at| canvas.ring(*at, 4.0, 1.5, palette::ROUTE));
            if ground_plan.has_further_rooms() {
                let walls_m = ground_plan.walls_m();
                walls_m
                    .iter()
                    .for_each(|[from, to]| canvas.line(self.place(*from), self.place(*to), 2.5, palette::WALL));
            } else {
                canvas.outline(&floors[0], 2.5, palette::WALL);
            }
        });
    }

    /// Draws the furniture, and the paths along which people walk.
    pub(super) fn draw_things(&self, canvas: &mut Canvas, scene: &Scene) {
        canvas.clipped(self.panel, |canvas| {
            for piece in &scene.furniture {
                let (sin, cos) = piece.rotation_deg.to_radians().sin_cos();
                let corner = |along: f64, across: f64| {
                    let (along_m, across_m) = (0.5 * along * piece.size_m[0], 0.5 * across * piece.size_m[1]);
                    self.place([piece.x_m + along_m * cos - across_m * sin, piece.y_m + along_m * sin + across_m * cos])
                };
                let corners = [corner(1.0, 1.0), corner(-1.0, 1.0), corner(-1.0, -1.0), corner(1.0, -1.0)];
                canvas.fill(&corners, palette::FURNITURE, 1.0);
                canvas.outline(&corners, 1.2, palette::FAINT_INK);
            }
            for person in &scene.people {
                let walk: Vec<[f64; 2]> = person.waypoints_m.iter().map(|at| self.place(*at)).collect();
                walk.windows(2).for_each(|pair| canvas.line(pair[0], pair[1], 1.5, palette::PEOPLE));
                let radius_px = person.radius_m * self.pixels_per_m;
                walk.iter().for_each(|at| canvas.ring(*at, radius_px, 1.0, palette::PEOPLE));
            }
        });
    }

    /// Draws the occupied cells of the grid map on which the ways of the robot's errands are planned.
    pub(super) fn draw_grid(&self, canvas: &mut Canvas, scene: &Scene) {
        if !scene.has_errands() {
            return;
        }
        let grid = OccupancyGrid::of(scene);
        canvas.clipped(self.panel, |canvas| {
            for (index, _) in grid.cells.iter().enumerate().filter(|(_, cell)| **cell == Cell::Occupied) {
                let [x_m, y_m] = grid.centre_m([index % grid.size[0], index / grid.size[0]]);
                let half_m = 0.5 * grid.resolution_m;
                let corners = self.rectangle([x_m - half_m, x_m + half_m], [y_m - half_m, y_m + half_m]);
                canvas.fill(&corners, palette::WALL, 0.35);
            }
        });
    }

    /// Draws the paths that were planned for the robot's errands until `until_s`, and the goals: each in the colour of how its errand ended, grey
    /// while it has not.
    pub(super) fn draw_errands(&self, canvas: &mut Canvas, record: &RunRecord, until_s: f64) {
        let Some(log) = &record.errands else { return };
        canvas.clipped(self.panel, |canvas| {
            for leg in log.legs.iter().filter(|leg| leg.from_s <= until_s) {
                let corners: Vec<[f64; 2]> = leg.corners_m.iter().map(|at| self.place(*at)).collect();
                corners.windows(2).for_each(|pair| canvas.line(pair[0], pair[1], 3.0, palette::ROUTE));
            }
            for errand in &log.errands {
                let colour = match errand.outcome {
                    _ if errand.ended_s.unwrap_or(f64::INFINITY) > until_s => palette::FAINT_INK,
                    Outcome::Reached => palette::TRUTH,
                    _ => palette::MISS,
                };
                canvas.ring(self.place(errand.goal_m), 6.0, 2.0, colour);
            }
        });
    }

    /// Draws the path that the robot has driven until `until_s`.
    pub(super) fn draw_trail(&self, canvas: &mut Canvas, record: &RunRecord, until_s: f64) {
        let places: Vec<[f64; 2]> = record
            .truths
            .iter()
            .take_while(|truth| truth.time_s <= until_s)
            .step_by(10)
            .map(|truth| self.place([truth.pose.x_m, truth.pose.y_m]))
            .collect();
        canvas.clipped(self.panel, |canvas| {
            places.windows(2).for_each(|pair| canvas.line(pair[0], pair[1], 1.2, palette::TRAIL));
        });
    }

    /// Draws the trail of the middles of the answers, ten for each second.
    pub(super) fn draw_answers(&self, canvas: &mut Canvas, record: &RunRecord) {
        let middles: Vec<[f64; 2]> = record
            .estimates
            .iter()
            .step_by(10)
            .map(|estimate| estimate.pose.hull().midpoint())
            .filter(|middle| middle.iter().all(|value| value.is_finite()))
            .map(|[x_m, y_m, _]| self.place([x_m, y_m]))
            .collect();
        canvas.clipped(self.panel, |canvas| {
            middles.windows(2).for_each(|pair| canvas.line(pair[0], pair[1], 1.2, palette::BOX));
        });
    }

    /// Draws a path from place to place.
    pub(super) fn draw_path(&self, canvas: &mut Canvas, places_m: &[[f64; 2]], colour: Rgb<u8>) {
        canvas.clipped(self.panel, |canvas| {
            for pair in places_m.windows(2) {
                canvas.line(self.place(pair[0]), self.place(pair[1]), 1.2, colour);
            }
        });
    }

    /// Draws the outline of every box of a union.
    pub(super) fn draw_union(&self, canvas: &mut Canvas, union: &PoseUnion) {
        canvas.clipped(self.panel, |canvas| {
            for branch in &union.branches {
                let [x, y, _] = branch.components();
                canvas.outline(&self.rectangle([x.lo(), x.hi()], [y.lo(), y.hi()]), 1.2, palette::BOX);
            }
        });
    }

    /// Draws every box of the estimate, with a wedge of this length of the headings that the box allows; all boxes are red when none of them holds
    /// the true pose.
    pub(super) fn draw_boxes(&self, canvas: &mut Canvas, union: &PoseUnion, truth: Pose, wedge_px: f64) {
        let is_contained = union.contains(truth);
        let colour = if is_contained { palette::BOX } else { palette::MISS };
        canvas.clipped(self.panel, |canvas| {
            for branch in &union.branches {
                let [x, y, heading] = branch.components();
                let centre = self.place([x.mid(), y.mid()]);
                let end =
                    |angle_rad: f64| [centre[0] + wedge_px * angle_rad.cos(), centre[1] - wedge_px * angle_rad.sin()];
                // A box whose heading interval is half a turn or more gets no wedge of headings.
                if heading.width() < std::f64::consts::PI {
                    canvas.fill(&[centre, end(heading.lo()), end(heading.hi())], colour, 0.35);
                    canvas.line(centre, end(heading.lo()), 1.0, colour);
                    canvas.line(centre, end(heading.hi()), 1.0, colour);
                }
                let corners = self.rectangle([x.lo(), x.hi()], [y.lo(), y.hi()]);
                canvas.fill(&corners, colour, 0.25);
                canvas.outline(&corners, 1.5, colour);
                // In the view of the whole room a box of a few millimetres is smaller than a pixel, so that a ring marks it.
                let is_tiny = (corners[2][0] - corners[0][0]).abs() < 6.0;
                if is_tiny {
                    canvas.ring(centre, 5.0, 1.5, colour);
                }
            }
        });
    }

    /// Draws what a localizer states that has no boxes: the region around the mean pose, by its corners relative to the mean, and a stroke in the
    /// direction of the mean heading.
    pub(super) fn draw_region(&self, canvas: &mut Canvas, mean: Pose, corners_m: &[[f64; 2]], colour: Rgb<u8>) {
        const STROKE_PX: f64 = 14.0;
        let corners: Vec<[f64; 2]> =
            corners_m.iter().map(|[x_m, y_m]| self.place([mean.x_m + x_m, mean.y_m + y_m])).collect();
        let middle = self.place([mean.x_m, mean.y_m]);
        let (sin, cos) = mean.heading_rad.sin_cos();
        canvas.clipped(self.panel, |canvas| {
            canvas.fill(&corners, colour, 0.25);
            canvas.outline(&corners, 1.5, colour);
            canvas.line(middle, [middle[0] + STROKE_PX * cos, middle[1] - STROKE_PX * sin], 2.0, colour);
            canvas.ring(middle, 5.0, 1.5, colour);
        });
    }

    /// Draws the true pose as an arrow.
    pub(super) fn draw_truth(&self, canvas: &mut Canvas, truth: Pose, length_px: f64) {
        let from = self.place([truth.x_m, truth.y_m]);
        let to = [from[0] + length_px * truth.heading_rad.cos(), from[1] - length_px * truth.heading_rad.sin()];
        canvas.clipped(self.panel, |canvas| {
            canvas.arrow(from, to, 2.5, palette::TRUTH);
            canvas.ring(from, 3.5, 3.5, palette::TRUTH);
        });
    }

    /// Draws the outline of the robot's body at a pose, and of the part of the floor that its floor camera sees.
    pub(super) fn draw_robot(&self, canvas: &mut Canvas, scene: &Scene, pose: Pose) {
        let (sin, cos) = pose.heading_rad.sin_cos();
        let in_world = |forward_m: f64, left_m: f64| {
            self.place([pose.x_m + forward_m * cos - left_m * sin, pose.y_m + forward_m * sin + left_m * cos])
        };
        canvas.clipped(self.panel, |canvas| {
            canvas.ring(in_world(0.0, 0.0), scene.robot.body_radius_m * self.pixels_per_m, 1.2, palette::FAINT_INK);
            if let Some(camera) = &scene.robot.floor_camera {
                let half_width_m = camera.footprint_width_m / 2.0;
                let half_length_m = half_width_m * f64::from(camera.height_px) / f64::from(camera.width_px);
                let corner = |forward: f64, left: f64| {
                    in_world(camera.forward_m + forward * half_length_m, camera.left_m + left * half_width_m)
                };
                let corners = [corner(1.0, 1.0), corner(1.0, -1.0), corner(-1.0, -1.0), corner(-1.0, 1.0)];
                canvas.outline(&corners, 1.2, palette::SEEN);
            }
        });
    }

    /// Draws a scale bar of a round length with its label in the lower-left corner of the panel.
    pub(super) fn draw_scale(&self, canvas: &mut Canvas) {
        let longest_m = 0.35 * self.panel.width_px / self.pixels_per_m;
        let decade_m = 10_f64.powf(longest_m.log10().floor());
        let length_m = [5.0, 2.0].into_iter().find(|step| step * decade_m <= longest_m).unwrap_or(1.0) * decade_m;
        let label = if length_m < 0.995 { format!("{:.0} mm", length_m * 1e3) } else { format!("{length_m:.0} m") };
        let (left, bottom) = (self.panel.left_px + 14.0, self.panel.top_px + self.panel.height_px - 14.0);
        let right = left + length_m * self.pixels_per_m;
        let width_px = (right - left).max(Canvas::text_width_px(15.0, &label)) + 12.0;
        let around = [
            [left - 6.0, bottom - 26.0],
            [left - 6.0 + width_px, bottom - 26.0],
            [left - 6.0 + width_px, bottom + 7.0],
            [left - 6.0, bottom + 7.0],
        ];
        canvas.fill(&around, palette::PAPER, 0.85);
        canvas.line([left, bottom], [right, bottom], 2.0, palette::INK);
        for end in [left, right] {
            canvas.line([end, bottom - 4.0], [end, bottom + 4.0], 2.0, palette::INK);
        }
        canvas.text([left, bottom - 23.0], 15.0, palette::INK, &label);
    }

    /// Draws the joints between tiles, those of the whole floor or those within a convex part of it.
    fn draw_joints(&self, canvas: &mut Canvas, tiles: &Tiles, laid: &LaidTiles, within: Option<&[[f64; 2]]>) {
        let (sin, cos) = tiles.rotation_deg.to_radians().sin_cos();
        let corner = |i: usize, j: usize| {
            let offset_m = laid.corner_offset_m[i * laid.count[1] + j];
            let x_m = tiles.edge_x_m * (f64::from(laid.first[0]) + i as f64) + tiles.phase_x_m + offset_m[0];
            let y_m = tiles.edge_y_m * (f64::from(laid.first[1]) + j as f64) + tiles.phase_y_m + offset_m[1];
            self.place([x_m * cos - y_m * sin, x_m * sin + y_m * cos])
        };
        let width_px = (tiles.joint_width_m * self.pixels_per_m).max(1.0);
        for i in 0..laid.count[0] {
            for j in 0..laid.count[1] {
                for (axis, [next_i, next_j]) in [[i, j + 1], [i + 1, j]].into_iter().enumerate() {
                    let is_seen = laid.contrast[axis][i * laid.count[1] + j] > 0.0;
                    if is_seen && next_i < laid.count[0] && next_j < laid.count[1] {
                        let joint = [corner(i, j), corner(next_i, next_j)];
                        let seen = within.map_or(Some(joint), |within| clipped_to(within, joint));
                        if let Some([from, to]) = seen {
                            canvas.line(from, to, width_px, palette::JOINT);
                        }
                    }
                }
            }
        }
    }

    /// The part of the panel inside the upright rectangle around some corners.
    fn visible(&self, corners: &[[f64; 2]]) -> Panel {
        let panel = self.panel;
        let least = |axis: usize| corners.iter().map(|corner| corner[axis]).fold(f64::INFINITY, f64::min);
        let most = |axis: usize| corners.iter().map(|corner| corner[axis]).fold(f64::NEG_INFINITY, f64::max);
        let (left_px, top_px) = (panel.left_px.max(least(0)), panel.top_px.max(least(1)));
        let right_px = (panel.left_px + panel.width_px).min(most(0));
        let bottom_px = (panel.top_px + panel.height_px).min(most(1));
        Panel { left_px, top_px, width_px: right_px - left_px, height_px: bottom_px - top_px }
    }

    fn place(&self, at_m: [f64; 2]) -> [f64; 2] {
        let middle_px =
            [self.panel.left_px + self.panel.width_px / 2.0, self.panel.top_px + self.panel.height_px / 2.0];
        [
            middle_px[0] + (at_m[0] - self.centre_m[0]) * self.pixels_per_m,
            middle_px[1] - (at_m[1] - self.centre_m[1]) * self.pixels_per_m,
        ]
    }

    fn rectangle(&self, x_m: [f64; 2], y_m: [f64; 2]) -> [[f64; 2]; 4] {
        [[x_m[0], y_m[0]], [x_m[1], y_m[0]], [x_m[1], y_m[1]], [x_m[0], y_m[1]]].map(|corner| self.place(corner))
    }
}

/// The part of a line between two points that is within a convex polygon, whose corners go round either way; `None` if no part is.
fn clipped_to(polygon: &[[f64; 2]], [from, to]: [[f64; 2]; 2]) -> Option<[[f64; 2]; 2]> {
    let corner = |index: usize| polygon[index % polygon.len()];
    let cross = |one: [f64; 2], other: [f64; 2], at: [f64; 2]| {
        (other[0] - one[0]) * (at[1] - one[1]) - (other[1] - one[1]) * (at[0] - one[0])
    };
    let area: f64 = (0..polygon.len()).map(|index| cross([0.0; 2], corner(index), corner(index + 1))).sum();
    let (mut low, mut high) = (0.0_f64, 1.0_f64);
    for index in 0..polygon.len() {
        let [start, end] = [from, to].map(|at| cross(corner(index), corner(index + 1), at) * area.signum());
        match (start >= 0.0, end >= 0.0) {
            (true, true) => {}
            (false, false) => return None,
            (true, false) => high = high.min(start / (start - end)),
            (false, true) => low = low.max(start / (start - end)),
        }
    }
    let at = |share: f64| [0, 1].map(|axis| from[axis] + (to[axis] - from[axis]) * share);
    (low < high).then(|| [at(low), at(high)])
}

//! What the dots of an image relate: the pose, the constants of the camera, the lean of the body, and where each marker truly is.

use interval::Interval;

use crate::{
    PoseBox, RobotModel,
    bounds::{self, Assumption},
    graph::{Disc, Domain, Relations, Row, SeenPlace, Stray, Variable},
    map::PlacedMarker,
    markers::{GridPlace, dot_in_marker_m},
    robot::cayley_radius,
};

use super::{SeenDot, ray::Optics};

/// Greatest number of markers of an image of which rows are made; those nearest to the middle of the picture are taken.
const MOST_MARKERS: usize = 4;

/// Factor that makes up for the roundings of a dot's place on the map.
const ABOVE: f64 = 1.0 + 1e-9;

/// The dots of an image as relations.
pub(super) struct Dots {
    markers: Vec<SeenMarker>,
    placement_m: f64,
    body_radius: f64,
    stamp_error_s: f64,
}

/// The dots of one marker that span it: the rest, between them, tell nothing more.
struct SeenMarker {
    placed: PlacedMarker,
    /// Place on the map and its greatest error, beside that of the marker's place, with what the camera sees of the dot.
    dots: Vec<([Interval; 2], f64, SeenPlace)>,
}

impl Dots {
    /// No dots yet; the map gives the greatest error of a marker's place.
    pub(super) fn new(robot: &RobotModel, placement_m: f64, stamp_error_s: f64) -> Dots {
        Dots { markers: Vec::new(), placement_m, body_radius: cayley_radius(robot.body.tilt_rad), stamp_error_s }
    }

    /// Adds the dots of a marker. `turn_rad` is the greatest turn of the picture about the vertical beside the heading and the camera's yaw.
    pub(super) fn add(&mut self, placed: PlacedMarker, seen: &[(GridPlace, SeenDot)], optics: &Optics, turn_rad: f64) {
        if self.markers.len() == MOST_MARKERS {
            return;
        }
        let dots = outermost(seen).into_iter().map(|&(_, dot)| {
            let place = optics.place(&dot.sight, placed.id, placed.height_m, turn_rad);
            (dot.in_world_m.map(|side| Interval::point(side.mid())), dot.in_world_m[0].radius(), place)
        });
        self.markers.push(SeenMarker { placed, dots: dots.collect() });
    }
}

impl Relations for Dots {
    fn quantities(&self, frame: usize, _pose: &PoseBox) -> Vec<(Variable, Interval)> {
        let tilt = Interval::centred(0.0, self.body_radius);
        let mut quantities: Vec<(Variable, Interval)> =
            (0..2).map(|axis| (Variable::BodyTilt(frame, axis), tilt)).collect();
        for marker in &self.markers {
            let place = Interval::centred(0.0, self.placement_m);
            (0..2).for_each(|axis| quantities.push((Variable::Marker(marker.placed.id, axis), place)));
            quantities.push((Variable::MarkerHeight(marker.placed.id), marker.placed.height_m));
        }
        quantities
    }

    fn discs(&self, frame: usize) -> Vec<Disc> {
        let pair = |of_axis: &dyn Fn(usize) -> Variable| [0, 1].map(of_axis);
        let mut discs = vec![(pair(&|axis| Variable::BodyTilt(frame, axis)), self.body_radius)];
        for marker in &self.markers {
            discs.push((pair(&|axis| Variable::Marker(marker.placed.id, axis)), self.placement_m));
        }
        discs
    }

    fn is_of_the_map(&self) -> bool {
        true
    }

    fn stamp_error_s(&self) -> f64 {
        self.stamp_error_s
    }

    fn shift_m(&self, stray: &Stray) -> f64 {
        stray.metres
    }

    fn shift_parts(&self, stray: &Stray) -> Vec<(Assumption, f64)> {
        [bounds::CEILING_CAMERA_STAMP, bounds::REACH_SPEED].map(|bound| (bound, stray.metres)).to_vec()
    }

    fn stamp_bound(&self) -> Assumption {
        bounds::CEILING_CAMERA_STAMP
    }

    fn rows(&self, frame: usize, domain: &Domain) -> Vec<Row> {
        let mut rows = Vec::new();
        for marker in &self.markers {
            for (in_world_m, slack_m, place) in &marker.dots {
                let seen = place.at(frame, domain);
                for direction in seen.axes() {
                    let placed = [0, 1].map(|axis| {
                        let variable = Variable::Marker(marker.placed.id, axis);
                        (variable, direction[axis], direction[axis] * domain.reference(variable))
                    });
                    let along_m =
                        direction[0] * in_world_m[0] + direction[1] * in_world_m[1] + placed[0].2 + placed[1].2;
                    let others = placed.map(|(variable, coefficient, _)| (variable, coefficient));
                    rows.push(seen.row(direction, along_m.inflate(slack_m * ABOVE), &others));
                }
            }
        }
        rows
    }
}

/// The dots that are farthest out along the four diagonals of the marker.
fn outermost(seen: &[(GridPlace, SeenDot)]) -> Vec<&(GridPlace, SeenDot)> {
    let mut kept: Vec<usize> = Vec::new();
    for [x, y] in [[1.0, 1.0], [1.0, -1.0], [-1.0, 1.0], [-1.0, -1.0]] {
        let far = |&(place, _): &(GridPlace, SeenDot)| {
            let [at_x, at_y] = dot_in_marker_m(place);
            x * at_x + y * at_y
        };
        let farthest = (0..seen.len()).max_by(|&a, &b| far(&seen[a]).total_cmp(&far(&seen[b])));
        kept.extend(farthest.filter(|idx| !kept.contains(idx)));
    }
    kept.into_iter().map(|idx| &seen[idx]).collect()
}

#[cfg(test)]
#[allow(clippy::expect_used)]
mod tests {
    use std::{collections::BTreeMap, f64::consts::PI};

    use nalgebra::{Rotation3, Vector3};

    use super::{
        super::trial::{CEILING_M, bench},
        *,
    };
    use crate::{
        graph::{
            Constant,
            trial::{Draw, rounds, tilt},
        },
        markers::MarkerId,
    };

    /// The pixel of a world point, by the camera's model in robot.rs, at focal lengths and a principal point.
    fn pixel(
        world_from_camera: Rotation3<f64>,
        offset_m: Vector3<f64>,
        focal_px: [f64; 2],
        centre_px: [f64; 2],
    ) -> [f64; 2] {
        let [forward, left, up] = (world_from_camera.inverse() * offset_m).into();
        [centre_px[0] + focal_px[0] * left / up, centre_px[1] - focal_px[1] * forward / up]
    }

    #[test]
    fn the_truth_satisfies_the_rows_of_dots_at_the_corners_of_all_bounds() {
        let mut draw = Draw::new(20_261_129);
        let mut nearest: f64 = 0.0;
        for round in 0..rounds(20_000) {
            let mut robot = bench();
            let camera = robot.ceiling_camera.as_mut().expect("a ceiling camera");
            let half = |value: f64, draw: &mut Draw| draw.or_zero(value);
            camera.focal_px = [480.0, 481.0].map(|at| Interval::centred(at, half(1.5, &mut draw)));
            camera.centre_px = [319.5, 239.5].map(|at| Interval::centred(at, half(3.0, &mut draw)));
            camera.position_m = [0.1, -0.05].map(|at| Interval::centred(at, half(0.002, &mut draw)));
            camera.height_m = Interval::centred(0.3, half(0.002, &mut draw));
            camera.yaw_rad = Interval::centred(0.3, half(0.005, &mut draw));
            camera.tilt_rad = half(0.005, &mut draw);
            robot.body.tilt_rad = half(0.006, &mut draw);
            robot.body.heave_m = half(0.001, &mut draw);
            let camera = camera.clone();
            let placed = PlacedMarker {
                id: MarkerId(5),
                centre_m: [draw.between(-2.0, 2.0), draw.between(-2.0, 2.0)],
                rotation_rad: 0.0,
                height_m: Interval::centred(CEILING_M, half(0.005, &mut draw)),
            };
            let (placement_m, slack_m, bound_px) =
                (half(0.004, &mut draw), half(0.0005, &mut draw), draw.or_zero(0.2) + 1e-9);

            // The truth.
            let mut truth = BTreeMap::new();
            let mut set = |variable, value: f64| {
                truth.insert(variable, value);
                value
            };
            let constant = Variable::Constant;
            let focal = [0, 1].map(|k| set(constant(Constant::CeilingFocal(k)), draw.within(camera.focal_px[k])));
            let centre = [0, 1].map(|k| set(constant(Constant::CeilingCentre(k)), draw.within(camera.centre_px[k])));
            let mount = [0, 1].map(|k| set(constant(Constant::CeilingPosition(k)), draw.within(camera.position_m[k])));
            let height = set(constant(Constant::CeilingHeight), draw.within(camera.height_m));
            let yaw = set(constant(Constant::CeilingYaw), draw.within(camera.yaw_rad));
            let (mount_tilt, cayley) = tilt(&mut draw, camera.tilt_rad);
            (0..2).for_each(|k| {
                set(constant(Constant::CeilingTilt(k)), cayley[k]);
            });
            let (body, cayley) = tilt(&mut draw, robot.body.tilt_rad);
            let (sin, cos) = (yaw - camera.yaw_rad.mid()).sin_cos();
            set(Variable::BodyTilt(4, 0), cos * cayley[0] + sin * cayley[1]);
            set(Variable::BodyTilt(4, 1), cos * cayley[1] - sin * cayley[0]);
            let marker_height = set(Variable::MarkerHeight(placed.id), draw.within(placed.height_m));
            let (course, far) = (draw.between(-PI, PI), draw.within(Interval::new(0.0, placement_m)));
            let off = [far * course.cos(), far * course.sin()];
            (0..2).for_each(|k| {
                set(Variable::Marker(placed.id, k), off[k]);
            });
            let heave = draw.within(Interval::centred(0.0, robot.body.heave_m));
            let turned = Rotation3::from_axis_angle(&Vector3::z_axis(), draw.between(-PI, PI)) * body;
            let forward = turned * Vector3::x();
            let heading = forward.y.atan2(forward.x);
            let at = [0, 1].map(|k| placed.centre_m[k] + draw.between(-0.9, 0.9));
            (0..2).for_each(|k| {
                set(Variable::Pose(4, k), at[k]);
            });
            set(Variable::Pose(4, 2), heading);

            // A dot of the marker, 6 cm from its middle, seen with an error at the bound.
            let slack_course = draw.between(-PI, PI);
            let on_map = [placed.centre_m[0] + 0.06, placed.centre_m[1] - 0.06];
            let dot = Vector3::new(
                on_map[0] + off[0] + slack_m * slack_course.cos(),
                on_map[1] + off[1] + slack_m * slack_course.sin(),
                marker_height,
            );
            let eye = Vector3::new(at[0], at[1], heave) + turned * Vector3::new(mount[0], mount[1], height);
            let world_from_camera = turned * Rotation3::from_axis_angle(&Vector3::z_axis(), yaw) * mount_tilt;
            let seen = pixel(world_from_camera, dot - eye, focal, centre);
            let told = [0, 1].map(|k| seen[k] + draw.within(Interval::centred(0.0, bound_px)));

            let optics = Optics::new(&camera, &robot.body);
            let sight = optics.sight([told[0], told[1], bound_px], placed.height_m).expect("a ray that goes up");
            let in_world_m = on_map.map(|at| Interval::centred(at, slack_m));
            let mut dots = Dots::new(&robot, placement_m, 0.0);
            let turn_rad = super::super::super::lean::heading_off_rad(robot.body.tilt_rad);
            dots.add(placed, &[([0, 0], SeenDot { sight, in_world_m })], &optics, turn_rad);
            let mut domain = Domain::of_constants(&robot);
            for (axis, half) in [(0, 0.05), (1, 0.08), (2, 0.02)] {
                let variable = Variable::Pose(4, axis);
                let around = truth[&variable] + draw.within(Interval::centred(0.0, half));
                domain.put(variable, Interval::centred(around, half + 1e-12));
            }
            dots.quantities(4, &PoseBox::EMPTY).into_iter().for_each(|(variable, value)| domain.put(variable, value));
            for (variable, value) in domain.iter() {
                let true_value = truth.get(&variable).copied().unwrap_or(value.mid());
                assert!(value.inflate(1e-12).contains(true_value), "{variable:?}: {true_value} {value}");
            }
            let rows = dots.rows(4, &domain);
            assert_eq!(rows.len(), 2);
            for row in rows {
                let value = row.value_at(|variable| truth[&variable] - domain.reference(variable));
                assert!(row.sides.inflate(1e-10).contains(value), "round {round}: {value} {}", row.sides);
                nearest = nearest.max((value - row.sides.mid()).abs() / row.sides.radius());
            }
        }
        assert!(nearest > 0.98, "{nearest}");
    }
}

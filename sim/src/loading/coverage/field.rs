//! The part of the ceiling that the ceiling camera surely sees.

use interval::Interval;
use localizer::Pose;
use nalgebra::Vector3;

use super::{Place, Poses};
use crate::{
    devices::camera::DrawnCamera,
    place::drawn::markers::DOT_RADIUS_M,
    scene::{CeilingCamera, Scene},
};

/// Distance from the middle of a marker to the middle of its corner dots.
const CORNER_M: f64 = 0.06 * std::f64::consts::SQRT_2;
/// Allowance in metres for the rounding of computations without intervals in this file; a thousand times more than needed.
const ROUNDING_M: f64 = 1e-9;

/// The part of the ceiling that a ceiling camera is sure to see, whatever its errors and those of the markers are within their tolerances.
#[derive(Clone, Debug)]
pub struct Field {
    /// Inward unit normals of the planes through the optical centre and the image's edges, in the frame of an upright robot body without
    /// errors.
    edges: [Vector3<f64>; 4],
    /// Lengths of the horizontal parts of these normals.
    levels: [f64; 4],
    /// Sine of the greatest angle between the camera's true attitude and the nominal attitude that it has at a given heading of the robot.
    sin_tilt: f64,
    /// Optical centre of the camera in the robot frame: forward, left, and height.
    centre_m: [f64; 3],
    /// Horizontal distance of the camera from the robot's origin, about which it moves in a circle when the robot turns.
    aside_m: f64,
    /// Greatest horizontal distance of a point of a marker from the marker's middle on the map, including the error of the camera's
    /// position.
    reach_m: f64,
    /// Horizontal distance from the robot's origin beyond which no point of the ceiling is in the image.
    farthest_m: f64,
    /// Greatest errors of a marker's height above the camera: by how much it may be lower, and by how much higher.
    rise_m: [f64; 2],
}

impl Field {
    /// The field of view of a scene's ceiling camera, without a margin of `margin_px` at the image's edges. `None` if the scene has no
    /// ceiling camera or no markers, or if the margin leaves nothing of the image.
    pub fn new(scene: &Scene, margin_px: f64) -> Option<Field> {
        let (camera, markers) = (scene.robot.ceiling_camera.as_ref()?, scene.markers.as_ref()?);
        let (robot, known) = (scene.robot_model(), DrawnCamera::nominal(camera));
        let model = robot.ceiling_camera.as_ref()?;
        let [left, right, top, bottom] = half_angles(camera, margin_px)?;
        let inward = [
            Vector3::new(1.0, 0.0, left),
            Vector3::new(-1.0, 0.0, right),
            Vector3::new(0.0, 1.0, top),
            Vector3::new(0.0, -1.0, bottom),
        ];
        let tilt_rad = robot.body.tilt_rad;
        let (aside_m, height_m) = (camera.forward_m.hypot(camera.left_m), camera.height_m);
        let tolerance_m = camera.calibration.position_tolerance_m;
        // When the robot's body tilts, the camera moves with it. An error of the camera's attitude about the vertical is treated as another
        // heading of the robot, which also moves the camera's position.
        let moved_m =
            1.5 * tolerance_m + height_m * tilt_rad.sin() + aside_m * (model.yaw_rad.radius() + tilt_rad * tilt_rad);
        let heaved_m = tolerance_m + robot.body.heave_m + aside_m * tilt_rad.sin() + markers.height_tolerance_m;
        let rise_m = scene.building.ceiling_height_m - height_m;
        let edges = inward.map(|normal| known.body_from_camera.rotation * normal.normalize());
        let farthest_rad = left.max(right).hypot(top.max(bottom)).atan() + lean_rad(camera);
        Some(Field {
            farthest_m: aside_m + farthest_rad.min(MOST_RAD).tan() * rise_m.max(0.0),
            edges,
            levels: edges.map(|normal| normal.x.hypot(normal.y)),
            sin_tilt: (tilt_rad + model.tilt_rad).sin(),
            centre_m: [camera.forward_m, camera.left_m, height_m],
            aside_m,
            reach_m: CORNER_M + DOT_RADIUS_M + markers.print_tolerance_m + markers.placement_tolerance_m + moved_m,
            rise_m: [heaved_m, heaved_m + height_m * tilt_rad * tilt_rad],
        })
    }

    /// The same field of view, narrowed on every side by a length on the ceiling.
    pub(super) fn narrowed(&self, by_m: f64) -> Field {
        Field { reach_m: self.reach_m + by_m, ..self.clone() }
    }

    /// This field of view from a box of robot poses.
    pub(super) fn view_from<'a>(&'a self, poses: &'a Poses) -> View<'a> {
        View {
            field: self,
            poses,
            sin_cos: poses.middle.heading_rad.sin_cos(),
            half_m: poses.half_m[0].hypot(poses.half_m[1]),
        }
    }

    /// Whether a marker is near enough to a position of the robot's origin to be in the image at any heading. One that is too far away by no more than
    /// what rounding makes of the distance may pass.
    pub(super) fn reaches(&self, from_m: [f64; 2], place: &Place) -> bool {
        let off_m = [place[0] - from_m[0], place[1] - from_m[1]];
        off_m[0] * off_m[0] + off_m[1] * off_m[1] <= self.farthest_m * self.farthest_m * (1.0 + 1e-12)
    }

    /// Whether the middle of a marker is in the image from a robot pose if there are no errors.
    pub fn sees_without_errors(&self, pose: &Pose, place: &Place) -> bool {
        self.view_from(&Poses::at(*pose)).sees_without_errors(place)
    }
}

/// A field of view from a box of robot poses, with what depends on the poses alone computed once for all markers.
pub(super) struct View<'a> {
    field: &'a Field,
    poses: &'a Poses,
    /// Sine and cosine of the heading in the middle of the box of poses.
    sin_cos: (f64, f64),
    /// Greatest distance of the robot's origin from where it is in the middle of the box of poses.
    half_m: f64,
}

impl View<'_> {
    /// Whether the whole of a marker is in the image from every pose of the box, whatever the errors are within their tolerances.
    pub(super) fn surely_sees(&self, place: &Place) -> bool {
        let (field, half_m) = (self.field, self.half_m);
        let from_origin_m = self.origin_distance_m(place);
        if from_origin_m > half_m + field.farthest_m {
            return false;
        }
        let (along_m, rise_m) = self.seen(place);
        let farthest_m = from_origin_m + half_m + field.aside_m;
        let turned_m = half_m + self.poses.half_rad * farthest_m;
        let rises_m = [rise_m - field.rise_m[0], rise_m + field.rise_m[1]];
        let tilted_m = field.sin_tilt * (farthest_m + field.reach_m).hypot(rises_m[1]);
        field.edges.iter().zip(field.levels).all(|(normal, level)| {
            let up_m = (normal.z * rises_m[0]).min(normal.z * rises_m[1]);
            let at_middle_m = normal.x * along_m[0] + normal.y * along_m[1] - level * turned_m;
            // Lower bound, for any heading, on the part of the marker's distance inside the image's edge that changes with the heading.
            let at_worst_m = -level * farthest_m;
            let level_m = if self.poses.has_all_headings() { at_worst_m } else { at_middle_m.max(at_worst_m) };
            up_m + level_m - level * field.reach_m >= tilted_m + ROUNDING_M
        })
    }

    /// Whether the middle of a marker may be in the image from some pose of the box, if there are no errors.
    pub(super) fn may_see(&self, place: &Place) -> bool {
        let (along_m, rise_m) = self.seen(place);
        let turned_m =
            self.half_m + self.poses.half_rad * (self.origin_distance_m(place) + self.half_m + self.field.aside_m);
        self.field.edges.iter().zip(self.field.levels).all(|(normal, level)| {
            normal.x * along_m[0] + normal.y * along_m[1] + normal.z * rise_m + level * turned_m >= -ROUNDING_M
        })
    }

    /// Whether the middle of a marker is in the image from the middle of the box, if there are no errors.
    pub(super) fn sees_without_errors(&self, place: &Place) -> bool {
        let (along_m, rise_m) = self.seen(place);
        self.field.edges.iter().all(|normal| {
            let inside_m = normal.x * along_m[0] + normal.y * along_m[1] + normal.z * rise_m;
            inside_m >= 0.0
        })
    }

    /// Horizontal distance of a marker from the robot's origin in the middle of the box.
    fn origin_distance_m(&self, place: &Place) -> f64 {
        (place[0] - self.poses.middle.x_m).hypot(place[1] - self.poses.middle.y_m)
    }

    /// Vector from the camera's optical centre to a marker's middle, in the robot frame of the box's middle: forward and left, and upwards.
    fn seen(&self, place: &Place) -> ([f64; 2], f64) {
        let (sin, cos) = self.sin_cos;
        let (x_m, y_m) = (place[0] - self.poses.middle.x_m, place[1] - self.poses.middle.y_m);
        let [forward_m, left_m, height_m] = self.field.centre_m;
        ([cos * x_m + sin * y_m - forward_m, cos * y_m - sin * x_m - left_m], place[2] - height_m)
    }
}

/// Greatest angle from the optical axis that is considered; points of the ceiling nearer to the horizon count as not seen.
const MOST_RAD: f64 = 1.5;

fn lean_rad(camera: &CeilingCamera) -> f64 {
    camera.lean_forward_deg.hypot(camera.lean_left_deg).to_radians()
}

/// Lower bounds on the tangents of the angles from the optical axis to the left, right, upper and lower edge of the image. A point of the
/// plane at depth 1 within them is in the image, whatever the lens is within its calibration.
fn half_angles(camera: &CeilingCamera, margin_px: f64) -> Option<[f64; 4]> {
    let calibration = &camera.calibration;
    let margin_px = margin_px + calibration.distortion_tolerance_px;
    let size_px = [camera.width_px, camera.height_px].map(f64::from);
    let focal_px = camera
        .focal_px
        .map(|focal_px| Interval::point(focal_px) * (Interval::point(1.0).inflate(calibration.focal_tolerance)));
    let centre_px =
        camera.principal_point_px.map(|at_px| Interval::point(at_px).inflate(calibration.principal_point_tolerance_px));
    let least_px = -0.5 + margin_px;
    let most_px = size_px.map(|size| size - 0.5 - margin_px);
    // First, the tangents to the image's edges for a lens without distortion.
    let mut tangents = [0.0; 4];
    for axis in 0..2 {
        tangents[2 * axis] = ((centre_px[axis] - least_px) / focal_px[axis]).lo();
        tangents[2 * axis + 1] = ((Interval::point(most_px[axis]) - centre_px[axis]) / focal_px[axis]).lo();
    }
    if tangents.iter().any(|tangent| *tangent <= 0.0) {
        return None;
    }
    if camera.lens.distortion == [0.0; 5] {
        return Some(tangents);
    }
    // A lens that draws the rim inwards shows more than a lens without distortion, and one that draws the rim outwards shows less.
    let is_inside = |scale: f64| {
        let [left, right, top, bottom] = tangents.map(|tangent| scale * tangent);
        let side = |from: f64, to: f64, step: f64| {
            Interval::new(from + step / 16.0 * (to - from), from + (step + 1.0) / 16.0 * (to - from))
        };
        (0..16).all(|i| {
            (0..16).all(|j| {
                let bent =
                    bent(&camera.lens.distortion, [side(-left, right, f64::from(i)), side(-top, bottom, f64::from(j))]);
                (0..2).all(|axis| {
                    let pixel = bent[axis] * focal_px[axis] + centre_px[axis];
                    pixel.lo() >= least_px && pixel.hi() <= most_px[axis]
                })
            })
        })
    };
    (1..=140).rev().map(|percent| f64::from(percent) / 100.0).find(|scale| is_inside(*scale)).map(|scale| {
        // The resulting tangents are made slightly smaller than those that were checked, so that rounding cannot put a point between the
        // two.
        tangents.map(|tangent| tangent * scale * (1.0 - 1e-9))
    })
}

/// Brown's distortion model, evaluated over a box of the plane at depth 1.
fn bent([k1, k2, p1, p2, k3]: &[f64; 5], [x, y]: [Interval; 2]) -> [Interval; 2] {
    let (x2, y2) = (x.sqr(), y.sqr());
    let r2 = x2 + y2;
    let radial = ((r2 * *k3 + *k2) * r2 + *k1) * r2 + 1.0;
    let product = x * y * 2.0;
    [x * radial + product * *p1 + (r2 + x2 * 2.0) * *p2, y * radial + (r2 + y2 * 2.0) * *p1 + product * *p2]
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use nalgebra::{Point3, UnitQuaternion, vector};

    use super::*;
    use crate::{devices::camera::world_from_camera, optics::Lens, truth::Truth};

    #[test]
    fn at_the_edge_of_what_is_surely_seen_the_worst_tilt_still_shows_the_marker() {
        // Set-up: only the mount's tilt is uncertain, by 2°, which is 3 % of the distance; a pixel is a fifth of a percent of it.
        let exact = "position_tolerance_m = 0.0\nfocal_tolerance = 0.0\nprincipal_point_tolerance_px = 0.0\n";
        let text = format!(
            "[room]\nwidth_m = 8.0\ndepth_m = 8.0\n[start]\nx_m = 1.0\ny_m = 1.0\n[[route.waypoint]]\nx_m = 1.0\ny_m = 1.0\n\
             [robot]\nerrors = \"corner\"\nfloor_camera = false\n[robot.ceiling_camera]\nfocal_px = [480.0, 480.0]\n\
             [robot.ceiling_camera.calibration]\nangle_tolerance_deg = 2.0\n{exact}\
             [bounds]\nbody_tilt_deg = 0.0\n[markers]\n[[markers.marker]]\nid = 125\nx_m = 4\ny_m = 4\n"
        );
        let scene = Scene::parse(&text, "room.toml").unwrap();
        let field = Field::new(&scene, 0.0).unwrap();
        let camera = scene.robot.ceiling_camera.as_ref().unwrap();
        let pose = Pose { x_m: 4.0, y_m: 4.0, heading_rad: 0.3 };
        let height_m = scene.markers.as_ref().unwrap().height_m(&scene.markers.as_ref().unwrap().all()[0], &scene);
        let mut hidden_a_little_farther = 0;
        for step in 0..16 {
            let (sin, cos) = (f64::from(step) * std::f64::consts::PI / 8.0).sin_cos();
            let at = |distance_m: f64| [4.0 + cos * distance_m, 4.0 + sin * distance_m, height_m];
            let (mut near_m, mut far_m) = (0.0, 3.0);
            while far_m - near_m > 1e-6 {
                let middle_m = 0.5 * (near_m + far_m);
                if field.view_from(&Poses::at(pose)).surely_sees(&at(middle_m)) {
                    near_m = middle_m
                } else {
                    far_m = middle_m
                }
            }
            assert!(near_m > 0.3);
            // Whether the whole square of the marker is seen at this distance, whichever way the camera's mount is tilted by 2°.
            let is_shown = |distance_m: f64| {
                (0..32).all(|course| {
                    let (sin, cos) = (f64::from(course) * std::f64::consts::PI / 16.0).sin_cos();
                    let mut mount = DrawnCamera::nominal(camera);
                    let tilt = UnitQuaternion::from_scaled_axis(vector![cos, sin, 0.0] * 2f64.to_radians());
                    mount.body_from_camera.rotation = tilt * mount.body_from_camera.rotation;
                    let lens = Lens::of(camera, &mount);
                    let truth = Truth { pose, ..Truth::default() };
                    let camera_from_world = world_from_camera(&truth, &mount).inverse();
                    let [x_m, y_m, z_m] = at(distance_m);
                    [[-1.0, -1.0], [-1.0, 1.0], [1.0, -1.0], [1.0, 1.0]].iter().all(|[a, b]| {
                        let seen = camera_from_world * Point3::new(x_m + 0.067 * a, y_m + 0.067 * b, z_m);
                        let [u, v] = lens.pixel([seen.x / seen.z, seen.y / seen.z]);
                        (-0.5..=f64::from(camera.width_px) - 0.5).contains(&u)
                            && (-0.5..=f64::from(camera.height_px) - 0.5).contains(&v)
                    })
                })
            };
            assert!(is_shown(near_m), "{step}: {near_m}");
            // The proof is not too cautious: if the marker is moved 8 cm farther away, less than the 9 cm by which the tilt
            // shifts the view, some tilt hides it in many directions.
            hidden_a_little_farther += usize::from(!is_shown(near_m + 0.08));
        }
        assert!(hidden_a_little_farther >= 8, "{hidden_a_little_farther}");
    }
}

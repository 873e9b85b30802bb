//! A camera that sees things of the map: where its image shows a point of the world, as a function of pose, posture, mount and lens.
//!
//! The formulas are written for this check alone, forwards from the point to the pixel.

mod cameras;

use interval::Interval;
use localizer::{RobotModel, bounds::Assumption, reading::Camera};
use nalgebra::UnitQuaternion;

use crate::{
    devices::camera::DrawnCamera,
    optics::mounts,
    scene::{CameraKeys, Scene},
    world::Drawn,
};

use super::{
    history::{CameraPart, History, Looker, Quantity},
    kind::{Broken, Declared, Linearised, demand, within},
    number::{Number, Vector, turned_about, turned_by},
};

/// Number of values on which a sight depends: the pose (3), the body's roll, pitch and heave, and of the camera the position (3), yaw, tilt (2), focal
/// lengths (2) and principal point (2).
const N_INPUTS: usize = 16;

/// Step of the numeric differentiation: near the cube root of the rounding unit, for central differences.
const STEP: f64 = 1e-6;

/// A constant of a camera as it enters a sight: a quantity times a factor, or a known value.
#[derive(Clone, Copy, Debug)]
enum Input {
    Quantity(CameraPart, f64),
    Known(f64),
}

/// A camera with its declared bounds.
pub(super) struct Eye {
    pub(super) camera: Camera,
    /// The camera's axes in the robot frame, before it leans: image right, image down and ahead.
    axes: [Vector<f64>; 3],
    /// Rotation vector of the nominal lean, about robot x and robot y.
    lean_rad: [f64; 2],
    /// Whether the error of the tilt acts on a camera that is turned by its yaw already, not the other way round.
    tilts_last: bool,
    /// Coefficients k1, k2, p1, p2, k3 of the true lens. The witness keeps them.
    distortion: [f64; 5],
    constants: [Input; N_INPUTS - 6],
    declared: Vec<(CameraPart, Interval, Assumption)>,
    tilt: (f64, Assumption),
    stamp: (f64, Assumption),
}

/// A camera at one instant: the directions of its axes and its optical centre in the world, and its lens.
#[derive(Clone, Copy, Debug)]
pub(super) struct Sight<T> {
    axes: [Vector<T>; 3],
    pub(super) centre_m: Vector<T>,
    focal_px: [T; 2],
    principal_point_px: [T; 2],
    distortion: [f64; 5],
}

impl<T: Number> Sight<T> {
    /// The pixel at which a point of the world is seen, and its depth, which must be positive.
    pub(super) fn pixel(&self, point_m: Vector<T>) -> ([T; 2], T) {
        self.pixel_of(self.in_camera(std::array::from_fn(|axis| point_m[axis] - self.centre_m[axis])))
    }

    /// A vector of the world in the camera's frame: right, down, ahead.
    pub(super) fn in_camera(&self, vector: Vector<T>) -> Vector<T> {
        let along = |axis: &Vector<T>| axis[0] * vector[0] + axis[1] * vector[1] + axis[2] * vector[2];
        [along(&self.axes[0]), along(&self.axes[1]), along(&self.axes[2])]
    }

    /// The pixel at which a point in the camera's frame is seen, and its depth, which must be positive.
    pub(super) fn pixel_of(&self, [right, down, depth_m]: Vector<T>) -> ([T; 2], T) {
        let (x, y) = (right.over(depth_m), down.over(depth_m));
        let seen = if self.distortion == [0.0; 5] { [x, y] } else { self.bent(x, y) };
        (std::array::from_fn(|axis| self.focal_px[axis] * seen[axis] + self.principal_point_px[axis]), depth_m)
    }

    /// Brown and Conrady's model: x·(1 + k1·r² + k2·r⁴ + k3·r⁶) + 2·p1·x·y + p2·(r² + 2x²), and likewise y with p1 and p2 exchanged.
    fn bent(&self, x: T, y: T) -> [T; 2] {
        let [k1, k2, p1, p2, k3] = self.distortion.map(T::of);
        let (two, r2) = (T::of(2.0), x * x + y * y);
        let radial = T::of(1.0) + r2 * (k1 + r2 * (k2 + r2 * k3));
        [
            x * radial + two * p1 * x * y + p2 * (r2 + two * x * x),
            y * radial + two * p2 * x * y + p1 * (r2 + two * y * y),
        ]
    }
}

impl Sight<f64> {
    /// The point at depth 1 in the camera's frame that a pixel shows, to within rounding: what the lens bends is subtracted until it agrees.
    pub(super) fn ray(&self, pixel: [f64; 2]) -> Vector<f64> {
        /// Number of iterations, each of which leaves about a tenth of the error with a strong distortion.
        const N_STEPS: usize = 20;
        let [mut x, mut y] = [0, 1].map(|axis| (pixel[axis] - self.principal_point_px[axis]) / self.focal_px[axis]);
        let n_steps = if self.distortion == [0.0; 5] { 0 } else { N_STEPS };
        for _ in 0..n_steps {
            let at = self.pixel_of([x, y, 1.0]).0;
            x -= (at[0] - pixel[0]) / self.focal_px[0];
            y -= (at[1] - pixel[1]) / self.focal_px[1];
        }
        [x, y, 1.0]
    }
}

impl Eye {
    /// The camera of this name as the scene declares it, with the lens that was drawn; `None` if the robot does not have it.
    pub(super) fn of(camera: Camera, scene: &Scene, robot: &RobotModel, drawn: &Drawn) -> Option<Eye> {
        let keys = scene.robot.camera(camera)?;
        let drawn = drawn.devices.camera(camera)?;
        let stamp_error_s = keys.shared().stamp_tolerance_s;
        match camera {
            Camera::Floor => cameras::floor(robot, &drawn, stamp_error_s),
            Camera::Ceiling => cameras::ceiling(robot, &drawn, stamp_error_s),
            Camera::Forward => cameras::forward(robot, &drawn, stamp_error_s),
        }
    }

    fn quantity(&self, part: CameraPart) -> Quantity {
        Quantity::Camera(self.camera, part)
    }

    fn instant(&self, stamp: usize) -> Quantity {
        Quantity::Instant(Looker::Camera(self.camera), stamp)
    }

    /// The camera's constants with their declared intervals, and the instants of its looks, each given by its stamp in the history and the stamp that the
    /// camera gave it.
    pub(super) fn declared(&self, history: &History, looks: impl Iterator<Item = (usize, f64)>) -> Vec<Declared> {
        let constants = self.declared.iter().map(|&(part, interval, bound)| Declared {
            quantity: self.quantity(part),
            interval,
            bound,
        });
        let instants = looks.map(|(stamp, measured_s)| Declared {
            quantity: self.instant(stamp),
            interval: history.instants_s(measured_s, self.stamp.0),
            bound: self.stamp.1,
        });
        constants.chain(instants).collect()
    }

    /// Checks that the camera's tilt is within its bound as a vector.
    pub(super) fn check_tilt(&self, history: &History, slack: f64) -> Result<(), Broken> {
        let tilt = [0, 1].map(|axis| Interval::point(history.value(self.quantity(CameraPart::Tilt(axis)))));
        let most_rad = within(Interval::point(self.tilt.0));
        demand(slack, self.tilt.1, history.stamps_s[0], tilt[0].hypot(tilt[1]), most_rad)
    }

    /// Adds rows that keep the camera's tilt within its bound.
    pub(super) fn add_tilt_rows(&self, near: &mut Linearised<'_>) {
        near.add_disc([0, 1].map(|axis| self.quantity(CameraPart::Tilt(axis))), self.tilt.0);
    }

    fn inputs<T: Number>(&self, history: &History, stamp: usize) -> [T; N_INPUTS] {
        let pose: [T; 3] = history.pose_at(history.value(self.instant(stamp)));
        let posture = [Quantity::BodyTilt(stamp, 0), Quantity::BodyTilt(stamp, 1), Quantity::Heave(stamp)];
        let posture = posture.map(|quantity| T::of(history.value(quantity)));
        std::array::from_fn(|at| match at {
            0..3 => pose[at],
            3..6 => posture[at - 3],
            _ => match self.constants[at - 6] {
                Input::Quantity(part, factor) => T::of(history.value(self.quantity(part))) * T::of(factor),
                Input::Known(value) => T::of(value),
            },
        })
    }

    fn sight_by<T: Number>(&self, inputs: &[T; N_INPUTS]) -> Sight<T> {
        let &[x, y, heading, roll, pitch, heave, forward, left, up, yaw, tilt_x, tilt_y, fu, fv, cu, cv] = inputs;
        let in_body = |axis: &Vector<f64>| {
            let mut axis = axis.map(T::of);
            if self.lean_rad != [0.0; 2] {
                axis = turned_by(self.lean_rad.map(T::of), axis);
            }
            if self.tilts_last {
                turned_by([tilt_x, tilt_y], turned_about(2, yaw, axis))
            } else {
                turned_about(2, yaw, turned_by([tilt_x, tilt_y], axis))
            }
        };
        // The body is turned by Rz(heading)·Ry(pitch)·Rx(roll).
        let in_world = |vector| turned_about(2, heading, turned_about(1, pitch, turned_about(0, roll, vector)));
        let centre = in_world([forward, left, up]);
        Sight {
            axes: [0, 1, 2].map(|axis| in_world(in_body(&self.axes[axis]))),
            centre_m: [centre[0] + x, centre[1] + y, centre[2] + heave],
            focal_px: [fu, fv],
            principal_point_px: [cu, cv],
            distortion: self.distortion,
        }
    }

    /// The camera at the look that was truly at the stamp with this index.
    pub(super) fn sight<T: Number>(&self, history: &History, stamp: usize) -> Sight<T> {
        self.sight_by(&self.inputs(history, stamp))
    }

    /// The camera at a look, with what is needed to tell how pixels change.
    pub(super) fn slopes(&self, history: &History, stamp: usize) -> Slopes<'_> {
        let inputs: [f64; N_INPUTS] = self.inputs(history, stamp);
        let moved = std::array::from_fn(|input| {
            [STEP, -STEP].map(|step| {
                let mut moved = inputs;
                moved[input] += step;
                self.sight_by(&moved)
            })
        });
        Slopes { eye: self, stamp, velocity: history.velocity_at(stamp), sight: self.sight_by(&inputs), moved }
    }

    /// True value of a constant of the camera.
    pub(super) fn true_value(part: CameraPart, camera: &dyn CameraKeys, drawn: &DrawnCamera) -> f64 {
        let turn = drawn.body_from_camera.rotation * mounts::body_from_camera(camera).rotation.inverse();
        let yaw_rad = 2.0 * turn.k.atan2(turn.w);
        let yaw = UnitQuaternion::from_axis_angle(&nalgebra::Vector3::z_axis(), -yaw_rad);
        match part {
            CameraPart::Position(axis) => drawn.body_from_camera.translation.vector[axis],
            CameraPart::Yaw => yaw_rad,
            CameraPart::Tilt(axis) => {
                let tilts_last = camera.name() == Camera::Floor;
                let tilt = if tilts_last { turn * yaw } else { yaw * turn };
                tilt.scaled_axis()[axis]
            }
            CameraPart::Focal(axis) if camera.name() == Camera::Floor => {
                drawn.focal_px[axis] / camera.shared().position_m[2]
            }
            CameraPart::Focal(axis) => drawn.focal_px[axis],
            CameraPart::Centre(axis) => drawn.principal_point_px[axis],
        }
    }
}

/// A camera at a look of a history, and how what it sees changes with the history.
pub(super) struct Slopes<'a> {
    eye: &'a Eye,
    stamp: usize,
    velocity: [f64; 3],
    pub(super) sight: Sight<f64>,
    /// The sight with each input a little greater, and a little less.
    moved: [[Sight<f64>; 2]; N_INPUTS],
}

impl Slopes<'_> {
    /// Terms of how the pixel of a point of the world moves along a direction of the image, without what moves the point.
    pub(super) fn terms(&self, near: &Linearised<'_>, point_m: Vector<f64>, direction: [f64; 2]) -> Vec<(usize, f64)> {
        self.terms_of(near, &|sight: &Sight<f64>| {
            let [u, v] = sight.pixel(point_m).0;
            direction[0] * u + direction[1] * v
        })
    }

    /// Terms of how a value that depends on the camera changes.
    pub(super) fn terms_of(&self, near: &Linearised<'_>, of: &dyn Fn(&Sight<f64>) -> f64) -> Vec<(usize, f64)> {
        let mut terms = Vec::with_capacity(2 * N_INPUTS);
        for (input, [more, less]) in self.moved.iter().enumerate() {
            let slope = (of(more) - of(less)) / (2.0 * STEP);
            match input {
                0..3 => {
                    terms.extend(near.pose(self.stamp, input, slope));
                    terms.push(near.quantity(self.eye.instant(self.stamp), slope * self.velocity[input]));
                }
                3 | 4 => terms.push(near.quantity(Quantity::BodyTilt(self.stamp, input - 3), slope)),
                5 => terms.push(near.quantity(Quantity::Heave(self.stamp), slope)),
                _ => {
                    if let Input::Quantity(part, factor) = self.eye.constants[input - 6] {
                        terms.push(near.quantity(self.eye.quantity(part), slope * factor));
                    }
                }
            }
        }
        terms
    }

    /// How the pixel of a point of the world moves along a direction of the image when the point moves along each axis of the world.
    pub(super) fn by_point(&self, point_m: Vector<f64>, direction: [f64; 2]) -> Vector<f64> {
        std::array::from_fn(|axis| {
            let [more, less] = [STEP, -STEP].map(|step| {
                let mut moved = point_m;
                moved[axis] += step;
                let [u, v] = self.sight.pixel(moved).0;
                direction[0] * u + direction[1] * v
            });
            (more - less) / (2.0 * STEP)
        })
    }
}

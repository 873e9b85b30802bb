//! Map from a pixel to a place on the ceiling, with every declared error as a parameter.
//!
//! The place is given in the frame `apparent`: the robot frame made level (its x axis is the robot's heading seen from above), turned by
//! the unknown error δ of the camera's yaw; its origin is the robot origin. With T(a) the rotation by a tilt a about a horizontal axis, m
//! the optical centre, Z the dot's height above the robot origin and (f, l, up) = (−y, x, 1) the ray of the pixel's (x, y) for an upright
//! camera:
//!
//! ```text
//! c = T(body) m      d = T(body) Rz(yaw) T(mount) Lean (−y, x, 1)      dot = c + d·(Z − c_up)/d_up      (its two level components)
//! ```
//!
//! Tilts are written as Cayley vectors ([`tilted`]).

use interval::{Dual, Interval};

use crate::{
    bounds,
    graph::{Constant, SeenPlace, Variable},
    markers::MarkerId,
    reading::Camera,
    robot::{BodyModel, CeilingCameraModel, cayley_radius},
    vision::distortion,
};

use super::super::tilt::tilted;

/// Number of error parameters: the unknowns of one dot (its pixel), of the image (optics and posture of the camera), and of the marker (its
/// height). The constants below are the indices of the parameters.
pub(super) const N_PARAMETERS: usize = 14;
pub(super) const PIXEL: [usize; 2] = [0, 1];
pub(super) const CENTRE: [usize; 2] = [2, 3];
const FOCAL: [usize; 2] = [4, 5];
pub(super) const MOUNT_TILT: [usize; 2] = [6, 7];
pub(super) const BODY_TILT: [usize; 2] = [8, 9];
const POSITION: [usize; 2] = [10, 11];
const CAMERA_HEIGHT: usize = 12;
pub(super) const DOT_HEIGHT: usize = 13;

type Number = Dual<N_PARAMETERS>;

/// Known values of the camera and the body that are the same for all dots of an image; only a dot's pixel and height are still to be filled
/// in.
#[derive(Clone, Debug)]
pub(super) struct Optics {
    parameters: [Interval; N_PARAMETERS],
    lean: [[Interval; 3]; 3],
    yaw: [Interval; 2],
    /// Rotation of the camera about the vertical, and its position in the robot frame.
    yaw_rad: Interval,
    position_m: [Interval; 2],
    distortion: [f64; 5],
    distortion_px: f64,
    heave_m: f64,
}

/// Place in the apparent frame of the dot seen at a pixel, to first order in the deviations of the error parameters from their middles.
#[derive(Clone, Copy, Debug)]
pub(super) struct Sight {
    /// Place of the dot when every error parameter has its middle value.
    pub(super) middle_m: [Interval; 2],
    /// Derivatives of the dot's place (two components) by every error parameter, valid over the whole box of parameters.
    pub(super) slopes: [[Interval; N_PARAMETERS]; 2],
    /// Deviations of the error parameters from their middles, as intervals around 0.
    pub(super) deviations: [Interval; N_PARAMETERS],
}

/// Dot of a marker as the camera sees it, with its place in the world. The errors that all dots of the group share are not included.
#[derive(Clone, Copy, Debug)]
pub(super) struct SeenDot {
    pub(super) sight: Sight,
    pub(super) in_world_m: [Interval; 2],
}

/// Whether an error parameter is each dot's own and not shared by a group of dots: the error of the dot's pixel, and, where the group has several
/// markers, the height of the dot's marker.
pub(super) fn is_own(parameter: usize, is_one_marker: bool) -> bool {
    PIXEL.contains(&parameter) || (parameter == DOT_HEIGHT && !is_one_marker)
}

impl Optics {
    pub(super) fn new(camera: &CeilingCameraModel, body: &BodyModel) -> Optics {
        let mut parameters = [Interval::ZERO; N_PARAMETERS];
        let yaw_error = camera.yaw_rad - Interval::point(camera.yaw_rad.mid());
        let (sin, cos) = (yaw_error.sin(), yaw_error.cos());
        let [forward, left] = camera.position_m;
        // The camera's optical centre m, expressed in the frame that is turned by the camera's yaw error δ, is Rz(−δ) m.
        let position = [forward * cos + left * sin, left * cos - forward * sin];
        let tilt = |angle_rad: f64| Interval::centred(0.0, cayley_radius(angle_rad));
        for axis in 0..2 {
            parameters[CENTRE[axis]] = camera.centre_px[axis];
            parameters[FOCAL[axis]] = camera.focal_px[axis];
            parameters[MOUNT_TILT[axis]] = tilt(camera.tilt_rad);
            parameters[BODY_TILT[axis]] = tilt(body.tilt_rad);
            parameters[POSITION[axis]] = position[axis];
        }
        parameters[CAMERA_HEIGHT] = camera.height_m;
        let yaw = Interval::point(camera.yaw_rad.mid());
        Optics {
            parameters,
            lean: lean_matrix(camera.lean_rad),
            yaw: [yaw.cos(), yaw.sin()],
            yaw_rad: camera.yaw_rad,
            position_m: camera.position_m,
            distortion: camera.distortion,
            distortion_px: camera.distortion_px,
            heave_m: body.heave_m,
        }
    }

    /// First-order model of the place on a ceiling of this height that a pixel `[u, v, bound]` sees; `None` if the pixel's ray does not go
    /// up, or the lens model folds there.
    pub(super) fn sight(&self, [u, v, bound_px]: [f64; 3], height_m: Interval) -> Option<Sight> {
        let mut parameters = self.parameters;
        // The lens calibration's error shifts pixels of the image as taken, like a pixel's own error does, so that the two add up.
        parameters[PIXEL[0]] = Interval::centred(u, bound_px).inflate(self.distortion_px);
        parameters[PIXEL[1]] = Interval::centred(v, bound_px).inflate(self.distortion_px);
        parameters[DOT_HEIGHT] = height_m.inflate(self.heave_m);
        let middles = parameters.map(|parameter| Interval::point(parameter.mid()));
        let mut deviations = [Interval::ZERO; N_PARAMETERS];
        for (deviation, (parameter, middle)) in deviations.iter_mut().zip(parameters.iter().zip(&middles)) {
            *deviation = *parameter - *middle;
        }
        let over_box = self.dot_m(&parameters)?;
        let at_middle = self.dot_m(&middles)?;
        Some(Sight {
            middle_m: at_middle.map(|number| number.value),
            slopes: over_box.map(|number| number.slopes),
            deviations,
        })
    }

    /// The place of a seen dot as a function of the constants of the camera, the lean of the body, and the height of the dot's marker, which is within
    /// `height_m`. `turn_rad` is the greatest turn of the picture about the vertical beside the heading and the camera's yaw.
    pub(super) fn place(&self, sight: &Sight, marker: MarkerId, height_m: Interval, turn_rad: f64) -> SeenPlace {
        let column = |parameter: usize| [0, 1].map(|axis| sight.slopes[axis][parameter]);
        let mut place = SeenPlace {
            device: Camera::Ceiling.device(),
            yaw: Some((Constant::CeilingYaw, self.yaw_rad.mid())),
            middle_m: sight.middle_m,
            terms: Vec::new(),
            noise_m: PIXEL.iter().map(|&parameter| (column(parameter), sight.deviations[parameter], None)).collect(),
            turn_rad,
        };
        let heave = Interval::centred(0.0, self.heave_m);
        place.noise_m.push((column(DOT_HEIGHT), heave, Some(bounds::BODY_HEAVE)));
        let mut depends = |parameter: usize, variable: Variable| {
            place.terms.push((variable, self.parameters[parameter].mid(), column(parameter)));
        };
        for axis in 0..2 {
            depends(CENTRE[axis], Variable::Constant(Constant::CeilingCentre(axis)));
            depends(FOCAL[axis], Variable::Constant(Constant::CeilingFocal(axis)));
            depends(MOUNT_TILT[axis], Variable::Constant(Constant::CeilingTilt(axis)));
            depends(BODY_TILT[axis], Variable::BodyTilt(0, axis));
        }
        depends(CAMERA_HEIGHT, Variable::Constant(Constant::CeilingHeight));
        let height_mid_m = height_m.inflate(self.heave_m).mid();
        place.terms.push((Variable::MarkerHeight(marker), height_mid_m, column(DOT_HEIGHT)));
        let at_m = POSITION.map(|parameter| self.parameters[parameter].mid());
        let position = [0, 1].map(Constant::CeilingPosition);
        place.mounted(position, self.position_m, self.yaw_rad, (at_m, POSITION.map(column)));
        place
    }

    fn dot_m(&self, parameters: &[Interval; N_PARAMETERS]) -> Option<[Number; 2]> {
        let number = |index: usize| Number::parameter(index, parameters[index]);
        let x = (number(PIXEL[0]) - number(CENTRE[0])) / number(FOCAL[0]);
        let y = (number(PIXEL[1]) - number(CENTRE[1])) / number(FOCAL[1]);
        let [x, y] = distortion::unbent_models(self.distortion, [x, y])?;
        let upright = [-y, x, Number::constant(Interval::ONE)];
        let leaning = self.lean.map(|row| {
            let products = [0, 1, 2].map(|k| Number::constant(row[k]) * upright[k]);
            products[0] + products[1] + products[2]
        });
        let mounted = tilted(leaning, MOUNT_TILT.map(number));
        let [cos, sin] = self.yaw.map(Number::constant);
        let turned = [mounted[0] * cos - mounted[1] * sin, mounted[0] * sin + mounted[1] * cos, mounted[2]];
        let body = BODY_TILT.map(number);
        let ray = tilted(turned, body);
        let centre = tilted([number(POSITION[0]), number(POSITION[1]), number(CAMERA_HEIGHT)], body);
        if ray[2].value.lo() < 0.05 {
            return None;
        }
        let length = (number(DOT_HEIGHT) - centre[2]) / ray[2];
        Some([centre[0] + ray[0] * length, centre[1] + ray[1] * length])
    }
}

/// Rotation matrix that leans the upright axis by the given angles towards forward and towards left: rotation vector (−left, forward, 0).
fn lean_matrix([forward, left]: [f64; 2]) -> [[Interval; 3]; 3] {
    let vector = [Interval::point(-left), Interval::point(forward), Interval::ZERO];
    let angle = (vector[0].sqr() + vector[1].sqr()).sqrt();
    let identity =
        [0, 1, 2].map(|row| [0, 1, 2].map(|column| if row == column { Interval::ONE } else { Interval::ZERO }));
    if angle.hi() < 1e-300 {
        return identity;
    }
    // Formula of Rodrigues: I + sin α [n] + (1 − cos α) [n]².
    let [x, y, z] = vector.map(|component| component / angle);
    let cross = [[Interval::ZERO, -z, y], [z, Interval::ZERO, -x], [-y, x, Interval::ZERO]];
    let (sin, versine) = (angle.sin(), Interval::ONE - angle.cos());
    [0, 1, 2].map(|row| {
        [0, 1, 2].map(|column| {
            let square = (0..3).fold(Interval::ZERO, |sum, k| sum + cross[row][k] * cross[k][column]);
            identity[row][column] + sin * cross[row][column] + versine * square
        })
    })
}

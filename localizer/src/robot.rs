//! The robot model that the localizer is given: nominal dimensions as intervals, and the declared bounds of the robot's errors.
//!
//! Frame `robot`: x forward, y left, z up; its origin is the middle of the wheel axle, projected on the floor at rest.

mod steering;

use interval::Interval;

pub use steering::SteeringModel;

/// Everything that the localizer is given about the robot. The true values, drawn at random for a seed, stay with the simulator.
#[derive(Clone, Debug, PartialEq)]
pub struct RobotModel {
    /// Model of both drive wheels and their encoders.
    pub wheels: WheelModel,
    /// Limits that no motion of the robot exceeds, whatever the wheels read.
    pub reach: Reach,
    /// Bounds on how far the body departs from its posture at rest.
    pub body: BodyModel,
    /// The camera that looks straight down at the floor, if there is one.
    pub floor_camera: Option<FloorCameraModel>,
    /// The camera that looks ahead, if there is one.
    pub forward_camera: Option<ForwardCameraModel>,
    /// The gyroscope about the vertical, if there is one.
    pub gyro: Option<GyroModel>,
    /// The optical flow sensor, if there is one.
    pub flow: Option<FlowModel>,
    /// The camera that looks up at the ceiling's markers, if there is one.
    pub ceiling_camera: Option<CeilingCameraModel>,
    /// The range camera (a stereo or structured-light camera) that measures coded landmarks, if there is one.
    pub range_camera: Option<RangeCameraModel>,
    /// The steering of a car with a steering encoder, if there is one.
    pub steering: Option<SteeringModel>,
}

impl RobotModel {
    /// A robot that has nothing but its drive, on a level floor and without any extent. Devices are added as fields.
    pub fn new(wheels: WheelModel, reach: Reach) -> RobotModel {
        RobotModel {
            wheels,
            reach,
            body: BodyModel { tilt_rad: 0.0, heave_m: 0.0, clearance_m: 0.0 },
            floor_camera: None,
            forward_camera: None,
            gyro: None,
            flow: None,
            ceiling_camera: None,
            range_camera: None,
            steering: None,
        }
    }
}

/// Drive wheels and encoders, with bounds on the displacement by slip.
#[derive(Clone, Debug, PartialEq)]
pub struct WheelModel {
    /// Rolling radius of the left and of the right wheel.
    pub radius_m: [Interval; 2],
    /// Distance between the contact points of the two drive wheels.
    pub track_m: Interval,
    /// Encoder ticks in one turn of a wheel.
    pub ticks_per_turn: f64,
    /// Slip ratio of each wheel: over any time window of `slip_window_s`, `|true travel − rolled| ≤ slip_ratio·|rolled| + slip_floor_m`, where
    /// `rolled` is the distance that the wheel rolls and `true travel` that of its contact point.
    pub slip_ratio: f64,
    /// Additive part of the bound on a wheel's slip, in metres. Over a longer span it counts once for every window of `slip_window_s` that is begun.
    pub slip_floor_m: f64,
    /// Side-slip ratio: over any time window of `slip_window_s`, `|lateral travel of the axle's middle| ≤ side_slip_ratio·|rolled| +
    /// side_slip_floor_m`, where `rolled` is the mean of the distances that both wheels roll.
    pub side_slip_ratio: f64,
    /// Additive part of the bound on the axle's side slip, in metres. Over a longer span it counts once for every window of `slip_window_s` that is
    /// begun.
    pub side_slip_floor_m: f64,
    /// Length of the time window over which the bounds on slip and on side slip hold.
    pub slip_window_s: f64,
}

/// Law of the error of odometry: over any time T in which the odometry counts the way L, its error is at most `floor_m + share·L + m_per_s·T`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ErrorLaw {
    /// Part of the error that does not grow.
    pub floor_m: f64,
    /// Part of the error that grows with the way, as a share of it.
    pub share: f64,
    /// Part of the error that grows with the time.
    pub m_per_s: f64,
}

/// Length that stands for one encoder tick where odometry comes in metres: it is as nothing beside any odometry's error.
pub(crate) const ODOMETRY_TICK_M: f64 = 1e-6;
/// Shortest and longest slip window of odometry in metres. Shorter windows make the localizer store more poses; longer ones make it remember more
/// readings.
const ODOMETRY_WINDOW_S: [f64; 2] = [0.5, 5.0];

impl WheelModel {
    /// Wheels that stand for the odometry of a differential drive from elsewhere, whose readings are made by
    /// [`Reading::odometry`](crate::Reading::odometry). `along` is the law of each wheel's travel, `aside` that of the sideways travel of the axle's
    /// middle, in which L is the mean of both wheels' ways.
    pub fn of_odometry(track_m: Interval, along: ErrorLaw, aside: ErrorLaw) -> WheelModel {
        // A slip bound has a floor for every window that is begun. With a + c·W for each window W, n windows give n·a + n·c·W ≥ a + c·T. A window of
        // a/c makes both parts equal.
        let [shortest_s, longest_s] = ODOMETRY_WINDOW_S;
        let balanced_s = along.floor_m / along.m_per_s;
        let slip_window_s = if balanced_s.is_nan() { longest_s } else { balanced_s.clamp(shortest_s, longest_s) };
        let floor_m = |law: ErrorLaw| law.floor_m + law.m_per_s * slip_window_s;
        // A turn of a wheel of this radius by one tick is a way of the length that stands for a tick.
        let radius_m = Interval::point(ODOMETRY_TICK_M) / (Interval::PI * 2.0);
        WheelModel {
            radius_m: [radius_m; 2],
            track_m,
            ticks_per_turn: 1.0,
            slip_ratio: along.share,
            slip_floor_m: floor_m(along),
            side_slip_ratio: aside.share,
            side_slip_floor_m: floor_m(aside),
            slip_window_s,
        }
    }
}

/// Physical limits of any motion of the robot, pushes included. They are declared generously, so that they hold even when the wheel readings are
/// wrong.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Reach {
    /// Greatest speed of the axle's middle over the floor.
    pub speed_m_per_s: f64,
    /// Greatest turn rate of the robot.
    pub turn_rate_rad_per_s: f64,
    /// Greatest acceleration of a wheel's travel while the wheel bounds hold.
    pub acceleration_m_per_s2: f64,
}

/// Bounds on the body's posture over the floor, and the body's radius.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BodyModel {
    /// Greatest angle between the body's vertical and the floor's (bound `body.tilt`).
    pub tilt_rad: f64,
    /// Greatest rise or sinking of the robot origin from its height at rest (bound `body.heave`).
    pub heave_m: f64,
    /// Radius of the body about the robot origin: the origin keeps at least this distance from every wall.
    pub clearance_m: f64,
}

impl BodyModel {
    /// Greatest distance forward or left, seen from above, by which the body's lean may displace a point on the robot: a lean by φ shifts a point at
    /// the height h by up to h·sin φ to any side, and foreshortens its lever arm b by up to |b|·(1 − cos φ).
    pub fn most_leant_m(&self, position_m: [Interval; 2], height_m: f64) -> Interval {
        let lean = Interval::new(0.0, self.tilt_rad);
        let [forward, left] = position_m;
        let lever = Interval::point(forward.magnitude()) + Interval::point(left.magnitude());
        Interval::point(height_m) * lean.sin() + lever * (Interval::point(1.0) - lean.cos())
    }
}

/// Greatest length of the Cayley vector tan(α/2)·axis of a tilt by an angle α up to the given one.
pub fn cayley_radius(tilt_rad: f64) -> f64 {
    (Interval::point(tilt_rad) * 0.5).tan().hi()
}

/// Model of the camera that looks straight down at the floor. Image up is robot forward, image right is robot right.
#[derive(Clone, Debug, PartialEq)]
pub struct FloorCameraModel {
    /// Image width in pixels.
    pub width_px: u32,
    /// Image height in pixels.
    pub height_px: u32,
    /// Image scale: focal length divided by height, in pixels per metre of floor at rest, in the image of a pinhole camera (bound
    /// `floor_camera.scale`).
    pub pixels_per_m: Interval,
    /// Height of the floor camera's optical centre above the floor.
    pub height_m: f64,
    /// Coefficients k1, k2, p1, p2, k3 of Brown and Conrady's lens model for the floor camera as calibrated, for coordinates in focal lengths from
    /// the middle of the image.
    pub distortion: [f64; 5],
    /// Greatest distance between a point in the floor image and where the lens model puts it (bound `floor_camera.distortion`).
    pub distortion_px: f64,
    /// Time between the starts of the exposures of one row of the floor image and the next; 0 for a global shutter. An image's stamp is mid-exposure
    /// of row (height − 1)/2.
    pub row_time_s: f64,
    /// Position of the floor camera's optical centre in the robot frame: forward and left (bound `floor_camera.position`).
    pub position_m: [Interval; 2],
    /// Rotation of the floor image about the vertical, counter-clockwise seen from above (bound `floor_camera.yaw`).
    pub yaw_rad: Interval,
    /// Greatest angle between the floor camera's optical axis and the body's vertical (bound `floor_camera.tilt`).
    pub tilt_rad: f64,
    /// Greatest error of a floor image's stamp (bound `floor_camera.stamp`).
    pub stamp_error_s: f64,
    /// Greatest number of detected lines in one floor image that may be wrong, such as lines that are no joints between tiles, `floor_tiles.q_items`.
    pub q_items: usize,
}

/// Model of a camera that looks up at the ceiling, with a ring of infrared lamps around its lens.
///
/// With yaw and lean 0, image up is robot forward and image right is robot left (the camera looks up). `body_from_camera` is the rotation by the
/// yaw about the vertical, times the rotation by the unknown tilt error, times the rotation by the lean, times the orientation at yaw and lean 0.
#[derive(Clone, Debug, PartialEq)]
pub struct CeilingCameraModel {
    /// Image width in pixels.
    pub width_px: u32,
    /// Image height in pixels.
    pub height_px: u32,
    /// Focal lengths of the ceiling camera along u and v (bound `ceiling_camera.focal`).
    pub focal_px: [Interval; 2],
    /// Principal point of the ceiling camera (bound `ceiling_camera.centre`).
    pub centre_px: [Interval; 2],
    /// Coefficients k1, k2, p1, p2, k3 of Brown's lens model for the ceiling camera, for coordinates in focal lengths.
    pub distortion: [f64; 5],
    /// Greatest distance between a point in the ceiling image and where the lens model puts it (bound `ceiling_camera.distortion`).
    pub distortion_px: f64,
    /// Height of the ceiling camera's optical centre above the floor at rest (bound `ceiling_camera.height`).
    pub height_m: Interval,
    /// Position of the ceiling camera's optical centre in the robot frame: forward and left (bound `ceiling_camera.position`).
    pub position_m: [Interval; 2],
    /// Rotation of the ceiling image about the vertical, counter-clockwise seen from above (bound `ceiling_camera.yaw`).
    pub yaw_rad: Interval,
    /// Nominal angles by which the ceiling camera's optical axis leans from the body's vertical, towards forward and towards left, for a camera with
    /// yaw 0. They are the components of one rotation about a horizontal axis.
    pub lean_rad: [f64; 2],
    /// Greatest angle between the ceiling camera's optical axis and its nominal direction (bound `ceiling_camera.tilt`).
    pub tilt_rad: f64,
    /// Greatest error of a ceiling image's stamp (bound `ceiling_camera.stamp`).
    pub stamp_error_s: f64,
    /// Least number of photoelectrons in one step of grey level of the ceiling camera; it determines the noise of bright pixels.
    pub electrons_per_grey: f64,
    /// Time from the start of one row's exposure to the start of the next row's; 0 for a global shutter. The stamp is that of the middle row.
    pub row_time_s: f64,
    /// Greatest number of markers in one ceiling image that may differ from the map, `ceiling_markers.q_items`.
    pub q_items: usize,
}

/// Model of a gyroscope about the vertical: `rate read = scale·true rate + bias + noise`, each within its bound.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GyroModel {
    /// Bounds of the gyroscope's bias at any time (bound `gyro.bias`).
    pub bias_rad_per_s: Interval,
    /// Bounds of the gyroscope's scale factor, which is constant over a run (bound `gyro.scale`).
    pub scale: Interval,
    /// Greatest noise of one gyroscope reading, quantisation included (bound `gyro.noise`).
    pub noise_rad_per_s: f64,
    /// Constant part of the bound on accumulated angle error (bound `gyro.angle`). Over any span, the gyroscope's noise and the departures of its
    /// bias from one constant bias add up to at most `angle_floor_rad + angle_rad_per_s·span`. Infinite where only single readings are bounded.
    pub angle_floor_rad: f64,
    /// Part of the bound on the gyroscope's accumulated angle error that grows with the span, per second. Infinite where only single readings are
    /// bounded.
    pub angle_rad_per_s: f64,
    /// Greatest change of the gyroscope's bias per time (bound `gyro.wander`); 0 for a constant bias.
    pub bias_wander_rad_per_s2: f64,
    /// Length of the span that a gyroscope reading averages over; the span ends at the reading's stamp.
    pub period_s: f64,
}

impl GyroModel {
    /// Whether the bound `gyro.angle` on the accumulated angle error is declared.
    pub fn bounds_angle(&self) -> bool {
        self.angle_floor_rad.is_finite()
    }

    /// Whether the mean bias changes from one span of time to the next by an amount of which only its greatest change per time (bound `gyro.wander`)
    /// is known.
    pub fn drifts_from_way_to_way(&self) -> bool {
        self.bias_wander_rad_per_s2 > 0.0 && !self.bounds_angle()
    }
}

/// Model of a range camera, a stereo or structured-light camera that measures landmarks by the columns at which its two views see them.
///
/// Frame `sensor`: x right, z forward, origin at the optical centre of the first view. A point at (x, z) has the columns `left = centre + f·x/z` and
/// `right = centre + f·(x − b)/z` (Fig. 2 of paper 3, Mustafa et al., CSCS 2015), with focal length f and baseline b; each is rounded to a multiple
/// of its view's step.
#[derive(Clone, Debug, PartialEq)]
pub struct RangeCameraModel {
    /// Focal length of the range camera (bound `range_camera.focal`).
    pub focal_px: Interval,
    /// Distance between the optical centres of the range camera's two views (bound `range_camera.baseline`).
    pub baseline_m: Interval,
    /// Column at which the optical axis of either view of the range camera meets its image.
    pub centre_px: f64,
    /// Twice the greatest error of a column measured by the range camera, for the first and for the second view (bound `range_camera.columns`).
    /// Without noise these are the steps to which columns are rounded.
    pub step_px: [f64; 2],
    /// Position of the first view's optical centre in the robot frame: forward and left (bound `range_camera.position`).
    pub position_m: [Interval; 2],
    /// Height of the range camera's optical centres above the floor.
    pub height_m: f64,
    /// Direction of the range camera's optical axis from robot forward, counter-clockwise (bound `range_camera.yaw`).
    pub yaw_rad: Interval,
    /// Greatest angle between the range camera's vertical and the body's (bound `range_camera.tilt`).
    pub tilt_rad: f64,
    /// Greatest difference in height between the range camera and a landmark (bound `range_camera.height_span`).
    pub height_span_m: f64,
    /// Greatest error of the stamp of a range reading (bound `range_camera.stamp`).
    pub stamp_error_s: f64,
    /// Time from the measurement of a range reading to its delivery (bound `range_camera.latency`).
    pub latency_s: Interval,
    /// Least time between two range readings.
    pub period_s: f64,
    /// Greatest number of landmarks in one range reading that may be taken for another landmark (wrong correspondences), `range_landmarks.q_items`.
    pub q_items: usize,
    /// Least number of right correspondences between two wrong ones that name the same landmark, in the order of measuring (bound
    /// `range_landmarks.wrong_spacing`). A correspondence says which landmark a seen object is; the number matters only where wrong ones are
    /// possible.
    pub wrong_spacing: usize,
}

/// Model of a camera that looks ahead and is tilted up about its own u axis, which is level and points to the robot's right.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ForwardCameraModel {
    /// Both focal lengths of the forward camera (bound `forward_camera.focal`).
    pub focal_px: Interval,
    /// Image point where the forward camera's optical axis meets the image (bound `forward_camera.principal_point`).
    pub principal_point_px: [Interval; 2],
    /// Coefficients k1, k2, p1, p2, k3 of Brown and Conrady's lens model for the forward camera, as calibrated.
    pub distortion: [f64; 5],
    /// Greatest distance between a point in the forward image and where the lens model puts it (bound `forward_camera.distortion`).
    pub distortion_px: f64,
    /// Nominal upward tilt of the forward camera's optical axis.
    pub tilt_up_rad: f64,
    /// Direction of the forward camera's optical axis from robot forward, counter-clockwise (bound `forward_camera.yaw`).
    pub yaw_rad: Interval,
    /// Greatest turn of the forward camera about any level axis from its nominal attitude (bound `forward_camera.tilt`).
    pub tilt_error_rad: f64,
    /// Greatest error of a forward image's stamp (bound `forward_camera.stamp`).
    pub stamp_error_s: f64,
    /// Position of the optical centre in the robot frame: forward and left (bound `forward_camera.position`).
    pub position_m: [Interval; 2],
    /// Height of the optical centre above the floor (bound `forward_camera.height`).
    pub height_m: Interval,
    /// Number of rows of an image.
    pub height_px: u32,
    /// Time from the exposure of one row to that of the next; 0 for a global shutter. The stamp is the middle of the middle row's exposure.
    pub row_time_s: f64,
}

/// Model of a two-axis optical flow sensor that looks at the floor.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FlowModel {
    /// Position of the floor patch that the flow sensor sees, in the robot frame: forward and left (bound `flow.position`).
    pub position_m: [Interval; 2],
    /// Travel per count of the flow sensor at its mounted height, constant over a run (bound `flow.calibration`).
    pub metres_per_count: Interval,
    /// Greatest share, below 1, by which the flow sensor's counts per metre differ, at times upwards and at times downwards, from those at the
    /// mounted height (bound `flow.scale`).
    pub scale_change: f64,
    /// Angle of the flow sensor's forward axis from the robot's, counter-clockwise (bound `flow.yaw`).
    pub yaw_rad: Interval,
    /// Width, in counts, of an interval that contains the counting error along one axis of the flow sensor at all stamps: 1 where the sensor reports
    /// whole counts.
    pub quantisation_counts: f64,
    /// Greatest path that the flow sensor travels forth and back within one period, beyond the distance between the period's end points (bound
    /// `flow.back_and_forth`).
    pub back_and_forth_m: f64,
    /// Time between two readings of the flow sensor.
    pub period_s: f64,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_slip_bounds_of_odometry_hold_all_that_its_law_allows() {
        let none = ErrorLaw { floor_m: 0.0, share: 0.0, m_per_s: 0.0 };
        let laws = [(0.01, 0.001), (0.0, 0.01), (0.02, 0.0), (0.0, 0.0), (1.0, 1e-6), (1e-6, 1.0)];
        for (floor_m, m_per_s) in laws {
            let law = ErrorLaw { floor_m, share: 0.05, m_per_s };
            let wheels = WheelModel::of_odometry(Interval::point(0.4), law, none);
            for step in 1..1000 {
                let time_s = 0.037 * f64::from(step);
                // Over a longer span the floor counts once for every window that is begun.
                let bound_m = wheels.slip_floor_m * (time_s / wheels.slip_window_s).ceil();
                assert!(bound_m >= floor_m + m_per_s * time_s - 1e-12, "{law:?} over {time_s} s: {bound_m} m");
            }
            assert_eq!((wheels.slip_ratio, wheels.side_slip_floor_m), (0.05, 0.0));
            let tick_m = wheels.metres_per_tick(0);
            assert!(tick_m.contains(ODOMETRY_TICK_M) && tick_m.width() < 1e-20, "{tick_m}");
        }
    }
}

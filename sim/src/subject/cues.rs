//! What the classical estimators measure: the readings of every sensor as numbers with standard deviations.
//!
//! They are given the same readings, the same map and the same declared bounds as the interval localizer, and see the images through the same vision.
//! The standard deviation of a quantity is a third of its declared bound, as for a Gaussian that keeps within the bound 997 times in a thousand.
//!
//! Errors of a mount or a calibration that stay the same for a whole run are kept apart from those that differ from reading to reading: see
//! [`Mount`].

mod ceiling;
mod compared;
mod floor;
mod floor_plan;
mod motion;
mod position;
mod range;
mod scan;
mod walls;

use localizer::{
    Map, Reading, RobotModel,
    methods::{gnss_positions, wall_ranges},
    reading::Camera,
};
use nalgebra::{Matrix2, Matrix3, Vector2};

use crate::scene::Scene;

use ceiling::Ceiling;
use floor::Floor;
use position::Receiver;
use range::Range;
use scan::Scans;
use walls::Walls;

pub use compared::{Compared, Cue, CueReader};
pub(crate) use floor::Joint;
pub(crate) use floor_plan::FloorPlan;
pub(crate) use motion::{Step, Steps};
pub(crate) use scan::Line;
pub(crate) use walls::{Edge, heading_of};

/// Share of a declared bound that is taken for a standard deviation: the bound is three of them.
pub(crate) const SIGMAS_OF_BOUND: f64 = 1.0 / 3.0;

/// Way in metres over which errors last that the floor makes, namely slip and the error of the flow sensor that the surface makes: after it, 1/e of
/// what was known of them is left. A robot crosses doorways, carpets' edges and turns about once in a metre.
pub(crate) const LASTS_M: f64 = 1.0;

/// Way, and turn, that the robot must have gone since the last reading of a camera or scanner that was used for another to be used: a picture from
/// the same place has the same errors, so that a filter that takes them for new ones becomes overconfident at rest. Both are those of the method
/// `wall_directions`; AMCL has the same rule with greater values.
const NEW_PLACE_M: f64 = 0.03;
const NEW_PLACE_RAD: f64 = 0.05;

/// Number of readings that are used within the way over which errors last, where a robot drives straight ahead.
pub(crate) const READINGS_WHILE_LASTING: f64 = LASTS_M / NEW_PLACE_M;

/// Errors of a device's mount that last: where the robot would be and how turned if the device were mounted as stated, relative to where it is.
/// Forward and left in metres, counter-clockwise in radians, all 0 for a mount as stated.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Mount {
    /// Standard deviations of the three errors; 0 where there is none.
    pub(crate) sigma: [f64; 3],
}

/// A device whose mount has lasting errors.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Mounted {
    FloorCamera,
    CeilingCamera,
    ForwardCamera,
    RangeCamera,
    Antenna,
    Scanner,
}

impl Mounted {
    pub(crate) const ALL: [Mounted; 6] = [
        Mounted::FloorCamera,
        Mounted::CeilingCamera,
        Mounted::ForwardCamera,
        Mounted::RangeCamera,
        Mounted::Antenna,
        Mounted::Scanner,
    ];

    /// The device that a reading is of; `None` for the motion sensors.
    fn of(reading: &Reading) -> Option<Mounted> {
        match reading {
            Reading::Camera { camera: Camera::Floor, .. } => Some(Mounted::FloorCamera),
            Reading::Camera { camera: Camera::Ceiling, .. } => Some(Mounted::CeilingCamera),
            Reading::Camera { camera: Camera::Forward, .. } => Some(Mounted::ForwardCamera),
            Reading::Range { .. } => Some(Mounted::RangeCamera),
            Reading::Other { device, .. } if device == gnss_positions::DEVICE => Some(Mounted::Antenna),
            Reading::Other { device, .. } if device == wall_ranges::DEVICE => Some(Mounted::Scanner),
            Reading::Wheels { .. } | Reading::Gyro { .. } | Reading::Flow { .. } | Reading::Other { .. } => None,
        }
    }
}

/// What one reading measures. Poses and places in the robot frame are by the nominal mount.
#[derive(Clone, Debug)]
pub(crate) enum Seen {
    /// Pose in the world with its covariance, from the dots of all markers in a picture of the ceiling.
    Pose { pose: [f64; 3], covariance: Matrix3<f64> },
    /// Joints of the tiled floor.
    Joints(Vec<Joint>),
    /// Level edges, which run along a direction of the building or are clutter.
    Edges(Vec<Edge>),
    /// Straight parts of a scan, the longest first.
    Lines(Vec<Line>),
    /// Coded landmarks that a range camera sees.
    Landmarks(Vec<Landmark>),
    /// Position of a point of the robot in the world: where it is in the robot frame, where in the world, standard deviation of either coordinate.
    Position { in_robot_m: [f64; 2], in_world_m: [f64; 2], sigma_m: f64 },
}

/// A coded landmark in the robot frame.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Landmark {
    pub(crate) code: u32,
    /// Place by the nominal mount and scale.
    pub(crate) in_robot_m: Vector2<f64>,
    /// Vector from the camera to it: where the camera's distances are a share too long, the place is off by this share of it.
    pub(crate) ray_m: Vector2<f64>,
    /// Covariance of the errors that differ from reading to reading.
    pub(crate) covariance: Matrix2<f64>,
}

/// Makes measurements of readings.
pub(crate) struct Cues {
    steps: Steps,
    floor: Option<Floor>,
    ceiling: Option<Ceiling>,
    walls: Option<Walls>,
    range: Option<Range>,
    receiver: Option<Receiver>,
    scans: Option<(Scans, FloorPlan)>,
    /// For each device the way that the robot had gone and turned when a reading of it was used last.
    used_at: [Option<[f64; 2]>; Mounted::ALL.len()],
}

/// What a reading gives a filter.
pub(crate) enum Told {
    /// A step of the robot.
    Step(Step),
    /// A measurement at a stamp, by a device with a mount.
    Seen(f64, Mounted, Seen),
}

impl Cues {
    /// The cues of a scene: those that the scene's localizer uses.
    pub(crate) fn new(scene: &Scene, map: &Map, robot: &RobotModel) -> Cues {
        Cues {
            steps: Steps::new(robot),
            floor: Floor::new(map, robot),
            ceiling: Ceiling::new(map, robot),
            walls: Walls::new(map, robot, scene),
            range: Range::new(robot),
            receiver: Receiver::new(scene, robot),
            scans: Scans::new(robot, scene).zip(FloorPlan::new(map)),
            used_at: Default::default(),
        }
    }

    /// Begins a drive anew.
    pub(crate) fn restart(&mut self, robot: &RobotModel) {
        self.steps = Steps::new(robot);
        self.used_at = Default::default();
    }

    /// Takes in a reading. Images are looked at once, here.
    pub(crate) fn take(&mut self, reading: &Reading) -> Option<Told> {
        let twist = self.steps.twist();
        if let Some(step) = self.steps.take(reading) {
            return Some(Told::Step(step));
        }
        let mounted = Mounted::of(reading)?;
        let (used_at, here) = (self.used_at[mounted as usize], self.steps.gone());
        let is_new = used_at.is_none_or(|there| {
            here[0] - there[0] >= NEW_PLACE_M || here[1] - there[1] >= NEW_PLACE_RAD || mounted == Mounted::Antenna
        });
        if !is_new {
            return None;
        }
        let seen = match mounted {
            Mounted::FloorCamera => self.floor.as_ref()?.look(reading, &twist),
            Mounted::CeilingCamera => self.ceiling.as_ref()?.look(reading, &twist),
            Mounted::ForwardCamera => self.walls.as_ref()?.look(reading, &twist),
            Mounted::RangeCamera => self.range.as_ref()?.look(reading, &twist),
            Mounted::Antenna => self.receiver.as_ref()?.look(reading, &twist),
            Mounted::Scanner => self.scans.as_ref()?.0.look(reading, &twist),
        }?;
        self.used_at[mounted as usize] = Some(here);
        Some(Told::Seen(reading.measured_s(), mounted, seen))
    }

    /// Mean velocity by the wheels at present.
    pub(crate) fn twist(&self) -> localizer::motion::Twist {
        self.steps.twist()
    }

    /// The errors of a device's mount that last; `None` for a device that measures nothing.
    pub(crate) fn mount(&self, mounted: Mounted) -> Option<Mount> {
        match mounted {
            Mounted::FloorCamera => self.floor.as_ref().map(Floor::mount),
            Mounted::CeilingCamera => self.ceiling.as_ref().map(Ceiling::mount),
            Mounted::ForwardCamera => self.walls.as_ref().map(Walls::mount),
            Mounted::RangeCamera => self.range.as_ref().map(Range::mount),
            Mounted::Antenna => self.receiver.as_ref().map(Receiver::mount),
            Mounted::Scanner => self.scans.as_ref().map(|(scans, _)| scans.mount()),
        }
    }

    /// Standard deviation of the share by which all distances of the range camera are wrong in the same way; `None` without one.
    pub(crate) fn range_scale_sigma(&self) -> Option<f64> {
        self.range.as_ref().map(Range::scale_sigma)
    }

    /// Directions of the building's walls, modulo quarter turns.
    pub(crate) fn wall_directions_rad(&self) -> &[f64] {
        self.walls.as_ref().map_or(&[], |walls| &walls.directions_rad)
    }

    /// The walls of the map, where scans are compared with them.
    pub(crate) fn floor_plan(&self) -> Option<&FloorPlan> {
        self.scans.as_ref().map(|(_, plan)| plan)
    }

    /// The grid of tile joints, where joints are seen.
    pub(crate) fn tiles(&self) -> Option<&localizer::map::TileGrid> {
        self.floor.as_ref().map(|floor| &floor.grid)
    }
}

/// Standard deviation of the robot's way, in metres along any axis and in radians, within the error of a stamp.
fn stray(twist: &localizer::motion::Twist, stamp_error_s: f64) -> [f64; 2] {
    let sigma_s = stamp_error_s * SIGMAS_OF_BOUND;
    [twist.forward_m_per_s.abs() * sigma_s, twist.turn_rad_per_s.abs() * sigma_s]
}

/// Motion of the robot from an image's stamp to the exposure of a row, for a shutter with so much time from row to row and an image of so many rows:
/// forward, to the left, and turned.
fn since_stamp(twist: &localizer::motion::Twist, (row_time_s, n_rows): (f64, u32), row: f64) -> [f64; 3] {
    let after_s = (row - 0.5 * (f64::from(n_rows) - 1.0)) * row_time_s;
    let [ahead_m, turn_rad] = [twist.forward_m_per_s, twist.turn_rad_per_s].map(|speed| speed * after_s);
    [ahead_m, 0.5 * turn_rad * ahead_m, turn_rad]
}

/// The angle less the whole number of quarter turns nearest to it.
pub(crate) fn within_quarter(angle_rad: f64) -> f64 {
    let quarter_rad = std::f64::consts::FRAC_PI_2;
    angle_rad - quarter_rad * (angle_rad / quarter_rad).round()
}

/// A vector turned counter-clockwise.
pub(crate) fn turned([x, y]: [f64; 2], angle_rad: f64) -> [f64; 2] {
    let (sin, cos) = angle_rad.sin_cos();
    [cos * x - sin * y, sin * x + cos * y]
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
pub(crate) mod scan_trial;
#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests;

//! Sensor readings. Every reading carries the time at which it was measured and the time at which it reached the localizer.

use std::{any::Any, sync::Arc};

use image::GrayImage;

use crate::robot::ODOMETRY_TICK_M;

/// One reading of one sensor.
#[derive(Clone, Debug)]
pub enum Reading {
    /// Encoder counts of both wheels since the start.
    Wheels {
        /// Time at which the counters of both wheel encoders were latched for reading.
        measured_s: f64,
        /// Time at which the reading reaches the localizer.
        arrived_s: f64,
        /// Cumulative ticks of the left and of the right wheel.
        ticks: [i64; 2],
    },
    /// One image of one camera.
    Camera {
        /// Middle of the exposure, by the camera's own stamp.
        measured_s: f64,
        /// Time at which the image reaches the localizer.
        arrived_s: f64,
        /// Camera that took the image.
        camera: Camera,
        /// Length of the exposure.
        exposure_s: f64,
        /// Grey levels as the sensor gave them, row-major; (0, 0) is the centre of the first pixel. Copies of the reading share them.
        image: Arc<GrayImage>,
    },
    /// Turn rate of the body by the gyroscope, averaged since the gyroscope's reading before.
    Gyro {
        /// End of the time span over which the turn rate is averaged.
        measured_s: f64,
        /// Time at which the reading reaches the localizer.
        arrived_s: f64,
        /// Turn rate, counter-clockwise positive.
        rate_rad_per_s: f64,
    },
    /// Travel over the floor's surface since the start, as an optical flow sensor counts it.
    Flow {
        /// End of the latest period in which the sensor counted.
        measured_s: f64,
        /// Time at which the reading reaches the localizer.
        arrived_s: f64,
        /// Cumulative counts along the sensor's forward axis and left axis.
        counts: [i64; 2],
        /// Number of periods since the start in which the flow sensor found nothing to follow: the counts do not contain the travel of these
        /// periods.
        blind_periods: u64,
    },
    /// Coded landmarks as a range camera (a stereo or structured-light camera) measured them.
    Range {
        /// Middle of the exposure, by the range camera's own stamp.
        measured_s: f64,
        /// Time at which the reading reaches the localizer.
        arrived_s: f64,
        /// Landmarks that were in the range camera's view; their order has no meaning.
        sightings: Vec<Sighting>,
    },
    /// Reading of a device of any other kind: numbers whose meaning is known to the device and to the methods that read it.
    Other {
        /// Time of the measurement, by the device's own stamp.
        measured_s: f64,
        /// Time at which the reading reaches the localizer.
        arrived_s: f64,
        /// The device's name, such as `gnss`.
        device: String,
        /// Measured numbers in the device's own order and units.
        numbers: Vec<f64>,
    },
}

/// What one reading showed a method, as a value of a type of the method's own.
pub type Shown = Arc<dyn Any + Send + Sync>;

/// Columns at which the two views of a range camera (a stereo or structured-light camera) see one coded landmark.
///
/// The second view belongs to another camera or to a projector; it stands one baseline to the right of the first view and is parallel to it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sighting {
    /// Landmark that the range camera takes the seen object for; if this correspondence is wrong, the object is another landmark.
    pub landmark: LandmarkId,
    /// Column in the first (left) view, a multiple of the step declared in the range camera's model.
    pub left_px: f64,
    /// Column in the second (right) view, a multiple of the step declared in the range camera's model.
    pub right_px: f64,
}

/// Code that identifies a landmark.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct LandmarkId(pub u32);

/// The robot's cameras.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Camera {
    /// The camera that looks straight down at the floor.
    Floor,
    /// The camera that looks ahead, tilted up.
    Forward,
    /// The camera that looks up at the ceiling, in the infrared.
    Ceiling,
}

impl Camera {
    /// All cameras of the robot.
    pub const ALL: [Camera; 3] = [Camera::Floor, Camera::Forward, Camera::Ceiling];

    /// Name of the camera as a device, as in the names of its bounds.
    pub fn device(self) -> &'static str {
        match self {
            Camera::Floor => "floor_camera",
            Camera::Forward => "forward_camera",
            Camera::Ceiling => "ceiling_camera",
        }
    }

    /// Name of the camera in scenes, commands, files and topics.
    pub fn as_str(self) -> &'static str {
        match self {
            Camera::Floor => "floor",
            Camera::Forward => "forward",
            Camera::Ceiling => "ceiling",
        }
    }
}

impl Reading {
    /// A reading of odometry that gives the travel of the left and of the right wheel since the start in metres, for a robot whose wheels are
    /// [`WheelModel::of_odometry`](crate::robot::WheelModel::of_odometry). `None` for a travel that is not finite or longer than nine million
    /// kilometres.
    pub fn odometry(measured_s: f64, arrived_s: f64, travel_m: [f64; 2]) -> Option<Reading> {
        // Up to here a number of ticks is exact.
        let longest_m = ODOMETRY_TICK_M * (1_u64 << 53) as f64;
        let is_countable = travel_m.iter().all(|way_m| way_m.abs() <= longest_m);
        let ticks = travel_m.map(|way_m| (way_m / ODOMETRY_TICK_M).floor() as i64);
        is_countable.then_some(Reading::Wheels { measured_s, arrived_s, ticks })
    }

    /// Whether all numbers of the reading are finite.
    pub fn is_finite(&self) -> bool {
        let are_numbers_finite = match self {
            Reading::Wheels { .. } | Reading::Flow { .. } => true,
            Reading::Camera { exposure_s, .. } => exposure_s.is_finite(),
            Reading::Gyro { rate_rad_per_s, .. } => rate_rad_per_s.is_finite(),
            Reading::Range { sightings, .. } => {
                sightings.iter().all(|sighting| sighting.left_px.is_finite() && sighting.right_px.is_finite())
            }
            Reading::Other { numbers, .. } => numbers.iter().all(|number| number.is_finite()),
        };
        are_numbers_finite && self.measured_s().is_finite() && self.arrived_s().is_finite()
    }

    /// Time at which the reading was measured, by its stamp.
    pub fn measured_s(&self) -> f64 {
        match self {
            Reading::Wheels { measured_s, .. }
            | Reading::Camera { measured_s, .. }
            | Reading::Gyro { measured_s, .. }
            | Reading::Flow { measured_s, .. }
            | Reading::Range { measured_s, .. }
            | Reading::Other { measured_s, .. } => *measured_s,
        }
    }

    /// Time at which the reading reached the localizer.
    pub fn arrived_s(&self) -> f64 {
        match self {
            Reading::Wheels { arrived_s, .. }
            | Reading::Camera { arrived_s, .. }
            | Reading::Gyro { arrived_s, .. }
            | Reading::Flow { arrived_s, .. }
            | Reading::Range { arrived_s, .. }
            | Reading::Other { arrived_s, .. } => *arrived_s,
        }
    }

    /// Replaces the stamp of the reading, which says when it was measured.
    pub fn stamp_anew(&mut self, stamp_s: f64) {
        match self {
            Reading::Wheels { measured_s, .. }
            | Reading::Camera { measured_s, .. }
            | Reading::Gyro { measured_s, .. }
            | Reading::Flow { measured_s, .. }
            | Reading::Range { measured_s, .. }
            | Reading::Other { measured_s, .. } => *measured_s = stamp_s,
        }
    }

    /// Delays the reading's arrival at the localizer by the given time.
    pub fn delay(&mut self, by_s: f64) {
        match self {
            Reading::Wheels { arrived_s, .. }
            | Reading::Camera { arrived_s, .. }
            | Reading::Gyro { arrived_s, .. }
            | Reading::Flow { arrived_s, .. }
            | Reading::Range { arrived_s, .. }
            | Reading::Other { arrived_s, .. } => *arrived_s += by_s,
        }
    }
}

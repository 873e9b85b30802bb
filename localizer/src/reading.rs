//! What the robot senses. Every reading carries the time it speaks of and the time it reached the localizer.

use image::GrayImage;

/// One reading of one sensor.
#[derive(Clone, Debug)]
pub enum Reading {
    /// Encoder counts since the start, left and right.
    Wheels {
        /// When the counters were latched.
        measured_s: f64,
        /// When the localizer gets to know.
        arrived_s: f64,
        /// Cumulative ticks of the left and of the right wheel.
        ticks: [i64; 2],
    },
    /// One image of one camera.
    Camera {
        /// Middle of the exposure, by the camera's own stamp.
        measured_s: f64,
        /// When the localizer gets to know.
        arrived_s: f64,
        /// Which camera took it.
        camera: Camera,
        /// Length of the exposure.
        exposure_s: f64,
        /// Grey levels as the sensor gave them, row-major, (0, 0) the centre of the first pixel.
        image: GrayImage,
    },
    /// Turn rate of the body, averaged since the reading before.
    Gyro {
        /// End of the span averaged over.
        measured_s: f64,
        /// When the localizer gets to know.
        arrived_s: f64,
        /// Counter-clockwise.
        rate_rad_per_s: f64,
    },
    /// Travel over the floor's surface as an optical flow sensor counts it, since the start.
    Flow {
        /// End of the period in which the last of it was counted.
        measured_s: f64,
        /// When the localizer gets to know.
        arrived_s: f64,
        /// Cumulative counts along the sensor's forward and left axis.
        counts: [i64; 2],
        /// Number of periods so far in which it found nothing to follow: counts know nothing of the way in them.
        blind_periods: u64,
    },
    /// Coded landmarks as a range camera measured them.
    Range {
        /// Middle of the exposure, by the sensor's own stamp.
        measured_s: f64,
        /// When the localizer gets to know.
        arrived_s: f64,
        /// What was in view, in no order that means anything.
        sightings: Vec<Sighting>,
    },
    /// What any other device has read: numbers of which that device and the methods that read it know the meaning.
    Other {
        /// The time that they speak of, by the device's own stamp.
        measured_s: f64,
        /// When the localizer gets to know.
        arrived_s: f64,
        /// The device's name, such as `gnss`.
        device: String,
        /// In the device's own order and units.
        numbers: Vec<f64>,
    },
}

/// One coded landmark in the two views of a range camera.
///
/// The second view is another camera's or a projector's; it stands one baseline to the right of the first and looks the same way.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sighting {
    /// The landmark that it is taken for; a wrong correspondence is another one's.
    pub landmark: LandmarkId,
    /// Column in the first (left) view, a multiple of the model's step.
    pub left_px: f64,
    /// Column in the second (right) view, a multiple of the model's step.
    pub right_px: f64,
}

/// Code of a landmark.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct LandmarkId(pub u32);

/// The robot's cameras.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Camera {
    /// Looks straight down at the floor.
    Floor,
    /// Looks ahead, tilted up.
    Forward,
    /// Looks up at the ceiling, in the infrared.
    Ceiling,
}

impl Camera {
    /// All of them.
    pub const ALL: [Camera; 3] = [Camera::Floor, Camera::Forward, Camera::Ceiling];

    /// As scenes, commands, files and topics call it.
    pub fn as_str(self) -> &'static str {
        match self {
            Camera::Floor => "floor",
            Camera::Forward => "forward",
            Camera::Ceiling => "ceiling",
        }
    }
}

impl Reading {
    /// The time the reading speaks of.
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

    /// The time the reading reached the localizer.
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

    /// The reading says to speak of another time.
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

    /// The reading is on its way for longer.
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

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
}

/// The robot's cameras.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Camera {
    /// Looks straight down at the floor.
    Floor,
}

impl Reading {
    /// The time the reading speaks of.
    pub fn measured_s(&self) -> f64 {
        match self {
            Reading::Wheels { measured_s, .. } | Reading::Camera { measured_s, .. } => *measured_s,
        }
    }

    /// The time the reading reached the localizer.
    pub fn arrived_s(&self) -> f64 {
        match self {
            Reading::Wheels { arrived_s, .. } | Reading::Camera { arrived_s, .. } => *arrived_s,
        }
    }
}

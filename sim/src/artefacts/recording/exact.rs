//! Messages that carry the localizer's starts, readings and estimates to the last bit, for replays: encoding and decoding.

use std::sync::Arc;

use image::GrayImage;
use localizer::{
    Estimate, Reading, Status,
    reading::{Camera, LandmarkId, Sighting},
};

use super::cdr::{Fields, Message};

pub(crate) const START: &str = "/wherein/start";
pub(crate) const WHEELS: &str = "/wherein/wheels";
pub(crate) const IMAGE_STAMP: &str = "/wherein/image_stamp";
pub(crate) const GYRO: &str = "/wherein/gyro";
pub(crate) const FLOW: &str = "/wherein/flow";
pub(crate) const RANGE: &str = "/wherein/range";
pub(crate) const OTHER: &str = "/wherein/other";
pub(crate) const ESTIMATE: &str = "/wherein/estimate";

/// A start of the localizer: for a drive, or at a station (a pose at which the robot is put and stands still for one image).
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Start {
    /// Offset that is added to the times of the readings and estimates that follow the start, because the localizer's own time begins at 0 at every
    /// start.
    pub(crate) offset_s: f64,
    /// Index of the station (a pose at which the robot is put for one image) at which the localizer starts; `None` for a drive.
    pub(crate) station: Option<usize>,
}

/// An estimate as it was recorded.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct RecordedEstimate {
    pub(crate) time_s: f64,
    sound: bool,
    bounds: Vec<f64>,
}

/// A camera reading without its image.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ImageStamp {
    measured_s: f64,
    arrived_s: f64,
    exposure_s: f64,
    camera: Camera,
}

impl Start {
    pub(super) fn encode(self) -> Vec<u8> {
        // No scene has 2⁶³ stations, so that the cast is exact.
        let station = self.station.map_or(-1, |index| index as i64);
        Message::new().f64s(&[self.offset_s]).i64(station).finish()
    }

    pub(crate) fn decode(message: &[u8]) -> Option<Start> {
        let mut fields = Fields::of(message)?;
        Some(Start { offset_s: fields.f64()?, station: usize::try_from(fields.i64()?).ok() })
    }
}

impl RecordedEstimate {
    pub(crate) fn of(estimate: &Estimate) -> RecordedEstimate {
        let sides = estimate.pose.branches.iter().flat_map(|branch| branch.components());
        RecordedEstimate {
            time_s: estimate.time_s,
            sound: estimate.status == Status::Sound,
            bounds: sides.flat_map(|side| [side.lo(), side.hi()]).collect(),
        }
    }

    pub(crate) fn encode(&self) -> Vec<u8> {
        Message::new().f64s(&[self.time_s]).bool(self.sound).f64_sequence(&self.bounds).finish()
    }

    pub(crate) fn decode(message: &[u8]) -> Option<RecordedEstimate> {
        let mut fields = Fields::of(message)?;
        Some(RecordedEstimate { time_s: fields.f64()?, sound: fields.bool()?, bounds: fields.sequence(Fields::f64)? })
    }
}

/// The topic and the message of a reading. Of a camera reading this is the stamp; the image follows in a message of its own.
pub(crate) fn encode(reading: &Reading) -> (&'static str, Vec<u8>) {
    let message = Message::new().f64s(&[reading.measured_s(), reading.arrived_s()]);
    match reading {
        Reading::Wheels { ticks: [left, right], .. } => (WHEELS, message.i64(*left).i64(*right).finish()),
        Reading::Camera { exposure_s, camera, .. } => {
            (IMAGE_STAMP, message.f64s(&[*exposure_s]).text(camera.as_str()).finish())
        }
        Reading::Gyro { rate_rad_per_s, .. } => (GYRO, message.f64s(&[*rate_rad_per_s]).finish()),
        Reading::Flow { counts: [forward, left], blind_periods, .. } => {
            // No run has 2⁶³ periods, so that the cast is exact.
            (FLOW, message.i64(*forward).i64(*left).i64(*blind_periods as i64).finish())
        }
        Reading::Range { sightings, .. } => {
            let column = |value: fn(&Sighting) -> f64| -> Vec<f64> { sightings.iter().map(value).collect() };
            let message = message.length(sightings.len());
            let message = sightings.iter().fold(message, |message, sighting| message.u32(sighting.landmark.0));
            let message = message.f64_sequence(&column(|sighting| sighting.left_px));
            (RANGE, message.f64_sequence(&column(|sighting| sighting.right_px)).finish())
        }
        Reading::Other { device, numbers, .. } => (OTHER, message.text(device).f64_sequence(numbers).finish()),
    }
}

/// Decodes a reading other than an image; `None` when the topic is not one of readings or the message does not hold a reading.
pub(crate) fn decode(topic: &str, message: &[u8]) -> Option<Reading> {
    let mut fields = Fields::of(message)?;
    let (measured_s, arrived_s) = (fields.f64()?, fields.f64()?);
    match topic {
        WHEELS => Some(Reading::Wheels { measured_s, arrived_s, ticks: [fields.i64()?, fields.i64()?] }),
        GYRO => Some(Reading::Gyro { measured_s, arrived_s, rate_rad_per_s: fields.f64()? }),
        FLOW => Some(Reading::Flow {
            measured_s,
            arrived_s,
            counts: [fields.i64()?, fields.i64()?],
            blind_periods: u64::try_from(fields.i64()?).ok()?,
        }),
        RANGE => {
            let landmarks = fields.sequence(Fields::u32)?;
            let (left_px, right_px) = (fields.sequence(Fields::f64)?, fields.sequence(Fields::f64)?);
            if left_px.len() != landmarks.len() || right_px.len() != landmarks.len() {
                return None;
            }
            let columns = left_px.into_iter().zip(right_px);
            let sightings = landmarks.into_iter().zip(columns).map(|(landmark, (left_px, right_px))| Sighting {
                landmark: LandmarkId(landmark),
                left_px,
                right_px,
            });
            Some(Reading::Range { measured_s, arrived_s, sightings: sightings.collect() })
        }
        OTHER => {
            let device = fields.text()?.to_owned();
            Some(Reading::Other { measured_s, arrived_s, device, numbers: fields.sequence(Fields::f64)? })
        }
        _ => None,
    }
}

impl ImageStamp {
    pub(crate) fn decode(message: &[u8]) -> Option<ImageStamp> {
        let mut fields = Fields::of(message)?;
        let (measured_s, arrived_s, exposure_s) = (fields.f64()?, fields.f64()?, fields.f64()?);
        let name = fields.text()?;
        let camera = Camera::ALL.into_iter().find(|camera| camera.as_str() == name)?;
        Some(ImageStamp { measured_s, arrived_s, exposure_s, camera })
    }

    /// The camera reading made of this image stamp and of the `sensor_msgs/Image` that follows it in the recording.
    pub(crate) fn with_image(self, message: &[u8]) -> Option<Reading> {
        let mut fields = Fields::of(message)?;
        // The header of a `sensor_msgs/Image` consists of seconds, nanoseconds and the frame.
        let _header = (fields.u32()?, fields.u32()?, fields.text()?);
        let (height, width) = (fields.u32()?, fields.u32()?);
        if (fields.text()?, fields.u8()?, fields.u32()?) != ("mono8", 0, width) {
            return None;
        }
        let image = Arc::new(GrayImage::from_raw(width, height, fields.bytes()?.to_vec())?);
        let ImageStamp { measured_s, arrived_s, exposure_s, camera } = self;
        Some(Reading::Camera { measured_s, arrived_s, camera, exposure_s, image })
    }
}

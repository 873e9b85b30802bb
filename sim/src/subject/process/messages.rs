//! The messages that a process under test is sent, each with its JSON schema. They hold what a localizer is given and nothing else.

use localizer::{
    PoseBox, Reading,
    reading::{self, Camera},
};
use schemars::{JsonSchema, schema_for};
use serde::Serialize;
use serde_json::Value;

/// Version of the protocol, which the setup message names. It changes whenever a process that is written for the version before might misread a
/// message.
pub(super) const PROTOCOL: u32 = 1;

/// A topic of the stream. The order of [`Topic::ALL`] is the order of the channels in the stream.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Topic {
    Setup,
    Start,
    Wheels,
    Gyro,
    Flow,
    Range,
    Other,
    Image,
    Pixels,
    Ask,
}

impl Topic {
    pub(super) const ALL: [Topic; 10] = [
        Topic::Setup,
        Topic::Start,
        Topic::Wheels,
        Topic::Gyro,
        Topic::Flow,
        Topic::Range,
        Topic::Other,
        Topic::Image,
        Topic::Pixels,
        Topic::Ask,
    ];

    /// Name of the topic. Readings have the topics that recordings use for them.
    pub(super) fn name(self) -> &'static str {
        match self {
            Topic::Setup => "/wherein/setup",
            Topic::Start => "/wherein/start",
            Topic::Wheels => "/wherein/wheels",
            Topic::Gyro => "/wherein/gyro",
            Topic::Flow => "/wherein/flow",
            Topic::Range => "/wherein/range",
            Topic::Other => "/wherein/other",
            Topic::Image => "/wherein/image",
            Topic::Pixels => "/wherein/pixels",
            Topic::Ask => "/wherein/ask",
        }
    }

    /// Name of the topic's schema and its JSON schema; `None` for the topic of raw bytes.
    pub(super) fn schema(self) -> Option<(&'static str, Value)> {
        let (name, schema) = match self {
            Topic::Setup => ("wherein.Setup", schema_for!(Setup)),
            Topic::Start => ("wherein.Start", schema_for!(Start)),
            Topic::Wheels => ("wherein.Wheels", schema_for!(Stamped<Wheels>)),
            Topic::Gyro => ("wherein.Gyro", schema_for!(Stamped<Gyro>)),
            Topic::Flow => ("wherein.Flow", schema_for!(Stamped<Flow>)),
            Topic::Range => ("wherein.Range", schema_for!(Stamped<Range>)),
            Topic::Other => ("wherein.Other", schema_for!(Stamped<Other>)),
            Topic::Image => ("wherein.Image", schema_for!(Stamped<Image>)),
            Topic::Ask => ("wherein.Ask", schema_for!(Ask)),
            Topic::Pixels => return None,
        };
        Some((name, schema.to_value()))
    }
}

/// What a localizer may know beforehand. It is sent once, before everything else.
#[derive(Serialize, JsonSchema)]
pub(super) struct Setup {
    /// Version of the protocol.
    pub(super) protocol: u32,
    /// The map of the building, as surveyed.
    pub(super) map: Value,
    /// The robot's nominal dimensions and the declared bounds of its errors.
    pub(super) robot: Value,
}

/// The start of a drive. The clock is at 0.
#[derive(Serialize, JsonSchema)]
struct Start {
    /// The box of poses in which the robot stands: least and greatest x, y and heading.
    #[serde(rename = "box")]
    of_poses: [[f64; 2]; 3],
}

/// A request for the answer to where the robot is.
#[derive(Serialize, JsonSchema)]
struct Ask {
    /// Time for which to answer, never before the arrival of the newest reading.
    time_s: f64,
}

/// A reading: which device measured, when, and what.
#[derive(Serialize, JsonSchema)]
struct Stamped<P> {
    /// Name of the device that measured.
    device: String,
    /// Stamp: time of the measurement.
    measured_s: f64,
    /// Time at which the reading reaches the localizer.
    arrived_s: f64,
    #[serde(flatten)]
    payload: P,
}

/// Counts of the wheels' encoders.
#[derive(Serialize, JsonSchema)]
struct Wheels {
    /// Ticks of the left and of the right wheel since the start.
    ticks: [i64; 2],
}

/// Turn rate by the gyroscope.
#[derive(Serialize, JsonSchema)]
struct Gyro {
    /// Turn rate, counter-clockwise, averaged since the reading before.
    rate_rad_per_s: f64,
}

/// Counts of the flow sensor.
#[derive(Serialize, JsonSchema)]
struct Flow {
    /// Counts along the sensor's forward axis and left axis since the start.
    counts: [i64; 2],
    /// Number of periods since the start in which the sensor found nothing to follow.
    blind_periods: u64,
}

/// Coded landmarks seen by the range camera.
#[derive(Serialize, JsonSchema)]
struct Range {
    sightings: Vec<Sighting>,
}

/// Columns at which the two views of the range camera see a landmark.
#[derive(Serialize, JsonSchema)]
struct Sighting {
    /// Code of the landmark.
    landmark: u32,
    /// Column in the left view.
    left_px: f64,
    /// Column in the right view.
    right_px: f64,
}

/// Numbers of a device of any other kind.
#[derive(Serialize, JsonSchema)]
struct Other {
    /// Measured numbers in the device's own order and units.
    numbers: Vec<f64>,
}

/// An image, whose pixels are the next message.
#[derive(Serialize, JsonSchema)]
struct Image {
    /// Length of the exposure, whose middle is the stamp.
    exposure_s: f64,
    width_px: u32,
    height_px: u32,
}

/// A message as it goes into the stream.
pub(super) struct Message<'a> {
    pub(super) topic: Topic,
    pub(super) time_s: f64,
    pub(super) data: std::borrow::Cow<'a, [u8]>,
}

impl<'a> Message<'a> {
    fn json(topic: Topic, time_s: f64, content: &impl Serialize) -> Message<'a> {
        // The keys of a message are texts, so that serialising it cannot fail.
        Message { topic, time_s, data: serde_json::to_vec(content).unwrap_or_default().into() }
    }

    pub(super) fn setup(setup: &Setup) -> Message<'a> {
        Message::json(Topic::Setup, 0.0, setup)
    }

    pub(super) fn start(start: &PoseBox) -> Message<'a> {
        let of_poses = [0, 1, 2].map(|axis| [start[axis].lo(), start[axis].hi()]);
        Message::json(Topic::Start, 0.0, &Start { of_poses })
    }

    pub(super) fn ask(time_s: f64) -> Message<'a> {
        Message::json(Topic::Ask, time_s, &Ask { time_s })
    }

    /// The message of a reading; for an image the message with its pixels, too.
    pub(super) fn of(reading: &'a Reading) -> (Message<'a>, Option<Message<'a>>) {
        match reading {
            Reading::Wheels { ticks, .. } => (stamped(Topic::Wheels, reading, Wheels { ticks: *ticks }), None),
            Reading::Gyro { rate_rad_per_s, .. } => {
                (stamped(Topic::Gyro, reading, Gyro { rate_rad_per_s: *rate_rad_per_s }), None)
            }
            Reading::Flow { counts, blind_periods, .. } => {
                (stamped(Topic::Flow, reading, Flow { counts: *counts, blind_periods: *blind_periods }), None)
            }
            Reading::Range { sightings, .. } => {
                let sighting = |one: &reading::Sighting| Sighting {
                    landmark: one.landmark.0,
                    left_px: one.left_px,
                    right_px: one.right_px,
                };
                (stamped(Topic::Range, reading, Range { sightings: sightings.iter().map(sighting).collect() }), None)
            }
            Reading::Other { numbers, .. } => {
                (stamped(Topic::Other, reading, Other { numbers: numbers.clone() }), None)
            }
            Reading::Camera { exposure_s, image, .. } => {
                let (width_px, height_px) = image.dimensions();
                let head = stamped(Topic::Image, reading, Image { exposure_s: *exposure_s, width_px, height_px });
                let pixels = Message {
                    topic: Topic::Pixels,
                    time_s: reading.arrived_s(),
                    data: image.as_raw().as_slice().into(),
                };
                (head, Some(pixels))
            }
        }
    }
}

fn stamped<'a>(topic: Topic, reading: &Reading, payload: impl Serialize) -> Message<'a> {
    let stamped = Stamped {
        device: device(reading).to_owned(),
        measured_s: reading.measured_s(),
        arrived_s: reading.arrived_s(),
        payload,
    };
    Message::json(topic, reading.arrived_s(), &stamped)
}

/// Name of the device that made a reading, as its bounds have it.
pub fn device(reading: &Reading) -> &str {
    match reading {
        Reading::Wheels { .. } => "wheels",
        Reading::Camera { camera, .. } => Camera::device(*camera),
        Reading::Gyro { .. } => "gyro",
        Reading::Flow { .. } => "flow",
        Reading::Range { .. } => "range_camera",
        Reading::Other { device, .. } => device,
    }
}

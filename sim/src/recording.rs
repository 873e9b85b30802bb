//! `recording.mcap` or `rosbag2/`: all that the localizer was told during a run, what it answered, and what viewers draw of it.
//!
//! An MCAP file (<https://mcap.dev/spec>) of the profile `ros2`: messages in CDR, their definitions along with them. Its
//! order is the order of events, its times are simulated times, so that equal runs give equal bytes.
//!
//! | topic | content |
//! |---|---|
//! | `/wherein/…` | readings, starts and estimates to the last bit: what [`crate::replay`] reads |
//! | `/floor_camera/image`, `/floor_camera/camera_info` | images without loss, and the nominal calibration; likewise `forward_camera`, `ceiling_camera` |
//! | `/joint_states`, `/imu` | wheels and gyroscope as ROS 2 has them |
//! | `/truth`, `/estimate`, `/odometry` | poses in frame `world`: true, middle of the hull, wheels alone |
//! | `/tf`, `/tf_static` | `robot` where it is believed to be, `true_robot`, the cameras' nominal mounts |
//! | `/boxes` | the union of boxes, 20 times a second |
//! | `/log` | doubt while it lasts, contradictions, broken bounds, and who is to blame |
//!
//! The metadata `wherein_format` stands first. The scene's text is the attachment `scene.toml`; the metadata `wherein` at the end names seed, version, adapter and digests.

use std::{
    collections::BTreeMap,
    fs::{self, File},
    io::{self, BufWriter},
    path::{Path, PathBuf},
    process,
};

use localizer::{Estimate, Pose, Reading, RobotModel, Status, localizer::Account};
use mcap::{Attachment, Compression, McapError, WriteOptions, Writer, records::MessageHeader, records::Metadata};

use crate::{
    check::Verdict,
    record::{RecordError, Summary, folder, naming},
    run::Witness,
    scene::SceneFile,
    truth::Truth,
};

mod bag;
mod boxes;
pub(crate) mod cameras;
pub(crate) mod cdr;
mod definitions;
pub(crate) mod exact;
mod messages;
pub(crate) mod reader;

use cameras::NominalCamera;
use exact::{RecordedEstimate, Start};
use messages::{Level, ROBOT, TRUE_ROBOT};
pub use reader::RecordingError;

/// Name of the attachment that holds the scene's text.
pub(crate) const SCENE_ATTACHMENT: &str = "scene.toml";
/// Name of the metadata that holds seed, version, adapter and digests.
pub(crate) const METADATA: &str = "wherein";
/// Name of the metadata that holds [`FORMAT`]; it stands before all else.
pub(crate) const FORMAT_METADATA: &str = "wherein_format";
/// Changes whenever a message or the order of messages under `/wherein/` does.
pub(crate) const FORMAT: &str = "1";
/// Boxes are drawn at each fifth step of 10 ms: a viewer shows no more.
const STEPS_PER_DRAWING: usize = 5;

/// In whose messages the boxes are drawn; all else is the same.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Form {
    /// `foxglove_msgs/SceneUpdate`, for Foxglove and its open fork.
    Foxglove,
    /// `visualization_msgs/MarkerArray`, for a plain ROS 2.
    Ros2,
}

impl Form {
    /// Where the recording lies in the run's folder.
    pub fn path(self) -> &'static str {
        match self {
            Form::Foxglove => "recording.mcap",
            Form::Ros2 => "rosbag2/rosbag2_0.mcap",
        }
    }
}

/// A recording in the making, in a file beside the run's folder until [`Recording::finish`].
pub struct Recording {
    form: Form,
    writer: Option<Writer<BufWriter<File>>>,
    path: PathBuf,
    channels: BTreeMap<&'static str, Channel>,
    /// The first error; nothing is written after it.
    failed: Option<McapError>,
    robot: RobotModel,
    cameras: Vec<NominalCamera>,
    offset_s: f64,
    n_steps: usize,
    status: Status,
    last_ns: u64,
}

struct Channel {
    id: u16,
    /// `package/msg/Type`.
    kind: String,
    n_messages: u32,
}

impl Recording {
    /// Begins the recording of a run that will be written below `out`.
    pub fn begin(out: &Path, file: &SceneFile, seed: u64, form: Form) -> Result<Recording, RecordError> {
        let target = folder(out, &file.name, seed);
        let beside = target.parent().unwrap_or(out);
        naming("create the folder", beside, fs::create_dir_all(beside))?;
        let path = beside.join(format!(".{seed}-{}.mcap.partial", process::id()));
        let stream = naming("create", &path, File::create(&path))?;
        let options = WriteOptions::new()
            .profile("ros2")
            .library(concat!("wherein ", env!("CARGO_PKG_VERSION")))
            .compression(Some(Compression::Lz4));
        let writer = naming("write", &path, options.create(BufWriter::new(stream)).map_err(io::Error::other))?;
        let robot = file.scene.robot_model();
        let mut recording = Recording {
            form,
            writer: Some(writer),
            path,
            channels: BTreeMap::new(),
            failed: None,
            robot,
            cameras: NominalCamera::all(&file.scene),
            offset_s: 0.0,
            n_steps: 0,
            status: Status::Sound,
            last_ns: 0,
        };
        let format = BTreeMap::from([("format".to_owned(), FORMAT.to_owned())]);
        let metadata = Metadata { name: FORMAT_METADATA.to_owned(), metadata: format };
        recording.attempt(|writer| writer.write_metadata(&metadata));
        recording.attempt(|writer| {
            writer.attach(&Attachment {
                log_time: 0,
                create_time: 0,
                name: SCENE_ATTACHMENT.to_owned(),
                media_type: "application/toml".to_owned(),
                data: file.text.as_bytes().into(),
            })
        });
        if !recording.cameras.is_empty() {
            let mounts = messages::robot_from_cameras(&recording.cameras);
            recording.put("/tf_static", "tf2_msgs/TFMessage", 0.0, &mounts);
        }
        Ok(recording)
    }

    /// Adds what the check found, closes the file and moves it into the run's folder `run`.
    pub fn finish(mut self, summary: &Summary<'_>, run: &Path) -> Result<(), RecordError> {
        self.judge(summary.verdict);
        let entries = [
            ("scene", summary.scene.to_owned()),
            ("seed", summary.seed.to_string()),
            ("version", summary.version.to_owned()),
            ("adapter", summary.adapter.unwrap_or_default().to_owned()),
            ("digest.scene", summary.digest.scene.clone()),
            ("digest.readings", summary.digest.readings.clone()),
            ("digest.estimates", summary.digest.estimates.clone()),
        ];
        let metadata = entries.map(|(name, value)| (name.to_owned(), value)).into();
        self.attempt(|writer| writer.write_metadata(&Metadata { name: METADATA.to_owned(), metadata }));
        self.attempt(|writer| writer.finish().map(|_| ()));
        if let Some(error) = self.failed.take() {
            return naming("write", &self.path, Err(io::Error::other(error)));
        }
        // Whatever the buffer still holds goes out here, where an error is told.
        let flushed = self
            .writer
            .take()
            .map_or(Ok(()), |writer| writer.into_inner().into_inner().map(|_| ()).map_err(io::Error::from));
        naming("write", &self.path, flushed)?;
        let target = run.join(self.form.path());
        if let (Form::Ros2, Some(folder)) = (self.form, target.parent()) {
            naming("create the folder", folder, fs::create_dir_all(folder))?;
            let description = folder.join("metadata.yaml");
            naming("write", &description, fs::write(&description, self.metadata_yaml()))?;
        }
        naming("create", &target, fs::rename(&self.path, &target))
    }

    fn metadata_yaml(&self) -> String {
        let channels = self.channels.iter();
        let topics: Vec<bag::Topic<'_>> = channels
            .map(|(name, channel)| bag::Topic { name, kind: &channel.kind, n_messages: channel.n_messages })
            .collect();
        let file_name = self.form.path().rsplit('/').next().unwrap_or_default();
        bag::metadata_yaml(file_name, &topics, self.last_ns)
    }

    /// The verdict as log messages. They stand at the end of the file, each with the time that it speaks of.
    fn judge(&mut self, verdict: &Verdict) {
        for violation in &verdict.violations {
            let text = format!(
                "{} exceeded from {:.3} s to {:.3} s: {} where {} is declared",
                violation.bound, violation.from_s, violation.to_s, violation.true_value, violation.declared
            );
            self.log(violation.from_s, Level::Warn, "violation", &text);
        }
        if let Some(first) = &verdict.containment.first_failure {
            let text = format!("the truth is outside, {} by {}: {}", first.axis, first.margin, first.blame);
            self.log(first.time_s, Level::Error, "blame", &text);
        }
        for failed in &verdict.verdict.failed {
            self.log(self.last_ns as f64 * 1e-9, Level::Error, "verdict", failed);
        }
    }

    fn log(&mut self, time_s: f64, level: Level, name: &str, text: &str) {
        self.put("/log", "rcl_interfaces/Log", time_s, &messages::log(time_s, level, name, text));
    }

    /// Writes a message; its topic is announced with the definition before the first one. `kind` is `package/Type`.
    fn put(&mut self, topic: &'static str, kind: &str, time_s: f64, message: &[u8]) {
        if !self.channels.contains_key(topic) {
            let definition = definitions::definition(kind);
            let name = kind.replace('/', "/msg/");
            let mut id = 0;
            self.attempt(|writer| {
                let schema = writer.add_schema(&name, "ros2msg", definition.as_bytes())?;
                id = writer.add_channel(schema, topic, "cdr", &BTreeMap::new())?;
                Ok(())
            });
            self.channels.insert(topic, Channel { id, kind: name, n_messages: 0 });
        }
        let Some(channel) = self.channels.get_mut(topic) else { return };
        channel.n_messages += 1;
        // No simulated time is negative.
        let time_ns = u64::try_from(cdr::nanoseconds(time_s)).unwrap_or(0);
        self.last_ns = self.last_ns.max(time_ns);
        let header = MessageHeader {
            channel_id: channel.id,
            sequence: channel.n_messages,
            log_time: time_ns,
            publish_time: time_ns,
        };
        self.attempt(|writer| writer.write_to_known_channel(&header, message));
    }

    fn attempt(&mut self, write: impl FnOnce(&mut Writer<BufWriter<File>>) -> Result<(), McapError>) {
        if let (Some(writer), None) = (&mut self.writer, &self.failed) {
            self.failed = write(writer).err();
        }
    }
}

impl Witness for Recording {
    fn start(&mut self, offset_s: f64, station: Option<usize>) {
        self.offset_s = offset_s;
        self.put(exact::START, "wherein_msgs/Start", offset_s, &Start { offset_s, station }.encode());
    }

    fn sense(&mut self, reading: &Reading) {
        let (topic, message) = exact::encode(reading);
        let (arrived_s, measured_s) = (reading.arrived_s() + self.offset_s, reading.measured_s() + self.offset_s);
        match reading {
            Reading::Wheels { ticks, .. } => {
                self.put(topic, "wherein_msgs/Wheels", arrived_s, &message);
                let joints = messages::wheel_angles(measured_s, *ticks, self.robot.wheels.ticks_per_turn);
                self.put("/joint_states", "sensor_msgs/JointState", arrived_s, &joints);
            }
            Reading::Camera { image, camera, .. } => {
                self.put(topic, "wherein_msgs/ImageStamp", arrived_s, &message);
                let topics = cameras::topics(*camera);
                let image = messages::image(measured_s, topics.frame, image);
                self.put(topics.image, "sensor_msgs/Image", arrived_s, &image);
                if let Some(nominal) = self.cameras.iter().find(|nominal| nominal.name == *camera) {
                    let info = messages::camera_info(measured_s, nominal);
                    self.put(topics.camera_info, "sensor_msgs/CameraInfo", arrived_s, &info);
                }
            }
            Reading::Gyro { rate_rad_per_s, .. } => {
                self.put(topic, "wherein_msgs/Gyro", arrived_s, &message);
                self.put("/imu", "sensor_msgs/Imu", arrived_s, &messages::turn_rate(measured_s, *rate_rad_per_s));
            }
            Reading::Range { .. } => self.put(topic, "wherein_msgs/Range", arrived_s, &message),
        }
    }

    fn account(&mut self, reading: &Reading, accounts: &[Account]) {
        for account in accounts.iter().filter(|account| account.emptied) {
            let text = "nothing is left of the union: an assumption failed, perhaps a while ago";
            self.log(reading.arrived_s() + self.offset_s, Level::Warn, account.method, text);
        }
    }

    fn step(&mut self, truth: &Truth, estimate: &Estimate, odometry: Pose) {
        let time_s = truth.time_s;
        let exact = RecordedEstimate::of(estimate).encode();
        self.put(exact::ESTIMATE, "wherein_msgs/Estimate", time_s, &exact);
        self.put("/truth", "nav_msgs/Odometry", time_s, &messages::true_odometry(time_s, truth));
        self.put("/odometry", "geometry_msgs/PoseStamped", time_s, &messages::pose_stamped(time_s, odometry));
        let mut bodies = vec![(TRUE_ROBOT, truth.pose)];
        if !estimate.pose.is_empty() {
            let [x_m, y_m, heading_rad] = estimate.pose.hull().midpoint();
            let middle = Pose { x_m, y_m, heading_rad };
            self.put("/estimate", "geometry_msgs/PoseStamped", time_s, &messages::pose_stamped(time_s, middle));
            bodies.push((ROBOT, middle));
        }
        self.put("/tf", "tf2_msgs/TFMessage", time_s, &messages::world_from_bodies(time_s, &bodies));
        if self.n_steps.is_multiple_of(STEPS_PER_DRAWING) {
            let (kind, drawing) = match self.form {
                Form::Foxglove => ("foxglove_msgs/SceneUpdate", boxes::scene_update(time_s, estimate)),
                Form::Ros2 => ("visualization_msgs/MarkerArray", boxes::marker_array(time_s, estimate)),
            };
            self.put("/boxes", kind, time_s, &drawing);
        }
        self.n_steps += 1;
        if estimate.status != self.status {
            self.status = estimate.status;
            match estimate.status {
                Status::Recovering => self.log(time_s, Level::Warn, "doubt", "an assumption is doubted"),
                Status::Sound => self.log(time_s, Level::Info, "doubt", "the doubt is over"),
            }
        }
    }
}

impl Drop for Recording {
    fn drop(&mut self) {
        // A finished recording has been moved away; what a failed run leaves is of no use.
        let _ = fs::remove_file(&self.path);
    }
}

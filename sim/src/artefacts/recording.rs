//! A run as a stream of messages, into a file or live to viewers: everything that the localizer is given during the run, its estimates, and
//! drawings for viewers.
//!
//! `recording.mcap` and `rosbag2/` hold an MCAP file (<https://mcap.dev/spec>) of the profile `ros2`: messages in the encoding CDR, with their
//! definitions. Messages stand in the order of events and carry simulated times, so that equal runs give equal bytes.
//!
//! | topic | content |
//! |---|---|
//! | `/wherein/…` | readings, starts and estimates to the last bit: what [`crate::artefacts::replay`] reads |
//! | `/floor_camera/image`, `/floor_camera/camera_info` | lossless images and the nominal calibration; likewise `forward_camera`, `ceiling_camera` |
//! | `/joint_states`, `/imu` | wheels and gyroscope as ROS 2 has them |
//! | `/steering` | the steering angle as a car's steering encoder reads it, as a joint |
//! | `/truth`, `/estimate`, `/odometry` | poses in frame `world`: true, middle of the box around the estimate, by wheel odometry alone |
//! | `/tf`, `/tf_static` | frames `robot` at the estimated pose and `true_robot` at the true pose; the cameras' nominal mounts |
//! | `/boxes` | the estimate's union of boxes, 20 times a second |
//! | `/log` | when the localizer begins and ceases to doubt its assumptions, contradictions, broken bounds, and what is to blame |
//!
//! The metadata record `wherein_format` comes first. The scene's text is the attachment `scene.toml`; the metadata record `wherein` at the
//! end names seed, version, graphics adapter and digests.

use localizer::{
    Estimate, Pose, Reading, RobotModel, Status,
    localizer::Account,
    methods::wall_ranges::{self, Scan},
    motion::steering,
};

use crate::{
    devices::Observation,
    run::Witness,
    scene::{Scanner, Scene},
    truth::Truth,
};

mod bag;
mod boxes;
pub(crate) mod cameras;
pub(crate) mod cdr;
mod definitions;
pub(crate) mod exact;
mod file;
#[cfg_attr(not(feature = "live"), path = "recording/no_live.rs")]
mod live;
mod messages;
pub(crate) mod reader;

use cameras::NominalCamera;
use exact::{RecordedEstimate, Start};
pub use file::Recording;
#[cfg(feature = "live")]
pub use live::LiveError;
pub use live::{Live, LiveServer};
use messages::{Level, ROBOT, TRUE_ROBOT};
pub use reader::RecordingError;

/// Name of the attachment of a recording that holds the scene's text.
pub(crate) const SCENE_ATTACHMENT: &str = "scene.toml";
/// Name of the metadata record of a recording that holds the run's seed, version, graphics adapter and digests.
pub(crate) const METADATA: &str = "wherein";
/// Name of the metadata record that holds the recording's [`FORMAT`]; it comes before everything else in the file.
pub(crate) const FORMAT_METADATA: &str = "wherein_format";
/// Version of the recording format. It changes whenever a message under `/wherein/` or the order of these messages changes.
pub(crate) const FORMAT: &str = "1";
/// Boxes are drawn at every fifth step of 10 ms, because a viewer shows no more than 20 drawings a second.
const STEPS_PER_DRAWING: usize = 5;

/// The message type in which the boxes are drawn; all other messages are the same in both forms.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Form {
    /// Boxes as `foxglove_msgs/SceneUpdate`, for Foxglove and its open fork Lichtblick.
    Foxglove,
    /// Boxes as `visualization_msgs/MarkerArray`, for a plain ROS 2.
    Ros2,
}

impl Form {
    /// Path of the recording within the run's folder.
    pub fn path(self) -> &'static str {
        match self {
            Form::Foxglove => "recording.mcap",
            Form::Ros2 => "rosbag2/rosbag2_0.mcap",
        }
    }
}

/// Receiver of the messages of a run's stream, such as a file or a server for viewers.
trait Sink {
    /// Takes a message of a topic; `kind` is the message type `package/Type`, `time_ns` the simulated time.
    fn put(&mut self, topic: &'static str, kind: &str, time_ns: u64, message: &[u8]);
}

/// A run as a stream of messages: turns readings, estimates and truth into messages and hands them to a sink.
pub struct Stream<S> {
    sink: S,
    form: Form,
    robot: RobotModel,
    cameras: Vec<NominalCamera>,
    scanner: Option<Scanner>,
    offset_s: f64,
    n_steps: usize,
    status: Status,
    /// Time at which the contradiction was found that was reported last.
    contradicting_s: Option<f64>,
}

#[expect(private_bounds, reason = "there are two sinks, both here")]
impl<S: Sink> Stream<S> {
    fn new(sink: S, form: Form, scene: &Scene) -> Stream<S> {
        let mut stream = Stream {
            sink,
            form,
            robot: scene.robot_model(),
            cameras: NominalCamera::all(scene),
            scanner: scene.robot.scanner.clone(),
            offset_s: 0.0,
            n_steps: 0,
            status: Status::Sound,
            contradicting_s: None,
        };
        let cameras =
            stream.cameras.iter().map(|camera| (cameras::topics(camera.name).frame, camera.robot_from_camera));
        let scanner =
            stream.scanner.as_ref().map(|scanner| (messages::SCANNER, scanner.nominal().body_from_scanner(scanner)));
        let mounts: Vec<_> = cameras.chain(scanner).collect();
        if !mounts.is_empty() {
            stream.put("/tf_static", "tf2_msgs/TFMessage", 0.0, &messages::robot_from_devices(&mounts));
        }
        stream
    }

    fn log(&mut self, time_s: f64, level: Level, name: &str, text: &str) {
        self.put("/log", "rcl_interfaces/Log", time_s, &messages::log(time_s, level, name, text));
    }

    fn put(&mut self, topic: &'static str, kind: &str, time_s: f64, message: &[u8]) {
        // Simulated times are never negative, so that the conversion cannot fail.
        self.sink.put(topic, kind, u64::try_from(cdr::nanoseconds(time_s)).unwrap_or(0), message);
    }
}

impl<S: Sink> Witness for Stream<S> {
    fn start(&mut self, offset_s: f64, station: Option<usize>) {
        self.offset_s = offset_s;
        self.put(exact::START, "wherein_msgs/Start", offset_s, &Start { offset_s, station }.encode());
    }

    fn sense(&mut self, observation: &Observation) {
        let reading = &observation.reading;
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
            Reading::Flow { .. } => self.put(topic, "wherein_msgs/Flow", arrived_s, &message),
            Reading::Range { .. } => self.put(topic, "wherein_msgs/Range", arrived_s, &message),
            Reading::Other { device, numbers, .. } => {
                self.put(topic, "wherein_msgs/Other", arrived_s, &message);
                let scan = Scan::of(numbers).filter(|_| device == wall_ranges::DEVICE);
                if let Some((scan, scanner)) = scan.zip(self.scanner.as_ref()) {
                    let message = messages::laser_scan(measured_s, &scan, scanner);
                    self.put("/scan", "sensor_msgs/LaserScan", arrived_s, &message);
                }
                let steering = self.robot.steering.filter(|_| device == steering::DEVICE);
                if let Some((steering, ticks)) = steering.zip(numbers.first()) {
                    let joint = messages::steering_angle(measured_s, ticks * steering.rad_per_tick);
                    self.put("/steering", "sensor_msgs/JointState", arrived_s, &joint);
                }
            }
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
        if let Some(found) = estimate.contradicting.as_ref().filter(|found| self.contradicting_s != Some(found.found_s))
        {
            self.contradicting_s = Some(found.found_s);
            self.log(time_s, Level::Warn, "contradiction", &format!("since {:.3} s {found}", found.found_s));
        }
        if estimate.status != self.status {
            self.status = estimate.status;
            match estimate.status {
                Status::Recovering => self.log(time_s, Level::Warn, "doubt", "an assumption is doubted"),
                Status::Sound => self.log(time_s, Level::Info, "doubt", "the doubt is over"),
            }
        }
    }
}

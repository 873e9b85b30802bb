//! A log that has been read for all but the pixels of its images: its values with checked stamps, and the robot as the localizer is told it.

use std::{collections::BTreeMap, path::Path, sync::Arc};

use localizer::{
    Reading,
    methods::{
        gnss_positions::{self, Position},
        wall_ranges::{self, Scan},
    },
    reading::Camera,
};

use super::{
    account,
    error::LogError,
    gathered::{Gathered, Manner, Stamped},
    lenses::{self, LensFound},
    messages,
    motion::{self, Motion},
    pictures,
    raw_message::{Damage, RawMessage},
    source::Source,
    topics::{Choice, Offered, Role},
    truth::{self, TruePath},
};
use crate::{
    loading::SceneFile,
    scene::{Log, Scene},
};

/// Topics that are read, each with what it is read as.
type Roles = BTreeMap<String, Role>;

/// All that a log tells, except for the pixels of its images.
pub(super) struct OpenLog<'a> {
    pub(super) keys: &'a Log,
    source: Source,
    roles: Roles,
    pub(super) gathered: Gathered,
    pub(super) damage: Vec<Damage>,
    /// Stamp of the first reading of the wheels, from which times are counted.
    pub(super) zero_ns: i64,
    /// The robot as the localizer is told it.
    pub(super) told: Scene,
    pub(super) lenses: Vec<LensFound>,
    pub(super) motion: Motion,
    /// Readings of satellite navigation, in the order of their stamps.
    pub(super) positions: Vec<Reading>,
    /// Scans of the range scanner, in the order of their stamps.
    pub(super) scans: Vec<Reading>,
    pub(super) truth: Option<TruePath>,
}

impl<'a> OpenLog<'a> {
    /// Reads the log at `path` as the table `[log]` of the file `robot` says.
    pub(super) fn read(robot: &'a SceneFile, path: &Path) -> Result<OpenLog<'a>, LogError> {
        let keys = robot.scene.log.as_ref().ok_or_else(|| LogError::NoTable(robot.path.clone()))?;
        let source = Source::open(path)?;
        let (roles, offered) = roles(robot, keys, path, &source)?;
        let mut gathered = Gathered::default();
        let manner =
            Manner { keys, receiver: robot.scene.robot.gnss.as_ref(), scanner: robot.scene.robot.scanner.as_ref() };
        let damage = source.read(&mut |message| match roles.get(message.topic) {
            Some(role) => gathered.take(message, *role, &manner),
            None => true,
        })?;
        gathered.check_stamps(&roles, keys);
        if let Some(found) = clock_step(&gathered) {
            return Err(LogError::Unusable { log: path.to_owned(), found }.with_damage(&damage));
        }
        for (name, topic) in offered {
            let entry = gathered.topics.entry(name).or_default();
            entry.n_messages = entry.n_messages.max(topic.n_messages);
            entry.kind = topic.kind;
        }
        let zero_ns = first_stamp_ns(&gathered).ok_or_else(|| unusable(path, &gathered).with_damage(&damage))?;
        let (scene, lenses) =
            with_lenses(&robot.scene, keys, path, &gathered).map_err(|error| error.with_damage(&damage))?;
        let told = motion::told(&scene, keys, &gathered);
        let motion = Motion::of(&gathered, zero_ns, &told, keys);
        let positions = others(&gathered.positions, zero_ns, gnss_positions::DEVICE, Position::numbers);
        let scans = others(&gathered.scans, zero_ns, wall_ranges::DEVICE, Scan::numbers);
        let truth = true_path(robot, keys, &gathered, zero_ns)?;
        Ok(OpenLog { keys, source, roles, gathered, damage, zero_ns, told, lenses, motion, positions, scans, truth })
    }

    /// Readings of all devices that need neither motion nor pixels, in the order of their stamps.
    pub(super) fn others(&self) -> Vec<Reading> {
        let mut all = [self.positions.as_slice(), &self.scans].concat();
        all.sort_by(|one, other| one.measured_s().total_cmp(&other.measured_s()));
        all
    }

    /// Devices that the robot's file describes and of which the log has no reading that can be used.
    pub(super) fn without_readings(&self) -> Vec<&'static str> {
        let (robot, gathered) = (&self.told.robot, &self.gathered);
        let cameras = Camera::ALL
            .into_iter()
            .filter(|camera| robot.camera(*camera).is_some() && gathered.images.get(camera).is_none_or(Vec::is_empty));
        let gyro = robot.gyro.as_ref().filter(|_| gathered.rates.is_empty()).map(|_| "gyro");
        let receiver = robot.gnss.as_ref().filter(|_| gathered.positions.is_empty()).map(|_| "gnss");
        let scanner = robot.scanner.as_ref().filter(|_| gathered.scans.is_empty()).map(|_| "scanner");
        gyro.into_iter().chain(receiver).chain(scanner).chain(cameras.map(Camera::device)).collect()
    }

    /// Reads the log once more and shows its images one by one, until `see` answers that no more are wanted.
    pub(super) fn show_images(&mut self, see: &mut dyn FnMut(Reading) -> bool) -> Result<(), LogError> {
        if self.gathered.images.values().all(Vec::is_empty) {
            return Ok(());
        }
        let mut shown: BTreeMap<Camera, Shown> = BTreeMap::new();
        for (camera, stamps) in &self.gathered.images {
            let stamps = stamps.iter().map(|one| (one.number, one.stamp_ns)).collect();
            shown.insert(*camera, Shown { next: 0, stamps });
        }
        let (roles, told, topics) = (&self.roles, &self.told, &mut self.gathered.topics);
        self.source.read(&mut |message| {
            let Some(Role::Image(camera)) = roles.get(message.topic) else { return true };
            let Some(shown) = shown.get_mut(camera) else { return true };
            let number = shown.next;
            shown.next += 1;
            let Some(stamp_ns) = shown.stamps.get(&number) else { return true };
            let at_s = stamp_ns.saturating_sub(self.zero_ns) as f64 * 1e-9;
            match reading_of(message, *camera, at_s, told) {
                Ok(reading) => see(reading),
                Err(detail) => {
                    let topic = topics.entry(message.topic.to_owned()).or_default();
                    topic.account.drop_one("its image is not read", message.logged_ns, detail);
                    true
                }
            }
        })?;
        Ok(())
    }
}

/// The topics that are read, each with what it is read as, and all topics that the log offers.
fn roles(
    robot: &SceneFile,
    keys: &Log,
    log: &Path,
    source: &Source,
) -> Result<(Roles, BTreeMap<String, Offered>), LogError> {
    let mut offered: BTreeMap<String, Offered> = BTreeMap::new();
    let damage = source.read(&mut |message| {
        if let Some(topic) = offered.get_mut(message.topic) {
            topic.n_messages += 1;
        } else {
            let kind = message.kind.to_owned();
            offered.insert(message.topic.to_owned(), Offered { kind, n_messages: 1 });
        }
        true
    })?;
    let choice = Choice { log, robot: &robot.path, scene: &robot.scene, keys, offered: &offered };
    let roles = choice.roles().map_err(|error| error.with_damage(&damage))?;
    Ok((roles, offered))
}

/// Stamp of the first reading of the wheels, from which times are counted.
fn first_stamp_ns(gathered: &Gathered) -> Option<i64> {
    let joints = gathered.joints.first().map(|one| one.stamp_ns);
    joints.or_else(|| gathered.odometry.first().map(|one| one.stamp_ns))
}

/// What the report says of a log during which the clock of the motion sensors was set. The time that passed between a stamp before that and one after
/// it is unknown, and so is the robot's pose after it, since the start pose is known for the log's beginning only.
fn clock_step(gathered: &Gathered) -> Option<String> {
    let of_motion = |topic: &account::Topic| matches!(topic.role, Some(Role::Joints | Role::Odometry | Role::Imu));
    let (name, step) = gathered
        .topics
        .iter()
        .filter(|(_, topic)| of_motion(topic))
        .find_map(|(name, topic)| Some((name, topic.clock_step.as_ref()?)))?;
    let fault = match step.by_s {
        Some(by_s) => format!("was set by {by_s:+.3} s"),
        None => "stands, or goes at another rate than that of the times of logging,".to_owned(),
    };
    Some(format!(
        "the clock of the stamps of `{name}` {fault} where the time of logging is {:.3} s, expected stamps of one clock; with `stamps = \"log_time\"` in \
         `[log]` the times of logging are used, else cut the log there",
        step.logged_ns as f64 * 1e-9
    ))
}

/// The error of a log without a usable reading of the wheels.
fn unusable(path: &Path, gathered: &Gathered) -> LogError {
    let of_wheels = |topic: &&account::Topic| matches!(topic.role, Some(Role::Joints | Role::Odometry));
    let dropped = gathered.topics.iter().find(|(_, topic)| of_wheels(topic));
    let why = dropped.map(|(name, topic)| {
        let reasons: Vec<String> = topic
            .account
            .dropped
            .iter()
            .map(|(reason, dropped)| format!("{} times {reason}: {}", dropped.count, dropped.first))
            .collect();
        let set_back = gathered.set_back.iter().map(|one| {
            format!(
                "after the message of `{}` logged at {:.3} s, {}",
                one.topic,
                one.logged_ns as f64 * 1e-9,
                one.what()
            )
        });
        let reasons: Vec<String> = reasons.into_iter().chain(set_back).collect();
        let why = if reasons.is_empty() { "it has none".to_owned() } else { reasons.join("; ") };
        format!("no message of `{name}` can be used ({why})")
    });
    let found = why.unwrap_or_else(|| "it has no topic of the wheels".to_owned());
    let expected = "expected a topic of type nav_msgs/Odometry or sensor_msgs/JointState";
    LogError::Unusable { log: path.to_owned(), found: format!("{found}, {expected}") }
}

/// The robot with the lenses that the log states, if the robot's file asks for them, and what the log says about them.
fn with_lenses(
    scene: &Scene,
    keys: &Log,
    path: &Path,
    gathered: &Gathered,
) -> Result<(Scene, Vec<LensFound>), LogError> {
    let mut scene = scene.clone();
    if keys.lens_from_camera_info {
        for camera in gathered.images.keys() {
            let Some(lens) = gathered.lenses.get(camera) else {
                let found = format!(
                    "no message of type sensor_msgs/CameraInfo tells the lens of the {}, expected one on a topic `camera_info` beside its images, as \
                     `log.lens_from_camera_info` is true",
                    camera.device().replace('_', " ")
                );
                return Err(LogError::Unusable { log: path.to_owned(), found });
            };
            lenses::adopt(&mut scene, *camera, lens);
        }
    }
    let found = gathered.lenses.iter().filter_map(|(camera, lens)| lenses::compare(&scene, *camera, lens)).collect();
    Ok((scene, found))
}

/// Readings of a device of no kind of its own, such as a receiver of satellite navigation, in the order of their stamps.
fn others<T>(found: &[Stamped<T>], zero_ns: i64, device: &str, numbers: fn(&T) -> Vec<f64>) -> Vec<Reading> {
    let reading = |one: &Stamped<T>| {
        let at_s = one.stamp_ns.saturating_sub(zero_ns) as f64 * 1e-9;
        Reading::Other { measured_s: at_s, arrived_s: at_s, device: device.to_owned(), numbers: numbers(&one.value) }
    };
    found.iter().map(reading).filter(|reading| reading.measured_s() >= 0.0).collect()
}

/// The true path of the robot, if the robot's file says where it is.
fn true_path(robot: &SceneFile, keys: &Log, gathered: &Gathered, zero_ns: i64) -> Result<Option<TruePath>, LogError> {
    let Some(truth) = &keys.truth else { return Ok(None) };
    let path = match &truth.tum {
        Some(file) => {
            let path = robot.path.parent().unwrap_or(Path::new("")).join(file);
            let poses = truth::read_tum(&path).map_err(|found| LogError::Truth { path, found })?;
            TruePath::of(&poses, zero_ns, truth, keys.longest_gap_s)
        }
        None => TruePath::of(&gathered.truth, zero_ns, truth, keys.longest_gap_s),
    };
    Ok(Some(path))
}

/// The images of one camera: the number of the next one in the log, and the stamps of those that are used, by their numbers.
struct Shown {
    next: usize,
    stamps: BTreeMap<usize, i64>,
}

/// The reading of a camera that an image's message gives, or what is wrong with it.
fn reading_of(message: RawMessage<'_>, camera: Camera, at_s: f64, told: &Scene) -> Result<Reading, String> {
    let short = || "a message that does not decode".to_owned();
    let image = if message.kind.ends_with("CompressedImage") {
        let (_, format, data) = messages::compressed_image(message.data).ok_or_else(short)?;
        pictures::grey_of_file(format, data)?
    } else {
        let (_, raw) = messages::image(message.data).ok_or_else(short)?;
        pictures::grey(&raw)?
    };
    let keys = told.robot.camera(camera).ok_or_else(short)?;
    let [width, height] = keys.shared().size_px;
    if (image.width(), image.height()) != (width, height) {
        let [found_width, found_height] = [image.width(), image.height()];
        return Err(format!(
            "{found_width} × {found_height} pixels, where the {} has {width} × {height}",
            camera.device()
        ));
    }
    // A log does not tell the exposure; the longest one of the sensor is the one that blurs most.
    let exposure_s = keys.sensor_model().longest_exposure_s;
    Ok(Reading::Camera { measured_s: at_s, arrived_s: at_s, camera, exposure_s, image: Arc::new(image) })
}

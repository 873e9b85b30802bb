//! The messages of a log by what they are read as, with their stamps checked. Images are not kept: only their stamps are.

use std::collections::{BTreeMap, BTreeSet};

use localizer::{
    Pose,
    methods::{gnss_positions::Position, wall_ranges::Scan},
    reading::Camera,
};

use super::{
    account::{ClockStep, Topic},
    geodesy,
    messages::{self, LensInfo},
    raw_message::RawMessage,
    topics::Role,
};
use crate::scene::{Datum, Gnss, Log, Scanner, Stamps, UpAxis};

/// A value of a message with the message's times in nanoseconds, and its number among the messages of its topic.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Stamped<T> {
    pub(super) stamp_ns: i64,
    pub(super) logged_ns: i64,
    pub(super) number: usize,
    pub(super) value: T,
}

/// All that is read from a log, each list in the order of stamps after [`Gathered::check_stamps`].
#[derive(Clone, Debug, Default)]
pub(super) struct Gathered {
    /// Poses of odometry, in its own frame.
    pub(super) odometry: Vec<Stamped<Pose>>,
    /// Angles of the left and of the right wheel.
    pub(super) joints: Vec<Stamped<[f64; 2]>>,
    /// Turn rates about the vertical.
    pub(super) rates: Vec<Stamped<f64>>,
    /// Positions by satellite navigation, in the world frame.
    pub(super) positions: Vec<Stamped<Position>>,
    /// Scans of the range scanner.
    pub(super) scans: Vec<Stamped<Scan>>,
    /// True poses as the log has them.
    pub(super) truth: Vec<Stamped<Pose>>,
    /// Images of each camera, of which the log is read again.
    pub(super) images: BTreeMap<Camera, Vec<Stamped<()>>>,
    /// What the first message about each camera's lens says.
    pub(super) lenses: BTreeMap<Camera, LensInfo>,
    /// For each topic, what became of its messages.
    pub(super) topics: BTreeMap<String, Topic>,
    /// The frame of the first message of each topic.
    frames: BTreeMap<String, String>,
    /// Latest time of logging so far, for each topic: a file may hold one topic after the other.
    latest_ns: BTreeMap<String, i64>,
    /// Where and by how much a topic's time of logging went back, from where the log is read no further.
    pub(super) set_back: Option<SetBack>,
}

/// A place of a log at which the time of logging goes back.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct SetBack {
    pub(super) topic: String,
    pub(super) logged_ns: i64,
    pub(super) by_s: f64,
}

impl SetBack {
    /// What happens there, for messages.
    pub(super) fn what(&self) -> String {
        format!("the time of logging goes back by {:.3} s, and what comes after is not read", self.by_s)
    }
}

/// What a message gives, by its role.
enum Value {
    Odometry(Pose),
    Joints([f64; 2]),
    Rate(f64),
    Position(Position),
    Scan(Scan),
    Truth(Pose),
    Image(Camera),
    Lens(Camera, LensInfo),
}

/// What the robot's file says about reading messages.
pub(super) struct Manner<'a> {
    pub(super) keys: &'a Log,
    pub(super) receiver: Option<&'a Gnss>,
    pub(super) scanner: Option<&'a Scanner>,
}

impl Gathered {
    /// Takes in a message of a topic that is read as `role`. Returns whether the log is to be read further.
    pub(super) fn take(&mut self, message: RawMessage<'_>, role: Role, manner: &Manner<'_>) -> bool {
        let tolerance_ns = (manner.keys.clock_tolerance_s * 1e9) as i64;
        let latest_ns = self.latest_ns.get(message.topic).map_or(message.logged_ns, |ns| message.logged_ns.max(*ns));
        if message.logged_ns < latest_ns.saturating_sub(tolerance_ns) {
            let by_s = latest_ns.saturating_sub(message.logged_ns) as f64 * 1e-9;
            self.set_back = Some(SetBack { topic: message.topic.to_owned(), logged_ns: latest_ns, by_s });
            return false;
        }
        self.latest_ns.insert(message.topic.to_owned(), latest_ns);
        let topic = self.topics.entry(message.topic.to_owned()).or_default();
        let number = topic.n_messages;
        topic.n_messages += 1;
        let read = self.read(message, role, manner);
        match read {
            Ok((stamp_ns, value)) => self.keep(stamp_ns, message.logged_ns, number, value),
            Err((reason, detail)) => self.drop_one(message.topic, message.logged_ns, reason, detail),
        }
        true
    }

    fn drop_one(&mut self, topic: &str, logged_ns: i64, reason: &'static str, detail: String) {
        self.topics.entry(topic.to_owned()).or_default().account.drop_one(reason, logged_ns, detail);
    }

    /// The stamp and the value of a message, or why it is dropped.
    fn read(
        &mut self,
        message: RawMessage<'_>,
        role: Role,
        manner: &Manner<'_>,
    ) -> Result<(i64, Value), (&'static str, String)> {
        if message.encoding != "cdr" {
            return Err(("its encoding is not read", format!("`{}`, expected `cdr`", message.encoding)));
        }
        let short = || ("it does not decode", format!("{} bytes are no {}", message.data.len(), message.kind));
        let (header, value) = match role {
            Role::Odometry | Role::Truth => {
                let decoded = match message.kind {
                    "nav_msgs/Odometry" => messages::odometry(message.data),
                    _ => messages::pose_stamped(message.data),
                };
                let (header, pose) = decoded.ok_or_else(short)?;
                let numbers = pose.position_m.iter().chain(&pose.attitude);
                finite(numbers)?;
                let planar = pose
                    .planar()
                    .ok_or_else(|| ("its attitude is no unit quaternion", format!("{:?}", pose.attitude)))?;
                (header, if role == Role::Truth { Value::Truth(planar) } else { Value::Odometry(planar) })
            }
            Role::Joints => {
                let (header, joints) = messages::joint_state(message.data).ok_or_else(short)?;
                (header, Value::Joints(wheels_of(&joints, manner.keys)?))
            }
            Role::Imu => {
                let (header, rates) = messages::imu(message.data).ok_or_else(short)?;
                let rates =
                    rates.ok_or_else(|| ("it measures no turn rate", "its covariance begins with −1".to_owned()))?;
                finite(&rates)?;
                (header, Value::Rate(about_vertical(rates, manner.keys.imu.up)))
            }
            Role::Gnss => {
                let (header, fix) = messages::satellite_fix(message.data).ok_or_else(short)?;
                let datum = manner.keys.gnss.as_ref().zip(manner.receiver);
                let (datum, receiver) = datum.ok_or_else(short)?;
                (header, Value::Position(position(&fix, datum, receiver)?))
            }
            Role::Scans => {
                let (mut header, scan) = messages::laser_scan(message.data).ok_or_else(short)?;
                let sweep_s = scan.step_s * scan.distances_m.len().saturating_sub(1) as f64;
                let value = scan_of(scan, sweep_s, manner.scanner.ok_or_else(short)?)?;
                // The stamp is that of the first beam; the middle of the sweep is nearest to all beams.
                header.stamp_ns = header.stamp_ns.saturating_add((0.5e9 * sweep_s) as i64);
                (header, Value::Scan(value))
            }
            Role::Image(camera) => (messages::header(message.data).ok_or_else(short)?, Value::Image(camera)),
            Role::CameraInfo(camera) => {
                let (header, lens) = messages::camera_info(message.data).ok_or_else(short)?;
                finite(lens.focal_px.iter().chain(&lens.principal_point_px).chain(&lens.distortion))?;
                (header, Value::Lens(camera, lens))
            }
        };
        let frame = self.frames.entry(message.topic.to_owned()).or_insert_with(|| header.frame.clone());
        if *frame != header.frame {
            return Err((
                "its frame is another one",
                format!("`{}`, where the first message has `{frame}`", header.frame),
            ));
        }
        let stamp_ns = match manner.keys.stamps {
            Stamps::Header => header.stamp_ns,
            Stamps::LogTime => message.logged_ns,
        };
        Ok((stamp_ns, value))
    }

    fn keep(&mut self, stamp_ns: i64, logged_ns: i64, number: usize, value: Value) {
        macro_rules! stamped {
            ($value:expr) => {
                Stamped { stamp_ns, logged_ns, number, value: $value }
            };
        }
        match value {
            Value::Odometry(pose) => self.odometry.push(stamped!(pose)),
            Value::Joints(angles_rad) => self.joints.push(stamped!(angles_rad)),
            Value::Rate(rate_rad_per_s) => self.rates.push(stamped!(rate_rad_per_s)),
            Value::Position(position) => self.positions.push(stamped!(position)),
            Value::Scan(scan) => self.scans.push(stamped!(scan)),
            Value::Truth(pose) => self.truth.push(stamped!(pose)),
            Value::Image(camera) => self.images.entry(camera).or_default().push(stamped!(())),
            Value::Lens(camera, lens) => {
                self.lenses.entry(camera).or_insert(lens);
            }
        }
    }

    /// Puts every list into the order of stamps, and drops messages with false stamps and repeated ones. `roles` are the topics that are read.
    pub(super) fn check_stamps(&mut self, roles: &BTreeMap<String, Role>, keys: &Log) {
        for (name, role) in roles {
            let mut topic = self.topics.remove(name).unwrap_or_default();
            match role {
                Role::Odometry => check(&mut self.odometry, &mut topic, keys),
                Role::Joints => check(&mut self.joints, &mut topic, keys),
                Role::Imu => check(&mut self.rates, &mut topic, keys),
                Role::Gnss => check(&mut self.positions, &mut topic, keys),
                Role::Scans => check(&mut self.scans, &mut topic, keys),
                Role::Truth => check(&mut self.truth, &mut topic, keys),
                Role::Image(camera) => check(self.images.entry(*camera).or_default(), &mut topic, keys),
                Role::CameraInfo(_) => {}
            }
            topic.role = Some(*role);
            self.topics.insert(name.clone(), topic);
        }
    }
}

/// Drops the values of a topic whose stamps are false or repeated, sorts the others by their stamps, and notes what is known of the topic's times.
fn check<T>(values: &mut Vec<Stamped<T>>, topic: &mut Topic, keys: &Log) {
    let delay_ns = |value: &Stamped<T>| value.logged_ns.saturating_sub(value.stamp_ns);
    let mut delays_ns: Vec<i64> = values.iter().map(delay_ns).collect();
    delays_ns.sort_unstable();
    let Some(&usual_ns) = delays_ns.get(delays_ns.len() / 2) else { return };
    topic.delay_ns = Some(usual_ns);
    let tolerance_ns = (keys.clock_tolerance_s * 1e9) as i64;
    let ahead_ns = |value: &Stamped<T>| usual_ns.saturating_sub(delay_ns(value));
    let ahead: Vec<[i64; 2]> = values.iter().map(|value| [value.logged_ns, ahead_ns(value)]).collect();
    topic.clock_step = clock_step(&ahead, tolerance_ns, (keys.longest_gap_s * 1e9) as i64);
    let Topic { account, n_out_of_order, .. } = topic;
    values.retain(|value| {
        let ahead_ns = ahead_ns(value);
        let is_kept = ahead_ns.saturating_abs() <= tolerance_ns;
        if !is_kept {
            let detail = format!(
                "its stamp is off by {:.3} s from the time of logging, more than clock_tolerance_s",
                ahead_ns as f64 * 1e-9
            );
            account.drop_one("its stamp is false", value.logged_ns, detail);
        }
        is_kept
    });
    *n_out_of_order = values.windows(2).filter(|pair| pair[1].stamp_ns < pair[0].stamp_ns).count();
    values.sort_by_key(|value| value.stamp_ns);
    let mut stamps = BTreeSet::new();
    values.retain(|value| {
        let is_new = stamps.insert(value.stamp_ns);
        if !is_new {
            account.drop_one("its stamp is that of another message", value.logged_ns, String::new());
        }
        is_new
    });
    topic.note_times(&values.iter().map(|value| value.stamp_ns).collect::<Vec<_>>(), keys.longest_gap_s);
}

/// Least number of messages whose stamps show that their clock stands or goes at another rate.
const LEAST_OFF: usize = 5;

/// The first step of a clock among messages in the order of logging, each with its time of logging and by how much its stamp is ahead of what the
/// usual delay makes of that time. Messages whose stamps are off by the same time, to within `tolerance_ns`, for longer than `lasting_ns` are by a
/// clock that was set; ones that are off by ever more or ever less are by a clock that stands or goes at another rate; fewer ones are single false
/// stamps.
fn clock_step(ahead: &[[i64; 2]], tolerance_ns: i64, lasting_ns: i64) -> Option<ClockStep> {
    let is_off = |&[_, ahead_ns]: &[i64; 2]| ahead_ns.saturating_abs() > tolerance_ns;
    // Stamps that are off for so long by ever more, or by ever less, are by a clock that stands or goes at another rate. Single false stamps that
    // follow each other are off by now more and now less.
    let goes_otherwise = ahead.chunk_by(|one, next| is_off(one) == is_off(next)).find_map(|stretch| {
        let [first, .., last] = stretch else { return None };
        let lasts = last[0].saturating_sub(first[0]) > lasting_ns && stretch.len() >= LEAST_OFF;
        let changes = last[1].abs_diff(first[1]) > tolerance_ns.unsigned_abs();
        // Messages far apart are compared, as those beside each other are logged now a little earlier and now a little later.
        let parts = [0, 1, 2, 3, 4].map(|part| stretch[part * (stretch.len() - 1) / 4][1]);
        let goes = parts.is_sorted() || parts.iter().rev().is_sorted();
        (is_off(first) && lasts && changes && goes).then_some(ClockStep { logged_ns: first[0], by_s: None })
    });
    if goes_otherwise.is_some() {
        return goes_otherwise;
    }
    let mut first = 0;
    for idx in 0..ahead.len() {
        if !is_off(&ahead[idx]) || ahead[idx][1].abs_diff(ahead[first][1]) > tolerance_ns.unsigned_abs() {
            first = idx;
        }
        if is_off(&ahead[first]) && ahead[idx][0].saturating_sub(ahead[first][0]) > lasting_ns {
            // Where the first messages are off, the step is at the first one that is not.
            let right = ahead.iter().find(|one| !is_off(one)).filter(|_| first == 0);
            let (logged_ns, sign) = right.map_or((ahead[first][0], 1.0), |right| (right[0], -1.0));
            return Some(ClockStep { logged_ns, by_s: Some(sign * ahead[first][1] as f64 / 1e9) });
        }
    }
    None
}

fn finite<'a>(numbers: impl IntoIterator<Item = &'a f64>) -> Result<(), (&'static str, String)> {
    match numbers.into_iter().find(|number| !number.is_finite()) {
        Some(number) => Err(("a number in it is not finite", number.to_string())),
        None => Ok(()),
    }
}

/// The angles of the two wheels among those of all joints.
fn wheels_of(joints: &[(String, f64)], keys: &Log) -> Result<[f64; 2], (&'static str, String)> {
    let angle = |name: &String| joints.iter().find(|(joint, _)| joint == name).map(|(_, angle_rad)| *angle_rad);
    let (Some(left), Some(right)) = (angle(&keys.joints.left), angle(&keys.joints.right)) else {
        let names: Vec<String> = joints.iter().map(|(joint, _)| format!("`{joint}`")).collect();
        let detail = format!("`{}` and `{}` are not among {}", keys.joints.left, keys.joints.right, names.join(", "));
        return Err(("it has no position of the wheels' joints", detail));
    };
    finite(&[left, right])?;
    Ok([left, right])
}

fn about_vertical([x, y, z]: [f64; 3], up: UpAxis) -> f64 {
    match up {
        UpAxis::X => x,
        UpAxis::Y => y,
        UpAxis::Z => z,
        UpAxis::MinusX => -x,
        UpAxis::MinusY => -y,
        UpAxis::MinusZ => -z,
    }
}

/// The scan that a message tells, all of whose beams are taken to be measured at one instant; they are within `sweep_s`.
fn scan_of(scan: messages::LaserScan, sweep_s: f64, scanner: &Scanner) -> Result<Scan, (&'static str, String)> {
    finite(&[scan.first_rad, scan.step_rad, scan.step_s])?;
    let allowed_s = scanner.stamp_tolerance_s;
    if 0.5 * sweep_s.abs() > allowed_s {
        let detail = format!(
            "its beams are measured over {:.4} s, where `robot.scanner.stamp_tolerance_s` is {allowed_s}, expected half of that time at least",
            sweep_s.abs()
        );
        return Err(("its beams are measured over a longer time than declared", detail));
    }
    if scan.step_rad == 0.0 && scan.distances_m.len() > 1 {
        let detail = format!("`angle_increment` is 0 for {} beams, expected another number", scan.distances_m.len());
        return Err(("all of its beams have one direction", detail));
    }
    let [least_m, most_m] = scan.between_m;
    // A greatest distance that is infinite is that of a scanner without one.
    if least_m.is_nan() || most_m.is_nan() || least_m > most_m || most_m <= 0.0 {
        let detail = format!(
            "`range_min` is {least_m} and `range_max` {most_m}, expected a number and one above 0 that is no less"
        );
        return Err(("its least and greatest range hold no distance", detail));
    }
    let distance = |&at_m: &f64| (at_m.is_finite() && least_m <= at_m && at_m <= most_m && at_m >= 0.0).then_some(at_m);
    let distances_m = scan.distances_m.iter().map(distance).collect();
    Ok(Scan { first_rad: scan.first_rad, step_rad: scan.step_rad, distances_m })
}

/// The position in the world of a satellite fix, and whether it is as good as one with resolved ambiguities.
fn position(fix: &messages::SatelliteFix, datum: &Datum, receiver: &Gnss) -> Result<Position, (&'static str, String)> {
    if fix.status < 0 {
        return Err(("it has no fix", format!("its status is {}", fix.status)));
    }
    finite(&[fix.latitude_deg, fix.longitude_deg, fix.altitude_m])?;
    // By the definition of the message, 2 stands for corrections from the ground, by which receivers resolve ambiguities.
    let is_fixed = fix.status == 2;
    let declared_m = if is_fixed { receiver.fixed_tolerance_m } else { receiver.floating_tolerance_m };
    if let Some(covariance_m2) = fix.covariance_m2.filter(|_| datum.sigmas > 0.0) {
        finite(&covariance_m2)?;
        let allowed_m = datum.sigmas * covariance_m2[0].max(covariance_m2[4]).max(0.0).sqrt();
        if allowed_m > declared_m {
            let detail =
                format!("{} standard deviations are {allowed_m:.3} m, where {declared_m} m are declared", datum.sigmas);
            return Err(("its covariance allows more than is declared", detail));
        }
    }
    let at_m = geodesy::world_m(datum, fix.latitude_deg, fix.longitude_deg, fix.altitude_m);
    Ok(Position { at_m, is_fixed })
}

#[cfg(test)]
mod tests;

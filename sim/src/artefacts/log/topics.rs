//! Which topic of a log is read as what: as the robot's file names it, or else the only topic of a fitting type.

use std::{collections::BTreeMap, path::Path};

use localizer::reading::Camera;

use super::LogError;
use crate::scene::{Log, Scene};

/// What a topic is read as.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Role {
    Odometry,
    Joints,
    Imu,
    Image(Camera),
    CameraInfo(Camera),
    Gnss,
    Scans,
    Truth,
}

/// A topic as a log has it, before it is known what it is read as.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Offered {
    pub(super) kind: String,
    pub(super) n_messages: usize,
}

impl Role {
    /// Types of messages that a topic of this role may have.
    pub(super) fn kinds(self) -> &'static [&'static str] {
        match self {
            Role::Odometry => &["nav_msgs/Odometry"],
            Role::Joints => &["sensor_msgs/JointState"],
            Role::Imu => &["sensor_msgs/Imu"],
            Role::Image(_) => &["sensor_msgs/Image", "sensor_msgs/CompressedImage"],
            Role::CameraInfo(_) => &["sensor_msgs/CameraInfo"],
            Role::Gnss => &["sensor_msgs/NavSatFix"],
            Role::Scans => &["sensor_msgs/LaserScan"],
            Role::Truth => {
                &["nav_msgs/Odometry", "geometry_msgs/PoseStamped", "geometry_msgs/PoseWithCovarianceStamped"]
            }
        }
    }

    /// Name of the role in reports.
    pub(super) fn name(self) -> String {
        match self {
            Role::Odometry | Role::Joints => "wheels".to_owned(),
            Role::Imu => "gyro".to_owned(),
            Role::Image(camera) => camera.device().to_owned(),
            Role::CameraInfo(camera) => format!("{} lens", camera.device()),
            Role::Gnss => "gnss".to_owned(),
            Role::Scans => "scanner".to_owned(),
            Role::Truth => "truth".to_owned(),
        }
    }
}

/// Chooses the topics that are read, among those that the log offers.
pub(super) struct Choice<'a> {
    pub(super) log: &'a Path,
    pub(super) robot: &'a Path,
    pub(super) scene: &'a Scene,
    pub(super) keys: &'a Log,
    pub(super) offered: &'a BTreeMap<String, Offered>,
}

impl Choice<'_> {
    /// The topics that are read, each with what it is read as.
    pub(super) fn roles(&self) -> Result<BTreeMap<String, Role>, LogError> {
        let mut roles = BTreeMap::new();
        // The truth is chosen first, so that a topic of true poses is not taken for one of odometry.
        if let Some(name) = self.keys.truth.as_ref().and_then(|truth| truth.topic.as_ref()) {
            roles.insert(self.named("log.truth.topic", name, Role::Truth)?, Role::Truth);
        }
        let (topics, robot) = (&self.keys.topics, &self.scene.robot);
        let (mut joints, mut odometry) = (topics.joints.as_ref(), topics.odometry.as_ref());
        // Joints are nearer to the encoders than odometry, which somebody has computed of them. Messages of joints may be of an arm, though.
        let has_joints = self.of_kind(Role::Joints, &roles).len() == 1;
        let role = if joints.is_some() || (odometry.is_none() && has_joints) { Role::Joints } else { Role::Odometry };
        let (key, stated) = match role {
            Role::Joints => ("joints", joints.take()),
            _ => ("odometry", odometry.take()),
        };
        self.choose(&mut roles, key, stated, role)?;
        if robot.gyro.is_some() {
            self.choose(&mut roles, "imu", topics.imu.as_ref(), Role::Imu)?;
        }
        if robot.gnss.is_some() && self.keys.gnss.is_some() {
            self.choose(&mut roles, "gnss", topics.gnss.as_ref(), Role::Gnss)?;
        }
        if robot.scanner.is_some() {
            self.choose(&mut roles, "scanner", topics.scanner.as_ref(), Role::Scans)?;
        }
        let cameras = robot.cameras();
        for camera in &cameras {
            let (key, stated) = match camera {
                Camera::Floor => ("floor_camera", topics.floor_camera.as_ref()),
                Camera::Forward => ("forward_camera", topics.forward_camera.as_ref()),
                Camera::Ceiling => ("ceiling_camera", topics.ceiling_camera.as_ref()),
            };
            // Of several cameras none is told from the others by its type.
            if stated.is_none() && cameras.len() > 1 && !self.of_kind(Role::Image(*camera), &roles).is_empty() {
                return Err(self.refuse(
                    key,
                    "is missing, expected the topic of each camera, as the robot has several".to_owned(),
                ));
            }
            self.choose(&mut roles, key, stated, Role::Image(*camera))?;
        }
        self.add_lenses(&mut roles);
        Ok(roles)
    }

    /// Adds the topic that is named for a role, or else the only one of a fitting type if there is one.
    fn choose(
        &self,
        roles: &mut BTreeMap<String, Role>,
        key: &str,
        stated: Option<&String>,
        role: Role,
    ) -> Result<(), LogError> {
        if let Some(name) = stated {
            roles.insert(self.named(&format!("log.topics.{key}"), name, role)?, role);
            return Ok(());
        }
        match self.of_kind(role, roles).as_slice() {
            [] => {}
            [only] => {
                roles.insert((*only).clone(), role);
            }
            several => {
                let names: Vec<String> = several.iter().map(|name| format!("`{name}`")).collect();
                return Err(self.refuse(key, format!("is missing, expected one of {}", names.join(", "))));
            }
        }
        Ok(())
    }

    /// Adds for each camera the topic of its lens, which by ROS's custom stands beside that of its images.
    fn add_lenses(&self, roles: &mut BTreeMap<String, Role>) {
        let images: Vec<(String, Camera)> = roles
            .iter()
            .filter_map(|(name, role)| match role {
                Role::Image(camera) => Some((name.clone(), *camera)),
                _ => None,
            })
            .collect();
        for (name, camera) in images {
            let role = Role::CameraInfo(camera);
            let mut above = name.as_str();
            // A compressed image is one level below the image, as in /camera/image_raw/compressed.
            while let Some((folder, _)) = above.rsplit_once('/') {
                let beside = format!("{folder}/camera_info");
                if self.offered.get(&beside).is_some_and(|topic| role.kinds().contains(&topic.kind.as_str())) {
                    roles.insert(beside, role);
                    break;
                }
                above = folder;
            }
        }
    }

    /// The topics of a fitting type that nothing else is read from.
    fn of_kind(&self, role: Role, roles: &BTreeMap<String, Role>) -> Vec<&String> {
        let fits = |name: &&String| {
            let is_fitting = self.offered.get(*name).is_some_and(|topic| role.kinds().contains(&topic.kind.as_str()));
            is_fitting && !roles.contains_key(*name)
        };
        self.offered.keys().filter(fits).collect()
    }

    /// The topic that a key names, if the log has it and its type fits.
    fn named(&self, key: &str, name: &str, role: Role) -> Result<String, LogError> {
        let found = match self.offered.get(name) {
            Some(topic) if role.kinds().contains(&topic.kind.as_str()) => return Ok(name.to_owned()),
            Some(topic) => format!("is `{name}`, whose type is {}, expected {}", topic.kind, role.kinds().join(" or ")),
            None => {
                let known: Vec<String> = self.offered.keys().map(|name| format!("`{name}`")).collect();
                format!("is `{name}`, which the log does not have, expected {}", one_of(&known))
            }
        };
        Err(self.refuse_key(key, found))
    }

    fn refuse(&self, key: &str, found: String) -> LogError {
        self.refuse_key(&format!("log.topics.{key}"), found)
    }

    fn refuse_key(&self, key: &str, found: String) -> LogError {
        LogError::Topic { log: self.log.to_owned(), robot: self.robot.to_owned(), key: key.to_owned(), found }
    }
}
/// What a log offers, for messages.
fn one_of(known: &[String]) -> String {
    if known.is_empty() {
        "a log with a topic that can be read".to_owned()
    } else {
        format!("one of {}", known.join(", "))
    }
}

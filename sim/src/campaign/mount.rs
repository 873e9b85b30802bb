//! Position of the ceiling camera on the robot, from pictures of ceiling markers while the robot turns on the spot, and the keys of a scene that
//! declare it.
//!
//! Each picture tells where the camera is and how the robot is turned, by the markers of the map and by what the scene declares of the camera. The
//! position on the robot follows from how the camera's place turns with the heading ([`mount_offset`]). What turns with the robot as the position does
//! cannot be told from it, and widens the tolerance: under a ceiling that is h above the camera, a tilt of the camera or of the body by φ by h·tan φ,
//! and a principal point that is off by c pixels by h·c/f, with f the focal length in pixels.

use std::{
    fs,
    path::{Path, PathBuf},
};

use interval::Interval;
use localizer::{
    Pose, RobotModel,
    baselines::locate_upright,
    calibration::{
        TOLERATED_DEVIATIONS,
        mount_offset::{self, MountOffset, Stop},
    },
    map::MarkerMap,
};
use serde_json::{Value, json};

use super::board::{BoardError, decoded};
use crate::{loading::Setting, scene::Scene};

/// Least number of pictures in which a marker is read: with fewer, leaving one out leaves too little.
const LEAST_PICTURES: usize = 8;

/// Why pictures of spins tell no mount. The text of the error follows "failed to".
#[derive(Debug, thiserror::Error)]
pub enum MountError {
    /// The scene has no camera that looks up, or no markers.
    #[error("calibrate a mount by {}: it has no `{key}`, expected the robot with its ceiling camera under markers of its map", scene.display())]
    Lacking {
        /// The scene's file.
        scene: PathBuf,
        /// The key that is missing.
        key: &'static str,
    },
    /// A folder cannot be read.
    #[error("read the spin {}: {source}", path.display())]
    Folder {
        /// The folder.
        path: PathBuf,
        /// Error that the system reported.
        source: std::io::Error,
    },
    /// A picture cannot be read.
    #[error(transparent)]
    Picture(#[from] BoardError),
    /// In too few pictures a marker is read.
    #[error(
        "calibrate a mount by {n_pictures} pictures: in {n_read} a marker of the map is read, expected {LEAST_PICTURES} at least"
    )]
    FewRead {
        /// Number of pictures.
        n_pictures: usize,
        /// Number of pictures in which a marker was read.
        n_read: usize,
    },
    /// The robot hardly turned.
    #[error(
        "calibrate a mount by {0} pictures: the headings hardly differ, expected a turn on the spot of half a circle or more in each folder"
    )]
    HardlyTurned(usize),
}

/// Where the ceiling camera is mounted, by pictures of spins.
#[derive(Clone, Debug)]
pub struct MountCalibration {
    /// Number of spins and of pictures.
    pub n_spins: usize,
    /// Number of pictures in which a marker of the map was read.
    pub n_read: usize,
    /// Pictures in which none was.
    pub missed: Vec<PathBuf>,
    /// The position, and the residual of the fit.
    pub found: MountOffset,
    /// The position that the scene declares, forward and left.
    pub declared_m: [f64; 2],
    /// Standard deviations of the position, forward and left, by the jackknife over pictures.
    pub deviations_m: [f64; 2],
    /// What the tilts of camera and body, and the principal point, may make of the position.
    pub inseparable_m: f64,
    /// Keys of the scene that declare the position.
    pub keys: Vec<Setting>,
}

/// Finds where the ceiling camera of a scene's robot is mounted, from folders with the pictures of one turn on the spot each.
pub fn calibrate_mount(spins: &[PathBuf], scene: &Scene, path: &Path) -> Result<MountCalibration, MountError> {
    let lacking = |key| MountError::Lacking { scene: path.to_owned(), key };
    let robot = scene.robot_model();
    let camera = robot.ceiling_camera.clone().ok_or_else(|| lacking("robot.ceiling_camera"))?;
    let map = scene.map().markers.filter(|map| !map.markers.is_empty()).ok_or_else(|| lacking("markers"))?;
    let declared_m = camera.position_m.map(Interval::mid);
    let (mut stops, mut missed): (Vec<Vec<Stop>>, Vec<PathBuf>) = (Vec::new(), Vec::new());
    let mut n_pictures = 0;
    for folder in spins {
        let mut spin = Vec::new();
        for picture in pictures(folder)? {
            n_pictures += 1;
            match stop(&picture, &map, &robot, declared_m)? {
                Some(stop) => spin.push(stop),
                None => missed.push(picture),
            }
        }
        stops.push(spin);
    }
    let n_read: usize = stops.iter().map(Vec::len).sum();
    if n_read < LEAST_PICTURES {
        return Err(MountError::FewRead { n_pictures, n_read });
    }
    let found = mount_offset::solve(&stops).ok_or(MountError::HardlyTurned(n_read))?;
    let deviations_m = jackknife(&stops).ok_or(MountError::HardlyTurned(n_read))?;
    let above_m = map.markers.iter().map(|marker| marker.height_m.hi() - camera.height_m.lo()).fold(0.0, f64::max);
    let off_px = [0, 1].map(|axis| camera.centre_px[axis].radius() / camera.focal_px[axis].lo());
    let inseparable_m = above_m * ((camera.tilt_rad + robot.body.tilt_rad).tan() + off_px[0].hypot(off_px[1]))
        + found.radius_m() * camera.yaw_rad.radius();
    let within_m = TOLERATED_DEVIATIONS * deviations_m[0].max(deviations_m[1]) + inseparable_m;
    let number = |name: &str, value: f64| Setting::number(&format!("robot.ceiling_camera.{name}"), value);
    let keys = vec![
        number("forward_m", found.position_m[0]),
        number("left_m", found.position_m[1]),
        number("calibration.position_tolerance_m", within_m),
    ];
    Ok(MountCalibration { n_spins: spins.len(), n_read, missed, found, declared_m, deviations_m, inseparable_m, keys })
}

/// The pictures in a folder, in the order of their names.
fn pictures(folder: &Path) -> Result<Vec<PathBuf>, MountError> {
    let unreadable = |source| MountError::Folder { path: folder.to_owned(), source };
    let entries = fs::read_dir(folder).map_err(unreadable)?.collect::<Result<Vec<_>, _>>().map_err(unreadable)?;
    let is_picture = |path: &PathBuf| {
        let ending = path.extension().and_then(|ending| ending.to_str()).unwrap_or_default().to_ascii_lowercase();
        ["png", "jpg", "jpeg", "pgm"].contains(&ending.as_str())
    };
    let mut found: Vec<PathBuf> = entries.into_iter().map(|entry| entry.path()).filter(is_picture).collect();
    found.sort();
    Ok(found)
}

/// Place of the camera and heading of the robot, by the markers in a picture; `None` where no marker of the map is read.
fn stop(path: &Path, map: &MarkerMap, robot: &RobotModel, declared_m: [f64; 2]) -> Result<Option<Stop>, MountError> {
    let picture = decoded(path)?;
    // The pose is that of a robot whose camera is where the scene declares it: the camera's own place depends on no mount.
    let place = |Pose { x_m, y_m, heading_rad }: Pose| {
        let (sin, cos) = heading_rad.sin_cos();
        let [forward_m, left_m] = declared_m;
        [x_m + cos * forward_m - sin * left_m, y_m + sin * forward_m + cos * left_m, heading_rad]
    };
    Ok(locate_upright(&picture, map, robot).map(place))
}

/// Standard deviations of the position by leaving out one picture after the other (Efron, *The Jackknife, the Bootstrap and Other Resampling Plans*,
/// 1982).
fn jackknife(spins: &[Vec<Stop>]) -> Option<[f64; 2]> {
    let mut without: Vec<[f64; 2]> = Vec::new();
    for spin in 0..spins.len() {
        for left_out in 0..spins[spin].len() {
            let mut rest = spins.to_vec();
            rest[spin].remove(left_out);
            without.push(mount_offset::solve(&rest)?.position_m);
        }
    }
    let count = without.len() as f64;
    Some([0, 1].map(|axis| {
        let mean = without.iter().map(|position_m| position_m[axis]).sum::<f64>() / count;
        let squares: f64 = without.iter().map(|position_m| (position_m[axis] - mean).powi(2)).sum();
        ((count - 1.0) / count * squares).sqrt()
    }))
}

impl MountCalibration {
    /// What the terminal shows.
    pub fn text(&self) -> String {
        let mut text = format!(
            "{} pictures of {} spins, {:.1} mm from the camera's place in the root mean square\n{:<14} {:>12} {:>12} {:>12}\n",
            self.n_read,
            self.n_spins,
            1e3 * self.found.rms_m,
            "ceiling camera",
            "declared",
            "found",
            "± 3 σ"
        );
        for (axis, name) in ["forward, mm", "left, mm"].into_iter().enumerate() {
            let [declared, found] = [self.declared_m[axis], self.found.position_m[axis]].map(|at_m| 1e3 * at_m);
            let within = 1e3 * TOLERATED_DEVIATIONS * self.deviations_m[axis];
            text += &format!("{name:<14} {declared:>12.2} {found:>12.2} {within:>12.2}\n");
        }
        text += &format!(
            "Tilts and principal point within their declared tolerances look the same as {:.2} mm of position, which are added. The tolerance holds for \
             the height, too, which no spin tells: measure it as exactly.\n",
            1e3 * self.inseparable_m
        );
        if !self.missed.is_empty() {
            text += &format!("no marker of the map is read in {} pictures\n", self.missed.len());
        }
        text
    }

    /// All that was found, as JSON.
    pub fn to_json(&self) -> Value {
        json!({
            "spins": self.n_spins, "read": self.n_read, "missed": self.missed, "rms_m": self.found.rms_m,
            "declared_m": self.declared_m, "found_m": self.found.position_m, "deviations_m": self.deviations_m,
            "inseparable_m": self.inseparable_m,
            "keys": self.keys.iter().map(|one| (one.key.clone(), json!(one.value))).collect::<serde_json::Map<_, _>>(),
        })
    }
}

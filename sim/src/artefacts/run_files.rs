//! The files that a run leaves behind in `DIR/<scene>/<seed>/`. The folder is written completely or not at all.
//!
//! | file | content |
//! |---|---|
//! | `summary.json` | the verdict with all its figures; equal bytes for equal runs |
//! | `timing.json` | how long the run took, in a file of its own because it differs from run to run |
//! | `truth.tum`, `estimate.tum` | poses, for tools that read TUM trajectories |
//! | `boxes.csv` | every box of every estimate |
//! | `steps.csv` | error, width and judgement at every step |
//! | `post_localization.csv` | boxes at the key frames by what was read later, too, where `localizer.post_window` asks for them |
//! | `distribution.csv` | mean, covariance and normalised error at every step, for a localizer that states distributions |
//! | `landmarks.json` | the map of landmarks in space that the localizer knew at the end, if any, for `localizer.mapped_landmarks.map` |
//! | `errands.csv`, `errands.png` | what became of each errand and a map of them, when the scene has errands |
//! | `marker_tables.md` | Tables 1 to 3 as Zhou et al. 2016 (paper 5) print them, for a run at stations under ceiling markers with baselines |
//! | `subject.log` | what a tested localizer in a process of its own wrote to its standard error, if anything |
//! | `recording.mcap` or `rosbag2/` | all that the localizer was given and answered, when asked for |
//! | `film.png` | a time lapse of what each camera saw, of the map with the answers, and of the outcome (an animated PNG), when asked for |
//! | `image_*.png`, `figure_*.png` | debug frames, when asked for |

use std::{
    fs, io,
    path::{Path, PathBuf},
    process,
    time::{Duration, SystemTime},
};

use localizer::{Estimate, map::Views, reading::Camera};
use serde_json::Value;

use crate::{
    artefacts::{
        debug_frames::{self, Reel},
        recording::Recording,
    },
    devices::camera::world_from_camera,
    judge::Verdict,
    loading::SceneFile,
    place::landmark_map,
    run::{ImageRecord, RunRecord},
    scene::{LandmarkMap, Scene, TrueEye},
};

mod errands;
mod found;
mod marker_tables;
mod poses;

pub(crate) use super::debug_frames::FILM;
pub(crate) use super::digest::{estimates_digest, is_library};
pub use super::digest::{program_digest, run_as_library, scene_digest};
pub(crate) use super::files::naming;
pub use super::files::{RecordError, folder};
pub(crate) use super::summary::width_of;
pub use super::summary::{Summary, Timing, subject_of, width_by_bound};
pub use found::run_folders;
pub(crate) use poses::poses_tum;

/// Creates `out` and makes sure that files can be written into it, so that hours of simulation are not lost at the end.
pub fn prepare(out: &Path) -> Result<(), RecordError> {
    naming("create the folder", out, fs::create_dir_all(out))?;
    let probe = out.join(format!(".probe-{}", process::id()));
    let written = fs::write(&probe, b"wherein");
    // On a full disk the probe file exists in spite of the error, and is empty.
    let removed = fs::remove_file(&probe);
    naming("write into the folder", out, written)?;
    naming("delete", &probe, removed)
}

/// Creates the folder of a file that will be written at the end, and makes sure that files can be written into it.
pub fn prepare_for(file: &Path) -> Result<(), RecordError> {
    let folder = file.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    prepare(folder)
}

/// Writes all files of a run, with debug frames of the images that the run's `record` has kept, and returns the run's folder.
///
/// An existing folder of the same run is replaced. If an error occurs, the existing folder stays as it was.
pub fn write(out: &Path, file: &SceneFile, record: &RunRecord, verdict: &Verdict) -> Result<PathBuf, RecordError> {
    write_with(out, file, record, verdict, Followed::default())
}

/// What observers have kept of a run while it happened, for its folder.
#[derive(Default)]
pub struct Followed {
    /// The recordings.
    pub recordings: Vec<Recording>,
    /// What the film shows of the cameras.
    pub reel: Option<Reel>,
}

/// Writes like [`write()`], and adds what observers have kept of the run.
pub fn write_with(
    out: &Path,
    file: &SceneFile,
    record: &RunRecord,
    verdict: &Verdict,
    followed: Followed,
) -> Result<PathBuf, RecordError> {
    let target = folder(out, &file.name, record.seed);
    clear_stale(target.parent().unwrap_or(out));
    replace_whole(&target, |partial| fill(partial, file, record, verdict, followed))?;
    Ok(target)
}

/// Puts a new folder, filled by `fill`, in the place of `target`: completely or, when `fill` fails, not at all.
pub(crate) fn replace_whole(
    target: &Path,
    fill: impl FnOnce(&Path) -> Result<(), RecordError>,
) -> Result<(), RecordError> {
    let beside = target.parent().unwrap_or(target);
    naming("create the folder", beside, fs::create_dir_all(beside))?;
    let name = target.file_name().unwrap_or_default().to_string_lossy();
    let partial = beside.join(format!(".{name}-{}{PARTIAL}", process::id()));
    let created = naming("create the folder", &partial, fs::create_dir_all(&partial));
    let written = created.and_then(|()| fill(&partial)).and_then(|()| replace(target, &partial));
    if written.is_err() {
        // The error that is returned says what is wrong; what cannot be deleted here is cleared by a later run.
        let _ = fs::remove_dir_all(&partial);
    }
    written
}

/// Writes `estimate.tum` and `boxes.csv` of the given estimates into `folder`, replacing older ones.
pub fn write_estimates(folder: &Path, estimates: &[Estimate]) -> Result<(), RecordError> {
    naming("create the folder", folder, fs::create_dir_all(folder))?;
    for (name, text) in [("estimate.tum", poses::estimate_tum(estimates)), ("boxes.csv", poses::boxes_csv(estimates))] {
        replace_file(&folder.join(name), &text)?;
    }
    Ok(())
}

/// Puts bytes in the place of the file `path`, which need not exist: completely or, when that fails, not at all. A file that exists keeps its
/// permissions, and a link goes on to name its file. What exists and is no file, such as a device or a pipe, is written to as it is.
pub(crate) fn replace_file(path: &Path, bytes: impl AsRef<[u8]>) -> Result<(), RecordError> {
    let before = fs::metadata(path).ok();
    if before.as_ref().is_some_and(|before| !before.is_file()) {
        return naming("write", path, fs::write(path, bytes));
    }
    let target = fs::canonicalize(path).unwrap_or_else(|_| path.to_path_buf());
    let name = target.file_name().unwrap_or_default().to_string_lossy();
    let partial = target.with_file_name(format!(".{name}-{}{PARTIAL}", process::id()));
    let written = naming("write", path, fs::write(&partial, bytes)).and_then(|()| {
        if let Some(before) = before {
            naming("keep the permissions of", path, fs::set_permissions(&partial, before.permissions()))?;
        }
        naming("create", path, fs::rename(&partial, &target))
    });
    if written.is_err() {
        // The error that is returned says what is wrong.
        let _ = fs::remove_file(&partial);
    }
    written
}

/// Reads the summary and the timing that a run left in `folder`; `None` when there is no summary.
pub fn read(folder: &Path) -> Result<Option<(Value, Value)>, RecordError> {
    let summary = folder.join("summary.json");
    if !summary.exists() {
        return Ok(None);
    }
    Ok(Some((read_json(&summary)?, read_json(&folder.join("timing.json"))?)))
}

fn read_json(path: &Path) -> Result<Value, RecordError> {
    let text = naming("read", path, fs::read_to_string(path))?;
    naming("read", path, serde_json::from_str(&text).map_err(io::Error::from))
}

/// File in the folder of a run with what the localizer under test wrote for its author.
pub(crate) const SUBJECT_LOG: &str = "subject.log";

/// File in the folder of a run with the map of landmarks in space that the localizer knew at the end.
pub(crate) const LANDMARKS: &str = "landmarks.json";

/// File in the folder of a run with the boxes at its key frames by what was read later, too.
pub(crate) const POST_LOCALIZATION: &str = "post_localization.csv";

/// Ending of the name of a folder or file that is still being written.
const PARTIAL: &str = ".partial";

/// Ending of the name of a folder that has been moved aside for a newer one.
const REPLACED: &str = ".replaced";

/// Writes all files of a run into an empty folder.
pub(crate) fn fill(
    partial: &Path,
    file: &SceneFile,
    record: &RunRecord,
    verdict: &Verdict,
    followed: Followed,
) -> Result<(), RecordError> {
    let write = |name: &str, content: String| {
        let path = partial.join(name);
        naming("write", &path, fs::write(&path, content))
    };
    write("truth.tum", poses::truth_tum(record))?;
    write("estimate.tum", poses::estimate_tum(&record.estimates))?;
    write("boxes.csv", poses::boxes_csv(&record.estimates))?;
    write("steps.csv", poses::steps_csv(record, verdict))?;
    if let Some(text) = poses::post_localization_csv(record) {
        write(POST_LOCALIZATION, text)?;
    }
    if let Some(text) = poses::distribution_csv(record) {
        write("distribution.csv", text)?;
    }
    if let Some(log) = &record.errands {
        write("errands.csv", errands::errands_csv(record, log))?;
        debug_frames::write_errands(partial, file, record)?;
    }
    if let Some(log) = record.subject_log.as_ref().filter(|log| !log.is_empty()) {
        write(SUBJECT_LOG, log.clone())?;
    }
    if let Some(map) = learnt_map(&file.scene, record) {
        write(LANDMARKS, landmark_map::text(&map))?;
    }
    if let Some(tables) = marker_tables::marker_tables(&file.scene, record) {
        write("marker_tables.md", tables)?;
    }
    let shown = debug_frames::write(partial, file, record)?;
    if shown == 0 && !verdict.verdict.passed {
        debug_frames::write_widest(partial, file, record)?;
    }
    write("timing.json", format!("{:#}\n", Timing::of(file, record).to_json()))?;
    let summary = Summary::of(file, record, verdict);
    if let Some(reel) = &followed.reel {
        debug_frames::write_film(partial, file, record, verdict, reel)?;
    }
    for recording in followed.recordings {
        recording.finish(&summary, partial)?;
    }
    write("summary.json", summary.to_text())
}

/// The map of the landmarks in space that the localizer knew at the end of a run, if there are any.
fn learnt_map(scene: &Scene, record: &RunRecord) -> Option<LandmarkMap> {
    let landmarks = record.space_points.clone();
    let relied = record.estimates.last().map_or(&[][..], |estimate| &estimate.relies_on);
    let mut relies_on: Vec<String> = relied.iter().map(|bound| (*bound).to_owned()).collect();
    // Landmarks of a map go on relying on what they relied on when they were learnt.
    let earlier = scene.localizer.mapped_landmarks().known.map_or_else(Vec::new, |map| map.relies_on);
    relies_on.extend(earlier.into_iter().filter(|bound| !relied.contains(&bound.as_str())));
    let room_m = [scene.room.width_m, scene.room.depth_m];
    let looks = record.looks.clone();
    let views = record.views.clone().unwrap_or_default();
    let true_eyes = true_eyes(scene, record, &views).unwrap_or_default();
    (!landmarks.is_empty()).then_some(LandmarkMap { room_m, relies_on, landmarks, looks, views, true_eyes })
}

/// The cameras that truly took the pictures of a run's views, and those of the map that it was given; `None` where one of them is not known.
fn true_eyes(scene: &Scene, record: &RunRecord, views: &Views) -> Option<Vec<TrueEye>> {
    let given = scene.localizer.mapped_landmarks().known;
    let (n_given, mut eyes) = given.map_or((0, Vec::new()), |map| (map.views.pictures.len(), map.true_eyes));
    if eyes.len() != n_given {
        return None;
    }
    let drawn = record.drawn.devices.forward_camera.as_ref()?;
    for picture in views.pictures.iter().skip(eyes.len()) {
        let is_it = |image: &&ImageRecord| image.camera == Some(Camera::Forward) && image.measured_s == picture.stamp_s;
        let image = record.images.iter().find(is_it)?;
        eyes.push(TrueEye {
            world_from_camera: world_from_camera(&image.truth, drawn),
            focal_px: drawn.focal_px[0],
            centre_px: drawn.principal_point_px,
        });
    }
    Some(eyes)
}

/// Puts the folder `partial` in the place of `target`. A run that is killed between the two renames leaves the old folder under another name.
fn replace(target: &Path, partial: &Path) -> Result<(), RecordError> {
    let old = partial.with_extension(&REPLACED[1..]);
    if target.exists() {
        naming("move aside", target, fs::rename(target, &old))?;
    }
    if let Err(error) = naming("create", target, fs::rename(partial, target)) {
        if old.exists() {
            naming("restore", target, fs::rename(&old, target))?;
        }
        return Err(error);
    }
    if old.exists() { naming("delete", &old, fs::remove_dir_all(&old)) } else { Ok(()) }
}

/// Deletes what runs that were killed while writing left in `folder`. Entries less than an hour old stay: they may belong to a running process.
fn clear_stale(folder: &Path) {
    const STALE: Duration = Duration::from_secs(3600);
    let Ok(entries) = fs::read_dir(folder) else { return };
    for entry in entries.flatten() {
        let name = entry.file_name().to_string_lossy().into_owned();
        let modified = entry.metadata().and_then(|metadata| metadata.modified()).unwrap_or_else(|_| SystemTime::now());
        let is_stale = modified.elapsed().is_ok_and(|age| age > STALE);
        if name.starts_with('.') && (name.ends_with(PARTIAL) || name.ends_with(REPLACED)) && is_stale {
            // Another process may be clearing the same folder at the same time; in either case the entry is gone.
            let _ = fs::remove_dir_all(entry.path()).or_else(|_| fs::remove_file(entry.path()));
        }
    }
}

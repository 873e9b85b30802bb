//! SHA-256 digests of the bytes in which scenes, true states and estimates are written in one fixed form: two runs are equal if and only if their
//! digests are.

use std::{env, fmt::Write, fs, io, path::PathBuf, sync::OnceLock};

use localizer::{Estimate, Status};
use sha2::{Digest, Sha256};

use crate::{
    place::{landmark_map, navigation::map_server},
    scene::Scene,
    truth::Truth,
};

/// Digest of all that a scene states and of the maps that it names. The layout and the comments of the scene's file do not matter, nor does where a map of
/// landmarks is found.
pub fn scene_digest(scene: &Scene) -> String {
    let mut stated = scene.clone();
    if let Some(setup) = stated.localizer.mapped_landmarks.as_mut().filter(|setup| setup.known.is_some()) {
        setup.map = None;
    }
    // The keys of a scene are texts, so that serialising it cannot fail.
    let mut hasher = Sha256::new_with_prefix(serde_json::to_vec(&stated).unwrap_or_default());
    if let Some(grid) = scene.navigation.as_ref().and_then(|navigation| navigation.surveyed.as_ref()) {
        hasher.update(map_server::header(grid, ""));
        hasher.update(map_server::pgm(grid));
    }
    if let Some(known) = scene.localizer.mapped_landmarks.as_ref().and_then(|setup| setup.known.as_ref()) {
        hasher.update(landmark_map::text(known));
    }
    hex(&hasher.finalize())
}

/// File of the library by which a program of another kind, such as an interpreter, runs this code; none for the command `wherein`.
static LIBRARY: OnceLock<PathBuf> = OnceLock::new();

/// Says that this code runs as a library of another program, in the file `library`: results are then those of the library's build.
pub fn run_as_library(library: PathBuf) {
    // Whoever says so first is right, as a process loads the library once.
    let _ = LIBRARY.set(library);
}

/// Whether this code runs as a library of another program.
pub(crate) fn is_library() -> bool {
    LIBRARY.get().is_some()
}

/// Digest of the running program's own file, or of the library's where this code runs as a library. By it a program recognises results of its own build and does not take those of another.
///
/// `None` when the system does not let a program read its own file; then no results are taken as its own.
pub fn program_digest() -> Option<&'static str> {
    static DIGEST: OnceLock<Option<String>> = OnceLock::new();
    let of_file = || {
        let mut hasher = Sha256::new();
        io::copy(
            &mut fs::File::open(LIBRARY.get().cloned().map_or_else(env::current_exe, Ok)?)?,
            &mut Hashing(&mut hasher),
        )?;
        io::Result::Ok(hex(&hasher.finalize()))
    };
    DIGEST.get_or_init(|| of_file().ok()).as_deref()
}

/// Digest of every field of the run's true states, in the order of the fields of `Truth`, as little-endian f64.
pub(super) fn truth_digest(truths: &[Truth]) -> String {
    let mut numbers = Numbers::default();
    for truth in truths {
        numbers.add(&[truth.time_s]);
        numbers.add(&truth.pose.to_array());
        numbers.add(&truth.velocity);
        numbers.add(&[truth.heave_m]);
        numbers.add(&truth.tilt_rad);
        numbers.add(&truth.wheel_angle_rad);
        numbers.add(&truth.wheel_travel_m);
        numbers.add(&[truth.lateral_travel_m]);
    }
    numbers.digest()
}

/// Digest of every estimate's time, status, number of boxes and all bounds of its boxes, as little-endian f64.
pub(crate) fn estimates_digest(estimates: &[Estimate]) -> String {
    let mut numbers = Numbers::default();
    for estimate in estimates {
        let is_sound = f64::from(u8::from(estimate.status == Status::Sound));
        numbers.add(&[estimate.time_s, is_sound, estimate.pose.branches.len() as f64]);
        for side in estimate.pose.branches.iter().flat_map(|branch| branch.components()) {
            numbers.add(&[side.lo(), side.hi()]);
        }
    }
    numbers.digest()
}

#[derive(Default)]
struct Numbers(Sha256);

impl Numbers {
    fn add(&mut self, numbers: &[f64]) {
        for number in numbers {
            self.0.update(number.to_le_bytes());
        }
    }

    fn digest(self) -> String {
        hex(&self.0.finalize())
    }
}

struct Hashing<'a>(&'a mut Sha256);

impl io::Write for Hashing<'_> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.0.update(bytes);
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

fn hex(bytes: &[u8]) -> String {
    bytes.iter().fold(String::new(), |mut text, byte| {
        // Writing to a `String` cannot fail.
        let _ = write!(text, "{byte:02x}");
        text
    })
}

use std::{
    fs,
    path::{Path, PathBuf},
    process::{Command, Output},
};

use sim::loading::SceneFile;

/// A folder for one test alone, empty at first.
pub(crate) fn folder(name: &str) -> PathBuf {
    let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
    let _ = fs::remove_dir_all(&path);
    fs::create_dir_all(&path).unwrap();
    path
}

/// A folder for one test alone with these files in it, each with its path and its text.
pub(crate) fn folder_of(name: &str, texts: &[(&str, &str)]) -> PathBuf {
    let folder = folder(name);
    for (file, text) in texts {
        let path = folder.join(file);
        fs::create_dir_all(path.parent().unwrap()).unwrap();
        fs::write(path, text).unwrap();
    }
    folder
}

/// How many rounds, seeds or scenes of a test to go through: `few` in `make test`, `all` in `make test-long`, which sets `WHEREIN_LONG`.
pub(crate) fn rounds<N>(few: N, all: N) -> N {
    if std::env::var_os("WHEREIN_LONG").is_some() { all } else { few }
}

/// The root folder of the repository.
pub(crate) fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR")).parent().unwrap()
}

/// A scene of the repository as one text, merged with the scenes that it extends.
pub(crate) fn scene_text(path: &str) -> String {
    let file = SceneFile::load(&root().join("scenes").join(path));
    file.unwrap_or_else(|error| panic!("failed to {error}")).text
}

/// The command `wherein` with these arguments, to be run in `folder`.
pub(crate) fn wherein(folder: &Path, arguments: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_wherein-under-test"));
    command.current_dir(folder).args(arguments);
    command
}

/// The exit code, standard output and standard error of a command.
pub(crate) fn outcome(command: &mut Command) -> (i32, String, String) {
    let Output { status, stdout, stderr } = command.output().unwrap();
    (status.code().unwrap(), String::from_utf8(stdout).unwrap(), String::from_utf8(stderr).unwrap())
}

/// Text of a scene without a camera, so that a run takes milliseconds. `more` is appended to that text.
pub(crate) fn blind_scene(duration_s: f64, more: &str) -> String {
    format!(
        "duration_s = {duration_s}\n[room]\nwidth_m = 3.0\ndepth_m = 2.0\n[robot]\nfloor_camera = false\n\
         [start]\nx_m = 0.6\ny_m = 0.6\n[[route.waypoint]]\nx_m = 2.4\ny_m = 1.2\n{more}"
    )
}

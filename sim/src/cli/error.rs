//! Reasons why a command could not be carried out, and the messages that the user reads.

use std::{
    io::{self, IsTerminal, Write},
    path::PathBuf,
};

use crate::{
    artefacts::{
        log::LogError,
        replay::ReplayError,
        result_table::{self, UnknownColumn},
        run_files::RecordError,
    },
    campaign::{
        board::BoardError, comparison::SideError, falsify::FalsifyError, mount::MountError, sharpness::SharpnessError,
        sweep::SweepError,
    },
    loading::UpgradeError,
    render::RenderError,
    scene::SceneError,
};

/// Why a command could not be carried out. The text of the error follows "failed to".
#[derive(Debug, thiserror::Error)]
pub(super) enum CommandError {
    #[error(transparent)]
    Scene(#[from] SceneError),
    #[error(transparent)]
    Map(#[from] crate::place::navigation::map_server::MapError),
    #[error("teach a map by {0} drives, expected one scene and one seed")]
    SeveralTaught(usize),
    #[error("teach a map by {}: `{key}` leaves nothing to learn, expected {expected}", scene.display())]
    TeachesNothing { scene: PathBuf, key: &'static str, expected: &'static str },
    #[error("teach a map by {}: no landmark was seen where the pose was known, or images contradict each other, expected a `[robot.point_camera]` and some `[[landmark]]` in its view, or a `[robot.forward_camera]` and textured surfaces in its view", .0.display())]
    LearntNothing(PathBuf),
    #[error("write the map {}: it is a file that is no map, expected a map to replace, or a path without a file", .0.display())]
    NoMapToReplace(PathBuf),
    #[error("{command} with `--subject {subject}`: it is given no map, expected no `--subject`, or `wherein run`")]
    KnowsNoMap { command: &'static str, subject: String },
    #[error("repeat {} by a map: `localizer.methods` uses none, expected `mapped_landmarks` among them", .0.display())]
    UsesNoMap(PathBuf),
    #[error("write `--out {}`: it is the scene of the robot itself, expected another file, which extends it", path.display())]
    OutIsInput { path: PathBuf },
    #[error("set a key: {0}")]
    Setting(String),
    #[error(transparent)]
    Render(#[from] RenderError),
    #[error(transparent)]
    Replay(#[from] ReplayError),
    #[error(transparent)]
    Log(#[from] LogError),
    #[error(transparent)]
    Board(#[from] BoardError),
    #[error(transparent)]
    Mount(#[from] MountError),
    #[error(transparent)]
    Record(#[from] RecordError),
    #[cfg(feature = "live")]
    #[error(transparent)]
    Live(#[from] crate::artefacts::recording::LiveError),
    #[error(transparent)]
    Sweep(#[from] SweepError),
    #[error(transparent)]
    Falsify(#[from] FalsifyError),
    #[error(transparent)]
    Sharpness(#[from] SharpnessError),
    #[error(transparent)]
    Side(#[from] SideError),
    #[error("compare {} and {}: no case ran in both, expected the same scenes, settings and seeds", .0.display(), .1.display())]
    NoPairs(PathBuf, PathBuf),
    #[error("find results in {}: expected summary.json files that `wherein run` wrote", .0.display())]
    NoResults(PathBuf),
    #[error("report on {0} folders: expected one, or --out with the folder for the report on all of them")]
    SeveralReported(usize),
    #[error("write {}: a report on tables keeps no cases for JUnit XML, expected one folder of results without --out", .0.display())]
    TestsOfTables(PathBuf),
    #[error("write {}: {n_cases} cases, expected at most {most} for JUnit XML", path.display())]
    TooManyTests { path: PathBuf, n_cases: usize, most: usize },
    #[error("put the table into {}: expected a line `{} -->` and after it a line `{}`", .0.display(), result_table::BEGIN, result_table::END)]
    NoMarkers(PathBuf),
    #[error("put a table into {}: {source}", document.display())]
    Marker { document: PathBuf, source: UnknownColumn },
    #[error("render {}: it stands for {count} scenes, expected one scene file", path.display())]
    SeveralScenes { path: PathBuf, count: usize },
    #[error(
        "render {}: its robot has no {}camera, expected a table such as `[robot.forward_camera]`",
        scene.display(),
        wanted.map(|name| format!("{name} ")).unwrap_or_default()
    )]
    NoCamera { scene: PathBuf, wanted: Option<&'static str> },
    #[error("render {} --at {},{}: outside the room, expected x from {} to {} and y from {} to {}, as the robot's body reaches {reach_m} m about its origin", scene.display(), at_m[0], at_m[1], reach_m, room_m[0] - reach_m, reach_m, room_m[1] - reach_m)]
    OutsideRoom { scene: PathBuf, at_m: [f64; 2], room_m: [f64; 2], reach_m: f64 },
    #[error("render {} --at {},{}: in no room or by a wall, expected {reach_m} m of distance from walls, as the robot's body reaches that far about its origin", scene.display(), at_m[0], at_m[1])]
    ByWall { scene: PathBuf, at_m: [f64; 2], reach_m: f64 },
    #[error("render {} --at {},{}: in or by {piece}, expected {reach_m} m of distance, as the robot's body reaches that far about its origin", scene.display(), at_m[0], at_m[1])]
    InFurniture { scene: PathBuf, at_m: [f64; 2], piece: String, reach_m: f64 },
    #[error("upgrade {}: failed to {}", .0.display(), .1)]
    Upgrade(PathBuf, UpgradeError),
    #[error("write {}: {}", .0.display(), .1)]
    Unwritable(PathBuf, io::Error),
    #[error("find markers in {}: expected a table `[markers]` with at least one marker on the map", .0.display())]
    NoCeilingMarkers(PathBuf),
    #[error("write {}: it exists already, expected another folder by --out", .0.display())]
    Exists(PathBuf),
    #[error("measure the sharpness of {}: `{key}` is missing or not allowed, expected {expected}", run.display())]
    UnknownRun { run: PathBuf, key: &'static str, expected: &'static str },
    #[error("measure the sharpness of {}: `digest.readings` is {now} when simulated again, expected {recorded} as recorded, by the same version and graphics adapter", run.display())]
    OtherReadings { run: PathBuf, recorded: String, now: String },
    #[error("print: {0}")]
    Output(#[from] io::Error),
}

impl CommandError {
    /// Prints the error message and, for a mistake in a scene file, the place of the mistake below it.
    pub(super) fn complain(&self) {
        // A closed standard error is no failure: its reader may stop early.
        let _ = writeln!(io::stderr(), "wherein: failed to {self}");
        let (CommandError::Scene(scene @ SceneError::Invalid { .. })
        | CommandError::Replay(ReplayError::Scene(scene @ SceneError::Invalid { .. }))
        | CommandError::Sweep(SweepError::Scene(scene @ SceneError::Invalid { .. }))) = self
        else {
            return;
        };
        if let Some(place) = scene.place(io::stderr().is_terminal()) {
            let _ = writeln!(io::stderr(), "{place}");
        }
    }
}

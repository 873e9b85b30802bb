//! The command `wherein`: what it is asked, and how it answers.

use std::{
    io::{self, IsTerminal, Write},
    net::SocketAddr,
    path::PathBuf,
    process::ExitCode,
};

use clap::{Args, Parser, Subcommand};
use clap_complete::Shell;
use localizer::reading::Camera;
use miette::{GraphicalReportHandler, GraphicalTheme};

use crate::{
    artefacts::{recording::LiveError, replay::ReplayError, run_files::RecordError},
    campaign::{
        comparison::SideError,
        falsify::FalsifyError,
        sweep::{Seeds, SweepError},
    },
    loading::{SceneTemplate, Setting},
    render::RenderError,
    run::FramesPolicy,
    scene::{SceneError, keys_markdown, schema_text},
};

mod compare;
mod conclude;
mod falsify;
mod github;
mod manual;
mod map;
mod markers;
mod render;
mod replay;
mod report;
mod results_arguments;
mod run;
mod sweep;
mod table;
mod weaken;

pub use render::{At, Lights};
use results_arguments::{CompareArguments, MergeArguments, Outputs, ReportArguments, SweepArguments};

/// Simulates an indoor robot and its cameras, localizes it by interval boxes, and checks every box against the truth.
#[derive(Debug, Parser)]
#[command(name = "wherein", version, arg_required_else_help = true, after_help = AFTER_HELP)]
struct Cli {
    /// Graphics adapter to render with, by a part of its name, driver or backend. WHEREIN_ADAPTER says the same.
    #[arg(long, value_name = "NAME", global = true)]
    adapter: Option<String>,
    #[command(subcommand)]
    command: Command,
}

const AFTER_HELP: &str = "\
Examples:
  wherein run scenes/papers/floor_vision_odometry.toml            one run with seed 0
  wherein run scenes --seeds 0..10 --out results                  every scene, ten seeds each
  wherein run scenes/x.toml --seed 7 --frames failures            pictures of what went wrong with seed 7
  wherein sweep scenes/x.toml --vary light.illuminance_at_floor_lux=1,10,100 --seeds 0..20
                                                                  every value with twenty seeds, and a report
  wherein falsify --minutes 10                                    random scenes against the promise
  wherein weaken scenes/x.toml --set robot.errors=corner          how tight its bounds are
  wherein render scenes/x.toml --at 1.5,2,90                      what each camera sees from there
  wherein run scenes/x.toml --record                              a recording that Foxglove and Rerun open
  wherein run scenes/x.toml --live                                the same while it happens
  wherein replay renders/x/0/recording.mcap                       the localizer on that recording, bit for bit
  wherein markers scenes/x.toml                                   the sheet and the map of its ceiling markers
  wherein scene scenes/x.toml                                     the scene with what it extends, as one text
  wherein schema > scenes/schema.json                             what an editor needs to complete and check scenes

Exit code: 0 every run met its scene's expectations, 1 some did not, 2 could not run.";

#[derive(Debug, Subcommand)]
enum Command {
    /// Runs scenes and records what they leave behind.
    Run(RunArguments),
    /// Tells the localizer ever narrower bounds until it loses the truth: how tight the declared ones are.
    Weaken(WeakenArguments),
    /// Runs one scene with every combination of the values of some keys, and reports on all of them.
    Sweep(SweepArguments),
    /// Writes the report of a folder of results: report.html, summary.md and results.csv.
    Report(ReportArguments),
    /// Says in which figures results are better or worse than others, case by case.
    Compare(CompareArguments),
    /// Brings the parts of a sweep together that several machines ran with --shard.
    Merge(MergeArguments),
    /// Searches random scenes for one that breaks the promise, and makes it small.
    Falsify(falsify::FalsifyArguments),
    /// Takes pictures of a robot that stands still, one per camera.
    Render(RenderArguments),
    /// Writes the sheet to print of a scene's ceiling markers and their map, and says whether they cover the room.
    Markers(MarkersArguments),
    /// Runs the localizer on a recording, without the simulator, and compares its estimates with the recorded ones.
    Replay(ReplayArguments),
    /// Prints a Markdown table of recorded runs, or puts it into a document.
    Table(TableArguments),
    /// Writes a scene's occupancy grid as files of ROS's map_server.
    Map(MapArguments),
    /// Prints a scene as one text, with what it extends and what is set.
    Scene(SceneArguments),
    /// Prints the JSON schema of scene files.
    Schema {
        /// Print a page of all keys to read instead.
        #[arg(long)]
        markdown: bool,
    },
    /// Prints completions for a shell, to be put where it looks for them.
    Completions {
        /// The shell.
        shell: Shell,
    },
    /// Prints the manual page of the command, or writes one for each subcommand too.
    Man {
        /// Write wherein.1, wherein-run.1 and so on into this folder instead.
        #[arg(long, value_name = "DIR")]
        out: Option<PathBuf>,
    },
    /// Prints the graphics adapter that renders the images; exit code 2 when there is none.
    Adapter,
}

/// What `wherein run` is asked.
#[derive(Debug, Args)]
#[command(after_help = RUN_AFTER_HELP)]
struct RunArguments {
    /// Scene files, or folders that stand for all scenes below them.
    #[arg(required = true, value_name = "PATH")]
    paths: Vec<PathBuf>,
    /// Seed of everything drawn in the run.
    #[arg(long, value_name = "N", default_value_t = 0, conflicts_with = "seeds")]
    seed: u64,
    /// Several seeds, A included and B not.
    #[arg(long, value_name = "A..B")]
    seeds: Option<Seeds>,
    /// Set a key of the scenes, such as floor.friction=0.3; may be given several times.
    #[arg(long, value_name = "KEY=VALUE")]
    set: Vec<Setting>,
    /// Where results go.
    #[arg(long, value_name = "DIR", default_value = "renders")]
    out: PathBuf,
    /// Images of which to leave debug frames: none, failures, every=N or all.
    #[arg(long, value_name = "WHICH", default_value = "none")]
    frames: FramesPolicy,
    /// Print the summaries as a JSON list instead of a table.
    #[arg(long)]
    json: bool,
    /// Leave recording.mcap too: images, readings, poses, boxes and log messages, for Foxglove, Rerun and `wherein replay`.
    #[arg(long)]
    record: bool,
    /// Leave the recording as rosbag2/, a bag that ROS 2 and `evo` open; its boxes are markers of ROS 2.
    #[arg(long, conflicts_with = "record")]
    ros2: bool,
    /// Let viewers such as Foxglove look on, in real time; the first run begins when one is there.
    #[arg(long, value_name = "ADDRESS", num_args = 0..=1, require_equals = true, default_missing_value = "127.0.0.1:8765")]
    live: Option<SocketAddr>,
    /// Write the results as JUnit XML, too.
    #[arg(long, value_name = "FILE")]
    junit: Option<PathBuf>,
    /// Skip runs that this build of the program has already recorded for the same scene; continues what was interrupted.
    #[arg(long)]
    resume: bool,
}

const RUN_AFTER_HELP: &str = "\
Each run leaves DIR/<scene>/<seed>/ with summary.json (all figures, and whether the scene's [expect] was met),
timing.json, truth.tum and estimate.tum (poses), boxes.csv (every box), and the frames and the recording asked for.

In the table, a check is one step of 10 ms. `contained`: the truth is in a box. Outside of it, the cause is named:
`bound broken`: a declared bound was exceeded, and the same commands with it kept hold the truth; `perception`: the vision saw
what is not there, and without it they do; `unsound`: neither.
Errors are root mean squares of the worst third of a run, widths are full widths of the box.";

/// What `wherein weaken` is asked.
#[derive(Debug, Args)]
#[command(after_help = WEAKEN_AFTER_HELP)]
struct WeakenArguments {
    /// Scene files, or folders that stand for all scenes below them.
    #[arg(required = true, value_name = "PATH")]
    paths: Vec<PathBuf>,
    /// Seed of everything drawn in the run.
    #[arg(long, value_name = "N", default_value_t = 0, conflicts_with = "seeds")]
    seed: u64,
    /// Several seeds, A included and B not.
    #[arg(long, value_name = "A..B")]
    seeds: Option<Seeds>,
    /// Set a key of the scenes, such as robot.errors=corner; may be given several times.
    #[arg(long, value_name = "KEY=VALUE")]
    set: Vec<Setting>,
    /// Print a JSON list instead of a table.
    #[arg(long)]
    json: bool,
}

const WEAKEN_AFTER_HELP: &str = "\
Each run is simulated again by its own commands and with its own draws, the localizer told 0.9, 0.8, … 0.1 of every bound that
the scene declares, until the truth is outside, no box is left, or an assumption is doubted. 1 / that share is printed: 1.0 for
bounds that are all used, above 3 where nobody would notice boxes a third as wide. Where the robot starts is told as it is.
What is lost in the first 5 s of a drive, or in its first half where it is shorter than 10 s, does not count unless it still is lost then:
before, wheels and gyroscope are alone with errors at their corners, and no method has told anything.
With robot.errors=corner errors are as large as declared. Exit code: 0 it ran, 2 it could not.";

/// What `wherein scene` is asked.
#[derive(Debug, Args)]
struct SceneArguments {
    /// Scene file.
    #[arg(value_name = "SCENE")]
    scene: PathBuf,
    /// Set a key of the scene, such as floor.friction=0.3; may be given several times.
    #[arg(long, value_name = "KEY=VALUE")]
    set: Vec<Setting>,
}

/// What `wherein map` is asked.
#[derive(Debug, Args)]
struct MapArguments {
    /// Scene file.
    #[arg(value_name = "SCENE")]
    scene: PathBuf,
    /// Where map.yaml and map.pgm go, below the scene's name.
    #[arg(long, value_name = "DIR", default_value = "renders")]
    out: PathBuf,
}

/// What `wherein render` is asked.
#[derive(Debug, Args)]
#[command(after_help = RENDER_AFTER_HELP)]
struct RenderArguments {
    /// Scene file.
    #[arg(value_name = "SCENE")]
    scene: PathBuf,
    /// Where the robot stands: x and y in metres, heading in degrees. The scene's start unless given.
    #[arg(long, value_name = "X,Y,HEADING", allow_hyphen_values = true)]
    at: Option<At>,
    /// One camera only: floor, forward or ceiling.
    #[arg(long, value_name = "NAME", value_parser = camera_name)]
    camera: Option<Camera>,
    /// Mean illuminance at the floor in lux, all lamps dimmed alike. What the scene states unless given.
    #[arg(long, value_name = "LUX", value_parser = render::illuminance, allow_hyphen_values = true, conflicts_with = "contact_sheet")]
    lux: Option<f64>,
    /// One sheet with all cameras in several lights, such as lux=0.1,1,10,100,1000.
    #[arg(long, value_name = "lux=A,B,…")]
    contact_sheet: Option<Lights>,
    /// Seed of mounts, tiles and noise.
    #[arg(long, value_name = "N", default_value_t = 0)]
    seed: u64,
    /// Where pictures go.
    #[arg(long, value_name = "DIR", default_value = "renders")]
    out: PathBuf,
}

const RENDER_AFTER_HELP: &str = "\
Writes DIR/<scene>/<camera>.png as the sensor gave it and <camera>_tone_mapped.png as a screen should show it,
or DIR/<scene>/contact_sheet.png. Exposures are those on which automatic exposure settles.";

fn camera_name(text: &str) -> Result<Camera, String> {
    let found = Camera::ALL.into_iter().find(|name| name.as_str() == text);
    found.ok_or_else(|| format!("expected one of {}", Camera::ALL.map(Camera::as_str).join(", ")))
}

/// What `wherein markers` is asked.
#[derive(Debug, Args)]
#[command(after_help = MARKERS_AFTER_HELP)]
struct MarkersArguments {
    /// Scene file.
    #[arg(value_name = "SCENE")]
    scene: PathBuf,
    /// Where sheet and map go.
    #[arg(long, value_name = "DIR", default_value = "renders")]
    out: PathBuf,
}

const MARKERS_AFTER_HELP: &str = "\
Writes DIR/<scene>/markers.pdf, one marker a page of A4 at true scale, and DIR/<scene>/markers.toml, the keys of a scene
that place them one by one. Files that are there already are left alone: exit code 2.";

/// What `wherein replay` is asked.
#[derive(Debug, Args)]
#[command(after_help = REPLAY_AFTER_HELP)]
struct ReplayArguments {
    /// A recording that `wherein run --record` or `--ros2` left.
    #[arg(value_name = "FILE")]
    recording: PathBuf,
    /// Set up the localizer as this scene does instead of the recorded one.
    #[arg(long, value_name = "SCENE")]
    scene: Option<PathBuf>,
    /// Write estimate.tum and boxes.csv of the replay there.
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
}

const REPLAY_AFTER_HELP: &str = "\
Exit code: 0 every estimate is the recorded one bit for bit, 1 some are not, 2 could not replay. With --scene estimates may differ.";

/// What `wherein table` is asked.
#[derive(Debug, Args)]
struct TableArguments {
    /// Folders that `wherein run` wrote.
    #[arg(required = true, value_name = "DIR")]
    folders: Vec<PathBuf>,
    /// Replace what stands between the lines `<!-- results:begin -->` and `<!-- results:end -->` of this document; in `<!-- results:begin
    /// floor papers/floor --no-baselines -->` only scenes whose names begin so, without what others made of the same readings.
    #[arg(long, value_name = "FILE")]
    into: Option<PathBuf>,
}

/// Why a command could not be carried out. Its text follows "failed to".
#[derive(Debug, thiserror::Error)]
enum CommandError {
    #[error(transparent)]
    Scene(#[from] SceneError),
    #[error(transparent)]
    Map(#[from] crate::navigation::map_server::MapError),
    #[error(transparent)]
    Render(#[from] RenderError),
    #[error(transparent)]
    Replay(#[from] ReplayError),
    #[error(transparent)]
    Record(#[from] RecordError),
    #[error(transparent)]
    Live(#[from] LiveError),
    #[error(transparent)]
    Sweep(#[from] SweepError),
    #[error(transparent)]
    Falsify(#[from] FalsifyError),
    #[error(transparent)]
    Side(#[from] SideError),
    #[error("compare {} and {}: no case ran in both, expected the same scenes, settings and seeds", .0.display(), .1.display())]
    NoPairs(PathBuf, PathBuf),
    #[error("find results in {}: expected summary.json files that `wherein run` wrote", .0.display())]
    NoResults(PathBuf),
    #[error("put the table into {}: expected a line `{} -->` and after it a line `{}`", .0.display(), table::BEGIN, table::END)]
    NoMarkers(PathBuf),
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
    #[error("render {} --at {},{}: in or by `furniture[{index}]`, expected {reach_m} m of distance, as the robot's body reaches that far about its origin", scene.display(), at_m[0], at_m[1])]
    InFurniture { scene: PathBuf, at_m: [f64; 2], index: usize, reach_m: f64 },
    #[error("write {}: {}", .0.display(), .1)]
    Unwritable(PathBuf, io::Error),
    #[error("find markers in {}: expected a table `[markers]` with at least one marker on the map", .0.display())]
    NoCeilingMarkers(PathBuf),
    #[error("write {}: it exists already, expected another folder by --out", .0.display())]
    Exists(PathBuf),
    #[error("print: {0}")]
    Output(#[from] io::Error),
}

/// Runs the command that the process was asked for.
pub fn main() -> ExitCode {
    let Cli { adapter, command } = Cli::parse();
    let adapter = adapter.as_deref();
    let outcome = match command {
        Command::Run(arguments) => run::run_scenes(&arguments, adapter),
        Command::Weaken(arguments) => weaken::weaken_scenes(&arguments, adapter),
        Command::Sweep(arguments) => sweep::sweep(&arguments, adapter),
        Command::Merge(arguments) => sweep::merge_folders(&arguments),
        Command::Report(arguments) => report::report_folder(&arguments),
        Command::Compare(arguments) => compare::compare_sides(&arguments),
        Command::Falsify(arguments) => falsify::falsify(&arguments, adapter),
        Command::Render(arguments) => render::render(&arguments, adapter).map(|()| ExitCode::SUCCESS),
        Command::Markers(arguments) => markers::markers(&arguments).map(|()| ExitCode::SUCCESS),
        Command::Replay(arguments) => replay::replay_recording(&arguments),
        Command::Table(arguments) => table::tabulate(&arguments).map(|()| ExitCode::SUCCESS),
        Command::Map(arguments) => map::write_map(&arguments).map(|()| ExitCode::SUCCESS),
        Command::Scene(arguments) => print_scene(&arguments).map(|()| ExitCode::SUCCESS),
        Command::Completions { shell } => manual::completions(shell).map(|()| ExitCode::SUCCESS),
        Command::Man { out } => manual::manual(out.as_deref()).map(|()| ExitCode::SUCCESS),
        Command::Schema { markdown } => {
            print(&if markdown { keys_markdown() } else { schema_text() }).map(|()| ExitCode::SUCCESS)
        }
        Command::Adapter => print_adapter(adapter).map(|()| ExitCode::SUCCESS),
    };
    outcome.unwrap_or_else(|error| {
        complain(&error);
        ExitCode::from(2)
    })
}

fn print_scene(arguments: &SceneArguments) -> Result<(), CommandError> {
    print(&SceneTemplate::load(&arguments.scene)?.with(&arguments.set)?.text)
}

fn print_adapter(adapter: Option<&str>) -> Result<(), CommandError> {
    let renderer = crate::render::Renderer::on_adapter(adapter)?;
    print(&format!("{}\n", renderer.adapter()))
}

/// Writes to standard output. A reader that has seen enough, such as `head`, is no error.
fn print(text: &str) -> Result<(), CommandError> {
    let mut stdout = io::stdout().lock();
    match stdout.write_all(text.as_bytes()).and_then(|()| stdout.flush()) {
        Err(error) if error.kind() != io::ErrorKind::BrokenPipe => Err(error.into()),
        _ => Ok(()),
    }
}

fn complain(error: &CommandError) {
    // A reader that has seen enough is no error here either.
    let _ = writeln!(io::stderr(), "wherein: failed to {error}");
    let (CommandError::Scene(scene @ SceneError::Invalid { .. })
    | CommandError::Replay(ReplayError::Scene(scene @ SceneError::Invalid { .. }))
    | CommandError::Sweep(SweepError::Scene(scene @ SceneError::Invalid { .. }))) = error
    else {
        return;
    };
    let theme = if io::stderr().is_terminal() { GraphicalTheme::unicode() } else { GraphicalTheme::unicode_nocolor() };
    let handler = GraphicalReportHandler::new_themed(theme).without_cause_chain().with_wrap_lines(false);
    let mut snippet = String::new();
    // The first line repeats the message above; what follows shows the place.
    if handler.render_report(&mut snippet, scene).is_ok()
        && let Some((_, place)) = snippet.split_once('\n')
    {
        let _ = writeln!(io::stderr(), "{place}");
    }
}

//! The command `wherein`: its subcommands, their arguments, and what they print.

use std::{
    io::{self, Write},
    path::PathBuf,
    process::ExitCode,
};

use clap::{Args, Parser, Subcommand};
use clap_complete::Shell;

use crate::{
    loading::{SceneTemplate, Setting},
    scene::{keys_markdown, schema_text},
};

mod calibrate;
mod check;
mod compare;
mod conclude;
mod error;
mod falsify;
mod github;
mod judge;
mod manual;
mod map;
mod markers;
mod reading;
mod repeat;
mod render;
mod replay;
mod report;
mod results_arguments;
mod run;
mod scenes_and_seeds;
mod sharpness;
mod sweep;
mod table;
mod teach;
mod tested;
mod upgrade;
mod weaken;

use error::CommandError;
pub use render::{At, Lights};
use results_arguments::{CompareArguments, MergeArguments, Outputs, ReportArguments, SweepArguments};

/// Simulates an indoor robot and its cameras, localizes it by interval boxes, and checks every box against the truth.
#[derive(Debug, Parser)]
#[command(name = "wherein", version, arg_required_else_help = true, after_help = after_help())]
struct Cli {
    /// Graphics adapter to render with, by a part of its name, driver or backend. The environment variable WHEREIN_ADAPTER has the same effect.
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
  wherein falsify --minutes 10                                    a search for random scenes that fail
  wherein teach scenes/landmarks/teach.toml --map map.json        a drive that learns where landmarks are
  wherein repeat scenes/landmarks/repeat.toml --map map.json      a drive by that map
  wherein check scenes/x.toml                                     what the cameras would show, before the scene is run
  wherein weaken scenes/x.toml --set robot.errors=corner          how tight the scene's bounds are
  wherein sharpness renders/x/0                                   how much wider its boxes are than they must be
  wherein render scenes/x.toml --at 1.5,2,90                      what each camera sees from that pose
  wherein run scenes/x.toml --record                              a recording that Foxglove and Rerun open
  wherein replay renders/x/0/recording.mcap                       the localizer on that recording
  wherein replay --robot robot.toml rosbag2_2026_05_04            a localizer on a log that another program recorded
  wherein judge renders/x/0/recording.mcap --estimate mine.tum    another program's estimates against the recorded truth
  wherein calibrate drive calibration_drive --robot robot.toml    radii, track, gyroscope and bounds from a log with true poses
  wherein markers scenes/x.toml                                   a printable sheet and the map of its markers
  wherein scene scenes/x.toml                                     the scene with all that it extends, as one text
  wherein upgrade scenes/x.toml                                   a scene of an older version, rewritten for this one
  wherein schema > scenes/schema.json                             for editors that complete and check scenes

Exit code: 0 every run met its scene's expectations, 1 some did not, 2 could not run.";

/// The text below the help, with what this program was built with.
fn after_help() -> String {
    let record = "  wherein replay renders/x";
    let live = "  wherein run scenes/x.toml --live                                the same, live\n";
    let told = if cfg!(feature = "live") { live } else { "" };
    AFTER_HELP.replacen(record, &format!("{told}{record}"), 1)
}

#[derive(Debug, Subcommand)]
enum Command {
    /// Runs scenes with the localizer and records the results.
    Run(run::RunArguments),
    /// Runs a scene whose localizer learns where landmarks are, and keeps the map of them in a file.
    Teach(teach::TeachArguments),
    /// Runs scenes with a map of landmarks that `wherein teach` has made.
    Repeat(repeat::RepeatArguments),
    /// Takes pictures along a scene's way and tells what the localizer's methods would see in them, before the scene is run.
    Check(check::CheckArguments),
    /// Gives the localizer ever narrower bounds until it loses the truth, to show how tight the declared bounds are.
    Weaken(weaken::WeakenArguments),
    /// Compares the boxes of a run with witnesses: histories other than the truth that keep every bound on the run's readings.
    Sharpness(sharpness::SharpnessArguments),
    /// Runs one scene with every combination of the values of some keys, and reports on all of these runs.
    Sweep(SweepArguments),
    /// Writes the report of a folder of results: report.html, summary.md and results.csv.
    Report(ReportArguments),
    /// Compares two sets of results case by case, and prints which figures are better or worse in the second.
    Compare(CompareArguments),
    /// Merges the parts of a sweep that several machines ran with --shard.
    Merge(MergeArguments),
    /// Searches random scenes for one in which the program or the localizer fails, and reduces that scene to a small one.
    Falsify(falsify::FalsifyArguments),
    /// Takes pictures of a robot that stands still, one per camera.
    Render(render::RenderArguments),
    /// Writes a printable sheet of a scene's ceiling markers and their map, and prints whether the ceiling camera sees enough of them from everywhere
    /// in the room.
    Markers(markers::MarkersArguments),
    /// Runs the localizer on a recording, without the simulator, and compares its estimates with the recorded ones; with --robot, runs a localizer on
    /// a log that another program recorded.
    Replay(replay::ReplayArguments),
    /// Compares estimates that any program made from a recording with the recorded true poses.
    Judge(judge::JudgeArguments),
    /// Finds constants of a robot and its cameras, and the bounds to declare, from a drive with true poses or from pictures of a board.
    Calibrate(calibrate::CalibrateArguments),
    /// Prints a Markdown table of recorded runs, or inserts the table into a document.
    Table(table::TableArguments),
    /// Writes a scene's occupancy grid as files for ROS's map_server.
    Map(map::MapArguments),
    /// Prints a scene as one text, with all that it extends and all keys that are set.
    Scene(SceneArguments),
    /// Rewrites scene files of an older version in place, where keys have moved since.
    Upgrade(upgrade::UpgradeArguments),
    /// Prints the JSON schema of scene files.
    Schema {
        /// Print a readable page of all keys instead of the JSON schema.
        #[arg(long)]
        markdown: bool,
    },
    /// Prints completions for a shell, to be saved where the shell searches for completions.
    Completions {
        /// The shell to print completions for.
        shell: Shell,
    },
    /// Prints the manual page of the command, or writes one page for each subcommand too.
    #[cfg(feature = "man")]
    Man {
        /// Write the pages wherein.1, wherein-run.1 and so on into this folder instead of printing one.
        #[arg(long, value_name = "DIR")]
        out: Option<PathBuf>,
    },
    /// Prints the graphics adapter that renders the images; exit code 2 when there is none.
    Adapter,
}

/// Arguments of `wherein scene`.
#[derive(Debug, Args)]
struct SceneArguments {
    /// Scene file.
    #[arg(value_name = "SCENE")]
    scene: PathBuf,
    /// Set a key of the scene, such as floor.friction=0.3; may be given several times.
    #[arg(long, value_name = "KEY=VALUE")]
    set: Vec<Setting>,
}

/// Runs the subcommand that the process's arguments name, and returns its exit code.
pub fn main() -> ExitCode {
    let Cli { adapter, command } = Cli::parse();
    let adapter = adapter.as_deref();
    let outcome = match command {
        Command::Run(arguments) => run::run_scenes(&arguments, adapter),
        Command::Teach(arguments) => teach::teach(arguments, adapter),
        Command::Repeat(arguments) => repeat::repeat(arguments, adapter),
        Command::Check(arguments) => check::check_scene(&arguments, adapter),
        Command::Weaken(arguments) => weaken::weaken_scenes(&arguments, adapter),
        Command::Sharpness(arguments) => sharpness::sharpness(&arguments, adapter),
        Command::Sweep(arguments) => sweep::sweep(&arguments, adapter),
        Command::Merge(arguments) => sweep::merge_folders(&arguments),
        Command::Report(arguments) => report::report_folder(&arguments),
        Command::Compare(arguments) => compare::compare_sides(&arguments),
        Command::Falsify(arguments) => falsify::falsify(&arguments, adapter),
        Command::Render(arguments) => render::render(&arguments, adapter).map(|()| ExitCode::SUCCESS),
        Command::Markers(arguments) => markers::markers(&arguments).map(|()| ExitCode::SUCCESS),
        Command::Replay(arguments) => replay::replay_recording(&arguments),
        Command::Judge(arguments) => judge::judge(&arguments),
        Command::Calibrate(arguments) => calibrate::calibrate(&arguments),
        Command::Table(arguments) => table::tabulate(&arguments).map(|()| ExitCode::SUCCESS),
        Command::Map(arguments) => map::write_map(&arguments).map(|()| ExitCode::SUCCESS),
        Command::Upgrade(arguments) => upgrade::upgrade(&arguments).map(|()| ExitCode::SUCCESS),
        Command::Scene(arguments) => print_scene(&arguments).map(|()| ExitCode::SUCCESS),
        Command::Completions { shell } => manual::completions(shell).map(|()| ExitCode::SUCCESS),
        #[cfg(feature = "man")]
        Command::Man { out } => manual::manual(out.as_deref()).map(|()| ExitCode::SUCCESS),
        Command::Schema { markdown } => {
            print(&if markdown { keys_markdown() } else { schema_text() }).map(|()| ExitCode::SUCCESS)
        }
        Command::Adapter => print_adapter(adapter).map(|()| ExitCode::SUCCESS),
    };
    outcome.unwrap_or_else(|error| {
        error.complain();
        ExitCode::from(2)
    })
}

/// Parses the words of a command line, the program's name first, without carrying the command out. The error says what the command would complain of.
pub fn parse(words: &[String]) -> Result<(), clap::Error> {
    match Cli::try_parse_from(words) {
        // Whoever asks for help or for the version has made no mistake.
        Err(error) if error.exit_code() != 0 => Err(error),
        _ => Ok(()),
    }
}

fn print_scene(arguments: &SceneArguments) -> Result<(), CommandError> {
    print(&SceneTemplate::load(&arguments.scene)?.with(&arguments.set)?.text)
}

fn print_adapter(adapter: Option<&str>) -> Result<(), CommandError> {
    let renderer = crate::render::Renderer::on_adapter(adapter)?;
    print(&format!("{}\n", renderer.adapter()))
}

/// Writes to standard output. A closed output is no error: a reader such as `head` stops reading early.
fn print(text: &str) -> Result<(), CommandError> {
    let mut stdout = io::stdout().lock();
    match stdout.write_all(text.as_bytes()).and_then(|()| stdout.flush()) {
        Err(error) if error.kind() != io::ErrorKind::BrokenPipe => Err(error.into()),
        _ => Ok(()),
    }
}

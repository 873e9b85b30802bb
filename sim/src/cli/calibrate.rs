//! `wherein calibrate`: constants of a robot and its cameras, and the bounds to declare, from a drive with true poses, from pictures of a
//! board, or from pictures of turns on the spot.

use std::{
    fs,
    path::{Path, PathBuf},
    process::ExitCode,
};

use clap::{Args, Subcommand, ValueEnum};
use localizer::{
    calibration::chessboard::{Bend, corners::Board},
    reading::Camera,
};
use serde_json::Value;

use super::{CommandError, print};
use crate::{
    artefacts::{
        log::calibration::{Calibrating, calibrate_drive},
        run_files::replace_file,
    },
    campaign::{board::calibrate_board, mount::calibrate_mount},
    loading::{SceneTemplate, Setting, extending},
};

/// Arguments of `wherein calibrate`.
#[derive(Debug, Args)]
pub(super) struct CalibrateArguments {
    #[command(subcommand)]
    by: By,
}

#[derive(Debug, Subcommand)]
enum By {
    /// Finds the wheels' radii and track, the gyroscope's scale and bias, the antenna's place, and the least bounds that a drive keeps, from a log with
    /// true poses.
    Drive(DriveArguments),
    /// Finds a camera's focal lengths, principal point and lens from pictures of a chessboard.
    Board(BoardArguments),
    /// Finds where the ceiling camera is mounted, from pictures of ceiling markers while the robot turns on the spot.
    Mount(MountArguments),
}

#[derive(Debug, Args)]
#[command(after_help = "\
Radii and track come from spans with straight ways and turns; a span in which something else acted, such as a push, is set aside and listed.
± is three standard deviations by the jackknife. Bounds are the least that the whole log keeps, times --margin: a drive that does not do
what the robot will do later, such as turning on carpet, does not tell its bounds.

Exit code: 0 something was found, 2 nothing was, or the log cannot be used.")]
struct DriveArguments {
    /// An MCAP file or a bag of rosbag2, with true poses; also a recording that `wherein run --ros2` wrote.
    #[arg(value_name = "LOG")]
    log: PathBuf,
    /// Scene of the robot, whose table `[log]` says how the log is read and where its true poses are.
    #[arg(long, value_name = "SCENE")]
    robot: PathBuf,
    /// Length of the spans that the drive is divided into.
    #[arg(long, value_name = "SECONDS", default_value_t = 2.0, value_parser = positive, allow_negative_numbers = true)]
    span_s: f64,
    /// Factor by which bounds are declared greater than the least that the log keeps.
    #[arg(long, value_name = "FACTOR", default_value_t = 1.5, value_parser = positive, allow_negative_numbers = true)]
    margin: f64,
    #[command(flatten)]
    output: Output,
}

#[derive(Debug, Args)]
#[command(after_help = "\
Six pictures or more, better twenty, with boards that lean in several directions and reach into the image's corners. ± is three standard
deviations by the jackknife over pictures.

Exit code: 0 the camera was calibrated, 2 it was not.")]
struct BoardArguments {
    /// Pictures of the board: PNG, JPEG or PGM files of one size.
    #[arg(value_name = "PICTURE", required = true)]
    pictures: Vec<PathBuf>,
    /// Number of squares of the board along both sides, black and white, such as 12x9.
    #[arg(long, value_name = "COLUMNSxROWS", value_parser = squares)]
    board: [usize; 2],
    /// Side length of a square.
    #[arg(long, value_name = "METRES", value_parser = positive, allow_negative_numbers = true)]
    square_m: f64,
    /// Camera of the scene whose keys are found.
    #[arg(long, value_enum, default_value = "ceiling")]
    camera: Named,
    /// Solve for tangential lens coefficients, too, as of a lens whose elements are not centred. They are told well only by many pictures.
    #[arg(long)]
    tangential: bool,
    /// Scene of the robot, which --out extends.
    #[arg(long, value_name = "SCENE")]
    robot: Option<PathBuf>,
    #[command(flatten)]
    output: Output,
}

#[derive(Debug, Args)]
#[command(after_help = "\
Let the robot turn on the spot under a marker of its map and take a picture every 10 to 30 degrees, a full circle in each folder; two folders
from different places, or more. ± is three standard deviations by the jackknife over pictures. A tilt of the camera and an error of its
principal point turn with the robot as its position does, and are added to the tolerance.

Exit code: 0 the position was found, 2 it was not.")]
struct MountArguments {
    /// Folders, each with the pictures of one turn on the spot: PNG, JPEG or PGM files.
    #[arg(value_name = "SPIN", required = true)]
    spins: Vec<PathBuf>,
    /// Scene of the robot with its ceiling camera, under the markers of its map.
    #[arg(long, value_name = "SCENE")]
    robot: PathBuf,
    #[command(flatten)]
    output: Output,
}

#[derive(Debug, Args)]
struct Output {
    /// Write a scene that extends the robot's by what was found.
    #[arg(long, value_name = "FILE", requires = "robot")]
    out: Option<PathBuf>,
    /// Print JSON instead of a text.
    #[arg(long)]
    json: bool,
}

/// A camera whose keys a board tells.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum Named {
    Ceiling,
    Forward,
}

fn positive(text: &str) -> Result<f64, String> {
    text.parse()
        .ok()
        .filter(|value: &f64| value.is_finite() && *value > 0.0)
        .ok_or_else(|| "expected a number above 0".to_owned())
}

fn squares(text: &str) -> Result<[usize; 2], String> {
    let sides = text.split_once('x').and_then(|(columns, rows)| Some([columns.parse().ok()?, rows.parse().ok()?]));
    sides
        .filter(|sides| sides.iter().all(|side| (3..=100).contains(side)))
        .ok_or_else(|| "expected two numbers from 3 to 100, such as 12x9".to_owned())
}

/// Calibrates, and prints what was found.
pub(super) fn calibrate(arguments: &CalibrateArguments) -> Result<ExitCode, CommandError> {
    match &arguments.by {
        By::Drive(drive) => by_drive(drive),
        By::Board(board) => by_board(board),
        By::Mount(mount) => by_spins(mount),
    }
}

fn by_drive(arguments: &DriveArguments) -> Result<ExitCode, CommandError> {
    let robot = SceneTemplate::load(&arguments.robot)?;
    arguments.output.refuse_robot(&arguments.robot)?;
    let how = Calibrating { span_s: arguments.span_s, margin: arguments.margin };
    let found = calibrate_drive(&robot, &arguments.log, &how)?;
    arguments.output.tell(&found.text(), &found.to_json(), Some(&robot), &found.settings())?;
    Ok(ExitCode::SUCCESS)
}

fn by_board(arguments: &BoardArguments) -> Result<ExitCode, CommandError> {
    let camera = match arguments.camera {
        Named::Ceiling => Camera::Ceiling,
        Named::Forward => Camera::Forward,
    };
    let robot = arguments.robot.as_deref().map(SceneTemplate::load).transpose()?;
    arguments.robot.as_deref().map_or(Ok(()), |robot| arguments.output.refuse_robot(robot))?;
    let board = Board { columns: arguments.board[0], rows: arguments.board[1], square_m: arguments.square_m };
    let bend = if arguments.tangential { Bend::RadialAndTangential } else { Bend::Radial };
    let found = calibrate_board(&arguments.pictures, &board, bend, camera)?;
    arguments.output.tell(&found.text(), &found.to_json(), robot.as_ref(), &found.keys)?;
    Ok(ExitCode::SUCCESS)
}

fn by_spins(arguments: &MountArguments) -> Result<ExitCode, CommandError> {
    arguments.output.refuse_robot(&arguments.robot)?;
    let robot = SceneTemplate::load(&arguments.robot)?;
    let found = calibrate_mount(&arguments.spins, &robot.file().scene, &arguments.robot)?;
    arguments.output.tell(&found.text(), &found.to_json(), Some(&robot), &found.keys)?;
    Ok(ExitCode::SUCCESS)
}

impl Output {
    /// Refuses to write over the robot's own scene, which would then extend itself.
    fn refuse_robot(&self, robot: &Path) -> Result<(), CommandError> {
        let real = |path: &Path| fs::canonicalize(path).ok();
        match &self.out {
            Some(out) if real(out).is_some() && real(out) == real(robot) => {
                Err(CommandError::OutIsInput { path: out.clone() })
            }
            _ => Ok(()),
        }
    }

    /// Prints what was found, with the keys that declare it, and writes these keys to a scene.
    fn tell(
        &self,
        text: &str,
        json: &Value,
        robot: Option<&SceneTemplate>,
        keys: &[Setting],
    ) -> Result<(), CommandError> {
        let base = robot.map(|robot| robot.file().path.as_path());
        if let (Some(out), Some(robot)) = (&self.out, robot) {
            // What the keys do not allow, such as a tolerance beyond its range, is refused before anything is written.
            robot.with(keys)?;
            replace_file(out, extending(&base_beside(&robot.file().path, out), keys))?;
        }
        if self.json {
            return print(&format!("{json:#}\n"));
        }
        let base = base.map_or_else(|| "robot.toml".to_owned(), |base| base.display().to_string());
        let declared = match &self.out {
            Some(out) => format!("\nwritten to {}\n", out.display()),
            None => format!("\nTo declare this, in a scene of its own:\n\n{}", extending(&base, keys)),
        };
        print(&format!("{text}{declared}"))
    }
}

/// The path of a scene as a scene beside it in `out` names it: its name, if both are in one folder.
fn base_beside(base: &Path, out: &Path) -> String {
    let folder = |path: &Path| {
        let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
        fs::canonicalize(folder).ok()
    };
    match base.file_name() {
        Some(name) if folder(base).is_some() && folder(base) == folder(out) => name.to_string_lossy().into_owned(),
        _ => fs::canonicalize(base).unwrap_or_else(|_| base.to_owned()).display().to_string(),
    }
}

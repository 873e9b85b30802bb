//! A log that another program recorded, replayed through a localizer: read, checked, localized and reported.
//!
//! | module | what it does |
//! |---|---|
//! | `source`, `mcap_file`, `bag_database`, `sqlite`, `raw_message` | from files to messages |
//! | `topics`, `messages`, `gathered`, `account` | from messages to values with checked stamps, and what was dropped for what reason |
//! | `motion`, `pictures`, `geodesy`, `lenses` | from values to readings, and to the robot as the localizer is told it |
//! | `open_log` | all of this for one log |
//! | `player` | from readings to estimates |
//! | [`calibration`](mod@calibration) | from readings and true poses to constants of the robot |
//! | `truth`, `containment`, `tightness` | estimates and bounds compared with true poses, if there are any |
//! | `report` | the files and the text that tell all this |
//!
//! A log is read from its files as often as needed, so that its images are never all in memory: for its topics, for all but the pixels, and, with
//! cameras, for the pixels.

mod account;
mod bag_database;
pub mod calibration;
mod containment;
mod error;
mod estimate_file;
mod gathered;
mod geodesy;
mod judged;
mod lenses;
mod mcap_file;
mod messages;
mod motion;
mod open_log;
mod pictures;
mod player;
mod raw_message;
mod report;
mod source;
mod sqlite;
mod tightness;
mod topics;
mod truth;

use std::{f64::consts::PI, path::Path, time::Instant};

use interval::Interval;
use localizer::PoseBox;

use crate::{
    loading::SceneFile,
    scene::{Log, Scene},
    subject::{SubjectChoice, subject},
};

pub use error::LogError;
pub use judged::{JudgedEstimates, judge_estimates};
use open_log::OpenLog;
use player::Player;
use report::Told;
pub use report::{LogReplay, log_text};

/// Replays a log through a localizer that is given the robot, the map and the bounds of the file `robot`.
pub fn replay_log(robot: &SceneFile, path: &Path, choice: &SubjectChoice) -> Result<LogReplay, LogError> {
    let began = Instant::now();
    let mut log = OpenLog::read(robot, path)?;
    let start = start_box(&log.told, log.keys);
    let mut player = Player::start(
        subject(choice, &log.told),
        &start,
        log.motion.readings.clone(),
        log.motion.excesses.clone(),
        log.others(),
        log.keys.step_s,
    );
    log.show_images(&mut |reading| {
        player.show(reading);
        player.goes_on()
    })?;
    let played = player.finish();
    if let (Some(truth), Some(last)) = (&log.truth, played.estimates.last()) {
        truth.overlaps(last.time_s).map_err(|found| LogError::Unusable { log: path.to_owned(), found })?;
    }
    Ok(LogReplay::of(&Told {
        robot,
        path,
        log: &log,
        played: &played,
        start: &start,
        wall_s: began.elapsed().as_secs_f64(),
    }))
}

/// The box in which the localizer is told that the robot begins.
fn start_box(told: &Scene, keys: &Log) -> PoseBox {
    if keys.start_is_known {
        return told.start_box();
    }
    let [x_m, y_m] = told.room_hull_m();
    PoseBox::from([x_m, y_m, Interval::new(-PI, PI)])
}

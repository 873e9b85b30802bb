//! A process of any language as the subject of a run: it is sent its readings as an MCAP stream and answers by lines of JSON.
//!
//! The page `docs/src/own_localizer_process.md` of the book is the protocol's description.
//!
//! | module | what it is |
//! |---|---|
//! | `setup` | what the process is told beforehand: map, robot model, bounds |
//! | `messages` | the messages of the stream, with their schemas |
//! | `stream` | the stream itself: MCAP without chunks |
//! | `answer` | the lines that the process answers with |
//! | `child` | the operating system's side: start, pipes, time limits, the end |

mod answer;
mod child;
mod messages;
mod setup;
mod stream;

use std::{
    cell::{OnceCell, RefCell},
    time::Duration,
};

use localizer::{Pose, PoseBox, Reading};

use crate::scene::Scene;

use super::{Answer, Failure, GivenReading, Subject, foreign_answer::turned_to};

use child::Running;
pub use messages::device;
use messages::{Message, Setup};
use stream::Stream;

/// What a localizer is told about a scene beforehand, as JSON: `protocol`, `map` and `robot`.
pub fn told(scene: &Scene) -> serde_json::Value {
    // The parts are JSON already.
    serde_json::to_value(Setup::of(scene)).unwrap_or_default()
}

/// A process under test. Each answer is asked for and awaited, so that a run does not depend on how fast the process is.
pub struct ForeignProcess {
    command: String,
    talk: RefCell<Option<Talk>>,
    limit: Duration,
    /// Number of readings given, and the newest of them.
    given: (usize, Option<GivenReading>),
    /// The first thing that the process did wrong; nothing more is sent to it afterwards.
    failure: OnceCell<Failure>,
    /// What the process wrote to its standard error before it was ended.
    log: Option<String>,
}

/// The exchange of readings and answers with a running process.
struct Talk {
    running: Running,
    stream: Stream,
    /// Heading near which the next answer's headings are taken: that of the answer before, or the middle of the start box.
    heading_rad: f64,
    /// The latest answer, with the time that it is for and the number of readings that it is based on.
    latest: Option<(f64, usize, Answer)>,
    /// Stamp of the newest reading that the latest answer takes into account, if the process told it.
    newest_s: Option<f64>,
}

impl ForeignProcess {
    /// Starts a process by a command of the shell, and tells it what a localizer is given about the scene. It has the time `limit` for each answer,
    /// in which it reads the readings before it, too.
    ///
    /// A command that cannot be started is a failure at the first answer.
    pub fn start(command: &str, limit: Duration, scene: &Scene) -> ForeignProcess {
        let process = ForeignProcess {
            command: command.to_owned(),
            talk: RefCell::new(None),
            limit,
            given: (0, None),
            failure: OnceCell::new(),
            log: None,
        };
        match Talk::begin(command, scene) {
            Ok(talk) => *process.talk.borrow_mut() = Some(talk),
            Err(reason) => process.fail(0.0, reason),
        }
        process
    }

    /// Keeps the first failure of the process.
    fn fail(&self, time_s: f64, reason: String) {
        let failure = Failure { time_s, reading: self.given.1.clone(), reason };
        self.failure.get_or_init(|| failure);
    }

    /// Sends the process a message, unless it has failed.
    fn send(&mut self, message: &Message<'_>) {
        let talk = self.talk.get_mut();
        let sent = match talk {
            Some(talk) if self.failure.get().is_none() => talk.stream.put(message),
            _ => return,
        };
        if let Err(error) = sent {
            self.fail(message.time_s, format!("it cannot be sent a message: {error}"));
        }
    }
}

impl Talk {
    fn begin(command: &str, scene: &Scene) -> Result<Talk, String> {
        let (running, pipe) =
            Running::start(command).map_err(|error| format!("the shell cannot be started: {error}"))?;
        let unsent = |error| format!("it cannot be sent a message: {error}");
        let mut stream = Stream::begin(pipe).map_err(unsent)?;
        stream.put(&Message::setup(&Setup::of(scene))).map_err(unsent)?;
        Ok(Talk { running, stream, heading_rad: 0.0, latest: None, newest_s: None })
    }

    /// Asks for the answer for `time_s` and waits for it. An answer that has been given for the same time and the same readings is not asked again.
    fn ask(&mut self, time_s: f64, n_given: usize, limit: Duration) -> Result<Answer, String> {
        if let Some((at_s, based_on, answer)) = &self.latest
            && (*at_s, *based_on) == (time_s, n_given)
        {
            return Ok(answer.clone());
        }
        let unsent = |error| format!("it cannot be sent a message: {error}");
        self.stream.put(&Message::ask(time_s)).map_err(unsent)?;
        let line = self.running.line(limit)?;
        let (answer, newest_s) = answer::read(&line, time_s)?;
        let answer = turned_to(answer, self.heading_rad);
        self.newest_s = newest_s;
        let middle = answer.clone().into_estimate(time_s).pose.hull()[2].mid();
        if middle.is_finite() {
            self.heading_rad = middle;
        }
        self.latest = Some((time_s, n_given, answer.clone()));
        Ok(answer)
    }
}

impl Subject for ForeignProcess {
    fn name(&self) -> &str {
        &self.command
    }

    fn start(&mut self, start: &PoseBox) {
        self.send(&Message::start(start));
        if let Some(talk) = self.talk.get_mut() {
            (talk.latest, talk.heading_rad) = (None, start[2].mid());
        }
    }

    fn observe(&mut self, reading: &Reading) {
        let (head, pixels) = Message::of(reading);
        self.send(&head);
        pixels.iter().for_each(|pixels| self.send(pixels));
        let (number, measured_s, arrived_s) = (self.given.0 + 1, reading.measured_s(), reading.arrived_s());
        let device = device(reading).to_owned();
        self.given = (number, Some(GivenReading { number, device, measured_s, arrived_s }));
    }

    fn estimate_at(&self, time_s: f64) -> Answer {
        let answer = match &mut *self.talk.borrow_mut() {
            Some(talk) if self.failure.get().is_none() => talk.ask(time_s, self.given.0, self.limit),
            _ => return nowhere(),
        };
        answer.unwrap_or_else(|reason| {
            self.fail(time_s, reason);
            nowhere()
        })
    }

    fn knows_until_s(&self) -> Option<f64> {
        self.talk.borrow().as_ref()?.newest_s
    }

    fn failure(&self) -> Option<&Failure> {
        self.failure.get()
    }

    fn end(&mut self) -> Option<String> {
        if let Some(Talk { mut running, stream, .. }) = self.talk.take() {
            // The end of its input tells the process to end. It may take its time, as if for one more answer, and then is ended.
            let _ = stream.end();
            if self.failure.get().is_none() {
                running.ends_within(self.limit);
            }
            self.log = Some(running.into_log());
        }
        self.log.clone()
    }
}

/// The answer of a process that has failed, which nobody uses.
fn nowhere() -> Answer {
    Answer::Point(Pose::default())
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use interval::Interval;

    use super::*;

    fn process(command: &str) -> ForeignProcess {
        let text = "duration_s = 5.0\n[room]\nwidth_m = 6.0\ndepth_m = 6.0\n[start]\nx_m = 1.0\ny_m = 3.0\n[localizer]\n\
                    methods = []\n[[route.waypoint]]\nx_m = 3.0\ny_m = 3.0\n";
        let scene = Scene::parse(text, "scene.toml").unwrap_or_else(|error| panic!("failed to {error}"));
        ForeignProcess::start(command, Duration::from_secs(10), &scene)
    }

    #[test]
    fn each_drive_counts_its_turns_from_its_own_start() {
        let line = r#"echo '{"time_s":1,"pose":[0,0,0.1]}'"#;
        let mut process = process(&format!("{line}; {line}; cat >/dev/null"));
        // The heading of 0.1 rad nearest to 6.2 rad is a turn further.
        for (start_rad, heading_rad) in [(6.2, 0.1 + std::f64::consts::TAU), (0.0, 0.1)] {
            process.start(&PoseBox::from([0.0, 0.0, start_rad].map(Interval::point)));
            let Answer::Point(pose) = process.estimate_at(1.0) else { panic!("no point") };
            assert!((pose.heading_rad - heading_rad).abs() < 1e-12, "{pose:?}: {:?}", process.failure());
        }
    }

    #[test]
    fn a_process_has_time_to_end_after_its_last_answer() {
        let mut process = process("cat >/dev/null; sleep 0.3; echo all is written >&2");
        assert_eq!(process.end().as_deref(), Some("all is written\n"));
    }
}

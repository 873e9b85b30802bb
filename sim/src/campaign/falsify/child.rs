//! Runs each scene in a process of its own, so that a run that panics, aborts or never ends does not end the search.

use std::{
    env, fs,
    io::{self, BufRead, BufReader, Read, Write},
    process::{Child, ChildStdin, Command, ExitStatus, Stdio},
    sync::mpsc::{self, Receiver, RecvTimeoutError},
    thread,
    time::{Duration, Instant},
};

use super::{
    probe::{Outcome, Told},
    wish::Wish,
};

/// How the run of a scene ended.
#[derive(Clone, Debug, PartialEq)]
pub enum Ending {
    /// The scene was refused as invalid; the text names the first key that is wrong.
    Refused(String),
    /// The run reached its end.
    Ran(Outcome),
    /// The process crashed: it ended before the simulated run was complete.
    Crashed {
        /// Simulated time that the run had reached when its process ended or was killed.
        at_s: f64,
        /// Place of the panic in the source, the exit status of the process, or the limit of memory that it exceeded.
        place: String,
        /// Text that the process wrote to standard error, or the limit of memory for which it was killed.
        said: String,
    },
    /// The run took far longer than runs of similar scenes.
    Hung {
        /// Simulated time that the run had reached when its process ended or was killed.
        at_s: f64,
        /// Processor time that the process had taken when it was killed.
        took_s: f64,
    },
    /// The run could not be made: no graphics adapter worked, or a signal from outside the search ended the process. The text is the reason.
    CouldNotRun(String),
}

/// A run of a scene in a process of its own.
pub(super) struct Run<'a> {
    /// Text of the scene.
    pub(super) text: &'a str,
    /// Seed of the run.
    pub(super) seed: u64,
    /// Graphics adapter to render with.
    pub(super) adapter: Option<&'a str>,
    /// Number of threads that Mesa's software drivers may use; none leaves the number to the driver.
    pub(super) driver_threads: Option<usize>,
    /// Whether witnesses are searched for, too.
    pub(super) seeks_witnesses: bool,
}

/// Processor time that a process may take to read a scene, start a graphics adapter and finish. On two cores at 3 GHz these take 0.01 to 1 s, most of
/// it for an adapter, but up to 20 s where the program itself has to find places for markers all over the ceiling of a room of a few metres.
const START_S: f64 = 40.0;
/// Processor time that a process may take for a second of simulation without cameras. The average over sixty scenes drawn at random was 0.008 s.
const SIMULATION_S: f64 = 1.0;
/// Processor time that a process may take for a million pixels of camera images. Rendering and vision take 0.1 to 0.3 s on a software adapter.
const MEGAPIXEL_S: f64 = 3.0;
/// Ratio of the wall-clock time to the processor time that a process may take, as many processes may share the machine.
const WALL_PER_PROCESSOR: f64 = 10.0;
/// Memory in kilobytes beyond which a process is killed: a run with three cameras takes 0.4 GB.
const MOST_MEMORY_KB: u64 = 3_000_000;
/// Interval at which the processor time and the memory of a run's process are checked.
const LOOK: Duration = Duration::from_millis(20);

impl Run<'_> {
    /// Starts the child process of a run and waits until the run has ended, or until the process has to be killed.
    pub(super) fn run(&self) -> io::Result<Ending> {
        let mut child = self.start()?;
        let began = Instant::now();
        let input = self.send(&mut child)?;
        let told = listen(&mut child);
        let said = overhear(&mut child);
        let ending = attend(&mut child, &told, began);
        // A process that is still alive here will not end by itself and is killed; one that has ended must still be waited for.
        let _ = child.kill();
        let status = child.wait()?;
        drop(input);
        let said = said.recv().unwrap_or_default();
        Ok(ending.unwrap_or_else(|at_s| match interruption(status) {
            Some(reason) => Ending::CouldNotRun(reason),
            None => Ending::Crashed { at_s, place: place(&said, &status.to_string()), said },
        }))
    }

    fn start(&self) -> io::Result<Child> {
        let mut command = Command::new(env::current_exe()?);
        if let Some(adapter) = self.adapter {
            command.args(["--adapter", adapter]);
        }
        if let Some(threads) = self.driver_threads {
            command.env("LP_NUM_THREADS", threads.to_string());
        }
        command.args(["falsify", "--probe", &self.seed.to_string()]);
        if self.seeks_witnesses {
            command.args(["--wish", Wish::WitnessOutside.name()]);
        }
        command.stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn()
    }

    /// Sends the scene to the process. The returned pipe has to stay open: when it closes, the process knows that the search does not
    /// wait for it any more.
    fn send(&self, child: &mut Child) -> io::Result<Option<ChildStdin>> {
        let mut input = child.stdin.take();
        if let Some(input) = &mut input {
            // An error of writing is ignored: a process that has ended already shows the reason by its exit status.
            let _ = write!(input, "{}\n{}", self.text.len(), self.text).and_then(|()| input.flush());
        }
        Ok(input)
    }
}

/// Starts a thread that receives the reports that the process writes to standard output, one per line.
fn listen(child: &mut Child) -> Receiver<Told> {
    let (sender, receiver) = mpsc::channel();
    if let Some(output) = child.stdout.take() {
        thread::spawn(move || {
            for line in BufReader::new(output).lines().map_while(Result::ok) {
                let Ok(told) = serde_json::from_str(&line) else { continue };
                if sender.send(told).is_err() {
                    return;
                }
            }
        });
    }
    receiver
}

/// Starts a thread that collects the text that the process writes to standard error, and sends all of it on when the process has ended.
fn overhear(child: &mut Child) -> Receiver<String> {
    let (sender, receiver) = mpsc::channel();
    if let Some(mut errors) = child.stderr.take() {
        thread::spawn(move || {
            let mut said = Vec::new();
            let _ = errors.read_to_end(&mut said);
            let _ = sender.send(String::from_utf8_lossy(&said).into_owned());
        });
    }
    receiver
}

/// Follows a run in its child process to the end. The error is the simulated time that the run had reached when its process ended too early.
fn attend(child: &mut Child, told: &Receiver<Told>, began: Instant) -> Result<Ending, f64> {
    let (mut at_s, mut allowed_s) = (0.0, START_S);
    loop {
        match told.recv_timeout(LOOK) {
            Ok(Told::Refused(reason)) => return Ok(Ending::Refused(reason)),
            Ok(Told::CouldNotRun(reason)) => return Ok(Ending::CouldNotRun(reason)),
            Ok(Told::Ran(outcome)) => return Ok(Ending::Ran(outcome)),
            Ok(Told::At(simulated_s)) => at_s = simulated_s,
            Ok(Told::Began { simulated_s, pixels_per_s }) => {
                allowed_s = START_S + simulated_s * (SIMULATION_S + MEGAPIXEL_S * 1e-6 * pixels_per_s);
            }
            Err(RecvTimeoutError::Disconnected) => return Err(at_s),
            Err(RecvTimeoutError::Timeout) => {
                let wall_s = began.elapsed().as_secs_f64() / WALL_PER_PROCESSOR;
                let took_s = processor_s(child.id()).unwrap_or(0.0).max(wall_s);
                if took_s > allowed_s {
                    return Ok(Ending::Hung { at_s, took_s });
                }
                if memory_kb(child.id()).is_some_and(|kilobytes| kilobytes > MOST_MEMORY_KB) {
                    let place = format!("more than {} GB of memory", MOST_MEMORY_KB / 1_000_000);
                    return Ok(Ending::Crashed { at_s, said: place.clone(), place });
                }
            }
        }
    }
}

/// Returns why a process ended, if it ended by one of the signals with which a terminal, a person or a service manager interrupts programs: the
/// simulated run is not at fault then. SIGKILL is not among these signals, as it may come from a system that is short of memory, which may well be
/// the fault of the run.
fn interruption(status: ExitStatus) -> Option<String> {
    #[cfg(unix)]
    {
        use std::os::unix::process::ExitStatusExt;
        // POSIX: 1 is SIGHUP, 2 SIGINT, 15 SIGTERM.
        if let Some(signal @ (1 | 2 | 15)) = status.signal() {
            return Some(format!("its process was interrupted from outside by signal {signal}"));
        }
    }
    let _ = status;
    None
}

/// Returns the place of a panic in the source, without the column, or else the exit status of the process.
fn place(said: &str, status: &str) -> String {
    let panicked = said.lines().find_map(|line| line.split_once("panicked at ")).map(|(_, place)| place);
    let Some(place) = panicked else { return status.to_owned() };
    let parts: Vec<&str> = place.trim_end_matches(':').split(':').collect();
    parts.iter().take(2).copied().collect::<Vec<_>>().join(":")
}

/// Returns the processor time of a process and its threads, where the system reports it (Linux: fields 14 and 15 of `stat`, in hundredths
/// of a second).
fn processor_s(process: u32) -> Option<f64> {
    let text = fs::read_to_string(format!("/proc/{process}/stat")).ok()?;
    // The name of the process, which stands in brackets before these fields, may itself hold blanks and brackets.
    let fields: Vec<&str> = text.rsplit_once(')')?.1.split_whitespace().collect();
    let ticks = |index: usize| fields.get(index)?.parse::<f64>().ok();
    Some((ticks(11)? + ticks(12)?) / 100.0)
}

/// Returns the memory in kilobytes that a process holds, where the system reports it.
fn memory_kb(process: u32) -> Option<u64> {
    let text = fs::read_to_string(format!("/proc/{process}/status")).ok()?;
    let line = text.lines().find(|line| line.starts_with("VmRSS:"))?;
    line.split_whitespace().nth(1)?.parse().ok()
}

#[cfg(test)]
mod tests {
    use super::{ExitStatus, interruption, place};

    #[test]
    fn a_panic_is_told_by_file_and_line_and_an_abort_by_its_signal() {
        let said = "\nthread 'main' (7) panicked at localizer/src/boxes.rs:37:9:\ncapacity overflow\n";
        assert_eq!(place(said, "exit status: 101"), "localizer/src/boxes.rs:37");
        assert_eq!(place("", "signal: 9 (SIGKILL)"), "signal: 9 (SIGKILL)");
    }

    #[cfg(unix)]
    #[test]
    fn a_signal_from_a_terminal_or_a_person_is_no_crash() {
        use std::os::unix::process::ExitStatusExt;
        for interrupts in [1, 2, 15] {
            let reason = interruption(ExitStatus::from_raw(interrupts));
            assert!(reason.is_some_and(|reason| reason.contains(&interrupts.to_string())));
        }
        // SIGABRT, SIGKILL and SIGSEGV end a run that has gone wrong. In the raw status of a process the exit code is the second byte, so that `2 <<
        // 8` is exit code 2.
        for crashes in [6, 9, 11, 2 << 8] {
            assert_eq!(interruption(ExitStatus::from_raw(crashes)), None);
        }
    }
}

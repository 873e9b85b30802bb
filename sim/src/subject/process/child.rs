//! A process under test as an operating system has it: started, written to, listened to, and ended with every process that it started in turn.

use std::{
    io::{self, BufRead, BufReader, Read, Write},
    process::{Child, Command, ExitStatus, Stdio},
    sync::mpsc::{self, Receiver, RecvTimeoutError, Sender, SyncSender},
    thread,
    time::{Duration, Instant},
};

/// Greatest length of a line. An answer with ten thousand samples has a tenth of it.
const LONGEST_LINE: u64 = 8 << 20;
/// Greatest length of the kept part of a process's standard error; what is kept is the end.
const LONGEST_LOG: usize = 8 << 20;
/// Number of lines that are read before somebody wants them. A process that writes on then has to wait.
const LINES_AHEAD: usize = 4;
/// Time within which a process that closes its pipes ends if it is about to end: freeing the memory of a great process takes some tenths of a second.
const TIME_TO_END: Duration = Duration::from_secs(2);
/// Time between two looks at whether a process has ended.
const LOOK: Duration = Duration::from_millis(2);

/// What a process does that concerns the simulator.
enum Event {
    /// It wrote a line to its standard output.
    Line(Vec<u8>),
    /// It wrote more than a line may have.
    TooLong,
    /// It closed its standard output.
    Closed,
    /// It closed its standard input.
    Deaf,
}

/// A running process with its pipes.
pub(super) struct Running {
    child: Child,
    /// Ends the process where this program is killed; none where it cannot be started.
    guard: Option<Child>,
    /// How the process ended, once it has been waited for.
    status: Option<ExitStatus>,
    events: Receiver<Event>,
    log: Receiver<Vec<u8>>,
}

impl Running {
    /// Starts a command by the shell. Bytes that are sent into the returned pipe reach the process's standard input in order.
    pub(super) fn start(command: &str) -> io::Result<(Running, Sender<Vec<u8>>)> {
        let mut shell = by_shell(command);
        let mut child = shell.stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn()?;
        let (sender, events) = mpsc::sync_channel(LINES_AHEAD);
        let (pipe, bytes) = mpsc::channel();
        let (end, log) = mpsc::channel();
        // The threads end with the pipes. They are not waited for, as a process that left the group could keep a pipe open.
        if let Some(input) = child.stdin.take() {
            let events = sender.clone();
            thread::spawn(move || write_all(input, &bytes, &events));
        }
        if let Some(output) = child.stdout.take() {
            thread::spawn(move || read_lines(output, &sender));
        }
        if let Some(errors) = child.stderr.take() {
            thread::spawn(move || end.send(read_end(errors)));
        }
        let guard = guard_of(&child);
        Ok((Running { child, guard, status: None, events, log }, pipe))
    }

    /// The next line that the process writes, if it does so within `limit`. The error says what the process did instead.
    pub(super) fn line(&mut self, limit: Duration) -> Result<Vec<u8>, String> {
        match self.events.recv_timeout(limit) {
            Ok(Event::Line(line)) => Ok(line),
            Ok(Event::TooLong) => {
                Err(format!("it wrote {LONGEST_LINE} bytes without the end of a line, expected an answer of one line"))
            }
            Ok(Event::Closed) | Err(RecvTimeoutError::Disconnected) => Err(self.ended("output")),
            Ok(Event::Deaf) => Err(self.ended("input")),
            Err(RecvTimeoutError::Timeout) => Err(format!("it gave no answer within {} s", limit.as_secs_f64())),
        }
    }

    /// What there is to say of a process that closed its standard input or output.
    fn ended(&mut self, closed: &str) -> String {
        let status = self.ends_within(TIME_TO_END).then(|| self.end());
        match status {
            Some(Ok(status)) => format!("it ended before it answered: {status}"),
            Some(Err(_)) | None => format!("it closed its standard {closed}"),
        }
    }

    /// Whether the process ends within a time. One that has ended is still to be waited for, so that its number stays its own.
    pub(super) fn ends_within(&mut self, limit: Duration) -> bool {
        let began = Instant::now();
        loop {
            if self.status.is_some() || has_ended(&mut self.child) {
                return true;
            }
            if began.elapsed() >= limit {
                return false;
            }
            thread::sleep(LOOK);
        }
    }

    /// Ends the process and all that it started in its group, and returns how the process ended.
    fn end(&mut self) -> io::Result<ExitStatus> {
        if let Some(status) = self.status {
            return Ok(status);
        }
        // The guard ends first: once the process has been waited for, the number of its group may be another group's.
        if let Some(mut guard) = self.guard.take() {
            let _ = guard.kill();
            let _ = guard.wait();
        }
        end_group(&mut self.child);
        let status = self.child.wait()?;
        self.status = Some(status);
        Ok(status)
    }

    /// Ends the process, and returns what it wrote to its standard error, the end of it if it was much.
    pub(super) fn into_log(mut self) -> String {
        // A process that cannot be waited for is not there any more.
        let _ = self.end();
        let log = self.log.recv_timeout(TIME_TO_END).unwrap_or_default();
        String::from_utf8_lossy(&log).into_owned()
    }
}

impl Drop for Running {
    fn drop(&mut self) {
        let _ = self.end();
    }
}

#[cfg(unix)]
fn by_shell(command: &str) -> Command {
    use std::os::unix::process::CommandExt;
    let mut shell = Command::new("sh");
    // A group of its own makes it possible to end the process with all that it starts.
    shell.args(["-c", command]).process_group(0);
    shell
}

#[cfg(not(unix))]
fn by_shell(command: &str) -> Command {
    let mut shell = Command::new("cmd");
    shell.args(["/C", command]);
    shell
}

/// Starts a shell that waits for the end of its standard input, which comes when this program ends in whatever way, and then ends the process's group.
/// It is in a group of its own, so that an interrupt from the terminal does not end it.
#[cfg(unix)]
fn guard_of(child: &Child) -> Option<Child> {
    use std::os::unix::process::CommandExt;
    let group = format!("-{}", child.id());
    let mut shell = Command::new("sh");
    shell.args(["-c", "read -r _; kill -s KILL -- \"$1\"", "sh", &group]).process_group(0);
    shell.stdin(Stdio::piped()).stdout(Stdio::null()).stderr(Stdio::null()).spawn().ok()
}

#[cfg(not(unix))]
fn guard_of(_child: &Child) -> Option<Child> {
    None
}

/// Whether a process has ended. It is not waited for, which would free its number for another process while its group is still to be ended.
#[cfg(unix)]
fn has_ended(child: &mut Child) -> bool {
    use rustix::process::{WaitId, WaitIdOptions, waitid};
    let Some(pid) = pid(child) else { return true };
    let options = WaitIdOptions::EXITED | WaitIdOptions::NOHANG | WaitIdOptions::NOWAIT;
    // A process that cannot be waited for is not there any more.
    waitid(WaitId::Pid(pid), options).map_or(true, |status| status.is_some())
}

#[cfg(not(unix))]
fn has_ended(child: &mut Child) -> bool {
    child.try_wait().map_or(true, |status| status.is_some())
}

#[cfg(unix)]
fn pid(child: &Child) -> Option<rustix::process::Pid> {
    i32::try_from(child.id()).ok().and_then(rustix::process::Pid::from_raw)
}

/// Ends the group of a process that has not been waited for: by then its number could be that of another group.
#[cfg(unix)]
fn end_group(child: &mut Child) {
    if let Some(pid) = pid(child) {
        let _ = rustix::process::kill_process_group(pid, rustix::process::Signal::KILL);
    }
}

#[cfg(not(unix))]
fn end_group(child: &mut Child) {
    let _ = child.kill();
}

/// Writes bytes into a pipe in the order in which they come, until there are no more or nobody reads.
fn write_all(mut input: impl Write, bytes: &Receiver<Vec<u8>>, events: &SyncSender<Event>) {
    while let Ok(bytes) = bytes.recv() {
        if input.write_all(&bytes).is_err() {
            // Nobody listens any more when the run has ended.
            let _ = events.send(Event::Deaf);
            return;
        }
    }
}

fn read_lines(output: impl Read, events: &SyncSender<Event>) {
    let mut output = BufReader::new(output);
    loop {
        let mut line = Vec::new();
        let event = match (&mut output).take(LONGEST_LINE).read_until(b'\n', &mut line) {
            Ok(n_read) if line.ends_with(b"\n") && n_read > 0 => Event::Line(line),
            Ok(n_read) if n_read as u64 == LONGEST_LINE => Event::TooLong,
            Ok(_) | Err(_) => Event::Closed,
        };
        let is_last = !matches!(event, Event::Line(_));
        if events.send(event).is_err() || is_last {
            return;
        }
    }
}

/// Reads everything, and returns the end of it.
fn read_end(mut errors: impl Read) -> Vec<u8> {
    let (mut kept, mut piece) = (Vec::new(), vec![0; 1 << 16]);
    while let Ok(n_read @ 1..) = errors.read(&mut piece) {
        kept.extend_from_slice(&piece[..n_read]);
        if kept.len() > 2 * LONGEST_LOG {
            kept.drain(..kept.len() - LONGEST_LOG);
        }
    }
    kept.drain(..kept.len().saturating_sub(LONGEST_LOG));
    kept
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;

    const LIMIT: Duration = Duration::from_secs(10);

    #[test]
    fn the_bytes_that_are_sent_reach_the_process_in_order() {
        let (mut running, pipe) = Running::start("cat").unwrap();
        for text in ["one\ntw", "o\n"] {
            pipe.send(text.as_bytes().to_vec()).unwrap();
        }
        assert_eq!([running.line(LIMIT), running.line(LIMIT)], [Ok(b"one\n".to_vec()), Ok(b"two\n".to_vec())]);
        drop(pipe);
        // `cat` ends with its input.
        assert!(running.ends_within(LIMIT));
    }

    #[test]
    fn the_log_is_the_end_of_what_a_process_says() {
        let (mut running, _pipe) = Running::start("echo first >&2; echo last >&2; echo done").unwrap();
        assert_eq!(running.line(LIMIT), Ok(b"done\n".to_vec()));
        assert_eq!(running.into_log(), "first\nlast\n");
        let much = vec![b'x'; 3 * LONGEST_LOG];
        assert_eq!(read_end([&much[..], b"last"].concat().as_slice()).len(), LONGEST_LOG);
    }

    #[test]
    #[cfg(target_os = "linux")]
    fn a_process_that_has_been_ended_is_gone() {
        let (running, _pipe) = Running::start("sleep 1000").unwrap();
        let entry = format!("/proc/{}", running.child.id());
        assert!(std::path::Path::new(&entry).exists());
        drop(running);
        // A process that nobody has waited for would still have its entry.
        assert!(!std::path::Path::new(&entry).exists());
    }

    #[test]
    fn a_process_that_hangs_is_waited_for_as_long_as_its_limit() {
        let (mut running, _pipe) = Running::start("sleep 1000").unwrap();
        let limit = Duration::from_secs(1);
        let began = Instant::now();
        assert_eq!(running.line(limit), Err("it gave no answer within 1 s".to_owned()));
        let answered = began.elapsed();
        assert!(!running.ends_within(limit));
        for waited in [answered, began.elapsed() - answered] {
            assert!(waited >= limit && waited < 2 * limit, "{waited:?}");
        }
    }
}

//! The machine that runs, in words.

use std::{env::consts, fs, sync::OnceLock, thread};

/// Processor, number of cores and system, such as `AMD EPYC 7B13, 2 cores, linux x86_64`.
pub fn machine() -> &'static str {
    static MACHINE: OnceLock<String> = OnceLock::new();
    MACHINE.get_or_init(|| {
        let cores = cores();
        let plural = if cores == 1 { "" } else { "s" };
        let system = format!("{cores} core{plural}, {} {}", consts::OS, consts::ARCH);
        processor().map_or(system.clone(), |name| format!("{name}, {system}"))
    })
}

/// Cores that this process may use.
pub fn cores() -> usize {
    thread::available_parallelism().map_or(1, usize::from)
}

/// What Linux calls the processor; other systems tell only to programs of their own.
fn processor() -> Option<String> {
    let text = fs::read_to_string("/proc/cpuinfo").ok()?;
    let line = text.lines().find(|line| line.starts_with("model name"))?;
    Some(line.split_once(':')?.1.trim().to_owned())
}

//! A description in words of the computer that runs the simulation.

use std::{env::consts, fs, sync::OnceLock, thread};

/// Description of this computer: processor, number of cores and system, such as `AMD EPYC 7B13, 2 cores, linux x86_64`.
pub fn machine() -> &'static str {
    static MACHINE: OnceLock<String> = OnceLock::new();
    MACHINE.get_or_init(|| {
        let cores = cores();
        let plural = if cores == 1 { "" } else { "s" };
        let system = format!("{cores} core{plural}, {} {}", consts::OS, consts::ARCH);
        processor().map_or(system.clone(), |name| format!("{name}, {system}"))
    })
}

/// Number of processor cores that this process may use.
pub fn cores() -> usize {
    thread::available_parallelism().map_or(1, usize::from)
}

/// The processor's name as Linux gives it in `/proc/cpuinfo`; `None` on other systems, which have no such file.
fn processor() -> Option<String> {
    let text = fs::read_to_string("/proc/cpuinfo").ok()?;
    let line = text.lines().find(|line| line.starts_with("model name"))?;
    Some(line.split_once(':')?.1.trim().to_owned())
}

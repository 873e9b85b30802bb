//! The `wherein` command.

use std::process::ExitCode;

fn main() -> ExitCode {
    keep_mesa_quiet();
    sim::cli::main()
}

/// Switches off the Vulkan layer of the Mesa graphics drivers that chooses a device, by an environment variable. The layer asks for a display; where
/// there is none, it prints an error message although nothing is wrong.
#[allow(unsafe_code)]
fn keep_mesa_quiet() {
    const LAYER_OFF: &str = "NODEVICE_SELECT";
    if std::env::var_os(LAYER_OFF).is_none() {
        // SAFETY: the process has not started a second thread yet, so that no other thread reads the environment while it changes.
        unsafe { std::env::set_var(LAYER_OFF, "1") };
    }
}

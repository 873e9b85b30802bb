//! The `wherein` command.

use std::process::ExitCode;

fn main() -> ExitCode {
    keep_mesa_quiet();
    sim::cli::main()
}

/// Mesa's layer for choosing a device asks for a display. Where there is no display, the layer prints an error message although nothing
/// is wrong; a variable of the environment switches the layer off.
#[allow(unsafe_code)]
fn keep_mesa_quiet() {
    const LAYER_OFF: &str = "NODEVICE_SELECT";
    if std::env::var_os(LAYER_OFF).is_none() {
        // SAFETY: the process has not started a second thread yet, so that no other thread reads the environment while it changes.
        unsafe { std::env::set_var(LAYER_OFF, "1") };
    }
}

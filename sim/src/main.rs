//! The `wherein` command.

use std::process::ExitCode;

fn main() -> ExitCode {
    keep_mesa_quiet();
    sim::cli::main()
}

/// Mesa's layer for choosing a device asks for a display; without one it prints an error that is none.
#[allow(unsafe_code)]
fn keep_mesa_quiet() {
    const LAYER_OFF: &str = "NODEVICE_SELECT";
    if std::env::var_os(LAYER_OFF).is_none() {
        // SAFETY: nothing has started a second thread yet, so that nobody reads the environment meanwhile.
        unsafe { std::env::set_var(LAYER_OFF, "1") };
    }
}

//! The `wherein` command under a name of its own, because Cargo tells tests where to find only the programs of their own package.

use std::process::ExitCode;

fn main() -> ExitCode {
    sim::cli::main()
}

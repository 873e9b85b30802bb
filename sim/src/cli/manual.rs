//! Completions for shells and manual pages for `man`.

#[cfg(feature = "man")]
use std::{fs, path::Path};

use clap::CommandFactory;
use clap_complete::Shell;

use super::{Cli, CommandError, print};

/// Prints the completions for a shell.
pub(super) fn completions(shell: Shell) -> Result<(), CommandError> {
    let mut text = Vec::new();
    clap_complete::generate(shell, &mut Cli::command(), "wherein", &mut text);
    print(&String::from_utf8_lossy(&text))
}

/// Prints the manual page of the command, or writes the pages of all subcommands into a folder.
#[cfg(feature = "man")]
pub(super) fn manual(out: Option<&Path>) -> Result<(), CommandError> {
    let Some(folder) = out else {
        let mut text = Vec::new();
        clap_mangen::Man::new(Cli::command()).render(&mut text)?;
        return print(&String::from_utf8_lossy(&text));
    };
    let written = fs::create_dir_all(folder).and_then(|()| clap_mangen::generate_to(Cli::command(), folder));
    written.map_err(|error| CommandError::Unwritable(folder.to_owned(), error))
}

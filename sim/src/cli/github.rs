//! What GitHub Actions shows of a job: annotations at the failed scenes, and a summary.

use std::{
    env,
    fs::OpenOptions,
    io::Write,
    path::{Component, Path, PathBuf},
};

use crate::{
    artefacts::run_files::naming,
    campaign::{
        cases::{CaseResult, Results},
        junit::{failure_account, failure_message},
        report::{Overview, as_markdown},
    },
};

use super::CommandError;

/// GitHub shows no more errors than this of one step.
const MOST: usize = 10;

/// Annotates the worst failures and appends to the job's summary, where the process runs in GitHub Actions.
pub(super) fn tell_github(overview: &Overview, results: &Results) -> Result<(), CommandError> {
    if env::var("GITHUB_ACTIONS").as_deref() != Ok("true") {
        return Ok(());
    }
    let absent = results.missing().map(|case| (case, "missing".to_owned()));
    let failed = results.failed().map(|(case, reason)| (case, reason.to_owned()));
    let missed = overview.worst.iter().map(|index| &results.cases[*index]);
    let missed = missed.filter(|case| case.passed() == Some(false)).map(|case| (case, failure_message(case)));
    for (case, message) in failed.chain(missed).chain(absent).take(MOST) {
        // Commands are read from both streams, and standard output may be asked for in JSON. If the stream is closed, the
        // exit code still tells.
        let _ = writeln!(std::io::stderr(), "{}", annotation(case, &message));
    }
    let Some(path) = env::var_os("GITHUB_STEP_SUMMARY").filter(|path| !path.is_empty()) else { return Ok(()) };
    let summary = as_markdown(overview, results);
    let file = OpenOptions::new().append(true).create(true).open(&path);
    Ok(naming("write", path.as_ref(), file.and_then(|mut file| file.write_all(summary.as_bytes())))?)
}

fn annotation(case: &CaseResult, message: &str) -> String {
    let title = property(&case.describe(true));
    let file = property(&straight(&case.scene_path).display().to_string());
    let message = data(&failure_account(case, message));
    format!("::error file={file},title={title}::{message}")
}

/// The path without `folder/..`, as annotations are put to files by their names: a sweep's file names its scene from its own folder.
fn straight(path: &Path) -> PathBuf {
    let mut straight = PathBuf::new();
    for component in path.components() {
        let goes_back = component == Component::ParentDir
            && matches!(straight.components().next_back(), Some(Component::Normal(_)));
        if goes_back {
            straight.pop();
        } else if component != Component::CurDir {
            straight.push(component);
        }
    }
    straight
}

/// Text after the `::` of a workflow command.
fn data(text: &str) -> String {
    text.replace('%', "%25").replace('\r', "%0D").replace('\n', "%0A")
}

/// Text of a property of a workflow command.
fn property(text: &str) -> String {
    data(text).replace(':', "%3A").replace(',', "%2C")
}

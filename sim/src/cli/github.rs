//! Output for GitHub Actions: annotations at the failed scenes, and a summary of the job.

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

/// Greatest number of error annotations that are written: GitHub shows no more of one step.
const MOST: usize = 10;

/// Annotates the worst failures and appends to the job's summary, if the process runs in GitHub Actions; otherwise does nothing.
pub(super) fn tell_github(overview: &Overview, results: &Results) -> Result<(), CommandError> {
    if env::var("GITHUB_ACTIONS").as_deref() != Ok("true") {
        return Ok(());
    }
    let absent = results.missing().map(|case| (case, "missing".to_owned()));
    let failed = results.failed().map(|(case, reason)| (case, reason.to_owned()));
    let missed = overview.worst.iter().map(|index| &results.cases[*index]);
    let missed = missed.filter(|case| case.passed() == Some(false)).map(|case| (case, failure_message(case)));
    for (case, message) in failed.chain(missed).chain(absent).take(MOST) {
        // GitHub reads annotations from both streams, and standard output may have to be pure JSON. If standard error is closed, the exit
        // code still shows the failure.
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

/// Returns the path without parts such as `folder/..`. GitHub assigns annotations to files by name, and a sweep file gives the path of
/// its scene relative to its own folder.
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

/// Escapes text for the part after the `::` of a GitHub workflow command.
fn data(text: &str) -> String {
    text.replace('%', "%25").replace('\r', "%0D").replace('\n', "%0A")
}

/// Escapes text for a property of a GitHub workflow command.
fn property(text: &str) -> String {
    data(text).replace(':', "%3A").replace(',', "%2C")
}

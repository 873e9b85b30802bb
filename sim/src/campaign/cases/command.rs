//! Shell commands that repeat the run of a case.

use std::{env, fmt};

use crate::{artefacts::run_files::is_library, subject::SubjectChoice};

use super::CaseResult;

/// A shell command that runs one case again and writes its debug frames, the pictures that show what the vision found in camera images. Where no
/// command can start the localizer under test, it is a comment of the shell instead, which says what runs the case again.
#[derive(Clone, Debug)]
pub struct Replay(String);

impl Replay {
    /// Returns the command that runs `case` again and writes its results into `out`.
    pub fn of(case: &CaseResult, out: &str) -> Replay {
        if case.subject_is_elsewhere {
            return Replay(elsewhere(case));
        }
        if case.scene_path.as_os_str().is_empty() {
            return Replay(of_scene_elsewhere(case));
        }
        let scene = case.scene_path.display().to_string();
        let log = case.timing().and_then(|timing| timing["log_path"].as_str());
        let mut words = program();
        let mut add = |more: &[&str]| words.extend(more.iter().map(|word| (*word).to_owned()));
        match log {
            Some(log) => add(&["replay", "--robot", &scene, log]),
            None => add(&["run", &scene]),
        }
        for setting in &case.settings {
            add(&["--set", &setting.to_string()]);
        }
        if case.subject != SubjectChoice::default().to_string() {
            add(&["--subject", &case.subject]);
        }
        if log.is_none() {
            // In a case that passed and never lost the truth there is no failure to draw, so that a debug frame of every 20th image is asked for.
            let is_clean = case.passed() == Some(true) && case.first_failure().is_null();
            add(&["--seed", &case.seed.to_string(), "--frames", if is_clean { "every=20" } else { "failures" }]);
        }
        add(&["--out", out]);
        Replay(words.iter().map(|word| quoted(word)).collect::<Vec<_>>().join(" "))
    }
}

/// What runs a case again of which only the name of its scene is known, as for a table of results without the sweep that it came from.
fn of_scene_elsewhere(case: &CaseResult) -> String {
    let CaseResult { scene, seed, .. } = case;
    let subject = subject_option(&case.subject);
    let settings: String = case.settings.iter().map(|one| format!(" --set {}", quoted(&one.to_string()))).collect();
    format!("# run the scene {scene} from its file, which is not known here, with{settings} --seed {seed}{subject}")
}

/// What runs a case again whose localizer lives in a program of its user, and not in a command.
fn elsewhere(case: &CaseResult) -> String {
    let CaseResult { subject, seed, .. } = case;
    let scene = case.scene_path.display();
    let settings: Vec<String> = case.settings.iter().map(|setting| format!(" with {setting}")).collect();
    let settings = settings.join(" and");
    format!(
        "# the localizer {subject} lives in a program of its own: have that drive {scene}{settings} and seed {seed}"
    )
}

impl fmt::Display for Replay {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.0)
    }
}

/// Returns the beginning of a command line that starts this program again: the program's name as the user called it, and the option for the graphics
/// adapter that the user chose, as other adapters give other bytes. Where this code is a library of another program, it is the command `wherein`.
pub fn program() -> Vec<String> {
    if is_library() {
        return vec!["wherein".to_owned()];
    }
    let mut arguments = env::args();
    let mut words = vec![arguments.next().unwrap_or_else(|| "wherein".to_owned())];
    while let Some(argument) = arguments.next() {
        let value = argument.strip_prefix("--adapter=").map(str::to_owned);
        let value = if argument == "--adapter" { arguments.next() } else { value };
        words.extend(value.map(|value| format!("--adapter={value}")));
    }
    words
}

/// The option that chooses the localizer of this name, with a blank before it; empty for the localizer that is tested without the option.
pub fn subject_option(name: &str) -> String {
    if name == SubjectChoice::default().to_string() { String::new() } else { format!(" --subject {}", quoted(name)) }
}

/// Quotes `text` so that a POSIX shell reads it as one word.
pub fn quoted(text: &str) -> String {
    let is_plain = |c: char| c.is_ascii_alphanumeric() || "/._-+=:@,".contains(c);
    if !text.is_empty() && text.chars().all(is_plain) {
        text.to_owned()
    } else {
        format!("'{}'", text.replace('\'', r"'\''"))
    }
}

#[cfg(test)]
mod tests {
    use std::path::PathBuf;

    use crate::campaign::sweep::Recorded;

    use super::*;

    #[test]
    fn a_localizer_in_a_program_of_its_own_is_told_instead_of_a_command() {
        let mut case = CaseResult {
            id: String::new(),
            scene: "x".to_owned(),
            scene_path: PathBuf::from("x.toml"),
            settings: ["duration_s=20"].iter().filter_map(|text| text.parse().ok()).collect(),
            seed: 3,
            subject: "my filter".to_owned(),
            subject_is_elsewhere: false,
            folder: PathBuf::new(),
            recorded: Recorded::Missing,
        };
        assert!(Replay::of(&case, "renders").to_string().contains(" --subject 'my filter' --seed 3 "));
        case.scene_path = PathBuf::new();
        let told = Replay::of(&case, "renders").to_string();
        assert!(told.starts_with("# run the scene x "), "{told}");
        assert!(told.ends_with("with --set duration_s=20 --seed 3 --subject 'my filter'"), "{told}");
        case.scene_path = PathBuf::from("x.toml");
        case.subject_is_elsewhere = true;
        let told = Replay::of(&case, "renders").to_string();
        assert!(told.starts_with('#') && !told.contains("--subject"), "{told}");
        for part in ["my filter", "x.toml", "duration_s=20", "seed 3"] {
            assert!(told.contains(part), "{told}");
        }
    }
}

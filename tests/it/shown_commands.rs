use std::{
    fs,
    path::{Path, PathBuf},
};

use crate::{command::root, documents::documents};

/// What stands in a word for a variable, or for anything else whose value only the shell knows.
const UNKNOWN: char = '\u{1}';

/// A word of a shell's line, or a character that ends the command before it.
#[derive(Debug, PartialEq)]
enum Token {
    Word(String),
    End,
}

/// The lines of a text, each with its number. A line goes on in the next one if it ends with a backslash, or if that one begins with an option.
fn whole_lines<'a>(lines: impl Iterator<Item = (usize, &'a str)>) -> Vec<(usize, String)> {
    let mut whole: Vec<(usize, String)> = Vec::new();
    for (number, line) in lines {
        match whole.last_mut() {
            Some((_, before)) if before.ends_with('\\') => {
                before.pop();
                *before += line.trim();
            }
            Some((_, before)) if line.trim().starts_with("--") => *before += &format!(" {}", line.trim()),
            _ => whole.push((number, line.trim().to_owned())),
        }
    }
    whole
}

/// The lines within a document's code blocks for a shell, and in those without a language, each with its number.
fn code_lines(text: &str) -> Vec<(usize, &str)> {
    let mut language = None;
    let mut lines = Vec::new();
    for (idx, line) in text.lines().enumerate() {
        match (line.trim().strip_prefix("```"), language) {
            (Some(opened), None) => language = Some(opened),
            (Some(_), Some(_)) => language = None,
            (None, Some("" | "sh")) => lines.push((idx + 1, line)),
            (None, _) => {}
        }
    }
    lines
}

/// Reads a variable of the shell, or what a shell or another program puts in place of it, after its `$`. It is the program's name if that is in it.
fn variable(rest: &mut std::iter::Peekable<std::str::Chars<'_>>) -> String {
    let opening = rest.peek().copied();
    let mut name = String::new();
    match opening {
        Some('(' | '{') => {
            let mut depth = 0;
            for letter in rest.by_ref() {
                name.push(letter);
                depth += i32::from("({".contains(letter)) - i32::from(")}".contains(letter));
                if depth == 0 {
                    break;
                }
            }
        }
        Some(letter) if letter.is_alphabetic() || letter == '_' => {
            while let Some(letter) = rest.next_if(|letter| letter.is_alphanumeric() || *letter == '_') {
                name.push(letter);
            }
        }
        Some(letter) if !letter.is_whitespace() => name.extend(rest.next()),
        _ => return "$".to_owned(),
    }
    let name = name.trim_matches(['(', ')', '{', '}']).to_lowercase();
    match name.split(':').next() {
        Some("wherein") => "wherein".to_owned(),
        // Further options, or none at all.
        Some("flags") => String::new(),
        _ => UNKNOWN.to_string(),
    }
}

/// Splits a line into words as a POSIX shell does.
fn tokens(line: &str) -> Vec<Token> {
    let mut found = Vec::new();
    let mut word: Option<String> = None;
    let mut quote = None;
    let mut rest = line.chars().peekable();
    while let Some(letter) = rest.next() {
        match (letter, quote) {
            ('\'', Some('\'')) | ('"', Some('"')) => quote = None,
            (_, Some('\'')) => word.get_or_insert_default().push(letter),
            ('\\', _) => word.get_or_insert_default().extend(rest.next()),
            ('$', _) => *word.get_or_insert_default() += &variable(&mut rest),
            (_, Some(_)) => word.get_or_insert_default().push(letter),
            ('\'' | '"', None) => {
                quote = Some(letter);
                word.get_or_insert_default();
            }
            ('#', None) if word.is_none() => break,
            (';' | '|' | '&' | '<' | '>' | '(' | ')', None) => {
                // The number of a stream before an arrow is no argument.
                let is_stream = |word: &String| "<>".contains(letter) && word.chars().all(|one| one.is_ascii_digit());
                found.extend(word.take().filter(|word| !is_stream(word)).map(Token::Word));
                found.push(Token::End);
            }
            (_, None) if letter.is_whitespace() => found.extend(word.take().map(Token::Word)),
            (_, None) => word.get_or_insert_default().push(letter),
        }
    }
    found.extend(word.map(Token::Word));
    found
}

/// The arguments of the command `wherein` in the words of one command of the shell; none where it is another command.
fn arguments(words: &[String]) -> Option<Vec<String>> {
    /// Words before a command that belong to the shell, to a prompt, or to the file of a workflow.
    const BEFORE: [&str; 9] = ["$", "-", "!", "if", "then", "else", "do", "exec", "run:"];
    let begin = words.iter().position(|word| !BEFORE.contains(&word.as_str()) && !word.contains('='))?;
    let words = &words[begin..];
    let is_program = |word: &String| word == "wherein" || word.ends_with("/wherein");
    let is_cargo = words[0] == "cargo" && words.get(1).is_some_and(|word| word == "run");
    let at = if is_program(&words[0]) {
        0
    } else if is_cargo && words.iter().any(|word| word == "wherein-sim") {
        words.iter().position(|word| word == "--")?
    } else if words.get(1).is_some_and(|word| word == "run") {
        // A container's image is named like the program in it.
        words.iter().position(is_program)?
    } else {
        return None;
    };
    let first = words.get(at + 1)?;
    (!first.contains(UNKNOWN)).then(|| words[at + 1..].to_vec())
}

/// A command of `wherein` with values that its parser takes for what only the shell, or the reader, knows.
fn filled_in(arguments: &[String]) -> Vec<String> {
    let mut words = vec!["wherein".to_owned()];
    for argument in arguments
        .iter()
        .filter(|argument| !argument.is_empty())
        .map(|argument| argument.replace("{}", &UNKNOWN.to_string()))
    {
        let last = words.last().map(String::as_str);
        let is_unknown = argument.trim_matches('"') == UNKNOWN.to_string();
        words.push(match (last, argument.as_str()) {
            (Some("--seeds" | "--cases"), _) if is_unknown => "0..1".to_owned(),
            (Some("--set" | "--vary"), _) if is_unknown => "key=1".to_owned(),
            (Some("--at"), "x,y,heading") => "1,1,0".to_owned(),
            _ => argument.replace(UNKNOWN, "1"),
        });
    }
    words
}

/// Every command of `wherein` in a line, also in words that are a line of their own.
fn commands(line: &str) -> Vec<Vec<String>> {
    // A comment that ends with a command says what to do next.
    let line = line.strip_prefix('#').map_or(line, |comment| comment.split_once(": ").map_or("", |(_, after)| after));
    let mut found = Vec::new();
    let tokens = tokens(line);
    for command in tokens.split(|token| *token == Token::End) {
        let words: Vec<String> = command
            .iter()
            .filter_map(|token| if let Token::Word(word) = token { Some(word.clone()) } else { None })
            .collect();
        found.extend(arguments(&words).map(|arguments| filled_in(&arguments)));
        found.extend(words.iter().filter(|word| word.starts_with("wherein ")).flat_map(|word| commands(word)));
    }
    found
}

/// Commands in `back quotes`, each with the number of its line. Such a command may lack what it needs to run.
fn named_commands(text: &str) -> Vec<(usize, Vec<String>)> {
    let begins = text.match_indices("`wherein ");
    let named = begins.filter_map(|(at, _)| Some((at, text[at + 1..].split_once('`')?.0)));
    named
        .flat_map(|(at, command)| {
            let number = 1 + text[..at].matches('\n').count();
            commands(&command.replace('\n', " ")).into_iter().map(move |words| (number, words))
        })
        .collect()
}

/// How many commands a file shows, and what is wrong with which of them.
fn checked(path: &Path, text: &str) -> (usize, Vec<String>) {
    let is_page = path.extension().is_some_and(|ending| ending == "md");
    let is_program = text.starts_with("#!/usr/bin/env python") || path.starts_with("examples");
    let lines: Vec<(usize, &str)> = match (is_page, is_program) {
        (true, _) => code_lines(text),
        // The lines of a program in another language are no shell's.
        (_, true) => Vec::new(),
        _ => text.lines().enumerate().map(|(idx, line)| (idx + 1, line)).collect(),
    };
    let lines = whole_lines(lines.into_iter());
    let shown = lines.iter().flat_map(|(number, line)| commands(line).into_iter().map(|words| (*number, words, true)));
    let named = named_commands(text).into_iter().map(|(number, words)| (number, words, false));
    let (mut n_commands, mut wrong) = (0, Vec::new());
    for (number, words, is_whole) in shown.chain(named) {
        n_commands += 1;
        if let Err(error) = sim::cli::parse(&words) {
            let kind = format!("{:?}", error.kind());
            let lacks = ["MissingRequiredArgument", "MissingSubcommand", "DisplayHelpOnMissingArgumentOrSubcommand"];
            let is_cut_off = lacks.contains(&kind.as_str()) || error.to_string().contains("a value is required");
            if is_whole || !is_cut_off {
                wrong.push(format!("{}:{number}: {}\n{error}", path.display(), words.join(" ")));
            }
        }
    }
    (n_commands, wrong)
}

/// Files beside the documents that call the command: recipes, scripts, workflows and the Makefile.
fn callers() -> Vec<PathBuf> {
    let folders = ["docs/ci", "scripts", ".ci", ".github/workflows", "examples/own_localizer"];
    let entries = folders.into_iter().flat_map(|folder| fs::read_dir(root().join(folder)).unwrap());
    let mut files: Vec<PathBuf> = entries.map(|entry| entry.unwrap().path()).filter(|path| path.is_file()).collect();
    files.push(root().join("Makefile"));
    files
}

#[test]
fn every_command_that_a_document_or_a_script_shows_is_one_of_the_program() {
    let callers = callers().into_iter().map(|path| (path.clone(), fs::read_to_string(path).unwrap()));
    let (mut n_commands, mut wrong) = (0, Vec::new());
    for (path, text) in documents().into_iter().chain(callers) {
        let (n_of_file, of_file) = checked(path.strip_prefix(root()).unwrap(), &text);
        n_commands += n_of_file;
        wrong.extend(of_file);
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
    assert!(n_commands > 100, "{n_commands} commands");
}

#[test]
fn a_misspelt_command_is_told_with_file_and_line() {
    let page = "Text.\n```sh\n$ wherein run x.toml --sede 1 # seed\nA=b wherein report a 2> c | tail\n```\n\
                ```toml\nwherein tell\n```\n`wherein swep --jobs 2` and `wherein sweep --jobs 2`\n\
                ```sh\nwherein sweep x.toml \\\n    --sharp 1/2\n\
                seq 2 | parallel \"wherein sweep x.toml --shard {}/2 --seed 1 || test \\$? -eq 1\"\n\
                cargo run -p wherein-sim -- chek x.toml\npodman run --rm i/wherein rum x.toml\n\
                wherein run \"$scene\" --seeds $seeds && wherein report\n```\n";
    let (n_commands, wrong) = checked(Path::new("page.md"), page);
    let told: Vec<&str> = wrong.iter().map(|text| text.lines().next().unwrap()).collect();
    assert_eq!(
        told,
        [
            "page.md:3: wherein run x.toml --sede 1",
            "page.md:11: wherein sweep x.toml --sharp 1/2",
            "page.md:13: wherein sweep x.toml --shard 1/2 --seed 1",
            "page.md:14: wherein chek x.toml",
            "page.md:15: wherein rum x.toml",
            "page.md:16: wherein report",
            "page.md:9: wherein swep --jobs 2",
        ]
    );
    assert_eq!(n_commands, 10);
    let script = "# Then: wherein mrege a --out b\nif [ -x a/wherein ]; then\n\t\"${WHEREIN:-wherein}\" sweap \"$1\" >b\nfi\n\
                  $(PYTHON) scripts/power --wherein $(WHEREIN)\n\t$(WHEREIN) run $(DEMO_SCENE) --frames every=25\n";
    let (n_commands, wrong) = checked(Path::new("script"), script);
    assert!(wrong.len() == 2 && n_commands == 3, "{n_commands} {wrong:?}");
    assert!(wrong[0].starts_with("script:1: wherein mrege") && wrong[1].starts_with("script:3: wherein sweap"));
}

/// Each call of a script of the repository in a line: the script, and the names of the options that it is given.
fn script_calls(line: &str) -> Vec<(String, Vec<String>)> {
    let tokens = tokens(line);
    let commands = tokens.split(|token| *token == Token::End);
    let call = |command: &[Token]| {
        let words: Vec<&str> = command
            .iter()
            .filter_map(|token| if let Token::Word(word) = token { Some(word.as_str()) } else { None })
            .collect();
        // Before it there may be an interpreter and values of variables.
        let at = words.iter().take(4).position(|word| word.starts_with("scripts/"))?;
        let options = words[at + 1..].iter().filter(|word| word.starts_with("--") && word.len() > 2);
        let names = options.map(|option| option.split('=').next().unwrap().to_owned()).collect();
        Some((words[at].to_owned(), names))
    };
    commands.filter_map(call).collect()
}

/// How many calls of scripts a page shows, and which of them name a script or an option that there is not.
fn checked_scripts(path: &Path, text: &str) -> (usize, Vec<String>) {
    let (mut n_calls, mut wrong) = (0, Vec::new());
    let named = text.match_indices("`scripts/").filter_map(|(at, _)| {
        let call = text[at + 1..].split_once('`')?.0.replace('\n', " ");
        Some((1 + text[..at].matches('\n').count(), call))
    });
    for (number, line) in whole_lines(code_lines(text).into_iter()).into_iter().chain(named) {
        for (script, options) in script_calls(&line) {
            if root().join(&script).is_dir() {
                continue;
            }
            n_calls += 1;
            let mut source = fs::read_to_string(root().join(&script)).unwrap_or_default();
            // The script calls a module of the Python package.
            if source.contains("python/wherein/ray.py") {
                source += &fs::read_to_string(root().join("python/wherein/ray.py")).unwrap();
            }
            // Part of a longer option's name is no option.
            let is_end = |at: usize| !source[at..].starts_with(|next: char| next.is_alphanumeric() || next == '-');
            let has = |option: &String| source.match_indices(option).any(|(at, _)| is_end(at + option.len()));
            if source.is_empty() || !options.iter().all(has) {
                wrong.push(format!("{}:{number}: {line}", path.display()));
            }
        }
    }
    (n_calls, wrong)
}

#[test]
fn every_script_that_a_document_calls_has_the_options_that_it_is_given() {
    let (mut n_calls, mut wrong) = (0, Vec::new());
    for (path, text) in documents() {
        let (n_of_page, of_page) = checked_scripts(path.strip_prefix(root()).unwrap(), &text);
        n_calls += n_of_page;
        wrong.extend(of_page);
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
    assert!(n_calls > 10, "{n_calls} calls");
    let page = "```sh\nscripts/ray_swep x.toml\npython3 scripts/ray_sweep x.toml --out a --addres local\nscripts/ray_sweep x --jobs=2\n```\nAs `scripts/ray_trial --only\noverhead` does.\n";
    let (n_calls, wrong) = checked_scripts(Path::new("page.md"), page);
    assert_eq!((n_calls, wrong.len()), (4, 2), "{wrong:?}");
}

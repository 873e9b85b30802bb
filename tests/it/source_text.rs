//! Reads Rust source files as text: which of their lines are compiled into the library, and which modules they name.

use std::{collections::BTreeSet, fs, path::Path};

/// Calls `see` for each Rust file under a folder, with its path and its text.
pub(crate) fn walk(folder: &Path, see: &mut dyn FnMut(&Path, &str)) {
    let mut paths: Vec<_> = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).collect();
    paths.sort();
    for path in paths {
        if path.is_dir() {
            walk(&path, see);
        } else if path.extension().is_some_and(|ending| ending == "rs") {
            see(&path, &fs::read_to_string(&path).unwrap());
        }
    }
}

/// The part of a source file that is no comment and no block of unit tests.
pub(crate) fn code(text: &str) -> String {
    let mut rest = text;
    let mut without_tests = String::new();
    // The block begins and ends at the left margin.
    while let Some((before, block)) = rest.split_once("\nmod tests {\n") {
        without_tests += before;
        rest = block.split_once("\n}\n").map_or("", |(_, after)| after);
    }
    without_tests += "\n";
    without_tests += rest;
    without_tests.lines().filter(|line| !line.trim_start().starts_with("//")).collect::<Vec<_>>().join("\n")
}

/// The path of the module that a file holds, given by the file's path below the crate's sources: `a/b.rs` and `a/b/mod.rs` both hold `a::b`.
pub(crate) fn module_of(below: &Path) -> Vec<String> {
    let stem = below.with_extension("");
    let mut module: Vec<String> = stem.iter().map(|part| part.to_str().unwrap().to_owned()).collect();
    module.pop_if(|last| last == "mod");
    module
}

/// The modules at the root of the crate that the code of a file names, by paths from the root or up from its own module.
pub(crate) fn named(code: &str, module: &[String]) -> BTreeSet<String> {
    let mut names = BTreeSet::new();
    for (at, _) in code.match_indices("crate::").chain(code.match_indices("super::")) {
        // A path that goes up twice is read from its first step.
        let before = &code[..at];
        if !before.ends_with("::") && !before.ends_with(is_of_a_name) {
            follow(&code[at..], module.to_vec(), &mut names);
        }
    }
    names
}

/// Follows a path, or the paths of a group in braces, from a module to the first name below the root of the crate. Returns what comes after.
fn follow<'a>(path: &'a str, mut module: Vec<String>, names: &mut BTreeSet<String>) -> &'a str {
    let path = path.trim_start();
    if let Some(mut group) = path.strip_prefix('{') {
        loop {
            group = group.trim_start();
            match group.chars().next() {
                None => return group,
                Some('}') => return &group[1..],
                Some(',') => group = &group[1..],
                Some(_) => {
                    let after = follow(group, module.clone(), names);
                    // What a path ends with, such as `as other`, is skipped up to the next path of the group.
                    group = after.trim_start_matches(|letter| letter != ',' && letter != '}');
                }
            }
        }
    }
    let name: String = path.chars().take_while(|letter| is_of_a_name(*letter)).collect();
    let after = &path[name.len()..];
    let Some(further) = after.strip_prefix("::") else {
        if module.is_empty() && !["", "self", "super", "crate"].contains(&name.as_str()) {
            names.insert(name);
        }
        return after;
    };
    match name.as_str() {
        "crate" => module.clear(),
        "super" => drop(module.pop()),
        "self" => {}
        _ => {
            if module.is_empty() {
                names.insert(name.clone());
            }
            module.push(name);
        }
    }
    follow(further, module, names)
}

fn is_of_a_name(letter: char) -> bool {
    letter.is_alphanumeric() || letter == '_'
}

/// Source code without the texts among the arguments of calls of `stream`, which name streams of random numbers.
pub(crate) fn without_names_of_streams(code: &str) -> String {
    let mut kept = String::new();
    let mut rest = code;
    while let Some((before, call)) = rest.split_once("stream(") {
        let is_whole_name = !before.ends_with(is_of_a_name);
        kept += before;
        kept += "stream(";
        rest = call;
        let (mut depth, mut is_text) = (1, false);
        while is_whole_name && depth > 0 {
            let Some(letter) = rest.chars().next() else { break };
            rest = &rest[letter.len_utf8()..];
            match letter {
                '"' => is_text = !is_text,
                '(' if !is_text => depth += 1,
                ')' if !is_text => depth -= 1,
                _ => {}
            }
            if !is_text && letter != '"' {
                kept.push(letter);
            }
        }
    }
    kept + rest
}

/// Every name in a piece of code and every word of its texts, in small letters and without underscores, so that `AbC`, `ab_c` and `AB_C` are the
/// same.
pub(crate) fn words(code: &str) -> BTreeSet<String> {
    let squeezed = |word: &str| word.replace('_', "").to_lowercase();
    code.split(|letter| !is_of_a_name(letter)).filter(|word| !word.is_empty()).map(squeezed).collect()
}

#[test]
fn only_comments_and_the_block_of_unit_tests_are_no_code() {
    let text = "use a;\n#[cfg(test)]\nmod trial;\nuse b;\n// use c;\nfn d() {}\n\n#[cfg(test)]\n#[allow(e)]\nmod tests {\n    use f;\n}\nfn g() {}\n";
    assert_eq!(
        code(text),
        "use a;\n#[cfg(test)]\nmod trial;\nuse b;\nfn d() {}\n\n#[cfg(test)]\n#[allow(e)]\nfn g() {}"
    );
}

#[test]
fn a_path_up_to_the_root_names_the_module_that_it_goes_down_to() {
    let named =
        |code: &str, below: &str| -> Vec<String> { named(code, &module_of(Path::new(below))).into_iter().collect() };
    let code = "use crate::{\n    d::{E, f},\n    g as k,\n};\nfn i() -> crate::j::K {}";
    assert_eq!(named(code, "a.rs"), ["d", "g", "j"]);
    for below in ["a/b.rs", "a/b/mod.rs"] {
        assert_eq!(named("use super::super::{c::D, e};\nlet f = super::super::g::H;", below), ["c", "e", "g"]);
        assert_eq!(named("use super::{super::c::D, e::F};", below), ["c"]);
        assert_eq!(named("use super::c::D;", below), Vec::<String>::new());
    }
    assert_eq!(named("use super::b::C;", "a.rs"), ["b"]);
    assert_eq!(named("use super::super::c;", "a/b/d.rs"), Vec::<String>::new());
}

#[test]
fn only_the_name_of_a_stream_is_taken_out_of_a_line() {
    let code = "let a = (stream(seed, &format!(\"x.{}\", b(1))), \"y.z\"); rng.set_stream(\"k\")";
    assert_eq!(
        without_names_of_streams(code),
        "let a = (stream(seed, &format!(, b(1))), \"y.z\"); rng.set_stream(\"k\")"
    );
}

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

/// A path from the root of a crate that code names, and the name that the code calls it by: the last name of the path, or another one after `as`, or
/// `*` for everything below the path.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct Named {
    pub(crate) path: Vec<String>,
    pub(crate) name: String,
}

/// What the code of a module names by paths that begin with `crate`, `super` or `self`.
pub(crate) fn named(code: &str, module: &[String]) -> BTreeSet<Named> {
    let mut names = BTreeSet::new();
    let mut starts: Vec<usize> =
        ["crate::", "super::", "self::"].iter().flat_map(|first| code.match_indices(first)).map(|(at, _)| at).collect();
    starts.sort_unstable();
    let mut end = 0;
    for at in starts {
        // A path is read from its first step, and a group of paths as one.
        if at >= end && !code[..at].ends_with(is_of_a_name) {
            end = code.len() - follow(&code[at..], module.to_vec(), &mut names).len();
        }
    }
    names
}

/// What the `use` statements at the left margin of a module's file name, given the names of the modules directly below that module.
pub(crate) fn imported(code: &str, module: &[String], children: &[&str]) -> BTreeSet<Named> {
    let mut names = BTreeSet::new();
    for statement in code.split(';') {
        let starts = statement.match_indices("use ").map(|(at, _)| at);
        let Some(start) = starts.filter(|at| is_margin(&statement[..*at])).last() else { continue };
        let path = statement[start..].trim_start_matches("use ").trim();
        let first: String = path.chars().take_while(|letter| is_of_a_name(*letter)).collect();
        // What begins with the name of another crate names nothing of this one.
        if ["crate", "super", "self"].contains(&first.as_str()) {
            follow(path, module.to_vec(), &mut names);
        } else if children.contains(&first.as_str()) {
            follow(&format!("self::{path}"), module.to_vec(), &mut names);
        }
    }
    names
}

/// Whether a statement after this text stands at the left margin, with nothing but its visibility before it.
fn is_margin(before: &str) -> bool {
    let line = before.rsplit('\n').next().unwrap_or_default();
    line.is_empty() || line == "pub " || line.starts_with("pub(") && line.ends_with(") ")
}

/// Follows a path, or the paths of a group in braces, from a module. Returns what comes after.
fn follow<'a>(path: &'a str, mut module: Vec<String>, names: &mut BTreeSet<Named>) -> &'a str {
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
    let is_everything = path.starts_with('*');
    let name: String = path.chars().take_while(|letter| is_of_a_name(*letter)).collect();
    let after = &path[name.len()..];
    let further = after.strip_prefix("::");
    match name.as_str() {
        "crate" => module.clear(),
        "super" => drop(module.pop()),
        "self" | "" => {}
        _ => module.push(name),
    }
    if let Some(further) =
        further.filter(|further| further.starts_with(|letter| is_of_a_name(letter) || "{*".contains(letter)))
    {
        return follow(further, module, names);
    }
    let other = after
        .trim_start()
        .strip_prefix("as ")
        .map(|other| other.trim_start().chars().take_while(|letter| is_of_a_name(*letter)).collect());
    let name = if is_everything { Some("*".to_owned()) } else { other.or_else(|| module.last().cloned()) };
    names.extend(name.map(|name| Named { path: module, name }));
    after
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
fn a_path_is_followed_from_the_module_that_names_it() {
    let paths = |names: BTreeSet<Named>| -> Vec<String> {
        names.into_iter().map(|Named { path, name }| format!("{} as {name}", path.join("::"))).collect()
    };
    let named = |code: &str, below: &str| paths(named(code, &module_of(Path::new(below))));
    let code = "use crate::{\n    d::{E, f},\n    g as k,\n};\nfn i() -> crate::j::K<super::L> {}";
    assert_eq!(named(code, "a.rs"), ["L as L", "d::E as E", "d::f as f", "g as k", "j::K as K"]);
    for below in ["a/b.rs", "a/b/mod.rs"] {
        let code = "use super::super::{c::D, e};\nlet f = super::super::g::H::new();";
        assert_eq!(named(code, below), ["c::D as D", "e as e", "g::H::new as new"]);
        assert_eq!(
            named("use super::{super::c::D, e::{self, F}, *};", below),
            ["a as *", "a::e as e", "a::e::F as F", "c::D as D"]
        );
    }
    assert_eq!(named("use self::b::C; let d = Self::e; myself::f", "a.rs"), ["a::b::C as C"]);

    let imported = |code: &str| paths(imported(code, &["a".to_owned()], &["b"]));
    let code = "mod b;\nuse std::fs;\npub(super) use b::{C, d::E as F};\nuse super::g;\nfn h() {\n    use b::I;\n}";
    assert_eq!(imported(code), ["a::b::C as C", "a::b::d::E as F", "g as g"]);
}

#[test]
fn only_the_name_of_a_stream_is_taken_out_of_a_line() {
    let code = "let a = (stream(seed, &format!(\"x.{}\", b(1))), \"y.z\"); rng.set_stream(\"k\")";
    assert_eq!(
        without_names_of_streams(code),
        "let a = (stream(seed, &format!(, b(1))), \"y.z\"); rng.set_stream(\"k\")"
    );
}

//! The modules of a crate and which of them use which others, read from its source files.

use std::{
    collections::{BTreeMap, BTreeSet},
    path::Path,
};

use crate::source_text::{Named, code, imported, module_of, named, walk};

/// For each of the modules of one folder: the others that it uses, each with a file of it that names the other.
pub(crate) type Uses = BTreeMap<String, BTreeMap<String, String>>;

/// The source files of a crate, each under the path of the module that it holds.
#[derive(Default)]
pub(crate) struct Crate {
    /// The name of each file below the crate's sources, and its code without comments and unit tests.
    files: BTreeMap<Vec<String>, (String, String)>,
    /// For each name that a module imports or exports: the path that the name stands for.
    stands_for: BTreeMap<Vec<String>, Vec<String>>,
    /// For each module that imports or exports everything of others: those others.
    everything_of: BTreeMap<Vec<String>, Vec<Vec<String>>>,
}

impl Crate {
    /// Reads the files under a folder of sources. A program's main file is left out: it may name every module, and no module names it.
    pub(crate) fn read(folder: &Path) -> Crate {
        let mut texts = Vec::new();
        walk(folder, &mut |path, text| {
            texts.push((path.strip_prefix(folder).unwrap().to_str().unwrap().to_owned(), text.to_owned()));
        });
        Crate::of(texts)
    }

    /// The crate whose files have these names and texts.
    fn of(texts: impl IntoIterator<Item = (String, String)>) -> Crate {
        let mut read = Crate::default();
        for (name, text) in texts {
            let mut module = module_of(Path::new(&name));
            if module == ["main"] {
                continue;
            }
            if module == ["lib"] {
                module.clear();
            }
            read.files.insert(module, (name, code(&text)));
        }
        let tests: Vec<Vec<String>> =
            read.files.iter().flat_map(|(module, (_, code))| only_tests(module, code)).collect();
        read.files.retain(|module, _| !tests.iter().any(|test| module.starts_with(test)));
        read.follow_uses();
        read
    }

    /// Notes what each name stands for that a `use` at the left margin of a file brings in.
    fn follow_uses(&mut self) {
        for (module, (_, code)) in &self.files {
            let children: Vec<&str> = self
                .files
                .keys()
                .filter_map(|child| child.split_last())
                .filter(|(_, parent)| parent == module)
                .map(|(name, _)| name.as_str())
                .collect();
            for Named { path, name } in imported(code, module, &children) {
                if name == "*" {
                    self.everything_of.entry(module.clone()).or_default().push(path);
                } else if below(module, &name) != path {
                    self.stands_for.insert(below(module, &name), path);
                }
            }
        }
    }

    /// The module whose file defines what a path from the root of the crate names.
    fn that_defines(&self, path: &[String]) -> Vec<String> {
        self.by_way_of(path, &mut BTreeSet::new())
    }

    /// The same, but for a path that leads back to one of those followed so far: that counts as an item of the module that it was followed to.
    fn by_way_of(&self, path: &[String], followed: &mut BTreeSet<Vec<String>>) -> Vec<String> {
        let mut module = Vec::new();
        for (at, name) in path.iter().enumerate() {
            let further = below(&module, name);
            if self.files.contains_key(&further) {
                module = further;
                continue;
            }
            if self.defines(&module, name) || !followed.insert(further.clone()) {
                return module;
            }
            if let Some(path_of_item) = self.stands_for.get(&further) {
                return self.by_way_of(&[path_of_item, &path[at + 1..]].concat(), followed);
            }
            for other in self.everything_of.get(&module).into_iter().flatten() {
                let other = self.by_way_of(&below(other, name), followed);
                if self.defines(&other, name) {
                    return other;
                }
            }
            return module;
        }
        module
    }

    fn defines(&self, module: &[String], name: &str) -> bool {
        let Some((_, code)) = self.files.get(module) else { return false };
        ["struct ", "enum ", "trait ", "type ", "fn ", "const ", "static ", "macro_rules! ", "define_camera!(", "mod "]
            .iter()
            .any(|what| {
                code.match_indices(&format!("{what}{name}")).any(|(at, found)| {
                    !code[at + found.len()..].starts_with(|letter: char| letter.is_alphanumeric() || letter == '_')
                })
            })
    }

    /// For each module that has modules of its own, and for the root of the crate: which of those use which others of them. All that lies below a
    /// module counts as that module. What a module defines itself, those below it may use.
    pub(crate) fn uses(&self) -> BTreeMap<Vec<String>, Uses> {
        let mut uses: BTreeMap<Vec<String>, Uses> = BTreeMap::new();
        for (module, (file, code)) in &self.files {
            for Named { path, .. } in named(code, module) {
                let other = self.that_defines(&path);
                let shared = module.iter().zip(&other).take_while(|(one, other)| one == other).count();
                if let (Some(one), Some(other)) = (module.get(shared), other.get(shared)) {
                    let of_one = uses.entry(module[..shared].to_vec()).or_default().entry(one.clone()).or_default();
                    of_one.entry(other.clone()).or_insert_with(|| file.clone());
                }
            }
        }
        uses
    }
}

fn below(module: &[String], name: &str) -> Vec<String> {
    [module, &[name.to_owned()]].concat()
}

/// The modules that a file declares for tests alone.
fn only_tests(module: &[String], code: &str) -> Vec<Vec<String>> {
    let mut tests = Vec::new();
    let mut is_for_tests = false;
    for line in code.lines() {
        if line == "#[cfg(test)]" {
            is_for_tests = true;
        } else if !line.starts_with("#[") {
            if let Some(name) =
                line.split_once("mod ").and_then(|(_, name)| name.strip_suffix(';')).filter(|_| is_for_tests)
            {
                tests.push(below(module, name));
            }
            is_for_tests = false;
        }
    }
    tests
}

/// The circles among modules: each a set of modules, every one of which uses every other, directly or by way of others of the set, with a sentence
/// for each use within it.
pub(crate) fn circles(uses: &Uses) -> Vec<(BTreeSet<String>, String)> {
    let reached = |from: &str| {
        let mut reached = BTreeSet::new();
        let mut next = vec![from.to_owned()];
        while let Some(module) = next.pop() {
            next.extend(
                uses.get(&module)
                    .into_iter()
                    .flat_map(|to| to.keys())
                    .filter(|to| reached.insert((*to).clone()))
                    .cloned(),
            );
        }
        reached
    };
    let reaches: BTreeMap<&String, BTreeSet<String>> = uses.keys().map(|module| (module, reached(module))).collect();
    let mut circles = BTreeMap::new();
    for (module, reached) in &reaches {
        let circle: BTreeSet<String> = reached
            .iter()
            .filter(|other| reaches.get(other).is_some_and(|back| back.contains(*module)))
            .cloned()
            .collect();
        if !circle.is_empty() {
            let steps = circle
                .iter()
                .flat_map(|one| uses[one].iter().filter(|(other, _)| circle.contains(*other)).map(move |to| (one, to)));
            let steps = steps.map(|(one, (other, file))| format!("{one} names {other} in {file}; ")).collect();
            circles.insert(circle, steps);
        }
    }
    circles.into_iter().collect()
}

mod tests {
    use super::*;

    /// Each use of one module by another of the same folder.
    fn uses(files: &[(&str, &str)]) -> Vec<String> {
        let read = Crate::of(files.iter().map(|(name, text)| ((*name).to_owned(), (*text).to_owned())));
        let lines = read.uses().into_iter().flat_map(|(folder, uses)| {
            uses.into_iter().flat_map(move |(one, others)| {
                let folder = folder.join("::");
                others
                    .into_iter()
                    .map(move |(other, file)| format!("{folder}: {one} {other} {file}"))
                    .collect::<Vec<_>>()
            })
        });
        lines.collect()
    }

    #[test]
    fn a_use_counts_in_the_folder_that_holds_both_modules() {
        let files = [("lib.rs", "mod a;\nmod b;"), ("a/mod.rs", "mod c;\nmod d;"), ("b.rs", "use crate::a::c::E;")];
        let deep = [
            ("a/c.rs", "use super::d::f::G;"),
            ("a/d.rs", "mod f;"),
            ("a/d/f.rs", "pub struct G(super::super::super::b::H);"),
        ];
        assert_eq!(uses(&[&files[..], &deep].concat()), [": a b a/d/f.rs", ": b a b.rs", "a: c d a/c.rs"]);
    }

    #[test]
    fn what_a_module_passes_on_belongs_to_the_module_that_defines_it() {
        let root = ("lib.rs", "mod a;\nmod b;\npub use a::F as G;");
        let parent = ("a/mod.rs", "mod c;\nmod d;\npub use c::*;\nuse d::F;\npub struct H;");
        let children = [
            ("a/c.rs", "pub struct E;\nfn i(_: super::F, _: super::H) {}"),
            ("a/d.rs", "pub struct F(super::E, super::H);"),
        ];
        let other = ("b.rs", "use crate::G;");
        let uses = uses(&[&[root, parent, other][..], &children].concat());
        assert_eq!(uses, [": b a b.rs", "a: c d a/c.rs", "a: d c a/d.rs"]);
    }

    #[test]
    fn what_is_for_tests_alone_is_left_out() {
        let files = [
            ("lib.rs", "mod a;\n#[cfg(test)]\n#[allow(x)]\nmod b;\nmod c;"),
            ("a.rs", "// crate::c\n#[cfg(test)]\nmod tests {\n    use crate::c;\n}"),
        ];
        assert_eq!(
            uses(&[
                files[0],
                files[1],
                ("b.rs", "use crate::a;"),
                ("b/d.rs", "use crate::a;"),
                ("c.rs", "use crate::a;")
            ]),
            [": c a c.rs"]
        );
    }

    #[test]
    fn a_circle_through_three_modules_is_found() {
        let to = |other: &str, file: &str| BTreeMap::from([(other.to_owned(), file.to_owned())]);
        let mut uses = Uses::from([
            ("a".to_owned(), to("b", "a.rs")),
            ("b".to_owned(), to("c", "b/one.rs")),
            ("c".to_owned(), to("a", "c.rs")),
            ("d".to_owned(), to("a", "d.rs")),
        ]);
        let circle = ["a", "b", "c"].map(str::to_owned).into();
        let steps = "a names b in a.rs; b names c in b/one.rs; c names a in c.rs; ".to_owned();
        assert_eq!(circles(&uses), [(circle, steps)]);
        uses.remove("b");
        assert_eq!(circles(&uses), []);
    }
}

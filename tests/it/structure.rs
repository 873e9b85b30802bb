//! Which modules of each crate may name which others, checked in their source texts.

use std::{
    collections::{BTreeMap, BTreeSet},
    fs,
};

use localizer::{baselines::SOLVERS, bounds};
use serde_json::Value;
use sim::{
    run::{BASELINES, ForwardBaselines, MarkerBaselines},
    scene::schema_text,
};

use crate::{
    command::root,
    source_text::{code, module_of, named, walk, without_names_of_streams, words},
};

/// For each module below the root of a crate: the modules at the root that its files name, each with a file that names it.
type Uses = BTreeMap<String, BTreeMap<String, String>>;

fn uses(sources: &str) -> Uses {
    let folder = root().join(sources);
    let exported = exported(&fs::read_to_string(folder.join("lib.rs")).unwrap());
    let mut uses = Uses::new();
    walk(&folder, &mut |path, text| {
        let below = path.strip_prefix(&folder).unwrap();
        let module = module_of(below);
        // The library's root and the program's main file may name every module, and no module names them.
        if ["lib", "main"].contains(&module[0].as_str()) {
            return;
        }
        for name in named(&code(text), &module) {
            let other = exported.get(&name).unwrap_or(&name).clone();
            if other != module[0] {
                uses.entry(module[0].clone()).or_default().entry(other).or_insert(below.display().to_string());
            }
        }
    });
    uses
}

/// Names that a library's root exports, each with the module that it comes from; a module comes from itself.
fn exported(lib: &str) -> BTreeMap<String, String> {
    let mut exported = BTreeMap::new();
    for statement in code(lib).split(';') {
        let Some((_, public)) = statement.split_once("pub ") else { continue };
        if let Some(module) = public.strip_prefix("mod ") {
            exported.insert(module.to_owned(), module.to_owned());
            continue;
        }
        let path = public.strip_prefix("use ").unwrap_or_else(|| panic!("neither a module nor a re-export: {public}"));
        let (module, _) = path.split_once("::").unwrap();
        // The last name of each path; what ends with two colons is the beginning of a group.
        for name in path.split([',', '{', '}']).filter(|path| !path.trim().is_empty() && !path.ends_with("::")) {
            let name = name.rsplit("::").next().unwrap().rsplit(" as ").next().unwrap().trim();
            assert_ne!(name, "*", "{path} does not say what it exports");
            exported.insert(name.to_owned(), module.to_owned());
        }
    }
    exported
}

/// A path from a module back to itself, each step with the file that makes it; `None` where there is none.
fn circle(uses: &Uses) -> Option<String> {
    fn from(module: &str, uses: &Uses, way: &mut Vec<String>, done: &mut BTreeSet<String>) -> Option<String> {
        if let Some(first) = way.iter().position(|before| before == module) {
            let steps = way[first..].iter().zip(way[first + 1..].iter().map(String::as_str).chain([module]));
            return Some(steps.map(|(one, next)| format!("{one} names {next} in {}; ", uses[one][next])).collect());
        }
        if !done.insert(module.to_owned()) {
            return None;
        }
        way.push(module.to_owned());
        let found = uses.get(module).into_iter().flatten().find_map(|(next, _)| from(next, uses, way, done));
        way.pop();
        found
    }
    let mut done = BTreeSet::new();
    uses.keys().find_map(|module| from(module, uses, &mut Vec::new(), &mut done))
}

#[test]
fn no_module_of_a_crate_knows_itself_by_way_of_others() {
    for sources in ["localizer/interval/src", "localizer/src", "sim/src"] {
        let uses = uses(sources);
        assert!(sources.contains("interval") || uses.len() > 5, "{sources}: {uses:?}");
        assert_eq!(circle(&uses), None, "{sources}");
    }
}

#[test]
fn a_scene_is_keys_and_knows_nothing_that_is_made_of_them() {
    assert_eq!(uses("sim/src").get("scene"), None);
}

#[test]
fn the_simulator_is_a_list_of_at_most_18_entries() {
    let entries: Vec<_> =
        fs::read_dir(root().join("sim/src")).unwrap().map(|entry| entry.unwrap().file_name()).collect();
    assert!(entries.len() <= 18, "{entries:?}");
}

#[test]
fn the_root_of_the_localizer_exports_at_most_40_names_and_nothing_unnamed() {
    let names = exported(&fs::read_to_string(root().join("localizer/src/lib.rs")).unwrap());
    assert!(names.contains_key("Localizer") && names.contains_key("methods") && names.len() <= 40, "{names:?}");
}

#[test]
fn each_name_that_a_root_exports_is_counted() {
    let lib = "//! pub use z::*;\npub mod a;\nmod b;\n#[doc(inline)]\npub use b::{\n    C,\n    d::{E, F as G},\n};\npub use a::H;\n";
    let names: Vec<(String, String)> = exported(lib).into_iter().collect();
    let expected = [("C", "b"), ("E", "b"), ("G", "b"), ("H", "a"), ("a", "a")];
    assert_eq!(names, expected.map(|(name, module)| (name.to_owned(), module.to_owned())));
    assert!(std::panic::catch_unwind(|| exported("mod b;\npub use b::*;\n")).is_err());
}

#[test]
fn the_judge_names_no_method_and_no_baseline() {
    let schema: Value = serde_json::from_str(&schema_text()).unwrap();
    let methods = schema["$defs"]["MethodName"]["oneOf"].as_array().unwrap().iter();
    let methods: Vec<&str> = methods.map(|method| method["const"].as_str().unwrap()).collect();
    assert!(methods.len() >= 5 && methods.contains(&"floor_tiles"), "{methods:?}");
    let figures = MarkerBaselines::FIGURES.into_iter().chain(ForwardBaselines::FIGURES);
    let baselines = BASELINES.into_iter().chain(SOLVERS.map(|(name, _)| name)).chain(figures);
    let names: Vec<String> = methods.into_iter().chain(baselines).map(|name| name.replace('_', "")).collect();
    walk(&root().join("sim/src/judge"), &mut |path, text| {
        for word in words(&code(text)) {
            let known = names.iter().find(|name| word.contains(*name));
            assert_eq!(known, None, "{} has `{word}`", path.display());
        }
    });
}

#[test]
fn bounds_are_named_by_their_table_and_nowhere_else() {
    for sources in ["localizer/src", "sim/src"] {
        walk(&root().join(sources), &mut |path, text| {
            if path.ends_with("localizer/src/bounds.rs") {
                return;
            }
            // The name of a bound must not occur as text in the sources, but for the name of a stream of random numbers, which may be that of the
            // bound that limits its numbers.
            for line in without_names_of_streams(&code(text)).lines() {
                let named = bounds::ALL.iter().find(|bound| line.contains(&format!("\"{}\"", bound.name)));
                assert_eq!(named, None, "{}: {line}", path.display());
            }
        });
    }
}

#[test]
fn each_bound_has_one_name_a_unit_and_a_sentence() {
    let names: BTreeSet<&str> = bounds::ALL.iter().map(|bound| bound.name).collect();
    assert_eq!(names.len(), bounds::ALL.len());
    for bound in bounds::ALL {
        assert!(bound.what.ends_with('.') && !bound.unit.is_empty(), "{bound:?}");
    }
}

#[test]
fn a_circle_through_three_modules_is_found() {
    let to = |other: &str, file: &str| BTreeMap::from([(other.to_owned(), file.to_owned())]);
    let uses = Uses::from([
        ("a".to_owned(), to("b", "a.rs")),
        ("b".to_owned(), to("c", "b/one.rs")),
        ("c".to_owned(), to("a", "c.rs")),
    ]);
    assert_eq!(circle(&uses).unwrap(), "a names b in a.rs; b names c in b/one.rs; c names a in c.rs; ");
    assert_eq!(circle(&Uses::from([("a".to_owned(), to("b", "a.rs")), ("c".to_owned(), to("a", "c.rs"))])), None);
}

/// The number that follows the first occurrence of `before` in a file of the simulator's sources.
fn number_after(file: &str, before: &str) -> f64 {
    let text = fs::read_to_string(root().join("sim/src").join(file)).unwrap();
    let (_, rest) = text.split_once(before).unwrap_or_else(|| panic!("{file} has no `{before}`"));
    let digits: String =
        rest.chars().take_while(|letter| letter.is_ascii_digit() || "._e-".contains(*letter)).collect();
    digits.replace('_', "").parse().unwrap_or_else(|_| panic!("{file}: no number after `{before}`"))
}

#[test]
fn numbers_that_shaders_share_with_the_program_are_the_same() {
    let same = |program: (&str, &str), shader: (&str, &str), more: f64| {
        let [stated, shared] = [program, shader].map(|(file, before)| number_after(file, before));
        assert_eq!(stated + more, shared, "{program:?} and {shader:?}");
    };
    let near = ("render/room/view.wgsl", "const NEAR_M: f32 = ");
    same(("render/room/frustum.rs", "const NEAR_M: f64 = "), near, 0.0);
    same(("render/room/strips.rs", "const NEAR_M: f64 = "), near, 0.0);
    let roughness = ("render/room/mirror.wgsl", "max(roughness, ");
    same(("render/room/glints.rs", "const LEAST_ROUGHNESS_RAD: f64 = "), roughness, 0.0);
    let albedo = ("render/room/lamp.wgsl", "const DIFFUSER_ALBEDO: f32 = ");
    same(("render/room/faces.rs", "const DIFFUSER_ALBEDO: f64 = "), albedo, 0.0);
    let lamps = ("scene/lamps.rs", "const MAX_LAMPS: usize = ");
    same(lamps, ("render/room/world.wgsl", "array<Lamp, "), 0.0);
    same(lamps, ("render/room/surface.wgsl", "const LAMP_ENDS: u32 = "), 1.0);
    let sub_frames = ("render/exposure.rs", "const MAX_SUB_FRAMES: usize = ");
    same(sub_frames, ("render/floor/view.wgsl", "sub_frame_ends: array<Homography, "), 1.0);
    same(
        ("render/floor/cut.rs", "const LAMPLIGHT_PX: u32 = "),
        ("render/lens.wgsl", "const LAMPLIGHT_PX: f32 = "),
        0.0,
    );
}

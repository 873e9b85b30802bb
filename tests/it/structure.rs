//! Which modules of each crate may name which others, checked in their source texts.

use std::{
    collections::{BTreeMap, BTreeSet},
    fs,
};

use localizer::{baselines::SOLVERS, bounds};
use serde_json::Value;
use sim::{
    run::{BASELINES, ForwardBaselines, LandmarkBaselines, MarkerBaselines},
    scene::schema_text,
};

use crate::{
    command::root,
    modules::{Crate, circles},
    source_text::{code, walk, without_names_of_streams, words},
};

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

/// The sources of every crate of the project but its tests.
const SOURCES: [&str; 5] =
    ["localizer/interval/src", "localizer/src", "sim/src", "python/src", "examples/own_subject/src"];

/// Circles of modules that are left, each by the folder that holds the modules.
const CIRCLES_LEFT: [(&str, [&str; 2]); 1] = [
    // The class `Cues` of the Python package is made for a `Drive`, and a `Drive` tells a localizer `Cues`; the methods of a Python class that users
    // call stand in one file.
    ("python/src", ["cues", "drive"]),
];

#[test]
fn no_module_of_a_crate_knows_itself_by_way_of_others_in_its_folder() {
    let mut left = Vec::new();
    for sources in SOURCES {
        let uses = Crate::read(&root().join(sources)).uses();
        assert!(sources != "sim/src" || uses.len() > 20 && uses[&Vec::new()].len() > 10, "{uses:?}");
        for (folder, uses) in &uses {
            let folder = [&[sources.to_owned()], &folder[..]].concat().join("/");
            for (circle, steps) in circles(uses) {
                let circle: Vec<&str> = circle.iter().map(String::as_str).collect();
                let is_left = CIRCLES_LEFT.iter().any(|(at, known)| *at == folder && circle == known);
                assert!(is_left, "in {folder}: {steps}");
                left.push(folder.clone());
            }
        }
    }
    left.sort();
    assert_eq!(left, CIRCLES_LEFT.map(|(folder, _)| folder), "a circle that is named here is gone");
}

#[test]
fn a_scene_is_keys_and_knows_nothing_that_is_made_of_them() {
    let uses = Crate::read(&root().join("sim/src")).uses();
    assert_eq!(uses[&Vec::new()].get("scene"), None);
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
    let figures = [MarkerBaselines::FIGURES, ForwardBaselines::FIGURES, LandmarkBaselines::FIGURES];
    let figures = figures.into_iter().flatten();
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
    same(("render/lens.rs", "const LAMPLIGHT_PX: u32 = "), ("render/lens.wgsl", "const LAMPLIGHT_PX: f32 = "), 0.0);
}

//! Reduces a failing scene to the smallest one found that still shows the same failure.

use std::collections::BTreeSet;

use toml::{Table, Value};

/// One step of a path in a TOML document: a key of a table, or an index into a list.
#[derive(Clone, Debug, PartialEq)]
enum Step {
    Key(String),
    Item(usize),
}

/// One change that makes a scene smaller or simpler.
#[derive(Clone, Debug)]
enum Edit {
    /// Removes a key, so that its default value applies.
    Remove(Vec<Step>),
    /// Removes the items of a list from one index up to another.
    RemoveItems(Vec<Step>, usize, usize),
    /// Replaces a value by a simpler one.
    Set(Vec<Step>, Value),
}

/// Makes `scene` smaller step by step. A step is kept if `is_same` confirms that the smaller scene shows the same failure; at most `tries` scenes are
/// tried.
///
/// The duration is shortened first, as this makes all further attempts cheaper. Then tables and halves of lists are removed, then single
/// keys; at last numbers are rounded. These stages repeat until none of them changes the scene any more. `at_s` is the time of the
/// failure.
pub fn shrink(scene: Table, at_s: f64, tries: usize, is_same: &mut dyn FnMut(&Table) -> bool) -> Table {
    let stages: [fn(&Table, f64) -> Vec<Edit>; 5] = [
        shorter,
        |scene, _| fewer_items(scene),
        |scene, _| without_tables(scene),
        |scene, _| without_keys(scene),
        |scene, _| rounder(scene),
    ];
    let mut current = scene;
    let mut tried = BTreeSet::from([current.to_string()]);
    loop {
        let before = current.to_string();
        for stage in stages {
            let mut index = 0;
            while let Some(edit) = stage(&current, at_s).get(index) {
                if tried.len() > tries {
                    return current;
                }
                let smaller = edited(&current, edit);
                // A scene that was tried before, reached by another sequence of changes, is not run again.
                if tried.insert(smaller.to_string()) && is_same(&smaller) {
                    current = smaller;
                } else {
                    index += 1;
                }
            }
        }
        if current.to_string() == before {
            return current;
        }
    }
}

/// Returns edits that shorten the run. Where one is applied, events that would come after the end are removed.
fn shorter(scene: &Table, at_s: f64) -> Vec<Edit> {
    let Some(duration_s) = scene.get("duration_s").and_then(as_number) else { return Vec::new() };
    // The first two durations end the run shortly after the failure: 0.1 s after it, for a failure that shows at once, and 1.5 s after it, for one
    // that counts only when it has lasted a second.
    let wanted_s = [at_s + 0.1, at_s + 1.5, 0.5 * duration_s, 0.75 * duration_s];
    let shorter_s = wanted_s.into_iter().filter(|wanted_s| *wanted_s < 0.95 * duration_s && *wanted_s > 0.05);
    shorter_s
        .map(|wanted_s| {
            Edit::Set(vec![Step::Key("duration_s".to_owned())], Value::Float((100.0 * wanted_s).ceil() / 100.0))
        })
        .collect()
}

/// Returns edits that remove the first or second half, the quarters, … and the single items of lists.
fn fewer_items(scene: &Table) -> Vec<Edit> {
    let mut edits = Vec::new();
    for (path, value) in places(scene) {
        let Value::Array(items) = value else { continue };
        // No items are removed from a list of plain values, such as the two numbers of a position, as the shorter list could be invalid.
        if items.iter().any(|item| !item.is_table() && !item.is_array()) {
            continue;
        }
        let mut size = items.len().div_ceil(2);
        while size > 0 {
            let starts = (0..items.len()).step_by(size);
            edits.extend(starts.map(|from| Edit::RemoveItems(path.clone(), from, (from + size).min(items.len()))));
            size /= 2;
        }
    }
    edits
}

/// Returns edits each of which removes one table or list, the outermost first.
fn without_tables(scene: &Table) -> Vec<Edit> {
    let mut found: Vec<Vec<Step>> = places(scene)
        .into_iter()
        .filter(|(path, value)| is_key(path) && (value.is_table() || value.is_array()))
        .map(|(path, _)| path)
        .collect();
    found.sort_by_key(Vec::len);
    found.into_iter().map(Edit::Remove).collect()
}

/// Returns edits each of which removes one key with a plain value.
fn without_keys(scene: &Table) -> Vec<Edit> {
    let plain =
        places(scene).into_iter().filter(|(path, value)| is_key(path) && !value.is_table() && !value.is_array());
    plain.map(|(path, _)| Edit::Remove(path)).collect()
}

/// Returns edits that round a number to one, two or three digits.
fn rounder(scene: &Table) -> Vec<Edit> {
    let mut edits = Vec::new();
    for (path, value) in places(scene) {
        let Value::Float(number) = value else { continue };
        for digits in 1..=3 {
            let rounded = super::dice::rounded(number, digits);
            if rounded != number {
                edits.push(Edit::Set(path.clone(), Value::Float(rounded)));
            }
        }
    }
    edits
}

fn is_key(path: &[Step]) -> bool {
    matches!(path.last(), Some(Step::Key(_)))
}

fn as_number(value: &Value) -> Option<f64> {
    value.as_float().or_else(|| value.as_integer().map(|whole| whole as f64))
}

/// Returns every value of a scene with its path; a table or list comes before its contents.
fn places(scene: &Table) -> Vec<(Vec<Step>, Value)> {
    fn collect(value: &Value, path: &[Step], found: &mut Vec<(Vec<Step>, Value)>) {
        let steps: Vec<(Step, &Value)> = match value {
            Value::Table(table) => table.iter().map(|(key, value)| (Step::Key(key.clone()), value)).collect(),
            Value::Array(items) => items.iter().enumerate().map(|(index, item)| (Step::Item(index), item)).collect(),
            _ => Vec::new(),
        };
        for (step, value) in steps {
            let path: Vec<Step> = path.iter().cloned().chain([step]).collect();
            found.push((path.clone(), value.clone()));
            collect(value, &path, found);
        }
    }
    let mut found = Vec::new();
    collect(&Value::Table(scene.clone()), &[], &mut found);
    found
}

fn edited(scene: &Table, edit: &Edit) -> Table {
    let mut whole = Value::Table(scene.clone());
    match edit {
        Edit::Remove(path) => {
            if let Some((Step::Key(key), before)) = path.split_last()
                && let Some(Value::Table(table)) = at(&mut whole, before)
            {
                table.remove(key);
            }
        }
        Edit::RemoveItems(path, from, to) => {
            if let Some(Value::Array(items)) = at(&mut whole, path) {
                items.drain(*from..*to);
            }
        }
        Edit::Set(path, value) => {
            if let Some(place) = at(&mut whole, path) {
                *place = value.clone();
            }
        }
    }
    let Value::Table(mut scene) = whole else { return scene.clone() };
    drop_late_events(&mut scene);
    scene
}

fn at<'a>(value: &'a mut Value, path: &[Step]) -> Option<&'a mut Value> {
    path.iter().try_fold(value, |value, step| match step {
        Step::Key(key) => value.get_mut(key.as_str()),
        Step::Item(index) => value.get_mut(*index),
    })
}

/// Removes events that end after the end of the run, as a scene with such events is refused.
fn drop_late_events(scene: &mut Table) {
    let Some(duration_s) = scene.get("duration_s").and_then(as_number) else { return };
    let Some(Value::Array(events)) = scene.get_mut("event") else { return };
    let seconds = |event: &Value, key: &str| event.get(key).and_then(as_number).unwrap_or(0.0);
    events.retain(|event| seconds(event, "at_s") + seconds(event, "lasts_s") <= duration_s);
    if events.is_empty() {
        scene.remove("event");
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;

    /// Parses a scene and reduces it as far as `is_same` accepts the smaller scene. Returns the reduced scene and the number of calls of `is_same`.
    fn shrunk(text: &str, tries: usize, is_same: impl Fn(&Table) -> bool) -> (Table, usize) {
        let mut asked = 0;
        let small = shrink(text.parse().unwrap(), 2.0, tries, &mut |scene| {
            asked += 1;
            is_same(scene)
        });
        (small, asked)
    }

    const SCENE: &str = "duration_s = 40.0\nlandmark = [{ x_m = 1.2345 }, { x_m = 2.3456 }, { x_m = 3.4567 }, { x_m = 4.5678 }]\n\
                         [robot]\nmass_kg = 3.21\n[robot.gyro]\nperiod_s = 0.017\n[floor]\nfriction = 0.777\n";

    #[test]
    fn what_does_not_matter_goes_and_what_matters_stays() {
        let matters = |scene: &Table| {
            let landmarks = scene.get("landmark").and_then(Value::as_array);
            let has_third = landmarks.is_some_and(|all| {
                all.iter().any(|one| one.get("x_m").and_then(Value::as_float).is_some_and(|x_m| x_m > 3.0 && x_m < 4.0))
            });
            has_third && scene.get("robot").and_then(|robot| robot.get("gyro")).is_some()
        };
        let (small, _) = shrunk(SCENE, 1000, matters);
        // Every number is rounded as far as possible: 3.4567 is 3.0 with one digit, which is outside the required range, and 3.5 with two.
        let expected: Table = "landmark = [{ x_m = 3.5 }]\n[robot.gyro]\n".parse().unwrap();
        assert_eq!(small, expected);
    }

    #[test]
    fn a_run_is_cut_just_behind_what_it_shows() {
        let lasts = |scene: &Table| {
            scene.get("duration_s").and_then(Value::as_float).is_some_and(|duration_s| duration_s > 2.05)
        };
        let (small, _) = shrunk(SCENE, 1000, lasts);
        assert_eq!(small["duration_s"], Value::Float(2.1));
    }

    #[test]
    fn the_tries_are_kept_and_what_is_left_still_shows_it() {
        let (small, asked) = shrunk(SCENE, 5, |scene| scene.contains_key("floor"));
        assert!(asked <= 5 && small.contains_key("floor"), "{asked}");
    }
}

//! A sweep as a file with the keys `scene`, `seeds`, `subject` and `baselines` and a table `[vary]`.

use std::path::Path;

use toml::{
    Table, Value,
    de::{DeTable, DeValue},
};

use crate::{
    scene::{SceneError, text_of},
    subject::SubjectChoice,
};

use super::{Seeds, Sweep, SweepError, Variable, variable::values_of};

/// The keys of a sweep file.
const KEYS: [&str; 5] = ["scene", "seeds", "subject", "baselines", "vary"];

impl Sweep {
    /// Reads a sweep file; none when the file is not a sweep but, because it has no key `scene`, presumably a scene.
    ///
    /// The path of the scene in the file is relative to the sweep file.
    pub fn load(path: &Path) -> Result<Option<Sweep>, SweepError> {
        let text = match text_of(path) {
            Ok(text) => text,
            // A file that is not text is no sweep; loading it as a scene reports the error.
            Err(SceneError::NotText { .. }) => return Ok(None),
            Err(error) => return Err(error.into()),
        };
        let wrong = |expected: String| SweepError::BadFile { path: path.to_owned(), expected };
        let text = with_keys_quoted(&text);
        let table = match text.parse::<Table>() {
            Ok(table) => table,
            Err(error) if begins_a_sweep(&text) => {
                return Err(wrong(format!("not a sweep in TOML: {}", place(&error, &text))));
            }
            Err(_) => return Ok(None),
        };
        if !table.contains_key("scene") {
            let expected = "`scene`: missing, expected the path of a scene in quotes beside the table `[vary]`";
            return if table.contains_key("vary") { Err(wrong(expected.to_owned())) } else { Ok(None) };
        }
        if let Some(unknown) = table.keys().find(|key| !KEYS.contains(&key.as_str())) {
            return Err(wrong(format!("`{unknown}`: unknown key, expected one of {}", KEYS.join(", "))));
        }
        let scene = table["scene"].as_str().ok_or_else(|| wrong("`scene`: expected a text in quotes".to_owned()))?;
        let seeds = match table.get("seeds") {
            None => 0..1,
            Some(stated) => {
                let text =
                    stated.as_str().ok_or_else(|| wrong("`seeds`: expected a text such as \"0..20\"".to_owned()))?;
                text.parse::<Seeds>().map_err(|expected| wrong(format!("`seeds = \"{text}\"`: {expected}")))?.0
            }
        };
        let baselines = match table.get("baselines") {
            None => false,
            Some(stated) => stated.as_bool().ok_or_else(|| wrong("`baselines`: expected true or false".to_owned()))?,
        };
        let subject = match table.get("subject") {
            None => SubjectChoice::default(),
            Some(stated) => {
                let text =
                    stated.as_str().ok_or_else(|| wrong("`subject`: expected a text such as \"ekf\"".to_owned()))?;
                text.parse().map_err(|expected| wrong(format!("`subject = \"{text}\"`: {expected}")))?
            }
        };
        let vary = variables(&text).map_err(wrong)?;
        let scene = path.parent().unwrap_or(Path::new("")).join(scene);
        Ok(Some(Sweep { scene, vary, seeds, subject, baselines }))
    }
}

/// The text with quotes around keys that name an entry of a list, such as `route.waypoint[0].x_m`, which TOML knows in quotes only.
fn with_keys_quoted(text: &str) -> String {
    let quoted = |line: &str| -> Option<String> {
        let (key, value) = line.split_once('=')?;
        let key = key.trim();
        let is_of_key = |letter: char| letter.is_ascii_alphanumeric() || "_-.[]".contains(letter);
        let names_an_entry = !key.starts_with('[') && key.contains('[') && key.chars().all(is_of_key);
        names_an_entry.then(|| format!("\"{key}\" ={value}"))
    };
    text.split_inclusive('\n').map(|line| quoted(line).unwrap_or_else(|| line.to_owned())).collect()
}

/// Whether a text that is not TOML is meant as a sweep: a line begins with the key `scene` or with the table `[vary]`.
fn begins_a_sweep(text: &str) -> bool {
    text.lines().any(|line| {
        let line = line.trim();
        line.starts_with("[vary]") || line.strip_prefix("scene").is_some_and(|rest| rest.trim_start().starts_with('='))
    })
}

/// What is wrong with a text that is not TOML, and in which line.
fn place(error: &toml::de::Error, text: &str) -> String {
    let line = error.span().map(|span| 1 + text.bytes().take(span.start).filter(|byte| *byte == b'\n').count());
    line.map_or_else(|| error.message().to_owned(), |line| format!("line {line}: {}", error.message()))
}

/// Returns the variables of the table `[vary]`, in the order of the file.
fn variables(text: &str) -> Result<Vec<Variable>, String> {
    let document = DeTable::parse(text).map_err(|error| error.message().to_owned())?;
    let Some(vary) = document.get_ref().get("vary") else { return Ok(Vec::new()) };
    let DeValue::Table(table) = vary.get_ref() else { return Err("`vary`: expected a table".to_owned()) };
    let mut found = Vec::new();
    collect(table, "", &mut found)?;
    found.sort_by_key(|(start, _)| *start);
    Ok(found.into_iter().map(|(_, variable)| variable).collect())
}

/// Collects the variables of a table. Dotted keys are nested tables; each list, range or single value at the end of a key is a variable.
fn collect(table: &DeTable<'_>, path: &str, found: &mut Vec<(usize, Variable)>) -> Result<(), String> {
    for (name, value) in table.iter() {
        let key = if path.is_empty() { name.get_ref().to_string() } else { format!("{path}.{}", name.get_ref()) };
        let start = value.span().start;
        let stated = match value.get_ref() {
            DeValue::Table(inner) => {
                collect(inner, &key, found)?;
                continue;
            }
            other => owned(other),
        };
        let values = match stated {
            Value::Array(values) => values,
            Value::String(text) => values_of(&text).map_err(|expected| format!("`vary.{key}`: {expected}"))?,
            single => vec![single],
        };
        if values.is_empty() {
            return Err(format!("`vary.{key}`: an empty list, expected at least one value"));
        }
        found.push((start, Variable { key, values }));
    }
    Ok(())
}

fn owned(value: &DeValue<'_>) -> Value {
    match value {
        DeValue::String(text) => Value::String(text.to_string()),
        DeValue::Integer(number) => {
            i64::from_str_radix(number.as_str(), number.radix()).map_or(Value::Float(f64::NAN), Value::Integer)
        }
        DeValue::Float(number) => Value::Float(number.as_str().parse().unwrap_or(f64::NAN)),
        DeValue::Boolean(truth) => Value::Boolean(*truth),
        DeValue::Datetime(time) => Value::Datetime(*time),
        DeValue::Array(items) => Value::Array(items.iter().map(|item| owned(item.get_ref())).collect()),
        DeValue::Table(table) => {
            Value::Table(table.iter().map(|(key, value)| (key.get_ref().to_string(), owned(value.get_ref()))).collect())
        }
    }
}

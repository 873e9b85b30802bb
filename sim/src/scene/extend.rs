//! Scenes that extend other scene files: merges a scene's file with the files that it extends, and remembers for each value where in their text it
//! stands.

use std::{
    fs::{self, File},
    io::Read,
    ops::Range,
    path::{Component, Path},
};

use toml::{
    Spanned,
    de::{DeArray, DeTable, DeValue},
};

use super::{
    SceneError,
    conform::{excerpt, found},
    problem::{Problem, Problems},
    schema::{ADDS, EXTENDS},
    sources::{Source, Sources},
};

/// Greatest size of a scene's file, in 10⁶ bytes. Five hundred times the largest scene that comes with the program are read in a few seconds; a file
/// that is larger is no scene, and would be read for a minute before anything said so.
const MOST_MB: u64 = 4;

impl Sources {
    /// Reads a scene's file, the file that it extends, the file that this one extends, and so on.
    pub(crate) fn load(path: &Path) -> Result<Sources, SceneError> {
        let mut sources = Sources::alone(&text_of(path)?, &path.display().to_string());
        let mut path = path.to_owned();
        let mut read = vec![fs::canonicalize(&path).unwrap_or_else(|_| path.clone())];
        loop {
            let stated = match sources.stated() {
                Ok(Some(stated)) => stated,
                // The file read last extends no other, or it is not TOML, in which case it is refused when all files are merged.
                Ok(None) => return Ok(sources),
                Err(problem) => return Err(sources.refuse(vec![*problem])),
            };
            path = path.with_file_name("").join(&stated.base);
            let text = match text_of(&path) {
                Ok(text) => text,
                Err(error) => {
                    let why = format!("failed to {error}, expected the path of a file from this file's folder");
                    return Err(sources.refuse(vec![stated.problem(why)]));
                }
            };
            let real = fs::canonicalize(&path).unwrap_or_else(|_| path.clone());
            if read.contains(&real) {
                let around: Vec<&str> = sources.files.iter().map(|source| source.name.as_str()).collect();
                let why = format!(
                    "goes round in a circle ({}, and {} again), expected a file that does not build on this one",
                    around.join(", then "),
                    path.display()
                );
                return Err(sources.refuse(vec![stated.problem(why)]));
            }
            read.push(real);
            sources.add(&text, path.display().to_string(), &stated.base);
        }
    }

    fn add(&mut self, text: &str, name: String, base: &str) {
        let inner = base.rfind('/').map_or("", |slash| &base[..=slash]);
        let folder = self.files.last().map_or_else(String::new, |last| format!("{}{inner}", last.folder));
        self.text.push('\n');
        let span = self.text.len()..self.text.len() + text.len();
        self.text.push_str(text);
        self.files.push(Source { name, span, folder });
    }

    /// The key `extends` of the last file that was read, if it has one.
    fn stated(&self) -> Result<Option<Stated>, Box<Problem>> {
        let Some(last) = self.files.last() else { return Ok(None) };
        let Ok(document) = DeTable::parse(&self.text[last.span.clone()]) else { return Ok(None) };
        let Some(value) = document.get_ref().get("extends") else { return Ok(None) };
        let span = shifted(value.span(), last.span.start);
        let stated =
            |base: &str| Stated { value: excerpt(&self.text[span.clone()]), base: base.to_owned(), span: span.clone() };
        match value.get_ref().as_str() {
            None => {
                let why = format!("{}, expected a text in quotes, such as \"lab.toml\"", found(value.get_ref()));
                Err(Box::new(stated("").problem(why)))
            }
            Some(base)
                if Path::new(base)
                    .components()
                    .any(|part| matches!(part, Component::RootDir | Component::Prefix(_))) =>
            {
                let why = "an absolute path, expected one from this file's folder, such as \"../lab.toml\"".to_owned();
                Err(Box::new(stated(base).problem(why)))
            }
            Some(base) => Ok(Some(stated(base))),
        }
    }

    /// All files merged into one document, without their keys `extends` and `adds`. Spans in the document are ranges of bytes of the joined `text`.
    pub(crate) fn merged(&self) -> Result<Spanned<DeTable<'_>>, Vec<Problem>> {
        let tables: Vec<DeTable<'_>> =
            self.files.iter().map(|source| self.table_of(source)).collect::<Result<_, _>>()?;
        let mut merged = DeTable::new();
        for mut table in tables.into_iter().rev() {
            let adds = table.remove("adds");
            if table.contains_key("expect") {
                merged.remove("expect");
            }
            lay_under(&mut table, merged);
            if let Some(adds) = adds {
                add(&mut table, adds, "adds").map_err(|problem| {
                    let value = Some(excerpt(&self.text[problem.span.clone()]));
                    vec![Problem { value, ..*problem }]
                })?;
            }
            merged = table;
        }
        Ok(Spanned::new(0..self.text.len(), merged))
    }

    /// What one of the files states, without its key `extends` and without what a file that extends it does not take over.
    fn table_of(&self, source: &Source) -> Result<DeTable<'_>, Vec<Problem>> {
        let start = source.span.start;
        let document =
            DeTable::parse(&self.text[source.span.clone()]).map_err(|error| vec![Problem::of_toml(&error, start)])?;
        let mut table = shifted_table(document.into_inner(), start);
        let stated = table.remove("extends");
        // A file that states `extends` is followed by the file that it extends. So the last text states it only if it comes from no file.
        let is_last = source.span.end == self.text.len();
        if let Some(base) = stated.filter(|_| is_last) {
            let value = excerpt(&self.text[base.span()]);
            let stated = Stated { value, base: String::new(), span: base.span() };
            return Err(vec![stated.problem(
                "stands in a text without a file, expected all keys in the text itself, as `wherein scene` prints them".to_owned(),
            )]);
        }
        let is_base = start > 0;
        if is_base {
            table.remove("description");
            move_map(&mut table, &source.folder);
        }
        Ok(table)
    }

    /// Makes the error that refuses the scene because of `problems`. Enters in each problem the name of the file in which it stands.
    pub(crate) fn refuse(self, mut problems: Vec<Problem>) -> SceneError {
        for problem in &mut problems {
            problem.file = self.base_at(&problem.span).map(str::to_owned);
        }
        SceneError::Invalid { sources: self, problems: Problems(problems) }
    }
}

/// A key `extends` as a file states it.
struct Stated {
    value: String,
    base: String,
    span: Range<usize>,
}

impl Stated {
    fn problem(self, expected: String) -> Problem {
        Problem {
            key: "extends".to_owned(),
            value: Some(self.value),
            expected,
            span: self.span,
            help: Some(format!("`extends`: {EXTENDS}")),
            file: None,
        }
    }
}

/// Adds to the table `over` those keys of the table `under` that `over` does not state, and does the same with the tables in them.
fn lay_under<'text>(over: &mut DeTable<'text>, under: DeTable<'text>) {
    for (key, value) in under {
        match over.get_mut(key.get_ref().as_ref()) {
            None => drop(over.insert(key, value)),
            Some(stated) => {
                if let (DeValue::Table(over), DeValue::Table(under)) = (stated.get_mut(), value.into_inner()) {
                    lay_under(over, under);
                }
            }
        }
    }
}

/// Puts entries at the end of lists of the table `to`, each under the key of its list. `path` is the dotted path of `adds`, for messages.
fn add<'text>(to: &mut DeTable<'text>, adds: Spanned<DeValue<'text>>, path: &str) -> Result<(), Box<Problem>> {
    let span = adds.span();
    let refused = |path: &str, found: &str, span: Range<usize>| {
        Box::new(Problem {
            key: path.to_owned(),
            value: None,
            expected: format!("{found}, expected entries of a list, such as `[[adds.furniture]]`"),
            span,
            help: Some(format!("`adds`: {ADDS}")),
            file: None,
        })
    };
    let adds = match adds.into_inner() {
        DeValue::Table(adds) => adds,
        other => return Err(refused(path, found(&other), span)),
    };
    for (name, value) in adds {
        let path = format!("{path}.{}", name.get_ref());
        let (span, is_list) = (value.span(), value.get_ref().as_array().is_some());
        let missing = if is_list { DeValue::Array(DeArray::new()) } else { DeValue::Table(DeTable::new()) };
        let there = to.entry(name).or_insert_with(|| Spanned::new(span.clone(), missing)).get_mut();
        match (there, value.get_ref()) {
            (DeValue::Table(there), _) => add(there, value, &path)?,
            (DeValue::Array(there), DeValue::Array(_)) => {
                if let DeValue::Array(more) = value.into_inner() {
                    more.into_iter().for_each(|entry| there.push(entry));
                }
            }
            (_, other) => return Err(refused(&path, found(other), span)),
        }
    }
    Ok(())
}

/// Rewrites the path of a map file in `table`: it is relative to the file that states it, and becomes relative to the scene's own file. `folder` is
/// the path from the scene's folder to the folder of the file that states the map.
fn move_map(table: &mut DeTable<'_>, folder: &str) {
    let navigation = table.get_mut("navigation").map(Spanned::get_mut);
    let Some(DeValue::Table(navigation)) = navigation else { return };
    if let Some(DeValue::String(map)) = navigation.get_mut("map").map(Spanned::get_mut)
        && !Path::new(map.as_ref()).is_absolute()
    {
        *map = format!("{folder}{map}").into();
    }
}

fn shifted(span: Range<usize>, by: usize) -> Range<usize> {
    span.start + by..span.end + by
}

fn shifted_table(table: DeTable<'_>, by: usize) -> DeTable<'_> {
    let shifted_key = |key: Spanned<_>| Spanned::new(shifted(key.span(), by), key.into_inner());
    table.into_iter().map(|(key, value)| (shifted_key(key), shifted_value(value, by))).collect()
}

fn shifted_value(value: Spanned<DeValue<'_>>, by: usize) -> Spanned<DeValue<'_>> {
    let span = shifted(value.span(), by);
    let moved = match value.into_inner() {
        DeValue::Table(table) => DeValue::Table(shifted_table(table, by)),
        DeValue::Array(array) => {
            let mut moved = DeArray::new();
            array.into_iter().for_each(|item| moved.push(shifted_value(item, by)));
            DeValue::Array(moved)
        }
        plain => plain,
    };
    Spanned::new(span, moved)
}

/// Reads the text of a scene file, or of a file that names a scene. Errors at once for a file that is larger than any scene.
pub(crate) fn text_of(path: &Path) -> Result<String, SceneError> {
    let unreadable = |source| SceneError::Unreadable { path: path.to_owned(), source };
    let file = File::open(path).map_err(unreadable)?;
    let (stated_bytes, most_bytes) = (file.metadata().map_err(unreadable)?.len(), MOST_MB * 1_000_000);
    let too_large = |size_mb| SceneError::TooLarge { path: path.to_owned(), size_mb, most_mb: MOST_MB };
    if stated_bytes > most_bytes {
        return Err(too_large(Some(stated_bytes as f64 / 1e6)));
    }
    // A device or a pipe states no size, so that what is read is limited, too.
    let mut bytes = Vec::new();
    file.take(most_bytes + 1).read_to_end(&mut bytes).map_err(unreadable)?;
    if bytes.len() as u64 > most_bytes {
        return Err(too_large(None));
    }
    String::from_utf8(bytes).map_err(|error| SceneError::NotText {
        file: path.display().to_string(),
        offset: error.utf8_error().valid_up_to(),
    })
}

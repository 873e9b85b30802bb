//! Scenes that extend other scene files: merges a scene's file with the files that it extends, and remembers for each value where in their text it
//! stands.

use std::{
    fs,
    ops::Range,
    path::{Component, Path},
};

use miette::{MietteError, MietteSpanContents, SourceCode, SourceSpan, SpanContents};
use toml::{
    Spanned,
    de::{DeArray, DeTable, DeValue},
};

use super::{
    SceneError,
    conform::{excerpt, found},
    error::{Problem, Problems},
};

/// Explanation of the key `extends`, for the schema.
pub(super) const EXTENDS: &str = "A file on whose keys this one builds, as a path from this file's folder. Tables merge key by key, and this file \
wins; any other value, lists included, replaces the whole. `description` is never taken over, `[expect]` only as a whole.";

/// The texts of a scene's file and of the files that it extends, joined one after the other, so that a range of bytes gives both a file and a place
/// in it.
#[derive(Debug)]
pub struct Sources {
    /// The joined texts of all files, with a line break between each two.
    text: String,
    /// The files in the order of the joined text: the scene's own file first, and after each file the one that it extends.
    files: Vec<Source>,
}

#[derive(Debug)]
struct Source {
    name: String,
    /// Range of bytes that a file takes up in the joined text of all files.
    span: Range<usize>,
    /// Relative path to this file's folder from the folder of the scene's own file: `""`, or with a slash at its end.
    folder: String,
}

impl Sources {
    /// Makes sources of a single text. A text that comes from no file cannot extend a file, as there is no folder in which that file could be found.
    pub(crate) fn alone(text: &str, name: &str) -> Sources {
        let whole = Source { name: name.to_owned(), span: 0..text.len(), folder: String::new() };
        Sources { text: text.to_owned(), files: vec![whole] }
    }

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

    /// All files merged into one document, without their keys `extends`. Spans in the document are ranges of bytes of the joined `text`.
    pub(crate) fn merged(&self) -> Result<Spanned<DeTable<'_>>, Vec<Problem>> {
        let mut merged = DeTable::new();
        for source in &self.files {
            let start = source.span.start;
            let document = DeTable::parse(&self.text[source.span.clone()])
                .map_err(|error| vec![Problem::of_toml(&error, start)])?;
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
            if merged.contains_key("expect") {
                table.remove("expect");
            }
            lay_under(&mut merged, table);
        }
        Ok(Spanned::new(0..self.text.len(), merged))
    }

    /// The joined text of all files. The spans of keys and values are ranges of its bytes.
    pub(crate) fn text(&self) -> &str {
        &self.text
    }

    /// Whether the scene consists of a single file.
    pub(crate) fn is_one(&self) -> bool {
        self.files.len() == 1
    }

    /// Name of the scene's own file.
    pub fn name(&self) -> &str {
        self.files.first().map_or("", |file| &file.name)
    }

    /// Makes the error that refuses the scene because of `problems`. Enters in each problem the name of the file in which it stands.
    pub(crate) fn refuse(self, mut problems: Vec<Problem>) -> SceneError {
        for problem in &mut problems {
            let place = self.files.iter().position(|source| source.holds(&problem.span));
            problem.file = place.filter(|index| *index > 0).map(|index| self.files[index].name.clone());
        }
        SceneError::Invalid { sources: self, problems: Problems(problems) }
    }
}

impl Source {
    fn holds(&self, span: &Range<usize>) -> bool {
        self.span.start <= span.start && span.end <= self.span.end
    }
}

/// Shows a range of bytes of the joined text in an error message, together with the name and the lines of the file in which it stands.
impl SourceCode for Sources {
    fn read_span<'a>(
        &'a self,
        span: &SourceSpan,
        lines_before: usize,
        lines_after: usize,
    ) -> Result<Box<dyn SpanContents<'a> + 'a>, MietteError> {
        let range = span.offset()..span.offset() + span.len();
        let source = self.files.iter().find(|source| source.holds(&range)).ok_or(MietteError::OutOfBounds)?;
        let start = source.span.start;
        let inside = SourceSpan::from((span.offset() - start, span.len()));
        let text = &self.text[source.span.clone()];
        let read = text.read_span(&inside, lines_before, lines_after)?;
        let shown = SourceSpan::from((read.span().offset() + start, read.span().len()));
        let (line, column, n_lines) = (read.line(), read.column(), read.line_count());
        let named = MietteSpanContents::new_named(source.name.clone(), read.data(), shown, line, column, n_lines);
        Ok(Box::new(named.with_language("toml")))
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

/// Reads the text of a scene file.
fn text_of(path: &Path) -> Result<String, SceneError> {
    let bytes = fs::read(path).map_err(|source| SceneError::Unreadable { path: path.to_owned(), source })?;
    String::from_utf8(bytes).map_err(|error| SceneError::NotText {
        file: path.display().to_string(),
        offset: error.utf8_error().valid_up_to(),
    })
}

//! The texts of which a scene is made, for what reads them and for messages that show a place in them.

use std::ops::Range;

use miette::{MietteError, MietteSpanContents, SourceCode, SourceSpan, SpanContents};

/// The texts of a scene's file and of the files that it extends, joined one after the other, so that a range of bytes gives both a file and a place
/// in it.
#[derive(Debug)]
pub struct Sources {
    /// The joined texts of all files, with a line break between each two.
    pub(super) text: String,
    /// The files in the order of the joined text: the scene's own file first, and after each file the one that it extends.
    pub(super) files: Vec<Source>,
}

/// One of the files, and where its text stands among the others.
#[derive(Debug)]
pub(super) struct Source {
    pub(super) name: String,
    /// Range of bytes that a file takes up in the joined text of all files.
    pub(super) span: Range<usize>,
    /// Relative path to this file's folder from the folder of the scene's own file: `""`, or with a slash at its end.
    pub(super) folder: String,
}

impl Sources {
    /// Makes sources of a single text. A text that comes from no file cannot extend a file, as there is no folder in which that file could be found.
    pub(crate) fn alone(text: &str, name: &str) -> Sources {
        let whole = Source { name: name.to_owned(), span: 0..text.len(), folder: String::new() };
        Sources { text: text.to_owned(), files: vec![whole] }
    }

    /// The joined text of all files. The spans of keys and values are ranges of its bytes.
    pub(crate) fn text(&self) -> &str {
        &self.text
    }

    /// Whether the scene consists of a single file.
    pub(crate) fn is_one(&self) -> bool {
        self.files.len() == 1
    }

    /// Name of the file in which a range of bytes of the joined text lies; `None` if that is the scene's own file.
    pub(super) fn base_at(&self, span: &Range<usize>) -> Option<&str> {
        let place = self.files.iter().position(|source| source.holds(span))?;
        (place > 0).then(|| self.files[place].name.as_str())
    }

    /// Name of the scene's own file.
    pub fn name(&self) -> &str {
        self.files.first().map_or("", |file| &file.name)
    }
}

impl Source {
    /// Whether a range of bytes of the joined text lies in this file.
    pub(super) fn holds(&self, span: &Range<usize>) -> bool {
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

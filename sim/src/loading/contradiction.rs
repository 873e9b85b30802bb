//! A contradiction in a scene, and where in the scene's text it stands.

use std::ops::Range;

use toml::{
    Spanned,
    de::{DeTable, DeValue},
};

use crate::scene::{conform, problem::Problem};

/// A contradiction: something that a scene states in the right form but that is impossible.
pub(super) struct Contradiction {
    /// Dotted path of the key of the scene that states something impossible.
    pub(super) key: String,
    /// What is wrong, and what was expected.
    pub(super) expected: String,
}

impl Contradiction {
    /// The contradiction as a problem in the scene's text, from which `document` was parsed.
    pub(super) fn in_text(self, document: &Spanned<DeTable<'_>>, text: &str) -> Problem {
        let (span, is_value) = locate(document.get_ref(), &self.key);
        let value = is_value.then(|| conform::excerpt(&text[span.clone()]));
        Problem { key: self.key, value, expected: self.expected, span, help: None, file: None }
    }
}

/// Range of bytes in the scene's text of the value of `key`. If the file does not state the key, the range is that of the innermost table around it
/// that the file has. The flag says whether the range is that of the value.
fn locate(document: &DeTable<'_>, key: &str) -> (Range<usize>, bool) {
    let mut table = document;
    let mut span = 0..0;
    for part in key.split('.') {
        let (name, index) = match part.split_once('[') {
            Some((name, index)) => (name, index.trim_end_matches(']').parse::<usize>().ok()),
            None => (part, None),
        };
        let Some(mut value) = table.get(name) else { return (span, false) };
        if let (Some(index), DeValue::Array(array)) = (index, value.get_ref()) {
            match array.get(index) {
                Some(item) => value = item,
                None => return (value.span(), false),
            }
        }
        span = value.span();
        match value.get_ref() {
            DeValue::Table(inner) => table = inner,
            _ => return (span, true),
        }
    }
    (span, false)
}

//! What the cases of a sweep come to: verdict first, then where, then the worst cases and how to see them again.
//!
//! One [`Overview`] serves a terminal, a Markdown summary and a page of HTML, so that they cannot differ.

mod measure;
mod overview;
mod text;

pub use measure::{MEASURES, Measure};
pub use overview::{Group, Overview};
pub use text::as_text;

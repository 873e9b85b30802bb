//! What the cases of a sweep come to: verdict first, then where, then the worst cases and how to see them again.
//!
//! One [`Overview`] serves a terminal, a Markdown summary and a page of HTML, so that they cannot differ.

mod corridor;
mod diagram;
mod heatmap;
mod markdown;
mod measure;
mod overview;
mod page;
mod picture;
mod steps;
mod text;

pub use markdown::as_markdown;
pub use measure::{MEASURES, Measure};
pub use overview::{Group, Overview};
pub use page::as_html;
pub use text::{as_text, first_outside};

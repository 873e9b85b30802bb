//! The report on the cases of a sweep: the verdict first, then where cases failed, then the worst cases and the commands that run them again.
//!
//! One [`Overview`] serves the terminal, the Markdown summary and the HTML page, so that they cannot differ.

mod chosen;
mod corridor;
mod costs;
mod diagram;
mod files;
mod heatmap;
mod incidents;
mod looked_back;
mod markdown;
mod measure;
mod overview;
mod page;
mod picture;
mod sketched;
mod steps;
mod text;
mod worst;

pub use chosen::shown_figures;
pub use files::write;
pub use markdown::as_markdown;
pub use measure::{MEASURES, Measure};
pub(super) use overview::badness;
pub use overview::{Group, Overview};
pub use page::as_html;
pub use sketched::Sketched;
pub use text::{as_text, broken_bounds, first_outside, first_outside_of};

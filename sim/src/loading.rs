//! From files and texts to scenes that are valid: read, merged, held against the schema, and then against themselves.

mod parse;
mod files;
mod setting;
mod places;
mod markers;

pub use files::SceneFile;
pub use setting::{SceneTemplate, Setting, shown, value_of};

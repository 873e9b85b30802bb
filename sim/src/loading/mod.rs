//! From files and texts to valid scenes: files are read, merged, checked against the schema, and then checked for contradictions in themselves.

mod parse;
mod files;
mod setting;
mod upgrade;
mod places;
mod markers;
mod remarks;
pub mod coverage;

pub use files::SceneFile;
pub(crate) use files::texts;
pub use setting::{SceneTemplate, Setting, shown, value_of};
pub use upgrade::{UpgradeError, Upgraded, upgraded};

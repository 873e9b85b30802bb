//! From files and texts to valid scenes: files are read, merged, checked against the schema, and then checked for contradictions in themselves.

mod contradiction;
mod parse;
mod files;
mod setting;
mod template;
mod upgrade;
mod places;
mod markers;
mod remarks;
pub mod coverage;

pub use files::SceneFile;
pub(crate) use files::texts;
pub use setting::{Setting, extending, shown, value_of};
pub use template::SceneTemplate;
pub use upgrade::{UpgradeError, Upgraded, upgraded};

//! Scenes of older versions rewritten for this one: keys that have moved are put where they stand now. Comments and layout of the text are kept.

use toml_edit::{DocumentMut, InlineTable, Item, Key, Table, TomlError, Value};

use crate::scene::moved::MOVED;

/// The text of a scene after its rewriting, and what was rewritten.
#[derive(Clone, Debug, PartialEq)]
pub struct Upgraded {
    /// New text of the scene.
    pub text: String,
    /// Keys that were moved: for each its old and its new dotted path. Without any, the text is as it was.
    pub moved: Vec<(&'static str, &'static str)>,
}

/// Why a scene could not be rewritten. The text of the error follows "failed to".
#[derive(Debug, thiserror::Error)]
pub enum UpgradeError {
    /// The text is not TOML.
    #[error("read it as TOML: {}", .0.to_string().trim())]
    NotToml(Box<TomlError>),
    /// A key is stated both where it stood and where it stands now.
    #[error("move `{before}` to `{now}`: both are stated, expected one of them")]
    Twice {
        /// Old dotted path of the key.
        before: &'static str,
        /// New dotted path of the key.
        now: &'static str,
    },
    /// Something else stands where a table is needed for a key that has moved.
    #[error("move `{before}` to `{now}`: `{at}` is not a table, expected one")]
    NoTable {
        /// Old dotted path of the key.
        before: &'static str,
        /// New dotted path of the key.
        now: &'static str,
        /// Name of the key at which a table was expected.
        at: &'static str,
    },
}

/// Rewrites the text of a scene, or of a file that scenes extend.
///
/// # Errors
/// If the text is not TOML, or if a key cannot be put where it stands now.
pub fn upgraded(text: &str) -> Result<Upgraded, UpgradeError> {
    let mut document: DocumentMut = text.parse().map_err(|error| UpgradeError::NotToml(Box::new(error)))?;
    let mut moved = Vec::new();
    for (before, now) in MOVED {
        if let Some((key, item)) = take(document.as_item_mut(), before) {
            put(document.as_item_mut(), (before, now), &key, item)?;
            moved.push((before, now));
        }
    }
    // A text in which nothing has moved is returned as it is, whatever the library makes of its line ends.
    let text = if moved.is_empty() { text.to_owned() } else { document.to_string() };
    Ok(Upgraded { text, moved })
}

/// Takes the value at a dotted path out of a document, with its key, to which comments belong.
fn take(document: &mut Item, path: &str) -> Option<(Key, Item)> {
    let (tables, name) = path.rsplit_once('.')?;
    let table = tables.split('.').try_fold(document, |item, table| item.get_mut(table))?.as_table_like_mut()?;
    let key = table.key(name)?.clone();
    Some((key, table.remove(name)?))
}

/// Puts a value at a dotted path of a document. Tables that are missing on the way are made in the style of the table in which they are.
fn put(
    document: &mut Item,
    (before, now): (&'static str, &'static str),
    key: &Key,
    value: Item,
) -> Result<(), UpgradeError> {
    let (tables, name) = now.rsplit_once('.').unwrap_or(("", now));
    let mut item = document;
    for at in tables.split('.') {
        let missing = match &*item {
            Item::Value(_) => Item::Value(Value::InlineTable(InlineTable::new())),
            outer => {
                let mut table = Table::new();
                table.set_dotted(outer.as_table().is_some_and(Table::is_dotted));
                // The new table stands directly behind the keys of the table in which it is, before other tables in there.
                table.set_position(outer.as_table().and_then(Table::position));
                Item::Table(table)
            }
        };
        let table = item.as_table_like_mut().ok_or(UpgradeError::NoTable { before, now, at })?;
        item = table.entry(at).or_insert(missing);
    }
    let at = tables.rsplit('.').next().unwrap_or(tables);
    let table = item.as_table_like_mut().ok_or(UpgradeError::NoTable { before, now, at })?;
    if table.contains_key(name) {
        return Err(UpgradeError::Twice { before, now });
    }
    let mut renamed = Key::new(name);
    *renamed.leaf_decor_mut() = key.leaf_decor().clone();
    table.entry_format(&renamed).or_insert(value);
    Ok(())
}

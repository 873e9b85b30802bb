//! A bag of rosbag2 in an SQLite database: the table `topics` names the topics and their types, the table `messages` has a row for each message.

use std::collections::BTreeMap;

use super::{
    raw_message::{RawMessage, See},
    sqlite::{Database, Seekable, SqliteError, Value},
};

/// A row of the table `topics`.
struct Topic {
    name: String,
    kind: String,
    encoding: String,
}

/// Why the walk over the rows of a bag ended early.
enum Ended {
    Failed(SqliteError),
    /// The receiver of the messages wants no more of them.
    Enough,
}

impl From<SqliteError> for Ended {
    fn from(error: SqliteError) -> Ended {
        Ended::Failed(error)
    }
}

/// Hands every message of a bag to `see`, in the order of the rows. Returns what is damaged in it: rows after damage are lost.
pub(super) fn read(file: Box<dyn Seekable>, see: &mut See<'_>) -> Result<Vec<String>, SqliteError> {
    let mut database = Database::open(file)?;
    let mut topics = BTreeMap::new();
    database.rows("topics", &["id", "name", "type", "serialization_format"], &mut |row| {
        let [Value::Integer(id), Value::Text(name), Value::Text(kind), Value::Text(encoding)] = row else {
            return Err(SqliteError::Damaged("a row of the table `topics` is not what rosbag2 writes"));
        };
        let [name, kind, encoding] = [name, kind, encoding].map(|text| String::from_utf8_lossy(text).into_owned());
        topics.insert(*id, Topic { name, kind: kind.replace("/msg/", "/"), encoding });
        Ok(())
    })?;
    let mut n_bad = 0_usize;
    let walked = database.rows("messages", &["topic_id", "timestamp", "data"], &mut |row| {
        let [Value::Integer(topic), Value::Integer(logged_ns), Value::Blob(data)] = row else {
            n_bad += 1;
            return Ok(());
        };
        let Some(Topic { name, kind, encoding }) = topics.get(topic) else {
            n_bad += 1;
            return Ok(());
        };
        let goes_on = see(RawMessage { topic: name, kind, encoding, logged_ns: *logged_ns, data });
        if goes_on { Ok(()) } else { Err(Ended::Enough) }
    });
    let mut damage = Vec::new();
    if n_bad > 0 {
        damage.push(format!("{n_bad} rows of the table `messages` are not what rosbag2 writes"));
    }
    match walked {
        Err(Ended::Failed(SqliteError::Damaged(what))) => {
            damage.push(format!("the SQLite database is damaged, and the messages that come after are lost: {what}"));
        }
        Err(Ended::Failed(error)) => return Err(error),
        Ok(()) | Err(Ended::Enough) => {}
    }
    Ok(damage)
}

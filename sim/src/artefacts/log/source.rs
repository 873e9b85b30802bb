//! The files of a log, and the messages in them: an MCAP file, a database of rosbag2, or a folder of rosbag2 with either.

use std::{
    fs::{self, File},
    io::{self, Cursor, Read},
    path::{Path, PathBuf},
};

use serde::Deserialize;

use super::{
    LogError, bag_database,
    mcap_file::{self, MCAP_MAGIC},
    raw_message::{Damage, RawMessage, See},
    sqlite,
};

/// First bytes of a file that Zstandard compressed.
const ZSTD_MAGIC: [u8; 4] = [0x28, 0xb5, 0x2f, 0xfd];
/// First bytes of a bag of ROS 1.
const ROS1_MAGIC: &[u8] = b"#ROSBAG V";
/// Greatest number of bytes of a compressed message after decompression: no image is that large.
const GREATEST_MESSAGE_BYTES: usize = 1 << 28;
/// Greatest number of bytes of a compressed file of a database after decompression, as it is kept in memory.
const GREATEST_DATABASE_BYTES: u64 = 1 << 32;
/// What a log may be, for messages.
const LOG: &str = "an MCAP file, a `.db3` file of rosbag2, or a folder of rosbag2";

/// The files of a log in the order of recording.
#[derive(Clone, Debug)]
pub(super) struct Source {
    files: Vec<PathBuf>,
    /// Whether each message is compressed by itself.
    compresses_messages: bool,
    /// What is wrong with the log as a whole.
    damage: Vec<Damage>,
}

/// The part of a bag's `metadata.yaml` that is needed to read the bag.
#[derive(Debug, Deserialize)]
struct Metadata {
    rosbag2_bagfile_information: Information,
}

#[derive(Debug, Deserialize)]
struct Information {
    #[serde(default)]
    compression_format: String,
    #[serde(default)]
    compression_mode: String,
    relative_file_paths: Vec<String>,
}

impl Source {
    /// Finds the files of a log.
    pub(super) fn open(path: &Path) -> Result<Source, LogError> {
        if !path.is_dir() {
            // The system says best why a file cannot be opened.
            File::open(path).map_err(|source| LogError::Unreadable { path: path.to_owned(), source })?;
            return Ok(Source { files: vec![path.to_owned()], compresses_messages: false, damage: Vec::new() });
        }
        let description = path.join("metadata.yaml");
        if !description.exists() {
            return Source::of_undescribed(path);
        }
        let text = fs::read_to_string(&description)
            .map_err(|source| LogError::Unreadable { path: description.clone(), source })?;
        let invalid = |found: String| LogError::Invalid {
            path: description.clone(),
            found,
            expected: "the description of a bag as rosbag2 writes it",
        };
        let Metadata { rosbag2_bagfile_information: about } =
            serde_saphyr::from_str(&text).map_err(|error| invalid(error.to_string().replace('\n', " ")))?;
        if !["", "zstd"].contains(&about.compression_format.as_str()) {
            return Err(invalid(format!(
                "`compression_format` is `{}`, of which only `zstd` is read",
                about.compression_format
            )));
        }
        if about.relative_file_paths.is_empty() {
            return Err(invalid("`relative_file_paths` is empty".to_owned()));
        }
        let files: Vec<PathBuf> = about.relative_file_paths.iter().map(|name| path.join(name)).collect();
        for file in &files {
            File::open(file).map_err(|source| LogError::Unreadable { path: file.clone(), source })?;
        }
        let compresses_messages = about.compression_mode.eq_ignore_ascii_case("message");
        Ok(Source { files, compresses_messages, damage: Vec::new() })
    }

    /// The files of a bag whose recording was not finished, so that its description is missing.
    fn of_undescribed(folder: &Path) -> Result<Source, LogError> {
        let unreadable = |source| LogError::Unreadable { path: folder.to_owned(), source };
        let entries: io::Result<Vec<PathBuf>> =
            fs::read_dir(folder).map_err(unreadable)?.map(|entry| Ok(entry?.path())).collect();
        let is_log = |path: &PathBuf| {
            let name = path.file_name().unwrap_or_default().to_string_lossy();
            [".mcap", ".db3", ".mcap.zstd", ".db3.zstd"].iter().any(|ending| name.ends_with(ending))
        };
        let mut files: Vec<PathBuf> = entries.map_err(unreadable)?.into_iter().filter(is_log).collect();
        files.sort();
        if files.is_empty() {
            let found = "the folder has neither metadata.yaml nor a file of messages".to_owned();
            return Err(LogError::Invalid { path: folder.to_owned(), found, expected: LOG });
        }
        let what = "metadata.yaml is missing, as where the recording was not closed".to_owned();
        Ok(Source { files, compresses_messages: false, damage: vec![Damage { what, after: None }] })
    }

    /// Hands every message of the log to `see`, in the order of the files. Returns what damage kept messages from being read.
    pub(super) fn read(&self, see: &mut See<'_>) -> Result<Vec<Damage>, LogError> {
        let mut damage = self.damage.clone();
        let (mut goes_on, mut last, mut n_bad) = (true, None::<(String, i64)>, 0_usize);
        for file in &self.files {
            let mut see_one = |message: RawMessage<'_>| {
                if last.as_ref().is_none_or(|(topic, _)| topic != message.topic) {
                    last = Some((message.topic.to_owned(), message.logged_ns));
                } else if let Some((_, logged_ns)) = &mut last {
                    *logged_ns = message.logged_ns;
                }
                if !self.compresses_messages {
                    goes_on = see(message);
                } else if let Ok(data) = zstd::bulk::decompress(message.data, GREATEST_MESSAGE_BYTES) {
                    goes_on = see(RawMessage { data: &data, ..message });
                } else {
                    n_bad += 1;
                }
                goes_on
            };
            let found = read_file(file, &mut see_one)?;
            damage.extend(found.into_iter().map(|what| Damage { what, after: last.clone() }));
            if !goes_on {
                break;
            }
        }
        if n_bad > 0 {
            let what = format!("{n_bad} messages do not decompress");
            damage.push(Damage { what, after: None });
        }
        Ok(damage)
    }
}

/// Hands every message of one file to `see`. Returns what is damaged in it.
fn read_file(path: &Path, see: &mut See<'_>) -> Result<Vec<String>, LogError> {
    let unreadable = |source| LogError::Unreadable { path: path.to_owned(), source };
    let invalid = |found: String| LogError::Invalid { path: path.to_owned(), found, expected: LOG };
    let mut file = File::open(path).map_err(unreadable)?;
    let begin = first_bytes(&mut file).map_err(unreadable)?;
    let again = File::open(path).map_err(unreadable)?;
    let (is_compressed, begin) = match begin.starts_with(&ZSTD_MAGIC) {
        true => {
            let mut inside = zstd::Decoder::new(File::open(path).map_err(unreadable)?).map_err(unreadable)?;
            (true, first_bytes(&mut inside).map_err(|error| invalid(format!("it does not decompress: {error}")))?)
        }
        false => (false, begin),
    };
    if begin.starts_with(&MCAP_MAGIC) {
        let stream: Box<dyn Read> =
            if is_compressed { Box::new(zstd::Decoder::new(again).map_err(unreadable)?) } else { Box::new(again) };
        return mcap_file::read(stream, see).map_err(unreadable);
    }
    if begin.starts_with(sqlite::MAGIC) {
        if fs::metadata(with_ending(path, "-wal")).is_ok_and(|log| log.len() > 0) {
            let found = "beside it is a write-ahead log with messages that are not in it yet".to_owned();
            return Err(LogError::Invalid {
                path: path.to_owned(),
                found,
                expected: "a closed bag, as `ros2 bag reindex` or any program of SQLite that opens it makes of it",
            });
        }
        let file: Box<dyn sqlite::Seekable> = if is_compressed {
            let mut bytes = Vec::new();
            let inside = zstd::Decoder::new(again).map_err(unreadable)?;
            let read = inside.take(GREATEST_DATABASE_BYTES + 1).read_to_end(&mut bytes);
            read.map_err(|error| invalid(format!("it does not decompress: {error}")))?;
            if bytes.len() as u64 > GREATEST_DATABASE_BYTES {
                return Err(invalid("it is too long for the memory after decompression".to_owned()));
            }
            Box::new(Cursor::new(bytes))
        } else {
            Box::new(again)
        };
        return bag_database::read(file, see).map_err(|error| LogError::of_database(path, error));
    }
    if begin.starts_with(ROS1_MAGIC) {
        return Err(invalid(
            "it is a bag of ROS 1, which `rosbags-convert` of the Python package rosbags turns into one of ROS 2"
                .to_owned(),
        ));
    }
    Err(invalid("it begins as none of these".to_owned()))
}

/// The first bytes of a stream, as many as tell what it is.
fn first_bytes(stream: &mut dyn Read) -> io::Result<Vec<u8>> {
    let mut bytes = Vec::new();
    stream.take(16).read_to_end(&mut bytes)?;
    Ok(bytes)
}

fn with_ending(path: &Path, ending: &str) -> PathBuf {
    let mut name = path.as_os_str().to_owned();
    name.push(ending);
    PathBuf::from(name)
}

//! Reads a recording from its beginning to its end, one part after another.

use std::{
    collections::BTreeMap,
    fs::File,
    io::{self, BufReader, Read},
    path::{Path, PathBuf},
};

use mcap::{
    McapError,
    records::Record,
    sans_io::linear_reader::{LinearReadEvent, LinearReader, LinearReaderOptions},
};
use thiserror::Error;

use super::{FORMAT, FORMAT_METADATA, METADATA, SCENE_ATTACHMENT};

/// Greatest plausible length of a record. A greater one indicates a damaged file, since no chunk or image is that long.
const GREATEST_RECORD_BYTES: usize = 1 << 28;

/// Reason why a recording cannot be read. The error's text is phrased to follow "failed to".
#[derive(Debug, Error)]
pub enum RecordingError {
    /// The file cannot be opened or read.
    #[error("read recording {}: {source}", path.display())]
    Unreadable {
        /// The file that was read.
        path: PathBuf,
        /// Error that the system reported.
        source: io::Error,
    },
    /// The file ends too early, as it does while it is still being written or when it was copied only in part.
    #[error("read recording {}: it is cut short, expected a file that `wherein run --record` finished", .0.display())]
    CutShort(PathBuf),
    /// The file is not an MCAP file, or is a damaged one.
    #[error("read recording {}: {source}, expected an MCAP file that `wherein run --record` wrote", path.display())]
    Damaged {
        /// The file that was read.
        path: PathBuf,
        /// What is wrong with the file.
        source: McapError,
    },
    /// The file is an MCAP file that another program wrote.
    #[error("read recording {}: {missing} is missing, expected a file that `wherein run --record` wrote", path.display())]
    Foreign {
        /// The file that was read.
        path: PathBuf,
        /// The part that every recording of Wherein has and this file lacks.
        missing: &'static str,
    },
    /// The recording was made by an older or a newer version of Wherein.
    #[error("read recording {}: its format is `{found}`, expected `{FORMAT}`", path.display())]
    OtherFormat {
        /// The file that was read.
        path: PathBuf,
        /// The format that the file names.
        found: String,
    },
    /// A message does not have the content that its topic requires.
    #[error("read recording {}: a message of {topic} is not what its topic promises", path.display())]
    Message {
        /// The file that was read.
        path: PathBuf,
        /// The topic of the message.
        topic: String,
    },
}

/// A part of a recording.
pub(crate) enum Part<'a> {
    /// The text of the scene; it comes before every message.
    Scene(&'a str),
    /// A message; messages come in the order of events.
    Message { topic: &'a str, message: &'a [u8] },
    /// Seed, version, graphics adapter and digests of the run; they come after every message.
    Facts(&'a BTreeMap<String, String>),
}

/// The recording's file: of a folder, as `wherein run --ros2` writes one, the only file in it that ends in `.mcap`.
fn file_of(path: &Path) -> Result<PathBuf, RecordingError> {
    if !path.is_dir() {
        return Ok(path.to_owned());
    }
    let unreadable = |source| RecordingError::Unreadable { path: path.to_owned(), source };
    let entries = path.read_dir().map_err(unreadable)?.filter_map(Result::ok).map(|entry| entry.path());
    let files: Vec<PathBuf> = entries.filter(|file| file.extension().is_some_and(|end| end == "mcap")).collect();
    match files.as_slice() {
        [file] => Ok(file.clone()),
        _ => Err(unreadable(io::Error::other(format!(
            "a folder with {} files that end in .mcap, expected a file, or a folder with one such file",
            files.len()
        )))),
    }
}

/// Hands every part of the file to `hear`, then makes sure that the file was complete.
pub(crate) fn read<E: From<RecordingError>>(
    path: &Path,
    hear: &mut dyn FnMut(Part<'_>) -> Result<(), E>,
) -> Result<(), E> {
    let path = &file_of(path)?;
    let unreadable = |source| RecordingError::Unreadable { path: path.to_owned(), source };
    let mut file = BufReader::new(File::open(path).map_err(unreadable)?);
    let options = LinearReaderOptions::default()
        .with_prevalidate_chunk_crcs(true)
        .with_validate_data_section_crc(true)
        .with_record_length_limit(GREATEST_RECORD_BYTES);
    let mut reader = LinearReader::new_with_options(options);
    let mut topics = BTreeMap::new();
    let (mut is_ours, mut is_whole) = (false, false);
    while let Some(event) = reader.next_event() {
        let (opcode, data) = match event.map_err(|error| broken(path, error))? {
            LinearReadEvent::ReadRequest(need) => {
                let n_bytes = file.read(reader.insert(need)).map_err(unreadable)?;
                reader.notify_read(n_bytes);
                continue;
            }
            LinearReadEvent::Record { opcode, data } => (opcode, data),
        };
        let record = mcap::parse_record(opcode, data).map_err(|error| broken(path, error))?;
        if !is_ours && !matches!(record, Record::Header(_) | Record::Metadata(_)) {
            return Err(
                RecordingError::Foreign { path: path.to_owned(), missing: "the metadata `wherein_format`" }.into()
            );
        }
        match record {
            Record::Metadata(facts) if facts.name == FORMAT_METADATA => {
                let found = facts.metadata.get("format").cloned().unwrap_or_default();
                if found != FORMAT {
                    return Err(RecordingError::OtherFormat { path: path.to_owned(), found }.into());
                }
                is_ours = true;
            }
            Record::Metadata(facts) if facts.name == METADATA => {
                hear(Part::Facts(&facts.metadata))?;
                is_whole = true;
            }
            Record::Attachment { header, data, .. } if header.name == SCENE_ATTACHMENT => {
                let missing = || RecordingError::Foreign { path: path.to_owned(), missing: "the scene's text" };
                hear(Part::Scene(std::str::from_utf8(&data).map_err(|_| missing())?))?;
            }
            Record::Channel(channel) => {
                topics.insert(channel.id, channel.topic);
            }
            Record::Message { header, data } => {
                let topic = topics.get(&header.channel_id).map(String::as_str).unwrap_or_default();
                hear(Part::Message { topic, message: &data })?;
            }
            _ => {}
        }
    }
    if is_whole { Ok(()) } else { Err(RecordingError::CutShort(path.to_owned()).into()) }
}

fn broken(path: &Path, error: McapError) -> RecordingError {
    match error {
        McapError::UnexpectedEof | McapError::UnexpectedEoc => RecordingError::CutShort(path.to_owned()),
        source => RecordingError::Damaged { path: path.to_owned(), source },
    }
}

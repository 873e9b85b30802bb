//! A recording from its beginning to its end, one part after another.

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

/// A length beyond this is a broken file's, not that of a chunk or an image.
const GREATEST_RECORD_BYTES: usize = 1 << 28;

/// Why a recording cannot be read. Its text follows "failed to".
#[derive(Debug, Error)]
pub enum RecordingError {
    /// The file cannot be opened or read.
    #[error("read recording {}: {source}", path.display())]
    Unreadable {
        /// The file.
        path: PathBuf,
        /// What the system said.
        source: io::Error,
    },
    /// It ends before its end, as one does that is still being written or was copied in part.
    #[error("read recording {}: it is cut short, expected a file that `wherein run --record` finished", .0.display())]
    CutShort(PathBuf),
    /// It is no MCAP file or a damaged one.
    #[error("read recording {}: {source}, expected an MCAP file that `wherein run --record` wrote", path.display())]
    Damaged {
        /// The file.
        path: PathBuf,
        /// What is wrong with it.
        source: McapError,
    },
    /// An MCAP file of another program.
    #[error("read recording {}: {missing} is missing, expected a file that `wherein run --record` wrote", path.display())]
    Foreign {
        /// The file.
        path: PathBuf,
        /// What every recording has.
        missing: &'static str,
    },
    /// A recording of an older or a newer Wherein.
    #[error("read recording {}: its format is `{found}`, expected `{FORMAT}`", path.display())]
    OtherFormat {
        /// The file.
        path: PathBuf,
        /// The format that it names.
        found: String,
    },
    /// A message does not hold what its topic promises.
    #[error("read recording {}: a message of {topic} is not what its topic promises", path.display())]
    Message {
        /// The file.
        path: PathBuf,
        /// The topic.
        topic: String,
    },
}

/// A part of a recording.
pub(crate) enum Part<'a> {
    /// The text of the scene; before every message.
    Scene(&'a str),
    /// A message; in the order of events.
    Message { topic: &'a str, message: &'a [u8] },
    /// Seed, version, adapter and digests; after every message.
    Facts(&'a BTreeMap<String, String>),
}

/// Tells `hear` every part of the file, then makes sure that the file was whole.
pub(crate) fn read<E: From<RecordingError>>(
    path: &Path,
    hear: &mut dyn FnMut(Part<'_>) -> Result<(), E>,
) -> Result<(), E> {
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

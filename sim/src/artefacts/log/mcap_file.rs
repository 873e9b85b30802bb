//! An MCAP file of another program, read from its beginning to its end. The file's summary is not needed, so that a file that was cut short can be
//! read up to there; a chunk that is damaged is left out as a whole.
//!
//! Source: <https://mcap.dev/spec>.

use std::{
    collections::BTreeMap,
    io::{self, BufReader, Read},
};

use mcap::{
    parse_record,
    records::{ChunkHeader, Record, op},
};

use super::raw_message::{RawMessage, See};

/// First bytes of an MCAP file.
pub(super) const MCAP_MAGIC: [u8; 8] = [0x89, b'M', b'C', b'A', b'P', b'0', b'\r', b'\n'];

/// Greatest number of bytes of a chunk after decompression. Writers begin a new chunk after some megabytes.
const GREATEST_CHUNK_BYTES: u64 = 1 << 30;

/// A channel: the topic of its messages, their type and their encoding.
struct Channel {
    topic: String,
    kind: String,
    encoding: String,
}

/// What the records so far have said.
#[derive(Default)]
struct Reader {
    schemas: BTreeMap<u16, String>,
    channels: BTreeMap<u16, Channel>,
    damage: Vec<String>,
    /// Number of messages of channels that no record before them describes.
    n_unknown: usize,
}

/// Hands every message of an MCAP file to `see`, in the order of the file. Returns what is damaged in it.
///
/// Errors when the file cannot be read.
pub(super) fn read(file: Box<dyn Read>, see: &mut See<'_>) -> io::Result<Vec<String>> {
    let mut file = BufReader::new(file);
    let mut magic = [0; MCAP_MAGIC.len()];
    file.read_exact(&mut magic)?;
    let mut reader = Reader::default();
    while let Some((opcode, body)) = next_record(&mut file, &mut reader.damage)? {
        match opcode {
            op::DATA_END => break,
            op::CHUNK => match parse_record(opcode, &body) {
                Ok(Record::Chunk { header, data }) => {
                    if !reader.chunk(header, &data, see) {
                        break;
                    }
                }
                _ => reader.damage.push("a chunk is damaged, and its messages are lost".to_owned()),
            },
            op::SCHEMA | op::CHANNEL | op::MESSAGE => match parse_record(opcode, &body) {
                Ok(record) => {
                    if !reader.record(&record, see) {
                        break;
                    }
                }
                Err(_) => reader.damage.push("a record is damaged".to_owned()),
            },
            _ => {}
        }
    }
    if reader.n_unknown > 0 {
        reader.damage.push(format!("{} messages are of channels that nothing describes", reader.n_unknown));
    }
    Ok(reader.damage)
}

/// The next record of the file: its kind and its content; `None` where the file ends, which is noted as damage, as every file ends with a summary.
fn next_record(file: &mut dyn Read, damage: &mut Vec<String>) -> io::Result<Option<(u8, Vec<u8>)>> {
    let cut_short = "the file is cut short, and the messages that came after are lost";
    let mut head = Vec::new();
    let mut body = Vec::new();
    let whole = file.take(9).read_to_end(&mut head).and_then(|_| {
        let Some(&[opcode, ref length @ ..]) = head.first_chunk::<9>() else { return Ok(None) };
        let length = u64::from_le_bytes(*length);
        // The bytes are taken as they come, so that a false length asks for no more memory than the file has.
        file.take(length).read_to_end(&mut body)?;
        Ok((body.len() as u64 == length).then_some(opcode))
    });
    match whole {
        Ok(Some(opcode)) => Ok(Some((opcode, body))),
        Ok(None) => {
            damage.push(cut_short.to_owned());
            Ok(None)
        }
        // A compressed file that is cut short or damaged ends with an error of its decompression.
        Err(error) if matches!(error.kind(), io::ErrorKind::UnexpectedEof | io::ErrorKind::Other) => {
            damage.push(format!("{cut_short} ({error})"));
            Ok(None)
        }
        Err(error) => Err(error),
    }
}

/// The content of a chunk after decompression, if it has the length and the checksum that its header states.
fn content(header: &ChunkHeader, data: &[u8]) -> Result<Vec<u8>, String> {
    let mut whole = Vec::new();
    // One byte more shows a content that is longer than stated, and no false length asks for memory that nothing fills.
    let most = header.uncompressed_size.saturating_add(1);
    let read = match header.compression.as_str() {
        "" => data.take(most).read_to_end(&mut whole),
        "zstd" => zstd::Decoder::new(data).and_then(|inside| inside.take(most).read_to_end(&mut whole)),
        "lz4" => lz4::Decoder::new(data).and_then(|inside| inside.take(most).read_to_end(&mut whole)),
        other => return Err(format!("it is compressed by `{other}`, expected zstd, lz4 or nothing")),
    };
    read.map_err(|error| error.to_string())?;
    if whole.len() as u64 != header.uncompressed_size {
        return Err(format!("it has not the {} bytes that it states", header.uncompressed_size));
    }
    if header.uncompressed_crc != 0 && crc32fast::hash(&whole) != header.uncompressed_crc {
        return Err("its checksum is another one".to_owned());
    }
    Ok(whole)
}

/// The records of a chunk's content.
fn records(mut rest: &[u8]) -> Result<Vec<Record<'_>>, String> {
    let mut records = Vec::new();
    while let Some((&[opcode, ref length @ ..], body)) = rest.split_first_chunk::<9>() {
        let length = usize::try_from(u64::from_le_bytes(*length)).ok().filter(|length| *length <= body.len());
        let (record, after) = body.split_at(length.ok_or("a record in it is longer than what is left of it")?);
        records.push(parse_record(opcode, record).map_err(|error| error.to_string())?);
        rest = after;
    }
    if rest.is_empty() { Ok(records) } else { Err("it ends within a record".to_owned()) }
}

impl Reader {
    /// Hands the messages of a chunk to `see`, unless the chunk is damaged. Returns whether to read further.
    fn chunk(&mut self, header: ChunkHeader, data: &[u8], see: &mut See<'_>) -> bool {
        let span_s = [header.message_start_time, header.message_end_time].map(|time_ns| time_ns as f64 * 1e-9);
        let lost = |why: &str| {
            let [from_s, to_s] = span_s;
            format!("a chunk of messages that were logged from {from_s:.3} s to {to_s:.3} s is lost: {why}")
        };
        if header.uncompressed_size > GREATEST_CHUNK_BYTES {
            self.damage.push(lost("it is longer than any writer makes one"));
            return true;
        }
        // A chunk is taken as a whole or not at all, so that all of its records are read before the first is handed over.
        let whole = content(&header, data);
        let records = whole.as_deref().map_err(Clone::clone).and_then(records);
        match records {
            Ok(records) => records.iter().all(|record| self.record(record, see)),
            Err(why) => {
                self.damage.push(lost(&why));
                true
            }
        }
    }

    /// Takes in a record that is no chunk. Returns whether to read further.
    fn record(&mut self, record: &Record<'_>, see: &mut See<'_>) -> bool {
        match record {
            Record::Schema { header, .. } => {
                self.schemas.insert(header.id, header.name.replace("/msg/", "/"));
            }
            Record::Channel(channel) => {
                let kind = self.schemas.get(&channel.schema_id).cloned().unwrap_or_default();
                let (topic, encoding) = (channel.topic.clone(), channel.message_encoding.clone());
                self.channels.insert(channel.id, Channel { topic, kind, encoding });
            }
            Record::Message { header, data } => {
                let Some(Channel { topic, kind, encoding }) = self.channels.get(&header.channel_id) else {
                    self.n_unknown += 1;
                    return true;
                };
                let logged_ns = i64::try_from(header.log_time).unwrap_or(i64::MAX);
                return see(RawMessage { topic, kind, encoding, logged_ns, data });
            }
            _ => {}
        }
        true
    }
}

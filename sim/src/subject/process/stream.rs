//! The MCAP stream (<https://mcap.dev/spec>) that a process under test reads: neither chunked nor compressed, without a summary.

use std::{
    collections::BTreeMap,
    io::{self, Write},
    sync::mpsc::Sender,
};

use mcap::{McapResult, WriteOptions, Writer, records::MessageHeader, write::NoSeek};

use super::messages::{Message, Topic};

/// A stream of messages, which hands the bytes of each message on at once.
pub(super) struct Stream {
    writer: Writer<NoSeek<Outbox>>,
    /// Identifiers of the channels, in the order of [`Topic::ALL`].
    channels: Vec<u16>,
    n_messages: u32,
}

/// Collects bytes until they are flushed, and then hands them on.
struct Outbox {
    bytes: Vec<u8>,
    pipe: Sender<Vec<u8>>,
}

impl Write for Outbox {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.bytes.extend_from_slice(bytes);
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        if !self.bytes.is_empty() {
            // Nobody takes the bytes any more when the process has ended, which shows where its answer is awaited.
            let _ = self.pipe.send(std::mem::take(&mut self.bytes));
        }
        Ok(())
    }
}

impl Stream {
    /// Begins a stream into `pipe` with all its schemas and channels.
    pub(super) fn begin(pipe: Sender<Vec<u8>>) -> McapResult<Stream> {
        let options = WriteOptions::new()
            .library(concat!("wherein ", env!("CARGO_PKG_VERSION")))
            .compression(None)
            .use_chunks(false)
            .disable_seeking(true)
            .emit_summary_records(false)
            .emit_summary_offsets(false)
            .calculate_data_section_crc(false);
        let mut writer = options.create(NoSeek::new(Outbox { bytes: Vec::new(), pipe }))?;
        let mut channels = Vec::new();
        for topic in Topic::ALL {
            let (schema, encoding) = match topic.schema() {
                Some((name, schema)) => (writer.add_schema(name, "jsonschema", schema.to_string().as_bytes())?, "json"),
                None => (0, "raw"),
            };
            channels.push(writer.add_channel(schema, topic.name(), encoding, &BTreeMap::new())?);
        }
        writer.flush()?;
        Ok(Stream { writer, channels, n_messages: 0 })
    }

    /// Writes a message.
    pub(super) fn put(&mut self, message: &Message<'_>) -> McapResult<()> {
        // Simulated times are at least 0 and far below 2⁶⁴ ns, so that the conversion is exact to the nanosecond.
        let time_ns = (message.time_s * 1e9).round() as u64;
        let header = MessageHeader {
            channel_id: self.channels[message.topic as usize],
            sequence: self.n_messages,
            log_time: time_ns,
            publish_time: time_ns,
        };
        self.n_messages += 1;
        self.writer.write_to_known_channel(&header, &message.data)?;
        self.writer.flush()
    }

    /// Ends the stream, so that it is a complete MCAP file.
    pub(super) fn end(mut self) -> McapResult<()> {
        self.writer.finish()?;
        Ok(self.writer.into_inner().into_inner().flush()?)
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use std::sync::mpsc;

    use image::{GrayImage, Luma};
    use localizer::{Reading, reading::Camera};
    use mcap::MessageStream;
    use serde_json::{Value, json};

    use super::*;

    fn image() -> Reading {
        Reading::Camera {
            measured_s: 1.25,
            arrived_s: 1.5,
            camera: Camera::Ceiling,
            exposure_s: 0.01,
            image: GrayImage::from_fn(3, 2, |x, y| Luma([(10 * y + x) as u8])).into(),
        }
    }

    #[test]
    fn an_image_is_sent_as_its_stamps_and_then_its_bytes_row_by_row() {
        let (pipe, bytes) = mpsc::channel();
        let mut stream = Stream::begin(pipe).unwrap();
        let reading = image();
        let (head, pixels) = Message::of(&reading);
        stream.put(&head).unwrap();
        stream.put(&pixels.unwrap()).unwrap();
        stream.end().unwrap();
        let file: Vec<u8> = bytes.iter().flatten().collect();
        let messages: Vec<_> = MessageStream::new(&file).unwrap().map(Result::unwrap).collect();
        assert_eq!(messages.len(), 2);
        let content: Value = serde_json::from_slice(&messages[0].data).unwrap();
        let expected = json!({
            "device": "ceiling_camera", "measured_s": 1.25, "arrived_s": 1.5, "exposure_s": 0.01, "width_px": 3, "height_px": 2,
        });
        assert_eq!((messages[0].channel.topic.as_str(), content), ("/wherein/image", expected));
        assert_eq!(messages[1].channel.topic, "/wherein/pixels");
        assert_eq!(messages[1].data.as_ref(), [0, 1, 2, 10, 11, 12]);
        assert!(messages.iter().all(|message| message.log_time == 1_500_000_000));
    }

    #[test]
    fn each_message_is_handed_on_at_once_and_uncompressed() {
        let (pipe, bytes) = mpsc::channel();
        let mut stream = Stream::begin(pipe).unwrap();
        bytes.try_iter().count();
        for n_asked in 0..3 {
            stream.put(&Message::ask(f64::from(n_asked))).unwrap();
            let handed_on: Vec<Vec<u8>> = bytes.try_iter().collect();
            let [message] = &handed_on[..] else { panic!("{handed_on:?}") };
            // A record of the kind 5 with 22 bytes before its data, as the specification of MCAP has it.
            let data = format!("{{\"time_s\":{n_asked}.0}}");
            assert_eq!((message[0], message.len()), (5, 9 + 22 + data.len()));
            assert!(message.ends_with(data.as_bytes()));
        }
    }
}

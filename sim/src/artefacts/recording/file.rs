//! A recording: a stream of messages in an MCAP file.

use std::{
    collections::BTreeMap,
    fs::{self, File},
    io::{self, BufWriter},
    path::{Path, PathBuf},
    process,
};

use mcap::{Attachment, Compression, McapError, WriteOptions, Writer, records::MessageHeader, records::Metadata};

use crate::{
    artefacts::{
        files::{RecordError, folder, naming},
        summary::Summary,
        wording::{of_bound, outside_by},
    },
    judge::Verdict,
    loading::SceneFile,
};

use super::{
    FORMAT, FORMAT_METADATA, Form, METADATA, SCENE_ATTACHMENT, Sink, Stream, bag, definitions, messages::Level,
};

/// A recording under construction, in a file beside the run's folder until [`Recording::finish`].
pub type Recording = Stream<McapFile>;

/// An MCAP file that is being written.
pub struct McapFile {
    writer: Option<Writer<BufWriter<File>>>,
    path: PathBuf,
    channels: BTreeMap<&'static str, Channel>,
    /// The first error of writing; after it nothing more is written.
    failed: Option<McapError>,
    last_ns: u64,
}

struct Channel {
    id: u16,
    /// Message type, as `package/msg/Type`.
    kind: String,
    n_messages: u32,
}

impl Recording {
    /// Begins the recording of a run whose files will be written into a folder below `out`.
    pub fn begin(out: &Path, file: &SceneFile, seed: u64, form: Form) -> Result<Recording, RecordError> {
        let target = folder(out, &file.name, seed);
        let beside = target.parent().unwrap_or(out);
        naming("create the folder", beside, fs::create_dir_all(beside))?;
        // A run may be recorded in both forms at once.
        let path = beside.join(format!(".{seed}-{}-{form:?}.mcap.partial", process::id()));
        let stream = naming("create", &path, File::create(&path))?;
        let options = WriteOptions::new()
            .profile("ros2")
            .library(concat!("wherein ", env!("CARGO_PKG_VERSION")))
            .compression(Some(Compression::Lz4));
        let writer = naming("write", &path, options.create(BufWriter::new(stream)).map_err(io::Error::other))?;
        let mut begun = McapFile { writer: Some(writer), path, channels: BTreeMap::new(), failed: None, last_ns: 0 };
        let format = BTreeMap::from([("format".to_owned(), FORMAT.to_owned())]);
        let metadata = Metadata { name: FORMAT_METADATA.to_owned(), metadata: format };
        begun.attempt(|writer| writer.write_metadata(&metadata));
        begun.attempt(|writer| {
            writer.attach(&Attachment {
                log_time: 0,
                create_time: 0,
                name: SCENE_ATTACHMENT.to_owned(),
                media_type: "application/toml".to_owned(),
                data: file.text.as_bytes().into(),
            })
        });
        Ok(Stream::new(begun, form, &file.scene))
    }

    /// Adds the judge's verdict on the run, closes the recording's file and moves it into the run's folder `run`.
    pub fn finish(mut self, summary: &Summary<'_>, run: &Path) -> Result<(), RecordError> {
        self.judge(summary.verdict);
        let entries = [
            ("scene", summary.scene.to_owned()),
            ("seed", summary.seed.to_string()),
            ("subject", summary.subject.to_owned()),
            ("version", summary.version.to_owned()),
            ("adapter", summary.adapter.unwrap_or_default().to_owned()),
            ("digest.scene", summary.digest.scene.clone()),
            ("digest.readings", summary.digest.readings.clone()),
            ("digest.estimates", summary.digest.estimates.clone()),
        ];
        let metadata = entries.map(|(name, value)| (name.to_owned(), value)).into();
        self.sink.attempt(|writer| writer.write_metadata(&Metadata { name: METADATA.to_owned(), metadata }));
        self.sink.attempt(|writer| writer.finish().map(|_| ()));
        if let Some(error) = self.sink.failed.take() {
            return naming("write", &self.sink.path, Err(io::Error::other(error)));
        }
        // The bytes that the file's write buffer still holds are written here, where an error can be reported.
        let flushed = self
            .sink
            .writer
            .take()
            .map_or(Ok(()), |writer| writer.into_inner().into_inner().map(|_| ()).map_err(io::Error::from));
        naming("write", &self.sink.path, flushed)?;
        let target = run.join(self.form.path());
        if let (Form::Ros2, Some(folder)) = (self.form, target.parent()) {
            naming("create the folder", folder, fs::create_dir_all(folder))?;
            let description = folder.join("metadata.yaml");
            naming("write", &description, fs::write(&description, self.metadata_yaml()))?;
        }
        naming("create", &target, fs::rename(&self.sink.path, &target))
    }

    fn metadata_yaml(&self) -> String {
        let channels = self.sink.channels.iter();
        let topics: Vec<bag::Topic<'_>> = channels
            .map(|(name, channel)| bag::Topic { name, kind: &channel.kind, n_messages: channel.n_messages })
            .collect();
        let file_name = self.form.path().rsplit('/').next().unwrap_or_default();
        bag::metadata_yaml(file_name, &topics, self.sink.last_ns)
    }

    /// Writes the judge's verdict as log messages: bounds that were exceeded, and where the truth was first outside the boxes. The messages stand at
    /// the end of the file, each with the time of the event that it reports.
    fn judge(&mut self, verdict: &Verdict) {
        for violation in &verdict.violations {
            let text = format!(
                "{} exceeded from {:.3} s to {:.3} s: {} where {} is declared",
                violation.bound,
                violation.from_s,
                violation.to_s,
                of_bound(&violation.bound, violation.true_value),
                of_bound(&violation.bound, violation.declared)
            );
            self.log(violation.from_s, Level::Warn, "violation", &text);
        }
        if let Some(first) = verdict.containment.as_ref().and_then(|containment| containment.first_failure.as_ref()) {
            let text = format!("the truth is outside, {}: {}", outside_by(first.axis, first.margin), first.blame);
            self.log(first.time_s, Level::Error, "blame", &text);
        }
        for failed in &verdict.verdict.failed {
            self.log(self.sink.last_ns as f64 * 1e-9, Level::Error, "verdict", failed);
        }
    }
}

impl Sink for McapFile {
    /// Writes a message; before the first message of a topic the topic is announced with its message definition.
    fn put(&mut self, topic: &'static str, kind: &str, time_ns: u64, message: &[u8]) {
        if !self.channels.contains_key(topic) {
            let definition = definitions::definition(kind);
            let name = kind.replace('/', "/msg/");
            let qos = bag::offered_qos_profiles(topic).to_owned();
            let metadata = BTreeMap::from([("offered_qos_profiles".to_owned(), qos)]);
            let mut id = 0;
            self.attempt(|writer| {
                let schema = writer.add_schema(&name, "ros2msg", definition.as_bytes())?;
                id = writer.add_channel(schema, topic, "cdr", &metadata)?;
                Ok(())
            });
            self.channels.insert(topic, Channel { id, kind: name, n_messages: 0 });
        }
        let Some(channel) = self.channels.get_mut(topic) else { return };
        channel.n_messages += 1;
        self.last_ns = self.last_ns.max(time_ns);
        let header = MessageHeader {
            channel_id: channel.id,
            sequence: channel.n_messages,
            log_time: time_ns,
            publish_time: time_ns,
        };
        self.attempt(|writer| writer.write_to_known_channel(&header, message));
    }
}

impl McapFile {
    fn attempt(&mut self, write: impl FnOnce(&mut Writer<BufWriter<File>>) -> Result<(), McapError>) {
        if let (Some(writer), None) = (&mut self.writer, &self.failed) {
            self.failed = write(writer).err();
        }
    }
}

impl Drop for McapFile {
    fn drop(&mut self) {
        // The file of a finished recording has been moved to the run's folder already. The partial file that a failed run leaves is of no use.
        let _ = fs::remove_file(&self.path);
    }
}

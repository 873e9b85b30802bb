//! A live stream of messages to viewers: Foxglove, its open fork Lichtblick, or any other program that speaks Foxglove's WebSocket protocol.

use std::{
    borrow::Cow,
    collections::BTreeMap,
    net::SocketAddr,
    sync::Arc,
    thread,
    time::{Duration, Instant},
};

use foxglove::{
    ChannelBuilder, Context, FoxgloveError, PartialMetadata, RawChannel, Schema, WebSocketServer,
    WebSocketServerHandle, websocket::Capability,
};
use thiserror::Error;

use crate::scene::Scene;

use super::{Form, Sink, Stream, definitions};

/// A run that is streamed live to viewers.
pub type Live<'s> = Stream<Broadcast<'s>>;

/// Reason why viewers cannot connect. The error's text is phrased to follow "failed to".
#[derive(Debug, Error)]
#[error("listen at {address} for viewers: {source}")]
pub struct LiveError {
    /// Address at which the server tried to listen.
    pub address: SocketAddr,
    /// Error that the server reported.
    pub source: FoxgloveError,
}

/// A server to which viewers connect. It serves any number of runs, one after another.
pub struct LiveServer {
    handle: WebSocketServerHandle,
    context: Arc<Context>,
    address: SocketAddr,
}

impl LiveServer {
    /// Listens for viewers at a network address; with port 0 the system chooses the port.
    pub fn start(address: SocketAddr) -> Result<LiveServer, LiveError> {
        let context = Context::new();
        let server = WebSocketServer::new()
            .name("wherein")
            .bind(address.ip().to_string(), address.port())
            .capabilities([Capability::Time])
            // The backlog of messages that wait for a viewer is large enough that a viewer that is slow for some seconds misses nothing.
            .message_backlog_size(8192)
            .context(&context);
        let handle = server.start_blocking().map_err(|source| LiveError { address, source })?;
        let address = SocketAddr::new(address.ip(), handle.port());
        Ok(LiveServer { handle, context, address })
    }

    /// Address at which the server listens.
    pub fn address(&self) -> SocketAddr {
        self.address
    }

    /// Waits until at least one viewer is connected.
    pub fn await_viewer(&self) {
        while self.handle.client_count() == 0 {
            thread::sleep(Duration::from_millis(50));
        }
    }

    /// Begins the stream of a run, which proceeds in real time, or slower where the simulation is slower.
    pub fn begin(&self, scene: &Scene) -> Live<'_> {
        // The times of a run begin at 0 again, so that viewers have to start a new session.
        self.handle.clear_session(None);
        let broadcast = Broadcast {
            server: self,
            channels: BTreeMap::new(),
            mounts: Vec::new(),
            began: Instant::now(),
            last_ns: 0,
        };
        Stream::new(broadcast, Form::Foxglove, scene)
    }
}

/// Sends the messages of one run to all connected viewers.
pub struct Broadcast<'s> {
    server: &'s LiveServer,
    channels: BTreeMap<&'static str, Arc<RawChannel>>,
    /// Message with the cameras' mounts. It is sent again every second, because a viewer that connects late has missed it.
    mounts: Vec<u8>,
    began: Instant,
    last_ns: u64,
}

/// The topic of the cameras' mounts and its message type.
const MOUNTS: (&str, &str) = ("/tf_static", "tf2_msgs/TFMessage");
const SECOND_NS: u64 = 1_000_000_000;

impl Sink for Broadcast<'_> {
    fn put(&mut self, topic: &'static str, kind: &str, time_ns: u64, message: &[u8]) {
        // Messages that are exact to the last bit are for replays only; viewers get the same content in standard messages.
        if topic.starts_with("/wherein/") {
            return;
        }
        if topic == MOUNTS.0 {
            self.mounts = message.to_vec();
        }
        self.keep_time(time_ns);
        self.send(topic, kind, time_ns, message);
    }
}

impl Broadcast<'_> {
    /// Waits until as much real time has passed as simulated time.
    fn keep_time(&mut self, time_ns: u64) {
        if time_ns <= self.last_ns {
            return;
        }
        let ahead = Duration::from_nanos(time_ns).saturating_sub(self.began.elapsed());
        thread::sleep(ahead);
        self.server.handle.broadcast_time(time_ns);
        if time_ns / SECOND_NS > self.last_ns / SECOND_NS && !self.mounts.is_empty() {
            let mounts = self.mounts.clone();
            self.send(MOUNTS.0, MOUNTS.1, time_ns, &mounts);
        }
        self.last_ns = time_ns;
    }

    /// Sends a message; before the first message of a topic the topic is announced with its message definition.
    fn send(&mut self, topic: &'static str, kind: &str, time_ns: u64, message: &[u8]) {
        let context = &self.server.context;
        let channel = self.channels.entry(topic).or_insert_with(|| announced(context, topic, kind));
        channel.log_with_meta(message, PartialMetadata::with_log_time(time_ns));
    }
}

impl Drop for Broadcast<'_> {
    fn drop(&mut self) {
        self.channels.values().for_each(|channel| channel.close());
    }
}

fn announced(context: &Arc<Context>, topic: &str, kind: &str) -> Arc<RawChannel> {
    let definition = definitions::definition(kind).into_bytes();
    let schema =
        Schema { name: kind.replace('/', "/msg/"), encoding: "ros2msg".to_owned(), data: Cow::Owned(definition) };
    let channel = ChannelBuilder::new(topic).schema(schema).message_encoding("cdr").context(context);
    // A channel cannot be built only where no encoding is stated, and here one is.
    channel.build_raw().unwrap_or_else(|_| unreachable!("the encoding is stated"))
}

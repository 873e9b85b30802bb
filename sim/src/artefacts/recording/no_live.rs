//! In place of the live stream in a program that is built without the feature `live`: there is never a server.

use crate::scene::Scene;

use super::{Sink, Stream};

/// A run that is streamed live to viewers.
pub type Live = Stream<Broadcast>;

/// A server to which viewers connect. This program can start none.
pub enum LiveServer {}

impl LiveServer {
    /// Begins the stream of a run.
    pub fn begin(&self, _: &Scene) -> Live {
        match *self {}
    }
}

/// Sends the messages of one run to all connected viewers.
pub enum Broadcast {}

impl Sink for Broadcast {
    fn put(&mut self, _: &'static str, _: &str, _: u64, _: &[u8]) {
        match *self {}
    }
}

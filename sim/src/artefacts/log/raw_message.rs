//! What the files of a log hold, whatever their kind: messages, and damage where messages were.

/// A message as it stands in a log.
#[derive(Clone, Copy, Debug)]
pub(super) struct RawMessage<'a> {
    pub(super) topic: &'a str,
    /// Type of the message, as `package/Type`.
    pub(super) kind: &'a str,
    /// Encoding of the message, such as `cdr`.
    pub(super) encoding: &'a str,
    /// Time at which the message was logged, in nanoseconds.
    pub(super) logged_ns: i64,
    pub(super) data: &'a [u8],
}

/// Takes a message of a log. Returns whether the log is to be read further.
pub(super) type See<'a> = dyn FnMut(RawMessage<'_>) -> bool + 'a;

/// Damage of a log that makes some of its messages unreadable.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Damage {
    /// What is wrong, and which messages are lost.
    pub(super) what: String,
    /// The topic and the time of logging of the last message before it.
    pub(super) after: Option<(String, i64)>,
}

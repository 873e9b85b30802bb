//! CDR, the encoding of ROS 2 messages: little-endian, each number aligned to its own size.
//!
//! Source: OMG Common Data Representation as DDS-XTypes 1.3, 7.4.1 uses it (XCDR version 1).

/// Encapsulation header: plain CDR, little-endian, no options. Alignment counts from behind it.
const HEADER: [u8; 4] = [0, 1, 0, 0];

/// A message in the making; fields are added in the order of the definition.
pub(super) struct Message(Vec<u8>);

impl Message {
    pub(super) fn new() -> Message {
        Message(HEADER.to_vec())
    }

    pub(super) fn u8(self, value: u8) -> Message {
        self.number([value])
    }

    pub(super) fn bool(self, value: bool) -> Message {
        self.number([u8::from(value)])
    }

    pub(super) fn u32(self, value: u32) -> Message {
        self.number(value.to_le_bytes())
    }

    pub(super) fn i32(self, value: i32) -> Message {
        self.number(value.to_le_bytes())
    }

    pub(super) fn i64(self, value: i64) -> Message {
        self.number(value.to_le_bytes())
    }

    pub(super) fn f32(self, value: f32) -> Message {
        self.number(value.to_le_bytes())
    }

    /// Numbers without a length: fields one after another, or an array of fixed length.
    pub(super) fn f64s(self, values: &[f64]) -> Message {
        values.iter().fold(self, |message, value| message.number(value.to_le_bytes()))
    }

    /// The length that precedes the items of a sequence.
    pub(super) fn length(self, n_items: usize) -> Message {
        self.u32(u32::try_from(n_items).unwrap_or(u32::MAX))
    }

    pub(super) fn f64_sequence(self, values: &[f64]) -> Message {
        self.length(values.len()).f64s(values)
    }

    pub(super) fn bytes(mut self, values: &[u8]) -> Message {
        self = self.length(values.len());
        self.0.extend_from_slice(values);
        self
    }

    /// Text with the zero behind it that CDR counts in.
    pub(super) fn text(mut self, text: &str) -> Message {
        self = self.length(text.len() + 1);
        self.0.extend_from_slice(text.as_bytes());
        self.0.push(0);
        self
    }

    /// `builtin_interfaces/Time` of seconds.
    pub(super) fn time(self, time_s: f64) -> Message {
        let nanoseconds = nanoseconds(time_s);
        self.i32(nanoseconds.div_euclid(1_000_000_000) as i32).u32(nanoseconds.rem_euclid(1_000_000_000) as u32)
    }

    /// `std_msgs/Header`.
    pub(super) fn header(self, time_s: f64, frame: &str) -> Message {
        self.time(time_s).text(frame)
    }

    /// Adds fields that a function knows how to add.
    pub(super) fn with(self, fields: impl FnOnce(Message) -> Message) -> Message {
        fields(self)
    }

    pub(super) fn finish(self) -> Vec<u8> {
        self.0
    }

    fn number<const SIZE: usize>(mut self, bytes: [u8; SIZE]) -> Message {
        let end = HEADER.len() + (self.0.len() - HEADER.len()).next_multiple_of(SIZE);
        self.0.resize(end, 0);
        self.0.extend_from_slice(&bytes);
        self
    }
}

/// The nearest nanosecond.
pub(super) fn nanoseconds(time_s: f64) -> i64 {
    (time_s * 1e9).round() as i64
}

/// The fields of a message, taken in the order of the definition. Every function answers `None` when the bytes are used up.
pub(crate) struct Fields<'a> {
    bytes: &'a [u8],
    at: usize,
}

impl<'a> Fields<'a> {
    /// The fields of a whole message; `None` without the header that [`Message`] writes.
    pub(crate) fn of(message: &'a [u8]) -> Option<Fields<'a>> {
        message.strip_prefix(&HEADER).map(|bytes| Fields { bytes, at: 0 })
    }

    pub(crate) fn bool(&mut self) -> Option<bool> {
        self.number::<1>().map(|[byte]| byte != 0)
    }

    pub(crate) fn u8(&mut self) -> Option<u8> {
        self.number::<1>().map(|[byte]| byte)
    }

    pub(crate) fn u32(&mut self) -> Option<u32> {
        self.number().map(u32::from_le_bytes)
    }

    pub(crate) fn i64(&mut self) -> Option<i64> {
        self.number().map(i64::from_le_bytes)
    }

    pub(crate) fn f64(&mut self) -> Option<f64> {
        self.number().map(f64::from_le_bytes)
    }

    pub(crate) fn sequence<T>(&mut self, item: impl Fn(&mut Self) -> Option<T>) -> Option<Vec<T>> {
        let n_items = self.u32()?;
        (0..n_items).map(|_| item(self)).collect()
    }

    pub(crate) fn bytes(&mut self) -> Option<&'a [u8]> {
        let length = self.u32()? as usize;
        let bytes = self.bytes.get(self.at..self.at.checked_add(length)?)?;
        self.at += length;
        Some(bytes)
    }

    pub(crate) fn text(&mut self) -> Option<&'a str> {
        std::str::from_utf8(self.bytes()?.strip_suffix(&[0])?).ok()
    }

    fn number<const SIZE: usize>(&mut self) -> Option<[u8; SIZE]> {
        let from = self.at.next_multiple_of(SIZE);
        let bytes = self.bytes.get(from..from + SIZE)?;
        self.at = from + SIZE;
        bytes.try_into().ok()
    }
}

//! CDR, the encoding of ROS 2 messages: little-endian, with each number aligned to its own size.
//!
//! Source: OMG Common Data Representation as DDS-XTypes 1.3, 7.4.1 uses it (XCDR version 1).

/// Encapsulation header of a message: plain CDR, little-endian, no options. Alignment is counted from the first byte after the header.
const HEADER: [u8; 4] = [0, 1, 0, 0];

/// A message under construction; fields are added in the order of the message's definition.
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

    /// Adds numbers without a preceding length: several fields in a row, or an array of fixed length.
    pub(super) fn f64s(self, values: &[f64]) -> Message {
        values.iter().fold(self, |message, value| message.number(value.to_le_bytes()))
    }

    /// Adds the length that precedes the items of a sequence.
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

    /// Adds text with a terminating zero byte, which CDR counts in the text's length.
    pub(super) fn text(mut self, text: &str) -> Message {
        self = self.length(text.len() + 1);
        self.0.extend_from_slice(text.as_bytes());
        self.0.push(0);
        self
    }

    /// Adds a time in seconds as `builtin_interfaces/Time`.
    pub(super) fn time(self, time_s: f64) -> Message {
        let nanoseconds = nanoseconds(time_s);
        self.i32(nanoseconds.div_euclid(1_000_000_000) as i32).u32(nanoseconds.rem_euclid(1_000_000_000) as u32)
    }

    /// Adds a `std_msgs/Header`.
    pub(super) fn header(self, time_s: f64, frame: &str) -> Message {
        self.time(time_s).text(frame)
    }

    /// Adds a group of fields, such as a nested message, which the function `fields` writes.
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

/// Time in nanoseconds, rounded to the nearest one.
pub(super) fn nanoseconds(time_s: f64) -> i64 {
    (time_s * 1e9).round() as i64
}

/// Reader of a message's fields, which are taken in the order of the message's definition. Every function of the reader returns `None` when
/// the bytes are used up.
pub(crate) struct Fields<'a> {
    bytes: &'a [u8],
    at: usize,
    /// Whether the most significant byte of a number comes first.
    is_big_endian: bool,
}

impl<'a> Fields<'a> {
    /// Starts reading a whole message; `None` when it does not begin with the header that [`Message`] writes.
    pub(crate) fn of(message: &'a [u8]) -> Option<Fields<'a>> {
        message.strip_prefix(&HEADER).map(|bytes| Fields { bytes, at: 0, is_big_endian: false })
    }

    /// Starts reading a whole message that another program wrote; `None` when it is not in plain CDR. Either order of bytes is read, and the options
    /// in the header, in which newer writers state how many bytes they added at the end, are skipped.
    pub(crate) fn of_others(message: &'a [u8]) -> Option<Fields<'a>> {
        let (&[0, order @ (0 | 1), _, _], bytes) = message.split_first_chunk()? else { return None };
        Some(Fields { bytes, at: 0, is_big_endian: order == 0 })
    }

    pub(crate) fn bool(&mut self) -> Option<bool> {
        self.number::<1>().map(|[byte]| byte != 0)
    }

    pub(crate) fn u8(&mut self) -> Option<u8> {
        self.number::<1>().map(|[byte]| byte)
    }

    pub(crate) fn u16(&mut self) -> Option<u16> {
        self.number().map(u16::from_le_bytes)
    }

    pub(crate) fn i32(&mut self) -> Option<i32> {
        self.number().map(i32::from_le_bytes)
    }

    pub(crate) fn u32(&mut self) -> Option<u32> {
        self.number().map(u32::from_le_bytes)
    }

    pub(crate) fn i64(&mut self) -> Option<i64> {
        self.number().map(i64::from_le_bytes)
    }

    pub(crate) fn f32(&mut self) -> Option<f32> {
        self.number().map(f32::from_le_bytes)
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

    /// Text, whose terminating zero byte some writers leave out where the text is empty.
    pub(crate) fn text(&mut self) -> Option<&'a str> {
        let bytes = self.bytes()?;
        std::str::from_utf8(if bytes.is_empty() { bytes } else { bytes.strip_suffix(&[0])? }).ok()
    }

    /// Numbers without a preceding length: several fields in a row, or an array of fixed length.
    pub(crate) fn f64s<const COUNT: usize>(&mut self) -> Option<[f64; COUNT]> {
        let mut numbers = [0.0; COUNT];
        for number in &mut numbers {
            *number = self.f64()?;
        }
        Some(numbers)
    }

    fn number<const SIZE: usize>(&mut self) -> Option<[u8; SIZE]> {
        let from = self.at.next_multiple_of(SIZE);
        let bytes = self.bytes.get(from..from + SIZE)?;
        self.at = from + SIZE;
        let mut bytes: [u8; SIZE] = bytes.try_into().ok()?;
        if self.is_big_endian {
            bytes.reverse();
        }
        Some(bytes)
    }
}

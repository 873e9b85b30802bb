//! Reads the tables of an SQLite database file, without SQL and without writing: what a bag of ROS 2 needs, whose messages are the rows of one table.
//!
//! Source: the database file format, version 3, as <https://www.sqlite.org/fileformat2.html> describes it. A table is a B-tree of pages; a leaf
//! holds rows, each a record of columns, and what does not fit into the leaf continues on overflow pages. Every number that the file states is
//! checked against what is left of its page and of the file, so that a damaged file gives an error.

use std::{
    collections::{BTreeMap, BTreeSet},
    io::{self, Read, Seek, SeekFrom},
};

use thiserror::Error;

/// First bytes of every database file.
pub(super) const MAGIC: &[u8; 16] = b"SQLite format 3\0";
/// Bytes of the file's header, which stands before the first page's own header.
const FILE_HEADER_BYTES: usize = 100;
/// Greatest number of bytes of a row. SQLite's own default limit is 10⁹ bytes.
const GREATEST_ROW_BYTES: u64 = 1 << 30;
/// Greatest depth of a B-tree. Every inner page has at least two children, so that a deeper tree has more pages than a file can hold.
const GREATEST_DEPTH: usize = 40;

/// Reason why a database cannot be read. The error's text says what is wrong with the file.
#[derive(Debug, Error)]
pub(super) enum SqliteError {
    /// The file cannot be read.
    #[error("{0}")]
    Io(#[from] io::Error),
    /// The file has another content than the format demands.
    #[error("the SQLite database is damaged: {0}")]
    Damaged(&'static str),
    /// The database uses something that no bag uses.
    #[error("the SQLite database has {0}, which is not read")]
    Unsupported(&'static str),
    /// The database has no such table.
    #[error("the SQLite database has no table `{0}`")]
    NoTable(String),
}

/// A value in a row.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Value {
    Null,
    Integer(i64),
    Real(f64),
    Text(Vec<u8>),
    Blob(Vec<u8>),
}

/// A table: where its rows are, and the names of its columns.
#[derive(Clone, Debug)]
struct Table {
    root: u32,
    columns: Vec<String>,
    /// Column that stands for the number of the row and is stored as nothing.
    row_number_column: Option<usize>,
}

/// Bytes that can be read from any place on.
pub(super) trait Seekable: Read + Seek {}

impl<T: Read + Seek> Seekable for T {}

/// Takes the number and the values of a row.
type SeeRow<'a, E> = dyn FnMut(i64, &[Value]) -> Result<(), E> + 'a;

/// An open database.
pub(super) struct Database {
    file: Box<dyn Seekable>,
    page_bytes: usize,
    /// Bytes of each page that rows may use.
    usable_bytes: usize,
    n_pages: u32,
    tables: BTreeMap<String, Table>,
}

impl Database {
    /// Opens a database and reads the list of its tables.
    pub(super) fn open(mut file: Box<dyn Seekable>) -> Result<Database, SqliteError> {
        let mut header = [0; FILE_HEADER_BYTES];
        file.read_exact(&mut header).map_err(|_| SqliteError::Damaged("it is shorter than its header"))?;
        if !header.starts_with(MAGIC) {
            return Err(SqliteError::Damaged("it does not begin as one"));
        }
        let page_bytes = match u16::from_be_bytes([header[16], header[17]]) {
            1 => 65_536,
            bytes if bytes.is_power_of_two() && bytes >= 512 => usize::from(bytes),
            _ => return Err(SqliteError::Damaged("the size of its pages is no power of two from 512 to 65536")),
        };
        if u32::from_be_bytes([header[56], header[57], header[58], header[59]]) > 1 {
            return Err(SqliteError::Unsupported("texts in UTF-16"));
        }
        let usable_bytes = page_bytes.checked_sub(usize::from(header[20])).filter(|usable| *usable >= 480);
        let usable_bytes = usable_bytes.ok_or(SqliteError::Damaged("too much of its pages is reserved"))?;
        let n_pages = u32::try_from(file.seek(SeekFrom::End(0))? / page_bytes as u64).unwrap_or(u32::MAX);
        let mut database = Database { file, page_bytes, usable_bytes, n_pages, tables: BTreeMap::new() };
        let list = Table { root: 1, columns: Vec::new(), row_number_column: None };
        let mut tables = BTreeMap::new();
        database.rows_of(&list, &mut |_, row| {
            if let [Value::Text(kind), Value::Text(name), _, Value::Integer(root), Value::Text(sql), ..] = row
                && kind == b"table"
                && let Ok(root) = u32::try_from(*root)
            {
                let (columns, row_number_column) = columns_of(&String::from_utf8_lossy(sql));
                let name = String::from_utf8_lossy(name).into_owned();
                tables.insert(name, Table { root, columns, row_number_column });
            }
            Ok::<(), SqliteError>(())
        })?;
        database.tables = tables;
        Ok(database)
    }

    /// Hands the named columns of every row of a table to `see`, in the order of the rows' numbers. A column that the table does not have, and one
    /// that was added after the row was written, is null.
    pub(super) fn rows<E: From<SqliteError>>(
        &mut self,
        table: &str,
        columns: &[&str],
        see: &mut dyn FnMut(&[Value]) -> Result<(), E>,
    ) -> Result<(), E> {
        let table = self.tables.get(table).cloned().ok_or_else(|| SqliteError::NoTable(table.to_owned()))?;
        let places: Vec<Option<usize>> =
            columns.iter().map(|name| table.columns.iter().position(|column| column == name)).collect();
        self.rows_of(&table, &mut |number, row| {
            let wanted: Vec<Value> = places
                .iter()
                .map(|place| match place {
                    Some(place) if Some(*place) == table.row_number_column => Value::Integer(number),
                    Some(place) => row.get(*place).cloned().unwrap_or(Value::Null),
                    None => Value::Null,
                })
                .collect();
            see(&wanted)
        })
    }

    fn rows_of<E: From<SqliteError>>(&mut self, table: &Table, see: &mut SeeRow<'_, E>) -> Result<(), E> {
        self.walk(table.root, 0, &mut BTreeSet::new(), see)
    }

    /// Walks through the rows below a page, from left to right.
    fn walk<E: From<SqliteError>>(
        &mut self,
        page_number: u32,
        depth: usize,
        seen: &mut BTreeSet<u32>,
        see: &mut SeeRow<'_, E>,
    ) -> Result<(), E> {
        if depth > GREATEST_DEPTH || !seen.insert(page_number) {
            return Err(SqliteError::Damaged("its pages lead back to themselves").into());
        }
        let page = self.page(page_number)?;
        let begin = if page_number == 1 { FILE_HEADER_BYTES } else { 0 };
        let is_leaf = match page.get(begin) {
            Some(13) => true,
            Some(5) => false,
            _ => return Err(SqliteError::Damaged("a page of a table is no page of a table").into()),
        };
        let n_cells = usize::from(u16_at(&page, begin + 3)?);
        let pointers = begin + if is_leaf { 8 } else { 12 };
        for cell in 0..n_cells {
            let at = usize::from(u16_at(&page, pointers + 2 * cell)?);
            if is_leaf {
                let (number, payload) = self.cell(&page, at)?;
                see(number, &record(&payload)?)?;
            } else {
                self.walk(u32_at(&page, at)?, depth + 1, seen, see)?;
            }
        }
        if is_leaf { Ok(()) } else { self.walk(u32_at(&page, begin + 8)?, depth + 1, seen, see) }
    }

    /// The number of a row and all bytes of its record, from the leaf's cell and the overflow pages.
    fn cell(&mut self, page: &[u8], at: usize) -> Result<(i64, Vec<u8>), SqliteError> {
        let mut at = at;
        let n_bytes = varint(page, &mut at)? as u64;
        let number = varint(page, &mut at)?;
        if n_bytes > GREATEST_ROW_BYTES || n_bytes > u64::from(self.n_pages) * self.page_bytes as u64 {
            return Err(SqliteError::Damaged("a row is longer than the file"));
        }
        let (n_bytes, usable) = (n_bytes as usize, self.usable_bytes);
        // Section 1.6 of the format: how much of a row stays in its leaf.
        let most = usable - 35;
        let local = if n_bytes <= most {
            n_bytes
        } else {
            let least = (usable - 12) * 32 / 255 - 23;
            let fitting = least + (n_bytes - least) % (usable - 4);
            if fitting <= most { fitting } else { least }
        };
        let mut payload = slice(page, at, local)?.to_vec();
        let mut next = if local < n_bytes { u32_at(page, at + local)? } else { 0 };
        while payload.len() < n_bytes {
            let overflow = self.page(next)?;
            let part = (n_bytes - payload.len()).min(usable - 4);
            payload.extend_from_slice(slice(&overflow, 4, part)?);
            next = u32_at(&overflow, 0)?;
        }
        Ok((number, payload))
    }

    fn page(&mut self, number: u32) -> Result<Vec<u8>, SqliteError> {
        if number == 0 || number > self.n_pages {
            return Err(SqliteError::Damaged("it refers to a page beyond its end, as where it is cut short"));
        }
        self.file.seek(SeekFrom::Start(u64::from(number - 1) * self.page_bytes as u64))?;
        let mut page = vec![0; self.page_bytes];
        self.file.read_exact(&mut page)?;
        Ok(page)
    }
}

/// The columns that a statement `CREATE TABLE name (column type …, …)` names, and which of them stands for the number of the row.
fn columns_of(sql: &str) -> (Vec<String>, Option<usize>) {
    let inside = sql.split_once('(').map_or("", |(_, inside)| inside);
    let (mut depth, mut definitions) = (0, vec![String::new()]);
    for letter in inside.chars() {
        match letter {
            '(' => depth += 1,
            ')' if depth == 0 => break,
            ')' => depth -= 1,
            ',' if depth == 0 => definitions.push(String::new()),
            _ => {}
        }
        if let Some(last) = definitions.last_mut().filter(|_| letter != ',' || depth > 0) {
            last.push(letter);
        }
    }
    let is_constraint = |definition: &str| {
        let words = ["PRIMARY", "UNIQUE", "CHECK", "FOREIGN", "CONSTRAINT"];
        definition.split_whitespace().next().is_none_or(|word| words.contains(&word.to_uppercase().as_str()))
    };
    let columns: Vec<String> = definitions.into_iter().filter(|definition| !is_constraint(definition)).collect();
    let is_row_number = |definition: &String| definition.to_uppercase().contains("INTEGER PRIMARY KEY");
    let row_number_column = columns.iter().position(is_row_number);
    let name = |definition: &String| {
        let word = definition.split_whitespace().next().unwrap_or_default();
        word.trim_matches(['"', '`', '[', ']', '\'']).to_owned()
    };
    (columns.iter().map(name).collect(), row_number_column)
}

/// The values of a record.
fn record(payload: &[u8]) -> Result<Vec<Value>, SqliteError> {
    let mut at = 0;
    let header_bytes = usize::try_from(varint(payload, &mut at)?).unwrap_or(usize::MAX);
    if header_bytes > payload.len() {
        return Err(SqliteError::Damaged("the header of a row is longer than the row"));
    }
    let (mut values, mut body) = (Vec::new(), header_bytes);
    while at < header_bytes {
        let kind = varint(payload, &mut at)? as u64;
        let n_bytes = match kind {
            0 | 8 | 9 => 0,
            1..=4 => kind as usize,
            5 => 6,
            6 | 7 => 8,
            10 | 11 => return Err(SqliteError::Damaged("a column has a reserved type")),
            _ => usize::try_from((kind - 12) / 2).unwrap_or(usize::MAX),
        };
        let bytes = slice(payload, body, n_bytes)?;
        body += n_bytes;
        values.push(match kind {
            0 => Value::Null,
            8 => Value::Integer(0),
            9 => Value::Integer(1),
            7 => Value::Real(f64::from_bits(big_endian(bytes) as u64)),
            1..=6 => Value::Integer(big_endian(bytes)),
            _ if kind.is_multiple_of(2) => Value::Blob(bytes.to_vec()),
            _ => Value::Text(bytes.to_vec()),
        });
    }
    Ok(values)
}

/// A signed number of up to eight bytes, the most significant first.
fn big_endian(bytes: &[u8]) -> i64 {
    let first = bytes.first().map_or(0, |byte| if *byte >= 0x80 { -1 } else { 0 });
    bytes.iter().fold(first, |number: i64, byte| (number << 8) | i64::from(*byte))
}

/// A number of one to nine bytes: seven bits from each of the first eight, and all eight bits of a ninth.
fn varint(bytes: &[u8], at: &mut usize) -> Result<i64, SqliteError> {
    let mut number = 0_u64;
    for index in 0..9 {
        let byte = *bytes.get(*at).ok_or(SqliteError::Damaged("a number reaches beyond its page"))?;
        *at += 1;
        if index == 8 {
            return Ok(((number << 8) | u64::from(byte)) as i64);
        }
        number = (number << 7) | u64::from(byte & 0x7f);
        if byte < 0x80 {
            break;
        }
    }
    Ok(number as i64)
}

fn slice(bytes: &[u8], at: usize, n_bytes: usize) -> Result<&[u8], SqliteError> {
    let end = at.checked_add(n_bytes);
    end.and_then(|end| bytes.get(at..end)).ok_or(SqliteError::Damaged("a row reaches beyond its page"))
}

fn u16_at(bytes: &[u8], at: usize) -> Result<u16, SqliteError> {
    let part = slice(bytes, at, 2)?;
    Ok(u16::from_be_bytes([part[0], part[1]]))
}

fn u32_at(bytes: &[u8], at: usize) -> Result<u32, SqliteError> {
    let part = slice(bytes, at, 4)?;
    Ok(u32::from_be_bytes([part[0], part[1], part[2], part[3]]))
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;

    #[test]
    fn numbers_have_one_to_nine_bytes() {
        // By hand from the format's description: 0x81 0x00 is 1·128 + 0; nine bytes of ones are −1.
        for (bytes, number) in [(vec![0x7f], 127), (vec![0x81, 0x00], 128), (vec![0xff; 9], -1)] {
            let mut at = 0;
            assert_eq!(varint(&bytes, &mut at).unwrap(), number);
            assert_eq!(at, bytes.len());
        }
        assert!(varint(&[0x81], &mut 0).is_err());
    }

    #[test]
    fn the_columns_of_a_bag_are_named() {
        let sql = "CREATE TABLE messages(id INTEGER PRIMARY KEY,topic_id INTEGER NOT NULL,timestamp INTEGER NOT NULL, data BLOB NOT NULL, \
                   FOREIGN KEY(topic_id) REFERENCES topics(id))";
        let (columns, number) = columns_of(sql);
        assert_eq!((columns.join(" ").as_str(), number), ("id topic_id timestamp data", Some(0)));
    }

    #[test]
    fn a_record_is_read_by_the_types_of_its_columns() {
        // Header of 5 bytes: null, one byte, text of 2 bytes (13 + 2·2), blob of 1 byte (12 + 2·1).
        let payload = [5, 0, 1, 17, 14, 0xfe, b'a', b'b', 9];
        let expected = [Value::Null, Value::Integer(-2), Value::Text(b"ab".to_vec()), Value::Blob(vec![9])];
        assert_eq!(record(&payload).unwrap(), expected);
        assert!(record(&payload[..8]).is_err());
    }
}

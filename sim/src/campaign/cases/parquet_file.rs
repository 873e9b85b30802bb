//! Tables of results as Parquet files, a binary format that stores tables by columns. Compiled with the feature `parquet` only.

use std::{fs::File, sync::Arc};

use parquet::{
    basic::{LogicalType, Repetition, Type as Physical},
    column::reader::{ColumnReader, ColumnReaderImpl},
    data_type::{BoolType, ByteArray, ByteArrayType, DataType, DoubleType, Int64Type},
    errors::Result,
    file::{
        properties::WriterProperties,
        reader::{FileReader, SerializedFileReader},
        writer::{SerializedColumnWriter, SerializedFileWriter},
    },
    schema::types::Type,
};

use super::{Cell, Table};

/// Writes a table of results as the bytes of a Parquet file: one row group, every column optional, numbers as doubles.
pub fn to_parquet(table: &Table) -> Result<Vec<u8>> {
    let kinds: Vec<Physical> = (0..table.columns.len()).map(|column| kind(table, column)).collect();
    let fields = table.columns.iter().zip(&kinds).map(|(name, kind)| {
        let text = (*kind == Physical::BYTE_ARRAY).then_some(LogicalType::String);
        let field = Type::primitive_type_builder(name, *kind).with_repetition(Repetition::OPTIONAL);
        field.with_logical_type(text).build().map(Arc::new)
    });
    let schema = Arc::new(Type::group_type_builder("case").with_fields(fields.collect::<Result<_>>()?).build()?);
    let properties = WriterProperties::builder().set_created_by("wherein".to_owned()).build();
    let mut bytes = Vec::new();
    let mut writer = SerializedFileWriter::new(&mut bytes, schema, Arc::new(properties))?;
    let mut group = writer.next_row_group()?;
    let mut column = 0;
    while let Some(mut open) = group.next_column()? {
        let cells = table.rows.iter().map(|row| &row[column]);
        match kinds[column] {
            Physical::DOUBLE => fill::<DoubleType>(&mut open, cells, |cell| match cell {
                Cell::Number(number) => Some(*number),
                _ => None,
            })?,
            Physical::INT64 => fill::<Int64Type>(&mut open, cells, |cell| match cell {
                // The greatest signed integer of Parquet is 2⁶³ − 1; a seed above that is stored with the same bits and reads as a negative number.
                Cell::Whole(number) => Some(*number as i64),
                _ => None,
            })?,
            Physical::BOOLEAN => fill::<BoolType>(&mut open, cells, |cell| match cell {
                Cell::Truth(truth) => Some(*truth),
                _ => None,
            })?,
            _ => fill::<ByteArrayType>(&mut open, cells, |cell| match cell {
                Cell::Empty => None,
                Cell::Text(text) => Some(ByteArray::from(text.as_str())),
                Cell::Number(number) => Some(ByteArray::from(number.to_string().as_str())),
                Cell::Whole(number) => Some(ByteArray::from(number.to_string().as_str())),
                Cell::Truth(truth) => Some(ByteArray::from(truth.to_string().as_str())),
            })?,
        }
        open.close()?;
        column += 1;
    }
    group.close()?;
    writer.close()?;
    Ok(bytes)
}

/// Reads those columns whose names are wanted, and calls `see` for each row group of the file.
pub(super) fn read_pieces(file: File, is_wanted: &dyn Fn(&str) -> bool, see: &mut dyn FnMut(&Table)) -> Result<()> {
    let reader = SerializedFileReader::new(file)?;
    let fields = reader.metadata().file_metadata().schema_descr().columns().iter();
    let wanted: Vec<(usize, String)> =
        fields.map(|field| field.name().to_owned()).enumerate().filter(|(_, name)| is_wanted(name)).collect();
    let columns: Vec<String> = wanted.iter().map(|(_, name)| name.clone()).collect();
    for group in 0..reader.num_row_groups() {
        let group = reader.get_row_group(group)?;
        let n_rows = usize::try_from(group.metadata().num_rows()).unwrap_or_default();
        let mut rows: Vec<Vec<Cell>> = (0..n_rows).map(|_| Vec::with_capacity(columns.len())).collect();
        for (column, _) in &wanted {
            match group.get_column_reader(*column)? {
                ColumnReader::DoubleColumnReader(open) => empty(open, &mut rows, |value| Cell::Number(*value))?,
                ColumnReader::Int64ColumnReader(open) => empty(open, &mut rows, |value| Cell::Whole(*value as u64))?,
                ColumnReader::BoolColumnReader(open) => empty(open, &mut rows, |value| Cell::Truth(*value))?,
                ColumnReader::ByteArrayColumnReader(open) => {
                    empty(open, &mut rows, |value| {
                        value.as_utf8().map_or(Cell::Empty, |text| Cell::Text(text.to_owned()))
                    })?;
                }
                // No column of another type is ever written.
                _ => rows.iter_mut().for_each(|row| row.push(Cell::Empty)),
            }
        }
        see(&Table { columns: columns.clone(), rows });
    }
    Ok(())
}

/// Reads one column to its end, and gives each row its cell.
fn empty<T: DataType>(
    mut column: ColumnReaderImpl<T>,
    rows: &mut [Vec<Cell>],
    cell: impl Fn(&T::T) -> Cell,
) -> Result<()> {
    let (mut values, mut present) = (Vec::new(), Vec::new());
    while present.len() < rows.len() {
        let (n_records, _, _) =
            column.read_records(rows.len() - present.len(), Some(&mut present), None, &mut values)?;
        if n_records == 0 {
            break;
        }
    }
    let mut values = values.iter();
    for (idx, row) in rows.iter_mut().enumerate() {
        let value = present.get(idx).filter(|level| **level > 0).and_then(|_| values.next());
        row.push(value.map_or(Cell::Empty, &cell));
    }
    Ok(())
}

/// Returns the type of a column: the type of its cells, or text when its cells are of several types.
fn kind(table: &Table, column: usize) -> Physical {
    let of = |cell: &Cell| match cell {
        Cell::Empty => None,
        Cell::Text(_) => Some(Physical::BYTE_ARRAY),
        Cell::Number(_) => Some(Physical::DOUBLE),
        Cell::Whole(_) => Some(Physical::INT64),
        Cell::Truth(_) => Some(Physical::BOOLEAN),
    };
    let mut kinds = table.rows.iter().filter_map(|row| of(&row[column]));
    let first = kinds.next().unwrap_or(Physical::BYTE_ARRAY);
    if kinds.all(|kind| kind == first) { first } else { Physical::BYTE_ARRAY }
}

/// Writes one column: its values, and for each row whether it has a value.
fn fill<'a, T: DataType>(
    column: &mut SerializedColumnWriter<'_>,
    cells: impl Iterator<Item = &'a Cell>,
    value: impl Fn(&Cell) -> Option<T::T>,
) -> Result<()> {
    let values: Vec<Option<T::T>> = cells.map(value).collect();
    let present: Vec<i16> = values.iter().map(|value| i16::from(value.is_some())).collect();
    let values: Vec<T::T> = values.into_iter().flatten().collect();
    column.typed::<T>().write_batch(&values, Some(&present), None)?;
    Ok(())
}

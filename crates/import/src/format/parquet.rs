//! Parquet, as pyarrow, pandas and DuckDB write it.

use crate::channel::{Channel, MOST_CHANNELS, Values};
use crate::clock::stamp_text;
use crate::listing;
use crate::refusal::{Refusal, guarded};
use bytes::Bytes;
use parquet::basic::{ConvertedType, LogicalType, TimeUnit};
use parquet::column::reader::{ColumnReader, ColumnReaderImpl};
use parquet::data_type::DataType;
use parquet::errors::ParquetError;
use parquet::file::reader::{FileReader, RowGroupReader, SerializedFileReader};
use parquet::schema::types::ColumnDescriptor;

const FORMAT: &str = "Parquet";
/// Most numbers of a file: 2 GB in memory.
const MOST_NUMBERS: usize = 1 << 28;
/// Most numbers for each byte of a file: as many as fit into what deflate unpacks from it (1032 bytes).
/// Values that repeat take no room at all, but no table holds nothing else.
const MOST_PACKED: usize = 1032 / 8;
/// Rows that are read at a time.
const BATCH: usize = 8192;

/// The columns of a file that hold numbers or dates, by their names; members of a structure by the names of
/// both, with a dot between them. A cell without a value is no number.
pub(super) fn channels(bytes: &[u8]) -> Result<Vec<Channel>, Refusal> {
    guarded(FORMAT, || read(bytes))
}

fn read(bytes: &[u8]) -> Result<Vec<Channel>, Refusal> {
    let file = SerializedFileReader::new(Bytes::copy_from_slice(bytes)).map_err(broken)?;
    let columns = file.metadata().file_metadata().schema_descr().columns();
    let mut kinds = columns.iter().map(|c| Kind::of(c)).enumerate();
    let wanted: Vec<(usize, Kind)> = kinds.by_ref().filter_map(|(k, kind)| Some((k, kind?))).collect();
    if wanted.len() > MOST_CHANNELS {
        return Err(Refusal::file(
            format!("it has {} columns", columns.len()),
            "save the time, the motion and the inputs in a file of their own",
        ));
    }
    let mut left = bytes.len().saturating_mul(MOST_PACKED).min(MOST_NUMBERS);
    let mut all: Vec<Cells> = wanted.iter().map(|(_, kind)| Cells::of(*kind)).collect();
    for group in 0..file.num_row_groups() {
        let group = file.get_row_group(group).map_err(broken)?;
        for ((column, kind), cells) in wanted.iter().zip(&mut all) {
            cells
                .read(&*group, *column, *kind, &mut left)
                .map_err(|e| refused(columns[*column].name(), &e))?;
        }
    }
    let several = all.into_iter().zip(&wanted).filter(|(cells, _)| cells.len() > 1);
    Ok(several.map(|(cells, (column, _))| cells.channel(&columns[*column])).collect())
}

fn broken(error: ParquetError) -> Refusal {
    Refusal::broken(FORMAT, error.to_string())
}

/// A column cannot be read: it is packed in a way that needs a library in C, or broken.
fn refused(column: &str, error: &ParquetError) -> Refusal {
    let (column, words) = (listing::name(column), error.to_string());
    if words.contains("Disabled feature") {
        return Refusal::file(
            format!("the column `{column}` is packed in a way that is not read (zstd, brotli)"),
            "write it with another one: pandas.read_parquet(path).to_parquet(path, compression='snappy')",
        );
    }
    Refusal::broken(FORMAT, format!("the column `{column}`: {words}"))
}

/// What the numbers of a column mean.
#[derive(Clone, Copy, PartialEq)]
enum Kind {
    /// Themselves.
    Plain,
    /// Numbers without sign, of so many bits.
    Unsigned(u32),
    /// A date in so many nanoseconds since 1970.
    Date(i128),
}

impl Kind {
    /// None of what is no column of a record: lists, texts, decimals of many digits.
    fn of(column: &ColumnDescriptor) -> Option<Kind> {
        use parquet::basic::Type;
        if column.max_rep_level() > 0 {
            return None;
        }
        let whole = matches!(column.physical_type(), Type::INT32 | Type::INT64);
        if !whole {
            let number = matches!(column.physical_type(), Type::BOOLEAN | Type::FLOAT | Type::DOUBLE);
            return number.then_some(Kind::Plain);
        }
        match column.logical_type_ref() {
            Some(LogicalType::Timestamp(stamp)) => Some(Kind::Date(nanoseconds(&stamp.unit))),
            Some(LogicalType::Integer(int)) if !int.is_signed => {
                Some(Kind::Unsigned(u32::from(int.bit_width.unsigned_abs())))
            }
            Some(LogicalType::Integer(_)) => Some(Kind::Plain),
            Some(_) => None,
            // As older programs write it.
            None => match column.converted_type() {
                ConvertedType::TIMESTAMP_MILLIS => Some(Kind::Date(1_000_000)),
                ConvertedType::TIMESTAMP_MICROS => Some(Kind::Date(1_000)),
                ConvertedType::UINT_8 | ConvertedType::UINT_16 | ConvertedType::UINT_32 => {
                    Some(Kind::Unsigned(32))
                }
                ConvertedType::UINT_64 => Some(Kind::Unsigned(64)),
                ConvertedType::NONE
                | ConvertedType::INT_8
                | ConvertedType::INT_16
                | ConvertedType::INT_32
                | ConvertedType::INT_64 => Some(Kind::Plain),
                _ => None,
            },
        }
    }

    fn number(self, x: i64) -> f64 {
        match self {
            Kind::Unsigned(64) => x as u64 as f64,
            Kind::Unsigned(_) => f64::from(x as u32),
            _ => x as f64,
        }
    }
}

fn nanoseconds(unit: &TimeUnit) -> i128 {
    match unit {
        TimeUnit::MILLIS => 1_000_000,
        TimeUnit::MICROS => 1_000,
        TimeUnit::NANOS => 1,
    }
}

/// The cells of a column.
enum Cells {
    Numbers(Vec<f64>),
    Dates(Vec<String>),
}

impl Cells {
    fn of(kind: Kind) -> Cells {
        if matches!(kind, Kind::Date(_)) { Cells::Dates(vec![]) } else { Cells::Numbers(vec![]) }
    }

    fn len(&self) -> usize {
        match self {
            Cells::Numbers(x) => x.len(),
            Cells::Dates(x) => x.len(),
        }
    }

    fn channel(self, column: &ColumnDescriptor) -> Channel {
        let (name, path) =
            column.path().parts().split_last().map_or((String::new(), &[][..]), |(n, p)| (n.clone(), p));
        let values = match self {
            Cells::Numbers(x) => Values::Numbers(x),
            Cells::Dates(x) => Values::Words(x),
        };
        Channel { group: path.join("."), name, unit: None, values, clock: None }
    }

    /// Adds the cells of a group of rows.
    fn read(
        &mut self,
        group: &dyn RowGroupReader,
        column: usize,
        kind: Kind,
        left: &mut usize,
    ) -> Result<(), ParquetError> {
        let chunk = group.metadata().column(column);
        // The reader asserts that these are not negative, and does not look.
        if chunk.dictionary_page_offset().unwrap_or(chunk.data_page_offset()) < 0
            || chunk.compressed_size() < 0
        {
            return Err(ParquetError::General("its place lies before the file".to_owned()));
        }
        let level = chunk.column_descr().max_def_level();
        let reader = group.get_column_reader(column)?;
        match (self, reader) {
            (Cells::Dates(all), ColumnReader::Int64ColumnReader(reader)) => {
                let Kind::Date(unit) = kind else { return Ok(()) };
                let text = |x: Option<i64>| x.map_or(String::new(), |x| stamp_text(i128::from(x) * unit));
                cells(reader, level, left, |x| all.push(text(x)))
            }
            (Cells::Numbers(all), reader) => {
                let mut push = |x: Option<f64>| all.push(x.unwrap_or(f64::NAN));
                match reader {
                    ColumnReader::BoolColumnReader(r) => {
                        cells(r, level, left, |x| push(x.map(|x| f64::from(u8::from(x)))))
                    }
                    ColumnReader::Int32ColumnReader(r) => {
                        cells(r, level, left, |x| push(x.map(|x| kind.number(i64::from(x)))))
                    }
                    ColumnReader::Int64ColumnReader(r) => {
                        cells(r, level, left, |x| push(x.map(|x| kind.number(x))))
                    }
                    ColumnReader::FloatColumnReader(r) => cells(r, level, left, |x| push(x.map(f64::from))),
                    ColumnReader::DoubleColumnReader(r) => cells(r, level, left, push),
                    _ => Ok(()),
                }
            }
            (Cells::Dates(_), _) => Ok(()),
        }
    }
}

/// Calls `push` with each cell of a column of a group of rows; none where the level of its definition is not
/// `level`.
fn cells<T: DataType>(
    mut reader: ColumnReaderImpl<T>,
    level: i16,
    left: &mut usize,
    mut push: impl FnMut(Option<T::T>),
) -> Result<(), ParquetError> {
    loop {
        let (mut levels, mut values) = (vec![], vec![]);
        let definitions = (level > 0).then_some(&mut levels);
        let (rows, ..) = reader.read_records(BATCH, definitions, None, &mut values)?;
        if rows == 0 {
            return Ok(());
        }
        let too_large =
            || ParquetError::General("it should hold more numbers than a file of this size can".to_owned());
        *left = left.checked_sub(rows).ok_or_else(too_large)?;
        let mut values = values.into_iter();
        if level == 0 {
            values.for_each(|x| push(Some(x)));
        } else {
            levels.iter().for_each(|own| push(if *own == level { values.next() } else { None }));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_place_before_the_file_is_an_error_and_no_panic() {
        let whole = include_bytes!("../../tests/fixtures/run.parquet");
        let places: Vec<String> = (0..whole.len())
            .filter_map(|k| {
                let mut bytes = whole.to_vec();
                // The sign of a number in the footer is the last bit of its first byte.
                bytes[k] ^= 1;
                read(&bytes).err().map(|why| format!("{why:?}"))
            })
            .collect();
        assert!(places.iter().any(|why| why.contains("before the file")), "{places:?}");
    }
}

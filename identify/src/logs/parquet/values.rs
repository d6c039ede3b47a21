//! Values of flat columns: numbers, times, texts.

use parquet::basic::{ConvertedType, LogicalType, TimeUnit, Type as Physical};
use parquet::column::reader::{ColumnReader, ColumnReaderImpl};
use parquet::data_type::DataType;
use parquet::errors::ParquetError;
use parquet::schema::types::ColumnDescriptor;

use super::guarded;

/// A plain column, not a list or a field of a structure.
pub(super) fn is_flat(column: &ColumnDescriptor) -> bool {
    column.max_rep_level() == 0 && column.max_def_level() <= 1
}

/// A plain column whose bits mean the number they spell, or a time.
pub(super) fn is_number(column: &ColumnDescriptor) -> bool {
    let plain = matches!(
        column.logical_type_ref(),
        // A column that is null throughout has the last of them.
        None | Some(LogicalType::Integer { .. } | LogicalType::Unknown)
    );
    let physical = column.physical_type();
    let number = [
        Physical::INT32,
        Physical::INT64,
        Physical::FLOAT,
        Physical::DOUBLE,
    ];
    is_flat(column) && (unit(column).is_some() || plain && number.contains(&physical))
}

/// The unit of a column of timestamps, s.
pub(super) fn unit(column: &ColumnDescriptor) -> Option<f64> {
    match (column.physical_type(), column.logical_type_ref()) {
        // Nanoseconds, as Spark and Hive count them.
        (Physical::INT96, _) => Some(1e-9),
        (Physical::INT64, Some(LogicalType::Timestamp(time))) => Some(match time.unit {
            TimeUnit::MILLIS => 1e-3,
            TimeUnit::MICROS => 1e-6,
            TimeUnit::NANOS => 1e-9,
        }),
        (Physical::INT64, None) => match column.converted_type() {
            ConvertedType::TIMESTAMP_MILLIS => Some(1e-3),
            ConvertedType::TIMESTAMP_MICROS => Some(1e-6),
            _ => None,
        },
        _ => None,
    }
}

/// Up to `n` values, fewer at the end of the column; NaN for none.
pub(super) fn read_numbers(reader: &mut ColumnReader, n: usize) -> Result<Vec<f64>, ParquetError> {
    fn all<T: DataType>(
        reader: &mut ColumnReaderImpl<T>,
        n: usize,
        number: impl Fn(T::T) -> f64,
    ) -> Result<Vec<f64>, ParquetError> {
        let (values, levels) = read(reader, n)?;
        let values = values.into_iter().map(number);
        Ok(match levels {
            None => values.collect(),
            Some(levels) => spread(values, &levels)
                .map(|value| value.unwrap_or(f64::NAN))
                .collect(),
        })
    }
    Ok(match reader {
        ColumnReader::Int32ColumnReader(reader) => all(reader, n, f64::from)?,
        ColumnReader::Int64ColumnReader(reader) => all(reader, n, |x| x as f64)?,
        ColumnReader::Int96ColumnReader(reader) => all(reader, n, |x| x.to_nanos() as f64)?,
        ColumnReader::FloatColumnReader(reader) => all(reader, n, f64::from)?,
        ColumnReader::DoubleColumnReader(reader) => all(reader, n, |x| x)?,
        _ => Vec::new(),
    })
}

/// Values of a flat column, and where some are missing, which are there.
pub(super) type Column<T> = (Vec<<T as DataType>::T>, Option<Vec<i16>>);

/// Up to `n` values of a flat column.
pub(super) fn read<T: DataType>(
    reader: &mut ColumnReaderImpl<T>,
    n: usize,
) -> Result<Column<T>, ParquetError> {
    let (mut levels, mut values) = (Vec::new(), Vec::with_capacity(n.min(1 << 16)));
    let (records, found, _) =
        guarded(|| reader.read_records(n, Some(&mut levels), None, &mut values))?;
    levels.truncate(records);
    Ok((values, (found < records).then_some(levels)))
}

/// Values where `levels` say that there is one.
pub(super) fn spread<'a, T>(
    mut values: impl Iterator<Item = T> + 'a,
    levels: &'a [i16],
) -> impl Iterator<Item = Option<T>> + 'a {
    let of = move |level: &i16| if *level > 0 { values.next() } else { None };
    levels.iter().map(of)
}

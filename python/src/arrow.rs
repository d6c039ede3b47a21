//! Tables of other libraries, by the Arrow C stream interface.
//!
//! ```text
//! __arrow_c_stream__ ─▶ batches ─▶ columns: numbers, whole numbers, texts, or what they are instead
//! numbers     float, integer, bool, times · unit (s), decimals m / 10^scale
//! the rest    is said by its name where it is used
//! ```
//!
//! Values are copied; what the producer owns is released before the call ends.

use arrow_array::cast::AsArray;
use arrow_array::ffi_stream::{ArrayStreamReader, FFI_ArrowArrayStream};
use arrow_array::types::{
    ArrowPrimitiveType, Decimal32Type, Decimal64Type, Decimal128Type, Decimal256Type, Float16Type,
    Float32Type, Float64Type,
};
use arrow_array::{Array, ArrayReader as _, ArrayRef, downcast_integer_array, make_array};
use arrow_schema::ffi::FFI_ArrowSchema;
use arrow_schema::{ArrowError, DataType, TimeUnit};
use numpy::PyArray1;
use pyo3::prelude::*;
use pyo3::types::PyCapsule;

use crate::calls::{Signals, guarded};
use crate::errors::{Doing, Failure};

/// Rows of a column that are read between looks for signals: a millisecond's worth.
const CHUNK: usize = 1 << 16;

/// A column that grows batch by batch.
enum Values {
    Numbers(Vec<f64>),
    Integers(Vec<i64>),
    Texts(Vec<String>),
    /// Neither numbers nor texts, so many rows: what they are.
    Unusable(usize, String),
}

/// A column that holds neither numbers nor texts: it is in nobody's way until it is used.
#[pyclass(frozen, module = "sesc._sesc")]
pub struct Unusable {
    pub rows: usize,
    pub what: String,
}

#[pymethods]
impl Unusable {
    #[new]
    fn new(rows: usize, what: String) -> Unusable {
        Unusable { rows, what }
    }
}

/// Columns of an Arrow stream, by name.
#[pyfunction]
pub(crate) fn arrow_columns<'py>(
    py: Python<'py>,
    capsule: &Bound<'py, PyCapsule>,
) -> PyResult<Vec<(String, Bound<'py, PyAny>)>> {
    let pointer = capsule.pointer_checked(Some(c"arrow_array_stream"))?;
    // SAFETY: a capsule of this name holds such a stream (the PyCapsule interface of Arrow). Its
    // functions may be called by any thread, one at a time, and take the interpreter's lock by
    // themselves where they need it.
    #[allow(unsafe_code)]
    let stream = unsafe { FFI_ArrowArrayStream::from_raw(pointer.as_ptr().cast()) };
    let columns = guarded(py, || py.detach(|| read(stream)))?.into_iter();
    columns
        .map(|(name, values)| Ok((name, values.array(py)?)))
        .collect()
}

/// The error of a table that cannot be read, for threads that may have no interpreter.
fn refused(message: impl Into<String>) -> PyErr {
    Python::attach(|py| Failure::plain(Doing::Log, message).raise(py))
}

/// The same in the producer's words, where it has any.
fn failed(error: ArrowError) -> PyErr {
    let said = error.to_string();
    let own = said.split_once("Producer error: ");
    refused(own.map_or(&*said, |(_, own)| own))
}

fn read(stream: FFI_ArrowArrayStream) -> PyResult<Vec<(String, Values)>> {
    if stream.release().is_none() {
        return Err(refused("the Arrow stream was released"));
    }
    let reader = ArrayStreamReader::try_new(stream).map_err(failed)?;
    let DataType::Struct(fields) = reader.field().data_type().clone() else {
        return Err(refused("the Arrow stream is of an array; give a table"));
    };
    let columns = fields.iter().map(|field| {
        let values = Values::of(field.data_type(), field.name());
        (field.name().clone(), values)
    });
    let mut columns: Vec<(String, Values)> = columns.collect();
    let mut signals = Signals::new();
    for batch in reader {
        let batch = batch.map_err(failed)?;
        for ((name, values), array) in columns.iter_mut().zip(batch.as_struct().columns()) {
            // Values of a dictionary are made once a batch.
            let chunk = match array.data_type() {
                DataType::Dictionary(..) => array.len().max(1),
                _ => CHUNK,
            };
            for from in (0..array.len()).step_by(chunk) {
                let some = array.slice(from, chunk.min(array.len() - from));
                values.append(&some).map_err(|row| {
                    let row = from + row + 1;
                    let message =
                        format!("column `{name}` has no value in row {row}; give every row one");
                    refused(message)
                })?;
                signals.look()?;
            }
        }
    }
    Ok(columns)
}

impl Values {
    /// None yet, of a column of this type and name.
    fn of(column: &DataType, name: &str) -> Values {
        let entry = match column {
            DataType::Dictionary(_, entry) => entry,
            own => own,
        };
        match entry {
            DataType::Utf8 | DataType::LargeUtf8 | DataType::Utf8View => Values::Texts(Vec::new()),
            own if own.is_integer() && name == "pose" => Values::Integers(Vec::new()),
            own => match unusable(own) {
                None => Values::Numbers(Vec::new()),
                Some(what) => Values::Unusable(0, what),
            },
        }
    }

    /// Append rows of the column; the error is a row without a value where each needs one.
    fn append(&mut self, rows: &ArrayRef) -> Result<(), usize> {
        match self {
            Values::Numbers(all) => all.extend(numbers(rows)),
            Values::Texts(all) => all.extend(texts(rows)),
            Values::Unusable(count, _) => *count += rows.len(),
            Values::Integers(all) => {
                for (row, value) in integers(rows).into_iter().enumerate() {
                    all.push(value.ok_or(row)?);
                }
            }
        }
        Ok(())
    }

    fn array(self, py: Python<'_>) -> PyResult<Bound<'_, PyAny>> {
        Ok(match self {
            Values::Numbers(x) => PyArray1::from_vec(py, x).into_any(),
            Values::Integers(x) => PyArray1::from_vec(py, x).into_any(),
            Values::Texts(x) => py.import("numpy")?.call_method1("array", (x,))?,
            Values::Unusable(rows, what) => Bound::new(py, Unusable { rows, what })?.into_any(),
        })
    }
}

/// What a type holds that is neither numbers nor texts.
fn unusable(of: &DataType) -> Option<String> {
    use DataType as Type;
    let what = match of {
        Type::Date32 | Type::Date64 => "dates",
        Type::Time32(_) | Type::Time64(_) => "times of day",
        Type::Interval(_) => "intervals of a calendar",
        Type::Binary | Type::LargeBinary | Type::BinaryView | Type::FixedSizeBinary(_) => "bytes",
        Type::List(_) | Type::LargeList(_) | Type::FixedSizeList(..) => "lists",
        Type::ListView(_) | Type::LargeListView(_) => "lists",
        Type::Struct(_) => "structures",
        Type::Map(..) => "maps",
        Type::RunEndEncoded(..) => "runs of values",
        Type::Union(..) => "values of several types",
        Type::Dictionary(..) => "values",
        _ => return None,
    };
    let format = FFI_ArrowSchema::try_from(of).ok();
    let format = format.map_or_else(String::new, |own| own.format().to_string());
    Some(format!("{what} (Arrow format {format})"))
}

/// Values of a dictionary row by row, each found by `of`; `none` where there is none.
fn entries<T: Clone>(rows: &ArrayRef, of: impl Fn(&ArrayRef) -> Vec<T>, none: T) -> Vec<T> {
    let dictionary = rows.as_any_dictionary();
    let values = of(dictionary.values());
    let keys = integers(&make_array(dictionary.keys().to_data())).into_iter();
    let value = |key: Option<i64>| values.get(usize::try_from(key?).ok()?).cloned();
    keys.map(|key| value(key).unwrap_or_else(|| none.clone()))
        .collect()
}

/// Whole numbers.
fn integers(rows: &ArrayRef) -> Vec<Option<i64>> {
    downcast_integer_array!(
        rows => rows.iter().map(|x| x.map(|x| (x as i128).min(i64::MAX.into()) as i64)).collect(),
        DataType::Dictionary(..) => entries(rows, integers, None),
        _ => vec![None; rows.len()],
    )
}

/// Texts, empty where there is none.
fn texts(rows: &ArrayRef) -> Vec<String> {
    // Producers do not always check their bytes.
    let owned = |text: Option<&str>| {
        let bytes = text.unwrap_or_default().as_bytes();
        String::from_utf8_lossy(bytes).into_owned()
    };
    match rows.data_type() {
        DataType::Utf8 => rows.as_string::<i32>().iter().map(owned).collect(),
        DataType::LargeUtf8 => rows.as_string::<i64>().iter().map(owned).collect(),
        DataType::Utf8View => rows.as_string_view().iter().map(owned).collect(),
        _ => entries(rows, texts, String::new()),
    }
}

/// Numbers, NaN where there is none; times in seconds.
fn numbers(rows: &ArrayRef) -> Vec<f64> {
    let scaled = |whole: f64, scale: &i8| whole / 10f64.powi((*scale).into());
    downcast_integer_array!(
        rows => rows.iter().map(|x| x.map_or(f64::NAN, |x| x as f64)).collect(),
        DataType::Boolean => {
            let values = rows.as_boolean().iter();
            values.map(|x| x.map_or(f64::NAN, |x| f64::from(u8::from(x)))).collect()
        }
        DataType::Float16 => of::<Float16Type>(rows, f64::from),
        DataType::Float32 => of::<Float32Type>(rows, f64::from),
        DataType::Float64 => of::<Float64Type>(rows, |x| x),
        DataType::Decimal32(_, scale) => of::<Decimal32Type>(rows, |x| scaled(x.into(), scale)),
        DataType::Decimal64(_, scale) => of::<Decimal64Type>(rows, |x| scaled(x as f64, scale)),
        DataType::Decimal128(_, scale) => of::<Decimal128Type>(rows, |x| scaled(x as f64, scale)),
        DataType::Decimal256(_, scale) => of::<Decimal256Type>(rows, |x| {
            let (low, high) = x.to_parts();
            let whole = match low as i128 {
                own if high == own >> 127 => own as f64,
                _ => high as f64 * 2f64.powi(128) + low as f64,
            };
            scaled(whole, scale)
        }),
        DataType::Timestamp(unit, _) | DataType::Duration(unit) => {
            let seconds = match unit {
                TimeUnit::Second => 1.0,
                TimeUnit::Millisecond => 1e-3,
                TimeUnit::Microsecond => 1e-6,
                TimeUnit::Nanosecond => 1e-9,
            };
            let whole = rows.to_data().into_builder().data_type(DataType::Int64).build();
            let whole = whole.map_or_else(|_| Vec::new(), |whole| numbers(&make_array(whole)));
            whole.into_iter().map(|x| x * seconds).collect()
        }
        DataType::Dictionary(..) => entries(rows, numbers, f64::NAN),
        _ => vec![f64::NAN; rows.len()],
    )
}

fn of<T: ArrowPrimitiveType>(rows: &ArrayRef, number: impl Fn(T::Native) -> f64) -> Vec<f64> {
    let values = rows.as_primitive::<T>().iter();
    values.map(|x| x.map_or(f64::NAN, &number)).collect()
}

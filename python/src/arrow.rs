//! Tables of other libraries, by the Arrow C stream interface: no library of Arrow is needed.
//!
//! ```text
//! __arrow_c_stream__ ─▶ ArrowArrayStream ─▶ batches ─▶ columns: numbers, whole numbers, texts, or what they are instead
//! ```
//!
//! The layouts are those of <https://arrow.apache.org/docs/format/CDataInterface.html> and
//! <https://arrow.apache.org/docs/format/CStreamInterface.html>. Values are copied; what the
//! producer owns is released before the call ends.

#![allow(unsafe_code)]

mod values;

use std::ffi::{CStr, c_char, c_int, c_void};

use numpy::PyArray1;
use pyo3::prelude::*;
use pyo3::types::PyCapsule;

use self::values::{Kind, integer, is_valid, kind, number, string};
use crate::calls::{Signals, guarded};
use crate::errors::{Doing, Failure};

/// Rows of a column that are read between looks for signals: a millisecond's worth.
const CHUNK: usize = 1 << 16;

#[repr(C)]
struct Schema {
    format: *const c_char,
    name: *const c_char,
    metadata: *const c_char,
    flags: i64,
    n_children: i64,
    children: *mut *mut Schema,
    dictionary: *mut Schema,
    release: Option<unsafe extern "C" fn(*mut Schema)>,
    private_data: *mut c_void,
}

#[repr(C)]
struct Array {
    length: i64,
    null_count: i64,
    offset: i64,
    n_buffers: i64,
    n_children: i64,
    buffers: *mut *const c_void,
    children: *mut *mut Array,
    dictionary: *mut Array,
    release: Option<unsafe extern "C" fn(*mut Array)>,
    private_data: *mut c_void,
}

#[repr(C)]
struct Stream {
    get_schema: Option<unsafe extern "C" fn(*mut Stream, *mut Schema) -> c_int>,
    get_next: Option<unsafe extern "C" fn(*mut Stream, *mut Array) -> c_int>,
    get_last_error: Option<unsafe extern "C" fn(*mut Stream) -> *const c_char>,
    release: Option<unsafe extern "C" fn(*mut Stream)>,
    private_data: *mut c_void,
}

/// A structure that its producer filled, released when it is dropped.
macro_rules! owned {
    ($name:ident, $of:ty) => {
        struct $name(Box<$of>);
        impl $name {
            fn empty() -> $name {
                // SAFETY: all fields are integers, pointers or optional functions, for which
                // zero is a value: nothing, or released.
                $name(Box::new(unsafe { std::mem::zeroed() }))
            }
        }
        impl Drop for $name {
            fn drop(&mut self) {
                if let Some(release) = self.0.release {
                    // SAFETY: it was filled by its producer and is released once.
                    unsafe { release(&mut *self.0) }
                }
            }
        }
    };
}
owned!(OwnedSchema, Schema);
owned!(OwnedArray, Array);

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

/// A column of the schema, and what was read of it.
struct Column {
    name: String,
    kind: Kind,
    /// What the places in a dictionary are.
    index: Option<Kind>,
    values: Values,
}

impl Column {
    /// # Safety
    /// `schema` is valid.
    unsafe fn of(schema: &Schema) -> Column {
        // SAFETY: names and formats are texts, the dictionary is none or a schema.
        let (name, format, dictionary) = unsafe {
            let dictionary = schema.dictionary.as_ref();
            let dictionary = dictionary.map(|dictionary| text(dictionary.format));
            (text(schema.name), text(schema.format), dictionary)
        };
        let found = match &dictionary {
            None => kind(&format).map(|kind| (kind, None)),
            Some(values) => {
                let both = kind(values).and_then(|kind| Ok((kind, self::kind(&format)?)));
                both.map(|(kind, index)| (kind, Some(index)))
            }
        };
        let (kind, index, values) = match found {
            Ok((kind, index)) => (kind, index, Values::new(kind, &name)),
            Err(what) => (Kind::Nothing, None, Values::Unusable(0, what)),
        };
        Column {
            name,
            kind,
            index,
            values,
        }
    }
}

impl Values {
    fn new(kind: Kind, name: &str) -> Values {
        match kind {
            Kind::Text(_) | Kind::TextView => Values::Texts(Vec::new()),
            Kind::Int(..) if name == "pose" => Values::Integers(Vec::new()),
            _ => Values::Numbers(Vec::new()),
        }
    }

    fn array(self, py: Python<'_>) -> PyResult<Bound<'_, PyAny>> {
        Ok(match self {
            Values::Numbers(x) => PyArray1::from_vec(py, x).into_any(),
            Values::Integers(x) => PyArray1::from_vec(py, x).into_any(),
            Values::Texts(x) => numpy_texts(py, x)?,
            Values::Unusable(rows, what) => Bound::new(py, Unusable { rows, what })?.into_any(),
        })
    }
}

/// The error of a table that cannot be read, for threads that may have no interpreter.
fn refused(message: impl Into<String>) -> PyErr {
    Python::attach(|py| Failure::plain(Doing::Log, message).raise(py))
}

/// A stream on its way to where the interpreter's lock is free.
struct Pointer(*mut Stream);

// SAFETY: the interface asks no thread of its own for a stream, only that calls do not overlap;
// the pointer is used by the one closure that takes it.
unsafe impl Send for Pointer {}

impl Pointer {
    fn get(self) -> *mut Stream {
        self.0
    }
}

/// Columns of an Arrow stream, by name.
#[pyfunction]
pub fn arrow_columns<'py>(
    py: Python<'py>,
    capsule: &Bound<'py, PyCapsule>,
) -> PyResult<Vec<(String, Bound<'py, PyAny>)>> {
    let pointer = capsule.pointer_checked(Some(c"arrow_array_stream"))?;
    let stream: *mut Stream = pointer.as_ptr().cast();
    let stream = Pointer(stream);
    // SAFETY: a capsule of this name holds such a stream (the PyCapsule interface of Arrow);
    // the capsule outlives this call, and its own destructor releases the stream. Functions of a
    // stream may be called by any thread, one at a time, and take the interpreter's lock by
    // themselves where they need it.
    let columns = guarded(py, || py.detach(move || unsafe { read(stream.get()) }))?;
    let columns = columns.into_iter();
    columns
        .map(|column| Ok((column.name, column.values.array(py)?)))
        .collect()
}

fn numpy_texts(py: Python<'_>, texts: Vec<String>) -> PyResult<Bound<'_, PyAny>> {
    py.import("numpy")?.call_method1("array", (texts,))
}

/// # Safety
/// `stream` is valid.
unsafe fn read(stream: *mut Stream) -> PyResult<Vec<Column>> {
    let failed = |stream: *mut Stream| {
        // SAFETY: as above; the text lives until the next call.
        let said = unsafe {
            let text = (*stream).get_last_error.map(|last| last(stream));
            text.filter(|text| !text.is_null())
                .map(|text| CStr::from_ptr(text).to_string_lossy().into_owned())
        };
        refused(said.unwrap_or_else(|| "the Arrow stream failed".to_string()))
    };
    // SAFETY: the stream is valid, and its functions are called as the interface says.
    unsafe {
        // Of a stream that was released its producer clears `release` alone.
        let (Some(_), Some(get_schema), Some(get_next)) =
            ((*stream).release, (*stream).get_schema, (*stream).get_next)
        else {
            return Err(refused("the Arrow stream was released"));
        };
        let mut schema = OwnedSchema::empty();
        if get_schema(stream, &mut *schema.0) != 0 {
            return Err(failed(stream));
        }
        if CStr::from_ptr(schema.0.format).to_bytes() != b"+s" {
            return Err(refused("the Arrow stream is of an array; give a table"));
        }
        let children = (0..schema.0.n_children as usize).map(|k| &**schema.0.children.add(k));
        let mut columns: Vec<Column> = children.map(|child| Column::of(child)).collect();
        let mut signals = Signals::new();
        loop {
            let mut batch = OwnedArray::empty();
            if get_next(stream, &mut *batch.0) != 0 {
                return Err(failed(stream));
            }
            if batch.0.release.is_none() {
                break;
            }
            if batch.0.n_children as usize != columns.len() {
                return Err(refused(
                    "a batch of the Arrow stream has other columns than its schema",
                ));
            }
            for (k, column) in columns.iter_mut().enumerate() {
                let child = &**batch.0.children.add(k);
                let rows = batch.0.offset as usize..(batch.0.offset + batch.0.length) as usize;
                for from in rows.clone().step_by(CHUNK) {
                    let some = from..rows.end.min(from + CHUNK);
                    append(child, some, column)?;
                    signals.look()?;
                }
            }
        }
        Ok(columns)
    }
}

/// # Safety
/// `pointer` is null or a text that ends with zero.
unsafe fn text(pointer: *const c_char) -> String {
    match pointer.is_null() {
        true => String::new(),
        // SAFETY: as said.
        false => unsafe { CStr::from_ptr(pointer) }
            .to_string_lossy()
            .into_owned(),
    }
}

/// # Safety
/// `array` is valid and of the column's kind.
unsafe fn append(array: &Array, rows: std::ops::Range<usize>, column: &mut Column) -> PyResult<()> {
    let kind = column.kind;
    if let Values::Unusable(count, _) = &mut column.values {
        *count += rows.len();
        return Ok(());
    }
    for row in rows {
        // SAFETY: rows of the batch are rows of its columns.
        let place = unsafe {
            match column.index {
                _ if !is_valid(array, row) => None,
                None => Some((array, row)),
                Some(index) => {
                    let entry = number(array, index, row) as usize;
                    let dictionary = &*array.dictionary;
                    is_valid(dictionary, entry).then_some((dictionary, entry))
                }
            }
        };
        // SAFETY: likewise.
        unsafe {
            match (&mut column.values, place) {
                (Values::Numbers(all), Some((of, row))) => all.push(number(of, kind, row)),
                (Values::Numbers(all), None) => all.push(f64::NAN),
                (Values::Integers(all), Some((of, row))) => all.push(integer(of, kind, row)),
                (Values::Integers(_), None) => {
                    return Err(refused(format!(
                        "column `{}` has no value in row {}; give every row one",
                        column.name,
                        row + 1
                    )));
                }
                (Values::Texts(all), Some((of, row))) => all.push(string(of, kind, row)),
                (Values::Texts(all), None) => all.push(String::new()),
                (Values::Unusable(..), _) => {}
            }
        }
    }
    Ok(())
}

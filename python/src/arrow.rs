//! Tables of other libraries, by the Arrow C stream interface: no library of Arrow is needed.
//!
//! ```text
//! __arrow_c_stream__ ─▶ ArrowArrayStream ─▶ batches ─▶ columns: numbers, whole numbers, texts
//! ```
//!
//! The layouts are those of <https://arrow.apache.org/docs/format/CDataInterface.html> and
//! <https://arrow.apache.org/docs/format/CStreamInterface.html>. Values are copied; what the
//! producer owns is released before the call ends.

#![allow(unsafe_code)]

use std::ffi::{CStr, c_char, c_int, c_void};
use std::ptr;

use numpy::PyArray1;
use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::PyCapsule;

use crate::calls::{Signals, guarded};

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

/// What a format holds, and by what its numbers are multiplied: times are seconds.
#[derive(Clone, Copy)]
enum Kind {
    Bool,
    Int(u8, bool),
    Float(u8),
    Text(u8),
    TextView,
    Time(f64),
}

fn kind(format: &str, name: &str) -> PyResult<Kind> {
    let unit = |unit: Option<char>| match unit {
        Some('s') => Some(1.0),
        Some('m') => Some(1e-3),
        Some('u') => Some(1e-6),
        Some('n') => Some(1e-9),
        _ => None,
    };
    let time = format.strip_prefix("ts").or(format.strip_prefix("tD"));
    if let Some(factor) = time.and_then(|rest| unit(rest.chars().next())) {
        return Ok(Kind::Time(factor));
    }
    Ok(match format {
        "b" => Kind::Bool,
        "c" => Kind::Int(1, true),
        "C" => Kind::Int(1, false),
        "s" => Kind::Int(2, true),
        "S" => Kind::Int(2, false),
        "i" => Kind::Int(4, true),
        "I" => Kind::Int(4, false),
        "l" => Kind::Int(8, true),
        "L" => Kind::Int(8, false),
        "f" => Kind::Float(4),
        "g" => Kind::Float(8),
        "u" => Kind::Text(4),
        "U" => Kind::Text(8),
        "vu" => Kind::TextView,
        other => {
            return Err(PyTypeError::new_err(format!(
                "column `{name}` has the Arrow format {other}, which is neither numbers nor text; \
                 cast it or leave it out"
            )));
        }
    })
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
    let array = |values| -> PyResult<Bound<'py, PyAny>> {
        Ok(match values {
            Values::Numbers(x) => PyArray1::from_vec(py, x).into_any(),
            Values::Integers(x) => PyArray1::from_vec(py, x).into_any(),
            Values::Texts(x) => numpy_texts(py, x)?,
        })
    };
    let columns = columns.into_iter();
    columns
        .map(|(name, values)| Ok((name, array(values)?)))
        .collect()
}

fn numpy_texts(py: Python<'_>, texts: Vec<String>) -> PyResult<Bound<'_, PyAny>> {
    py.import("numpy")?.call_method1("array", (texts,))
}

/// # Safety
/// `stream` is valid.
unsafe fn read(stream: *mut Stream) -> PyResult<Vec<(String, Values)>> {
    let failed = |stream: *mut Stream| {
        // SAFETY: as above; the text lives until the next call.
        let said = unsafe {
            let text = (*stream).get_last_error.map(|last| last(stream));
            text.filter(|text| !text.is_null())
                .map(|text| CStr::from_ptr(text).to_string_lossy().into_owned())
        };
        PyValueError::new_err(said.unwrap_or_else(|| "the Arrow stream failed".to_string()))
    };
    // SAFETY: the stream is valid, and its functions are called as the interface says.
    unsafe {
        // Of a stream that was released its producer clears `release` alone.
        let (Some(_), Some(get_schema), Some(get_next)) =
            ((*stream).release, (*stream).get_schema, (*stream).get_next)
        else {
            return Err(PyValueError::new_err("the Arrow stream was released"));
        };
        let mut schema = OwnedSchema::empty();
        if get_schema(stream, &mut *schema.0) != 0 {
            return Err(failed(stream));
        }
        if CStr::from_ptr(schema.0.format).to_bytes() != b"+s" {
            return Err(PyTypeError::new_err(
                "the Arrow stream is of an array; give a table",
            ));
        }
        let mut columns = Vec::new();
        for k in 0..schema.0.n_children as usize {
            let child = &**schema.0.children.add(k);
            let name = text(child.name);
            let of = |schema: &Schema| kind(&text(schema.format), &name);
            let values = match child.dictionary.is_null() {
                true => of(child)?,
                false => of(&*child.dictionary)?,
            };
            let index = (!child.dictionary.is_null())
                .then(|| of(child))
                .transpose()?;
            let empty = match (values, name.as_str()) {
                (Kind::Text(_) | Kind::TextView, _) => Values::Texts(Vec::new()),
                (Kind::Int(..), "pose") => Values::Integers(Vec::new()),
                _ => Values::Numbers(Vec::new()),
            };
            columns.push((name, values, index, empty));
        }
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
                return Err(PyValueError::new_err(
                    "a batch of the Arrow stream has other columns than its schema",
                ));
            }
            for (k, (name, kind, index, values)) in columns.iter_mut().enumerate() {
                let child = &**batch.0.children.add(k);
                let rows = batch.0.offset as usize..(batch.0.offset + batch.0.length) as usize;
                for from in rows.clone().step_by(CHUNK) {
                    let some = from..rows.end.min(from + CHUNK);
                    append(child, *kind, *index, some, name, values)?;
                    signals.look()?;
                }
            }
        }
        Ok(columns
            .into_iter()
            .map(|(name, _, _, values)| (name, values))
            .collect())
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
/// `array` is valid and of that kind.
unsafe fn append(
    array: &Array,
    kind: Kind,
    index: Option<Kind>,
    rows: std::ops::Range<usize>,
    name: &str,
    values: &mut Values,
) -> PyResult<()> {
    for row in rows {
        // SAFETY: rows of the batch are rows of its columns.
        let place = unsafe {
            match index {
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
            match (&mut *values, place) {
                (Values::Numbers(all), Some((of, row))) => all.push(number(of, kind, row)),
                (Values::Numbers(all), None) => all.push(f64::NAN),
                (Values::Integers(all), Some((of, row))) => all.push(integer(of, kind, row)),
                (Values::Integers(_), None) => {
                    return Err(PyValueError::new_err(format!(
                        "column `{name}` has no value in row {}; give every row one",
                        row + 1
                    )));
                }
                (Values::Texts(all), Some((of, row))) => all.push(string(of, kind, row)),
                (Values::Texts(all), None) => all.push(String::new()),
            }
        }
    }
    Ok(())
}

/// # Safety
/// `row` is a row of the valid `array`.
unsafe fn is_valid(array: &Array, row: usize) -> bool {
    let at = row + array.offset as usize;
    // SAFETY: the first buffer, if there is one, has a bit for each row.
    unsafe {
        let bits: *const u8 = (*array.buffers).cast();
        array.null_count == 0 || bits.is_null() || (*bits.add(at / 8) >> (at % 8)) & 1 == 1
    }
}

/// The value of type `T` in the second buffer.
///
/// # Safety
/// The array's values are of that type, and `row` is one of its rows.
unsafe fn value<T: Copy>(array: &Array, row: usize) -> T {
    // SAFETY: as said; buffers of other libraries may be unaligned.
    unsafe {
        let values: *const T = (*array.buffers.add(1)).cast();
        ptr::read_unaligned(values.add(row + array.offset as usize))
    }
}

/// # Safety
/// As [`value`].
unsafe fn integer(array: &Array, kind: Kind, row: usize) -> i64 {
    // SAFETY: the format says the type.
    unsafe {
        match kind {
            Kind::Int(1, true) => value::<i8>(array, row).into(),
            Kind::Int(1, false) => value::<u8>(array, row).into(),
            Kind::Int(2, true) => value::<i16>(array, row).into(),
            Kind::Int(2, false) => value::<u16>(array, row).into(),
            Kind::Int(4, true) => value::<i32>(array, row).into(),
            Kind::Int(4, false) => value::<u32>(array, row).into(),
            Kind::Int(_, false) => value::<u64>(array, row).try_into().unwrap_or(i64::MAX),
            _ => value::<i64>(array, row),
        }
    }
}

/// # Safety
/// As [`value`].
unsafe fn number(array: &Array, kind: Kind, row: usize) -> f64 {
    // SAFETY: the format says the type; booleans are bits.
    unsafe {
        match kind {
            Kind::Float(4) => value::<f32>(array, row).into(),
            Kind::Float(_) => value::<f64>(array, row),
            Kind::Time(factor) => value::<i64>(array, row) as f64 * factor,
            Kind::Bool => {
                let at = row + array.offset as usize;
                let bits: *const u8 = (*array.buffers.add(1)).cast();
                f64::from((*bits.add(at / 8) >> (at % 8)) & 1)
            }
            Kind::Int(8, false) => value::<u64>(array, row) as f64,
            _ => integer(array, kind, row) as f64,
        }
    }
}

/// # Safety
/// The array is of texts, and `row` is one of its rows.
unsafe fn string(array: &Array, kind: Kind, row: usize) -> String {
    // SAFETY: offsets of a row and the next bound its bytes; a view is 16 bytes: length, then
    // the text itself up to 12 bytes, else 4 of it, a buffer and an offset.
    unsafe {
        let bytes = match kind {
            Kind::TextView => {
                let at = row + array.offset as usize;
                let views: *const u8 = (*array.buffers.add(1)).cast();
                let view = views.add(16 * at);
                let word = |k: usize| ptr::read_unaligned(view.add(4 * k).cast::<i32>()) as usize;
                let length = word(0);
                match length <= 12 {
                    true => std::slice::from_raw_parts(view.add(4), length),
                    false => {
                        let data: *const u8 = (*array.buffers.add(2 + word(2))).cast();
                        std::slice::from_raw_parts(data.add(word(3)), length)
                    }
                }
            }
            _ => {
                let offset = |row: usize| match kind {
                    Kind::Text(4) => value::<i32>(array, row) as usize,
                    _ => value::<i64>(array, row) as usize,
                };
                let (from, to) = (offset(row), offset(row + 1));
                let data: *const u8 = (*array.buffers.add(2)).cast();
                match to > from {
                    true => std::slice::from_raw_parts(data.add(from), to - from),
                    false => &[],
                }
            }
        };
        String::from_utf8_lossy(bytes).into_owned()
    }
}

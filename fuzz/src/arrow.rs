//! Columns of Arrow as the Python package reads them: any format, and any values of it.
//!
//! What the producer's pointers lead to is its contract with us; buffers here are as long as the
//! format says, and what is in them is made up.

#[allow(unsafe_code)]
#[path = "../../python/src/arrow/values.rs"]
mod values;

use std::ffi::c_void;

use self::values::{Kind, integer, is_valid, kind, number, string};

/// Rows of a column, and rows before the first.
const ROWS: usize = 8;
const OFFSET: usize = 3;
const ALL: usize = ROWS + OFFSET;
/// Bytes of the longest value, and of a text.
const WIDEST: usize = 32;
const TEXT: usize = 20;

/// What the reader of values looks at of Arrow's array.
struct Array {
    null_count: i64,
    offset: i64,
    n_buffers: i64,
    buffers: *mut *const c_void,
}

/// A format, then the bytes of its values.
pub fn arrow(data: &[u8]) {
    let Some((&length, data)) = data.split_first() else {
        return;
    };
    let (format, data) = data.split_at(data.len().min(usize::from(length % 16)));
    let Ok(kind) = kind(&String::from_utf8_lossy(format)) else {
        return;
    };
    let mut bytes = data.iter().copied().chain(std::iter::repeat(0));
    let mut take = |n: usize| -> Vec<u8> { bytes.by_ref().take(n).collect() };
    let valid = take(ALL.div_ceil(8));
    let lengths = take(ALL);
    let lengths = lengths.iter().map(|n| usize::from(*n) % TEXT);
    let texts = take(ALL * TEXT);
    let main = match kind {
        Kind::Text(width) => {
            let ends = lengths.scan(0, |end, n| {
                *end += n as i64;
                Some(*end)
            });
            let offsets = std::iter::once(0).chain(ends).map(i64::to_le_bytes);
            offsets
                .flat_map(|n| n[..usize::from(width)].to_vec())
                .collect()
        }
        Kind::TextView => {
            let words = |(k, n): (usize, usize)| match n {
                0..=12 => [n, 0, 0, 0],
                _ => [n, 0, 0, k * TEXT],
            };
            let words = lengths.enumerate().flat_map(words);
            words.flat_map(|n| (n as i32).to_le_bytes()).collect()
        }
        _ => take(ALL * WIDEST),
    };
    let buffers = [&valid, &main, &texts].map(|own| own.as_ptr().cast::<c_void>());
    let mut buffers = buffers.to_vec();
    let array = Array {
        null_count: i64::from(length & 16),
        offset: OFFSET as i64,
        n_buffers: buffers.len() as i64,
        buffers: buffers.as_mut_ptr(),
    };
    for row in 0..ROWS {
        // SAFETY: `row` is a row of the array, whose buffers are as long as its kind says.
        unsafe {
            match kind {
                _ if !is_valid(&array, row) => {}
                Kind::Text(_) | Kind::TextView => {
                    assert!(string(&array, kind, row).len() <= 3 * TEXT)
                }
                Kind::Int(..) => drop((integer(&array, kind, row), number(&array, kind, row))),
                _ => drop(number(&array, kind, row)),
            }
        }
    }
}

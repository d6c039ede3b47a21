//! Single values of Arrow's columns: what a format holds, and how a row of it is read.
//!
//! ```text
//! numbers     float, integer, bool, times · factor (s), decimals m / 10^scale
//! texts       offsets into bytes, or views of 16 bytes
//! the rest    is said by its name where it is used
//! ```

use std::ptr;

use super::Array;

/// What a format holds, and by what its numbers are multiplied: times are seconds.
#[derive(Clone, Copy)]
pub(super) enum Kind {
    Bool,
    Int(u8, bool),
    Half,
    Float(u8),
    /// Bytes of a whole number, and how many of its decimal digits stand behind the point.
    Decimal(u8, i32),
    Text(u8),
    TextView,
    Time(f64),
    /// No value in any row.
    Nothing,
}

/// What a format holds; the error says what it is that is neither numbers nor text.
pub(super) fn kind(format: &str) -> Result<Kind, String> {
    let time = format.strip_prefix("ts").or(format.strip_prefix("tD"));
    if let Some(factor) = time.and_then(seconds) {
        return Ok(Kind::Time(factor));
    }
    if let Some(decimal) = format.strip_prefix("d:").and_then(decimal) {
        return Ok(decimal);
    }
    Ok(match format {
        "n" => Kind::Nothing,
        "b" => Kind::Bool,
        "c" => Kind::Int(1, true),
        "C" => Kind::Int(1, false),
        "s" => Kind::Int(2, true),
        "S" => Kind::Int(2, false),
        "i" => Kind::Int(4, true),
        "I" => Kind::Int(4, false),
        "l" => Kind::Int(8, true),
        "L" => Kind::Int(8, false),
        "e" => Kind::Half,
        "f" => Kind::Float(4),
        "g" => Kind::Float(8),
        "u" => Kind::Text(4),
        "U" => Kind::Text(8),
        "vu" => Kind::TextView,
        other => return Err(said(other)),
    })
}

/// The unit of times, s.
fn seconds(format: &str) -> Option<f64> {
    match format.chars().next()? {
        's' => Some(1.0),
        'm' => Some(1e-3),
        'u' => Some(1e-6),
        'n' => Some(1e-9),
        _ => None,
    }
}

/// Digits, digits behind the point, and bits unless 128.
fn decimal(format: &str) -> Option<Kind> {
    let mut parts = format.split(',');
    let (_, scale) = (parts.next()?, parts.next()?.parse().ok()?);
    let bytes = match parts.next() {
        None | Some("128") => 16,
        Some("32") => 4,
        Some("64") => 8,
        Some("256") => 32,
        Some(_) => return None,
    };
    Some(Kind::Decimal(bytes, scale))
}

/// What a format that is neither numbers nor text holds.
fn said(format: &str) -> String {
    let what = match format.as_bytes() {
        [b't', b'd', ..] => "dates",
        [b't', b't', ..] => "times of day",
        [b't', b'i', ..] => "intervals of a calendar",
        [b'z' | b'Z' | b'w', ..] | [b'v', b'z'] => "bytes",
        [b'+', b'l' | b'L' | b'w' | b'v', ..] => "lists",
        [b'+', b's', ..] => "structures",
        [b'+', b'm', ..] => "maps",
        [b'+', b'r', ..] => "runs of values",
        [b'+', b'u', ..] => "values of several types",
        _ => "values",
    };
    format!("{what} (Arrow format {format})")
}

/// # Safety
/// `row` is a row of the valid `array`.
pub(super) unsafe fn is_valid(array: &Array, row: usize) -> bool {
    let at = row + array.offset as usize;
    // SAFETY: the first buffer, if there is one, has a bit for each row.
    unsafe {
        if array.n_buffers == 0 {
            return false;
        }
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
pub(super) unsafe fn integer(array: &Array, kind: Kind, row: usize) -> i64 {
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
pub(super) unsafe fn number(array: &Array, kind: Kind, row: usize) -> f64 {
    // SAFETY: the format says the type; booleans are bits.
    unsafe {
        match kind {
            Kind::Half => half(value::<u16>(array, row)),
            Kind::Float(4) => value::<f32>(array, row).into(),
            Kind::Float(_) => value::<f64>(array, row),
            Kind::Time(factor) => value::<i64>(array, row) as f64 * factor,
            Kind::Decimal(bytes, scale) => whole(array, bytes, row) / 10f64.powi(scale),
            Kind::Nothing => f64::NAN,
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

/// The whole number of a decimal.
///
/// # Safety
/// As [`value`].
unsafe fn whole(array: &Array, bytes: u8, row: usize) -> f64 {
    // SAFETY: the format says the type; the lower half of 32 bytes comes first.
    unsafe {
        match bytes {
            4 => value::<i32>(array, row).into(),
            8 => value::<i64>(array, row) as f64,
            16 => value::<i128>(array, row) as f64,
            _ => {
                let [low, high] = value::<[u128; 2]>(array, row);
                match (low as i128, high as i128) {
                    (low, high) if high == low >> 127 => low as f64,
                    (_, high) => high as f64 * 2f64.powi(128) + low as f64,
                }
            }
        }
    }
}

/// A float of 16 bits.
fn half(bits: u16) -> f64 {
    let (exponent, fraction) = (i32::from(bits >> 10 & 31), f64::from(bits & 1023));
    let size = match exponent {
        0 => fraction * 2f64.powi(-24),
        31 if fraction == 0.0 => f64::INFINITY,
        31 => f64::NAN,
        _ => (1024.0 + fraction) * 2f64.powi(exponent - 25),
    };
    match bits >> 15 {
        0 => size,
        _ => -size,
    }
}

/// # Safety
/// The array is of texts, and `row` is one of its rows.
pub(super) unsafe fn string(array: &Array, kind: Kind, row: usize) -> String {
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

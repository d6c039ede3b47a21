//! What every format delivers: rows of numbers as they stand in the file.

use std::cell::Cell;
#[cfg(feature = "parquet")]
use std::panic::{self, AssertUnwindSafe};
use std::sync::Arc;

use super::block::Share;
use super::columns::{Columns, POSE};
use crate::Error;

/// Rows of a file before anything is made of them.
#[derive(Debug, Clone, Default)]
pub(super) struct Raw {
    pub line: Vec<u64>,
    /// Empty where the log has no such column; [`MISSING`] where a row has no value.
    pub pose: Vec<i64>,
    /// Empty where the log has no such column.
    pub support: Vec<Arc<str>>,
    /// Column by column, in the order of [`Columns::numbers`]. Not yet known to be
    /// finite; a missing value is NaN.
    pub numbers: Vec<Vec<f64>>,
    /// The other contact of rows of both feet; empty of other logs.
    pub other: Vec<Share>,
}

impl Raw {
    /// No rows yet, of these columns.
    pub(super) fn new(columns: &Columns) -> Raw {
        Raw {
            numbers: vec![Vec::new(); columns.numbers.len()],
            ..Raw::default()
        }
    }

    /// The numbers of a row.
    pub(super) fn row(&self, row: usize) -> impl Iterator<Item = f64> {
        self.numbers.iter().map(move |column| column[row])
    }

    /// Append the poses of rows from `line` on, as numbers.
    ///
    /// # Errors
    /// The first row whose pose is not whole.
    pub(super) fn poses(&mut self, line: u64, values: Vec<f64>) -> Result<(), Error> {
        for (line, value) in (line..).zip(values) {
            let pose = whole(value).map_err(|said| Error::row(Some(line), said))?;
            self.pose.push(pose);
        }
        Ok(())
    }
}

/// A file of some format, read row by row.
pub(super) trait RowSource: Send {
    /// Names of the columns, without blanks around them.
    fn header(&self) -> &[String];

    /// The line of these names in a text, whatever its name says.
    fn names_line(&self) -> Option<u64> {
        None
    }

    /// Append up to `count` rows to `raw`; fewer only at the end of the file.
    fn fill(&mut self, columns: &Columns, count: usize, raw: &mut Raw) -> Result<(), Error>;

    /// Pass over about `rows` rows; where a format cannot leap over them, they are read, and what is
    /// wrong with one is an error.
    fn skip(&mut self, columns: &Columns, mut rows: u64) -> Result<(), Error> {
        while rows > 0 {
            let mut raw = Raw::new(columns);
            self.fill(columns, rows.min(1 << 12) as usize, &mut raw)?;
            let taken = raw.line.len() as u64;
            rows = if taken == 0 { 0 } else { rows - taken };
        }
        Ok(())
    }

    /// Whether rows are of stretches in which the robot held still already.
    fn knows_stays(&self) -> bool {
        false
    }

    /// The support and the other link that stands, where each row has a contact of both.
    fn both(&self) -> Option<[String; 2]> {
        None
    }

    /// How much was read, and of how much if that is known: bytes or rows.
    fn progress(&self) -> (u64, Option<u64>);

    /// What is odd so far; drained by the call.
    fn warnings(&mut self) -> Vec<String> {
        Vec::new()
    }

    /// 64-bit hash of the file's bytes, once all of them were read and none passed over.
    fn hash(&self) -> u64;
}

/// A text, kept once where it is that of the row above.
pub(super) fn repeated(above: Option<&Arc<str>>, text: &str) -> Arc<str> {
    match above {
        Some(own) if **own == *text => own.clone(),
        _ => text.into(),
    }
}

/// The pose of a row that has no value there.
pub(super) const MISSING: i64 = i64::MIN;

/// A pose as a number; integers up to 2^53 come through floats unchanged.
pub(super) fn whole(value: f64) -> Result<i64, String> {
    if value.is_nan() {
        Ok(MISSING)
    } else if value.fract() == 0.0 && value.abs() <= 9_007_199_254_740_992.0 {
        Ok(value as i64)
    } else {
        Err(format!(
            "column `{POSE}`: {value} is no whole number below 2^53"
        ))
    }
}

thread_local! {
    static GUARDED: Cell<bool> = const { Cell::new(false) };
}

/// Whether a panic on this thread becomes an error of the log that is being read.
///
/// The Parquet library meets some damaged files with a panic, which is caught. The panic
/// hook runs before that and by default prints a message; it belongs to the application, so
/// this library leaves it alone. An application may set one that is silent where this
/// is true, as the command line does:
///
/// ```
/// let usual = std::panic::take_hook();
/// std::panic::set_hook(Box::new(move |about| {
///     if !sesc_identify::logs::panic_becomes_error() {
///         usual(about);
///     }
/// }));
/// ```
pub fn panic_becomes_error() -> bool {
    GUARDED.get()
}

/// What `step` gives; none where it panics.
#[cfg(feature = "parquet")]
pub(super) fn catch_panic<T>(step: impl FnOnce() -> T) -> Option<T> {
    GUARDED.set(true);
    let done = panic::catch_unwind(AssertUnwindSafe(step));
    GUARDED.set(false);
    done.ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn equal_texts_are_kept_once() {
        let first = repeated(None, "a");
        assert!(Arc::ptr_eq(&first, &repeated(Some(&first), "a")));
        assert_eq!(&*repeated(Some(&first), "b"), "b");
    }
}

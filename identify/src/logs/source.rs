//! What every format delivers: rows of numbers as they stand in the file.

use std::collections::HashSet;
use std::sync::Arc;

use super::columns::{Columns, POSE};
use super::contacts::Share;
use crate::{Error, Message};

/// Rows of a file before anything is made of them.
#[derive(Debug, Clone, Default)]
pub(super) struct Raw {
    pub line: Vec<u64>,
    /// Empty where the log has no such column; [`MISSING`] where a row has no value.
    pub pose: Vec<i64>,
    /// Empty where the log has no such column.
    pub support: Vec<Arc<str>>,
    /// Row by row, in the order of [`Columns::numbers`]. Not yet known to be
    /// finite; a missing value is NaN.
    pub numbers: Vec<f64>,
    /// The other contact of rows of both feet; empty of other logs.
    pub other: Vec<Share>,
}

impl Raw {
    /// Forget all rows, keeping the room for them.
    pub fn clear(&mut self) {
        self.line.clear();
        self.pose.clear();
        self.support.clear();
        self.numbers.clear();
        self.other.clear();
    }
}

/// A file of some format, read row by row.
pub(super) trait RowSource: Send {
    /// Names of the columns, without blanks around them.
    fn header(&self) -> &[String];

    /// The line or row of these names.
    fn names_line(&self) -> u64 {
        1
    }

    /// Append up to `count` rows to `raw`; fewer only at the end of the file.
    fn fill(&mut self, columns: &Columns, count: usize, raw: &mut Raw) -> Result<(), Error>;

    /// Pass over about `rows` rows without a look at them.
    fn skip(&mut self, columns: &Columns, rows: u64) -> Result<(), Error>;

    /// Whether rows are of stretches in which the robot held still already.
    fn knows_stays(&self) -> bool {
        false
    }

    /// The support and the other link that stands, where each row has a contact of both.
    fn both(&self) -> Option<[String; 2]> {
        None
    }

    /// Whether it is text, whatever its name says.
    fn is_text(&self) -> bool {
        false
    }

    /// How much was read, and of how much if that is known: bytes or rows.
    fn progress(&self) -> (u64, Option<u64>);

    /// What is odd so far; drained by the call.
    fn warnings(&mut self) -> Vec<Message> {
        Vec::new()
    }

    /// 64-bit hash of the file's bytes, once all of them were read and none passed over.
    fn hash(&self) -> u64;
}

/// Repeated texts, each kept once.
#[derive(Debug, Default)]
pub(super) struct Interner(HashSet<Arc<str>>);

impl Interner {
    /// A log that names more links than this names no links: no longer kept.
    const MOST: usize = 10_000;

    pub fn get(&mut self, text: &str) -> Arc<str> {
        if let Some(known) = self.0.get(text) {
            return known.clone();
        }
        let new: Arc<str> = text.into();
        if self.0.len() < Interner::MOST {
            self.0.insert(new.clone());
        }
        new
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn equal_texts_are_kept_once() {
        let mut interner = Interner::default();
        assert!(Arc::ptr_eq(&interner.get("a"), &interner.get("a")));
    }
}

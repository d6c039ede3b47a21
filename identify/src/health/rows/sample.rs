//! Which rows of a log are looked at: all of a short one, stretches over the whole of a long one.
//!
//! ```text
//! │ FIRST rows │   │ PIECE │   │ PIECE │  …  │ PIECE │        ROWS in all, the last at the end
//! ```
//!
//! Between the pieces the file is passed over without being parsed; messages of a recording (MCAP)
//! are read, and their rows not kept. A log whose length is not known (a pipe) is looked at from
//! its first row on.

use super::ROWS;
use crate::Error;
use crate::logs::{Block, PostureReader};

/// Rows before the first gap: a chunk of the reader, which tells how long rows are.
const FIRST: usize = 4096;
/// Rows between gaps: 10 s at 100 Hz.
const PIECE: usize = 1024;
const PIECES: u64 = ((ROWS - FIRST) / PIECE) as u64;

/// How far a log was looked at.
#[derive(Debug, Default)]
pub(super) struct Sample {
    /// Rows that were taken.
    taken: usize,
    /// Rows that were passed over, about.
    passed: u64,
    /// Pieces that are to come; none where rows follow each other.
    to_come: Option<u64>,
    /// Whether rows may be left that were not looked at.
    pub is_part: bool,
}

impl Sample {
    /// The next rows that are looked at; none after the last.
    ///
    /// # Errors
    /// What is wrong with the log.
    pub fn next(&mut self, reader: &mut PostureReader) -> Result<Option<Block>, Error> {
        let block = match self.to_come {
            _ if self.taken >= ROWS => return Ok(None),
            // Rows of the end may still wait for the end of their stay.
            Some(0) => reader.block(PIECE).unwrap_or_default(),
            Some(pieces) => {
                let Some(rows) = self.rows_left(reader) else {
                    return Ok(None);
                };
                let between = (rows / pieces).saturating_sub(PIECE as u64);
                // Behind a gap a quoted line end may look like a row; who reads all of the log
                // says what is wrong with it.
                let piece = reader
                    .skip(between, PIECE)
                    .and_then(|_| reader.block(PIECE));
                let Ok(block) = piece else {
                    return Ok(None);
                };
                self.passed += between;
                self.to_come = Some(pieces - 1);
                block
            }
            None => {
                let block = reader.block(FIRST)?;
                if self.taken == 0 {
                    let left = self.rows_left(reader).unwrap_or(0);
                    if left > (ROWS - FIRST) as u64 && reader.skip(0, PIECE)? {
                        (self.to_come, self.is_part) = (Some(PIECES), true);
                    }
                }
                block
            }
        };
        self.taken += block.len();
        if self.taken >= ROWS {
            self.is_part = true;
        }
        Ok((!block.is_empty()).then_some(block))
    }

    /// About so many rows are behind the last one, if they are as long as those before; none
    /// where that is not known.
    fn rows_left(&self, reader: &PostureReader) -> Option<u64> {
        let (done, total) = reader.progress();
        // More than were given out where rows wait for the end of their stay.
        let rows = (reader.taken() + self.passed).max(1);
        let per_row = done as f64 / rows as f64;
        Some((total?.saturating_sub(done) as f64 / per_row.max(1e-9)) as u64)
    }
}

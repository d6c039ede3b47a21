//! The bytes of a CSV file on their way to the parser.

use std::io::{self, Read};
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

/// A row longer than this is no posture, bytes.
const LONGEST_ROW: u64 = 4 << 20;

/// Input for the parser: rows end in `\n`, the last one too, and none is
/// endless, since an open quote could swallow the whole file.
pub(super) struct RowInput<R> {
    input: R,
    since_row: Arc<AtomicU64>,
    /// A `\r` of which it is not yet known whether a `\n` follows.
    held: bool,
    last: u8,
    ended: bool,
}

impl<R: Read> RowInput<R> {
    pub fn new(input: R, since_row: Arc<AtomicU64>) -> RowInput<R> {
        RowInput {
            input,
            since_row,
            held: false,
            last: 0,
            ended: false,
        }
    }

    /// Drop each `\r` before a `\n` from `bytes`; how many are left.
    fn unify(&mut self, bytes: &mut [u8]) -> usize {
        if !bytes.contains(&b'\r') {
            self.held = false;
            return bytes.len();
        }
        let mut to = 0;
        for from in 0..bytes.len() {
            if bytes[from] == b'\n' && to > 0 && bytes[to - 1] == b'\r' {
                to -= 1;
            }
            bytes[to] = bytes[from];
            to += 1;
        }
        self.held = to > 0 && bytes[to - 1] == b'\r';
        to - usize::from(self.held)
    }
}

impl<R: Read> Read for RowInput<R> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        if self.since_row.load(Ordering::Relaxed) > LONGEST_ROW {
            return Err(io::Error::other(format!(
                "a row of more than {} MiB; is a quote left open, or is this no log?",
                LONGEST_ROW >> 20
            )));
        }
        // Room for a held byte and a new one; the parser gives thousands.
        if self.ended || buffer.len() < 2 {
            return Ok(0);
        }
        loop {
            let start = usize::from(self.held);
            buffer[0] = b'\r';
            let n = self.input.read(&mut buffer[start..])?;
            let kept = if n > 0 {
                self.unify(&mut buffer[..start + n])
            } else {
                self.ended = true;
                if self.held || self.last == b'\n' {
                    return Ok(start);
                }
                buffer[0] = b'\n';
                1
            };
            if kept > 0 {
                self.last = buffer[kept - 1];
                self.since_row.fetch_add(kept as u64, Ordering::Relaxed);
                return Ok(kept);
            }
        }
    }
}

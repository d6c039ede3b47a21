//! The bytes of a CSV file on their way to the parser.

use std::io::{self, Cursor, Read};
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use memchr::{memchr, memchr_iter};

/// A row longer than this is no posture, bytes.
const LONGEST_ROW: u64 = 4 << 20;

/// Bytes that are taken at once where rows are passed over.
const PASSED_AT_ONCE: usize = 256 << 10;

/// Rows that are passed over.
#[derive(Debug, Default)]
pub(super) struct Passing {
    /// Bytes that are to be, and the rest of the row that these end in.
    pub bytes: AtomicU64,
    /// Lines that were.
    pub lines: AtomicU64,
}

/// Input for the parser: rows end in `\n`, the last one too, and none is
/// endless, since an open quote could swallow the whole file.
pub(super) struct RowInput<R> {
    input: R,
    since_row: Arc<AtomicU64>,
    passing: Arc<Passing>,
    /// Bytes that were taken from the input and not yet given out.
    rest: Cursor<Vec<u8>>,
    /// A `\r` of which it is not yet known whether a `\n` follows.
    held: bool,
    last: u8,
    ended: bool,
}

impl<R: Read> RowInput<R> {
    pub fn new(input: R, since_row: Arc<AtomicU64>, passing: Arc<Passing>) -> RowInput<R> {
        RowInput {
            input,
            since_row,
            passing,
            rest: Cursor::default(),
            held: false,
            last: 0,
            ended: false,
        }
    }

    fn take(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        match self.rest.read(buffer)? {
            0 => self.input.read(buffer),
            n => Ok(n),
        }
    }

    /// Take bytes; no more than the end of a row where rows behind it are to be passed over.
    fn next(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let passed_over = self.passing.bytes.load(Ordering::Relaxed);
        if passed_over == 0 {
            return self.take(buffer);
        }
        if self.last == b'\n' && !self.held {
            self.passing.bytes.store(0, Ordering::Relaxed);
            self.pass(passed_over)?;
            return self.take(buffer);
        }
        let n = self.take(buffer)?;
        let Some(end) = memchr(b'\n', &buffer[..n]) else {
            return Ok(n);
        };
        self.put_back(&buffer[end + 1..n]);
        Ok(end + 1)
    }

    /// Bytes that are given out before the others.
    fn put_back(&mut self, bytes: &[u8]) {
        let mut rest = bytes.to_vec();
        let at = usize::try_from(self.rest.position()).unwrap_or(usize::MAX);
        rest.extend(self.rest.get_ref().get(at..).unwrap_or_default());
        self.rest = Cursor::new(rest);
    }

    /// Pass over so many bytes, and the row that these end in.
    fn pass(&mut self, bytes: u64) -> io::Result<()> {
        let mut left = usize::try_from(bytes).unwrap_or(usize::MAX);
        let mut buffer = vec![0; PASSED_AT_ONCE];
        loop {
            let n = self.take(&mut buffer)?;
            if n == 0 {
                return Ok(());
            }
            let whole = n.min(left);
            left -= whole;
            let end = memchr(b'\n', &buffer[whole..n]);
            let passed = end.map_or(n, |end| whole + end + 1);
            let lines = memchr_iter(b'\n', &buffer[..passed]).count() as u64;
            self.passing.lines.fetch_add(lines, Ordering::Relaxed);
            if end.is_some() {
                self.put_back(&buffer[passed..n]);
                return Ok(());
            }
        }
    }

    /// Drop each `\r` before a `\n` from `bytes`; how many are left.
    fn unify(&mut self, bytes: &mut [u8]) -> usize {
        if memchr(b'\r', bytes).is_none() {
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
            let n = self.next(&mut buffer[start..])?;
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

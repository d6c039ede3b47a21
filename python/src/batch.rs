//! Batches of postures: without the interpreter's lock, on threads of the call, stoppable.
//!
//! A batch is cut into chunks of whole blocks of the tape. Threads take one after the other;
//! the calling thread takes its own, and looks for signals between them.

use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, Ordering};

use pyo3::prelude::*;
use sesc_model::tape::BLOCK;

use crate::calls::Signals;
use crate::errors::{Doing, Failure};

/// Additions from which on the interpreter's lock is released: below ten microseconds' worth
/// where postures come one by one, and far below where they come in blocks.
const LONG: usize = 4_000;
/// Additions of a chunk: a fraction of a millisecond.
const CHUNK: usize = 1_000_000;
/// Chunks for each of several threads: at the end, one waits for the other's last.
const TURNS: usize = 8;

/// How many threads share a batch out.
pub(crate) struct Count(pub i64);

impl<'a, 'py> FromPyObject<'a, 'py> for Count {
    type Error = PyErr;

    fn extract(given: Borrowed<'a, 'py, PyAny>) -> PyResult<Count> {
        given.extract().map(Count).map_err(|_| {
            let said = given
                .repr()
                .map_or_else(|_| String::new(), |repr| repr.to_string());
            let message = format!("threads is {said}; give a whole number, 1 or more");
            Failure::plain(Doing::ArgumentType, message).raise(given.py())
        })
    }
}

/// A batch, and how it is shared out.
pub(crate) struct Batch {
    pub postures: usize,
    /// Values per posture of the result.
    pub width: usize,
    /// Cost of a posture, in additions.
    pub operations: usize,
    pub threads: i64,
}

impl Batch {
    /// `run(start, n, out)` evaluates n postures from `start` on.
    pub(crate) fn run(
        &self,
        py: Python<'_>,
        out: &mut [f64],
        run: impl Fn(usize, usize, &mut [f64]) + Sync + Send,
    ) -> PyResult<()> {
        let Some(threads) = usize::try_from(self.threads).ok().filter(|n| *n > 0) else {
            let message = format!("threads is {}; give 1 or more", self.threads);
            return Err(Failure::plain(Doing::Argument, message).raise(py));
        };
        if self.postures.saturating_mul(self.operations) < LONG {
            run(0, self.postures, out);
            return Ok(());
        }
        py.detach(|| self.in_chunks(threads, out, run))
    }

    fn in_chunks(
        &self,
        threads: usize,
        out: &mut [f64],
        run: impl Fn(usize, usize, &mut [f64]) + Sync + Send,
    ) -> PyResult<()> {
        let blocks = self.postures.div_ceil(BLOCK);
        let threads = threads.min(blocks.max(1));
        let most = CHUNK / (BLOCK * self.operations.max(1));
        let turns = if threads > 1 { TURNS } else { 1 };
        let chunk = BLOCK * blocks.div_ceil(threads * turns).min(most).max(1);
        let chunks = out.chunks_mut(chunk * self.width.max(1)).enumerate();
        let (chunks, stop) = (Mutex::new(chunks), AtomicBool::new(false));
        let next = || {
            let mut chunks = chunks.lock().ok()?;
            chunks.next().filter(|_| !stop.load(Ordering::Relaxed))
        };
        let work = |(k, out): (usize, &mut [f64])| {
            let start = k * chunk;
            run(start, chunk.min(self.postures - start), out);
        };
        std::thread::scope(|scope| {
            for _ in 1..threads {
                scope.spawn(|| {
                    while let Some(chunk) = next() {
                        work(chunk);
                    }
                });
            }
            let mut signals = Signals::new();
            while let Some(chunk) = next() {
                work(chunk);
                if let Err(signal) = signals.look() {
                    stop.store(true, Ordering::Relaxed);
                    return Err(signal);
                }
            }
            Ok(())
        })
    }
}

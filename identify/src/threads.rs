//! Work that is done side by side, and comes to the same by any number of threads.

use std::ops::Range;
use std::panic::resume_unwind;
use std::sync::{Mutex, PoisonError};
use std::thread::{self, Builder};

/// Processors that there are.
pub(crate) fn processors() -> usize {
    thread::available_parallelism().map_or(1, usize::from)
}

/// What `work` makes of each of `items`, which are about `rows` rows, in their order.
pub fn each<T: Send, R: Send>(
    rows: usize,
    items: impl IntoIterator<Item = T>,
    work: impl Fn(T) -> R + Sync,
) -> Vec<R> {
    // With fewer rows a thread takes longer to start than it helps.
    if rows < 1024 {
        return items.into_iter().map(work).collect();
    }
    each_long(items, work)
}

/// The same where an item is work for longer than a thread takes to start.
pub fn each_long<T: Send, R: Send>(
    items: impl IntoIterator<Item = T>,
    work: impl Fn(T) -> R + Sync,
) -> Vec<R> {
    let items: Vec<T> = items.into_iter().collect();
    let mut done: Vec<Option<R>> = items.iter().map(|_| None).collect();
    let threads = processors().min(items.len());
    let queue = Mutex::new(items.into_iter().zip(&mut done));
    let next = || queue.lock().unwrap_or_else(PoisonError::into_inner).next();
    let all = || {
        while let Some((item, place)) = next() {
            *place = Some(work(item));
        }
    };
    thread::scope(|scope| {
        for _ in 1..threads {
            // Where no thread starts, there are fewer: nothing of the queue is lost.
            let _ = Builder::new().spawn_scoped(scope, all);
        }
        all();
    });
    drop(queue);
    done.into_iter().flatten().collect()
}

/// What two pieces of work make that know nothing of each other, side by side.
pub fn both<A: Send, B>(first: impl Fn() -> A + Sync, second: impl FnOnce() -> B) -> (A, B) {
    thread::scope(|scope| {
        let thread = Builder::new().spawn_scoped(scope, &first);
        let second = second();
        let first = match thread {
            Ok(thread) => thread.join().unwrap_or_else(|panic| resume_unwind(panic)),
            // No thread starts: one after the other.
            Err(_) => first(),
        };
        (first, second)
    })
}

/// What `work` makes of each `part` of some `rows`, in their order.
pub(crate) fn by_parts<R: Send>(
    rows: Range<usize>,
    part: usize,
    work: impl Fn(Range<usize>) -> R + Sync,
) -> Vec<R> {
    let starts = rows.clone().step_by(part);
    each(rows.len(), starts, |start| {
        work(start..rows.end.min(start + part))
    })
}

//! Rows on their way into folds, on threads of their own while the next rows are read.
//!
//! ```text
//! rows of a block ─▶ at most one waits ─▶ thread 1: folds 0, 2, 4, …
//!                                      ─▶ thread 2: folds 1, 3, 5, …
//! ```
//!
//! Each fold is worked on by one thread, in the order of the rows: what it comes to does not
//! depend on how many threads there are.

use std::mem;
use std::panic;
use std::sync::Arc;
use std::sync::mpsc::{SyncSender, sync_channel};
use std::thread::{Builder, JoinHandle};

use nalgebra::DVector;

use super::Fold;
use crate::observations::row_matrix::RowMatrix;
use crate::threads::processors;

/// Blocks that wait for a thread, at most.
const WAITING: usize = 1;
/// Threads, at most: reading takes as long as folding by so many.
const MOST: usize = 4;

/// What becomes of rows.
pub(super) enum Goal {
    /// They are weighed; and taken as they are where one number, the deviation that all of a fold
    /// have, does not make those of them.
    Both(Vec<Option<f64>>),
    /// They are weighed alone.
    Weighted,
    /// They are taken as they are.
    Plain,
}

/// Numbers of the rows of one fold, and their weights.
pub(super) type Share = Vec<(usize, f64)>;

/// Rows for all folds.
pub(super) struct Work {
    pub matrix: RowMatrix,
    pub reading: DVector<f64>,
    /// One of each fold.
    pub shares: Vec<Share>,
    pub goal: Goal,
}

impl Work {
    fn fold(&self, index: usize, fold: &mut Fold) {
        let share = &self.shares[index];
        if share.is_empty() {
            return;
        }
        let (matrix, reading) = (&self.matrix, &self.reading);
        let weighted = share.iter().copied();
        let plain = share.iter().map(|(row, _)| (*row, 1.0));
        match &self.goal {
            Goal::Weighted => fold.weighted.push_rows(matrix, reading, weighted),
            Goal::Plain => {
                if let Some(own) = &mut fold.plain {
                    own.push_rows(matrix, reading, plain);
                }
            }
            Goal::Both(each) => {
                if !each[index].is_some_and(|each| fold.takes(each)) {
                    fold.part_plain().push_rows(matrix, reading, plain);
                }
                fold.weighted.push_rows(matrix, reading, weighted);
            }
        }
    }
}

/// A thread with the folds that it works on.
struct Worker {
    work: SyncSender<Arc<Work>>,
    folds: JoinHandle<Vec<(usize, Fold)>>,
}

/// The threads, from the first large block of a log to its end; none otherwise.
#[derive(Default)]
pub(in crate::fit) struct Folding(Vec<Worker>);

impl Folding {
    /// Let threads work on `folds` until [`Folding::end`], if there are processors for them.
    pub fn begin(&mut self, folds: &mut [Fold]) {
        if !self.0.is_empty() {
            return;
        }
        let count = (processors() - 1).min(MOST).min(folds.len());
        for worker in 0..count {
            let (to, work) = sync_channel::<Arc<Work>>(WAITING);
            // Where no thread starts, the folds are not lost with it.
            let (hand_over, take) = sync_channel::<Vec<(usize, Fold)>>(1);
            let spawned = Builder::new().name("folds".into()).spawn(move || {
                let mut own = take.recv().unwrap_or_default();
                for work in work {
                    for (index, fold) in &mut own {
                        work.fold(*index, fold);
                    }
                }
                own
            });
            let Ok(handle) = spawned else {
                self.end(folds);
                return;
            };
            let own = folds.iter_mut().enumerate().skip(worker).step_by(count);
            let own = own.map(|(index, fold)| {
                let empty = Fold::new(fold.weighted.params());
                (index, mem::replace(fold, empty))
            });
            // It waits for them.
            let _ = hand_over.send(own.collect());
            self.0.push(Worker {
                work: to,
                folds: handle,
            });
        }
    }

    /// Fold rows in, now or soon.
    pub(super) fn push(&mut self, work: Work, folds: &mut [Fold]) {
        if self.0.is_empty() {
            for (index, fold) in folds.iter_mut().enumerate() {
                work.fold(index, fold);
            }
            return;
        }
        let work = Arc::new(work);
        for worker in &self.0 {
            // A thread that has ended says why when it is joined.
            let _ = worker.work.send(Arc::clone(&work));
        }
    }

    /// Wait for the threads, and take the folds back.
    pub fn end(&mut self, folds: &mut [Fold]) {
        for worker in self.0.drain(..) {
            drop(worker.work);
            match worker.folds.join() {
                Ok(own) => own
                    .into_iter()
                    .for_each(|(index, fold)| folds[index] = fold),
                Err(payload) => panic::resume_unwind(payload),
            }
        }
    }
}

//! A log that is read on a thread of its own while its rows are worked on.
//!
//! ```text
//! file ─▶ reader (thread) ─▶ at most two blocks wait ─▶ whoever takes them
//! ```
//!
//! Blocks come in the same order and with the same rows as from the reader itself, so that
//! nothing depends on which of the two is faster.

use std::panic;
use std::sync::mpsc::{Receiver, SyncSender, sync_channel};
use std::thread::{Builder, JoinHandle};

use super::block::Block;
use super::reader::{PostureReader, Summary};
use super::sidecar::Sidecar;
use crate::{Error, Message};

/// Blocks that wait to be taken, at most.
const WAITING: usize = 2;

/// A block and what the reader says after it.
struct Step {
    block: Block,
    warnings: Vec<Message>,
    progress: (u64, Option<u64>),
    averaged: f64,
    summary: Option<Summary>,
}

/// A reader of postures that reads ahead.
pub struct Ahead {
    source: Source,
    /// What the log's sidecar says.
    pub sidecar: Sidecar,
    /// What is odd about the log so far, complete after the last block.
    pub warnings: Vec<Message>,
    progress: (u64, Option<u64>),
    averaged: f64,
    summary: Option<Summary>,
}

enum Source {
    /// Nothing was asked for yet, or there are no threads.
    Here(Box<PostureReader>),
    Thread(Thread),
    Ended,
}

/// The thread that reads. It ends by itself once nobody takes its blocks: nobody waits for it,
/// since a pipe may have nothing more to say.
struct Thread {
    steps: Receiver<Result<Step, Error>>,
    handle: Option<JoinHandle<()>>,
}

impl Ahead {
    /// Read on with `reader`, ahead from the first block on that is asked for.
    pub fn new(mut reader: PostureReader) -> Ahead {
        Ahead {
            sidecar: reader.sidecar.clone(),
            warnings: std::mem::take(&mut reader.warnings),
            progress: reader.progress(),
            averaged: reader.averaged(),
            summary: reader.summary(),
            source: Source::Here(Box::new(reader)),
        }
    }

    /// The next rows, `count` at most; an empty block is the end of the log. Blocks that were
    /// read ahead have as many rows as the first call asked for.
    ///
    /// # Errors
    /// As [`PostureReader::block`].
    pub fn block(&mut self, count: usize) -> Result<Block, Error> {
        self.source = match std::mem::replace(&mut self.source, Source::Ended) {
            Source::Here(reader) => Source::started(reader, count),
            other => other,
        };
        let step = match &mut self.source {
            Source::Here(reader) => step(reader, count)?,
            Source::Thread(thread) => match thread.next() {
                Some(step) => step?,
                None => return Ok(Block::default()),
            },
            Source::Ended => return Ok(Block::default()),
        };
        self.warnings.extend(step.warnings);
        self.progress = step.progress;
        self.averaged = step.averaged;
        self.summary = step.summary;
        Ok(step.block)
    }

    /// See [`PostureReader::progress`]; of the blocks that were taken.
    pub fn progress(&self) -> (u64, Option<u64>) {
        self.progress
    }

    /// See [`PostureReader::averaged`].
    pub fn averaged(&self) -> f64 {
        self.averaged
    }

    /// See [`PostureReader::summary`].
    pub fn summary(&self) -> Option<Summary> {
        self.summary.clone()
    }
}

impl Source {
    /// Read ahead on a thread, if there are threads.
    fn started(reader: Box<PostureReader>, count: usize) -> Source {
        let (to, steps) = sync_channel(WAITING);
        // Where no thread starts, the reader is not lost with it.
        let (hand_over, take) = sync_channel(1);
        let thread = Builder::new().name("log".into()).spawn(move || {
            if let Ok(reader) = take.recv() {
                read(reader, count, &to);
            }
        });
        let Ok(handle) = thread else {
            return Source::Here(reader);
        };
        match hand_over.send(reader) {
            Ok(()) => Source::Thread(Thread {
                steps,
                handle: Some(handle),
            }),
            Err(unsent) => Source::Here(unsent.0),
        }
    }
}

/// Read to the end, to the first error, or until nobody listens.
fn read(mut reader: Box<PostureReader>, count: usize, to: &SyncSender<Result<Step, Error>>) {
    loop {
        let step = step(&mut reader, count);
        let last = step.as_ref().map_or(true, |step| step.block.is_empty());
        if to.send(step).is_err() || last {
            return;
        }
    }
}

fn step(reader: &mut PostureReader, count: usize) -> Result<Step, Error> {
    Ok(Step {
        block: reader.block(count)?,
        warnings: std::mem::take(&mut reader.warnings),
        progress: reader.progress(),
        averaged: reader.averaged(),
        summary: reader.summary(),
    })
}

impl Thread {
    /// None after the last block; a panic of the reader is the caller's.
    fn next(&mut self) -> Option<Result<Step, Error>> {
        if let Ok(step) = self.steps.recv() {
            return Some(step);
        }
        if let Some(Err(reason)) = self.handle.take().map(JoinHandle::join) {
            panic::resume_unwind(reason);
        }
        None
    }
}

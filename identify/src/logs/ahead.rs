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
    source: BlockSource,
    /// What the log's sidecar says.
    pub sidecar: Sidecar,
    /// What is odd about the log so far, complete after the last block.
    pub warnings: Vec<Message>,
    /// What the reader said after the block that was taken last.
    last: Step,
}

enum BlockSource {
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
            last: Step::after(&mut reader, Block::default()),
            source: BlockSource::Here(Box::new(reader)),
        }
    }

    /// The next rows, `count` at most; an empty block is the end of the log. Blocks that were
    /// read ahead have as many rows as the first call asked for.
    ///
    /// # Errors
    /// As [`PostureReader::block`].
    pub fn block(&mut self, count: usize) -> Result<Block, Error> {
        self.source = match std::mem::replace(&mut self.source, BlockSource::Ended) {
            BlockSource::Here(reader) => BlockSource::started(reader, count),
            other => other,
        };
        self.last = match &mut self.source {
            BlockSource::Here(reader) => Step::next(reader, count)?,
            BlockSource::Thread(thread) => match thread.next() {
                Some(step) => step?,
                None => return Ok(Block::default()),
            },
            BlockSource::Ended => return Ok(Block::default()),
        };
        self.warnings.append(&mut self.last.warnings);
        Ok(std::mem::take(&mut self.last.block))
    }

    /// See [`PostureReader::progress`]; of the blocks that were taken.
    pub fn progress(&self) -> (u64, Option<u64>) {
        self.last.progress
    }

    /// See [`PostureReader::averaged`].
    pub fn averaged(&self) -> f64 {
        self.last.averaged
    }

    /// See [`PostureReader::summary`].
    pub fn summary(&self) -> Option<Summary> {
        self.last.summary.clone()
    }
}

impl BlockSource {
    /// Read ahead on a thread, if there are threads.
    fn started(reader: Box<PostureReader>, count: usize) -> BlockSource {
        let (to, steps) = sync_channel(WAITING);
        // Where no thread starts, the reader is not lost with it.
        let (hand_over, take) = sync_channel(1);
        let thread = Builder::new().name("log".into()).spawn(move || {
            if let Ok(reader) = take.recv() {
                read(reader, count, &to);
            }
        });
        let Ok(handle) = thread else {
            return BlockSource::Here(reader);
        };
        match hand_over.send(reader) {
            Ok(()) => BlockSource::Thread(Thread {
                steps,
                handle: Some(handle),
            }),
            Err(unsent) => BlockSource::Here(unsent.0),
        }
    }
}

/// Read to the end, to the first error, or until nobody listens.
fn read(mut reader: Box<PostureReader>, count: usize, to: &SyncSender<Result<Step, Error>>) {
    loop {
        let step = Step::next(&mut reader, count);
        let last = step.as_ref().map_or(true, |step| step.block.is_empty());
        if to.send(step).is_err() || last {
            return;
        }
    }
}

impl Step {
    fn next(reader: &mut PostureReader, count: usize) -> Result<Step, Error> {
        let block = reader.block(count)?;
        Ok(Step::after(reader, block))
    }

    fn after(reader: &mut PostureReader, block: Block) -> Step {
        Step {
            block,
            warnings: std::mem::take(&mut reader.warnings),
            progress: reader.progress(),
            averaged: reader.averaged(),
            summary: reader.summary(),
        }
    }
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

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::super::Options;
    use super::super::tests::{dofs, log};
    use super::*;

    /// So many rows in radians, of which row `odd` holds an angle that is no number.
    fn rows(count: usize, odd: Option<usize>) -> String {
        let mut text = String::from("pose,hip,knee,cop_x,cop_y\n");
        for k in 0..count {
            let knee = match odd == Some(k) {
                true => "bent".to_string(),
                false => format!("0.{k:03}"),
            };
            text += &format!("{k},0.5,{knee},0.01,0.02\n");
        }
        text
    }

    fn reader(path: &Path) -> PostureReader {
        PostureReader::open(path, &dofs(&["hip", "knee"]), &Options::default()).unwrap()
    }

    /// What a reader says until its log ends or fails, the empty block of the end included.
    fn told(mut next: impl FnMut() -> Result<Block, Error>) -> (Vec<Block>, Option<String>) {
        let mut blocks = Vec::new();
        loop {
            match next() {
                Ok(block) if block.is_empty() => return (blocks, None),
                Ok(block) => blocks.push(block),
                Err(error) => return (blocks, Some(error.to_string())),
            }
        }
    }

    #[test]
    fn a_reader_ahead_gives_what_the_reader_gives() {
        let (_folder, path) = log("log.csv", rows(2500, None).as_bytes(), "");
        let (mut plain, mut ahead) = (reader(&path), Ahead::new(reader(&path)));
        let expected = told(|| plain.block(100));
        assert_eq!((expected.0.len(), &expected.1), (25, &None));
        assert_eq!(told(|| ahead.block(100)), expected);
        // The end is told as often as it is asked for.
        assert!(ahead.block(100).unwrap().is_empty());
        let warnings = [&ahead.warnings, &plain.warnings].map(|all| format!("{all:?}"));
        assert_eq!(warnings[0], warnings[1]);
        assert_eq!(ahead.progress(), plain.progress());
        assert_eq!(ahead.averaged(), plain.averaged());
        assert_eq!(ahead.summary(), plain.summary());
        assert_eq!(ahead.summary().unwrap().rows, 2500);
    }

    #[test]
    fn an_error_comes_after_the_same_blocks_and_ends_the_log() {
        let (_folder, path) = log("log.csv", rows(20_000, Some(15_000)).as_bytes(), "");
        let (mut plain, mut ahead) = (reader(&path), Ahead::new(reader(&path)));
        let expected = told(|| plain.block(100));
        assert!(!expected.0.is_empty());
        assert!(expected.1.as_ref().unwrap().contains("15002"));
        assert_eq!(told(|| ahead.block(100)), expected);
        assert!(ahead.block(100).unwrap().is_empty());
    }

    #[test]
    fn a_log_that_is_left_in_the_middle_is_closed() {
        let (_folder, path) = log("log.csv", rows(20_000, None).as_bytes(), "");
        let mut ahead = Ahead::new(reader(&path));
        assert_eq!(ahead.block(10).unwrap().len(), 10);
        let BlockSource::Thread(mut thread) =
            std::mem::replace(&mut ahead.source, BlockSource::Ended)
        else {
            panic!("no thread reads");
        };
        let handle = thread.handle.take().unwrap();
        drop(thread);
        // The thread waits with its next block; nobody takes it, so that it ends.
        handle.join().unwrap();
    }
}

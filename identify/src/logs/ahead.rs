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
    /// The reader, until a block is asked for, and where there are no threads.
    reader: Option<Box<PostureReader>>,
    /// The thread that reads, whose blocks come one by one. It ends by itself once nobody takes
    /// them: nobody waits for it, since a pipe may have nothing more to say.
    thread: Option<(Receiver<Result<Step, Error>>, JoinHandle<()>)>,
    /// What the log's sidecar says.
    pub sidecar: Sidecar,
    /// What is odd about the log so far, complete after the last block.
    pub warnings: Vec<Message>,
    /// What the reader said after the block that was taken last.
    last: Step,
}

impl Ahead {
    /// Read on with `reader`, ahead from the first block on that is asked for.
    pub fn new(mut reader: PostureReader) -> Ahead {
        Ahead {
            sidecar: reader.sidecar.clone(),
            warnings: std::mem::take(&mut reader.warnings),
            last: Step::after(&mut reader, Block::default()),
            reader: Some(Box::new(reader)),
            thread: None,
        }
    }

    /// The next rows, `count` at most; an empty block is the end of the log. Blocks that were
    /// read ahead have as many rows as the first call asked for.
    ///
    /// # Errors
    /// As [`PostureReader::block`].
    pub fn block(&mut self, count: usize) -> Result<Block, Error> {
        if let Some(reader) = self.reader.take() {
            self.start(reader, count);
        }
        self.last = match (&mut self.reader, &self.thread) {
            (Some(reader), _) => Step::next(reader, count)?,
            (None, Some((steps, _))) => match steps.recv() {
                Ok(step) => step?,
                Err(_) => return self.ended(),
            },
            (None, None) => return Ok(Block::default()),
        };
        self.warnings.append(&mut self.last.warnings);
        Ok(std::mem::take(&mut self.last.block))
    }

    /// Read ahead on a thread, if there are threads.
    fn start(&mut self, reader: Box<PostureReader>, count: usize) {
        let (to, steps) = sync_channel(2);
        // Where no thread starts, the reader is not lost with it.
        let (hand_over, take) = sync_channel(1);
        let work = move || {
            if let Ok(reader) = take.recv() {
                read(reader, count, &to);
            }
        };
        match Builder::new().name("log".into()).spawn(work) {
            Ok(thread) => {
                self.thread = Some((steps, thread));
                self.reader = hand_over.send(reader).err().map(|unsent| unsent.0);
            }
            Err(_) => self.reader = Some(reader),
        }
    }

    /// The empty block after the last one; a panic of the reader is the caller's.
    fn ended(&mut self) -> Result<Block, Error> {
        if let Some((_, thread)) = self.thread.take()
            && let Err(reason) = thread.join()
        {
            panic::resume_unwind(reason);
        }
        Ok(Block::default())
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
        let (steps, handle) = ahead.thread.take().expect("no thread reads");
        drop(steps);
        // The thread waits with its next block; nobody takes it, so that it ends.
        handle.join().unwrap();
    }
}

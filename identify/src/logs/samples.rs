//! The rows of a log in memory, from one pass over its file.
//!
//! ```text
//! file ─▶ reader ─▶ rows in SI units ─▶ health, noise, factors, postures, figures
//! ```
//!
//! A log that is too long to be kept is read from its file each time its rows are asked for.

use std::sync::Arc;

use sesc_model::tree::Dof;
use sesc_model::urdf::Description;

use super::block::Block;
use super::bounds::LEAST_LOAD_N;
use super::input::{AllRows, LogSource, Screen, Screening};
use super::reader::{PostureReader, Summary, joints};
use super::settings::{Options, Sidecar};
use crate::watch::{Watch, tell};
use crate::{Error, Message};

/// Numbers that are kept of all logs of one call, at most: 16 MB.
pub(crate) const ROOM: usize = 1 << 21;
/// Numbers of a row beside its joints: readings, deviations, time, posture and their like.
const BESIDE: usize = 8;
/// Rows taken at once.
const BLOCK: usize = 4096;

/// A log of one robot, read in one way.
#[derive(Clone)]
pub struct Samples {
    /// The log, without what was found to be unusable.
    pub log: LogSource,
    dofs: Vec<Dof>,
    pub options: Options,
    /// What the sidecar says, completed by what a recording says itself.
    pub sidecar: Sidecar,
    kept: Option<Arc<Kept>>,
}

/// All rows of a log, and what its reader says of them.
struct Kept {
    rows: Block,
    /// Whether nothing stands on the foot cells in some row.
    unloaded: bool,
    summary: Option<Summary>,
    averaged: f64,
    warnings: Vec<Message>,
}

impl Samples {
    /// Read a log of `robot` as `options` say; its rows are kept if they have no more numbers than
    /// `room`: what logs beside it leave of [`ROOM`].
    ///
    /// # Errors
    /// Whatever is wrong with the log or its sidecar, as far as it was read; the kind `Interrupted`
    /// where `watch` stops it.
    pub fn read(
        log: &LogSource,
        robot: &Description,
        options: &Options,
        room: usize,
        watch: &mut dyn Watch,
    ) -> Result<Samples, Error> {
        let log = log.clone().unchanged()?;
        let support = match &options.support {
            Some(support) => Some(support.clone()),
            None => log.sidecar()?.0.support,
        };
        let dofs = joints(&log, robot, options, support.as_deref())?;
        Samples::of_joints(&log, dofs, options, room, watch)
    }

    /// The same of a log with columns of these joints.
    ///
    /// # Errors
    /// As [`read`](Self::read).
    pub fn of_joints(
        log: &LogSource,
        dofs: Vec<Dof>,
        options: &Options,
        room: usize,
        watch: &mut dyn Watch,
    ) -> Result<Samples, Error> {
        let log = log.clone();
        // Rows without load are judged when the log is looked at.
        let all = log.clone().screened(Arc::new(AllRows));
        let mut reader = PostureReader::open(&all, &dofs, options)?;
        let width = dofs.len() + BESIDE;
        let mut rows = Block::default();
        let mut ended = false;
        while !ended && rows.len() * width <= room && !exceeds(&reader, room / width) {
            let block = reader.block(BLOCK)?;
            ended = block.is_empty();
            rows.append(block);
            let (done, total) = reader.progress();
            tell(watch, "reading", done, total)?;
        }
        Ok(Samples {
            log,
            dofs,
            options: options.clone(),
            sidecar: reader.sidecar.clone(),
            kept: ended.then(|| {
                let loads = rows.cells.iter();
                let mut loads =
                    loads.flat_map(|cells| cells.force.chunks_exact(cells.count.max(1)));
                Arc::new(Kept {
                    unloaded: loads.any(|forces| forces.iter().sum::<f64>() < LEAST_LOAD_N),
                    rows,
                    summary: reader.summary(),
                    averaged: reader.averaged(),
                    warnings: reader.warnings,
                })
            }),
        })
    }

    /// The same log without what the screen leaves out.
    pub fn screened(self, screen: Arc<dyn Screen>) -> Samples {
        Samples {
            log: self.log.screened(screen),
            ..self
        }
    }

    /// Its rows, from the first on.
    ///
    /// # Errors
    /// Where they were not kept, those of [`PostureReader::open`].
    pub fn rows(&self) -> Result<Rows, Error> {
        let screening = self.log.screen.as_ref().map(|screen| screen.start());
        match &self.kept {
            // The reader says which row is without load.
            Some(kept) if screening.is_some() || !kept.unloaded => Ok(Rows {
                warnings: kept.warnings.clone(),
                from: From::Memory(Arc::clone(kept), 0, 0),
                screening,
            }),
            _ => Ok(PostureReader::open(&self.log, &self.dofs, &self.options)?.into()),
        }
    }

    /// The reader of a log that was not kept, all of whose rows it gives.
    ///
    /// # Errors
    /// As [`rows`](Self::rows).
    pub fn all_rows(&self) -> Result<Rows, Error> {
        let screened = self.clone().screened(Arc::new(AllRows));
        screened.rows()
    }

    /// The link that its first row stands on; empty where the log does not say.
    ///
    /// # Errors
    /// As [`rows`](Self::rows).
    pub fn first_support(&self) -> Result<Option<Arc<str>>, Error> {
        match &self.kept {
            Some(kept) => Ok(kept
                .rows
                .support
                .as_ref()
                .and_then(|all| all.first().cloned())),
            None => PostureReader::open(&self.log, &self.dofs, &self.options)?.first_support(),
        }
    }

    /// Numbers that are kept of it.
    pub fn size(&self) -> usize {
        let rows = self.kept.as_ref().map_or(0, |kept| kept.rows.len());
        rows * (self.dofs.len() + BESIDE)
    }

    /// Joints of a row.
    pub fn dof(&self) -> usize {
        self.dofs.len()
    }
}

/// Whether a reader that has given some rows has clearly more than `most`.
fn exceeds(reader: &PostureReader, most: usize) -> bool {
    let (done, total) = reader.progress();
    let rows = reader.taken() as f64;
    let all = total.map_or(0.0, |total| rows * total as f64 / (done as f64).max(1.0));
    all > 2.0 * most as f64
}

/// Rows of a log on their way, from memory or from its file.
pub struct Rows {
    from: From,
    screening: Option<Screening>,
    /// What is odd about the log so far, complete after the last block.
    pub warnings: Vec<Message>,
}

enum From {
    /// Rows that were kept, the number of the next one, and how many were given out.
    Memory(Arc<Kept>, usize, u64),
    File(Box<PostureReader>),
}

impl std::convert::From<PostureReader> for Rows {
    fn from(mut reader: PostureReader) -> Rows {
        Rows {
            warnings: std::mem::take(&mut reader.warnings),
            from: From::File(Box::new(reader)),
            screening: None,
        }
    }
}

impl Rows {
    /// The next rows, `count` at most; an empty block is the end of the log.
    ///
    /// # Errors
    /// As [`PostureReader::block`].
    pub fn block(&mut self, count: usize) -> Result<Block, Error> {
        let (kept, next, given) = match &mut self.from {
            From::Memory(kept, next, given) => (kept, next, given),
            From::File(reader) => {
                let block = reader.block(count);
                self.warnings.append(&mut reader.warnings);
                return block;
            }
        };
        loop {
            let end = kept.rows.len().min(*next + count);
            let mut block = kept.rows.part(*next..end);
            let ended = block.is_empty();
            *given += block.len() as u64;
            *next = end;
            if let Some(screen) = &mut self.screening {
                screen(&mut block);
            }
            // A block of which nothing is left is not the end of the log.
            if ended || !block.is_empty() {
                return Ok(block);
            }
        }
    }

    /// Pass over about `rows` rows; see [`PostureReader::skip`].
    ///
    /// # Errors
    /// A file that cannot be read there.
    pub fn skip(&mut self, rows: u64, then: usize) -> Result<bool, Error> {
        match &mut self.from {
            From::Memory(kept, next, _) => {
                *next = kept.rows.len().min(*next + rows as usize);
                Ok(*next < kept.rows.len())
            }
            From::File(reader) => reader.skip(rows, then),
        }
    }

    /// Rows that were taken so far, those that were passed over not among them.
    pub fn taken(&self) -> u64 {
        match &self.from {
            From::Memory(_, _, given) => *given,
            From::File(reader) => reader.taken(),
        }
    }

    /// How much was read, and of how much, see [`PostureReader::progress`].
    pub fn progress(&self) -> (u64, Option<u64>) {
        match &self.from {
            From::Memory(kept, next, _) => (*next as u64, Some(kept.rows.len() as u64)),
            From::File(reader) => reader.progress(),
        }
    }

    /// What was read, see [`PostureReader::summary`].
    pub fn summary(&self) -> Option<Summary> {
        match &self.from {
            From::Memory(kept, ..) => kept.summary.clone(),
            From::File(reader) => reader.summary(),
        }
    }

    /// See [`PostureReader::averaged`].
    pub fn averaged(&self) -> f64 {
        match &self.from {
            From::Memory(kept, ..) => kept.averaged,
            From::File(reader) => reader.averaged(),
        }
    }
}

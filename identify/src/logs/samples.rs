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
use super::input::LogSource;
use super::reader::{BLOCK, Kept, PostureReader, Screening, joints};
use super::settings::{Options, Sidecar};
use super::weight::Weight;
use crate::Error;
use crate::watch::{Watch, tell};

/// Numbers that are kept of all logs of one call, at most: 16 MB.
pub(crate) const ROOM: usize = 1 << 21;
/// Numbers of a row beside its joints: readings, deviations, time, posture and their like.
const BESIDE: usize = 8;

/// Leaves rows out of a log, or says less of them, whenever it is read.
pub trait Screen: Send + Sync {
    /// Begin a reading of the log.
    fn start(&self) -> Screening;
}

/// A log of one robot, read in one way.
#[derive(Clone)]
pub struct Samples {
    pub log: LogSource,
    /// What leaves out rows that were found to be unusable.
    screen: Option<Arc<dyn Screen>>,
    dofs: Vec<Dof>,
    pub options: Options,
    /// What the sidecar says, completed by what a recording says itself.
    pub sidecar: Sidecar,
    /// What it weighs, where it has the total force and was looked at.
    pub weight: Option<Weight>,
    kept: Option<Arc<Kept>>,
    /// Whether nothing stands on the sensor in some row that is kept.
    unloaded: bool,
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
        let (sidecar, _) = log.sidecar()?;
        let support = options.support.as_deref().or(sidecar.support.as_deref());
        let dofs = joints(&log, robot, options, support)?;
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
        // Rows without load are judged when the log is looked at.
        let mut reader = PostureReader::open(log, &dofs, options)?.screened(Box::new(|_| {}));
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
        let is_loaded = |row: usize| rows.total_force(row).is_none_or(|n| n >= LEAST_LOAD_N);
        let unloaded = ended && !(0..rows.len()).all(is_loaded);
        Ok(Samples {
            log: log.clone(),
            screen: None,
            weight: None,
            dofs,
            options: options.clone(),
            sidecar: reader.sidecar.clone(),
            unloaded,
            kept: ended.then(|| {
                Arc::new(Kept {
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
            screen: Some(screen),
            ..self
        }
    }

    /// Its rows, from the first on.
    ///
    /// # Errors
    /// Where they were not kept, those of [`PostureReader::open`].
    pub fn rows(&self) -> Result<PostureReader, Error> {
        self.reader(self.screen.as_ref().map(|screen| screen.start()))
    }

    /// All of its rows, also those that the screen leaves out.
    ///
    /// # Errors
    /// As [`rows`](Self::rows).
    pub fn all_rows(&self) -> Result<PostureReader, Error> {
        self.reader(Some(Box::new(|_| {})))
    }

    fn reader(&self, screening: Option<Screening>) -> Result<PostureReader, Error> {
        let reader = match &self.kept {
            // The reader of the file says which row is without load.
            Some(kept) if screening.is_some() || !self.unloaded => {
                PostureReader::of_rows(kept, &self.sidecar)
            }
            _ => PostureReader::open(&self.log, &self.dofs, &self.options)?,
        };
        Ok(match screening {
            Some(screening) => reader.screened(screening),
            None => reader,
        })
    }

    /// The link that its first row stands on; empty where the log does not say.
    ///
    /// # Errors
    /// As [`rows`](Self::rows).
    pub fn first_support(&self) -> Result<Option<Arc<str>>, Error> {
        self.all_rows()?.first_support()
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

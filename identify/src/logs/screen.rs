//! What is left out of a log before anyone sees its rows.

use std::fmt::Debug;

use super::block::Block;

/// What becomes of each block, first row to last.
pub type Screening = Box<dyn FnMut(&mut Block) + Send>;

/// Leaves rows out of a log, or says less of them, whenever it is read.
///
/// A log with a screen may have rows in which nothing stands on the foot cells: their
/// reading is zero, and the screen is to take them out.
pub trait Screen: Debug + Send + Sync {
    /// Begin a reading of the log.
    fn start(&self) -> Screening;
}

//! Posture logs: joint angles of many postures and what the foot measured.
//!
//! ```text
//! input ─▶ csv, parquet, mcap, table ─▶ assemble ─▶ stillness ─▶ reader ─▶ blocks
//!          rows as they stand in it     checked, SI  stays
//!
//! settings, columns, names   what options, a sidecar and names of columns say of a log
//! bounds, suspect            what a value can be; what a whole log looks like it got wrong
//! writer                     logs and predictions
//! ```
//!
//! [`PostureReader`] gives a log of any [`LogSource`] in blocks of columns, so that a
//! million postures need the memory of one block; [`PostureWriter`] writes one.
//! The names of columns are in [`COLUMNS`], the sidecar's keys in [`Sidecar`].
//!
//! A fault is an error that names file, row, column and remedy. What is only
//! odd is a warning, see [`PostureReader::warnings`].

mod assemble;
mod block;
mod bounds;
mod columns;
pub(crate) mod criteria;
mod csv;
mod input;
#[cfg(feature = "mcap")]
mod mcap;
pub(crate) mod names;
#[cfg(feature = "parquet")]
mod parquet;
mod reader;
mod samples;
mod settings;
mod source;
mod stillness;
mod suspect;
mod table;
#[cfg(test)]
mod tests;
mod weight;
mod writer;

pub(crate) use block::keep_some;
pub use block::{Block, Cells};
#[doc(hidden)]
pub use block::{Frame, Soles};
pub(crate) use bounds::LEAST_LOAD_N;
pub use columns::{COLUMNS, Column, Need, Row, Written};
pub(crate) use csv::delimiter;
pub use input::LogSource;
pub(crate) use reader::{BLOCK, Screening, joints};
pub use reader::{PostureReader, Summary, column_names};
pub(crate) use samples::{ROOM, Samples, Screen};
#[doc(hidden)]
pub use settings::KEYS as SIDECAR_KEYS;
pub use settings::{Angles, Options, Readings, Sensor, Sidecar, Stays};
#[doc(hidden)]
pub use source::panic_becomes_error;
pub use table::{Table, Values};
pub use weight::{Quantity, Weight};
pub use writer::{PREDICTED, PostureWriter};

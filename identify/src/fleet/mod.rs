//! A fleet: a log per robot and day in, a row per robot and day out, and what the rows say
//! together.
//!
//! ```text
//! inputs ─▶ groups (robot, day or week) ─▶ row(URDF, options, logs) ─▶ table, Parquet or CSV
//!                                       ▲  │                     │
//!                              store: a file for each row        ▼
//!                                                  summary: shared effects, changes,
//!                                                  what to look at first
//! ```
//!
//! [`row`] is a pure function: the logs of a group are sorted by the hash of their content,
//! one that comes twice counts once, and nothing of the result depends on time, paths or the
//! order in which logs arrive. Whatever runs it (threads here, processes or machines
//! elsewhere) and however often, the table is the same to the byte. A log that cannot be
//! read is an error in its row and never the end of a run.
//!
//! [`summary`](summary::summary()) is a pure function of the rows.

mod cache;
mod evaluate;
mod inputs;
mod log;
mod options;
mod population;
mod row;
mod run;
pub mod summary;
mod table;

pub use cache::Store;
pub use evaluate::row;
pub use inputs::{Group, Input, groups, inputs};
#[doc(hidden)]
pub use log::content_hash;
pub use log::{Failed, Log};
pub use options::{Only, Options};
#[doc(hidden)]
pub use population::check_population;
pub use population::population;
pub use row::{EffectFound, Row, Size};
#[doc(hidden)]
pub use run::{Done, gathered, work};
pub use run::{Fleet, Request, Twice, run};
#[doc(hidden)]
pub use table::check_table;
pub use table::{COLUMNS, write};

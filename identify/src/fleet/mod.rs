//! A fleet: a log per robot and day in, a row per robot and day out, and what the rows say
//! together.
//!
//! ```text
//! inputs ─▶ groups (robot, day or window) ─▶ row(URDF, options, logs) ─▶ table, Parquet or CSV
//!                                        ▲  │                    │
//!                      store: rows, and a part of each log       ▼
//!                                                  summary: shared effects, changes,
//!                                                  what to look at first
//! ```
//!
//! [`row`] is a pure function: the logs of a group are sorted by the hash of their content,
//! one that comes twice counts once, and nothing of the result depends on time, paths or the
//! order in which logs arrive. Whatever runs it (threads here, processes or machines
//! elsewhere) and however often, the table is the same to the byte. A log that cannot be
//! read is an error in its row and never the end of a run. The parameters of a row come from
//! the parts of its logs (`part_of_log`), so that a group with a new log reads that one alone; a
//! diagnosis reads all of them.
//!
//! [`summary`](summary::summary()) is a pure function of the rows.

mod content;
mod desk;
mod disk;
mod evaluate;
mod failed;
mod gathering;
mod groups;
mod input;
mod inputs;
mod joined_logs;
mod known_logs;
mod manifest;
mod named_files;
mod options;
#[cfg(feature = "parquet")]
mod parquet;
mod part_of_log;
mod population;
mod row;
mod run;
mod store;
pub mod summary;
mod table;
mod windows;
mod work;

pub use content::Log;
#[doc(hidden)]
pub use content::content_hash;
#[doc(hidden)]
pub use disk::{Disk, Local, Stamp};
pub use evaluate::row;
pub use failed::Failed;
#[doc(hidden)]
pub use gathering::Gathering;
pub use gathering::{Fleet, Twice};
pub use groups::{Group, groups};
pub use input::Input;
#[doc(hidden)]
pub use input::is_address;
pub use inputs::inputs;
pub use options::{Only, Options};
#[doc(hidden)]
pub use population::check_population;
pub use population::population;
pub use row::{EffectFound, Row, Size};
pub use run::{Request, run};
pub use store::Store;
pub use table::{COLUMNS, write};
#[doc(hidden)]
pub use table::{assembled, check_table};
pub use windows::windows;
#[doc(hidden)]
pub use work::{Done, Job, work};

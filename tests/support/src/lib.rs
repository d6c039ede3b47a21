//! What several tests and studies share: running `sesc` and tools, random trees,
//! arithmetic exact enough to judge rounding, and robots with hidden effects.
//!
//! ```text
//! stage ─▶ trial (what is hidden, which postures) ─▶ log ─▶ diagnose ─▶ judge ─▶ table
//! ```
//!
//! The virtual robot is the reference's `World`, which shares no code with the
//! effects that the diagnosis tries. Tests ask a few such questions, `cargo xtask
//! study` some hundred.

pub mod child;
pub mod command;
pub mod contacts;
pub mod diagnoser;
pub mod exact;
pub mod examine;
pub mod feet;
pub mod fleet;
pub mod hidden;
pub mod judge;
pub mod kills;
pub mod log;
pub mod machine;
pub mod moving;
pub mod poses;
pub mod recording;
pub mod refit;
pub mod sizes;
pub mod stage;
pub mod survey;
pub mod table;
pub mod trees;
pub mod trial;

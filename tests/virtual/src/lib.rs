//! The study of hidden effects: hide something in a virtual robot, hand its log
//! to the diagnoser, and judge what it says against the truth.
//!
//! ```text
//! stage ─▶ trial (what is hidden, which postures) ─▶ log ─▶ diagnose ─▶ judge ─▶ table
//! ```
//!
//! The virtual robot is the reference's `World`, which shares no code with the
//! effects that the diagnoser tries. The tests
//! `hidden_effect` and `diagnose_cli` ask a few questions, `cargo xtask study` some
//! hundred.

pub mod contacts;
pub mod diagnoser;
pub mod feet;
pub mod fleet;
pub mod hidden;
pub mod judge;
pub mod log;
pub mod moving;
pub mod poses;
pub mod recording;
pub mod refit;
pub mod sizes;
pub mod stage;
pub mod survey;
pub mod table;
pub mod trial;

//! What several tests and benches share: running `sesc` and tools, random trees,
//! and arithmetic exact enough to judge rounding.

pub mod command;
pub mod exact;
pub mod kills;
pub mod machine;
pub mod memo;
pub mod trees;

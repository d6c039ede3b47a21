//! What generated code needs of this crate, by version; hand-written code has no use for it.

pub mod v1;

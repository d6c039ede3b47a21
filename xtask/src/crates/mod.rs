//! Crates that sesc is built from: which, under what licences, and what each is there for.

pub mod archive;
pub mod tree;

use std::error::Error;

/// Whatever keeps a list from being made.
pub(crate) type Failure = Box<dyn Error>;

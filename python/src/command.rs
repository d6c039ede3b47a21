//! The command line that comes with the package.

use std::ffi::OsString;

use pyo3::prelude::*;

use crate::calls::detached;

/// Run the command line of these words, in a process that does nothing else.
#[pyfunction]
pub(crate) fn command(py: Python<'_>, words: Vec<OsString>) -> PyResult<u8> {
    detached(py, || Ok(sesc::cli::main_from(words)))
}

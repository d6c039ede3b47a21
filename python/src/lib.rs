//! `sesc._sesc`: what Python calls.
//!
//! ```text
//! sesc/*.py (types, tables, files) ─▶ _sesc ─▶ model, codegen, identify, reports
//! ```
//!
//! No arithmetic and no second implementation stands here: arguments are turned into the
//! library's requests, its results into arrays and JSON. Long calls release the interpreter's
//! lock, are stopped by Ctrl-C, and turn every error and panic into an exception.

#![deny(unsafe_code)]

mod arrays;
#[allow(dead_code)]
mod calls;
#[allow(dead_code)]
mod errors;
mod model;
mod robot;

use pyo3::prelude::*;

#[pymodule(gil_used = false)]
mod _sesc {
    use super::*;

    #[pymodule_export]
    use super::model::Model;
    #[pymodule_export]
    use super::robot::Robot;

    #[pymodule_init]
    fn init(module: &Bound<'_, PyModule>) -> PyResult<()> {
        calls::keep_panics_to_ourselves();
        module.add("__version__", env!("CARGO_PKG_VERSION"))
    }
}

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
mod arrow;
mod batch;
mod calls;
mod checks;
mod code;
mod command;
mod diagnosis;
mod drawing;
mod errors;
mod fit;
mod fleet;
mod log;
mod model;
mod options;
mod part;
mod postures;
mod prepared;
mod robot;
mod steps;

use pyo3::prelude::*;
use pyo3::types::PyTuple;

#[pymodule(gil_used = false)]
mod _sesc {
    use super::*;

    #[pymodule_export]
    use super::arrow::{Unusable, arrow_columns};
    #[pymodule_export]
    use super::checks::{compare_models, effects_about, verify_model};
    #[pymodule_export]
    use super::code::{c_files, rust_files, write_bytes, write_text};
    #[pymodule_export]
    use super::command::command;
    #[pymodule_export]
    use super::diagnosis::{correct_urdf, diagnose_log};
    #[pymodule_export]
    use super::drawing::{draw_postures, draw_robot};
    #[pymodule_export]
    use super::fit::{FitReport, correct_fit, fit_logs};
    #[pymodule_export]
    use super::fleet::{FleetFound, fleet_groups, fleet_work};
    #[pymodule_export]
    use super::log::Log;
    #[pymodule_export]
    use super::model::Model;
    #[pymodule_export]
    use super::part::Part;
    #[pymodule_export]
    use super::postures::{plan_postures, predict_log, simulate_log, write_postures};
    #[pymodule_export]
    use super::robot::Robot;

    #[pymodule_init]
    fn init(module: &Bound<'_, PyModule>) -> PyResult<()> {
        calls::keep_panics_to_ourselves();
        // Its functions are looked up once, here: Ctrl-C within that would be a panic.
        numpy::PyArray1::<f64>::zeros(module.py(), 0, false);
        // Beside what the module exports.
        #[cfg(debug_assertions)]
        module.setattr("_panic", wrap_pyfunction!(calls::_panic, module)?)?;
        module.add("OP2_URDF", sesc::OP2_URDF)?;
        let columns = sesc_identify::fleet::COLUMNS;
        module.add("FLEET_COLUMNS", PyTuple::new(module.py(), columns)?)?;
        module.add("__version__", env!("CARGO_PKG_VERSION"))
    }
}

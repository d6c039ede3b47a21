//! Generated code, and other files, written whole or not at all.

use std::path::{Path, PathBuf};

use pyo3::prelude::*;
use sesc::cli::values::{LAYOUTS, SCALARS};
use sesc_codegen::Servos;
use sesc_codegen::facts::Facts;
use sesc_codegen::sources::{self, C99, Sources};
use sesc_identify::files;

use crate::calls::{Stopped, detached, watched};
use crate::errors::{Doing, During, Failure};
use crate::model::Model;
use crate::options::{named, taken};

/// Keywords of C code, all of them given.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub(crate) struct COptions {
    scalar: Option<String>,
    name: Option<String>,
    layout: String,
    ticks: Option<bool>,
    servos: Option<PathBuf>,
    estimator: bool,
    lanes: Option<u32>,
    functions: Option<Vec<String>>,
}

/// Write C99 to a folder; gives the files.
#[pyfunction]
pub(crate) fn c_files(
    py: Python<'_>,
    model: PyRef<'_, Model>,
    folder: PathBuf,
    options: &Bound<'_, PyAny>,
) -> PyResult<Vec<PathBuf>> {
    let options: COptions = taken(options, Doing::Sesc)?;
    let model = model.inner.clone();
    let sources = watched(py, None, Stopped::Abandoned, move |_| {
        let scalar = options.scalar.as_deref();
        let scalar = scalar.map(|given| named("scalar", given, SCALARS, Doing::Sesc));
        let scalar = scalar.transpose()?;
        let layout = named("layout", &options.layout, LAYOUTS, Doing::Sesc)?;
        let servos = match (&options.servos, options.ticks) {
            (Some(_), Some(false)) => {
                let message =
                    "`servos` says what a tick is, `ticks=False` leaves ticks out; give one";
                return Err(Failure::plain(Doing::Sesc, message));
            }
            (Some(file), _) => {
                let servos = Servos::read(file);
                Some(Some(servos.during(Doing::Sesc)?))
            }
            (None, ticks) => ticks.map(|wanted| wanted.then(Servos::default)),
        };
        let wanted = C99 {
            scalar,
            servos,
            estimator: options.estimator,
            lanes: options.lanes,
            layout,
        };
        let functions = sources::functions(options.functions.as_deref());
        let written = functions.and_then(|functions| {
            let facts = Facts::with(&model, &functions);
            sources::c99(&facts, options.name.as_deref(), &wanted)
        });
        written.during(Doing::Sesc)
    })?;
    detached(py, || write(&folder, sources))
}

/// Write a Rust module to a folder; gives the file.
#[pyfunction]
pub(crate) fn rust_files(
    py: Python<'_>,
    model: PyRef<'_, Model>,
    folder: PathBuf,
    name: Option<String>,
    functions: Option<Vec<String>>,
) -> PyResult<Vec<PathBuf>> {
    let model = model.inner.clone();
    let sources = watched(py, None, Stopped::Abandoned, move |_| {
        let functions = sources::functions(functions.as_deref());
        functions
            .and_then(|functions| sources::rust(&Facts::with(&model, &functions), name.as_deref()))
            .during(Doing::Sesc)
    })?;
    detached(py, || write(&folder, sources))
}

fn write(folder: &Path, sources: Sources) -> Result<Vec<PathBuf>, Failure> {
    let all = sources.files.into_iter();
    let all: Vec<_> = all.map(|(file, text)| (folder.join(file), text)).collect();
    files::write_all_if_changed(&all).during(Doing::Sesc)?;
    Ok(all.into_iter().map(|(file, _)| file).collect())
}

/// Write a text, whole or not at all.
#[pyfunction]
pub(crate) fn write_text(py: Python<'_>, path: PathBuf, text: &str) -> PyResult<()> {
    detached(py, || files::write(&path, text).during(Doing::Sesc))
}

/// Write a part's bytes, whole or not at all.
#[pyfunction]
pub(crate) fn write_bytes(py: Python<'_>, path: PathBuf, data: &[u8]) -> PyResult<()> {
    detached(py, || files::write(&path, data).during(Doing::Sesc))
}

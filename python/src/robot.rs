//! A robot as its URDF describes it.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use pyo3::prelude::*;
use sesc_identify::robot;
use sesc_model::Snapping;

use crate::calls::detached;
use crate::errors::{Doing, Failure};

/// A robot, and how right angles of its URDF are read.
#[pyclass(frozen, subclass, module = "sesc._sesc")]
pub struct Robot {
    pub inner: Arc<robot::Robot>,
    pub snapping: Snapping,
    /// Where its meshes may be.
    pub folder: Option<PathBuf>,
}

#[pymethods]
impl Robot {
    /// The robot of a URDF's `text`; `file` names it in messages. Without a text the file is read.
    #[new]
    #[pyo3(signature = (file, text, snap))]
    fn new(py: Python<'_>, file: PathBuf, text: Option<&str>, snap: bool) -> PyResult<Robot> {
        let read = || match text {
            Some(text) => robot::Robot::parse(text, &file.display().to_string()),
            None => robot::Robot::read(&file),
        };
        let inner = detached(py, || {
            read().map_err(|error| Failure::of(&error, Doing::Robot))
        })?;
        let snapping = match snap {
            true => Snapping::default(),
            false => Snapping::Off,
        };
        Ok(Robot {
            inner: Arc::new(inner),
            snapping,
            folder: file.parent().map(Path::to_path_buf),
        })
    }

    #[getter]
    fn name(&self) -> &str {
        &self.inner.description.name
    }

    #[getter]
    fn file(&self) -> &str {
        &self.inner.description.file
    }

    #[getter]
    fn hash(&self) -> &str {
        &self.inner.description.hash
    }

    #[getter]
    fn urdf(&self) -> &str {
        self.inner.text()
    }

    #[getter]
    fn snap(&self) -> bool {
        self.snapping != Snapping::Off
    }

    #[getter]
    fn links(&self) -> Vec<&str> {
        self.inner.description.link_names().collect()
    }

    #[getter]
    fn joints(&self) -> Vec<String> {
        let dofs = self.inner.description.dofs();
        dofs.into_iter().map(|dof| dof.joint).collect()
    }
}

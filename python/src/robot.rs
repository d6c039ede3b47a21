//! A robot as its URDF describes it.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use pyo3::prelude::*;
use sesc_identify::robot;
use sesc_identify::skeleton::Skeleton;
use sesc_model::{Model, Snapping};

use crate::calls::detached;
use crate::errors::{Doing, During, Failure};

/// A robot, and how right angles of its URDF are read.
#[pyclass(frozen, subclass, module = "sesc._sesc")]
pub struct Robot {
    pub inner: Arc<robot::Robot>,
    pub snapping: Snapping,
    /// Where its meshes may be.
    pub folder: Option<PathBuf>,
    /// Whether `xacro` was run over its file.
    #[pyo3(get, name = "_expanded")]
    expanded: bool,
}

impl Robot {
    /// The robot on a link.
    pub fn on(&self, support: &str) -> Result<Model, Failure> {
        let model = self.inner.model(support, self.snapping, None);
        model.during(Doing::Urdf)
    }

    /// The robot of `model` as it is drawn.
    pub fn skeleton(&self, model: &Model) -> Skeleton {
        Skeleton::of(model, &self.inner.description, self.folder.as_deref())
    }
}

#[pymethods]
impl Robot {
    /// The robot of a URDF's `text`; `file` names it in messages. Without a text the file is
    /// read, and expanded by the program `xacro` where `xacro` is true or its name ends so.
    #[new]
    #[pyo3(signature = (file, text, snap, xacro = false))]
    fn new(
        py: Python<'_>,
        file: PathBuf,
        text: Option<&str>,
        snap: bool,
        xacro: bool,
    ) -> PyResult<Robot> {
        let read = || match text {
            Some(text) => {
                let robot = robot::Robot::parse(text, &file.display().to_string());
                robot.map(|robot| (robot, false))
            }
            None => {
                let read = robot::Robot::read_typed(&file, xacro);
                read.map(|read| (read.robot, read.expanded))
            }
        };
        let (inner, expanded) = detached(py, || read().during(Doing::Urdf))?;
        let snapping = match snap {
            true => Snapping::default(),
            false => Snapping::Off,
        };
        Ok(Robot {
            inner: Arc::new(inner),
            snapping,
            folder: file.parent().map(Path::to_path_buf),
            expanded,
        })
    }

    /// The name in the URDF.
    ///
    /// Example:
    ///     >>> robot.name
    ///     'pole'
    #[getter]
    fn name(&self) -> &str {
        &self.inner.description.name
    }

    /// The file that messages name.
    ///
    /// Example:
    ///     >>> robot.file
    ///     'robot.urdf'
    #[getter]
    fn file(&self) -> &str {
        &self.inner.description.file
    }

    /// Hash of the description, in hexadecimal: model files and parts carry it.
    ///
    /// Example:
    ///     >>> len(robot.hash)
    ///     16
    #[getter]
    fn hash(&self) -> &str {
        &self.inner.description.hash
    }

    /// The text of the URDF.
    ///
    /// Example:
    ///     >>> robot.urdf == urdf
    ///     True
    #[getter]
    fn urdf(&self) -> &str {
        self.inner.text()
    }

    /// Whether decimals of right angles are made exact.
    ///
    /// Example:
    ///     >>> robot.snap
    ///     True
    #[getter]
    fn snap(&self) -> bool {
        self.snapping != Snapping::Off
    }

    /// Names of the links: any of them can be the support.
    ///
    /// Example:
    ///     >>> robot.links
    ///     ['foot', 'top']
    #[getter]
    fn links(&self) -> Vec<&str> {
        self.inner.description.link_names().collect()
    }

    /// The link that no joint carries.
    ///
    /// Example:
    ///     >>> robot.root
    ///     'foot'
    #[getter]
    fn root(&self) -> &str {
        let about = &self.inner.description;
        let is_root = |link: &&str| about.joints.iter().all(|joint| joint.child != *link);
        about.link_names().find(is_root).unwrap_or_default()
    }

    /// Names of the independent joints, in the order of the document.
    ///
    /// Example:
    ///     >>> robot.joints
    ///     ['hip']
    #[getter]
    fn joints(&self) -> Vec<String> {
        let dofs = self.inner.description.dofs();
        dofs.into_iter().map(|dof| dof.joint).collect()
    }
}

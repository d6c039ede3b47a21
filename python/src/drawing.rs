//! The robot as reports draw it, for notebooks.

use numpy::{PyReadonlyArray2, PyUntypedArrayMethods};
use pyo3::prelude::*;
use sesc::report::figures::robot::{Marks, Pictured, sheet};

use crate::calls::detached;
use crate::model::Model;
use crate::robot::Robot;

/// The robot with all joints at zero, from the front and from its right, as SVG.
#[pyfunction]
pub(crate) fn draw_robot(
    py: Python<'_>,
    robot: PyRef<'_, Robot>,
    model: PyRef<'_, Model>,
) -> PyResult<Vec<String>> {
    let (robot, model) = (&*robot, &*model);
    detached(py, || {
        let pictured = Pictured {
            skeleton: &robot.skeleton(&model.inner),
            postures: vec![&[]],
            shown: 0,
            cop: Vec::new(),
            marks: Marks::default(),
        };
        Ok(pictured.views().to_vec())
    })
}

/// A small picture of each posture, as SVG.
#[pyfunction]
pub(crate) fn draw_postures(
    py: Python<'_>,
    robot: PyRef<'_, Robot>,
    model: PyRef<'_, Model>,
    q: PyReadonlyArray2<'_, f64>,
) -> PyResult<Vec<String>> {
    let (robot, model) = (&*robot, &*model);
    let dof = q.shape()[1];
    let q: Vec<f64> = q.as_array().iter().copied().collect();
    detached(py, || {
        let postures: Vec<&[f64]> = q.chunks_exact(dof.max(1)).collect();
        Ok(sheet(&robot.skeleton(&model.inner), &postures))
    })
}

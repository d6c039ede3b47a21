//! Arrays of postures in, arrays of results out.
//!
//! ```text
//! q (…, dof) ─▶ result (…, shape of one posture)
//! ```
//!
//! Arrays of 64-bit floats in C order are read where they are; everything else is converted
//! once by `sesc._arrays`.

use numpy::{
    BorrowError, PyArrayDyn, PyArrayMethods, PyReadonlyArrayDyn, PyReadwriteArrayDyn,
    PyUntypedArrayMethods,
};
use pyo3::prelude::*;
use pyo3::sync::PyOnceLock;

use crate::errors::{Doing, Failure};

/// What the last axis of an argument is.
#[derive(Clone, Copy)]
pub(crate) enum Axis<'a> {
    /// The joints of a model.
    Joints(&'a [String]),
    /// x and y of a reading of the CoP.
    Reading(&'a [String; 2]),
}

impl<'a> Axis<'a> {
    /// The columns of a table that it is.
    pub(crate) fn names(self) -> &'a [String] {
        match self {
            Axis::Joints(names) => names,
            Axis::Reading(names) => names,
        }
    }

    fn said(self) -> String {
        match self {
            Axis::Joints(names) => format!("the {} joints of `model.joints`", names.len()),
            Axis::Reading(_) => "x and y of a reading".to_string(),
        }
    }
}

/// `sesc._arrays.positions`.
fn convert<'py>(
    given: &Bound<'py, PyAny>,
    names: &[String],
    name: &str,
) -> PyResult<Bound<'py, PyAny>> {
    static POSITIONS: PyOnceLock<Py<PyAny>> = PyOnceLock::new();
    let positions = POSITIONS.import(given.py(), "sesc._arrays", "positions")?;
    positions.call1((given, names.to_vec(), name))
}

/// Numbers that are given (joint positions, velocities, readings).
pub(crate) enum Numbers<'py> {
    /// The numbers of one posture, copied: that costs less than the books that are kept of who
    /// reads an array.
    Copied(Bound<'py, PyArrayDyn<f64>>, Vec<f64>),
    /// Where they are.
    Borrowed(PyReadonlyArrayDyn<'py, f64>),
}

impl Numbers<'_> {
    /// The shape that numpy says.
    pub(crate) fn shape(&self) -> &[usize] {
        match self {
            Numbers::Copied(array, _) => array.shape(),
            Numbers::Borrowed(array) => array.shape(),
        }
    }

    /// The numbers, row by row.
    pub(crate) fn values(&self) -> PyResult<&[f64]> {
        match self {
            Numbers::Copied(_, values) => Ok(values),
            Numbers::Borrowed(array) => Ok(array.as_slice()?),
        }
    }
}

/// What is given, checked: the last axis is `axis`. Beside a result in an array of the caller's,
/// nothing `is_new`, and even one posture is borrowed: the two may share memory.
pub(crate) fn numbers<'py>(
    given: &Bound<'py, PyAny>,
    axis: Axis<'_>,
    name: &str,
    is_new: bool,
) -> PyResult<Numbers<'py>> {
    // A kind of array of its own may have a mask.
    let array = match given.cast_exact::<PyArrayDyn<f64>>() {
        Ok(array) if array.is_c_contiguous() && array.is_aligned() => array.clone(),
        _ => convert(given, axis.names(), name)?.cast_into::<PyArrayDyn<f64>>()?,
    };
    if array.shape().last() != Some(&axis.names().len()) {
        let (shape, axis) = (array.shape(), axis.said());
        let message = format!("{name} has the shape {shape:?}; its last axis must hold {axis}");
        return Err(refused(given.py(), message));
    }
    // Books of borrows cost a tenth of such a call. What another thread writes to the array
    // meanwhile is copied half written, as by numpy's own functions.
    if is_new && array.ndim() == 1 {
        let values = array.to_vec()?;
        return Ok(Numbers::Copied(array, values));
    }
    array.try_readonly().map(Numbers::Borrowed).map_err(|_| {
        let message = format!("{name} is being written to; give a copy of it");
        refused(given.py(), message)
    })
}

fn refused(py: Python<'_>, message: impl Into<String>) -> PyErr {
    Failure::plain(Doing::Argument, message).raise(py)
}

/// An array for results.
pub(crate) enum Target<'py> {
    /// Just made: nobody else has it yet.
    New(Bound<'py, PyArrayDyn<f64>>),
    /// The caller's.
    Given(PyReadwriteArrayDyn<'py, f64>),
}

impl<'py> Target<'py> {
    /// The caller's array, or a new one.
    pub(crate) fn of(
        py: Python<'py>,
        out: Option<&Bound<'py, PyAny>>,
        shape: &[usize],
    ) -> PyResult<Target<'py>> {
        let Some(out) = out else {
            return Ok(Target::New(PyArrayDyn::zeros(py, shape, false)));
        };
        let array = out.cast::<PyArrayDyn<f64>>().map_err(|_| {
            let message = "out must be a numpy array of 64-bit floats";
            Failure::plain(Doing::ArgumentType, message).raise(py)
        })?;
        if !out.is_exact_instance_of::<PyArrayDyn<f64>>() && out.hasattr("mask")? {
            let message = "out has a mask, which results would not change; give a plain array";
            return Err(Failure::plain(Doing::ArgumentType, message).raise(py));
        }
        if array.shape() != shape || !array.is_c_contiguous() {
            let (found, gaps) = match array.is_c_contiguous() {
                true => (array.shape(), ""),
                false => (array.shape(), ", and gaps"),
            };
            let wanted = format!("give a C-contiguous array of the shape {shape:?}");
            let message = format!("out has the shape {found:?}{gaps}; {wanted}");
            return Err(refused(py, message));
        }
        if !array.is_aligned() {
            let message = "out is not aligned in memory; give an array that numpy made";
            return Err(Failure::plain(Doing::ArgumentType, message).raise(py));
        }
        array.try_readwrite().map(Target::Given).map_err(|wrong| {
            let message = match wrong {
                BorrowError::NotWriteable => "out is read-only; give an array that is writeable",
                _ => "out shares memory with an argument; give an array of its own",
            };
            refused(py, message)
        })
    }

    /// Its values, row by row.
    #[allow(unsafe_code)]
    pub(crate) fn values(&mut self) -> PyResult<&mut [f64]> {
        match self {
            Target::New(array) => {
                // SAFETY: the array was made by this call, has memory of its own, and has been
                // given to nobody; `&mut self` keeps it from being given away meanwhile.
                let values = unsafe { array.as_slice_mut() };
                Ok(values?)
            }
            Target::Given(array) => Ok(array.as_slice_mut()?),
        }
    }

    /// The array, for the caller.
    pub(crate) fn array(self) -> Bound<'py, PyArrayDyn<f64>> {
        match self {
            Target::New(array) => array,
            Target::Given(array) => (**array).clone(),
        }
    }
}

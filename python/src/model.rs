//! A robot on its support, with its parameters: functions of many postures at once.

use std::path::PathBuf;
use std::sync::Arc;

use numpy::{PyArray1, PyArrayDyn};
use pyo3::prelude::*;
use serde::Serialize;
use sesc::inspect::{inspect, notes};
use sesc::report::next_steps::{WithSteps, Worded};
use sesc_identify::NextStep;
use sesc_model::tape::Values;
use sesc_model::{self as model, Function, ModelFile};

use crate::arrays::{Axis, Target, numbers};
use crate::batch::{Batch, Count};
use crate::calls::{detached, guarded};
use crate::errors::{Doing, During, Failure};
use crate::prepared::{Functions, READING};
use crate::robot::Robot;
use crate::steps;

/// An array-like of joint positions, velocities or accelerations.
type In<'a, 'py> = &'a Bound<'py, PyAny>;
/// The caller's array for the result.
type Out<'a, 'py> = Option<&'a Bound<'py, PyAny>>;
/// Over how many threads; one where nothing is said.
type Threads = Option<Count>;
/// The result, or an exception.
type Found<'py> = PyResult<Bound<'py, PyArrayDyn<f64>>>;

/// A robot on its support link, with CAD's parameters or identified ones.
#[pyclass(frozen, subclass, module = "sesc._sesc")]
pub struct Model {
    pub inner: Arc<model::Model>,
    joints: Vec<String>,
    reading: [String; 2],
    prepared: Functions,
}

impl Model {
    /// What comes before the first log.
    fn next_step(&self) -> Vec<Worded> {
        let support = self.inner.support().to_string();
        steps::worded([&NextStep::Plan { support }], steps::text)
    }

    /// A function of arrays of one shape: positions, and velocities and accelerations where
    /// the robot moves.
    fn run<'py, const N: usize>(
        &self,
        function: Function,
        inputs: [(&str, In<'_, 'py>); N],
        out: Out<'_, 'py>,
        threads: Threads,
    ) -> Found<'py> {
        let py = inputs[0].1.py();
        guarded(py, || {
            let prepared = self.prepared.get(py, &self.inner, function);
            let axis = match function {
                Function::CorrectCop => Axis::Reading(&self.reading),
                _ => Axis::Joints(&self.joints),
            };
            let arrays =
                each(inputs.map(|(name, input)| numbers(input, axis, name, out.is_none())))?;
            let shape = arrays[0].shape();
            if arrays.iter().any(|array| array.shape() != shape) {
                let shapes: Vec<String> = inputs
                    .iter()
                    .zip(&arrays)
                    .map(|((name, _), array)| format!("{name} {:?}", array.shape()))
                    .collect();
                let message = format!(
                    "the shapes are {}; give arrays of one shape",
                    shapes.join(", ")
                );
                return Err(Failure::plain(Doing::ArgumentType, message).raise(py));
            }
            let outer = &shape[..shape.len() - 1];
            let shape: Vec<usize> = outer.iter().chain(&prepared.shape).copied().collect();
            let mut target = Target::of(py, out, &shape)?;
            let values = target.values()?;
            let mut q: [&[f64]; N] = [&[]; N];
            for (q, array) in q.iter_mut().zip(&arrays) {
                *q = array.values()?;
            }
            match &prepared.evaluator {
                // Without effects of the sensor a reading is the CoP itself.
                None => values.copy_from_slice(q[0]),
                Some(evaluator) => {
                    let width = axis.names().len();
                    let batch = Batch {
                        postures: outer.iter().product(),
                        width: evaluator.width(),
                        operations: evaluator.operations(),
                        threads: threads.map_or(1, |threads| threads.0),
                    };
                    batch.run(py, values, |start, n, out| {
                        let from = |k: usize| &q[k.min(N - 1)][start * width..];
                        match N {
                            1 => evaluator.run_into(from(0), n, out),
                            _ => {
                                let motion = [from(1), from(2)].map(Values::PerPosture);
                                evaluator.run_moving_into(from(0), motion, n, out)
                            }
                        }
                    })?;
                }
            }
            Ok(target.array())
        })
    }
}

/// All of the results, or the first error.
fn each<T, const N: usize>(results: [PyResult<T>; N]) -> PyResult<[T; N]> {
    let mut error = None;
    let values = results.map(|result| match result {
        Ok(value) => Some(value),
        Err(own) => {
            error.get_or_insert(own);
            None
        }
    });
    match error {
        Some(error) => Err(error),
        None => Ok(values.map(|value| value.expect("there is no error"))),
    }
}

#[pymethods]
impl Model {
    /// `robot` on `support` with the parameters of a model file, by its text or its path.
    #[new]
    #[pyo3(signature = (robot, support, file=None, text=None))]
    fn new(
        py: Python<'_>,
        robot: &Robot,
        support: &str,
        file: Option<PathBuf>,
        text: Option<&str>,
    ) -> PyResult<Model> {
        let build = || -> Result<model::Model, Failure> {
            let name = file.as_ref().map(|path| path.display().to_string());
            let parameters = match (text, &file, name) {
                (Some(text), _, name) => {
                    let name = name.unwrap_or_else(|| "model".to_string());
                    Some(ModelFile::parse(text, &name))
                }
                (None, Some(path), _) => Some(ModelFile::read(path)),
                (None, None, _) => None,
            };
            let parameters = parameters.transpose().during(Doing::ModelFile)?;
            let found = robot.on(support)?;
            match parameters {
                Some(parameters) => found.with_file(parameters).during(Doing::ModelFile),
                None => Ok(found),
            }
        };
        let inner = detached(py, build)?;
        let joints = inner.tree.dofs.iter().map(|dof| dof.joint.clone());
        Ok(Model {
            joints: joints.collect(),
            inner: Arc::new(inner),
            reading: READING.map(String::from),
            prepared: Functions::default(),
        })
    }

    /// The text of the model file that it was made with.
    #[getter]
    fn model_file(&self, py: Python<'_>) -> PyResult<Option<String>> {
        let text = self.inner.file.as_ref().map(ModelFile::to_toml).transpose();
        let text = text.during(Doing::ModelFile);
        text.map_err(|failure| failure.raise(py))
    }

    /// The link on the ground.
    ///
    /// Example:
    ///     >>> model.support
    ///     'foot'
    #[getter]
    fn support(&self) -> &str {
        self.inner.support()
    }

    /// Names of the independent joints, in the order of ``q``.
    ///
    /// Example:
    ///     >>> model.joints
    ///     ['hip']
    #[getter]
    fn joints(&self) -> Vec<String> {
        self.joints.clone()
    }

    /// How many independent joints there are.
    ///
    /// Example:
    ///     >>> model.dof
    ///     1
    #[getter]
    fn dof(&self) -> usize {
        self.joints.len()
    }

    /// The base parameters, m (of a prismatic joint: a mass fraction), shape (p,): identified
    /// ones where the model has them, else CAD's.
    ///
    /// Example:
    ///     >>> model.params.shape
    ///     (5,)
    #[getter]
    fn params<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        PyArray1::from_vec(py, self.inner.params())
    }

    /// Their names: body and axis.
    ///
    /// Example:
    ///     >>> model.param_names[-2:]
    ///     ['top.x', 'top.z']
    #[getter]
    fn param_names(&self) -> Vec<&str> {
        let params = self.inner.base.params.iter();
        params.map(|param| param.name.as_str()).collect()
    }

    /// Mass of the robot with its loads, kg.
    ///
    /// Example:
    ///     >>> model.total_mass
    ///     2.0
    #[getter]
    fn total_mass(&self) -> f64 {
        self.inner.total_mass_kg()
    }

    /// Lower and upper limit of each joint, joint by joint.
    #[getter]
    fn bounds(&self) -> Vec<[f64; 2]> {
        let dofs = self.inner.tree.dofs.iter();
        dofs.map(|dof| dof.limits()).collect()
    }

    /// What no CoP of a flat foot can tell, a sentence each.
    ///
    /// Example:
    ///     >>> any("height" in sentence for sentence in model.unobservable)
    ///     True
    #[getter]
    fn unobservable(&self) -> Vec<&str> {
        let all = self.inner.base.unobservable.iter();
        all.map(|direction| direction.sentence.as_str()).collect()
    }

    /// What is to be known of the robot, a sentence each.
    ///
    /// Example:
    ///     >>> isinstance(model.notes, list)
    ///     True
    #[getter]
    fn notes(&self) -> Vec<String> {
        let notes = notes(&self.inner).into_iter();
        notes.chain(self.inner.cautions()).collect()
    }

    /// What `sesc inspect --json` says.
    fn inspection(&self, py: Python<'_>) -> PyResult<String> {
        detached(py, || {
            json(&WithSteps {
                found: &inspect(&self.inner),
                next_steps: &self.next_step(),
            })
        })
    }

    /// What it says to do next.
    fn next_steps(&self, py: Python<'_>) -> PyResult<String> {
        detached(py, || compact(&self.next_step()))
    }

    /// Centre of mass in the support frame, m: ``(dof,)`` gives ``(3,)``, ``(n, dof)`` gives
    /// ``(n, 3)``.
    ///
    /// Raises:
    ///     ArgumentError: a last axis that is not the joints', or an unsuitable ``out``.
    ///     ArgumentTypeError: no numbers.
    ///
    /// Example:
    ///     >>> model.com([0.0]).tolist()
    ///     [0.1, 0.0, 1.0]
    #[pyo3(signature = (q, *, out=None, threads=None))]
    fn com<'py>(&self, q: In<'_, 'py>, out: Out<'_, 'py>, threads: Threads) -> Found<'py> {
        self.run(Function::Com, [("q", q)], out, threads)
    }

    /// Its derivative with respect to joint positions, m/rad (prismatic: m/m): ``(3, dof)`` or
    /// ``(n, 3, dof)``.
    ///
    /// Raises:
    ///     ArgumentError: a last axis that is not the joints', or an unsuitable ``out``.
    ///     ArgumentTypeError: no numbers.
    ///
    /// Example:
    ///     >>> model.com_jacobian([[0.0], [0.5]]).shape
    ///     (2, 3, 1)
    #[pyo3(signature = (q, *, out=None, threads=None))]
    fn com_jacobian<'py>(&self, q: In<'_, 'py>, out: Out<'_, 'py>, threads: Threads) -> Found<'py> {
        self.run(Function::ComJacobian, [("q", q)], out, threads)
    }

    /// Velocity of the centre of mass, m/s, of joints at `qd` (rad/s, m/s): positions and
    /// velocities of one shape give ``(3,)`` or ``(n, 3)``.
    ///
    /// Raises:
    ///     ArgumentError: a last axis that is not the joints', or an unsuitable ``out``.
    ///     ArgumentTypeError: no numbers, or arrays of different shapes.
    ///
    /// Example:
    ///     >>> float(model.com_velocity([0.0], [0.5])[0])
    ///     0.5
    #[pyo3(signature = (q, qd, *, out=None, threads=None))]
    fn com_velocity<'py>(
        &self,
        q: In<'_, 'py>,
        qd: In<'_, 'py>,
        out: Out<'_, 'py>,
        threads: Threads,
    ) -> Found<'py> {
        self.run(Function::ComVelocity, [("q", q), ("qd", qd)], out, threads)
    }

    /// The moment that gravity exerts about each joint, per kg of total mass times g, m, −∂z/∂q of
    /// the CoM: ``(dof,)`` or ``(n, dof)``. A motor that holds the posture applies the opposite,
    /// ``-model.total_mass * 9.80665`` times it in Nm, which is Pinocchio's
    /// ``computeGeneralizedGravity``.
    ///
    /// Raises:
    ///     ArgumentError: a last axis that is not the joints', or an unsuitable ``out``.
    ///     ArgumentTypeError: no numbers.
    ///
    /// Example:
    ///     >>> model.gravity_moments([0.0]).shape
    ///     (1,)
    #[pyo3(signature = (q, *, out=None, threads=None))]
    fn gravity_moments<'py>(
        &self,
        q: In<'_, 'py>,
        out: Out<'_, 'py>,
        threads: Threads,
    ) -> Found<'py> {
        self.run(Function::GravityMoments, [("q", q)], out, threads)
    }

    /// Reading of the centre of pressure that a static posture gives, m, with the effects of the
    /// model: ``(2,)`` or ``(n, 2)``.
    ///
    /// Raises:
    ///     ArgumentError: a last axis that is not the joints', or an unsuitable ``out``.
    ///     ArgumentTypeError: no numbers.
    ///
    /// Example:
    ///     >>> model.cop([0.0]).tolist()
    ///     [0.1, 0.0]
    #[pyo3(signature = (q, *, out=None, threads=None))]
    fn cop<'py>(&self, q: In<'_, 'py>, out: Out<'_, 'py>, threads: Threads) -> Found<'py> {
        self.run(Function::Cop, [("q", q)], out, threads)
    }

    /// How that reading moves with what encoders read, m/rad (prismatic: m/m): ``(2, dof)`` or
    /// ``(n, 2, dof)``.
    ///
    /// Raises:
    ///     ArgumentError: a last axis that is not the joints', or an unsuitable ``out``.
    ///     ArgumentTypeError: no numbers.
    ///
    /// Example:
    ///     >>> model.cop_jacobian([0.0]).shape
    ///     (2, 1)
    #[pyo3(signature = (q, *, out=None, threads=None))]
    fn cop_jacobian<'py>(&self, q: In<'_, 'py>, out: Out<'_, 'py>, threads: Threads) -> Found<'py> {
        self.run(Function::CopJacobian, [("q", q)], out, threads)
    }

    /// Rows of the CoP in the parameters, ``cop = cop_rows @ params`` without effects: ``(2,
    /// p)`` or ``(n, 2, p)``.
    ///
    /// Raises:
    ///     ArgumentError: a last axis that is not the joints', or an unsuitable ``out``.
    ///     ArgumentTypeError: no numbers.
    ///
    /// Example:
    ///     >>> model.cop_rows([0.0]).shape
    ///     (2, 5)
    #[pyo3(signature = (q, *, out=None, threads=None))]
    fn cop_rows<'py>(&self, q: In<'_, 'py>, out: Out<'_, 'py>, threads: Threads) -> Found<'py> {
        self.run(Function::RegressorCop, [("q", q)], out, threads)
    }

    /// Rows of the CoM in the parameters, ``com = com_rows @ params``: ``(3, p)`` or ``(n, 3,
    /// p)``.
    ///
    /// Raises:
    ///     ArgumentError: a last axis that is not the joints', or an unsuitable ``out``.
    ///     ArgumentTypeError: no numbers.
    ///
    /// Example:
    ///     >>> model.com_rows([0.0]).shape
    ///     (3, 5)
    #[pyo3(signature = (q, *, out=None, threads=None))]
    fn com_rows<'py>(&self, q: In<'_, 'py>, out: Out<'_, 'py>, threads: Threads) -> Found<'py> {
        self.run(Function::Regressor, [("q", q)], out, threads)
    }

    /// Rows of the CoM in all parameters of the chain, ``[B_0 B_1 …]``, three columns for the
    /// `r_i` of each body in its own frame (and one for each prismatic joint): ``(3, f)`` or
    /// ``(n, 3, f)``.
    ///
    /// Raises:
    ///     ArgumentError: a last axis that is not the joints', or an unsuitable ``out``.
    ///     ArgumentTypeError: no numbers.
    ///
    /// Example:
    ///     >>> model.full_rows([0.0]).shape
    ///     (3, 6)
    #[pyo3(signature = (q, *, out=None, threads=None))]
    fn full_rows<'py>(&self, q: In<'_, 'py>, out: Out<'_, 'py>, threads: Threads) -> Found<'py> {
        self.run(Function::RegressorFull, [("q", q)], out, threads)
    }

    /// The CoP that a reading was made of, m: takes back the sensor's effects of the model
    /// (offset, gain, rotation); the reading itself where it has none. ``(2,)`` gives ``(2,)``,
    /// ``(n, 2)`` gives ``(n, 2)``; a data frame or dict is asked for ``cop_x`` and ``cop_y``.
    ///
    /// Raises:
    ///     ArgumentError: a last axis that is not x and y, or an unsuitable ``out``.
    ///     ArgumentTypeError: no numbers.
    ///
    /// Example:
    ///     >>> model.correct_cop([0.02, 0.01]).tolist()
    ///     [0.02, 0.01]
    #[pyo3(signature = (reading, *, out=None, threads=None))]
    fn correct_cop<'py>(
        &self,
        reading: In<'_, 'py>,
        out: Out<'_, 'py>,
        threads: Threads,
    ) -> Found<'py> {
        self.run(Function::CorrectCop, [("reading", reading)], out, threads)
    }

    /// Zero-moment point of a robot that moves, m: positions, velocities (rad/s, m/s) and
    /// accelerations of one shape give ``(2,)`` or ``(n, 2)``.
    ///
    /// Raises:
    ///     ArgumentError: a last axis that is not the joints', or an unsuitable ``out``.
    ///     ArgumentTypeError: no numbers.
    ///
    /// Example:
    ///     >>> model.zmp([0.0], [0.0], [0.0]).tolist()
    ///     [0.1, 0.0]
    #[pyo3(signature = (q, qd, qdd, *, out=None, threads=None))]
    fn zmp<'py>(
        &self,
        q: In<'_, 'py>,
        qd: In<'_, 'py>,
        qdd: In<'_, 'py>,
        out: Out<'_, 'py>,
        threads: Threads,
    ) -> Found<'py> {
        self.run(
            Function::Zmp,
            [("q", q), ("qd", qd), ("qdd", qdd)],
            out,
            threads,
        )
    }
}

/// A result as the command line prints it.
pub(crate) fn json(value: &impl Serialize) -> Result<String, Failure> {
    sesc::cli::json(value).map_err(Failure::internal)
}

/// A value as JSON on one line, for the package itself.
pub(crate) fn compact(value: &impl Serialize) -> Result<String, Failure> {
    serde_json::to_string(value).map_err(Failure::internal)
}

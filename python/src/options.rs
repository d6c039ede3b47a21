//! Keywords of calls: how they are taken, and those that fits and parts share, as requests of the
//! library.

use pyo3::exceptions::PyOverflowError;
use pyo3::prelude::*;
use sesc::cli::values::{self, DUPLICATES, LOSSES, Words};
use sesc_identify::fit::MotionModel;
use sesc_identify::fit::Request;
use sesc_identify::fit::part::Part;
use sesc_identify::fit::prior::PriorChoice;
use sesc_identify::logs::{Angles, Stays};

use crate::errors::{Doing, Failure};
use crate::log::Log;
use crate::robot::Robot;

/// The keywords of a call. What cannot be taken is said by the keyword's name: a number that is out
/// of range as any other fault of what is asked for, a value of another type as an `ArgumentTypeError`.
pub(crate) fn taken<'a, 'py, T>(given: &'a Bound<'py, PyAny>, doing: Doing) -> PyResult<T>
where
    T: FromPyObject<'a, 'py>,
{
    let py = given.py();
    let options = given.extract().map_err(|error: T::Error| {
        let error: PyErr = error.into();
        let said = error.value(py).to_string();
        let Some(cause) = error.cause(py) else {
            return error;
        };
        let name = said.rsplit('.').next().unwrap_or_default();
        let value = given.get_item(name).and_then(|value| value.repr());
        let value = value.map_or_else(|_| String::new(), |value| value.to_string());
        match cause.is_instance_of::<PyOverflowError>(py) {
            true if value.starts_with('-') => {
                let message = format!("`{name}` {value}: give a whole number, zero or more");
                Failure::plain(doing, message).raise(py)
            }
            true => Failure::plain(doing, format!("`{name}` {value}: too large")).raise(py),
            false => {
                let message = format!("`{name}` {value}: {}", cause.value(py));
                Failure::plain(Doing::ArgumentType, message).raise(py)
            }
        }
    })?;
    for name in values::sized() {
        // What a call does not have, and None.
        let value = given
            .get_item(name)
            .and_then(|value| value.extract::<f64>());
        if let Ok(value) = value {
            sized(name, value, doing).map_err(|failure| failure.raise(py))?;
        }
    }
    Ok(options)
}

/// What the name that a keyword is `given` stands for, of those that are `known`.
pub(crate) fn named<T: Copy>(
    keyword: &str,
    given: &str,
    known: &Words<T>,
    doing: Doing,
) -> Result<T, Failure> {
    let found = known.iter().find(|(name, ..)| *name == given);
    found.map(|(_, value, _)| *value).ok_or_else(|| {
        let names: Vec<&str> = known.iter().map(|(name, ..)| *name).collect();
        let names = names.join(", ");
        let message = format!("`{keyword}` {given}: known are {names}");
        Failure::plain(doing, message)
    })
}

/// A value in SI units that can be meant.
pub(crate) fn sized(name: &str, value: f64, doing: Doing) -> Result<(), Failure> {
    let wrong = |wrong| Failure::plain(doing, format!("`{name}` {value:?}: {wrong}"));
    values::check(name, value).map_err(wrong)
}

/// What a corrected robot may weigh, kg.
pub(crate) fn weighed(
    total_mass: Option<f64>,
    robot: &sesc_identify::robot::Robot,
) -> Result<(), Failure> {
    let wrong = |wrong| {
        let kg = total_mass.unwrap_or_default();
        Failure::plain(Doing::Fit, format!("`total_mass` {kg:?}: {wrong}"))
    };
    values::check_mass(total_mass, robot).map_err(wrong)
}

/// Keywords of a fit, all of them given.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub(crate) struct FitOptions {
    support: Option<String>,
    degrees: Option<bool>,
    prior: String,
    noise: Option<f64>,
    offset: Option<f64>,
    robust: Option<String>,
    folds: Option<usize>,
    range: Option<f64>,
    physical: bool,
    motion: bool,
    settle: Option<f64>,
    unit: Option<String>,
    duplicates: String,
}

impl FitOptions {
    /// The request of a fit of these logs and parts.
    pub(crate) fn request(
        self,
        robot: Option<&Robot>,
        logs: &[PyRef<'_, Log>],
        parts: Vec<Part>,
    ) -> Result<Request, Failure> {
        let mut request = Request::default();
        if let Some(robot) = robot {
            request.robot = Some(robot.inner.clone());
            request.snapping = robot.snapping;
        }
        request.logs = logs.iter().map(|log| log.source.clone()).collect();
        let parts = parts.into_iter().enumerate();
        let parts = parts.map(|(k, part)| (format!("part {}", k + 1), part));
        request.parts = parts.collect();
        request.support = self.support;
        request.angles = self.degrees.map(angles);
        request.prior = PriorChoice::from(self.prior.as_str());
        request.noise = self.noise;
        request.offset = self.offset;
        let robust = self.robust.as_deref();
        let robust = robust.map(|given| named("robust", given, LOSSES, Doing::Fit));
        request.robust = robust.transpose()?;
        request.folds = self.folds;
        request.range = self.range;
        request.physical = self.physical;
        request.motion = motion(self.motion);
        request.stays = stays(self.settle)?;
        request.unit = self.unit;
        request.duplicates = named("duplicates", &self.duplicates, DUPLICATES, Doing::Fit)?;
        Ok(request)
    }
}

/// The unit of revolute joints.
pub(crate) fn angles(degrees: bool) -> Angles {
    if degrees { Angles::Deg } else { Angles::Rad }
}

/// Whether the motion of the joints counts where a log knows it.
pub(crate) fn motion(counts: bool) -> MotionModel {
    match counts {
        true => MotionModel::Auto,
        false => MotionModel::Off,
    }
}

/// Stays of at least so many seconds alone, or all rows, where that is asked for.
pub(crate) fn stays(settle: Option<f64>) -> Result<Stays, Failure> {
    let Some(seconds) = settle else {
        return Ok(Stays::default());
    };
    Stays::settled(seconds).map_err(|what| Failure::plain(Doing::Fit, format!("`settle`: {what}")))
}

//! What is checked and looked up: functions against the reference, two models, the effects.

use std::path::PathBuf;

use pyo3::prelude::*;
use sesc::report::compare::{page, text};
use sesc::report::next_steps::{self, WithSteps};
use sesc::verify;
use sesc_identify::compare;
use sesc_model::ModelFile;
use sesc_model::effects::Catalog;
use sesc_model::effects::about::about;

use crate::calls::{Stopped, detached, watched};
use crate::errors::{Doing, During, Failure};
use crate::model::{Model, compact, json};
use crate::robot::Robot;
use crate::steps;

/// What `sesc verify --json` prints of the functions of a model, and the unit of each.
#[pyfunction]
#[pyo3(signature = (robot, model, samples, seed, show=None))]
pub(crate) fn verify_model(
    py: Python<'_>,
    robot: PyRef<'_, Robot>,
    model: PyRef<'_, Model>,
    samples: Option<usize>,
    seed: u64,
    show: Option<Py<PyAny>>,
) -> PyResult<(String, Vec<(String, &'static str)>)> {
    let (robot, model) = (robot.inner.clone(), model.inner.clone());
    watched(py, show, Stopped::Abandoned, move |watch| {
        let samples = samples.unwrap_or_else(|| verify::samples(model.dof()));
        let found =
            verify::verify(&robot, &model, samples, seed, watch).during(Doing::ModelFile)?;
        let file = model.file.as_ref().map(|_| "model.toml".to_string());
        let step = next_steps::of_verification(model.support(), file, found.pass);
        let printed = json(&WithSteps {
            found: &found,
            next_steps: &steps::worded([&step], steps::text),
        })?;
        Ok((printed, found.units.into_iter().collect()))
    })
}

/// A model file by its text or its path, and what messages and next steps call it.
type Given = (Option<String>, PathBuf, String);

/// What `sesc compare` prints of two model files, as JSON and as text, and its page, with `robot`
/// drawn where it is known.
#[pyfunction]
#[pyo3(signature = (before, after, robot=None))]
pub(crate) fn compare_models(
    py: Python<'_>,
    before: Given,
    after: Given,
    robot: Option<PyRef<'_, Robot>>,
) -> PyResult<(String, String, String)> {
    let robot = robot.as_deref();
    detached(py, || {
        // Objects are expressions, files are texts.
        let is_object = |name: &str| {
            let mut given = [&before, &after].into_iter();
            given.any(|(text, _, own)| text.is_some() && own == name)
        };
        let named = |model: &str| match is_object(model) {
            true => model.to_string(),
            false => steps::text(model),
        };
        let read = |(text, path, _): &Given| {
            match text {
                Some(text) => ModelFile::parse(text, &path.display().to_string()),
                None => ModelFile::read(path),
            }
            .during(Doing::ModelFile)
        };
        let (first, second) = (read(&before)?, read(&after)?);
        let found = compare::compare(&first, &second).during(Doing::ModelFile)?;
        let drawn = robot.map(|robot| Ok(robot.skeleton(&robot.on(&found.support)?)));
        let drawn = drawn.transpose()?;
        let (names, support) = ([&*before.2, &*after.2], Some(found.support.clone()));
        let steps = next_steps::of_comparison(&found, names, support, false);
        let steps = steps::worded(&steps, named);
        let page = page(
            &found,
            [&first, &second],
            &steps,
            drawn.as_ref(),
            "sesc.compare(…)",
        )
        .map_err(Failure::internal)?;
        let printed = json(&WithSteps {
            found: &found,
            next_steps: &steps,
        })?;
        let text = text(&found, &first.file, &second.file);
        let text = format!("{text}\n{}", next_steps::text(&steps));
        Ok((printed, text, page))
    })
}

/// The effects that a diagnosis knows, as JSON.
#[pyfunction]
pub(crate) fn effects_about(py: Python<'_>) -> PyResult<String> {
    detached(py, || compact(&about(&Catalog::standard())))
}

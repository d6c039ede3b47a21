//! The reading of a CoP and its inverse, with the effects of a model file.

use crate::effects::{self, Catalog, EffectContext, Instance, Measured, PostureContext, Source};
use crate::expr::{Argument, Id};
use crate::functions::Parameters;
use crate::interface::Given;
use crate::model::Model;
use crate::program::{Array, Program, Shape};
use crate::tape::{Kernels, Tape, Values};

/// The robot with the foot cells of the model file.
fn context(model: &Model) -> EffectContext<'_> {
    let cells = model.file.as_ref().map_or(&[][..], |file| &file.cells);
    EffectContext::new(model, cells, false, Catalog::standard())
}

/// The predicted reading of a posture, with the effects of the model
/// file as constants; effects that only a log can show are left out. `None` from
/// sines and cosines: joints may be bent.
pub(super) fn cop(model: &Model, given: Given, params: Option<Vec<f64>>) -> Option<Program> {
    if given != Given::Positions {
        return None;
    }
    let mut inputs = vec![Array::new(Argument::Positions, model.dof())];
    let parameters = match params {
        Some(values) => Parameters::Baked(values),
        None => {
            inputs.push(Array::new(Argument::Parameters, model.base.params.len()));
            Parameters::Argument(model.param_limits.clone())
        }
    };
    let measured = static_measurement(model, Source::Posture, parameters);
    let outputs = measured.reading;
    Some(Program::new(
        measured.into_graph(),
        inputs,
        Shape::Vector(2),
        &outputs,
    ))
}

/// The same for postures with their [`PostureContext`], of which only gravity's
/// direction counts. Inputs: `q`, `r`, `u`.
pub fn tilted_cop(model: &Model) -> Program {
    let measured = static_measurement(
        model,
        Source::Tilted,
        Parameters::Argument(model.param_limits.clone()),
    );
    let outputs = measured.reading;
    let inputs = vec![
        Array::new(Argument::Positions, model.dof()),
        Array::new(Argument::Parameters, model.base.params.len()),
        Array::new(Argument::Context, PostureContext::of(model).len()),
    ];
    Program::new(measured.into_graph(), inputs, Shape::Vector(2), &outputs)
}

fn static_measurement(model: &Model, source: Source, parameters: Parameters) -> Measured<'_> {
    let context = context(model);
    let mut measured = Measured::new(model, source, parameters, &context.cells);
    let instances: Vec<Instance> = model.static_effects().map(|(i, _)| i.clone()).collect();
    let values = model.static_effects().flat_map(|(_, x)| x.iter().copied());
    let values: Vec<f64> = values.collect();
    let unknowns: Vec<Id> = values.iter().map(|x| measured.constant(*x)).collect();
    effects::apply(&mut measured, &context, &instances, &unknowns);
    measured
}

/// The CoP that a reading was made of: the sensor's effects of the model file taken
/// back, last stage first. Input: `reading`, in the record's unit; `None` where
/// there is no effect of the sensor.
pub(super) fn correct_cop(model: &Model, given: Given) -> Option<Program> {
    match given {
        Given::Positions => sensor(model, effects::undo),
        Given::SinesCosines | Given::Direction => None,
    }
}

/// The reading of a CoP (m, the input): the sensor's effects of the model file.
/// What [`Function::CorrectCop`](crate::Function::CorrectCop) is the inverse of.
pub fn sensor_reading(model: &Model) -> Option<Program> {
    sensor(model, effects::sense)
}

type Way = fn(&mut Measured, &EffectContext, &[Instance], &[Id]);

fn sensor(model: &Model, way: Way) -> Option<Program> {
    let of_sensor = |(i, _): &&(Instance, Vec<f64>)| i.effect.is_sensor_effect(&i.target);
    let parts: Vec<_> = model.static_effects().filter(of_sensor).collect();
    if parts.is_empty() {
        return None;
    }
    let context = context(model);
    let baked = Parameters::Baked(model.params());
    let mut measured = Measured::new(model, Source::Posture, baked, &context.cells);
    measured.reading = [0, 1].map(|axis| measured.g().input(Argument::Reading, axis));
    let instances: Vec<Instance> = parts.iter().map(|(i, _)| i.clone()).collect();
    let values = parts.iter().flat_map(|(_, x)| x);
    let unknowns: Vec<Id> = values.map(|x| measured.constant(*x)).collect();
    way(&mut measured, &context, &instances, &unknowns);
    let outputs = measured.reading;
    let inputs = vec![Array::new(Argument::Reading, 2)];
    let shape = Shape::Vector(2);
    Some(Program::new(measured.into_graph(), inputs, shape, &outputs))
}

impl Model {
    /// The reading of a CoP, m to the record's unit.
    pub fn reading_of(&self, cop: [f64; 2]) -> [f64; 2] {
        let mut reading = cop;
        if let Some(program) = sensor_reading(self) {
            let tape = Tape::new(&program);
            tape.run(&[Values::Shared(&cop)], 1, &mut reading, Kernels::LIBM);
        }
        reading
    }

    /// Largest reading on each axis of CoPs within the robot's reach, in the
    /// record's unit: what corners show of an affine sensor.
    pub(crate) fn largest_reading(&self) -> [f64; 2] {
        let reach = self.reach();
        let corners = [[1.0, 1.0], [1.0, -1.0], [-1.0, 1.0], [-1.0, -1.0]];
        let readings = corners.map(|corner| self.reading_of(corner.map(|x: f64| x * reach)));
        [0, 1].map(|axis| {
            readings
                .iter()
                .fold(0.0, |most: f64, y| most.max(libm::fabs(y[axis])))
        })
    }
}

//! The reading of a CoP and its inverse, with the effects of a model file.

use super::posture::context;
use crate::effects::{self, ContextSource, EffectContext, Instance, Measured};
use crate::expr::{Argument, Id};
use crate::functions::Parameters;
use crate::interface::{Function, Given};
use crate::model::Model;
use crate::program::{Array, Program, Shape};
use crate::tape::{Kernels, Tape, Values};

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
/// What [`Function::CorrectCop`] is the inverse of.
pub fn sensor_reading(model: &Model) -> Option<Program> {
    sensor(model, effects::sense)
}

type Way = fn(&mut Measured, &EffectContext, &[Instance], &[Id]);

fn sensor(model: &Model, way: Way) -> Option<Program> {
    let parts = model.effects_of(Function::CorrectCop);
    if parts.is_empty() {
        return None;
    }
    let context = context(model);
    let baked = Parameters::Baked(model.params());
    let mut measured = Measured::new(
        model,
        ContextSource::Posture,
        Given::Positions,
        baked,
        &context.cells,
    );
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

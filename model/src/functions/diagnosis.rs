//! Programs of the measurement with effects, for fitting them.

use super::Parameters;
use super::circumstances::{Circumstances, Source};
use super::measured::Measured;
use crate::effects::{self, EffectContext, Instance, Stage};
use crate::expr::Id;
use crate::model::{Given, Model};
use crate::program::{Array, Program, Shape};

/// Input arrays: q, then unknowns `e`, then circumstances `u`; r is constant.
fn inputs(context: &EffectContext, unknowns: usize) -> Vec<Array> {
    let array = |name, len| Array { name, len };
    vec![
        array("q", context.model.dof()),
        array("e", unknowns),
        array("u", Circumstances::of(context.model).len()),
    ]
}

fn written<'m>(
    context: &EffectContext<'m>,
    instances: &[Instance],
    params: &[f64],
) -> (Measured<'m>, Vec<Id>) {
    let baked = Some(params.to_vec());
    let mut measured = Measured::new(context.model, Source::Log, 2, baked, &context.cells);
    let count = instances.iter().map(|i| i.unknowns(context)).sum();
    let unknowns: Vec<Id> = (0..count).map(|k| measured.g().input(1, k)).collect();
    effects::apply(&mut measured, context, instances, &unknowns);
    (measured, unknowns)
}

/// The reading of a posture of a log under effects, and its derivative with
/// respect to each unknown: rows x and y, columns value, ∂/∂e_1, ∂/∂e_2, ….
///
/// Inputs: `q`, `e` (unknowns in the order of the instances), `u`
/// ([`Circumstances`]). Base parameters are the constants `params`.
pub fn reading(context: &EffectContext, instances: &[Instance], params: &[f64]) -> Program {
    let (mut measured, unknowns) = written(context, instances, params);
    let reading = measured.reading;
    let mut columns = vec![reading.to_vec()];
    for &unknown in &unknowns {
        columns.push(measured.g().derivative(&reading, unknown));
    }
    let outputs: Vec<Id> = (0..2)
        .flat_map(|axis| columns.iter().map(move |column| column[axis]))
        .collect();
    let shape = Shape::Matrix {
        rows: 2,
        cols: columns.len(),
    };
    let inputs = inputs(context, unknowns.len());
    Program::new(measured.into_graph(), inputs, shape, &outputs)
}

/// Gravity moments of all joints over the weight under effects, m, and how far
/// the reading moves with each joint: rows moments, ∂y_x/∂φ, ∂y_y/∂φ.
///
/// What decides on which side of its dead band a joint rests. Inputs as in
/// [`reading`].
pub fn moments(context: &EffectContext, instances: &[Instance], params: &[f64]) -> Program {
    let (mut measured, unknowns) = written(context, instances, params);
    let dof = context.model.dof();
    let moments = measured.moments("m");
    let slopes = measured.slopes();
    let outputs: Vec<Id> = moments.into_iter().chain(slopes).collect();
    let shape = Shape::Matrix { rows: 3, cols: dof };
    let inputs = inputs(context, unknowns.len());
    Program::new(measured.into_graph(), inputs, shape, &outputs)
}

/// The reading that a posture alone foretells, with the effects of the model
/// file as constants; effects that only a log can show are left out. `None` from
/// sines and cosines: joints may be bent.
pub(super) fn cop(model: &Model, given: Given, parameters: Parameters) -> Option<Program> {
    if given != Given::Positions {
        return None;
    }
    let baked = (parameters == Parameters::Baked).then(|| model.params());
    let mut inputs = vec![Array {
        name: "q",
        len: model.dof(),
    }];
    if baked.is_none() {
        inputs.push(Array {
            name: "r",
            len: model.base.params.len(),
        });
    }
    let measured = static_measurement(model, Source::Posture, baked);
    let outputs = measured.reading;
    Some(Program::new(
        measured.into_graph(),
        inputs,
        Shape::Vector(2),
        &outputs,
    ))
}

/// The same for postures with their [`Circumstances`], of which only gravity's
/// direction counts. Inputs: `q`, `r`, `u`.
pub fn tilted_cop(model: &Model) -> Program {
    let measured = static_measurement(model, Source::Tilted, None);
    let outputs = measured.reading;
    let array = |name, len| Array { name, len };
    let inputs = vec![
        array("q", model.dof()),
        array("r", model.base.params.len()),
        array("u", Circumstances::of(model).len()),
    ];
    Program::new(measured.into_graph(), inputs, Shape::Vector(2), &outputs)
}

fn static_measurement(model: &Model, source: Source, baked: Option<Vec<f64>>) -> Measured<'_> {
    let cells = model.file.as_ref().map_or(&[][..], |file| &file.cells);
    let context = EffectContext::new(model, cells, false);
    let mut measured = Measured::new(model, source, 2, baked, cells);
    let instances: Vec<Instance> = model.static_effects().map(|(i, _)| i.clone()).collect();
    let values = model.static_effects().flat_map(|(_, x)| x.iter().copied());
    let values: Vec<f64> = values.collect();
    let unknowns: Vec<Id> = values.iter().map(|x| measured.constant(*x)).collect();
    effects::apply(&mut measured, &context, &instances, &unknowns);
    measured
}

/// Joint positions of a posture after faults of wiring, which have no unknowns: of
/// `q`, without the measurement behind them.
pub fn wired_joints(context: &EffectContext, instances: &[Instance]) -> Program {
    let params = Some(vec![0.0; context.model.base.params.len()]);
    let mut measured = Measured::new(context.model, Source::Posture, 2, params, &context.cells);
    for instance in instances {
        if instance.effect.stage() == Stage::Wiring {
            instance
                .effect
                .rewrite(&instance.target, &mut measured, &[]);
        }
    }
    let outputs = measured.joints.clone();
    let shape = Shape::Vector(outputs.len());
    let inputs = vec![Array {
        name: "q",
        len: context.model.dof(),
    }];
    Program::new(measured.into_graph(), inputs, shape, &outputs)
}

/// What faults of wiring and of the record, which have no unknowns, make of a CoP
/// (m, the input).
pub fn wired_reading(context: &EffectContext, instances: &[Instance]) -> Program {
    let params = Some(vec![0.0; context.model.base.params.len()]);
    let mut measured = Measured::new(context.model, Source::Posture, 2, params, &context.cells);
    measured.reading = [0, 1].map(|axis| measured.g().input(0, axis));
    effects::sense(&mut measured, context, instances, &[]);
    let outputs = measured.reading;
    let inputs = vec![Array {
        name: "reading",
        len: 2,
    }];
    Program::new(measured.into_graph(), inputs, Shape::Vector(2), &outputs)
}

/// Joint positions of a posture as effects bend them. Inputs as in [`reading`].
pub fn joints(context: &EffectContext, instances: &[Instance], params: &[f64]) -> Program {
    let (measured, unknowns) = written(context, instances, params);
    let outputs = measured.joints.clone();
    let shape = Shape::Vector(outputs.len());
    let inputs = inputs(context, unknowns.len());
    Program::new(measured.into_graph(), inputs, shape, &outputs)
}

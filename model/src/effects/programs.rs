//! Programs of the measurement with effects, for fitting them.

use super::{EffectContext, Instance, Stage, apply, sense};
use crate::expr::{Argument, Id};
use crate::functions::Parameters;
use crate::interface::Given;
use crate::measurement::{ContextSource, Measured, PostureContext};
use crate::program::{Array, Program, Shape};

/// Input arrays: q, then unknowns `e`, then posture context `u`; r is constant.
fn inputs(context: &EffectContext, unknowns: usize) -> Vec<Array> {
    vec![
        Array::new(Argument::Positions, context.robot.dof()),
        Array::new(Argument::Unknowns, unknowns),
        Array::new(Argument::Context, PostureContext::of(context.robot).len()),
    ]
}

fn written<'m>(
    context: &EffectContext<'m>,
    instances: &[Instance],
    source: ContextSource,
    parameters: Parameters,
) -> (Measured<'m>, Vec<Id>) {
    let mut measured = Measured::new(
        context.robot,
        source,
        Given::Positions,
        parameters,
        &context.cells,
    );
    let count = instances.iter().map(|i| i.unknowns(context)).sum();
    let unknowns: Vec<Id> = (0..count)
        .map(|k| measured.g().input(Argument::Unknowns, k))
        .collect();
    apply(&mut measured, context, instances, &unknowns);
    (measured, unknowns)
}

/// The reading of a posture of a log under effects, and its derivative with
/// respect to each unknown: rows x and y, columns value, ∂/∂e_1, ∂/∂e_2, ….
///
/// Inputs: `q`, `e` (unknowns in the order of the instances), `u`
/// ([`PostureContext`]). Base parameters are the constants `params`.
pub fn reading(context: &EffectContext, instances: &[Instance], params: &[f64]) -> Program {
    let (measured, unknowns) = written(
        context,
        instances,
        ContextSource::Log,
        Parameters::Baked(params.to_vec()),
    );
    let reading = measured.reading;
    let inputs = inputs(context, unknowns.len());
    slopes_beside(measured, &reading, &unknowns, inputs)
}

/// The reading and its derivative by each base parameter, through joints that give way under their
/// moments: rows x and y, columns value, ∂/∂r_1, ∂/∂r_2, …. Inputs: `q`, `e`, `u`, `r`.
pub fn reading_by_masses(context: &EffectContext, instances: &[Instance]) -> Program {
    let params = context.robot.base.params.len();
    let unbounded = Parameters::Argument(vec![f64::INFINITY; params]);
    let (measured, unknowns) = written(context, instances, ContextSource::Log, unbounded);
    let masses: Vec<Id> = (0..params)
        .map(|k| measured.g().input(Argument::Parameters, k))
        .collect();
    let reading = measured.reading;
    let mut inputs = inputs(context, unknowns.len());
    inputs.push(Array::new(Argument::Parameters, params));
    slopes_beside(measured, &reading, &masses, inputs)
}

/// The reading where loose joints rest as their gravity moments have them, as a model file
/// predicts it, then how far into its dead band each joint is, −1 to 1 (0 without one).
///
/// Inputs: `q`, `e`, `u` without sides, `r`.
pub fn resting_reading(context: &EffectContext, instances: &[Instance]) -> Program {
    let params = context.robot.base.params.len();
    let unbounded = Parameters::Argument(vec![f64::INFINITY; params]);
    let (measured, unknowns) = written(context, instances, ContextSource::Resting, unbounded);
    let mut outputs = measured.reading.to_vec();
    let zero = measured.constant(0.0);
    let sides = measured.sides.iter().map(|side| side.unwrap_or(zero));
    outputs.extend(sides);
    let mut inputs = inputs(context, unknowns.len());
    inputs.push(Array::new(Argument::Parameters, params));
    let shape = Shape::Vector(outputs.len());
    Program::new(measured.into_graph(), inputs, shape, &outputs)
}

/// Gravity moments of all joints over the weight under effects, m, and how far
/// the reading moves with each joint: rows moments, ∂y_x/∂φ, ∂y_y/∂φ.
///
/// What decides on which side of its dead band a joint rests. Inputs as in
/// [`reading`].
pub fn moments(context: &EffectContext, instances: &[Instance], params: &[f64]) -> Program {
    let (mut measured, unknowns) = written(
        context,
        instances,
        ContextSource::Log,
        Parameters::Baked(params.to_vec()),
    );
    let dof = context.robot.dof();
    let moments = measured.moments("m");
    let slopes = measured.slopes("m");
    let outputs: Vec<Id> = moments.into_iter().chain(slopes).collect();
    let shape = Shape::Matrix { rows: 3, cols: dof };
    let inputs = inputs(context, unknowns.len());
    Program::new(measured.into_graph(), inputs, shape, &outputs)
}

/// A measurement of which only joints or the sensor are asked.
fn without_masses<'m>(context: &EffectContext<'m>) -> Measured<'m> {
    let params = Parameters::Baked(vec![0.0; context.robot.base.params.len()]);
    Measured::new(
        context.robot,
        ContextSource::Posture,
        Given::Positions,
        params,
        &context.cells,
    )
}

/// Joint positions of a posture after wiring errors, which have no unknowns: of
/// `q`, without the measurement behind them.
pub fn wired_joints(context: &EffectContext, instances: &[Instance]) -> Program {
    let mut measured = without_masses(context);
    for instance in instances {
        if instance.effect.stage() == Stage::Wiring {
            instance
                .effect
                .rewrite(&instance.target, &mut measured, &[]);
        }
    }
    let outputs = measured.joints.clone();
    let shape = Shape::Vector(outputs.len());
    let inputs = vec![Array::new(Argument::Positions, context.robot.dof())];
    Program::new(measured.into_graph(), inputs, shape, &outputs)
}

/// What wiring errors and of the record, which have no unknowns, make of a CoP
/// (m, the input).
pub fn wired_reading(context: &EffectContext, instances: &[Instance]) -> Program {
    let mut measured = without_masses(context);
    measured.reading = [0, 1].map(|axis| measured.g().input(Argument::Reading, axis));
    sense(&mut measured, context, instances, &[]);
    let outputs = measured.reading;
    let inputs = vec![Array::new(Argument::Reading, 2)];
    Program::new(measured.into_graph(), inputs, Shape::Vector(2), &outputs)
}

/// Joint positions of a posture as effects bend them. Inputs as in [`reading`].
pub fn joints(context: &EffectContext, instances: &[Instance], params: &[f64]) -> Program {
    let (measured, unknowns) = written(
        context,
        instances,
        ContextSource::Log,
        Parameters::Baked(params.to_vec()),
    );
    let outputs = measured.joints.clone();
    let shape = Shape::Vector(outputs.len());
    let inputs = inputs(context, unknowns.len());
    Program::new(measured.into_graph(), inputs, shape, &outputs)
}

/// How the sole that is `below_m` under the origin of `link`, along its −z, lies on the sole
/// plane of the support under effects: its height, m, and the sines of its roll and pitch; rows of
/// these, columns value, ∂/∂e_1, ….
///
/// Inputs as in [`reading`]. Where joints bend, `params` are the base parameters that they
/// bend under.
pub fn other_sole(
    context: &EffectContext,
    instances: &[Instance],
    params: &[f64],
    (link, below_m): (usize, f64),
) -> Program {
    let (mut measured, unknowns) = written(
        context,
        instances,
        ContextSource::Log,
        Parameters::Baked(params.to_vec()),
    );
    let lies = measured.lies(link, below_m);
    let inputs = inputs(context, unknowns.len());
    slopes_beside(measured, &lies, &unknowns, inputs)
}

/// The same of a robot without effects, of `q` alone, and its slopes by every joint: rows of
/// height, roll and pitch, columns value, ∂/∂q_1, ….
pub fn other_sole_by_joints(robot: &crate::Robot, (link, below_m): (usize, f64)) -> Program {
    let params = Parameters::Baked(vec![0.0; robot.base.params.len()]);
    let mut measured = Measured::new(robot, ContextSource::Posture, Given::Positions, params, &[]);
    let joints: Vec<Id> = (0..robot.dof())
        .map(|j| measured.g().input(Argument::Positions, j))
        .collect();
    let lies = measured.lies(link, below_m);
    let inputs = vec![Array::new(Argument::Positions, robot.dof())];
    slopes_beside(measured, &lies, &joints, inputs)
}

/// Rows of values, each with its derivatives by `unknowns`.
fn slopes_beside(
    measured: Measured,
    values: &[Id],
    unknowns: &[Id],
    inputs: Vec<Array>,
) -> Program {
    let mut columns = vec![values.to_vec()];
    for &unknown in unknowns {
        columns.push(measured.g().derivative(values, unknown));
    }
    let rows = 0..values.len();
    let outputs: Vec<Id> = rows
        .flat_map(|row| columns.iter().map(move |column| column[row]))
        .collect();
    let shape = Shape::Matrix {
        rows: values.len(),
        cols: columns.len(),
    };
    Program::new(measured.into_graph(), inputs, shape, &outputs)
}

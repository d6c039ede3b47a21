//! The functions of the C interface, made once: programs, binary points, bounds.

use super::Scalar;
use super::routine::{Input, Routine};
use super::ticks::Ticks;
use crate::Error;
use crate::error::Problem;
use sesc_model::bounds::{Overflow, Quantity, Unfit};
use sesc_model::expr::Argument;
use sesc_model::program::Program;
use sesc_model::{Function, Given, Model};

/// Every function that can be had, in the order of the header.
pub(super) fn routines(
    model: &Model,
    scalar: Scalar,
    ticks: Option<&Ticks>,
) -> Result<Vec<Routine>, Error> {
    let mut routines = Vec::new();
    let baked: &[bool] = match &model.file {
        Some(_) => &[false, true],
        None => &[false],
    };
    for &baked in baked {
        for given in [Given::Positions, Given::SinesCosines] {
            for function in Function::ALL {
                let program = match baked {
                    false => model.program(function, given),
                    true if matches!(function, Function::Com | Function::Cop) => {
                        model.baked_program(function, given)
                    }
                    true => None,
                };
                let Some(program) = program.filter(|program| !program.shape.is_empty()) else {
                    continue;
                };
                routines.push(routine(model, scalar, function, given, baked, program)?);
            }
        }
        if let Some(ticks) = ticks {
            let of_ticks: Vec<Routine> = routines
                .iter()
                .filter(|r| r.baked == baked && r.given == ticks.given && !r.is_of_ticks())
                .map(|routine| ticks.routine(model, routine))
                .collect();
            routines.extend(of_ticks);
        }
    }
    let (function, given) = (Function::CorrectCop, Given::Positions);
    if let Some(program) = model.program(function, given) {
        routines.push(routine(model, scalar, function, given, false, program)?);
    }
    share_formats(&mut routines);
    for routine in &mut routines {
        routine.bound = match (routine.input, ticks, &routine.formats, scalar.precision()) {
            (Input::Ticks, Some(ticks), ..) => ticks.bound(model, routine),
            (_, _, Some(formats), _) => model.rounding_fixed(&routine.program, formats).worst,
            (_, _, None, Some(precision)) => model.rounding(&routine.program, precision).worst,
            (_, _, None, None) => unreachable!("fixed point comes with formats"),
        };
        // An iteration has no proven bound; its header says so.
        if !routine.bound.is_finite() && routine.function != Function::CorrectCop {
            let problem = match routine.counts.other {
                0 => Problem::Unbounded {
                    function: routine.name(),
                },
                _ => Problem::UnboundedEffect {
                    function: routine.name(),
                },
            };
            return Err(problem.into());
        }
    }
    Ok(routines)
}

fn routine(
    model: &Model,
    scalar: Scalar,
    function: Function,
    given: Given,
    baked: bool,
    program: Program,
) -> Result<Routine, Error> {
    let formats = match scalar {
        Scalar::Fixed32 => {
            let formats = model.fixed_point(&program);
            Some(formats.map_err(|unfit| no_fixed_point(model, function, &unfit))?)
        }
        _ => None,
    };
    Ok(Routine {
        function,
        given,
        input: Input::Program,
        baked,
        counts: program.counts(),
        look_ups: 0,
        program,
        formats,
        bound: f64::INFINITY,
    })
}

fn no_fixed_point(model: &Model, function: Function, unfit: &Unfit) -> Problem {
    match unfit {
        Unfit::Overflow(overflow) => too_large(model, function, overflow),
        Unfit::Operation => Problem::NoFixedPoint {
            function: function.name(),
        },
    }
}

fn too_large(model: &Model, function: Function, overflow: &Overflow) -> Problem {
    let what = match overflow.angle {
        true => "an angle needs 16 bits below its point",
        false => "32 bits do not hold it",
    };
    let of_function = |text: &str| format!("{text} of {}", function.name());
    let quantity = match &overflow.quantity {
        Quantity::Input {
            argument: Argument::Positions,
            index,
        } => format!("the position of joint `{}`", model.tree.dofs[*index].joint),
        Quantity::Input { argument, index } => {
            of_function(&format!("{}[{index}]", argument.name()))
        }
        Quantity::Named(name) => of_function(&format!("`{name}`")),
        Quantity::Step(title) => of_function(&format!("a step for `{title}`")),
        Quantity::Intermediate => of_function("an intermediate result"),
    };
    Problem::Overflow {
        reason: format!(
            "{quantity} may reach {:.3e}; {what} (the robot reaches {:.3e} m)",
            overflow.size,
            model.reach()
        ),
    }
}

/// Variants of one function share the binary point of its results.
fn share_formats(routines: &mut [Routine]) {
    for function in Function::ALL {
        let of = |r: &&Routine| r.function == function;
        let outputs = routines
            .iter()
            .filter(of)
            .filter_map(|r| r.formats.as_ref());
        let Some(coarsest) = outputs.map(|formats| formats.output).min() else {
            continue;
        };
        for routine in routines.iter_mut().filter(|r| r.function == function) {
            if let Some(formats) = &mut routine.formats {
                formats.share_output(coarsest);
            }
        }
    }
}

#[cfg(test)]
mod tests;

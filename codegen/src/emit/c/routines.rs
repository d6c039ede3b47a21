//! The functions of the C interface, made once: programs, binary points, bounds.

use super::exported::{Exported, Input};
use super::ticks::Ticks;
use super::{Options, Scalar};
use crate::Error;
use crate::error::Problem;
use crate::facts::Facts;
use crate::routines::{Routine, beyond};
use crate::seen;
use sesc_model::bounds::{self, Formats, Overflow, Quantity, Unfit};
use sesc_model::expr::Argument;
use sesc_model::{Function, Given};

/// Every function that can be had, in the order of the header.
pub(super) fn routines<'f>(
    facts: &'f Facts,
    options: &Options,
    ticks: Option<&Ticks>,
) -> Result<Vec<Exported<'f>>, Error> {
    let scalar = options.scalar;
    let (corrections, of_posture): (Vec<&Routine>, Vec<&Routine>) = facts
        .routines
        .iter()
        .filter(|routine| routine.given != Given::Direction && !routine.program.shape.is_empty())
        // The ground's load divides it: floats alone have room for that.
        .filter(|routine| scalar != Scalar::Fixed32 || routine.function != Function::Zmp)
        .partition(|routine| routine.function == Function::CorrectCop);
    let most = match scalar {
        Scalar::F32 => f64::from(f32::MAX),
        Scalar::F64 | Scalar::Fixed32 => f64::MAX,
    };
    if let Some(beyond) = beyond(facts.routines.iter(), most) {
        let function = beyond.function.name();
        return Err(Problem::NotFinite { function }.into());
    }
    let mut all = Vec::new();
    for baked in [false, true] {
        let first = all.len();
        for routine in of_posture.iter().filter(|routine| routine.baked == baked) {
            all.push(exported(facts, scalar, routine)?);
        }
        if let Some(ticks) = ticks {
            let of_ticks = all[first..].iter().filter(|r| r.given == ticks.given);
            let of_ticks: Vec<Exported> = of_ticks.map(|r| ticks.routine(facts.dofs, r)).collect();
            all.extend(of_ticks);
        }
        if options.lanes.is_some() {
            batches(&mut all, first);
        }
    }
    let first = all.len();
    for routine in corrections {
        all.push(exported(facts, scalar, routine)?);
    }
    if options.lanes.is_some() {
        batches(&mut all, first);
    }
    share_formats(&mut all);
    for routine in &mut all {
        routine.bound = match (routine.input, ticks, &routine.formats, scalar.precision()) {
            (Input::Ticks, Some(ticks), ..) => ticks.bound(facts.dofs, routine),
            (_, _, Some(formats), _) => {
                bounds::prove_fixed(&routine.program, &routine.inputs, formats).worst
            }
            (_, _, None, Some(precision)) => routine.rounding(precision).worst,
            (_, _, None, None) => unreachable!("fixed point comes with formats"),
        };
        if scalar == Scalar::F32 {
            routine.seen = seen::largest(facts, routine, routine.bound);
        }
        // An iteration has no proven bound, and neither has a load on the ground that rounding
        // may make anything, in robots of kilometres or with joints that give way, nor the slope of
        // a root at no load; the header says so.
        let may_lack = matches!(
            routine.function,
            Function::CorrectCop | Function::CopJacobian | Function::Zmp
        );
        if !routine.bound.is_finite() && !may_lack {
            let function = routine.name();
            return Err(match routine.counts.other {
                0 => Problem::Unbounded { function },
                _ => Problem::UnboundedEffect { function },
            }
            .into());
        }
    }
    Ok(all)
}

/// Functions of many postures, behind those of one from `first` on.
fn batches(all: &mut Vec<Exported>, first: usize) {
    for k in first..all.len() {
        if all[k].input == Input::Program && all[k].given == Given::Positions {
            all.push(Exported {
                input: Input::Batch,
                ..all[k].clone()
            });
        }
    }
}

fn exported<'f>(
    facts: &Facts,
    scalar: Scalar,
    routine: &'f Routine,
) -> Result<Exported<'f>, Error> {
    let formats = match scalar {
        Scalar::Fixed32 => {
            let formats = Formats::choose(&routine.program, &routine.inputs);
            Some(formats.map_err(|unfit| no_fixed_point(facts, routine.function, &unfit))?)
        }
        _ => None,
    };
    Ok(Exported {
        routine,
        input: Input::Program,
        counts: routine.program.counts(),
        look_ups: 0,
        formats,
        bound: f64::INFINITY,
        seen: None,
    })
}

fn no_fixed_point(facts: &Facts, function: Function, unfit: &Unfit) -> Problem {
    match unfit {
        Unfit::Overflow(overflow) => too_large(facts, function, overflow),
        Unfit::Operation => Problem::NoFixedPoint {
            function: function.name(),
        },
    }
}

fn too_large(facts: &Facts, function: Function, overflow: &Overflow) -> Problem {
    let what = match overflow.angle {
        true => "an angle needs 16 bits below its point",
        false => "32 bits do not hold it",
    };
    let of_function = |text: &str| format!("{text} of {}", function.name());
    let quantity = match &overflow.quantity {
        Quantity::Input {
            argument: Argument::Positions,
            index,
        } => format!("the position of joint `{}`", facts.dofs[*index].joint),
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
            facts.model.reach()
        ),
    }
}

/// Variants of one function share the binary point of its results.
fn share_formats(routines: &mut [Exported]) {
    for function in Function::ALL {
        let of = |r: &&Exported| r.function == function;
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

//! The comment at the top of both files: the robot, what functions cost, how exact they are.

use super::exported::Exported;
use super::{Options, Scalar};
use crate::emit::header;
use crate::emit::header::printable;
use crate::facts::Facts;
use sesc_model::Function;

/// What is to be said of functions of ticks.
const OF_TICKS: [&str; 2] = [
    "Functions of ticks are compared with the angles and positions that the ticks stand for;",
    "look_up counts the sines and cosines that they read from a table.",
];

/// What is to be said of the stack.
const OF_STACK: [&str; 2] = [
    "stack: bytes at most of a function and all that it calls, by gcc with -O1, -Os or more; by",
    "clang up to a third more, and several times as much without optimisation.",
];

pub(super) fn about(facts: &Facts, routines: &[Exported], options: &Options) -> Vec<String> {
    let scalar = options.scalar;
    let mut lines = header::about(facts);
    lines.push(
        "method         statically equivalent serial chain (SESC), CoM = r_0 + sum of B_i(q) r_i:"
            .to_string(),
    );
    lines.push(format!("               {}, eq. (4)", header::PAPER));
    lines.push(format!(
        "scalar         {}",
        match scalar {
            Scalar::F64 => "f64 (double)",
            Scalar::F32 => "f32 (float); double is never touched",
            Scalar::Fixed32 => "fixed32 (int32_t, binary points proven from ranges; no division)",
        }
    ));
    lines.push(String::new());
    lines.push(format!(
        "{:<22} {:>7} {:>7} {:>8} {:>8} {:>7}   proven |rounding error|",
        "function", "mul", "add", "sin_cos", "look_up", "stack"
    ));
    for routine in routines {
        let counts = routine.counts;
        lines.push(format!(
            "{:<22} {:>7} {:>7} {:>8} {:>8} {:>7}   {}{}",
            routine.name(),
            counts.mul,
            counts.add,
            counts.sin_cos,
            routine.look_ups,
            routine.stack(facts, options),
            header::bound_or_seen(routine.function, routine.bound, routine.seen),
            header::others(routine.function, counts)
        ));
    }
    lines.extend(header::BOUNDS_HOLD.map(str::to_string));
    let is_seen = routines.iter().any(|routine| routine.seen.is_some());
    lines.extend(header::zmp_bound_holds(
        facts,
        scalar != Scalar::Fixed32,
        is_seen,
    ));
    let proven = |r: &Exported| r.function != Function::CorrectCop || r.bound.is_finite();
    let proven = routines.iter().all(proven);
    lines.extend(header::cautions(facts, proven));
    if routines.iter().any(Exported::is_of_ticks) {
        lines.extend(OF_TICKS.map(str::to_string));
    }
    lines.extend(OF_STACK.map(str::to_string));
    lines
        .iter()
        .map(|line| printable(line).trim_end().to_string())
        .collect()
}

//! The largest rounding error that random postures show, where no proven bound is of use.
//!
//! ```text
//! error = max |f32(x) − f64(x)|        a sum, product or quotient of f32: that of f64, rounded
//! ```
//!
//! Doubles have more than twice the digits of f32, so rounding their results is what f32 computes.

use sesc_model::Function;
use sesc_model::expr::{Argument, Expr};
use sesc_model::program::Program;

use crate::facts::Facts;
use crate::routines::Routine;

/// A bound of the ZMP beyond this, m, is of no use to anyone.
const USEFUL_M: f64 = 1e-3;
/// Postures that are tried.
pub(crate) const POSTURES: usize = 1000;

/// The largest error of `routine` in f32 on random postures, with the parameters of CAD; none
/// where `bound`, which is proven, is of use.
pub(crate) fn largest(facts: &Facts, routine: &Routine, bound: f64) -> Option<f64> {
    if routine.function != Function::Zmp || bound <= USEFUL_M {
        return None;
    }
    let mut seed = 1_u64;
    let mut uniform = |lower: f64, upper: f64| {
        seed = seed.wrapping_mul(6_364_136_223_846_793_005);
        seed = seed.wrapping_add(1_442_695_040_888_963_407);
        let share = (seed >> 11) as f64 / (1_u64 << 53) as f64;
        // As f32 holds it.
        single(lower + share * (upper - lower))
    };
    let mut worst = 0.0_f64;
    for _ in 0..POSTURES {
        let q = facts.dofs.iter();
        let q: Vec<f64> = q.map(|dof| uniform(dof.lower, dof.upper)).collect();
        let arrays = routine.program.inputs.iter().zip(&routine.inputs);
        let arrays = arrays.map(|(array, ranges)| match array.argument {
            Argument::Positions => q.clone(),
            Argument::Sines => sines(facts, &q, libm::sin),
            Argument::Cosines => sines(facts, &q, libm::cos),
            Argument::Parameters => facts.model.cad_params().into_iter().map(single).collect(),
            _ => (ranges.iter())
                .map(|range| uniform(range.lower, range.upper))
                .collect(),
        });
        let arrays: Vec<Vec<f64>> = arrays.collect();
        // The ground does not carry the robot.
        let Some(exact) = run(&routine.program, &arrays, |x| x) else {
            continue;
        };
        let rounded = run(&routine.program, &arrays, single);
        for (a, b) in exact.iter().zip(rounded.into_iter().flatten()) {
            worst = worst.max(libm::fabs(a - b));
        }
    }
    Some(worst)
}

fn single(x: f64) -> f64 {
    f64::from(x as f32)
}

/// What `_sc` takes: of a prismatic joint its position, and zero.
fn sines(facts: &Facts, q: &[f64], of: fn(f64) -> f64) -> Vec<f64> {
    let joints = facts.dofs.iter().zip(q);
    let value = |(dof, q): (&sesc_model::tree::Dof, &f64)| match (dof.prismatic, of(0.0) == 0.0) {
        (false, _) => single(of(*q)),
        (true, true) => *q,
        (true, false) => 0.0,
    };
    joints.map(value).collect()
}

/// The outputs, each operation rounded; none where a value is below what bounds assume.
fn run(program: &Program, arrays: &[Vec<f64>], round: impl Fn(f64) -> f64) -> Option<Vec<f64>> {
    let mut values: Vec<f64> = Vec::with_capacity(program.nodes.len());
    for (id, node) in program.iter() {
        let at = |id: sesc_model::expr::Id| values[id.index()];
        let value = match node.expr {
            Expr::Const(x) => x,
            Expr::Input { argument, index } => arrays[program.slot(argument)][index as usize],
            Expr::Neg(a) => -at(a),
            Expr::Add(a, b) => at(a) + at(b),
            Expr::Sub(a, b) => at(a) - at(b),
            Expr::Mul(a, b) => at(a) * at(b),
            Expr::Div(a, b) => at(a) / at(b),
            Expr::Sin(a) => libm::sin(at(a)),
            Expr::Cos(a) => libm::cos(at(a)),
            Expr::Clamp(a) => at(a).clamp(-1.0, 1.0),
            Expr::Pow(a, b) => libm::pow(at(a), at(b)),
            Expr::Max(a, b) => at(a).max(at(b)),
        };
        if program.least(id).is_some_and(|least| value < least) {
            return None;
        }
        values.push(round(value));
    }
    Some(
        program
            .outputs
            .iter()
            .map(|id| values[id.index()])
            .collect(),
    )
}

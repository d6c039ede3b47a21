//! A plan over blocks of postures: inputs from rows to registers, steps, registers to rows.

use std::ops::Range;

use super::plan::{Binary, Plan, Step};
use super::rows::{Register, read, write};
use super::step::larger;
use super::sums::Sum;
use super::{Kernels, SHORT, Values};
use crate::wide::{Loops, widest};

/// All blocks of a call.
pub(super) struct Blocks<'a, const N: usize> {
    pub plan: &'a Plan,
    /// An array for each input of the plan, with enough values.
    pub arguments: &'a [Values<'a>],
    pub postures: Range<usize>,
    pub out: &'a mut [f64],
    pub kernels: Kernels,
}

impl<const N: usize> Blocks<'_, N> {
    pub(super) fn run(self) {
        let plan = self.plan;
        let mut registers = vec![Register([0.0; N]); plan.registers];
        let uniform = uniform(plan, self.arguments);
        for (register, value) in registers.iter_mut().zip(&uniform) {
            if let Some(value) = value {
                register.0.fill(*value);
            }
        }
        // To look up what is shared costs more than to load it for a few postures.
        let shared: &[Option<f64>] = if N == SHORT { &[] } else { &uniform };
        let width = plan.outputs.len();
        for start in self.postures.clone().step_by(N) {
            let n = N.min(self.postures.end - start);
            for (places, argument) in plan.inputs.iter().zip(self.arguments) {
                if let Values::PerPosture(values) = argument {
                    let values = &values[start * places.len()..];
                    let is_read = &plan.is_read[places.clone()];
                    read(values, n, is_read, &mut registers[places.clone()]);
                }
            }
            widest(Steps {
                plan,
                registers: &mut registers,
                uniform: shared,
                kernels: self.kernels,
                n,
                out: &mut self.out[start * width..],
            });
        }
    }
}

/// What all postures share, of the first registers.
fn uniform(plan: &Plan, arguments: &[Values]) -> Vec<Option<f64>> {
    let mut uniform = Vec::new();
    for (places, argument) in plan.inputs.iter().zip(arguments) {
        match argument {
            Values::Shared(values) => {
                uniform.extend(values[..places.len()].iter().copied().map(Some));
            }
            Values::PerPosture(_) => uniform.extend(places.clone().map(|_| None)),
        }
    }
    uniform.extend(plan.constants.iter().copied().map(Some));
    uniform
}

/// All steps on one block.
struct Steps<'a, const N: usize> {
    plan: &'a Plan,
    registers: &'a mut [Register<N>],
    uniform: &'a [Option<f64>],
    kernels: Kernels,
    n: usize,
    out: &'a mut [f64],
}

impl<const N: usize> Loops for Steps<'_, N> {
    #[inline(always)]
    fn run(self) {
        steps(self);
    }
}

#[inline(always)]
fn steps<const N: usize>(block: Steps<N>) {
    let Steps {
        plan,
        registers,
        uniform,
        kernels,
        n,
        out,
    } = block;
    for step in &plan.steps {
        match *step {
            Step::Binary(operation, to, of) => match operation {
                Binary::Add => binary(registers, uniform, to, of, |x, y| x + y),
                Binary::Sub => binary(registers, uniform, to, of, |x, y| x - y),
                Binary::Mul => binary(registers, uniform, to, of, |x, y| x * y),
                Binary::Div => binary(registers, uniform, to, of, |x, y| x / y),
                Binary::Max => binary(registers, uniform, to, of, larger),
                Binary::Pow => {
                    let [base, exponent] = of.map(|k| registers[k as usize]);
                    (kernels.power)(&base.0, &exponent.0, &mut registers[to as usize].0);
                }
            },
            Step::Neg(to, a) => binary(registers, uniform, to, [a, a], |x, _| -x),
            Step::Clamp(to, a) => {
                binary(registers, uniform, to, [a, a], |x, _| x.clamp(-1.0, 1.0));
            }
            Step::Write(start) => write(plan, start, registers, n, out),
            Step::SinCos([sin, cos], a) => {
                let [angle, sin, cos] = apart(registers, [a, sin, cos]);
                (kernels.sin_cos)(angle, sin, cos);
            }
            Step::Product(sum, to, of) => match sum {
                Sum::Plus => product(registers, uniform, to, of, |p, w| p + w),
                Sum::Minus => product(registers, uniform, to, of, |p, w| p - w),
                Sum::Reverse => product(registers, uniform, to, of, |p, w| w - p),
            },
            Step::Products(sum, to, [x, c, y, s]) => {
                let [to, x, c, y, s] = apart(registers, [to, x, c, y, s]);
                match sum {
                    Sum::Plus => products(to, x, c, y, s, |p, q| p + q),
                    Sum::Minus => products(to, x, c, y, s, |p, q| p - q),
                    Sum::Reverse => products(to, x, c, y, s, |p, q| q - p),
                }
            }
            Step::Turn(sums, [u, v], [x, c, y, s]) => {
                let [u, v, x, c, y, s] = apart(registers, [u, v, x, c, y, s]);
                match sums {
                    [Sum::Plus, Sum::Plus] => turn(u, v, x, c, y, s, |p, q| p + q, |p, q| p + q),
                    [Sum::Plus, Sum::Minus] => turn(u, v, x, c, y, s, |p, q| p + q, |p, q| p - q),
                    [Sum::Plus, Sum::Reverse] => turn(u, v, x, c, y, s, |p, q| p + q, |p, q| q - p),
                    [_, Sum::Plus] => turn(u, v, x, c, y, s, |p, q| p - q, |p, q| p + q),
                    [_, Sum::Minus] => turn(u, v, x, c, y, s, |p, q| p - q, |p, q| p - q),
                    [_, Sum::Reverse] => turn(u, v, x, c, y, s, |p, q| p - q, |p, q| q - p),
                }
            }
        }
    }
}

/// Registers that differ.
#[inline(always)]
fn apart<const N: usize, const M: usize>(
    registers: &mut [Register<N>],
    places: [u32; M],
) -> [&mut [f64; N]; M] {
    let registers = registers.get_disjoint_mut(places.map(|k| k as usize));
    let registers = registers.expect("a step reads each register once and makes others");
    registers.map(|register| &mut register.0)
}

// Loops stand in functions of their own: of references among its arguments the compiler knows
// that they are apart.

/// Sums of two products.
#[inline(always)]
fn products<const N: usize>(
    to: &mut [f64; N],
    x: &[f64; N],
    c: &[f64; N],
    y: &[f64; N],
    s: &[f64; N],
    sum: impl Fn(f64, f64) -> f64,
) {
    for k in 0..N {
        to[k] = sum(x[k] * c[k], y[k] * s[k]);
    }
}

/// Two sums of products of the same four.
#[inline(always)]
#[allow(clippy::too_many_arguments)] // see above
fn turn<const N: usize>(
    u: &mut [f64; N],
    v: &mut [f64; N],
    x: &[f64; N],
    c: &[f64; N],
    y: &[f64; N],
    s: &[f64; N],
    first: impl Fn(f64, f64) -> f64,
    second: impl Fn(f64, f64) -> f64,
) {
    for k in 0..N {
        let [x, c, y, s] = [x[k], c[k], y[k], s[k]];
        u[k] = first(x * c, y * s);
        v[k] = second(x * s, y * c);
    }
}

/// A product with a sum; factors change places where the first is shared.
#[inline(always)]
fn product<const N: usize>(
    registers: &mut [Register<N>],
    uniform: &[Option<f64>],
    to: u32,
    [x, y, w]: [u32; 3],
    sum: impl Fn(f64, f64) -> f64,
) {
    let shared = |k: u32| uniform.get(k as usize).copied().flatten();
    let [x, y] = if shared(x).is_some() { [y, x] } else { [x, y] };
    let (y_of_all, w_of_all) = (shared(y), shared(w));
    let [to, x, y, w] = apart(registers, [to, x, y, w]);
    match (y_of_all, w_of_all) {
        (None, None) => each(to, x, y, w, |x, y, w| sum(x * y, w)),
        (Some(y), None) => each(to, x, w, w, |x, w, _| sum(x * y, w)),
        (None, Some(w)) => each(to, x, y, y, |x, y, _| sum(x * y, w)),
        (Some(y), Some(w)) => each(to, x, x, x, |x, _, _| sum(x * y, w)),
    }
}

#[inline(always)]
fn each<const N: usize>(
    to: &mut [f64; N],
    x: &[f64; N],
    y: &[f64; N],
    w: &[f64; N],
    f: impl Fn(f64, f64, f64) -> f64,
) {
    for k in 0..N {
        to[k] = f(x[k], y[k], w[k]);
    }
}

/// What all postures share stays in a register of the processor.
#[inline(always)]
fn binary<const N: usize>(
    registers: &mut [Register<N>],
    uniform: &[Option<f64>],
    to: u32,
    [a, b]: [u32; 2],
    f: impl Fn(f64, f64) -> f64,
) {
    let shared = |k: u32| uniform.get(k as usize).copied().flatten();
    match (shared(a), shared(b)) {
        (Some(x), Some(y)) => registers[to as usize].0.fill(f(x, y)),
        (Some(x), None) => {
            let [to, y] = apart(registers, [to, b]);
            each(to, y, y, y, |y, _, _| f(x, y));
        }
        (None, Some(y)) => {
            let [to, x] = apart(registers, [to, a]);
            each(to, x, x, x, |x, _, _| f(x, y));
        }
        (None, None) if a == b => {
            let [to, x] = apart(registers, [to, a]);
            each(to, x, x, x, |x, _, _| f(x, x));
        }
        (None, None) => {
            let [to, x, y] = apart(registers, [to, a, b]);
            each(to, x, y, y, |x, y, _| f(x, y));
        }
    }
}

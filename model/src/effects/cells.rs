#![doc = include_str!("pages/cells.md")]

use super::remedy::digits;
use super::{Effect, EffectContext, Fitted, Measured, Parameter, Reason, Target};
use crate::expr::Id;
use crate::measurement::foot::{Foot, rectangle};

/// Least load of a cell, over the weight, that a power is taken of: a root's slope
/// at zero would have no bound.
const LEAST: f64 = 1e-12;
/// Least sum of the cells, over the weight, and more than any sum.
const FAINT: f64 = 0.01;
const MOST: f64 = 8.0;

/// Load of one cell over the weight, from the CoP: 0 to 1.
fn load_of(faulty: usize, cop: [Id; 2], at: &mut Measured) -> Option<Id> {
    let (middle, half) = rectangle(&at.cells)?;
    let cells = at.cells.clone();
    let (one, quarter) = (at.constant(1.0), at.constant(0.25));
    let off = [0, 1].map(|axis| {
        let middle = at.constant(-middle[axis]);
        at.add(cop[axis], middle)
    });
    let mut plane = Vec::with_capacity(cells.len());
    for cell in &cells {
        let mut share = one;
        for axis in 0..2 {
            let slope = (cell[axis] - middle[axis]) / (half[axis] * half[axis]);
            let slope = at.constant(slope);
            let along = at.mul(slope, off[axis]);
            share = at.add(share, along);
        }
        plane.push(at.mul(quarter, share));
    }
    // Opposite corners gain what the other two lose; at most one of two hangs.
    let corner = |k: usize| (cells[k][0] > middle[0]) == (cells[k][1] > middle[1]);
    let mut load = *plane.get(faulty)?;
    for (k, other) in plane.iter().enumerate() {
        let missing = at.neg(*other);
        let missing = ramp(at, missing);
        load = match corner(k) == corner(faulty) {
            true => at.add(load, missing),
            false => at.sub(load, missing),
        };
    }
    Some(ramp(at, load))
}

/// `max(x, 0)` for x up to 1.
fn ramp(at: &mut Measured, x: Id) -> Id {
    let (two, half, one) = (at.constant(2.0), at.constant(0.5), at.constant(1.0));
    let doubled = at.mul(two, x);
    let centred = at.sub(doubled, one);
    let inside = at.g().clamp(centred);
    let lifted = at.add(inside, one);
    at.mul(half, lifted)
}

/// CoP of what the cells say once cell `faulty` reads `wrong(its load)`, loads
/// over the nominal weight:
///
/// ```text
/// y = (p + Σ Δ_k p_k) / (1 + Σ Δ_k)        Δ_k = f'_k − f_k of the cells that are wrong
/// ```
pub(super) fn read_with(
    target: &Target,
    at: &mut Measured,
    wrong: impl Fn(&mut Measured, Id) -> Id,
) {
    let Target::Cell(faulty) = *target else {
        return;
    };
    let mut foot = at.foot.take().unwrap_or(Foot {
        cop: at.reading,
        wrong: vec![None; at.cells.len()],
    });
    let before = match foot.wrong.get(faulty) {
        Some(Some(already)) => Some(*already),
        _ => load_of(faulty, foot.cop, at).map(|load| (load, load)),
    };
    if let Some((load, felt)) = before {
        let felt = at.mul(at.weight, felt);
        let said = wrong(at, felt);
        let said = at.div(said, at.weight);
        foot.wrong[faulty] = Some((load, said));
        let changes = foot
            .wrong
            .iter()
            .map(|cell| cell.map(|(f, s)| at.sub(s, f)));
        let changes: Vec<Option<Id>> = changes.collect();
        let zero = at.constant(0.0);
        let change = changes
            .iter()
            .flatten()
            .fold(zero, |sum, &c| at.add(sum, c));
        let sum = whole(at, change);
        for axis in 0..2 {
            let mut moment = foot.cop[axis];
            for (k, change) in changes.iter().enumerate() {
                if let Some(change) = *change {
                    let arm = at.constant(at.cells[k][axis]);
                    let moved = at.mul(arm, change);
                    moment = at.add(moment, moved);
                }
            }
            at.reading[axis] = at.div(moment, sum);
        }
    }
    at.foot = Some(foot);
}

/// `1 + change`, where cells say next to nothing no less than [`FAINT`]: a
/// quotient that cannot run away.
fn whole(at: &mut Measured, change: Id) -> Id {
    let (most, faint) = (at.constant(MOST), at.constant(FAINT));
    let (scale, rest) = (at.constant(1.0 / MOST), at.constant(1.0 - FAINT));
    let above = at.add(change, rest);
    let above = at.mul(scale, above);
    let above = ramp(at, above);
    let above = at.mul(most, above);
    at.add(above, faint)
}

/// A load no smaller than [`LEAST`].
fn positive(at: &mut Measured, load: Id) -> Id {
    let least = at.constant(LEAST);
    at.add(load, least)
}

macro_rules! cell_effect {
    ($(#[$doc:meta])* $type:ident, $name:literal, $phrase:literal, $remedy:literal, $parameter:expr,
     $invalid:expr, $starts:expr, $bound:expr, $wrong:expr) => {
        $(#[$doc])*
        pub(super) struct $type;

        impl Effect for $type {
            kind!($name, Cells, cell_targets);

            fn parameters(&self, _: &EffectContext, _: &Target) -> &'static [Parameter] {
                const PARAMETERS: &[Parameter] = &[$parameter];
                PARAMETERS
            }

            fn phrase(&self, _: &Target, name: &str) -> String {
                format!($phrase, name)
            }

            fn remedy(&self, context: &EffectContext, target: &Target, values: &[f64]) -> String {
                format!($remedy, name = context.name_of(target), x = digits(values[0], 4))
            }

            fn starts(&self, _: &EffectContext, _: &Target) -> Vec<Vec<f64>> {
                let starts: &[f64] = &$starts;
                starts.iter().map(|x| vec![*x]).collect()
            }

            fn rewrite(&self, target: &Target, at: &mut Measured, unknowns: &[Id]) {
                let x = unknowns[0];
                let wrong: fn(&mut Measured, Id, Id) -> Id = $wrong;
                read_with(target, at, |at, load| wrong(at, load, x));
            }

            fn invalid_reason(&self, _: &EffectContext, _: &Target, values: &[f64]) -> Reason {
                let invalid: fn(f64) -> Reason = $invalid;
                invalid(values[0])
            }

            fn bound_violation(
                &self,
                _: &EffectContext,
                _: &Target,
                unknowns: &[f64],
            ) -> Vec<f64> {
                let bound: fn(f64) -> Vec<f64> = $bound;
                bound(unknowns[0])
            }
        }
    };
}

cell_effect!(
    /// `f' = g f`
    Gain,
    "cell_gain",
    "a gain of foot cell {}",
    "true load of {name} = reading / {x}; calibrate the cell",
    Parameter::new("gain", 0.1).fitted(Fitted::LessOne),
    |g| (g < 0.0).then_some("cells do not pull; give a gain of 0 or more"),
    [0.0],
    |x| vec![(-0.95 - x).max(0.0) / 0.02, (x - 4.0).max(0.0) / 0.2],
    |at, load, x| {
        let one = at.constant(1.0);
        let gain = at.add(one, x);
        at.mul(gain, load)
    }
);

cell_effect!(
    /// `f' = f + o`, o in N.
    Offset,
    "cell_offset",
    "a zero offset of foot cell {}",
    "true load of {name} = reading − ({x} N); set the zero of the cell",
    Parameter::new("offset_n", 0.03).fitted(Fitted::OverWeight),
    |_| None,
    [0.0],
    |x| super::beyond(x, 0.6, 0.05),
    |at, load, x| at.add(load, x)
);

cell_effect!(
    /// `f' = f^γ`, loads over the robot's weight.
    Exponent,
    "cell_exponent",
    "a bent characteristic of foot cell {}",
    "true load of {name} = reading to the power of 1/{x}, both over the robot's weight; \
     calibrate the cell",
    Parameter::new("exponent", 0.1).fitted(Fitted::LessOne),
    |e| (e <= 0.0).then_some("such a cell feels no load; give an exponent above 0"),
    [0.0],
    |x| vec![(-0.8 - x).max(0.0) / 0.05, (x - 3.0).max(0.0) / 0.2],
    |at, load, x| {
        let load = positive(at, load);
        let one = at.constant(1.0);
        let exponent = at.add(one, x);
        at.g().pow(load, exponent)
    }
);

cell_effect!(
    /// `f' = s tanh(f / s)`, s in N: nearly true far below s, never above.
    Saturation,
    "cell_saturation",
    "a saturated foot cell {}",
    "{name} reads no more than {x} N and too little near it; load it less or replace it",
    Parameter::new("level_n", 0.05).fitted(Fitted::OverWeight),
    |s| (s <= 0.0).then_some("such a cell feels no load; give a level_n above 0"),
    [0.15, 0.22, 0.3, 0.38, 0.46, 0.54],
    |x| vec![(0.02 - x).max(0.0) / 0.01, (x - 1.0).max(0.0) / 0.01],
    |at, load, x| {
        // tanh u = (1 − w) / (1 + w), w = e^−2u: nothing grows with u.
        let u = at.div(load, x);
        let square = core::f64::consts::E * core::f64::consts::E;
        let (base, one) = (at.constant(1.0 / square), at.constant(1.0));
        let w = at.g().pow(base, u);
        let (less, more) = (at.sub(one, w), at.add(one, w));
        let filled = at.div(less, more);
        at.mul(x, filled)
    }
);

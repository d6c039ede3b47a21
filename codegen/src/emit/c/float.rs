//! Function bodies in floating point: the listing as C expressions.

use super::helpers::{Calls, Helper};
use super::{Scalar, pair, spelled};
use crate::emit::header::printable;
use crate::emit::listing::{Line, Listing, Results, Strength};
use sesc_model::expr::{Expr, Id};
use sesc_model::program::Program;

/// Lines of the body that computes `program` into array `output`.
pub(super) fn body(program: &Program, scalar: Scalar, calls: &Calls, output: &str) -> Vec<String> {
    let listing = Listing::new(program, Results::AtTheEnd);
    let spelling = Spelling {
        listing: &listing,
        scalar,
        calls,
    };
    let real = scalar.c_type();
    let mut lines = Vec::new();
    for array in &program.inputs {
        if !listing.reads(array.argument) {
            lines.push(format!("(void){};", spelled(array.argument)));
        }
    }
    for line in &listing.lines {
        match *line {
            Line::Title(title) => lines.push(format!("/* {} */", printable(title))),
            Line::SinCos { angle, sin, cos } => {
                let pair = pair(&listing, sin, cos);
                lines.push(format!("{real} {};", pair[0]));
                lines.push(format!("{real} {};", pair[1]));
                let (angle, _) = spelling.operand(angle);
                let arguments = format!("{angle}, &{}, &{}", pair[0], pair[1]);
                lines.push(calls.call(Helper::Sincos, &arguments) + ";");
            }
            Line::Let(id) => {
                let (value, _) = spelling.expression(id);
                let name = listing.name(id).expect("a statement binds a name");
                lines.push(format!("const {real} {name} = {value};"));
            }
            Line::Result(k) => {
                let (value, _) = spelling.operand(program.outputs[k]);
                lines.push(format!("{output}[{k}] = {value};"));
            }
        }
    }
    lines
}

/// A literal that reads back to the same bits.
pub(super) fn literal(x: f64, scalar: Scalar) -> String {
    match scalar {
        Scalar::F32 => format!("{:?}f", x as f32),
        _ => format!("{x:?}"),
    }
}

struct Spelling<'l, 'p> {
    listing: &'l Listing<'p>,
    scalar: Scalar,
    calls: &'l Calls<'l>,
}

impl Spelling<'_, '_> {
    /// An operand: its name, or its expression written out.
    fn operand(&self, id: Id) -> (String, Strength) {
        match self.listing.name(id) {
            Some(name) => (name.to_string(), Strength::Atom),
            None => self.expression(id),
        }
    }

    fn expression(&self, id: Id) -> (String, Strength) {
        let at = |id: Id, least: Strength| {
            let (value, strength) = self.operand(id);
            match strength < least {
                true => format!("({value})"),
                false => value,
            }
        };
        let program = self.listing.program;
        // Products inside sums carry parentheses: MISRA C 12.1.
        match program.expr(id) {
            Expr::Const(x) => (literal(x, self.scalar), Strength::Atom),
            Expr::Input { argument, index } => {
                let array = spelled(argument);
                (format!("{array}[{index}]"), Strength::Atom)
            }
            // A sum on the right keeps its parentheses: rounding depends on the order.
            Expr::Add(a, b) => {
                let (a, b) = (self.addend(a), at(b, Strength::Sign));
                (format!("{a} + {b}"), Strength::Sum)
            }
            Expr::Sub(a, b) => {
                let (a, b) = (self.addend(a), at(b, Strength::Sign));
                (format!("{a} - {b}"), Strength::Sum)
            }
            Expr::Mul(a, b) => {
                let (a, b) = (at(a, Strength::Product), at(b, Strength::Sign));
                (format!("{a} * {b}"), Strength::Product)
            }
            Expr::Div(a, b) => {
                let (a, b) = (at(a, Strength::Product), at(b, Strength::Sign));
                (format!("{a} / {b}"), Strength::Product)
            }
            Expr::Neg(a) => (format!("-{}", at(a, Strength::Atom)), Strength::Sign),
            Expr::Clamp(a) => {
                let call = self.calls.call(Helper::Clamp, &at(a, Strength::Sum));
                (call, Strength::Atom)
            }
            Expr::Pow(a, b) => {
                let (a, b) = (at(a, Strength::Sum), at(b, Strength::Sum));
                let call = self.calls.call(Helper::Power, &format!("{a}, {b}"));
                (call, Strength::Atom)
            }
            Expr::Sin(_) | Expr::Cos(_) => {
                unreachable!("sines and cosines have statements of their own")
            }
        }
    }

    /// The left operand of a sum: sums run on, products get parentheses.
    fn addend(&self, id: Id) -> String {
        match self.operand(id) {
            (value, Strength::Product) => format!("({value})"),
            (value, _) => value,
        }
    }
}

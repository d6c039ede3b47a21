//! Function bodies in 32-bit fixed point.
//!
//! ```text
//! a b + c d  →  narrow((int64_t)a * b + (int64_t)c * d, bits)
//! ```
//!
//! Products of a sum are added in 64 bits and rounded once; sums without
//! products stay in 32 bits. Binary points come from [`Formats`].

use super::helpers::{Calls, Helper};
use super::{pair, spelled, unread};
use crate::emit::header::printable;
use crate::emit::listing::{Line, Listing, Results, Strength};
use sesc_model::bounds::Formats;
use sesc_model::expr::{Expr, Id};
use sesc_model::program::Program;

/// Lines of the body that computes `program` into array `output`.
pub(super) fn body(
    program: &Program,
    formats: &Formats,
    calls: &Calls,
    output: &str,
) -> Vec<String> {
    let listing = Listing::new(program, Results::AtTheEnd);
    let spelling = Spelling {
        listing: &listing,
        formats,
        calls,
    };
    let mut lines = unread(&listing);
    for line in &listing.lines {
        match *line {
            Line::Title(title) => lines.push(format!("/* {} */", printable(title))),
            Line::SinCos { angle, sin, cos } => {
                let pair = pair(&listing, sin, cos);
                lines.push(format!("int32_t {};", pair[0]));
                lines.push(format!("int32_t {};", pair[1]));
                let bits = formats.of(angle);
                let angle = spelling.operand(angle);
                let arguments = format!("{angle}, {bits}u, &{}, &{}", pair[0], pair[1]);
                lines.push(calls.call(Helper::Sincos, &arguments) + ";");
            }
            Line::Let(id) => {
                let name = listing.name(id).expect("a statement binds a name");
                lines.push(format!("const int32_t {name} = {};", spelling.value(id).0));
            }
            Line::Result(k) => {
                let (value, _) = spelling.in_format(program.outputs[k], formats.output);
                lines.push(format!("{output}[{k}] = {value};"));
            }
        }
    }
    lines
}

/// `x` as an integer with `bits` fraction bits.
pub(super) fn literal(x: f64, bits: i32) -> String {
    whole(x, bits).to_string()
}

fn whole(x: f64, bits: i32) -> i64 {
    // Formats hold every constant: the cast does not saturate.
    libm::rint(libm::ldexp(x, bits)) as i64
}

/// `x` with `bits` fraction bits as 1 or -1 times a power of two, if it is.
fn power_of_two(x: f64, bits: i32) -> Option<(i64, i32)> {
    let whole = whole(x, bits);
    let exponent = whole.unsigned_abs().trailing_zeros();
    (whole.unsigned_abs().is_power_of_two()).then_some((whole.signum(), exponent as i32))
}

fn number(x: f64, bits: i32) -> (String, Strength) {
    let is_negative = x < 0.0;
    let strength = [Strength::Atom, Strength::Sign][usize::from(is_negative)];
    (literal(x, bits), strength)
}

/// Powers of two from this one on are written as such: 1 with 30 bits below its point is no
/// number that a reader knows by its digits.
const SHIFTED: i32 = 10;

struct Spelling<'l, 'p> {
    listing: &'l Listing<'p>,
    formats: &'l Formats,
    calls: &'l Calls<'l>,
}

/// One addend of a sum in 64 bits.
struct Term {
    negative: bool,
    of: Addend,
}

#[derive(Clone, Copy)]
enum Addend {
    Product(Id, Id),
    Constant(f64),
    Value(Id),
}

impl Spelling<'_, '_> {
    fn expr(&self, id: Id) -> Expr {
        self.listing.program.expr(id)
    }

    /// An operand in its own format, safe beside any operator.
    fn operand(&self, id: Id) -> String {
        if let Some(name) = self.listing.name(id) {
            return name.to_string();
        }
        match self.value(id) {
            (value, Strength::Atom) => value,
            (value, _) => format!("({value})"),
        }
    }

    /// The expression of a node, in its own format.
    fn value(&self, id: Id) -> (String, Strength) {
        match self.expr(id) {
            Expr::Const(x) => number(x, self.formats.of(id)),
            Expr::Input { argument, index } => {
                let array = spelled(argument);
                (format!("{array}[{index}]"), Strength::Atom)
            }
            Expr::Neg(a) => (format!("-{}", self.operand(a)), Strength::Sign),
            Expr::Add(a, b) => self.sum(id, [a, b], Helper::Add),
            Expr::Sub(a, b) => self.sum(id, [a, b], Helper::Subtract),
            Expr::Max(a, b) => self.sum(id, [a, b], Helper::Larger),
            Expr::Mul(..) => {
                let value = self.wide(id).unwrap_or_else(|| self.product(id));
                (value, Strength::Atom)
            }
            Expr::Clamp(a) => {
                let bits = self.formats.of(a);
                let [(one, _), (unit, _)] = [bits, 30 - bits].map(|bits| self.addend(1.0, bits));
                let arguments = format!("{}, {one}, {unit}", self.operand(a));
                (self.calls.call(Helper::Clamp, &arguments), Strength::Atom)
            }
            Expr::Div(..) | Expr::Pow(..) => {
                unreachable!("no format can be chosen for these")
            }
            Expr::Sin(_) | Expr::Cos(_) => {
                unreachable!("sines and cosines have statements of their own")
            }
        }
    }

    /// A sum: in 64 bits where it holds products and has room, else in 32, where it wraps for
    /// inputs out of their ranges.
    fn sum(&self, id: Id, addends: [Id; 2], helper: Helper) -> (String, Strength) {
        let text = self.wide(id).unwrap_or_else(|| {
            let bits = self.formats.of(id);
            let [(a, _), (b, _)] = addends.map(|x| self.in_format(x, bits));
            self.calls.call(helper, &format!("{a}, {b}"))
        });
        (text, Strength::Atom)
    }

    /// An operand rounded to `bits` fraction bits.
    fn in_format(&self, id: Id, bits: i32) -> (String, Strength) {
        if let Expr::Const(x) = self.expr(id) {
            return self.addend(x, bits);
        }
        let value = match self.formats.of(id) - bits {
            0 => self.operand(id),
            more => self.narrow(&self.widened(id, self.formats.of(id)), more),
        };
        (value, Strength::Atom)
    }

    /// A value with `bits` fraction bits in 64 bits: of a sum without a name each addend is
    /// cast, for a cast of the whole would come after it was made in 32.
    fn widened(&self, id: Id, bits: i32) -> String {
        let unnamed = self.listing.name(id).is_none();
        match self.expr(id) {
            Expr::Add(a, b) | Expr::Sub(a, b) if unnamed && self.wide(id).is_none() => {
                let sign = match self.expr(id) {
                    Expr::Sub(..) => "-",
                    _ => "+",
                };
                let [a, b] = [a, b].map(|x| self.widened(x, bits));
                let b = if b.contains(' ') { format!("({b})") } else { b };
                format!("{a} {sign} {b}")
            }
            _ => match self.in_format(id, bits) {
                (value, Strength::Atom) => format!("(int64_t){value}"),
                (value, _) => format!("(int64_t)({value})"),
            },
        }
    }

    /// A sum in 64 bits as 32, with `bits` fewer bits below the point.
    fn narrow(&self, wide: &str, bits: i32) -> String {
        match bits {
            0 => format!("(int32_t)({wide})"),
            _ => self.calls.call(Helper::Narrow, &format!("{wide}, {bits}u")),
        }
    }

    /// A product rounded by itself.
    fn product(&self, id: Id) -> String {
        let Expr::Mul(a, b) = self.expr(id) else {
            unreachable!("asked of products")
        };
        let bits = self.formats.of(a) + self.formats.of(b) - self.formats.of(id);
        let wide = format!("(int64_t){} * {}", self.operand(a), self.operand(b));
        self.narrow(&wide, bits)
    }

    /// A sum of products in 64 bits, rounded once; `None` where it holds no
    /// product or has no room.
    fn wide(&self, id: Id) -> Option<String> {
        let mut terms = Vec::new();
        self.collect(id, false, true, &mut terms);
        let bits = |term: &Term| match term.of {
            Addend::Product(a, b) => self.formats.of(a) + self.formats.of(b),
            Addend::Constant(_) => 0,
            Addend::Value(id) => self.formats.of(id),
        };
        let is_product = |term: &&Term| matches!(term.of, Addend::Product(..));
        terms.iter().find(is_product)?;
        let common = terms.iter().map(bits).max()?;
        let size: f64 = terms.iter().map(|term| self.size(term.of)).sum();
        if libm::ldexp(size, common) >= libm::ldexp(1.0, 62) {
            return None;
        }
        let mut text = String::new();
        for (k, term) in terms.iter().enumerate() {
            let shifted = |text: String, strength| match common - bits(term) {
                0 => (text, strength),
                more => self.shift_up(&text, more),
            };
            let (value, strength) = match term.of {
                Addend::Product(a, b) => {
                    let product = format!("(int64_t){} * {}", self.operand(a), self.operand(b));
                    shifted(product, Strength::Product)
                }
                Addend::Constant(x) => match power_of_two(x, common) {
                    Some((one, exponent @ 1..)) => self.shift_up(&one.to_string(), exponent),
                    _ => (format!("INT64_C({})", literal(x, common)), Strength::Atom),
                },
                Addend::Value(id) if common == bits(term) => {
                    (format!("(int64_t){}", self.operand(id)), Strength::Sign)
                }
                Addend::Value(id) => shifted(self.operand(id), Strength::Sign),
            };
            let negative = term.negative;
            text += match (k, negative) {
                (0, false) => "",
                (0, true) => "-",
                (_, false) => " + ",
                (_, true) => " - ",
            };
            text += &match (terms.len(), strength) {
                (1, _) if !negative => value,
                (_, Strength::Atom) => value,
                _ => format!("({value})"),
            };
        }
        Some(self.narrow(&text, common - self.formats.of(id)))
    }

    /// `x` with `bits` fraction bits in 32 bits, where it is no factor.
    fn addend(&self, x: f64, bits: i32) -> (String, Strength) {
        match power_of_two(x, bits) {
            Some((one, exponent @ SHIFTED..)) => {
                let (wide, _) = self.shift_up(&one.to_string(), exponent);
                (format!("(int32_t){wide}"), Strength::Atom)
            }
            _ => number(x, bits),
        }
    }

    /// A value in 64 bits with `bits` more below its point.
    fn shift_up(&self, value: &str, bits: i32) -> (String, Strength) {
        let arguments = format!("{value}, {bits}u");
        (self.calls.call(Helper::ShiftUp, &arguments), Strength::Atom)
    }

    /// Addends of node `id`: through sums and signs that have no statement.
    fn collect(&self, id: Id, negative: bool, top: bool, terms: &mut Vec<Term>) {
        let open = top || self.listing.name(id).is_none();
        match self.expr(id) {
            Expr::Add(a, b) if open => {
                self.collect(a, negative, false, terms);
                self.collect(b, negative, false, terms);
            }
            Expr::Sub(a, b) if open => {
                self.collect(a, negative, false, terms);
                self.collect(b, !negative, false, terms);
            }
            Expr::Neg(a) if open => self.collect(a, !negative, false, terms),
            expr => {
                let of = match expr {
                    Expr::Mul(a, b) if open => Addend::Product(a, b),
                    Expr::Const(x) => Addend::Constant(x),
                    _ => Addend::Value(id),
                };
                terms.push(Term { negative, of });
            }
        }
    }

    /// Largest magnitude of an addend.
    fn size(&self, addend: Addend) -> f64 {
        match addend {
            Addend::Product(a, b) => self.formats.size(a) * self.formats.size(b),
            Addend::Constant(x) => libm::fabs(x),
            Addend::Value(id) => self.formats.size(id),
        }
    }
}

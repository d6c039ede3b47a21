//! Function bodies in floating point: the listing as C expressions.

use super::helpers::{Calls, Helper};
use super::sines::{self, SinCos, Statement};
use super::{Scalar, pair, spelled, unread};
use crate::emit::header::printable;
use crate::emit::listing::{Line, Listing, Results, Strength};
use crate::emit::shared::Shared;
use sesc_model::expr::{Argument, Expr, Id};
use sesc_model::program::{Program, Shape, operands};

/// A body that two functions call.
pub(super) struct Core {
    pub(super) shared: Shared,
    /// Of each angle: itself, its sine and its cosine, unless it is a joint's position.
    pub(super) turned: Vec<Option<Turned>>,
}

/// How the sine and cosine of an angle come about.
pub(super) struct Turned {
    pub(super) angle: String,
    pub(super) sine_and_cosine: [String; 2],
}

/// Lines of the body that computes `program` into array `output`; `core` where functions of
/// positions and of sines and cosines share it.
pub(super) fn body(
    program: &Program,
    core: Option<&Core>,
    scalar: Scalar,
    calls: &Calls,
    output: &str,
) -> Vec<String> {
    let listing = &Listing::new(program, Results::AtTheEnd);
    let plain = Spelling::new(listing, scalar, calls);
    Spelling { core, ..plain }.lines(output)
}

/// A value that takes no statements.
pub(super) fn value(listing: &Listing, scalar: Scalar, calls: &Calls, id: Id) -> String {
    Spelling::new(listing, scalar, calls).operand(id).0
}

/// The same for a block of postures: entry k of an array stands n postures after entry k - 1.
pub(super) fn lanes(program: &Program, scalar: Scalar, calls: &Calls, output: &str) -> Vec<String> {
    // A wide matrix is not held until its last entry.
    let results = match program.shape {
        Shape::Matrix { .. } => Results::AsTheyCome,
        Shape::Vector(_) => Results::AtTheEnd,
    };
    let listing = &Listing::new(program, results);
    let shared = Some(shared(program));
    let plain = Spelling::new(listing, scalar, calls);
    Spelling { shared, ..plain }.lines(output)
}

/// Which nodes are the same number in all postures.
fn shared(program: &Program) -> Vec<bool> {
    let mut shared: Vec<bool> = Vec::with_capacity(program.nodes.len());
    for (_, node) in program.iter() {
        shared.push(match node.expr {
            Expr::Input { argument, .. } => argument == Argument::Parameters,
            other => operands(other).all(|id| shared[id.index()]),
        });
    }
    shared
}

struct Spelling<'l, 'p> {
    listing: &'l Listing<'p>,
    scalar: Scalar,
    calls: &'l Calls<'l>,
    /// For a block of postures, the nodes that are one number for all of them; the others
    /// have a lane for each.
    shared: Option<Vec<bool>>,
    /// The body that this is, where two functions share it.
    core: Option<&'l Core>,
}

impl<'l, 'p> Spelling<'l, 'p> {
    fn new(listing: &'l Listing<'p>, scalar: Scalar, calls: &'l Calls<'l>) -> Self {
        Spelling {
            listing,
            scalar,
            calls,
            shared: None,
            core: None,
        }
    }

    /// Whether a node has a lane for each posture.
    fn is_lanes(&self, id: Id) -> bool {
        let mut shared = self.shared.iter();
        shared.any(|shared| !shared[id.index()])
    }

    fn type_of(&self, id: Id) -> String {
        match self.is_lanes(id) {
            true => self.calls.named("lanes"),
            false => self.scalar.c_type().to_string(),
        }
    }

    /// An operand with a lane for each posture.
    fn spread(&self, id: Id) -> String {
        let (value, _) = self.operand(id);
        match self.is_lanes(id) {
            true => value,
            false => self.calls.call(Helper::Splat, &value),
        }
    }

    /// The statements of the body, whose results go to array `output`.
    fn lines(&self, output: &str) -> Vec<String> {
        let Spelling { listing, calls, .. } = *self;
        let program = listing.program;
        let mut lines = unread(listing);
        let statements = match self.shared {
            Some(_) => sines::in_pairs(listing, |id| self.is_lanes(id)),
            None => listing.lines.iter().map(Statement::Line).collect(),
        };
        for statement in statements {
            let line = match statement {
                Statement::Line(line) => line,
                Statement::Reduced(both) => {
                    lines.extend(self.reduced(both));
                    continue;
                }
                Statement::Both(both) => {
                    lines.extend(self.both(both));
                    continue;
                }
            };
            match *line {
                Line::Title(title) => lines.push(format!("/* {} */", printable(title))),
                Line::SinCos { angle, sin, cos } => {
                    let pair = pair(listing, sin, cos);
                    let of = self.type_of(angle);
                    lines.push(format!("{of} {};", pair[0]));
                    lines.push(format!("{of} {};", pair[1]));
                    if let Some(core) = self.core {
                        lines.extend(self.turned(core, angle, pair));
                        continue;
                    }
                    let helper = match self.is_lanes(angle) {
                        true => Helper::SincosLanes,
                        false => Helper::Sincos,
                    };
                    let (angle, _) = self.operand(angle);
                    let arguments = format!("{angle}, &{}, &{}", pair[0], pair[1]);
                    lines.push(calls.call(helper, &arguments) + ";");
                }
                Line::Let(id) => {
                    let (value, _) = self.expression(id);
                    let name = listing.name(id).expect("a statement binds a name");
                    lines.push(format!("const {} {name} = {value};", self.type_of(id)));
                }
                Line::Result(k) if self.shared.is_some() => {
                    let value = self.spread(program.outputs[k]);
                    let arguments = format!("{output}, {k}u, n, {value}");
                    lines.push(calls.call(Helper::Store, &arguments) + ";");
                }
                Line::Result(k) => {
                    let (value, _) = self.operand(program.outputs[k]);
                    lines.push(format!("{output}[{k}] = {value};"));
                }
            }
        }
        lines
    }

    /// The sine and cosine of an angle of a body that two functions share.
    fn turned(&self, core: &Core, angle: Id, [sine, cosine]: [String; 2]) -> Vec<String> {
        let place = core.shared.place(angle);
        let Some(Turned {
            angle,
            sine_and_cosine: [s, c],
        }) = &core.turned[place]
        else {
            let joint = core.shared.angles[place].joint;
            let arguments = [Argument::Positions, Argument::Sines, Argument::Cosines];
            let [q, s, c] = arguments.map(|array| format!("{}[{joint}]", spelled(array)));
            let arguments = format!("of_sines, {q}, {s}, {c}, &{sine}, &{cosine}");
            return vec![self.calls.call(Helper::Turn, &arguments) + ";"];
        };
        let of_angle = format!("{angle}, &{sine}, &{cosine}");
        vec![
            "if (of_sines != 0) {".to_string(),
            format!("    {sine} = {s};"),
            format!("    {cosine} = {c};"),
            "} else {".to_string(),
            format!("    {};", self.calls.call(Helper::Sincos, &of_angle)),
            "}".to_string(),
        ]
    }

    /// Two angles of a block of postures less quarter turns.
    fn reduced(&self, both: [SinCos; 2]) -> Vec<String> {
        let reduced = both.map(|of| self.name_of_reduced(of));
        let angles = both.map(|of| self.operand(of.angle).0);
        self.of_both(Helper::ReduceBoth, "reduced", &angles, &reduced)
    }

    /// Sines and cosines of two angles that are reduced.
    fn both(&self, both: [SinCos; 2]) -> Vec<String> {
        let results = both.map(|of| pair(self.listing, of.sin, of.cos));
        let reduced = both.map(|of| format!("&{}", self.name_of_reduced(of)));
        self.of_both(
            Helper::SincosBoth,
            "lanes",
            &reduced,
            results.as_flattened(),
        )
    }

    /// Results of a type, and the call that writes them.
    fn of_both(&self, helper: Helper, of: &str, from: &[String], to: &[String]) -> Vec<String> {
        let of = self.calls.named(of);
        let declared = to.iter().map(|name| format!("{of} {name};"));
        let places = to.iter().map(|name| format!("&{name}"));
        let arguments: Vec<String> = from.iter().cloned().chain(places).collect();
        let call = self.calls.call(helper, &arguments.join(", "));
        declared.chain([call + ";"]).collect()
    }

    /// `reduced_knee` beside `s_knee` and `c_knee`.
    fn name_of_reduced(&self, of: SinCos) -> String {
        let [sine, _] = pair(self.listing, of.sin, of.cos);
        let sine = sine.strip_prefix("no_").unwrap_or(&sine);
        format!("reduced_{}", sine.strip_prefix("s_").unwrap_or(sine))
    }

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
        let sum = |sign, a, b| format!("{} {sign} {}", self.addend(a), at(b, Strength::Sign));
        let product = |sign, a, b| {
            format!(
                "{} {sign} {}",
                at(a, Strength::Product),
                at(b, Strength::Sign)
            )
        };
        let call = |one, of_lanes, operands: &[Id]| {
            let operands = operands.iter().copied();
            let (helper, operands): (Helper, Vec<String>) = match self.is_lanes(id) {
                true => (of_lanes, operands.map(|id| self.spread(id)).collect()),
                false => (one, operands.map(|id| at(id, Strength::Sum)).collect()),
            };
            (
                self.calls.call(helper, &operands.join(", ")),
                Strength::Atom,
            )
        };
        let program = self.listing.program;
        // Products inside sums carry parentheses: MISRA C 12.1.
        match program.expr(id) {
            Expr::Const(x) => (literal(x, self.scalar), Strength::Atom),
            Expr::Input { argument, index }
                if self.shared.is_some() && argument != Argument::Parameters =>
            {
                let arguments = format!("{}, {index}u, n", spelled(argument));
                (self.calls.call(Helper::Load, &arguments), Strength::Atom)
            }
            Expr::Input { argument, index } => {
                let array = spelled(argument);
                (format!("{array}[{index}]"), Strength::Atom)
            }
            // A sum on the right keeps its parentheses: rounding depends on the order.
            Expr::Add(a, b) => (sum('+', a, b), Strength::Sum),
            Expr::Sub(a, b) => (sum('-', a, b), Strength::Sum),
            Expr::Mul(a, b) => (product('*', a, b), Strength::Product),
            Expr::Div(a, b) => (product('/', a, b), Strength::Product),
            Expr::Neg(a) => (format!("-{}", at(a, Strength::Atom)), Strength::Sign),
            Expr::Clamp(a) => call(Helper::Clamp, Helper::ClampLanes, &[a]),
            Expr::Pow(a, b) => call(Helper::Power, Helper::PowerLanes, &[a, b]),
            Expr::Max(a, b) => call(Helper::Larger, Helper::LargerLanes, &[a, b]),
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

/// A literal that reads back to the same bits.
pub(super) fn literal(x: f64, scalar: Scalar) -> String {
    match scalar {
        Scalar::F32 => format!("{:?}f", x as f32),
        _ => format!("{x:?}"),
    }
}

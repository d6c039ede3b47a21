//! Formulas of effects, as text and in the graph.
//!
//! ```text
//! k * max(q - start, 0.0)        expressions of Rust: + - * / ( ) and the functions below
//! ```
//!
//! Variables are those of [`Variable`]; every other name is a parameter. Texts are printed in one
//! way: spaces around operators, no parentheses that are not needed, numbers that read back to the
//! same bits.

use std::collections::HashMap;
use std::fmt;

use syn::spanned::Spanned as _;
use syn::{BinOp, Expr as Syntax, Lit, UnOp};

use crate::expr::{Graph, Id};
use crate::urdf::suggestion;

/// A longer text is no formula.
const LONGEST: usize = 1000;
/// Brackets and signs inside each other, at most: each takes a part of the stack.
const DEEPEST: usize = 32;
/// Largest integer power that is written as products.
const LARGEST_POWER: f64 = 16.0;
/// Roots and powers are taken of no less: the slope of a root at zero has no bound.
const LEAST: f64 = 1e-12;

/// What a formula may depend on.
#[derive(Debug, Clone, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Variable {
    /// Position of a joint, rad or m; of the site's own where there is no name: `q`, `q["l_knee"]`.
    Position(Option<String>),
    /// Gravity's moment about a joint, N m: `tau`, `tau["l_knee"]`.
    Moment(Option<String>),
    /// The reading along an axis, m: `x`, `y`.
    Reading(usize),
    /// Time from the start, s: `t`.
    Time,
    /// Side from which a joint came to where it stands, −1 to 1: `approach`.
    Approach(Option<String>),
    /// A further column of the log: `column["temp"]`.
    Column(String),
}

impl fmt::Display for Variable {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        let (word, name) = match self {
            Variable::Position(name) => ("q", name.as_ref()),
            Variable::Moment(name) => ("tau", name.as_ref()),
            Variable::Approach(name) => ("approach", name.as_ref()),
            Variable::Column(name) => ("column", Some(name)),
            Variable::Reading(axis) => (["x", "y"][*axis], None),
            Variable::Time => ("t", None),
        };
        match name {
            Some(name) => write!(f, "{word}[\"{name}\"]"),
            None => f.write_str(word),
        }
    }
}

impl Variable {
    /// The variable of a word alone.
    fn plain(word: &str) -> Option<Variable> {
        Some(match word {
            "q" => Variable::Position(None),
            "tau" => Variable::Moment(None),
            "x" => Variable::Reading(0),
            "y" => Variable::Reading(1),
            "t" => Variable::Time,
            "approach" => Variable::Approach(None),
            _ => return None,
        })
    }

    /// The variable of a word with a name in brackets.
    fn named(word: &str, name: String) -> Option<Variable> {
        Some(match word {
            "q" => Variable::Position(Some(name)),
            "tau" => Variable::Moment(Some(name)),
            "approach" => Variable::Approach(Some(name)),
            "column" => Variable::Column(name),
            _ => return None,
        })
    }
}

/// A function that formulas may call.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Function {
    Sin,
    Cos,
    Abs,
    Sign,
    Sqrt,
    Exp,
    Pow,
    Max,
    Min,
}

/// Functions by name, with how many arguments they take.
const FUNCTIONS: [(&str, Function, usize); 9] = [
    ("sin", Function::Sin, 1),
    ("cos", Function::Cos, 1),
    ("abs", Function::Abs, 1),
    ("sign", Function::Sign, 1),
    ("sqrt", Function::Sqrt, 1),
    ("exp", Function::Exp, 1),
    ("pow", Function::Pow, 2),
    ("max", Function::Max, 2),
    ("min", Function::Min, 2),
];

/// Names of the functions that formulas may call.
pub fn functions() -> [&'static str; 9] {
    FUNCTIONS.map(|(name, ..)| name)
}

/// An operator between two formulas.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Operator {
    Add,
    Sub,
    Mul,
    Div,
}

/// A formula.
#[derive(Debug, Clone, PartialEq)]
enum Node {
    Number(f64),
    Parameter(String),
    Variable(Variable),
    Neg(Box<Node>),
    Binary(Operator, Box<[Node; 2]>),
    Call(Function, Vec<Node>),
}

/// A formula as it was read, printed in one way by `Display`.
#[derive(Debug, Clone, PartialEq)]
pub struct Formula(Node);

/// Where a text is no formula, and why.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Fault {
    /// Character of the text, from 1.
    pub column: usize,
    /// What is wrong there and what to write instead.
    pub reason: String,
}

impl fmt::Display for Fault {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        write!(f, "column {}: {}", self.column, self.reason)
    }
}

impl Formula {
    /// Read a formula.
    ///
    /// # Errors
    /// Where the text is none, with the column.
    ///
    /// ```
    /// use sesc_model::formula::Formula;
    ///
    /// let formula = Formula::parse("k*max((q - start), 0)").unwrap();
    /// assert_eq!(formula.to_string(), "k * max(q - start, 0.0)");
    /// let fault = Formula::parse("k * q ^ 2").unwrap_err();
    /// assert_eq!(fault.column, 7);
    /// ```
    pub fn parse(text: &str) -> Result<Formula, Fault> {
        check_characters(text)?;
        let syntax: Syntax = syn::parse_str(text).map_err(|error| Fault {
            column: match error.to_string().starts_with("unexpected end") {
                true => text.chars().count() + 1,
                false => error.span().start().column + 1,
            },
            reason: format!("{error}; write a formula such as k * sin(2.0 * q)"),
        })?;
        node(&syntax).map(Formula)
    }

    /// The variables, each once, in the order of the text.
    pub fn variables(&self) -> Vec<Variable> {
        let mut found: Vec<Variable> = Vec::new();
        self.0.walk(&mut |node| {
            if let Node::Variable(variable) = node
                && !found.contains(variable)
            {
                found.push(variable.clone());
            }
        });
        found
    }

    /// Names of the parameters, each once, in the order of the text.
    pub fn parameters(&self) -> Vec<String> {
        let mut found: Vec<String> = Vec::new();
        self.0.walk(&mut |node| {
            if let Node::Parameter(name) = node
                && !found.contains(name)
            {
                found.push(name.clone());
            }
        });
        found
    }

    /// Whether it or a derivative of it jumps, so that rounding decides on which side it is.
    pub fn has_corners(&self) -> bool {
        let mut corners = false;
        self.0.walk(&mut |node| {
            corners |= matches!(
                node,
                Node::Call(
                    Function::Abs | Function::Sign | Function::Max | Function::Min,
                    _
                )
            );
        });
        corners
    }

    /// Its value at those of its variables and parameters.
    pub fn value(
        &self,
        variable: &dyn Fn(&Variable) -> f64,
        parameter: &dyn Fn(&str) -> f64,
    ) -> f64 {
        self.0.value(variable, parameter)
    }

    /// The expression, from those of its variables and parameters.
    pub(crate) fn write(
        &self,
        g: &mut Graph,
        variables: &HashMap<Variable, Id>,
        parameters: &HashMap<&str, Id>,
    ) -> Id {
        self.0.write(g, variables, parameters)
    }
}

impl Node {
    fn walk(&self, see: &mut impl FnMut(&Node)) {
        see(self);
        match self {
            Node::Number(_) | Node::Parameter(_) | Node::Variable(_) => {}
            Node::Neg(a) => a.walk(see),
            Node::Binary(_, both) => both.iter().for_each(|part| part.walk(see)),
            Node::Call(_, arguments) => arguments.iter().for_each(|part| part.walk(see)),
        }
    }

    fn write(
        &self,
        g: &mut Graph,
        variables: &HashMap<Variable, Id>,
        parameters: &HashMap<&str, Id>,
    ) -> Id {
        let of = |g: &mut Graph, node: &Node| node.write(g, variables, parameters);
        match self {
            Node::Number(x) => g.constant(*x),
            Node::Parameter(name) => parameters[name.as_str()],
            Node::Variable(variable) => variables[variable],
            Node::Neg(a) => {
                let a = of(g, a);
                g.neg(a)
            }
            Node::Binary(operator, both) => {
                let (a, b) = (of(g, &both[0]), of(g, &both[1]));
                match operator {
                    Operator::Add => g.add(a, b),
                    Operator::Sub => g.sub(a, b),
                    Operator::Mul => g.mul(a, b),
                    Operator::Div => g.div(a, b),
                }
            }
            Node::Call(function, arguments) => {
                let ids: Vec<Id> = arguments.iter().map(|node| of(g, node)).collect();
                let a = ids[0];
                match function {
                    Function::Sin => g.sin(a),
                    Function::Cos => g.cos(a),
                    Function::Abs => g.abs(a),
                    Function::Sign => g.sign(a),
                    Function::Sqrt => {
                        let half = g.constant(0.5);
                        power(g, a, half)
                    }
                    Function::Exp => {
                        let e = g.constant(core::f64::consts::E);
                        g.pow(e, a)
                    }
                    Function::Pow => match arguments[1].integer() {
                        Some(times) => products(g, a, times),
                        None => power(g, a, ids[1]),
                    },
                    Function::Max => g.max(a, ids[1]),
                    Function::Min => {
                        let [a, b] = [a, ids[1]].map(|x| g.neg(x));
                        let larger = g.max(a, b);
                        g.neg(larger)
                    }
                }
            }
        }
    }

    fn value(&self, variable: &dyn Fn(&Variable) -> f64, parameter: &dyn Fn(&str) -> f64) -> f64 {
        let of = |node: &Node| node.value(variable, parameter);
        match self {
            Node::Number(x) => *x,
            Node::Parameter(name) => parameter(name),
            Node::Variable(own) => variable(own),
            Node::Neg(a) => -of(a),
            Node::Binary(operator, both) => {
                let [a, b] = [of(&both[0]), of(&both[1])];
                match operator {
                    Operator::Add => a + b,
                    Operator::Sub => a - b,
                    Operator::Mul => a * b,
                    Operator::Div => a / b,
                }
            }
            Node::Call(function, arguments) => {
                let a = of(&arguments[0]);
                let b = || of(&arguments[1]);
                match function {
                    Function::Sin => libm::sin(a),
                    Function::Cos => libm::cos(a),
                    Function::Abs => libm::fabs(a),
                    Function::Sign if a == 0.0 => 0.0,
                    Function::Sign => libm::copysign(1.0, a),
                    Function::Sqrt => libm::sqrt(a.max(0.0)),
                    Function::Exp => libm::exp(a),
                    Function::Pow => match arguments[1].integer() {
                        Some(_) => libm::pow(a, b()),
                        None => libm::pow(a.max(0.0), b()),
                    },
                    Function::Max => a.max(b()),
                    Function::Min => a.min(b()),
                }
            }
        }
    }

    /// The whole number that an exponent is, where products write its power.
    fn integer(&self) -> Option<i32> {
        let value = match self {
            Node::Number(x) => *x,
            Node::Neg(inner) => match **inner {
                Node::Number(x) => -x,
                _ => return None,
            },
            _ => return None,
        };
        let whole = value == libm::rint(value) && libm::fabs(value) <= LARGEST_POWER;
        whole.then_some(value as i32)
    }

    /// How strongly it binds: what stands beside a stronger operator takes parentheses.
    fn strength(&self) -> u8 {
        match self {
            Node::Binary(Operator::Add | Operator::Sub, _) => 1,
            Node::Binary(..) => 2,
            Node::Neg(_) => 3,
            _ => 4,
        }
    }
}

/// `a^times`
fn products(g: &mut Graph, a: Id, times: i32) -> Id {
    let one = g.constant(1.0);
    let product = (0..times.abs()).fold(one, |product, _| g.mul(product, a));
    match times < 0 {
        true => g.div(one, product),
        false => product,
    }
}

/// `a^b` of what is not negative.
fn power(g: &mut Graph, a: Id, b: Id) -> Id {
    let least = g.constant(LEAST);
    let base = g.max(a, least);
    g.pow(base, b)
}

impl fmt::Display for Formula {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        self.0.fmt(f)
    }
}

impl fmt::Display for Node {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        let part = |f: &mut fmt::Formatter, node: &Node, least: u8| match node.strength() < least {
            true => write!(f, "({node})"),
            false => write!(f, "{node}"),
        };
        match self {
            Node::Number(x) => write!(f, "{x:?}"),
            Node::Parameter(name) => f.write_str(name),
            Node::Variable(variable) => write!(f, "{variable}"),
            Node::Neg(a) => {
                f.write_str("-")?;
                part(f, a, 3)
            }
            Node::Binary(operator, both) => {
                let own = self.strength();
                part(f, &both[0], own)?;
                f.write_str(match operator {
                    Operator::Add => " + ",
                    Operator::Sub => " - ",
                    Operator::Mul => " * ",
                    Operator::Div => " / ",
                })?;
                // Rounding depends on the order.
                part(f, &both[1], own + 1)
            }
            Node::Call(function, arguments) => {
                let known = FUNCTIONS.iter().find(|(_, known, _)| known == function);
                f.write_str(known.map_or("", |(name, ..)| name))?;
                f.write_str("(")?;
                for (k, argument) in arguments.iter().enumerate() {
                    f.write_str(if k > 0 { ", " } else { "" })?;
                    write!(f, "{argument}")?;
                }
                f.write_str(")")
            }
        }
    }
}

/// Refuses what no formula holds before anything parses it: what is inside of many brackets would
/// take the stack.
fn check_characters(text: &str) -> Result<(), Fault> {
    let fault = |column: usize, reason: String| Err(Fault { column, reason });
    let mut open: Vec<(char, usize)> = Vec::new();
    let (mut signs, mut quote) = (0_usize, None);
    for (k, c) in text.chars().enumerate() {
        let column = k + 1;
        if column > LONGEST {
            return fault(
                column,
                format!("longer than {LONGEST} characters; shorten it"),
            );
        }
        if c == '"' {
            quote = match quote {
                None => Some(column),
                Some(_) => None,
            };
        }
        if quote.is_some() {
            match c {
                '\\' => return fault(column, "a name in brackets holds no `\\`".into()),
                c if c.is_control() => return fault(column, "a control character".into()),
                _ => continue,
            }
        }
        signs = match c {
            '-' | '*' => signs + 1,
            ' ' => signs,
            _ => 0,
        };
        match c {
            '(' => open.push((')', column)),
            '[' => open.push((']', column)),
            ')' | ']' => match open.pop() {
                Some((close, _)) if close == c => {}
                _ => return fault(column, format!("`{c}` closes nothing")),
            },
            '^' => {
                let reason = "`^` is no power; write x * x or pow(x, 2)";
                return fault(column, reason.into());
            }
            '%' | '<' | '>' | '=' | '&' | '|' | '!' => {
                let reason = format!("no operator `{c}`; a formula has + - * / and functions");
                return fault(column, reason);
            }
            ' ' | '+' | '-' | '*' | '/' | ',' | '.' | '_' | '"' => {}
            c if c.is_alphanumeric() => {}
            c => {
                return fault(
                    column,
                    format!("`{}` stands in no formula", c.escape_debug()),
                );
            }
        }
        if open.len() + signs > DEEPEST {
            return fault(
                column,
                format!("more than {DEEPEST} brackets inside each other"),
            );
        }
    }
    if let Some(column) = quote.or(open.pop().map(|(_, column)| column)) {
        return fault(column, "it is opened here and never closed".to_string());
    }
    match text.contains("//") || text.contains("/*") {
        true => fault(1, "a formula has no comments".into()),
        false => Ok(()),
    }
}

fn node(syntax: &Syntax) -> Result<Node, Fault> {
    let fault = |at: proc_macro2::Span, reason: &str| Fault {
        column: at.start().column + 1,
        reason: reason.to_string(),
    };
    Ok(match syntax {
        Syntax::Paren(inner) => node(&inner.expr)?,
        Syntax::Group(inner) => node(&inner.expr)?,
        Syntax::Lit(literal) => Node::Number(number(&literal.lit)?),
        Syntax::Unary(unary) => match unary.op {
            UnOp::Neg(_) => Node::Neg(Box::new(node(&unary.expr)?)),
            _ => return Err(fault(unary.op.span(), "of signs a formula has `-` alone")),
        },
        Syntax::Binary(binary) => {
            let operator = match binary.op {
                BinOp::Add(_) => Operator::Add,
                BinOp::Sub(_) => Operator::Sub,
                BinOp::Mul(_) => Operator::Mul,
                BinOp::Div(_) => Operator::Div,
                _ => {
                    let reason = "no such operator; a formula has + - * / and functions";
                    return Err(fault(binary.op.span(), reason));
                }
            };
            Node::Binary(
                operator,
                Box::new([node(&binary.left)?, node(&binary.right)?]),
            )
        }
        Syntax::Call(call) => {
            let name = word(&call.func)?;
            let known = FUNCTIONS.iter().find(|(known, ..)| **known == name);
            let Some((_, function, count)) = known else {
                let names = functions();
                let meant = suggestion(&name, names);
                let reason = format!("no function `{name}`; there are {}{meant}", names.join(" "));
                return Err(fault(call.func.span(), &reason));
            };
            if call.args.len() != *count {
                let reason = format!("`{name}` takes {count}, not {}", call.args.len());
                return Err(fault(call.func.span(), &reason));
            }
            Node::Call(
                *function,
                call.args.iter().map(node).collect::<Result<_, _>>()?,
            )
        }
        Syntax::Index(index) => {
            let array = word(&index.expr)?;
            let Syntax::Lit(syn::ExprLit {
                lit: Lit::Str(name),
                ..
            }) = &*index.index
            else {
                let reason = "in brackets stands a name in quotes: q[\"l_knee\"]";
                return Err(fault(index.index.span(), reason));
            };
            match Variable::named(&array, name.value()) {
                Some(variable) => Node::Variable(variable),
                None => {
                    let reason = "names in brackets are those of q, tau, approach and column";
                    return Err(fault(index.expr.span(), reason));
                }
            }
        }
        Syntax::Path(_) => {
            let name = word(syntax)?;
            match Variable::plain(&name) {
                Some(variable) => Node::Variable(variable),
                None if name == "column" || functions().contains(&name.as_str()) => {
                    let reason = format!(
                        "`{name}` needs what it is of: sin(q), column[\"temp\"]; a parameter has \
                         another name"
                    );
                    return Err(fault(syntax.span(), &reason));
                }
                None => Node::Parameter(name),
            }
        }
        _ => {
            let reason = "no part of a formula: it has numbers, names, + - * /, parentheses and \
                          functions, no `if`, casts or methods";
            return Err(fault(syntax.span(), reason));
        }
    })
}

/// A name that stands for itself.
fn word(syntax: &Syntax) -> Result<String, Fault> {
    match syntax {
        Syntax::Path(path) => path.path.get_ident().map(ToString::to_string),
        _ => None,
    }
    .ok_or_else(|| Fault {
        column: syntax.span().start().column + 1,
        reason: "a name is expected here".to_string(),
    })
}

fn number(literal: &Lit) -> Result<f64, Fault> {
    let (digits, suffix) = match literal {
        Lit::Int(whole) => (whole.base10_digits(), whole.suffix()),
        Lit::Float(float) => (float.base10_digits(), float.suffix()),
        _ => ("", "other"),
    };
    let value = digits.parse::<f64>().ok().filter(|x| x.is_finite());
    value.filter(|_| suffix.is_empty()).ok_or_else(|| Fault {
        column: literal.span().start().column + 1,
        reason: "no number; write one like 2.5 or 1e-3".to_string(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::expr::Argument;

    /// What a formula is at numbers, by its expression.
    fn value(text: &str, q: f64, k: f64) -> f64 {
        let mut g = Graph::default();
        let (q, k) = (g.constant(q), g.constant(k));
        let formula = Formula::parse(text).unwrap();
        let variables = formula.variables().into_iter().map(|v| (v, q)).collect();
        let id = formula.write(&mut g, &variables, &HashMap::from([("k", k)]));
        g.value(id).unwrap()
    }

    #[test]
    fn a_formula_is_the_number_that_its_text_says() {
        for (text, q, k, expected) in [
            ("k * sin(6.0 * q)", 0.3, 2.0, 2.0 * libm::sin(1.8)),
            ("k*max(q-0.5,0)", 0.75, 2.0, 0.5),
            ("k*max(q-0.5,0)", 0.25, 2.0, 0.0),
            ("min(q, k) - -1", 3.0, 2.0, 3.0),
            ("-q * k / 2 - (q - k)", 3.0, 2.0, -4.0),
            ("k * q * abs(q)", -3.0, 2.0, -18.0),
            ("sign(q) * sqrt(abs(q))", -4.0, 0.0, -2.0),
            ("pow(q, 3) + pow(q, -1)", 2.0, 0.0, 8.5),
            ("pow(k, 0.5) + exp(0)", 0.0, 9.0, 4.0),
            ("q[\"l-knee\"] + column[\"temp °C\"]", 2.0, 0.0, 4.0),
        ] {
            let found = value(text, q, k);
            assert!((found - expected).abs() < 1e-12, "{text}: {found}");
            let formula = Formula::parse(text).unwrap();
            let plain = formula.value(&|_| q, &|_| k);
            assert!((plain - expected).abs() < 1e-12, "{text}: {plain}");
        }
    }

    #[test]
    fn a_text_is_printed_in_one_way_and_reads_back() {
        for (text, printed) in [
            ("(k*((sin( 6*q ))))", "k * sin(6.0 * q)"),
            ("a-(b-c)", "a - (b - c)"),
            ("(a-b)-c", "a - b - c"),
            ("a*(b/c)*-(d+e)", "a * (b / c) * -(d + e)"),
            ("--q", "--q"),
            ("1e-3*tau[\"l knee\"]", "0.001 * tau[\"l knee\"]"),
            ("x*y+t", "x * y + t"),
        ] {
            let formula = Formula::parse(text).unwrap();
            assert_eq!(formula.to_string(), printed);
            assert_eq!(Formula::parse(printed).unwrap(), formula);
        }
        let formula = Formula::parse("a * q + b * tau * q + a").unwrap();
        assert_eq!(formula.parameters(), ["a", "b"]);
        let own = [Variable::Position(None), Variable::Moment(None)];
        assert_eq!(formula.variables(), own);
    }

    #[test]
    fn what_is_no_formula_is_refused_with_its_column() {
        for (text, column, said) in [
            ("k * q ^ 2", 7, "pow(x, 2)"),
            ("k % 2", 3, "no operator"),
            ("q < 1", 3, "no operator"),
            ("k * if q { 1 } else { 2 }", 10, "stands in no formula"),
            ("k * (q as f64)", 6, "casts"),
            ("k * q.sin()", 5, "methods"),
            ("k * sine(q)", 5, "did you mean"),
            ("max(q)", 1, "takes 2"),
            ("k * sin", 5, "needs what it is of"),
            ("q[0]", 3, "a name in quotes"),
            ("k[\"a\"]", 1, "names in brackets"),
            ("2f64 * q", 1, "no number"),
            ("1e999 * q", 1, "no number"),
            ("k *", 4, "formula such as"),
            ("", 1, "formula such as"),
            ("*q", 1, "`-` alone"),
            ("'a' * q", 1, "stands in no formula"),
            ("\"a\" * q", 1, "no number"),
            ("a::b * q", 2, "stands in no formula"),
            ("q // 2", 1, "comments"),
            ("k * sin(6 * q", 8, "never closed"),
            ("k * q)", 6, "closes nothing"),
            ("k * sin(q]", 10, "closes nothing"),
            ("q[\"l knee]", 3, "never closed"),
        ] {
            let fault = Formula::parse(text).unwrap_err();
            assert!(fault.reason.contains(said), "{text}: {fault}");
            assert_eq!(fault.column, column, "{text}: {fault}");
        }
    }

    #[test]
    fn no_text_is_too_deep_and_none_panics() {
        let deep = |open: &str, close: &str| open.repeat(400) + "q" + &close.repeat(400);
        for text in [
            deep("(", ")"),
            deep("-", ""),
            deep("- ", ""),
            deep("sin(", ")"),
        ] {
            assert!(
                Formula::parse(&text)
                    .unwrap_err()
                    .reason
                    .contains("more than")
            );
        }
        let parts = [
            "q", "tau", "(", ")", "[", "]", "\"", "k", "1.0", "1e", "*", "-", "/", ",", "max", " ",
            "if", "as", ".", "_", "é", "\n", "0x", "r#", "{", "b", "x", "column",
        ];
        let mut state = 7_u64;
        for _ in 0..20_000 {
            let mut text = String::new();
            for _ in 0..1 + (state >> 60) {
                state = state
                    .wrapping_mul(6_364_136_223_846_793_005)
                    .wrapping_add(1);
                text += parts[(state >> 33) as usize % parts.len()];
            }
            if let Ok(formula) = Formula::parse(&text) {
                let printed = formula.to_string();
                assert_eq!(
                    Formula::parse(&printed).unwrap(),
                    formula,
                    "{text}: {printed}"
                );
                let mut g = Graph::default();
                let any = g.input(Argument::Positions, 0);
                let variables = formula.variables().into_iter().map(|v| (v, any)).collect();
                let names = formula.parameters();
                let parameters = names.iter().map(|name| (name.as_str(), any)).collect();
                formula.write(&mut g, &variables, &parameters);
            }
        }
    }
}

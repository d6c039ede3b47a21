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

/// A function that formulas may call: its name, how many arguments it takes, and what it is of
/// expressions and of numbers.
struct Function {
    name: &'static str,
    takes: usize,
    write: fn(&Graph, &[Id]) -> Id,
    value: fn(&[f64]) -> f64,
}

const FUNCTIONS: [Function; 9] = [
    Function {
        name: "sin",
        takes: 1,
        write: |g, of| g.sin(of[0]),
        value: |of| libm::sin(of[0]),
    },
    Function {
        name: "cos",
        takes: 1,
        write: |g, of| g.cos(of[0]),
        value: |of| libm::cos(of[0]),
    },
    Function {
        name: "abs",
        takes: 1,
        write: |g, of| g.abs(of[0]),
        value: |of| libm::fabs(of[0]),
    },
    Function {
        name: "sign",
        takes: 1,
        write: |g, of| g.sign(of[0]),
        value: |of| f64::from(i8::from(of[0] > 0.0) - i8::from(of[0] < 0.0)),
    },
    Function {
        name: "sqrt",
        takes: 1,
        write: |g, of| {
            let half = g.constant(0.5);
            power(g, of[0], half)
        },
        value: |of| libm::sqrt(of[0].max(0.0)),
    },
    Function {
        name: "exp",
        takes: 1,
        write: |g, of| {
            let e = g.constant(core::f64::consts::E);
            g.pow(e, of[0])
        },
        value: |of| libm::exp(of[0]),
    },
    Function {
        name: "pow",
        takes: 2,
        write: |g, of| power(g, of[0], of[1]),
        value: |of| libm::pow(of[0].max(0.0), of[1]),
    },
    Function {
        name: "max",
        takes: 2,
        write: |g, of| g.max(of[0], of[1]),
        value: |of| of[0].max(of[1]),
    },
    Function {
        name: "min",
        takes: 2,
        write: |g, of| g.min(of[0], of[1]),
        value: |of| of[0].min(of[1]),
    },
];

/// Those that have a corner, or jump.
const CORNERS: [&str; 4] = ["abs", "sign", "max", "min"];

/// Names of the functions that formulas may call.
pub fn functions() -> [&'static str; 9] {
    FUNCTIONS.map(|function| function.name)
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
    /// A whole power, as products write it.
    Power(Box<Node>, i32),
    /// A function, by its place in the table.
    Call(usize, Vec<Node>),
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
            corners |= matches!(node, Node::Call(k, _) if CORNERS.contains(&FUNCTIONS[*k].name));
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
        g: &Graph,
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
            Node::Neg(a) | Node::Power(a, _) => a.walk(see),
            Node::Binary(_, both) => both.iter().for_each(|part| part.walk(see)),
            Node::Call(_, arguments) => arguments.iter().for_each(|part| part.walk(see)),
        }
    }

    fn write(
        &self,
        g: &Graph,
        variables: &HashMap<Variable, Id>,
        parameters: &HashMap<&str, Id>,
    ) -> Id {
        let of = |g: &Graph, node: &Node| node.write(g, variables, parameters);
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
            Node::Power(a, times) => {
                let a = of(g, a);
                products(g, a, *times)
            }
            Node::Call(function, arguments) => {
                let ids: Vec<Id> = arguments.iter().map(|node| of(g, node)).collect();
                (FUNCTIONS[*function].write)(g, &ids)
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
            Node::Power(a, times) => libm::pow(of(a), f64::from(*times)),
            Node::Call(function, arguments) => {
                let values: Vec<f64> = arguments.iter().map(of).collect();
                (FUNCTIONS[*function].value)(&values)
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
fn products(g: &Graph, a: Id, times: i32) -> Id {
    let one = g.constant(1.0);
    let product = (0..times.abs()).fold(one, |product, _| g.mul(product, a));
    match times < 0 {
        true => g.div(one, product),
        false => product,
    }
}

/// `a^b` of what is not negative.
fn power(g: &Graph, a: Id, b: Id) -> Id {
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
            Node::Power(a, times) => write!(f, "pow({a}, {times})"),
            Node::Call(function, arguments) => {
                f.write_str(FUNCTIONS[*function].name)?;
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
    // The last character that is no space, and whether it stands right before.
    let (mut last, mut beside) = (' ', false);
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
        let is_word = |c: char| c.is_alphanumeric() || c == '_';
        if is_word(c) && is_word(last) && !beside {
            let reason = "two names need an operator between them; a formula has no `if`, casts or \
                          statements";
            return fault(column, reason.into());
        }
        if c == '.' && last == '.' && beside {
            return fault(column, "a formula has no ranges".into());
        }
        if c == ' ' {
            beside = false;
        } else {
            (last, beside) = (c, true);
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
            let Some(k) = FUNCTIONS.iter().position(|known| known.name == name) else {
                let names = functions();
                let meant = suggestion(&name, names);
                let reason = format!("no function `{name}`; there are {}{meant}", names.join(" "));
                return Err(fault(call.func.span(), &reason));
            };
            let takes = FUNCTIONS[k].takes;
            if call.args.len() != takes {
                let reason = format!("`{name}` takes {takes}, not {}", call.args.len());
                return Err(fault(call.func.span(), &reason));
            }
            let mut arguments = call.args.iter().map(node).collect::<Result<Vec<_>, _>>()?;
            match arguments.get(1).and_then(Node::integer) {
                Some(times) if name == "pow" => Node::Power(Box::new(arguments.remove(0)), times),
                _ => Node::Call(k, arguments),
            }
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
        let g = Graph::default();
        let (q, k) = (g.constant(q), g.constant(k));
        let formula = Formula::parse(text).unwrap();
        let variables = formula.variables().into_iter().map(|v| (v, q)).collect();
        let id = formula.write(&g, &variables, &HashMap::from([("k", k)]));
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
            ("k * if q { 1 } else { 2 }", 8, "no `if`"),
            ("k * (q as f64)", 8, "casts"),
            ("return q", 8, "statements"),
            ("0..q", 3, "no ranges"),
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
                let g = Graph::default();
                let any = g.input(Argument::Positions, 0);
                let variables = formula.variables().into_iter().map(|v| (v, any)).collect();
                let names = formula.parameters();
                let parameters = names.iter().map(|name| (name.as_str(), any)).collect();
                formula.write(&g, &variables, &parameters);
            }
        }
    }
}

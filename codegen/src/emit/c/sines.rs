//! Sines and cosines of a block of postures, of two angles at a time.
//!
//! ```text
//! reduce x₁, x₂; reduce x₃, x₄; sines of x₁, x₂; reduce x₅, x₆; sines of x₃, x₄; …
//! ```
//!
//! The steps of one angle wait for each other, a dozen cycles of four. Those of two angles take
//! turns, and the next two are reduced by quarter turns before the sines of these two are summed,
//! so that a processor finds work meanwhile; the bits are those of one angle alone.

use std::collections::{BTreeSet, HashSet};

use crate::emit::listing::{Line, Listing};
use sesc_model::expr::{Expr, Id};
use sesc_model::program::{Program, operands};

/// An angle, its sine and its cosine; one of them may not be needed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct SinCos {
    pub angle: Id,
    pub sin: Option<Id>,
    pub cos: Option<Id>,
}

/// A statement of a block of postures.
#[derive(Debug, PartialEq)]
pub(super) enum Statement<'l, 'p> {
    Line(&'l Line<'p>),
    /// Two angles less quarter turns.
    Reduced([SinCos; 2]),
    /// Their sines and cosines.
    Both([SinCos; 2]),
}

/// Two angles, and which lines of the listing their sines are.
struct Pair {
    both: [SinCos; 2],
    at: [usize; 2],
}

/// The lines of `listing`, angles that `is_lanes` two by two. An angle that is made of inputs
/// alone comes forward to the one before it, with what it is made of; two such angles are reduced
/// before the sines of the two before them.
pub(super) fn in_pairs<'l, 'p>(
    listing: &'l Listing<'p>,
    is_lanes: impl Fn(Id) -> bool,
) -> Vec<Statement<'l, 'p>> {
    let lines = &listing.lines;
    let of_inputs = of_inputs(listing.program);
    let is_of_inputs = |of: &SinCos| of_inputs[of.angle.index()];
    let mut pairs = pairs(lines, is_lanes, is_of_inputs).into_iter().peekable();
    let mut statements = Vec::with_capacity(lines.len());
    // Lines that came forward.
    let mut moved: HashSet<usize> = HashSet::new();
    let mut is_reduced = false;
    for (at, line) in lines.iter().enumerate() {
        if moved.contains(&at) {
            continue;
        }
        let Some(pair) = pairs.next_if(|pair| pair.at[0] == at) else {
            statements.push(Statement::Line(line));
            continue;
        };
        let next = pairs
            .peek()
            .filter(|next| next.both.iter().all(is_of_inputs));
        let now = (!is_reduced).then_some(&pair);
        is_reduced = next.is_some();
        for pair in now.into_iter().chain(next) {
            let forward = pair.both.iter().filter(|of| is_of_inputs(of));
            let needed = made_of(listing.program, forward.map(|of| of.angle));
            for (k, line) in lines.iter().enumerate().take(pair.at[1]).skip(at) {
                if matches!(line, Line::Let(id) if needed.contains(id)) && moved.insert(k) {
                    statements.push(Statement::Line(line));
                }
            }
            statements.push(Statement::Reduced(pair.both));
        }
        moved.insert(pair.at[1]);
        statements.push(Statement::Both(pair.both));
    }
    without_empty_titles(statements, listing.program.outputs.len())
}

/// Leaves out titles whose lines all came forward: another title follows, or all `results`.
fn without_empty_titles<'l, 'p>(
    statements: Vec<Statement<'l, 'p>>,
    results: usize,
) -> Vec<Statement<'l, 'p>> {
    let is_title = |statement: &Statement| matches!(statement, Statement::Line(Line::Title(_)));
    let is_result = |statement: &Statement| matches!(statement, Statement::Line(Line::Result(_)));
    let at_the_end = statements.len() - results;
    let has_end = statements[at_the_end..].iter().all(is_result);
    let mut kept: Vec<Statement> = Vec::with_capacity(statements.len());
    for (at, statement) in statements.into_iter().enumerate() {
        let ends = is_title(&statement) || (has_end && at == at_the_end);
        if ends && kept.last().is_some_and(is_title) {
            kept.pop();
        }
        kept.push(statement);
    }
    kept
}

/// Angles two by two as they come: any first, and a second that is made of inputs.
fn pairs(
    lines: &[Line],
    is_lanes: impl Fn(Id) -> bool,
    is_of_inputs: impl Fn(&SinCos) -> bool,
) -> Vec<Pair> {
    let sines = lines
        .iter()
        .enumerate()
        .filter_map(|(at, line)| match *line {
            Line::SinCos { angle, sin, cos } if is_lanes(angle) => {
                Some((at, SinCos { angle, sin, cos }))
            }
            _ => None,
        });
    let mut sines = sines.peekable();
    let mut pairs = Vec::new();
    while let Some((first_at, first)) = sines.next() {
        if let Some((second_at, second)) = sines.next_if(|(_, second)| is_of_inputs(second)) {
            pairs.push(Pair {
                both: [first, second],
                at: [first_at, second_at],
            });
        }
    }
    pairs
}

/// Which nodes need no sine.
fn of_inputs(program: &Program) -> Vec<bool> {
    let mut of_inputs: Vec<bool> = Vec::with_capacity(program.nodes.len());
    for (_, node) in program.iter() {
        of_inputs.push(match node.expr {
            Expr::Sin(_) | Expr::Cos(_) => false,
            other => operands(other).all(|id| of_inputs[id.index()]),
        });
    }
    of_inputs
}

/// Nodes and all that they are made of.
fn made_of(program: &Program, ids: impl Iterator<Item = Id>) -> BTreeSet<Id> {
    let mut all: BTreeSet<Id> = ids.collect();
    let mut left: Vec<Id> = all.iter().copied().collect();
    while let Some(id) = left.pop() {
        left.extend(operands(program.expr(id)).filter(|operand| all.insert(*operand)));
    }
    all
}

/// Statements on the angle `x` or what is kept `of` it, with the results `sine` and `cosine`, each
/// for `x_1` and then for `x_2`.
pub(super) fn taking_turns(body: &str) -> String {
    let mut names: HashSet<&str> = HashSet::from(["x", "of", "sine", "cosine"]);
    names.extend(body.lines().filter_map(|line| {
        let (declared, _) = line.split_once(" = ")?;
        let [kind, _, name] = declared.split_whitespace().collect::<Vec<_>>()[..] else {
            return None;
        };
        (kind == "const").then_some(name)
    }));
    let mut out = String::new();
    for statement in body.split_inclusive(";\n") {
        // Comments and empty lines stand before the statement, once.
        let code = statement
            .split_inclusive('\n')
            .skip_while(|line| line.trim().is_empty() || line.trim().starts_with("/*"));
        let code: String = code.collect();
        out.push_str(&statement[..statement.len() - code.len()]);
        for of in ["_1", "_2"] {
            out.push_str(&renamed(&code, &names, of));
        }
    }
    out
}

/// `code` with `of` behind each of `names`.
fn renamed(code: &str, names: &HashSet<&str>, of: &str) -> String {
    let is_of_name = |c: char| c.is_ascii_alphanumeric() || c == '_' || c == '.';
    let mut out = String::new();
    let mut rest = code;
    while !rest.is_empty() {
        let end = rest.find(|c| !is_of_name(c)).unwrap_or(rest.len());
        let (word, after) = rest.split_at(end);
        let is_field = out.ends_with("->");
        out.push_str(word);
        if names.contains(word) && !is_field {
            out.push_str(of);
        }
        let next = after.find(is_of_name).unwrap_or(after.len());
        out.push_str(&after[..next]);
        rest = &after[next..];
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::emit::c::helpers::Calls;
    use crate::emit::c::{Scalar, float};
    use crate::emit::listing::Results;
    use sesc_model::expr::{Argument, Graph};
    use sesc_model::program::{Array, Shape};

    /// A program of joint positions.
    fn program(g: Graph, joints: usize, outputs: &[Id]) -> Program {
        let inputs = vec![Array::new(Argument::Positions, joints)];
        Program::new(g, inputs, Shape::Vector(outputs.len()), outputs)
    }

    /// The statements in short: a title, a name that is bound, angles by their sines' names.
    fn told(program: &Program) -> Vec<String> {
        let listing = Listing::new(program, Results::AtTheEnd);
        let name = |id: Option<Id>| listing.name(id.unwrap()).unwrap().to_string();
        let names = |both: [SinCos; 2]| both.map(|of| name(of.sin)).join(" and ");
        let statements = in_pairs(&listing, |_| true).into_iter();
        let told = statements.filter_map(|statement| match statement {
            Statement::Line(Line::Title(title)) => Some(format!("/* {title} */")),
            Statement::Line(Line::Let(id)) => Some(name(Some(*id))),
            Statement::Line(Line::SinCos { sin, .. }) => Some(format!("{} alone", name(*sin))),
            Statement::Line(Line::Result(_)) => None,
            Statement::Reduced(both) => Some(format!("reduced {}", names(both))),
            Statement::Both(both) => Some(names(both)),
        });
        told.collect()
    }

    #[test]
    fn angles_of_inputs_come_forward_with_what_they_are_made_of() {
        let mut g = Graph::default();
        let q = [0, 1, 2, 3].map(|k| g.input(Argument::Positions, k));
        let first = g.sin(q[0]);
        let half = g.constant(0.5);
        let shifted = g.add(q[1], half);
        g.name(shifted, || "shifted".to_string());
        let second = g.sin(shifted);
        // A joint that the first bends.
        let bent = g.add(q[2], first);
        let third = g.sin(bent);
        let fourth = g.sin(q[3]);
        let outputs = [first, second, third, fourth];
        for (id, name) in outputs.into_iter().zip(["s_1", "s_2", "s_3", "s_4"]) {
            g.name(id, || name.to_string());
        }
        let expected = [
            "shifted",
            "reduced s_1 and s_2",
            "s_1 and s_2",
            "reduced s_3 and s_4",
            "s_3 and s_4",
        ];
        assert_eq!(told(&program(g, 4, &outputs)), expected);
    }

    /// Sines of six joints under titles; those of the second half have offsets.
    fn six_joints() -> Program {
        let mut g = Graph::default();
        let mut outputs = Vec::new();
        for k in 0..6 {
            g.section(format!("joint {k}"));
            let mut angle = g.input(Argument::Positions, k);
            if k >= 3 {
                let offset = g.constant(k as f64);
                angle = g.add(angle, offset);
                g.name(angle, || format!("a_{k}"));
            }
            let sine = g.sin(angle);
            g.name(sine, || format!("s_{k}"));
            outputs.push(sine);
        }
        program(g, 6, &outputs)
    }

    #[test]
    fn two_angles_are_reduced_before_the_sines_of_the_two_before() {
        let expected = [
            "/* joint 0 */",
            "reduced s_0 and s_1",
            "a_3",
            "reduced s_2 and s_3",
            "s_0 and s_1",
            "/* joint 2 */",
            "a_4",
            "a_5",
            "reduced s_4 and s_5",
            "s_2 and s_3",
            "/* joint 4 */",
            "s_4 and s_5",
        ];
        // Titles of joints that came forward are left out.
        assert_eq!(told(&six_joints()), expected);
    }

    #[test]
    fn helpers_of_two_angles_are_called_once_for_both() {
        let program = six_joints();
        let calls = Calls::new("arm");
        let lines = float::lanes(&program, Scalar::F32, &calls, "out");
        let count = |call: &str| lines.iter().filter(|line| line.starts_with(call)).count();
        assert_eq!(count("arm_reduce_both("), 3);
        assert_eq!(count("arm_sincos_both("), 3);
        assert_eq!(count("arm_sincos_lanes("), 0);
        let wanted = "arm_reduce_both(arm_load(q, 2u, n), a_3, &reduced_2, &reduced_3);";
        assert!(lines.iter().any(|line| line == wanted), "{lines:#?}");
    }

    #[test]
    fn an_angle_that_needs_a_sine_stays_where_it_is() {
        let g = Graph::default();
        let q = g.input(Argument::Positions, 0);
        let first = g.sin(q);
        let second = g.sin(first);
        let third = g.sin(second);
        let program = program(g, 1, &[third]);
        let listing = Listing::new(&program, Results::AtTheEnd);
        let statements = in_pairs(&listing, |_| true);
        let expected: Vec<Statement> = listing.lines.iter().map(Statement::Line).collect();
        assert_eq!(statements, expected);
    }

    #[test]
    fn statements_of_two_angles_take_turns() {
        let body = "    /* Twice x. */\n    const lanes y = x + x;\n\n    \
                    const lanes y2 = y\n        * 0.5;\n    of->y = y2;\n    \
                    *sine = y2;\n    *cosine = f.y;\n";
        let expected = "    /* Twice x. */\n    const lanes y_1 = x_1 + x_1;\n    \
                        const lanes y_2 = x_2 + x_2;\n\n    const lanes y2_1 = y_1\n        \
                        * 0.5;\n    const lanes y2_2 = y_2\n        * 0.5;\n    \
                        of_1->y = y2_1;\n    of_2->y = y2_2;\n    \
                        *sine_1 = y2_1;\n    *sine_2 = y2_2;\n    *cosine_1 = f.y;\n    \
                        *cosine_2 = f.y;\n";
        assert_eq!(taking_turns(body), expected);
    }
}

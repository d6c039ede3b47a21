//! Sines and cosines of a block of postures, of two angles at a time.
//!
//! ```text
//! a₁ = f(x₁), a₂ = f(x₂), b₁ = g(a₁), b₂ = g(a₂), …
//! ```
//!
//! The steps of one angle wait for each other, a dozen cycles of four. Those of two angles take
//! turns, so that a processor finds work meanwhile; the bits are those of one angle alone.

use std::collections::{BTreeSet, HashSet};

use crate::emit::listing::{Line, Listing};
use sesc_model::expr::{Expr, Id};
use sesc_model::program::operands;

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
    /// Sines and cosines of two angles.
    Both([SinCos; 2]),
}

/// The lines of `listing`, angles that `is_lanes` two by two. An angle that is made of inputs
/// alone comes forward to the one before it, with what it is made of.
pub(super) fn in_pairs<'l, 'p>(
    listing: &'l Listing<'p>,
    is_lanes: impl Fn(Id) -> bool,
) -> Vec<Statement<'l, 'p>> {
    let lines = &listing.lines;
    let sines = |(at, line): (usize, &Line)| match *line {
        Line::SinCos { angle, sin, cos } if is_lanes(angle) => {
            Some((at, SinCos { angle, sin, cos }))
        }
        _ => None,
    };
    let mut ahead = lines.iter().enumerate().filter_map(sines).peekable();
    let mut statements = Vec::with_capacity(lines.len());
    // Lines that came forward.
    let mut moved: HashSet<usize> = HashSet::new();
    for (at, line) in lines.iter().enumerate() {
        if moved.contains(&at) {
            continue;
        }
        let first = ahead.next_if(|(of, _)| *of == at);
        let second =
            first.and_then(|_| ahead.next_if(|(_, second)| is_of_inputs(listing, second.angle)));
        let (Some((_, first)), Some((of_second, second))) = (first, second) else {
            statements.push(Statement::Line(line));
            continue;
        };
        let needed = made_of(listing, second.angle);
        for (k, line) in lines.iter().enumerate().take(of_second).skip(at) {
            if matches!(line, Line::Let(id) if needed.contains(id)) && moved.insert(k) {
                statements.push(Statement::Line(line));
            }
        }
        moved.insert(of_second);
        statements.push(Statement::Both([first, second]));
    }
    // Titles whose lines all came forward.
    let is_title = |statement: &Statement| matches!(statement, Statement::Line(Line::Title(_)));
    let mut kept: Vec<Statement> = Vec::with_capacity(statements.len());
    for statement in statements {
        if is_title(&statement) && kept.last().is_some_and(is_title) {
            kept.pop();
        }
        kept.push(statement);
    }
    kept
}

/// Whether a node needs no sine.
fn is_of_inputs(listing: &Listing, id: Id) -> bool {
    made_of(listing, id)
        .iter()
        .all(|id| !matches!(listing.program.expr(*id), Expr::Sin(_) | Expr::Cos(_)))
}

/// A node and all that it is made of.
fn made_of(listing: &Listing, id: Id) -> BTreeSet<Id> {
    let mut all = BTreeSet::from([id]);
    let mut left = vec![id];
    while let Some(id) = left.pop() {
        let new = operands(listing.program.expr(id)).filter(|operand| all.insert(*operand));
        left.extend(new);
    }
    all
}

/// The body of a function of `x` with the results `sine` and `cosine`, each statement for `x_1`
/// and then for `x_2`.
pub(super) fn taking_turns(function: &str) -> String {
    let body = function
        .split_once("\n{\n")
        .map_or(function, |(_, body)| body);
    let body = body.trim_end().trim_end_matches('}');
    let mut names: HashSet<&str> = HashSet::from(["x", "sine", "cosine"]);
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
        out.push_str(word);
        if names.contains(word) {
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
    use crate::emit::listing::Results;
    use sesc_model::expr::{Argument, Graph};
    use sesc_model::program::{Array, Program, Shape};

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
        let inputs = vec![Array::new(Argument::Positions, 4)];
        let outputs = [first, second, third, fourth];
        let program = Program::new(g, inputs, Shape::Vector(4), &outputs);
        let listing = Listing::new(&program, Results::AtTheEnd);
        let of = |id: Id| format!("{:?}", program.expr(id));
        let told =
            in_pairs(&listing, |_| true)
                .into_iter()
                .filter_map(|statement| match statement {
                    Statement::Line(Line::Let(id)) => listing.name(*id).map(str::to_string),
                    Statement::Line(Line::SinCos { angle, .. }) => Some(of(*angle)),
                    Statement::Line(_) => None,
                    Statement::Both(both) => Some(both.map(|one| of(one.angle)).join(" with ")),
                });
        let told: Vec<String> = told.collect();
        let angles = program.outputs.iter().map(|id| match program.expr(*id) {
            Expr::Sin(angle) => of(angle),
            other => unreachable!("{other:?} is no sine"),
        });
        let angles: Vec<String> = angles.collect();
        let pairs = angles.chunks(2).map(|pair| pair.join(" with "));
        let expected: Vec<String> = ["shifted".to_string()].into_iter().chain(pairs).collect();
        assert_eq!(told, expected);
    }

    #[test]
    fn an_angle_that_needs_a_sine_stays_where_it_is() {
        let mut g = Graph::default();
        let q = g.input(Argument::Positions, 0);
        let first = g.sin(q);
        let second = g.sin(first);
        let third = g.sin(second);
        let inputs = vec![Array::new(Argument::Positions, 1)];
        let program = Program::new(g, inputs, Shape::Vector(1), &[third]);
        let listing = Listing::new(&program, Results::AtTheEnd);
        let statements = in_pairs(&listing, |_| true);
        let expected: Vec<Statement> = listing.lines.iter().map(Statement::Line).collect();
        assert_eq!(statements, expected);
    }

    #[test]
    fn statements_of_two_angles_take_turns() {
        let function = "static void f(lanes x, lanes *sine, lanes *cosine)\n{\n    \
                        /* Twice x. */\n    const lanes y = x + x;\n\n    \
                        const lanes y2 = y\n        * 0.5;\n    *sine = y2;\n    *cosine = f.y;\n}";
        let expected = "    /* Twice x. */\n    const lanes y_1 = x_1 + x_1;\n    \
                        const lanes y_2 = x_2 + x_2;\n\n    const lanes y2_1 = y_1\n        \
                        * 0.5;\n    const lanes y2_2 = y_2\n        * 0.5;\n    \
                        *sine_1 = y2_1;\n    *sine_2 = y2_2;\n    *cosine_1 = f.y;\n    \
                        *cosine_2 = f.y;\n";
        assert_eq!(taking_turns(function), expected);
    }
}

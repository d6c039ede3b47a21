//! A program as a list of statements, the same for every language.
//!
//! Which nodes get a name, what it is, in which order they stand and under
//! which title is decided here; `rust` and `c` only spell it.

use std::collections::HashMap;

use sesc_model::expr::{Argument, Expr, Id};
use sesc_model::program::{Program, operands};

/// Expressions nested deeper than this get a name of their own.
const DEEPEST: usize = 6;

/// One statement of a function's body.
#[derive(Debug, Clone, PartialEq)]
pub enum Line<'p> {
    /// A comment: the joint or link that the lines below are about.
    Title(&'p str),
    /// Sine and cosine of one angle; one of them may not be needed.
    SinCos {
        angle: Id,
        sin: Option<Id>,
        cos: Option<Id>,
    },
    /// A node that gets a name.
    Let(Id),
    /// A result, by its place among them.
    Result(usize),
}

/// When results leave a function.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Results {
    /// All together, at its end.
    AtTheEnd,
    /// Each entry once it is computed, so that a wide matrix is not held until its last entry.
    AsTheyCome,
}

/// The statements of a program, and the names they bind.
#[derive(Debug, Clone)]
pub struct Listing<'p> {
    pub program: &'p Program,
    pub lines: Vec<Line<'p>>,
    names: HashMap<Id, String>,
    /// Names made up so far: `e1`, `e2`, …
    fresh: usize,
}

/// Binding strength of an expression, for parentheses.
#[derive(Debug, Clone, Copy, PartialEq, PartialOrd)]
pub enum Strength {
    Sum,
    Product,
    Sign,
    Atom,
}

impl<'p> Listing<'p> {
    pub fn new(program: &'p Program, results: Results) -> Listing<'p> {
        let mut listing = Listing {
            program,
            lines: Vec::new(),
            names: HashMap::new(),
            fresh: 0,
        };
        listing.fill(results);
        listing
    }

    /// Name of a node that has one; others are written out where they are used.
    pub fn name(&self, id: Id) -> Option<&str> {
        self.names.get(&id).map(String::as_str)
    }

    /// Whether any node reads this input array.
    pub fn reads(&self, array: Argument) -> bool {
        let of = |expr| matches!(expr, Expr::Input { argument, .. } if argument == array);
        let mut nodes = self.program.nodes.iter().filter(|node| node.uses > 0);
        nodes.any(|node| of(node.expr))
    }

    fn fill(&mut self, results: Results) {
        let program = self.program;
        let mut places: HashMap<Id, Vec<usize>> = HashMap::new();
        if results == Results::AsTheyCome {
            for (k, id) in program.outputs.iter().enumerate() {
                places.entry(*id).or_default().push(k);
            }
        }
        let angles = program.angles();
        let mut depth = vec![0; program.nodes.len()];
        let mut sections = program.sections.iter().peekable();
        let mut title = None;
        for (id, node) in program.iter() {
            while let Some((_, next)) = sections.next_if(|(at, _)| *at <= id.index()) {
                title = Some(next);
            }
            if node.uses == 0 {
                continue;
            }
            let named = |x: Id| self.names.contains_key(&x);
            let deepest = operands(node.expr).map(|x| if named(x) { 0 } else { depth[x.index()] });
            depth[id.index()] = 1 + deepest.max().unwrap_or(0);
            let leaf = matches!(node.expr, Expr::Const(_) | Expr::Input { .. });
            let trig = matches!(node.expr, Expr::Sin(_) | Expr::Cos(_));
            let wants = trig || node.name.is_some() || node.uses > 1;
            let binds = !leaf && !named(id) && (wants || depth[id.index()] > DEEPEST);
            let places = places.remove(&id).unwrap_or_default();
            if !binds && places.is_empty() {
                continue;
            }
            // Constants and inputs need no section.
            if let (Some(next), false) = (title, leaf) {
                self.lines.push(Line::Title(next));
                title = None;
            }
            if binds {
                self.define(id, &angles);
            }
            self.lines.extend(places.into_iter().map(Line::Result));
        }
        if results == Results::AtTheEnd {
            self.lines
                .extend((0..program.outputs.len()).map(Line::Result));
        }
    }

    /// The statement that binds a node; the one of a sine binds its cosine as well.
    fn define(&mut self, id: Id, angles: &HashMap<Id, (Option<Id>, Option<Id>)>) {
        match self.program.expr(id) {
            Expr::Sin(angle) | Expr::Cos(angle) => {
                let (sin, cos) = angles[&angle];
                for id in [sin, cos].into_iter().flatten() {
                    self.bind(id);
                }
                self.lines.push(Line::SinCos { angle, sin, cos });
            }
            _ => {
                self.bind(id);
                self.lines.push(Line::Let(id));
            }
        }
    }

    fn bind(&mut self, id: Id) {
        let name = match &self.program.nodes[id.index()].name {
            Some(name) => name.clone(),
            None => {
                self.fresh += 1;
                format!("e{}", self.fresh)
            }
        };
        self.names.insert(id, name);
    }
}

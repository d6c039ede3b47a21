//! Straight-line programs: what is left of a graph once outputs are chosen.
//!
//! Dead nodes are dropped, the rest keeps the order in which it was made, so a
//! program reads like the derivation and one new term is one new line. Rust,
//! C and tape all come from this form; operation counts are counted on it.

use std::collections::{HashMap, HashSet};

use serde::Serialize;

#[doc(hidden)]
pub use crate::expr::operands;
use crate::expr::{Argument, Expr, Graph, Id, Product, Vector, VectorId};

/// An input array.
#[doc(hidden)]
#[derive(Debug, Clone, PartialEq)]
pub struct Array {
    /// What it is.
    pub argument: Argument,
    /// How many entries it has.
    pub len: usize,
}

impl Array {
    /// An input array of `len` entries.
    pub const fn new(argument: Argument, len: usize) -> Array {
        Array { argument, len }
    }
}

/// Shape of the result.
#[doc(hidden)]
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Shape {
    /// A vector with this many entries.
    Vector(usize),
    /// Row-major.
    Matrix {
        /// Number of rows.
        rows: usize,
        /// Number of columns.
        cols: usize,
    },
}

/// Exact operation counts.
///
/// Operations that only form the argument of a sine and cosine (a constant in
/// the angle, a mimic's multiplier) belong to it and are counted as `angle`.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Counts {
    /// Multiplications.
    pub mul: usize,
    /// Additions and subtractions.
    pub add: usize,
    /// Sine-cosine pairs.
    pub sin_cos: usize,
    /// Operations on angles; before their sine and cosine.
    pub angle: usize,
    /// Sign changes that no addition absorbs.
    #[serde(skip)]
    pub neg: usize,
    /// Divisions, clamps, powers and maxima, which only effects need; left out of JSON where
    /// there are none.
    #[serde(skip_serializing_if = "is_zero")]
    pub other: usize,
}

/// The new id of a node that lives: an output, or an operand of one.
fn live_id(new_ids: &[Option<Id>], id: Id) -> Id {
    new_ids[id.index()].expect("operands of what lives live, and come before it")
}

fn is_zero(count: &usize) -> bool {
    *count == 0
}

/// One node of a program.
#[doc(hidden)]
#[derive(Debug, Clone)]
pub struct Node {
    /// What it computes.
    pub expr: Expr,
    /// Name it was given in the graph.
    pub name: Option<String>,
    /// How often other nodes and outputs use it.
    pub uses: usize,
}

/// Straight-line code for one function.
#[derive(Debug, Clone)]
pub struct Program {
    /// In the order in which values are given.
    #[doc(hidden)]
    pub inputs: Vec<Array>,
    /// How outputs are arranged.
    #[doc(hidden)]
    pub shape: Shape,
    /// Operands stand before their users; ids index this list.
    #[doc(hidden)]
    pub nodes: Vec<Node>,
    /// In row-major order of `shape`.
    #[doc(hidden)]
    pub outputs: Vec<Id>,
    /// Titles, each with the node it stands before.
    #[doc(hidden)]
    pub sections: Vec<(usize, String)>,
    pub(crate) vectors: Vec<Vector>,
    pub(crate) products: Vec<Product>,
    pub(crate) weights: HashSet<Id>,
    pub(crate) least: HashMap<Id, f64>,
}

/// `expr` with its operands renamed.
pub(crate) fn rename(expr: Expr, to: impl Fn(Id) -> Id) -> Expr {
    match expr {
        Expr::Const(_) | Expr::Input { .. } => expr,
        Expr::Add(a, b) => Expr::Add(to(a), to(b)),
        Expr::Sub(a, b) => Expr::Sub(to(a), to(b)),
        Expr::Mul(a, b) => Expr::Mul(to(a), to(b)),
        Expr::Div(a, b) => Expr::Div(to(a), to(b)),
        Expr::Neg(a) => Expr::Neg(to(a)),
        Expr::Sin(a) => Expr::Sin(to(a)),
        Expr::Cos(a) => Expr::Cos(to(a)),
        Expr::Clamp(a) => Expr::Clamp(to(a)),
        Expr::Pow(a, b) => Expr::Pow(to(a), to(b)),
        Expr::Max(a, b) => Expr::Max(to(a), to(b)),
    }
}

impl Program {
    /// Keep what `outputs` need.
    #[doc(hidden)]
    pub fn new(mut graph: Graph, inputs: Vec<Array>, shape: Shape, outputs: &[Id]) -> Program {
        let made = graph.nodes.into_inner();
        let mut live = vec![false; made.len()];
        for id in outputs {
            live[id.index()] = true;
        }
        for k in (0..made.len()).rev() {
            if live[k] {
                for operand in operands(made[k]) {
                    live[operand.index()] = true;
                }
            }
        }
        let mut new_ids: Vec<Option<Id>> = vec![None; made.len()];
        let mut nodes: Vec<Node> = Vec::new();
        let mut before = vec![0; made.len() + 1];
        for k in 0..made.len() {
            before[k] = nodes.len();
            if !live[k] {
                continue;
            }
            let old = Id(k as u32);
            new_ids[k] = Some(Id(nodes.len() as u32));
            let expr = rename(made[k], |id| live_id(&new_ids, id));
            for operand in operands(expr) {
                nodes[operand.index()].uses += 1;
            }
            nodes.push(Node {
                expr,
                name: graph.names.remove(&old),
                uses: 0,
            });
        }
        before[made.len()] = nodes.len();
        let new_id = |id: Id| new_ids[id.index()];
        let outputs: Vec<Id> = outputs.iter().map(|id| live_id(&new_ids, *id)).collect();
        for id in &outputs {
            nodes[id.index()].uses += 1;
        }
        let vectors = graph
            .vectors
            .into_iter()
            .map(|vector| {
                let scale = vector.scale.and_then(new_id);
                // Nothing of a multiple lives where its factor does not.
                let gone = scale.is_none() && vector.scale.is_some();
                Vector {
                    // A dead entry is as good as computed exactly.
                    entries: vector.entries.into_iter().filter_map(new_id).collect(),
                    norm: if gone { Some(0.0) } else { vector.norm },
                    from: if gone { Vec::new() } else { vector.from },
                    scale,
                }
            })
            .collect();
        let products = graph
            .products
            .iter()
            .filter_map(|product| {
                Some(Product {
                    entry: new_id(product.entry)?,
                    ..*product
                })
            })
            .collect();
        let weights = graph.weights.iter().filter_map(|id| new_id(*id)).collect();
        let least = graph.least.iter();
        let least = least.filter_map(|(id, least)| Some((new_id(*id)?, *least)));
        let least = least.collect();
        let sections = graph
            .sections
            .into_iter()
            .map(|(at, title)| (before[at], title))
            .collect();
        Program {
            inputs,
            shape,
            nodes,
            outputs,
            sections,
            vectors,
            products,
            weights,
            least,
        }
    }

    /// The place of an input array among [`Program::inputs`].
    ///
    /// # Panics
    /// When the program has no such input: its expressions were made of others.
    #[doc(hidden)]
    pub fn slot(&self, argument: Argument) -> usize {
        let place = self
            .inputs
            .iter()
            .position(|array| array.argument == argument);
        place.expect("an expression reads an input that its program lacks")
    }

    /// Whether any node reads this input array.
    #[doc(hidden)]
    pub fn reads(&self, array: Argument) -> bool {
        let of = |expr| matches!(expr, Expr::Input { argument, .. } if argument == array);
        self.nodes.iter().any(|node| of(node.expr))
    }

    /// Choose other outputs: uses are counted anew, nodes stay where they are.
    #[doc(hidden)]
    pub fn keep(&mut self, outputs: Vec<Id>) {
        self.outputs = outputs;
        for node in &mut self.nodes {
            node.uses = 0;
        }
        for id in &self.outputs {
            self.nodes[id.index()].uses += 1;
        }
        for k in (0..self.nodes.len()).rev() {
            if self.nodes[k].uses > 0 {
                for operand in operands(self.nodes[k].expr) {
                    self.nodes[operand.index()].uses += 1;
                }
            }
        }
    }

    /// What bounds take node `id` to be at least, where they take anything.
    #[doc(hidden)]
    pub fn least(&self, id: Id) -> Option<f64> {
        self.least.get(&id).copied()
    }

    /// What node `id` is.
    #[doc(hidden)]
    pub fn expr(&self, id: Id) -> Expr {
        self.nodes[id.index()].expr
    }

    /// Nodes in order, with their ids.
    #[doc(hidden)]
    pub fn iter(&self) -> impl DoubleEndedIterator<Item = (Id, &Node)> {
        self.nodes
            .iter()
            .enumerate()
            .map(|(k, node)| (Id(k as u32), node))
    }

    /// Sine and cosine nodes of each angle that has either.
    #[doc(hidden)]
    pub fn angles(&self) -> HashMap<Id, (Option<Id>, Option<Id>)> {
        let mut angles: HashMap<Id, (Option<Id>, Option<Id>)> = HashMap::new();
        for (id, node) in self.iter() {
            match node.expr {
                Expr::Sin(a) => angles.entry(a).or_default().0 = Some(id),
                Expr::Cos(a) => angles.entry(a).or_default().1 = Some(id),
                _ => {}
            }
        }
        angles
    }

    /// Operations of one call.
    pub fn counts(&self) -> Counts {
        let mut counts = Counts::default();
        // Whether a node is made of sines and cosines: where effects bend joints, what
        // forms their angles is a computation of its own.
        let mut made = vec![false; self.nodes.len()];
        for (k, node) in self.nodes.iter().enumerate() {
            let trig = matches!(node.expr, Expr::Sin(_) | Expr::Cos(_));
            made[k] = trig || operands(node.expr).any(|operand| made[operand.index()]);
        }
        // Whether a node feeds anything but sines and cosines.
        let mut beyond = made;
        for id in &self.outputs {
            beyond[id.index()] = true;
        }
        for (k, node) in self.nodes.iter().enumerate().rev() {
            let trig = matches!(node.expr, Expr::Sin(_) | Expr::Cos(_));
            for operand in operands(node.expr) {
                beyond[operand.index()] |= beyond[k] && !trig;
            }
            match node.expr {
                Expr::Const(_) | Expr::Input { .. } | Expr::Sin(_) | Expr::Cos(_) => {}
                _ if !beyond[k] => counts.angle += 1,
                Expr::Add(..) | Expr::Sub(..) => counts.add += 1,
                Expr::Mul(..) => counts.mul += 1,
                Expr::Neg(_) => counts.neg += 1,
                Expr::Div(..) | Expr::Clamp(_) | Expr::Pow(..) | Expr::Max(..) => counts.other += 1,
            }
        }
        counts.sin_cos = self.angles().len();
        counts
    }

    /// Known vectors, by number.
    pub(crate) fn vector(&self, id: VectorId) -> &Vector {
        &self.vectors[id.0 as usize]
    }
}

impl Shape {
    /// Number of outputs.
    pub fn len(self) -> usize {
        match self {
            Shape::Vector(n) => n,
            Shape::Matrix { rows, cols } => rows * cols,
        }
    }

    /// Whether there is no output at all (a robot without joints has an empty Jacobian).
    pub fn is_empty(self) -> bool {
        self.len() == 0
    }
}

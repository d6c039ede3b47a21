//! A hash-consed expression graph.
//!
//! Equal expressions share one node, so common subexpressions are found by
//! construction. Nodes are numbered in the order of their making; an operand
//! always has a smaller number than its user.
//!
//! Beside the nodes the graph records what is known of *vectors* of them: a
//! bound on the Euclidean norm, and that a vector is a sum of orthogonal images
//! of others. Scalar interval arithmetic loses this (each rotation widens a box
//! by √2); the rounding analysis in `bounds` lives on it.

use std::cell::RefCell;
use std::collections::{HashMap, HashSet};
use std::mem::{Discriminant, discriminant};

use rustc_hash::FxHashMap;

use super::argument::Argument;

/// A node of one [`Graph`].
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct Id(pub(crate) u32);

impl Id {
    /// Its place among the nodes.
    pub fn index(self) -> usize {
        self.0 as usize
    }
}

/// What a node is.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Expr {
    /// A constant.
    Const(f64),
    /// Element `index` of an input array.
    Input {
        /// Which array.
        argument: Argument,
        /// Which element of it.
        index: u32,
    },
    /// A sum.
    Add(Id, Id),
    /// A difference.
    Sub(Id, Id),
    /// A product.
    Mul(Id, Id),
    /// A quotient.
    Div(Id, Id),
    /// A number with the other sign.
    Neg(Id),
    /// The sine of an angle, rad.
    Sin(Id),
    /// The cosine of an angle, rad.
    Cos(Id),
    /// The nearest number in [-1, 1].
    Clamp(Id),
    /// The first, not negative, to the power of the second.
    Pow(Id, Id),
    /// The larger of two; the first where they are equal.
    Max(Id, Id),
}

/// The nodes that `expr` reads.
pub fn operands(expr: Expr) -> impl Iterator<Item = Id> {
    let (a, b) = match expr {
        Expr::Const(_) | Expr::Input { .. } => (None, None),
        Expr::Neg(a) | Expr::Sin(a) | Expr::Cos(a) | Expr::Clamp(a) => (Some(a), None),
        Expr::Add(a, b)
        | Expr::Sub(a, b)
        | Expr::Mul(a, b)
        | Expr::Div(a, b)
        | Expr::Pow(a, b)
        | Expr::Max(a, b) => (Some(a), Some(b)),
    };
    a.into_iter().chain(b)
}

/// A node's identity for hash-consing.
type Key = (Discriminant<Expr>, [u64; 2]);

/// Commutative operands are sorted, floats go by their bits.
fn key(expr: Expr) -> Key {
    let place = |id: Option<Id>| id.map_or(0, |id| u64::from(id.0));
    let mut of = operands(expr);
    let mut of = [of.next(), of.next()].map(place);
    match expr {
        Expr::Const(x) => of = [x.to_bits(), 0],
        Expr::Input { argument, index } => of = [argument as u64, u64::from(index)],
        Expr::Add(..) | Expr::Mul(..) | Expr::Max(..) => of.sort_unstable(),
        _ => {}
    }
    (discriminant(&expr), of)
}

/// A vector of nodes, see [`Graph::know`].
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct VectorId(pub(crate) u32);

/// What is known of a vector of nodes.
#[derive(Debug, Clone)]
pub struct Vector {
    /// Its nodes, without their signs.
    pub entries: Vec<Id>,
    /// Bound on the Euclidean norm for every admissible input; none where the vectors
    /// of `from` are all that it is made of, and bound it. With neither, its entries do.
    pub norm: Option<f64>,
    /// In exact arithmetic the vector is a sum of orthogonal images of these,
    /// plus terms that do not depend on them.
    pub from: Vec<VectorId>,
    /// What that sum is multiplied by.
    pub scale: Option<Id>,
}

/// `entry` is a scalar product of parts of two known vectors.
#[derive(Debug, Clone, Copy)]
pub struct Product {
    /// The node that is the product.
    pub entry: Id,
    /// The two vectors.
    pub factors: [VectorId; 2],
}

/// Expressions under construction. Nodes are made by shared reference, so that expressions nest.
#[derive(Default)]
pub struct Graph {
    pub(crate) nodes: RefCell<Vec<Expr>>,
    pub(crate) names: HashMap<Id, String>,
    pub(crate) sections: Vec<(usize, String)>,
    pub(crate) vectors: Vec<Vector>,
    pub(crate) products: Vec<Product>,
    pub(crate) weights: HashSet<Id>,
    /// What nodes are no less than, as the caller promises.
    pub(crate) least: HashMap<Id, f64>,
    index: RefCell<FxHashMap<Key, Id>>,
}

impl Graph {
    /// What node `id` is.
    pub fn expr(&self, id: Id) -> Expr {
        self.nodes.borrow()[id.index()]
    }

    /// Give a node the name it will carry in generated code; the first one stays.
    pub fn name(&mut self, id: Id, name: impl FnOnce() -> String) {
        if !matches!(self.expr(id), Expr::Const(_) | Expr::Input { .. }) {
            self.names.entry(id).or_insert_with(name);
        }
    }

    /// Start a section of generated code, or go on with the one of that title: nodes made
    /// from here on stand below it.
    pub fn section(&mut self, title: impl Into<String>) {
        let title = title.into();
        if self.sections.last().is_none_or(|(_, last)| *last != title) {
            let place = self.nodes.borrow().len();
            self.sections.push((place, title));
        }
    }

    /// Record that `entries` have Euclidean norm at most `norm` and are a sum
    /// of orthogonal images of the vectors `from` (plus independent terms).
    ///
    /// Signs do not matter to any of this, so entries are kept without them: a
    /// sign that the next operation absorbs never becomes a node of a program.
    pub fn know(&mut self, entries: &[Id], norm: f64, from: &[VectorId]) -> VectorId {
        self.know_vector(entries, Some(norm), from, None)
    }

    /// Record that `entries` are a sum of orthogonal images of the vectors `from` and of
    /// nothing else.
    pub fn know_sum(&mut self, entries: &[Id], from: &[VectorId]) -> VectorId {
        self.know_vector(entries, None, from, None)
    }

    /// Record that `entries` are a vector of which no more is known than of each entry.
    pub fn know_entries(&mut self, entries: &[Id]) -> VectorId {
        self.know_vector(entries, None, &[], None)
    }

    /// Record that bounds hold where node `id` is no less than `least`.
    pub fn assume_least(&mut self, id: Id, least: f64) {
        self.least.insert(id, least);
    }

    /// Record that `entries` are `scale` times an orthogonal image of the vector `of`.
    pub fn know_scaled(&mut self, entries: &[Id], scale: Id, of: VectorId) -> VectorId {
        self.know_vector(entries, None, &[of], Some(self.unsigned(scale)))
    }

    fn know_vector(
        &mut self,
        entries: &[Id],
        norm: Option<f64>,
        from: &[VectorId],
        scale: Option<Id>,
    ) -> VectorId {
        self.vectors.push(Vector {
            entries: entries.iter().map(|id| self.unsigned(*id)).collect(),
            norm,
            from: from.to_vec(),
            scale,
        });
        VectorId(self.vectors.len() as u32 - 1)
    }

    /// Record that `entry` is a scalar product of parts of two known vectors.
    pub fn know_product(&mut self, entry: Id, factors: [VectorId; 2]) {
        let entry = self.unsigned(entry);
        self.products.push(Product { entry, factors });
    }

    /// Record that `id` is a weight of orthogonal maps: a sine, a cosine. It may
    /// be an entry of a vector too, but its own error then counts in both roles.
    pub fn know_weight(&mut self, id: Id) {
        self.weights.insert(self.unsigned(id));
    }

    /// The node without its sign.
    pub(super) fn unsigned(&self, id: Id) -> Id {
        match self.expr(id) {
            Expr::Neg(x) => x,
            _ => id,
        }
    }

    /// The node for `expr`, made if it is new. Rules have been applied already.
    pub(crate) fn intern(&self, expr: Expr) -> Id {
        *self.index.borrow_mut().entry(key(expr)).or_insert_with(|| {
            let mut nodes = self.nodes.borrow_mut();
            let id = u32::try_from(nodes.len()).expect("a graph of 2^32 nodes does not fit memory");
            nodes.push(expr);
            Id(id)
        })
    }

    /// Whether the node `a − b` exists.
    pub(crate) fn has_difference(&self, a: Id, b: Id) -> bool {
        self.index.borrow().contains_key(&key(Expr::Sub(a, b)))
    }

    /// The node of a constant.
    pub fn constant(&self, x: f64) -> Id {
        // One zero: -0.0 and 0.0 are the same expression.
        self.intern(Expr::Const(if x == 0.0 { 0.0 } else { x }))
    }

    /// The node of one element of an input array.
    pub fn input(&self, argument: Argument, index: usize) -> Id {
        self.intern(Expr::Input {
            argument,
            index: index as u32,
        })
    }

    /// The nodes of the first `len` elements of an input array.
    pub fn inputs(&self, argument: Argument, len: usize) -> Vec<Id> {
        (0..len).map(|index| self.input(argument, index)).collect()
    }

    pub(crate) fn value(&self, id: Id) -> Option<f64> {
        match self.expr(id) {
            Expr::Const(x) => Some(x),
            _ => None,
        }
    }

    /// Σ_k a_k b_k, left to right; vanishing terms cost nothing.
    pub fn dot(&self, a: &[Id], b: &[Id]) -> Id {
        let zero = self.constant(0.0);
        let terms = a.iter().zip(b);
        terms.fold(zero, |sum, (&x, &y)| self.add(sum, self.mul(x, y)))
    }
}

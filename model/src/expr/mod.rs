//! Symbolic expressions: pure algebra, without any robot in it.

mod derivative;
mod graph;
mod rules;
mod substitute;

pub use graph::{Expr, Graph, Id, Product, Vector, VectorId};

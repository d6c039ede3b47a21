//! Symbolic expressions: pure algebra, without any robot in it.

mod argument;
mod derivative;
mod graph;
mod rules;
mod substitute;

pub use argument::Argument;
pub use graph::{Expr, Graph, Id, Product, Vector, VectorId, operands};

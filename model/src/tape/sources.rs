//! What stands in the first places of a program: inputs, each array in one piece, and constants.

use std::ops::Range;

use crate::expr::{Expr, Id};
use crate::program::{Node, Program};

/// What fills a register before any step.
#[derive(Debug, Clone, Copy)]
pub(super) enum RegisterFill {
    Const(f64),
    Input { array: usize, index: usize },
}

/// What fills the first places of a posture alone, in their order.
pub(super) fn sources(program: &Program) -> Vec<RegisterFill> {
    let source = |(_, node): (Id, &Node)| match node.expr {
        Expr::Const(x) => Some(RegisterFill::Const(x)),
        Expr::Input { argument, index } => Some(RegisterFill::Input {
            array: program.slot(argument),
            index: index as usize,
        }),
        _ => None,
    };
    program.iter().filter_map(source).collect()
}

/// The places of input arrays: the first, each array in one piece.
pub(super) fn inputs(program: &Program) -> Vec<Range<usize>> {
    let lens = program.inputs.iter().map(|array| array.len);
    let range = |end: &mut usize, len: usize| {
        *end += len;
        Some(*end - len..*end)
    };
    lens.scan(0, range).collect()
}

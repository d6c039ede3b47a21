//! One step of a posture alone: a product with a sum, or one of a few other operations.

/// An operation that is no product and no sum.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Operation {
    Div,
    Clamp,
    Pow,
    Max,
    /// The cosine goes where the second operand says.
    SinCos,
}

/// A step, on values or on their places.
#[derive(Debug, Clone, Copy)]
pub(super) enum Step {
    /// `[to, x, y, w]`
    Product([usize; 4]),
    /// `[to, a, b]`
    Other(Operation, [usize; 3]),
}

/// The larger of two numbers, the first where neither is.
#[inline(always)]
pub(super) fn larger(x: f64, y: f64) -> f64 {
    if x < y { y } else { x }
}

impl Step {
    pub(super) fn operands(self) -> impl Iterator<Item = usize> {
        let (used, count) = match self {
            Step::Product([_, x, y, w]) => ([x, y, w], 3),
            Step::Other(Operation::Clamp | Operation::SinCos, [_, a, _]) => ([a, a, a], 1),
            Step::Other(_, [_, a, b]) => ([a, b, b], 2),
        };
        used.into_iter().take(count)
    }

    pub(super) fn results(self) -> impl Iterator<Item = usize> {
        let (to, also) = match self {
            Step::Other(Operation::SinCos, [to, _, also]) => (to, Some(also)),
            Step::Product([to, ..]) | Step::Other(_, [to, ..]) => (to, None),
        };
        [to].into_iter().chain(also)
    }

    /// The same on places.
    pub(super) fn placed(self, place: impl Fn(usize) -> usize) -> Step {
        match self {
            Step::Product(values) => Step::Product(values.map(place)),
            Step::Other(operation, values) => Step::Other(operation, values.map(place)),
        }
    }
}

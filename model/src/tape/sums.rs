//! Which sums of a program take in the products that they are made of.
//!
//! ```text
//! x y + w                            one product that nothing else uses
//! x c + y s                          two of them
//! x c + y s,  x s − y c              two such sums of the same four: a vector turned by an angle
//! ```
//!
//! What is taken in is neither stored nor loaded again. Each product is rounded before its sum, as
//! by itself: the bits stay the same.

use rustc_hash::FxHashMap;

use crate::expr::{Expr, Id};
use crate::program::{Node, Program};

/// The sum of two numbers, of either sign.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Sum {
    /// `a + b`
    Plus,
    /// `a − b`
    Minus,
    /// `b − a`
    Reverse,
}

/// How the value of a node comes about.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Way {
    /// Its own operation makes it.
    Alone,
    /// The step of another node makes it on the way.
    Inside,
    /// `x y` and `w`
    Product(Sum, [Id; 3]),
    /// `x c` and `y s`; never [`Sum::Reverse`].
    Products(Sum, [Id; 4]),
    /// The same, and of `x s` and `y c` the value of another node.
    Turn([Sum; 2], Id, [Id; 4]),
}

/// The way of each node.
pub(super) fn ways(program: &Program) -> Vec<Way> {
    let mut ways = vec![Way::Alone; program.nodes.len()];
    // The first sum of each four factors.
    let mut known: FxHashMap<[Id; 4], Id> = FxHashMap::default();
    for (id, node) in program.iter() {
        let Some((way, inside)) = taken_in(program, node) else {
            continue;
        };
        ways[id.index()] = way;
        for product in inside.into_iter().flatten() {
            ways[product.index()] = Way::Inside;
        }
        let Way::Products(sum, of) = way else {
            continue;
        };
        let mut four = of;
        four.sort_by_key(|of| of.index());
        let Some(first) = known.remove(&four) else {
            known.insert(four, id);
            continue;
        };
        let Way::Products(own, factors) = ways[first.index()] else {
            continue;
        };
        if let Some((sum, factors)) = turned(factors, sum, of) {
            ways[first.index()] = Way::Turn([own, sum], id, factors);
            ways[id.index()] = Way::Inside;
        }
    }
    ways
}

/// A sum with the products that it takes in. All that it reads has to differ: a step borrows each
/// register once.
fn taken_in(program: &Program, node: &Node) -> Option<(Way, [Option<Id>; 2])> {
    let (sum, a, b) = match node.expr {
        Expr::Add(a, b) => (Sum::Plus, a, b),
        Expr::Sub(a, b) => (Sum::Minus, a, b),
        _ => return None,
    };
    let factors = |of: Id| match program.nodes[of.index()] {
        Node {
            expr: Expr::Mul(x, y),
            uses: 1,
            ..
        } => Some([x, y]),
        _ => None,
    };
    if let (Some([x, c]), Some([y, s])) = (factors(a), factors(b))
        && are_apart(&[x, c, y, s])
    {
        return Some((Way::Products(sum, [x, c, y, s]), [Some(a), Some(b)]));
    }
    if let Some([x, y]) = factors(b)
        && are_apart(&[x, y, a])
    {
        let sum = match sum {
            Sum::Minus => Sum::Reverse,
            other => other,
        };
        return Some((Way::Product(sum, [x, y, a]), [Some(b), None]));
    }
    match factors(a) {
        Some([x, y]) if are_apart(&[x, y, b]) => {
            Some((Way::Product(sum, [x, y, b]), [Some(a), None]))
        }
        _ => None,
    }
}

fn are_apart(ids: &[Id]) -> bool {
    let mut rest = ids;
    while let Some((first, others)) = rest.split_first() {
        if others.contains(first) {
            return false;
        }
        rest = others;
    }
    true
}

/// The second sum of the same four factors as one of `x s` and `y c`, the first being of `x c`
/// and `y s`: with the factors in an order that makes it so.
fn turned([x, c, y, s]: [Id; 4], sum: Sum, second: [Id; 4]) -> Option<(Sum, [Id; 4])> {
    let [a, b, d, e] = second;
    let (partner, is_first) = match x {
        _ if x == a => (b, true),
        _ if x == b => (a, true),
        _ if x == d => (e, false),
        _ => (d, false),
    };
    let [y, s] = match partner {
        _ if partner == c => return None,
        _ if partner == y => [s, y],
        _ => [y, s],
    };
    let sum = match sum {
        Sum::Minus if !is_first => Sum::Reverse,
        other => other,
    };
    Some((sum, [x, c, y, s]))
}

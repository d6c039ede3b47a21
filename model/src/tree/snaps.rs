//! How far snapping a joint's rotation to a right angle can move the CoM.

use super::{Motion, Snap, Tree};

/// A snap that moves the CoM by no more moves nothing: less than doubles hold of a robot's size, m.
const NOTHING: f64 = 1e-12;

/// Snaps as lines say them: those that move nothing are one line with the largest errors
/// of all, unless each is wanted.
#[doc(hidden)]
pub fn snapped(snaps: &[Snap], each: bool) -> Vec<Snap> {
    let moves = |snap: &&Snap| each || snap.com_error > NOTHING;
    let (moving, still): (Vec<&Snap>, Vec<&Snap>) = snaps.iter().partition(moves);
    let mut lines: Vec<Snap> = moving.into_iter().cloned().collect();
    let largest = |of: fn(&Snap) -> f64| still.iter().map(|snap| of(snap)).fold(0.0, f64::max);
    lines.extend(still.first().map(|first| Snap {
        joint: match still.len() {
            1 => first.joint.clone(),
            n => format!("{} and {} more", first.joint, n - 1),
        },
        angle_error: largest(|snap| snap.angle_error),
        com_error: largest(|snap| snap.com_error),
    }));
    lines
}

/// What each rotation error can do to the CoM: a lever arm argument.
///
/// Rotating everything beyond edge e by ε about the joint's point moves the CoM
/// by at most ε W_e / M, where W_e sums mass times the longest possible reach.
pub(super) fn snaps(tree: &Tree, errors: &[f64]) -> Vec<Snap> {
    let n = tree.edges.len();
    let mut beyond = vec![0.0; n]; // mass beyond each edge, kg
    let mut reach = vec![0.0; n]; // W_e, kg m
    let mut children: Vec<Vec<usize>> = vec![Vec::new(); tree.links.len()];
    for (e, edge) in tree.edges.iter().enumerate() {
        children[edge.near].push(e);
    }
    for e in (0..n).rev() {
        let edge = &tree.edges[e];
        let link = &tree.links[edge.far];
        beyond[e] = link.mass;
        reach[e] = link.mass * (link.com - edge.offset).norm();
        for &k in &children[edge.far] {
            let child = &tree.edges[k];
            beyond[e] += beyond[k];
            reach[e] += beyond[k] * (child.anchor - edge.offset).norm() + reach[k];
        }
        if let Motion::Prismatic { by, .. } = edge.motion {
            reach[e] += beyond[e] * tree.stroke(&by);
        }
    }
    (0..n)
        .filter(|&e| errors[e] > 0.0)
        .map(|e| Snap {
            joint: tree.edges[e].joint.clone(),
            angle_error: errors[e],
            com_error: errors[e] * reach[e] / tree.mass,
        })
        .collect()
}

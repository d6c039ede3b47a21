//! Motion for the rows of a regressor: with as little noise as can be.
//!
//! ```text
//! E[Xᵀ e] = −E[ε_Xᵀ ε_X] r        where the noise of q, q̇ and q̈ is in rows and readings alike
//! ```
//!
//! Of a window of 2 h the noise of an acceleration has a thirtieth of the square that one of h
//! has, and what both share is no more than that (it is the better estimate of the two). Near the
//! ends and beside a pause a window reaches as far as the log goes on: a few rows as they were read
//! would hold more of the noise than all others together, and rows freed of noise that lasts are
//! differences, which have all of it.

use std::ops::Range;

use super::polynomials::{HIGH, Polynomials};
use super::windows::Nodes;
use super::{Motion, PART, Plan};
use crate::threads::by_parts;

/// Windows are so many times as long.
pub(super) const LONGER: f64 = 2.0;

/// Motion by windows of twice the length: with little noise, and bent where it is fast.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Smooth {
    /// rad or m
    pub q: Vec<f64>,
    /// rad/s or m/s
    pub rates: Vec<f64>,
    /// rad/s² or m/s²
    pub gains: Vec<f64>,
}

impl Smooth {
    /// The motion of `rows` by longer windows; that which is known where those reach no further to either side.
    pub(super) fn of(
        plan: &Plan,
        (t, q): (&[f64], &[f64]),
        known: &Motion,
        rows: Range<usize>,
    ) -> Smooth {
        let (dof, half) = (known.dof(), LONGER * plan.half);
        let nodes = Nodes::of(t, q, dof, plan.step_s, half);
        let first = rows.start;
        let parts = by_parts(rows, PART, |rows| {
            let mut smooth = Smooth::default();
            let mut row = rows.start;
            for own in nodes.of_row[rows].chunk_by(|a, b| a == b) {
                let node = own[0];
                let around = nodes.around(node);
                let fits = nodes.reaches(node, &around, plan.half) && !nodes.are_still(&around);
                let fit = fits.then(|| Polynomials::fit(&nodes, node, around, HIGH));
                let fit = fit.flatten();
                for row in row..row + own.len() {
                    let after = t[row] - nodes.t[node];
                    for joint in 0..dof {
                        let at = (row - first) * dof + joint;
                        let fit = fit.as_ref();
                        // Joints that stand have accelerations without deviation.
                        let [q, rate, gain] = match fit.filter(|_| known.gains_std[at] > 0.0) {
                            Some(fit) => [
                                nodes.position(node, joint) + fit.position(joint, after),
                                fit.rate(joint, after),
                                fit.gain(joint, after),
                            ],
                            None => [q[row * dof + joint], known.rates[at], known.gains[at]],
                        };
                        smooth.q.push(q);
                        smooth.rates.push(rate);
                        smooth.gains.push(gain);
                    }
                }
                row += own.len();
            }
            smooth
        });
        let mut smooth = Smooth::default();
        for own in parts {
            smooth.q.extend(own.q);
            smooth.rates.extend(own.rates);
            smooth.gains.extend(own.gains);
        }
        smooth
    }

    pub(super) fn columns(&mut self) -> [&mut Vec<f64>; 3] {
        let Smooth { q, rates, gains } = self;
        [q, rates, gains]
    }
}

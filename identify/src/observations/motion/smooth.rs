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
use super::windows::{Nodes, Window};
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
        let window = Window::new(&nodes, plan.step_s, half);
        let first = rows.start;
        let parts = by_parts(rows, PART, |rows| {
            let mut smooth = Smooth::default();
            let mut at: Option<(usize, Option<Polynomials>)> = None;
            for row in rows {
                let k = row - first;
                let node = nodes.of_row[row];
                if at.as_ref().is_none_or(|(of, _)| *of != node) {
                    let around = window.around(node);
                    let reaches = window.reaches(node, &around, plan.half);
                    let fit = (reaches && !nodes.are_still(&around))
                        .then(|| Polynomials::fit(&nodes, node, around, half, HIGH));
                    at = Some((node, fit.flatten()));
                }
                let (_, fit) = at.as_ref().expect("set above");
                let (after, own) = (t[row] - nodes.t[node], k * dof..(k + 1) * dof);
                let here = smooth.q.len()..smooth.q.len() + dof;
                smooth.q.extend(&q[row * dof..(row + 1) * dof]);
                smooth.rates.extend(&known.rates[own.clone()]);
                smooth.gains.extend(&known.gains[own.clone()]);
                let Some(fit) = fit else { continue };
                // Joints that stand have accelerations without deviation.
                let stands = |joint: usize| known.gains_std[own.start + joint] <= 0.0;
                let standing: Vec<usize> = (0..dof).filter(|joint| stands(*joint)).collect();
                fit.rates(after, &mut smooth.rates[here.clone()]);
                fit.gains(after, &mut smooth.gains[here.clone()]);
                for (joint, q) in smooth.q[here.clone()].iter_mut().enumerate() {
                    *q = nodes.position(node, joint) + fit.position(joint, after);
                }
                for joint in standing {
                    let (at, of) = (here.start + joint, own.start + joint);
                    smooth.q[at] = q[row * dof + joint];
                    smooth.rates[at] = known.rates[of];
                    smooth.gains[at] = known.gains[of];
                }
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

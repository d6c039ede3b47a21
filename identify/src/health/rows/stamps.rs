//! Stamps that do not go with their rows.
//!
//! ```text
//! J(order) = Σ_j Σ_k (q_j,k+1 − q_j,k)² / 2 n Σ_j Var(q_j)        1 where rows are in any order
//! ```
//!
//! A recording is smooth from row to row. If it is not so from stamp to stamp the stamps are
//! those of other rows; whole rows in another order are smooth from stamp to stamp. Postures
//! that were drawn at random are smooth in neither order, and their stamps say nothing.

use super::LogRows;
use crate::health::criteria::{BACKWARDS, ENOUGH, JUMPS, JUMPS_LESS, OUT_OF_ORDER};
use crate::health::{Finding, Kind, Picture};

pub(super) fn shuffled(rows: &LogRows) -> Option<Finding> {
    let (n, t) = (rows.len(), &rows.t);
    if t.len() != n || n < ENOUGH {
        return None;
    }
    let back = t.windows(2).filter(|pair| pair[1] < pair[0]).count() as f64;
    let part = back / (n - 1) as f64;
    let sentence = match part {
        part if part > BACKWARDS => format!(
            "Stamps run backwards in {:.0} % of the rows: sort the log by time; if its rows are \
             in order and the stamps alone are reversed, mend the stamps or leave `t` out.",
            100.0 * part
        ),
        part if part > OUT_OF_ORDER => {
            let mut by_stamp: Vec<usize> = (0..n).collect();
            by_stamp.sort_by(|a, b| t[*a].total_cmp(&t[*b]));
            let in_order: Vec<usize> = (0..n).collect();
            let [stamped, as_read] = [&by_stamp, &in_order].map(|order| jumps(rows, order));
            if stamped < JUMPS || as_read > JUMPS_LESS * stamped {
                return None;
            }
            format!(
                "Joints move smoothly from row to row and jump from stamp to stamp ({:.0} % of \
                 the rows are stamped before the one above them): stamps and rows do not belong \
                 together; check how `t` was joined, or leave it out.",
                100.0 * part
            )
        }
        _ => return None,
    };
    let back = |k: usize| k > 0 && t[k] < t[k - 1];
    let picture = Picture::of("t, s", n, |k| rows.row(k), |k| t[k], back);
    Some(Finding::new(Kind::RowsShuffled, "t", sentence).showing(picture))
}

/// How far joints jump between rows that follow each other in an order, over what rows in any
/// order do.
fn jumps(rows: &LogRows, order: &[usize]) -> f64 {
    let (mut stepped, mut about) = (0.0, 0.0);
    for joint in 0..rows.dof {
        let at = |row: usize| rows.q(row)[joint];
        let mean = order.iter().map(|&k| at(k)).sum::<f64>() / order.len() as f64;
        about += order.iter().map(|&k| (at(k) - mean).powi(2)).sum::<f64>();
        let steps = order.windows(2).map(|pair| at(pair[1]) - at(pair[0]));
        stepped += steps.map(|step| step * step).sum::<f64>();
    }
    stepped / (2.0 * about).max(f64::MIN_POSITIVE)
}

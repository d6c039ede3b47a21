//! Joints that leap faster than they can, and stamps that do not go with their rows.
//!
//! ```text
//! |Δq| > 3°,  |Δq|/Δt > 1.5 v_limit        of a joint without a limit: > 10 times the median
//! J(order) = Σ_j Σ_k (q_j,k+1 − q_j,k)² / 2 n Σ_j Var(q_j)        1 where rows are in any order
//! ```
//!
//! A recording is smooth from row to row. If it is not so from stamp to stamp the stamps are
//! those of other rows; whole rows in another order are smooth from stamp to stamp. Postures
//! that were drawn at random are smooth in neither order, and their stamps say nothing.

use sesc_model::tree::Dof;

use super::LogRows;
use crate::health::criteria::{ENOUGH, JUMPS, MANY_ROWS, NEARLY_ALL, SHORT_S, TENFOLD};
use crate::health::{Finding, Kind};
use crate::logs::criteria::{FASTER, LEAP};
use crate::observations::noise::quantile;

/// The joint that leaps most often.
pub(super) fn leaps(rows: &LogRows, dofs: &[Dof]) -> Option<Finding> {
    let t = rows.block.t.as_ref()?;
    // How far a joint moves from the row before, and in what time, s.
    let steps = |joint: usize| -> Vec<(f64, f64)> {
        let step = |k: usize| match k.checked_sub(1) {
            Some(before) if rows.number(k) == rows.number(before) + 1 => (
                (rows.q(k)[joint] - rows.q(before)[joint]).abs(),
                t[k] - t[before],
            ),
            _ => (0.0, 0.0),
        };
        (0..rows.len()).map(step).collect()
    };
    let leaps = |joint: usize| -> Vec<usize> {
        let steps = steps(joint);
        let fastest = limit(&dofs[joint]).map(|limit| FASTER * limit);
        let fastest = fastest.unwrap_or_else(|| {
            let moves = steps
                .iter()
                .filter(|(step, time)| *step > 0.0 && *time > 0.0);
            let median = quantile(moves.map(|(step, time)| step / time), 0.5);
            TENFOLD * median.unwrap_or(f64::INFINITY)
        });
        let leaps = |k: &usize| {
            let (step, time) = steps[*k];
            time > 0.0 && time < SHORT_S && step > LEAP && step > fastest * time
        };
        (0..rows.len()).filter(leaps).collect()
    };
    let all = (0..rows.dof).map(|joint| (joint, leaps(joint)));
    let (joint, found) = all.max_by_key(|(joint, found)| (found.len(), rows.dof - joint))?;
    let first = *found.first()?;
    let dof = &dofs[joint];
    let (name, unit) = (&dof.joint, if dof.prismatic { "m" } else { "rad" });
    let than = match limit(dof) {
        Some(limit) => format!("its limit is {limit} {unit}/s"),
        None => "it moves ten times slower otherwise".to_string(),
    };
    let steps = steps(joint);
    let (distance, time) = steps[first];
    let sentence = format!(
        "Joint `{name}` moves by {distance:.2} {unit} in {:.0} ms in row {} ({} such rows; {than}): two \
         senders on one topic, a glitch of the bus, angles that wrap, or stamps of other rows; \
         leave these rows out, or mend `t`.",
        1e3 * time,
        rows.number(first),
        found.len()
    );
    let speed = |k: usize| steps[k].0 / steps[k].1.max(1e-9);
    let about = (Kind::JointLeaps, name.as_str(), sentence);
    let is_leap = |k: usize| found.binary_search(&k).is_ok();
    Some(rows.finding(about, &format!("Speed of {name}, {unit}/s"), speed, is_leap))
}

/// The velocity limit that the URDF gives a joint, rad/s or m/s.
fn limit(dof: &Dof) -> Option<f64> {
    Some(dof.speed).filter(|speed| speed.is_finite() && *speed > 0.0)
}

pub(super) fn stamps_of_other_rows(rows: &LogRows) -> Option<Finding> {
    let (n, t) = (rows.len(), rows.block.t.as_ref()?);
    if n < ENOUGH {
        return None;
    }
    let back = |k: usize| k > 0 && t[k] < t[k - 1];
    let part = (0..n).filter(|k| back(*k)).count() as f64 / (n - 1) as f64;
    if part <= MANY_ROWS {
        return None;
    }
    let percent = 100.0 * part;
    let mut sentence = format!(
        "Stamps run backwards in {percent:.0} % of the rows: sort the log by time; if its rows are \
         in order and the stamps alone are reversed, mend the stamps or leave `t` out."
    );
    if part <= NEARLY_ALL {
        let in_order: Vec<usize> = (0..n).collect();
        let mut by_stamp = in_order.clone();
        by_stamp.sort_by(|a, b| t[*a].total_cmp(&t[*b]));
        let [stamped, as_read] = [&by_stamp, &in_order].map(|order| jumps(rows, order));
        if stamped < JUMPS || as_read > JUMPS * stamped {
            return None;
        }
        sentence = format!(
            "Joints move smoothly from row to row and jump from stamp to stamp ({percent:.0} % of \
             the rows are stamped before the one above them): stamps and rows do not belong \
             together; check how `t` was joined, or leave it out."
        );
    }
    Some(rows.finding((Kind::RowsShuffled, "t", sentence), "t, s", |k| t[k], back))
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

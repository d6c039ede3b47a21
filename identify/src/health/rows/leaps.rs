//! Joints that leap faster than they can.
//!
//! ```text
//! |Δq| > 3°,  |Δq|/Δt > 1.5 v_limit        of a joint without a limit: > 10 times the median
//! ```

use super::LogRows;
use crate::health::criteria::{SHORT_S, TIMES_MEDIAN};
use crate::health::{Finding, Kind, Picture};
use crate::logs::criteria::{FASTER, LEAP};
use sesc_model::tree::Dof;

/// The joint that leaps most often.
pub(super) fn of(rows: &LogRows, dofs: &[Dof]) -> Option<Finding> {
    if rows.t.len() != rows.len() {
        return None;
    }
    let leaps = |joint: usize| {
        let fastest = fastest(rows, joint, &dofs[joint]);
        let leaps = move |k: &usize| {
            let (step, time) = step(rows, joint, *k);
            time > 0.0 && time < SHORT_S && step > LEAP && step > fastest * time
        };
        (1..rows.len()).filter(leaps).collect::<Vec<usize>>()
    };
    let all = (0..rows.dof).map(|joint| (joint, leaps(joint)));
    let (joint, found) = all.max_by_key(|(joint, found)| (found.len(), rows.dof - joint))?;
    let first = *found.first()?;
    let (step, time) = step(rows, joint, first);
    let (name, limit) = (&dofs[joint].joint, dofs[joint].speed);
    let unit = if dofs[joint].prismatic { "m" } else { "rad" };
    let than = match limit.is_finite() && limit > 0.0 {
        true => format!("its limit is {limit} {unit}/s"),
        false => "it moves ten times slower otherwise".to_string(),
    };
    let sentence = format!(
        "Joint `{name}` moves by {step:.2} {unit} in {:.0} ms in row {} ({} such rows; {than}): two \
         senders on one topic, a glitch of the bus, angles that wrap, or stamps of other rows; \
         leave these rows out, or mend `t`.",
        1e3 * time,
        rows.number[first],
        found.len()
    );
    let speed = |k: usize| match k.checked_sub(1) {
        Some(_) => {
            let (step, time) = self::step(rows, joint, k);
            step / time.max(1e-9)
        }
        None => 0.0,
    };
    let picture = Picture::of(
        &format!("Speed of {name}, {unit}/s"),
        rows.len(),
        |k| rows.row(k),
        speed,
        |k| found.binary_search(&k).is_ok(),
    );
    Some(Finding::new(Kind::JointLeaps, name, sentence).showing(picture))
}

/// How far a joint moves from the row before, and in what time, s.
fn step(rows: &LogRows, joint: usize, row: usize) -> (f64, f64) {
    let q = |row: usize| rows.q(row)[joint];
    let follows = rows.number[row] == rows.number[row - 1] + 1;
    let time = if follows {
        rows.t[row] - rows.t[row - 1]
    } else {
        0.0
    };
    ((q(row) - q(row - 1)).abs(), time)
}

/// What a joint cannot exceed, rad/s or m/s.
fn fastest(rows: &LogRows, joint: usize, dof: &Dof) -> f64 {
    if dof.speed.is_finite() && dof.speed > 0.0 {
        return FASTER * dof.speed;
    }
    let moves = (1..rows.len()).map(|k| step(rows, joint, k));
    let moves = moves.filter(|(step, time)| *step > 0.0 && *time > 0.0);
    let mut speeds: Vec<f64> = moves.map(|(step, time)| step / time).collect();
    speeds.sort_by(f64::total_cmp);
    speeds
        .get(speeds.len() / 2)
        .map_or(f64::INFINITY, |median| TIMES_MEDIAN * median)
}

//! Encoders that stop in the middle of a log though their joint moves on.
//!
//! ```text
//! q_j = const over a run of rows in which other joints move, and moves elsewhere
//! ‖y − p(q)‖ of the run ≫ ‖y − p(q)‖ of the other rows, and motion of j explains it (`encoders`)
//! ```
//!
//! Over the log as a whole such an encoder moves. A joint that is really held for a while leaves
//! no more in that time than in the rest, whatever effects are hidden; rows of a run in which it
//! is not held are left out.

use sesc_model::{Model, Snapping};

use super::criteria::{LEAST_MOTION, PARKED_ROWS, PARKED_SHARE, PARKED_WORSE, STILL};
use super::encoders::{UNITS, of_joint};
use super::rows::{LeftOut, LogRows, Parked, standing};
use super::{Finding, Kind, Picture, Views, stuck};
use crate::observations::postures::range;
use crate::robot::Robot;

/// Rows of a run, and of the others, that are compared, at most.
const LOOKED: usize = 500;

/// The encoder that stops, if there is one; its rows are left out.
pub(super) fn stretch(
    rows: &LogRows,
    (robot, model): (&Robot, &Model),
    left_out: &mut LeftOut,
) -> Option<Finding> {
    let kept = rows.kept(left_out);
    let least = PARKED_ROWS.max((PARKED_SHARE * kept.len() as f64).ceil() as usize);
    let moves = |joint: usize, among: &mut dyn Iterator<Item = usize>| {
        let (low, high) = range(among.map(|k| rows.q(k)[joint]));
        high - low > of_joint(&model.tree.dofs[joint], LEAST_MOTION)
    };
    for joint in 0..rows.dof {
        let (from, to) = longest(rows, &kept, joint);
        let run = &kept[from..to];
        let others = || kept[..from].iter().chain(&kept[to..]).copied();
        let other_moves = || {
            let mut others = (0..rows.dof).filter(|other| *other != joint);
            others.any(|other| moves(other, &mut run.iter().copied()))
        };
        if run.len() < least || !moves(joint, &mut others()) || !other_moves() {
            continue;
        }
        let others: Vec<usize> = others().collect();
        let (read, still) = standing::postures(rows, &some(&others), model);
        let gap_of_others = Views::of(robot, model, &read, still.as_ref()).gap;
        let (read, still) = standing::postures(rows, &some(run), model);
        let views = Views::of(robot, model, &read, still.as_ref());
        let gap = views.gap;
        if gap < PARKED_WORSE * gap_of_others {
            continue;
        }
        let found = stuck(robot, model, Snapping::default(), &views);
        if found.is_none_or(|(_, found)| found.joint != joint) {
            continue;
        }
        let at = rows.q(run[0])[joint];
        left_out.parked.push(Parked { joint, at });
        return Some(finding(rows, model, (joint, at), run, [gap, gap_of_others]));
    }
    None
}

/// The longest run among `kept` rows, by their places there, in which a joint does not move.
fn longest(rows: &LogRows, kept: &[usize], joint: usize) -> (usize, usize) {
    let (mut longest, mut from) = ((0, 0), 0);
    for k in 0..kept.len() {
        if (rows.q(kept[k])[joint] - rows.q(kept[from])[joint]).abs() > STILL {
            from = k;
        }
        if k + 1 - from > longest.1 - longest.0 {
            longest = (from, k + 1);
        }
    }
    longest
}

/// Some of the rows, evenly chosen.
fn some(rows: &[usize]) -> Vec<usize> {
    let stride = rows.len().div_ceil(LOOKED).max(1);
    rows.iter().copied().step_by(stride).collect()
}

fn finding(
    rows: &LogRows,
    model: &Model,
    (joint, at): (usize, f64),
    run: &[usize],
    [gap, of_others]: [f64; 2],
) -> Finding {
    let dof = &model.tree.dofs[joint];
    let parked = |k: usize| (rows.q(k)[joint] - at).abs() <= STILL;
    let count = (0..rows.len()).filter(|&k| parked(k)).count();
    let sentence = format!(
        "The encoder of {} stops in {} (the longest stretch is rows {} to {}) while other joints \
         and the CoP move as if the joint did: there CAD is {:.1} mm off, elsewhere {:.1} mm. \
         Rows with this position are left out; check its cable.",
        dof.joint,
        rows.some(count),
        rows.number[run[0]],
        rows.number[run[run.len() - 1]],
        1e3 * gap,
        1e3 * of_others
    );
    let (unit, per_unit) = of_joint(dof, UNITS);
    let title = format!("{} by its encoder, {unit}", dof.joint);
    let position = |k: usize| per_unit * rows.q(k)[joint];
    let row = |k: usize| rows.row(k);
    let picture = Picture::of(&title, rows.len(), row, position, parked);
    Finding::new(Kind::EncoderStuck, &dof.joint, sentence).showing(picture)
}

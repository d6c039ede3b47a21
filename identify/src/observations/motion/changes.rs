//! How accelerations change in time: parabolas through those of the rows around each row.
//!
//! ```text
//! b, f: slopes to the first and to the last row, at −a and +c        |a|, |c| ≤ reach
//! d³q/dt³ = (c b + a f)/(a + c)        d⁴q/dt⁴ = 2 (f − b)/(a + c)
//! ```

use super::Motion;
use crate::observations::correlation::GAP;
use crate::observations::criteria::accelerations::REACH_S;

/// How far a parabola through rows `step_s` apart reaches to either side, s; 0 where rows are too
/// far apart.
pub(super) fn reach(step_s: f64) -> f64 {
    if step_s > 2.0 * REACH_S {
        return 0.0;
    }
    REACH_S.max(1.5 * step_s)
}

/// Find the changes of the accelerations in rows at times `t`; left zero where a row has a neighbour
/// of known motion on one side alone, and where rows are too far apart.
pub(super) fn find(motion: &mut Motion, t: &[f64], step_s: f64) {
    let dof = motion.dof();
    let reach = reach(step_s);
    let joins = |a: usize, b: usize| t[b] > t[a] && t[b] - t[a] <= GAP * step_s;
    for k in 0..t.len() {
        let near = |row: usize| motion.known[row] && (t[row] - t[k]).abs() <= reach;
        let (mut first, mut last) = (k, k);
        while first > 0 && joins(first - 1, first) && near(first - 1) {
            first -= 1;
        }
        while last + 1 < t.len() && joins(last, last + 1) && near(last + 1) {
            last += 1;
        }
        if first == k || last == k || !motion.known[k] {
            continue;
        }
        let (a, c) = (t[k] - t[first], t[last] - t[k]);
        for joint in 0..dof {
            let at = |row: usize| motion.gains[row * dof + joint];
            let (back, forth) = ((at(k) - at(first)) / a, (at(last) - at(k)) / c);
            motion.jerks[k * dof + joint] = (c * back + a * forth) / (a + c);
            motion.snaps[k * dof + joint] = 2.0 * (forth - back) / (a + c);
        }
    }
}

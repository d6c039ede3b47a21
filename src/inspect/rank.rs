//! Numeric ranks of regressor rows, which confirm those by structure.
//!
//! ```text
//! D_j = rows(q with another q_j) − rows(q)        Σ x_c column_c(q) = 0 for all q   ⇒   D_j x = 0
//! ```
//!
//! A joint changes the columns of what lies beyond it, and no others. Where its own columns
//! are the only ones that are not yet known to be independent, and `D_j` has full rank in
//! them, they are independent of all the others: outermost joints first, that takes two or
//! three columns at a time. What is left, the columns that nothing moves and those of joints
//! that are tied to each other, is counted by the pivots of rows over many postures.

use sesc_identify::evaluate::Evaluator;
use sesc_identify::threads::each;
use sesc_model::tree::{Coordinate, Motion};
use sesc_model::{Function, Model, numeric};

use serde::Serialize;

/// Pivots below this, relative to the largest, count as dependent columns; changes below it,
/// as none.
const RANK_TOLERANCE: f64 = 1e-12;
/// Pivots tell a rank if the last one that counts is so many times the next one.
const GAP: f64 = 1e3;
/// Columns that a joint changes are surely independent with no pivot below this.
const SURE: f64 = 1e-6;
/// Positions that each joint takes while the others stand: one of each scale of
/// [`numeric::wide_postures`].
const POSITIONS: usize = 3;
/// Joints whose rows are held at a time.
const JOINTS: usize = 32;

/// Ranks of stacked regressor rows.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Rank {
    /// From three-dimensional CoM rows.
    pub xyz: usize,
    /// From flat CoP rows.
    pub cop: usize,
}

/// What numeric ranks say of those by structure.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
pub enum RankCheck {
    /// They are the same.
    Agrees,
    /// Pivots shrink without a gap: they tell no rank.
    Undecided,
    /// They are others.
    Contradicts,
}

/// Ranks of the regressor the program computes, and what they say of the ranks by structure.
pub fn numeric_rank(model: &Model) -> (Rank, RankCheck) {
    let functions = [
        (Function::Regressor, 3, model.base.params.len()),
        (Function::RegressorCop, 2, model.base.rank_cop),
    ];
    let confirm = |(function, rows, expected)| confirmed(model, function, rows, expected);
    let found = each(usize::MAX, functions, confirm);
    let rank = Rank {
        xyz: found[0].0,
        cop: found[1].0,
    };
    (rank, found[0].1.max(found[1].1))
}

/// The rank of the `rows` rows of `function`, where the structure has `expected`.
fn confirmed(
    model: &Model,
    function: Function,
    rows: usize,
    expected: usize,
) -> (usize, RankCheck) {
    let evaluator = Evaluator::new(model, function);
    let rest = undecided(model, &evaluator, rows);
    let alone = model.base.params.len() - rest.len();
    let count = numeric::enough(rest.len(), rows);
    let postures = numeric::wide_postures(&model.chain, &model.tree.dofs, count);
    let mut values = Vec::with_capacity(count * rows * rest.len());
    for some in postures.chunks(POSITIONS * JOINTS) {
        let all = evaluator.run(&some.concat(), some.len());
        for row in all.chunks(model.base.params.len().max(1)) {
            values.extend(rest.iter().map(|&c| row[c]));
        }
    }
    let pivots = numeric::pivots(&values, rest.len());
    let (rank, check) = counted(&pivots, expected.saturating_sub(alone));
    match alone <= expected {
        true => (alone + rank, check),
        false => (alone + rank, RankCheck::Contradicts),
    }
}

/// Columns that are not seen to be independent of all others by moving one joint at a time.
fn undecided(model: &Model, evaluator: &Evaluator, rows: usize) -> Vec<usize> {
    let params = model.base.params.len();
    let wide = numeric::wide_postures(&model.chain, &model.tree.dofs, 1 + POSITIONS);
    let here = &wide[0];
    let still = evaluator.run(here, 1);
    let mut open = vec![true; params];
    for joints in outermost_first(model).chunks(JOINTS) {
        let mut moved = here.repeat(joints.len() * POSITIONS);
        let places = joints
            .iter()
            .flat_map(|&j| (1..=POSITIONS).map(move |k| (j, k)));
        for (q, (j, k)) in moved.chunks_mut(model.dof()).zip(places) {
            q[j] = wide[k][j];
        }
        let mut values = evaluator.run(&moved, joints.len() * POSITIONS);
        for values in values.chunks_mut(POSITIONS * rows * params) {
            let mut most = vec![0.0_f64; params];
            for there in values.chunks_mut(rows * params) {
                there.iter_mut().zip(&still).for_each(|(x, x0)| *x -= x0);
                for row in there.chunks(params) {
                    let each = most.iter_mut().zip(row);
                    each.for_each(|(most, x)| *most = most.max(x.abs()));
                }
            }
            let largest = most.iter().fold(0.0_f64, |a, &b| a.max(b));
            let moves = |c: usize| most[c] > RANK_TOLERANCE * largest;
            let own: Vec<usize> = (0..params).filter(|&c| open[c] && moves(c)).collect();
            if own.is_empty() || own.len() > POSITIONS * rows {
                continue;
            }
            let rows = values.chunks(params);
            let matrix: Vec<f64> = rows.flat_map(|row| own.iter().map(|&c| row[c])).collect();
            let pivots = numeric::pivots(&matrix, own.len());
            if pivots.len() == own.len() && pivots.iter().all(|&p| p > SURE) {
                own.iter().for_each(|&c| open[c] = false);
            }
        }
    }
    (0..params).filter(|&c| open[c]).collect()
}

/// Independent joints: those beyond others before these.
fn outermost_first(model: &Model) -> Vec<usize> {
    let mut first = vec![0; model.dof()];
    for (i, body) in model.chain.bodies.iter().enumerate().rev() {
        if let Motion::Revolute { by, .. } | Motion::Prismatic { by, .. } = body.motion {
            let Coordinate { dof, .. } = by;
            first[dof] = i;
        }
    }
    let mut joints: Vec<usize> = (0..model.dof()).collect();
    joints.sort_by_key(|&j| std::cmp::Reverse(first[j]));
    joints
}

/// Pivots above the tolerance, and whether there are `expected` ones. Pivots that shrink to the
/// tolerance without a gap, as those of hundreds of joints that follow one, tell no rank.
fn counted(pivots: &[f64], expected: usize) -> (usize, RankCheck) {
    let rank = pivots.iter().filter(|&&p| p > RANK_TOLERANCE).count();
    let last = rank.checked_sub(1).map_or(1.0, |k| pivots[k]);
    let next = pivots.get(rank).copied().unwrap_or(0.0);
    let check = match rank == expected {
        true => RankCheck::Agrees,
        false if last <= GAP * next => RankCheck::Undecided,
        false => RankCheck::Contradicts,
    };
    (rank, check)
}

#[cfg(test)]
mod tests {
    use super::*;

    use sesc_identify::robot::{Robot, Stance};

    #[test]
    fn pivots_contradict_a_count_only_where_they_have_a_gap() {
        let clear = [1.0, 0.5, 1e-3, 1e-16];
        assert_eq!(counted(&clear, 3), (3, RankCheck::Agrees));
        assert_eq!(counted(&clear, 4), (3, RankCheck::Contradicts));
        assert_eq!(counted(&clear, 2), (3, RankCheck::Contradicts));
        assert_eq!(counted(&clear[..3], 4), (3, RankCheck::Contradicts));
        let smooth: Vec<f64> = (0..20).map(|k| 10_f64.powi(-k)).collect();
        let (rank, check) = counted(&smooth, 16);
        assert_eq!((rank < 16, check), (true, RankCheck::Undecided));
        assert_eq!(counted(&[], 0), (0, RankCheck::Agrees));
        assert_eq!(counted(&[], 1), (0, RankCheck::Contradicts));
    }

    fn quadruped() -> Model {
        let urdf = include_str!("../../robots/quadruped/quadruped.urdf");
        let robot = Robot::parse(urdf, "quadruped.urdf").unwrap();
        Stance::new(robot).on("lf_foot").model().unwrap()
    }

    /// Without mimics, only the columns of r_0 are left to be counted by pivots.
    #[test]
    fn moving_one_joint_at_a_time_decides_all_columns_that_move() {
        let model = quadruped();
        for (function, rows) in [(Function::Regressor, 3), (Function::RegressorCop, 2)] {
            let rest = undecided(&model, &Evaluator::new(&model, function), rows);
            assert_eq!(rest, [0, 1, 2]);
        }
    }

    #[test]
    fn a_column_that_is_there_twice_contradicts() {
        let sound = quadruped();
        let columns = sound.base.params.len();
        let cop = sound.base.rank_cop;
        assert_eq!(numeric_rank(&sound).1, RankCheck::Agrees);
        for k in 1..columns {
            let mut model = sound.clone();
            let params = &mut model.robot.base.params;
            params[k].column = params[k - 1].column;
            let (rank, check) = numeric_rank(&model);
            assert_eq!(check, RankCheck::Contradicts, "{k}");
            // The height is no column of a CoP: where it is lost, nothing of that is.
            let lost = usize::from(k != 2);
            assert_eq!((rank.xyz, rank.cop), (columns - 1, cop - lost), "{k}");
        }
    }
}

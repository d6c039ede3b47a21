//! What mimic joints tie together: base columns that are linear combinations of
//! others, found numerically on the tied part of the tree.
//!
//! Postures go through several scales, so that slow followers move too; columns
//! are compared by Gram–Schmidt in preorder, and a dependent one is regrouped
//! into those it depends on.

use nalgebra::{DMatrix, DVector, Vector3};

use crate::chain::{Body, Chain};
use crate::frames::Frame;
use crate::numeric;
use crate::tree::Tree;

use super::types::{BaseParam, Column, Unobservable, add};

/// Pivots below this, relative to the column's norm, mean dependence.
const DEPENDENT: f64 = 1e-12;

/// Bodies whose columns mimic joints could make dependent: everything above or
/// below a tied joint. Elsewhere the averaging argument holds joint by joint.
fn tied_bodies(tree: &Tree, chain: &Chain) -> Vec<bool> {
    let mut users = vec![0; tree.dofs.len()];
    for by in chain.bodies.iter().filter_map(|b| b.motion.coordinate()) {
        users[by.dof] += 1;
    }
    let shared = |body: &Body| body.motion.coordinate().is_some_and(|by| users[by.dof] > 1);
    let mut tied: Vec<bool> = chain.bodies.iter().map(shared).collect();
    for i in 1..chain.bodies.len() {
        tied[i] |= chain.bodies[i].parent.is_some_and(|p| tied[p]);
    }
    for i in (1..chain.bodies.len()).rev() {
        if let (true, Some(p)) = (tied[i], chain.bodies[i].parent) {
            tied[p] = true;
        }
    }
    tied
}

/// Regroup columns that tied angles make linear combinations of earlier ones.
///
/// Returns what was dropped, each with the largest part of its column that the
/// others do not make up.
pub(super) fn untie(
    tree: &Tree,
    chain: &Chain,
    frames: &[Frame],
    params: &mut Vec<BaseParam>,
    unobservable: &mut Vec<Unobservable>,
) -> Vec<(BaseParam, f64)> {
    let tied = tied_bodies(tree, chain);
    let suspects: Vec<usize> = (0..params.len())
        .filter(|&k| match params[k].column {
            Column::Axis { body, .. } | Column::Prismatic { body } => tied[body],
        })
        .collect();
    let mut lost_params = Vec::new();
    if suspects.is_empty() {
        return lost_params;
    }
    let columns: Vec<Column> = suspects.iter().map(|&k| params[k].column).collect();
    let rows = sampled(tree, chain, frames, &columns, &[0, 1, 2]);
    let mut dropped = vec![false; params.len()];
    for (k, dependence) in dependencies(&rows).into_iter().enumerate() {
        let Some(Dependence { weights, rest }) = dependence else {
            continue;
        };
        let lost = params[suspects[k]].clone();
        dropped[suspects[k]] = true;
        for (j, weight) in weights {
            add(&mut params[suspects[j]].terms, &lost.terms, weight);
        }
        unobservable.push(Unobservable {
            sentence: format!(
                "`{}` cannot be told from earlier parameters: mimic joints tie its angle to theirs",
                lost.name
            ),
            name: format!("tied {}", lost.name),
            only_from_cop: false,
        });
        lost_params.push((lost, rest));
    }
    let mut keep = dropped.iter().map(|d| !d);
    params.retain(|_| keep.next().unwrap_or(true));
    lost_params
}

/// Values of the given columns over enough postures: (rows · postures) × columns.
fn sampled(
    tree: &Tree,
    chain: &Chain,
    frames: &[Frame],
    columns: &[Column],
    rows: &[usize],
) -> DMatrix<f64> {
    let count = numeric::enough(columns.len(), rows.len());
    let mut stacked = DMatrix::zeros(rows.len() * count, columns.len());
    for (n, q) in numeric::wide_postures(chain, &tree.dofs, count)
        .iter()
        .enumerate()
    {
        let full = numeric::full_regressor(chain, q);
        for (c, column) in columns.iter().enumerate() {
            let value: Vector3<f64> = match *column {
                Column::Axis { body, axis } => {
                    let b = full.fixed_view::<3, 3>(0, chain.bodies[body].column);
                    b * frames[body].axes.column(axis)
                }
                Column::Prismatic { body } => full
                    .column(chain.bodies[body].column + 3)
                    .fixed_rows::<3>(0)
                    .into_owned(),
            };
            for (k, &row) in rows.iter().enumerate() {
                stacked[(rows.len() * n + k, c)] = value[row];
            }
        }
    }
    stacked
}

/// A column made up of earlier ones.
struct Dependence {
    /// Earlier column, and its weight.
    weights: Vec<(usize, f64)>,
    /// Twice the largest entry they leave (twice, for postures between the samples).
    rest: f64,
}

/// For each column, what it depends on, if it does.
///
/// Gram–Schmidt in the given order, every projection made twice.
fn dependencies(rows: &DMatrix<f64>) -> Vec<Option<Dependence>> {
    let mut basis: Vec<DVector<f64>> = Vec::new();
    let mut triangle: Vec<DVector<f64>> = Vec::new(); // kept columns in the basis
    let mut kept: Vec<usize> = Vec::new();
    (0..rows.ncols())
        .map(|c| {
            let mut rest = rows.column(c).into_owned();
            let norm = rest.norm();
            let mut weights = DVector::zeros(kept.len());
            for _ in 0..2 {
                for (k, q) in basis.iter().enumerate() {
                    let w = q.dot(&rest);
                    weights[k] += w;
                    rest.axpy(-w, q, 1.0);
                }
            }
            if rest.norm() > DEPENDENT * norm {
                let length = rest.norm();
                basis.push(rest / length);
                let mut column = weights.push(length);
                column.resize_vertically_mut(basis.len(), 0.0);
                triangle.push(column);
                kept.push(c);
                return None;
            }
            // Back substitution through the kept columns.
            let mut solved = Vec::new();
            for k in (0..kept.len()).rev() {
                let w = weights[k] / triangle[k][k];
                for m in 0..k {
                    weights[m] -= w * triangle[k][m];
                }
                if libm::fabs(w) > 1e-10 {
                    solved.push((kept[k], w));
                }
            }
            Some(Dependence {
                weights: solved,
                rest: 2.0 * rest.amax(),
            })
        })
        .collect()
}

/// How many of the `visible` columns tied angles hide in the x and y rows.
pub(super) fn tied_in_cop(
    tree: &Tree,
    chain: &Chain,
    frames: &[Frame],
    mut visible: Vec<Column>,
) -> usize {
    let tied = tied_bodies(tree, chain);
    visible.retain(|column| match *column {
        Column::Axis { body, .. } | Column::Prismatic { body } => tied[body],
    });
    if visible.is_empty() {
        return 0;
    }
    let rows = sampled(tree, chain, frames, &visible, &[0, 1]);
    dependencies(&rows).iter().flatten().count()
}

//! Base parameters: the combinations of full parameters that data can see.
//!
//! A turning joint leaves its axis `a` where it is in the parent, so the part
//! of r_i along `a` cannot be told from the same vector in the parent's r: it
//! moves there, and 2 parameters stay. A sliding joint leaves the whole
//! orientation alone: all of r_i moves, one s_i stays. r_0 keeps 3. Working
//! from the leaves to the root gives 3 + 2 (turning) + 1 (sliding) columns.
//!
//! These columns are linearly independent as functions of posture when every
//! joint is independent: averaging over one joint's angle removes its own
//! columns and leaves those outside its subtree. Mimic joints tie angles
//! together and may lower the rank; the columns of the tied part of the tree
//! are therefore also compared numerically, and the dependent ones regrouped.

use std::collections::BTreeMap;

use nalgebra::{DMatrix, DVector, Vector3};

use crate::chain::Chain;
use crate::frames::Frame;
use crate::numeric;
use crate::snap::tidy;
use crate::tree::{Motion, Tree};

/// Pivots below this, relative to the column's norm, mean dependence.
const DEPENDENT: f64 = 1e-12;

/// Which column of the regressor a base parameter multiplies.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Column {
    /// Canonical axis `axis` of body `body` in the support frame.
    Axis { body: usize, axis: usize },
    /// `B_parent a q` of the sliding body.
    Slide { body: usize },
}

/// One base parameter: a linear combination of full parameters.
#[derive(Debug, Clone)]
pub struct BaseParam {
    pub name: String,
    pub column: Column,
    /// Full parameter → weight; the parameter is their weighted sum.
    pub terms: BTreeMap<usize, f64>,
    /// CAD value, m (or a mass fraction for a slide).
    pub cad: f64,
}

/// A direction in parameter space that leaves the measurement unchanged.
#[derive(Debug, Clone)]
pub struct Unobservable {
    pub name: String,
    pub sentence: String,
    /// Seen from three-dimensional CoM data at least.
    pub only_from_cop: bool,
}

/// Base parameters, in preorder of bodies.
#[derive(Debug, Clone)]
pub struct Base {
    pub params: Vec<BaseParam>,
    pub unobservable: Vec<Unobservable>,
    /// Rank of stacked CoP rows (x and y), by structure.
    pub rank_cop: usize,
    /// What regrouping columns that are dependent up to rounding moves the CoM, m.
    pub regrouping_error: f64,
}

/// A vector of linear forms in the full parameters.
type Forms = [BTreeMap<usize, f64>; 3];

/// Group the columns of `chain` into base parameters.
pub fn group(tree: &Tree, chain: &Chain, frames: &[Frame]) -> Base {
    let mut forms: Vec<Forms> = chain
        .bodies
        .iter()
        .map(|body| [0, 1, 2].map(|k| BTreeMap::from([(body.column + k, 1.0)])))
        .collect();
    let mut own: Vec<Vec<BaseParam>> = vec![Vec::new(); chain.bodies.len()];
    let mut unobservable = Vec::new();
    for (i, body) in chain.bodies.iter().enumerate().rev() {
        let form = std::mem::take(&mut forms[i]);
        let param = |name: String, column, terms| BaseParam {
            name,
            column,
            terms,
            cad: 0.0,
        };
        let moved: Vec<Vector3<f64>> = match (body.motion, body.parent) {
            (Motion::Turn { .. }, Some(_)) => {
                for k in [0, 1] {
                    let name = format!("{}.{}", body.name, frames[i].axis_name(k));
                    let terms = project(&form, &frames[i].axes.column(k).into_owned());
                    own[i].push(param(name, Column::Axis { body: i, axis: k }, terms));
                }
                vec![frames[i].axes.column(2).into_owned()]
            }
            (Motion::Slide { .. }, Some(_)) => {
                let terms = BTreeMap::from([(body.column + 3, 1.0)]);
                own[i].push(param(
                    format!("{}.s", body.name),
                    Column::Slide { body: i },
                    terms,
                ));
                (0..3).map(|k| Vector3::ith(k, 1.0)).collect()
            }
            _ => {
                for (k, axis) in ["x", "y", "z"].into_iter().enumerate() {
                    let name = format!("{}.{axis}", body.name);
                    own[i].push(param(
                        name,
                        Column::Axis { body: i, axis: k },
                        form[k].clone(),
                    ));
                }
                Vec::new()
            }
        };
        let Some(parent) = body.parent else { continue };
        for axis in &moved {
            let along = project(&form, axis);
            let there = (body.rotation * axis).map(tidy);
            for (k, sum) in forms[parent].iter_mut().enumerate() {
                add(sum, &along, there[k]);
            }
        }
        unobservable.push(moved_to_parent(chain, i, parent));
    }
    unobservable.reverse();
    let mut params: Vec<BaseParam> = own.into_iter().flatten().collect();
    let dropped = untie(tree, chain, frames, &mut params, &mut unobservable);
    let cad = chain.full_cad();
    let value =
        |terms: &BTreeMap<usize, f64>| -> f64 { terms.iter().map(|(&k, w)| w * cad[k]).sum() };
    let regrouping_error = dropped
        .iter()
        .map(|(lost, rest)| libm::fabs(value(&lost.terms)) * rest)
        .sum();
    for param in &mut params {
        param.cad = value(&param.terms);
    }
    let invisible = invisible_in_cop(tree, chain, frames, &params, &mut unobservable);
    Base {
        rank_cop: params.len() - invisible,
        regrouping_error,
        params,
        unobservable,
    }
}

fn project(form: &Forms, axis: &Vector3<f64>) -> BTreeMap<usize, f64> {
    let mut sum = BTreeMap::new();
    for k in 0..3 {
        add(&mut sum, &form[k], axis[k]);
    }
    sum
}

fn add(sum: &mut BTreeMap<usize, f64>, terms: &BTreeMap<usize, f64>, weight: f64) {
    if weight == 0.0 {
        return;
    }
    for (&k, w) in terms {
        *sum.entry(k).or_insert(0.0) += w * weight;
    }
}

fn moved_to_parent(chain: &Chain, i: usize, parent: usize) -> Unobservable {
    let (body, parent) = (&chain.bodies[i], &chain.bodies[parent]);
    let joint = body.joint.as_deref().unwrap_or_default();
    let (name, sentence) = match body.motion {
        Motion::Slide { .. } => (
            format!("r of {}", body.name),
            format!(
                "r of `{}` moves to its parent `{}`: sliding joint `{joint}` never turns it",
                body.name, parent.name
            ),
        ),
        _ => (
            format!("axis of {joint}"),
            format!(
                "r of `{}` along the axis of `{joint}` moves to its parent `{}`: \
                 turning about that axis leaves it unchanged",
                body.name, parent.name
            ),
        ),
    };
    Unobservable {
        name,
        sentence,
        only_from_cop: false,
    }
}

/// Bodies whose columns mimic joints could make dependent: everything above or
/// below a tied joint. Elsewhere the averaging argument holds joint by joint.
fn tied_bodies(tree: &Tree, chain: &Chain) -> Vec<bool> {
    let mut users = vec![0; tree.dofs.len()];
    let by = |motion: &Motion| match motion {
        Motion::Turn { by, .. } | Motion::Slide { by, .. } => Some(by.dof),
        Motion::Fixed => None,
    };
    for dof in chain.bodies.iter().filter_map(|b| by(&b.motion)) {
        users[dof] += 1;
    }
    let shared = |i: usize| by(&chain.bodies[i].motion).is_some_and(|dof| users[dof] > 1);
    let mut tied: Vec<bool> = (0..chain.bodies.len()).map(shared).collect();
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
fn untie(
    tree: &Tree,
    chain: &Chain,
    frames: &[Frame],
    params: &mut Vec<BaseParam>,
    unobservable: &mut Vec<Unobservable>,
) -> Vec<(BaseParam, f64)> {
    let tied = tied_bodies(tree, chain);
    let suspects: Vec<usize> = (0..params.len())
        .filter(|&k| match params[k].column {
            Column::Axis { body, .. } | Column::Slide { body } => tied[body],
        })
        .collect();
    let mut lost_params = Vec::new();
    if suspects.is_empty() {
        return lost_params;
    }
    let columns: Vec<Column> = suspects.iter().map(|&k| params[k].column).collect();
    let rows = sampled(tree, chain, frames, &columns, &[0, 1, 2]);
    let mut dropped = vec![false; params.len()];
    for (k, weights) in dependencies(&rows).into_iter().enumerate() {
        let Some((weights, rest)) = weights else {
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
    let count = 4 * columns.len() / rows.len() + 30;
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
                Column::Slide { body } => full
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

/// For each column, if dependent: its weights on the kept earlier columns, and
/// twice the largest entry they leave (twice, for postures between the samples).
///
/// Gram–Schmidt in the given order, every projection made twice.
fn dependencies(rows: &DMatrix<f64>) -> Vec<Option<(Vec<(usize, f64)>, f64)>> {
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
            Some((solved, 2.0 * rest.amax()))
        })
        .collect()
}

/// Number of base columns that CoP rows lose.
///
/// A column whose x and y vanish in every posture: the height in r_0, and a
/// slide whose direction stays vertical. Tied joints are checked numerically.
fn invisible_in_cop(
    tree: &Tree,
    chain: &Chain,
    frames: &[Frame],
    params: &[BaseParam],
    unobservable: &mut Vec<Unobservable>,
) -> usize {
    // The vertical, where it is constant in the body.
    let mut vertical: Vec<Option<Vector3<f64>>> = Vec::new();
    for body in &chain.bodies {
        let up = match body.parent.map(|p| vertical[p]) {
            None => Some(Vector3::z()),
            Some(None) => None,
            Some(Some(up)) => {
                let here = (body.rotation.transpose() * up).map(tidy);
                match body.motion {
                    Motion::Turn { axis, .. } if axis.cross(&here).norm() > 1e-14 => None,
                    _ => Some(here),
                }
            }
        };
        vertical.push(up);
    }
    let mut visible = Vec::new();
    for param in params {
        let sentence = match param.column {
            Column::Axis { body: 0, axis: 2 } => {
                "the height of the CoM is known up to one constant: it never moves a flat CoP"
                    .to_string()
            }
            Column::Slide { body } => {
                let (Motion::Slide { axis, .. }, Some(parent)) =
                    (chain.bodies[body].motion, chain.bodies[body].parent)
                else {
                    continue;
                };
                let stays = vertical[parent].is_some_and(|up| axis.cross(&up).norm() < 1e-14);
                if !stays {
                    visible.push(param.column);
                    continue;
                }
                format!(
                    "the mass lifted by `{}` never moves a flat CoP: the joint stays vertical",
                    chain.bodies[body].joint.as_deref().unwrap_or_default()
                )
            }
            column => {
                visible.push(column);
                continue;
            }
        };
        unobservable.push(Unobservable {
            name: format!("{} from CoP", param.name),
            sentence,
            only_from_cop: true,
        });
    }
    params.len() - visible.len() + tied_in_cop(tree, chain, frames, visible)
}

/// How many of the `visible` columns tied angles hide in the x and y rows.
fn tied_in_cop(tree: &Tree, chain: &Chain, frames: &[Frame], mut visible: Vec<Column>) -> usize {
    let tied = tied_bodies(tree, chain);
    visible.retain(|column| match *column {
        Column::Axis { body, .. } | Column::Slide { body } => tied[body],
    });
    if visible.is_empty() {
        return 0;
    }
    let rows = sampled(tree, chain, frames, &visible, &[0, 1]);
    dependencies(&rows).iter().flatten().count()
}

//! Base parameters: the combinations of full parameters that data can see.
//!
//! A revolute joint leaves its axis `a` where it is in the parent, so the part
//! of r_i along `a` cannot be told from the same vector in the parent's r: it
//! moves there, and 2 parameters stay. A prismatic joint leaves the whole
//! orientation alone: all of r_i moves, one s_i stays. r_0 keeps 3. Working
//! from the leaves to the root gives 3 + 2 (revolute) + 1 (prismatic) columns.
//!
//! These columns are linearly independent as functions of posture when every
//! joint is independent: averaging over one joint's angle removes its own
//! columns and leaves those outside its subtree. Mimic joints tie angles
//! together and may lower the rank; the columns of the tied part of the tree
//! are therefore also compared numerically, and the dependent ones regrouped.

mod mimic_rank;
mod types;

use nalgebra::Vector3;

use crate::chain::Chain;
use crate::frames::Frame;
use crate::snap::tidy;
use crate::tree::{Motion, Tree};
use mimic_rank::{tied_in_cop, untie};
pub use types::{Base, BaseParam, Column, Unobservable};
use types::{Form, add};

/// A vector of linear forms in the full parameters.
type Forms = [Form; 3];

/// Group the columns of `chain` into base parameters.
#[doc(hidden)]
pub fn group(tree: &Tree, chain: &Chain, frames: &[Frame]) -> Base {
    let mut forms: Vec<Forms> = chain
        .bodies
        .iter()
        .map(|body| [0, 1, 2].map(|k| vec![(body.column + k, 1.0)]))
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
            ulps_of: 0.0,
        };
        let moved: Vec<Vector3<f64>> = match (body.motion, body.parent) {
            (Motion::Revolute { .. }, Some(_)) => {
                for k in [0, 1] {
                    let name = format!("{}.{}", body.name, frames[i].axis_name(k));
                    let terms = project(&form, &frames[i].axes.column(k).into_owned());
                    own[i].push(param(name, Column::Axis { body: i, axis: k }, terms));
                }
                vec![frames[i].axes.column(2).into_owned()]
            }
            (Motion::Prismatic { .. }, Some(_)) => {
                let terms = vec![(body.column + 3, 1.0)];
                own[i].push(param(
                    format!("{}.s", body.name),
                    Column::Prismatic { body: i },
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
    let value = |terms: &Form| -> f64 { terms.iter().map(|(k, w)| w * cad[*k]).sum() };
    let regrouping_error = dropped
        .iter()
        .map(|(lost, rest)| libm::fabs(value(&lost.terms)) * rest)
        .sum();
    for param in &mut params {
        param.cad = value(&param.terms);
        // A rounded sum of rounded products.
        let sizes = param.terms.iter().map(|(k, w)| libm::fabs(w * cad[*k]));
        param.ulps_of = sizes.sum::<f64>() * (8.0 + param.terms.len() as f64);
    }
    let invisible = invisible_in_cop(tree, chain, frames, &params, &mut unobservable);
    Base {
        rank_cop: params.len() - invisible,
        regrouping_error,
        params,
        unobservable,
    }
}

fn project(form: &Forms, axis: &Vector3<f64>) -> Form {
    let mut sum = Form::new();
    for k in 0..3 {
        add(&mut sum, &form[k], axis[k]);
    }
    sum
}

fn moved_to_parent(chain: &Chain, i: usize, parent: usize) -> Unobservable {
    let (body, parent) = (&chain.bodies[i], &chain.bodies[parent]);
    let joint = body.joint.as_deref().unwrap_or_default();
    let (name, sentence) = match body.motion {
        Motion::Prismatic { .. } => (
            format!("r of {}", body.name),
            format!(
                "r of `{}` moves to its parent `{}`: prismatic joint `{joint}` never rotates it",
                body.name, parent.name
            ),
        ),
        _ => (
            format!("axis of {joint}"),
            format!(
                "r of `{}` along the axis of `{joint}` moves to its parent `{}`: \
                 rotation about that axis leaves it unchanged",
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

/// Number of base columns that CoP rows lose.
///
/// A column whose x and y vanish in every posture: the height in r_0, and a
/// prismatic joint whose direction stays vertical. Tied joints are checked numerically.
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
                    Motion::Revolute { axis, .. } if axis.cross(&here).norm() > 1e-14 => None,
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
            Column::Prismatic { body } => {
                let (Motion::Prismatic { axis, .. }, Some(parent)) =
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

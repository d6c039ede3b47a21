//! The tree: in which order to walk it, and what moves each joint.
//!
//! ```text
//! q_j = k_1 (k_2 (… q_dof …) + o_2) + o_1 = factor q_dof + offset
//! ```

use std::collections::HashMap;

use crate::error::{Error, Problem};
use crate::joint::{Joint, Link};

/// A joint's position as a function of the posture: `factor · q[dof] + offset`,
/// or `offset` alone.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Coordinate {
    /// Which entry of the posture moves the joint, if any does.
    pub dof: Option<usize>,
    /// How fast it does.
    pub factor: f64,
    /// Where it stands when that entry is zero, rad or m.
    pub offset: f64,
}

/// Joints in an order that meets every parent link before its children.
pub(crate) fn sort_from_root(links: &[Link], joints: &[Joint]) -> Result<Vec<usize>, Error> {
    let not_a_tree = |why: String| Err(Problem::NotATree { why }.into());
    let mut carrier: Vec<Option<usize>> = vec![None; links.len()];
    let mut outward: Vec<Vec<usize>> = vec![Vec::new(); links.len()];
    for (j, joint) in joints.iter().enumerate() {
        if let Some(other) = carrier[joint.child].replace(j) {
            return not_a_tree(format!(
                "link `{}` hangs on both `{}` and `{}`",
                links[joint.child].name, joints[other].name, joint.name
            ));
        }
        outward[joint.parent].push(j);
    }
    let roots: Vec<usize> = (0..links.len()).filter(|&l| carrier[l].is_none()).collect();
    let root = match roots[..] {
        [root] => root,
        [] if links.is_empty() => return Err(Problem::NoLinks.into()),
        [] => return not_a_tree("the joints form a closed circle".to_owned()),
        _ => {
            let names = join(roots.iter().map(|&l| links[l].name.as_str()));
            return not_a_tree(format!(
                "no joint carries {names}; only one link may be the root"
            ));
        }
    };
    let mut order = Vec::with_capacity(joints.len());
    let mut open = vec![root];
    while let Some(link) = open.pop() {
        for &j in &outward[link] {
            order.push(j);
            open.push(joints[j].child);
        }
    }
    if order.len() < joints.len() {
        return not_a_tree(format!(
            "some joints form a closed circle apart from root `{}`",
            links[root].name
        ));
    }
    Ok(order)
}

/// Every joint's position as a function of the posture, mimics followed to
/// the end of their chain.
pub(crate) fn resolve_mimics(
    joints: &[Joint],
    movable: &[usize],
) -> Result<Vec<Coordinate>, Error> {
    let index: HashMap<&str, usize> = joints
        .iter()
        .enumerate()
        .map(|(j, joint)| (joint.name.as_str(), j))
        .collect();
    let dof_of: HashMap<usize, usize> = movable.iter().copied().zip(0..).collect();

    let resolve = |start: usize| {
        let (mut factor, mut offset, mut at) = (1.0, 0.0, start);
        for _ in 0..=joints.len() {
            let Some(mimic) = &joints[at].mimic else {
                let dof = dof_of.get(&at).copied();
                return Ok(Coordinate {
                    dof,
                    factor: if dof.is_some() { factor } else { 0.0 },
                    offset,
                });
            };
            let master =
                *index
                    .get(mimic.master.as_str())
                    .ok_or_else(|| Problem::UnknownMaster {
                        joint: joints[at].name.clone(),
                        master: mimic.master.clone(),
                    })?;
            if joints[master].kind.is_free() {
                return Err(Problem::FreeMaster {
                    joint: joints[at].name.clone(),
                    master: mimic.master.clone(),
                }
                .into());
            }
            offset += factor * mimic.offset;
            factor *= mimic.multiplier;
            at = master;
        }
        Err(Problem::MimicCircle {
            joint: joints[start].name.clone(),
        }
        .into())
    };
    (0..joints.len()).map(resolve).collect()
}

/// Names for an error message.
pub(crate) fn join<'a>(names: impl Iterator<Item = &'a str>) -> String {
    let quoted: Vec<String> = names.map(|name| format!("`{name}`")).collect();
    if quoted.is_empty() {
        "none".to_owned()
    } else {
        quoted.join(", ")
    }
}

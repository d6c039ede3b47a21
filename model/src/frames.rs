//! Which frame each body's parameters are written in.
//!
//! Only the rotation axis of a joint is given; the two axes beside it are free.
//! They are chosen so that the joint is a rotation in the first two coordinates
//! after a cheap constant twist:
//!
//! ```text
//! B_i F_i = (B_p F_p) K_i Rz(κ q + θ) diag(1, ±1, 1)
//! ```
//!
//! `K_i` is a signed permutation when the axes meet at right angles (no
//! multiplications), a plane rotation when the child's axis lies in a
//! coordinate plane of its parent (4), a reflection otherwise (5). Turning the
//! free axes of the parent by a constant (its θ, one addition to the joint
//! angle) brings one child's axis into such a plane. Over a whole tree this
//! costs at most 4 more per joint: every child that pays 5 leaves, somewhere
//! below, a leaf that pays 2 instead of 4.

use nalgebra::{Matrix3, Vector3};

use crate::chain::Chain;
use crate::snap::{self, tidy};
use crate::tree::{Coordinate, Motion};

/// A constant orthogonal map between canonical frames, by its cheapest form.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Twist {
    /// Entries, at most two in a row; the zeros and ones cost nothing.
    Sparse(Matrix3<f64>),
    /// `I − k u uᵀ`
    Reflection {
        /// One entry is one.
        u: Vector3<f64>,
        /// 2 / uᵀu
        k: f64,
    },
}

impl Twist {
    /// Whether it only changes the places and signs of coordinates.
    pub(crate) fn is_permutation(&self) -> bool {
        match self {
            Twist::Sparse(k) => k.iter().all(|x| [0.0, 1.0].contains(&libm::fabs(*x))),
            Twist::Reflection { .. } => false,
        }
    }
}

/// How the body of a revolute joint sits on its parent, in canonical coordinates.
#[derive(Debug, Clone, PartialEq)]
pub struct Rotation {
    /// The constant part.
    pub(crate) twist: Twist,
    /// The angle κ q + θ, rotating the first two coordinates.
    pub angle: Coordinate,
    /// The second coordinate is mirrored before the rotation.
    pub mirrored: bool,
}

/// Canonical axes of a body.
#[derive(Debug, Clone)]
pub struct Frame {
    /// Columns: canonical axes in the body frame; the third is ± the joint axis.
    pub(crate) axes: Matrix3<f64>,
    /// For bodies on a revolute joint.
    pub rotation: Option<Rotation>,
}

/// Choose the canonical frame of every body, root to leaf.
pub fn choose(chain: &Chain) -> Vec<Frame> {
    let children = chain.children();
    let mut frames: Vec<Frame> = Vec::with_capacity(chain.bodies.len());
    for (i, body) in chain.bodies.iter().enumerate() {
        let frame = match (body.motion, body.parent) {
            (Motion::Revolute { axis, by }, Some(parent)) => {
                let carried = revolute_children(chain, &children, i);
                revolute_frame(&frames[parent].axes, &body.rotation, &axis, by, &carried)
            }
            (_, Some(parent)) => Frame {
                // A body on a prismatic joint never rotates: it keeps its parent's axes.
                axes: (body.rotation.transpose() * frames[parent].axes).map(tidy),
                rotation: None,
            },
            (_, None) => Frame {
                axes: Matrix3::identity(),
                rotation: None,
            },
        };
        frames.push(frame);
    }
    frames
}

/// A revolute body carried by another: the direction of its axis there, and
/// whether it carries nothing itself.
struct Carried {
    axis: Vector3<f64>,
    leaf: bool,
}

/// Revolute bodies on body `i`, directly or over prismatic ones.
fn revolute_children(chain: &Chain, children: &[Vec<usize>], i: usize) -> Vec<Carried> {
    let mut found = Vec::new();
    let mut stack: Vec<(usize, Matrix3<f64>)> = children[i]
        .iter()
        .rev()
        .map(|&k| (k, Matrix3::identity()))
        .collect();
    while let Some((k, outer)) = stack.pop() {
        let body = &chain.bodies[k];
        let rotation = outer * body.rotation;
        match body.motion {
            Motion::Revolute { axis, .. } => found.push(Carried {
                axis: (rotation * axis).map(tidy),
                leaf: children[k].is_empty(),
            }),
            _ => stack.extend(children[k].iter().rev().map(|&c| (c, rotation))),
        }
    }
    found
}

fn revolute_frame(
    parent: &Matrix3<f64>,
    rotation: &Matrix3<f64>,
    axis: &Vector3<f64>,
    by: Coordinate,
    carried: &[Carried],
) -> Frame {
    let to_parent = parent.transpose() * rotation;
    let mut best: Option<((u32, bool), Frame)> = None;
    for axes in candidates(axis, &to_parent, carried) {
        let frame = seat(&to_parent, axes, axis, by);
        let twists = carried
            .iter()
            .map(|child| cost(&(axes.transpose() * child.axis).map(tidy), child.leaf))
            .sum();
        let rotation = frame
            .rotation
            .as_ref()
            .expect("seat always makes a rotation");
        let cost = (twists, snap::quarters(rotation.angle.offset).1 != 0.0);
        if best.as_ref().is_none_or(|(least, _)| cost < *least) {
            best = Some((cost, frame));
        }
    }
    best.expect("there is always a candidate").1
}

/// Candidate frames, the most readable first.
fn candidates(
    axis: &Vector3<f64>,
    to_parent: &Matrix3<f64>,
    carried: &[Carried],
) -> Vec<Matrix3<f64>> {
    let mut frames = Vec::new();
    let unit = |k: usize| Vector3::ith(k, 1.0);
    if let Some(k) = snap::aligned(axis) {
        let (a, b) = [(1, 2), (0, 2), (0, 1)][k];
        frames.push(Matrix3::from_columns(&[unit(a), unit(b), unit(k)]));
    }
    let third = frames.first().map_or(*axis, |f| f.column(2).into_owned());
    let mut push = |first: Vector3<f64>| {
        // Twice: what is left of nearly parallel vectors is mostly rounding.
        let beside = |x: Vector3<f64>| (x - third * third.dot(&x)).normalize();
        let first = beside(beside(first)).map(tidy);
        let second = third.cross(&first).map(tidy);
        frames.push(Matrix3::from_columns(&[first, second, third]));
    };
    // As the parent's twist leaves it: no constant in the joint angle.
    let twist = twist(&(to_parent * third).map(tidy)).matrix();
    push(to_parent.transpose() * twist.column(0));
    for child in carried {
        let beside = child.axis - third * third.dot(&child.axis);
        if beside.norm() > 1e-14 {
            push(beside);
        }
    }
    frames
}

/// Decompose the constant orientation of `axes` in the parent's canonical frame.
fn seat(
    to_parent: &Matrix3<f64>,
    axes: Matrix3<f64>,
    axis: &Vector3<f64>,
    by: Coordinate,
) -> Frame {
    let whole = (to_parent * axes).map(tidy);
    let twist = twist(&whole.column(2).into_owned());
    let rest = twist.matrix().transpose() * whole;
    let mirrored = rest[(0, 0)] * rest[(1, 1)] - rest[(0, 1)] * rest[(1, 0)] < 0.0;
    let theta = whole_quarters(libm::atan2(rest[(1, 0)], rest[(0, 0)]));
    // Sense of rotation of a positive angle about `axis`, seen in these axes.
    let mut sense = axes.column(2).dot(axis).signum() * axes.determinant().signum();
    if mirrored {
        sense = -sense;
    }
    let angle = Coordinate {
        dof: by.dof,
        factor: sense * by.factor,
        offset: whole_quarters(theta + sense * by.offset),
    };
    Frame {
        axes,
        rotation: Some(Rotation {
            twist,
            angle,
            mirrored,
        }),
    }
}

/// Rounding noise around multiples of a quarter turn removed.
fn whole_quarters(angle: f64) -> f64 {
    let quarter = std::f64::consts::FRAC_PI_2;
    let whole = libm::rint(angle / quarter) * quarter;
    if libm::fabs(angle - whole) < 2e-15 {
        whole
    } else {
        angle
    }
}

/// The cheapest orthogonal map that takes the third axis to `z` (unit).
fn twist(z: &Vector3<f64>) -> Twist {
    let unit = |k: usize| Vector3::ith(k, 1.0);
    let zeros: Vec<usize> = (0..3).filter(|&k| z[k] == 0.0).collect();
    match zeros[..] {
        [a, b] => Twist::Sparse(Matrix3::from_columns(&[unit(a), unit(b), *z])),
        [a] => {
            let beside = unit(a).cross(z);
            Twist::Sparse(Matrix3::from_columns(&[unit(a), beside, *z]))
        }
        _ => {
            let mut u = unit(2) - z;
            if z[2] > 0.0 {
                // 1 − z without cancellation, for axes that are almost parallel.
                u[2] = (z[0] * z[0] + z[1] * z[1]) / (1.0 + z[2]);
            }
            let largest = u[u.iamax()];
            let u = u / largest;
            Twist::Reflection {
                u,
                k: 2.0 / u.norm_squared(),
            }
        }
    }
}

/// Multiplications of the twist that a child with axis `z` needs.
fn cost(z: &Vector3<f64>, leaf: bool) -> u32 {
    match (z.iter().filter(|x| **x == 0.0).count(), leaf) {
        (2, _) => 0,
        (1, true) => 2,
        (0, false) => 5,
        _ => 4,
    }
}

impl Twist {
    /// All nine entries.
    pub(crate) fn matrix(&self) -> Matrix3<f64> {
        match self {
            Twist::Sparse(matrix) => *matrix,
            Twist::Reflection { u, k } => Matrix3::identity() - u * u.transpose() * *k,
        }
    }
}

impl Frame {
    /// The canonical axis `k` in words: `x` when it is an axis of the link, else `u`, `v`, `w`.
    pub fn axis_name(&self, k: usize) -> &'static str {
        let column = self.axes.column(k);
        match (0..3).find(|&m| column[m] == 1.0) {
            Some(m) => ["x", "y", "z"][m],
            None => ["u", "v", "w"][k],
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_twist_is_orthogonal_and_hits_its_axis() {
        for z in [
            Vector3::new(0.0, 0.0, -1.0),
            Vector3::new(1.0, 0.0, 0.0),
            Vector3::new(0.6, 0.0, 0.8),
            Vector3::new(0.6, -0.8, 0.0),
            Vector3::new(0.36, 0.48, -0.8),
            Vector3::new(1e-7, 1e-7, 1.0).normalize(),
        ] {
            let k = twist(&z).matrix();
            assert!((k * k.transpose() - Matrix3::identity()).norm() < 1e-14);
            assert!((k.column(2) - z).norm() < 1e-14, "{z} {k}");
        }
    }
}

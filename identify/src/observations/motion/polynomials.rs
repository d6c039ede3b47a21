//! One polynomial through the nodes of a window for each joint, by least squares.

use std::array;
use std::ops::Range;

use nalgebra::SMatrix;
use sesc_runtime::{F64x8, Simd};

use super::windows::Nodes;

/// Coefficients of the polynomial of order 4, the highest.
pub(super) const HIGH: usize = 5;
/// A pivot of the normal equations, per coefficient, below which nodes do not settle them.
const SINGULAR: f64 = 1e-9;

/// Nodes' worth of what a whole log says of their noise, beside those of a window.
const SHARED: f64 = 10.0;

/// The polynomials of all joints about a node.
pub(super) struct Polynomials {
    /// Joint by joint within each power; zero of powers that it does not have.
    pub coefficients: Vec<f64>,
    /// What they leave of each joint: Σ e².
    pub left: Vec<f64>,
    /// Nodes beyond the coefficients.
    pub spare: f64,
    pub half: f64,
    /// Deviation of an acceleration for nodes of deviation one.
    pub weight: f64,
    /// How much of the polynomial at the node is the node's own.
    pub own: f64,
    /// Correlation of an acceleration with the node's own position: a position that is read too
    /// large bends the polynomial down there.
    pub with_own: f64,
}

impl Polynomials {
    pub(super) fn fit(
        nodes: &Nodes,
        node: usize,
        around: Range<usize>,
        terms: usize,
    ) -> Option<Polynomials> {
        let (dof, half, count) = (nodes.dof, nodes.half, around.len());
        if count < terms {
            return None;
        }
        let mut powers = Vec::with_capacity(count);
        let mut moments = [0.0; 2 * HIGH - 1];
        for t in &nodes.t[around.clone()] {
            let s = (t - nodes.t[node]) / half;
            let [square, cube] = [s * s, s * s * s];
            let own = [1.0, s, square, cube, square * square];
            let beyond = own.iter().skip(1).map(|x| x * own[HIGH - 1]);
            for (sum, x) in moments.iter_mut().zip(own.into_iter().chain(beyond)) {
                *sum += x;
            }
            powers.push(own);
        }
        let inverse = inverse(&moments, terms)?;
        let zero = F64x8::splat(0.0);
        let mut sums = vec![zero; HIGH * nodes.width];
        let mut left = vec![zero; nodes.width];
        let about = nodes.blocks(node..node + 1);
        let rows = nodes.blocks(around);
        Simd::best().moments(&powers, rows, about, &mut sums, &mut left);
        let mut coefficients = vec![0.0; HIGH * dof];
        for (block, left) in left.iter_mut().enumerate() {
            let sums: [&F64x8; HIGH] = array::from_fn(|m| &sums[m * nodes.width + block]);
            for m in 0..terms {
                let mut own = zero;
                for (k, sums) in sums.iter().enumerate().take(terms) {
                    own = own + F64x8::splat(inverse[m][k]) * **sums;
                }
                *left = *left - own * *sums[m];
                let first = m * dof + 8 * block;
                let places = &mut coefficients[first..first + 8.min(dof - 8 * block)];
                places.iter_mut().zip(own.0).for_each(|(to, x)| *to = x);
            }
        }
        Some(Polynomials {
            coefficients,
            left: left.iter().flat_map(|block| block.0).take(dof).collect(),
            spare: (count - terms).max(1) as f64,
            half,
            weight: 2.0 / (half * half) * inverse[2][2].max(0.0).sqrt(),
            own: inverse[0][0],
            with_own: inverse[2][0] / inverse[2][2].max(f64::MIN_POSITIVE).sqrt(),
        })
    }

    /// Position `after` seconds from the node, less the node's own.
    pub(super) fn position(&self, joint: usize, after: f64) -> f64 {
        let (s, [c0, c1, c2, c3, c4]) = (after / self.half, self.of(joint));
        c0 + s * (c1 + s * (c2 + s * (c3 + s * c4)))
    }

    /// Velocity `after` seconds from the node.
    pub(super) fn rate(&self, joint: usize, after: f64) -> f64 {
        let (s, [_, c1, c2, c3, c4]) = (after / self.half, self.of(joint));
        (c1 + s * (2.0 * c2 + s * (3.0 * c3 + s * 4.0 * c4))) / self.half
    }

    /// Acceleration `after` seconds from the node.
    pub(super) fn gain(&self, joint: usize, after: f64) -> f64 {
        let (s, [_, _, c2, c3, c4]) = (after / self.half, self.of(joint));
        (2.0 * c2 + s * (6.0 * c3 + s * 12.0 * c4)) / (self.half * self.half)
    }

    /// Variance of a node.
    pub(super) fn variance(&self, joint: usize) -> f64 {
        self.left[joint].max(0.0) / self.spare
    }

    /// Deviation of the acceleration of a joint whose nodes have this `variance` in all of the
    /// log: few nodes alone say little of it.
    pub(super) fn gain_std(&self, joint: usize, variance: f64) -> f64 {
        let left = self.left[joint].max(0.0) + SHARED * variance;
        (left / (self.spare + SHARED)).sqrt() * self.weight
    }

    fn of(&self, joint: usize) -> [f64; HIGH] {
        array::from_fn(|power| self.coefficients[power * self.left.len() + joint])
    }
}

/// The inverse of the leading block of a positive definite matrix of `moments`; none of another.
fn inverse(moments: &[f64; 2 * HIGH - 1], terms: usize) -> Option<[[f64; HIGH]; HIGH]> {
    // Of the largest size whatever the terms, one beyond them: windows are many, and nothing is
    // allocated.
    let is_own = |a: usize, b: usize| a.max(b) < terms;
    let factor = SMatrix::<f64, HIGH, HIGH>::from_fn(|a, b| match is_own(a, b) {
        true => moments[a + b],
        false => f64::from(u8::from(a == b)),
    });
    let factor = factor.cholesky()?;
    let least = SINGULAR * terms as f64;
    let pivots = factor.l_dirty().diagonal().map(|root| root * root);
    let inverse = factor.inverse();
    let entry = |a: usize, b: usize| if is_own(a, b) { inverse[(a, b)] } else { 0.0 };
    let entries = || array::from_fn(|a| array::from_fn(|b| entry(a, b)));
    pivots.iter().all(|pivot| *pivot > least).then(entries)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Moments of nodes that lie unevenly.
    fn moments() -> [f64; 2 * HIGH - 1] {
        let nodes = (0..12).map(|k| -0.95 + 0.17 * f64::from(k) + 0.01 * f64::from(k * k % 5));
        let nodes: Vec<f64> = nodes.collect();
        array::from_fn(|power| nodes.iter().map(|s| s.powi(power as i32)).sum())
    }

    #[test]
    fn the_inverse_times_the_moments_is_one() {
        let moments = moments();
        for terms in 1..=HIGH {
            let inverse = inverse(&moments, terms).unwrap();
            for (a, row) in inverse.iter().enumerate().take(terms) {
                for b in 0..terms {
                    let product: f64 = (0..terms).map(|k| row[k] * moments[k + b]).sum();
                    let one = f64::from(u8::from(a == b));
                    assert!((product - one).abs() < 1e-12, "{terms}: {a} {b} {product}");
                }
            }
        }
    }

    #[test]
    fn nodes_at_two_places_settle_no_parabola() {
        let moments = array::from_fn(|power| if power % 2 == 0 { 8.0 } else { 0.0 });
        assert!(inverse(&moments, 2).is_some() && inverse(&moments, 3).is_none());
        assert!(inverse(&[f64::NAN; 2 * HIGH - 1], 3).is_none());
    }
}

//! One polynomial through the nodes of a window for each joint, by least squares.

use std::ops::Range;

use nalgebra::Matrix5;

use super::windows::Nodes;

/// Coefficients of the polynomial of order 4, the highest.
pub(super) const HIGH: usize = 5;
/// A pivot of the normal equations, per coefficient, below which nodes do not settle them.
const SINGULAR: f64 = 1e-9;

/// Nodes' worth of what a whole log says of their noise, beside those of a window.
const SHARED: f64 = 10.0;

/// The polynomials of all joints about a node.
pub(super) struct Polynomials {
    pub terms: usize,
    /// Joint by joint within each power.
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
}

impl Polynomials {
    pub fn fit(
        nodes: &Nodes,
        node: usize,
        around: Range<usize>,
        half: f64,
        terms: usize,
    ) -> Option<Polynomials> {
        let (dof, count) = (nodes.dof, around.len());
        if count < terms {
            return None;
        }
        let about = &nodes.q[node * dof..(node + 1) * dof];
        let mut normal = Matrix5::zeros();
        let mut sums = vec![0.0; terms * dof];
        let mut left = vec![0.0; dof];
        for i in around {
            let s = (nodes.t[i] - nodes.t[node]) / half;
            let powers = [1.0, s, s * s, s * s * s, s * s * s * s];
            for a in 0..terms {
                for b in 0..terms {
                    normal[(a, b)] += powers[a] * powers[b];
                }
            }
            let own = &nodes.q[i * dof..(i + 1) * dof];
            for (m, sums) in sums.chunks_exact_mut(dof).enumerate() {
                for ((sum, x), origin) in sums.iter_mut().zip(own).zip(about) {
                    *sum += powers[m] * (x - origin);
                }
            }
            for ((sum, x), origin) in left.iter_mut().zip(own).zip(about) {
                *sum += (x - origin) * (x - origin);
            }
        }
        let inverse = inverse(normal, terms)?;
        let mut coefficients = vec![0.0; terms * dof];
        for (m, row) in coefficients.chunks_exact_mut(dof).enumerate() {
            for (k, sums) in sums.chunks_exact(dof).enumerate() {
                for (c, sum) in row.iter_mut().zip(sums) {
                    *c += inverse[(m, k)] * sum;
                }
            }
        }
        for (c, sum) in coefficients.chunks_exact(dof).zip(sums.chunks_exact(dof)) {
            for ((left, c), sum) in left.iter_mut().zip(c).zip(sum) {
                *left -= c * sum;
            }
        }
        Some(Polynomials {
            terms,
            coefficients,
            left,
            spare: (count - terms).max(1) as f64,
            half,
            weight: 2.0 / (half * half) * inverse[(2, 2)].max(0.0).sqrt(),
            own: inverse[(0, 0)],
        })
    }

    pub fn coefficient(&self, power: usize, joint: usize) -> f64 {
        let dof = self.left.len();
        match power < self.terms {
            true => self.coefficients[power * dof + joint],
            false => 0.0,
        }
    }

    /// Acceleration at the node.
    pub fn gain(&self, joint: usize) -> f64 {
        2.0 * self.coefficient(2, joint) / (self.half * self.half)
    }

    /// Position `after` seconds from the node, less the node's own.
    pub fn position(&self, joint: usize, after: f64) -> f64 {
        let (s, c) = (after / self.half, |power| self.coefficient(power, joint));
        c(0) + s * (c(1) + s * (c(2) + s * (c(3) + s * c(4))))
    }

    /// Variance of a node.
    pub fn variance(&self, joint: usize) -> f64 {
        self.left[joint].max(0.0) / self.spare
    }

    /// Velocity, acceleration and the deviation of that, `after` seconds from the node, of a
    /// joint whose nodes have `variance` in all of the log: few nodes alone say little of it.
    pub fn at(&self, joint: usize, after: f64, variance: f64) -> [f64; 3] {
        let (s, h) = (after / self.half, self.half);
        let c = |power| self.coefficient(power, joint);
        let rate = c(1) + s * (2.0 * c(2) + s * (3.0 * c(3) + s * 4.0 * c(4)));
        let gain = 2.0 * c(2) + s * (6.0 * c(3) + s * 12.0 * c(4));
        let left = self.left[joint].max(0.0) + SHARED * variance;
        let std = (left / (self.spare + SHARED)).sqrt() * self.weight;
        [rate / h, gain / (h * h), std]
    }
}

/// The inverse of the leading block of a positive definite matrix; none of another.
fn inverse(normal: Matrix5<f64>, terms: usize) -> Option<Matrix5<f64>> {
    let padded = Matrix5::from_fn(|r, c| match r < terms && c < terms {
        true => normal[(r, c)],
        false => f64::from(u8::from(r == c)),
    });
    let factor = padded.cholesky()?;
    let least = SINGULAR * terms as f64;
    let pivots = factor.l_dirty().diagonal();
    let regular = pivots.iter().all(|pivot| pivot * pivot > least);
    regular.then(|| factor.inverse())
}

//! The weighted triangle and its rotations, free of square roots.
//!
//! ```text
//! Σ w (x θ − y)²  =  (θ − θ̂)ᵀ R̄ᵀ D R̄ (θ − θ̂) + rest        R̄ θ̂ = θ̄
//! ```
//!
//! R̄ is upper triangular with a unit diagonal, D diagonal. A row (x, y) of weight w
//! meets line i of the triangle with its pivot p = x_i,
//!
//! ```text
//! d' = d + w p²      c = d / d'      s = w p / d'      w' = c w
//! x_k' = x_k − p r_ik         r_ik' = c r_ik + s x_k = r_ik + s x_k'
//! ```
//!
//! and leaves it with p = 0 and the weight w'. Of the two forms of r' the second is
//! taken where c > 1/2: there r changes little, and a rounded c would pull at all
//! of r in every row. Where c is small the second would cancel. W. M. Gentleman, "Basic procedures
//! for large, sparse or weighted linear least squares problems", Algorithm AS 154,
//! Applied Statistics 23 (1974) 448-454.

use super::error::Error;
use crate::scalar::Scalar;

/// Lines r̄_i (right of the diagonal), their weights d_i and their values θ̄_i.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Triangle<T, const N: usize> {
    pub lines: [[T; N]; N],
    pub weights: [T; N],
    pub values: [T; N],
}

/// What no parameters can remove of a row: its value and weight once it has lost all pivots.
#[derive(Debug, Clone, Copy)]
pub(super) struct Left<T> {
    value: T,
    weight: T,
}

impl<T: Scalar> Left<T> {
    /// w v²: what it adds to the sum of squares.
    pub(super) fn square(self) -> T {
        self.weight * self.value * self.value
    }

    /// √w v: the error of the prediction by the rows before, over its deviation; zero where
    /// they predicted nothing.
    pub(super) fn error(self) -> T {
        match self.weight > T::ZERO {
            true => self.weight.root() * self.value,
            false => T::ZERO,
        }
    }
}

impl<T: Scalar, const N: usize> Triangle<T, N> {
    pub(super) const fn empty() -> Self {
        Self {
            lines: [[T::ZERO; N]; N],
            weights: [T::ZERO; N],
            values: [T::ZERO; N],
        }
    }

    /// R row by row from its diagonal on: d_i = R_ii², r̄_ik = R_ik/R_ii, values zero.
    pub(super) fn of_factor(factor: &[f64]) -> Result<Self, Error> {
        if factor.len() != N * (N + 1) / 2 {
            return Err(Error::Factor);
        }
        let mut triangle = Self::empty();
        let mut rest = factor;
        for i in 0..N {
            let Some((row, after)) = rest.split_at_checked(N - i) else {
                break;
            };
            rest = after;
            let [pivot, row @ ..] = row else { break };
            let pivot = T::from_f64(*pivot);
            if !pivot.is_finite() || row.iter().any(|x| !T::from_f64(*x).is_finite()) {
                return Err(Error::NotFinite);
            }
            if pivot < T::ZERO || (pivot == T::ZERO && row.iter().any(|x| *x != 0.0)) {
                return Err(Error::Factor);
            }
            let information = pivot * pivot;
            if information < T::LEAST {
                continue;
            }
            triangle.weights[i] = information;
            if let Some(line) = triangle.lines[i].get_mut(i + 1..) {
                for (r, x) in line.iter_mut().zip(row) {
                    *r = T::from_f64(*x) / pivot;
                }
            }
        }
        let taken = |sum: &T| *sum <= T::MOST;
        match triangle.information().iter().all(taken) {
            true => Ok(triangle),
            false => Err(Error::OutOfRange),
        }
    }

    /// Rotate `weight`·(`row`·θ − `value`)² into the triangle; what no θ can remove of
    /// it is the result, `w v²` of weight w and value v.
    ///
    /// Rotations preserve Σ w x_k² of every column, so that d r² and w x² stay below
    /// it. With d ≥ `LEAST` and w ≥ `LIGHT`, neither r nor x can overflow.
    pub(super) fn include(&mut self, mut row: [T; N], mut value: T, mut weight: T) -> Left<T> {
        for i in 0..N {
            let Some((done, [pivot, rest @ ..])) = row.split_at_mut_checked(i) else {
                break;
            };
            let pivot = *pivot;
            let information = weight * pivot * pivot;
            if information < T::LEAST {
                continue;
            }
            // The first pivot of a column decides what the line means: rounding may not.
            if self.weights[i] == T::ZERO && self.is_rounding(done, pivot, &[true; N]) {
                continue;
            }
            let sum = self.weights[i] + information;
            let (c, s) = (self.weights[i] / sum, weight * pivot / sum);
            self.weights[i] = sum;
            if let Some(line) = self.lines[i].get_mut(i + 1..) {
                rotate(rest, line, pivot, c, s);
            }
            let last = core::slice::from_mut(&mut value);
            rotate(
                last,
                core::slice::from_mut(&mut self.values[i]),
                pivot,
                c,
                s,
            );
            weight = c * weight;
            if weight == T::ZERO {
                return Left { value, weight };
            }
            while weight < T::LIGHT {
                weight = weight / (T::LIGHT * T::LIGHT);
                value = value * T::LIGHT;
                for x in &mut row {
                    *x = *x * T::LIGHT;
                }
            }
        }
        Left { value, weight }
    }

    /// Whether the pivot of column `done.len()` is what cancellation leaves of larger
    /// terms: `done` are the pivots of the columns before it.
    fn is_rounding(&self, done: &[T], pivot: T, observable: &[bool; N]) -> bool {
        let column = done.len();
        let mut terms = pivot.abs();
        for ((x, line), observable) in done.iter().zip(&self.lines).zip(observable) {
            if let (Some(r), true) = (line.get(column), observable) {
                terms = terms + (*x * *r).abs();
            }
        }
        pivot.abs() <= T::INDEPENDENT * terms
    }

    /// Take line i out and rotate it in again without its pivot.
    pub(super) fn drop_pivot(&mut self, i: usize) -> T {
        if i >= N {
            return T::ZERO;
        }
        let (line, value, weight) = (self.lines[i], self.values[i], self.weights[i]);
        self.lines[i] = [T::ZERO; N];
        (self.values[i], self.weights[i]) = (T::ZERO, T::ZERO);
        self.include(line, value, weight).square()
    }

    /// Line i with its unit diagonal: what it says about the parameters.
    pub(super) fn line(&self, i: usize) -> [T; N] {
        let mut line = [T::ZERO; N];
        if let Some(from) = self.lines.get(i) {
            line = *from;
        }
        if let Some(pivot) = line.get_mut(i) {
            *pivot = T::ONE;
        }
        line
    }

    /// Σ w x_k² of everything that came in, per column.
    pub(super) fn information(&self) -> [T; N] {
        let mut columns = self.weights;
        for (i, (line, weight)) in self.lines.iter().zip(&self.weights).enumerate() {
            for (column, r) in columns.iter_mut().zip(line).skip(i + 1) {
                *column = *column + *weight * *r * *r;
            }
        }
        columns
    }

    /// Columns that hold more than rounding beyond the columns before them.
    pub(super) fn observable(&self) -> [bool; N] {
        let columns = self.information();
        let mut observable = [false; N];
        for ((observable, weight), column) in observable.iter_mut().zip(&self.weights).zip(&columns)
        {
            *observable = *weight > T::INDEPENDENT * T::INDEPENDENT * *column;
        }
        observable
    }

    /// θ̂, zero in unobservable columns.
    pub(super) fn solve(&self, observable: &[bool; N]) -> [T; N] {
        let mut params = [T::ZERO; N];
        for i in (0..N).rev() {
            if observable[i] {
                params[i] = self.values[i] - dot(&self.lines[i], &params, i + 1);
            }
        }
        params
    }

    /// The change of the parameters that no reading shows, with 1 at the unobservable column k.
    pub(super) fn direction(&self, k: usize, observable: &[bool; N]) -> [T; N] {
        let mut direction = [T::ZERO; N];
        if k < N {
            direction[k] = T::ONE;
            for i in (0..k).rev() {
                if observable[i] {
                    direction[i] = -dot(&self.lines[i], &direction, i + 1);
                }
            }
        }
        direction
    }

    /// Variance of `row`·θ̂ given the unobservable parameters, Σ p_i²/d_i with p = row R̄⁻¹,
    /// and whether the row asks for an unobservable one.
    pub(super) fn variance(&self, mut row: [T; N], observable: &[bool; N]) -> (T, bool) {
        let (mut variance, mut unobservable) = (T::ZERO, false);
        for i in 0..N {
            let Some((done, [pivot, rest @ ..])) = row.split_at_mut_checked(i) else {
                break;
            };
            let pivot = *pivot;
            if observable[i] {
                variance = variance + pivot * pivot / self.weights[i];
                for (x, r) in rest.iter_mut().zip(self.lines[i].iter().skip(i + 1)) {
                    *x = *x - pivot * *r;
                }
            } else {
                unobservable |= pivot != T::ZERO && !self.is_rounding(done, pivot, observable);
            }
        }
        (variance, unobservable)
    }

    /// R̄⁻¹ D⁻¹ R̄⁻ᵀ of the observable columns, in place; infinite variances elsewhere.
    pub(super) fn covariance(&self, observable: &[bool; N], out: &mut [[T; N]; N]) {
        // R̄⁻¹, line by line: v R̄ = e_a.
        for a in 0..N {
            let v = &mut out[a];
            *v = [T::ZERO; N];
            v[a] = T::ONE;
            for i in a..N {
                if !observable[i] {
                    v[i] = T::ZERO;
                    continue;
                }
                let pivot = v[i];
                for (x, r) in v.iter_mut().zip(&self.lines[i]).skip(i + 1) {
                    *x = *x - pivot * *r;
                }
            }
        }
        // Line a of the product needs only lines below it, which are still R̄⁻¹.
        for a in 0..N {
            let mut v = out[a];
            for (i, x) in v.iter_mut().enumerate() {
                if observable[i] {
                    *x = *x / self.weights[i];
                }
            }
            let mut product = [T::ZERO; N];
            for (b, (x, line)) in product.iter_mut().zip(out.iter()).enumerate().skip(a) {
                *x = dot(&v, line, b);
            }
            out[a] = product;
            if !observable[a] {
                out[a][a] = T::INFINITY;
            }
        }
        for a in 0..N {
            if let Some((above, [line, ..])) = out.split_at_mut_checked(a) {
                for (x, mirrored) in line.iter_mut().zip(above) {
                    *x = mirrored[a];
                }
            }
        }
    }
}

/// One rotation of a row and a line, right of the pivot.
fn rotate<T: Scalar>(row: &mut [T], line: &mut [T], pivot: T, c: T, s: T) {
    if c + c > T::ONE {
        for (x, r) in row.iter_mut().zip(line) {
            *x = *x - pivot * *r;
            *r = *r + s * *x;
        }
    } else {
        for (x, r) in row.iter_mut().zip(line) {
            let before = *x;
            *x = before - pivot * *r;
            *r = c * *r + s * before;
        }
    }
}

/// Σ a_k b_k from column `first` on.
fn dot<T: Scalar, const N: usize>(a: &[T; N], b: &[T; N], first: usize) -> T {
    let mut sum = T::ZERO;
    if let (Some(a), Some(b)) = (a.get(first..), b.get(first..)) {
        for (a, b) in a.iter().zip(b) {
            sum = sum + *a * *b;
        }
    }
    sum
}

//! One posture: its sines and cosines side by side, then its rows side by side.

use core::marker::PhantomData;

use super::Simd;
use super::sealed::{Machine, Task};
use crate::model::SescFromSinCos;
use crate::scalar::Scalar;

/// The functions of [`Sesc`](crate::Sesc) for one posture.
///
/// Sines and cosines are nine tenths of the work: here a register takes those of many
/// joints at once, another the rows of a Jacobian or regressor, and products are fused
/// with sums. For robots whose functions can be had
/// from sines and cosines: all but those with joints tied to others by fractions, or with
/// effects in their joints. An angle out of the domain of the sine may make all of a
/// Jacobian or regressor NaN, also what does not depend on it.
///
/// ```
/// use sesc_runtime::{Simd, Single, SescFromSinCos};
///
/// /// Metres.
/// fn height<M, const DOF: usize, const BASE: usize, const FULL: usize>(q: &[f64; DOF]) -> f64
/// where
///     M: SescFromSinCos<DOF, BASE, FULL>,
/// {
///     M::com_single(Simd::best(), q, &M::CAD_PARAMS)[2]
/// }
/// ```
pub trait Single<const DOF: usize, const BASE: usize, const FULL: usize>:
    SescFromSinCos<DOF, BASE, FULL>
{
    /// [`Sesc::com`](crate::Sesc::com), metres.
    #[inline]
    fn com_single<S: Scalar>(simd: Simd, q: &[S; DOF], r: &[S; BASE]) -> [S; 3] {
        let mut out = [S::default(); 3];
        S::run(
            simd,
            Com::<Self, S, DOF, BASE, FULL> {
                q,
                r,
                out: &mut out,
                model: PhantomData,
            },
        );
        out
    }

    /// [`Sesc::com_jacobian`](crate::Sesc::com_jacobian).
    #[inline]
    fn com_jacobian_single<S: Scalar>(simd: Simd, q: &[S; DOF], r: &[S; BASE]) -> [[S; DOF]; 3] {
        let mut jacobian = [[S::default(); DOF]; 3];
        Self::com_jacobian_single_into(simd, q, r, &mut jacobian);
        jacobian
    }

    /// The same into a matrix that is there: moving one costs a third of the time.
    #[inline]
    fn com_jacobian_single_into<S: Scalar>(
        simd: Simd,
        q: &[S; DOF],
        r: &[S; BASE],
        jacobian: &mut [[S; DOF]; 3],
    ) {
        S::run(
            simd,
            ComJacobian::<Self, S, DOF, BASE, FULL> {
                q,
                r,
                out: jacobian,
                model: PhantomData,
            },
        );
    }

    /// [`Sesc::gravity_moments`](crate::Sesc::gravity_moments), metres.
    #[inline]
    fn gravity_moments_single<S: Scalar>(simd: Simd, q: &[S; DOF], r: &[S; BASE]) -> [S; DOF] {
        let mut out = [S::default(); DOF];
        S::run(
            simd,
            GravityMoments::<Self, S, DOF, BASE, FULL> {
                q,
                r,
                out: &mut out,
                model: PhantomData,
            },
        );
        out
    }

    /// [`Sesc::regressor`](crate::Sesc::regressor).
    #[inline]
    fn regressor_single<S: Scalar>(simd: Simd, q: &[S; DOF]) -> [[S; BASE]; 3] {
        let mut rows = [[S::default(); BASE]; 3];
        Self::regressor_single_into(simd, q, &mut rows);
        rows
    }

    /// The same into a matrix that is there: moving one costs a third of the time.
    #[inline]
    fn regressor_single_into<S: Scalar>(simd: Simd, q: &[S; DOF], rows: &mut [[S; BASE]; 3]) {
        S::run(
            simd,
            Regressor::<Self, S, DOF, BASE, FULL> {
                q,
                out: rows,
                model: PhantomData,
            },
        );
    }

    /// [`Sesc::regressor_cop`](crate::Sesc::regressor_cop).
    #[inline]
    fn regressor_cop_single<S: Scalar>(simd: Simd, q: &[S; DOF]) -> [[S; BASE]; 2] {
        let mut rows = [[S::default(); BASE]; 2];
        Self::regressor_cop_single_into(simd, q, &mut rows);
        rows
    }

    /// The same into a matrix that is there: moving one costs a third of the time.
    #[inline]
    fn regressor_cop_single_into<S: Scalar>(simd: Simd, q: &[S; DOF], rows: &mut [[S; BASE]; 2]) {
        S::run(
            simd,
            RegressorCop::<Self, S, DOF, BASE, FULL> {
                q,
                out: rows,
                model: PhantomData,
            },
        );
    }

    /// [`Sesc::regressor_full`](crate::Sesc::regressor_full).
    #[inline]
    fn regressor_full_single<S: Scalar>(simd: Simd, q: &[S; DOF]) -> [[S; FULL]; 3] {
        let mut rows = [[S::default(); FULL]; 3];
        Self::regressor_full_single_into(simd, q, &mut rows);
        rows
    }

    /// The same into a matrix that is there: moving one costs a third of the time.
    #[inline]
    fn regressor_full_single_into<S: Scalar>(simd: Simd, q: &[S; DOF], rows: &mut [[S; FULL]; 3]) {
        S::run(
            simd,
            RegressorFull::<Self, S, DOF, BASE, FULL> {
                q,
                out: rows,
                model: PhantomData,
            },
        );
    }

    /// [`Sesc::cop`](crate::Sesc::cop), metres.
    #[inline]
    fn cop_single<S: Scalar>(simd: Simd, q: &[S; DOF], r: &[S; BASE]) -> [S; 2] {
        let mut out = [S::default(); 2];
        S::run(
            simd,
            Cop::<Self, S, DOF, BASE, FULL> {
                q,
                r,
                out: &mut out,
                model: PhantomData,
            },
        );
        out
    }
}

impl<M, const DOF: usize, const BASE: usize, const FULL: usize> Single<DOF, BASE, FULL> for M where
    M: SescFromSinCos<DOF, BASE, FULL> + ?Sized
{
}

/// What the functions of [`SescFromSinCos`] take. Written in place: a copy would load
/// across stores that have not left the core yet.
#[inline(always)]
fn sines<M, S, X, const DOF: usize, const BASE: usize, const FULL: usize>(
    q: &[S; DOF],
    sin: &mut [S; DOF],
    cos: &mut [S; DOF],
) where
    M: SescFromSinCos<DOF, BASE, FULL> + ?Sized,
    S: Scalar,
    X: Machine<S>,
{
    X::sin_cos(q, sin, cos);
    for ((sin, q), slides) in sin.iter_mut().zip(q).zip(M::PRISMATIC) {
        if slides {
            *sin = *q;
        }
    }
}

/// The same numbers in every row. (`map` of an array is compiled for itself, without the
/// instructions of the set.)
#[inline(always)]
fn every_row<S: Scalar, X: Machine<S>, const N: usize>(numbers: &[S; N]) -> [X::Rows; N] {
    let mut rows = [X::every_row(S::default()); N];
    for (row, x) in rows.iter_mut().zip(numbers) {
        *row = X::every_row(*x);
    }
    rows
}

/// The first rows of the unit matrix, each in its lane.
#[inline(always)]
fn axes<S: Scalar, X: Machine<S>>() -> [X::Rows; 3] {
    core::array::from_fn(|axis| {
        X::rows(core::array::from_fn(|row| {
            S::from_f64(if row == axis { 1.0 } else { 0.0 })
        }))
    })
}

/// What tasks have in common.
macro_rules! fields {
    ($name:ident, $($r:ident)?, $out:ty) => {
        struct $name<'a, M, S, const DOF: usize, const BASE: usize, const FULL: usize>
        where
            M: ?Sized,
            S: Scalar,
        {
            q: &'a [S; DOF],
            $($r: &'a [S; BASE],)?
            out: &'a mut $out,
            model: PhantomData<M>,
        }
    };
}

/// A vector of one posture, as a task for any set of instructions.
macro_rules! vector {
    ($name:ident, $method:ident -> $n:tt) => {
        fields!($name, r, [S; $n]);

        impl<M, S, const DOF: usize, const BASE: usize, const FULL: usize> Task<S>
            for $name<'_, M, S, DOF, BASE, FULL>
        where
            M: SescFromSinCos<DOF, BASE, FULL> + ?Sized,
            S: Scalar,
        {
            #[inline(always)]
            fn run<X: Machine<S>>(self) {
                let (mut sin, mut cos) = ([S::default(); DOF], [S::default(); DOF]);
                sines::<M, S, X, DOF, BASE, FULL>(self.q, &mut sin, &mut cos);
                let value = M::$method(X::ones(&sin), X::ones(&cos), X::ones(self.r));
                self.out.copy_from_slice(X::scalars(&value));
            }
        }
    };
}

/// Rows of one posture side by side, as a task likewise.
macro_rules! rows {
    ($name:ident, $method:ident($($r:ident)?) -> [$n:tt; $m:literal]) => {
        fields!($name, $($r)?, [[S; $n]; $m]);

        impl<M, S, const DOF: usize, const BASE: usize, const FULL: usize> Task<S>
            for $name<'_, M, S, DOF, BASE, FULL>
        where
            M: SescFromSinCos<DOF, BASE, FULL> + ?Sized,
            S: Scalar,
        {
            #[inline(always)]
            fn run<X: Machine<S>>(self) {
                let (mut sin, mut cos) = ([S::default(); DOF], [S::default(); DOF]);
                sines::<M, S, X, DOF, BASE, FULL>(self.q, &mut sin, &mut cos);
                let (sin, cos) = (every_row::<S, X, DOF>(&sin), every_row::<S, X, DOF>(&cos));
                $(let $r = every_row::<S, X, BASE>(self.$r);)?
                let columns = M::$method(&sin, &cos, $(&$r,)? &axes::<S, X>());
                for (row, out) in self.out.iter_mut().enumerate() {
                    for (x, column) in out.iter_mut().zip(&columns) {
                        *x = X::numbers(*column)[row];
                    }
                }
            }
        }
    };
}

vector!(Com, com_sc -> 3);
vector!(GravityMoments, gravity_moments_sc -> DOF);
vector!(Cop, cop_sc -> 2);
rows!(ComJacobian, com_jacobian_along(r) -> [DOF; 3]);
rows!(Regressor, regressor_along() -> [BASE; 3]);
rows!(RegressorCop, regressor_along() -> [BASE; 2]);
rows!(RegressorFull, regressor_full_along() -> [FULL; 3]);

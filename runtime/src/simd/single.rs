//! One posture, its sines and cosines side by side.

use core::marker::PhantomData;

use super::sealed::{Machine, Task};
use super::{Scalar, Simd};
use crate::model::SescFromSinCos;

/// The functions of [`Sesc`](crate::Sesc) for one posture.
///
/// Sines and cosines are nine tenths of the work: here a register takes those of many
/// joints at once, and products are fused with sums. For robots whose functions can be had
/// from sines and cosines: all but those with joints tied to others by fractions, or with
/// effects in their joints.
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
        let mut out = [[S::default(); DOF]; 3];
        S::run(
            simd,
            ComJacobian::<Self, S, DOF, BASE, FULL> {
                q,
                r,
                out: &mut out,
                model: PhantomData,
            },
        );
        out
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
        let mut out = [[S::default(); BASE]; 3];
        S::run(
            simd,
            Regressor::<Self, S, DOF, BASE, FULL> {
                q,
                out: &mut out,
                model: PhantomData,
            },
        );
        out
    }

    /// [`Sesc::regressor_cop`](crate::Sesc::regressor_cop).
    #[inline]
    fn regressor_cop_single<S: Scalar>(simd: Simd, q: &[S; DOF]) -> [[S; BASE]; 2] {
        let mut out = [[S::default(); BASE]; 2];
        S::run(
            simd,
            RegressorCop::<Self, S, DOF, BASE, FULL> {
                q,
                out: &mut out,
                model: PhantomData,
            },
        );
        out
    }

    /// [`Sesc::regressor_full`](crate::Sesc::regressor_full).
    #[inline]
    fn regressor_full_single<S: Scalar>(simd: Simd, q: &[S; DOF]) -> [[S; FULL]; 3] {
        let mut out = [[S::default(); FULL]; 3];
        S::run(
            simd,
            RegressorFull::<Self, S, DOF, BASE, FULL> {
                q,
                out: &mut out,
                model: PhantomData,
            },
        );
        out
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

/// A function of one posture, as a task for any set of instructions.
macro_rules! task {
    ($name:ident, $method:ident($($r:ident)?) -> $shape:tt) => {
        struct $name<'a, M, S, const DOF: usize, const BASE: usize, const FULL: usize>
        where
            M: ?Sized,
            S: Scalar,
        {
            q: &'a [S; DOF],
            $($r: &'a [S; BASE],)?
            out: &'a mut task!(@of S, $shape),
            model: PhantomData<M>,
        }

        impl<M, S, const DOF: usize, const BASE: usize, const FULL: usize> Task<S>
            for $name<'_, M, S, DOF, BASE, FULL>
        where
            M: SescFromSinCos<DOF, BASE, FULL> + ?Sized,
            S: Scalar,
        {
            #[inline(always)]
            fn run<X: Machine<S>>(self) {
                let (mut sin, mut cos) = ([S::default(); DOF], [S::default(); DOF]);
                X::sin_cos(self.q, &mut sin, &mut cos);
                for ((sin, q), slides) in sin.iter_mut().zip(self.q).zip(M::SLIDING) {
                    if slides {
                        *sin = *q;
                    }
                }
                let value = M::$method(X::ones(&sin), X::ones(&cos), $(X::ones(self.$r))?);
                let value = X::scalars(task!(@flat &value, $shape));
                task!(@flat self.out, $shape, mut).copy_from_slice(value);
            }
        }
    };
    (@of $t:ty, [$n:tt]) => { [$t; $n] };
    (@of $t:ty, [$n:ident; $m:literal]) => { [[$t; $n]; $m] };
    (@flat $array:expr, [$n:tt]$(, mut)?) => { $array };
    (@flat $array:expr, [$n:ident; $m:literal]) => { ($array).as_flattened() };
    (@flat $array:expr, [$n:ident; $m:literal], mut) => { $array.as_flattened_mut() };
}

task!(Com, com_sc(r) -> [3]);
task!(ComJacobian, com_jacobian_sc(r) -> [DOF; 3]);
task!(GravityMoments, gravity_moments_sc(r) -> [DOF]);
task!(Regressor, regressor_sc() -> [BASE; 3]);
task!(RegressorCop, regressor_cop_sc() -> [BASE; 2]);
task!(RegressorFull, regressor_full_sc() -> [FULL; 3]);
task!(Cop, cop_sc(r) -> [2]);

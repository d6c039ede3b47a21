//! Many postures, one per lane.

use core::marker::PhantomData;

use super::sealed::{Dispatch, Machine, Task};
use super::{Block, Simd};
use crate::model::Sesc;
use crate::scalar::Scalar;

/// The functions of [`Sesc`] on blocks of postures.
///
/// A block is a cache line per joint: eight postures in `f64`, sixteen in `f32`, as
/// [`pack`](crate::pack) lays them out. Block k of the results belongs to block k of
/// the postures; of the longer slice, the rest is left as it is. A lane out of the domain
/// of the sine is NaN and leaves its neighbours alone.
///
/// ```
/// use sesc_runtime::{Batch, F64x8, Sesc, Simd, pack};
///
/// /// Heights of the CoM, metres, of eight postures.
/// fn heights<M, const DOF: usize, const BASE: usize, const FULL: usize>(
///     postures: &[[f64; DOF]; 8],
/// ) -> F64x8
/// where
///     M: Sesc<DOF, BASE, FULL>,
/// {
///     let mut com = [[F64x8::splat(0.0); 3]];
///     M::com_batch(Simd::best(), &[pack(postures)], &M::CAD_PARAMS, &mut com);
///     com[0][2]
/// }
/// ```
pub trait Batch<const DOF: usize, const BASE: usize, const FULL: usize>:
    Sesc<DOF, BASE, FULL>
{
    /// [`Sesc::com`] of every posture, metres.
    fn com_batch<B: Block>(simd: Simd, q: &[[B; DOF]], r: &[B::Scalar; BASE], com: &mut [[B; 3]]) {
        B::Scalar::run(
            simd,
            Com::<Self, B::Scalar, DOF, BASE, FULL> {
                q,
                r,
                out: com,
                model: PhantomData,
            },
        );
    }

    /// [`Sesc::com_jacobian`] of every posture.
    fn com_jacobian_batch<B: Block>(
        simd: Simd,
        q: &[[B; DOF]],
        r: &[B::Scalar; BASE],
        jacobian: &mut [[[B; DOF]; 3]],
    ) {
        B::Scalar::run(
            simd,
            ComJacobian::<Self, B::Scalar, DOF, BASE, FULL> {
                q,
                r,
                out: jacobian,
                model: PhantomData,
            },
        );
    }

    /// [`Sesc::gravity_moments`] of every posture.
    fn gravity_moments_batch<B: Block>(
        simd: Simd,
        q: &[[B; DOF]],
        r: &[B::Scalar; BASE],
        moments: &mut [[B; DOF]],
    ) {
        B::Scalar::run(
            simd,
            GravityMoments::<Self, B::Scalar, DOF, BASE, FULL> {
                q,
                r,
                out: moments,
                model: PhantomData,
            },
        );
    }

    /// [`Sesc::regressor`] of every posture.
    fn regressor_batch<B: Block>(simd: Simd, q: &[[B; DOF]], rows: &mut [[[B; BASE]; 3]]) {
        B::Scalar::run(
            simd,
            Regressor::<Self, B::Scalar, DOF, BASE, FULL> {
                q,
                out: rows,
                model: PhantomData,
            },
        );
    }

    /// [`Sesc::regressor_cop`] of every posture.
    fn regressor_cop_batch<B: Block>(simd: Simd, q: &[[B; DOF]], rows: &mut [[[B; BASE]; 2]]) {
        B::Scalar::run(
            simd,
            RegressorCop::<Self, B::Scalar, DOF, BASE, FULL> {
                q,
                out: rows,
                model: PhantomData,
            },
        );
    }

    /// [`Sesc::regressor_full`] of every posture.
    fn regressor_full_batch<B: Block>(simd: Simd, q: &[[B; DOF]], rows: &mut [[[B; FULL]; 3]]) {
        B::Scalar::run(
            simd,
            RegressorFull::<Self, B::Scalar, DOF, BASE, FULL> {
                q,
                out: rows,
                model: PhantomData,
            },
        );
    }

    /// [`Sesc::cop`] of every posture, metres.
    fn cop_batch<B: Block>(simd: Simd, q: &[[B; DOF]], r: &[B::Scalar; BASE], cop: &mut [[B; 2]]) {
        B::Scalar::run(
            simd,
            Cop::<Self, B::Scalar, DOF, BASE, FULL> {
                q,
                r,
                out: cop,
                model: PhantomData,
            },
        );
    }
}

impl<M, const DOF: usize, const BASE: usize, const FULL: usize> Batch<DOF, BASE, FULL> for M where
    M: Sesc<DOF, BASE, FULL> + ?Sized
{
}

/// A function over all blocks, as a task for any set of instructions: `$result` of one
/// part of a block, from joint positions `$q` and parameters `$r`.
macro_rules! task {
    (
        @task $name:ident, $out:ty, ($($r:ident)?), $room:ident = [$start:expr],
        |$q:ident, $block:ident, $part:ident| $result:expr
    ) => {
        struct $name<'a, M, S, const DOF: usize, const BASE: usize, const FULL: usize>
        where
            M: ?Sized,
            S: Scalar,
        {
            q: &'a [[S::Block; DOF]],
            $($r: &'a [S; BASE],)?
            out: &'a mut [$out],
            model: PhantomData<M>,
        }

        impl<M, S, const DOF: usize, const BASE: usize, const FULL: usize> Task<S>
            for $name<'_, M, S, DOF, BASE, FULL>
        where
            M: Sesc<DOF, BASE, FULL> + ?Sized,
            S: Scalar,
        {
            #[inline(always)]
            fn run<X: Machine<S>>(self) {
                $(let $r: [X::Vector; BASE] = core::array::from_fn(|k| X::splat(self.$r[k]));)?
                #[allow(unused_mut, clippy::let_unit_value)] // vectors need no room
                let mut $room = $start;
                for (q, $block) in self.q.iter().zip(self.out) {
                    for $part in 0..X::PARTS {
                        let $q = &X::load(q, $part);
                        $result;
                    }
                }
            }
        }
    };
    ($name:ident, $method:ident($($r:ident)?) -> [$n:tt]) => {
        task!(@task $name, [S::Block; $n], ($($r)?), _room = [()], |q, block, part| {
            X::store(&M::$method(q, $(&$r)?), block, part)
        });
    };
    ($name:ident, $method:ident($($r:ident)?) -> [$n:ident; $m:literal]) => {
        task!(@task $name, [[S::Block; $n]; $m], ($($r)?), room = [
            [[X::splat(S::default()); $n]; $m]
        ], |q, block, part| {
            M::$method(q, $(&$r,)? X::place(block, &mut room));
            X::settle(&room, block, part);
        });
    };
}

task!(Com, com(r) -> [3]);
task!(ComJacobian, com_jacobian_into(r) -> [DOF; 3]);
task!(GravityMoments, gravity_moments(r) -> [DOF]);
task!(Regressor, regressor_into() -> [BASE; 3]);
task!(RegressorCop, regressor_cop_into() -> [BASE; 2]);
task!(RegressorFull, regressor_full_into() -> [FULL; 3]);
task!(Cop, cop(r) -> [2]);

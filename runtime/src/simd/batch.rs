//! Many postures, one per lane.

use crate::__private::v1::{Array, Robot};
use crate::dim::Dim;
use crate::model::{FullParams, Params, Posture, Sesc};
use crate::scalar::sealed::{Dispatch, Machine, Task};
use crate::scalar::{Block, Scalar, Simd};

/// The functions of [`Sesc`] on blocks of postures.
///
/// A block is a cache line per joint: eight postures in `f64`, sixteen in `f32`, as
/// [`pack`](crate::pack) lays them out. Block k of the results belongs to block k of
/// the postures; of the longer slice, the rest is left as it is. A lane out of the domain
/// of the sine is NaN and leaves its neighbours alone.
///
/// ```
/// use sesc_generated::two_link_foot::TwoLinkFoot;
/// use sesc_runtime::{Batch, F64x8, Sesc, Simd, pack};
///
/// /// Heights of the CoM of any robot, metres, in eight postures.
/// fn heights<R: Sesc>(postures: &[sesc_runtime::Posture<R, F64x8>]) -> F64x8 {
///     let mut com = [[F64x8::splat(0.0); 3]];
///     R::com_batch(Simd::best(), postures, &R::CAD_PARAMS, &mut com);
///     com[0][2]
/// }
///
/// let postures = core::array::from_fn(|k| [0.1 * k as f64, 0.0]);
/// let heights = heights::<TwoLinkFoot>(&[pack(&postures)]);
/// assert!((heights.0[0] - 0.45).abs() < 1e-15 && heights.0[7] < heights.0[0]);
/// ```
pub trait Batch: Sesc {
    /// [`Sesc::com`] of every posture, metres.
    ///
    /// ```
    /// # use sesc_generated::two_link_foot::{CAD_PARAMS, TwoLinkFoot};
    /// # use sesc_runtime::{Batch, F64x8, Simd};
    /// # let q = [[F64x8::splat(0.0); 2]];
    /// let mut com = [[F64x8::splat(0.0); 3]];
    /// TwoLinkFoot::com_batch(Simd::best(), &q, &CAD_PARAMS, &mut com);
    /// assert!((com[0][2].0[0] - 0.45).abs() < 1e-15);
    /// ```
    fn com_batch<B: Block>(
        simd: Simd,
        q: &[Posture<Self, B>],
        r: &Params<Self, B::Scalar>,
        com: &mut [[B; 3]],
    ) {
        B::Scalar::run(simd, Com::<Self::Generated, B::Scalar> { q, r, out: com });
    }

    /// [`Sesc::com_jacobian`] of every posture.
    ///
    /// ```
    /// # use sesc_generated::two_link_foot::{CAD_PARAMS, TwoLinkFoot};
    /// # use sesc_runtime::{Batch, F64x8, Simd};
    /// # let q = [[F64x8::splat(0.0); 2]];
    /// let mut jacobian = [[[F64x8::splat(0.0); 2]; 3]];
    /// TwoLinkFoot::com_jacobian_batch(Simd::best(), &q, &CAD_PARAMS, &mut jacobian);
    /// assert!((jacobian[0][0][0].0[0] - 0.36).abs() < 1e-15);
    /// ```
    fn com_jacobian_batch<B: Block>(
        simd: Simd,
        q: &[Posture<Self, B>],
        r: &Params<Self, B::Scalar>,
        jacobian: &mut [[Posture<Self, B>; 3]],
    ) {
        let out = jacobian;
        B::Scalar::run(
            simd,
            ComJacobian::<Self::Generated, B::Scalar> { q, r, out },
        );
    }

    /// [`Sesc::com_velocity`] of every posture with its joint velocities, m/s.
    ///
    /// ```
    /// # use sesc_generated::two_link_foot::{CAD_PARAMS, TwoLinkFoot};
    /// # use sesc_runtime::{Batch, F64x8, Simd};
    /// # let q = [[F64x8::splat(0.0); 2]];
    /// let qd = [[F64x8::splat(1.0), F64x8::splat(0.0)]]; // rad/s
    /// let mut velocity = [[F64x8::splat(0.0); 3]];
    /// TwoLinkFoot::com_velocity_batch(Simd::best(), &q, &qd, &CAD_PARAMS, &mut velocity);
    /// assert!((velocity[0][0].0[0] - 0.36).abs() < 1e-15);
    /// ```
    fn com_velocity_batch<B: Block>(
        simd: Simd,
        q: &[Posture<Self, B>],
        qd: &[Posture<Self, B>],
        r: &Params<Self, B::Scalar>,
        velocity: &mut [[B; 3]],
    ) {
        let out = velocity;
        B::Scalar::run(
            simd,
            ComVelocity::<Self::Generated, B::Scalar> { q, qd, r, out },
        );
    }

    /// [`Sesc::gravity_moments`] of every posture, metres.
    ///
    /// ```
    /// # use sesc_generated::two_link_foot::{CAD_PARAMS, TwoLinkFoot};
    /// # use sesc_runtime::{Batch, F64x8, Simd};
    /// # let q = [[F64x8::splat(0.0); 2]];
    /// let mut moments = [[F64x8::splat(1.0); 2]];
    /// TwoLinkFoot::gravity_moments_batch(Simd::best(), &q, &CAD_PARAMS, &mut moments);
    /// assert_eq!(moments[0][0].0, [0.0; 8]);
    /// ```
    fn gravity_moments_batch<B: Block>(
        simd: Simd,
        q: &[Posture<Self, B>],
        r: &Params<Self, B::Scalar>,
        moments: &mut [Posture<Self, B>],
    ) {
        B::Scalar::run(
            simd,
            GravityMoments::<Self::Generated, B::Scalar> { q, r, out: moments },
        );
    }

    /// [`Sesc::regressor`] of every posture.
    ///
    /// ```
    /// # use sesc_generated::two_link_foot::TwoLinkFoot;
    /// # use sesc_runtime::{Batch, F64x8, Simd};
    /// # let q = [[F64x8::splat(0.0); 2]];
    /// let mut rows = [[[F64x8::splat(0.0); 7]; 3]];
    /// TwoLinkFoot::regressor_batch(Simd::best(), &q, &mut rows);
    /// assert_eq!(rows[0][2][2].0, [1.0; 8]);
    /// ```
    fn regressor_batch<B: Block>(
        simd: Simd,
        q: &[Posture<Self, B>],
        rows: &mut [[Params<Self, B>; 3]],
    ) {
        B::Scalar::run(
            simd,
            Regressor::<Self::Generated, B::Scalar> { q, out: rows },
        );
    }

    /// [`Sesc::regressor_cop`] of every posture.
    ///
    /// ```
    /// # use sesc_generated::two_link_foot::TwoLinkFoot;
    /// # use sesc_runtime::{Batch, F64x8, Simd};
    /// # let q = [[F64x8::splat(0.0); 2]];
    /// let mut rows = [[[F64x8::splat(0.0); 7]; 2]];
    /// TwoLinkFoot::regressor_cop_batch(Simd::best(), &q, &mut rows);
    /// assert_eq!(rows[0][0][0].0, [1.0; 8]);
    /// ```
    fn regressor_cop_batch<B: Block>(
        simd: Simd,
        q: &[Posture<Self, B>],
        rows: &mut [[Params<Self, B>; 2]],
    ) {
        B::Scalar::run(
            simd,
            RegressorCop::<Self::Generated, B::Scalar> { q, out: rows },
        );
    }

    /// [`Sesc::regressor_full`] of every posture.
    ///
    /// ```
    /// # use sesc_generated::two_link_foot::TwoLinkFoot;
    /// # use sesc_runtime::{Batch, F64x8, Simd};
    /// # let q = [[F64x8::splat(0.0); 2]];
    /// let mut rows = [[[F64x8::splat(0.0); 9]; 3]];
    /// TwoLinkFoot::regressor_full_batch(Simd::best(), &q, &mut rows);
    /// assert_eq!(rows[0][1][1].0, [1.0; 8]);
    /// ```
    fn regressor_full_batch<B: Block>(
        simd: Simd,
        q: &[Posture<Self, B>],
        rows: &mut [[FullParams<Self, B>; 3]],
    ) {
        B::Scalar::run(
            simd,
            RegressorFull::<Self::Generated, B::Scalar> { q, out: rows },
        );
    }

    /// [`Sesc::cop`] of every posture, metres.
    ///
    /// ```
    /// # use sesc_generated::two_link_foot::{CAD_PARAMS, TwoLinkFoot};
    /// # use sesc_runtime::{Batch, F64x8, Simd};
    /// # let q = [[F64x8::splat(0.0); 2]];
    /// let mut cop = [[F64x8::splat(0.0); 2]];
    /// TwoLinkFoot::cop_batch(Simd::best(), &q, &CAD_PARAMS, &mut cop);
    /// assert!((cop[0][0].0[0] - 0.01).abs() < 1e-15);
    /// ```
    fn cop_batch<B: Block>(
        simd: Simd,
        q: &[Posture<Self, B>],
        r: &Params<Self, B::Scalar>,
        cop: &mut [[B; 2]],
    ) {
        B::Scalar::run(simd, Cop::<Self::Generated, B::Scalar> { q, r, out: cop });
    }

    /// [`Sesc::zmp`] of every posture with its joint velocities and accelerations, metres.
    ///
    /// ```
    /// # use sesc_generated::two_link_foot::{CAD_PARAMS, TwoLinkFoot};
    /// # use sesc_runtime::{Batch, F64x8, Simd};
    /// # let q = [[F64x8::splat(0.0); 2]];
    /// let still = [[F64x8::splat(0.0); 2]];
    /// let mut zmp = [[F64x8::splat(0.0); 2]];
    /// TwoLinkFoot::zmp_batch(Simd::best(), &q, &still, &still, &CAD_PARAMS, &mut zmp);
    /// assert!((zmp[0][0].0[0] - 0.01).abs() < 1e-15);
    /// ```
    fn zmp_batch<B: Block>(
        simd: Simd,
        q: &[Posture<Self, B>],
        qd: &[Posture<Self, B>],
        qdd: &[Posture<Self, B>],
        r: &Params<Self, B::Scalar>,
        zmp: &mut [[B; 2]],
    ) {
        let out = zmp;
        B::Scalar::run(
            simd,
            Zmp::<Self::Generated, B::Scalar> { q, qd, qdd, r, out },
        );
    }
}

impl<M: Sesc> Batch for M {}

/// A function over all blocks, as a task for any set of instructions: `$result` of one
/// part of a block, from joint positions `$q`, their `$motion` and parameters `$r`.
macro_rules! task {
    (
        @task $name:ident, $out:ty, ($($r:ident)? $(; $($motion:ident)*)?),
        $room:ident = [$start:expr], |$q:ident, $block:ident, $part:ident| $result:expr
    ) => {
        struct $name<'a, M: Robot, S: Scalar> {
            q: &'a [Array<M::Dof, S::Block>],
            $($($motion: &'a [Array<M::Dof, S::Block>],)*)?
            $($r: &'a Array<M::Base, S>,)?
            out: &'a mut [$out],
        }

        impl<M: Robot, S: Scalar> Task<S> for $name<'_, M, S> {
            #[inline(always)]
            fn run<X: Machine<S>>(self) {
                $(let $r = <M::Base as Dim>::from_fn(|k| X::splat(self.$r[k]));)?
                #[allow(unused_mut, clippy::let_unit_value)] // vectors need no room
                let mut $room = $start;
                $($(let mut $motion = self.$motion.iter();)*)?
                for (q, $block) in self.q.iter().zip(self.out) {
                    $($(let Some($motion) = $motion.next() else { break };)*)?
                    for $part in 0..X::PARTS {
                        let $q = &<M::Dof as Dim>::load::<S, X>(q, $part);
                        $($(let $motion = &<M::Dof as Dim>::load::<S, X>($motion, $part);)*)?
                        $result;
                    }
                }
            }
        }
    };
    ($name:ident, $method:ident(r $(; $($motion:ident)*)?) -> $n:literal) => {
        task!(@task $name, [S::Block; $n], (r $(; $($motion)*)?), _room = [()], |q, block, part| {
            X::store(&M::$method(q, $($($motion,)*)? &r), block, part)
        });
    };
    ($name:ident, $method:ident(r) -> $n:ident) => {
        task!(@task $name, Array<M::$n, S::Block>, (r), _room = [()], |q, block, part| {
            X::store(M::$method(q, &r).as_ref(), block.as_mut(), part)
        });
    };
    ($name:ident, $method:ident($($r:ident)?) -> [$n:ident; $m:literal]) => {
        task!(@task $name, [Array<M::$n, S::Block>; $m], ($($r)?), room = [
            [<M::$n as Dim>::filled(X::splat(S::ZERO)); $m]
        ], |q, block, part| {
            M::$method(q, $(&$r,)? <M::$n as Dim>::place::<S, X, $m>(block, &mut room));
            if X::PARTS > 1 {
                for (room, row) in room.iter().zip(block.iter_mut()) {
                    X::store(room.as_ref(), row.as_mut(), part);
                }
            }
        });
    };
}

task!(Com, com(r) -> 3);
task!(ComJacobian, com_jacobian_into(r) -> [Dof; 3]);
task!(ComVelocity, com_velocity(r; qd) -> 3);
task!(GravityMoments, gravity_moments(r) -> Dof);
task!(Regressor, regressor_into() -> [Base; 3]);
task!(RegressorCop, regressor_cop_into() -> [Base; 2]);
task!(RegressorFull, regressor_full_into() -> [Full; 3]);
task!(Cop, cop(r) -> 2);
task!(Zmp, zmp(r; qd qdd) -> 2);

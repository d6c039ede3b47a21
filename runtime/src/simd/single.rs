//! One posture: its sines and cosines side by side, then its rows side by side.

use crate::__private::v1::{Array, SinCosRobot};
use crate::dim::Dim;
use crate::from_sin_cos::SescFromSinCos;
use crate::model::{FullParams, Params, Posture};
use crate::scalar::sealed::{Machine, Task};
use crate::scalar::{Scalar, Simd};

/// The functions of [`Sesc`](crate::Sesc) for one posture.
///
/// Sines and cosines are nine tenths of the work: here a register takes those of many
/// joints at once, another the rows of a Jacobian or regressor, and products are fused
/// with sums. For robots whose functions can be had from sines and cosines of what encoders
/// read: not where a joint follows another by a fraction of its angle, nor with a model that
/// has `joint_scale` or angles in degrees (`units`), as sines of q do not give those of
/// 1.03 q; [`Batch`](crate::Batch) serves those. Offsets, loads, springs and backlash of a
/// model are part of it. An angle out of the domain of the sine may make all of a Jacobian
/// or regressor NaN, also what does not depend on it.
///
/// ```
/// use sesc_generated::two_link_foot::TwoLinkFoot;
/// use sesc_runtime::{Posture, SescFromSinCos, Simd, Single};
///
/// /// Height of the CoM of any robot, metres.
/// fn height<R: SescFromSinCos>(q: &Posture<R>) -> f64 {
///     R::com_single(Simd::best(), q, &R::CAD_PARAMS)[2]
/// }
///
/// assert!((height::<TwoLinkFoot>(&[0.0, 0.0]) - 0.45).abs() < 1e-15);
/// ```
pub trait Single: SescFromSinCos {
    /// [`Sesc::com`](crate::Sesc::com), metres.
    ///
    /// ```
    /// # use sesc_generated::two_link_foot::{CAD_PARAMS, TwoLinkFoot};
    /// # use sesc_runtime::{Simd, Single};
    /// # let q = [0.0_f64, 0.0];
    /// let com = TwoLinkFoot::com_single(Simd::best(), &q, &CAD_PARAMS);
    /// assert!((com[2] - 0.45).abs() < 1e-15);
    /// ```
    #[inline]
    fn com_single<S: Scalar>(simd: Simd, q: &Posture<Self, S>, r: &Params<Self, S>) -> [S; 3] {
        let mut value = [S::ZERO; 3];
        let out = &mut value;
        S::run(simd, Com::<Self::GeneratedSinCos, S> { q, r, out });
        value
    }

    /// [`Sesc::com_jacobian`](crate::Sesc::com_jacobian).
    ///
    /// ```
    /// # use sesc_generated::two_link_foot::{CAD_PARAMS, TwoLinkFoot};
    /// # use sesc_runtime::{Simd, Single};
    /// # let q = [0.0_f64, 0.0];
    /// let jacobian = TwoLinkFoot::com_jacobian_single(Simd::best(), &q, &CAD_PARAMS);
    /// assert!((jacobian[0][0] - 0.36).abs() < 1e-15);
    /// ```
    #[inline]
    fn com_jacobian_single<S: Scalar>(
        simd: Simd,
        q: &Posture<Self, S>,
        r: &Params<Self, S>,
    ) -> [Posture<Self, S>; 3] {
        let mut jacobian = [<Self::Dof as Dim>::filled(S::ZERO); 3];
        Self::com_jacobian_single_into(simd, q, r, &mut jacobian);
        jacobian
    }

    /// The same into the caller's matrix: a copy costs a third of the time.
    ///
    /// ```
    /// # use sesc_generated::two_link_foot::{CAD_PARAMS, TwoLinkFoot};
    /// # use sesc_runtime::{Simd, Single};
    /// # let q = [0.0_f64, 0.0];
    /// let mut jacobian = [[0.0; 2]; 3];
    /// TwoLinkFoot::com_jacobian_single_into(Simd::best(), &q, &CAD_PARAMS, &mut jacobian);
    /// assert!((jacobian[0][0] - 0.36).abs() < 1e-15);
    /// ```
    #[inline]
    fn com_jacobian_single_into<S: Scalar>(
        simd: Simd,
        q: &Posture<Self, S>,
        r: &Params<Self, S>,
        jacobian: &mut [Posture<Self, S>; 3],
    ) {
        let out = jacobian;
        S::run_rows(simd, ComJacobian::<Self::GeneratedSinCos, S> { q, r, out });
    }

    /// [`Sesc::com_velocity`](crate::Sesc::com_velocity), m/s.
    ///
    /// ```
    /// # use sesc_generated::two_link_foot::{CAD_PARAMS, TwoLinkFoot};
    /// # use sesc_runtime::{Simd, Single};
    /// # let q = [0.0_f64, 0.0];
    /// let qd = [1.0, 0.0]; // rad/s
    /// let velocity = TwoLinkFoot::com_velocity_single(Simd::best(), &q, &qd, &CAD_PARAMS);
    /// assert!((velocity[0] - 0.36).abs() < 1e-15);
    /// ```
    #[inline]
    fn com_velocity_single<S: Scalar>(
        simd: Simd,
        q: &Posture<Self, S>,
        qd: &Posture<Self, S>,
        r: &Params<Self, S>,
    ) -> [S; 3] {
        let mut value = [S::ZERO; 3];
        let out = &mut value;
        S::run(
            simd,
            ComVelocity::<Self::GeneratedSinCos, S> { q, qd, r, out },
        );
        value
    }

    /// [`Sesc::gravity_moments`](crate::Sesc::gravity_moments), metres.
    ///
    /// ```
    /// # use sesc_generated::two_link_foot::{CAD_PARAMS, TwoLinkFoot};
    /// # use sesc_runtime::{Simd, Single};
    /// # let q = [0.0_f64, 0.0];
    /// let moments = TwoLinkFoot::gravity_moments_single(Simd::best(), &q, &CAD_PARAMS);
    /// assert_eq!(moments, [0.0, 0.0]);
    /// ```
    #[inline]
    fn gravity_moments_single<S: Scalar>(
        simd: Simd,
        q: &Posture<Self, S>,
        r: &Params<Self, S>,
    ) -> Posture<Self, S> {
        let mut value = <Self::Dof as Dim>::filled(S::ZERO);
        let out = &mut value;
        S::run(
            simd,
            GravityMoments::<Self::GeneratedSinCos, S> { q, r, out },
        );
        value
    }

    /// [`Sesc::regressor`](crate::Sesc::regressor).
    ///
    /// ```
    /// # use sesc_generated::two_link_foot::TwoLinkFoot;
    /// # use sesc_runtime::{Simd, Single};
    /// # let q = [0.0_f64, 0.0];
    /// let rows = TwoLinkFoot::regressor_single(Simd::best(), &q);
    /// assert_eq!(rows[2][2], 1.0);
    /// ```
    #[inline]
    fn regressor_single<S: Scalar>(simd: Simd, q: &Posture<Self, S>) -> [Params<Self, S>; 3] {
        let mut rows = [<Self::Base as Dim>::filled(S::ZERO); 3];
        Self::regressor_single_into(simd, q, &mut rows);
        rows
    }

    /// The same into the caller's matrix: a copy costs a third of the time.
    ///
    /// ```
    /// # use sesc_generated::two_link_foot::TwoLinkFoot;
    /// # use sesc_runtime::{Simd, Single};
    /// # let q = [0.0_f64, 0.0];
    /// let mut rows = [[0.0; 7]; 3];
    /// TwoLinkFoot::regressor_single_into(Simd::best(), &q, &mut rows);
    /// assert_eq!(rows[2][2], 1.0);
    /// ```
    #[inline]
    fn regressor_single_into<S: Scalar>(
        simd: Simd,
        q: &Posture<Self, S>,
        rows: &mut [Params<Self, S>; 3],
    ) {
        S::run_rows(simd, Regressor::<Self::GeneratedSinCos, S> { q, out: rows });
    }

    /// [`Sesc::regressor_cop`](crate::Sesc::regressor_cop).
    ///
    /// ```
    /// # use sesc_generated::two_link_foot::TwoLinkFoot;
    /// # use sesc_runtime::{Simd, Single};
    /// # let q = [0.0_f64, 0.0];
    /// let rows = TwoLinkFoot::regressor_cop_single(Simd::best(), &q);
    /// assert_eq!(rows[0][0], 1.0);
    /// ```
    #[inline]
    fn regressor_cop_single<S: Scalar>(simd: Simd, q: &Posture<Self, S>) -> [Params<Self, S>; 2] {
        let mut rows = [<Self::Base as Dim>::filled(S::ZERO); 2];
        Self::regressor_cop_single_into(simd, q, &mut rows);
        rows
    }

    /// The same into the caller's matrix: a copy costs a third of the time.
    ///
    /// ```
    /// # use sesc_generated::two_link_foot::TwoLinkFoot;
    /// # use sesc_runtime::{Simd, Single};
    /// # let q = [0.0_f64, 0.0];
    /// let mut rows = [[0.0; 7]; 2];
    /// TwoLinkFoot::regressor_cop_single_into(Simd::best(), &q, &mut rows);
    /// assert_eq!(rows[0][0], 1.0);
    /// ```
    #[inline]
    fn regressor_cop_single_into<S: Scalar>(
        simd: Simd,
        q: &Posture<Self, S>,
        rows: &mut [Params<Self, S>; 2],
    ) {
        S::run_rows(
            simd,
            RegressorCop::<Self::GeneratedSinCos, S> { q, out: rows },
        );
    }

    /// [`Sesc::regressor_full`](crate::Sesc::regressor_full).
    ///
    /// ```
    /// # use sesc_generated::two_link_foot::TwoLinkFoot;
    /// # use sesc_runtime::{Simd, Single};
    /// # let q = [0.0_f64, 0.0];
    /// let rows = TwoLinkFoot::regressor_full_single(Simd::best(), &q);
    /// assert_eq!(rows[1][1], 1.0);
    /// ```
    #[inline]
    fn regressor_full_single<S: Scalar>(
        simd: Simd,
        q: &Posture<Self, S>,
    ) -> [FullParams<Self, S>; 3] {
        let mut rows = [<Self::Full as Dim>::filled(S::ZERO); 3];
        Self::regressor_full_single_into(simd, q, &mut rows);
        rows
    }

    /// The same into the caller's matrix: a copy costs a third of the time.
    ///
    /// ```
    /// # use sesc_generated::two_link_foot::TwoLinkFoot;
    /// # use sesc_runtime::{Simd, Single};
    /// # let q = [0.0_f64, 0.0];
    /// let mut rows = [[0.0; 9]; 3];
    /// TwoLinkFoot::regressor_full_single_into(Simd::best(), &q, &mut rows);
    /// assert_eq!(rows[1][1], 1.0);
    /// ```
    #[inline]
    fn regressor_full_single_into<S: Scalar>(
        simd: Simd,
        q: &Posture<Self, S>,
        rows: &mut [FullParams<Self, S>; 3],
    ) {
        S::run_rows(
            simd,
            RegressorFull::<Self::GeneratedSinCos, S> { q, out: rows },
        );
    }

    /// [`Sesc::cop`](crate::Sesc::cop), metres.
    ///
    /// ```
    /// # use sesc_generated::two_link_foot::{CAD_PARAMS, TwoLinkFoot};
    /// # use sesc_runtime::{Simd, Single};
    /// # let q = [0.0_f64, 0.0];
    /// let cop = TwoLinkFoot::cop_single(Simd::best(), &q, &CAD_PARAMS);
    /// assert!((cop[0] - 0.01).abs() < 1e-15);
    /// ```
    #[inline]
    fn cop_single<S: Scalar>(simd: Simd, q: &Posture<Self, S>, r: &Params<Self, S>) -> [S; 2] {
        let mut value = [S::ZERO; 2];
        let out = &mut value;
        S::run(simd, Cop::<Self::GeneratedSinCos, S> { q, r, out });
        value
    }

    /// [`Sesc::zmp`](crate::Sesc::zmp), metres.
    ///
    /// ```
    /// # use sesc_generated::two_link_foot::{CAD_PARAMS, TwoLinkFoot};
    /// # use sesc_runtime::{Simd, Single};
    /// # let q = [0.0_f64, 0.0];
    /// let still = [0.0, 0.0]; // rad/s, rad/s²
    /// let zmp = TwoLinkFoot::zmp_single(Simd::best(), &q, &still, &still, &CAD_PARAMS);
    /// assert!((zmp[0] - 0.01).abs() < 1e-15);
    /// ```
    #[inline]
    fn zmp_single<S: Scalar>(
        simd: Simd,
        q: &Posture<Self, S>,
        qd: &Posture<Self, S>,
        qdd: &Posture<Self, S>,
        r: &Params<Self, S>,
    ) -> [S; 2] {
        let mut value = [S::ZERO; 2];
        let out = &mut value;
        S::run(simd, Zmp::<Self::GeneratedSinCos, S> { q, qd, qdd, r, out });
        value
    }
}

impl<M: SescFromSinCos> Single for M {}

/// What the functions of [`SescFromSinCos`] take. Written in place: a copy would load
/// across stores that have not left the core yet.
#[inline(always)]
fn sines<M: SinCosRobot, S: Scalar, X: Machine<S>>(
    q: &Array<M::Dof, S>,
    sin: &mut Array<M::Dof, S>,
    cos: &mut Array<M::Dof, S>,
) {
    <M::Dof as Dim>::sin_cos::<S, X>(q, sin, cos);
    let prismatic = M::PRISMATIC;
    let positions = sin.as_mut().iter_mut().zip(q.as_ref());
    for ((sin, q), prismatic) in positions.zip(prismatic.as_ref()) {
        if *prismatic {
            *sin = *q;
        }
    }
}

/// The same numbers in every row. (`map` of an array is compiled for itself, without the
/// instructions of the set.)
#[inline(always)]
fn every_row<D: Dim, S: Scalar, X: Machine<S>>(numbers: &Array<D, S>) -> Array<D, X::Rows> {
    let mut rows = D::filled(X::every_row(S::ZERO));
    for (row, x) in rows.as_mut().iter_mut().zip(numbers.as_ref()) {
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

/// A function of one posture, as a task for any set of instructions: `$body` from its sines
/// and cosines.
macro_rules! task {
    (
        @task $name:ident, ($($x:ident: $of:ident),*), $out:ty, $set:ident,
        |$task:ident, $sin:ident, $cos:ident| $body:expr
    ) => {
        struct $name<'a, M: SinCosRobot, S: Scalar> {
            q: &'a Array<M::Dof, S>,
            $($x: &'a Array<M::$of, S>,)*
            out: &'a mut $out,
        }

        impl<M: SinCosRobot, S: Scalar> Task<S> for $name<'_, M, S> {
            #[inline(always)]
            fn run<$set: Machine<S>>(self) {
                let $task = self;
                let zeros = <M::Dof as Dim>::filled(S::ZERO);
                let (mut sin, mut cos) = (zeros, zeros);
                sines::<M, S, $set>($task.q, &mut sin, &mut cos);
                let ($sin, $cos) = (&sin, &cos);
                $body
            }
        }
    };
    // A vector.
    ($name:ident, $method:ident($($x:ident: $of:ident),*) => $out:ty) => {
        task!(@task $name, ($($x: $of),*), $out, X, |task, sin, cos| {
            let (sin, cos) = (<M::Dof as Dim>::ones::<S, X>(sin), <M::Dof as Dim>::ones::<S, X>(cos));
            let value = M::$method(sin, cos, $(<M::$of as Dim>::ones::<S, X>(task.$x)),*);
            let out: &mut [S] = task.out.as_mut();
            out.copy_from_slice(X::scalars(value.as_ref()));
        });
    };
    // Rows side by side.
    ($name:ident, $method:ident($($x:ident: $of:ident),*) -> [$n:ident; $m:literal]) => {
        task!(@task $name, ($($x: $of),*), [Array<M::$n, S>; $m], X, |task, sin, cos| {
            let sin = every_row::<M::Dof, S, X>(sin);
            let cos = every_row::<M::Dof, S, X>(cos);
            $(let $x = every_row::<M::$of, S, X>(task.$x);)*
            let columns = M::$method(&sin, &cos, $(&$x,)* &axes::<S, X>());
            for (row, out) in task.out.iter_mut().enumerate() {
                for (entry, column) in out.as_mut().iter_mut().zip(columns.as_ref()) {
                    *entry = X::numbers(*column)[row];
                }
            }
        });
    };
}

task!(Com, com_sc(r: Base) => [S; 3]);
task!(ComVelocity, com_velocity_sc(qd: Dof, r: Base) => [S; 3]);
task!(GravityMoments, gravity_moments_sc(r: Base) => Array<M::Dof, S>);
task!(Cop, cop_sc(r: Base) => [S; 2]);
task!(Zmp, zmp_sc(qd: Dof, qdd: Dof, r: Base) => [S; 2]);
task!(ComJacobian, com_jacobian_along(r: Base) -> [Dof; 3]);
task!(Regressor, regressor_along() -> [Base; 3]);
task!(RegressorCop, regressor_along() -> [Base; 2]);
task!(RegressorFull, regressor_full_along() -> [Full; 3]);

//! The functions and constants of a generated robot.
//!
//! ```text
//! CoM(q) = r_0 + Σ B_i(q) r_i
//! ```
//!
//! `B_i` rotates body i into the support frame; `r_i` gathers masses and lengths and
//! is the same in every posture. At a prismatic joint j, `B_parent(j) a_j q_j s_j`
//! is added: its axis, its position, and the share `s_j` of the mass it carries.
//!
//! All `r_i` and `s_j`, stacked, are the *full* parameters. Those directions of them
//! that no posture shows are left out of the *base* parameters `r`, and with these
//!
//! ```text
//! CoM(q) = Y(q) r,    J = ∂CoM/∂q,    τ_j / (M g) = -(J_j)_z
//! ```
//!
//! with the regressor `Y`. On flat ground the centre of pressure of a robot that
//! stands still is `(x, y)` of the CoM, hence the first two rows of `Y` times `r`,
//! then whatever effects the model has.
//!
//! Everything is in the support frame: the sole plane is z = 0 and gravity points
//! along -z.

use crate::__private::v1;
use crate::dim::Dim;
use crate::real::Real;

/// Joint positions of the robot `R`, or other numbers of its joints: `[T; DOF]`.
pub type Posture<R, T = f64> = <<R as Sesc>::Dof as Dim>::Array<T>;

/// Base parameters of the robot `R`, or a row of its regressor: `[T; BASE_PARAMS]`.
pub type Params<R, T = f64> = <<R as Sesc>::Base as Dim>::Array<T>;

/// Full parameters of the robot `R`, or a row of their regressor: `[T; FULL_PARAMS]`.
pub type FullParams<R, T = f64> = <<R as Sesc>::Full as Dim>::Array<T>;

/// A robot seen from one support link: what every generated unit struct is.
///
/// Joint positions are in the order of [`JOINT_NAMES`](Self::JOINT_NAMES), radians (metres
/// at a prismatic joint). Parameters are lengths in metres, except the mass share `s_j` of
/// a prismatic joint, which is a plain ratio.
///
/// No function allocates, branches or panics. Where a joint angle is out of the
/// domain of [`Real::sin_cos`], what depends on it is NaN.
///
/// Only generated code implements this trait, by way of a hidden one, so that a function
/// added here breaks nobody.
///
/// ```
/// use sesc_generated::two_link_foot::TwoLinkFoot;
/// use sesc_runtime::{Posture, Sesc};
///
/// /// Moments, N m, with which the joints of any robot hold a posture.
/// fn holding_moments<R: Sesc>(q: &Posture<R>) -> Posture<R> {
///     let weight_n = R::TOTAL_MASS_KG * 9.80665;
///     let mut moments = R::gravity_moments(q, &R::CAD_PARAMS);
///     for moment in moments.as_mut() {
///         *moment *= -weight_n;
///     }
///     moments
/// }
///
/// let [ankle, knee] = holding_moments::<TwoLinkFoot>(&[0.2, -0.4]);
/// assert!(ankle * knee < 0.0);
/// ```
pub trait Sesc: Sized {
    /// The number of joints; in [`Posture`].
    type Dof: Dim;

    /// The number of base parameters; in [`Params`].
    type Base: Dim;

    /// The number of full parameters; in [`FullParams`].
    type Full: Dim;

    /// The generated functions.
    #[doc(hidden)]
    type Generated: v1::Robot<Dof = Self::Dof, Base = Self::Base, Full = Self::Full>;

    /// Names of the joints, in the order of `q`.
    const JOINT_NAMES: Posture<Self, &'static str>;

    /// Which joints are prismatic: their position is in metres.
    const PRISMATIC: Posture<Self, bool>;

    /// Lower joint limits, rad or m; -∞ where a joint has none.
    const JOINT_LOWER: Posture<Self>;

    /// Upper joint limits, rad or m; ∞ where a joint has none.
    const JOINT_UPPER: Posture<Self>;

    /// Total mass from CAD, kg.
    const TOTAL_MASS_KG: f64;

    /// Base parameters from CAD, metres.
    const CAD_PARAMS: Params<Self>;

    /// Centre of mass, metres, in the support frame: `r_0 + Σ B_i(q) r_i`.
    ///
    /// ```
    /// # use sesc_generated::two_link_foot::{CAD_PARAMS, TwoLinkFoot};
    /// # use sesc_runtime::Sesc;
    /// let [x, y, z] = TwoLinkFoot::com(&[0.0, 0.0], &CAD_PARAMS);
    /// assert!((x - 0.01).abs() < 1e-15 && y == 0.0 && (z - 0.45).abs() < 1e-15);
    /// ```
    #[inline]
    fn com<T: Real>(q: &Posture<Self, T>, r: &Params<Self, T>) -> [T; 3] {
        <Self::Generated as v1::Robot>::com(q, r)
    }

    /// Derivatives of [`com`](Self::com): `[row][joint]`, metres per radian (at a
    /// prismatic joint, metres per metre).
    ///
    /// ```
    /// # use sesc_generated::two_link_foot::{CAD_PARAMS, TwoLinkFoot, joint};
    /// # use sesc_runtime::Sesc;
    /// let jacobian = TwoLinkFoot::com_jacobian(&[0.0, 0.0], &CAD_PARAMS);
    /// // Upright, the ankle moves the CoM forward by its height over the ankle.
    /// assert_eq!(jacobian[0][joint::ANKLE], 0.36);
    /// ```
    #[inline]
    fn com_jacobian<T: Real>(q: &Posture<Self, T>, r: &Params<Self, T>) -> [Posture<Self, T>; 3] {
        let zero = T::from_f64(0.0);
        let mut jacobian = [<Self::Dof as Dim>::filled(zero); 3];
        <Self::Generated as v1::Robot>::com_jacobian_into(q, r, &mut jacobian);
        jacobian
    }

    /// Moment of gravity at each joint, `τ_j = -(J_j)_z`, per kg of total mass and per
    /// unit of g: metres. Times `M g` it is in N m (at a prismatic joint, the
    /// force in N, the value here being a plain ratio); the joint holds the posture
    /// with the opposite.
    ///
    /// ```
    /// # use sesc_generated::two_link_foot::{CAD_PARAMS, TwoLinkFoot, joint};
    /// # use sesc_runtime::Sesc;
    /// let moments = TwoLinkFoot::gravity_moments(&[0.1, 0.0], &CAD_PARAMS);
    /// assert!(moments[joint::ANKLE] > moments[joint::KNEE]);
    /// ```
    #[inline]
    fn gravity_moments<T: Real>(q: &Posture<Self, T>, r: &Params<Self, T>) -> Posture<Self, T> {
        <Self::Generated as v1::Robot>::gravity_moments(q, r)
    }

    /// The regressor `Y`: `[row][base parameter]`, with `CoM = Y r`. No unit, except
    /// metres in the column of a mass share `s_j`.
    ///
    /// ```
    /// # use sesc_generated::two_link_foot::{CAD_PARAMS, TwoLinkFoot};
    /// # use sesc_runtime::Sesc;
    /// let rows = TwoLinkFoot::regressor(&[0.3, -0.5]);
    /// let z: f64 = rows[2].iter().zip(&CAD_PARAMS).map(|(y, r)| y * r).sum();
    /// let com = TwoLinkFoot::com(&[0.3, -0.5], &CAD_PARAMS);
    /// assert!((z - com[2]).abs() < 1e-15);
    /// ```
    #[inline]
    fn regressor<T: Real>(q: &Posture<Self, T>) -> [Params<Self, T>; 3] {
        let zero = T::from_f64(0.0);
        let mut rows = [<Self::Base as Dim>::filled(zero); 3];
        <Self::Generated as v1::Robot>::regressor_into(q, &mut rows);
        rows
    }

    /// The x and y rows of [`regressor`](Self::regressor) alone.
    ///
    /// ```
    /// # use sesc_generated::two_link_foot::TwoLinkFoot;
    /// # use sesc_runtime::Sesc;
    /// let [x, y] = TwoLinkFoot::regressor_cop(&[0.3, -0.5]);
    /// assert_eq!([x, y], TwoLinkFoot::regressor(&[0.3, -0.5])[..2]);
    /// ```
    #[inline]
    fn regressor_cop<T: Real>(q: &Posture<Self, T>) -> [Params<Self, T>; 2] {
        let zero = T::from_f64(0.0);
        let mut rows = [<Self::Base as Dim>::filled(zero); 2];
        <Self::Generated as v1::Robot>::regressor_cop_into(q, &mut rows);
        rows
    }

    /// The regressor of the full parameters: `[row][full parameter]`.
    ///
    /// ```
    /// # use sesc_generated::two_link_foot::TwoLinkFoot;
    /// # use sesc_runtime::Sesc;
    /// let rows = TwoLinkFoot::regressor_full(&[0.3, -0.5]);
    /// // r_0 is in the support frame, and all of it counts.
    /// assert_eq!(rows[0][..3], [1.0, 0.0, 0.0]);
    /// ```
    #[inline]
    fn regressor_full<T: Real>(q: &Posture<Self, T>) -> [FullParams<Self, T>; 3] {
        let zero = T::from_f64(0.0);
        let mut rows = [<Self::Full as Dim>::filled(zero); 3];
        <Self::Generated as v1::Robot>::regressor_full_into(q, &mut rows);
        rows
    }

    /// The predicted reading of the centre of pressure, metres, in the support frame,
    /// with the effects of the model if it has any.
    ///
    /// ```
    /// # use sesc_generated::two_link_foot::{CAD_PARAMS, TwoLinkFoot};
    /// # use sesc_runtime::Sesc;
    /// let com = TwoLinkFoot::com(&[0.3, -0.5], &CAD_PARAMS);
    /// assert_eq!(TwoLinkFoot::cop(&[0.3, -0.5], &CAD_PARAMS), com[..2]);
    /// ```
    #[inline]
    fn cop<T: Real>(q: &Posture<Self, T>, r: &Params<Self, T>) -> [T; 2] {
        <Self::Generated as v1::Robot>::cop(q, r)
    }
}

impl<R: v1::Robot> Sesc for R {
    type Dof = R::Dof;
    type Base = R::Base;
    type Full = R::Full;
    type Generated = R;
    const JOINT_NAMES: Posture<R, &'static str> = <R as v1::Robot>::JOINT_NAMES;
    const PRISMATIC: Posture<R, bool> = <R as v1::Robot>::PRISMATIC;
    const JOINT_LOWER: Posture<R> = <R as v1::Robot>::JOINT_LOWER;
    const JOINT_UPPER: Posture<R> = <R as v1::Robot>::JOINT_UPPER;
    const TOTAL_MASS_KG: f64 = <R as v1::Robot>::TOTAL_MASS_KG;
    const CAD_PARAMS: Params<R> = <R as v1::Robot>::CAD_PARAMS;
}

/// The functions of [`Sesc`] from given sines and cosines.
///
/// For a controller that has them already, or takes them from a table. `sin[j]` and
/// `cos[j]` belong to joint j and should lie on the unit circle; at a prismatic joint
/// `sin[j]` carries the position q_j in metres and `cos[j]` is not read. Shapes
/// and units are those of [`Sesc`].
///
/// ```
/// use sesc_generated::two_link_foot::{CAD_PARAMS, TwoLinkFoot};
/// use sesc_runtime::{Sesc, SescFromSinCos, trig};
///
/// let q = [0.3, -0.5];
/// let (sin, cos) = (q.map(|q| trig::sin_cos(q).0), q.map(|q| trig::sin_cos(q).1));
/// let r = CAD_PARAMS;
/// let com = TwoLinkFoot::com_sc(&sin, &cos, &r);
/// assert_eq!(com, TwoLinkFoot::com(&q, &r));
/// # assert_eq!(TwoLinkFoot::cop_sc(&sin, &cos, &r), com[..2]);
/// # let moments = TwoLinkFoot::gravity_moments_sc(&sin, &cos, &r);
/// # assert_eq!(moments, TwoLinkFoot::gravity_moments(&q, &r));
/// ```
pub trait SescFromSinCos: Sesc {
    /// The generated functions.
    #[doc(hidden)]
    type GeneratedSinCos: v1::SinCosRobot<Dof = Self::Dof, Base = Self::Base, Full = Self::Full>;

    /// [`Sesc::com`] from sines and cosines.
    #[inline]
    fn com_sc<T: Real>(
        sin: &Posture<Self, T>,
        cos: &Posture<Self, T>,
        r: &Params<Self, T>,
    ) -> [T; 3] {
        <Self::GeneratedSinCos as v1::SinCosRobot>::com_sc(sin, cos, r)
    }

    /// [`Sesc::com_jacobian`] from sines and cosines.
    #[inline]
    fn com_jacobian_sc<T: Real>(
        sin: &Posture<Self, T>,
        cos: &Posture<Self, T>,
        r: &Params<Self, T>,
    ) -> [Posture<Self, T>; 3] {
        <Self::GeneratedSinCos as v1::SinCosRobot>::com_jacobian_sc(sin, cos, r)
    }

    /// [`Sesc::gravity_moments`] from sines and cosines.
    #[inline]
    fn gravity_moments_sc<T: Real>(
        sin: &Posture<Self, T>,
        cos: &Posture<Self, T>,
        r: &Params<Self, T>,
    ) -> Posture<Self, T> {
        <Self::GeneratedSinCos as v1::SinCosRobot>::gravity_moments_sc(sin, cos, r)
    }

    /// [`Sesc::regressor`] from sines and cosines.
    #[inline]
    fn regressor_sc<T: Real>(
        sin: &Posture<Self, T>,
        cos: &Posture<Self, T>,
    ) -> [Params<Self, T>; 3] {
        <Self::GeneratedSinCos as v1::SinCosRobot>::regressor_sc(sin, cos)
    }

    /// [`Sesc::regressor_cop`] from sines and cosines.
    #[inline]
    fn regressor_cop_sc<T: Real>(
        sin: &Posture<Self, T>,
        cos: &Posture<Self, T>,
    ) -> [Params<Self, T>; 2] {
        <Self::GeneratedSinCos as v1::SinCosRobot>::regressor_cop_sc(sin, cos)
    }

    /// [`Sesc::regressor_full`] from sines and cosines.
    #[inline]
    fn regressor_full_sc<T: Real>(
        sin: &Posture<Self, T>,
        cos: &Posture<Self, T>,
    ) -> [FullParams<Self, T>; 3] {
        <Self::GeneratedSinCos as v1::SinCosRobot>::regressor_full_sc(sin, cos)
    }

    /// [`Sesc::cop`] from sines and cosines.
    #[inline]
    fn cop_sc<T: Real>(
        sin: &Posture<Self, T>,
        cos: &Posture<Self, T>,
        r: &Params<Self, T>,
    ) -> [T; 2] {
        <Self::GeneratedSinCos as v1::SinCosRobot>::cop_sc(sin, cos, r)
    }
}

impl<R: v1::SinCosRobot> SescFromSinCos for R {
    type GeneratedSinCos = R;
}

/// A robot whose model has effects of its CoP sensor.
///
/// ```
/// use sesc_runtime::{CorrectCop, Params, Posture, Sesc};
///
/// /// How far the CoM is from over the CoP that a reading stands for, metres.
/// fn lean<R: Sesc + CorrectCop>(q: &Posture<R>, r: &Params<R>, reading: &[f64; 2]) -> [f64; 2] {
///     let (com, cop) = (R::com(q, r), R::correct_cop(reading));
///     [com[0] - cop[0], com[1] - cop[1]]
/// }
/// ```
pub trait CorrectCop: Sesc {
    /// The centre of pressure, metres, that a reading was made of: what
    /// [`Sesc::cop`] would be without the effects of the sensor (a wrong cell, a
    /// gain, a rotation, an offset, swapped axes, the unit of the record). It means nothing
    /// where no CoP on the foot has that reading.
    fn correct_cop<T: Real>(reading: &[T; 2]) -> [T; 2];
}

impl<R: v1::SensorEffects> CorrectCop for R {
    #[inline]
    fn correct_cop<T: Real>(reading: &[T; 2]) -> [T; 2] {
        <R as v1::SensorEffects>::correct_cop(reading)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lanes::{F64x8, Lanes};
    use leg::Leg;

    mod leg {
        use crate::__private::v1::{Const, Real, Robot, SinCosRobot};

        /// A foot and a leg that pitches about y: what the generator would write,
        /// derived by hand. Base parameters: r_0 (3), then x and z of r_1, whose y lies
        /// along the axis and is part of r_0.
        pub struct Leg;

        impl Robot for Leg {
            type Dof = Const<1>;
            type Base = Const<5>;
            type Full = Const<6>;
            const JOINT_NAMES: [&'static str; 1] = ["ankle_pitch"];
            const PRISMATIC: [bool; 1] = [false];
            const JOINT_LOWER: [f64; 1] = [-1.0];
            const JOINT_UPPER: [f64; 1] = [1.0];
            const TOTAL_MASS_KG: f64 = 2.0;
            const CAD_PARAMS: [f64; 5] = [0.01, -0.005, 0.03, 0.02, 0.25];

            fn com<T: Real>(q: &[T; 1], r: &[T; 5]) -> [T; 3] {
                let (s, c) = q[0].sin_cos();
                Self::com_sc(&[s], &[c], r)
            }

            fn com_jacobian_into<T: Real>(q: &[T; 1], r: &[T; 5], jacobian: &mut [[T; 1]; 3]) {
                let (s, c) = q[0].sin_cos();
                *jacobian = Self::com_jacobian_sc(&[s], &[c], r);
            }

            fn gravity_moments<T: Real>(q: &[T; 1], r: &[T; 5]) -> [T; 1] {
                let (s, c) = q[0].sin_cos();
                Self::gravity_moments_sc(&[s], &[c], r)
            }

            fn regressor_into<T: Real>(q: &[T; 1], rows: &mut [[T; 5]; 3]) {
                let (s, c) = q[0].sin_cos();
                *rows = Self::regressor_sc(&[s], &[c]);
            }

            fn regressor_cop_into<T: Real>(q: &[T; 1], rows: &mut [[T; 5]; 2]) {
                let (s, c) = q[0].sin_cos();
                *rows = Self::regressor_cop_sc(&[s], &[c]);
            }

            fn regressor_full_into<T: Real>(q: &[T; 1], rows: &mut [[T; 6]; 3]) {
                let (s, c) = q[0].sin_cos();
                *rows = Self::regressor_full_sc(&[s], &[c]);
            }

            fn cop<T: Real>(q: &[T; 1], r: &[T; 5]) -> [T; 2] {
                let (s, c) = q[0].sin_cos();
                Self::cop_sc(&[s], &[c], r)
            }
        }

        impl SinCosRobot for Leg {
            fn com_sc<T: Real>([s]: &[T; 1], [c]: &[T; 1], r: &[T; 5]) -> [T; 3] {
                [
                    r[0] + *c * r[3] + *s * r[4],
                    r[1],
                    r[2] + *c * r[4] - *s * r[3],
                ]
            }

            fn com_jacobian_sc<T: Real>([s]: &[T; 1], [c]: &[T; 1], r: &[T; 5]) -> [[T; 1]; 3] {
                let zero = T::from_f64(0.0);
                [[*c * r[4] - *s * r[3]], [zero], [-(*c * r[3] + *s * r[4])]]
            }

            fn gravity_moments_sc<T: Real>([s]: &[T; 1], [c]: &[T; 1], r: &[T; 5]) -> [T; 1] {
                [*c * r[3] + *s * r[4]]
            }

            fn regressor_sc<T: Real>(sin: &[T; 1], cos: &[T; 1]) -> [[T; 5]; 3] {
                let (zero, one) = (T::from_f64(0.0), T::from_f64(1.0));
                let [x, y] = Self::regressor_cop_sc(sin, cos);
                [x, y, [zero, zero, one, -sin[0], cos[0]]]
            }

            fn regressor_cop_sc<T: Real>([s]: &[T; 1], [c]: &[T; 1]) -> [[T; 5]; 2] {
                let (zero, one) = (T::from_f64(0.0), T::from_f64(1.0));
                [[one, zero, zero, *c, *s], [zero, one, zero, zero, zero]]
            }

            fn regressor_full_sc<T: Real>([s]: &[T; 1], [c]: &[T; 1]) -> [[T; 6]; 3] {
                let (zero, one) = (T::from_f64(0.0), T::from_f64(1.0));
                [
                    [one, zero, zero, *c, zero, *s],
                    [zero, one, zero, zero, one, zero],
                    [zero, zero, one, -*s, zero, *c],
                ]
            }

            fn cop_sc<T: Real>(sin: &[T; 1], cos: &[T; 1], r: &[T; 5]) -> [T; 2] {
                let [x, y, _] = Self::com_sc(sin, cos, r);
                [x, y]
            }
        }
    }

    const R: [f64; 5] = Leg::CAD_PARAMS;

    fn times<const COLUMNS: usize>(rows: &[[f64; COLUMNS]; 3], r: &[f64; COLUMNS]) -> [f64; 3] {
        rows.map(|row| row.iter().zip(r).map(|(a, b)| a * b).sum())
    }

    #[test]
    fn regressors_times_parameters_are_the_com() {
        for q in [-1.2, -0.3, 0.0, 0.7, 2.0] {
            let com = Leg::com(&[q], &R);
            // The unobservable y of r_1 may be shared out as one likes.
            let full = [R[0], R[1] - 0.04, R[2], R[3], 0.04, R[4]];
            let from_base = times(&Leg::regressor(&[q]), &R);
            let from_full = times(&Leg::regressor_full(&[q]), &full);
            for axis in 0..3 {
                assert!((com[axis] - from_base[axis]).abs() < 1e-16);
                assert!((com[axis] - from_full[axis]).abs() < 1e-16);
            }
            assert_eq!(Leg::cop(&[q], &R), [com[0], com[1]]);
        }
    }

    #[test]
    fn gravity_moments_are_minus_the_slope_of_the_height() {
        let h = 1e-5;
        for q in [-1.2, -0.3, 0.0, 0.7, 2.0] {
            let rise = Leg::com(&[q + h], &R)[2] - Leg::com(&[q - h], &R)[2];
            let moment = Leg::gravity_moments(&[q], &R)[0];
            assert!((moment + rise / (2.0 * h)).abs() < 1e-10);
            assert_eq!(moment, -Leg::com_jacobian(&[q], &R)[2][0]);
        }
    }

    #[test]
    fn one_model_serves_scalars_and_lanes() {
        let q = Lanes([-2.0, -1.0, -0.5, 0.0, 0.1, 0.4, 1.0, 3.0]);
        let lanes: [F64x8; 3] = Leg::com(&[q], &R.map(Lanes::splat));
        for (i, q) in q.0.into_iter().enumerate() {
            let com = Leg::com(&[q], &R);
            let single = Leg::com(&[q as f32], &R.map(Real::from_f64));
            for axis in 0..3 {
                assert_eq!(com[axis].to_bits(), lanes[axis].0[i].to_bits());
                assert!((com[axis] - f64::from(single[axis])).abs() < 1e-7);
            }
        }
    }
}

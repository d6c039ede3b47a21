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
///
/// ```
/// use sesc_generated::two_link_foot::TwoLinkFoot;
/// use sesc_runtime::Posture;
///
/// let q: Posture<TwoLinkFoot> = [0.2, -0.4]; // rad
/// let single: Posture<TwoLinkFoot, f32> = q.map(|q| q as f32);
/// assert_eq!(single.len(), 2);
/// ```
pub type Posture<R, T = f64> = <<R as Sesc>::Dof as Dim>::Array<T>;

/// Base parameters of the robot `R`, or a row of its regressor: `[T; BASE_PARAMS]`.
///
/// ```
/// use sesc_generated::two_link_foot::TwoLinkFoot;
/// use sesc_runtime::{Params, Sesc};
///
/// let mut r: Params<TwoLinkFoot> = TwoLinkFoot::CAD_PARAMS; // m
/// r[0] += 1e-3;
/// assert!(TwoLinkFoot::com(&[0.0, 0.0], &r)[0] > 0.01);
/// ```
pub type Params<R, T = f64> = <<R as Sesc>::Base as Dim>::Array<T>;

/// Full parameters of the robot `R`, or a row of their regressor: `[T; FULL_PARAMS]`.
///
/// ```
/// use sesc_generated::two_link_foot::TwoLinkFoot;
/// use sesc_runtime::{FullParams, Sesc};
///
/// let [x, _, _]: [FullParams<TwoLinkFoot>; 3] = TwoLinkFoot::regressor_full(&[0.3, -0.5]);
/// assert_eq!(x.len(), 9);
/// ```
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
/// Only generated code implements this trait, by way of a hidden one, so that adding a
/// function here breaks no caller.
///
/// A module may have been generated without some of the functions (`Builder::functions` of
/// `sesc-codegen`): where one of them is called, the build fails with its name.
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
    ///
    /// ```
    /// # use sesc_generated::two_link_foot::TwoLinkFoot;
    /// # use sesc_runtime::Sesc;
    /// assert_eq!(TwoLinkFoot::JOINT_NAMES, ["ankle", "knee"]);
    /// ```
    const JOINT_NAMES: Posture<Self, &'static str>;

    /// Which joints are prismatic: their position is in metres.
    ///
    /// ```
    /// # use sesc_generated::two_link_foot::TwoLinkFoot;
    /// # use sesc_runtime::Sesc;
    /// assert_eq!(TwoLinkFoot::PRISMATIC, [false, false]);
    /// ```
    const PRISMATIC: Posture<Self, bool>;

    /// Lower joint limits, rad or m; -∞ where a joint has none.
    ///
    /// ```
    /// # use sesc_generated::two_link_foot::TwoLinkFoot;
    /// # use sesc_runtime::Sesc;
    /// /// A posture inside the limits of any robot.
    /// fn inside<R: Sesc>(q: &mut sesc_runtime::Posture<R>) {
    ///     for (j, q) in q.as_mut().iter_mut().enumerate() {
    ///         *q = q.max(R::JOINT_LOWER[j]).min(R::JOINT_UPPER[j]);
    ///     }
    /// }
    ///
    /// let mut q = [-9.0, -0.1];
    /// inside::<TwoLinkFoot>(&mut q);
    /// assert_eq!(q, [TwoLinkFoot::JOINT_LOWER[0], -0.1]);
    /// ```
    const JOINT_LOWER: Posture<Self>;

    /// Upper joint limits, rad or m; ∞ where a joint has none.
    ///
    /// ```
    /// # use sesc_generated::two_link_foot::TwoLinkFoot;
    /// # use sesc_runtime::Sesc;
    /// assert!(TwoLinkFoot::JOINT_UPPER[0] > TwoLinkFoot::JOINT_LOWER[0]);
    /// ```
    const JOINT_UPPER: Posture<Self>;

    /// Total mass, kg: what CAD says, and the loads of the model file.
    ///
    /// ```
    /// # use sesc_generated::two_link_foot::TwoLinkFoot;
    /// # use sesc_runtime::Sesc;
    /// assert_eq!(TwoLinkFoot::TOTAL_MASS_KG, 10.0);
    /// ```
    const TOTAL_MASS_KG: f64;

    /// Base parameters from CAD, metres.
    ///
    /// ```
    /// # use sesc_generated::two_link_foot::TwoLinkFoot;
    /// # use sesc_runtime::Sesc;
    /// // Upright, the CoM is over the first parameter.
    /// let [x, ..] = TwoLinkFoot::com(&[0.0, 0.0], &TwoLinkFoot::CAD_PARAMS);
    /// assert!((x - TwoLinkFoot::CAD_PARAMS[0]).abs() < 1e-15);
    /// ```
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

    /// Velocity of the centre of mass, metres per second, as joints move at `qd`:
    /// [`com_jacobian`](Self::com_jacobian) times `qd` without forming it.
    ///
    /// ```
    /// # use sesc_generated::two_link_foot::{CAD_PARAMS, TwoLinkFoot};
    /// # use sesc_runtime::Sesc;
    /// let [forward, _, up] = TwoLinkFoot::com_velocity(&[0.0; 2], &[0.5, 0.0], &CAD_PARAMS);
    /// assert!((forward - 0.18).abs() < 1e-15 && up.abs() < 0.01);
    /// ```
    #[inline]
    fn com_velocity<T: Real>(
        q: &Posture<Self, T>,
        qd: &Posture<Self, T>,
        r: &Params<Self, T>,
    ) -> [T; 3] {
        <Self::Generated as v1::Robot>::com_velocity(q, qd, r)
    }

    /// The moment that gravity exerts about each joint, `τ_j = -(J_j)_z`, per kg of total mass
    /// times g: metres. Times `M g` it is in N m (at a prismatic joint, the force in N, the
    /// value here being a plain ratio); a motor that holds the posture applies the opposite,
    /// `−M g τ_j`, which is Pinocchio's `computeGeneralizedGravity`.
    ///
    /// ```
    /// # use sesc_generated::two_link_foot::{CAD_PARAMS, TwoLinkFoot, joint};
    /// # use sesc_runtime::Sesc;
    /// // Leaning forward, gravity turns the ankle further forward: positive, as its angle.
    /// let moments = TwoLinkFoot::gravity_moments(&[0.1, 0.0], &CAD_PARAMS);
    /// assert!(moments[joint::ANKLE] > moments[joint::KNEE] && moments[joint::KNEE] > 0.0);
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

    /// How [`cop`](Self::cop), the predicted reading, moves with what encoders read: `∂cop/∂q`,
    /// m/rad (prismatic: m/m), rows x and y.
    ///
    /// ```
    /// # use sesc_generated::two_link_foot::{CAD_PARAMS, TwoLinkFoot};
    /// # use sesc_runtime::Sesc;
    /// let [x, y] = TwoLinkFoot::cop_jacobian(&[0.3, -0.5], &CAD_PARAMS);
    /// let jacobian = TwoLinkFoot::com_jacobian(&[0.3, -0.5], &CAD_PARAMS);
    /// assert_eq!([x, y], jacobian[..2]); // without effects
    /// ```
    #[inline]
    fn cop_jacobian<T: Real>(q: &Posture<Self, T>, r: &Params<Self, T>) -> [Posture<Self, T>; 2] {
        let zero = T::from_f64(0.0);
        let mut jacobian = [<Self::Dof as Dim>::filled(zero); 2];
        <Self::Generated as v1::Robot>::cop_jacobian_into(q, r, &mut jacobian);
        jacobian
    }

    /// The zero-moment point on the sole plane, metres, in the support frame, as joints at `q`
    /// move at `qd` with accelerations `qdd`:
    ///
    /// ```text
    /// p = c − (c_z c̈ + L̇⊥/M)/(g + c̈_z)        L̇⊥ = (L̇_y, −L̇_x)        g = 9.80665 m/s²
    /// ```
    ///
    /// c and its acceleration follow from `r`; L̇, the rate of angular momentum about the CoM,
    /// from the masses and inertias of the URDF. Standing still it is the projected CoM;
    /// where the ground carries nothing (`c̈_z = −g`) there is none.
    ///
    /// ```
    /// # use sesc_generated::two_link_foot::{CAD_PARAMS, TwoLinkFoot};
    /// # use sesc_runtime::Sesc;
    /// let (q, still) = ([0.0, 0.0], [0.0, 0.0]);
    /// let com = TwoLinkFoot::com(&q, &CAD_PARAMS);
    /// assert_eq!(TwoLinkFoot::zmp(&q, &still, &still, &CAD_PARAMS), com[..2]);
    /// // Thrown forward at the ankle, the robot pushes the ground back.
    /// assert!(TwoLinkFoot::zmp(&q, &still, &[1.0, 0.0], &CAD_PARAMS)[0] < com[0] - 0.01);
    /// ```
    #[inline]
    fn zmp<T: Real>(
        q: &Posture<Self, T>,
        qd: &Posture<Self, T>,
        qdd: &Posture<Self, T>,
        r: &Params<Self, T>,
    ) -> [T; 2] {
        <Self::Generated as v1::Robot>::zmp(q, qd, qdd, r)
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
    ///
    /// ```
    /// use sesc_runtime::CorrectCop;
    ///
    /// /// The readings of a log, metres, freed of the effects of the sensor.
    /// fn correct<R: CorrectCop>(readings: &mut [[f64; 2]]) {
    ///     for reading in readings {
    ///         *reading = R::correct_cop(reading);
    ///     }
    /// }
    /// ```
    fn correct_cop<T: Real>(reading: &[T; 2]) -> [T; 2];
}

impl<R: v1::SensorEffects> CorrectCop for R {
    #[inline]
    fn correct_cop<T: Real>(reading: &[T; 2]) -> [T; 2] {
        <R as v1::Robot>::correct_cop(reading)
    }
}

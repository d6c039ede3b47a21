//! The functions of a generated robot from sines and cosines that are given.

use crate::__private::v1;
use crate::model::{FullParams, Params, Posture, Sesc};
use crate::real::Real;

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
    ///
    /// ```
    /// # use sesc_generated::two_link_foot::{CAD_PARAMS, TwoLinkFoot};
    /// # use sesc_runtime::{Sesc, SescFromSinCos, trig};
    /// # let q = [0.3, -0.5];
    /// # let (sin, cos) = (q.map(|q| trig::sin_cos(q).0), q.map(|q| trig::sin_cos(q).1));
    /// let com = TwoLinkFoot::com_sc(&sin, &cos, &CAD_PARAMS);
    /// assert_eq!(com, TwoLinkFoot::com(&q, &CAD_PARAMS));
    /// ```
    #[inline]
    fn com_sc<T: Real>(
        sin: &Posture<Self, T>,
        cos: &Posture<Self, T>,
        r: &Params<Self, T>,
    ) -> [T; 3] {
        <Self::GeneratedSinCos as v1::SinCosRobot>::com_sc(sin, cos, r)
    }

    /// [`Sesc::com_jacobian`] from sines and cosines.
    ///
    /// ```
    /// # use sesc_generated::two_link_foot::{CAD_PARAMS, TwoLinkFoot};
    /// # use sesc_runtime::{Sesc, SescFromSinCos, trig};
    /// # let q = [0.3, -0.5];
    /// # let (sin, cos) = (q.map(|q| trig::sin_cos(q).0), q.map(|q| trig::sin_cos(q).1));
    /// let jacobian = TwoLinkFoot::com_jacobian_sc(&sin, &cos, &CAD_PARAMS);
    /// assert_eq!(jacobian, TwoLinkFoot::com_jacobian(&q, &CAD_PARAMS));
    /// ```
    #[inline]
    fn com_jacobian_sc<T: Real>(
        sin: &Posture<Self, T>,
        cos: &Posture<Self, T>,
        r: &Params<Self, T>,
    ) -> [Posture<Self, T>; 3] {
        <Self::GeneratedSinCos as v1::SinCosRobot>::com_jacobian_sc(sin, cos, r)
    }

    /// [`Sesc::com_velocity`] from sines and cosines.
    ///
    /// ```
    /// # use sesc_generated::two_link_foot::{CAD_PARAMS, TwoLinkFoot};
    /// # use sesc_runtime::{Sesc, SescFromSinCos, trig};
    /// # let q = [0.3, -0.5];
    /// # let (sin, cos) = (q.map(|q| trig::sin_cos(q).0), q.map(|q| trig::sin_cos(q).1));
    /// let qd = [0.5, 0.0]; // rad/s
    /// let velocity = TwoLinkFoot::com_velocity_sc(&sin, &cos, &qd, &CAD_PARAMS);
    /// assert_eq!(velocity, TwoLinkFoot::com_velocity(&q, &qd, &CAD_PARAMS));
    /// ```
    #[inline]
    fn com_velocity_sc<T: Real>(
        sin: &Posture<Self, T>,
        cos: &Posture<Self, T>,
        qd: &Posture<Self, T>,
        r: &Params<Self, T>,
    ) -> [T; 3] {
        <Self::GeneratedSinCos as v1::SinCosRobot>::com_velocity_sc(sin, cos, qd, r)
    }

    /// [`Sesc::gravity_moments`] from sines and cosines.
    ///
    /// ```
    /// # use sesc_generated::two_link_foot::{CAD_PARAMS, TwoLinkFoot};
    /// # use sesc_runtime::{Sesc, SescFromSinCos, trig};
    /// # let q = [0.3, -0.5];
    /// # let (sin, cos) = (q.map(|q| trig::sin_cos(q).0), q.map(|q| trig::sin_cos(q).1));
    /// let moments = TwoLinkFoot::gravity_moments_sc(&sin, &cos, &CAD_PARAMS);
    /// assert_eq!(moments, TwoLinkFoot::gravity_moments(&q, &CAD_PARAMS));
    /// ```
    #[inline]
    fn gravity_moments_sc<T: Real>(
        sin: &Posture<Self, T>,
        cos: &Posture<Self, T>,
        r: &Params<Self, T>,
    ) -> Posture<Self, T> {
        <Self::GeneratedSinCos as v1::SinCosRobot>::gravity_moments_sc(sin, cos, r)
    }

    /// [`Sesc::regressor`] from sines and cosines.
    ///
    /// ```
    /// # use sesc_generated::two_link_foot::TwoLinkFoot;
    /// # use sesc_runtime::{Sesc, SescFromSinCos, trig};
    /// # let q = [0.3, -0.5];
    /// # let (sin, cos) = (q.map(|q| trig::sin_cos(q).0), q.map(|q| trig::sin_cos(q).1));
    /// let rows = TwoLinkFoot::regressor_sc(&sin, &cos);
    /// assert_eq!(rows, TwoLinkFoot::regressor(&q));
    /// ```
    #[inline]
    fn regressor_sc<T: Real>(
        sin: &Posture<Self, T>,
        cos: &Posture<Self, T>,
    ) -> [Params<Self, T>; 3] {
        <Self::GeneratedSinCos as v1::SinCosRobot>::regressor_sc(sin, cos)
    }

    /// [`Sesc::regressor_cop`] from sines and cosines.
    ///
    /// ```
    /// # use sesc_generated::two_link_foot::TwoLinkFoot;
    /// # use sesc_runtime::{Sesc, SescFromSinCos, trig};
    /// # let q = [0.3, -0.5];
    /// # let (sin, cos) = (q.map(|q| trig::sin_cos(q).0), q.map(|q| trig::sin_cos(q).1));
    /// let rows = TwoLinkFoot::regressor_cop_sc(&sin, &cos);
    /// assert_eq!(rows, TwoLinkFoot::regressor_cop(&q));
    /// ```
    #[inline]
    fn regressor_cop_sc<T: Real>(
        sin: &Posture<Self, T>,
        cos: &Posture<Self, T>,
    ) -> [Params<Self, T>; 2] {
        <Self::GeneratedSinCos as v1::SinCosRobot>::regressor_cop_sc(sin, cos)
    }

    /// [`Sesc::regressor_full`] from sines and cosines.
    ///
    /// ```
    /// # use sesc_generated::two_link_foot::TwoLinkFoot;
    /// # use sesc_runtime::{Sesc, SescFromSinCos, trig};
    /// # let q = [0.3, -0.5];
    /// # let (sin, cos) = (q.map(|q| trig::sin_cos(q).0), q.map(|q| trig::sin_cos(q).1));
    /// let rows = TwoLinkFoot::regressor_full_sc(&sin, &cos);
    /// assert_eq!(rows, TwoLinkFoot::regressor_full(&q));
    /// ```
    #[inline]
    fn regressor_full_sc<T: Real>(
        sin: &Posture<Self, T>,
        cos: &Posture<Self, T>,
    ) -> [FullParams<Self, T>; 3] {
        <Self::GeneratedSinCos as v1::SinCosRobot>::regressor_full_sc(sin, cos)
    }

    /// [`Sesc::cop_jacobian`] from sines and cosines.
    ///
    /// ```
    /// # use sesc_generated::two_link_foot::{CAD_PARAMS, TwoLinkFoot};
    /// # use sesc_runtime::{Sesc, SescFromSinCos, trig};
    /// # let q = [0.3, -0.5];
    /// # let (sin, cos) = (q.map(|q| trig::sin_cos(q).0), q.map(|q| trig::sin_cos(q).1));
    /// let jacobian = TwoLinkFoot::cop_jacobian_sc(&sin, &cos, &CAD_PARAMS);
    /// assert_eq!(jacobian, TwoLinkFoot::cop_jacobian(&q, &CAD_PARAMS));
    /// ```
    #[inline]
    fn cop_jacobian_sc<T: Real>(
        sin: &Posture<Self, T>,
        cos: &Posture<Self, T>,
        r: &Params<Self, T>,
    ) -> [Posture<Self, T>; 2] {
        <Self::GeneratedSinCos as v1::SinCosRobot>::cop_jacobian_sc(sin, cos, r)
    }

    /// [`Sesc::cop`] from sines and cosines.
    ///
    /// ```
    /// # use sesc_generated::two_link_foot::{CAD_PARAMS, TwoLinkFoot};
    /// # use sesc_runtime::{Sesc, SescFromSinCos, trig};
    /// # let q = [0.3, -0.5];
    /// # let (sin, cos) = (q.map(|q| trig::sin_cos(q).0), q.map(|q| trig::sin_cos(q).1));
    /// let cop = TwoLinkFoot::cop_sc(&sin, &cos, &CAD_PARAMS);
    /// assert_eq!(cop, TwoLinkFoot::cop(&q, &CAD_PARAMS));
    /// ```
    #[inline]
    fn cop_sc<T: Real>(
        sin: &Posture<Self, T>,
        cos: &Posture<Self, T>,
        r: &Params<Self, T>,
    ) -> [T; 2] {
        <Self::GeneratedSinCos as v1::SinCosRobot>::cop_sc(sin, cos, r)
    }

    /// [`Sesc::zmp`] from sines and cosines.
    ///
    /// ```
    /// # use sesc_generated::two_link_foot::{CAD_PARAMS, TwoLinkFoot};
    /// # use sesc_runtime::{Sesc, SescFromSinCos, trig};
    /// # let q = [0.3, -0.5];
    /// # let (sin, cos) = (q.map(|q| trig::sin_cos(q).0), q.map(|q| trig::sin_cos(q).1));
    /// let (still, qdd) = ([0.0, 0.0], [1.0, 0.0]); // rad/s, rad/s²
    /// let zmp = TwoLinkFoot::zmp_sc(&sin, &cos, &still, &qdd, &CAD_PARAMS);
    /// assert_eq!(zmp, TwoLinkFoot::zmp(&q, &still, &qdd, &CAD_PARAMS));
    /// ```
    #[inline]
    fn zmp_sc<T: Real>(
        sin: &Posture<Self, T>,
        cos: &Posture<Self, T>,
        qd: &Posture<Self, T>,
        qdd: &Posture<Self, T>,
        r: &Params<Self, T>,
    ) -> [T; 2] {
        <Self::GeneratedSinCos as v1::SinCosRobot>::zmp_sc(sin, cos, qd, qdd, r)
    }
}

impl<R: v1::SinCosRobot> SescFromSinCos for R {
    type GeneratedSinCos = R;
}

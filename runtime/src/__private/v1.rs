//! What generated code implements: version 1 of the interface between generator and runtime.
//!
//! Everything public about a robot ([`Sesc`](crate::Sesc) and what builds on it) is derived
//! from these traits, so that it can grow without a change of generated code. Where these
//! traits change, a new version of this module stands beside or instead of it, and
//! [`__interface`](crate::__interface) tells generated code of another version what to do.
//!
//! Bodies are `inline(always)`: they end up inside functions that are compiled for the
//! registers of a set of instructions, and nothing that is called can have those.

pub use crate::dim::{Const, Dim};
pub use crate::real::Real;

/// An array of `T`.
pub type Array<D, T> = <D as Dim>::Array<T>;

/// Sines and cosines of the angles that links turn by: what a function's body reads.
pub trait Angles<T> {
    /// Those of angle `k`.
    fn sin_cos(&self, k: usize) -> (T, T);
}

/// Sines and cosines that the caller has.
impl<T: Real, const N: usize> Angles<T> for (&[T; N], &[T; N]) {
    #[inline(always)]
    fn sin_cos(&self, k: usize) -> (T, T) {
        (self.0[k], self.1[k])
    }
}

/// Most angles whose sines are computed without a loop: each where the body first needs it.
const MOST_STRAIGHT: usize = 64;

/// Sines and cosines of angles.
pub struct Positions<T, const N: usize> {
    /// The angles themselves where there is no loop.
    sin: [T; N],
    cos: [T; N],
}

impl<T: Real, const N: usize> Positions<T, N> {
    /// Whether sines are computed in a loop before anything else, which the compiler digests.
    const LOOP: bool = N > MOST_STRAIGHT;

    #[inline(always)]
    #[allow(missing_docs)]
    pub fn new(angles: &[T; N]) -> Self {
        let (mut sin, mut cos) = (*angles, *angles);
        if Self::LOOP {
            for ((sin, cos), angle) in sin.iter_mut().zip(&mut cos).zip(angles) {
                (*sin, *cos) = angle.sin_cos();
            }
        }
        Positions { sin, cos }
    }
}

impl<T: Real, const N: usize> Angles<T> for Positions<T, N> {
    #[inline(always)]
    fn sin_cos(&self, k: usize) -> (T, T) {
        match Self::LOOP {
            true => (self.sin[k], self.cos[k]),
            false => self.sin[k].sin_cos(),
        }
    }
}

/// Fails to compile where a function is used that the module was generated without.
macro_rules! left_out {
    ($function:literal) => {
        const {
            panic!(concat!(
                "this robot's module was generated without `",
                $function,
                "`: name it in Builder::functions, or where else the module was generated"
            ))
        }
    };
}

/// A robot on one support link; constants and functions are those of
/// [`Sesc`](crate::Sesc), matrices written to where the caller wants them. All but `com` may be
/// left out of a module.
#[allow(missing_docs, unused_variables)]
pub trait Robot {
    type Dof: Dim;
    type Base: Dim;
    type Full: Dim;

    const JOINT_NAMES: Array<Self::Dof, &'static str>;
    const PRISMATIC: Array<Self::Dof, bool>;
    const JOINT_LOWER: Array<Self::Dof, f64>;
    const JOINT_UPPER: Array<Self::Dof, f64>;
    const TOTAL_MASS_KG: f64;
    const CAD_PARAMS: Array<Self::Base, f64>;

    fn com<T: Real>(q: &Array<Self::Dof, T>, r: &Array<Self::Base, T>) -> [T; 3];

    fn com_jacobian_into<T: Real>(
        q: &Array<Self::Dof, T>,
        r: &Array<Self::Base, T>,
        jacobian: &mut [Array<Self::Dof, T>; 3],
    ) {
        left_out!("com_jacobian")
    }

    fn com_velocity<T: Real>(
        q: &Array<Self::Dof, T>,
        qd: &Array<Self::Dof, T>,
        r: &Array<Self::Base, T>,
    ) -> [T; 3] {
        left_out!("com_velocity")
    }

    fn gravity_moments<T: Real>(
        q: &Array<Self::Dof, T>,
        r: &Array<Self::Base, T>,
    ) -> Array<Self::Dof, T> {
        left_out!("gravity_moments")
    }

    fn regressor_into<T: Real>(q: &Array<Self::Dof, T>, rows: &mut [Array<Self::Base, T>; 3]) {
        left_out!("regressor")
    }

    fn regressor_cop_into<T: Real>(q: &Array<Self::Dof, T>, rows: &mut [Array<Self::Base, T>; 2]) {
        left_out!("regressor_cop")
    }

    fn regressor_full_into<T: Real>(q: &Array<Self::Dof, T>, rows: &mut [Array<Self::Full, T>; 3]) {
        left_out!("regressor_full")
    }

    fn cop<T: Real>(q: &Array<Self::Dof, T>, r: &Array<Self::Base, T>) -> [T; 2] {
        left_out!("cop")
    }

    fn cop_jacobian_into<T: Real>(
        q: &Array<Self::Dof, T>,
        r: &Array<Self::Base, T>,
        jacobian: &mut [Array<Self::Dof, T>; 2],
    ) {
        left_out!("cop_jacobian")
    }

    fn zmp<T: Real>(
        q: &Array<Self::Dof, T>,
        qd: &Array<Self::Dof, T>,
        qdd: &Array<Self::Dof, T>,
        r: &Array<Self::Base, T>,
    ) -> [T; 2] {
        left_out!("zmp")
    }

    /// The CoP behind a reading: the reading itself where the model has no sensor effects.
    #[inline(always)]
    fn correct_cop<T: Real>(reading: &[T; 2]) -> [T; 2] {
        *reading
    }
}

/// The functions of [`SescFromSinCos`](crate::SescFromSinCos), and rows combined by a
/// direction d (`along`) of the support frame, ‖d‖ ≤ 1: `dᵀ J` and `dᵀ Y`. Three
/// directions side by side in `T` give the three rows of one posture.
#[allow(missing_docs, unused_variables)]
pub trait SinCosRobot: Robot {
    fn com_sc<T: Real>(
        sin: &Array<Self::Dof, T>,
        cos: &Array<Self::Dof, T>,
        r: &Array<Self::Base, T>,
    ) -> [T; 3];

    fn com_jacobian_sc<T: Real>(
        sin: &Array<Self::Dof, T>,
        cos: &Array<Self::Dof, T>,
        r: &Array<Self::Base, T>,
    ) -> [Array<Self::Dof, T>; 3] {
        left_out!("com_jacobian")
    }

    fn com_velocity_sc<T: Real>(
        sin: &Array<Self::Dof, T>,
        cos: &Array<Self::Dof, T>,
        qd: &Array<Self::Dof, T>,
        r: &Array<Self::Base, T>,
    ) -> [T; 3] {
        left_out!("com_velocity")
    }

    fn gravity_moments_sc<T: Real>(
        sin: &Array<Self::Dof, T>,
        cos: &Array<Self::Dof, T>,
        r: &Array<Self::Base, T>,
    ) -> Array<Self::Dof, T> {
        left_out!("gravity_moments")
    }

    fn regressor_sc<T: Real>(
        sin: &Array<Self::Dof, T>,
        cos: &Array<Self::Dof, T>,
    ) -> [Array<Self::Base, T>; 3] {
        left_out!("regressor")
    }

    fn regressor_cop_sc<T: Real>(
        sin: &Array<Self::Dof, T>,
        cos: &Array<Self::Dof, T>,
    ) -> [Array<Self::Base, T>; 2] {
        left_out!("regressor_cop")
    }

    fn regressor_full_sc<T: Real>(
        sin: &Array<Self::Dof, T>,
        cos: &Array<Self::Dof, T>,
    ) -> [Array<Self::Full, T>; 3] {
        left_out!("regressor_full")
    }

    fn cop_sc<T: Real>(
        sin: &Array<Self::Dof, T>,
        cos: &Array<Self::Dof, T>,
        r: &Array<Self::Base, T>,
    ) -> [T; 2] {
        left_out!("cop")
    }

    fn cop_jacobian_sc<T: Real>(
        sin: &Array<Self::Dof, T>,
        cos: &Array<Self::Dof, T>,
        r: &Array<Self::Base, T>,
    ) -> [Array<Self::Dof, T>; 2] {
        left_out!("cop_jacobian")
    }

    fn zmp_sc<T: Real>(
        sin: &Array<Self::Dof, T>,
        cos: &Array<Self::Dof, T>,
        qd: &Array<Self::Dof, T>,
        qdd: &Array<Self::Dof, T>,
        r: &Array<Self::Base, T>,
    ) -> [T; 2] {
        left_out!("zmp")
    }

    #[inline(always)]
    fn com_jacobian_along<T: Real>(
        sin: &Array<Self::Dof, T>,
        cos: &Array<Self::Dof, T>,
        r: &Array<Self::Base, T>,
        along: &[T; 3],
    ) -> Array<Self::Dof, T> {
        combined::<Self::Dof, T>(&Self::com_jacobian_sc(sin, cos, r), along)
    }

    #[inline(always)]
    fn regressor_along<T: Real>(
        sin: &Array<Self::Dof, T>,
        cos: &Array<Self::Dof, T>,
        along: &[T; 3],
    ) -> Array<Self::Base, T> {
        combined::<Self::Base, T>(&Self::regressor_sc(sin, cos), along)
    }

    #[inline(always)]
    fn regressor_full_along<T: Real>(
        sin: &Array<Self::Dof, T>,
        cos: &Array<Self::Dof, T>,
        along: &[T; 3],
    ) -> Array<Self::Full, T> {
        combined::<Self::Full, T>(&Self::regressor_full_sc(sin, cos), along)
    }
}

#[inline(always)]
fn combined<D: Dim, T: Real>([x, y, z]: &[D::Array<T>; 3], d: &[T; 3]) -> D::Array<T> {
    D::from_fn(|k| x[k] * d[0] + y[k] * d[1] + z[k] * d[2])
}

/// A robot whose model has effects of its CoP sensor: [`CorrectCop`](crate::CorrectCop).
pub trait SensorEffects: Robot {}

/// Fails where generated code was written for another version than this module's, with a
/// sentence that says what to do.
#[doc(hidden)]
#[macro_export]
macro_rules! __interface {
    (1) => {};
    ($other:tt) => {
        compile_error!(concat!(
            "this file was generated for version ",
            stringify!($other),
            " of the interface between sesc-codegen and sesc-runtime, and the sesc-runtime of \
             this build has version 1: give both crates the same version in Cargo.toml, and \
             where the file was written by `sesc generate`, write it again with that version"
        ));
    };
}

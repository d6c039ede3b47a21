//! Numbers of joints and of parameters, as types.
//!
//! ```text
//! R::Dof = Const<20>        Posture<R> = <R::Dof as Dim>::Array<f64> = [f64; 20]
//! ```
//!
//! A length `[f64; R::DOF]` with an associated constant of a type parameter is not stable
//! Rust, so a robot names its numbers by types that know their arrays. A function for any
//! robot `R` then needs no number beside `R`, and for a given robot all types are plain
//! arrays. An associated `type Posture<T>` without a number behind it would not do: nothing
//! would say that a posture of `f64` and one of lanes have the same length, and no loop
//! could turn one into the other.

use core::ops::{Index, IndexMut};

use crate::scalar::{Scalar, sealed::Machine};

/// A number of joints or of parameters, as a type: [`Const<N>`](Const) and no other.
///
/// ```
/// use sesc_runtime::{Dim, Params, Real, Sesc};
///
/// /// The CAD parameters of any robot, in another scalar.
/// fn cad<R: Sesc, T: Real>() -> Params<R, T> {
///     <R::Base as Dim>::from_fn(|k| T::from_f64(R::CAD_PARAMS[k]))
/// }
///
/// use sesc_generated::two_link_foot::{CAD_PARAMS, TwoLinkFoot};
/// assert_eq!(cad::<TwoLinkFoot, f32>(), CAD_PARAMS.map(|r| r as f32));
/// ```
pub trait Dim: sealed::Sealed {
    /// The number itself.
    ///
    /// ```
    /// use sesc_runtime::{Const, Dim};
    ///
    /// assert_eq!(<Const<20> as Dim>::LEN, 20);
    /// ```
    const LEN: usize;

    /// The array of this length: `[T; N]`.
    type Array<T: Copy>: Copy
        + AsRef<[T]>
        + AsMut<[T]>
        + Index<usize, Output = T>
        + IndexMut<usize>
        + IntoIterator<Item = T>;

    /// The array whose entry k is `f(k)`.
    ///
    /// ```
    /// use sesc_runtime::{Const, Dim};
    ///
    /// assert_eq!(<Const<3> as Dim>::from_fn(|k| 2 * k), [0, 2, 4]);
    /// ```
    fn from_fn<T: Copy>(f: impl FnMut(usize) -> T) -> Self::Array<T>;

    /// The array of `x` in every entry.
    ///
    /// ```
    /// use sesc_runtime::{Const, Dim};
    ///
    /// assert_eq!(<Const<3> as Dim>::filled(0.5), [0.5; 3]);
    /// ```
    fn filled<T: Copy>(x: T) -> Self::Array<T>;

    /// [`Machine::load`] of this many blocks.
    #[doc(hidden)]
    fn load<S: Scalar, X: Machine<S>>(
        blocks: &Self::Array<S::Block>,
        part: usize,
    ) -> Self::Array<X::Vector>;

    /// [`Machine::columns`] of this many columns.
    #[doc(hidden)]
    fn columns<S: Scalar, X: Machine<S>>(
        rows: &[Self::Array<S>],
        part: usize,
    ) -> Self::Array<X::Vector>;

    /// [`Machine::place`] of rows that are so long.
    #[doc(hidden)]
    fn place<'a, S: Scalar, X: Machine<S>, const M: usize>(
        blocks: &'a mut [Self::Array<S::Block>; M],
        room: &'a mut [Self::Array<X::Vector>; M],
    ) -> &'a mut [Self::Array<X::Vector>; M];

    /// [`Machine::ones`] of this many scalars.
    #[doc(hidden)]
    fn ones<S: Scalar, X: Machine<S>>(scalars: &Self::Array<S>) -> &Self::Array<X::One>;

    /// [`Machine::sin_cos`] of this many angles.
    #[doc(hidden)]
    fn sin_cos<S: Scalar, X: Machine<S>>(
        angles: &Self::Array<S>,
        sin: &mut Self::Array<S>,
        cos: &mut Self::Array<S>,
    );
}

/// The number `N` as a type, whose arrays are `[T; N]`.
///
/// ```
/// use sesc_runtime::{Const, Dim};
///
/// assert_eq!(<Const<20> as Dim>::LEN, 20);
/// let q: <Const<2> as Dim>::Array<f64> = [0.1, 0.2];
/// assert_eq!(q.len(), 2);
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Const<const N: usize>;

impl<const N: usize> Dim for Const<N> {
    const LEN: usize = N;
    type Array<T: Copy> = [T; N];

    #[inline(always)]
    fn from_fn<T: Copy>(f: impl FnMut(usize) -> T) -> [T; N] {
        core::array::from_fn(f)
    }

    #[inline(always)]
    fn filled<T: Copy>(x: T) -> [T; N] {
        [x; N]
    }

    #[inline(always)]
    fn load<S: Scalar, X: Machine<S>>(blocks: &[S::Block; N], part: usize) -> [X::Vector; N] {
        X::load(blocks, part)
    }

    #[inline(always)]
    fn columns<S: Scalar, X: Machine<S>>(rows: &[[S; N]], part: usize) -> [X::Vector; N] {
        X::columns(rows, part)
    }

    #[inline(always)]
    fn place<'a, S: Scalar, X: Machine<S>, const M: usize>(
        blocks: &'a mut [[S::Block; N]; M],
        room: &'a mut [[X::Vector; N]; M],
    ) -> &'a mut [[X::Vector; N]; M] {
        X::place(blocks, room)
    }

    #[inline(always)]
    fn ones<S: Scalar, X: Machine<S>>(scalars: &[S; N]) -> &[X::One; N] {
        X::ones(scalars)
    }

    #[inline(always)]
    fn sin_cos<S: Scalar, X: Machine<S>>(angles: &[S; N], sin: &mut [S; N], cos: &mut [S; N]) {
        X::sin_cos(angles, sin, cos);
    }
}

mod sealed {
    /// No other type is a number.
    pub trait Sealed {}
    impl<const N: usize> Sealed for super::Const<N> {}
}

//! Many postures, a row each, however many.
//!
//! ```text
//! out[k] = f(q[k])        k = 0 .. n, in blocks of 8 (f32: 16), the last one filled up
//! ```
//!
//! Rows of postures are turned into blocks, a column per joint; [`Batch`] evaluates these, and
//! its results are turned into rows again. Nothing passes between lanes, so row k has the bits
//! that [`Batch`] gives for posture k, wherever it stands in its block. What is left of the last
//! block repeats its last posture.

use core::error;
use core::fmt;

use super::batch::Batch;
use crate::dim::{Const, Dim};
use crate::model::{FullParams, Params, Posture, Sesc};
use crate::real::Real as _;
use crate::scalar::sealed::{Machine, Task};
use crate::scalar::{Block, Scalar, Simd};

/// Blocks that are evaluated at a time where results are vectors: they stay in the first cache.
const VECTORS: usize = 8;
/// The same where results are matrices: their rows take kilobytes of stack.
const MATRICES: usize = 1;
/// Postures of the largest block.
const MOST: usize = 16;

/// The functions of [`Sesc`] on slices of postures of any length.
///
/// Row k of the results belongs to posture k. A posture out of the domain of the sine gives NaN
/// and leaves the others alone. Takes some kilobytes of stack: 8 blocks of the posture, or a
/// block of the rows. Who keeps postures in blocks calls [`Batch`] and spares the turning of
/// rows into columns and back.
///
/// ```
/// use sesc_generated::two_link_foot::TwoLinkFoot;
/// use sesc_runtime::{Many, Posture, Sesc, Simd, UnequalLengths};
///
/// /// Heights of the CoM of any robot, metres.
/// fn heights<R: Sesc>(q: &[Posture<R>], z: &mut [f64]) -> Result<(), UnequalLengths> {
///     let mut com = vec![[0.0; 3]; q.len()];
///     R::com_many(Simd::best(), q, &R::CAD_PARAMS, &mut com)?;
///     z.iter_mut().zip(com).for_each(|(z, com)| *z = com[2]);
///     Ok(())
/// }
///
/// let q: Vec<[f64; 2]> = (0..100).map(|k| [0.01 * k as f64, 0.0]).collect();
/// let mut z = vec![0.0; 100];
/// heights::<TwoLinkFoot>(&q, &mut z)?;
/// assert!((z[0] - 0.45).abs() < 1e-15 && z[99] < z[0]);
/// # Ok::<(), UnequalLengths>(())
/// ```
pub trait Many: Batch {
    /// [`Sesc::com`] of every posture, metres.
    ///
    /// ```
    /// # use sesc_generated::two_link_foot::{CAD_PARAMS, TwoLinkFoot};
    /// # use sesc_runtime::{Many, Simd};
    /// let q = [[0.0, 0.0], [0.1, 0.0], [0.2, 0.0]];
    /// let mut com = [[0.0; 3]; 3];
    /// TwoLinkFoot::com_many(Simd::best(), &q, &CAD_PARAMS, &mut com)?;
    /// assert!((com[0][2] - 0.45).abs() < 1e-15 && com[2][2] < com[1][2]);
    /// # Ok::<(), sesc_runtime::UnequalLengths>(())
    /// ```
    ///
    /// # Errors
    ///
    /// When there are not as many results as postures; nothing is written then.
    fn com_many<S: Scalar>(
        simd: Simd,
        q: &[Posture<Self, S>],
        r: &Params<Self, S>,
        com: &mut [[S; 3]],
    ) -> Result<(), UnequalLengths> {
        vectors::<Self, S, Const<3>>(simd, q, com, |q, com| {
            Self::com_batch::<S::Block>(simd, q, r, com);
        })
    }

    /// [`Sesc::com_jacobian`] of every posture, `[row][joint]`, metres per radian.
    ///
    /// ```
    /// # use sesc_generated::two_link_foot::{CAD_PARAMS, TwoLinkFoot};
    /// # use sesc_runtime::{Many, Simd};
    /// let mut jacobian = [[[0.0; 2]; 3]];
    /// TwoLinkFoot::com_jacobian_many(Simd::best(), &[[0.0, 0.0]], &CAD_PARAMS, &mut jacobian)?;
    /// assert!((jacobian[0][0][0] - 0.36).abs() < 1e-15);
    /// # Ok::<(), sesc_runtime::UnequalLengths>(())
    /// ```
    ///
    /// # Errors
    ///
    /// When there are not as many results as postures; nothing is written then.
    fn com_jacobian_many<S: Scalar>(
        simd: Simd,
        q: &[Posture<Self, S>],
        r: &Params<Self, S>,
        jacobian: &mut [[Posture<Self, S>; 3]],
    ) -> Result<(), UnequalLengths> {
        matrices::<Self, S, Self::Dof, 3>(simd, q, jacobian, |q, jacobian| {
            Self::com_jacobian_batch::<S::Block>(simd, q, r, jacobian);
        })
    }

    /// [`Sesc::gravity_moments`] of every posture, metres.
    ///
    /// ```
    /// # use sesc_generated::two_link_foot::{CAD_PARAMS, TwoLinkFoot};
    /// # use sesc_runtime::{Many, Simd};
    /// let mut moments = [[1.0; 2]];
    /// TwoLinkFoot::gravity_moments_many(Simd::best(), &[[0.0, 0.0]], &CAD_PARAMS, &mut moments)?;
    /// assert_eq!(moments, [[0.0, 0.0]]);
    /// # Ok::<(), sesc_runtime::UnequalLengths>(())
    /// ```
    ///
    /// # Errors
    ///
    /// When there are not as many results as postures; nothing is written then.
    fn gravity_moments_many<S: Scalar>(
        simd: Simd,
        q: &[Posture<Self, S>],
        r: &Params<Self, S>,
        moments: &mut [Posture<Self, S>],
    ) -> Result<(), UnequalLengths> {
        vectors::<Self, S, Self::Dof>(simd, q, moments, |q, moments| {
            Self::gravity_moments_batch::<S::Block>(simd, q, r, moments);
        })
    }

    /// [`Sesc::regressor`] of every posture.
    ///
    /// ```
    /// # use sesc_generated::two_link_foot::TwoLinkFoot;
    /// # use sesc_runtime::{Many, Simd};
    /// let mut rows = [[[0.0; 7]; 3]];
    /// TwoLinkFoot::regressor_many(Simd::best(), &[[0.0, 0.0]], &mut rows)?;
    /// assert_eq!(rows[0][2][2], 1.0);
    /// # Ok::<(), sesc_runtime::UnequalLengths>(())
    /// ```
    ///
    /// # Errors
    ///
    /// When there are not as many results as postures; nothing is written then.
    fn regressor_many<S: Scalar>(
        simd: Simd,
        q: &[Posture<Self, S>],
        rows: &mut [[Params<Self, S>; 3]],
    ) -> Result<(), UnequalLengths> {
        matrices::<Self, S, Self::Base, 3>(simd, q, rows, |q, rows| {
            Self::regressor_batch::<S::Block>(simd, q, rows);
        })
    }

    /// [`Sesc::regressor_cop`] of every posture.
    ///
    /// ```
    /// # use sesc_generated::two_link_foot::TwoLinkFoot;
    /// # use sesc_runtime::{Many, Simd};
    /// let mut rows = [[[0.0; 7]; 2]];
    /// TwoLinkFoot::regressor_cop_many(Simd::best(), &[[0.0, 0.0]], &mut rows)?;
    /// assert_eq!(rows[0][0][0], 1.0);
    /// # Ok::<(), sesc_runtime::UnequalLengths>(())
    /// ```
    ///
    /// # Errors
    ///
    /// When there are not as many results as postures; nothing is written then.
    fn regressor_cop_many<S: Scalar>(
        simd: Simd,
        q: &[Posture<Self, S>],
        rows: &mut [[Params<Self, S>; 2]],
    ) -> Result<(), UnequalLengths> {
        matrices::<Self, S, Self::Base, 2>(simd, q, rows, |q, rows| {
            Self::regressor_cop_batch::<S::Block>(simd, q, rows);
        })
    }

    /// [`Sesc::regressor_full`] of every posture.
    ///
    /// ```
    /// # use sesc_generated::two_link_foot::TwoLinkFoot;
    /// # use sesc_runtime::{Many, Simd};
    /// let mut rows = [[[0.0; 9]; 3]];
    /// TwoLinkFoot::regressor_full_many(Simd::best(), &[[0.0, 0.0]], &mut rows)?;
    /// assert_eq!(rows[0][1][1], 1.0);
    /// # Ok::<(), sesc_runtime::UnequalLengths>(())
    /// ```
    ///
    /// # Errors
    ///
    /// When there are not as many results as postures; nothing is written then.
    fn regressor_full_many<S: Scalar>(
        simd: Simd,
        q: &[Posture<Self, S>],
        rows: &mut [[FullParams<Self, S>; 3]],
    ) -> Result<(), UnequalLengths> {
        matrices::<Self, S, Self::Full, 3>(simd, q, rows, |q, rows| {
            Self::regressor_full_batch::<S::Block>(simd, q, rows);
        })
    }

    /// [`Sesc::cop`] of every posture, metres.
    ///
    /// ```
    /// # use sesc_generated::two_link_foot::{CAD_PARAMS, TwoLinkFoot};
    /// # use sesc_runtime::{Many, Simd};
    /// let mut cop = [[0.0; 2]];
    /// TwoLinkFoot::cop_many(Simd::best(), &[[0.0, 0.0]], &CAD_PARAMS, &mut cop)?;
    /// assert!((cop[0][0] - 0.01).abs() < 1e-15);
    /// # Ok::<(), sesc_runtime::UnequalLengths>(())
    /// ```
    ///
    /// # Errors
    ///
    /// When there are not as many results as postures; nothing is written then.
    fn cop_many<S: Scalar>(
        simd: Simd,
        q: &[Posture<Self, S>],
        r: &Params<Self, S>,
        cop: &mut [[S; 2]],
    ) -> Result<(), UnequalLengths> {
        vectors::<Self, S, Const<2>>(simd, q, cop, |q, cop| {
            Self::cop_batch::<S::Block>(simd, q, r, cop);
        })
    }
}

impl<M: Sesc> Many for M {}

/// There are not as many results as postures.
///
/// ```
/// use sesc_generated::two_link_foot::{CAD_PARAMS, TwoLinkFoot};
/// use sesc_runtime::{Many, Simd};
///
/// let (q, mut com) = ([[0.0; 2]; 10], [[0.0; 3]; 9]);
/// let error = TwoLinkFoot::com_many(Simd::best(), &q, &CAD_PARAMS, &mut com).unwrap_err();
/// assert_eq!((error.postures, error.results), (10, 9));
/// assert_eq!(error.to_string(), "10 postures but room for 9 results; give one for each");
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct UnequalLengths {
    /// Postures given.
    pub postures: usize,
    /// Results that there is room for.
    pub results: usize,
}

impl fmt::Display for UnequalLengths {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { postures, results } = self;
        write!(
            f,
            "{postures} postures but room for {results} results; give one for each"
        )
    }
}

impl error::Error for UnequalLengths {}

/// A function whose results are vectors.
fn vectors<R: Sesc, S: Scalar, D: Dim>(
    simd: Simd,
    q: &[Posture<R, S>],
    out: &mut [D::Array<S>],
    run: impl Fn(&[Posture<R, S::Block>], &mut [D::Array<S::Block>]),
) -> Result<(), UnequalLengths> {
    let blocks = [D::filled(S::Block::from_f64(0.0)); VECTORS];
    in_blocks::<R, S, _, _, _>(simd, q, out, blocks, run, |block, rows| {
        turn(block.as_ref(), rows, |row| row.as_mut());
    })
}

/// A function whose results are matrices.
fn matrices<R: Sesc, S: Scalar, D: Dim, const ROWS: usize>(
    simd: Simd,
    q: &[Posture<R, S>],
    out: &mut [[D::Array<S>; ROWS]],
    run: impl Fn(&[Posture<R, S::Block>], &mut [[D::Array<S::Block>; ROWS]]),
) -> Result<(), UnequalLengths> {
    let blocks = [[D::filled(S::Block::from_f64(0.0)); ROWS]; MATRICES];
    in_blocks::<R, S, _, _, _>(simd, q, out, blocks, run, |block, rows| {
        for (k, block) in block.iter().enumerate() {
            turn(block.as_ref(), rows, |row| row[k].as_mut());
        }
    })
}

/// All postures, so many blocks at a time as there are in `found`: `run` evaluates them, and
/// `unpack` writes the rows of a block.
fn in_blocks<R: Sesc, S: Scalar, Found, To, const BLOCKS: usize>(
    simd: Simd,
    q: &[Posture<R, S>],
    out: &mut [To],
    mut found: [Found; BLOCKS],
    run: impl Fn(&[Posture<R, S::Block>], &mut [Found]),
    unpack: impl Fn(&Found, &mut [To]),
) -> Result<(), UnequalLengths> {
    let [postures, results] = [q.len(), out.len()];
    if postures != results {
        return Err(UnequalLengths { postures, results });
    }
    let zero = S::Block::from_f64(0.0);
    let lanes = zero.lanes().len();
    let mut packed = [<R::Dof as Dim>::filled(zero); BLOCKS];
    let each = BLOCKS * lanes;
    for (q, out) in q.chunks(each).zip(out.chunks_mut(each)) {
        let whole = q.len() / lanes;
        let (rows, rest) = q.split_at(whole * lanes);
        let blocks = &mut packed[..q.len().div_ceil(lanes)];
        S::run(simd, Pack::<R::Dof, S> { rows, blocks });
        if let (Some(last), Some(block)) = (rest.last(), blocks.get_mut(whole..)) {
            let mut rows = [*last; MOST];
            rows[..rest.len()].copy_from_slice(rest);
            let (rows, blocks) = (&rows[..lanes], block);
            S::run(simd, Pack::<R::Dof, S> { rows, blocks });
        }
        run(blocks, &mut found);
        for (found, out) in found.iter().zip(out.chunks_mut(lanes)) {
            unpack(found, out);
        }
    }
    Ok(())
}

/// Rows of postures as blocks, a whole one each.
struct Pack<'a, D: Dim, S: Scalar> {
    rows: &'a [D::Array<S>],
    blocks: &'a mut [D::Array<S::Block>],
}

impl<D: Dim, S: Scalar> Task<S> for Pack<'_, D, S> {
    #[inline(always)]
    fn run<X: Machine<S>>(self) {
        let lanes = S::Block::from_f64(0.0).lanes().len();
        for (rows, block) in self.rows.chunks_exact(lanes).zip(self.blocks) {
            for part in 0..X::PARTS {
                let columns = D::columns::<S, X>(rows, part);
                X::store(columns.as_ref(), block.as_mut(), part);
            }
        }
    }
}

/// The numbers of a block into rows: entry k of each row, as `row` finds it in a result.
fn turn<B: Block, To>(block: &[B], out: &mut [To], row: impl Fn(&mut To) -> &mut [B::Scalar]) {
    for (k, entry) in block.iter().enumerate() {
        for (out, x) in out.iter_mut().zip(entry.lanes()) {
            if let Some(place) = row(out).get_mut(k) {
                *place = *x;
            }
        }
    }
}

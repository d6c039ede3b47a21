//! What a generated robot model offers.
//!
//! ```text
//! CoM(q) = r_0 + Σ B_i(q) r_i
//! ```
//!
//! `B_i` turns body i into the support frame; `r_i` gathers masses and lengths and
//! is the same in every posture. At a prismatic joint j, `B_parent(j) a_j q_j s_j`
//! is added: its axis, its position, and the share `s_j` of the mass it carries.
//!
//! All `r_i` and `s_j`, stacked, are the *full* parameters. Those directions of them
//! that no posture shows are left out of the *base* parameters `r`, and in these
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

use crate::real::Real;

/// A robot seen from one support link: implemented by generated unit structs.
///
/// `DOF` joint positions in the order of [`JOINT_NAMES`](Self::JOINT_NAMES), radians
/// (metres at a prismatic joint); `BASE` base and `FULL` full parameters. Parameters
/// are lengths in metres, except the mass share `s_j` of a prismatic joint, which
/// is a plain ratio.
///
/// No function allocates, branches or panics. Where a joint angle is out of the
/// domain of [`Real::sin_cos`], what depends on it is NaN.
///
/// ```
/// use sesc_runtime::{Real, Sesc};
///
/// /// Moments, in N m, with which the joints have to hold a posture.
/// fn holding_moments<M, const DOF: usize, const BASE: usize, const FULL: usize>(
///     q: &[f64; DOF],
///     mass_kg: f64,
/// ) -> [f64; DOF]
/// where
///     M: Sesc<DOF, BASE, FULL>,
/// {
///     let weight_n = mass_kg * 9.80665;
///     M::gravity_moments(q, &M::CAD_PARAMS).map(|moment_m| -weight_n * moment_m)
/// }
///
/// /// The CAD parameters for any scalar.
/// fn cad<M, T: Real, const DOF: usize, const BASE: usize, const FULL: usize>() -> [T; BASE]
/// where
///     M: Sesc<DOF, BASE, FULL>,
/// {
///     M::CAD_PARAMS.map(T::from_f64)
/// }
/// ```
pub trait Sesc<const DOF: usize, const BASE: usize, const FULL: usize> {
    /// Names of the joints, in the order of `q`.
    const JOINT_NAMES: [&'static str; DOF];

    /// Which joints slide: their position is in metres.
    const PRISMATIC: [bool; DOF];

    /// Base parameters from CAD, metres.
    const CAD_PARAMS: [f64; BASE];

    /// Centre of mass, metres, in the support frame: `r_0 + Σ B_i(q) r_i`.
    fn com<T: Real>(q: &[T; DOF], r: &[T; BASE]) -> [T; 3];

    /// Derivatives of [`com`](Self::com): `[row][joint]`, metres per radian (at a
    /// prismatic joint, metres per metre).
    fn com_jacobian<T: Real>(q: &[T; DOF], r: &[T; BASE]) -> [[T; DOF]; 3];

    /// Moment of gravity at each joint, `τ_j = -(J_j)_z`, per kg of total mass and per
    /// unit of g: metres. Times `M g` it is in N m (at a prismatic joint, the
    /// force in N, the value here being a plain ratio); the joint holds the posture
    /// with the opposite.
    fn gravity_moments<T: Real>(q: &[T; DOF], r: &[T; BASE]) -> [T; DOF];

    /// The regressor `Y`: `[row][base parameter]`, with `CoM = Y r`. No unit, except
    /// metres in the column of a mass share `s_j`.
    fn regressor<T: Real>(q: &[T; DOF]) -> [[T; BASE]; 3];

    /// The x and y rows of [`regressor`](Self::regressor) alone.
    fn regressor_cop<T: Real>(q: &[T; DOF]) -> [[T; BASE]; 2];

    /// The regressor of the full parameters: `[row][full parameter]`.
    fn regressor_full<T: Real>(q: &[T; DOF]) -> [[T; FULL]; 3];

    /// The predicted reading of the centre of pressure, metres, in the support frame,
    /// with the effects of the model if it has any.
    fn cop<T: Real>(q: &[T; DOF], r: &[T; BASE]) -> [T; 2];

    /// [`com_jacobian`](Self::com_jacobian) into a matrix that is there. Generated code
    /// writes each number as soon as it has it, and keeps none for the end.
    fn com_jacobian_into<T: Real>(q: &[T; DOF], r: &[T; BASE], jacobian: &mut [[T; DOF]; 3]) {
        *jacobian = Self::com_jacobian(q, r);
    }

    /// [`regressor`](Self::regressor) likewise.
    fn regressor_into<T: Real>(q: &[T; DOF], rows: &mut [[T; BASE]; 3]) {
        *rows = Self::regressor(q);
    }

    /// [`regressor_cop`](Self::regressor_cop) likewise.
    fn regressor_cop_into<T: Real>(q: &[T; DOF], rows: &mut [[T; BASE]; 2]) {
        *rows = Self::regressor_cop(q);
    }

    /// [`regressor_full`](Self::regressor_full) likewise.
    fn regressor_full_into<T: Real>(q: &[T; DOF], rows: &mut [[T; FULL]; 3]) {
        *rows = Self::regressor_full(q);
    }
}

/// The functions of [`Sesc`] from given sines and cosines.
///
/// For a controller that has them already, or takes them from a table. `sin[j]` and
/// `cos[j]` belong to joint j and should lie on the unit circle; at a prismatic joint
/// `sin[j]` carries the position q_j in metres and `cos[j]` is not read. Shapes
/// and units are those of [`Sesc`].
pub trait SescFromSinCos<const DOF: usize, const BASE: usize, const FULL: usize>:
    Sesc<DOF, BASE, FULL>
{
    /// [`Sesc::com`] from sines and cosines.
    fn com_sc<T: Real>(sin: &[T; DOF], cos: &[T; DOF], r: &[T; BASE]) -> [T; 3];

    /// [`Sesc::com_jacobian`] from sines and cosines.
    fn com_jacobian_sc<T: Real>(sin: &[T; DOF], cos: &[T; DOF], r: &[T; BASE]) -> [[T; DOF]; 3];

    /// [`Sesc::gravity_moments`] from sines and cosines.
    fn gravity_moments_sc<T: Real>(sin: &[T; DOF], cos: &[T; DOF], r: &[T; BASE]) -> [T; DOF];

    /// [`Sesc::regressor`] from sines and cosines.
    fn regressor_sc<T: Real>(sin: &[T; DOF], cos: &[T; DOF]) -> [[T; BASE]; 3];

    /// [`Sesc::regressor_cop`] from sines and cosines.
    fn regressor_cop_sc<T: Real>(sin: &[T; DOF], cos: &[T; DOF]) -> [[T; BASE]; 2];

    /// [`Sesc::regressor_full`] from sines and cosines.
    fn regressor_full_sc<T: Real>(sin: &[T; DOF], cos: &[T; DOF]) -> [[T; FULL]; 3];

    /// [`Sesc::cop`] from sines and cosines.
    fn cop_sc<T: Real>(sin: &[T; DOF], cos: &[T; DOF], r: &[T; BASE]) -> [T; 2];

    /// `dᵀ J`: rows of [`Sesc::com_jacobian`] combined by a direction `d` of the support
    /// frame, no longer than one. With three directions side by side in `T`, three rows.
    fn com_jacobian_along<T: Real>(
        sin: &[T; DOF],
        cos: &[T; DOF],
        r: &[T; BASE],
        along: &[T; 3],
    ) -> [T; DOF] {
        combined(&Self::com_jacobian_sc(sin, cos, r), along)
    }

    /// `dᵀ Y`: rows of [`Sesc::regressor`] combined likewise.
    fn regressor_along<T: Real>(sin: &[T; DOF], cos: &[T; DOF], along: &[T; 3]) -> [T; BASE] {
        combined(&Self::regressor_sc(sin, cos), along)
    }

    /// Rows of [`Sesc::regressor_full`] combined likewise.
    fn regressor_full_along<T: Real>(sin: &[T; DOF], cos: &[T; DOF], along: &[T; 3]) -> [T; FULL] {
        combined(&Self::regressor_full_sc(sin, cos), along)
    }
}

fn combined<T: Real, const N: usize>([x, y, z]: &[[T; N]; 3], d: &[T; 3]) -> [T; N] {
    core::array::from_fn(|k| x[k] * d[0] + y[k] * d[1] + z[k] * d[2])
}

/// A robot whose model has effects of its CoP sensor.
pub trait CorrectCop {
    /// The centre of pressure, metres, that a reading was made of: what
    /// [`Sesc::cop`] would be without the effects of the sensor, a wrong cell, a
    /// gain, a turn, an offset, swapped axes, the unit of the record. Means nothing
    /// where no CoP on the foot has that reading.
    fn correct_cop<T: Real>(reading: &[T; 2]) -> [T; 2];
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lanes::{F64x8, Lanes};

    /// A foot and a leg that pitches about y: what the generator would write,
    /// derived by hand. Base parameters: r_0 (3), then x and z of r_1, whose y lies
    /// along the axis and is part of r_0.
    struct Leg;

    impl Sesc<1, 5, 6> for Leg {
        const JOINT_NAMES: [&'static str; 1] = ["ankle_pitch"];
        const PRISMATIC: [bool; 1] = [false];
        const CAD_PARAMS: [f64; 5] = [0.01, -0.005, 0.03, 0.02, 0.25];

        fn com<T: Real>(q: &[T; 1], r: &[T; 5]) -> [T; 3] {
            let (s, c) = q[0].sin_cos();
            Self::com_sc(&[s], &[c], r)
        }

        fn com_jacobian<T: Real>(q: &[T; 1], r: &[T; 5]) -> [[T; 1]; 3] {
            let (s, c) = q[0].sin_cos();
            Self::com_jacobian_sc(&[s], &[c], r)
        }

        fn gravity_moments<T: Real>(q: &[T; 1], r: &[T; 5]) -> [T; 1] {
            let (s, c) = q[0].sin_cos();
            Self::gravity_moments_sc(&[s], &[c], r)
        }

        fn regressor<T: Real>(q: &[T; 1]) -> [[T; 5]; 3] {
            let (s, c) = q[0].sin_cos();
            Self::regressor_sc(&[s], &[c])
        }

        fn regressor_cop<T: Real>(q: &[T; 1]) -> [[T; 5]; 2] {
            let (s, c) = q[0].sin_cos();
            Self::regressor_cop_sc(&[s], &[c])
        }

        fn regressor_full<T: Real>(q: &[T; 1]) -> [[T; 6]; 3] {
            let (s, c) = q[0].sin_cos();
            Self::regressor_full_sc(&[s], &[c])
        }

        fn cop<T: Real>(q: &[T; 1], r: &[T; 5]) -> [T; 2] {
            let (s, c) = q[0].sin_cos();
            Self::cop_sc(&[s], &[c], r)
        }
    }

    impl SescFromSinCos<1, 5, 6> for Leg {
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

    const R: [f64; 5] = Leg::CAD_PARAMS;

    fn times<const COLUMNS: usize>(rows: &[[f64; COLUMNS]; 3], r: &[f64; COLUMNS]) -> [f64; 3] {
        rows.map(|row| row.iter().zip(r).map(|(a, b)| a * b).sum())
    }

    #[test]
    fn regressors_times_parameters_are_the_com() {
        for q in [-1.2, -0.3, 0.0, 0.7, 2.0] {
            let com = Leg::com(&[q], &R);
            // The unseen y of r_1 may be shared out as one likes.
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

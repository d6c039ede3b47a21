//! The functions of a robot written by hand.

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

        fn com_velocity<T: Real>(q: &[T; 1], qd: &[T; 1], r: &[T; 5]) -> [T; 3] {
            let (s, c) = q[0].sin_cos();
            Self::com_velocity_sc(&[s], &[c], qd, r)
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

        fn zmp<T: Real>(q: &[T; 1], qd: &[T; 1], qdd: &[T; 1], r: &[T; 5]) -> [T; 2] {
            let (s, c) = q[0].sin_cos();
            Self::zmp_sc(&[s], &[c], qd, qdd, r)
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

        fn com_velocity_sc<T: Real>(sin: &[T; 1], cos: &[T; 1], qd: &[T; 1], r: &[T; 5]) -> [T; 3] {
            Self::com_jacobian_sc(sin, cos, r).map(|row| row[0] * qd[0])
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

        fn zmp_sc<T: Real>(
            sin: &[T; 1],
            cos: &[T; 1],
            qd: &[T; 1],
            qdd: &[T; 1],
            r: &[T; 5],
        ) -> [T; 2] {
            Self::cop_sc(sin, cos, r).map(|x| x - qd[0] * qdd[0])
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

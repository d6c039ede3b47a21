//! Every instruction set of this machine against exact values, scalars and documented errors.

use std::println;
use std::vec::Vec;

use super::*;
use crate::model::Sesc;
use crate::trig::tests::{Exact, Random};
use crate::{Lanes, pack, trig, unpack};
use bench::Bench;

mod bench {
    use crate::__private::v1::{Const, Real, Robot, SinCosRobot};

    /// Two joints whose functions are what the registers do: sines and cosines, a fused
    /// product, a quotient, a clamp and a power. The second joint is prismatic.
    pub(super) struct Bench;

    impl Robot for Bench {
        type Dof = Const<2>;
        type Base = Const<2>;
        type Full = Const<2>;
        const JOINT_NAMES: [&'static str; 2] = ["revolute", "prismatic"];
        const PRISMATIC: [bool; 2] = [false, true];
        const JOINT_LOWER: [f64; 2] = [-6.0, -2.0];
        const JOINT_UPPER: [f64; 2] = [6.0, 2.0];
        const TOTAL_MASS_KG: f64 = 1.0;
        const CAD_PARAMS: [f64; 2] = [0.25, -3.0];

        fn com<T: Real>(q: &[T; 2], r: &[T; 2]) -> [T; 3] {
            let (s, c) = q[0].sin_cos();
            Self::com_sc(&[s, q[1]], &[c, T::from_f64(0.0)], r)
        }
        fn com_jacobian_into<T: Real>(q: &[T; 2], r: &[T; 2], jacobian: &mut [[T; 2]; 3]) {
            let [x, y, z] = Self::com(q, r);
            *jacobian = [[x, y], [y, z], [z, x]];
        }
        fn com_velocity<T: Real>(q: &[T; 2], qd: &[T; 2], r: &[T; 2]) -> [T; 3] {
            Self::com(q, r).map(|x| x * qd[0] + qd[1])
        }
        fn gravity_moments<T: Real>(q: &[T; 2], r: &[T; 2]) -> [T; 2] {
            [(q[0] / r[1]).clamp_unit(), (q[1] * q[1]).power(r[0])]
        }
        fn regressor_into<T: Real>(q: &[T; 2], rows: &mut [[T; 2]; 3]) {
            let (s, c) = q[0].sin_cos();
            *rows = [[s, c], [-s, q[0] - q[1]], [s + c, s * c]];
        }
        fn regressor_cop_into<T: Real>(q: &[T; 2], rows: &mut [[T; 2]; 2]) {
            let (s, c) = q[0].sin_cos();
            *rows = [[s, c], [c, s]];
        }
        fn regressor_full_into<T: Real>(q: &[T; 2], rows: &mut [[T; 2]; 3]) {
            Self::regressor_into(q, rows);
        }
        fn cop<T: Real>(q: &[T; 2], r: &[T; 2]) -> [T; 2] {
            let [x, y, _] = Self::com(q, r);
            [x, y]
        }
        fn zmp<T: Real>(q: &[T; 2], qd: &[T; 2], qdd: &[T; 2], r: &[T; 2]) -> [T; 2] {
            Self::cop(q, r).map(|x| x * qd[0] + qdd[1])
        }
    }

    impl SinCosRobot for Bench {
        fn com_sc<T: Real>(sin: &[T; 2], cos: &[T; 2], r: &[T; 2]) -> [T; 3] {
            let squares = sin[0].mul_plus(sin[0], -(cos[0] * cos[0]));
            [squares, sin[1].mul_plus(r[0], r[1]), sin[0]]
        }
        fn com_jacobian_sc<T: Real>(sin: &[T; 2], cos: &[T; 2], r: &[T; 2]) -> [[T; 2]; 3] {
            let [x, y, z] = Self::com_sc(sin, cos, r);
            [[x, y], [y, z], [z, x]]
        }
        fn com_velocity_sc<T: Real>(sin: &[T; 2], cos: &[T; 2], qd: &[T; 2], r: &[T; 2]) -> [T; 3] {
            Self::com_sc(sin, cos, r).map(|x| x * qd[0] + qd[1])
        }
        fn gravity_moments_sc<T: Real>(sin: &[T; 2], cos: &[T; 2], r: &[T; 2]) -> [T; 2] {
            [sin[0] * r[0], cos[0] * r[1]]
        }
        fn regressor_sc<T: Real>(sin: &[T; 2], cos: &[T; 2]) -> [[T; 2]; 3] {
            [[sin[0], cos[0]], [sin[1], sin[0]], [cos[0], sin[1]]]
        }
        fn regressor_cop_sc<T: Real>(sin: &[T; 2], cos: &[T; 2]) -> [[T; 2]; 2] {
            [[sin[0], cos[0]], [sin[1], sin[0]]]
        }
        fn regressor_full_sc<T: Real>(sin: &[T; 2], cos: &[T; 2]) -> [[T; 2]; 3] {
            Self::regressor_sc(sin, cos)
        }
        fn cop_sc<T: Real>(sin: &[T; 2], cos: &[T; 2], r: &[T; 2]) -> [T; 2] {
            let [x, y, _] = Self::com_sc(sin, cos, r);
            [x, y]
        }
        fn zmp_sc<T: Real>(
            sin: &[T; 2],
            cos: &[T; 2],
            qd: &[T; 2],
            qdd: &[T; 2],
            r: &[T; 2],
        ) -> [T; 2] {
            Self::cop_sc(sin, cos, r).map(|x| x * qd[0] + qdd[1])
        }
    }
}

/// Largest promised error of sine and cosine, in units of 2^-53 (f32: 2^-24).
const LIMIT_UNITS: f64 = 1.7;

/// Sines and cosines of eight angles by the lanes of a set.
fn double(simd: Simd, x: [f64; 8]) -> [(f64, f64); 8] {
    let mut rows = [[[F64x8::splat(0.0); 2]; 2]];
    Bench::regressor_cop_batch(simd, &[pack(&x.map(|x| [x, 0.0]))], &mut rows);
    core::array::from_fn(|i| (rows[0][0][0].0[i], rows[0][0][1].0[i]))
}

fn single(simd: Simd, x: [f32; 16]) -> [(f32, f32); 16] {
    let mut rows = [[[F32x16::splat(0.0); 2]; 2]];
    Bench::regressor_cop_batch(simd, &[pack(&x.map(|x| [x, 0.0]))], &mut rows);
    core::array::from_fn(|i| (rows[0][0][0].0[i], rows[0][0][1].0[i]))
}

/// Angles of all sizes, and beside every eighth of the first turns.
fn angles(seed: u64, count: usize, limit: f64) -> Vec<f64> {
    let mut random = Random::new(seed);
    (0..count)
        .map(|i| match i % 4 {
            0 => random.within(core::f64::consts::TAU),
            1 => random.within(limit),
            2 => {
                f64::from(i as i32 % 65 - 32) * (core::f64::consts::PI / 16.0) + random.within(1e-6)
            }
            _ => random.within(1.0) * f64::from(-(i as i32 % 300)).exp2(),
        })
        .collect()
}

#[test]
fn sines_and_cosines_of_doubles_are_near_the_exact() {
    for simd in Simd::available() {
        let (mut exact, mut worst) = (Exact::new(), 0.0_f64);
        for chunk in angles(11, 16_000, trig::LIMIT_RAD).chunks_exact(8) {
            let x: [f64; 8] = chunk.try_into().unwrap();
            for (x, found) in x.into_iter().zip(double(simd, x)) {
                let (s, c) = exact.errors(x, found);
                worst = worst.max(s.max(c) * 53_f64.exp2());
            }
        }
        println!("{}: {worst:.3} units", simd.name());
        assert!(worst <= LIMIT_UNITS);
    }
}

#[test]
fn sines_and_cosines_of_singles_are_near_the_exact() {
    let limit = f64::from(trig::LIMIT_RAD_F32);
    for simd in Simd::available() {
        let mut worst = 0.0_f64;
        for chunk in angles(12, 400_000, limit).chunks_exact(16) {
            let x: [f32; 16] = core::array::from_fn(|i| chunk[i] as f32);
            for (x, (s, c)) in x.into_iter().zip(single(simd, x)) {
                let (sin, cos) = trig::sin_cos(f64::from(x));
                let error = (sin - f64::from(s)).abs().max((cos - f64::from(c)).abs());
                worst = worst.max(error * 24_f64.exp2());
            }
        }
        println!("{}: {worst:.3} units", simd.name());
        assert!(worst <= LIMIT_UNITS);
    }
}

#[test]
fn out_of_the_domain_is_nan_in_its_lane_alone() {
    let past = f64::from_bits(trig::LIMIT_RAD.to_bits() + 1);
    let past_single = f32::from_bits(trig::LIMIT_RAD_F32.to_bits() + 1);
    for simd in Simd::available() {
        let none = [f64::INFINITY, f64::NEG_INFINITY, f64::NAN];
        for wrong in [past, -past, 1e300].into_iter().chain(none) {
            for lane in 0..8 {
                let mut x = [0.5, -1.0, 3.0, trig::LIMIT_RAD, -0.1, 2.0, 7.0, -40.0];
                let right = double(simd, x);
                x[lane] = wrong;
                for (i, found) in double(simd, x).into_iter().enumerate() {
                    match i == lane {
                        true => assert!(found.0.is_nan() && found.1.is_nan()),
                        false => assert_eq!(found, right[i]),
                    }
                }
            }
        }
        for wrong in [past_single, -past_single, f32::MAX, f32::INFINITY, f32::NAN] {
            let mut x = [1.0; 16];
            x[13] = wrong;
            let found = single(simd, x);
            assert!(found[13].0.is_nan() && found[13].1.is_nan());
            assert!(found[12].0.is_finite() && found[14].1.is_finite());
        }
    }
}

#[test]
fn the_portable_set_has_the_bits_of_scalars() {
    let postures: [[f64; 2]; 8] = core::array::from_fn(|i| [0.7 * i as f64 - 2.0, 0.1 * i as f64]);
    let mut com = [[F64x8::splat(0.0); 3]];
    let r = Bench::CAD_PARAMS;
    Bench::com_batch(Simd::PORTABLE, &[pack(&postures)], &r, &mut com);
    for (q, found) in postures.iter().zip(unpack(&com[0])) {
        assert_eq!(Bench::com(q, &r).map(f64::to_bits), found.map(f64::to_bits));
        let one = Bench::com_single(Simd::PORTABLE, q, &r);
        assert_eq!(found.map(f64::to_bits), one.map(f64::to_bits));
    }
}

#[test]
fn every_operation_means_the_same_on_every_set() {
    let mut random = Random::new(13);
    for _ in 0..200 {
        let postures: [[f64; 2]; 8] =
            core::array::from_fn(|_| [random.within(6.0), random.within(2.0)]);
        let blocks = [pack(&postures)];
        let r = [0.3 + random.within(0.2), random.within(4.0)];
        for simd in Simd::available() {
            let zero = F64x8::splat(0.0);
            let (mut moments, mut rows) = ([[zero; 2]], [[[zero; 2]; 3]]);
            Bench::gravity_moments_batch(simd, &blocks, &r, &mut moments);
            Bench::regressor_batch(simd, &blocks, &mut rows);
            for (i, q) in postures.iter().enumerate() {
                // No sine and nothing to fuse: the same bits.
                let exact = Bench::gravity_moments(q, &r);
                assert_eq!(exact, moments[0].map(|lanes| lanes.0[i]), "{}", simd.name());
                for (exact, found) in Bench::regressor(q).iter().zip(&rows[0]) {
                    for (exact, found) in exact.iter().zip(found) {
                        assert!((exact - found.0[i]).abs() < 1e-15, "{}", simd.name());
                    }
                }
            }
        }
    }
}

#[test]
fn single_postures_are_those_of_the_batch() {
    let mut random = Random::new(14);
    for _ in 0..500 {
        let q: [f64; 2] = [random.within(6.0), random.within(2.0)];
        let r = Bench::CAD_PARAMS;
        let exact = Bench::com(&q, &r);
        for simd in Simd::available() {
            let mut batch = [[F64x8::splat(0.0); 3]];
            Bench::com_batch(simd, &[q.map(Lanes::splat)], &r, &mut batch);
            let single = Bench::com_single(simd, &q, &r);
            for axis in 0..3 {
                for found in [single[axis], batch[0][axis].0[5]] {
                    let off = (found - exact[axis]).abs();
                    assert!(off < 1e-15, "{}", simd.name());
                }
            }
            // A prismatic joint keeps its position, whatever its sine is.
            let straight = q[1] * r[0] + r[1];
            assert!((single[1] - straight).abs() < 1e-15, "{}", simd.name());
        }
    }
}

/// Whole registers, part of one, and none at all.
#[test]
fn any_number_of_angles() {
    fn check<const N: usize>(simd: Simd) {
        let angles: [f64; N] = core::array::from_fn(|k| 0.7 * k as f64 - 3.0);
        let (mut sin, mut cos) = ([9.0; N], [9.0; N]);
        simd.sin_cos(&angles, &mut sin, &mut cos);
        let singles = angles.map(|x| x as f32);
        let (mut sin_f32, mut cos_f32) = ([9.0; N], [9.0; N]);
        simd.sin_cos(&singles, &mut sin_f32, &mut cos_f32);
        for k in 0..N {
            let (s, c) = trig::sin_cos(angles[k]);
            assert!((sin[k] - s).abs() < 4e-16 && (cos[k] - c).abs() < 4e-16);
            let (s, c) = trig::sin_cos(f64::from(singles[k]));
            assert!((f64::from(sin_f32[k]) - s).abs() < 2e-7);
            assert!((f64::from(cos_f32[k]) - c).abs() < 2e-7);
        }
    }
    for simd in Simd::available() {
        check::<0>(simd);
        check::<1>(simd);
        check::<7>(simd);
        check::<8>(simd);
        check::<15>(simd);
        check::<16>(simd);
        check::<20>(simd);
        check::<33>(simd);
    }
}

#[test]
fn the_shorter_slice_counts() {
    let q = [[F64x8::splat(0.1), F64x8::splat(0.2)]; 3];
    for simd in Simd::available() {
        let mut com = [[F64x8::splat(7.0); 3]; 2];
        Bench::com_batch(simd, &q[..1], &Bench::CAD_PARAMS, &mut com);
        assert!(com[0][0].0[0] != 7.0);
        assert_eq!(com[1], [F64x8::splat(7.0); 3]);
        Bench::com_batch(simd, &q, &Bench::CAD_PARAMS, &mut com);
        assert_eq!(com[0], com[1]);
    }
}

#[test]
fn the_best_is_the_last_and_the_portable_is_always_there() {
    let sets: Vec<Simd> = Simd::available().collect();
    assert_eq!(sets[0], Simd::PORTABLE);
    assert_eq!(sets.last(), Some(&Simd::best()));
}

/// Lanes do not meet: rows of one posture have their bits in registers of any width.
#[cfg(target_arch = "x86_64")]
#[test]
fn rows_of_one_posture_are_the_same_in_short_registers() {
    let (Set::Avx512 | Set::Avx512Short) = Simd::best().0 else {
        return;
    };
    let mut random = Random::new(17);
    for _ in 0..200 {
        let q = [random.within(6.0), random.within(2.0)];
        let r = [random.within(1.0), random.within(9.0)];
        let single = |set: Set| {
            let jacobian = Bench::com_jacobian_single(Simd(set), &q, &r);
            let rows = Bench::regressor_single(Simd(set), &q);
            [jacobian, rows].map(|rows| rows.map(|row| row.map(f64::to_bits)))
        };
        assert_eq!(single(Set::Avx512), single(Set::Avx512Short));
        let (q, r) = (q.map(|x| x as f32), r.map(|x| x as f32));
        let single = |set: Set| {
            let jacobian = Bench::com_jacobian_single(Simd(set), &q, &r);
            jacobian.map(|row| row.map(f32::to_bits))
        };
        assert_eq!(single(Set::Avx512), single(Set::Avx512Short));
    }
}

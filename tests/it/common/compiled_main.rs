//! Evaluates every module on its postures; part of a crate that the tests write.

#![deny(warnings)]

use std::fs;

use compiled::*;
#[allow(unused_imports)]
use sesc_runtime::__private::v1::SinCosRobot;
use sesc_runtime::{Lanes, Real};

fn postures<const DOF: usize>(module: &str) -> Vec<[f64; DOF]> {
    let bytes = fs::read(format!("{module}.q")).unwrap();
    let q: Vec<f64> =
        bytes.chunks(8).map(|b| f64::from_le_bytes(b.try_into().unwrap())).collect();
    q.chunks(DOF).map(|q| q.try_into().unwrap()).collect()
}

fn write(module: &str, what: &str, values: &[f64]) {
    let bytes: Vec<u8> = values.iter().flat_map(|x| x.to_le_bytes()).collect();
    fs::write(format!("{module}.{what}"), bytes).unwrap();
}

/// Postures whose results are written out; of the others only a checksum is.
const WRITTEN: usize = 200;

/// FNV-1a over the bits of values; −0 counts as 0.
fn checksum(values: &[f64]) -> f64 {
    let mut hash = 0xcbf2_9ce4_8422_2325u64;
    for value in values {
        let bits = if *value == 0.0 { 0 } else { value.to_bits() };
        hash = (hash ^ bits).wrapping_mul(0x0000_0100_0000_01b3);
    }
    (hash >> 12) as f64
}

/// Joint velocities, rad/s or m/s, no two alike; as `tests/it/compiled.rs` has them. Beside
/// accelerations, minus a half of these, an eighth.
fn velocities<const DOF: usize>() -> [f64; DOF] {
    core::array::from_fn(|j| f64::from(1.0 / (1.0 + j as f32)))
}

/// Rows combined by a direction.
#[allow(dead_code)]
fn combined<const N: usize>(rows: &[[f64; N]; 3], along: [f64; 3]) -> [f64; N] {
    core::array::from_fn(|k| (0..3).map(|row| rows[row][k] * along[row]).sum())
}

#[allow(unused_macros)]
macro_rules! run {
    ($m:ident, $unit:ident) => {{
        let name = stringify!($m);
        let r = $m::CAD_PARAMS;
        let qd = velocities();
        let com = $m::com(&$m::SELF_TEST_Q, &r);
        for k in 0..3 {
            assert!((com[k] - $m::SELF_TEST_COM[k]).abs() < 1e-12, "{name} self-test");
        }
        let all = postures::<{ $m::DOF }>(name);
        let each = |f: &dyn Fn(&[f64; $m::DOF]) -> Vec<f64>| -> Vec<f64> {
            let mut values: Vec<f64> = all[..WRITTEN].iter().flat_map(|q| f(q)).collect();
            values.extend(all[WRITTEN..].iter().map(|q| checksum(&f(q))));
            values
        };
        write(name, "com", &each(&|q| $m::com(q, &r).to_vec()));
        write(name, "com_jacobian", &each(&|q| $m::com_jacobian(q, &r).concat()));
        write(name, "com_velocity", &each(&|q| $m::com_velocity(q, &qd, &r).to_vec()));
        write(name, "gravity_moments", &each(&|q| $m::gravity_moments(q, &r).to_vec()));
        write(name, "regressor", &each(&|q| $m::regressor(q).concat()));
        write(name, "regressor_cop", &each(&|q| $m::regressor_cop(q).concat()));
        write(name, "regressor_full", &each(&|q| $m::regressor_full(q).concat()));
        write(name, "cop", &each(&|q| $m::cop(q, &r).to_vec()));
        write(name, "cop_jacobian", &each(&|q| $m::cop_jacobian(q, &r).concat()));
        let (r32, qd32) = (r.map(|x| x as f32), qd.map(|x| x as f32));
        let single = |what: &str, f: &dyn Fn(&[f32; $m::DOF]) -> Vec<f32>| {
            let wide = |q: &[f64; $m::DOF]| f(&q.map(|x| x as f32)).into_iter().map(f64::from).collect();
            write(name, what, &each(&wide));
        };
        single("com_f32", &|q| $m::com(q, &r32).to_vec());
        single("com_jacobian_f32", &|q| $m::com_jacobian(q, &r32).concat());
        single("com_velocity_f32", &|q| $m::com_velocity(q, &qd32, &r32).to_vec());
        single("gravity_moments_f32", &|q| $m::gravity_moments(q, &r32).to_vec());
        single("regressor_f32", &|q| $m::regressor(q).concat());
        single("regressor_cop_f32", &|q| $m::regressor_cop(q).concat());
        single("regressor_full_f32", &|q| $m::regressor_full(q).concat());
        single("cop_f32", &|q| $m::cop(q, &r32).to_vec());
        single("cop_jacobian_f32", &|q| $m::cop_jacobian(q, &r32).concat());
        // Lanes: four postures at once, each lane the same bits as alone.
        for four in all[..WRITTEN].chunks_exact(4) {
            let q = core::array::from_fn(|j| Lanes(core::array::from_fn::<f64, 4, _>(|k| four[k][j])));
            let lanes = $m::com(&q, &r.map(Lanes::<f64, 4>::from_f64));
            for (k, q) in four.iter().enumerate() {
                let alone = $m::com(q, &r);
                for axis in 0..3 {
                    assert_eq!(lanes[axis].0[k].to_bits(), alone[axis].to_bits(), "{name} lanes");
                }
            }
        }
    }};
}

/// Does what `run` does, and from sines and cosines: close to the same function of q.
macro_rules! run_sc {
    ($m:ident, $unit:ident) => {{
        run!($m, $unit);
        let name = stringify!($m);
        let (r, qd) = ($m::CAD_PARAMS, velocities());
        let size: f64 = r.iter().map(|x| x.abs()).sum::<f64>() + 1.0;
        for q in postures::<{ $m::DOF }>(name).into_iter().take(WRITTEN) {
            let pairs = q.map(|x| Real::sin_cos(x));
            // A prismatic joint passes its position in `sin`.
            let prismatic = $m::PRISMATIC;
            let sin = core::array::from_fn(|j| if prismatic[j] { q[j] } else { pairs[j].0 });
            let cos = pairs.map(|p| p.1);
            let near = |a: &[f64], b: &[f64]| {
                for (x, y) in a.iter().zip(b) {
                    assert!((x - y).abs() < 1e-13 * size, "{name} from sines: {x} {y}");
                }
            };
            near(&$m::com_sc(&sin, &cos, &r), &$m::com(&q, &r));
            near(&$m::cop_sc(&sin, &cos, &r), &$m::cop(&q, &r));
            near(&$m::com_jacobian_sc(&sin, &cos, &r).concat(), &$m::com_jacobian(&q, &r).concat());
            near(&$m::cop_jacobian_sc(&sin, &cos, &r).concat(), &$m::cop_jacobian(&q, &r).concat());
            near(&$m::com_velocity_sc(&sin, &cos, &qd, &r), &$m::com_velocity(&q, &qd, &r));
            near(&$m::gravity_moments_sc(&sin, &cos, &r), &$m::gravity_moments(&q, &r));
            near(&$m::regressor_sc(&sin, &cos).concat(), &$m::regressor(&q).concat());
            near(&$m::regressor_cop_sc(&sin, &cos).concat(), &$m::regressor_cop(&q).concat());
            near(&$m::regressor_full_sc(&sin, &cos).concat(), &$m::regressor_full(&q).concat());
            for along in [[1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.36, -0.48, 0.8]] {
                let jacobian = combined(&$m::com_jacobian(&q, &r), along);
                near(&<$m::$unit as SinCosRobot>::com_jacobian_along(&sin, &cos, &r, &along), &jacobian);
                let row = combined(&$m::regressor(&q), along);
                near(&<$m::$unit as SinCosRobot>::regressor_along(&sin, &cos, &along), &row);
                let row = combined(&$m::regressor_full(&q), along);
                near(&<$m::$unit as SinCosRobot>::regressor_full_along(&sin, &cos, &along), &row);
            }
        }
    }};
}

/// The ZMP in both precisions, of robots that do not take the compiler minutes.
#[allow(unused_macros)]
macro_rules! run_zmp {
    ($m:ident) => {{
        let name = stringify!($m);
        let all = postures::<{ $m::DOF }>(name);
        let (r, rates) = ($m::CAD_PARAMS, velocities());
        let (slow, qdd) = (rates.map(|x| 0.125 * x), rates.map(|x| -0.5 * x));
        let of = |q: &[f64; $m::DOF]| $m::zmp(q, &slow, &qdd, &r).to_vec();
        let mut values: Vec<f64> = all[..WRITTEN].iter().flat_map(of).collect();
        values.extend(all[WRITTEN..].iter().map(|q| checksum(&of(q))));
        write(name, "zmp", &values);
        let narrow = |x: &[f64; $m::DOF]| x.map(|x| x as f32);
        let (r, slow, qdd) = (r.map(|x| x as f32), narrow(&slow), narrow(&qdd));
        let of = |q: &[f64; $m::DOF]| $m::zmp(&narrow(q), &slow, &qdd, &r).map(f64::from);
        write(name, "zmp_f32", &all[..WRITTEN].iter().flat_map(of).collect::<Vec<f64>>());
    }};
}

/// Readings without the effects of the sensor.
#[allow(unused_macros)]
macro_rules! run_correction {
    ($m:ident) => {{
        let all = postures::<{ $m::DOF }>(stringify!($m));
        let of = |q: &[f64; $m::DOF]| $m::correct_cop(&$m::cop(q, &$m::CAD_PARAMS));
        write(stringify!($m), "correct_cop", &all[..WRITTEN].iter().flat_map(of).collect::<Vec<f64>>());
    }};
}

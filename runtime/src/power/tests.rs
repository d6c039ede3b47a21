//! Against 256 bits, at the edges of the formats, and to the bit.

use core::fmt::Debug;
use std::println;
use std::vec::Vec;

use super::*;
use crate::trig::tests::{Exact, Random, error_ulp_f32};

/// The documented error for every base and exponent.
const LIMIT_ULP: f64 = 0.7;

fn worst(points: impl Iterator<Item = (f64, f64)>) -> (f64, f64, f64) {
    let mut exact = Exact::new();
    let all = points.map(|(x, y)| (exact.power_error_ulp(x, y, power(x, y)), x, y));
    all.fold((0.0, 0.0, 0.0), larger)
}

fn larger<T>(a: (f64, T, T), b: (f64, T, T)) -> (f64, T, T) {
    if b.0 > a.0 { b } else { a }
}

fn worst_f32(points: impl Iterator<Item = (f32, f32)>) -> (f64, f32, f32) {
    let all = points.map(|(x, y)| {
        let truth = power(f64::from(x), f64::from(y));
        (error_ulp_f32(truth, power_f32(x, y)), x, y)
    });
    all.fold((0.0, 0.0, 0.0), larger)
}

#[track_caller]
fn assert_accurate(what: &str, worst: (f64, impl Debug, impl Debug)) {
    let (error, x, y) = worst;
    println!("{what}: {error:.4} ulp at {x:?} ^ {y:?}");
    assert!(error <= LIMIT_ULP);
}

/// A number with an exponent of two evenly in `±power`.
fn spread(random: &mut Random, power: f64) -> f64 {
    random.within(power).exp2()
}

/// How many random points in each test: with SESC_EXHAUSTIVE set while compiling, many.
fn points(few: usize) -> core::ops::Range<usize> {
    match option_env!("SESC_EXHAUSTIVE") {
        Some(_) => 0..100 * few,
        None => 0..few,
    }
}

#[test]
fn accurate_for_forces_and_exponents_near_one() {
    let mut random = Random::new(21);
    let all = points(8_000).map(|_| (random.within(50.0).abs(), 1.0 + random.within(1.0)));
    assert_accurate("x <= 50, 0 <= y <= 2", worst(all));
}

#[test]
fn accurate_near_one_where_the_logarithm_cancels() {
    let mut random = Random::new(22);
    let all = points(4_000).map(|i| {
        let near = spread(&mut random, 1.0) * (-(i as f64 % 52.0)).exp2();
        let x = [1.0 + near, 1.0 - 0.5 * near][i % 2];
        // Results over the whole range.
        (x, random.within(700.0) / x.ln().abs().max(1e-16))
    });
    let all = all.filter(|(x, y)| is_normal(*x, *y));
    assert_accurate("near 1", worst(all));
}

fn is_normal(x: f64, y: f64) -> bool {
    let size = x.ln() * y;
    x > 0.0 && x != 1.0 && size.abs() < 708.0
}

#[test]
fn accurate_over_the_whole_range() {
    let mut random = Random::new(23);
    let all = points(8_000).map(|_| {
        let x = spread(&mut random, 1022.0);
        (x, random.within(708.0) / x.ln())
    });
    let all = all.filter(|(x, y)| is_normal(*x, *y));
    assert_accurate("any x", worst(all));
    let subnormal = points(1_000).map(|_| {
        let x = f64::from_bits((random.bits() >> 12).max(1));
        (x, random.within(0.9))
    });
    assert_accurate("subnormal x", worst(subnormal));
    // Where s is largest, and where the exponential's argument is.
    let edges = points(4_000).map(|i| {
        let x = core::f64::consts::SQRT_2 * (1.0 + random.within(1e-3));
        ([x, 0.5 * x][i % 2], 1.0 + random.within(2.0))
    });
    assert_accurate("near the square root of 2", worst(edges));
}

#[test]
fn accurate_in_single_precision() {
    let mut random = Random::new(24);
    let forces = points(400_000).map(|_| {
        let x = random.within(50.0).abs() as f32;
        (x, 1.0 + random.within(1.0) as f32)
    });
    assert_accurate("x <= 50, 0 <= y <= 2", worst_f32(forces));
    let any = points(400_000).map(|_| {
        let x = spread(&mut random, 126.0) as f32;
        (x, (random.within(87.0) / f64::from(x).ln()) as f32)
    });
    let any = any.filter(|(x, _)| *x != 1.0);
    assert_accurate("any x", worst_f32(any));
    let near = points(400_000).map(|i| {
        let x = f32::from_bits(1.0_f32.to_bits() - 4096 + (i % 8192) as u32);
        (x, (random.within(87.0) / f64::from(x).ln()) as f32)
    });
    let near = near.filter(|(x, _)| *x != 1.0);
    assert_accurate("near 1", worst_f32(near));
    let subnormal = points(20_000).map(|_| {
        let x = f32::from_bits((random.bits() >> 41) as u32 + 1);
        (x, random.within(0.9) as f32)
    });
    assert_accurate("subnormal x", worst_f32(subnormal));
    let every = (1..f32::INFINITY.to_bits())
        .step_by(4001)
        .map(f32::from_bits);
    let every = every.map(|x| (x, 0.9));
    assert_accurate("every x", worst_f32(every));
}

#[test]
fn results_below_the_normal_numbers_are_off_by_at_most_a_unit() {
    let mut random = Random::new(25);
    for _ in 0..2_000 {
        let x = spread(&mut random, 1000.0);
        let y = (-1048.0 + random.within(26.0)) / x.log2();
        // The same from a root that is normal, by an exact scale.
        let truth = power(x, 0.5 * y);
        let unit = power(x, y) / f64::from_bits(1);
        let expected = truth * (537_f64).exp2() * (truth * (537_f64).exp2());
        let off = (unit - expected).abs();
        assert!(off <= 1.0 + 1e-12 * expected, "{x:e} ^ {y}");
    }
}

#[test]
fn what_is_a_number_of_the_format_is_exact() {
    let mut random = Random::new(26);
    for i in 0..20_000 {
        let x = spread(&mut random, 1074.0);
        assert_eq!(power(x, 1.0).to_bits(), x.to_bits());
        assert_eq!(power(x, 0.0), 1.0);
        assert_eq!(power(1.0, x), 1.0);
        let x = spread(&mut random, 140.0) as f32;
        assert_eq!(power_f32(x, 1.0).to_bits(), x.to_bits());
        let whole = f64::from(i);
        assert_eq!(power(whole, 2.0), whole * whole);
        assert_eq!(power(whole * whole, 0.5), whole);
        assert_eq!(power(whole, 3.0), whole * whole * whole);
        let whole = (i % 4096) as f32;
        assert_eq!(power_f32(whole, 2.0), whole * whole);
        assert_eq!(power_f32(whole * whole, 0.5), whole);
    }
}

#[test]
fn edges_are_as_listed() {
    let exponents = [5e-324, 1e-300, 0.5, 1.0, 2.0, 3.0, 1e10, 1e300];
    for y in exponents.into_iter().chain([f64::INFINITY]) {
        for zero in [0.0, -0.0] {
            assert_eq!(power(zero, y).to_bits(), 0);
            assert_eq!(power(zero, -y), f64::INFINITY);
            assert_eq!(power(f64::INFINITY, zero), 1.0);
            assert_eq!(power(zero, zero), 1.0);
            assert_eq!(power_f32(zero as f32, -1.0), f32::INFINITY);
            assert_eq!(power_f32(zero as f32, 0.5).to_bits(), 0);
            assert_eq!(power_f32(zero as f32, 0.0), 1.0);
        }
        assert_eq!(power(f64::INFINITY, y), f64::INFINITY);
        assert_eq!(power(f64::INFINITY, -y), 0.0);
        assert_eq!(power(1.0, y), 1.0);
        assert_eq!(power(1.0, -y), 1.0);
        for x in [-5e-324, -1.0, -2.5, f64::MIN, f64::NEG_INFINITY, f64::NAN] {
            for y in [y, -y, 0.0, f64::NAN] {
                assert!(power(x, y).is_nan() && power_f32(x as f32 - 1e-30, y as f32).is_nan());
            }
        }
        for x in [0.0, 0.5, 1.0, 2.0, f64::INFINITY] {
            assert!(power(x, f64::NAN).is_nan() && power_f32(x as f32, f32::NAN).is_nan());
        }
    }
    for (x, y, truth) in [
        (2.0, f64::INFINITY, f64::INFINITY),
        (0.5, f64::INFINITY, 0.0),
        (2.0, f64::NEG_INFINITY, 0.0),
        (f64::MAX, f64::MAX, f64::INFINITY),
        (f64::MAX, f64::MIN, 0.0),
        (5e-324, f64::MAX, 0.0),
        (f64::from_bits(1.0_f64.to_bits() + 1), 1e300, f64::INFINITY),
        (f64::from_bits(1.0_f64.to_bits() - 1), 1e300, 0.0),
        (2.0, 1023.0, (1023_f64).exp2()),
        (2.0, 1024.0, f64::INFINITY),
        (2.0, -1074.0, 5e-324),
        (2.0, -1076.0, 0.0),
        (5e-324, -1.0, f64::INFINITY),
        (10.0, 308.0, 1e308),
    ] {
        assert_eq!(power(x, y), truth, "{x:e} ^ {y:e}");
    }
    assert_eq!(power_f32(2.0, 127.0), 127_f32.exp2());
    assert_eq!(power_f32(2.0, 128.0), f32::INFINITY);
    assert_eq!(power_f32(2.0, -149.0), f32::from_bits(1));
    let below_one = f32::from_bits(1.0_f32.to_bits() - 1);
    assert_eq!(power_f32(below_one, f32::MAX), 0.0);
}

#[test]
fn powers_grow_with_the_base() {
    for y in [0.3, 0.9, 1.1, 2.5] {
        let all: Vec<f64> = (0..20_000).map(|i| power(f64::from(i) * 1e-3, y)).collect();
        assert!(all.windows(2).all(|pair| pair[0] < pair[1]));
    }
}

#[test]
fn blocks_have_the_bits_of_scalars() {
    let mut random = Random::new(27);
    let mut out = [0.0; 64];
    for _ in 0..200 {
        let x: [f64; 64] = core::array::from_fn(|_| random.within(50.0));
        let y: [f64; 64] = core::array::from_fn(|_| random.within(3.0));
        power_block(&x, &y, &mut out);
        for i in 0..64 {
            let one = power(x[i], y[i]);
            assert!(out[i].to_bits() == one.to_bits() || (one.is_nan() && out[i].is_nan()));
        }
    }
}

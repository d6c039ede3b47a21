//! Rows of any number of postures have the bits of the functions of blocks.

use core::array;

use sesc_generated::{op2_r_sole, two_link_foot};
use sesc_runtime::{Batch, Dim, F32x16, F64x8, Many, Posture, Scalar, Sesc, Simd, UnequalLengths};

/// No posture, less than a block, whole blocks, and what is left over beside them.
const COUNTS: [usize; 11] = [0, 1, 7, 8, 9, 15, 17, 63, 64, 65, 1000];

/// Postures of a robot, of which number 5 is out of the domain of the sine.
fn postures<R: Sesc, S: Scalar>(count: usize) -> Vec<Posture<R, S>> {
    let angle = |k: usize, j: usize| match (k, j) {
        (5, 0) => 1e9,
        _ => (0.37 * k as f64 + 1.3 * j as f64).sin(),
    };
    let posture = |k| <R::Dof as Dim>::from_fn(|j| S::from_f64(angle(k, j)));
    (0..count).map(posture).collect()
}

/// Everything as bits; a NaN is a NaN.
fn bits<S: Scalar>(numbers: &[S]) -> Vec<u64> {
    let bits = |x: f64| if x.is_nan() { u64::MAX } else { x.to_bits() };
    numbers.iter().map(|x| bits(x.to_f64())).collect()
}

/// Every function of a robot in one scalar, with so many postures to a block.
macro_rules! check {
    ($module:ident::$robot:ident, $scalar:ident, $block:ident, $lanes:literal) => {
        use $module::{BASE_PARAMS as BASE, CAD_PARAMS, DOF, FULL_PARAMS as FULL, $robot};
        let r = CAD_PARAMS.map(|r| r as $scalar);
        for simd in Simd::available() {
            for count in COUNTS {
                let q = postures::<$robot, $scalar>(count);
                // Blocks are filled up with zeros here.
                let block = |rows: &[[$scalar; DOF]]| -> [$block; DOF] {
                    array::from_fn(|j| {
                        $block::from(array::from_fn(|k| rows.get(k).map_or(0.0, |q| q[j])))
                    })
                };
                let blocks: Vec<_> = q.chunks($lanes).map(block).collect();
                check!(@ simd, q, blocks, $robot::com_many, com_batch, (&r), $scalar, $block, $lanes, |z| [[z; 3]; 1]);
                check!(@ simd, q, blocks, $robot::cop_many, cop_batch, (&r), $scalar, $block, $lanes, |z| [[z; 2]; 1]);
                check!(@ simd, q, blocks, $robot::gravity_moments_many, gravity_moments_batch, (&r), $scalar, $block, $lanes, |z| [[z; DOF]; 1]);
                check!(@@ simd, q, blocks, $robot::com_jacobian_many, com_jacobian_batch, (&r), $scalar, $block, $lanes, |z| [[z; DOF]; 3]);
                check!(@@ simd, q, blocks, $robot::regressor_many, regressor_batch, (), $scalar, $block, $lanes, |z| [[z; BASE]; 3]);
                check!(@@ simd, q, blocks, $robot::regressor_cop_many, regressor_cop_batch, (), $scalar, $block, $lanes, |z| [[z; BASE]; 2]);
                check!(@@ simd, q, blocks, $robot::regressor_full_many, regressor_full_batch, (), $scalar, $block, $lanes, |z| [[z; FULL]; 3]);
            }
        }
    };
    // Vectors: a matrix of one row.
    (@ $simd:ident, $q:ident, $blocks:ident, $robot:ident::$many:ident, $batch:ident, ($($r:expr)?),
     $scalar:ident, $block:ident, $lanes:literal, |$z:ident| $start:expr) => {
        let start = { let $z: $scalar = -9.0; $start };
        let mut found = vec![start[0]; $q.len()];
        $robot::$many($simd, &$q, $($r,)? &mut found).unwrap();
        let start = { let $z = $block::splat(-9.0); $start };
        let mut expected = vec![start[0]; $blocks.len()];
        $robot::$batch($simd, &$blocks, $($r,)? &mut expected);
        for (k, found) in found.iter().enumerate() {
            let expected = expected[k / $lanes].map(|entry| entry.0[k % $lanes]);
            let what = stringify!($many);
            assert_eq!(bits(found), bits(&expected), "{what} {} {k} of {}", $simd.name(), $q.len());
        }
    };
    (@@ $simd:ident, $q:ident, $blocks:ident, $robot:ident::$many:ident, $batch:ident, ($($r:expr)?),
     $scalar:ident, $block:ident, $lanes:literal, |$z:ident| $start:expr) => {
        let mut found = vec![{ let $z: $scalar = -9.0; $start }; $q.len()];
        $robot::$many($simd, &$q, $($r,)? &mut found).unwrap();
        let mut expected = vec![{ let $z = $block::splat(-9.0); $start }; $blocks.len()];
        $robot::$batch($simd, &$blocks, $($r,)? &mut expected);
        for (k, found) in found.iter().enumerate() {
            let expected = expected[k / $lanes].map(|row| row.map(|entry| entry.0[k % $lanes]));
            let (what, expected) = (stringify!($many), expected.as_flattened());
            let found = bits(found.as_flattened());
            assert_eq!(found, bits(expected), "{what} {} {k} of {}", $simd.name(), $q.len());
        }
    };
}

#[test]
fn rows_in_double_precision_have_the_bits_of_blocks() {
    {
        check!(two_link_foot::TwoLinkFoot, f64, F64x8, 8);
    }
    check!(op2_r_sole::Op2RSole, f64, F64x8, 8);
}

#[test]
fn rows_in_single_precision_have_the_bits_of_blocks() {
    {
        check!(two_link_foot::TwoLinkFoot, f32, F32x16, 16);
    }
    check!(op2_r_sole::Op2RSole, f32, F32x16, 16);
}

#[test]
fn unequal_lengths_are_refused_and_nothing_is_written() {
    use two_link_foot::{CAD_PARAMS, TwoLinkFoot};
    let q = [[0.1, 0.2]; 20];
    for results in [0, 19, 21] {
        let mut com = vec![[-9.0; 3]; results];
        let mut rows = vec![[[-9.0; 7]; 2]; results];
        let error = UnequalLengths {
            postures: 20,
            results,
        };
        let found = TwoLinkFoot::com_many(Simd::best(), &q, &CAD_PARAMS, &mut com);
        assert_eq!(found, Err(error));
        let found = TwoLinkFoot::regressor_cop_many(Simd::best(), &q, &mut rows);
        assert_eq!(found, Err(error));
        assert!(com.iter().all(|com| *com == [-9.0; 3]));
        assert!(rows.iter().all(|rows| *rows == [[-9.0; 7]; 2]));
    }
}

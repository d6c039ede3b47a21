//! Prints a hash over the bits of each function of the OP2, of a fit, and of generated text:
//! `machines URDF SUPPORT FOLDER`. `.ci/all machines` compares what machines print.

use std::error::Error;
use std::path::Path;

use sesc_codegen::emit::c::Scalar;
use sesc_generated::op2_r_sole::{self as op2, BASE_PARAMS, CAD_PARAMS, DOF, Op2RSole};
use sesc_runtime::fit::Estimator;
use sesc_runtime::{Batch as _, F64x8, Lanes, Simd};

/// FNV-1a over 64 bits.
struct Hash(u64);

impl Hash {
    fn new() -> Hash {
        Hash(0xcbf2_9ce4_8422_2325)
    }

    fn bytes(&mut self, bytes: impl IntoIterator<Item = u8>) {
        for byte in bytes {
            self.0 = (self.0 ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3);
        }
    }

    fn doubles(&mut self, numbers: impl IntoIterator<Item = f64>) {
        for x in numbers {
            self.bytes(x.to_bits().to_le_bytes());
        }
    }

    fn singles(&mut self, numbers: impl IntoIterator<Item = f32>) {
        for x in numbers {
            self.bytes(x.to_bits().to_le_bytes());
        }
    }
}

/// Angles that every machine draws alike, up to 30 rad.
fn drawn(postures: usize) -> Vec<[f64; DOF]> {
    let mut draw = 1u32;
    let mut angle = || {
        draw = draw.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (f64::from(draw >> 8) - f64::from(1 << 23)) * 3.576_278_686_523_437_5e-6
    };
    (0..postures)
        .map(|_| core::array::from_fn(|_| angle()))
        .collect()
}

fn functions(postures: &[[f64; DOF]]) {
    let (mut doubles, mut singles, mut lanes) = (Hash::new(), Hash::new(), Hash::new());
    let narrow = CAD_PARAMS.map(|x| x as f32);
    for q in postures {
        doubles.doubles(op2::com(q, &CAD_PARAMS));
        doubles.doubles(op2::com_jacobian(q, &CAD_PARAMS).into_iter().flatten());
        doubles.doubles(op2::com_velocity(q, q, &CAD_PARAMS));
        doubles.doubles(op2::gravity_moments(q, &CAD_PARAMS));
        doubles.doubles(op2::regressor_cop(q).into_iter().flatten());
        doubles.doubles(op2::zmp(q, &[0.1; DOF], &[1.0; DOF], &CAD_PARAMS));
        let q = q.map(|x| x as f32);
        singles.singles(op2::com(&q, &narrow));
        singles.singles(op2::com_jacobian(&q, &narrow).into_iter().flatten());
        singles.singles(op2::regressor_cop(&q).into_iter().flatten());
    }
    for eight in postures.chunks_exact(8) {
        let q = core::array::from_fn(|k| Lanes(core::array::from_fn(|lane| eight[lane][k])));
        let mut com = [[F64x8::splat(0.0); 3]];
        Op2RSole::com_batch(Simd::PORTABLE, &[q], &CAD_PARAMS, &mut com);
        lanes.doubles(com[0].iter().flat_map(|x| x.0));
    }
    println!("f64 {:016x}", doubles.0);
    println!("f32 {:016x}", singles.0);
    println!("eight f64 {:016x}", lanes.0);
}

/// Parameters identified posture by posture, of the CAD's own CoP and 0.1 mm of bias.
fn fit(postures: &[[f64; DOF]]) -> Result<(), Box<dyn Error>> {
    let mut estimator = Estimator::<f64, BASE_PARAMS>::with_nominal(&CAD_PARAMS)?;
    for q in postures {
        let [x, y] = op2::cop(q, &CAD_PARAMS);
        estimator.add_posture::<Op2RSole>(q, &[x + 1e-4, y], &[1e-3; 2])?;
    }
    let mut hash = Hash::new();
    hash.doubles(estimator.params());
    println!("fit {:016x}", hash.0);
    Ok(())
}

/// Rust, and C of every scalar.
fn generated(urdf: &Path, support: &str, folder: &Path) -> Result<(), Box<dyn Error>> {
    for scalar in [Scalar::F64, Scalar::F32, Scalar::Fixed32] {
        let mut hash = Hash::new();
        std::fs::create_dir_all(folder)?;
        let module = sesc_codegen::Builder::new(urdf)
            .support(support)
            .emit_rerun_if_changed(false)
            .out_dir(folder)
            .c99(folder)
            .scalar(scalar)
            .emit()?;
        let mut files = vec![
            module.with_extension("c"),
            module.with_extension("h"),
            module,
        ];
        files.sort();
        for file in files {
            hash.bytes(std::fs::read(file)?);
        }
        println!("text, {scalar:?} {:016x}", hash.0);
    }
    Ok(())
}

fn main() -> Result<(), Box<dyn Error>> {
    let words: Vec<String> = std::env::args().skip(1).collect();
    let [urdf, support, folder] = &words[..] else {
        return Err("machines URDF SUPPORT FOLDER".into());
    };
    let postures = drawn(200);
    functions(&postures);
    fit(&postures)?;
    generated(urdf.as_ref(), support, folder.as_ref())
}

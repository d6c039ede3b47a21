//! The CoM as a symbolic expression, from which `symplex` writes Rust.
//!
//! ```text
//! v_i = r_i + Σ_children A_k v_k        CoM = v_0
//! ```
//!
//! The serial chain, worked out for it: `symplex` reads no robots, and the weighted
//! mean of all links would make it write more.

use std::path::PathBuf;

use symplex::matrix::{Matrix, jacobian};
use symplex::prelude::*;
use symplex_build::CodeGen;

const DOF: usize = 20;

/// Arrays of `robot.h`, which `prepare.py` wrote.
struct Header(String);

impl Header {
    fn numbers(&self, name: &str) -> Vec<f64> {
        let (_, behind) = self
            .0
            .split_once(&format!(" {name}[] = {{"))
            .unwrap_or_else(|| panic!("robot.h has no array {name}"));
        let body = behind.split('}').next().unwrap_or(behind);
        let words = body.split(|c: char| c == ',' || c.is_whitespace());
        words
            .filter(|word| !word.is_empty())
            .map(|word| word.parse().expect("arrays of robot.h hold numbers"))
            .collect()
    }
}

fn com(header: &Header, q: &[Ex], number: &dyn Fn(f64) -> Ex) -> [Ex; 3] {
    let parent = header.numbers("robot_parent");
    let axis = header.numbers("robot_axis");
    let rotation = header.numbers("robot_rotation");
    let mut v: Vec<[Ex; 3]> = header
        .numbers("robot_full_params")
        .chunks(3)
        .map(|r| [number(r[0]), number(r[1]), number(r[2])])
        .collect();
    for joint in (0..DOF).rev() {
        let (parent, axis) = (parent[joint] as usize, axis[joint] as usize);
        let (a, b) = ((axis + 1) % 3, (axis + 2) % 3);
        let (sin, cos) = (q[joint].sin(), q[joint].cos());
        let at = v[joint + 1].clone();
        let mut turned = at.clone();
        turned[a] = &(&cos * &at[a]) - &(&sin * &at[b]);
        turned[b] = &(&sin * &at[a]) + &(&cos * &at[b]);
        for row in 0..3 {
            for (column, turned) in turned.iter().enumerate() {
                let entry = rotation[9 * joint + 3 * row + column];
                if entry != 0.0 {
                    v[parent][row] = &v[parent][row] + &(&number(entry) * turned);
                }
            }
        }
    }
    v[0].clone()
}

fn main() {
    println!("cargo::rerun-if-env-changed=PEERS_ROBOT");
    let robot = std::env::var_os("PEERS_ROBOT")
        .map(PathBuf::from)
        .expect("PEERS_ROBOT names robot.h; benches/peers/run sets it");
    println!("cargo::rerun-if-changed={}", robot.display());
    let text = std::fs::read_to_string(&robot);
    let header = Header(text.unwrap_or_else(|error| panic!("{}: {error}", robot.display())));

    let context = Context::new();
    let names: Vec<String> = (0..DOF).map(|joint| format!("q{joint}")).collect();
    let names: Vec<&str> = names.iter().map(String::as_str).collect();
    let q: Vec<Ex> = names.iter().map(|name| context.symbol(name)).collect();
    let number = |x: f64| context.from_f64(x).expect("a finite number");
    let com = com(&header, &q, &number);
    let slopes = jacobian(
        &com.iter().collect::<Vec<_>>(),
        &q.iter().collect::<Vec<_>>(),
    );
    let slopes = slopes.expect("three functions of twenty angles");
    let com = Matrix::col_vector(com.to_vec()).expect("three rows");
    let code = || {
        CodeGen::new()
            .add_matrix_fn("com", &com, &names)
            .add_matrix_fn("jacobian", &slopes, &names)
    };
    let written = code().write_to_out_dir("symplex_f64.rs");
    written.expect("symplex writes double precision");
    let written = code().precision_f32().write_to_out_dir("symplex_f32.rs");
    written.expect("symplex writes single precision");
}

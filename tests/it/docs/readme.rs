//! README and the book show what the commands print and the generator writes.
//!
//! `SESC_BLESS=1 cargo test --test it readme` accepts new output.

use std::fs;

use sesc_test_support::command::{Folder, ROOT};

use super::{blocks, read};

#[test]
fn the_output_shown_is_the_output_printed() {
    let page = format!("{ROOT}/docs/demo.md");
    let [readme, demo] = ["README.md", "docs/demo.md"].map(read);
    assert_eq!(blocks(&readme, "sh")[0], "cargo demo\n");
    let printed = Folder::empty().stdout("demo");
    let shown = &blocks(&demo, "text")[0];
    // README has the end of it.
    let end = &blocks(&readme, "text")[0];
    let begin = end.lines().next().unwrap();
    if std::env::var_os("SESC_BLESS").is_some() {
        let accepted = demo.replace(shown.as_str(), &printed);
        fs::write(page, accepted).unwrap();
        let from = printed.find(begin).expect("a line of the demo");
        let accepted = readme.replace(end.as_str(), &printed[from..]);
        fs::write(format!("{ROOT}/README.md"), accepted).unwrap();
        return;
    }
    assert!(
        shown.ends_with(end.as_str()),
        "README's excerpt is not its end"
    );
    assert!(end.lines().count() > 10);
    assert_eq!(printed.lines().count(), shown.lines().count());
    for (printed, shown) in printed.lines().zip(shown.lines()) {
        let words = |line: &'_ str| line.split_whitespace().map(str::to_string).collect();
        let (a, b): (Vec<String>, Vec<String>) = (words(printed), words(shown));
        assert_eq!(a.len(), b.len(), "{printed}\n{shown}");
        for (a, b) in a.iter().zip(&b) {
            // Rounding errors differ a little from machine to machine; nothing else does.
            let same = match (a.parse::<f64>(), b.parse::<f64>()) {
                (Ok(x), Ok(y)) if x.abs() < 1e-6 => (x / y).log2().abs() < 1.0,
                _ => a == b,
            };
            assert!(same, "{printed}\n{shown}");
        }
    }
}

#[test]
fn the_lines_shown_are_generated() {
    let shown = blocks(&read("docs/controller.md"), "rust");
    assert!(read("generated/src/op2_r_sole.rs").contains(&shown[0]));
    // What stands a robot on a corrected model is what the example runs.
    let example = read("examples/controller/src/main.rs");
    let stand = shown.iter().find(|block| block.contains("fn stand("));
    assert!(example.contains(stand.unwrap().as_str()));
}

/// README's example in Rust, and that it is the one that compiles here.
mod example {
    use sesc_generated::op2_r_sole as op2;

    #[rustfmt::skip]
    #[test]
    fn the_rust_shown_compiles_and_runs() {
use op2::{CAD_PARAMS, DOF, Op2RSole, joint};
use sesc_runtime::{Simd, Single};

/// CoM (m, sole frame) and what the motor of the right knee feeds forward (N m).
fn tick(q: &[f64; DOF], r: &[f64; op2::BASE_PARAMS]) -> ([f64; 3], f64) {
    let com = Op2RSole::com_single(Simd::best(), q, r); // AVX2 or AVX-512 where they are
    let moments = op2::gravity_moments(q, r); // the same bits on every machine
    let weight = 9.80665 * op2::TOTAL_MASS_KG;
    // The moment that gravity exerts; a motor that holds the posture applies the opposite.
    (com, -weight * moments[joint::R_KNEE])
}
let (com, knee) = tick(&[0.0; DOF], &CAD_PARAMS);

        let shown = &super::blocks(&super::read("README.md"), "rust")[0];
        assert!(include_str!("readme.rs").contains(&format!("\n{shown}")));
        // A straight leg: the CoM lies above the sole and near the line of the knee.
        assert!(com[2] > 0.2 && com[2] < 0.3, "{com:?}");
        assert!(knee.abs() < 1.0, "{knee}");
        // Lifting the robot by its bent knee is work that the motor does.
        let robot = sesc_reference::Robot::from_urdf(&super::read("robots/op2/op2.urdf")).unwrap();
        let reference = sesc_reference::Reference::new(&robot, "r_sole").unwrap();
        let bent = |angle: f64| std::array::from_fn(|j| if j == joint::R_KNEE { angle } else { 0.0 });
        let energy = |angle: f64| 9.80665 * reference.total_mass() * reference.com(&bent(angle)).z;
        let work = (energy(-1.0 + 1e-4) - energy(-1.0 - 1e-4)) / 2e-4;
        let (_, applied) = tick(&bent(-1.0), &CAD_PARAMS);
        assert!(work.abs() > 0.1 && (applied - work).abs() < 1e-6, "{applied} {work}");
    }
}

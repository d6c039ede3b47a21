//! README and the book show what the commands print and the generator writes.
//!
//! `SESC_BLESS=1 cargo test --test it readme` accepts new output.

use std::fs;
use std::process::Command;

const ROOT: &str = env!("CARGO_MANIFEST_DIR");

/// Fenced blocks of the given kind.
fn blocks(text: &str, kind: &str) -> Vec<String> {
    let mut blocks = Vec::new();
    let mut lines = text.lines();
    while let Some(line) = lines.next() {
        if line == format!("```{kind}") {
            let inside = lines.by_ref().take_while(|line| *line != "```");
            blocks.push(inside.collect::<Vec<_>>().join("\n"));
        }
    }
    blocks
}

#[test]
fn the_output_shown_is_the_output_printed() {
    let page = format!("{ROOT}/docs/demo.md");
    let [readme, demo] =
        [&format!("{ROOT}/README.md"), &page].map(|p| fs::read_to_string(p).unwrap());
    assert_eq!(blocks(&readme, "sh")[0], "cargo demo");
    let folder = tempfile::tempdir().unwrap();
    let output = Command::new(env!("CARGO_BIN_EXE_sesc"))
        .arg("demo")
        .current_dir(folder.path())
        .output()
        .unwrap();
    let printed = String::from_utf8(output.stdout).unwrap();
    let shown = &blocks(&demo, "text")[0];
    // README has the end of it.
    let end = &blocks(&readme, "text")[0];
    let begin = end.lines().next().unwrap();
    if std::env::var_os("SESC_BLESS").is_some() {
        let accepted = demo.replace(shown.as_str(), printed.trim_end());
        fs::write(page, accepted).unwrap();
        let from = printed
            .find(begin)
            .expect("README's excerpt begins with a line of the demo");
        let accepted = readme.replace(end.as_str(), printed[from..].trim_end());
        fs::write(format!("{ROOT}/README.md"), accepted).unwrap();
        return;
    }
    assert!(
        shown.ends_with(end.as_str()),
        "README's excerpt is not the end of {page}"
    );
    assert!(end.lines().count() > 10);
    assert_eq!(printed.lines().count(), shown.lines().count());
    for (printed, shown) in printed.lines().zip(shown.lines()) {
        let (a, b): (Vec<&str>, Vec<&str>) = (
            printed.split_whitespace().collect(),
            shown.split_whitespace().collect(),
        );
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
    let page = fs::read_to_string(format!("{ROOT}/docs/controller.md")).unwrap();
    let module = fs::read_to_string(format!("{ROOT}/generated/src/op2_r_sole.rs")).unwrap();
    assert!(module.contains(&blocks(&page, "rust")[0]));
    // What stands a robot on a corrected model is what the example runs.
    let example = fs::read_to_string(format!("{ROOT}/examples/controller/src/main.rs")).unwrap();
    let shown = blocks(&page, "rust");
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

        let readme = std::fs::read_to_string(format!("{}/README.md", super::ROOT)).unwrap();
        let shown = &super::blocks(&readme, "rust")[0];
        assert!(include_str!("readme.rs").contains(&format!("\n{shown}\n")));
        // A straight leg: the CoM lies above the sole and near the line of the knee.
        assert!(com[2] > 0.2 && com[2] < 0.3, "{com:?}");
        assert!(knee.abs() < 1.0, "{knee}");
        // Lifting the robot by its bent knee is work that the motor does.
        let text = std::fs::read_to_string(format!("{}/robots/op2/op2.urdf", super::ROOT)).unwrap();
        let robot = sesc_reference::Robot::from_urdf(&text).unwrap();
        let reference = sesc_reference::Reference::new(&robot, "r_sole").unwrap();
        let bent = |angle: f64| std::array::from_fn(|j| if j == joint::R_KNEE { angle } else { 0.0 });
        let energy = |angle: f64| 9.80665 * reference.total_mass() * reference.com(&bent(angle)).z;
        let work = (energy(-1.0 + 1e-4) - energy(-1.0 - 1e-4)) / 2e-4;
        let (_, applied) = tick(&bent(-1.0), &CAD_PARAMS);
        assert!(work.abs() > 0.1 && (applied - work).abs() < 1e-6, "{applied} {work}");
    }
}

//! Golden cases: a URDF beside the chain, the Rust and the C it must become.
//!
//! `SESC_BLESS=1 cargo test -p sesc-codegen --test golden` accepts new output;
//! nothing rewrites itself otherwise.

use std::fmt::Write as _;
use std::path::Path;

use sesc_codegen::emit::c::{self, Options, Scalar};
use sesc_codegen::emit::rust;
use sesc_codegen::facts::Facts;
use sesc_model::chain::Body;
use sesc_model::{Function, Model, Snapping, urdf};

/// Folder under `golden/`, support link, functions of the Rust module: of the lift those that show
/// what two links do not, a prismatic joint, a turned axis and a follower.
const CASES: [(&str, &str, &[Function]); 2] = [
    ("two_link", "foot", &Function::ALL),
    ("lift", "base", &[Function::ComJacobian]),
];

/// Names of the full parameters: `shank.x`, or `lift.s` for a share of mass.
fn full_names(model: &Model) -> Vec<String> {
    let of = |body: &Body| {
        let r = ["x", "y", "z"].map(|axis| format!("{}.{axis}", body.name));
        r.into_iter()
            .chain(body.s.map(|_| format!("{}.s", body.name)))
    };
    model.chain.bodies.iter().flat_map(of).collect()
}

fn chain_text(model: &Model) -> String {
    let full = full_names(model);
    let mut text = String::new();
    let orientations = model.chain.orientation_products();
    for (body, orientation) in model.chain.bodies.iter().zip(orientations) {
        let _ = writeln!(text, "B[{}] = {orientation}", body.name);
        let _ = writeln!(text, "r[{}] = {:?}", body.name, body.r());
        if let Some(s) = body.s {
            let _ = writeln!(text, "s[{}] = {s:?}", body.name);
        }
    }
    let _ = writeln!(text);
    for param in &model.base.params {
        let terms: Vec<String> = param
            .terms
            .iter()
            .map(|(k, w)| format!("{w:+} {}", full[*k]))
            .collect();
        let _ = writeln!(text, "{} = {}", param.name, terms.join(" "));
    }
    let _ = writeln!(text, "\nrank from CoP rows: {}", model.base.rank_cop);
    for direction in &model.base.unobservable {
        let _ = writeln!(text, "unobservable: {}", direction.sentence);
    }
    text
}

#[test]
fn output_is_what_it_was() {
    let golden = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/golden");
    let bless = std::env::var_os("SESC_BLESS").is_some();
    let mut changed = Vec::new();
    for (case, support, functions) in CASES {
        let folder = golden.join(case);
        let description = urdf::read(&folder.join("robot.urdf")).unwrap();
        let model = Model::new(&description, support, Snapping::default()).unwrap();
        let package = |scalar| c::package(&Facts::of(&model), case, &Options::of(scalar)).unwrap();
        let [float, fixed] = [Scalar::F32, Scalar::Fixed32].map(package);
        let files = [
            ("chain.txt", chain_text(&model)),
            (
                "expected.rs",
                rust::module(&Facts::with(&model, functions), case).unwrap(),
            ),
            ("expected_f32.h", float.header),
            ("expected_f32.c", float.source),
            ("expected_fixed32.h", fixed.header),
            ("expected_fixed32.c", fixed.source),
        ];
        for (name, text) in files {
            let path = folder.join(name);
            if std::fs::read_to_string(&path).unwrap_or_default() == text {
                continue;
            }
            if bless {
                std::fs::write(&path, &text).unwrap();
            } else {
                let old = std::fs::read_to_string(&path).unwrap_or_default();
                let line = old.lines().zip(text.lines()).position(|(a, b)| a != b);
                let line = line.unwrap_or(old.lines().count().min(text.lines().count()));
                changed.push(format!(
                    "{case}/{name} line {}:\n  was {:?}\n  now {:?}",
                    line + 1,
                    old.lines().nth(line),
                    text.lines().nth(line)
                ));
            }
        }
    }
    assert!(
        changed.is_empty(),
        "{}\naccept with SESC_BLESS=1 cargo test -p sesc-codegen --test golden",
        changed.join("\n")
    );
}

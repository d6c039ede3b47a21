//! How far the CoM of a diagnosed model is from the true one.
//!
//! ```text
//! error = √(mean over postures of ‖CoM_model(q) − CoM_robot(q)‖²)
//! ratio = error of the diagnosed model / error of CAD's
//! ```
//!
//! The robot is the virtual one, which bends its own body; `q` is what its encoders read
//! in balanced postures that the log does not have. CAD's error is also how far the
//! effect moves the CoM. The model goes through the text of its file.

use std::error::Error;
use std::fs;
use std::path::Path;
use std::process::Command;
use std::sync::Arc;

use rand::SeedableRng as _;
use rand_chacha::ChaCha8Rng;
use sesc_codegen::emit::c::{self, Options, Scalar};
use sesc_codegen::facts::Facts;
use sesc_identify::diagnose::{self, Request, Verdict};
use sesc_identify::evaluate::Evaluator;
use sesc_identify::robot::Robot;
use sesc_model::{Function, Model, ModelFile, Snapping};
use sesc_test_support::hidden::hide_all;
use sesc_test_support::judge::{Answer, Labels, truth};
use sesc_test_support::trial::Trial;

/// Postures that judge.
pub const JUDGED: usize = 200;
/// Name of the C package.
const NAME: &str = "corrected";

/// What became of one log.
#[derive(Debug, Clone)]
pub struct Corrected {
    /// Seed of the log.
    pub seed: u64,
    /// The robot.
    pub robot: &'static str,
    /// Names of the hidden effects.
    pub effects: Vec<&'static str>,
    /// What is hidden, with sizes.
    pub hidden: String,
    /// What the diagnosis comes to, and its explanation.
    pub said: String,
    /// Whether a named explanation, or the first of a class, is what was hidden.
    pub named: bool,
    /// Whether what was hidden is reported, or of the class reported.
    pub listed: bool,
    /// CoM error of CAD's model, m.
    pub before_m: f64,
    /// CoM error of the diagnosed model, m.
    pub after_m: f64,
    /// CoM error that the model file's own uncertainty of its masses leads to expect, m.
    pub expected_m: f64,
    /// The same error by `corrected_model_com` of the C package, m.
    pub after_in_c_m: Option<f64>,
}

impl Corrected {
    /// Error of the diagnosed model over CAD's.
    pub fn ratio(&self) -> f64 {
        self.after_m / self.before_m
    }
}

/// Diagnoses the log of `trial`, written to `folder`, and judges the CoM of the model
/// that comes of it; also of its C, by gcc, where that is asked.
///
/// # Errors
/// Where the log cannot be diagnosed, or its model not be read, generated or compiled.
pub fn examine(trial: &Trial, folder: &Path, in_c: bool) -> Result<Corrected, Box<dyn Error>> {
    let stage = &trial.stage;
    let log = trial.log.write(folder, &format!("trial_{}", trial.seed));
    let robot = Arc::new(Robot::read(&stage.urdf)?);
    let report = diagnose::diagnose(&Request::new(Arc::clone(&robot), log.as_path()), &mut ())?;
    let text = toml::to_string(&report.model_file)?;
    let file = ModelFile::parse(&text, "model.toml")?;
    let model = |file| robot.model(stage.support, Snapping::default(), file);
    let (cad, corrected) = (model(None)?, model(Some(&file))?);

    let mut random = ChaCha8Rng::seed_from_u64(!trial.seed);
    let q = stage.balanced(JUDGED, &mut random);
    let world = hide_all(stage.world(), &trial.hidden)?;
    let true_com: Vec<[f64; 3]> = q.iter().map(|q| world.com(q).into()).collect();
    let q = q.concat();
    let error = |com: &[f64]| distance(com, &true_com);
    let by_tape = |model: &Model| Evaluator::new(model, Function::Com).run(&q, JUDGED);
    let by_c = in_c.then(|| com_in_c(&corrected, &q, folder)).transpose()?;

    let answer = Answer::read(&serde_json::to_value(&report.diagnosis)?)?;
    let hidden = truth(&trial.hidden);
    let explained = matches!(report.diagnosis.verdict, Verdict::Named | Verdict::Class);
    let sizes = trial.hidden.iter().map(|hidden| {
        let values: Vec<String> = hidden.values.iter().map(|v| format!("{v:.2e}")).collect();
        format!("{}({})", hidden.label(), values.join(" "))
    });
    Ok(Corrected {
        seed: trial.seed,
        robot: robot_name(&stage.urdf),
        effects: trial.hidden.iter().map(|h| h.effect.name()).collect(),
        hidden: sizes.collect::<Vec<_>>().join(" + "),
        said: format!("{}: {}", answer.verdict, joined(&answer.steps)),
        named: explained && answer.is(&hidden),
        listed: explained && answer.lists(&hidden),
        before_m: error(&by_tape(&cad)),
        after_m: error(&by_tape(&corrected)),
        expected_m: expected(&corrected, &file, &q),
        after_in_c_m: by_c.map(|com| error(&com)),
    })
}

fn robot_name(urdf: &Path) -> &'static str {
    match urdf.file_stem().is_some_and(|stem| stem == "op2") {
        true => "op2",
        false => "skew_humanoid",
    }
}

fn joined(labels: &Labels) -> String {
    let labels: Vec<&str> = labels.iter().map(String::as_str).collect();
    labels.join(" + ")
}

/// RMS distance, m.
fn distance(com: &[f64], truth: &[[f64; 3]]) -> f64 {
    let gaps = com.as_chunks::<3>().0.iter().zip(truth);
    let squares = gaps.map(|(a, b)| (0..3).map(|k| (a[k] - b[k]).powi(2)).sum::<f64>());
    (squares.sum::<f64>() / truth.len() as f64).sqrt()
}

/// RMS over the postures of √tr(Y C Yᵀ), m: Y the regressor of the CoM, C the covariance of
/// the base parameters in the model file. What only CAD says (the constant part of the
/// height) counts as known.
fn expected(model: &Model, file: &ModelFile, q: &[f64]) -> f64 {
    let Some(information) = &file.information else {
        return 0.0;
    };
    let rows = Evaluator::new(model, Function::Regressor).run(q, JUDGED);
    let variance = |row: &[f64]| {
        // x R = row: its squares are the variance.
        let mut left = row.to_vec();
        let mut variance = 0.0;
        for (i, line) in information.factor.iter().enumerate() {
            if line[0] > 0.0 {
                let pivot = left[i] / line[0];
                variance += pivot * pivot;
                for (x, r) in left[i..].iter_mut().zip(line) {
                    *x -= pivot * r;
                }
            }
        }
        variance
    };
    let sum: f64 = rows
        .chunks_exact(information.factor.len())
        .map(variance)
        .sum();
    (sum / JUDGED as f64).sqrt()
}

/// CoM of all postures by the model's package in C, f64, compiled by gcc in `folder`, m.
fn com_in_c(model: &Model, q: &[f64], folder: &Path) -> Result<Vec<f64>, Box<dyn Error>> {
    let package = c::package(&Facts::of(model), NAME, &Options::of(Scalar::F64))?;
    let folder = tempfile::tempdir_in(folder)?;
    let path = |name: &str| folder.path().join(name);
    fs::write(path("corrected.h"), &package.header)?;
    fs::write(path("corrected.c"), &package.source)?;
    let main = "#include \"corrected.h\"\n#include <stdio.h>\n\nint main(void)\n{\n    \
                double q[corrected_DOF], com[3];\n    \
                while (fread(q, sizeof q, 1u, stdin) == 1u) {\n        \
                corrected_model_com(q, com);\n        \
                if (fwrite(com, sizeof com, 1u, stdout) != 1u) {\n            return 1;\n        \
                }\n    }\n    return 0;\n}\n";
    fs::write(path("main.c"), main)?;
    let postures: Vec<u8> = q.iter().flat_map(|q| q.to_le_bytes()).collect();
    fs::write(path("postures"), postures)?;
    let program = path("program");
    let status = Command::new("gcc")
        .args(["-std=c99", "-Wall", "-Wextra", "-Werror", "-O1", "-o"])
        .args([&program, &path("corrected.c"), &path("main.c")])
        .status()?;
    if !status.success() {
        return Err("gcc does not compile the package".into());
    }
    let output = Command::new(&program)
        .stdin(fs::File::open(path("postures"))?)
        .output()?;
    let values = output.stdout.as_chunks::<8>().0.iter();
    let com: Vec<f64> = values.map(|bytes| f64::from_le_bytes(*bytes)).collect();
    match com.len() * model.dof() == 3 * q.len() {
        true => Ok(com),
        false => Err("the C program does not answer for every posture".into()),
    }
}

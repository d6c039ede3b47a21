//! The CoM of the diagnosed model against the true one, where an effect of the body is hidden.
//!
//! ```text
//! error = √(mean over postures of ‖CoM_model(q) − CoM_robot(q)‖²)
//! ratio = error of the diagnosed model / error of CAD's
//! ```
//!
//! The robot is the virtual one, which bends its own body; `q` is what its encoders read
//! in balanced postures that the log does not have. CAD's error is also how far the
//! effect moves the CoM. The model goes through the text of its file. Every third log hides
//! two effects; single ones take turns.

use std::path::Path;
use std::sync::Arc;

use rand::SeedableRng as _;
use rand_chacha::ChaCha8Rng;
use sesc_identify::diagnose::{self, Request, Verdict};
use sesc_identify::evaluate::Evaluator;
use sesc_identify::robot::Robot;
use sesc_model::{Function, Model, ModelFile, Snapping};
use sesc_test_support::hidden::{Effect, hide_all};
use sesc_test_support::judge::{Answer as Explained, truth};
use sesc_test_support::stage::Platform;
use sesc_test_support::trial::{Choice, Question, Trial};

use super::{Answer, Asked, Case, Cell, Failure, Plan};

/// What a corrected model may keep of CAD's CoM error.
pub const GOAL: f64 = 0.25;
/// An effect that moves the CoM by less is not counted, m.
pub const MOVED_M: f64 = 1e-3;
/// The robots, turn by turn.
const PLATFORMS: [Platform; 2] = [Platform::Op2, Platform::Skew];

/// Postures that judge.
pub const JUDGED: usize = 200;

/// What became of one log.
#[derive(Debug, Clone)]
pub struct Corrected {
    /// The log: its seed, its robot and what is hidden, with sizes.
    pub log: String,
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
}

impl Corrected {
    /// Error of the diagnosed model over CAD's.
    pub fn ratio(&self) -> f64 {
        self.after_m / self.before_m
    }
}

/// Diagnoses the log of `trial`, written to `folder`, and judges the CoM of the model
/// that comes of it.
///
/// # Errors
/// Where the log cannot be diagnosed, or its model not be read.
pub fn examine(trial: &Trial, folder: &Path) -> Result<Corrected, Failure> {
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

    let answer = Explained::read(&serde_json::to_value(&report.diagnosis)?)?;
    let hidden = truth(&trial.hidden);
    let explained = matches!(report.diagnosis.verdict, Verdict::Named | Verdict::Class);
    let sizes = trial.hidden.iter().map(|hidden| {
        let values: Vec<String> = hidden.values.iter().map(|v| format!("{v:.2e}")).collect();
        format!("{}({})", hidden.label(), values.join(" "))
    });
    let sizes: Vec<String> = sizes.collect();
    let steps: Vec<&str> = answer.steps.iter().map(String::as_str).collect();
    Ok(Corrected {
        log: format!(
            "seed {} {:?} {}",
            trial.seed,
            stage.platform,
            sizes.join(" + ")
        ),
        said: format!("{}: {}", answer.verdict, steps.join(" + ")),
        named: explained && answer.is(&hidden),
        listed: explained && answer.lists(&hidden),
        before_m: error(&by_tape(&cad)),
        after_m: error(&by_tape(&corrected)),
    })
}

/// RMS distance, m.
fn distance(com: &[f64], truth: &[[f64; 3]]) -> f64 {
    let gaps = com.as_chunks::<3>().0.iter().zip(truth);
    let squares = gaps.map(|(a, b)| (0..3).map(|k| (a[k] - b[k]).powi(2)).sum::<f64>());
    (squares.sum::<f64>() / truth.len() as f64).sqrt()
}

/// The log number `i`.
fn draw(i: usize, seed: u64) -> Trial {
    let choice = |platform: usize, only| Choice {
        platforms: vec![PLATFORMS[platform % PLATFORMS.len()]],
        only,
        body: true,
        long: false,
        held: 0.0,
    };
    let (question, choice) = match i % 3 {
        2 => (Question::Library(2), choice(i / 3, None)),
        rest => {
            let single = 2 * (i / 3) + rest;
            let effect = Effect::BODY[single % Effect::BODY.len()];
            let choice = choice(single / Effect::BODY.len(), Some(effect));
            (Question::Library(1), choice)
        }
    };
    Trial::draw(question, &choice, seed + i as u64)
}

/// The rows that a log is counted in: its effect or the pair, its robot, and all.
fn rows(trial: &Trial) -> Vec<(usize, String)> {
    let single = match &trial.hidden[..] {
        [one] => Effect::BODY.iter().position(|effect| *effect == one.effect),
        _ => None,
    };
    let mut rows: Vec<(usize, String)> = single
        .map(|k| (k, Effect::BODY[k].name().to_owned()))
        .into_iter()
        .collect();
    let pairs = if trial.hidden.len() == 1 {
        (100, "one effect")
    } else {
        (101, "two effects")
    };
    let robot = match trial.stage.platform {
        Platform::Op2 => (102, "OP2"),
        _ => (103, "humanoid"),
    };
    let more = [pairs, robot, (104, "all")].map(|(k, name)| (k, name.to_owned()));
    rows.extend(more);
    rows
}

/// What is counted of a log: only where the effect moves the CoM by more than [`MOVED_M`].
fn counted(found: &Corrected) -> Answer {
    let moved = found.before_m > MOVED_M;
    let share = |of: bool, holds: bool| Cell::Share(usize::from(of && holds), usize::from(of));
    let listed = moved && found.listed;
    let number = |value: f64| if listed { value } else { f64::NAN };
    let small = found.ratio() < GOAL;
    let note = format!(
        "{}: {:.3} -> {:.3} mm, ratio {:.3}; {}",
        found.log,
        1e3 * found.before_m,
        1e3 * found.after_m,
        found.ratio(),
        found.said
    );
    Answer {
        cells: vec![
            share(moved, found.named),
            share(moved && found.named, small),
            share(moved, found.listed),
            share(listed, small),
            Cell::Median(number(found.ratio())),
            Cell::Median(number(1e3 * found.before_m)),
            Cell::Median(number(1e3 * found.after_m)),
        ],
        note: (moved && !(found.listed && small)).then_some(note),
    }
}

pub(super) fn plan<'a>(asked: &'a Asked<'_>) -> Plan<'a> {
    let cases = (0..asked.logs as usize).map(|k| {
        let trial = draw(k, asked.seed);
        Case {
            rows: rows(&trial),
            ask: Box::new(move || Ok(counted(&examine(&trial, asked.folder)?))),
        }
    });
    Plan {
        about: "Effects of the body are hidden in virtual robots, from barely visible to as large as they \
                come; the log is diagnosed, and the CoM of the model file is held against the robot's \
                true CoM on 200 balanced postures that the log does not have. Logs count where the \
                effect moves the CoM by more than 1 mm RMS. Named: the verdict is `named` or `class` \
                and the first explanation is what was hidden, on the right target; listed: what was \
                hidden is that or of the class. Ratios are the CoM error of the diagnosed model over \
                CAD's, of listed logs; errors are medians of these.",
        columns: &[
            "named",
            "of these < 0.25",
            "listed",
            "of these < 0.25",
            "ratio, median",
            "CoM error of CAD, mm",
            "diagnosed, mm",
        ],
        cases: cases.collect(),
    }
}

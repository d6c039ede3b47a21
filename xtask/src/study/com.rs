//! The CoM of the diagnosed model against the true one (`tests/support/src/examine/com.rs`).
//! Every third log hides two effects; single ones take turns.

use sesc_test_support::examine::com::{Corrected, GOAL, MOVED_M, examine};
use sesc_test_support::hidden::Effect;
use sesc_test_support::stage::Platform;
use sesc_test_support::trial::{Choice, Question, Trial};

use super::{Answer, Asked, Case, Cell, Plan};

/// The robots, turn by turn.
const PLATFORMS: [Platform; 2] = [Platform::Op2, Platform::Skew];

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
    let single = single.map(|k| (k, Effect::BODY[k].name()));
    let count = match trial.hidden.len() {
        1 => (100, "one effect"),
        _ => (101, "two effects"),
    };
    let robot = match trial.stage.platform {
        Platform::Op2 => (102, "OP2"),
        _ => (103, "humanoid"),
    };
    let rows = single.into_iter().chain([count, robot, (104, "all")]);
    rows.map(|(k, name)| (k, name.to_owned())).collect()
}

/// What is counted of a log: only where the effect moves the CoM by more than [`MOVED_M`].
fn counted(found: &Corrected) -> Answer {
    let moved = found.before_m > MOVED_M;
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
            ("named", Cell::of(moved, found.named)),
            ("named, < 0.25", Cell::of(moved && found.named, small)),
            ("listed", Cell::of(moved, found.listed)),
            ("listed, < 0.25", Cell::of(listed, small)),
            ("ratio, median", Cell::Median(number(found.ratio()))),
            (
                "CoM error of CAD, mm",
                Cell::Median(number(1e3 * found.before_m)),
            ),
            ("diagnosed, mm", Cell::Median(number(1e3 * found.after_m))),
        ],
        note: (moved && !(found.listed && small)).then_some(note),
    }
}

pub(super) fn plan<'a>(asked: &'a Asked<'_>) -> Plan<'a> {
    let cases = (0..asked.logs as usize).map(|k| {
        let trial = draw(k, asked.seed);
        Case::new(rows(&trial), move || {
            Ok(counted(&examine(&trial, asked.folder)?))
        })
    });
    Plan {
        about: "Effects of the body are hidden in virtual robots, from barely visible to as large as they \
                come; the log is diagnosed, and the CoM of the model file is held against the robot's \
                true CoM on 200 balanced postures that the log does not have. Logs count where the \
                effect moves the CoM by more than 1 mm RMS. Named: the verdict is `named` or `class` \
                and the first explanation is what was hidden, on the right target; listed: what was \
                hidden is that or of the class. Ratios are the CoM error of the diagnosed model over \
                CAD's, of listed logs; errors are medians of these.",
        cases: cases.collect(),
    }
}

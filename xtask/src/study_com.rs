//! The study of corrected models: effects of the body are hidden in virtual robots, and
//! the CoM of the diagnosed model is judged by the robot's own, in `docs/dev/study/com.txt`.
//!
//! Every third log hides two effects; single ones take turns. The logs are drawn from
//! seeds: the same command counts the same logs again.

use std::error::Error;
use std::fmt::Write as _;
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Mutex, PoisonError};

use clap::Args;
use sesc_test_support::hidden::Effect;
use sesc_test_support::stage::Platform;
use sesc_test_support::trial::{Choice, Question, Trial};

use crate::corrected::{Corrected, JUDGED, examine};

/// What a corrected model may keep of CAD's CoM error.
pub const GOAL: f64 = 0.25;
/// An effect that moves the CoM by less is not counted, m.
pub const MOVED_M: f64 = 1e-3;
/// The robots, turn by turn.
const PLATFORMS: [Platform; 2] = [Platform::Op2, Platform::Skew];

/// How many logs.
#[derive(Args)]
pub struct StudyCom {
    /// Number of logs, a third of them with two effects
    #[arg(long, default_value_t = 150)]
    logs: usize,
    /// The first log's seed; each further one's is one more
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Judge the generated C, too, of every log of this many
    #[arg(long, default_value_t = 10)]
    every: usize,
    /// Only those of the logs that hide this effect: `backlash`
    #[arg(long, value_name = "EFFECT")]
    only: Option<String>,
    /// Where the table goes, instead of docs/dev/study/com.txt
    #[arg(long, value_name = "FILE")]
    out: Option<PathBuf>,
    /// Logs diagnosed at once
    #[arg(long, default_value_t = 1)]
    jobs: usize,
}

/// The log number `i`.
fn draw(i: usize, seed: u64) -> Trial {
    let of = |platform: usize, only| Choice {
        platforms: vec![PLATFORMS[platform % PLATFORMS.len()]],
        only,
        body: true,
        long: false,
        held: 0.0,
    };
    let (question, choice) = match i % 3 {
        2 => (Question::Library(2), of(i / 3, None)),
        rest => {
            let single = 2 * (i / 3) + rest;
            let effect = Effect::BODY[single % Effect::BODY.len()];
            let choice = of(single / Effect::BODY.len(), Some(effect));
            (Question::Library(1), choice)
        }
    };
    Trial::draw(question, &choice, seed + i as u64)
}

impl StudyCom {
    /// Draws, diagnoses and judges every log; writes the table.
    ///
    /// # Errors
    /// A folder or file that cannot be written. A log without an answer is named on
    /// stderr and counted as missing.
    pub fn run(&self, root: &Path) -> Result<(), Box<dyn Error>> {
        let folder = tempfile::tempdir()?;
        let next = AtomicUsize::new(0);
        let found: Mutex<Vec<Corrected>> = Mutex::default();
        let work = || {
            while let Some(i) =
                Some(next.fetch_add(1, Ordering::Relaxed)).filter(|i| *i < self.logs)
            {
                let in_c = i % self.every.max(1) == 0;
                let trial = draw(i, self.seed);
                let mut names = trial.hidden.iter().map(|hidden| hidden.effect.name());
                if self
                    .only
                    .as_ref()
                    .is_some_and(|only| !names.any(|name| name == only))
                {
                    continue;
                }
                match examine(&trial, folder.path(), in_c) {
                    Ok(one) => {
                        eprintln!("{i:4} {}", line(&one));
                        found
                            .lock()
                            .unwrap_or_else(PoisonError::into_inner)
                            .push(one);
                    }
                    Err(error) => eprintln!("{i:4} no answer: {error}"),
                }
            }
        };
        std::thread::scope(|scope| {
            for _ in 1..self.jobs {
                scope.spawn(work);
            }
            work();
        });
        let mut found = found.into_inner().unwrap_or_else(PoisonError::into_inner);
        found.sort_by_key(|one| one.seed);
        let default = || root.join("docs/dev/study/com.txt");
        let out = self.out.clone().unwrap_or_else(default);
        fs::write(&out, self.page(&found))?;
        eprintln!("wrote {}", out.display());
        Ok(())
    }

    /// The table as Markdown, with the command that makes it.
    fn page(&self, found: &[Corrected]) -> String {
        let in_c: Vec<f64> = found
            .iter()
            .filter_map(|one| Some((one.after_in_c_m? - one.after_m).abs()))
            .collect();
        let apart = in_c.iter().fold(0.0_f64, |a, b| a.max(*b));
        let missed = |one: &&Corrected| counts(one) && one.listed && one.ratio() >= GOAL;
        let wrong = |one: &&Corrected| counts(one) && !one.listed;
        format!(
            "# The study of corrected models\n\n\
             Effects of the body are hidden in virtual robots (`tests/support`), from barely visible \
             to as large as they come; the log is diagnosed, and the CoM of the model \
             file is held against the robot's true CoM on {JUDGED} balanced postures that the log \
             does not have. The OP2 and a humanoid of 30 joints (`robots/skew_humanoid`); {} of {} \
             logs were answered:\n\n\
             ```text\ncargo xtask study-com --logs {} --seed {}\n```\n\n\
             Logs count where the effect moves the CoM by more than {:.0} mm RMS. *Named*: the verdict \
             is `named` or `class` and the first explanation is what was hidden, on the right \
             target; *listed*: what was hidden is that or of the class. Ratios are the CoM error of \
             the diagnosed model over CAD's, of listed logs; errors are medians of these. *Expected* is \
             the CoM error that the model file's own uncertainty of its masses leads to expect: where \
             it is of the size of the error found, the log does not say more of the masses.\n\n{}\n\
             The same postures through `model_com` of the generated C (f64, gcc), {} of these logs: \
             the RMS error differs by at most {apart:.0e} m.\n\n\
             ## Listed, and not below {GOAL}\n\n```text\n{}```\n\n\
             ## Not listed\n\n```text\n{}```\n",
            found.len(),
            self.logs,
            self.logs,
            self.seed,
            1e3 * MOVED_M,
            table(found),
            in_c.len(),
            lines(found.iter().filter(missed)),
            lines(found.iter().filter(wrong)),
        )
    }
}

fn counts(one: &Corrected) -> bool {
    one.before_m > MOVED_M
}

fn lines<'a>(found: impl Iterator<Item = &'a Corrected>) -> String {
    let mut text = String::new();
    for one in found {
        let _ = writeln!(text, "seed {} {}", one.seed, line(one));
    }
    match text.is_empty() {
        true => "none\n".into(),
        false => text,
    }
}

fn line(one: &Corrected) -> String {
    format!(
        "{} {}: {:.3} -> {:.3} mm (expected {:.3}), ratio {:.3}; {}",
        one.robot,
        one.hidden,
        1e3 * one.before_m,
        1e3 * one.after_m,
        1e3 * one.expected_m,
        one.ratio(),
        one.said
    )
}

/// One row for every effect hidden alone, one for pairs, one for every robot, one for all.
fn table(found: &[Corrected]) -> String {
    let mut text = String::from(
        "| hidden | logs | moved > 1 mm | named | of these < 0.25 | listed | of these < 0.25 | ratio, \
         median | worst | CoM error of CAD, mm | diagnosed, mm |\n\
         |---|---|---|---|---|---|---|---|---|---|---|\n",
    );
    let mut row = |name: &str, of: &dyn Fn(&Corrected) -> bool| {
        let all: Vec<&Corrected> = found.iter().filter(|one| of(one)).collect();
        let moved: Vec<&Corrected> = all.iter().copied().filter(|one| counts(one)).collect();
        let listed: Vec<&Corrected> = moved.iter().copied().filter(|one| one.listed).collect();
        let named = moved.iter().filter(|one| one.named);
        let median = |of: &dyn Fn(&Corrected) -> f64| {
            let mut values: Vec<f64> = listed.iter().map(|one| of(one)).collect();
            values.sort_by(f64::total_cmp);
            values.get(values.len() / 2).copied()
        };
        let shown = |value: Option<f64>| value.map_or("-".into(), |value| format!("{value:.3}"));
        let worst = listed.iter().map(|one| one.ratio()).max_by(f64::total_cmp);
        let _ = writeln!(
            text,
            "| {name} | {} | {} | {} | {} | {} | {} | {} | {} | {} | {} |",
            all.len(),
            moved.len(),
            named.clone().count(),
            named.filter(|one| one.ratio() < GOAL).count(),
            listed.len(),
            listed.iter().filter(|one| one.ratio() < GOAL).count(),
            shown(median(&Corrected::ratio)),
            shown(worst),
            shown(median(&|one| 1e3 * one.before_m)),
            shown(median(&|one| 1e3 * one.after_m)),
        );
    };
    for effect in Effect::BODY {
        row(&format!("`{}`", effect.name()), &|one| {
            one.effects == [effect.name()]
        });
    }
    row("one effect", &|one| one.effects.len() == 1);
    row("two effects", &|one| one.effects.len() == 2);
    row("OP2", &|one| one.robot == "op2");
    row("humanoid", &|one| one.robot != "op2");
    row("all", &|_| true);
    text
}

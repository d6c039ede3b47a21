//! The study of hidden effects: some hundred logs of virtual robots, each diagnosed
//! and judged, counted in `docs/dev/study/effects.txt`.
//!
//! Its logs are drawn from seeds, so that the same command counts the same logs again:
//! after a change of `criteria`, the difference of two tables is the change's.

use std::error::Error;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Mutex, PoisonError};

use clap::Args;
use sesc_test_support::diagnoser::Diagnoser;
use sesc_test_support::hidden::Effect;
use sesc_test_support::stage::Platform;
use sesc_test_support::survey::{self, Outcome};
use sesc_test_support::table;
use sesc_test_support::trial::{Choice, Question, Trial};

/// What to ask how often.
#[derive(Args)]
pub struct Study {
    /// Number of logs
    #[arg(long, default_value_t = 100)]
    trials: usize,
    /// The first log's seed; each further one's is one more
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Hide this effect alone
    #[arg(long, value_name = "EFFECT")]
    only: Option<String>,
    /// Hide nothing at all
    #[arg(long, conflicts_with = "only")]
    nothing: bool,
    /// The OP2 alone, at most 200 postures
    #[arg(long)]
    small: bool,
    /// Where the tables go, instead of docs/dev/study/effects.txt
    #[arg(long, value_name = "FILE")]
    out: Option<PathBuf>,
    /// Keep the logs here
    #[arg(long, value_name = "DIR")]
    keep: Option<PathBuf>,
    /// The sesc to ask, instead of the one that is built from here
    #[arg(long, value_name = "PATH")]
    sesc: Option<PathBuf>,
    /// Logs diagnosed at once
    #[arg(long, default_value_t = 1)]
    jobs: usize,
}

impl Study {
    fn choice(&self) -> Result<Choice, Box<dyn Error>> {
        let mut choice = survey::everything();
        if self.small {
            choice.platforms = vec![Platform::Op2];
            choice.long = false;
        }
        if let Some(name) = &self.only {
            choice.only = Some(Effect::named(name).ok_or_else(|| format!("no effect `{name}`"))?);
        }
        Ok(choice)
    }

    /// The command that counts the same logs again.
    fn command(&self) -> String {
        let mut text = format!(
            "cargo xtask study --trials {} --seed {}",
            self.trials, self.seed
        );
        if let Some(only) = &self.only {
            text += &format!(" --only {only}");
        }
        for (given, flag) in [(self.nothing, " --nothing"), (self.small, " --small")] {
            text += if given { flag } else { "" };
        }
        text
    }

    /// Draws, diagnoses and judges every log; writes the tables.
    ///
    /// # Errors
    /// No such effect, a `sesc` that cannot be built or found, a file that cannot be
    /// written. A log without an answer is named on stderr and left out.
    pub fn run(&self, root: &Path) -> Result<(), Box<dyn Error>> {
        let choice = self.choice()?;
        let sesc = match &self.sesc {
            Some(sesc) => sesc.clone(),
            None => build(root)?,
        };
        if !sesc.is_file() {
            return Err(format!("no sesc at {}", sesc.display()).into());
        }
        let scratch = tempfile::tempdir()?;
        let folder = self
            .keep
            .clone()
            .unwrap_or_else(|| scratch.path().to_owned());
        fs::create_dir_all(&folder)?;
        let questions = if self.nothing {
            vec![Question::Nothing; self.trials]
        } else {
            survey::questions(self.trials, &choice)
        };
        let outcomes = self.ask(&Diagnoser { sesc }, &questions, &choice, &folder);
        let default = || root.join("docs/dev/study/effects.txt");
        let out = self.out.clone().unwrap_or_else(default);
        fs::write(&out, self.page(&outcomes, questions.len()))?;
        eprintln!("wrote {}", out.display());
        Ok(())
    }

    /// Asks all questions, in order of their seeds.
    fn ask(
        &self,
        diagnoser: &Diagnoser,
        questions: &[Question],
        choice: &Choice,
        folder: &Path,
    ) -> Vec<Outcome> {
        let next = AtomicUsize::new(0);
        let outcomes: Mutex<Vec<Outcome>> = Mutex::default();
        let work = || {
            while let Some((i, &question)) = {
                let i = next.fetch_add(1, Ordering::Relaxed);
                questions.get(i).map(|question| (i, question))
            } {
                let trial = Trial::draw(question, choice, self.seed + i as u64);
                match survey::ask(diagnoser, &trial, folder) {
                    Ok(outcome) => {
                        eprintln!("{:4} {}", i + 1, told(&outcome));
                        let mut outcomes = outcomes.lock().unwrap_or_else(PoisonError::into_inner);
                        outcomes.push(outcome);
                    }
                    Err(error) => eprintln!("{:4} no answer: {error}", i + 1),
                }
            }
        };
        std::thread::scope(|scope| {
            for _ in 1..self.jobs {
                scope.spawn(work);
            }
            work();
        });
        let mut outcomes = outcomes
            .into_inner()
            .unwrap_or_else(PoisonError::into_inner);
        outcomes.sort_by_key(|outcome| outcome.seed);
        outcomes
    }

    /// The tables as Markdown, with the command that makes them.
    fn page(&self, outcomes: &[Outcome], asked: usize) -> String {
        format!(
            "# The study of hidden effects\n\n\
             Effects are hidden in virtual robots (`tests/support`, which bends the robot itself \
             and shares no code with the diagnosis); `sesc diagnose` reads the logs and is judged \
             by the truth. {} of {asked} logs were answered:\n\n\
             ```text\n{}\n```\n\n\
             ## Goals\n\n```text\n{}```\n\n\
             ## Effects hidden alone\n\n\
             Shares of the logs in percent: named exactly, with the right target, the truth among \
             the listed explanations, right as a class, postures put aside below 1.1 noise floors, \
             reported as unexplained; then the number of listed explanations.\n\n\
             ```text\n{}```\n\n\
             ## Answers that are not right as a class\n\n```text\n{}```\n",
            outcomes.len(),
            self.command(),
            table::goal_table(&table::goals(outcomes)),
            table::effect_table(outcomes),
            table::mistakes(outcomes)
        )
    }
}

fn told(outcome: &Outcome) -> String {
    format!(
        "{:5.1} s  chi2 {:8.0}  {}  ->  {}{}",
        outcome.seconds,
        outcome.chi2,
        outcome.description,
        outcome.judgement.said,
        if outcome.judgement.unexplained {
            " ?"
        } else {
            ""
        },
    )
}

/// The command line in release, built from here.
fn build(root: &Path) -> Result<PathBuf, Box<dyn Error>> {
    let cargo = std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into());
    let status = Command::new(cargo)
        .args(["build", "--release", "--package", "sesc", "--bin", "sesc"])
        .current_dir(root)
        .status()?;
    if !status.success() {
        return Err("sesc does not build".into());
    }
    let target = std::env::var_os("CARGO_TARGET_DIR").map_or(root.join("target"), PathBuf::from);
    Ok(target.join("release/sesc"))
}

//! Hides effects in a virtual robot by the hundred and counts what the
//! diagnoser makes of their logs.
//!
//! ```text
//! cargo run --release --example hidden_effects -- table.txt --trials 300 --seed 1
//! ```
//!
//! The table of goals, effect by effect, and every mistake with the seed that
//! draws it again go to the file; progress goes to stderr. `--only EFFECT`
//! hides nothing else, `--nothing` hides nothing at all, `--keep FOLDER` keeps
//! the logs, `--sesc PATH` names the binary (default: the one beside this
//! example).

#[path = "../tests/hidden_effect/mod.rs"]
mod hidden_effect;

use std::path::PathBuf;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Mutex, PoisonError};

use clap::Parser;
use hidden_effect::diagnoser::Diagnoser;
use hidden_effect::hidden::Effect;
use hidden_effect::survey::{self, Outcome};
use hidden_effect::table;
use hidden_effect::trial::{Question, Trial};

/// Hide effects in a virtual robot and count what the diagnoser makes of them
#[derive(Parser)]
struct Arguments {
    /// Where the tables go
    out: PathBuf,
    /// Number of logs
    #[arg(long, default_value_t = 100)]
    trials: usize,
    /// The first log's seed; each further one's is one more
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Hide this effect alone
    #[arg(long)]
    only: Option<String>,
    /// Hide nothing at all
    #[arg(long, conflicts_with = "only")]
    nothing: bool,
    /// The OP2 alone, at most 200 postures
    #[arg(long)]
    small: bool,
    /// Keep the logs here
    #[arg(long)]
    keep: Option<PathBuf>,
    /// The sesc to ask
    #[arg(long)]
    sesc: Option<PathBuf>,
    /// Logs diagnosed at once
    #[arg(long, default_value_t = 1)]
    jobs: usize,
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let arguments = Arguments::parse();
    let mut choice = survey::everything();
    if arguments.small {
        choice.platforms = vec![hidden_effect::stage::Platform::Op2];
        choice.long = false;
    }
    if let Some(name) = &arguments.only {
        choice.only = Some(Effect::named(name).ok_or_else(|| format!("no effect `{name}`"))?);
    }
    let sesc = match arguments.sesc {
        Some(sesc) => sesc,
        // target/release/examples/hidden_effects
        None => {
            let here = std::env::current_exe()?;
            let release = here.parent().and_then(|folder| folder.parent());
            release.ok_or("no folder above this one")?.join("sesc")
        }
    };
    if !sesc.is_file() {
        let build = "cargo build --release builds it, --sesc PATH names another";
        return Err(format!("no sesc at {}; {build}", sesc.display()).into());
    }
    let diagnoser = Diagnoser { sesc };
    let scratch = tempfile::tempdir()?;
    let folder = arguments.keep.unwrap_or_else(|| scratch.path().to_owned());
    std::fs::create_dir_all(&folder)?;

    let questions = if arguments.nothing {
        vec![Question::Nothing; arguments.trials]
    } else {
        survey::questions(arguments.trials, &choice)
    };
    let next = AtomicUsize::new(0);
    let outcomes: Mutex<Vec<Outcome>> = Mutex::default();
    let work = || {
        while let Some((i, &question)) = {
            let i = next.fetch_add(1, Ordering::Relaxed);
            questions.get(i).map(|question| (i, question))
        } {
            let trial = Trial::draw(question, &choice, arguments.seed + i as u64);
            match survey::ask(&diagnoser, &trial, &folder) {
                Ok(outcome) => {
                    eprintln!(
                        "{:4} {:5.1} s  chi2 {:8.0}  {}  ->  {}{}",
                        i + 1,
                        outcome.seconds,
                        outcome.chi2,
                        outcome.description,
                        outcome.judgement.said,
                        if outcome.judgement.unexplained {
                            " ?"
                        } else {
                            ""
                        },
                    );
                    let mut outcomes = outcomes.lock().unwrap_or_else(PoisonError::into_inner);
                    outcomes.push(outcome);
                }
                Err(error) => eprintln!("{:4} no answer: {error}", i + 1),
            }
        }
    };
    std::thread::scope(|scope| {
        for _ in 1..arguments.jobs {
            scope.spawn(work);
        }
        work();
    });

    let mut outcomes = outcomes
        .into_inner()
        .unwrap_or_else(PoisonError::into_inner);
    outcomes.sort_by_key(|outcome| outcome.seed);
    let goals = table::goals(&outcomes);
    let text = format!(
        "{} of {} logs answered, seeds from {}\n\n{}\n{}\n{}",
        outcomes.len(),
        questions.len(),
        arguments.seed,
        table::goal_table(&goals),
        table::effect_table(&outcomes),
        table::mistakes(&outcomes)
    );
    std::fs::write(&arguments.out, text)?;
    Ok(())
}

//! `cargo xtask study SCENARIO`: virtual robots of the reference are asked about, and the
//! answers are counted.
//!
//! ```text
//! scenario ─▶ cases (seeded) ─▶ ask ─▶ cells ─▶ rows of a table
//! ```
//!
//! Every case is drawn from its seed: the same command counts the same logs again, and after
//! a change of criteria the difference of two tables is the change's. `docs/dev/study/` holds
//! the last tables.

mod alarms;
pub mod com;
mod effects;
mod fleet;
mod health;
mod motion;
pub mod recordings;

use std::collections::BTreeMap;
use std::error::Error;
use std::fmt::Write as _;
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Mutex, PoisonError};

use clap::{Args, ValueEnum};
use sesc_identify::diagnose::{self, Diagnosis};
use sesc_identify::fit::{self, Identification};
use sesc_identify::logs::Table;
use sesc_identify::robot::Robot;
use sesc_test_support::recording::Recording;
use sesc_test_support::stage::Stage;

pub(crate) type Failure = Box<dyn Error>;

/// ± this many deviations hold 95 %.
const OF_95: f64 = 1.959_964;

/// What is hidden, and what is counted.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Scenario {
    /// Effects alone, in pairs and triples, and outside the list
    Effects,
    /// The CoM of the diagnosed model against the true one
    Com,
    /// Intervals and verdicts of recordings whose noise lasts
    Recordings,
    /// The same recording at four sampling rates
    Motion,
    /// Recordings of sound robots
    FalseAlarms,
    /// The same at 500 and 1000 Hz
    FastAlarms,
    /// Broken devices, and healthy logs
    Health,
    /// Fleets with faults, and sound fleets
    Fleet,
}

/// What to ask how often.
#[derive(Args)]
pub struct Study {
    #[arg(value_enum)]
    scenario: Scenario,
    /// Number of logs, or of logs of each kind; the table's own unless given
    #[arg(long)]
    logs: Option<u64>,
    /// The first log's seed; each further one's is one more
    #[arg(long)]
    seed: Option<u64>,
    /// Only cases in whose name this stands
    #[arg(long, value_name = "WORD")]
    only: Option<String>,
    /// Cases asked at once
    #[arg(long, default_value_t = 2)]
    jobs: usize,
    /// Where the table goes, instead of docs/dev/study/SCENARIO.txt
    #[arg(long, value_name = "FILE")]
    out: Option<PathBuf>,
}

/// Seeds of a study, and where its files may go.
struct Asked<'a> {
    logs: u64,
    seed: u64,
    only: Option<&'a str>,
    folder: &'a Path,
}

impl Asked<'_> {
    fn seeds(&self) -> std::ops::Range<u64> {
        self.seed..self.seed + self.logs
    }
}

/// One question. It is counted in every row of the table that it names; rows are ordered by
/// their numbers, then by name.
struct Case<'a> {
    rows: Vec<(usize, String)>,
    ask: Box<dyn Fn() -> Result<Answer, Failure> + Sync + 'a>,
}

/// What is counted of a case, column by column, and what is worth a line of its own.
#[derive(Default)]
struct Answer {
    cells: Vec<Cell>,
    note: Option<String>,
}

/// What a column counts.
#[derive(Debug, Clone, Copy)]
enum Cell {
    /// So many of so many.
    Share(usize, usize),
    /// So many of so many, as a percentage.
    Percent(usize, usize),
    /// A number, of which the median is shown; NaN is left out.
    Median(f64),
    /// A number, of which the largest is shown; NaN is left out.
    Worst(f64),
}

impl Cell {
    fn is(holds: bool) -> Cell {
        Cell::Share(usize::from(holds), 1)
    }
}

/// What the table of a scenario says, its columns and its cases.
struct Plan<'a> {
    about: &'static str,
    columns: &'static [&'static str],
    cases: Vec<Case<'a>>,
}

impl Scenario {
    /// Logs and first seed of the committed tables.
    fn size(self) -> (u64, u64) {
        match self {
            Scenario::Effects => (400, 800_000),
            Scenario::Com => (150, 1),
            Scenario::Recordings => (8, 1),
            Scenario::Motion => (1, 1),
            Scenario::FalseAlarms => (1000, 1),
            Scenario::FastAlarms => (60, 1),
            Scenario::Health => (20, 1),
            Scenario::Fleet => (20, 1),
        }
    }
}

impl Study {
    /// Draws, asks and counts; writes the table.
    ///
    /// # Errors
    /// A log that cannot be drawn or asked about; a file that cannot be written.
    pub fn run(&self, root: &Path) -> Result<(), Failure> {
        let scenario = self.scenario.to_possible_value();
        let name = scenario.ok_or("no such scenario")?.get_name().to_owned();
        let folder = tempfile::tempdir()?;
        let (logs, seed) = self.scenario.size();
        let asked = Asked {
            logs: self.logs.unwrap_or(logs),
            seed: self.seed.unwrap_or(seed),
            only: self.only.as_deref(),
            folder: folder.path(),
        };
        let mut text = format!(
            "cargo xtask study {name} --logs {} --seed {}",
            asked.logs, asked.seed
        );
        if let Some(only) = asked.only {
            let _ = write!(text, " --only \"{only}\"");
        }
        text += "\n\n";
        let plan = match self.scenario {
            Scenario::Effects => None,
            Scenario::Com => Some(com::plan(&asked)),
            Scenario::Recordings => Some(recordings::plan(&asked)),
            Scenario::Motion => Some(motion::plan(&asked)),
            Scenario::FalseAlarms => Some(alarms::plan(&asked, false)),
            Scenario::FastAlarms => Some(alarms::plan(&asked, true)),
            Scenario::Health => Some(health::plan(&asked)),
            Scenario::Fleet => Some(fleet::plan(&asked)),
        };
        text += &match plan {
            Some(plan) => table(&plan, asked.only, self.jobs)?,
            None => effects::table(&asked, root, self.jobs)?,
        };
        let own = root.join(format!("docs/dev/study/{name}.txt"));
        let out = self.out.as_ref().unwrap_or(&own);
        fs::write(out, text)?;
        eprintln!("wrote {}", out.display());
        Ok(())
    }
}

/// Asks all cases that are wanted; a row for each name.
fn table(plan: &Plan, only: Option<&str>, jobs: usize) -> Result<String, Failure> {
    let wanted = |case: &&Case| {
        only.is_none_or(|word| case.rows.iter().any(|(_, name)| name.contains(word)))
    };
    let cases: Vec<&Case> = plan.cases.iter().filter(wanted).collect();
    let answers = side_by_side(cases.len(), jobs, |k| {
        let answer = (cases[k].ask)().map_err(|error| error.to_string())?;
        if let Some(note) = &answer.note {
            eprintln!("{note}");
        }
        eprintln!("{} of {}", k + 1, cases.len());
        Ok::<Answer, String>(answer)
    });
    let answers: Vec<Answer> = answers.into_iter().collect::<Result<_, _>>()?;
    let mut rows: BTreeMap<&(usize, String), Vec<&Answer>> = BTreeMap::new();
    for (case, answer) in cases.iter().zip(&answers) {
        for row in &case.rows {
            rows.entry(row).or_default().push(answer);
        }
    }
    let mut text = format!("{}\n\n| | logs |", plan.about);
    for column in plan.columns {
        let _ = write!(text, " {column} |");
    }
    text += &format!("\n|---|---|{}\n", "---|".repeat(plan.columns.len()));
    for ((_, name), answers) in rows {
        let _ = write!(text, "| {name} | {} |", answers.len());
        for column in 0..plan.columns.len() {
            let cells = answers.iter().filter_map(|a| a.cells.get(column).copied());
            let _ = write!(text, " {} |", shown(&cells.collect::<Vec<Cell>>()));
        }
        text += "\n";
    }
    let notes: Vec<&str> = answers.iter().filter_map(|a| a.note.as_deref()).collect();
    if !notes.is_empty() {
        let _ = write!(text, "\nWorth a look:\n\n{}\n", notes.join("\n"));
    }
    Ok(text)
}

/// The cells of a column in one row: sums of shares, the median or the largest of numbers.
fn shown(cells: &[Cell]) -> String {
    let (mut share, mut numbers) = ((0, 0), Vec::new());
    for cell in cells {
        match *cell {
            Cell::Share(hit, of) | Cell::Percent(hit, of) => {
                share = (share.0 + hit, share.1 + of);
            }
            Cell::Median(number) | Cell::Worst(number) => numbers.push(number),
        }
    }
    numbers.retain(|number| !number.is_nan());
    numbers.sort_by(f64::total_cmp);
    let at = match cells.first() {
        None => return "–".to_owned(),
        Some(Cell::Share(..)) if share.1 == 0 => return "–".to_owned(),
        Some(Cell::Share(..)) => return format!("{} of {}", share.0, share.1),
        Some(Cell::Percent(..)) => {
            let part = 100.0 * share.0 as f64 / share.1.max(1) as f64;
            return format!("{part:.1} % of {}", share.1);
        }
        Some(Cell::Median(_)) => numbers.len() / 2,
        Some(Cell::Worst(_)) => numbers.len().saturating_sub(1),
    };
    let number = numbers.get(at);
    number.map_or("–".to_owned(), |number| format!("{number:.3}"))
}

/// The results of `0..count`, in this order, from so many threads.
fn side_by_side<T: Send>(count: usize, jobs: usize, ask: impl Fn(usize) -> T + Sync) -> Vec<T> {
    let (next, all) = (AtomicUsize::new(0), Mutex::new(BTreeMap::new()));
    let work = || {
        while let Some(k) = Some(next.fetch_add(1, Ordering::Relaxed)).filter(|k| *k < count) {
            let result = ask(k);
            let mut all = all.lock().unwrap_or_else(PoisonError::into_inner);
            all.insert(k, result);
        }
    };
    std::thread::scope(|scope| {
        for _ in 1..jobs {
            scope.spawn(work);
        }
        work();
    });
    let all = all.into_inner().unwrap_or_else(PoisonError::into_inner);
    all.into_values().collect()
}

/// A recording as a log in memory.
fn log(recording: &Recording, timed: bool) -> Table {
    let columns = recording.columns(timed).into_iter();
    columns.fold(Table::new("recording"), |table, (name, values)| {
        table.numbers(&name, values)
    })
}

/// What `diagnose --prior tight` says.
fn diagnosed(stage: &Stage, log: Table, noise: Option<f64>) -> Result<Diagnosis, Failure> {
    let robot = Robot::read(&stage.urdf)?;
    let mut request = diagnose::Request::new(robot.into(), log);
    request.support = Some(stage.support.into());
    request.noise = noise;
    request.prior = "tight".into();
    Ok(diagnose::diagnose(&request, &mut ())?.diagnosis)
}

/// What `fit --prior free` says.
fn fitted(stage: &Stage, log: Table, noise: Option<f64>) -> Result<Identification, Failure> {
    let mut request = fit::Request::default();
    request.robot = Some(Robot::read(&stage.urdf)?.into());
    request.logs = vec![log.into()];
    request.support = Some(stage.support.into());
    request.noise = noise;
    request.prior = "free".into();
    Ok(fit::fit(&request, &mut ())?.identification)
}

/// Parameters whose 95 % interval holds the truth, of those that have one.
fn intervals(found: &Identification, truth: &[f64]) -> (usize, usize) {
    let known = found.parameters.iter().zip(truth);
    let holds: Vec<bool> = known
        .filter_map(|(p, truth)| Some((p.value - truth).abs() <= OF_95 * p.std?))
        .collect();
    (holds.iter().filter(|holds| **holds).count(), holds.len())
}

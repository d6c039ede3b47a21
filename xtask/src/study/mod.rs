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
mod ankles;
mod bought;
mod com;
mod effects;
mod fleet;
mod health;
mod labs;
mod motion;
mod recordings;
mod unlisted;

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::fs;
use std::path::{Path, PathBuf};

use clap::Args;
use rayon::prelude::*;
use sesc_test_support::examine::Failure;

/// A scenario: its name, logs and first seed of its committed table, and its cases. Effects have
/// a table of their own.
type Scenario = (
    &'static str,
    u64,
    u64,
    Option<for<'a> fn(&'a Asked) -> Plan<'a>>,
);
const SCENARIOS: [Scenario; 12] = [
    ("effects", 400, 800_000, None),
    ("bought", 400, 1, Some(bought::plan)),
    ("com", 150, 1, Some(com::plan)),
    ("unlisted", 20, 1, Some(unlisted::plan)),
    ("ankles", 60, 1, Some(ankles::plan)),
    ("labs", 20, 1, Some(labs::plan)),
    ("recordings", 8, 1, Some(recordings::plan)),
    ("motion", 1, 1, Some(motion::plan)),
    ("false-alarms", 1000, 1, Some(alarms::plan)),
    ("fast-alarms", 60, 1, Some(alarms::fast_plan)),
    ("health", 20, 1, Some(health::plan)),
    ("fleet", 6, 1, Some(fleet::plan)),
];

/// What to ask how often.
#[derive(Args)]
pub struct Study {
    /// effects, bought, com, unlisted, ankles, labs, recordings, motion, false-alarms, fast-alarms, health or fleet
    #[arg(value_parser = SCENARIOS.map(|scenario| scenario.0))]
    scenario: String,
    /// Number of logs, or of logs of each kind; that of the committed table unless given
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

impl<'a> Case<'a> {
    fn new(
        rows: Vec<(usize, String)>,
        ask: impl Fn() -> Result<Answer, Failure> + Sync + 'a,
    ) -> Case<'a> {
        let ask = Box::new(ask);
        Case { rows, ask }
    }
}

/// What is counted of a case, each under its column, and what is worth a line of its own.
#[derive(Default)]
struct Answer {
    cells: Vec<(&'static str, Cell)>,
    note: Option<String>,
}

/// What a column counts.
#[derive(Debug, Clone, Copy)]
enum Cell {
    /// So many of so many.
    Share(usize, usize),
    /// A number, of which the median is shown; NaN is left out.
    Median(f64),
}

impl Cell {
    fn is(holds: bool) -> Cell {
        Cell::Share(usize::from(holds), 1)
    }

    /// Whether it holds, where that counts.
    fn of(counts: bool, holds: bool) -> Cell {
        Cell::Share(usize::from(counts && holds), usize::from(counts))
    }
}

/// What the table of a scenario says, and its cases.
struct Plan<'a> {
    about: &'static str,
    cases: Vec<Case<'a>>,
}

impl Study {
    /// Draws, asks and counts; writes the table.
    ///
    /// # Errors
    /// A log that cannot be drawn or asked about; a file that cannot be written.
    pub fn run(&self, root: &Path) -> Result<(), Failure> {
        let scenario = SCENARIOS.iter().find(|known| known.0 == self.scenario);
        let &(name, logs, seed, plan) = scenario.ok_or("no such scenario")?;
        let folder = tempfile::tempdir()?;
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
        text += &match plan {
            Some(plan) => table(&plan(&asked), asked.only, self.jobs)?,
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
    })?;
    let answers: Vec<Answer> = answers.into_iter().collect::<Result<_, _>>()?;
    let mut rows: BTreeMap<&(usize, String), Vec<&Answer>> = BTreeMap::new();
    for (case, answer) in cases.iter().zip(&answers) {
        for row in &case.rows {
            rows.entry(row).or_default().push(answer);
        }
    }
    let mut columns: Vec<&str> = Vec::new();
    for (column, _) in answers.iter().flat_map(|answer| &answer.cells) {
        if !columns.contains(column) {
            columns.push(column);
        }
    }
    let mut text = format!("{}\n\n| | logs | {} |\n", plan.about, columns.join(" | "));
    text += &format!("|---|---|{}\n", "---|".repeat(columns.len()));
    for ((_, name), answers) in rows {
        let _ = write!(text, "| {name} | {} |", answers.len());
        for column in &columns {
            let cells = answers.iter().flat_map(|answer| &answer.cells);
            let cells = cells.filter(|(of, _)| of == column);
            let _ = write!(text, " {} |", shown(cells.map(|(_, cell)| *cell)));
        }
        text += "\n";
    }
    let notes: Vec<&str> = answers.iter().filter_map(|a| a.note.as_deref()).collect();
    if !notes.is_empty() {
        let _ = write!(text, "\nWorth a look:\n\n{}\n", notes.join("\n"));
    }
    Ok(text)
}

/// The cells of a column in one row: the sum of shares, or the median of numbers.
fn shown(cells: impl Iterator<Item = Cell>) -> String {
    let (mut share, mut numbers) = ((0, 0), Vec::new());
    for cell in cells {
        match cell {
            Cell::Share(hit, of) => share = (share.0 + hit, share.1 + of),
            Cell::Median(number) => numbers.extend(Some(number).filter(|number| !number.is_nan())),
        }
    }
    numbers.sort_by(f64::total_cmp);
    match (share, numbers.get(numbers.len() / 2)) {
        (_, Some(median)) => format!("{median:.3}"),
        ((_, 0), None) => "–".to_owned(),
        ((hit, of), None) => format!("{hit} of {of}"),
    }
}

/// The results of `0..count`, in this order, from so many threads.
fn side_by_side<T: Send>(
    count: usize,
    jobs: usize,
    ask: impl Fn(usize) -> T + Send + Sync,
) -> Result<Vec<T>, Failure> {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(jobs).build()?;
    Ok(pool.install(|| (0..count).into_par_iter().map(ask).collect()))
}

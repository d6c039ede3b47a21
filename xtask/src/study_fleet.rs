//! The study of fleets: the tested fleet, in which a batch of robots shares an offset, one
//! drifts, one encoder is stuck, one URDF is new, two logs are cut and one comes twice; and
//! fleets in which nothing is hidden, of which every shared effect and every change is a false
//! alarm.
//!
//! Every fleet has a seed: the same command counts the same logs again.

use std::collections::BTreeSet;
use std::error::Error;
use std::fmt::Write as _;
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Instant;

use clap::Args;
use sesc::report::fleet::{ROBOTS, pages};
use sesc_identify::diagnose::Verdict;
use sesc_identify::fleet::summary::{ChangeKind, Summary, summary};
use sesc_identify::fleet::{Fleet as Found, Request, Row, groups, inputs, run};
use sesc_identify::health::Kind;
use sesc_identify::robot::Robot;
use sesc_test_support::fleet::{BATCH, DRIFT, Fleet, STUCK};

/// How many fleets.
#[derive(Args)]
pub struct StudyFleet {
    /// Fleets with the faults of the tested fleet
    #[arg(long, default_value_t = 3)]
    faulty: u64,
    /// Fleets in which nothing is hidden
    #[arg(long, default_value_t = 20)]
    sound: u64,
    /// Robots of a fleet
    #[arg(long, default_value_t = 60)]
    robots: usize,
    /// Days
    #[arg(long, default_value_t = 7)]
    days: usize,
    /// Bodies of the fleets in which nothing is hidden differ by these deviations: part of each
    /// mass, m of each CoM
    #[arg(long, value_name = "PART,M", value_delimiter = ',', num_args = 1)]
    spread: Vec<f64>,
    /// Prior of fits and diagnoses, as of `sesc fleet`
    #[arg(long, value_name = "PRIOR")]
    prior: Option<String>,
    /// The first fleet's seed; each further one's is one more
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Threads
    #[arg(long, default_value_t = 1)]
    threads: usize,
    /// Only write the logs of the tested fleet into this folder
    #[arg(long, value_name = "DIR")]
    write: Option<PathBuf>,
    /// Where the table goes, instead of docs/dev/study/fleet.txt
    #[arg(long, value_name = "FILE")]
    out: Option<PathBuf>,
}

impl StudyFleet {
    /// Make the fleets, and write the table.
    ///
    /// # Errors
    /// What cannot be hidden, read or written; a tested fleet of which something is missed or
    /// something else is named; more than one in twenty sound fleets of which something is.
    pub fn run(&self, root: &Path) -> Result<(), Box<dyn Error>> {
        let faulty = |seed| Fleet::sound(self.robots, self.days, seed).with_faults(8);
        if let Some(folder) = &self.write {
            faulty(self.seed).write(folder)?;
            return Ok(());
        }
        let mut missed = Vec::new();
        let mut text = format!(
            "# Fleets\n\n`cargo xtask study-fleet --faulty {} --sound {} --robots {} --days {} --seed {}`: virtual \
             OP2s, {} robots, {} days, 60 postures a day, 0.1 mm of noise on each.\n\n## With faults\n\nEight robots \
             share an offset of {} ({} rad), one drifts in {} ({} rad a day), one has a stuck encoder ({STUCK}), one \
             another URDF from a day on, two logs are cut in the middle of a row, one is delivered twice.\n\n\
             | seed | shared: robots of the batch found, others | size, rad | drift: day told, day true | other changes \
             | stuck encoder | URDF | cut logs | twice | rows that name something else | robots to look at of none | page as it should be | s |\n\
             |---|---|---|---|---|---|---|---|---|---|---|---|---|\n",
            self.faulty,
            self.sound,
            self.robots,
            self.days,
            self.seed,
            self.robots,
            self.days,
            BATCH.0,
            BATCH.1,
            DRIFT.0,
            DRIFT.1
        );
        for seed in self.seed..self.seed + self.faulty {
            let fleet = faulty(seed);
            let (found, summary, seconds) = self.look(&fleet)?;
            let (line, is_right) = row(seed, &fleet, &found, &summary, seconds);
            writeln!(text, "{line}")?;
            if !is_right {
                missed.push(format!("the fleet of seed {seed}"));
            }
            eprintln!("{}", text.lines().last().unwrap_or_default());
        }
        text += "\n## Nothing hidden\n\n| seed | rows | verdicts but none and absorbed | shared effects | changes | robots to look at |\n|---|---|---|---|---|---|\n";
        let (mut shared, mut changed) = (0, 0);
        for seed in 1000 + self.seed..1000 + self.seed + self.sound {
            let mut fleet = Fleet::sound(self.robots, self.days, seed);
            if let [part, length] = self.spread[..] {
                fleet.spread = Some((part, length));
            }
            let (found, summary, _) = self.look(&fleet)?;
            let named = found
                .rows
                .iter()
                .filter(|row| !matches!(row.verdict, Some(Verdict::None | Verdict::Absorbed)));
            writeln!(
                text,
                "| {seed} | {} | {} | {} | {} | {} |",
                found.rows.len(),
                named.count(),
                summary.shared.len(),
                summary.changes.len(),
                summary.look_first.join(", ")
            )?;
            eprintln!("{}", text.lines().last().unwrap_or_default());
            shared += usize::from(!summary.shared.is_empty());
            changed += usize::from(!summary.changes.is_empty());
        }
        writeln!(
            text,
            "\nOf {} fleets in which nothing is hidden, {shared} had a shared effect and {changed} a change.",
            self.sound
        )?;
        let out = self
            .out
            .clone()
            .unwrap_or_else(|| root.join("docs/dev/study/fleet.txt"));
        fs::write(&out, text)?;
        eprintln!("wrote {}", out.display());
        for alarms in [shared, changed] {
            if alarms as u64 * 20 > self.sound {
                missed.push(format!("{alarms} of {} sound fleets", self.sound));
            }
        }
        match missed.is_empty() {
            true => Ok(()),
            false => Err(format!("not as it should be: {}", missed.join(", ")).into()),
        }
    }

    fn look(&self, fleet: &Fleet) -> Result<(Found, Summary, f64), Box<dyn Error>> {
        let folder = tempfile::tempdir()?;
        let urdf = fleet.write(folder.path())?;
        let start = Instant::now();
        let pattern = folder.path().join("logs/robot=*/day=*/*.csv");
        let by = ["robot".to_string(), "day".to_string()];
        let logs = inputs(&[pattern.display().to_string()], &by)?;
        let mut request = Request::new(Arc::new(Robot::read(&urdf)?), groups(&logs));
        request.threads = Some(self.threads);
        if let Some(prior) = &self.prior {
            request.options.prior = Some(prior.clone());
        }
        let found = run(&request, &mut ())?;
        let summary = summary(&found.rows, &found.names, None);
        Ok((found, summary, start.elapsed().as_secs_f64()))
    }
}

/// A line of the table, and whether it is what was hidden and nothing else.
fn row(seed: u64, fleet: &Fleet, found: &Found, summary: &Summary, seconds: f64) -> (String, bool) {
    let name = Fleet::name;
    let batch: BTreeSet<String> = fleet.batch.iter().map(|robot| name(*robot)).collect();
    let own = summary.shared.iter().find(|s| s.target == BATCH.0);
    let robots = own.map_or(0, |s| {
        s.robots
            .iter()
            .filter(|robot| batch.contains(*robot))
            .count()
    });
    let others = summary.shared.iter().map(|s| s.robots.len()).sum::<usize>() - robots;
    let size = own.map_or("–".to_string(), |s| {
        format!("{:.4} ± {:.4}", s.size, s.std)
    });
    let is =
        |robot: &str, own: Option<(usize, usize)>| own.is_some_and(|(own, _)| name(own) == robot);
    let drifts: Vec<&str> = summary
        .changes
        .iter()
        .filter(|c| {
            is(&c.robot, fleet.drifts)
                && c.kind == ChangeKind::Effect
                && c.target.ends_with(DRIFT.0)
        })
        .map(|c| c.day.as_str())
        .collect();
    let urdfs = summary
        .changes
        .iter()
        .filter(|c| is(&c.robot, fleet.urdf) && c.kind == ChangeKind::Urdf)
        .count();
    let told = drifts.join(", ");
    let rest = summary.changes.len() - drifts.len() - urdfs;
    let stuck: BTreeSet<&str> = found
        .rows
        .iter()
        .filter(|row| row.health.iter().any(|f| f.kind == Kind::EncoderStuck))
        .map(|row| row.robot.as_str())
        .collect();
    let stuck: Vec<&str> = stuck.into_iter().collect();
    let mut known = batch;
    known.extend(fleet.stuck.map(name));
    known.extend(
        [fleet.drifts, fleet.urdf]
            .into_iter()
            .flatten()
            .map(|(robot, _)| name(robot)),
    );
    known.extend(fleet.truncated.iter().map(|(robot, _)| name(*robot)));
    let none: Vec<&str> = summary
        .look_first
        .iter()
        .filter(|robot| !known.contains(*robot))
        .map(String::as_str)
        .collect();
    let (drifts_from, stuck_robot) = (fleet.drifts.map(|(_, day)| day), fleet.stuck.map(name));
    let strays = found.rows.iter().filter(|row| names_more(row, fleet));
    let strays: Vec<String> = strays
        .map(|row| format!("{} on {}", row.robot, row.day))
        .collect();
    let page = on_the_page(found, summary);
    let is_page_right = page.as_ref().is_some_and(|(headline, robots)| {
        headline == "1 shared effect, 2 changes, 2 logs with errors" && *robots == known
    });
    let is_right = (robots, others, rest, urdfs) == (fleet.batch.len(), 0, 0, 1)
        && drifts
            .iter()
            .eq(drifts_from.map(|day| day.to_string()).iter())
        && stuck.iter().eq(stuck_robot.iter())
        && (found.failed.len(), found.twice.len()) == (fleet.truncated.len(), 1)
        && none.is_empty()
        && strays.is_empty()
        && is_page_right;
    let line = format!(
        "| {seed} | {robots} of {}, {others} | {size} | {told}, {} | {rest} | {} | {urdfs} of 1 | {} of {} | {} of 1 | {} | {} | {} | {seconds:.0} |",
        fleet.batch.len(),
        drifts_from.unwrap_or(0),
        stuck.join(", "),
        found.failed.len(),
        fleet.truncated.len(),
        found.twice.len(),
        strays.join(", "),
        none.join(", "),
        if is_page_right { "yes" } else { "no" }
    );
    (line, is_right)
}

/// Whether a row of the table names anything but what was hidden in its robot on that day.
fn names_more(row: &Row, fleet: &Fleet) -> bool {
    let is = |robot: usize| row.robot == Fleet::name(robot);
    let from = |(robot, day): (usize, usize)| {
        is(robot) && row.day.parse().is_ok_and(|own: usize| own >= day)
    };
    let is_stuck = fleet.stuck.is_some_and(is);
    let joint = match () {
        () if fleet.batch.iter().any(|robot| is(*robot)) => Some(BATCH.0),
        () if fleet.drifts.is_some_and(from) => Some(DRIFT.0),
        () => None,
    };
    let is_cut = fleet
        .truncated
        .iter()
        .any(|(robot, day)| is(*robot) && row.day == day.to_string());
    let has_urdfs = fleet.urdf.is_some_and(|(robot, _)| is(robot));
    row.effects
        .iter()
        .any(|found| Some(found.target.as_str()) != joint)
        || row
            .health
            .iter()
            .any(|found| !is_stuck || found.target != STUCK)
        || row.verdict == Some(Verdict::Unexplained)
        || row.error.is_some() != is_cut
        || row.sentence.contains("This robot has 2 URDFs") != has_urdfs
}

/// The headline of the fleet's page, and the robots that it says to look at first.
fn on_the_page(found: &Found, summary: &Summary) -> Option<(String, BTreeSet<String>)> {
    let page = pages(found, summary, None, ("sesc fleet", "fleet.html"), ROBOTS).ok()?;
    let between = |start: &str, end: &str| {
        let rest = page.fleet.split_once(start)?.1;
        Some(rest.split_once(end)?.0.to_string())
    };
    let first = between("<h2>Look at these first</h2>", "</table>").unwrap_or_default();
    let robots = first.split("href=\"fleet/").skip(1);
    let robots = robots.filter_map(|link| Some(link.split_once(".html")?.0.to_string()));
    Some((between("<h1>", "</h1>")?, robots.collect()))
}

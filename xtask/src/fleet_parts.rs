//! A fleet that no machine here could log, by its parts alone: rows as diagnoses leave them are
//! drawn, and what is said across robots is made of them, with its time and its memory.

use std::error::Error;
use std::fs;
use std::time::Instant;

use clap::Args;
use rand::{RngExt as _, SeedableRng as _};
use rand_chacha::ChaCha8Rng;
use sesc::report::fleet::{ROBOTS, pages};
use sesc_identify::diagnose::Verdict;
use sesc_identify::fleet::summary::summary;
use sesc_identify::fleet::{EffectFound, Fleet, Row, assembled, write};

/// Parameters of the OP2, and their deviation, m.
const PARAMS: usize = 43;
const STD: f64 = 1e-4;
/// A text as long as that of a diagnosis in which nothing is found.
const SENTENCE: usize = 600;

/// How many rows.
#[derive(Args)]
pub struct FleetParts {
    /// Robots; every tenth has an offset, every hundredth one that it shares
    #[arg(long, default_value_t = 100)]
    robots: usize,
    /// Days
    #[arg(long, default_value_t = 365)]
    days: usize,
}

impl FleetParts {
    /// Draw rows, put them together, and print seconds and memory as a line of a table.
    ///
    /// # Errors
    /// What cannot be written.
    pub fn run(&self) -> Result<(), Box<dyn Error>> {
        let mut random = ChaCha8Rng::seed_from_u64(1);
        let mut rows = Vec::with_capacity(self.robots * self.days);
        // Days first, as they come in.
        for day in 0..self.days {
            rows.extend((0..self.robots).map(|robot| row(robot, day, &mut random)));
        }
        let drawn = memory_mb();
        let mut fleet = Fleet::default();
        let start = Instant::now();
        fleet.rows = assembled(rows);
        let sorted = start.elapsed().as_secs_f64();
        let start = Instant::now();
        let said = summary(&fleet.rows, &fleet.names, None);
        let together = start.elapsed().as_secs_f64();
        let folder = tempfile::tempdir()?;
        let table = folder.path().join("fleet.parquet");
        let start = Instant::now();
        write(&table, &fleet.rows)?;
        let written = start.elapsed().as_secs_f64();
        let size = fs::metadata(&table)?.len() as f64 / 1e6;
        let start = Instant::now();
        let pages = pages(&fleet, &said, None, ("sesc fleet", "fleet.html"), ROBOTS)?;
        let paged = start.elapsed().as_secs_f64();
        println!(
            "| robots × days | rows | sorting, s | summary, s | table, s | pages, s | drawn, MB | at most, MB | table, MB | found |\n\
             |---|---|---|---|---|---|---|---|---|---|"
        );
        println!(
            "| {} × {} | {} | {sorted:.1} | {together:.1} | {written:.1} | {paged:.1} | {drawn:.0} | {:.0} | {size:.0} | {} shared, {} changes, {} pages |",
            self.robots,
            self.days,
            fleet.rows.len(),
            memory_mb(),
            said.shared.len(),
            said.changes.len(),
            pages.robots.len()
        );
        Ok(())
    }
}

/// A row as a diagnosis leaves it.
fn row(robot: usize, day: usize, random: &mut ChaCha8Rng) -> Row {
    // Twelve even numbers less six: near enough to a normal one.
    let mut normal = || -> f64 { (0..12).map(|_| random.random::<f64>()).sum::<f64>() - 6.0 };
    let mut row = Row::default();
    row.robot = format!("r{robot:05}");
    row.day = format!("{day:03}");
    row.urdf_hash = "0123456789abcdef".to_string();
    row.support = "r_sole".to_string();
    row.postures = 2000;
    row.independent = 2000;
    row.noise_floor = Some(1.4e-4);
    row.held_out_rmse = Some(1.5e-4);
    row.verdict = Some(Verdict::None);
    row.sentence = "x".repeat(SENTENCE);
    row.params = (0..PARAMS).map(|_| STD * normal()).collect();
    row.std = vec![Some(STD); PARAMS];
    let line = |i: usize| (0..=i).map(move |j| if i == j { STD * STD } else { 0.0 });
    row.covariance = (0..PARAMS).flat_map(line).collect();
    row.inputs = vec![format!("{:032x}", robot * 1000 + day)];
    row.version = "0.1.0".to_string();
    let target = match (robot % 10, robot % 100) {
        (_, 0) => "l_knee".to_string(),
        (0, _) => format!("joint_{}", robot / 10 % 19),
        _ => return row,
    };
    let size = match target.as_str() {
        "l_knee" => 0.03,
        _ => 0.01 + 1e-5 * (robot % 5000) as f64,
    };
    let value = size + 1e-3 * normal();
    let found = format!(
        r#"{{"effect": "joint_offset", "target": "{target}", "evidence": 90.0,
            "parameters": {{"offset_rad": {{"value": {value}, "std": 0.001}}}}}}"#
    );
    row.verdict = Some(Verdict::Named);
    row.effects = serde_json::from_str::<EffectFound>(&found)
        .into_iter()
        .collect();
    row
}

/// The most memory that this process has had, MB; zero where the system does not say.
fn memory_mb() -> f64 {
    let about = fs::read_to_string("/proc/self/status").unwrap_or_default();
    let most = about.lines().find_map(|line| line.strip_prefix("VmHWM:"));
    let kilobytes = most.and_then(|text| text.split_whitespace().next()?.parse::<f64>().ok());
    kilobytes.unwrap_or(0.0) / 1e3
}

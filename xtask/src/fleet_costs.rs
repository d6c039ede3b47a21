//! What a log of a fleet costs, step by step and posture by posture: reading it, making a part of
//! it, merging parts, fitting them, and the row of a fleet.

use std::error::Error;
use std::fs;
use std::hint::black_box;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use clap::Args;
use sesc_identify::fit::part::Part;
use sesc_identify::fit::{self, fit, gather};
use sesc_identify::fleet::{Local, Log, Only, Options, row};
use sesc_identify::logs::PostureReader;
use sesc_identify::robot::Robot;
use sesc_identify::simulate;
use sesc_model::Snapping;

/// Noise of a posture's mean reading, m; joints are drawn within ± this, rad.
const NOISE: f64 = 1e-4;
const RANGE: f64 = 0.5;
/// Rows read at once, as a fit reads them.
const BLOCK: usize = 4096;
/// A step is done again until it has taken this, s: the clock of processors ticks each 10 ms.
const LONG: f64 = 1.0;
/// Logs whose parts are merged.
const MERGED: u64 = 8;

/// Which logs.
#[derive(Args)]
pub struct FleetCosts {
    /// Postures of a log, one line of the table for each
    #[arg(long, value_delimiter = ',', default_value = "60,2000,20000,200000")]
    postures: Vec<usize>,
    /// Diagnose each log, too, with as many postures as this or fewer
    #[arg(long, default_value_t = 2000)]
    diagnosed: usize,
}

impl FleetCosts {
    /// Simulate logs, do each step, and print a table.
    ///
    /// # Errors
    /// What cannot be written or read, and a system that does not tell the time of processors.
    pub fn run(&self, root: &Path) -> Result<(), Box<dyn Error>> {
        let robot = Arc::new(Robot::read(&root.join("robots/op2/op2.urdf"))?);
        println!(
            "| postures | file, B | reading, µs | part, µs | row, µs | row with diagnosis, µs | size of a part, kB | merging two parts, ms | fitting a part, ms |\n\
             |---|---|---|---|---|---|---|---|---|"
        );
        for postures in &self.postures {
            println!("{}", self.line(&robot, *postures)?);
        }
        Ok(())
    }

    fn line(&self, robot: &Arc<Robot>, postures: usize) -> Result<String, Box<dyn Error>> {
        let folder = tempfile::tempdir()?;
        let logs = (0..MERGED).map(|seed| simulated(robot, postures, seed, folder.path()));
        let logs = logs.collect::<Result<Vec<PathBuf>, Box<dyn Error>>>()?;
        let size = fs::metadata(&logs[0])?.len() as f64 / postures as f64;
        let dofs = robot.description.dofs();
        let reading = seconds(|| {
            let mut reader = PostureReader::open(&*logs[0], &dofs, &Default::default())?;
            while !black_box(reader.block(BLOCK)?).is_empty() {}
            Ok(())
        })?;
        let part = |log: &PathBuf| -> Result<Part, Box<dyn Error>> {
            let mut request = fit::Request::default();
            request.robot = Some(Arc::clone(robot));
            request.logs = vec![log.clone().into()];
            Ok(gather(&request, &mut ())?)
        };
        let gathering = seconds(|| part(&logs[0]))?;
        let parts = logs.iter().map(&part).collect::<Result<Vec<Part>, _>>()?;
        let bytes = parts[0].to_bytes()?.len();
        let copies = seconds(|| Ok(parts.clone()))?;
        let merging = seconds(|| merged(&parts))?;
        let whole = merged(&parts)?;
        let fitting = seconds(|| {
            let mut request = fit::Request::default();
            request.robot = Some(Arc::clone(robot));
            request.parts = vec![("parts".into(), whole.clone())];
            Ok(fit(&request, &mut ())?)
        })?;
        let making = |only: Only| {
            let mut options = Options::default();
            options.only = only;
            seconds(|| {
                let log = Log::read(&Local, &logs[0])?;
                let made = row(robot, &options, ("r", "1"), &[log], &mut ())?;
                match made.error {
                    None => Ok(()),
                    Some(error) => Err(error.into()),
                }
            })
        };
        let alone = making(Only::Parameters)?;
        let diagnosed = match postures <= self.diagnosed {
            true => each(making(Only::All)?, postures),
            false => "–".to_string(),
        };
        let pairs = (parts.len() - 1) as f64;
        Ok(format!(
            "| {postures} | {size:.0} | {} | {} | {} | {diagnosed} | {:.0} | {:.2} | {:.1} |",
            each(reading, postures),
            each(gathering, postures),
            each(alone, postures),
            bytes as f64 / 1e3,
            1e3 * (merging - copies).max(0.0) / pairs,
            1e3 * fitting,
        ))
    }
}

/// Microseconds for each posture.
fn each(seconds: f64, postures: usize) -> String {
    let each = 1e6 * seconds / postures as f64;
    match each < 9.95 {
        true => format!("{each:.1}"),
        false => format!("{each:.0}"),
    }
}

fn merged(parts: &[Part]) -> Result<Part, Box<dyn Error>> {
    let mut parts = parts.iter().cloned();
    let mut whole = parts.next().ok_or("no parts")?;
    for part in parts {
        whole.merge(part, "part")?;
    }
    Ok(whole)
}

fn simulated(
    robot: &Robot,
    postures: usize,
    seed: u64,
    folder: &Path,
) -> Result<PathBuf, Box<dyn Error>> {
    let model = robot.model("r_sole", Snapping::default(), None)?;
    let mut request = simulate::Request::new(model, postures);
    request.noise = NOISE;
    request.range = Some(RANGE);
    request.seed = seed + 1;
    let log = folder.join(format!("{seed}.parquet"));
    simulate::write(&request, &log, &mut ())?;
    Ok(log)
}

/// Seconds of processors, of all threads, that a step takes.
fn seconds<T>(mut step: impl FnMut() -> Result<T, Box<dyn Error>>) -> Result<f64, Box<dyn Error>> {
    // What is made once for all logs is made here.
    step()?;
    let (start, mut count) = (processors()?, 0);
    loop {
        black_box(step()?);
        count += 1;
        let taken = processors()? - start;
        if taken >= LONG {
            return Ok(taken / f64::from(count));
        }
    }
}

/// Seconds of processors that this process has had (Linux).
fn processors() -> Result<f64, Box<dyn Error>> {
    const TICKS: f64 = 100.0;
    let about = fs::read_to_string("/proc/self/stat")?;
    let (_, fields) = about
        .rsplit_once(')')
        .ok_or("/proc/self/stat is another's")?;
    let fields: Vec<&str> = fields.split_whitespace().collect();
    let ticks = |k: usize| -> Result<f64, Box<dyn Error>> { Ok(fields[k].parse::<f64>()?) };
    Ok((ticks(11)? + ticks(12)?) / TICKS)
}

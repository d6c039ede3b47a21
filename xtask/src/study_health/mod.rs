//! The study of broken data: how often each broken device is recognised, and how often a
//! finding is false, on healthy logs with hidden effects of every kind.
//!
//! Logs are those of the study of hidden effects, drawn from seeds; a device breaks their
//! rows. Findings are those of a look at the data, before any hypothesis.

mod devices;

use std::collections::BTreeMap;
use std::error::Error;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use clap::Args;
use sesc_identify::health;
use sesc_identify::logs::{LogSource, Options, Readings};
use sesc_identify::observations::postures::{Postures, Taking};
use sesc_identify::robot::Robot;
use sesc_model::Snapping;
use sesc_virtual::stage::Platform;
use sesc_virtual::survey;
use sesc_virtual::trial::{Choice, Question, Trial};

use devices::{Broken, DEVICES, Device};

/// What to count how often.
#[derive(Args)]
pub struct StudyHealth {
    /// Healthy logs with hidden effects
    #[arg(long, default_value_t = 200)]
    healthy: usize,
    /// Logs of each broken device on each robot
    #[arg(long, default_value_t = 100)]
    broken: usize,
    /// The first log's seed; each further one's is one more
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// This device alone
    #[arg(long, value_name = "KIND")]
    only: Option<String>,
    /// Where the tables go, instead of standard output
    #[arg(long, value_name = "FILE")]
    out: Option<PathBuf>,
}

const ROBOTS: [(Platform, &str); 3] = [
    (Platform::Op2, "op2"),
    (Platform::Skew, "skew_humanoid"),
    (Platform::Plain, "plain_humanoid"),
];

impl StudyHealth {
    /// Draw, break, look and count.
    ///
    /// # Errors
    /// A log that cannot be written or looked at.
    pub fn run(&self, _: &Path) -> Result<(), Box<dyn Error>> {
        let folder = tempfile::tempdir()?;
        let healthy = self.count_healthy(folder.path())?;
        let mut table = String::from("broken device         ");
        for (_, name) in ROBOTS {
            let _ = write!(table, "{name:>16}");
        }
        for device in DEVICES {
            if self.only.as_ref().is_some_and(|only| only != device.kind()) {
                continue;
            }
            let _ = write!(table, "\n{:<22}", device.name());
            for (platform, name) in ROBOTS {
                let (found, asked) = self.count_broken(device, platform, name, folder.path())?;
                eprintln!("{} on {name}: {found} of {asked}", device.name());
                let _ = write!(table, "{:>16}", format!("{found} of {asked}"));
            }
        }
        let page = format!("{healthy}\n{table}\n");
        match &self.out {
            Some(path) => std::fs::write(path, page)?,
            None => println!("{page}"),
        }
        Ok(())
    }

    /// False findings by kind.
    fn count_healthy(&self, folder: &Path) -> Result<String, Box<dyn Error>> {
        let choice = survey::everything();
        let mut false_ones: BTreeMap<String, usize> = BTreeMap::new();
        let mut with = 0;
        for (k, question) in survey::questions(self.healthy, &choice)
            .into_iter()
            .enumerate()
        {
            let seed = self.seed + k as u64;
            let trial = Trial::draw(question, &choice, seed);
            let log = trial.log.write(folder, "healthy");
            let found = look(&trial.stage.urdf, &log, trial.stage.support)?;
            with += usize::from(!found.is_empty());
            for finding in found {
                let hidden: Vec<String> = trial.hidden.iter().map(|h| h.label()).collect();
                eprintln!(
                    "seed {seed}: {finding:?} where {} is hidden",
                    hidden.join(" + ")
                );
                *false_ones.entry(finding.0).or_default() += 1;
            }
            if (k + 1) % 50 == 0 {
                eprintln!("{} healthy logs, {with} with a finding", k + 1);
            }
        }
        Ok(format!(
            "{with} of {} healthy logs have a finding {false_ones:?}",
            self.healthy
        ))
    }

    /// How many broken logs have exactly the finding that they should have.
    fn count_broken(
        &self,
        device: Device,
        platform: Platform,
        name: &str,
        folder: &Path,
    ) -> Result<(usize, usize), Box<dyn Error>> {
        let choice = Choice {
            platforms: vec![platform],
            ..survey::everything()
        };
        let (mut found, mut asked, mut seed) = (0, 0, self.seed);
        while asked < self.broken {
            seed += 1;
            let trial = Trial::draw(Question::Nothing, &choice, seed);
            let path = trial.log.write(folder, "broken");
            let Some(broken) = Broken::of(device, &trial, &path, seed)? else {
                continue;
            };
            asked += 1;
            let kinds = look(&broken.urdf, &path, &broken.support)?;
            match kinds
                .iter()
                .any(|(kind, target)| *kind == device.kind() && broken.is(target))
            {
                true => found += 1,
                false => eprintln!("{} on {name}, seed {seed}: {kinds:?}", device.name()),
            }
        }
        Ok((found, asked))
    }
}

/// Kinds and targets of what is found in a log.
fn look(urdf: &Path, log: &Path, support: &str) -> Result<Vec<(String, String)>, Box<dyn Error>> {
    let robot = Robot::read(urdf)?;
    let model = robot.model(support, Snapping::default(), None)?;
    let links = robot.description.links.iter();
    let options = Options {
        readings: Readings::Required,
        links: links.map(|link| link.name.clone()).collect(),
        support: Some(support.to_string()),
        any_unit: true,
        ..Options::default()
    };
    let log = LogSource::from(log);
    let (log, rows) = health::screen(&log, &model, &options, None, &mut ())?;
    let taking = Taking {
        options,
        noise: None,
        floor: sesc_identify::diagnose::FLOOR_M,
    };
    let data = Postures::read(&log, &model, &taking, &mut ())?;
    let found = health::examine(&robot, &model, Snapping::default(), &data).after(rows);
    let findings = found.findings.into_iter();
    Ok(findings
        .map(|f| (f.kind.name().to_string(), f.target))
        .collect())
}

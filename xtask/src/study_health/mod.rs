//! The study of broken data: how often each broken device is recognised, and how often a
//! finding is false, on healthy logs with hidden effects of every kind and on healthy
//! recordings. Of stuck encoders it is counted, too, what a diagnosis finds beside them: nothing
//! else is hidden.
//!
//! Standing logs are those of the study of hidden effects; recordings are slow sines at 10 to
//! 100 Hz with white or lasting noise. A device breaks their rows. A device is recognised
//! where both commands find it: `diagnose` looks at postures with their motion, `fit` at rows.

mod devices;
mod sheet;

use std::collections::BTreeMap;
use std::error::Error;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use clap::Args;
use sesc_identify::diagnose::{self, Verdict};
use sesc_identify::fit;
use sesc_identify::health::{self, Finding};
use sesc_identify::logs::{LogSource, Options, Readings};
use sesc_identify::robot::Robot;
use sesc_model::Snapping;
use sesc_test_support::stage::Platform;
use sesc_test_support::survey;
use sesc_test_support::trial::{Choice, Trial};

use devices::{Broken, DEVICES, Device};
use sheet::{RecordingKind, Sheet};

/// What to count how often.
#[derive(Args)]
pub struct StudyHealth {
    /// Healthy logs with hidden effects
    #[arg(long, default_value_t = 300)]
    healthy: usize,
    /// Healthy recordings
    #[arg(long, default_value_t = 300)]
    moving: usize,
    /// Healthy logs with hidden effects in which a third of the joints stand still, and as many
    /// such recordings
    #[arg(long, default_value_t = 300)]
    held: usize,
    /// Logs of each broken device on each robot, standing and moving each
    #[arg(long, default_value_t = 100)]
    broken: usize,
    /// How many of those with a stuck encoder are diagnosed
    #[arg(long, default_value_t = 20)]
    diagnosed: usize,
    /// The first log's seed; each further one's is one more
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// This device alone
    #[arg(long, value_name = "NAME")]
    only: Option<String>,
    /// Where the tables go, instead of docs/dev/study/health.txt
    #[arg(long, value_name = "FILE")]
    out: Option<PathBuf>,
}

const ROBOTS: [(Platform, &str); 3] = [
    (Platform::Op2, "OP2"),
    (Platform::Skew, "Skew"),
    (Platform::Plain, "plain"),
];
const SOURCES: [(RecordingKind, &str); 2] = [
    (RecordingKind::Standing, "standing"),
    (RecordingKind::Moving, "moving"),
];

/// Broken logs of one kind.
#[derive(Default)]
struct Count {
    asked: usize,
    found: usize,
    /// With a finding that is wrong.
    beside: usize,
    diagnosed: usize,
    /// With a verdict but none.
    named: usize,
}

impl Count {
    fn cell(&self) -> String {
        match self {
            Count { asked: 0, .. } => "–".to_string(),
            Count { beside: 0, .. } => format!("{} of {}", self.found, self.asked),
            _ => format!("{} of {}, {} beside", self.found, self.asked, self.beside),
        }
    }

    fn add(&mut self, other: &Count) {
        self.asked += other.asked;
        self.found += other.found;
        self.beside += other.beside;
        self.diagnosed += other.diagnosed;
        self.named += other.named;
    }
}

/// Share of the joints that stand still in some logs.
const HELD: f64 = 1.0 / 3.0;

/// Logs that are drawn for one in which a device has something to break.
const TRIES: usize = 60;

impl StudyHealth {
    /// Draw, break, look and count.
    ///
    /// # Errors
    /// A log that cannot be written or looked at.
    pub fn run(&self, root: &Path) -> Result<(), Box<dyn Error>> {
        let folder = tempfile::tempdir()?;
        let mut page = format!(
            "# Broken data\n\n\
             How often each broken device is recognised, by both `fit` and `diagnose` and by its \
             name and target, how often another finding stands beside it, and how often healthy \
             logs have a finding, those of a whole `fit` included. `cargo xtask study-health --healthy {} --moving {} --held {} --broken {} \
             --diagnosed {} --seed {}` counts the same logs again.\n\n\
             Standing: 38 to 1000 postures of the study of hidden effects, each averaged over 100 \
             readings or repeated 20 times, noise of a reading 5 mm (OP2) or 11 mm; stated in 7 of \
             10. Moving: half a minute to a minute and a half at 10 to 100 Hz (6000 rows at most), \
             two sines a joint of 5 to 11° each and up to 0.4 Hz, or of up to 11° and 0.1 Hz, of \
             robots whose masses are those of CAD; readings are ZMPs with noise of 0.3 to 1.5 mm \
             (OP2) or 0.7 to 3.3 mm, white or AR(1) of 0.1 to 1 s, stated in one of two; angles in \
             all digits or in ticks of 2π/4096. A stuck encoder hides 12 deviations of a reading \
             or more of CoP motion where its joint is beside the middle of its range.\n\n",
            self.healthy, self.moving, self.held, self.broken, self.diagnosed, self.seed
        );
        let _ = writeln!(page, "{}\n", self.count_healthy(folder.path())?);
        let _ = write!(page, "| broken device |");
        for (_, source) in SOURCES {
            for (_, robot) in ROBOTS {
                let _ = write!(page, " {robot}, {source} |");
            }
        }
        let _ = writeln!(page, " all |\n|---|---|---|---|---|---|---|---|");
        let mut stuck = Count::default();
        for device in DEVICES {
            if self
                .only
                .as_ref()
                .is_some_and(|only| !device.name().contains(only))
            {
                continue;
            }
            let _ = write!(page, "| {} |", device.name());
            let mut all = Count::default();
            for (source, how) in SOURCES {
                for (platform, name) in ROBOTS {
                    let count = self.count_broken(device, (source, platform), folder.path())?;
                    let cell = count.cell();
                    eprintln!("{} on {name}, {how}: {cell}", device.name());
                    let _ = write!(page, " {cell} |");
                    all.add(&count);
                }
            }
            let percent = 100.0 * all.found as f64 / all.asked.max(1) as f64;
            let _ = write!(page, " {percent:.1} % |");
            if device == Device::Stuck {
                stuck = all;
            }
            page += "\n";
        }
        if stuck.diagnosed > 0 {
            let _ = write!(
                page,
                "\nOf {} logs with a stuck encoder that were diagnosed to the end, {} have an \
                 effect named or suspected beside it.\n",
                stuck.diagnosed, stuck.named
            );
        }
        let own = root.join("docs/dev/study/health.txt");
        std::fs::write(self.out.as_ref().unwrap_or(&own), page)?;
        Ok(())
    }

    /// False findings by kind.
    fn count_healthy(&self, folder: &Path) -> Result<String, Box<dyn Error>> {
        let with_effects = |count: usize, held: f64| {
            let choice = Choice {
                held,
                ..survey::everything()
            };
            let questions = survey::questions(count, &choice);
            questions.into_iter().enumerate().map(move |(k, question)| {
                let trial = Trial::draw(question, &choice, self.seed + k as u64);
                let hidden: Vec<String> = trial.hidden.iter().map(|h| h.label()).collect();
                let mut sheet = Sheet::of_trial(&trial, folder)?;
                sheet.about += &format!(" where {} is hidden", hidden.join(" + "));
                Ok(sheet)
            })
        };
        let recordings = |count: usize, held: f64| {
            (0..count).map(move |k| {
                let platform = ROBOTS[k % ROBOTS.len()].0;
                Ok(Sheet::moving(platform, held, self.seed + k as u64))
            })
        };
        let mut told = String::new();
        told += &tally(
            "healthy logs with hidden effects",
            with_effects(self.healthy, 0.0),
        )?;
        told += &tally("healthy recordings", recordings(self.moving, 0.0))?;
        told += &tally(
            "healthy logs with hidden effects in which a third of the joints stand still",
            with_effects(self.held, HELD),
        )?;
        told += &tally(
            "healthy recordings in which a third of the joints stand still",
            recordings(self.held, HELD),
        )?;
        Ok(told)
    }

    /// How many broken logs have exactly the finding that they should have.
    fn count_broken(
        &self,
        device: Device,
        (source, platform): (RecordingKind, Platform),
        folder: &Path,
    ) -> Result<Count, Box<dyn Error>> {
        let (mut count, mut seed, mut tries) = (Count::default(), self.seed, 0);
        while count.asked < self.broken && tries < TRIES {
            seed += 1;
            let mut sheet = Sheet::draw(source, platform, seed, folder)?;
            let Some(broken) = Broken::of(device, &mut sheet, seed) else {
                tries += 1;
                continue;
            };
            (count.asked, tries) = (count.asked + 1, 0);
            let robot = Arc::new(Robot::parse(&broken.urdf, "robot.urdf")?);
            let log = sheet.log();
            let (on, noise) = (&broken.support, broken.noise);
            let seen = match device.needs_fit() {
                true => fitted(&robot, &log, on, noise).map(|found| [found, Vec::new()]),
                false => looks(&robot, &log, on, noise),
            };
            let seen = seen.map_err(|error| {
                format!("{} on {platform:?}, seed {seed}: {error}", device.name())
            })?;
            let is = |f: &Finding| f.kind.name() == device.kind() && broken.is(&f.target);
            let both = seen.iter().take(if device.needs_fit() { 1 } else { 2 });
            let found = both.clone().all(|all| all.iter().any(is));
            let beside = both.clone().flatten().any(|f| !is(f));
            count.found += usize::from(found);
            count.beside += usize::from(beside);
            if !found || beside {
                eprintln!(
                    "{} on {platform:?}, seed {seed}: {:?} ({})",
                    device.name(),
                    both.map(|all| names(all)).collect::<Vec<_>>(),
                    sheet.about
                );
            }
            if found && device == Device::Stuck && count.diagnosed < self.diagnosed {
                count.diagnosed += 1;
                if let Some(named) = named(&robot, &log, &broken)? {
                    count.named += 1;
                    let about = &sheet.about;
                    eprintln!(
                        "beside a stuck encoder, {platform:?}, seed {seed}: {named} ({about})"
                    );
                }
            }
        }
        Ok(count)
    }
}

/// What a diagnosis finds beside broken data; none where nothing.
fn named(
    robot: &Arc<Robot>,
    log: &LogSource,
    broken: &Broken,
) -> Result<Option<String>, Box<dyn Error>> {
    let mut request = diagnose::Request::new(Arc::clone(robot), log.clone());
    request.support = Some(broken.support.clone());
    request.noise = broken.noise;
    let found = diagnose::diagnose(&request, &mut ())?.diagnosis;
    Ok((found.verdict != Verdict::None).then_some(found.sentence))
}

/// How many healthy logs have a finding.
fn tally(
    name: &str,
    sheets: impl ExactSizeIterator<Item = Result<Sheet, Box<dyn Error>>>,
) -> Result<String, Box<dyn Error>> {
    let count = sheets.len();
    let mut with = 0;
    let mut kinds: BTreeMap<&str, usize> = BTreeMap::new();
    for (k, sheet) in sheets.enumerate() {
        let sheet = sheet?;
        let robot = Arc::new(Robot::read(&sheet.stage.urdf)?);
        let (log, support) = (sheet.log(), sheet.stage.support);
        let [diagnosed, looked_at] = looks(&robot, &log, support, None)?;
        let seen = [diagnosed, looked_at, fitted(&robot, &log, support, None)?];
        let any = seen.iter().any(|all| !all.is_empty());
        with += usize::from(any);
        if any {
            eprintln!(
                "{name}, number {k}: {:?} ({})",
                seen.each_ref().map(|all| names(all)),
                sheet.about
            );
        }
        for finding in seen.iter().flatten() {
            *kinds.entry(finding.kind.name()).or_default() += 1;
        }
    }
    eprintln!("{with} of {count} {name} have a finding {kinds:?}");
    let kinds: Vec<String> = kinds
        .iter()
        .map(|(kind, count)| format!("{kind} {count}"))
        .collect();
    let which = match kinds.is_empty() {
        true => String::new(),
        false => format!(" ({})", kinds.join(", ")),
    };
    Ok(format!("{with} of {count} {name} have a finding{which}. "))
}

fn names(findings: &[Finding]) -> Vec<String> {
    let name = |f: &Finding| format!("{}:{}", f.kind.name(), f.target);
    findings.iter().map(name).collect()
}

/// What `diagnose` and `fit` find in a log before any hypothesis.
fn looks(
    robot: &Arc<Robot>,
    log: &LogSource,
    support: &str,
    noise: Option<f64>,
) -> Result<[Vec<Finding>; 2], Box<dyn Error>> {
    let mut request = diagnose::Request::new(Arc::clone(robot), log.clone());
    request.support = Some(support.into());
    request.noise = noise;
    let diagnosed = diagnose::look(&request, &mut ())?;
    let model = robot.model(support, Snapping::default(), None)?;
    let links = robot.description.links.iter();
    let mut options = Options::default();
    options.readings = Readings::Required;
    options.links = links.map(|link| link.name.clone()).collect();
    options.support = Some(support.to_string());
    options.any_unit = true;
    let reading = health::Reading {
        options: &options,
        snapping: Snapping::default(),
        noise,
        alone: true,
    };
    let (_, fitted) = health::look(log, robot, &model, reading, &mut ())?;
    Ok([diagnosed, fitted])
}

/// What a whole fit says of the data.
fn fitted(
    robot: &Arc<Robot>,
    log: &LogSource,
    support: &str,
    noise: Option<f64>,
) -> Result<Vec<Finding>, Box<dyn Error>> {
    let mut request = fit::Request::default();
    request.robot = Some(Arc::clone(robot));
    request.logs = vec![log.clone()];
    request.support = Some(support.to_string());
    request.noise = noise;
    Ok(fit::fit(&request, &mut ())?.identification.health)
}

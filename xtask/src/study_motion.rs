//! The study of moving robots: one recording at several sampling rates, with and without
//! something hidden, with encoders that write all digits or ticks; counted are verdicts.
//!
//! Every rate must give the verdict of the fastest, and one explanation must be among those that
//! each rate cannot tell apart; where nothing is hidden, the verdict is `none`.
//! The logs are drawn from seeds: the same command counts the same logs again.

use std::collections::BTreeSet;
use std::error::Error;
use std::f64::consts::TAU;
use std::fmt::Write as _;
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use clap::Args;
use rand::SeedableRng as _;
use rand_chacha::ChaCha8Rng;
use sesc_identify::diagnose::{self, Diagnosis, Verdict, diagnose};
use sesc_identify::logs::Table;
use sesc_identify::robot::Robot;
use sesc_test_support::hidden::{Effect, Hidden, NOWHERE, hide_all};
use sesc_test_support::moving::Swing;
use sesc_test_support::recording::{Kind, Noise, Recording};
use sesc_test_support::stage::{Platform, Stage};

/// Recordings are made at this rate, Hz.
const RATE: f64 = 100.0;
/// One in so many rows: 100, 50, 20 and 10 Hz.
const EVERY: [usize; 4] = [1, 2, 5, 10];
/// 4096 ticks a turn, rad.
const TICK: f64 = TAU / 4096.0;

/// ± this many deviations hold 95 %.
const OF_95: f64 = 1.959_964;

/// How many logs.
#[derive(Args)]
pub struct StudyMotion {
    /// Number of recordings of each kind
    #[arg(long, default_value_t = 10)]
    logs: u64,
    /// The first recording's seed; each further one's is one more
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Only kinds of recording whose name contains this
    #[arg(long)]
    only: Option<String>,
    /// Print the sentence of every log
    #[arg(long)]
    sentences: bool,
    /// Where the table goes, instead of docs/dev/study/motion.txt
    #[arg(long, value_name = "FILE")]
    out: Option<PathBuf>,
}

/// A kind of recording.
struct Case {
    platform: Platform,
    hidden: Option<(Effect, &'static str, &'static [f64])>,
    swing: Swing,
    noise: Noise,
    stated: bool,
}

impl Case {
    fn name(&self) -> String {
        let hidden = match self.hidden {
            Some((effect, NOWHERE, _)) => effect.name().to_string(),
            Some((effect, target, _)) => format!("{}:{target}", effect.name()),
            None => "nothing hidden".to_string(),
        };
        let noise = match self.noise.kind {
            Kind::White => "white".to_string(),
            Kind::Ar1(tau) => format!("AR(1) {tau} s"),
            Kind::Smooth(tau) => format!("AR(2) {tau} s"),
            Kind::Sway(tau) => format!("sway {tau} s under white"),
        };
        let (tick, jitter) = (self.swing.tick > 0.0, self.swing.jitter > 0.0);
        format!(
            "{:?}, {hidden}, {} Hz, {}, {noise}{}{}",
            self.platform,
            self.swing.hertz,
            if tick { "ticks" } else { "all digits" },
            if jitter { ", stamps jitter" } else { "" },
            if self.stated {
                ""
            } else {
                ", noise not stated"
            },
        )
    }

    fn record(&self, stage: &Stage, seed: u64) -> Result<Recording, Box<dyn Error>> {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let hidden = self.hidden.map(|(effect, target, values)| Hidden {
            effect,
            target: target.to_string(),
            values: values.to_vec(),
            begins: 0.0,
            seed,
        });
        let world = hide_all(stage.world(), hidden.as_slice())?;
        Ok(self
            .swing
            .record(stage, world, self.noise, RATE, &mut random))
    }

    fn diagnosed(
        &self,
        stage: &Stage,
        robot: &Arc<Robot>,
        recording: &Recording,
    ) -> Result<Diagnosis, Box<dyn Error>> {
        let columns = recording.columns(true).into_iter();
        let log = columns.fold(Table::new("recording"), |table, (name, values)| {
            table.numbers(&name, values)
        });
        let mut request = diagnose::Request::new(Arc::clone(robot), log);
        request.support = Some(stage.support.into());
        request.noise = self.stated.then_some(self.noise.std[0]);
        request.prior = "tight".into();
        Ok(diagnose(&request, &mut ())?.diagnosis)
    }
}

/// What of a hidden effect is estimated by which parameter of the explanation.
fn truth(hidden: Option<(Effect, &'static str, &'static [f64])>) -> Vec<(&'static str, f64)> {
    match hidden {
        Some((Effect::JointOffset, _, values)) => vec![("offset_rad", values[0])],
        Some((Effect::SensorGain, _, values)) => {
            vec![("gain_x", 1.0 + values[0]), ("gain_y", 1.0 + values[1])]
        }
        Some((Effect::Payload, _, values)) => vec![("mass_kg", values[0])],
        Some((Effect::TimeDelay, _, values)) => vec![("delay_s", values[0])],
        _ => Vec::new(),
    }
}

/// How many of the hidden effect's parameters have intervals, and how many of these hold the truth.
fn intervals(case: &Case, found: &Diagnosis) -> [usize; 2] {
    let Some((effect, target, _)) = case.hidden else {
        return [0; 2];
    };
    let step = found
        .steps
        .iter()
        .find(|step| step.effect == effect.name() && (target == NOWHERE || step.target == target));
    let Some(step) = step else { return [0; 2] };
    let known = truth(case.hidden).into_iter().filter_map(|(name, truth)| {
        let found = step.parameters.get(name)?;
        Some((found.value - truth) / found.std)
    });
    let off: Vec<f64> = known.collect();
    [
        off.len(),
        off.iter().filter(|off| off.abs() <= OF_95).count(),
    ]
}

fn cases() -> Vec<Case> {
    let kinds = [Kind::White, Kind::Ar1(0.1), Kind::Ar1(0.5)];
    let hidden: [Option<(Effect, &str, &[f64])>; 5] = [
        None,
        Some((Effect::JointOffset, "r_hip_roll", &[0.05])),
        Some((Effect::SensorGain, NOWHERE, &[0.2, 0.2])),
        Some((Effect::Payload, "body_link", &[0.3, 0.0, 0.0, 0.03])),
        Some((Effect::TimeDelay, NOWHERE, &[0.05])),
    ];
    let mut cases = Vec::new();
    for hidden in hidden {
        for tick in [0.0, TICK] {
            for kind in kinds {
                for (hertz, amplitude) in [(0.7, 0.15), (0.2, 0.3)] {
                    for stated in [true, false] {
                        let swing = Swing {
                            tick,
                            ..Swing::new(hertz, amplitude, 20.0)
                        };
                        cases.push(Case {
                            platform: Platform::Op2,
                            hidden,
                            swing,
                            noise: Noise {
                                kind,
                                std: [5e-4; 2],
                                visit_std: 0.0,
                            },
                            stated,
                        });
                    }
                }
            }
        }
    }
    cases
}

/// The verdict and what is named, as one word each.
fn said(diagnosis: &Diagnosis) -> String {
    let named: Vec<String> = diagnosis
        .steps
        .iter()
        .map(|step| format!("{}:{}", step.effect, step.target))
        .collect();
    let verdict = format!("{:?}", diagnosis.verdict).to_lowercase();
    match diagnosis.verdict {
        Verdict::None => verdict,
        _ => format!("{verdict} {}", named.join(" ")),
    }
}

/// The explanations that a log leaves, each as its effects with their targets.
fn explanations(diagnosis: &Diagnosis) -> BTreeSet<Vec<String>> {
    let steps = diagnosis.steps.iter();
    let label = |step: &diagnose::Step| match step.target.as_str() {
        "-" => step.effect.to_string(),
        target => format!("{}:{target}", step.effect),
    };
    let named: Vec<String> = steps.map(label).collect();
    let all = diagnosis.indistinguishable.iter().cloned().chain([named]);
    all.map(|mut effects| {
        effects.sort();
        effects
    })
    .collect()
}

/// Whether all diagnoses have one verdict, and one explanation in common.
fn agree(all: &[Diagnosis]) -> bool {
    let common = all.iter().map(explanations);
    let common = common.reduce(|a, b| a.intersection(&b).cloned().collect());
    let one = all
        .windows(2)
        .all(|pair| pair[0].verdict == pair[1].verdict);
    one && common.is_some_and(|common| !common.is_empty())
}

impl StudyMotion {
    /// Draws and diagnoses every recording at every rate; writes the table.
    ///
    /// # Errors
    /// A log that cannot be diagnosed; a file that cannot be written.
    pub fn run(&self, root: &Path) -> Result<(), Box<dyn Error>> {
        let only = self.only.as_ref();
        let only = only.map_or(String::new(), |only| format!(" --only \"{only}\""));
        let mut text = format!(
            "# Motion\n\n\
             Recordings of 20 s with noise of 0.5 mm, each looked at by `diagnose --prior tight` at \
             100, 50, 20 and 10 Hz. The same is said at all rates where the verdict is the same \
             and one explanation, every effect with its target, is among those that each rate \
             leaves. Intervals are the 95 % ones of the hidden effect's sizes, at all rates. \
             `cargo xtask study-motion --logs {} --seed {}{only}` counts the same logs again.\n\n\
             | recording | a verdict but none at 100, 50, 20, 10 Hz | the same at all rates | \
             intervals hold |\n\
             |---|---|---|---|\n",
            self.logs, self.seed
        );
        let (mut recordings, mut agreeing) = (0, 0);
        for case in cases() {
            let name = case.name();
            if self.only.as_ref().is_some_and(|only| !name.contains(only)) {
                continue;
            }
            let stage = Stage::new(case.platform);
            let robot = Arc::new(Robot::read(&stage.urdf)?);
            let mut alarms = [0; EVERY.len()];
            let mut same = 0;
            let mut counted = [0; 2];
            for seed in self.seed..self.seed + self.logs {
                let recording = case.record(&stage, seed)?;
                let mut all = Vec::new();
                for (k, nth) in EVERY.into_iter().enumerate() {
                    let found = case.diagnosed(&stage, &robot, &recording.every(nth))?;
                    alarms[k] += usize::from(found.verdict != Verdict::None);
                    let [known, holding] = intervals(&case, &found);
                    counted[0] += known;
                    counted[1] += holding;
                    if self.sentences {
                        eprintln!(
                            "  seed {seed}, {} Hz: {}; worth {}; {} share {:?}",
                            RATE / nth as f64,
                            said(&found),
                            found.samples.independent,
                            found.motion.used,
                            found.motion.share.map(|share| (share.value, share.std))
                        );
                    }
                    all.push(found);
                }
                same += usize::from(agree(&all));
                recordings += 1;
            }
            agreeing += same;
            let alarms: Vec<String> = alarms.iter().map(usize::to_string).collect();
            let line = format!(
                "| {name} | {} of {} | {same} of {1} | {} of {} |",
                alarms.join(", "),
                self.logs,
                counted[1],
                counted[0]
            );
            eprintln!("{line}");
            let _ = writeln!(text, "{line}");
        }
        let _ = writeln!(
            text,
            "\nOf {recordings} recordings, {agreeing} are answered alike at all four rates."
        );
        let own = root.join("docs/dev/study/motion.txt");
        fs::write(self.out.as_ref().unwrap_or(&own), text)?;
        Ok(())
    }
}

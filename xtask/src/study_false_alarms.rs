//! The study of false alarms: recordings of moving and standing robots on which nothing is
//! hidden, with noise of any kind; counted are verdicts that say something is missing, and the
//! intervals of `fit` that hold the truth.
//!
//! Every log has a robot, a motion, a rate, stamps, encoders and a noise of its own, drawn from
//! its seed: the same command counts the same logs again.

use std::collections::BTreeMap;
use std::error::Error;
use std::f64::consts::TAU;
use std::fmt::Write as _;
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex, PoisonError};

use clap::Args;
use rand::{RngExt as _, SeedableRng as _};
use rand_chacha::ChaCha8Rng;
use sesc_identify::diagnose::{self, Verdict, diagnose};
use sesc_identify::fit::{self, fit};
use sesc_identify::logs::Table;
use sesc_identify::observations::Zmp;
use sesc_identify::observations::{Plan, Wanted};
use sesc_identify::robot::Robot;
use sesc_model::Snapping;
use sesc_test_support::moving::Swing;
use sesc_test_support::recording::{Kind, Motion, Noise, Recording};
use sesc_test_support::stage::{Platform, Stage};

/// Rows of a log, unless it would be shorter or longer than [`SECONDS`].
const ROWS: f64 = 600.0;
/// Lengths of logs, s.
const SECONDS: [f64; 2] = [30.0, 120.0];
/// Rates of logs, Hz.
const RATES: [f64; 7] = [1.0, 5.0, 10.0, 20.0, 50.0, 100.0, 200.0];
/// Rates of fast logs, Hz: they move for the shortest of [`SECONDS`], 30,000 rows at most.
const FAST_RATES: [f64; 2] = [500.0, 1000.0];
/// Rows of a stay, and how long one is in a fast log at least, s.
const STAY_ROWS: f64 = 5.0;
const FAST_STAY_S: f64 = 0.25;
/// Correlation times, s.
const TAUS: [f64; 2] = [0.05, 1.0];
/// 4096 ticks a turn, rad.
const TICK: f64 = TAU / 4096.0;
/// What is left over noise that is this many times as large as said is unexplained: the root of
/// `LEFTOVER_RATIO` of a diagnosis.
const CLEARLY_OFF: f64 = 1.0724;
/// ± this many deviations hold 95 %.
const OF_95: f64 = 1.959_964;

/// How many logs.
#[derive(Args)]
pub struct StudyFalseAlarms {
    /// Number of logs
    #[arg(long, default_value_t = 1000)]
    logs: u64,
    /// Number of fast logs, at 500 and 1000 Hz, in a table of their own
    #[arg(long, default_value_t = 60)]
    fast: u64,
    /// The first log's seed; each further one's is one more
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Fit, and diagnose nothing
    #[arg(long)]
    fits: bool,
    /// Print how far the ZMP is off over what is said of it, and fit and diagnose nothing
    #[arg(long)]
    zmp: bool,
    /// Logs in whose groups this stands alone
    #[arg(long, value_name = "WORD")]
    only: Option<String>,
    /// Where the tables go, instead of docs/study-false-alarms.md
    #[arg(long, value_name = "FILE")]
    out: Option<PathBuf>,
}

/// A log as its seed draws it.
struct Drawn {
    platform: Platform,
    moves: Option<Swing>,
    noise: Noise,
    rate: f64,
    /// How long a stay is held where the robot stands, s.
    hold: f64,
    stated: bool,
    random: ChaCha8Rng,
}

/// What was said of it.
struct Said {
    groups: [String; 3],
    /// Rate, motion and noise, and what the rows are found to be worth.
    drawn: String,
    /// What the diagnosis said; none where it was not asked.
    verdict: Option<Verdict>,
    sentence: String,
    /// Parameters, and those whose interval holds the truth; none where free masses have fewer
    /// independent rows than unknowns.
    intervals: Option<(usize, usize)>,
}

impl Drawn {
    /// The log of a seed; `fast` ones are those of the same seed at higher rates.
    fn of(seed: u64, fast: bool) -> Drawn {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let mut pick = |count: usize| (random.random::<f64>() * count as f64) as usize;
        let platform = [
            Platform::Op2,
            Platform::Op2,
            Platform::Op2,
            Platform::Plain,
            Platform::Skew,
        ][pick(5)];
        let rate = match (pick(RATES.len()), fast) {
            (k, false) => RATES[k],
            (k, true) => FAST_RATES[k % FAST_RATES.len()],
        };
        let (ticks, jitters) = (pick(2) == 1, pick(4) == 0);
        let (stands, stated) = (pick(3) == 0, pick(2) == 0);
        let kind = pick(4);
        let between = |[low, high]: [f64; 2], random: &mut ChaCha8Rng| -> f64 {
            low * (high / low).powf(random.random::<f64>())
        };
        let tau = between(TAUS, &mut random);
        let kind = match kind {
            0 => Kind::White,
            1 => Kind::Ar1(tau),
            2 => Kind::Smooth(0.5 * tau),
            _ => Kind::Sway(tau),
        };
        let std = between([2e-4, 5e-3], &mut random);
        let hertz = between([0.1, 0.7], &mut random).min(0.08 * rate);
        let seconds = (ROWS / rate).clamp(SECONDS[0], SECONDS[1]);
        let swing = Swing {
            tick: if ticks { TICK } else { 0.0 },
            jitter: if jitters { 0.3 } else { 0.0 },
            ..Swing::new(hertz, (0.1 / hertz).min(0.3), seconds)
        };
        Drawn {
            platform,
            moves: (!stands).then_some(swing),
            noise: Noise {
                kind,
                std: [std; 2],
                visit_std: 0.0,
            },
            hold: match fast {
                true => FAST_STAY_S,
                false => STAY_ROWS / rate.min(20.0),
            },
            rate: if stands && !fast {
                rate.min(20.0)
            } else {
                rate
            },
            stated,
            random,
        }
    }

    /// Independent readings of both axes that a moving log is worth; those of one that stands
    /// are enough.
    fn worth(&self) -> f64 {
        let Some(swing) = &self.moves else {
            return f64::INFINITY;
        };
        // ∫ ρ: τ of AR(1), 2 τ of AR(2), half of it is sway's.
        let lasts = match self.noise.kind {
            Kind::White => 0.0,
            Kind::Ar1(tau) | Kind::Sway(tau) => 2.0 * tau,
            Kind::Smooth(tau) => 4.0 * tau,
        };
        2.0 * swing.seconds / lasts.max(1.0 / self.rate)
    }

    /// How far the ZMP of the joints that were read is from the readings without their noise, over
    /// what is said of it, RMS, and the same of ZMP and noise together; of each axis of a log that
    /// moves and is differentiated.
    fn zmp_off(seed: u64) -> Result<Option<[[f64; 2]; 2]>, Box<dyn Error>> {
        let (mut drawn, mut quiet) = (Drawn::of(seed, false), Drawn::of(seed, false));
        let stage = Stage::new(drawn.platform);
        let model = Robot::read(&stage.urdf)?.model(stage.support, Snapping::default(), None)?;
        quiet.noise.std = [0.0; 2];
        let (recording, quiet) = (drawn.record(&stage), quiet.record(&stage));
        let (t, q) = (&recording.t, recording.q.concat());
        let log = (&t[..], &q[..], recording.joints.len());
        let motion = Plan::of(t, &q, log.2)
            .filter(|_| drawn.moves.is_some())
            .and_then(|plan| plan.motion(log, 0..t.len(), Wanted::All));
        let Some(motion) = motion else {
            return Ok(None);
        };
        let moved = Zmp::new(&model).moved(&q, &motion, 0..t.len(), &vec![[0.0; 2]; t.len()]);
        let cad = model.cad_params();
        let mean = |square: &dyn Fn(usize) -> f64| -> f64 {
            let known = (0..t.len()).filter(|k| motion.known[*k]);
            known.map(square).sum::<f64>() / t.len() as f64
        };
        Ok(Some([0, 1].map(|axis| {
            let off = mean(&|k| {
                let row = moved.rows.row(2 * k + axis).iter().zip(&cad);
                let zmp = row.map(|(a, b)| a * b).sum::<f64>() + moved.correction[k][axis];
                (quiet.cop[k][axis] - zmp).powi(2)
            });
            let said = mean(&|k| moved.std[k][axis].powi(2));
            let noise = mean(&|_| drawn.noise.std[axis].powi(2));
            [(off / said).sqrt(), ((off + noise) / (said + noise)).sqrt()]
        })))
    }

    fn groups(&self) -> [String; 3] {
        let noise = match self.noise.kind {
            Kind::White => "white noise",
            Kind::Ar1(_) => "AR(1)",
            Kind::Smooth(_) => "AR(2)",
            Kind::Sway(_) => "sway under white noise",
        };
        let moves = match &self.moves {
            Some(swing) if swing.tick > 0.0 => "moving, encoders in ticks",
            Some(_) => "moving, all digits",
            None => "standing, stays visited twice",
        };
        let known = match self.stated {
            true => "noise stated",
            false => "noise not stated",
        };
        [noise, moves, known].map(str::to_string)
    }

    fn record(&mut self, stage: &Stage) -> Recording {
        match &self.moves {
            Some(swing) => swing.record(
                stage,
                stage.world(),
                self.noise,
                self.rate,
                &mut self.random,
            ),
            None => {
                let stays = Motion::Stays {
                    postures: 50,
                    visits: 2,
                    hold: self.hold,
                };
                let world = stage.world();
                Recording::take(
                    stage,
                    &world,
                    stays,
                    self.noise,
                    self.rate,
                    &mut self.random,
                )
            }
        }
    }

    fn ask(mut self, fits: bool) -> Result<Said, Box<dyn Error>> {
        let stage = Stage::new(self.platform);
        let robot = Arc::new(Robot::read(&stage.urdf)?);
        let model = robot.model(stage.support, Snapping::default(), None)?;
        let recording = self.record(&stage);
        let log = || {
            let columns = recording.columns(true).into_iter();
            columns.fold(Table::new("recording"), |table, (name, values)| {
                table.numbers(&name, values)
            })
        };
        let noise = self.stated.then_some(self.noise.std[0]);
        let mut request = diagnose::Request::new(Arc::clone(&robot), log());
        request.support = Some(stage.support.into());
        request.noise = noise;
        request.prior = "tight".into();
        let diagnosis = (!fits).then(|| diagnose(&request, &mut ())).transpose()?;
        let diagnosis = diagnosis.map(|report| report.diagnosis);
        let mut request = fit::Request::default();
        request.robot = Some(robot);
        request.logs = vec![log().into()];
        request.support = Some(stage.support.into());
        request.noise = noise;
        request.prior = "free".into();
        let found = fit(&request, &mut ())?.identification;
        let truth = model.cad_params();
        let known = found.parameters.iter().zip(&truth);
        let known = known.filter_map(|(p, truth)| Some((p.value - truth).abs() <= OF_95 * p.std?));
        let known: Vec<bool> = known.collect();
        let enough = 2.0 * self.worth() > 3.0 * truth.len() as f64;
        let holding = known.iter().filter(|holds| **holds).count();
        let moves = self.moves.as_ref().map_or("standing".to_string(), |swing| {
            format!("{:.2} Hz for {:.0} s", swing.hertz, swing.seconds)
        });
        let drawn = format!(
            "{} rows/s, {moves}, {:.2} mm {:?}, {}",
            self.rate,
            1e3 * self.noise.std[0],
            self.noise.kind,
            found.samples.sentence()
        );
        Ok(Said {
            groups: self.groups(),
            drawn,
            verdict: diagnosis.as_ref().map(|found| found.verdict),
            sentence: diagnosis.map_or_else(String::new, |found| found.sentence),
            intervals: enough.then_some((known.len(), holding)),
        })
    }
}

impl Said {
    fn alarms(&self) -> bool {
        self.verdict.is_some_and(|verdict| verdict != Verdict::None)
    }

    /// Print what is worth a look of the log of a seed.
    fn tell(&self, seed: u64) {
        let Said { groups, drawn, .. } = self;
        if self.alarms() {
            let [noise, moves, known] = groups;
            eprintln!(
                "seed {seed}: {:?} ({noise}, {moves}, {known}; {drawn}) {}",
                self.verdict, self.sentence
            );
        }
        if let Some((all, hold)) = self.intervals
            && 10 * hold < 8 * all
        {
            eprintln!("seed {seed}: {hold} of {all} intervals hold ({groups:?}; {drawn})");
        }
    }
}

impl StudyFalseAlarms {
    /// Whether this log is counted.
    fn asks(&self, drawn: &Drawn) -> bool {
        let only = self.only.as_deref();
        only.is_none_or(|word| drawn.groups().iter().any(|group| group.contains(word)))
    }

    /// What gives the same tables again.
    fn command(&self) -> String {
        let mut command = format!(
            "cargo xtask study-false-alarms --logs {} --fast {} --seed {}",
            self.logs, self.fast, self.seed
        );
        if self.fits {
            command += " --fits";
        }
        if let Some(word) = &self.only {
            let _ = write!(command, " --only \"{word}\"");
        }
        command
    }

    /// Prints how far the ZMP is off over what is said of it.
    fn print_zmp(&self) -> Result<(), Box<dyn Error>> {
        let (mut logs, mut beyond) = (0, 0);
        let mut all = [Vec::new(), Vec::new()];
        for seed in
            (self.seed..self.seed + self.logs).filter(|seed| self.asks(&Drawn::of(*seed, false)))
        {
            if let Some(axes) = Drawn::zmp_off(seed)? {
                logs += 1;
                beyond += usize::from(axes.iter().any(|[_, whole]| *whole > CLEARLY_OFF));
                axes.iter()
                    .flatten()
                    .zip([0, 1, 0, 1])
                    .for_each(|(off, k)| all[k].push(*off));
            }
        }
        println!("{logs} logs, on each axis; said is 1:");
        for (name, own) in ["ZMP", "ZMP and noise"].into_iter().zip(&mut all) {
            own.sort_by(f64::total_cmp);
            let part = |part: f64| {
                own.get((part * own.len() as f64) as usize)
                    .unwrap_or(&f64::NAN)
            };
            println!(
                "{name}: 2 % are below {:.2}, half below {:.2}, 98 % below {:.2}",
                part(0.02),
                part(0.5),
                part(0.98)
            );
        }
        println!("ZMP and noise are beyond {CLEARLY_OFF} in {beyond} of {logs} logs");
        Ok(())
    }

    /// Draws, diagnoses and fits every log; writes the tables.
    ///
    /// # Errors
    /// A log that cannot be read; a file that cannot be written.
    pub fn run(&self, root: &Path) -> Result<(), Box<dyn Error>> {
        if self.zmp {
            return self.print_zmp();
        }
        let (slow, fast) = (
            self.ask_all(self.logs, false)?,
            self.ask_all(self.fast, true)?,
        );
        let mut text = format!(
            "# False alarms\n\n\
             Recordings of the OP2, a plain and a skewed humanoid on which nothing is hidden: moving \
             at 0.1 to 0.7 Hz, for 30 to 120 s, read at 1 to 200 Hz, or standing in 50 postures that are visited \
             twice; encoders in all digits or in 4096 ticks a turn, stamps even or not; noise of \
             0.2 to 5 mm that is white or lasts 0.05 to 1 s. Counted are verdicts of `diagnose \
             --prior tight` that are not `none`, and 95 % intervals of `fit --prior free` that hold \
             the truth, where a log is worth 1.5 times as many readings as there are parameters. \
             `{}` counts the same logs again.\n\n{}\n\
             ## At 500 and 1000 Hz\n\n\
             The same kinds of logs, of 30 s where the robot moves and of 100 stays of {FAST_STAY_S} s \
             where it stands.\n\n{}",
            self.command(),
            table(&slow),
            table(&fast)
        );
        text.truncate(text.trim_end().len());
        text.push('\n');
        eprintln!("{text}");
        let own = root.join("docs/study-false-alarms.md");
        fs::write(self.out.as_ref().unwrap_or(&own), text)?;
        Ok(())
    }

    /// What is said of so many logs.
    fn ask_all(&self, logs: u64, fast: bool) -> Result<Vec<Said>, Box<dyn Error>> {
        let (next, all) = (AtomicU64::new(0), Mutex::new(BTreeMap::new()));
        let threads = std::thread::available_parallelism().map_or(1, usize::from);
        std::thread::scope(|scope| {
            for _ in 0..threads {
                scope.spawn(|| {
                    loop {
                        let k = next.fetch_add(1, Ordering::Relaxed);
                        if k >= logs {
                            return;
                        }
                        let drawn = Drawn::of(self.seed + k, fast);
                        if !self.asks(&drawn) {
                            continue;
                        }
                        let said = drawn.ask(self.fits).map_err(|error| error.to_string());
                        if let Ok(said) = &said {
                            said.tell(self.seed + k);
                        }
                        if k % 50 == 49 {
                            eprintln!("{} of {logs}", k + 1);
                        }
                        let mut all = all.lock().unwrap_or_else(PoisonError::into_inner);
                        all.insert(k, said);
                    }
                });
            }
        });
        let all = all.into_inner().unwrap_or_else(PoisonError::into_inner);
        Ok(all.into_values().collect::<Result<_, _>>()?)
    }
}

/// A row for all logs and for each group.
fn table(all: &[Said]) -> String {
    let mut text = "| logs | a verdict but none | intervals hold |\n|---|---|---|\n".to_string();
    let mut rows: Vec<(&str, Vec<&Said>)> = vec![("all", all.iter().collect())];
    for group in 0..3 {
        let mut own: BTreeMap<&str, Vec<&Said>> = BTreeMap::new();
        for said in all {
            own.entry(&said.groups[group]).or_default().push(said);
        }
        rows.extend(own);
    }
    for (name, said) in rows {
        let alarms = said.iter().filter(|said| said.alarms());
        let asked = said.iter().filter(|said| said.verdict.is_some());
        let intervals = said.iter().filter_map(|said| said.intervals);
        let (all, hold) = intervals.fold((0, 0), |sum, own| (sum.0 + own.0, sum.1 + own.1));
        let _ = writeln!(
            text,
            "| {name} | {} of {} | {:.1} % of {all} |",
            alarms.count(),
            asked.count(),
            100.0 * hold as f64 / all.max(1) as f64
        );
    }
    text
}

//! Recordings of moving and standing robots on which nothing is hidden, with noise of any kind:
//! verdicts that say something is missing, and intervals of `fit` that hold the truth.
//!
//! Every log has a robot, a motion, a rate, stamps, encoders and a noise of its own, drawn from
//! its seed.

use std::f64::consts::TAU;

use rand::{RngExt as _, SeedableRng as _};
use rand_chacha::ChaCha8Rng;
use sesc_identify::diagnose::Verdict;
use sesc_model::Snapping;
use sesc_test_support::examine::{Failure, diagnosed, fitted, intervals, log, robot};
use sesc_test_support::moving::Swing;
use sesc_test_support::recording::{Kind, Motion, Noise, Recording};
use sesc_test_support::stage::{Platform, Stage};

use super::{Answer, Asked, Case, Cell, Plan};

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

impl Drawn {
    /// The log of a seed; `fast` ones are those of the same seed at higher rates.
    fn new(seed: u64, fast: bool) -> Drawn {
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
            noise: Noise::new(kind, std),
            hold: if fast {
                FAST_STAY_S
            } else {
                STAY_ROWS / rate.min(20.0)
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
        let known = ["noise not stated", "noise stated"][usize::from(self.stated)];
        [noise, moves, known].map(str::to_string)
    }

    fn record(&mut self, stage: &Stage) -> Recording {
        let random = &mut self.random;
        match &self.moves {
            Some(swing) => swing.record(stage, stage.world(), self.noise, self.rate, random),
            None => {
                let stays = Motion::Stays {
                    postures: 50,
                    visits: 2,
                    hold: self.hold,
                };
                let world = stage.world();
                Recording::take(stage, &world, stays, self.noise, self.rate, random)
            }
        }
    }

    fn ask(&mut self, seed: u64) -> Result<Answer, Failure> {
        let stage = Stage::new(self.platform);
        let (robot, on) = (robot(&stage)?, stage.support);
        let truth = robot.model(on, Snapping::default(), None)?.cad_params();
        let log = log(&self.record(&stage), true);
        let noise = self.stated.then_some(self.noise.std[0]);
        let diagnosis = diagnosed(&robot, on, log.clone(), noise)?;
        let found = fitted(&robot, on, log, noise, "free")?;
        let (hold, all) = intervals(&found, &truth);
        let enough = 2.0 * self.worth() > 3.0 * truth.len() as f64;
        let alarm = diagnosis.verdict != Verdict::None;
        let note = format!(
            "seed {seed}: {} rows/s, {:.2} mm {}, {}, {hold} of {all} intervals hold; {:?}: {}",
            self.rate,
            1e3 * self.noise.std[0],
            self.noise.kind,
            self.groups().join(", "),
            diagnosis.verdict,
            diagnosis.sentence
        );
        Ok(Answer {
            cells: vec![
                ("a verdict but none", Cell::is(alarm)),
                (
                    "intervals hold",
                    Cell::Share(hold * usize::from(enough), all * usize::from(enough)),
                ),
            ],
            note: (alarm || enough && 10 * hold < 8 * all).then_some(note),
        })
    }
}

pub(super) fn plan<'a>(asked: &'a Asked<'_>) -> Plan<'a> {
    drawn(asked, false)
}

/// The same at the rates of fast logs.
pub(super) fn fast_plan<'a>(asked: &'a Asked<'_>) -> Plan<'a> {
    drawn(asked, true)
}

fn drawn<'a>(asked: &'a Asked<'_>, fast: bool) -> Plan<'a> {
    let cases = asked.seeds().map(|seed| {
        let groups = Drawn::new(seed, fast).groups();
        let rows = (0..).zip(std::iter::once("all".to_owned()).chain(groups));
        Case::new(rows.collect(), move || Drawn::new(seed, fast).ask(seed))
    });
    Plan {
        about: if fast {
            "The logs of `false-alarms` at 500 and 1000 Hz, of 30 s where the robot moves and of 100 \
             stays of 0.25 s where it stands."
        } else {
            "Recordings of the OP2, a plain and a skewed humanoid on which nothing is hidden: moving at \
             0.1 to 0.7 Hz, for 30 to 120 s, read at 1 to 200 Hz, or standing in 50 postures that are \
             visited twice; encoders in all digits or in 4096 ticks a turn, stamps even or not; noise \
             of 0.2 to 5 mm that is white or lasts 0.05 to 1 s. Counted are verdicts of `diagnose \
             --prior tight` that are not `none`, and 95 % intervals of `fit --prior free` that hold \
             the truth, where a log is worth 1.5 times as many readings as there are parameters."
        },
        cases: cases.collect(),
    }
}

//! One question to the diagnoser: what is hidden, on which robot, in which
//! postures.

use rand::seq::IndexedRandom as _;
use rand::{RngExt as _, SeedableRng as _};
use rand_chacha::ChaCha8Rng;
use sesc_reference::Error;

use crate::hidden::{ALL, Effect, Hidden, hide_all};
use crate::log::{Log, READINGS, Style};
use crate::poses::Poses;
use crate::sizes::{self, INVISIBLE, VISIBLE};
use crate::stage::{Platform, Postures, Stage};

/// What CAD masses are trusted to: 0.2 % of mass, as much of the CoM's distance.
const TRUSTED: f64 = 0.002;

/// What is asked.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Question {
    /// Nothing is hidden.
    Nothing,
    /// So many effects of the library, each of them visible.
    Library(usize),
    /// Something outside the library.
    Outside,
    /// A fault that these postures cannot show.
    Invisible,
    /// Masses that differ within what CAD is trusted to.
    Absorbed,
}

/// A question with its truth and its log.
pub struct Trial {
    /// What is asked.
    pub question: Question,
    /// Robot and sole.
    pub stage: Stage,
    /// Kind and number of postures.
    pub postures: Postures,
    /// What is wrong.
    pub hidden: Vec<Hidden>,
    /// How visible that is: χ² of its readings.
    pub chi2: f64,
    /// What the diagnoser sees.
    pub log: Log,
    /// Readings without noise of the postures put aside, m.
    pub aside: Vec<[f64; 2]>,
    /// Seed that makes it again.
    pub seed: u64,
}

/// What a study draws from.
#[derive(Debug, Clone)]
pub struct Choice {
    /// Robots to draw from.
    pub platforms: Vec<Platform>,
    /// Only logs in which this is hidden.
    pub only: Option<Effect>,
    /// Whether only the library's effects of the body are drawn.
    pub body: bool,
    /// Logs of 1000 postures, too.
    pub long: bool,
    /// Share of the joints that stand still in a log.
    pub held: f64,
}

impl Choice {
    /// Short logs of one robot.
    pub fn on(platform: Platform) -> Choice {
        Choice {
            platforms: vec![platform],
            only: None,
            body: false,
            long: false,
            held: 0.0,
        }
    }
}

impl Trial {
    /// Draws; the same for the same seed.
    pub fn draw(question: Question, choice: &Choice, seed: u64) -> Trial {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        loop {
            let platform = choice.platforms.choose(&mut random).copied();
            let mut stage = Stage::new(platform.unwrap_or(Platform::Op2));
            if choice.held > 0.0 {
                stage = stage.holding(choice.held, &mut random);
            }
            let effects = effects(question, choice, &mut random);
            // Many targets of some effects cannot be seen: look for one that can.
            for _ in 0..50 {
                let postures = postures(&effects, choice, &mut random);
                let trial = attempt(question, &stage, &effects, postures, seed, &mut random);
                if let Some(trial) = trial {
                    return trial;
                }
            }
        }
    }
}

impl Trial {
    /// A given truth on 100 balanced postures of the first platform.
    ///
    /// # Errors
    /// What cannot be hidden there.
    pub fn of(hidden: Vec<Hidden>, choice: &Choice, seed: u64) -> Result<Trial, Error> {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let stage = Stage::new(choice.platforms.first().copied().unwrap_or(Platform::Op2));
        let postures = Postures::Bench(100);
        let poses = Poses::draw(&stage, postures, false, &mut random);
        let outside = hidden.iter().any(|hidden| hidden.effect.is_outside());
        let question = match hidden.len() {
            0 => Question::Nothing,
            _ if outside => Question::Outside,
            count => Question::Library(count),
        };
        Trial::take(
            (question, seed),
            &stage,
            (postures, &poses),
            hidden,
            Style::default(),
            &mut random,
        )
    }

    /// What is hidden, with sizes.
    pub fn sizes(&self) -> String {
        let size = |hidden: &Hidden| {
            let values: Vec<String> = hidden.values.iter().map(|v| format!("{v:.3e}")).collect();
            format!("{}({})", hidden.label(), values.join(" "))
        };
        let all: Vec<String> = self.hidden.iter().map(size).collect();
        match all.is_empty() {
            true => "nothing".to_owned(),
            false => all.join(" + "),
        }
    }

    /// Takes the log.
    fn take(
        (question, seed): (Question, u64),
        stage: &Stage,
        (postures, poses): (Postures, &Poses),
        hidden: Vec<Hidden>,
        style: Style,
        random: &mut ChaCha8Rng,
    ) -> Result<Trial, Error> {
        let world = hide_all(stage.world(), &hidden)?;
        let log = Log::take(stage, &world, poses, style, random);
        // Whoever predicts is not asked for outliers.
        let lasting = hidden
            .iter()
            .filter(|hidden| hidden.effect != Effect::CopOutliers);
        let lasting: Vec<Hidden> = lasting.cloned().collect();
        Ok(Trial {
            question,
            stage: stage.clone(),
            postures,
            chi2: sizes::chi2(stage, &hidden, &poses.track, sigma(stage)),
            aside: poses.read_aside(&hide_all(stage.world(), &lasting)?),
            hidden,
            log,
            seed,
        })
    }
}

/// Standard deviation of a mean reading, m.
fn sigma(stage: &Stage) -> f64 {
    stage.reading_std() / (READINGS as f64).sqrt()
}

fn effects(question: Question, choice: &Choice, random: &mut ChaCha8Rng) -> Vec<Effect> {
    let mut pick = |from: &[Effect]| from.choose(random).copied();
    // A log in degrees is refused or warned of before anybody is asked.
    let mut common = Effect::library();
    common.retain(|effect| *effect != Effect::Units);
    common.retain(|effect| !choice.body || Effect::BODY.contains(effect));
    let mut effects: Vec<Effect> = match question {
        Question::Nothing => Vec::new(),
        Question::Library(1) => choice.only.or_else(|| pick(&common)).into_iter().collect(),
        // A faulty cell, a motion and a whole set of masses come alone.
        Question::Library(count) => {
            let alone = |effect: &Effect| {
                effect.needs_cells()
                    || matches!(effect, Effect::TimeDelay | Effect::MassDistribution)
            };
            let together = common.iter().copied().filter(|effect| !alone(effect));
            let together: Vec<Effect> = together.collect();
            (0..count).filter_map(|_| pick(&together)).collect()
        }
        Question::Outside => {
            let only = choice.only.filter(|effect| effect.is_outside());
            let drawn = only.or_else(|| pick(&Effect::outside()));
            drawn.into_iter().collect()
        }
        Question::Invisible => vec![Effect::JointOffset],
        Question::Absorbed => vec![Effect::MassDistribution],
    };
    effects.sort_unstable();
    effects
}

fn postures(effects: &[Effect], choice: &Choice, random: &mut ChaCha8Rng) -> Postures {
    if effects.contains(&Effect::Units) {
        return Postures::Bench(100);
    }
    if effects.contains(&Effect::TimeDelay) {
        return Postures::Motion(if random.random_bool(0.5) { 100 } else { 200 });
    }
    let beyond = !effects.iter().any(|effect| effect.needs_cells());
    match random.random_range(0..100) {
        0..20 => Postures::Bench(38),
        20..65 => Postures::Bench(100),
        65..88 => Postures::Bench(200),
        88..94 if choice.long && beyond => Postures::Wide(1000),
        94..97 if beyond => Postures::Motion(100),
        _ => Postures::Bench(100),
    }
}

/// One attempt; none where what was drawn cannot be seen, or is seen where it
/// should not.
fn attempt(
    question: Question,
    stage: &Stage,
    effects: &[Effect],
    postures: Postures,
    seed: u64,
    random: &mut ChaCha8Rng,
) -> Option<Trial> {
    let degrees = effects.contains(&Effect::Units);
    let poses = Poses::draw(stage, postures, degrees, random);
    let track = &poses.track;
    let sigma = sigma(stage);
    let mut hidden = Vec::new();
    for &effect in effects {
        let large = sizes::large(effect, stage, random);
        hidden.push(match question {
            Question::Invisible => large,
            Question::Absorbed => large.with(vec![TRUSTED]),
            _ => sizes::visible(large, stage, track, sigma, random)?,
        });
    }
    let chi2 = sizes::chi2(stage, &hidden, track, sigma);
    let as_asked = match question {
        Question::Invisible => chi2 < INVISIBLE,
        Question::Library(_) | Question::Outside => chi2 > VISIBLE && distinct(&hidden),
        Question::Nothing | Question::Absorbed => true,
    };
    if !as_asked {
        return None;
    }
    let cells = effects.iter().any(|effect| effect.needs_cells());
    // Cells cannot pull: they are read where the CoP lies between them.
    let balanced = matches!(postures, Postures::Bench(_));
    let style = Style {
        cells: balanced && random.random_bool(if cells { 0.5 } else { 0.1 }),
        // Ticks are parts of a turn in radians.
        ticks: random.random_bool(0.25) && !degrees,
        repeats: postures.count() <= 38 && random.random_bool(0.2),
    };
    Trial::take(
        (question, seed),
        stage,
        (postures, &poses),
        hidden,
        style,
        random,
    )
    .ok()
}

/// No two of them on the same thing in the same way, nor on the same plug.
fn distinct(hidden: &[Hidden]) -> bool {
    let wired = |effect| matches!(effect, Effect::JointSign | Effect::JointSwap);
    let alike = |one: &Hidden, other: &Hidden| {
        one.effect == other.effect || (wired(one.effect) && wired(other.effect))
    };
    let meet = |one: &Hidden, other: &Hidden| {
        let shared = one
            .target
            .split(',')
            .any(|end| other.target.split(',').any(|e| e == end));
        shared || one.target == ALL || other.target == ALL
    };
    let pairs = hidden
        .iter()
        .enumerate()
        .flat_map(|(i, one)| hidden[..i].iter().map(move |other| (one, other)));
    pairs
        .into_iter()
        .all(|(one, other)| !(alike(one, other) && meet(one, other)))
}

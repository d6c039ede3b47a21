//! One recording at several sampling rates, with and without something hidden, with encoders
//! that write all digits or ticks.
//!
//! Every rate must give the verdict of the fastest, and one explanation must be among those
//! that each rate cannot tell apart; where nothing is hidden, the verdict is `none`.

use std::collections::BTreeSet;
use std::f64::consts::TAU;

use rand::SeedableRng as _;
use rand_chacha::ChaCha8Rng;
use sesc_identify::diagnose::{Diagnosis, Step, Verdict};
use sesc_test_support::examine::{Failure, OF_95, diagnosed, log, robot};
use sesc_test_support::hidden::{Effect, Hidden, NOWHERE, hide_all};
use sesc_test_support::moving::Swing;
use sesc_test_support::recording::{Kind, Noise};
use sesc_test_support::stage::{Platform, Stage};

use super::{Answer, Asked, Case, Cell, Plan};

/// Recordings are made at this rate, Hz.
const RATE: f64 = 100.0;
/// One in so many rows: 100, 50, 20 and 10 Hz.
const EVERY: [usize; 4] = [1, 2, 5, 10];
/// 4096 ticks a turn, rad.
const TICK: f64 = TAU / 4096.0;
/// Noise of a reading, m.
const NOISE_M: f64 = 5e-4;

/// An effect, its target and its values as the virtual robot takes them, and the parameters of
/// the explanation that estimate them.
type Known = (
    Effect,
    &'static str,
    &'static [f64],
    &'static [(&'static str, f64)],
);
const HIDDEN: [Known; 4] = [
    (
        Effect::JointOffset,
        "r_hip_roll",
        &[0.05],
        &[("offset_rad", 0.05)],
    ),
    (
        Effect::SensorGain,
        NOWHERE,
        &[0.2, 0.2],
        &[("gain_x", 1.2), ("gain_y", 1.2)],
    ),
    (
        Effect::Payload,
        "body_link",
        &[0.3, 0.0, 0.0, 0.03],
        &[("mass_kg", 0.3)],
    ),
    (Effect::TimeDelay, NOWHERE, &[0.05], &[("delay_s", 0.05)]),
];

/// How many of the hidden effect's parameters have intervals that hold the truth, of how many.
fn intervals((effect, target, _, truth): Known, found: &Diagnosis) -> (usize, usize) {
    let is =
        |step: &&Step| step.effect == effect.name() && (target == NOWHERE || step.target == target);
    let Some(step) = found.steps.iter().find(is) else {
        return (0, 0);
    };
    let off: Vec<f64> = truth
        .iter()
        .filter_map(|(name, truth)| {
            let found = step.parameters.get(*name)?;
            Some((found.value - truth) / found.std)
        })
        .collect();
    (
        off.iter().filter(|off| off.abs() <= OF_95).count(),
        off.len(),
    )
}

/// The explanations that a log leaves, each as its effects with their targets.
fn explanations(diagnosis: &Diagnosis) -> BTreeSet<Vec<String>> {
    let label = |step: &Step| match step.target.as_str() {
        "-" => step.effect.to_string(),
        target => format!("{}:{target}", step.effect),
    };
    let named: Vec<String> = diagnosis.steps.iter().map(label).collect();
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

fn ask(
    known: Option<Known>,
    swing: Swing,
    noise: Noise,
    stated: bool,
    seed: u64,
) -> Result<Answer, Failure> {
    let stage = Stage::new(Platform::Op2);
    let robot = robot(&stage)?;
    let random = &mut ChaCha8Rng::seed_from_u64(seed);
    let hidden = known.map(|(effect, target, values, _)| Hidden {
        effect,
        target: target.to_string(),
        values: values.to_vec(),
        begins: 0.0,
        seed,
    });
    let world = hide_all(stage.world(), hidden.as_slice())?;
    let recording = swing.record(&stage, world, noise, RATE, random);
    let stated = stated.then_some(NOISE_M);
    let all = EVERY.map(|nth| {
        let log = log(&recording.every(nth), true);
        diagnosed(&robot, stage.support, log, stated)
    });
    let all: Vec<Diagnosis> = all.into_iter().collect::<Result<_, _>>()?;
    let rates = ["a verdict but none, 100 Hz", "50 Hz", "20 Hz", "10 Hz"].into_iter();
    let verdicts = all
        .iter()
        .map(|found| Cell::is(found.verdict != Verdict::None));
    let mut cells: Vec<(&str, Cell)> = rates.zip(verdicts).collect();
    let counted = all
        .iter()
        .filter_map(|found| Some(intervals(known?, found)))
        .fold((0, 0), |sum, own| (sum.0 + own.0, sum.1 + own.1));
    cells.push(("the same at all rates", Cell::is(agree(&all))));
    cells.push(("intervals hold", Cell::Share(counted.0, counted.1)));
    Ok(Answer { cells, note: None })
}

pub(super) fn plan<'a>(asked: &'a Asked<'_>) -> Plan<'a> {
    let mut cases = Vec::new();
    let mut number = 0;
    for known in std::iter::once(None).chain(HIDDEN.map(Some)) {
        for tick in [0.0, TICK] {
            for kind in [Kind::White, Kind::Ar1(0.1), Kind::Ar1(0.5)] {
                for (hertz, amplitude) in [(0.7, 0.15), (0.2, 0.3)] {
                    for stated in [true, false] {
                        let hidden = known.map_or("nothing hidden".into(), |(effect, on, ..)| {
                            format!("{}:{on}", effect.name())
                        });
                        let name = format!(
                            "{}, {hertz} Hz, {}, {kind}{}",
                            hidden.trim_end_matches(":-"),
                            if tick > 0.0 { "ticks" } else { "all digits" },
                            if stated { "" } else { ", noise not stated" }
                        );
                        let swing = Swing {
                            tick,
                            ..Swing::new(hertz, amplitude, 20.0)
                        };
                        let noise = Noise::new(kind, NOISE_M);
                        number += 1;
                        cases.extend(asked.seeds().map(|seed| {
                            let rows = vec![(number, name.clone()), (usize::MAX, "all".into())];
                            Case::new(rows, move || ask(known, swing, noise, stated, seed))
                        }));
                    }
                }
            }
        }
    }
    Plan {
        about: "Recordings of 20 s of the OP2 with noise of 0.5 mm, each looked at by `diagnose --prior \
                tight` at 100, 50, 20 and 10 Hz. The same is said at all rates where the verdict is \
                the same and one explanation, every effect with its target, is among those that each \
                rate leaves. Intervals are the 95 % ones of the hidden effect's sizes, at all rates.",
        cases,
    }
}

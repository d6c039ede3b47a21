//! Robots as they are bought (`tests/support/src/examine/bought.rs`), with and without a log of the
//! healthy robot; every fifth log hides nothing.

use sesc_test_support::examine::bought::{Found, examine};
use sesc_test_support::hidden::Effect;
use sesc_test_support::stage::Platform;
use sesc_test_support::trial::{Choice, Question, Trial};

use super::{Answer, Asked, Case, Cell, Plan};

const PLATFORMS: [Platform; 3] = [Platform::Op2, Platform::Skew, Platform::Plain];
/// What is hidden: faults that come to a robot, one at a time.
const EFFECTS: [Effect; 10] = [
    Effect::JointOffset,
    Effect::JointScale,
    Effect::Payload,
    Effect::JointCompliance,
    Effect::Backlash,
    Effect::SensorRotation,
    Effect::SensorOffset,
    Effect::SensorGain,
    Effect::GroundSlope,
    Effect::ExternalForce,
];

fn draw(i: usize, seed: u64) -> Trial {
    let choice = Choice {
        platforms: vec![PLATFORMS[i % PLATFORMS.len()]],
        only: Some(EFFECTS[i / PLATFORMS.len() % EFFECTS.len()]),
        body: false,
        long: false,
        held: 0.0,
    };
    let question = match i % 5 {
        4 => Question::Nothing,
        _ => Question::Library(1),
    };
    Trial::draw(question, &choice, seed + i as u64)
}

fn counted(found: &Found, sound: bool) -> Answer {
    let share = |holds: bool| Cell::of(!sound, holds);
    let absorbed = !found.listed && !found.beside && !found.wrong;
    let note = format!("{}: {} (CoM {:.3})", found.log, found.said, found.ratio);
    Answer {
        cells: vec![
            ("alone", share(found.alone)),
            ("listed", share(found.listed)),
            ("beside", share(found.beside)),
            ("wrong", share(found.wrong)),
            ("absorbed", share(absorbed)),
            ("silent", Cell::of(sound, !found.wrong && !found.beside)),
            ("file", Cell::is(found.agrees)),
            ("CoM", Cell::Median(found.ratio)),
        ],
        note: (found.wrong || found.beside || !found.agrees || !found.listed).then_some(note),
    }
}

pub(super) fn plan<'a>(asked: &'a Asked<'_>) -> Plan<'a> {
    let cases = (0..asked.logs as usize).flat_map(|k| {
        [false, true].map(|healthy| {
            let trial = draw(k, asked.seed);
            let sound = trial.hidden.is_empty();
            let group = usize::from(healthy);
            let name = ["without", "with a healthy log"][group];
            let mut rows = vec![(group, name.to_owned())];
            let effect = trial.hidden.first().map(|hidden| hidden.effect);
            if let Some(k) = effect.and_then(|own| EFFECTS.iter().position(|e| *e == own)) {
                let row = 10 + 100 * group + k;
                rows.push((row, format!("{name}: {}", EFFECTS[k].name())));
            }
            Case::new(rows, move || {
                Ok(counted(&examine(&trial, healthy, asked.folder)?, sound))
            })
        })
    });
    Plan {
        about: "Every link of the virtual robots is off CAD by 10 % of its mass and 5 mm; an effect of \
                the list is hidden, from barely visible to as large as they come, in every fifth log \
                none. Alone: the answer is what was hidden, masses aside; listed: it is the answer or of \
                the class; beside: it is in the answer with something that is not there; wrong: \
                something else is named and masses are not of the class; absorbed: the rest. Silent: \
                nothing but masses is named of a sound robot. File: `predict` with the \
                written model leaves of its own log what the diagnosis states, to 1 %, without the postures that \
                the diagnosis lists as left out (outliers, and where only the log knows on which side \
                of its dead band a joint rests). CoM: error of the written model over \
                CAD's on 200 new postures, median.",
        cases: cases.collect(),
    }
}

//! Recordings as labs have them (`tests/support/src/examine/labs.rs`), beside an expert's script.

use sesc_test_support::examine::labs::{Kept, Moves, Off};
use sesc_test_support::stage::{Platform, Stage};

use super::{Answer, Asked, Case, Cell, Plan};

fn kinds() -> Vec<Kept> {
    let mut all = Vec::new();
    for moves in [Moves::Bows, Moves::Squats, Moves::Sways] {
        for off in [Off::Nothing, Off::Masses, Off::Offset, Off::Box, Off::Clock] {
            for (markers, rate) in [(false, 100.0), (true, 100.0), (true, 10.0)] {
                all.push(Kept {
                    platform: Platform::Plain,
                    moves,
                    off,
                    markers,
                    rate,
                });
            }
        }
    }
    all
}

pub(super) fn plan<'a>(asked: &'a Asked<'_>) -> Plan<'a> {
    let cases = kinds().into_iter().enumerate().flat_map(|(k, kind)| {
        asked.seeds().map(move |seed| {
            let rows = vec![(k, kind.to_string()), (1000, "all".to_owned())];
            Case::new(rows, move || {
                let stage = Stage::new(kind.platform);
                let said = kind.ask(&stage, &kind.record(&stage, seed)?)?;
                let over = |own: f64| own / said.expert;
                let found = &said.diagnosis;
                let note = format!(
                    "seed {seed} {kind}: mm CAD {:.2} expert {:.2} fit {:.2} diagnose {:.2}, {} {:?}, \
                     noise {:.2} of gap {:.2}, worth {}; {}",
                    1e3 * said.cad,
                    1e3 * said.expert,
                    1e3 * said.fit,
                    1e3 * said.diagnosed,
                    found.verdict.name(),
                    found.indistinguishable.first(),
                    1e3 * found.noise,
                    1e3 * found.baseline.rmse,
                    found.samples.independent,
                    found.motion.sentence,
                );
                let worst = over(said.fit.max(said.diagnosed));
                Ok(Answer {
                    cells: vec![
            ("CAD", Cell::Median(over(said.cad))),
            ("fit", Cell::Median(over(said.fit))),
            ("diagnose", Cell::Median(over(said.diagnosed))),
            ("fit ≤ 1.1", Cell::is(over(said.fit) <= 1.1)),
            ("diagnose ≤ 1.1", Cell::is(over(said.diagnosed) <= 1.1)),
            ("above 1.3", Cell::is(worst > 1.3)),
            ("rates agree", Cell::of(said.agree.is_some(), said.agree == Some(true))),
            ("above 1.05 of CAD's", Cell::is(said.fit.max(said.diagnosed) > 1.05 * said.cad)),
                    ],
                    note: (worst > 1.1 || said.agree == Some(false)).then_some(note),
                })
            })
        })
    });
    Plan {
        about: "Recordings of a minute of a robot that bows, squats or sways, with noise of 3 mm that \
                lasts 0.5 s; masses as in CAD, or off by 10 % and 5 mm with an offset of readings of 10 \
                to 30 mm, a box, or a clock that is 60 ms late beside them. RMS of predictions of \
                another recording, over that of an expert's script: an offset, the ZMP of CAD and four \
                masses held loosely.",
        cases: cases.collect(),
    }
}

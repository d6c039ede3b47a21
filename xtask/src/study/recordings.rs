//! Rows in time with noise that lasts, nothing hidden: the intervals of `fit` that hold the
//! truth, and the diagnoses that say something.

use sesc_identify::diagnose::Verdict;
use sesc_test_support::examine::recordings::Kept;
use sesc_test_support::recording::{Kind, Motion, Noise};
use sesc_test_support::stage::{Platform, Stage};

use super::{Answer, Asked, Case, Cell, Plan};

/// The name of a kind in the table.
fn name(kind: &Kept) -> String {
    let motion = match kind.motion {
        Motion::Sines(seconds) => format!("sines {seconds:.0} s"),
        Motion::Stays {
            postures,
            visits,
            hold,
        } => format!("{postures} stays of {hold} s, {visits} visits"),
    };
    let mut name = format!(
        "{:?}, {motion}, {} Hz, {}",
        kind.platform, kind.rate, kind.noise.kind
    );
    if kind.noise.visit_std > 0.0 {
        name += &format!(", visits differ by {} mm", 1e3 * kind.noise.visit_std);
    }
    name += if kind.timed { "" } else { ", no t" };
    name + if kind.stated {
        ""
    } else {
        ", noise not stated"
    }
}

/// The kinds of log that are counted.
fn kinds() -> Vec<Kept> {
    let noise = |kind, visit_std| Noise {
        visit_std,
        ..Noise::new(kind, 2e-3)
    };
    let mut all = Vec::new();
    for platform in [Platform::Op2, Platform::Skew] {
        for rate in [100.0, 10.0] {
            for kind in [
                Kind::White,
                Kind::Ar1(0.1),
                Kind::Ar1(0.5),
                Kind::Ar1(1.0),
                Kind::Smooth(0.1),
                Kind::Sway(0.3),
            ] {
                all.extend([true, false].map(|stated| Kept {
                    platform,
                    motion: Motion::Sines(120.0),
                    noise: noise(kind, 0.0),
                    rate,
                    timed: true,
                    stated,
                }));
            }
        }
    }
    for kind in [Kind::White, Kind::Ar1(0.3)] {
        for visit_std in [0.0, 2e-3] {
            all.extend([true, false].map(|timed| Kept {
                platform: Platform::Op2,
                motion: Motion::Stays {
                    postures: 60,
                    visits: 2,
                    hold: 1.0,
                },
                noise: noise(kind, visit_std),
                rate: 20.0,
                timed,
                stated: false,
            }));
        }
    }
    all
}

pub(super) fn plan<'a>(asked: &'a Asked<'_>) -> Plan<'a> {
    let cases = kinds().into_iter().enumerate().flat_map(|(k, kind)| {
        asked.seeds().map(move |seed| {
            Case::new(vec![(k, name(&kind))], move || {
                let stage = Stage::new(kind.platform);
                let said = kind.ask(&stage, &kind.record(&stage, seed), true)?;
                let (rows, worth) = said.samples;
                Ok(Answer {
                    cells: vec![
                        ("rows", Cell::Median(rows as f64)),
                        ("worth", Cell::Median(worth as f64)),
                        (
                            "intervals hold",
                            Cell::Share(said.intervals.0, said.intervals.1),
                        ),
                        ("noise over truth", Cell::Median(said.noise)),
                        (
                            "a verdict but none",
                            Cell::is(said.verdict != Some(Verdict::None)),
                        ),
                    ],
                    note: None,
                })
            })
        })
    });
    Plan {
        about: "Rows in time of virtual robots on which nothing is hidden, with noise of 2 mm per axis \
                that lasts: the 95 % intervals of `fit --prior free` that hold the truth, and the \
                verdicts of `diagnose --prior tight`.",
        cases: cases.collect(),
    }
}

//! Effects that the list does not have (`tests/support/src/examine/unlisted.rs`), and sound robots.

use sesc_test_support::examine::unlisted::{Found, Kind, examine};
use sesc_test_support::stage::{Platform, Stage};

use super::{Answer, Asked, Case, Cell, Plan};

/// Robots, with the name of each.
const PLATFORMS: [(Platform, &str); 2] = [(Platform::Op2, "OP2"), (Platform::Plain, "30 joints")];

fn counted(found: &Found, kind: Option<Kind>) -> Answer {
    let hidden = kind.is_some();
    let in_table = kind.is_some_and(Kind::is_in_table);
    let right = found.listed && (found.form || !in_table);
    Answer {
        cells: vec![
            ("place", Cell::of(hidden, found.place)),
            ("in class", Cell::of(hidden, found.listed)),
            ("form", Cell::of(in_table, found.form)),
            ("CoP in goal", Cell::of(in_table, found.cop <= found.goal)),
            (
                "CoM in goal",
                Cell::of(in_table && !found.com.is_nan(), found.com <= found.goal),
            ),
            (
                "CoP",
                Cell::Median(if hidden { found.cop } else { f64::NAN }),
            ),
            (
                "CoM",
                Cell::Median(if hidden { found.com } else { f64::NAN }),
            ),
            ("CoM worse", Cell::of(true, found.worse)),
            ("silent", Cell::of(!hidden, found.silent)),
            ("seconds", Cell::Median(found.seconds)),
        ],
        note: (!right || found.worse).then(|| found.said.clone()),
    }
}

pub(super) fn plan<'a>(asked: &'a Asked<'_>) -> Plan<'a> {
    let kinds = Kind::ALL.map(Some).into_iter().chain([None]).enumerate();
    let cases = kinds.flat_map(|(k, kind)| {
        let of = move |(platform, robot): (Platform, &'static str)| {
            asked.seeds().map(move |seed| {
                // With the masses of CAD, and as bought with a healthy log, in turns.
                let is_bought = seed % 2 == 0;
                let masses = if is_bought { "as bought" } else { "as CAD" };
                let name = kind.map_or("nothing".to_owned(), |kind| format!("{kind:?}"));
                let group = match kind {
                    None => (2, "sound"),
                    Some(kind) if kind.is_in_table() => (0, "in the table"),
                    Some(_) => (1, "not in the table"),
                };
                let of_masses = format!("{}, masses {masses}", group.1);
                let rows = vec![
                    (2 * group.0 + usize::from(is_bought), of_masses),
                    (10 + k, format!("{name}, {robot}")),
                ];
                Case::new(rows, move || {
                    let stage = Stage::new(platform);
                    let found = examine(&stage, kind, is_bought, seed + 1000 * k as u64)?;
                    Ok(counted(&found, kind))
                })
            })
        };
        PLATFORMS.into_iter().flat_map(of)
    });
    Plan {
        about: "A function at a site is hidden in a virtual robot, of a chi2 from 100 to 20,000, in 120 \
                postures; masses as in CAD, or 10 % and 5 mm off beside a log of 200 postures of the \
                healthy robot. Place: the steps act where it is hidden and nowhere else; in class: an explanation of the class does; form: they have \
                its name, or one of the class has; gaps are of the written model over CAD's on 500 fresh \
                postures without noise, their goal is 6 %, or 2 √(k/chi2) where that is more, k unknowns. \
                Silent: nothing is named of a sound robot.",
        cases: cases.collect(),
    }
}

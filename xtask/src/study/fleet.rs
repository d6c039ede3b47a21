//! Fleets in which a batch of robots shares an offset, one drifts, one encoder is stuck, one
//! URDF is new, two logs are cut and one comes twice; and fleets in which nothing is hidden, of
//! which every shared effect and every change is a false alarm.

use std::collections::BTreeSet;
use std::path::Path;
use std::sync::Arc;

use sesc_identify::diagnose::Verdict;
use sesc_identify::fleet::summary::{ChangeKind, Summary, summary};
use sesc_identify::fleet::{Fleet as Found, Request, Row, groups, inputs, run};
use sesc_identify::health::Kind;
use sesc_identify::robot::Robot;
use sesc_test_support::fleet::{BATCH, DRIFT, Fleet, STUCK};

use super::{Answer, Asked, Case, Cell, Failure, Plan};

/// Size of a fleet, and of the batch that shares an offset.
const ROBOTS: usize = 60;
const DAYS: usize = 7;
const IN_BATCH: usize = 8;
/// One fleet with faults for so many sound ones.
const SOUND: u64 = 7;

fn look(fleet: &Fleet) -> Result<(Found, Summary), Failure> {
    let folder = tempfile::tempdir()?;
    let urdf = fleet.write(folder.path())?;
    let pattern = folder.path().join("logs/robot=*/day=*/*.csv");
    let by = ["robot".to_string(), "day".to_string()];
    let logs = inputs(&[pattern.display().to_string()], &by)?;
    let mut request = Request::new(Arc::new(Robot::read(Path::new(&urdf))?), groups(&logs));
    request.threads = Some(1);
    let found = run(&request, &mut ())?;
    let summary = summary(&found.rows, &found.names, None);
    Ok((found, summary))
}

/// Whether a row of the table names anything but what was hidden in its robot on that day.
fn names_more(row: &Row, fleet: &Fleet) -> bool {
    let is = |robot: usize| row.robot == Fleet::name(robot);
    let from = |(robot, day): (usize, usize)| {
        is(robot) && row.day.parse().is_ok_and(|own: usize| own >= day)
    };
    let is_stuck = fleet.stuck.is_some_and(is);
    let joint = if fleet.batch.iter().any(|robot| is(*robot)) {
        Some(BATCH.0)
    } else {
        fleet.drifts.is_some_and(from).then_some(DRIFT.0)
    };
    let is_cut = fleet
        .truncated
        .iter()
        .any(|(robot, day)| is(*robot) && row.day == day.to_string());
    let mut effects = row.effects.iter();
    effects.any(|found| Some(found.target.as_str()) != joint)
        || row
            .health
            .iter()
            .any(|found| !is_stuck || found.target != STUCK)
        || row.verdict == Some(Verdict::Unexplained)
        || row.error.is_some() != is_cut
}

/// What of the hidden faults is found, and what else is said.
fn with_faults(seed: u64) -> Result<Answer, Failure> {
    let fleet = Fleet::sound(ROBOTS, DAYS, seed).with_faults(IN_BATCH);
    let (found, summary) = look(&fleet)?;
    let name = Fleet::name;
    let batch: BTreeSet<String> = fleet.batch.iter().map(|robot| name(*robot)).collect();
    let own = summary.shared.iter().find(|s| s.target == BATCH.0);
    let in_batch = own.map_or(0, |s| {
        let robots = s.robots.iter();
        robots.filter(|robot| batch.contains(*robot)).count()
    });
    let in_groups = summary.shared.iter().map(|s| s.robots.len()).sum::<usize>();
    let is =
        |robot: &str, own: Option<(usize, usize)>| own.is_some_and(|(own, _)| name(own) == robot);
    let changes = || summary.changes.iter();
    let drifts: Vec<&str> = changes()
        .filter(|c| {
            is(&c.robot, fleet.drifts)
                && c.kind == ChangeKind::Effect
                && c.target.ends_with(DRIFT.0)
        })
        .map(|c| c.day.as_str())
        .collect();
    let urdfs = changes()
        .filter(|c| is(&c.robot, fleet.urdf) && c.kind == ChangeKind::Urdf)
        .count();
    let from = fleet.drifts.map(|(_, day)| day.to_string());
    let rows = found.rows.iter();
    let stuck: BTreeSet<&str> = rows
        .clone()
        .filter(|row| row.health.iter().any(|f| f.kind == Kind::EncoderStuck))
        .map(|row| row.robot.as_str())
        .collect();
    let stuck_robot = fleet.stuck.map(name);
    let mut known = batch;
    known.extend(stuck_robot.clone());
    let changed = [fleet.drifts, fleet.urdf].into_iter().flatten();
    known.extend(changed.map(|(robot, _)| name(robot)));
    known.extend(fleet.truncated.iter().map(|(robot, _)| name(*robot)));
    let first = summary.look_first.iter();
    let share = |count: usize, of: usize| Cell::Share(count, of);
    Ok(Answer {
        cells: vec![
            share(in_batch, fleet.batch.len()),
            share(in_groups - in_batch, in_groups),
            Cell::is(drifts.iter().eq(from.iter())),
            Cell::is(urdfs == 1),
            share(changes().count() - drifts.len() - urdfs, changes().count()),
            Cell::is(stuck.into_iter().eq(stuck_robot.as_deref())),
            share(found.failed.len(), fleet.truncated.len()),
            share(
                rows.filter(|row| names_more(row, &fleet)).count(),
                found.rows.len(),
            ),
            share(
                first.filter(|robot| !known.contains(*robot)).count(),
                summary.look_first.len(),
            ),
        ],
        note: None,
    })
}

/// What is said of a fleet in which nothing is hidden.
fn sound(seed: u64) -> Result<Answer, Failure> {
    let (found, summary) = look(&Fleet::sound(ROBOTS, DAYS, seed))?;
    let quiet = |row: &&Row| matches!(row.verdict, Some(Verdict::None | Verdict::Absorbed));
    let none = Cell::Share(0, 0);
    let named = found.rows.len() - found.rows.iter().filter(quiet).count();
    Ok(Answer {
        cells: vec![
            none,
            Cell::is(!summary.shared.is_empty()),
            none,
            none,
            Cell::is(!summary.changes.is_empty()),
            none,
            none,
            Cell::Share(named, found.rows.len()),
            Cell::Share(summary.look_first.len(), ROBOTS),
        ],
        note: None,
    })
}

pub(super) fn plan<'a>(asked: &'a Asked<'_>) -> Plan<'a> {
    let faulty = (0..asked.logs.div_ceil(SOUND)).map(|k| Case {
        rows: vec![(0, "with faults".to_owned())],
        ask: Box::new(move || with_faults(asked.seed + k)),
    });
    let quiet = asked.seeds().map(|seed| Case {
        rows: vec![(1, "nothing hidden".to_owned())],
        ask: Box::new(move || sound(1000 + seed)),
    });
    Plan {
        about: "Virtual OP2s, 60 robots, 7 days, 60 postures a day, 0.1 mm of noise on each. With faults: \
                eight robots share an offset of l_hip_roll (0.035 rad), one drifts in r_ank_pitch \
                (0.012 rad a day), one has a stuck encoder (r_knee), one another URDF from a day on, \
                two logs are cut in the middle of a row, one is delivered twice.",
        columns: &[
            "batch found",
            "others in shared effects",
            "drift on its day",
            "URDF told",
            "other changes",
            "stuck encoder",
            "cut logs",
            "rows that name something else",
            "others to look at",
        ],
        cases: faulty.chain(quiet).collect(),
    }
}

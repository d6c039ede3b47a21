//! Broken devices: how often each is recognised, by `diagnose` and `fit` and by its name and
//! target, how often another finding stands beside it, and how often healthy logs, with hidden
//! effects of every kind, have a finding.
//!
//! Standing logs are those of the study of effects; recordings are slow sines at 10 to 100 Hz
//! with white or lasting noise. Of stuck encoders it is counted, too, what a diagnosis finds
//! beside them: nothing else is hidden.

mod devices;
mod sheet;

use std::sync::Arc;

use sesc_identify::diagnose::{self, Verdict};
use sesc_identify::fit;
use sesc_identify::health::{self, Finding};
use sesc_identify::logs::{LogSource, Options, Readings};
use sesc_identify::robot::Robot;
use sesc_model::Snapping;
use sesc_test_support::stage::Platform;
use sesc_test_support::survey;
use sesc_test_support::trial::{Choice, Trial};

use super::{Answer, Asked, Case, Cell, Failure, Plan};
use devices::{Broken, DEVICES, Device};
use sheet::{RecordingKind, Sheet};

const ROBOTS: [(Platform, &str); 3] = [
    (Platform::Op2, "OP2"),
    (Platform::Skew, "Skew"),
    (Platform::Plain, "plain"),
];
const SOURCES: [(RecordingKind, &str); 2] = [
    (RecordingKind::Standing, "standing"),
    (RecordingKind::Moving, "moving"),
];
/// Share of the joints that stand still in some healthy logs.
const HELD: f64 = 1.0 / 3.0;
/// Healthy logs of each kind for one broken log of each kind.
const HEALTHY: u64 = 8;
/// Logs that are drawn for one in which a device has something to break.
const TRIES: usize = 60;
/// One in so many logs with a stuck encoder is diagnosed to the end.
const DIAGNOSED: u64 = 2;

/// Whether a healthy log has a finding.
fn healthy(sheet: Result<Sheet, Failure>, number: u64) -> Result<Answer, Failure> {
    let sheet = sheet?;
    let robot = Arc::new(Robot::read(&sheet.stage.urdf)?);
    let (log, support) = (sheet.log(), sheet.stage.support);
    let [diagnosed, looked_at] = looks(&robot, &log, support, None)?;
    let seen = [diagnosed, looked_at, fitted(&robot, &log, support, None)?];
    let any = seen.iter().any(|all| !all.is_empty());
    let found = seen.each_ref().map(|all| names(all));
    let note = format!("healthy log {number}: {found:?} ({})", sheet.about);
    Ok(Answer {
        cells: vec![Cell::Share(0, 0), Cell::is(any)],
        note: any.then_some(note),
    })
}

/// Whether the `number`th log that a device has something to break in has exactly the finding
/// that it should have.
fn broken(
    (device, what, kind): (Device, &str, &str),
    (source, platform): (RecordingKind, Platform),
    asked: &Asked<'_>,
) -> Result<Answer, Failure> {
    let (mut count, mut found, mut beside, mut named_beside) = (0, 0, 0, (0, 0));
    let (mut seed, mut tries, mut notes) = (asked.seed, 0, Vec::new());
    while count < asked.logs && tries < TRIES {
        seed += 1;
        let mut sheet = Sheet::draw(source, platform, seed, asked.folder)?;
        let Some(broken) = Broken::of(device, &mut sheet, seed) else {
            tries += 1;
            continue;
        };
        (count, tries) = (count + 1, 0);
        let robot = Arc::new(Robot::parse(&broken.urdf, "robot.urdf")?);
        let log = sheet.log();
        let (on, noise) = (&broken.support, broken.noise);
        // Overstated noise shows only in what a fit leaves.
        let seen = if device == Device::Overstated {
            vec![fitted(&robot, &log, on, noise)?]
        } else {
            looks(&robot, &log, on, noise)?.into()
        };
        let is = |f: &Finding| f.kind.name() == kind && broken.is(&f.target);
        let recognised = seen.iter().all(|all| all.iter().any(is));
        let more = seen.iter().flatten().any(|f| !is(f));
        found += usize::from(recognised);
        beside += usize::from(more);
        if !recognised || more {
            let seen: Vec<_> = seen.iter().map(|all| names(all)).collect();
            let about = &sheet.about;
            notes.push(format!(
                "{what} on {platform:?}, seed {seed}: {seen:?} ({about})"
            ));
        }
        if recognised && device == Device::Stuck && count % DIAGNOSED == 0 {
            let named = named(&robot, &log, &broken)?;
            named_beside = (
                named_beside.0 + usize::from(named.is_some()),
                named_beside.1 + 1,
            );
            notes.extend(named.map(|text| format!("beside a stuck encoder, seed {seed}: {text}")));
        }
    }
    let count = count as usize;
    Ok(Answer {
        cells: vec![
            Cell::Share(found, count),
            Cell::Share(beside, count),
            Cell::Share(named_beside.0, named_beside.1),
        ],
        note: (!notes.is_empty()).then(|| notes.join("\n")),
    })
}

pub(super) fn plan<'a>(asked: &'a Asked<'_>) -> Plan<'a> {
    let mut cases = Vec::new();
    for (row, held, how) in [(0, 0.0, ""), (1, HELD, ", a third of the joints still")] {
        let choice = Choice {
            held,
            ..survey::everything()
        };
        let count = HEALTHY * asked.logs;
        let questions = survey::questions(count as usize, &choice);
        for (k, question) in (0..count).zip(questions) {
            let (seed, choice) = (asked.seed + k, choice.clone());
            cases.push(Case {
                rows: vec![(2 * row, format!("healthy, with hidden effects{how}"))],
                ask: Box::new(move || {
                    let trial = Trial::draw(question, &choice, seed);
                    healthy(Sheet::of_trial(&trial, asked.folder), seed)
                }),
            });
            let platform = ROBOTS[k as usize % ROBOTS.len()].0;
            cases.push(Case {
                rows: vec![(2 * row + 1, format!("healthy recordings{how}"))],
                ask: Box::new(move || healthy(Ok(Sheet::moving(platform, held, seed)), seed)),
            });
        }
    }
    for (k, device) in DEVICES.into_iter().enumerate() {
        let what = device.1;
        for (source, how) in SOURCES {
            for (platform, name) in ROBOTS {
                cases.push(Case {
                    rows: vec![
                        (10 + 10 * k, format!("{what}, {name}, {how}")),
                        (11 + 10 * k, format!("{what}, all")),
                    ],
                    ask: Box::new(move || broken(device, (source, platform), asked)),
                });
            }
        }
    }
    Plan {
        about: "How often each broken device is recognised, by both `fit` and `diagnose` and by its name \
                and target, how often another finding stands beside it (or a healthy log has one, \
                those of a whole `fit` included), and how often a diagnosis names something beside \
                a stuck encoder. Standing: 38 to 1000 postures, each averaged over 100 readings or \
                repeated 20 times, noise stated in 7 of 10. Moving: half a minute to a minute and a \
                half at 10 to 100 Hz of robots whose masses are those of CAD, noise white or AR(1) \
                of 0.1 to 1 s, stated in one of two, angles in all digits or in ticks. `logs` counts \
                batches where a device is broken.",
        columns: &["recognised", "another finding", "named beside"],
        cases,
    }
}

/// What a diagnosis finds beside broken data; none where nothing.
fn named(robot: &Arc<Robot>, log: &LogSource, broken: &Broken) -> Result<Option<String>, Failure> {
    let mut request = diagnose::Request::new(Arc::clone(robot), log.clone());
    request.support = Some(broken.support.clone());
    request.noise = broken.noise;
    let found = diagnose::diagnose(&request, &mut ())?.diagnosis;
    Ok((found.verdict != Verdict::None).then_some(found.sentence))
}

fn names(findings: &[Finding]) -> Vec<String> {
    let name = |f: &Finding| format!("{}:{}", f.kind.name(), f.target);
    findings.iter().map(name).collect()
}

/// What `diagnose` and `fit` find in a log before any hypothesis.
fn looks(
    robot: &Arc<Robot>,
    log: &LogSource,
    support: &str,
    noise: Option<f64>,
) -> Result<[Vec<Finding>; 2], Failure> {
    let mut request = diagnose::Request::new(Arc::clone(robot), log.clone());
    request.support = Some(support.into());
    request.noise = noise;
    let diagnosed = diagnose::look(&request, &mut ())?;
    let model = robot.model(support, Snapping::default(), None)?;
    let links = robot.description.links.iter();
    let mut options = Options::default();
    options.readings = Readings::Required;
    options.links = links.map(|link| link.name.clone()).collect();
    options.support = Some(support.to_string());
    options.any_unit = true;
    let reading = health::Reading {
        options: &options,
        snapping: Snapping::default(),
        noise,
        alone: true,
    };
    let (_, fitted) = health::look(log, robot, &model, reading, &mut ())?;
    Ok([diagnosed, fitted])
}

/// What a whole fit says of the data.
fn fitted(
    robot: &Arc<Robot>,
    log: &LogSource,
    support: &str,
    noise: Option<f64>,
) -> Result<Vec<Finding>, Failure> {
    let mut request = fit::Request::default();
    request.robot = Some(Arc::clone(robot));
    request.logs = vec![log.clone()];
    request.support = Some(support.to_string());
    request.noise = noise;
    Ok(fit::fit(&request, &mut ())?.identification.health)
}

//! Broken devices: how often each is recognised, by `diagnose` and `fit` and by its name and
//! target, how often another finding stands beside it, and how often healthy logs, with hidden
//! effects of every kind, have a finding.
//!
//! Standing logs are those of the study of effects; recordings are slow sines at 10 to 100 Hz
//! with white or lasting noise. Of stuck encoders it is counted, too, what a diagnosis finds
//! beside them: nothing else is hidden.

use std::f64::consts::TAU;
use std::path::Path;
use std::sync::Arc;

use rand::seq::{IndexedRandom as _, SliceRandom as _};
use rand::{RngExt as _, SeedableRng as _};
use rand_chacha::ChaCha8Rng;
use sesc_identify::diagnose::{self, Verdict};
use sesc_identify::fit;
use sesc_identify::health::Finding;
use sesc_identify::logs::{LogSource, Sidecar, Table};
use sesc_identify::robot::Robot;
use sesc_test_support::examine::{Failure, diagnosed, fitted};
use sesc_test_support::log::READINGS;
use sesc_test_support::moving::Swing;
use sesc_test_support::recording::{Kind, Motion, Noise, Recording};
use sesc_test_support::stage::{Platform, Stage};
use sesc_test_support::survey;
use sesc_test_support::trial::{Choice, Question, Trial};

use super::{Answer, Asked, Case, Cell, Plan};

const ROBOTS: [(Platform, &str); 3] = [
    (Platform::Op2, "OP2"),
    (Platform::Skew, "Skew"),
    (Platform::Plain, "plain"),
];
/// Whether the robot of a log moves: one row a posture or every reading of it, or rows in time.
const SOURCES: [(bool, &str); 2] = [(false, "standing"), (true, "moving")];
/// Share of the joints that stand still in some healthy logs.
const HELD: f64 = 1.0 / 3.0;
/// Healthy logs of each kind for one broken log of each kind.
const HEALTHY: u64 = 8;
/// Logs that are drawn for one in which a device has something to break.
const TRIES: usize = 60;
/// One in so many logs with a stuck encoder is diagnosed to the end.
const DIAGNOSED: u64 = 2;

/// Whether a healthy log has a finding.
fn healthy(sheet: &Sheet, number: u64) -> Result<Answer, Failure> {
    let robot = Arc::new(Robot::read(&sheet.stage.urdf)?);
    let (log, support) = (sheet.log(), sheet.stage.support);
    let [diagnosed, looked_at] = looks(&robot, &log, support, None)?;
    let whole = fitted(&robot, support, log, None, "cad")?.health;
    let seen = [diagnosed, looked_at, whole];
    let any = seen.iter().any(|all| !all.is_empty());
    let found = seen.each_ref().map(|all| names(all));
    let note = format!("healthy log {number}: {found:?} ({})", sheet.about);
    Ok(Answer {
        cells: vec![
            ("recognised", Cell::Share(0, 0)),
            ("another finding", Cell::is(any)),
        ],
        note: any.then_some(note),
    })
}

/// Whether the `number`th log that a device has something to break in has exactly the finding
/// that it should have.
fn broken(
    (device, what, kind): (Device, &str, &str),
    (moves, platform): (bool, Platform),
    asked: &Asked<'_>,
) -> Result<Answer, Failure> {
    let (mut count, mut found, mut beside, mut named_beside) = (0, 0, 0, (0, 0));
    let (mut seed, mut tries, mut notes) = (asked.seed, 0, Vec::new());
    while count < asked.logs && tries < TRIES {
        seed += 1;
        let mut sheet = Sheet::draw(moves, platform, seed, asked.folder)?;
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
            vec![fitted(&robot, on, log.clone(), noise, "cad")?.health]
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
            let more = diagnosed(&robot, on, log, noise)?;
            let is_named = more.verdict != Verdict::None;
            named_beside.0 += usize::from(is_named);
            named_beside.1 += 1;
            let note = || format!("beside a stuck encoder, seed {seed}: {}", more.sentence);
            notes.extend(is_named.then(note));
        }
    }
    let count = count as usize;
    Ok(Answer {
        cells: vec![
            ("recognised", Cell::Share(found, count)),
            ("another finding", Cell::Share(beside, count)),
            ("named beside", Cell::Share(named_beside.0, named_beside.1)),
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
            let rows = vec![(2 * row, format!("healthy, with hidden effects{how}"))];
            cases.push(Case::new(rows, move || {
                let trial = Trial::draw(question, &choice, seed);
                healthy(&Sheet::of_trial(&trial, asked.folder)?, seed)
            }));
            let platform = ROBOTS[k as usize % ROBOTS.len()].0;
            let rows = vec![(2 * row + 1, format!("healthy recordings{how}"))];
            cases.push(Case::new(rows, move || {
                healthy(&Sheet::moving(platform, held, seed), seed)
            }));
        }
    }
    for (k, device) in DEVICES.into_iter().enumerate() {
        let what = device.1;
        for (moves, how) in SOURCES {
            for (platform, name) in ROBOTS {
                let rows = vec![
                    (10 + 10 * k, format!("{what}, {name}, {how}")),
                    (11 + 10 * k, format!("{what}, all")),
                ];
                let ask = move || broken(device, (moves, platform), asked);
                cases.push(Case::new(rows, ask));
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
        cases,
    }
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
    let mut request = fit::Request::default();
    request.robot = Some(Arc::clone(robot));
    request.logs = vec![log.clone()];
    request.support = Some(support.into());
    request.noise = noise;
    let fitted = fit::gather(&request, &mut ())?.health().to_vec();
    Ok([diagnosed, fitted])
}

// Devices that break a log, as they do on a bench.

/// Rows that copying, clipping and so on need to be seen in.
const FEWEST: usize = 50;
/// A stuck encoder hides at least this much motion of the CoP, in deviations of a reading.
const HIDES: f64 = 12.0;

/// What is broken.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Device {
    Constant,
    DeadAxis,
    Stuck,
    OtherFoot,
    Turned,
    Shuffled,
    Lifted,
    Far,
    Frozen,
    Copied,
    Clipped,
    Coarse,
    Unplugged,
    Overstated,
}

/// Devices, their names in the table, and the finding that each should have.
const DEVICES: [(Device, &str, &str); 14] = [
    (Device::Constant, "constant CoP", "cop_constant"),
    (Device::DeadAxis, "dead axis", "cop_axis_dead"),
    (Device::Stuck, "stuck encoder", "encoder_stuck"),
    (Device::OtherFoot, "other foot", "other_foot"),
    (Device::Turned, "turned frame", "frame_turned"),
    (Device::Shuffled, "shuffled rows", "rows_shuffled"),
    (Device::Lifted, "lost contact", "contact_lost"),
    (Device::Far, "far readings", "cop_outside_sole"),
    (Device::Frozen, "frozen stretch", "cop_frozen"),
    (Device::Copied, "copied rows", "rows_copied"),
    (Device::Clipped, "clipped channel", "channel_saturated"),
    (Device::Coarse, "coarse channel", "channel_saturated"),
    (Device::Unplugged, "unplugged cell", "contact_lost"),
    (Device::Overstated, "overstated noise", "noise_overstated"),
];

/// A log that was broken, and how it is diagnosed.
struct Broken {
    urdf: String,
    support: String,
    /// Noise of a single reading, m, where the user says.
    noise: Option<f64>,
    target: Option<String>,
}

impl Broken {
    /// Whether this is the target that is broken.
    fn is(&self, target: &str) -> bool {
        self.target.as_ref().is_none_or(|own| own == target)
    }

    /// Break a log; none where this device has nothing to break in it.
    fn of(device: Device, sheet: &mut Sheet, seed: u64) -> Option<Broken> {
        let random = &mut ChaCha8Rng::seed_from_u64(seed);
        let n = sheet.rows();
        if n < FEWEST || sheet.cells != (device == Device::Unplugged) {
            return None;
        }
        let mut broken = Broken {
            urdf: std::fs::read_to_string(&sheet.stage.urdf).ok()?,
            support: sheet.stage.support.to_string(),
            noise: None,
            target: None,
        };
        if device == Device::Unplugged {
            let name = format!("fsr_{}", random.random_range(1..=4));
            // An open input shows its zero, or wherever it drifted to.
            let level = if random.random_bool(0.5) { 0.0 } else { 0.3 };
            sheet.column(&name)?.fill(level);
            broken.target = Some(name);
            return Some(broken);
        }
        let axis = random.random_range(0..2);
        let names = ["cop_x", "cop_y"];
        let name = names[axis];
        let stretch = |part: usize, random: &mut ChaCha8Rng| {
            let from = random.random_range(1..n - n / part);
            from..from + n / part
        };
        match device {
            Device::Constant => {
                let at = random.random_range(-0.03..0.03);
                for name in names {
                    sheet.column(name)?.fill(at);
                }
            }
            Device::DeadAxis => {
                let noisy = random.random_bool(0.3);
                let std = 0.1 * sheet.noise;
                for x in sheet.column(name)? {
                    // An amplifier without its sensor has noise of its own.
                    *x = if noisy {
                        std * random.random_range(-1.0..1.0)
                    } else {
                        0.0
                    };
                }
                broken.target = Some(["x", "y"][axis].to_string());
            }
            Device::Stuck => {
                let joint = stuck(sheet, random)?;
                let middle = sheet.stage.middle(&joint);
                let first = random.random_bool(0.5);
                let column = sheet.column(&joint)?;
                let at = if first { column[0] } else { middle };
                column.fill(at);
                broken.target = Some(joint);
            }
            Device::OtherFoot => {
                let own = broken.support.clone();
                broken.support = match own.strip_prefix("right") {
                    Some(rest) => format!("left{rest}"),
                    None => format!("l{}", &own[1..]),
                };
                broken.target = Some(own);
            }
            Device::Turned => {
                let rpy = ["0 1.5707963267948966 0", "1.5707963267948966 0 0"][axis];
                let more = format!(
                    "<link name='turned'/><joint name='turn' type='fixed'><parent link='{}'/>\
                     <child link='turned'/><origin xyz='0 0 0' rpy='{rpy}'/></joint></robot>",
                    broken.support
                );
                broken.urdf = broken.urdf.replace("</robot>", &more);
                broken.support = "turned".to_string();
            }
            Device::Shuffled => {
                let mut order: Vec<usize> = (0..n).collect();
                order.shuffle(random);
                for name in names {
                    let column = sheet.column(name)?;
                    *column = order.iter().map(|&k| column[k]).collect();
                }
            }
            Device::Lifted => {
                let gone = stretch(random.random_range(3..12), random);
                for name in names {
                    sheet.column(name)?[gone.clone()].fill(0.0);
                }
            }
            Device::Far => {
                let odd = random.random_range(7..15);
                let far = 2.5 * sheet.stage.size;
                let rows = sheet.column(name)?.iter_mut().enumerate();
                rows.filter(|(row, _)| row % odd == 3)
                    .for_each(|(_, x)| *x = far);
            }
            Device::Frozen => {
                let gone = stretch(random.random_range(4..10), random);
                for name in names {
                    let column = sheet.column(name)?;
                    let last = column[gone.start - 1];
                    column[gone.clone()].fill(last);
                }
            }
            Device::Copied => {
                let order: Vec<usize> = (0..n).chain(0..n / 3).collect();
                sheet.reorder(&order);
                if let Some(pose) = sheet.column("pose") {
                    (n..pose.len()).for_each(|k| pose[k] = (100_000 + k) as f64);
                }
                // As they were, or with stamps of when they were copied.
                let restamped = random.random_bool(0.5);
                if let Some(t) = sheet.column("t").filter(|_| restamped) {
                    let (end, step) = (t[n - 1], t[1] - t[0]);
                    let first = t[0];
                    (n..t.len()).for_each(|k| t[k] += end - first + step);
                }
            }
            Device::Clipped => {
                let column = sheet.column(name)?;
                let mut sorted = column.clone();
                sorted.sort_by(f64::total_cmp);
                let upper = random.random_bool(0.5);
                let part = random.random_range(5..15);
                let end = if upper {
                    sorted[n - n / part]
                } else {
                    sorted[n / part]
                };
                for x in column {
                    *x = if upper { x.min(end) } else { x.max(end) };
                }
                broken.target = Some(name.to_string());
            }
            Device::Coarse => {
                let step = 6.0 * sheet.row_std;
                for x in sheet.column(name)? {
                    *x = (*x / step).round() * step;
                }
                broken.target = Some(name.to_string());
            }
            Device::Overstated => {
                let mut stated = false;
                for name in ["cop_x_std", "cop_y_std"] {
                    if let Some(column) = sheet.column(name) {
                        column.iter_mut().for_each(|std| *std *= 4.0);
                        stated = true;
                    }
                }
                broken.noise = (!stated).then_some(4.0 * sheet.reading_std());
            }
            Device::Unplugged => {}
        }
        Some(broken)
    }
}

/// A joint whose motion in this log shows clearly in the CoP.
fn stuck(sheet: &Sheet, random: &mut ChaCha8Rng) -> Option<String> {
    let world = sheet.stage.world();
    let every = sheet.postures.len().div_ceil(200);
    let hides = |joint: &usize| {
        let middle = sheet.stage.middle(&sheet.joints[*joint]);
        let squares: Vec<f64> = (sheet.postures.iter().step_by(every))
            .map(|q| {
                let mut still = q.clone();
                still[*joint] = middle;
                let (a, b) = (world.cop(q), world.cop(&still));
                (a[0] - b[0]).powi(2) + (a[1] - b[1]).powi(2)
            })
            .collect();
        (squares.iter().sum::<f64>() / squares.len() as f64).sqrt() > HIDES * sheet.noise
    };
    let mut all: Vec<usize> = (0..sheet.joints.len()).filter(hides).collect();
    all.shuffle(random);
    Some(sheet.joints[*all.first()?].clone())
}

// A log as columns of numbers, drawn from a seed, before a device breaks it.

/// A log, and what it is of.
struct Sheet {
    stage: Stage,
    columns: Vec<(String, Vec<f64>)>,
    /// True joint positions row by row; of repeated readings those of the posture.
    postures: Vec<Vec<f64>>,
    joints: Vec<String>,
    /// Deviation of a row of the CoP on one axis, m.
    row_std: f64,
    /// Deviation of a posture's mean, m.
    noise: f64,
    cells: bool,
    readings_per_pose: Option<u64>,
    /// For a reader.
    about: String,
}

/// Rates of recordings, Hz.
const RATES: [f64; 4] = [10.0, 20.0, 50.0, 100.0];

impl Sheet {
    /// The log of a trial of the study of hidden effects.
    fn of_trial(trial: &Trial, folder: &Path) -> Result<Sheet, Failure> {
        // Cases are asked side by side.
        let own = tempfile::tempdir_in(folder)?;
        let path = trial.log.write(own.path(), "standing");
        let text = std::fs::read_to_string(path)?;
        let mut lines = text.lines().map(|line| line.split(','));
        let header = lines.next().ok_or("no header")?;
        let mut columns: Vec<(String, Vec<f64>)> =
            header.map(|name| (name.to_string(), Vec::new())).collect();
        for line in lines {
            for (column, cell) in columns.iter_mut().zip(line) {
                column.1.push(cell.parse()?);
            }
        }
        let rows = columns.first().map_or(0, |(_, values)| values.len());
        let repeated = rows != trial.log.postures.len();
        let mut random = ChaCha8Rng::seed_from_u64(trial.seed ^ 0x5eed);
        let noise = trial.stage.reading_std() / if repeated { 20.0 } else { 100.0_f64 }.sqrt();
        let mut sheet = Sheet {
            stage: trial.stage.clone(),
            cells: columns.iter().any(|(name, _)| name == "fsr_1"),
            columns,
            postures: trial.log.postures.clone(),
            joints: trial.log.joints.clone(),
            row_std: if repeated {
                trial.stage.reading_std()
            } else {
                noise
            },
            noise,
            readings_per_pose: Some(if repeated { 20 } else { READINGS as u64 }),
            about: format!("{:?}, {rows} rows", trial.postures),
        };
        // Many labs state no deviation.
        if random.random_bool(0.3) {
            sheet.columns.retain(|(name, _)| !name.ends_with("_std"));
            sheet.about += ", noise not stated";
        }
        Ok(sheet)
    }

    /// A log on which nothing is hidden.
    fn draw(moves: bool, platform: Platform, seed: u64, folder: &Path) -> Result<Sheet, Failure> {
        if moves {
            return Ok(Sheet::moving(platform, 0.0, seed));
        }
        let choice = Choice {
            platforms: vec![platform],
            ..survey::everything()
        };
        Sheet::of_trial(&Trial::draw(Question::Nothing, &choice, seed), folder)
    }

    /// A minute or so of slow sines at some rate, with white or lasting noise, angles as they
    /// are or in ticks; a share of the joints is `held`.
    fn moving(platform: Platform, held: f64, seed: u64) -> Sheet {
        let random = &mut ChaCha8Rng::seed_from_u64(seed);
        let mut stage = Stage::new(platform);
        if held > 0.0 {
            stage = stage.holding(held, random);
        }
        let rate = *RATES.choose(random).unwrap_or(&10.0);
        let seconds = 30.0 + 60.0 * random.random::<f64>();
        let seconds = seconds.min(6000.0 / rate);
        let std = stage.size * 1e-3 * (0.3 + 1.2 * random.random::<f64>());
        let kind = match random.random_bool(0.5) {
            true => Kind::White,
            false => Kind::Ar1(0.1 * 10f64.powf(random.random::<f64>())),
        };
        let noise = Noise::new(kind, std);
        let tick = f64::from(random.random_bool(0.5)) * TAU / 4096.0;
        let swing = Swing {
            tick,
            jitter: if random.random_bool(0.3) { 0.4 } else { 0.0 },
            ..Swing::new(
                0.1 + 0.3 * random.random::<f64>(),
                0.08 + 0.12 * random.random::<f64>(),
                seconds,
            )
        };
        let (recording, how) = match random.random_bool(0.5) {
            true => (
                swing.record(&stage, stage.world(), noise, rate, random),
                format!("{:.2} Hz", swing.hertz),
            ),
            false => {
                let motion = Motion::Sines(seconds);
                let world = stage.world();
                let mut own = Recording::take(&stage, &world, motion, noise, rate, random);
                for q in own.q.iter_mut().flatten().filter(|_| tick > 0.0) {
                    *q = (*q / tick).round() * tick;
                }
                (own, "slow sines".to_string())
            }
        };
        let mut columns = recording.columns(true);
        let stated = random.random_bool(0.5);
        if stated {
            for name in ["cop_x_std", "cop_y_std"] {
                columns.push((name.to_string(), vec![std; recording.t.len()]));
            }
        }
        Sheet {
            about: format!(
                "{seconds:.0} s at {rate} Hz, {how}, {kind:?} {:.2} mm{}{}",
                1e3 * std,
                if stated { " stated" } else { "" },
                if tick > 0.0 { ", ticks" } else { "" }
            ),
            stage,
            columns,
            joints: recording.joints,
            postures: recording.q,
            row_std: std,
            noise: std,
            cells: false,
            readings_per_pose: None,
        }
    }

    /// Deviation of a single reading, as a user would give it, m.
    fn reading_std(&self) -> f64 {
        match self.readings_per_pose {
            Some(_) => self.stage.reading_std(),
            None => self.row_std,
        }
    }

    fn rows(&self) -> usize {
        self.columns.first().map_or(0, |(_, values)| values.len())
    }

    fn column(&mut self, name: &str) -> Option<&mut Vec<f64>> {
        let mut columns = self.columns.iter_mut();
        columns
            .find(|(own, _)| own == name)
            .map(|(_, values)| values)
    }

    /// Rows in this order; some may come twice.
    fn reorder(&mut self, order: &[usize]) {
        for (_, values) in &mut self.columns {
            *values = order.iter().map(|&k| values[k]).collect();
        }
    }

    /// The log, in memory.
    fn log(&self) -> LogSource {
        let mut table = Table::new("log");
        for (name, values) in &self.columns {
            table = match name.as_str() {
                "pose" => {
                    table.integers(name, values.iter().map(|x| *x as i64).collect::<Vec<_>>())
                }
                _ => table.numbers(name, values.clone()),
            };
        }
        LogSource::from(table).with_sidecar(Sidecar {
            readings_per_pose: self.readings_per_pose,
            cells: self.cells.then(|| self.stage.cells().to_vec()),
            ..Sidecar::default()
        })
    }
}

//! The page of a fleet: what robots share, what changed, what to look at first, and every robot
//! with a link to its own page.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

use minijinja::value::{Serde, Value};
use minijinja::{Error, context};
use serde::Serialize;
use sesc_identify::diagnose::Verdict;
use sesc_identify::fleet::summary::{ChangeKind, Summary};
use sesc_identify::fleet::{Fleet, Options, Row, content_hash};
use sesc_identify::health::Kind;
use sesc_identify::robot::Robot;
use sesc_identify::skeleton::Skeleton;
use sesc_model::effects::Unit;

use super::super::html::render;
use super::super::origin::Origin;
use super::super::robot::{Card, Marked};
use super::super::table::{count, in_words};
use super::{hashes, headline, is_fine, outcome, outcomes, said, subject, twice};

/// Robots with a page of their own, at most.
pub const ROBOTS: usize = 2000;
/// Days of the picture, at most: the last ones.
const DAYS: usize = 31;

/// Bytes of a robot's name in that of its file, at most: file systems take 255, and a file on its
/// way to its place has some more.
const NAME: usize = 160;

/// The page of a fleet, and those of its robots.
pub struct Pages {
    /// The page of the fleet.
    pub fleet: String,
    /// Name of the folder beside it.
    pub folder: String,
    /// Names of files and pages of robots, for this folder.
    pub robots: Vec<(String, String)>,
}

/// All pages; `command` made them. That of the fleet has the name `file`, `fleet.html`, and those
/// of robots stand in the folder `fleet` beside it: of so many robots, those to look at first
/// before others. `drawn` is the robot on the page of the fleet.
///
/// # Errors
/// When a template cannot be filled.
pub fn pages(
    fleet: &Fleet,
    summary: &Summary,
    drawn: Option<&Skeleton>,
    (command, file): (&str, &str),
    most: usize,
) -> Result<Pages, Error> {
    let folder = folder_of(Path::new(file));
    let mut robots: BTreeMap<&str, Vec<&Row>> = BTreeMap::new();
    for row in &fleet.rows {
        robots.entry(&row.robot).or_default().push(row);
    }
    // Whoever is to be looked at has a page in any case.
    let first = summary.look_first.iter().map(String::as_str);
    let mut shown: BTreeSet<&str> = BTreeSet::new();
    for name in first.chain(robots.keys().copied()) {
        if shown.len() < most.min(ROBOTS) {
            shown.insert(name);
        }
    }
    let link = |name: &str| shown.contains(name).then(|| file_of(name));
    let links: BTreeMap<&str, Option<String>> =
        robots.keys().map(|name| (*name, link(name))).collect();
    let days: BTreeSet<&str> = fleet.rows.iter().map(|row| row.day.as_str()).collect();
    let before = days.len().saturating_sub(DAYS);
    let days: Vec<&str> = days.into_iter().skip(before).collect();
    let sections = robots.iter().take(ROBOTS).map(|(name, rows)| {
        context! {
            name => *name,
            days => rows.len(),
            postures => rows.iter().map(|row| row.postures).sum::<u64>(),
            said => verdicts(rows),
            bad => !rows.iter().all(|row| is_fine(row)),
        }
    });
    let picture = summary.look_first.iter().filter_map(|robot| {
        let rows = robots.get(robot.as_str())?;
        let marks: Vec<_> = days.iter().map(|day| mark(rows, day)).collect();
        Some(context! { robot, marks => Serde(marks) })
    });
    let reasons = summary.reasons.iter().map(|reason| {
        context! {
            robot => &reason.robot,
            why => &reason.why,
            places => reason.places_in_words(),
            chance => reason.chance_in_words(),
        }
    });
    let context = context! {
        robot => drawn.map(|drawn| card(fleet, summary, drawn)),
        headline => headline(summary.shared.len(), summary.changes.len(), fleet.failed.len()),
        robots => robots.len(),
        rows => fleet.rows.len(),
        postures => fleet.rows.iter().map(|row| row.postures).sum::<u64>(),
        of_robots => count(robots.len(), "robot"),
        of_rows => count(fleet.rows.len(), "row"),
        shared => Serde(&summary.shared),
        changes => Serde(&summary.changes),
        bodies => summary.bodies.as_ref(),
        reasons => reasons.collect::<Vec<Value>>(),
        linked => shown.len(),
        population => Serde(summary.population.as_ref().map(|p| (p.robots, p.names.len()))),
        failed => Serde(&fleet.failed),
        twice => fleet.twice.iter().map(twice).collect::<Vec<String>>(),
        days => Serde(&days),
        picture => picture.collect::<Vec<Value>>(),
        sections => sections.collect::<Vec<Value>>(),
        links => Serde(&links),
        folder => address(&folder),
        left_out => robots.len().saturating_sub(ROBOTS),
        hashes => Serde(hashes(fleet.rows.iter())),
        inputs => fleet.rows.iter().map(|row| row.inputs.len()).sum::<usize>(),
        first_day => Serde(fleet.rows.iter().map(|row| &row.day).min()),
        last_day => Serde(fleet.rows.iter().map(|row| &row.day).max()),
        origin => Origin { command, ..Origin::default() }.context(),
    };
    let own = robots.iter().filter(|(name, _)| shown.contains(*name));
    let own = own.map(|(name, rows)| {
        let page = robot_page(name, rows, summary, drawn, (&address(file), command))?;
        Ok((file_of(name), page))
    });
    Ok(Pages {
        fleet: render("fleet.html", context)?,
        folder,
        robots: own.collect::<Result<_, Error>>()?,
    })
}

/// What the days of a robot came to: `none on 5 days, named on 2`.
fn verdicts(rows: &[&Row]) -> String {
    let counts = outcomes(rows.iter().copied()).into_iter();
    let said = counts.map(|(verdict, n)| format!("{verdict} on {}", count(n, "day")));
    said.collect::<Vec<String>>().join(", ")
}

/// Where the page of a robot stands, if the fleet's is at `fleet`.
pub fn page_of_robot(fleet: &Path, robot: &str) -> PathBuf {
    let folder = fleet.with_file_name(folder_of(fleet));
    folder.join(file_of(robot))
}

/// Name of the folder beside the page of the fleet.
fn folder_of(fleet: &Path) -> String {
    let name = fleet.file_stem().unwrap_or_default();
    name.to_string_lossy().into_owned()
}

/// The name of a robot's file: letters, digits, `-`, `_` and `.` as they are, all else by its
/// number behind `~`, which means nothing in an address. Of a long name the beginning and, behind
/// `~~`, which is in no other, the hash of all of it. Behind `~_` stands which letters are capital:
/// no two robots have one file, on systems either that take `A.html` for `a.html`.
fn file_of(robot: &str) -> String {
    let name = spelt(robot, '~');
    let capitals: Vec<bool> = robot.chars().map(|c| c.is_ascii_uppercase()).collect();
    match name.get(..NAME) {
        Some(first) if name.len() > NAME => {
            format!("{first}~~{}.html", content_hash(name.as_bytes()))
        }
        _ if capitals.contains(&true) => {
            let four = capitals.chunks(4).map(|four| {
                let digit = four
                    .iter()
                    .rev()
                    .fold(0, |sum, one| 2 * sum + u8::from(*one));
                format!("{digit:x}")
            });
            let all = four.collect::<String>();
            format!("{name}~_{}.html", all.trim_end_matches('0'))
        }
        _ => format!("{name}.html"),
    }
}

/// A name in an address.
fn address(name: &str) -> String {
    spelt(name, '%')
}

fn spelt(name: &str, sign: char) -> String {
    let byte = |byte: u8| match byte {
        b'-' | b'_' | b'.' => char::from(byte).to_string(),
        _ if byte.is_ascii_alphanumeric() => char::from(byte).to_string(),
        _ => format!("{sign}{byte:02x}"),
    };
    name.bytes().map(byte).collect()
}

/// A day of a robot: mark, class, words.
fn mark(rows: &[&Row], day: &str) -> (&'static str, &'static str, String) {
    let own: Vec<&&Row> = rows.iter().filter(|row| row.day == day).collect();
    let Some(row) = own.last() else {
        return ("", "none", "no log".to_string());
    };
    let words = format!("{}: {}", outcome(row), said(row));
    match row.verdict {
        _ if row.error.is_some() || !row.has_result() => ("×", "bad", words),
        Some(Verdict::Unusable) => ("!", "bad", words),
        _ if !row.health.is_empty() => ("!", "bad", words),
        _ if is_fine(row) => ("·", "fine", words),
        _ => ("●", "ok", words),
    }
}

// The page of one robot of a fleet: why it is looked at, and what its rows say day by day.

/// An effect with its size on every day.
#[derive(Serialize)]
struct Course {
    effect: String,
    parameter: String,
    days: Vec<Option<(f64, f64)>>,
}

/// The page of the robot `name`; it stands in a folder beside the page `fleet`. `drawn` is the
/// robot of the fleet.
fn robot_page(
    name: &str,
    rows: &[&Row],
    summary: &Summary,
    drawn: Option<&Skeleton>,
    (fleet, command): (&str, &str),
) -> Result<String, Error> {
    let reason = summary.reasons.iter().find(|reason| reason.robot == name);
    let shared = summary.shared.iter();
    let shared = shared.filter(|shared| shared.robots.iter().any(|robot| robot == name));
    let shared: Vec<&str> = shared.map(|shared| shared.sentence.as_str()).collect();
    let changes = summary.changes.iter().filter(|c| c.robot == name);
    let changes: Vec<_> = changes.collect();
    let last = rows.iter().rev().find(|row| row.has_result());
    let context = context! {
        robot => drawn.and_then(|drawn| of_robot(rows, drawn)),
        name => name,
        fleet => fleet,
        why => reason.map(|reason| reason.why.as_str()),
        shared => Serde(shared),
        changes => Serde(changes),
        lines => rows.iter().map(|row| line(row)).collect::<Vec<Value>>(),
        courses => Serde(courses(rows)),
        days => Serde(rows.iter().map(|row| &row.day).collect::<Vec<&String>>()),
        last => Serde(last.map(|row| (&row.day, &row.sentence))),
        hashes => Serde(hashes(rows.iter().copied())),
        logs => Serde(rows.iter().map(|row| (&row.day, &row.inputs)).collect::<Vec<_>>()),
        origin => Origin { command, ..Origin::default() }.context(),
    };
    render("fleet_robot.html", context)
}

/// Every parameter of every effect, in the unit in which people read it.
fn courses(rows: &[&Row]) -> Vec<Course> {
    let mut found: Vec<Course> = Vec::new();
    for (day, row) in rows.iter().enumerate() {
        for effect in &row.effects.explanation {
            for (parameter, size) in &effect.parameters {
                let (factor, unit) = Unit::of(parameter).shown();
                let stem = Unit::stem(parameter);
                let shown = match unit {
                    "" => stem,
                    unit => format!("{stem}, {unit}"),
                };
                let name = subject(effect);
                let is_it = |course: &Course| course.effect == name && course.parameter == shown;
                let at = found.iter().position(is_it).unwrap_or_else(|| {
                    found.push(Course {
                        effect: name.clone(),
                        parameter: shown.clone(),
                        days: vec![None; rows.len()],
                    });
                    found.len() - 1
                });
                found[at].days[day] = Some((factor * size.value, factor * size.std));
            }
        }
    }
    found
}

/// A row: verdict, worth of the data, and what was found, in short.
fn line(row: &Row) -> Value {
    let mm = |metres: Option<f64>| metres.map(|metres| 1e3 * metres);
    context! {
        day => &row.day,
        verdict => outcome(row),
        bad => !is_fine(row),
        postures => row.postures,
        noise_mm => mm(row.noise_floor),
        left_mm => mm(row.held_out_rmse),
        said => said(row),
    }
}

// The robot of these pages: joints and links that something is said of.

/// The robot of a fleet as it is drawn, on the support of most of its rows; none where no row has
/// its URDF and a support. Meshes are looked for in `folder`.
pub fn skeleton(
    fleet: &Fleet,
    robot: &Robot,
    options: &Options,
    folder: Option<&Path>,
) -> Option<Skeleton> {
    let mut supports: BTreeMap<&str, usize> = BTreeMap::new();
    let own = |hash: &str| hash == robot.description.hash;
    for row in fleet.rows.iter().filter(|row| own(&row.urdf_hash)) {
        if !row.support.is_empty() {
            *supports.entry(&row.support).or_default() += 1;
        }
    }
    let (support, _) = supports.into_iter().max_by_key(|(_, rows)| *rows)?;
    let model = robot.model(support, options.snapping(), None).ok()?;
    Some(Skeleton::of(&model, &robot.description, folder))
}

/// Joints and links that robots share a fault of, that changed, or whose encoder is stuck, on the
/// robot; what `robot.html` takes.
fn card(fleet: &Fleet, summary: &Summary, skeleton: &Skeleton) -> Value {
    let mut marked = Marked::default();
    for group in &summary.shared {
        let robots = count(group.robots.len(), "robot");
        let what = format!("{} in {robots}", in_words(&group.effect));
        marked.point(skeleton, &group.effect, &group.target, &what);
    }
    let changes = summary.changes.iter();
    for change in changes.filter(|change| change.kind == ChangeKind::Effect) {
        if let Some((effect, target)) = change.target.split_once(':') {
            let said = in_words(effect);
            let what = format!("{said} of {} from {} on", change.robot, change.day);
            marked.point(skeleton, effect, target, &what);
        }
    }
    for (joint, robots) in stuck(fleet, summary) {
        let robots = robots.into_iter().collect::<Vec<&str>>().join(", ");
        marked.point(skeleton, "", joint, &format!("encoder stuck in {robots}"));
    }
    let nothing = "No joint and no link is shared, changed or stuck.";
    Card::standing(skeleton, marked, nothing, Vec::new()).context()
}

/// One robot of a fleet: joints and links of its last result, and encoders that are stuck on any
/// day; none where its last result is of another URDF than `skeleton`.
fn of_robot(rows: &[&Row], skeleton: &Skeleton) -> Option<Value> {
    let last = rows.iter().rev().find(|row| row.has_result())?;
    if last.urdf_hash != skeleton.hash {
        return None;
    }
    let mut marked = Marked::default();
    for effect in &last.effects.explanation {
        if marked.mark(skeleton, &effect.effect, &effect.target) {
            marked.said.push(subject(effect));
        }
    }
    let findings = rows.iter().flat_map(|row| &row.health);
    let stuck = findings.filter(|finding| finding.kind == Kind::EncoderStuck);
    let stuck: BTreeSet<&str> = stuck.map(|finding| finding.target.as_str()).collect();
    for joint in stuck {
        marked.point(skeleton, "", joint, "encoder stuck");
    }
    let nothing = "No joint and no link is suspected.";
    Some(Card::standing(skeleton, marked, nothing, Vec::new()).context())
}

/// Joints whose encoder is stuck in robots that are to be looked at.
fn stuck<'f>(fleet: &'f Fleet, summary: &Summary) -> BTreeMap<&'f str, BTreeSet<&'f str>> {
    let first: BTreeSet<&str> = summary.look_first.iter().map(String::as_str).collect();
    let mut found: BTreeMap<&str, BTreeSet<&str>> = BTreeMap::new();
    for row in &fleet.rows {
        let own = row.health.iter().filter(|f| f.kind == Kind::EncoderStuck);
        for finding in own.filter(|_| first.contains(row.robot.as_str())) {
            found.entry(&finding.target).or_default().insert(&row.robot);
        }
    }
    found
}

//! The page of a fleet: what robots share, what changed, what to look at first, and every robot
//! with a link to its own page.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

use minijinja::value::Serde;
use minijinja::{Error, context};
use serde::Serialize;
use sesc_identify::diagnose::Verdict;
use sesc_identify::fleet::summary::Summary;
use sesc_identify::fleet::{Fleet, Row, content_hash};
use sesc_identify::skeleton::Skeleton;

use super::super::html::render;
use super::super::origin::Origin;
use super::line::{is_fine, line, outcomes};
use super::picture::card;
use super::robot::robot_page;
use super::{count, hashes, headline, twice};

/// Robots with a page of their own, at most.
pub const ROBOTS: usize = 2000;
/// Days of the picture, at most: the last ones.
const DAYS: usize = 31;

/// Bytes of a robot's name in that of its file, at most: file systems take 255, and a file on its
/// way to its place has some more.
const NAME: usize = 160;

/// A robot in the list of all.
#[derive(Serialize)]
struct RobotLine {
    name: String,
    days: usize,
    postures: u64,
    said: String,
    bad: bool,
}

/// A robot to look at, and how sure that is.
#[derive(Serialize)]
struct LookFirst<'a> {
    robot: &'a str,
    why: &'a str,
    places: String,
    chance: String,
}

/// A robot of the picture: a mark a day.
#[derive(Serialize)]
struct Marks {
    robot: String,
    marks: Vec<(&'static str, &'static str, String)>,
}

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
    let sections = robots.iter().take(ROBOTS).map(|(name, rows)| RobotLine {
        name: name.to_string(),
        days: rows.len(),
        postures: rows.iter().map(|row| row.postures).sum(),
        said: verdicts(rows),
        bad: !rows.iter().all(|row| is_fine(row)),
    });
    let picture = summary.look_first.iter().filter_map(|robot| {
        let rows = robots.get(robot.as_str())?;
        let robot = robot.clone();
        let marks = days.iter().map(|day| mark(rows, day)).collect();
        Some(Marks { robot, marks })
    });
    let reasons = summary.reasons.iter().map(|reason| LookFirst {
        robot: &reason.robot,
        why: &reason.why,
        places: reason.places_in_words(),
        chance: reason.chance_in_words(),
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
        reasons => Serde(reasons.collect::<Vec<LookFirst>>()),
        linked => shown.len(),
        population => Serde(summary.population.as_ref().map(|p| (p.robots, p.names.len()))),
        failed => Serde(&fleet.failed),
        twice => fleet.twice.iter().map(twice).collect::<Vec<String>>(),
        days => Serde(&days),
        picture => Serde(picture.collect::<Vec<Marks>>()),
        sections => Serde(sections.collect::<Vec<RobotLine>>()),
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
    let line = line(row);
    let words = format!("{}: {}", line.verdict, line.said);
    match row.verdict {
        _ if row.error.is_some() || !row.has_result() => ("×", "bad", words),
        Some(Verdict::Unusable) => ("!", "bad", words),
        _ if !row.health.is_empty() => ("!", "bad", words),
        _ if is_fine(row) => ("·", "fine", words),
        _ => ("●", "ok", words),
    }
}

//! Names of columns: as other programs write them, and as messages say them.
//!
//! ```text
//! # robot: post               lines of comments, `sep=;` of Excel: passed over
//! # pose,ankle,cop_x          a mark before the first name, where numbers follow: names
//! t [s],ankle [deg],cop_x_mm  units: the values are brought to s, rad, m, N
//! time,__time,timestamp       times of other programs are `t`
//! -,rad,m                     a row of units: read as if it stood in the names
//! /joint_states/ankle/position, ankle_pos: told, with the line that renames them
//! ```

use std::collections::{HashMap, HashSet};
use std::f64::consts::PI;

use sesc_model::spelling::nearest;
use sesc_model::text::listed;
use sesc_model::tree::Dof;

use super::columns::{T, meaning};

/// Letters of a piece of a file in a message.
const LONGEST: usize = 64;

/// What joints' columns are called beside the joint, best first: positions, then what is none.
const POSITIONS: &str = "position pos angle q actual measured";
const NO_POSITIONS: &str = "velocity vel speed qd qdd dq effort torque tau current cmd command \
                            target desired reference error";

/// Names for a message, a dozen at most.
pub(crate) fn list(names: &[&str]) -> String {
    listed(names.iter().map(|name| format!("`{}`", short(name))), 12)
}

/// A piece of a file, cut so that a message stays readable.
pub(crate) fn short(text: &str) -> String {
    match text.char_indices().nth(LONGEST) {
        Some((end, _)) => format!("{}…", text[..end].escape_debug()),
        None => text.escape_debug().to_string(),
    }
}

/// `; did you mean `a` for `b`?` for the first few wrong names that have a near one.
pub(super) fn suggestion<'a>(wrong: &[&str], right: impl Iterator<Item = &'a str>) -> String {
    // Comparing takes time.
    let right: Vec<&str> = right.take(2_000).collect();
    let found: Vec<String> = wrong
        .iter()
        .take(3)
        .filter_map(|wrong| {
            nearest(wrong, "", right.iter().copied()).map(|near| format!("`{near}` for `{wrong}`"))
        })
        .collect();
    match found.len() {
        0 => String::new(),
        _ => format!("; did you mean {}?", found.join(", ")),
    }
}

/// The columns of a log that are positions of `missing` joints by their names: the name in
/// the log, then the joint.
pub(super) fn meant<'a>(
    missing: &[&'a str],
    columns: impl Iterator<Item = &'a str>,
) -> Vec<(&'a str, &'a str)> {
    let mut found: HashMap<&str, Vec<&str>> = HashMap::new();
    for column in columns {
        // `l_hip_roll_pos` is of `l_hip_roll`, not of a joint `hip`.
        let of = missing.iter().filter(|joint| holds(column, joint));
        if let Some(joint) = of.max_by_key(|joint| joint.len()) {
            found.entry(*joint).or_default().push(column);
        }
    }
    let pairs = missing.iter().filter_map(|joint| {
        let mut own = found.remove(joint)?;
        let rest = |column: &str| column.replacen(joint, " ", 1).to_lowercase();
        let says = |column: &str, words: &str| {
            let rest = rest(column);
            let mut parts = rest.split(|c: char| !c.is_alphanumeric());
            parts.any(|part| words.split(' ').any(|word| word == part))
        };
        own.retain(|column| !says(column, NO_POSITIONS));
        if own.len() > 1 {
            own.retain(|column| says(column, POSITIONS));
        }
        match own[..] {
            [one] => Some((one, *joint)),
            _ => None,
        }
    });
    pairs.take(100).collect()
}

/// Whether `name` has `part` in it, as a word or words of its own.
fn holds(name: &str, part: &str) -> bool {
    let is_end = |c: Option<char>| c.is_none_or(|c| !c.is_alphanumeric());
    let mut places = name.match_indices(part);
    places.any(|(at, _)| {
        let (before, after) = (&name[..at], &name[at + part.len()..]);
        is_end(before.chars().next_back()) && is_end(after.chars().next())
    })
}

/// What a column measures.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Quantity {
    Time,
    Angle,
    Length,
    Force,
}

/// Units as programs write them, what they measure, and how many s, rad, m or N one is.
const UNITS: [(&str, Quantity, f64); 16] = [
    ("s sec seconds", Quantity::Time, 1.0),
    ("ms", Quantity::Time, 1e-3),
    ("us µs", Quantity::Time, 1e-6),
    ("ns nsec", Quantity::Time, 1e-9),
    ("min", Quantity::Time, 60.0),
    ("days", Quantity::Time, 86_400.0),
    ("rad radians", Quantity::Angle, 1.0),
    ("deg degrees °", Quantity::Angle, PI / 180.0),
    ("m", Quantity::Length, 1.0),
    ("mm", Quantity::Length, 1e-3),
    ("cm", Quantity::Length, 1e-2),
    ("in inch", Quantity::Length, 0.0254),
    ("N", Quantity::Force, 1.0),
    ("kN", Quantity::Force, 1e3),
    ("kgf kg", Quantity::Force, 9.80665),
    ("lbf lb", Quantity::Force, 4.448_221_615_260_5),
];
/// Names that other programs give the time of a row, in small letters: PlotJuggler, pandas,
/// rostopic, spreadsheets.
const TIMES: [&str; 6] = ["time", "__time", "timestamp", "%time", "stamp", "elapsed"];
/// Marks before a line of comments, or before the first name.
const MARKS: [char; 2] = ['#', '%'];
/// A name that begins with one of them.
const TIME_OF_ROSTOPIC: &str = "%time";

/// Where the names of columns begin in a table in text.
#[derive(Debug, PartialEq)]
pub(super) struct Preamble {
    /// Bytes before the first name.
    pub start: usize,
    /// The line of the names, from 1.
    pub line: u64,
    /// The delimiter that a line of Excel says.
    pub delimiter: Option<u8>,
}

/// Find the names of columns in the first bytes of a text.
pub(super) fn preamble(head: &[u8]) -> Preamble {
    let (mut at, mut delimiter, mut marked) = (0, None, None);
    let mut line = 0;
    loop {
        line += 1;
        let (text, next) = first_line(head, at);
        let bare = text.trim_start_matches('\u{feff}').trim();
        let more = next > at && next < head.len() && line <= 1000;
        match bare.strip_prefix("sep=").map(str::as_bytes) {
            Some([own]) if line == 1 && more => delimiter = Some(*own),
            _ if bare.starts_with(MARKS) && !bare.starts_with(TIME_OF_ROSTOPIC) && more => {
                let names = bare.trim_start_matches(MARKS).trim_start();
                let start = text.len() - names.len() - (text.len() - text.trim_end().len());
                marked = Some((at + start, line));
            }
            _ if bare.is_empty() && more => {}
            _ => {
                // Above numbers the names stand in the last of the marked lines.
                let marked = marked.filter(|_| is_row_of_numbers(bare));
                let (start, line) = marked.unwrap_or((at, line));
                return Preamble {
                    start,
                    line,
                    delimiter,
                };
            }
        }
        at = next;
    }
}

/// The line of a text that begins at `at`, and where the next one does; of what is no text that
/// there is something.
fn first_line(head: &[u8], at: usize) -> (&str, usize) {
    let rest = &head[at..];
    let end = rest.iter().position(|byte| matches!(byte, b'\n' | b'\r'));
    let end = end.unwrap_or(rest.len());
    let both = rest[end..].starts_with(b"\r\n");
    let next = (end + 1 + usize::from(both)).min(rest.len());
    (str::from_utf8(&rest[..end]).unwrap_or("?"), at + next)
}

fn is_row_of_numbers(line: &str) -> bool {
    let fields = line.split([',', ';', '\t', ' ']).map(str::trim);
    let mut fields = fields.filter(|field| !field.is_empty()).peekable();
    fields.peek().is_some() && fields.all(|field| field.parse::<f64>().is_ok())
}

/// What is said of a table whose names cannot be found, because its columns are divided by
/// blanks or it has none.
pub(super) fn no_names(header: &[String]) -> Option<String> {
    if let [one] = header {
        let words = one.split_whitespace().count();
        return (words > 2).then(|| {
            format!(
                "the columns of {words} names are divided by blanks; write commas between names and \
                 between numbers"
            )
        });
    }
    let mut names = header.iter().filter(|name| !name.is_empty()).peekable();
    let numbers = names.peek().is_some() && names.all(|name| name.parse::<f64>().is_ok());
    let said = "the first line has numbers, not the names of columns; write a line of names above it: \
                `pose`, the URDF's joints, `cop_x`, `cop_y`";
    numbers.then(|| said.to_string())
}

/// The units of a row below the names, where it is one.
pub(super) fn units<'a>(fields: impl Iterator<Item = &'a str>) -> Option<Vec<String>> {
    let bare = |field: &str| {
        field
            .trim()
            .trim_matches(['[', ']', '(', ')'])
            .trim()
            .to_string()
    };
    let fields: Vec<String> = fields.map(bare).collect();
    let none = |field: &str| matches!(field, "" | "-" | "1");
    let known = |field: &String| none(field) || unit(field).is_some();
    let is_row = fields.iter().all(known) && fields.iter().any(|f| unit(f).is_some());
    is_row.then_some(fields)
}

/// A name with the unit of a row below it.
pub(super) fn with_unit(name: &str, unit: &str) -> String {
    match unit {
        "" | "-" | "1" => name.to_string(),
        unit => format!("{name} [{unit}]"),
    }
}

fn unit(text: &str) -> Option<(Quantity, f64)> {
    let is = |names: &str| names.split(' ').any(|name| name == text);
    let known = UNITS.iter().find(|(names, ..)| is(names));
    known.map(|(_, quantity, factor)| (*quantity, *factor))
}

/// Columns as the log names them, with what they are here.
#[derive(Debug, Default, PartialEq)]
pub(super) struct Named {
    /// Our names, those of the log where it has a name of its own.
    pub names: Vec<String>,
    /// What brings the values to s, rad, m or N.
    pub factors: Vec<f64>,
    /// What was read under another name than it has.
    pub note: Option<String>,
}

/// Read times and units of other programs in the names of columns.
pub(super) fn named(header: &[String], dofs: &[Dof]) -> Named {
    let joints: HashMap<&str, bool> = dofs
        .iter()
        .map(|dof| (dof.joint.trim(), dof.prismatic))
        .collect();
    let is_known = |name: &str| joints.contains_key(name) || meaning(name).is_some();
    let taken: HashSet<&str> = header.iter().map(String::as_str).collect();
    let unit_of = |name: &str| meaning(name).map(|column| column.unit);
    let quantity = |name: &str| match (joints.get(name), unit_of(name)) {
        (Some(true), _) | (None, Some("m")) => Some(Quantity::Length),
        (Some(false), _) => Some(Quantity::Angle),
        (None, Some("s")) => Some(Quantity::Time),
        (None, Some("N")) => Some(Quantity::Force),
        _ => None,
    };
    let mut named = Named::default();
    let (mut told, mut timed) = (Vec::new(), taken.contains(T));
    for name in header {
        let mut read = (name.as_str(), 1.0);
        if !is_known(name) {
            let (bare, unit) = without_unit(name, |bare| is_known(bare) || is_a_time(bare));
            let ours = if is_a_time(bare) { T } else { bare };
            let fits = unit.is_none_or(|(of, _)| quantity(ours) == Some(of));
            let free = ours != T || !std::mem::replace(&mut timed, true);
            if is_known(ours) && fits && free && !taken.contains(ours) {
                told.push(format!("`{}` as `{ours}`", short(name)));
                read = (ours, unit.map_or(1.0, |(_, factor)| factor));
            }
        }
        named.names.push(read.0.to_string());
        named.factors.push(read.1);
    }
    let converted = named.factors.iter().any(|factor| *factor != 1.0);
    named.note = (!told.is_empty()).then(|| {
        let units = if converted {
            ", in s, rad, m and N"
        } else {
            ""
        };
        format!(
            "columns are read by other names{units}: {}",
            sesc_model::text::listed(told, 4)
        )
    });
    named
}

fn is_a_time(name: &str) -> bool {
    TIMES.contains(&name.to_lowercase().as_str())
}

/// A name without the unit behind it: `ankle [deg]`, `t (ms)`, `cop_x_mm`.
fn without_unit(name: &str, is_known: impl Fn(&str) -> bool) -> (&str, Option<(Quantity, f64)>) {
    let bracketed = [("[", ']'), ("(", ')')]
        .into_iter()
        .find_map(|(open, close)| {
            let (bare, text) = name.strip_suffix(close)?.rsplit_once(open)?;
            match text.trim() {
                "-" | "" | "1" => Some((bare.trim(), None)),
                text => Some((bare.trim(), Some(unit(text)?))),
            }
        });
    let suffixed = || {
        let (bare, text) = name.rsplit_once(['_', ' '])?;
        Some((bare, Some(unit(text)?))).filter(|_| is_known(bare))
    };
    bracketed.or_else(suffixed).unwrap_or((name, None))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::logs::tests::dofs;

    #[test]
    fn the_first_wrong_names_get_a_suggestion() {
        let joints = ["l_knee", "r_knee", "head_pan"];
        let said = suggestion(&["L-Knee", "camera", "hed_pan"], joints.into_iter());
        assert_eq!(
            said,
            "; did you mean `l_knee` for `L-Knee`, `head_pan` for `hed_pan`?"
        );
        assert_eq!(suggestion(&["camera"], joints.into_iter()), "");
    }

    #[test]
    fn lists_and_pieces_stay_short() {
        assert_eq!(list(&["a", "b"]), "`a`, `b`");
        assert!(list(&["x"; 20]).ends_with("and 8 more"));
        assert_eq!(short(&"é".repeat(500)).chars().count(), LONGEST + 1);
    }

    #[test]
    fn columns_that_hold_a_joint_s_name_are_told() {
        let joints = ["knee", "l_knee", "ankle"];
        let columns = [
            "/joint_states/l_knee/position",
            "/joint_states/l_knee/velocity",
            "knee_pos",
            "knee_cmd",
            "ankles",
        ];
        let found = meant(&joints, columns.into_iter());
        let expected = [
            ("knee_pos", "knee"),
            ("/joint_states/l_knee/position", "l_knee"),
        ];
        assert_eq!(found, expected);
    }

    #[test]
    fn names_of_columns_are_found_below_comments_and_behind_a_mark() {
        for (text, names, line) in [
            ("a,b\n1,2\n", "a,b\n", 1),
            ("# robot: post\n\n# by hand\na,b\n1,2\n", "a,b\n", 4),
            ("# a,b \n1,2\n", "a,b \n", 1),
            ("% note\r\n%\ta b\r\n1 2\r\n", "a b\r\n", 2),
            ("sep=;\r\na;b\r\n1;2\r\n", "a;b\r\n", 2),
            ("%time,a\n1,2\n", "%time,a\n", 1),
            ("# a", "# a", 1),
            ("", "", 1),
        ] {
            let found = preamble(text.as_bytes());
            assert!(text[found.start..].starts_with(names), "{text:?}");
            assert_eq!(found.line, line, "{text:?}");
        }
        assert_eq!(preamble(b"sep=;\na;b\n").delimiter, Some(b';'));
    }

    #[test]
    fn units_and_times_of_other_programs_are_read() {
        let read = |header: &str| {
            let header: Vec<String> = header.split(',').map(str::to_string).collect();
            let found = named(&header, &dofs(&["hip", "hip_mm"]));
            (found.names.join(","), found.factors, found.note)
        };
        let (names, factors, note) = read("t [ms],hip (deg),cop_x_mm,cop_y [m],hip_mm,fsr_1 [kgf]");
        assert_eq!(names, "t,hip,cop_x,cop_y,hip_mm,fsr_1");
        let expected = [1e-3, PI / 180.0, 1e-3, 1.0, 1.0, 9.80665];
        assert_eq!(factors, expected);
        assert!(note.unwrap().contains("`hip (deg)` as `hip`"));
        for time in ["time", "__time", "Timestamp", "%time", "time [s]", "time_s"] {
            assert_eq!(read(&format!("{time},hip")).0, "t,hip", "{time}");
        }
        // Names that are ours stay, and one time is enough.
        assert_eq!(
            read("t,time,hip"),
            ("t,time,hip".into(), vec![1.0; 3], None)
        );
        assert_eq!(read("time,timestamp,hip").0, "t,timestamp,hip");
        // A unit that measures something else.
        assert_eq!(read("hip [mm],t [rad]").0, "hip [mm],t [rad]");
    }

    #[test]
    fn a_row_of_units_is_told_from_numbers() {
        let row = |text: &'static str| units(text.split(','));
        assert_eq!(row("-,[rad],m").unwrap(), ["-", "rad", "m"]);
        assert_eq!(row("0,1,2"), None);
        assert_eq!(row("-,1,-"), None);
        assert_eq!(row("s,turns"), None);
    }
}

//! The columns of a posture log: one table of what their names mean, for readers,
//! writers, messages and help; and their names as other programs write them.
//!
//! ```text
//! t [s],ankle [deg],cop_x_mm  units: the values are brought to s, rad, m, N
//! time,__time,timestamp       times of other programs are `t`
//! -,rad,m                     a row of units: read as if it stood in the names
//! /joint_states/ankle/position, ankle_pos: told, with the line that renames them
//! ```
//!
//! A sensor that the sidecar names has six columns beside those of the table: `l_fx`, `l_fy`, `l_fz`,
//! `l_mx`, `l_my`, `l_mz` of `[sensors.l]`.

use std::collections::{BTreeMap, HashMap, HashSet};
use std::f64::consts::PI;
use std::ops::Range;

use sesc_model::text::listed;
use sesc_model::tree::Dof;

use super::bounds::Bound;
use super::names::{list, meant, short, suggestion};
use super::settings::{Angles, Options, Readings, Sensor};
use crate::{Message, Setting, message};

pub(super) const POSE: &str = "pose";
pub(super) const T: &str = "t";
pub(super) const SUPPORT: &str = "support";
pub(super) const COP: [&str; 2] = ["cop_x", "cop_y"];
pub(super) const COP_STD: [&str; 2] = ["cop_x_std", "cop_y_std"];
const GRAVITY: [&str; 3] = ["gravity_x", "gravity_y", "gravity_z"];
/// Before the number of a foot cell, from 1.
pub(super) const FZ: &str = "fz";
const CELL: &str = "fsr_";
/// Behind the name of a sensor: force and moment on the robot.
const WRENCH: [&str; 6] = ["_fx", "_fy", "_fz", "_mx", "_my", "_mz"];
/// Behind the name of a reading.
const STD: &str = "_std";

/// A column of posture logs, or some that go together.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct Column {
    /// The names of the columns, all of which are needed if one is there; `k` counts
    /// from 1.
    pub names: &'static [&'static str],
    /// Unit of the values; empty of texts and whole numbers.
    pub unit: &'static str,
    /// What the values are.
    pub meaning: &'static str,
    /// Whether a log must have it.
    pub need: Need,
    /// Values that it can have, of a column of numbers that is no joint; gravity is judged as a
    /// vector.
    bound: Bound,
}

/// Whether a log must have a column.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum Need {
    /// Every log.
    Always,
    /// A log of readings has this or another one of its kind.
    Reading,
    /// It belongs to a reading, and may be left out.
    OfReading,
    /// It may be left out.
    Never,
}

/// All columns that mean something; others are ignored with a warning.
#[rustfmt::skip]
pub const COLUMNS: [Column; 10] = [
    column(&[POSE], "", Bound::ANY, Need::Never,
        "whole number; rows that share it are repeated readings"),
    column(&[T], "s", Bound::within(1e15, "s"), Need::Never, "time"),
    column(&[SUPPORT], "", Bound::ANY, Need::Never, "link on the ground"),
    column(&["JOINT"], "rad, m", Bound::ANY, Need::Always,
        "position of the URDF's joint of that name, for each independent joint"),
    column(&COP, "m", Bound::COP, Need::Reading, "CoP in the support frame"),
    column(&COP_STD, "m", Bound::COP.of_deviation(), Need::OfReading,
        "standard deviation of a single reading of the CoP"),
    column(&["fsr_k"], "N", Bound::FORCE, Need::Reading,
        "force on foot cell k; its place stands in the sidecar"),
    column(&["fsr_k_std"], "N", Bound::FORCE.of_deviation(), Need::OfReading,
        "standard deviation of a single reading of that force"),
    column(&[FZ], "N", Bound::FORCE, Need::OfReading,
        "total force on the support, up positive: it weighs the robot and what it carries"),
    column(&GRAVITY, "m/s²", Bound::ANY, Need::Never, "gravity in the support frame"),
];

const fn column(
    names: &'static [&'static str],
    unit: &'static str,
    bound: Bound,
    need: Need,
    meaning: &'static str,
) -> Column {
    Column {
        names,
        unit,
        meaning,
        need,
        bound,
    }
}

/// More columns than any robot has joints and readings.
const MOST: usize = 20_000;

/// A column of numbers that is wanted.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Number {
    /// Its place in the log.
    pub column: usize,
    /// For messages.
    pub name: String,
    /// Values that it can have.
    pub bound: Bound,
    /// What brings it to SI units.
    pub factor: f64,
    /// Whether every row has to have a value, and how many have none.
    pub is_needed: bool,
    pub missing: u64,
}

/// Where the wanted columns are: `numbers` lists columns of numbers in the
/// order a source delivers them, the ranges are positions in that list.
#[derive(Debug, Clone, Default, PartialEq)]
pub(super) struct Columns {
    pub pose: Option<usize>,
    pub support: Option<usize>,
    pub numbers: Vec<Number>,
    pub t: Option<usize>,
    pub joints: Range<usize>,
    pub cop: Option<usize>,
    pub cop_std: Option<usize>,
    pub cells: Range<usize>,
    pub cell_std: Option<usize>,
    pub load: Option<usize>,
    /// The first of six of each sensor, in the order of their names.
    pub sensors: Vec<usize>,
    pub gravity: Option<usize>,
    /// Columns that mean nothing here.
    pub ignored: Vec<String>,
    /// What was read under another name than it has.
    pub note: Option<String>,
}

impl Columns {
    /// Match the names of a log with the robot's joints. The error is the
    /// message without the file.
    pub(super) fn of(
        header: &[String],
        dofs: &[Dof],
        (options, angles): (&Options, Angles),
        sensors: &BTreeMap<String, Sensor>,
    ) -> Result<Columns, Message> {
        let (header, factors, note) = named(header, dofs, sensors);
        check_joints(dofs)?;
        if header.len() > MOST {
            return Err(format!(
                "{} columns; a log has one per joint and reading, {MOST} at most",
                header.len()
            )
            .into());
        }
        let mut at: HashMap<&str, usize> = HashMap::new();
        for (k, name) in header.iter().enumerate() {
            // Tables often carry an unnamed index.
            if !name.is_empty() && at.insert(name, k).is_some() {
                return Err(format!("column `{name}` appears twice; remove one").into());
            }
        }
        let mut columns = Columns {
            pose: at.remove(POSE),
            support: at.remove(SUPPORT),
            ..Columns::default()
        };
        columns.take_joints(&mut at, dofs, options.any_unit)?;
        columns.t = columns.take(&mut at, &[T], "")?;
        columns.gravity = columns.take(&mut at, &GRAVITY, "gravity")?;
        if options.readings == Readings::Ignored {
            let of_sensors: HashSet<String> = sensors.keys().flat_map(|own| wrench(own)).collect();
            at.retain(|name, _| !is_reading(name) && !of_sensors.contains(*name));
        } else {
            columns.take_readings(&mut at)?;
            columns.take_sensors(&mut at, sensors)?;
        }
        if options.readings == Readings::Required && !columns.readings() {
            let sensors = at.keys().filter_map(|name| name.strip_suffix(WRENCH[0]));
            let is_whole = |own: &&str| wrench(own).iter().all(|name| at.contains_key(&**name));
            if let Some(own) = sensors.filter(is_whole).min() {
                return Err(format!(
                    "columns {} are a wrench, and nothing says about which origin; put \
                     `[sensors.{own}]` with `frame = \"LINK\"` into the log's sidecar",
                    list(wrench(own))
                )
                .into());
            }
            let near = suggestion(&COP, at.keys().copied());
            return Err(format!(
                "no readings; add the columns `cop_x` and `cop_y` (m, support frame), \
                 or `fsr_1`, `fsr_2`, … (N){near}"
            )
            .into());
        }
        let ignored = header.iter().filter(|name| at.contains_key(name.as_str()));
        columns.ignored = ignored.cloned().collect();
        columns.note = note;
        for (k, own) in columns.numbers.iter_mut().enumerate() {
            own.factor = factors[own.column];
            let in_degrees = angles == Angles::Deg && dofs.get(k).is_some_and(|dof| !dof.prismatic);
            // Degrees that a name says need no other word for it.
            if in_degrees && own.factor == 1.0 {
                own.factor = PI / 180.0;
            }
        }
        Ok(columns)
    }

    fn take_joints(
        &mut self,
        at: &mut HashMap<&str, usize>,
        dofs: &[Dof],
        any_unit: bool,
    ) -> Result<(), Message> {
        let mut missing = Vec::new();
        for dof in dofs {
            let joint = dof.joint.trim();
            match at.remove(joint) {
                Some(column) => self.push(column, joint, Bound::joint(dof, any_unit)),
                None => missing.push(joint),
            }
        }
        self.joints = 0..self.numbers.len();
        if missing.is_empty() {
            return Ok(());
        }
        let said = format!("no column for joint {}", list(&missing));
        let mut others: Vec<&str> = at.keys().copied().collect();
        others.sort_unstable();
        let meant = meant(&missing, others.iter().copied());
        if !meant.is_empty() {
            let pair = |(column, joint): &(&str, &str)| format!("{column:?} = {joint:?}");
            let pairs = meant.iter().map(pair).collect::<Vec<_>>().join(", ");
            let said = format!("{said}; if these columns are positions of joints, ");
            return Err(message![said, Setting::Columns, format!(" {{ {pairs} }}")]);
        }
        let near = suggestion(&missing, others.iter().copied());
        let has = match !others.is_empty() && near.is_empty() {
            true => format!("; the log has {}", list(&others)),
            false => String::new(),
        };
        Err(format!("{said}; columns carry the URDF's joint names{near}{has}").into())
    }

    fn take_readings(&mut self, at: &mut HashMap<&str, usize>) -> Result<(), String> {
        self.cop = self.take(at, &COP, "the CoP")?;
        self.cop_std = self.take(at, &COP_STD, "its deviation")?;
        self.load = self.take(at, &[FZ], "")?;
        let cells = (1..).map(cell).take_while(|name| at.contains_key(&**name));
        let cells: Vec<String> = cells.collect();
        let stds: Vec<String> = cells.iter().map(|name| format!("{name}{STD}")).collect();
        self.cells = self.numbers.len()..self.numbers.len() + cells.len();
        self.take(at, &cells, "")?;
        self.cell_std = self.take(at, &stds, "the cells' deviation")?;
        let beyond = at.keys().find(|name| cell_number(name).is_some());
        beyond.map_or(Ok(()), |name| {
            Err(format!(
                "column `{name}`, but no `{}`; cells count from `fsr_1` without a gap",
                cell(cells.len() + 1)
            ))
        })
    }

    /// The wrenches of sensors, which stand alone: the CoP and the total force are theirs.
    fn take_sensors(
        &mut self,
        at: &mut HashMap<&str, usize>,
        sensors: &BTreeMap<String, Sensor>,
    ) -> Result<(), String> {
        for name in sensors.keys() {
            let (own, what) = (wrench(name), format!("sensor `{}`", short(name)));
            let first = self.take(at, &own, &what);
            let first = first.map_err(|said| {
                format!("{said}; write zeros for what the sensor does not measure")
            })?;
            let first = first.ok_or_else(|| {
                format!(
                    "no columns {} of the {what} of the sidecar; name them so, or remove \
                     `[sensors.{}]`",
                    list(&own),
                    short(name)
                )
            })?;
            self.sensors.push(first);
        }
        let others = [
            (self.cop.is_some(), "columns `cop_x` and `cop_y`"),
            (!self.cells.is_empty(), "columns `fsr_1` …"),
            (self.load.is_some(), "column `fz`"),
        ];
        let other = others.iter().find(|(is, _)| *is && !sensors.is_empty());
        other.map_or(Ok(()), |(_, other)| {
            Err(format!(
                "{other} beside the wrenches of {}, which say the same; remove one of both, \
                 or `[sensors]` from the sidecar",
                list(sensors.keys())
            ))
        })
    }

    /// Take all of `names` or none; some of them is an error about `what`.
    fn take(
        &mut self,
        at: &mut HashMap<&str, usize>,
        names: &[impl AsRef<str>],
        what: &str,
    ) -> Result<Option<usize>, String> {
        let start = self.numbers.len();
        let names: Vec<&str> = names.iter().map(AsRef::as_ref).collect();
        let mut missing = names.clone();
        missing.retain(|name| !at.contains_key(name));
        if missing.len() == names.len() {
            return Ok(None);
        }
        if !missing.is_empty() {
            // `cop_x` is not meant for `cop_y`.
            let others = at.keys().copied().filter(|name| !names.contains(name));
            let near = suggestion(&missing, others);
            return Err(format!(
                "no column {}; {what} needs all of {}{near}",
                list(&missing),
                list(&names)
            ));
        }
        for name in names {
            if let Some(column) = at.remove(name) {
                let bound = meaning(name).map_or(Bound::FORCE, |own| own.bound);
                self.push(column, name, bound);
            }
        }
        Ok(Some(start))
    }

    fn push(&mut self, column: usize, name: &str, bound: Bound) {
        self.numbers.push(Number {
            column,
            name: name.to_string(),
            bound,
            factor: 1.0,
            is_needed: true,
            missing: 0,
        });
    }

    /// Whether rows carry readings.
    pub(super) fn readings(&self) -> bool {
        self.cop.is_some() || !self.cells.is_empty() || !self.sensors.is_empty()
    }
}

/// Units as programs write them, what they are of in SI units, and how many of these one is.
const UNITS: [(&str, &str, f64); 18] = [
    ("s sec seconds", "s", 1.0),
    ("ms", "s", 1e-3),
    ("us µs", "s", 1e-6),
    ("ns nsec", "s", 1e-9),
    ("min", "s", 60.0),
    ("days", "s", 86_400.0),
    ("rad radians", "rad", 1.0),
    ("deg degrees °", "rad", PI / 180.0),
    ("m", "m", 1.0),
    ("mm", "m", 1e-3),
    ("cm", "m", 1e-2),
    ("in inch", "m", 0.0254),
    ("N", "N", 1.0),
    ("kN", "N", 1e3),
    ("kgf kg", "N", 9.80665),
    ("lbf lb", "N", 4.448_221_615_260_5),
    ("Nm N·m N*m", "N m", 1.0),
    ("Nmm N·mm N*mm", "N m", 1e-3),
];
/// Names that other programs give the time of a row, in small letters: PlotJuggler, pandas,
/// rostopic, spreadsheets.
const TIMES: [&str; 6] = ["time", "__time", "timestamp", "%time", "stamp", "elapsed"];
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
    let said = "the first line has numbers, not the names of columns; write a line of names above it: \
                `pose`, the URDF's joints, `cop_x`, `cop_y`";
    are_numbers(header.iter().map(String::as_str)).then(|| said.to_string())
}

/// Whether the fields of a line that are not empty are numbers, and some are.
pub(super) fn are_numbers<'a>(fields: impl Iterator<Item = &'a str>) -> bool {
    let mut fields = fields.filter(|field| !field.is_empty()).peekable();
    fields.peek().is_some() && fields.all(|field| field.parse::<f64>().is_ok())
}

/// The names of columns with the units of a row below them, where it is one.
pub(super) fn with_units(names: &[String], fields: Vec<&str>) -> Option<Vec<String>> {
    let bare = |field: &str| {
        field
            .trim()
            .trim_matches(['[', ']', '(', ')'])
            .trim()
            .to_string()
    };
    let units: Vec<String> = fields.into_iter().map(bare).collect();
    let mut said = units.iter().filter(|text| !is_no_unit(text)).peekable();
    let are_units = said.peek().is_some() && said.all(|text| unit(text).is_some());
    (are_units && units.len() == names.len()).then(|| {
        let named = names
            .iter()
            .zip(&units)
            .map(|(name, unit)| match is_no_unit(unit) {
                true => name.clone(),
                false => format!("{name} [{unit}]"),
            });
        named.collect()
    })
}

fn is_no_unit(text: &str) -> bool {
    matches!(text, "" | "-" | "1")
}

/// What a unit is of, in SI units, and how many of these it is.
fn unit(text: &str) -> Option<(&'static str, f64)> {
    let text = text.replace(' ', "");
    let is = |names: &str| names.split(' ').any(|name| name == text);
    let known = UNITS.iter().find(|(names, ..)| is(names));
    known.map(|(_, si, factor)| (*si, *factor))
}

/// The names of columns without times and units of other programs, what brings the values to s, rad,
/// m or N, and what is said of it.
fn named(
    header: &[String],
    dofs: &[Dof],
    sensors: &BTreeMap<String, Sensor>,
) -> (Vec<String>, Vec<f64>, Option<String>) {
    let joints = dofs.iter().map(|dof| (dof.joint.trim(), dof.prismatic));
    let joints: HashMap<&str, bool> = joints.collect();
    let taken: HashSet<&str> = header.iter().map(String::as_str).collect();
    let unit_of = |name: &str| match joints.get(name) {
        Some(true) => Some("m"),
        Some(false) => Some("rad"),
        None => {
            let own = WRENCH.iter().zip(["N", "N", "N", "N m", "N m", "N m"]);
            let mut of = own.filter_map(|(end, unit)| Some((name.strip_suffix(end)?, unit)));
            let of_wrench = of.find(|(sensor, _)| sensors.contains_key(*sensor));
            let of_wrench = of_wrench.map(|(_, unit)| unit);
            of_wrench.or_else(|| meaning(name).map(|column| column.unit))
        }
    };
    let is_known = |name: &str| unit_of(name).is_some();
    let (mut names, mut factors, mut told) = (Vec::new(), Vec::new(), Vec::new());
    let mut timed = taken.contains(T);
    for name in header {
        let mut read = (name.as_str(), 1.0);
        if !is_known(name) {
            let (bare, unit) = without_unit(name, |bare| is_known(bare) || is_a_time(bare));
            let ours = if is_a_time(bare) { T } else { bare };
            let fits = unit.is_none_or(|(of, _)| unit_of(ours) == Some(of));
            let free = ours != T || !std::mem::replace(&mut timed, true);
            if is_known(ours) && fits && free && !taken.contains(ours) {
                told.push(format!("`{}` as `{ours}`", short(name)));
                read = (ours, unit.map_or(1.0, |(_, factor)| factor));
            }
        }
        names.push(read.0.to_string());
        factors.push(read.1);
    }
    let units = match factors.iter().all(|factor| *factor == 1.0) {
        true => "",
        false => ", in s, rad, m and N",
    };
    let note = (!told.is_empty()).then(|| {
        let told = listed(told, 4);
        format!("columns are read by other names{units}: {told}")
    });
    (names, factors, note)
}

fn is_a_time(name: &str) -> bool {
    TIMES.contains(&name.to_lowercase().as_str())
}

/// A name without the unit behind it: `ankle [deg]`, `t (ms)`, `cop_x_mm`.
fn without_unit(
    name: &str,
    is_known: impl Fn(&str) -> bool,
) -> (&str, Option<(&'static str, f64)>) {
    let mut brackets = [("[", ']'), ("(", ')')].into_iter();
    let bracketed = brackets.find_map(|(open, close)| {
        let (bare, text) = name.strip_suffix(close)?.rsplit_once(open)?;
        match text.trim() {
            text if is_no_unit(text) => Some((bare.trim(), None)),
            text => Some((bare.trim(), Some(unit(text)?))),
        }
    });
    let suffixed = || {
        let (bare, text) = name.rsplit_once(['_', ' '])?;
        Some((bare, Some(unit(text)?))).filter(|_| is_known(bare))
    };
    bracketed.or_else(suffixed).unwrap_or((name, None))
}

/// Joints that can have a column of their own. A joint must not be called like
/// a column that has another meaning, nor like another joint.
pub(super) fn check_joints(dofs: &[Dof]) -> Result<(), String> {
    let mut seen = HashSet::new();
    for dof in dofs {
        let name = dof.joint.trim();
        if meaning(name).is_some() {
            return Err(format!(
                "joint `{name}` is called like a column of posture logs that is no joint; \
                 rename it in the URDF"
            ));
        }
        // Readers take off marks and quotes that programs put around names.
        let quoted = name.len() > 1 && name.starts_with('"') && name.ends_with('"');
        let wrapped = quoted || name.starts_with('\u{feff}');
        if name.is_empty() || wrapped || name.contains(['\n', '\r', '\0']) {
            return Err(format!(
                "joint {:?} cannot name a column; rename it in the URDF",
                dof.joint
            ));
        }
        if !seen.insert(name) {
            return Err(format!(
                "joint `{name}` differs from another only by blanks around its name; \
                 rename it in the URDF"
            ));
        }
    }
    Ok(())
}

fn is_reading(name: &str) -> bool {
    meaning(name).is_some_and(|column| matches!(column.need, Need::Reading | Need::OfReading))
}

/// What a column of this name is, joints aside.
pub(super) fn meaning(name: &str) -> Option<&'static Column> {
    let generic = match cell_number(name) {
        Some(_) if name.ends_with(STD) => "fsr_k_std",
        Some(_) => "fsr_k",
        None if name.starts_with(CELL) => return None,
        None => name,
    };
    let mut own = COLUMNS.iter().filter(|column| column.need != Need::Always);
    own.find(|column| column.names.contains(&generic))
}

/// Columns of a sensor.
fn wrench(sensor: &str) -> [String; 6] {
    WRENCH.map(|end| format!("{sensor}{end}"))
}

/// Name of foot cell `k`, from 1.
fn cell(k: usize) -> String {
    format!("{CELL}{k}")
}

/// The `k` of `fsr_k` and `fsr_k_std`.
fn cell_number(name: &str) -> Option<usize> {
    let digits = name.strip_prefix(CELL)?;
    let digits = digits.strip_suffix(STD).unwrap_or(digits);
    let plain = digits.bytes().all(|b| b.is_ascii_digit()) && !digits.starts_with('0');
    digits.parse().ok().filter(|_| plain)
}

/// The columns of a log besides the joints.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Written {
    /// `t`
    pub t: bool,
    /// `support`
    pub support: bool,
    /// `cop_x`, `cop_y`
    pub cop: bool,
    /// `cop_x_std`, `cop_y_std`
    pub cop_std: bool,
}

/// One row; what the log has no column for is not looked at.
#[derive(Debug, Clone, Copy, Default)]
pub struct Row<'a> {
    /// Rows that share it are repeated readings.
    pub pose: i64,
    /// s
    pub t: f64,
    /// Link on the ground.
    pub support: &'a str,
    /// rad or m, in the order of the robot's joints
    pub q: &'a [f64],
    /// m, support frame
    pub cop: [f64; 2],
    /// Standard deviation of a single reading, m.
    pub cop_std: [f64; 2],
}

/// A value of a row.
pub(super) enum Field<'a> {
    Whole(i64),
    Text(&'a str),
    Number(f64),
}

/// Values of a row, in the order of their columns.
pub(super) fn fields<'a>(row: &'a Row, columns: Written) -> impl Iterator<Item = Field<'a>> {
    let pose = [Field::Whole(row.pose)].into_iter();
    let t = columns.t.then_some(Field::Number(row.t));
    let support = columns.support.then_some(Field::Text(row.support));
    let cop = columns.cop.then_some(row.cop).into_iter().flatten();
    let std = columns.cop_std.then_some(row.cop_std).into_iter().flatten();
    let numbers = row.q.iter().copied().chain(cop).chain(std);
    let first = pose.chain(t).chain(support);
    first.chain(numbers.map(Field::Number))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::logs::tests::dofs;
    use crate::tests::says;

    fn header(names: &str) -> Vec<String> {
        names.split(',').map(str::to_string).collect()
    }

    fn required() -> Options {
        Options {
            readings: Readings::Required,
            ..Options::default()
        }
    }

    /// Columns of a log with these joints, and readings.
    fn of(header: &[String], joints: &[&str]) -> Result<Columns, Message> {
        let asked = (&required(), Angles::Rad);
        Columns::of(header, &dofs(joints), asked, &BTreeMap::new())
    }

    #[test]
    fn columns_are_found_by_name_in_any_order() {
        let names = header("fsr_2,knee,,t,fsr_1,hip,note,fsr_1_std,fsr_2_std,pose");
        let columns = of(&names, &["hip", "knee"]).unwrap();
        let numbers: Vec<usize> = columns.numbers.iter().map(|own| own.column).collect();
        assert_eq!(numbers, [5, 1, 3, 4, 0, 7, 8]);
        assert_eq!((columns.joints, columns.t), (0..2, Some(2)));
        assert_eq!((columns.cells, columns.cell_std), (3..5, Some(5)));
        assert_eq!((columns.pose, columns.cop), (Some(9), None));
        assert_eq!(columns.ignored, ["note"]);
    }

    #[test]
    fn halves_and_gaps_are_refused_by_name() {
        for (names, words) in [
            ("hip,cop_x", "no column `cop_y`"),
            ("hip,cop_x,cop_y,cop_y_std", "no column `cop_x_std`"),
            ("hip,fsr_1,fsr_3", "`fsr_3`, but no `fsr_2`"),
            (
                "hip,fsr_1,fsr_2,fsr_1_std",
                "the cells' deviation needs all",
            ),
            ("hip,gravity_x,gravity_y", "no column `gravity_z`"),
            ("hip", "no readings"),
            ("hip,x,x", "`x` appears twice"),
            ("hop,cop_x,cop_y", "did you mean `hop` for `hip`"),
            (
                "hip,CoP_x,CoP_y",
                "did you mean `CoP_x` for `cop_x`, `CoP_y` for `cop_y`?",
            ),
            ("hip,cop_x,COP-y", "did you mean `COP-y` for `cop_y`?"),
        ] {
            let error = of(&header(names), &["hip"]);
            says(error.unwrap_err(), &[words]);
        }
    }

    /// Whatever the table lists is read, and nothing else is.
    #[test]
    fn the_table_lists_what_is_read() {
        let mut names = vec!["hip".to_string()];
        for column in COLUMNS.iter().filter(|column| column.need != Need::Always) {
            let first = |name: &&str| name.replace("_k", "_1");
            names.extend(column.names.iter().map(first));
        }
        let columns = of(&names, &["hip"]).unwrap();
        assert!(columns.ignored.is_empty(), "{:?}", columns.ignored);
        assert_eq!(columns.numbers.len() + 2, names.len());
        for name in &names[1..] {
            assert!(check_joints(&dofs(&[name])).is_err(), "{name}");
        }
    }

    #[test]
    fn joints_called_like_other_columns_are_refused() {
        for joint in [
            "pose", "support", "t", "cop_x", "fsr_3", " pose ", "", "a\nb",
        ] {
            assert!(check_joints(&dofs(&[joint])).is_err(), "{joint:?}");
        }
        assert!(check_joints(&dofs(&["a", " a"])).is_err());
        assert!(check_joints(&dofs(&["a", "fsr_x", "fsr_k", "pose_2", "fsr_01"])).is_ok());
    }

    #[test]
    fn units_and_times_of_other_programs_are_read() {
        let read = |header: &str| {
            let header: Vec<String> = header.split(',').map(str::to_string).collect();
            let (names, factors, note) =
                named(&header, &dofs(&["hip", "hip_mm"]), &BTreeMap::new());
            (names.join(","), factors, note)
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
        let row = |text: &'static str| {
            let names: Vec<String> = text.split(',').map(|_| "a".to_string()).collect();
            with_units(&names, text.split(',').collect())
        };
        assert_eq!(row("-,[rad],m").unwrap(), ["a", "a [rad]", "a [m]"]);
        assert_eq!(row("0,1,2"), None);
        assert_eq!(row("-,1,-"), None);
        assert_eq!(row("s,turns"), None);
    }
}

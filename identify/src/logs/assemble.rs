//! Rows made into blocks of columns: SI units, everything finite, the CoP
//! whatever it was measured with.
//!
//! Foot cells at `p_k` with forces `f_k` give
//!
//! ```text
//! CoP = Σ f_k p_k / F        F = Σ f_k
//! var CoP = Σ ((p_k − CoP) σ_k / F)²
//! ```
//!
//! the variance to first order in the independent deviations `σ_k`, since
//! `∂CoP/∂f_k = (p_k − CoP) / F`.
//!
//! Sensors whose wrenches are `f_i, τ_i` in frames that the robot has at `R_i, o_i` of a sole give, sole
//! by sole,
//!
//! ```text
//! f = Σ R_i f_i        τ = Σ R_i τ_i + o_i × R_i f_i        F p = (−τ_y, τ_x),  F = f_z
//! CoP = (F₁ p₁ + F₂ T p₂) / (F₁ + F₂)        T(q): the other sole in the support frame
//! ```
//!
//! A row that misses a value which it should have, NaN or an empty field, is left out and counted;
//! an optional column without any value in the first rows is as if it were not there.
//!
//! A column of deviations is about a single reading. The sidecar's
//! `readings_per_pose` readings of a pose are in its rows, evenly: a row alone
//! in its pose is their mean and known to `std / √readings_per_pose`; in a log
//! that lists every reading a row is known to `std`.

use std::collections::BTreeMap;
use std::f64::consts::TAU;
use std::ops::Range;
use std::sync::Arc;

use sesc_model::spelling::nearest;
use sesc_model::text::listed;
use sesc_model::tree::{Dof, is_support, like_sole};

use super::block::{Block, Frame, Share};
use super::bounds::{Bound, LEAST_LOAD_N, check_cop, three_digits};
use super::columns::{Columns, POSE};
use super::names::{list, short};
use super::settings::{Options, Readings, Sensor, Sidecar, check_gravity};
use super::source::{MISSING, Raw};
use crate::{Error, Message, Setting, message};

/// Makes blocks of raw rows.
pub(super) struct Assembler {
    pub file: String,
    /// Those without a value are none, once the first rows were seen.
    pub columns: Columns,
    /// Whether a joint turns without end.
    endless: Vec<bool>,
    sidecar: Sidecar,
    options: Options,
    support: Option<Arc<str>>,
    /// 1/√readings of a row, once the first rows were seen.
    shrink: f64,
    /// Rows without load on the cells are no fault; their reading is zero.
    pub no_load: bool,
    /// The support and the other link that stands, in a recording of both contacts.
    pub both: Option<[String; 2]>,
    /// 1 of each sensor, −1 of one that says how the robot acts on the ground.
    signs: Vec<f64>,
    next_pose: i64,
    missing: Missing,
    /// Joints, time and posture of the last row.
    last: (Vec<f64>, f64, i64),
}

/// Values that rows do not have.
#[derive(Default)]
struct Missing {
    rows: u64,
    /// The first of these rows.
    first: u64,
    /// How many rows miss a value of each column, the `pose` last.
    of: Vec<u64>,
    /// Columns that have no value at all.
    unused: Vec<usize>,
}

impl Assembler {
    pub fn new(
        file: &str,
        columns: Columns,
        dofs: &[Dof],
        sidecar: &Sidecar,
        options: &Options,
    ) -> Result<Assembler, Error> {
        let support = options.support.as_deref().or(sidecar.support.as_deref());
        let assembler = Assembler {
            file: file.to_string(),
            endless: dofs.iter().map(|dof| dof.continuous).collect(),
            sidecar: sidecar.clone(),
            options: options.clone(),
            support: support.map(Arc::from),
            shrink: 1.0,
            no_load: false,
            both: None,
            signs: vec![1.0; columns.sensors.len()],
            next_pose: 0,
            missing: Missing {
                of: vec![0; columns.numbers.len() + 1],
                ..Missing::default()
            },
            last: (Vec::new(), f64::NAN, MISSING),
            columns,
        };
        let columns = &assembler.columns;
        if let Some(link) = &assembler.support {
            let known = assembler.known_link(link);
            known.map_err(|message| match options.support {
                Some(_) => Error::request(message),
                None => assembler.fault(None, format!("sidecar: {message}")),
            })?;
        }
        let sensors = sidecar.sensors.iter().flatten();
        for (name, sensor) in sensors.filter(|_| options.readings != Readings::Ignored) {
            if let Some(frame) = &sensor.frame {
                assembler.known_frame(name, frame)?;
            }
        }
        let (found, placed) = (columns.cells.len(), assembler.places().len());
        if columns.cop.is_none() && found > 0 && found != placed {
            let message = match sidecar.cells {
                None => "foot cells without places; give `cells = [[x, y], …]` (m, support \
                         frame) in the log's sidecar"
                    .to_string(),
                Some(_) => format!(
                    "{found} columns `fsr_…`, but {placed} places under `cells` in the sidecar; \
                     give one place for each"
                ),
            };
            return Err(assembler.fault(None, message));
        }
        Ok(assembler)
    }

    /// Sensors with wrenches in the log, in the order of their names.
    fn sensors(&self) -> impl Iterator<Item = (&String, &Sensor)> {
        let all = self.sidecar.sensors.iter().flatten();
        all.take(self.columns.sensors.len())
    }

    /// Whether a sensor's frame is one of the robot's.
    fn known_frame(&self, name: &str, frame: &str) -> Result<(), Error> {
        self.known(frame).map_err(|meant| {
            let said = format!(
                "sidecar: sensor `{}` is in the frame `{}`, which is no link: {meant}; a plate on \
                 the floor has, in place of `frame`, `pose = [x, y, z, roll, pitch, yaw]` in the support \
                 frame (m, rad)",
                short(name),
                short(frame)
            );
            self.fault(None, said)
        })
    }

    /// The other sole, where sensors of two feet stand on it and the support of all rows.
    pub fn other_sole(&self) -> Option<String> {
        let said = self.options.both_feet.or(self.sidecar.both_feet);
        let support = self.support_of_all()?;
        let placed = |(_, sensor)| self.placed(&support, sensor, [[0.0; 3]; 2]);
        let soles: Vec<_> = self.sensors().filter_map(placed).collect();
        let is_own = |(sole, _): &(Option<String>, _)| sole.is_none();
        let is_of_both = said != Some(false) && soles.iter().any(is_own);
        let mut others = soles.into_iter().filter_map(|(sole, _)| sole);
        others.next().filter(|_| is_of_both)
    }

    /// The sole of a foot in whose frame a sensor is that is not the support's.
    fn sole_of(&self, support: &str, frame: &str) -> String {
        match &self.sidecar.other_foot {
            Some(named) => named.clone(),
            None if frame.contains('@') => frame.to_string(),
            None => like_sole(support, frame),
        }
    }

    /// Places of the foot cells, m.
    fn places(&self) -> &[[f64; 2]] {
        self.sidecar.cells.as_deref().unwrap_or_default()
    }

    /// A fault of the log, at a row of it.
    pub fn fault(&self, line: Option<u64>, message: impl Into<Message>) -> Error {
        Error::log(self.file.clone(), line, message)
    }

    /// Look at the first rows for what holds for all: which columns have values, whether rows
    /// are means, which way forces are counted, and whether the CoP is in metres. Gives what is odd.
    pub fn look(&mut self, raw: &mut Raw) -> Result<Vec<Message>, Error> {
        let turned = self.find_signs(raw);
        self.find_unused(raw);
        self.fill_unused(raw);
        let rows = typical_run(&raw.pose).max(1) as f64;
        let readings = self.sidecar.readings_per_pose.unwrap_or(1) as f64;
        self.shrink = (rows / readings).min(1.0).sqrt();
        let typical = |k: Option<usize>| k.and_then(|k| self.typical(raw, k));
        let Some(far) = typical(self.columns.cop) else {
            return Ok(turned);
        };
        // In no unit is that the CoP of a robot: one that is wrong by a thousand is an effect.
        let most = if self.options.any_unit { 1e4 } else { 2.0 };
        // In a log in millimetres deviations are, too: the unit is found from its readings.
        let std = typical(self.columns.cop_std).filter(|std| far <= 2.0 && *std > 0.1);
        let said: Message = if far > most {
            let far = three_digits(far);
            format!(
                "columns `cop_x`, `cop_y`: the CoP is typically {far} m from the origin of the \
                 sole; give metres, not millimetres"
            )
            .into()
        } else if let Some(std) = std {
            let said = format!(
                "columns `cop_x_std`, `cop_y_std`: a reading is typically known to {} m, more than \
                 a sole; give metres, not millimetres, or leave out the columns and give ",
                three_digits(std)
            );
            message![said, Setting::Noise]
        } else {
            return Ok(turned);
        };
        Err(self.fault(raw.line.first().copied(), said))
    }

    /// Turn sensors whose force points down where it is large: they say how the robot acts on the
    /// ground.
    fn find_signs(&mut self, raw: &Raw) -> Vec<Message> {
        let Some(support) = self.support_of(raw.support.first()) else {
            return Vec::new();
        };
        let width = self.columns.numbers.len();
        let (mut signs, mut said) = (Vec::new(), Vec::new());
        for ((name, sensor), first) in self.sensors().zip(&self.columns.sensors) {
            let up = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]].map(|axis| {
                let placed = self.placed(support, sensor, [axis, [0.0; 3]]);
                placed.map_or(axis[2], |(_, [force, _])| force[2])
            });
            let rows = raw.numbers.chunks_exact(width).map(|row| &row[*first..]);
            let force = rows.map(|own| own.iter().zip(up).map(|(f, up)| f * up).sum::<f64>());
            let mut force: Vec<f64> = force.filter(|force| force.is_finite()).collect();
            force.sort_by(|a, b| b.abs().total_cmp(&a.abs()));
            // A foot that stands in a quarter of the rows is heard.
            force.truncate(force.len().div_ceil(4));
            let typical = force.iter().sum::<f64>() / force.len().max(1) as f64;
            let is_turned = typical <= -LEAST_LOAD_N;
            signs.push(if is_turned { -1.0 } else { 1.0 });
            said.extend(is_turned.then(|| {
                Message::from(format!(
                    "{}: the force of sensor `{}` points down ({} N): it is how the robot acts on \
                     the ground; its sign is turned",
                    self.file,
                    short(name),
                    three_digits(typical)
                ))
            }));
        }
        self.signs = signs;
        said
    }

    /// Optional columns without a value.
    fn find_unused(&mut self, raw: &mut Raw) {
        let width = self.columns.numbers.len();
        let mut empty = |k: usize| raw.column(k, width).all(|x| x.is_nan());
        let columns = &mut self.columns;
        let cells = columns.cells.len();
        for (column, count) in [
            (&mut columns.t, 1),
            (&mut columns.cop_std, 2),
            (&mut columns.cell_std, cells),
            (&mut columns.gravity, 3),
            (&mut columns.load, 1),
        ] {
            if let Some(first) = column.filter(|first| (*first..first + count).any(&mut empty)) {
                self.missing.unused.extend(first..first + count);
                columns.bounds[first..first + count].fill(Bound::ANY);
                *column = None;
            }
        }
    }

    /// Bring rows to SI units; columns without a value cost no row.
    pub fn scale(&self, raw: &mut Raw) {
        let factors = &self.columns.factors;
        for (k, factor) in factors.iter().enumerate().filter(|(_, own)| **own != 1.0) {
            raw.column(k, factors.len()).for_each(|x| *x *= factor);
        }
        self.fill_unused(raw);
    }

    fn fill_unused(&self, raw: &mut Raw) {
        let width = self.columns.numbers.len();
        for k in &self.missing.unused {
            raw.column(*k, width).for_each(|x| *x = 0.0);
        }
    }

    /// What is said at the end of the log, of which `rows` are left, of values that rows do not have.
    ///
    /// # Errors
    /// A log of which no row is left.
    pub fn conclude(&self, rows: u64) -> Result<Vec<Message>, Error> {
        let missing = &self.missing;
        let named = |k: usize| self.columns.names.get(k).map_or(POSE, String::as_str);
        let mut said = Vec::new();
        if !missing.unused.is_empty() {
            let nouns = ["a column", "columns"];
            let noun = nouns[usize::from(missing.unused.len() > 1)];
            let names = list(missing.unused.iter().map(|k| named(*k)));
            said.push(format!("{noun} without a value, and not used: {names}"));
        }
        if missing.rows > 0 {
            let of = missing.of.iter().enumerate();
            let of = of.filter(|(_, count)| **count > 0);
            let of = of.map(|(k, count)| format!("`{}` in {count}", short(named(k))));
            let lost = format!(
                "{} of {} rows have no value of a column and are left out: {} (the first is row {})",
                missing.rows,
                rows + missing.rows,
                listed(of, 8),
                missing.first
            );
            if rows == 0 {
                return Err(self.fault(Some(missing.first), lost));
            }
            said.push(lost);
        }
        let named = said.iter().map(|said| format!("{}: {said}", self.file));
        Ok(named.map(Message::from).collect())
    }

    /// Take note of a row that misses values.
    fn miss(&mut self, line: u64, numbers: &[f64], pose: Option<i64>) {
        let missing = &mut self.missing;
        if missing.rows == 0 {
            missing.first = line;
        }
        missing.rows += 1;
        let without = numbers.iter().map(|x| x.is_nan());
        let without = without.chain([pose == Some(MISSING)]);
        for (count, is) in missing.of.iter_mut().zip(without) {
            *count += u64::from(is);
        }
    }

    /// The typical length of columns `k` and `k + 1`, as they stand in the log.
    fn typical(&self, raw: &Raw, k: usize) -> Option<f64> {
        let width = self.columns.numbers.len();
        let rows = raw.numbers.chunks_exact(width);
        let far = rows.map(|row| row[k].hypot(row[k + 1]));
        let mut far: Vec<f64> = far.filter(|far| far.is_finite()).collect();
        far.sort_by(f64::total_cmp);
        far.get(far.len() / 2).copied()
    }

    /// The support of all rows, where none has its own.
    pub fn support_of_all(&self) -> Option<Arc<str>> {
        let own = self.columns.support.is_some();
        self.support.clone().filter(|_| !own)
    }

    /// See [`super::PostureReader::averaged`].
    pub fn averaged(&self) -> f64 {
        1.0 - self.shrink * self.shrink
    }

    /// Append rows of `raw` to `block`.
    pub fn append(
        &mut self,
        raw: &Raw,
        rows: Range<usize>,
        block: &mut Block,
    ) -> Result<(), Error> {
        let width = self.columns.numbers.len();
        for k in rows {
            let line = raw.line[k];
            let numbers = &raw.numbers[k * width..(k + 1) * width];
            let pose = raw.pose.get(k).copied();
            if pose == Some(MISSING) || numbers.iter().fold(false, |any, x| any | x.is_nan()) {
                self.miss(line, numbers, pose);
                continue;
            }
            self.row(numbers, (raw.support.get(k), raw.other.get(k)), block)
                .and_then(|()| Ok(self.support(raw.support.get(k), block)?))
                .map_err(|message| self.fault(Some(line), self.and_others(message, raw, k + 1)))?;
            block.line.push(line);
            let pose = pose.unwrap_or(self.next_pose);
            self.unwrap(pose, block);
            block.pose.push(pose);
            self.next_pose = pose.saturating_add(1);
        }
        Ok(())
    }

    /// Joints of the newest row that turn without end, on the branch nearest to the row before
    /// where it follows that, by a second at most: programs log them within ±π.
    fn unwrap(&mut self, pose: i64, block: &mut Block) {
        let t = block.t.as_ref().and_then(|all| all.last()).copied();
        let t = t.unwrap_or(f64::NAN);
        let start = block.q.len() - self.endless.len();
        let q = &mut block.q[start..];
        let (last, last_t, last_pose) = &mut self.last;
        let follows = *last_pose == pose || (0.0..=1.0).contains(&(t - *last_t));
        for ((q, last), endless) in q.iter_mut().zip(last.iter()).zip(&self.endless) {
            if *endless && follows {
                *q -= TAU * ((*q - last) / TAU).round();
            }
        }
        last.clear();
        last.extend(&*q);
        (*last_t, *last_pose) = (t, pose);
    }

    /// What is wrong with a row, and which of those after it in `raw`, from `next` on, are faulty,
    /// too.
    fn and_others(&self, message: Message, raw: &Raw, next: usize) -> Message {
        let width = self.columns.numbers.len().max(1);
        let rows = raw.numbers.chunks_exact(width).enumerate().skip(next);
        let whole = rows.filter(|(_, numbers)| !numbers.iter().any(|x| x.is_nan()));
        let faulty = whole.filter(|(k, numbers)| {
            let own = (raw.support.get(*k), raw.other.get(*k));
            self.row(numbers, own, &mut Block::default()).is_err()
        });
        let lines: Vec<String> = faulty.map(|(k, _)| raw.line[k].to_string()).collect();
        match lines.len() {
            0 => message,
            1 => message.and(format!("; row {} is faulty, too", lines[0])),
            _ => message.and(format!("; rows {} are faulty, too", listed(lines, 12))),
        }
    }

    fn row(
        &self,
        numbers: &[f64],
        (support, other): (Option<&Arc<str>>, Option<&Share>),
        block: &mut Block,
    ) -> Result<(), Message> {
        let columns = &self.columns;
        let bounded = numbers.iter().zip(&columns.bounds);
        if !bounded
            .clone()
            .fold(true, |all, (x, bound)| all & bound.holds(*x))
        {
            let mut named = bounded.zip(&columns.names);
            named.try_for_each(|((x, bound), name)| bound.check(name, *x))?;
        }
        block.q.extend(&numbers[columns.joints.clone()]);
        if let Some(k) = columns.t {
            block.t.get_or_insert_default().push(numbers[k]);
        }
        let gravity = columns
            .gravity
            .map(|k| [0, 1, 2].map(|axis| numbers[k + axis]));
        if let Some(gravity) = gravity.or(self.sidecar.gravity) {
            check_gravity(gravity)?;
            block.gravity.get_or_insert_default().push(gravity);
        }
        if let Some(k) = columns.load {
            block.load.get_or_insert_default().push(numbers[k]);
        }
        let force = &numbers[columns.cells.clone()];
        let force_std = columns.cell_std.map(|k| -> Vec<f64> {
            let own = numbers[k..k + force.len()].iter();
            own.map(|s| s * self.shrink).collect()
        });
        if !force.is_empty() {
            let cells = block.cells.get_or_insert_default();
            cells.count = force.len();
            cells.force.extend(force);
            if let Some(std) = &force_std {
                cells.std.get_or_insert_default().extend(std);
            }
        }
        if !columns.readings() {
            return Ok(());
        }
        let pair = |k: usize| [numbers[k], numbers[k + 1]];
        let std_of_cop = || Some(pair(columns.cop_std?).map(|s| s * self.shrink));
        let (cop, std) = match columns.cop {
            Some(k) => {
                let mut cop = pair(k);
                if let (Some(other), Some([from, of])) = (other, &self.both)
                    && let Some(soles) = &self.options.soles
                {
                    let own = cop.map(|x| (1.0 - other.share) * x);
                    let q = &numbers[columns.joints.clone()];
                    cop = other.join((&**soles, [from, of]), own, (q, block));
                }
                (cop, std_of_cop())
            }
            None if !columns.sensors.is_empty() => {
                let cop = self.by_sensors(numbers, support, block)?;
                check_cop(cop)?;
                (cop, std_of_cop())
            }
            None => {
                let cop = match centre(self.places(), force) {
                    Err(_) if self.no_load => [0.0; 2],
                    cop => cop?,
                };
                check_cop(cop)?;
                let std = force_std.map(|std| deviation(self.places(), force, &std, cop));
                (cop, std)
            }
        };
        block.reading.get_or_insert_default().push(cop);
        if let Some(std) = std {
            block.std.get_or_insert_default().push(std);
        }
        Ok(())
    }

    /// The CoP of a row by wrenches, m; its block is told the total force and the other contact.
    fn by_sensors(
        &self,
        numbers: &[f64],
        support: Option<&Arc<str>>,
        block: &mut Block,
    ) -> Result<[f64; 2], Message> {
        let Some(support) = self.support_of(support) else {
            let said = "sensors measure about frames, and nothing says which link stands: give ";
            return Err(message![said, Setting::Support]);
        };
        let mut own = [[0.0; 3]; 2];
        let mut other: Option<(String, [[f64; 3]; 2])> = None;
        let sensors = self.sensors().zip(&self.columns.sensors).zip(&self.signs);
        for (((name, sensor), first), sign) in sensors {
            let of = |at: usize| [0, 1, 2].map(|axis| sign * numbers[first + at + axis]);
            let (sum, moved) = match (self.placed(support, sensor, [of(0), of(3)]), &mut other) {
                (Some((None, moved)), _) => (&mut own, moved),
                (Some((Some(sole), moved)), None) => {
                    (&mut other.insert((sole, [[0.0; 3]; 2])).1, moved)
                }
                (Some((Some(sole), moved)), Some((known, sum))) if *known == sole => (sum, moved),
                (_, known) => {
                    let sole = known.as_ref().map(|(sole, _)| sole.clone());
                    return Err(self.nowhere([support, name], sensor, sole).into());
                }
            };
            let all = sum.as_flattened_mut().iter_mut();
            all.zip(moved.as_flattened()).for_each(|(sum, x)| *sum += x);
        }
        let force = other.as_ref().map_or(0.0, |(_, [force, _])| force[2]);
        let total = own[0][2] + force;
        block.load.get_or_insert_default().push(total);
        let stands = total.abs() >= LEAST_LOAD_N;
        if !stands && !self.no_load {
            let names = list(self.sensors().map(|(name, _)| name));
            return Err(format!(
                "sensors {names}: {total:?} N in total, less than {LEAST_LOAD_N} N, so nothing \
                 stands on them; remove the row, or mend the sign or the unit"
            )
            .into());
        }
        let part = |[_, torque]: [[f64; 3]; 2]| match stands {
            true => [-torque[1] / total, torque[0] / total],
            false => [0.0; 2],
        };
        let (Some((sole, wrench)), Some(soles)) = (other, &self.options.soles) else {
            return Ok(part(own));
        };
        // A foot in the air has no CoP.
        let is_loaded = stands && force.abs() >= LEAST_LOAD_N;
        let share = if is_loaded { force / total } else { 0.0 };
        let other = Share {
            share,
            cop: part(wrench).map(|x| if is_loaded { x / share } else { 0.0 }),
        };
        let q = &numbers[self.columns.joints.clone()];
        let links = [support, &*sole];
        Ok(other.join((&**soles, links), part(own), (q, block)))
    }

    /// The link on the ground of a row that may say its own.
    fn support_of<'a>(&'a self, own: Option<&'a Arc<str>>) -> Option<&'a str> {
        let own = own.filter(|link| !link.is_empty());
        own.or(self.support.as_ref()).map(|link| &**link)
    }

    /// The wrench of a sensor in the support frame, or in that of the other sole, with its name;
    /// none of one that is fixed to neither.
    fn placed(
        &self,
        support: &str,
        sensor: &Sensor,
        wrench: [[f64; 3]; 2],
    ) -> Option<(Option<String>, [[f64; 3]; 2])> {
        if let Some(pose) = sensor.pose {
            return Some((None, Frame::posed(pose).moved(wrench)));
        }
        let link = sensor.frame.as_deref()?;
        let fixed = |sole: &str| self.options.soles.as_ref()?.fixed(sole, link);
        let moved = |sole: &str| match sole == link {
            true => Some(wrench),
            false => fixed(sole).map(|frame| frame.moved(wrench)),
        };
        if let Some(moved) = moved(support) {
            return Some((None, moved));
        }
        // Only a robot says where another link is.
        self.options.soles.as_ref()?;
        let sole = self.sole_of(support, link);
        let moved = moved(&sole)?;
        Some((Some(sole), moved))
    }

    /// Why a sensor is not placed.
    fn nowhere(&self, [support, name]: [&str; 2], sensor: &Sensor, sole: Option<String>) -> String {
        let frame = sensor.frame.as_deref().unwrap_or_default();
        let sole = sole.unwrap_or_else(|| self.sole_of(support, frame));
        let why = match &self.options.soles {
            None => "which only a robot can place: give the robot of the log".to_string(),
            Some(_) => format!(
                "which is fixed neither to `{}` nor to `{}`; name the sole that it is fixed to by \
                 `other_foot = \"…\"` in the sidecar",
                short(support),
                short(&sole)
            ),
        };
        format!("sensor `{}` is in `{}`, {why}", short(name), short(frame))
    }

    fn support(&self, own: Option<&Arc<str>>, block: &mut Block) -> Result<(), String> {
        if self.columns.support.is_none() && self.support.is_none() {
            return Ok(());
        }
        let all = block.support.get_or_insert_default();
        let own = own.filter(|link| !link.is_empty());
        if let Some(link) = own {
            // Mostly the same as in the row above.
            if all.last().is_none_or(|last| !Arc::ptr_eq(last, link)) {
                self.known_link(link)?;
            }
        }
        let link = own.or(self.support.as_ref());
        all.push(link.cloned().unwrap_or_default());
        Ok(())
    }

    fn known_link(&self, link: &str) -> Result<(), String> {
        let known = self.known(link);
        known.map_err(|meant| format!("no link `{}` to stand on; {meant}", short(link)))
    }

    /// Whether the robot has a link, where it is known; else what is meant, or what it has.
    fn known(&self, link: &str) -> Result<(), String> {
        let links = self.options.links.iter().map(String::as_str);
        if self.options.links.is_empty() || is_support(link, links.clone()) {
            return Ok(());
        }
        Err(match nearest(link, "", links.clone()) {
            Some(near) => format!("did you mean `{near}`?"),
            None => format!("the robot has {}", list(links)),
        })
    }
}

/// How many rows typically share a pose, in succession or sweep by sweep: the median over the
/// poses, without the last, which may go on.
fn typical_run(poses: &[i64]) -> usize {
    let mut counts: BTreeMap<i64, usize> = BTreeMap::new();
    for pose in poses {
        *counts.entry(*pose).or_default() += 1;
    }
    // The last pose may go on after these rows.
    if counts.len() > 1
        && let Some(last) = poses.last()
    {
        counts.remove(last);
    }
    let mut runs: Vec<usize> = counts.into_values().collect();
    runs.sort_unstable();
    runs.get(runs.len() / 2).copied().unwrap_or(1)
}

/// CoP of forces `f` at `places`.
fn centre(places: &[[f64; 2]], f: &[f64]) -> Result<[f64; 2], String> {
    let total: f64 = f.iter().sum();
    let moment = |axis: usize| f.iter().zip(places).map(|(f, p)| f * p[axis]).sum::<f64>();
    let cop = [moment(0) / total, moment(1) / total];
    if total >= LEAST_LOAD_N && total.is_finite() && cop.iter().all(|x| x.is_finite()) {
        Ok(cop)
    } else {
        Err(format!(
            "columns `fsr_1` … `fsr_{}`: {total:?} N in total, less than {LEAST_LOAD_N} N, so \
             nothing stands on the cells; remove the row, or mend the sign or the unit",
            f.len()
        ))
    }
}

/// Deviation of a CoP from those of its forces, to first order; 1 m where that says nothing.
fn deviation(places: &[[f64; 2]], f: &[f64], std: &[f64], cop: [f64; 2]) -> [f64; 2] {
    let total: f64 = f.iter().sum();
    [0, 1].map(|axis| {
        let parts = places.iter().zip(std);
        let parts = parts.map(|(place, std)| ((place[axis] - cop[axis]) * std / total).powi(2));
        let own = parts.sum::<f64>().sqrt();
        if own.is_finite() { own } else { 1.0 }
    })
}

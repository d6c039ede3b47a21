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
use super::bounds::{LEAST_LOAD_N, check_cop, three_digits};
use super::columns::{Columns, POSE};
use super::names::{list, short};
use super::settings::{Options, Readings, Sensor, Sidecar, check_gravity};
use super::source::{MISSING, Raw};
use crate::{Error, Message, Setting, message};

/// Makes blocks of raw rows.
pub(super) struct Assembler {
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
    /// Rows that miss a value, the first of them, and those that miss the pose.
    missing: u64,
    first_missing: Option<u64>,
    missing_poses: u64,
    /// Joints, time and posture of the last row.
    last: (Vec<f64>, f64, i64),
}

impl Assembler {
    pub(super) fn new(
        columns: Columns,
        dofs: &[Dof],
        sidecar: &Sidecar,
        options: &Options,
    ) -> Result<Assembler, Error> {
        let support = options.support.as_deref().or(sidecar.support.as_deref());
        let assembler = Assembler {
            endless: dofs.iter().map(|dof| dof.continuous).collect(),
            sidecar: sidecar.clone(),
            options: options.clone(),
            support: support.map(Arc::from),
            shrink: 1.0,
            no_load: false,
            both: None,
            signs: vec![1.0; columns.sensors.len()],
            next_pose: 0,
            missing: 0,
            first_missing: None,
            missing_poses: 0,
            last: (Vec::new(), f64::NAN, MISSING),
            columns,
        };
        let columns = &assembler.columns;
        if let Some(link) = &assembler.support {
            let known = assembler.known_link(link);
            known.map_err(|message| match options.support {
                Some(_) => Error::request(message),
                None => Error::row(None, format!("sidecar: {message}")),
            })?;
        }
        let sensors = sidecar.sensors.iter().flatten();
        for (name, sensor) in sensors.filter(|_| options.readings != Readings::Ignored) {
            let Some(frame) = &sensor.frame else { continue };
            assembler.known(frame).map_err(|meant| {
                let said = format!(
                    "sidecar: sensor `{}` is in the frame `{}`, which is no link: {meant}; a plate \
                     on the floor has, in place of `frame`, `pose = [x, y, z, roll, pitch, yaw]` in \
                     the support frame (m, rad)",
                    short(name),
                    short(frame)
                );
                Error::row(None, said)
            })?;
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
            return Err(Error::row(None, message));
        }
        Ok(assembler)
    }

    /// Sensors with wrenches in the log, in the order of their names.
    fn sensors(&self) -> impl Iterator<Item = (&String, &Sensor)> {
        let all = self.sidecar.sensors.iter().flatten();
        all.take(self.columns.sensors.len())
    }

    /// The other sole, where sensors of two feet stand on it and the support of all rows.
    pub(super) fn other_sole(&self) -> Option<String> {
        let said = self.options.both_feet.or(self.sidecar.both_feet);
        let support = self.support_of_all()?;
        let place = |(name, sensor): (&String, &Sensor)| self.place([&support, name], sensor).ok();
        let soles: Vec<_> = self.sensors().filter_map(place).collect();
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

    /// Look at the first rows for what holds for all: which columns have values, whether rows
    /// are means, which way forces are counted, and whether the CoP is in metres. Gives what is odd.
    pub(super) fn look(&mut self, raw: &Raw) -> Result<Vec<String>, Error> {
        let turned = self.find_signs(raw);
        self.find_unused(raw);
        let rows = typical_run(&raw.pose).max(1) as f64;
        let readings = self.sidecar.readings_per_pose.unwrap_or(1) as f64;
        self.shrink = (rows / readings).min(1.0).sqrt();
        let typical = |k: Option<usize>| k.and_then(|k| typical_length(&raw.numbers[k..k + 2]));
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
        Err(Error::row(raw.line.first().copied(), said))
    }

    /// Turn sensors whose force points down where it is large: they say how the robot acts on the
    /// ground.
    fn find_signs(&mut self, raw: &Raw) -> Vec<String> {
        let Some(support) = self.support_of(raw.support.first()) else {
            return Vec::new();
        };
        let (mut signs, mut said) = (Vec::new(), Vec::new());
        for ((name, sensor), first) in self.sensors().zip(&self.columns.sensors) {
            let placed = self.place([support, name], sensor);
            let frame = placed.ok().and_then(|(_, frame)| frame);
            let up = frame.map_or([0.0, 0.0, 1.0], |frame| frame.axes.map(|axis| axis[2]));
            let upward = |row: usize| (0..3).map(|k| raw.numbers[first + k][row] * up[k]).sum();
            let force = (0..raw.line.len()).map(upward);
            let mut force: Vec<f64> = force.filter(|force: &f64| force.is_finite()).collect();
            force.sort_by(|a, b| b.abs().total_cmp(&a.abs()));
            // A foot that stands in a quarter of the rows is heard.
            force.truncate(force.len().div_ceil(4));
            let typical = force.iter().sum::<f64>() / force.len().max(1) as f64;
            let is_turned = typical <= -LEAST_LOAD_N;
            signs.push(if is_turned { -1.0 } else { 1.0 });
            said.extend(is_turned.then(|| {
                format!(
                    "the force of sensor `{}` points down ({} N): it is how the robot acts on the \
                     ground; its sign is turned",
                    short(name),
                    three_digits(typical)
                )
            }));
        }
        self.signs = signs;
        said
    }

    /// Optional columns without a value.
    fn find_unused(&mut self, raw: &Raw) {
        let empty = |k: usize| raw.numbers[k].iter().all(|x| x.is_nan());
        let columns = &mut self.columns;
        let cells = columns.cells.len();
        for (column, count) in [
            (&mut columns.t, 1),
            (&mut columns.cop_std, 2),
            (&mut columns.cell_std, cells),
            (&mut columns.gravity, 3),
            (&mut columns.load, 1),
        ] {
            if let Some(first) = column.filter(|first| (*first..first + count).any(empty)) {
                let own = &mut columns.numbers[first..first + count];
                own.iter_mut().for_each(|own| own.is_needed = false);
                *column = None;
            }
        }
    }

    /// Bring rows to SI units; columns without a value cost no row.
    pub(super) fn scale(&self, raw: &mut Raw) {
        for (own, values) in self.columns.numbers.iter().zip(&mut raw.numbers) {
            if own.factor != 1.0 {
                values.iter_mut().for_each(|x| *x *= own.factor);
            }
        }
    }

    /// What is said at the end of the log, of which `rows` are left, of values that rows do not have.
    ///
    /// # Errors
    /// A log of which no row is left.
    pub(super) fn conclude(&self, rows: u64) -> Result<Vec<String>, Error> {
        let mut said = Vec::new();
        let unused = self.columns.numbers.iter().filter(|own| !own.is_needed);
        let unused: Vec<&String> = unused.map(|own| &own.name).collect();
        if !unused.is_empty() {
            let noun = ["a column", "columns"][usize::from(unused.len() > 1)];
            let names = list(unused);
            said.push(format!("{noun} without a value, and not used: {names}"));
        }
        if let Some(first) = self.first_missing {
            let numbers = self.columns.numbers.iter();
            let counts = numbers.map(|own| (&*own.name, own.missing));
            let counts = counts.chain([(POSE, self.missing_poses)]);
            let of = counts.filter(|(_, count)| *count > 0);
            let of = of.map(|(name, count)| format!("`{}` in {count}", short(name)));
            let lost = format!(
                "{} of {} rows have no value of a column and are left out: {} (the first is row \
                 {first})",
                self.missing,
                rows + self.missing,
                listed(of, 8)
            );
            if rows == 0 {
                return Err(Error::row(Some(first), lost));
            }
            said.push(lost);
        }
        Ok(said)
    }

    /// The support of all rows, where none has its own.
    pub(super) fn support_of_all(&self) -> Option<Arc<str>> {
        let own = self.columns.support.is_some();
        self.support.clone().filter(|_| !own)
    }

    /// See [`super::PostureReader::averaged`].
    pub(super) fn averaged(&self) -> f64 {
        1.0 - self.shrink * self.shrink
    }

    /// Append rows of `raw` to `block`.
    pub(super) fn append(
        &mut self,
        raw: &Raw,
        rows: Range<usize>,
        block: &mut Block,
    ) -> Result<(), Error> {
        let mut numbers = Vec::new();
        for k in rows {
            let line = raw.line[k];
            numbers.clear();
            numbers.extend(raw.row(k));
            let pose = raw.pose.get(k).copied();
            let mut is_missing = pose == Some(MISSING);
            self.missing_poses += u64::from(is_missing);
            for (x, own) in numbers.iter().zip(&mut self.columns.numbers) {
                let lacks = x.is_nan() && own.is_needed;
                own.missing += u64::from(lacks);
                is_missing |= lacks;
            }
            if is_missing {
                self.missing += 1;
                self.first_missing.get_or_insert(line);
                continue;
            }
            self.row(&numbers, (raw.support.get(k), raw.other.get(k)), block)
                .and_then(|()| Ok(self.support(raw.support.get(k), block)?))
                .map_err(|message| Error::row(Some(line), self.and_others(message, raw, k + 1)))?;
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
        let faulty = (next..raw.line.len()).filter(|k| {
            let numbers: Vec<f64> = raw.row(*k).collect();
            let own = (raw.support.get(*k), raw.other.get(*k));
            let mut known = numbers.iter().zip(&self.columns.numbers);
            let is_whole = known.all(|(x, own)| !x.is_nan() || !own.is_needed);
            is_whole && self.row(&numbers, own, &mut Block::default()).is_err()
        });
        let lines: Vec<String> = faulty.map(|k| raw.line[k].to_string()).collect();
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
        let bounded = numbers.iter().zip(&columns.numbers);
        let mut odd = bounded.filter(|(x, own)| own.is_needed && !own.bound.holds(**x));
        odd.try_for_each(|(x, own)| own.bound.check(&own.name, *x))?;
        let q = &numbers[columns.joints.clone()];
        block.q.extend(q);
        push(&mut block.t, columns.t.map(|k| numbers[k]));
        let of_row = columns
            .gravity
            .map(|k| [0, 1, 2].map(|axis| numbers[k + axis]));
        let gravity = of_row.or(self.sidecar.gravity);
        gravity.map_or(Ok(()), check_gravity)?;
        push(&mut block.gravity, gravity);
        push(&mut block.load, columns.load.map(|k| numbers[k]));
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
        let mut std = columns.cop_std.map(|k| pair(k).map(|s| s * self.shrink));
        let cop = if let Some(k) = columns.cop {
            let cop = pair(k);
            match (other, &self.both, &self.options.soles) {
                (Some(other), Some([from, of]), Some(soles)) => {
                    let own = cop.map(|x| (1.0 - other.share) * x);
                    other.join((&**soles, [from, of]), own, (q, block))
                }
                _ => cop,
            }
        } else if columns.sensors.is_empty() {
            let cop = match centre(self.places(), force) {
                Err(_) if self.no_load => [0.0; 2],
                cop => cop?,
            };
            std = force_std.map(|std| deviation(self.places(), force, &std, cop));
            cop
        } else {
            self.by_sensors(numbers, support, block)?
        };
        if columns.cop.is_none() {
            check_cop(cop)?;
        }
        push(&mut block.reading, Some(cop));
        push(&mut block.std, std);
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
            let (sole, frame) = self.place([support, name], sensor)?;
            let sum = match (sole, &mut other) {
                (None, _) => &mut own,
                (Some(sole), None) => &mut other.insert((sole, [[0.0; 3]; 2])).1,
                (Some(sole), Some((known, sum))) if *known == sole => sum,
                (_, Some((known, _))) => {
                    return Err(self.nowhere([support, name], sensor, known).into());
                }
            };
            let read = [of(0), of(3)];
            let moved = frame.map_or(read, |frame| frame.moved(read));
            let all = sum.as_flattened_mut().iter_mut();
            all.zip(moved.as_flattened()).for_each(|(sum, x)| *sum += x);
        }
        let force = other.as_ref().map_or(0.0, |(_, [force, _])| force[2]);
        let total = own[0][2] + force;
        push(&mut block.load, Some(total));
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

    /// Where a sensor is in the support frame, or in that of the other sole, with its name; none
    /// where its frame is that one.
    ///
    /// # Errors
    /// Why one that is fixed to neither is not placed.
    fn place(
        &self,
        [support, name]: [&str; 2],
        sensor: &Sensor,
    ) -> Result<(Option<String>, Option<Frame>), String> {
        if let Some(pose) = sensor.pose {
            return Ok((None, Some(Frame::posed(pose))));
        }
        let link = sensor.frame.as_deref().unwrap_or_default();
        let soles = self.options.soles.as_ref();
        let on = |sole: &str| match sole == link {
            true => Some(None),
            false => soles?.fixed(sole, link).map(Some),
        };
        if let Some(frame) = on(support) {
            return Ok((None, frame));
        }
        let sole = self.sole_of(support, link);
        // Only a robot says where another link is.
        match on(&sole).filter(|_| soles.is_some()) {
            Some(frame) => Ok((Some(sole), frame)),
            None => Err(self.nowhere([support, name], sensor, &sole)),
        }
    }

    /// Why a sensor is not placed.
    fn nowhere(&self, [support, name]: [&str; 2], sensor: &Sensor, sole: &str) -> String {
        let frame = sensor.frame.as_deref().unwrap_or_default();
        let why = match &self.options.soles {
            None => "which only a robot can place: give the robot of the log".to_string(),
            Some(_) => format!(
                "which is fixed neither to `{}` nor to `{}`; name the sole that it is fixed to by \
                 `other_foot = \"…\"` in the sidecar",
                short(support),
                short(sole)
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

/// Append the value of a row to a column that the log has.
fn push<T>(column: &mut Option<Vec<T>>, value: Option<T>) {
    if let Some(value) = value {
        column.get_or_insert_default().push(value);
    }
}

/// The typical length of vectors in the plane.
fn typical_length(columns: &[Vec<f64>]) -> Option<f64> {
    let far = columns[0].iter().zip(&columns[1]).map(|(x, y)| x.hypot(*y));
    let mut far: Vec<f64> = far.filter(|far| far.is_finite()).collect();
    far.sort_by(f64::total_cmp);
    far.get(far.len() / 2).copied()
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

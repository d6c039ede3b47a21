//! Rows of a log as they are, before anything is averaged or fitted.
//!
//! ```text
//! contact    Σ f ≈ 0, or a CoP of exactly (0, 0) where CAD is elsewhere
//! outside    a CoP beyond the sole and every CoP that CAD predicts
//! frozen     a reading that stays the same to the last digit while the joints move
//! channels   a CoP or a cell that ends at one value, or moves in coarse steps
//! copies     the same joints and the same reading, to the last digit, once more
//! noise      stated noise that is several times what CAD leaves
//! leaps      joints that move faster than they can
//! held       a total force that is less than the weight for a while, or has two levels
//! load       a total force that is not the weight; a second sole on the floor
//! stamps     joints jump from stamp to stamp and not from row to row, or time runs backwards
//! ```
//!
//! Of a short log all rows are looked at, of a long one, whatever its format, stretches:
//!
//! ```text
//! │ BLOCK rows │   │ PIECE │   │ PIECE │  …  │ PIECE │        ROWS in all, the last at the end
//! ```
//!
//! Between the pieces the file is passed over without being parsed; messages of a recording (MCAP)
//! are read, and their rows not kept. A log whose length is not known (a pipe) is looked at from
//! its first row on. What is found wrong is left out of the whole log by a
//! [`Screen`](crate::logs::Screen), and the rest is used.

pub(crate) use contact::sole_of;

mod channels;
mod contact;
pub(super) mod noise;
mod screen;
mod times;
mod weight;

use std::f64::consts::PI;
use std::sync::Arc;

use nalgebra::{DMatrix, DVector};
use sesc_model::tree::Dof;
use sesc_model::{Function, Model};

use super::criteria::{FEW_ROWS, UNKNOWN_NOISE_M};
use super::finding::{Finding, Kind, Picture, Row};
use super::view::{On, View, evenly};
use crate::Error;
use crate::evaluate::Evaluator;
use crate::logs::{BLOCK, Block, LogSource, Options, PostureReader, ROOM, Samples, Weight};
use crate::observations::correlation;
use crate::observations::criteria::noise::SHOWS;
use crate::observations::motion::{Plan, Wanted};
use crate::observations::postures::{Postures, rms};
use crate::observations::rows::CopRows;
use crate::observations::zmp::Zmp;
use crate::watch::{Watch, tell};
pub(super) use screen::{LeftOut, LessKnown};
use weight::Weighed;

/// Rows that are looked at, at most.
const ROWS: usize = 50_000;
/// Rows between gaps: 10 s at 100 Hz.
const PIECE: usize = 1024;

/// Rows of a log on one support.
#[derive(Default)]
pub(super) struct LogRows {
    /// Empty of a log without readings.
    pub block: Block,
    pub dof: usize,
    /// Whether the log has more rows than are here.
    pub is_part: bool,
    /// What is said of the feet, by the caller or the sidecar.
    pub both_feet: Option<bool>,
    /// Places of the cells, m.
    pub places: Vec<[f64; 2]>,
    /// Noise of a row, m, where it is known: RMS where rows have their own.
    pub noise: Option<f64>,
    /// CoP by CAD, m.
    pub cad: Vec<[f64; 2]>,
    /// Corners of the sole, m, where the URDF has its shape.
    pub sole: Option<[[f64; 2]; 2]>,
}

impl LogRows {
    pub(super) fn len(&self) -> usize {
        self.block.len()
    }

    pub(super) fn readings(&self) -> &[[f64; 2]] {
        self.block.reading.as_deref().unwrap_or_default()
    }

    /// s; empty of logs without.
    pub(super) fn times(&self) -> &[f64] {
        self.block.t.as_deref().unwrap_or_default()
    }

    pub(super) fn q(&self, row: usize) -> &[f64] {
        self.block.joints(row)
    }

    /// Forces of the cells of a row, N; none where the log has a CoP.
    pub(super) fn force(&self, row: usize) -> &[f64] {
        self.block.forces(row)
    }

    /// Cells of a row.
    pub(super) fn cells(&self) -> usize {
        self.block.cells.as_ref().map_or(0, |cells| cells.count)
    }

    /// Total force of a row, N; NaN of a log without.
    fn load(&self, row: usize) -> f64 {
        self.block.total_force(row).unwrap_or(f64::NAN)
    }

    /// Number of a row from 1: among those on this support, or in the log where not all are here.
    pub(super) fn number(&self, row: usize) -> usize {
        let before = self.block.line[row].saturating_sub(self.block.line[0]);
        1 + if self.is_part { before as usize } else { row }
    }

    /// Some of the rows, in words that say what they are part of where that is not the log.
    pub(super) fn some(&self, count: usize) -> String {
        if self.is_part {
            return format!("{count} of {}", self.total());
        }
        format!("{count} rows")
    }

    /// All rows, in words that say what they are part of.
    pub(super) fn total(&self) -> String {
        let part = self.is_part.then_some(" that were looked at");
        format!("{} rows{}", self.len(), part.unwrap_or_default())
    }

    /// A row as figures show it.
    pub(super) fn row(&self, row: usize) -> Row {
        Row {
            number: self.number(row),
            ..Row::among(&self.block.pose, &self.block.q, row)
        }
    }

    /// A finding with a picture of one value of every row.
    pub(super) fn finding(
        &self,
        (kind, target, sentence): (Kind, &str, String),
        title: &str,
        value: impl Fn(usize) -> f64,
        meant: impl Fn(usize) -> bool,
    ) -> Finding {
        let values = |k: usize| vec![(value(k), meant(k))];
        let picture = Picture::new(title, self.len(), |k| self.row(k), values);
        Finding::new(kind, target, sentence).showing(picture)
    }

    /// Some of the rows as postures, with the readings that are given.
    fn view<'a>(&self, on: On<'a>, read: &[(usize, [f64; 2])]) -> View<'a> {
        let q: Vec<f64> = read.iter().flat_map(|(k, _)| self.q(*k)).copied().collect();
        let pose: Vec<i64> = read.iter().map(|(k, _)| self.block.pose[*k]).collect();
        let cop: Vec<f64> = read.iter().flat_map(|(_, y)| *y).collect();
        let data = Postures::of_rows(self.dof, (&pose, &q, &cop), self.noise, 0.0);
        View::new(on, data)
    }

    /// Some of the rows with their readings as they are.
    pub(super) fn as_read(&self, rows: &[usize]) -> Vec<(usize, [f64; 2])> {
        rows.iter().map(|&k| (k, self.readings()[k])).collect()
    }

    /// Distance of the reading from the origin, m.
    fn distance(&self, row: usize) -> f64 {
        let [x, y] = self.readings()[row];
        x.hypot(y)
    }

    /// Rows that stay by these rules, stopped encoders and copies aside.
    pub(super) fn kept(&self, rules: &LeftOut) -> Vec<usize> {
        let stays = |&k: &usize| rules.keeps(&self.block, k);
        (0..self.len()).filter(stays).collect()
    }

    /// Rows of a log that stand on the model's support.
    ///
    /// # Errors
    /// What is wrong with the log: also that its rows are copies of one or two.
    pub(super) fn read(
        samples: &Samples,
        On { robot, model, .. }: On,
        noise: Option<f64>,
        watch: &mut dyn Watch,
    ) -> Result<LogRows, Error> {
        let (mut rows, averaged) = LogRows::gather(samples, Some(model.support()), watch)?;
        if let Some(noise) = noise {
            rows.noise = Some(noise * (1.0 - averaged).sqrt());
            rows.block.std = None;
        }
        channels::check_distinct(&rows, samples.log.name())?;
        rows.sole = sole_of(robot, model);
        let cop = Evaluator::new(model, Function::Cop).fastest();
        rows.cad = cop.run(&rows.block.q, rows.len()).as_chunks().0.to_vec();
        Ok(rows)
    }

    /// Rows of a log that stand on `support`, or on any, and how much of the variance of a
    /// single reading they have averaged.
    fn gather(
        samples: &Samples,
        support: Option<&str>,
        watch: &mut dyn Watch,
    ) -> Result<(LogRows, f64), Error> {
        let mut reader = samples.all_rows()?;
        let sidecar = &samples.sidecar;
        let mut rows = LogRows {
            dof: samples.dof(),
            places: sidecar.cells.clone().unwrap_or_default(),
            both_feet: samples.options.both_feet.or(sidecar.both_feet),
            ..LogRows::default()
        };
        let mut sample = Sample::default();
        while let Some(mut block) = sample.next(&mut reader)? {
            if let (Some(all), Some(support)) = (&block.support, support) {
                let here = |link: &Arc<str>| link.is_empty() || **link == *support;
                let here: Vec<bool> = all.iter().map(here).collect();
                block.retain(&here);
            }
            if block.reading.is_some() {
                rows.block.append(block);
            }
            let (done, total) = reader.progress();
            tell(watch, "looking", done, total)?;
        }
        if let Some(std) = &rows.block.std {
            rows.noise = Some(rms(std.iter().flatten().copied()));
        }
        rows.is_part = sample.is_part;
        Ok((rows, reader.averaged()))
    }

    /// What free masses, and what CAD's CoM does to the CoP where it is accelerated, leave of
    /// one channel, m, in some of the rows; none where these are too few to tell.
    fn left_by_masses(&self, model: &Model, rows: &[usize], channel: usize) -> Option<f64> {
        let rows = evenly(rows.iter().copied(), 1000);
        let q: Vec<f64> = rows.iter().flat_map(|&k| self.q(k)).copied().collect();
        let of_masses = CopRows::new(model).fastest().of(&q, rows.len(), None);
        // CAD's CoP bends as its acceleration does, over 0.15 s either way.
        let step = correlation::step(self.times());
        let reach = step.map_or(self.len(), |step| (0.15 / step).round().max(1.0) as usize);
        let bend = |row: usize| {
            let at = |row: usize| self.cad[row][channel];
            let inside = row >= reach && row + reach < self.len();
            inside.then(|| at(row - reach) - 2.0 * at(row) + at(row + reach))
        };
        let count = of_masses.ncols();
        let x = DMatrix::from_fn(rows.len(), count + 1, |k, column| match column < count {
            true => of_masses[(2 * k + channel, column)],
            false => bend(rows[k]).unwrap_or(0.0),
        });
        let y = DVector::from_fn(rows.len(), |k, _| self.readings()[rows[k]][channel]);
        let (square, df) = correlation::left(&x, &y);
        (df >= FEW_ROWS as f64).then(|| square.sqrt())
    }

    /// The `chosen` rows as postures: as they were read, and without what motion adds to their
    /// readings where they are far from CAD.
    pub(super) fn views<'a>(&self, chosen: &[usize], on: On<'a>) -> Vec<View<'a>> {
        let mut views = vec![self.view(on, &self.as_read(chosen))];
        let gap = |&k: &usize| [0, 1].map(|axis| self.readings()[k][axis] - self.cad[k][axis]);
        let least = self.noise.map_or(UNKNOWN_NOISE_M, |noise| SHOWS * noise);
        if rms(chosen.iter().flat_map(gap)) >= least {
            let still = self.still(chosen, on.model);
            views.extend(still.map(|still| self.view(on, &still)));
        }
        views
    }

    /// Those of the `chosen` rows whose motion is known, and their readings as of a robot that
    /// stands, y − (ZMP − CoP) by CAD; none where it does stand, or the log is not dense enough
    /// in time.
    fn still(&self, chosen: &[usize], model: &Model) -> Option<Vec<(usize, [f64; 2])>> {
        let (t, q) = (self.block.t.as_ref()?, &self.block.q);
        let plan = Plan::of(t, q, self.dof)?;
        let (zmp, cad) = (Zmp::new(model), model.cad_params());
        let mut still = Vec::new();
        // The motion of all rows takes more memory than the rows.
        for start in (0..self.len()).step_by(BLOCK) {
            let rows = start..self.len().min(start + BLOCK);
            let mut known: Vec<usize> = chosen.to_vec();
            known.retain(|k| rows.contains(k));
            if known.is_empty() {
                continue;
            }
            let motion = plan.motion((t, q, self.dof), rows, Wanted::Alone)?;
            known.retain(|k| motion.known[k - start]);
            let of = |all: &[f64]| -> Vec<f64> {
                let row = |k: &usize| &all[(k - start) * self.dof..(k + 1 - start) * self.dof];
                known.iter().flat_map(row).copied().collect()
            };
            let (rates, gains) = (of(&motion.rates), of(&motion.gains));
            let q = of(&q[start * self.dof..]);
            let level = vec![[0.0; 2]; known.len()];
            let shifts = zmp.shifts(&cad, &q, (&rates, &gains), &level);
            still.extend(known.iter().zip(shifts).map(|(&k, shift)| {
                let y = self.readings()[k];
                (k, [0, 1].map(|axis| y[axis] - shift[axis]))
            }));
        }
        (!still.is_empty()).then_some(still)
    }
}

/// What is wrong with the rows of a log of no known robot: every column that means nothing
/// else is a joint.
pub(super) fn alone(log: &LogSource, watch: &mut dyn Watch) -> Result<Vec<Finding>, Error> {
    let options = Options {
        any_unit: true,
        ..Options::default()
    };
    let reader = PostureReader::open(log, &[], &options)?;
    let names = reader.unknown_columns().iter();
    let joints = names.filter(|name| !name.is_empty()).map(|joint| Dof {
        joint: joint.clone(),
        prismatic: false,
        continuous: false,
        lower: -PI,
        upper: PI,
        speed: 1.0,
    });
    let samples = Samples::of_joints(log, joints.collect(), &options, ROOM, watch)?;
    let (rows, _) = LogRows::gather(&samples, None, watch)?;
    let (mut left_out, mut findings) = (LeftOut::default(), Vec::new());
    if rows.len() < FEW_ROWS {
        return Ok(findings);
    }
    if rows.cells() > 0 {
        findings.extend(contact::lost(&rows, &mut left_out));
    }
    findings.extend(contact::unplugged(&rows));
    findings.extend(channels::saturated(&rows, None, &mut left_out));
    findings.extend(channels::copied(&rows, &mut left_out));
    findings.extend(times::stamps_of_other_rows(&rows));
    Ok(findings)
}

/// What is wrong with rows, and what to leave out.
pub(super) fn judge(rows: &LogRows, on: On) -> (LeftOut, Vec<Finding>, Option<Weight>) {
    let mut left_out = LeftOut::default();
    let (mut findings, mut weight) = (Vec::new(), None);
    if rows.len() < FEW_ROWS {
        return (left_out, findings, weight);
    }
    let model = on.model;
    findings.extend(times::stamps_of_other_rows(rows));
    findings.extend(contact::lost(rows, &mut left_out));
    findings.extend(contact::unplugged(rows));
    findings.extend(contact::unlike_weight(rows, model, &left_out));
    if let Some(mut weighed) = Weighed::new(rows, model, &left_out) {
        findings.extend(weighed.held(&mut left_out));
        let (found, levels) = weighed.weight();
        findings.extend(levels);
        weight = found;
    }
    findings.extend(contact::both_flat(rows, model));
    findings.extend(contact::outside(rows, on, &mut left_out));
    findings.extend(channels::frozen(rows, &mut left_out));
    findings.extend(channels::saturated(rows, Some(model), &mut left_out));
    let copied = channels::copied(rows, &mut left_out);
    // Where rows are copies, joints leap to them and back.
    let leaps = || times::leaps(rows, &model.tree.dofs);
    findings.extend(copied.or_else(leaps));
    findings.extend(noise::beside_cad(rows, model, &left_out));
    (left_out, findings, weight)
}

/// How far a log was looked at.
#[derive(Default)]
struct Sample {
    /// Rows that were taken.
    taken: usize,
    /// Rows that were passed over, about.
    passed: u64,
    /// Pieces that are to come; none where rows follow each other.
    to_come: Option<u64>,
    /// Whether rows may be left that were not looked at.
    is_part: bool,
}

impl Sample {
    /// The next rows that are looked at; none after the last.
    ///
    /// # Errors
    /// What is wrong with the log.
    fn next(&mut self, reader: &mut PostureReader) -> Result<Option<Block>, Error> {
        let block = match self.to_come {
            _ if self.taken >= ROWS => return Ok(None),
            // Rows of the end may still wait for the end of their stay.
            Some(0) => reader.block(PIECE).unwrap_or_default(),
            Some(pieces) => {
                let between = (self.rows_left(reader) / pieces).saturating_sub(PIECE as u64);
                (self.passed, self.to_come) = (self.passed + between, Some(pieces - 1));
                // Behind a gap a quoted line end may look like a row; who reads all of the log
                // says what is wrong with it.
                let piece = reader.skip(between, PIECE);
                piece.and_then(|_| reader.block(PIECE)).unwrap_or_default()
            }
            None => {
                // Before the first gap: a chunk of the reader, which tells how long rows are.
                let block = reader.block(BLOCK)?;
                let left = ROWS - BLOCK;
                let is_long = self.taken == 0 && self.rows_left(reader) > left as u64;
                if is_long && reader.skip(0, PIECE)? {
                    (self.to_come, self.is_part) = (Some((left / PIECE) as u64), true);
                }
                block
            }
        };
        self.taken += block.len();
        self.is_part |= self.taken >= ROWS;
        Ok((!block.is_empty()).then_some(block))
    }

    /// About so many rows are behind the last one, if they are as long as those before; 0 where
    /// that is not known.
    fn rows_left(&self, reader: &PostureReader) -> u64 {
        let (done, total) = reader.progress();
        // More than were given out where rows wait for the end of their stay.
        let rows = (reader.taken() + self.passed).max(1);
        let per_row = done as f64 / rows as f64;
        (total.unwrap_or(0).saturating_sub(done) as f64 / per_row.max(1e-9)) as u64
    }
}

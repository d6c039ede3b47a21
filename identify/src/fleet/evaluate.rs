//! The row of a group: a pure function of its URDF, its options and what its logs hold.
//!
//! ```text
//! logs, sorted by the hash of their content ─▶ one log  ─▶ diagnosis
//!                                           └▶ part of each log ─▶ one part ─▶ fit
//! ```

use std::mem;
use std::sync::Arc;

use super::log::{Log, each_once, row_of, without_path};
use super::row::{Row, SCORES};
use super::{Only, Options};
use crate::diagnose::diagnose;
use crate::fit::part::Part;
use crate::fit::prior::{Prior, PriorChoice};
use crate::fit::{fit, gather_as};
use crate::health::Kind;
use crate::logs::{Block, LogSource, Options as Reading, PostureReader, Readings, Sidecar, Table};
use crate::robot::Robot;
use crate::watch::Watch;
use crate::{Error, ErrorKind, Message, diagnose as diagnosis, fit as fitting};

/// A log and the link on the ground in rows that do not say.
struct Standing {
    log: LogSource,
    support: Option<String>,
}

/// What the logs of one robot on one day come to. Logs are sorted by what they hold, and one
/// that comes twice counts once; those that cannot be read are named in the row's error, and
/// the others make up the row.
///
/// # Errors
/// The kind `Interrupted` where `watch` stops it, and no other.
pub fn row(
    robot: &Arc<Robot>,
    options: &Options,
    (name, day): (&str, &str),
    logs: &[Log],
    watch: &mut dyn Watch,
) -> Result<Row, Error> {
    let logs = each_once(logs);
    let mut row = Row {
        urdf_hash: robot.description.hash.clone(),
        support: options.support.clone().unwrap_or_default(),
        ..row_of(name, day, &logs)
    };
    let mut group = Evaluation {
        robot,
        options,
        watch,
        support: String::new(),
        errors: Vec::new(),
        odd: Vec::new(),
    };
    let mut standing = Vec::new();
    for log in &logs {
        let found = group.standing(log);
        standing.extend(group.noted(found)?);
    }
    if let Some(support) = standing.iter().find_map(|log| log.support.as_ref()) {
        row.support.clone_from(support);
        group.support.clone_from(support);
        group.evaluate(standing, &mut row)?;
    } else if !standing.is_empty() {
        let missing = robot.no_support_of_fleet(&group.odd);
        group.noted::<()>(Err(missing))?;
    }
    row.set_errors(group.errors);
    Ok(row)
}

/// A robot and how its logs are looked at.
struct Evaluation<'a> {
    robot: &'a Arc<Robot>,
    options: &'a Options,
    watch: &'a mut dyn Watch,
    /// The link on the ground of logs that do not say.
    support: String,
    /// What is wrong with logs.
    errors: Vec<String>,
    /// What is odd about their sidecars.
    odd: Vec<Message>,
}

impl Evaluation<'_> {
    /// What came of something; what is wrong with a log is kept, and other errors are the end.
    fn noted<T>(&mut self, found: Result<T, Error>) -> Result<Option<T>, Error> {
        match found {
            Err(error) if error.kind() != ErrorKind::Interrupted => {
                self.errors.push(without_path(&error, self.robot));
                Ok(None)
            }
            found => found.map(Some),
        }
    }

    /// Fill a row from logs of which some say where they stand.
    fn evaluate(&mut self, mut logs: Vec<Standing>, row: &mut Row) -> Result<(), Error> {
        if self.options.only.is_none() {
            let usable = self.diagnose(&mut logs, row);
            if self.noted(usable)? != Some(true) {
                return Ok(());
            }
        }
        let mut parts = Vec::new();
        for log in logs {
            let part = self.gather(&log, true);
            parts.extend(self.noted(part)?.map(|part| (log, part)));
        }
        if parts.len() > 1 {
            // Rows that state no deviations are told some where an encoder is stuck, which rows
            // of several logs cannot be.
            let is_stuck = |part: &Part| part.health().iter().any(|f| f.kind == Kind::EncoderStuck);
            for (log, mut part) in mem::take(&mut parts) {
                if is_stuck(&part) {
                    let again = self.gather(&log, false);
                    let Some(again) = self.noted(again)? else {
                        continue;
                    };
                    part = again;
                }
                parts.push((log, part));
            }
        }
        if parts.is_empty() {
            return Ok(());
        }
        let fitted = self.fit(parts, row);
        self.noted(fitted).map(drop)
    }

    /// A log and where it stands: as the options say, else its sidecar, else its first row.
    fn standing(&mut self, log: &Log) -> Result<Standing, Error> {
        let (log, sidecar, odd) = log.source()?;
        self.odd.extend(odd);
        let mut support = self.options.support.clone().or(sidecar.support);
        if support.is_none() {
            let first = self.open(&log)?.first_support()?;
            support = first.map(|link| link.to_string());
        }
        let support = support.filter(|link| !link.is_empty());
        Ok(Standing { log, support })
    }

    fn open(&self, log: &LogSource) -> Result<PostureReader, Error> {
        let about = &self.robot.description;
        let reading = Reading {
            angles: self.options.angles,
            readings: Readings::Required,
            links: about.link_names().map(str::to_string).collect(),
            support: self.options.support.clone(),
            ..Reading::default()
        };
        PostureReader::of_robot(log, about, &reading)
    }

    /// All rows of a log, with what of its sidecar is about them.
    fn read(&self, log: &LogSource) -> Result<(Sidecar, Block), Error> {
        let mut reader = self.open(log)?;
        let block = reader.block(usize::MAX / 2)?;
        let sidecar = Sidecar {
            robot: None,
            support: None,
            angles: None,
            cells: None,
            gravity: None,
            topic: None,
            columns: None,
            ..reader.sidecar
        };
        Ok((sidecar, block))
    }

    fn prior(&self, usual: &str) -> PriorChoice {
        PriorChoice::from(self.options.prior.as_deref().unwrap_or(usual))
    }

    /// What is asked of the fit of a group, its logs aside.
    fn request(&self, support: &str) -> fitting::Request {
        fitting::Request {
            robot: Some(Arc::clone(self.robot)),
            support: Some(support.to_string()),
            snapping: self.options.snapping(),
            angles: self.options.angles,
            prior: self.prior(Prior::DEFAULT),
            noise: self.options.noise,
            motion: self.options.motion_model(),
            feet: self.options.feet(),
            ..fitting::Request::default()
        }
    }

    /// What a log contributes to the fit; `alone` where it is fitted without other logs.
    fn gather(&mut self, log: &Standing, alone: bool) -> Result<Part, Error> {
        let mut request = self.request(log.support.as_ref().unwrap_or(&self.support));
        request.logs = vec![log.log.clone()];
        gather_as(&request, alone, self.watch)
    }

    /// Fit the parts of all logs.
    fn fit(&mut self, parts: Vec<(Standing, Part)>, row: &mut Row) -> Result<(), Error> {
        let mut request = self.request(&self.support);
        // Sums are in SI units.
        request.angles = None;
        let parts = parts.into_iter();
        let parts = parts.map(|(log, part)| (log.log.name().to_string(), part));
        request.parts = parts.collect();
        let found = fit(&request, self.watch)?.identification;
        if self.options.only == Some(Only::Parameters) {
            row.fitted(&found);
            if !found.is_usable() {
                return Ok(());
            }
        }
        let parameters = found.parameters.iter();
        let known = parameters.map(|p| (p.value, p.std.filter(|std| std.is_finite())));
        (row.params, row.std) = known.unzip();
        // Effects that come and go in diagnoses are compared with it.
        if self.options.information || self.options.only.is_none() {
            let covariance = &found.estimate.covariance;
            let lower = (0..covariance.nrows()).flat_map(|i| (0..=i).map(move |j| (i, j)));
            row.covariance = lower.map(|place| covariance[place]).collect();
        }
        Ok(())
    }

    /// Diagnose the logs as one; gives whether they are fit for a fit.
    fn diagnose(&mut self, logs: &mut Vec<Standing>, row: &mut Row) -> Result<bool, Error> {
        // Several are diagnosed as one, of which each has to be read.
        let mut blocks = Vec::new();
        if logs.len() > 1 {
            for log in mem::take(logs) {
                let read = self.read(&log.log);
                if let Some(read) = self.noted(read)? {
                    blocks.push(read);
                    logs.push(log);
                }
            }
        }
        let log = match &logs[..] {
            [] => return Ok(false),
            [one] => one.log.clone(),
            several => self.one_log(several, blocks)?,
        };
        let mut request = diagnosis::Request::new(Arc::clone(self.robot), log);
        request.support = Some(self.support.clone());
        request.snapping = self.options.snapping();
        // Several logs were put together in SI units.
        request.angles = self.options.angles.filter(|_| logs.len() == 1);
        request.prior = self.prior(Prior::OF_DIAGNOSES);
        request.noise = self.options.noise;
        request.floor = self.options.floor;
        request.motion = self.options.motion_model();
        request.feet = self.options.feet();
        request.scores = SCORES;
        let found = diagnose(&request, self.watch)?;
        row.diagnosed(&found);
        Ok(found.diagnosis.verdict != diagnosis::Verdict::Unusable)
    }

    /// Several logs as one: postures are numbered on, times run on after a pause, and the CoP is
    /// in place of foot cells.
    fn one_log(&self, logs: &[Standing], all: Vec<(Sidecar, Block)>) -> Result<LogSource, Error> {
        let (sidecars, mut blocks): (Vec<Sidecar>, Vec<Block>) = all.into_iter().unzip();
        let mut sidecar = sidecars.first().cloned().unwrap_or_default();
        if let Some(at) = sidecars.iter().position(|other| *other != sidecar) {
            let differs = "its sidecar differs from that of another log of the same group; give \
                           them groups of their own";
            return Err(Error::log(logs[at].log.name(), None, differs));
        }
        let (mut numbered, mut later) = (0, None);
        for block in &mut blocks {
            // Numbers need not begin at zero.
            let least = block.pose.iter().copied().min().unwrap_or(0);
            for pose in &mut block.pose {
                *pose = pose.saturating_sub(least).saturating_add(numbered);
            }
            numbered = block.pose.iter().max().map_or(numbered, |last| last + 1);
            if let Some(t) = &mut block.t {
                let start = t.first().copied().unwrap_or(0.0);
                let from = later.unwrap_or(start);
                t.iter_mut().for_each(|t| *t = *t - start + from);
                // An hour is longer than any correlation between readings.
                later = t.iter().copied().reduce(f64::max).map(|t| t + 3600.0);
            }
        }
        let std = column(&mut blocks, "standard deviations", |b| b.std.take())?;
        let gravity = column(&mut blocks, "gravity", |b| b.gravity.take())?;
        let support = column(&mut blocks, "a support", |b| b.support.take())?;
        let t = column(&mut blocks, "times", |b| b.t.take()).ok().flatten();
        if std.is_some() {
            // Deviations are those of rows already.
            sidecar.readings_per_pose = None;
        }
        let q: Vec<f64> = blocks.iter().flat_map(|b| &b.q).copied().collect();
        let reading = blocks.iter().filter_map(|b| b.reading.as_ref());
        let reading: Vec<[f64; 2]> = reading.flatten().copied().collect();
        let pose: Vec<i64> = blocks.iter().flat_map(|b| &b.pose).copied().collect();
        let mut table = Table::new("the logs of this group").integers("pose", pose);
        if let Some(t) = t {
            table = table.numbers("t", t);
        }
        if let Some(support) = support {
            table = table.texts("support", support);
        }
        let support = self.options.support.as_deref();
        let support = support.or_else(|| logs.first()?.support.as_deref());
        let dofs = self.robot.description.dofs_on(support);
        for (k, joint) in dofs.iter().enumerate() {
            let column: Vec<f64> = q.iter().skip(k).step_by(dofs.len()).copied().collect();
            table = table.numbers(&joint.joint, column);
        }
        table = with_axes(table, ["cop_x", "cop_y"], Some(reading));
        table = with_axes(table, ["cop_x_std", "cop_y_std"], std);
        table = with_axes(table, ["gravity_x", "gravity_y", "gravity_z"], gravity);
        Ok(LogSource::from(table).with_sidecar(sidecar))
    }
}

/// A column of all logs; none where none has it.
fn column<T>(
    blocks: &mut [Block],
    what: &str,
    of: fn(&mut Block) -> Option<Vec<T>>,
) -> Result<Option<Vec<T>>, Error> {
    let found: Vec<Vec<T>> = blocks.iter_mut().filter_map(of).collect();
    match (found.len(), blocks.len()) {
        (0, _) => Ok(None),
        (has, all) if has == all => Ok(Some(found.into_iter().flatten().collect())),
        (has, all) => Err(Error::request(format!(
            "{has} of {all} logs of this group have {what}; give all of them or none"
        ))),
    }
}

/// A column for each axis of vectors, where there are some.
fn with_axes<const N: usize>(table: Table, names: [&str; N], rows: Option<Vec<[f64; N]>>) -> Table {
    let Some(rows) = rows else {
        return table;
    };
    (0..N).fold(table, |table, axis| {
        let column: Vec<f64> = rows.iter().map(|row| row[axis]).collect();
        table.numbers(names[axis], column)
    })
}

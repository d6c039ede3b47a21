//! The row of a group: a pure function of its URDF, its options and what its logs hold.
//!
//! ```text
//! logs, sorted by the hash of their content ─┬▶ blocks of one problem ─▶ diagnosis
//!                                            └▶ part of each log ─▶ fit
//! ```

use std::sync::Arc;

use super::log::{Log, each_once, row_of, without_path};
use super::row::{Row, SCORES, is_spoiling};
use super::{Only, Options};
use crate::diagnose::diagnose;
use crate::feet::Feet;
use crate::fit::part::Part;
use crate::fit::prior::{Prior, PriorChoice};
use crate::fit::{MotionModel, fit, gather_as};
use crate::logs::{LogSource, Options as Reading, PostureReader, Readings, Sidecar};
use crate::robot::Robot;
use crate::watch::Watch;
use crate::{Error, ErrorKind, diagnose as diagnosis, fit as fitting};

/// A log and the link on the ground in rows that do not say.
type Standing = (LogSource, String);

/// What the logs of one robot on one day come to. Logs are sorted by what they hold, and one
/// that comes twice counts once. Those that cannot be read are named in the row's error, and of
/// those whose data cannot be used the findings are kept; the others make up the row.
///
/// # Errors
/// The kind `Interrupted` where `watch` stops it, and no other.
pub fn row(
    robot: &Arc<Robot>,
    options: &Options,
    name: (&str, &str),
    logs: &[Log],
    watch: &mut dyn Watch,
) -> Result<Row, Error> {
    let logs = each_once(logs);
    let mut row = Row {
        urdf_hash: robot.description.hash.clone(),
        support: options.support.clone().unwrap_or_default(),
        ..row_of(name, &logs)
    };
    let mut group = Evaluation {
        robot,
        options,
        watch,
        support: String::new(),
        errors: Vec::new(),
    };
    let (mut standing, mut odd) = (Vec::new(), Vec::new());
    for log in &logs {
        let found = log.source().and_then(|(log, sidecar, own)| {
            odd.extend(own);
            group.standing(log, sidecar)
        });
        standing.extend(group.noted(found)?);
    }
    if let Some(support) = standing.iter().find_map(|(_, support)| support.clone()) {
        row.support.clone_from(&support);
        group.support.clone_from(&support);
        let logs = standing.into_iter();
        let logs = logs.map(|(log, own)| (log, own.unwrap_or_else(|| support.clone())));
        group.evaluate(logs.collect(), &mut row)?;
    } else if !standing.is_empty() {
        let missing = robot.no_support_of_fleet(&odd);
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

    /// A log and where it stands: as the options say, else its sidecar, else its first row.
    fn standing(
        &self,
        log: LogSource,
        sidecar: Sidecar,
    ) -> Result<(LogSource, Option<String>), Error> {
        let mut support = self.options.support.clone().or(sidecar.support.clone());
        if support.is_none() {
            let about = &self.robot.description;
            let reading = Reading {
                angles: self.options.angles,
                readings: Readings::Required,
                links: about.link_names().map(str::to_string).collect(),
                ..Reading::default()
            };
            let first = PostureReader::of_robot(&log, about, &reading)?.first_support()?;
            support = first.map(|link| link.to_string());
        }
        let support = support.filter(|link| !link.is_empty());
        let sidecar = Sidecar {
            support: support.clone(),
            ..sidecar
        };
        Ok((log.with_sidecar(sidecar), support))
    }

    /// Fill a row from logs of which some say where they stand. Of several those whose data cannot
    /// be used are left out: beside a stuck encoder, effects would make up for it.
    fn evaluate(&mut self, mut logs: Vec<Standing>, row: &mut Row) -> Result<(), Error> {
        let (mut parts, mut findings) = (Vec::new(), Vec::new());
        if logs.len() > 1 {
            let (mut sound, mut spoilt) = (Vec::new(), Vec::new());
            for log in logs {
                let part = self.gather(&log);
                if let Some(part) = self.noted(part)? {
                    findings.extend_from_slice(part.health());
                    let is_spoilt = part.health().iter().any(is_spoiling);
                    let of_its_kind = if is_spoilt { &mut spoilt } else { &mut sound };
                    of_its_kind.push((log, part));
                }
            }
            let taken = if sound.is_empty() { spoilt } else { sound };
            (logs, parts) = taken.into_iter().unzip();
        }
        if self.options.only.is_none() {
            let usable = self.diagnose(&logs, row);
            if self.noted(usable)? != Some(true) {
                return Ok(());
            }
        }
        if let ([log], []) = (&logs[..], &parts[..]) {
            let part = self.gather(log);
            parts.extend(self.noted(part)?);
        }
        if !parts.is_empty() {
            let fitted = self.fit(logs.iter().zip(parts).collect(), row);
            self.noted(fitted)?;
        }
        row.add_findings(findings);
        Ok(())
    }

    fn prior(&self, usual: &str) -> PriorChoice {
        PriorChoice::from(self.options.prior.as_deref().unwrap_or(usual))
    }

    /// What is asked of the fit of a group, its logs aside.
    fn request(&self) -> fitting::Request {
        fitting::Request {
            robot: Some(Arc::clone(self.robot)),
            snapping: self.options.snapping(),
            prior: self.prior(Prior::DEFAULT),
            noise: self.options.noise,
            // A shift of readings belongs to a log; parameters are compared from day to day.
            offset: Some(0.0),
            motion: match self.options.motion {
                true => MotionModel::Auto,
                false => MotionModel::Off,
            },
            feet: Feet {
                both: self.options.both_feet,
                other: self.options.other_foot.clone(),
            },
            ..fitting::Request::default()
        }
    }

    /// What a log contributes to the fit.
    fn gather(&mut self, (log, support): &Standing) -> Result<Part, Error> {
        let request = fitting::Request {
            logs: vec![log.clone()],
            support: Some(support.clone()),
            angles: self.options.angles,
            ..self.request()
        };
        gather_as(&request, true, self.watch)
    }

    /// Fit the parts of all logs.
    fn fit(&mut self, parts: Vec<(&Standing, Part)>, row: &mut Row) -> Result<(), Error> {
        let parts = parts.into_iter();
        let parts = parts.map(|((log, _), part)| (log.name().to_string(), part));
        let request = fitting::Request {
            parts: parts.collect(),
            support: Some(self.support.clone()),
            ..self.request()
        };
        let found = fit(&request, self.watch)?.identification;
        if self.options.only == Some(Only::Parameters) {
            row.fitted(&found);
            if !found.is_usable() {
                return Ok(());
            }
        }
        row.postures = found.postures;
        let parameters = found.parameters.iter();
        row.names = parameters.clone().map(|p| p.name.clone()).collect();
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

    /// Diagnose the logs, each a block of one problem; gives whether they are fit for a fit.
    fn diagnose(&mut self, logs: &[Standing], row: &mut Row) -> Result<bool, Error> {
        let Some(((first, support), others)) = logs.split_first() else {
            return Ok(false);
        };
        let of_fit = self.request();
        let mut request = diagnosis::Request::new(Arc::clone(self.robot), first.clone());
        request.then = others.iter().map(|(log, _)| log.clone()).collect();
        request.support = Some(support.clone());
        request.snapping = of_fit.snapping;
        request.angles = self.options.angles;
        request.prior = self.prior(Prior::OF_DIAGNOSES);
        request.noise = self.options.noise;
        request.floor = self.options.floor;
        request.motion = of_fit.motion;
        request.feet = of_fit.feet;
        request.scores = SCORES;
        let found = diagnose(&request, self.watch)?;
        row.diagnosed(&found);
        Ok(found.diagnosis.verdict != diagnosis::Verdict::Unusable)
    }
}

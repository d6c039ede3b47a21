//! The row of a group: a pure function of its URDF, its options and what its logs hold.

use std::sync::Arc;

use super::content::{Content, Log, each_once};
use super::failed::without_path;
use super::joined_logs::together;
use super::options::{Only, Options};
use super::part_of_log::{Contribution, Gathering, prior, request, support_said};
use super::row::Row;
use crate::diagnose::{Request, diagnose};
use crate::fit::fit;
use crate::fit::part::Part;
use crate::fit::prior::Prior;
use crate::logs::{LogSource, Options as Reading, PostureReader, Readings};
use crate::robot::Robot;
use crate::watch::Watch;
use crate::{Error, ErrorKind, Message};

/// Rows read at once where a log is only looked at.
const BLOCK: usize = 4096;

/// What the logs of one robot on one day come to. Logs are sorted by what they hold, and one
/// that comes twice counts once; those that cannot be read are named in the row's error, and
/// the others make up the row.
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
    let contents: Vec<Content> = logs.iter().map(Log::content).collect();
    let mut from_memory = FromMemory(&logs);
    let group = Group {
        robot,
        options,
        logs: &contents,
    };
    if options.only == Only::Parameters {
        return group.row_of_parts(name, &mut from_memory, watch);
    }
    let mut row = group.row(name);
    let (mut errors, mut sources) = (Vec::new(), Vec::new());
    // What is wrong with a log is said before a support is missed.
    let single = logs.len() == 1 && group.supports().of_group.is_ok();
    for log in &logs {
        let source = log.source().and_then(|source| match single {
            // The diagnosis will say what is wrong with it.
            true => Ok(source),
            false => readable(robot, options, &source).map(|()| source),
        });
        match source {
            Ok(source) => sources.push((log.content(), source)),
            Err(error) => errors.push(without_path(&error, robot)),
        }
    }
    let (readable, sources): (Vec<Content>, Vec<LogSource>) = sources.into_iter().unzip();
    let group = Group {
        logs: &readable,
        ..group
    };
    let made = group.diagnosed(&sources, &mut row, watch);
    let made = made.and_then(|is_usable| match is_usable {
        true => group.fitted(&mut row, &mut from_memory, watch),
        false => Ok(Vec::new()),
    });
    match made {
        Ok(faults) => errors.extend(faults),
        Err(error) if error.kind() == ErrorKind::Interrupted => return Err(error),
        Err(error) => errors.push(without_path(&error, robot)),
    }
    row.set_errors(errors);
    Ok(row)
}

/// Where the parts of logs come from.
pub(super) trait Parts {
    /// What a log contributes.
    ///
    /// # Errors
    /// The kind `Interrupted` where `watch` stops it; when a store cannot be written.
    fn part(
        &mut self,
        how: &Gathering,
        log: &Content,
        watch: &mut dyn Watch,
    ) -> Result<Contribution, Error>;

    /// The log itself; none where it cannot be read, which is noted elsewhere.
    fn log(&mut self, log: &Content) -> Option<Log>;
}

/// Parts of logs that are in memory.
struct FromMemory<'a>(&'a [Log]);

impl Parts for FromMemory<'_> {
    fn part(
        &mut self,
        how: &Gathering,
        log: &Content,
        watch: &mut dyn Watch,
    ) -> Result<Contribution, Error> {
        match self.log(log) {
            Some(log) => Contribution::of(how, &log, watch),
            None => Ok(Contribution::Fault(format!("{} is not here", log.name()))),
        }
    }

    fn log(&mut self, log: &Content) -> Option<Log> {
        let is_it = |own: &&Log| own.hash == log.hash && own.sidecar == log.sidecar;
        self.0.iter().find(is_it).cloned()
    }
}

/// The links on the ground of a group.
struct Supports<'a> {
    /// Logs whose sidecars can be read, with the link that options or sidecar say.
    of_logs: Vec<(&'a Content, Option<String>)>,
    /// The first of these; where there is none, what is missing.
    of_group: Result<String, Error>,
    /// What is wrong with other sidecars.
    faults: Vec<String>,
}

/// Logs of one robot and day, each once and sorted by what they hold.
#[derive(Clone, Copy)]
pub(super) struct Group<'a> {
    pub robot: &'a Arc<Robot>,
    pub options: &'a Options,
    pub logs: &'a [Content],
}

impl Group<'_> {
    /// The row, of parameters alone, of what logs contribute.
    ///
    /// # Errors
    /// The kind `Interrupted` where `watch` stops it; those of `parts`.
    pub fn row_of_parts(
        &self,
        name: (&str, &str),
        parts: &mut dyn Parts,
        watch: &mut dyn Watch,
    ) -> Result<Row, Error> {
        let mut row = self.row(name);
        let faults = self.fitted(&mut row, parts, watch)?;
        row.set_errors(faults);
        Ok(row)
    }

    /// A row that says whose it is and nothing else.
    pub fn row(&self, (name, day): (&str, &str)) -> Row {
        Row {
            robot: name.to_string(),
            day: day.to_string(),
            urdf_hash: self.robot.description.hash.clone(),
            support: self.options.support.clone().unwrap_or_default(),
            inputs: self.logs.iter().map(|log| log.hash.clone()).collect(),
            version: env!("CARGO_PKG_VERSION").to_string(),
            ..Row::default()
        }
    }

    fn supports(&self) -> Supports<'_> {
        let (mut of_logs, mut odd, mut faults) = (Vec::new(), Vec::<Message>::new(), Vec::new());
        for log in self.logs {
            match support_said(self.options, log) {
                Ok((support, of_log)) => {
                    of_logs.push((log, support));
                    odd.extend(of_log);
                }
                Err(error) => faults.push(without_path(&error, self.robot)),
            }
        }
        let first = of_logs.iter().find_map(|(_, support)| support.clone());
        Supports {
            of_group: first.ok_or_else(|| self.robot.no_support_of_fleet(&odd)),
            of_logs,
            faults,
        }
    }

    /// Fit what the logs contribute; gives what is wrong with those that contribute nothing.
    fn fitted(
        &self,
        row: &mut Row,
        parts: &mut dyn Parts,
        watch: &mut dyn Watch,
    ) -> Result<Vec<String>, Error> {
        let Supports {
            of_logs: logs,
            of_group: support,
            mut faults,
        } = self.supports();
        if logs.is_empty() {
            return Ok(faults);
        }
        let support = match support {
            Ok(support) => support,
            Err(error) => {
                // What is wrong with a log is said before a support is missed.
                let unreadable = self.unreadable(&logs, parts);
                let all = unreadable.len() == logs.len();
                faults.extend(unreadable);
                if !all {
                    faults.push(without_path(&error, self.robot));
                }
                return Ok(faults);
            }
        };
        row.support.clone_from(&support);
        let mut gathered = Vec::new();
        for (log, own) in logs {
            let own = own.unwrap_or_else(|| support.clone());
            match parts.part(&self.gathering(&own, true), log, watch)? {
                Contribution::Fault(fault) if faults.contains(&fault) => {}
                Contribution::Fault(fault) => faults.push(fault),
                part => gathered.push((log, own, part)),
            }
        }
        let several = gathered.len() > 1;
        let mut whole: Option<Part> = None;
        for (log, own, part) in gathered {
            let part = match part.depends_on_others() && several {
                true => parts.part(&self.gathering(&own, false), log, watch)?,
                false => part,
            };
            let part = match part {
                Contribution::Part(part) => *part,
                Contribution::Fault(fault) => {
                    faults.push(fault);
                    continue;
                }
            };
            let merged = match &mut whole {
                None => {
                    whole = Some(part);
                    Ok(())
                }
                Some(whole) => whole.merge(part, &log.name()),
            };
            if let Err(error) = merged {
                faults.push(without_path(&error, self.robot));
                return Ok(faults);
            }
        }
        if let Some(whole) = whole
            && let Err(error) = self.fit(&support, whole, row, watch)
        {
            if error.kind() == ErrorKind::Interrupted {
                return Err(error);
            }
            faults.push(without_path(&error, self.robot));
        }
        Ok(faults)
    }

    /// What is wrong with logs of which nobody says where they stand.
    fn unreadable(
        &self,
        logs: &[(&Content, Option<String>)],
        parts: &mut dyn Parts,
    ) -> Vec<String> {
        let found = logs.iter().filter_map(|(log, _)| {
            let source = parts.log(log)?.source();
            let read = source.and_then(|source| readable(self.robot, self.options, &source));
            read.err().map(|error| without_path(&error, self.robot))
        });
        found.collect()
    }

    fn gathering<'s>(&'s self, support: &'s str, alone: bool) -> Gathering<'s> {
        Gathering {
            robot: self.robot,
            options: self.options,
            support,
            alone,
        }
    }

    /// Fit the part of all logs.
    fn fit(
        &self,
        support: &str,
        whole: Part,
        row: &mut Row,
        watch: &mut dyn Watch,
    ) -> Result<(), Error> {
        let mut request = request(self.robot, self.options, support);
        // Sums are in SI units.
        request.angles = None;
        request.parts = vec![("the logs of this group".to_string(), whole)];
        let found = fit(&request, watch)?.identification;
        if self.options.only == Only::Parameters {
            row.fitted(&found);
            if !found.is_usable() {
                return Ok(());
            }
        }
        row.params = found.parameters.iter().map(|p| p.value).collect();
        let finite = |x: &f64| x.is_finite();
        let parameters = found.parameters.iter();
        row.std = parameters.map(|p| p.std.filter(finite)).collect();
        // What comes and goes in diagnoses is held against it.
        if self.options.information || self.options.only == Only::All {
            let covariance = &found.estimate.covariance;
            let lower =
                (0..covariance.nrows()).flat_map(|i| (0..=i).map(move |j| covariance[(i, j)]));
            row.covariance = lower.collect();
        }
        Ok(())
    }

    /// Diagnose the logs; gives whether they are fit for a fit.
    fn diagnosed(
        &self,
        sources: &[LogSource],
        row: &mut Row,
        watch: &mut dyn Watch,
    ) -> Result<bool, Error> {
        let (robot, options) = (self.robot, self.options);
        if sources.is_empty() {
            return Ok(false);
        }
        row.support = self.supports().of_group?;
        let log = match sources {
            [one] => one.clone(),
            several => together(several, &robot.description.dofs(), &reading(robot, options))?,
        };
        let mut request = Request::new(Arc::clone(robot), log);
        request.support = Some(row.support.clone());
        request.snapping = options.snapping();
        // Several logs were put together in SI units.
        request.angles = options.angles.filter(|_| sources.len() == 1);
        request.prior = prior(options, Prior::OF_DIAGNOSES);
        request.noise = options.noise;
        request.floor = options.floor;
        request.motion = options.motion_model();
        request.feet = options.feet();
        let report = diagnose(&request, watch)?;
        row.diagnosed(&report.diagnosis);
        Ok(row.is_usable())
    }
}

fn reading(robot: &Robot, options: &Options) -> Reading {
    Reading {
        angles: options.angles,
        readings: Readings::Required,
        links: robot.description.link_names().map(str::to_string).collect(),
        support: options.support.clone(),
        ..Reading::default()
    }
}

/// Whether a log can be read to its end.
fn readable(robot: &Robot, options: &Options, log: &LogSource) -> Result<(), Error> {
    let dofs = robot.description.dofs();
    let mut reader = PostureReader::open(log, &dofs, &reading(robot, options))?;
    while !reader.block(BLOCK)?.is_empty() {}
    Ok(())
}

//! What one log contributes to the fit of its group.
//!
//! ```text
//! log ─▶ part(URDF, options, support, log)       a pure function, of one size however long it is
//! parts of a group, sorted by the hash of their logs ─▶ one part ─▶ fit
//! ```

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Arc;

use super::content::{Content, Log};
use super::failed::without_path;
use super::options::Options;
use crate::fit::part::Part;
use crate::fit::prior::{Prior, PriorChoice};
use crate::fit::{Request, gather_as};
use crate::health::Kind;
use crate::logs::Sidecar;
use crate::robot::Robot;
use crate::watch::Watch;
use crate::{Error, ErrorKind, Message};

/// The error of logs that made the library panic; what came of them is not kept.
pub(super) const DEFECT: &str = "these logs meet a defect of sesc; please report it";

/// How the part of a log is gathered.
#[derive(Debug, Clone, Copy)]
pub(super) struct Gathering<'a> {
    pub robot: &'a Arc<Robot>,
    pub options: &'a Options,
    /// The link on the ground in rows that do not say.
    pub support: &'a str,
    /// Whether it is fitted without other logs.
    pub alone: bool,
}

/// What a log contributes to a fit.
#[derive(Debug, Clone)]
pub(super) enum Contribution {
    /// Its sums.
    Part(Box<Part>),
    /// Nothing, and why.
    Fault(String),
}

/// First bytes of each kind of contribution in the store.
const PART: &[u8] = b"part\n";
const FAULT: &[u8] = b"fault\n";

impl Contribution {
    /// What a log in memory contributes; a panic is a fault.
    ///
    /// # Errors
    /// The kind `Interrupted` where `watch` stops it, and no other.
    pub fn of(how: &Gathering, log: &Log, watch: &mut dyn Watch) -> Result<Contribution, Error> {
        let made = catch_unwind(AssertUnwindSafe(|| gathered(how, log, watch)));
        match made {
            Ok(Ok(part)) => Ok(Contribution::Part(Box::new(part))),
            Ok(Err(error)) if error.kind() == ErrorKind::Interrupted => Err(error),
            Ok(Err(error)) => Ok(Contribution::Fault(without_path(&error, how.robot))),
            Err(_) => Ok(Contribution::Fault(DEFECT.to_string())),
        }
    }

    /// Whether the same log gives the same the next time.
    pub fn is_sound(&self) -> bool {
        !matches!(self, Contribution::Fault(error) if error == DEFECT)
    }

    /// Whether it is another one beside those of other logs: rows that state no deviations are
    /// told some where an encoder is stuck, which rows of several logs cannot be.
    pub fn depends_on_others(&self) -> bool {
        match self {
            Contribution::Part(part) => {
                let mut kinds = part.health().iter().map(|finding| finding.kind);
                kinds.any(|kind| kind == Kind::EncoderStuck)
            }
            Contribution::Fault(_) => false,
        }
    }

    /// The bytes of an entry of the store: without the URDF, which its name stands for, so that
    /// they do not depend on where that is.
    ///
    /// # Errors
    /// When it cannot be written down.
    pub fn to_bytes(&self) -> Result<Vec<u8>, Error> {
        match self {
            Contribution::Fault(error) => Ok([FAULT, error.as_bytes()].concat()),
            Contribution::Part(part) => {
                let mut part = part.clone();
                part.urdf.clear();
                part.urdf_file.clear();
                Ok([PART, &part.to_bytes()?].concat())
            }
        }
    }

    /// What [`to_bytes`](Self::to_bytes) gave; none where that is damaged.
    pub fn from_bytes(bytes: &[u8], how: &Gathering, log: &Content) -> Option<Contribution> {
        if let Some(error) = bytes.strip_prefix(FAULT) {
            let error = String::from_utf8(error.to_vec()).ok()?;
            return Some(Contribution::Fault(error));
        }
        let part = Part::from_bytes(bytes.strip_prefix(PART)?, &log.name());
        let mut part = part.ok()?;
        part.urdf = how.robot.text().to_string();
        part.urdf_file.clone_from(&how.robot.description.file);
        Some(Contribution::Part(Box::new(part)))
    }
}

fn gathered(how: &Gathering, log: &Log, watch: &mut dyn Watch) -> Result<Part, Error> {
    let mut request = request(how.robot, how.options, how.support);
    request.logs = vec![log.source()?];
    gather_as(&request, how.alone, watch)
}

/// What is asked of the fit of a group, its logs aside.
pub(super) fn request(robot: &Arc<Robot>, options: &Options, support: &str) -> Request {
    Request {
        robot: Some(Arc::clone(robot)),
        support: Some(support.to_string()),
        snapping: options.snapping(),
        angles: options.angles,
        prior: prior(options, Prior::DEFAULT),
        noise: options.noise,
        motion: options.motion_model(),
        feet: options.feet(),
        ..Request::default()
    }
}

pub(super) fn prior(options: &Options, usual: &str) -> PriorChoice {
    PriorChoice::from(options.prior.as_deref().unwrap_or(usual))
}

/// The link on the ground that options or a log's sidecar say, and what is odd about that.
///
/// # Errors
/// What is wrong with the sidecar.
pub(super) fn support_said(
    options: &Options,
    log: &Content,
) -> Result<(Option<String>, Vec<Message>), Error> {
    let name = log.name();
    let parsed = Sidecar::parse(&log.sidecar, &name);
    let (sidecar, odd) =
        parsed.map_err(|message| Error::log(&name, None, format!("sidecar: {message}")))?;
    Ok((options.support.clone().or(sidecar.support), odd))
}

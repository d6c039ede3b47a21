//! A look at the data before any effect is fitted: what no effect should be fitted to.
//!
//! ```text
//! rows         what a log shows by itself, or beside CAD as it is: contact, copies, stamps, speeds
//! hypotheses   what explains the log far better than CAD and every effect that is known: another
//!              foot, a turned frame, turned axes of the sensor, a stuck encoder, rows of others
//! ```
//!
//! Data that fit are healthy: every test asks for a gap far above the noise first. And what a known
//! effect explains is no broken data.
//!
//! One look at a log for a fit takes memory that does not grow with it: rows are looked at one by
//! one and, thinned out, as postures. A stuck encoder leaves its joint's motion to the noise:
//!
//! ```text
//! σ² → σ² + (a ∂p/∂q_j)²        a: how far the joint may be from where it says
//! ```

mod criteria;
mod encoders;
mod finding;
mod hypotheses;
mod rows;
mod view;
pub(crate) mod wirings;

use std::sync::Arc;

use sesc_model::{Function, Model, Snapping};

use crate::Error;
use crate::evaluate::Evaluator;
use crate::feet::Places;
use crate::logs::{LogSource, Options, ROOM, Samples};
use crate::observations::postures::Postures;
use crate::robot::Robot;
use crate::watch::Watch;

use criteria::{ANYWHERE, UNKNOWN_NOISE_M};
#[doc(hidden)]
pub use encoders::Stuck;
use encoders::{nearest_first, of_joint, parked};
pub use finding::{Finding, Kind};
#[doc(hidden)]
pub use finding::{Picture, Row};
#[doc(hidden)]
pub use rows::noise::FitResiduals;
pub(crate) use rows::sole_of;
use rows::{LeftOut, LessKnown, LogRows};
use view::{On, View};

/// What is found.
#[doc(hidden)]
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Health {
    /// Each finding; data that cannot be used have one.
    pub findings: Vec<Finding>,
    /// A joint whose encoder does not follow it.
    pub stuck: Option<Stuck>,
}

impl Health {
    /// Whether anything can be done with the data.
    pub fn is_usable(&self) -> bool {
        !self.findings.iter().any(|f| f.kind.makes_unusable())
    }

    /// With what was found of the rows before; a finding that makes data unusable stands alone.
    pub fn after(mut self, rows: Vec<Finding>) -> Health {
        if self.is_usable() {
            self.findings.splice(0..0, rows);
        }
        self
    }
}

/// What is wrong with a log itself.
///
/// ```
/// use sesc_identify::health::of_log;
/// use sesc_identify::logs::{LogSource, Table};
/// use sesc_model::Snapping;
///
/// // Thirty rows, written twice.
/// let wave = |rate: f64| (0..60).map(move |k| (rate * f64::from(k % 30)).sin());
/// let log: LogSource = Table::new("rod.csv")
///     .numbers("cop_x", wave(0.7).map(|x| 0.01 * x).collect::<Vec<f64>>())
///     .numbers("cop_y", wave(1.3).map(|x| 0.01 * x).collect::<Vec<f64>>())
///     .numbers("hip", wave(0.7).collect::<Vec<f64>>())
///     .into();
/// let found = of_log(&log, None, Snapping::default(), &mut ())?;
/// assert!(found.iter().any(|finding| finding.kind.name() == "rows_copied"));
/// # Ok::<(), sesc_identify::Error>(())
/// ```
///
/// With a robot the log is looked at as a fit of that robot on the log's own support would
/// see it; without one, only what its rows show by themselves is found.
///
/// # Errors
/// What is wrong with the log; when `watch` stops it.
pub fn of_log(
    log: &LogSource,
    robot: Option<&Arc<Robot>>,
    snapping: Snapping,
    watch: &mut dyn Watch,
) -> Result<Vec<Finding>, Error> {
    let Some(robot) = robot else {
        return rows::alone(log, watch);
    };
    let (sidecar, odd) = log.sidecar()?;
    let support = sidecar.support.ok_or_else(|| robot.no_support(&odd))?;
    let model = robot.model(&support, snapping, None)?;
    let links = robot.description.link_names();
    let options = Options {
        links: links.map(str::to_string).collect(),
        support: Some(support),
        any_unit: true,
        soles: Some(Places::of(robot, snapping)),
        ..Options::default()
    };
    let samples = Samples::read(log, &robot.description, &options, ROOM, watch)?;
    Ok(look(samples, (robot, &model), (snapping, None, true), watch)?.1)
}

/// Examine the postures of a log of `model`.
pub fn examine(robot: &Robot, model: &Model, snapping: Snapping, data: &Postures) -> Health {
    let on = On::new((robot, model), snapping);
    let mut views = vec![View::new(on, data.clone())];
    if data.moved.is_some() {
        views.push(View::new(on, data.standing()));
    }
    // A sensor whose axes are turned is an effect, which a diagnosis names.
    examine_views(&views, false)
}

/// Examine postures as they were read, which come first, and without what motion adds to their
/// readings, where it is known: a dead sensor does not move, and would with what is taken from it; a
/// stuck encoder may hide more than motion does, so that the view that is farther from CAD is the
/// right one. `axes`: whether a sensor whose axes are turned about the normal of the sole is a
/// finding.
fn examine_views(views: &[View], axes: bool) -> Health {
    let by_gap = nearest_first(views);
    let (read, nearest) = (&views[0], by_gap[0]);
    // On another foot an axis may hardly move; one that is constant is dead on any.
    let broken = if hypotheses::is_constant(read) {
        hypotheses::dead_axes(read)
    } else {
        hypotheses::elsewhere(nearest).or_else(|| hypotheses::dead_axes(read))
    };
    let broken = broken.or_else(|| hypotheses::shuffled(nearest));
    // What motion adds by CAD has CAD's axes: readings are looked at as they are.
    let turned = || axes.then(|| hypotheses::turned(read)).flatten();
    let (finding, stuck) = match broken.or_else(turned) {
        Some(finding) => (Some(finding), None),
        None => encoders::stuck(&by_gap).unzip(),
    };
    Health {
        findings: finding.into_iter().collect(),
        stuck,
    }
}

/// Examine a log of a fit on the model's support: the log without what is wrong with it. `noise` is
/// that of a single reading, m, where the user says; `alone` whether no other log is fitted with
/// it, so that its rows may be given deviations.
///
/// # Errors
/// What is wrong with the log; when `watch` stops it.
pub(crate) fn look(
    mut samples: Samples,
    on: (&Robot, &Model),
    (snapping, noise, alone): (Snapping, Option<f64>, bool),
    watch: &mut dyn Watch,
) -> Result<(Samples, Vec<Finding>), Error> {
    let on = On::new(on, snapping);
    let (rows, left_out, findings) = judge(&mut samples, on, noise, watch)?;
    // At most 2000 postures.
    let stride = rows.len().div_ceil(2000).max(1);
    let kept = |k: &usize| left_out.keeps(&rows.block, *k) && left_out.follows(rows.q(*k));
    let chosen: Vec<usize> = (0..rows.len()).filter(kept).step_by(stride).collect();
    if chosen.is_empty() {
        return Ok((samples, findings));
    }
    let found = examine_views(&rows.views(&chosen, on), true);
    let Health { findings, stuck } = found.after(findings);
    let left_out = LeftOut {
        less_known: stuck.map(|stuck| LessKnown {
            slopes: Arc::new(Evaluator::new(on.model, Function::ComJacobian).fastest()),
            joint: stuck.joint,
            anywhere: of_joint(&on.model.tree.dofs[stuck.joint], ANYWHERE),
            noise: alone.then(|| rows.noise.unwrap_or(UNKNOWN_NOISE_M)),
        }),
        ..left_out
    };
    Ok((screened(samples, left_out), findings))
}

/// Examine the rows of a log on the model's support: the log without those that cannot be used.
/// `noise`: of a single reading, m, where the user says.
///
/// # Errors
/// What is wrong with the log; when `watch` stops it.
pub(crate) fn screen(
    mut samples: Samples,
    on: (&Robot, &Model),
    noise: Option<f64>,
    watch: &mut dyn Watch,
) -> Result<(Samples, Vec<Finding>), Error> {
    let on = On::new(on, Snapping::default());
    let (_, left_out, findings) = judge(&mut samples, on, noise, watch)?;
    Ok((screened(samples, left_out), findings))
}

/// Rows of a log, what to leave out of them, and what is wrong with them, by themselves and beside
/// what CAD says; the log learns what it weighs.
fn judge(
    samples: &mut Samples,
    on: On,
    noise: Option<f64>,
    watch: &mut dyn Watch,
) -> Result<(LogRows, LeftOut, Vec<Finding>), Error> {
    let rows = LogRows::read(samples, on, noise, watch)?;
    let (mut left_out, mut findings, weight) = rows::judge(&rows, on);
    samples.weight = weight;
    findings.extend(parked(&rows, on, &mut left_out));
    Ok((rows, left_out, findings))
}

/// A log without the rows that are to be left out.
fn screened(samples: Samples, left_out: LeftOut) -> Samples {
    if left_out == LeftOut::default() {
        return samples;
    }
    samples.screened(Arc::new(left_out))
}

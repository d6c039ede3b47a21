//! A look at the data before any hypothesis: what no effect should be fitted to.
//!
//! ```text
//! columns    an axis of the CoP that does not move where CAD says it must,
//!            or readings that scatter as CAD says, and go with no posture
//! frames     CAD on another link, or with another axis up, predicts the readings
//! axes       CAD predicts the readings of a sensor that is turned about the sole's normal (fits)
//! encoders   an encoder that does not move, and a gap that motion of its joint explains
//! parked     the same for a stretch of the log
//! ```
//!
//! Data that fit are healthy: every test asks for a gap far above the noise first. And what
//! a known effect explains is no broken data: before a finding makes data unusable it must
//! hold under every wiring that the effects know (`wirings`) and any offset, gain, rotation
//! or exchange of the sensor's axes.
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
mod frames;
mod rows;
mod wirings;

use std::fmt;
use std::sync::Arc;

use nalgebra::DMatrix;
use sesc_model::{Function, Model, Snapping};

use crate::Error;
use crate::evaluate::Evaluator;
use crate::logs::{Block, LogSource, Options, ROOM, Samples, Screen, Screening};
use crate::observations::postures::Postures;
use crate::observations::rows::CopRows;
use crate::robot::Robot;
use crate::watch::Watch;

use criteria::{ANYWHERE, UNKNOWN_NOISE_M};
#[doc(hidden)]
pub use encoders::Stuck;
use encoders::{of_joint, parked};
pub use finding::{Finding, Kind};
#[doc(hidden)]
pub use finding::{Picture, Row};
#[doc(hidden)]
pub use rows::noise::FitResiduals;
use rows::{LeftOut, LogRows};
use wirings::Wirings;

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
    robot: Option<&Robot>,
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
        ..Options::default()
    };
    let samples = Samples::read(log, &robot.description, &options, ROOM, watch)?;
    Ok(look(samples, (robot, &model), (snapping, None, true), watch)?.1)
}

/// Examine the postures of a log of `model`.
pub fn examine(robot: &Robot, model: &Model, snapping: Snapping, data: &Postures) -> Health {
    let still = data.moved.is_some().then(|| data.standing());
    let on = On {
        robot,
        model,
        snapping,
    };
    // A sensor whose axes are turned is an effect, which a diagnosis names.
    Views::of(on, data, still.as_ref()).examine(false)
}

/// A robot on its support.
#[derive(Clone, Copy)]
struct On<'a> {
    robot: &'a Robot,
    model: &'a Model,
    snapping: Snapping,
}

/// Postures as their readings may be meant.
struct Views<'a> {
    on: On<'a>,
    /// Postures as they were read.
    read: &'a Postures,
    /// These, or postures without what motion adds to readings, whichever are nearer to CAD.
    nearer: &'a Postures,
    /// The other of these two, where motion is known.
    farther: Option<&'a Postures>,
    /// Between the nearer readings and CAD, m RMS.
    gap: f64,
}

impl<'a> Views<'a> {
    /// Postures as `read`, and `still` without what motion adds to their readings.
    fn of(on: On<'a>, read: &'a Postures, still: Option<&'a Postures>) -> Views<'a> {
        let gap = |data| Look::of(on, data).gap();
        let as_read = gap(read);
        let (nearer, farther, gap) = match still.map(|still| (still, gap(still))) {
            Some((still, gap)) if gap < as_read => (still, Some(read), gap),
            _ => (read, still, as_read),
        };
        Views {
            on,
            read,
            nearer,
            farther,
            gap,
        }
    }

    /// Examine postures as they were read, and without what motion adds to their readings: a
    /// dead sensor does not move, and would with what is taken from it; a stuck encoder may hide
    /// more than motion does, so that the farther view is the right one. `axes`: whether a sensor
    /// whose axes are turned about the normal of the sole is a finding.
    fn examine(&self, axes: bool) -> Health {
        let model = self.on.model;
        let read = || (Look::of(self.on, self.read), Wirings::new(model, self.read));
        let (look, wirings) = (
            Look::of(self.on, self.nearer),
            Wirings::new(model, self.nearer),
        );
        let dead = || {
            let (look, wirings) = read();
            frames::dead_axes(&look, &wirings)
        };
        // On another foot an axis may hardly move; one that is constant is dead on any.
        let broken = if frames::is_constant(self.read) {
            dead()
        } else {
            frames::wrong(&look, &wirings).or_else(dead)
        };
        let broken = broken.or_else(|| frames::shuffled(&look, &wirings));
        let broken = broken.or_else(|| {
            // What motion adds by CAD has CAD's axes: readings are looked at as they are.
            let (look, wirings) = axes.then(read)?;
            frames::turned(&look, &wirings)
        });
        let (finding, stuck) = match broken {
            Some(finding) => (Some(finding), None),
            None => self.stuck().unzip(),
        };
        Health {
            findings: finding.into_iter().collect(),
            stuck,
        }
    }

    /// An encoder that does not move in any posture, though its joint does: in the nearer view,
    /// or in the farther one, which must explain what the nearer one leaves.
    fn stuck(&self) -> Option<(Finding, Stuck)> {
        let gap = Look::of(self.on, self.nearer).chi2();
        let of = |data| {
            let wirings = Wirings::new(self.on.model, data);
            encoders::stuck(&Look::of(self.on, data), &wirings, gap)
        };
        of(self.nearer).or_else(|| of(self.farther?))
    }
}

/// A log beside what CAD says of it.
struct Look<'a> {
    on: On<'a>,
    model: &'a Model,
    data: &'a Postures,
    /// Deviation of each reading, m; a guess where it is not known yet.
    std: Vec<f64>,
    noise_is_known: bool,
    /// CoM by CAD, three per posture, m.
    com: Vec<f64>,
    /// Its x and y, m.
    predicted: Vec<f64>,
}

impl<'a> Look<'a> {
    fn of(on: On<'a>, data: &'a Postures) -> Look<'a> {
        let com = Evaluator::new(on.model, Function::Com).run(&data.q, data.len());
        let predicted = com.chunks_exact(3).flat_map(|c| [c[0], c[1]]).collect();
        let known = |std: &f64| if std.is_nan() { UNKNOWN_NOISE_M } else { *std };
        Look {
            on,
            model: on.model,
            data,
            std: data.std.iter().map(known).collect(),
            noise_is_known: data.std.iter().all(|std| !std.is_nan()),
            com,
            predicted,
        }
    }

    /// Between readings and CAD, m RMS.
    fn gap(&self) -> f64 {
        wirings::gap(self.data, &self.predicted)
    }

    /// The same, variances of the noise a reading.
    fn chi2(&self) -> f64 {
        let readings = self.data.reading.iter().zip(&self.predicted);
        let whitened = readings.zip(&self.std).map(|((y, p), std)| (y - p) / std);
        whitened.map(|x| x * x).sum::<f64>() / self.predicted.len().max(1) as f64
    }

    /// Some postures, at most so many, and rows of the CoP's regressor for them.
    fn rows_of_masses(&self, most: usize) -> (Vec<usize>, DMatrix<f64>) {
        let dof = self.model.dof();
        let chosen = wirings::evenly(0..self.data.len(), most);
        let q = chosen
            .iter()
            .flat_map(|k| &self.data.q[k * dof..(k + 1) * dof]);
        let q: Vec<f64> = q.copied().collect();
        let rows = CopRows::new(self.model)
            .fastest()
            .of(&q, chosen.len(), None);
        (chosen, rows)
    }

    /// One axis of the readings beside what CAD says.
    fn beside_cad(&self, axis: usize) -> Picture {
        let title = ["CoP x, mm", "CoP y, mm"][axis];
        let cad = |k: usize| 1e3 * self.predicted[2 * k + axis];
        let read = |k: usize| 1e3 * self.data.reading[2 * k + axis];
        self.of_two(title, [&cad, &read], ["CAD", "reading"])
    }

    /// Distance of the readings from CAD's CoP as they should be meant, and as they are.
    fn distances(&self, meant: &[f64], marks: [&str; 2]) -> Picture {
        let from = |cop: &[f64], k: usize| {
            let gap = |axis: usize| self.data.reading[2 * k + axis] - cop[2 * k + axis];
            1e3 * gap(0).hypot(gap(1))
        };
        let values: [&dyn Fn(usize) -> f64; 2] =
            [&|k| from(meant, k), &|k| from(&self.predicted, k)];
        self.of_two("Distance of the CoP from CAD's, mm", values, marks)
    }

    /// Two values of every posture: one that would be in order, and that of the finding.
    fn of_two(
        &self,
        title: &str,
        [sound, found]: [&dyn Fn(usize) -> f64; 2],
        marks: [&str; 2],
    ) -> Picture {
        let row = |k: usize| Row::among(self.data, k);
        let both = |k: usize| [(sound(k), false), (found(k), true)];
        Picture {
            marks: Some(marks.map(str::to_string)),
            ..Picture::chosen(title, self.data.len(), row, both)
        }
    }
}

/// Examine a log of a fit on the model's support: the log without what is wrong with it. `noise` is
/// that of a single reading, m, where the user says; `alone` whether no other log is fitted with
/// it, so that its rows may be given deviations.
///
/// # Errors
/// What is wrong with the log; when `watch` stops it.
pub(crate) fn look(
    samples: Samples,
    (robot, model): (&Robot, &Model),
    (snapping, noise, alone): (Snapping, Option<f64>, bool),
    watch: &mut dyn Watch,
) -> Result<(Samples, Vec<Finding>), Error> {
    let on = On {
        robot,
        model,
        snapping,
    };
    let rows = LogRows::read(&samples, (robot, model), noise, watch)?;
    let (left_out, findings) = judge_rows(&rows, on);
    // At most 2000 postures.
    let stride = rows.len().div_ceil(2000).max(1);
    let kept = |k: &usize| {
        left_out.keeps(rows.reading[*k], rows.force(*k)) && left_out.follows(rows.q(*k))
    };
    let chosen: Vec<usize> = (0..rows.len()).filter(kept).step_by(stride).collect();
    if chosen.is_empty() {
        return Ok((samples, findings));
    }
    let noise = rows.noise.unwrap_or(UNKNOWN_NOISE_M);
    let (read, still) = rows.views(&chosen, model);
    let found = Views::of(on, &read, still.as_ref()).examine(true);
    let Health { findings, stuck } = found.after(findings);
    let Some(Stuck { joint, .. }) = stuck else {
        return Ok((screened(samples, left_out), findings));
    };
    let screen = LessKnown {
        left_out,
        slopes: Arc::new(Evaluator::new(model, Function::ComJacobian).fastest()),
        joint,
        dof: rows.dof,
        anywhere: of_joint(&model.tree.dofs[joint], ANYWHERE),
        noise: alone.then_some(noise),
    };
    Ok((samples.screened(Arc::new(screen)), findings))
}

/// Examine the rows of a log on the model's support: the log without those that cannot be used.
/// `noise`: of a single reading, m, where the user says.
///
/// # Errors
/// What is wrong with the log; when `watch` stops it.
pub(crate) fn screen(
    samples: Samples,
    (robot, model): (&Robot, &Model),
    noise: Option<f64>,
    watch: &mut dyn Watch,
) -> Result<(Samples, Vec<Finding>), Error> {
    let rows = LogRows::read(&samples, (robot, model), noise, watch)?;
    let on = On {
        robot,
        model,
        snapping: Snapping::default(),
    };
    let (left_out, findings) = judge_rows(&rows, on);
    Ok((screened(samples, left_out), findings))
}

/// What is wrong with rows, by themselves and beside what CAD says, and what to leave out.
fn judge_rows(rows: &LogRows, on: On) -> (LeftOut, Vec<Finding>) {
    let (mut left_out, mut findings) = rows::judge(rows, on.model);
    findings.extend(parked(rows, on, &mut left_out));
    (left_out, findings)
}

/// A log without the rows that are to be left out.
fn screened(samples: Samples, left_out: LeftOut) -> Samples {
    if left_out == LeftOut::default() {
        return samples;
    }
    samples.screened(Arc::new(left_out))
}

/// Rows that are left out, and the others count for less along the motion of one joint.
struct LessKnown {
    left_out: LeftOut,
    slopes: Arc<Evaluator>,
    joint: usize,
    dof: usize,
    anywhere: f64,
    /// Noise of rows that state none, m.
    noise: Option<f64>,
}

impl fmt::Debug for LessKnown {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "LessKnown({}, {:?})", self.joint, self.left_out)
    }
}

impl Screen for LessKnown {
    fn start(&self) -> Screening {
        let mut left_out = self.left_out.start();
        let (slopes, noise) = (Arc::clone(&self.slopes), self.noise);
        let (joint, dof, anywhere) = (self.joint, self.dof, self.anywhere);
        Box::new(move |block: &mut Block| {
            left_out(block);
            let n = block.len();
            if let (None, Some(noise)) = (&block.std, noise) {
                block.std = Some(vec![[noise; 2]; n]);
            }
            let slopes = slopes.run(&block.q, n);
            for (k, std) in block.std.iter_mut().flatten().enumerate() {
                *std = [0, 1].map(|axis| {
                    let slope = slopes[(3 * k + axis) * dof + joint];
                    std[axis].hypot(anywhere * slope)
                });
            }
        })
    }
}

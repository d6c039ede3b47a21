//! CoM and CoP of the postures in a log, on whatever link each stands.
//!
//! ```text
//! CoP = CoM − z_CoM g / g_z        without effects: the CoM along gravity g on the sole plane
//! ```
//!
//! A model with effects predicts the reading of its sensor instead. Where a log with times is
//! dense enough to know accelerations, its CoP is the ZMP. Of a log of both feet it is said where
//! the soles do not close in the postures that are predicted.
//!
//! Where soles do not close, joints are not where encoders, and the effects of a model file, have them,
//! and predictions are off by as much.

use std::collections::HashMap;

use serde::Serialize;
use sesc_model::effects::{self, Catalog, EffectContext, Instance, PostureContext};
use sesc_model::tape::{Tape, Values};
use sesc_model::{Model, MotionCounted};

use crate::Error;
use crate::evaluate::{FASTEST, InLog, MotionPredictor, ReadingPredictor};
use crate::feet::{Closure, Feet, OtherFoot};
use crate::logs::{
    Angles, BLOCK, Block, LogSource, Options, PostureReader, Readings, Sidecar, Stays, joints,
};
use crate::observations::approach::Approach;
use crate::observations::motion::{Motion, Wanted};
use crate::observations::motion_use::MotionModel;
use crate::observations::moving::Moving;
use crate::observations::postures::HEAD;
use crate::observations::rows;
use crate::observations::zmp::Zmp;
use crate::robot::Stance;
use crate::robot::check_joints;
use crate::watch::{Watch, tell};

/// What is to be predicted.
#[derive(Clone)]
#[non_exhaustive]
pub struct Request {
    /// The robot; where it has no support of its own, rows and sidecar say theirs.
    pub stance: Stance,
    /// The postures.
    pub log: LogSource,
    /// Unit of the revolute joints; the log's unless given.
    pub angles: Option<Angles>,
    /// Whether the motion of the joints counts.
    pub motion: MotionModel,
}

impl Request {
    /// Predict every posture of `log`.
    pub fn new(stance: Stance, log: impl Into<LogSource>) -> Request {
        Request {
            stance,
            log: log.into(),
            angles: None,
            motion: MotionModel::Auto,
        }
    }
}

/// Predictions, one entry per row of the log.
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct Predictions {
    /// The row's pose.
    pub pose: Vec<i64>,
    /// CoM, m, support frame.
    pub com_m: Vec<[f64; 3]>,
    /// CoP, m, support frame.
    pub cop_m: Vec<[f64; 2]>,
}

/// Predict all rows of a log.
///
/// ```
/// use sesc_identify::logs::Table;
/// use sesc_identify::predict::{Request, predict};
/// use sesc_identify::robot::{Robot, Stance};
///
/// # let urdf = "<robot name='pole'><link name='foot'/><link name='top'><inertial>\
/// #   <mass value='2'/></inertial></link><joint name='hip' type='revolute'>\
/// #   <parent link='foot'/><child link='top'/><origin xyz='0.1 0 1'/><axis xyz='0 1 0'/>\
/// #   <limit lower='-1' upper='1'/></joint></robot>";
/// let robot = Robot::parse(urdf, "pole.urdf")?;
/// let log = Table::new("postures").numbers("hip", vec![0.0, 0.5]);
/// let found = predict(&Request::new(Stance::new(robot).on("foot"), log), &mut ())?;
/// assert_eq!(found.cop_m[0], [0.1, 0.0]);
/// # Ok::<(), sesc_identify::Error>(())
/// ```
///
/// # Errors
/// As [`Predictor`].
pub fn predict(request: &Request, watch: &mut dyn Watch) -> Result<Predictions, Error> {
    let mut predictor = Predictor::open(request, watch)?;
    let mut all = Predictions::default();
    while let Some(some) = predictor.block(watch)? {
        all.pose.extend(some.pose);
        all.com_m.extend(some.com_m);
        all.cop_m.extend(some.cop_m);
    }
    Ok(all)
}

/// Predictions block by block: the memory of one, however long the log is.
pub struct Predictor {
    stance: Stance,
    log: String,
    reader: Moving,
    sidecar: Sidecar,
    evaluators: HashMap<String, Evaluators>,
    /// What effects of a model may depend on beside q.
    approach: Approach,
    began_s: Option<f64>,
    /// Whether motion adds nothing to readings.
    is_static: bool,
}

/// A robot on one link.
struct Evaluators {
    model: Model,
    readings: ReadingPredictor,
    /// Made when joints move; the second where gravity is tilted, too.
    motion: Option<(MotionPredictor, Zmp)>,
    /// The soles of a log of both feet.
    soles: Option<Soles>,
}

impl Predictor {
    /// Open the log.
    ///
    /// ```
    /// use sesc_identify::logs::Table;
    /// use sesc_identify::predict::{Predictor, Request};
    /// use sesc_identify::robot::Robot;
    /// use sesc_identify::robot::Stance;
    /// # let urdf = "<robot name='rod'><link name='foot'/>\
    /// #     <joint name='hip' type='revolute'><parent link='foot'/><child link='leg'/>\
    /// #     <axis xyz='0 1 0'/><limit lower='-1' upper='1' effort='1' velocity='1'/></joint>\
    /// #     <link name='leg'><inertial><origin xyz='0 0 0.1'/><mass value='1'/></inertial></link>\
    /// #     </robot>";
    /// let log = Table::new("postures").numbers("hip", vec![0.0; 1000]);
    /// let stance = Stance::new(Robot::parse(urdf, "rod.urdf")?).on("foot");
    /// let mut predictor = Predictor::open(&Request::new(stance, log), &mut ())?;
    /// let mut rows = 0;
    /// while let Some(block) = predictor.block(&mut ())? {
    ///     rows += block.cop_m.len();
    /// }
    /// assert_eq!(rows, 1000);
    /// # Ok::<(), sesc_identify::Error>(())
    /// ```
    ///
    /// # Errors
    /// Whatever is wrong with the log or its sidecar.
    pub fn open(request: &Request, watch: &mut dyn Watch) -> Result<Predictor, Error> {
        let Request {
            stance,
            log,
            angles,
            motion,
        } = request;
        // With a support of the caller's, what the log says about it is not looked at.
        let links = stance.robot.description.link_names();
        let links = links.filter(|_| stance.support.is_none());
        let options = Options {
            angles: *angles,
            readings: Readings::Ignored,
            links: links.map(str::to_string).collect(),
            stays: Stays::Apart,
            ..Options::default()
        };
        let (sidecar, _) = log.sidecar()?;
        let support = stance.support(sidecar.support.as_deref()).ok();
        let dofs = joints(log, &stance.robot.description, &options, support)?;
        let reader = PostureReader::open(log, &dofs, &options)?;
        let mut stance = stance.clone();
        if stance.support.is_none() && reader.is_recording() {
            let with_readings = Options {
                readings: Readings::Optional,
                ..options.clone()
            };
            let first = PostureReader::open(log, &dofs, &with_readings)?.first_support()?;
            let first = first.filter(|link| !link.is_empty());
            stance.support = first.map(|link| link.to_string());
        }
        let sidecar = reader.sidecar.clone();
        // As readings counted that the parameters are from.
        let counted = stance.parameters.as_ref().and_then(|file| file.motion);
        let reader = match motion {
            MotionModel::Auto => Moving::planned(reader, dofs.len(), HEAD, Wanted::Alone)?,
            MotionModel::Off => Moving::new(reader, dofs.len(), None, Wanted::Alone),
        };
        let mut predictor = Predictor {
            stance,
            log: log.name().to_string(),
            reader,
            sidecar,
            evaluators: HashMap::new(),
            approach: Approach::of(&dofs),
            began_s: None,
            is_static: counted == Some(MotionCounted::Static),
        };
        predictor.warn(watch);
        Ok(predictor)
    }

    /// Predictions for the next rows; none at the end of the log.
    ///
    /// # Errors
    /// A faulty row, rows that stand on no known link, an angle beyond all bounds.
    pub fn block(&mut self, watch: &mut dyn Watch) -> Result<Option<Predictions>, Error> {
        let (block, motion) = self.reader.rows(BLOCK)?;
        self.warn(watch);
        if block.is_empty() {
            self.warn_of_soles(watch);
            return Ok(None);
        }
        let (done, total) = self.reader.log.progress();
        tell(watch, "predicting", done, total)?;
        let found = self.predictions(&block, motion.as_ref(), watch)?;
        let finite = |row: &usize| {
            let (com, cop) = (&found.com_m[*row], &found.cop_m[*row]);
            com.iter().chain(cop).all(|x| x.is_finite())
        };
        if let Some(row) = (0..block.len()).find(|row| !finite(row)) {
            let message = "this posture has no finite CoM and CoP: an angle of a mimic joint is \
                           beyond 2^20 rad, where sines mean nothing, or an effect of the model \
                           file has a value that no robot has";
            return Err(Error::log(&self.log, Some(block.line[row]), message));
        }
        Ok(Some(found))
    }

    /// Runs of rows on one support are evaluated together.
    fn predictions(
        &mut self,
        block: &Block,
        motion: Option<&Motion>,
        watch: &mut dyn Watch,
    ) -> Result<Predictions, Error> {
        let dof = block.q.len() / block.len();
        let times = block.t.as_deref().unwrap_or_default();
        let first_s = times.first().copied().unwrap_or_default();
        let began_s = *self.began_s.get_or_insert(first_s);
        let positions = motion.map_or(&block.q, |motion| &motion.positions);
        let sides = positions.chunks_exact(dof.max(1));
        let sides = sides.flat_map(|q| self.approach.at(q).to_vec());
        let sides: Vec<f64> = sides.collect();
        let on = |row: usize| block.support.as_ref().map_or("", |all| &*all[row]);
        let mut found = Predictions {
            pose: block.pose.clone(),
            ..Predictions::default()
        };
        let (mut start, is_static) = (0, self.is_static);
        while start < block.len() {
            let link = on(start);
            let n = (start..block.len()).take_while(|row| on(*row) == link);
            let n = n.count();
            let logged = Some(link).filter(|link| !link.is_empty());
            let on_link = self.evaluator(logged, watch)?;
            check_joints(&on_link.model, dof)?;
            let q = &block.q[start * dof..(start + n) * dof];
            if let Some(soles) = &mut on_link.soles {
                soles.see(q, dof);
            }
            let gravity = block.gravity.as_ref();
            let gravity = gravity.map_or(&[][..], |all| &all[start..start + n]);
            let own = times.get(start..start + n).unwrap_or_default();
            let log = InLog {
                since_s: own.iter().map(|t| t - began_s).collect(),
                sides: sides[start * dof..(start + n) * dof].to_vec(),
            };
            let (com, mut cop) = on_link.readings.run((q, n), &log, gravity, &[]);
            if let Some(motion) = motion {
                // As a fit and a diagnosis see the joints.
                let q = &motion.positions[start * dof..(start + n) * dof];
                let shifts = match is_static {
                    true => Vec::new(),
                    false => on_link.shifts(q, motion, start, gravity),
                };
                cop = on_link.readings.run((q, n), &log, gravity, &shifts).1;
            }
            found.com_m.extend(com.as_chunks().0);
            found.cop_m.extend(cop.as_chunks().0);
            start += n;
        }
        Ok(found)
    }

    fn evaluator(
        &mut self,
        logged: Option<&str>,
        watch: &mut dyn Watch,
    ) -> Result<&mut Evaluators, Error> {
        let support = self.stance.support(logged)?;
        if !self.evaluators.contains_key(support) {
            let model = self.stance.model_on(support)?;
            if self.evaluators.is_empty() {
                let notes = model.tree.notes.iter().cloned().chain(model.cautions());
                notes.for_each(|note| watch.note(&note));
            }
            // Where the other sole cannot be told, nothing is said of it.
            let other = Feet::default().of(&self.sidecar, &model);
            let evaluators = Evaluators {
                readings: ReadingPredictor::new(&model),
                motion: None,
                soles: other.unwrap_or_default().map(Soles::new),
                model,
            };
            self.evaluators.insert(support.to_string(), evaluators);
        }
        Ok(self.evaluators.get_mut(support).expect("inserted above"))
    }

    /// Say once where soles do not close in the rows that were predicted.
    fn warn_of_soles(&mut self, watch: &mut dyn Watch) {
        for on_link in self.evaluators.values_mut() {
            let soles = on_link.soles.take();
            if let Some(open) = soles.and_then(|soles| soles.open(&on_link.model)) {
                watch.warning(&open.into());
            }
        }
    }

    /// What the reader noticed and has not yet been told.
    fn warn(&mut self, watch: &mut dyn Watch) {
        let warnings = self.reader.log.warnings.drain(..);
        warnings.for_each(|warning| watch.warning(&warning));
    }
}

impl Evaluators {
    /// What motion adds to the CoP of postures that are rows of it from `start`: by CAD's masses and
    /// the model's effects, and what its masses change of it as a fit counts that.
    fn shifts(
        &mut self,
        q: &[f64],
        motion: &Motion,
        start: usize,
        gravity: &[[f64; 3]],
    ) -> Vec<[f64; 2]> {
        let model = &self.model;
        let make = || {
            (
                MotionPredictor::new(&model.with_cad_masses()),
                Zmp::new(model),
            )
        };
        let (predictor, zmp) = self.motion.get_or_insert_with(make);
        let dof = model.dof();
        let own = start * dof..start * dof + q.len();
        let motion = (&motion.rates[own.clone()], &motion.gains[own]);
        let n = q.len() / dof;
        let mut shifts = predictor.shifts(q, n, motion);
        let mut add = |all: Vec<[f64; 2]>, sign: f64| {
            let all = shifts.iter_mut().flatten().zip(all.into_iter().flatten());
            all.for_each(|(shift, by)| *shift += sign * by);
        };
        let level = vec![[0.0; 2]; n];
        let tilts = match gravity {
            [] => level.clone(),
            gravity => gravity.iter().map(|g| rows::tilt(*g)).collect(),
        };
        let cad = model.cad_params();
        if tilts != level {
            add(zmp.shifts(&cad, q, motion, &tilts), 1.0);
            add(zmp.shifts(&cad, q, motion, &level), -1.0);
        }
        if model.params() != cad {
            let off = model.params().into_iter().zip(cad).map(|(r, cad)| r - cad);
            add(
                zmp.shifts_by_masses(&off.collect::<Vec<_>>(), q, motion, &tilts),
                1.0,
            );
        }
        shifts
    }
}

/// Postures that are looked at: from twice as many on, every other one of them is let go.
const POSTURES: usize = 2000;

/// Postures of a log on one support, evenly chosen.
struct Soles {
    other: OtherFoot,
    q: Vec<f64>,
    /// Every so many rows one is kept.
    every: usize,
    rows: usize,
}

impl Soles {
    fn new(other: OtherFoot) -> Soles {
        Soles {
            other,
            q: Vec::new(),
            every: 1,
            rows: 0,
        }
    }

    /// Take note of postures `q[posture * dof + joint]`.
    fn see(&mut self, q: &[f64], dof: usize) {
        for posture in q.chunks_exact(dof.max(1)) {
            if self.rows.is_multiple_of(self.every) {
                self.q.extend(posture);
            }
            self.rows += 1;
            if self.q.len() >= 2 * POSTURES * dof {
                let all = std::mem::take(&mut self.q);
                let kept = all.chunks_exact(dof).step_by(2);
                self.q = kept.flatten().copied().collect();
                self.every *= 2;
            }
        }
    }

    /// What is said where they do not close, as `model` has its joints.
    fn open(&self, model: &Model) -> Option<String> {
        let q = bent(model, &self.q);
        let closure = Closure::of(model, self.other.clone(), &q, None);
        let source = if model.effects.is_empty() {
            "CAD"
        } else {
            "the model file"
        };
        let found = closure.found_by(source);
        (!found.closes).then(|| {
            format!(
                "{} Predictions take the joints to be there; a diagnosis of the log can tell what \
                 is off",
                found.sentence
            )
        })
    }
}

/// Joint positions as the effects of a model bend them.
fn bent(model: &Model, q: &[f64]) -> Vec<f64> {
    if model.effects.is_empty() {
        return q.to_vec();
    }
    let context = EffectContext::new(model, &[], false, Catalog::standard());
    let instances: Vec<Instance> = model.effects.iter().map(|(i, _)| i.clone()).collect();
    let values: Vec<f64> = model.effects.iter().flat_map(|(_, x)| x.clone()).collect();
    let tape = Tape::new(&effects::joints(&context, &instances, &model.params()));
    let n = q.len() / model.dof().max(1);
    let level = vec![0.0; n * PostureContext::of(model).len()];
    let arguments = [
        Values::PerPosture(q),
        Values::Shared(&values),
        Values::PerPosture(&level),
    ];
    let mut out = vec![0.0; q.len()];
    tape.run(&arguments, n, &mut out, FASTEST);
    out
}

//! CoM and CoP of the postures in a log, on whatever link each stands.
//!
//! ```text
//! CoP = CoM − z_CoM g / g_z        without effects: the CoM along gravity g on the sole plane
//! ```
//!
//! A model with effects predicts the reading of its sensor instead.

use std::collections::HashMap;

use sesc_model::Function;

use crate::Error;
use crate::evaluate::{EffectPredictor, Evaluator};
use crate::logs::{Angles, Block, LogSource, Options, PostureReader, Readings};
use crate::stance::Stance;
use crate::watch::{Watch, tell};

/// Rows that are read and evaluated together.
const BLOCK: usize = 4096;

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
}

impl Request {
    /// Predict every posture of `log`.
    pub fn new(stance: Stance, log: impl Into<LogSource>) -> Request {
        Request {
            stance,
            log: log.into(),
            angles: None,
        }
    }
}

/// Predictions, one entry per row of the log.
#[derive(Debug, Clone, Default, PartialEq)]
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
/// use sesc_identify::robot::Robot;
/// use sesc_identify::stance::Stance;
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
    reader: PostureReader,
    evaluators: HashMap<String, (Evaluator, Option<EffectPredictor>)>,
}

impl Predictor {
    /// Open the log.
    ///
    /// # Errors
    /// Whatever is wrong with the log or its sidecar.
    pub fn open(request: &Request, watch: &mut dyn Watch) -> Result<Predictor, Error> {
        let Request {
            stance,
            log,
            angles,
        } = request;
        // With a support of the caller's, what the log says about it is not looked at.
        let links = match stance.support {
            Some(_) => Vec::new(),
            None => {
                let links = stance.robot.description.link_names();
                links.map(str::to_string).collect()
            }
        };
        let options = Options {
            angles: *angles,
            readings: Readings::Ignored,
            links,
            ..Options::default()
        };
        let dofs = stance.robot.description.dofs();
        let reader = PostureReader::open(log, &dofs, &options)?;
        let mut predictor = Predictor {
            stance: stance.clone(),
            log: log.name().to_string(),
            reader,
            evaluators: HashMap::new(),
        };
        predictor.warn(watch);
        Ok(predictor)
    }

    /// Predictions for the next rows; none at the end of the log.
    ///
    /// # Errors
    /// A faulty row, rows that stand on no known link, an angle beyond all bounds.
    pub fn block(&mut self, watch: &mut dyn Watch) -> Result<Option<Predictions>, Error> {
        let block = self.reader.block(BLOCK)?;
        self.warn(watch);
        if block.is_empty() {
            return Ok(None);
        }
        let (done, total) = self.reader.progress();
        tell(watch, "predicting", done, total)?;
        let found = self.predictions(&block, watch)?;
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
    fn predictions(&mut self, block: &Block, watch: &mut dyn Watch) -> Result<Predictions, Error> {
        let dof = block.q.len() / block.len();
        let on = |row: usize| block.support.as_ref().map_or("", |all| &*all[row]);
        let mut found = Predictions {
            pose: block.pose.clone(),
            ..Predictions::default()
        };
        let mut start = 0;
        while start < block.len() {
            let link = on(start);
            let n = (start..block.len()).take_while(|row| on(*row) == link);
            let n = n.count();
            let logged = Some(link).filter(|link| !link.is_empty());
            let (com, effects) = self.evaluator(logged, watch)?;
            let q = &block.q[start * dof..(start + n) * dof];
            let gravity = block.gravity.as_ref().map(|all| &all[start..start + n]);
            let com = match effects {
                Some(effects) => {
                    let (com, cop) = effects.run(q, n, gravity);
                    found
                        .cop_m
                        .extend(cop.chunks_exact(2).map(|c| [c[0], c[1]]));
                    com
                }
                None => {
                    let com = com.run(q, n);
                    let down = |k: usize| gravity.map_or([0.0, 0.0, -1.0], |all| all[k]);
                    let projections = com.chunks_exact(3).enumerate();
                    let projections =
                        projections.map(|(k, c)| projected([c[0], c[1], c[2]], down(k)));
                    found.cop_m.extend(projections);
                    com
                }
            };
            found
                .com_m
                .extend(com.chunks_exact(3).map(|c| [c[0], c[1], c[2]]));
            start += n;
        }
        Ok(found)
    }

    fn evaluator(
        &mut self,
        logged: Option<&str>,
        watch: &mut dyn Watch,
    ) -> Result<&(Evaluator, Option<EffectPredictor>), Error> {
        let support = self.stance.support(logged)?;
        if !self.evaluators.contains_key(support) {
            let model = self.stance.model_on(support)?;
            if self.evaluators.is_empty() {
                let notes = model.tree.notes.iter().cloned();
                notes
                    .chain(model.left_out())
                    .for_each(|note| watch.note(&note));
            }
            let evaluators = (
                Evaluator::new(&model, Function::Com),
                EffectPredictor::new(&model),
            );
            self.evaluators.insert(support.to_string(), evaluators);
        }
        Ok(&self.evaluators[support])
    }

    /// What the reader noticed and has not yet been told.
    fn warn(&mut self, watch: &mut dyn Watch) {
        let warnings = self.reader.warnings.drain(..);
        warnings.for_each(|warning| watch.warning(&warning));
    }
}

/// The CoM along gravity on the sole plane z = 0.
fn projected([x, y, z]: [f64; 3], gravity: [f64; 3]) -> [f64; 2] {
    let down = z / gravity[2];
    [x - gravity[0] * down, y - gravity[1] * down]
}

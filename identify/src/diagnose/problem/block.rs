//! One log in one support as a block of the likelihood: its rows, their noise, and what a
//! hypothesis predicts of them.
//!
//! ```text
//! y_b = f_b(S_b e, T_b r) + noise        S_b: what an experiment makes of the unknowns
//!                                        T_b: base parameters here from those of the first block
//! 0   = h_b(S_b e) + noise               soles of a two-foot stand, see `feet`
//! ```
//!
//! Masses move no sole, and sensors and the ground's slope do not: what bends the legs does.
//! Where joints give way, they do so as in the readings, under the moments of a robot that
//! stands on the support alone.

use std::collections::HashMap;
use std::sync::{Arc, Mutex, OnceLock, PoisonError};

use nalgebra::{DMatrix, DVector};
use sesc_model::effects::{
    self, Catalog, EffectContext, Experiment, Instance, PostureContext, Stage,
};
use sesc_model::standard::Shift;
use sesc_model::tape::{Tape, Values};
use sesc_model::{Function, Model};

use super::left_by_masses;
use crate::diagnose::hypothesis::{Term, effects_of, with_places};
use crate::evaluate::{Evaluator, FASTEST};
use crate::feet::{Closure, OtherFoot, ROWS};
use crate::health::wirings;
use crate::observations::correlation::Process;
use crate::observations::noise::NoiseSource;
use crate::observations::postures::Postures;
use crate::observations::rows::CopRows;

/// Rows of one log in one support.
#[derive(Clone)]
pub struct Block<'m> {
    /// The robot on this support, with the masses about which the log is explained.
    pub model: &'m Model,
    pub context: EffectContext<'m>,
    pub data: Postures,
    /// Base parameters from CAD, m.
    pub cad: Vec<f64>,
    /// Those about which readings are linear in masses: CAD's, or where a fit ended.
    pub params: Vec<f64>,
    /// Whitened shift of readings from `params` back to CAD's, where they differ.
    pub(super) offset: Option<DVector<f64>>,
    /// 1/σ per reading.
    pub weight: Vec<f64>,
    /// Factor of each axis's noise for the correlation of its readings in time.
    pub widened: [f64; 2],
    /// How each axis's noise lasts; none where readings are independent.
    pub(super) lasting: [Option<Process>; 2],
    /// Derivative of the readings by the base parameters here, 2 rows a posture.
    pub rows: Arc<DMatrix<f64>>,
    /// What of them is motion's; none of standing robots.
    motion_rows: Option<Arc<DMatrix<f64>>>,
    /// Both soles on one floor, where the log is of both feet.
    pub(crate) closure: Option<Arc<Closure>>,
    /// What this block makes of the first one's unknowns and masses; none of the first itself.
    pub further: Option<Further>,
    /// Shared by copies of the block, whose noise may be another.
    tapes: Arc<Mutex<HashMap<Vec<Instance>, Arc<Tapes>>>>,
}

/// A block beside the first one.
#[derive(Clone)]
pub struct Further {
    pub experiment: Experiment,
    /// Base parameters here from those of the first block; none on the same support.
    pub shift: Option<Arc<Shift>>,
}

/// Whitened rows of the soles: three a posture.
#[derive(Debug, Clone)]
pub struct Closed {
    /// (0 − value)/σ
    pub residual: DVector<f64>,
    /// Derivative of the value by the unknowns, over σ.
    pub slopes: DMatrix<f64>,
}

/// What a set of terms runs on.
struct Tapes {
    reading: Tape,
    /// Made when a dead band asks for sides.
    moments: OnceLock<Arc<Tape>>,
    /// Made where the log is of both feet.
    soles: OnceLock<Arc<Tape>>,
}

/// Whether a term moves a joint from where its encoder says.
fn bends(term: &Term) -> bool {
    let moves = |stage| stage <= Stage::Joints || stage == Stage::Bends;
    term.stage().is_some_and(moves)
}

impl<'m> Block<'m> {
    /// A log of the robot that stands as `model` does.
    pub(crate) fn new(
        model: &'m Model,
        mut data: Postures,
        closure: Option<Closure>,
        effects: &Catalog,
    ) -> Block<'m> {
        let times = data.motion.is_some();
        let mut context = EffectContext::new(model, &data.cells, times, effects.clone());
        context.moving = data.moved.is_some();
        let n = data.len();
        let layout = PostureContext::of(model);
        let entry = |k: usize, entry: usize| data.posture_context[k * layout.len() + entry];
        let tilt = |k: usize| [0, 1].map(|axis| entry(k, layout.tilt(axis)));
        let tilts: Vec<[f64; 2]> = (0..n).map(tilt).collect();
        let mut rows = CopRows::new(model).of(&data.q, n, Some(&tilts));
        let motion_rows = data.moved.as_ref().map(|moved| {
            let standing = std::mem::replace(&mut rows, moved.rows.dense());
            Arc::new(&rows - standing)
        });
        if data.noise_source == NoiseSource::Residuals {
            let mut out = Evaluator::new(model, Function::Cop).run(&data.q, n);
            let moved = data
                .moved
                .iter()
                .flat_map(|moved| moved.shift.iter().flatten());
            out.iter_mut().zip(moved).for_each(|(cop, by)| *cop += by);
            let (left, taken) = left_by_masses(&rows, &data.reading, &out);
            data.take_noise(&left, taken);
        }
        Block {
            cad: model.cad_params(),
            params: model.cad_params(),
            offset: None,
            widened: [1.0; 2],
            lasting: [None; 2],
            model,
            context,
            weight: data.std.iter().map(|s| 1.0 / s).collect(),
            data,
            rows: Arc::new(rows),
            motion_rows,
            closure: closure.map(Arc::new),
            further: None,
            tapes: Arc::default(),
        }
    }

    /// This log as one of an `experiment` beside the `first`.
    pub fn beside(self, first: &Block, experiment: Experiment) -> Block<'m> {
        let elsewhere = self.model.support() != first.model.support();
        let shift = elsewhere.then(|| Arc::new(self.model.params_from(first.context.robot)));
        Block {
            further: Some(Further { experiment, shift }),
            ..self
        }
    }

    /// The readings of the postures that are true in `keep`, without the soles.
    pub(super) fn some(&self, keep: &[bool]) -> Block<'m> {
        let mut data = self.data.clone();
        data.keep(keep);
        let is_kept = |row: &usize| keep[row / 2];
        let rows: Vec<usize> = (0..self.rows.nrows()).filter(is_kept).collect();
        Block {
            data,
            rows: Arc::new(self.rows.select_rows(&rows)),
            offset: self.offset.as_ref().map(|own| own.select_rows(&rows)),
            motion_rows: None,
            closure: None,
            ..self.clone()
        }
    }

    /// The same robot on another support: nothing can be fitted there, explanations can be
    /// evaluated.
    pub fn on<'o>(&self, model: &'o Model) -> Block<'o>
    where
        'm: 'o,
    {
        let (cells, times) = (&self.data.cells, self.data.motion.is_some());
        Block {
            cad: model.cad_params(),
            params: model.cad_params(),
            offset: None,
            widened: [1.0; 2],
            lasting: [None; 2],
            context: EffectContext::new(model, cells, times, self.context.catalog.clone()),
            model,
            motion_rows: None,
            closure: None,
            tapes: Arc::default(),
            ..self.clone()
        }
    }

    /// The same block about masses `params` (m): `rows` are the slopes of readings there.
    pub(in crate::diagnose) fn about(&self, params: Vec<f64>, rows: DMatrix<f64>) -> Block<'m> {
        let errors = params.iter().zip(&self.cad).map(|(r, cad)| r - cad);
        let mut offset = &rows * DVector::from_iterator(params.len(), errors);
        for (shift, weight) in offset.iter_mut().zip(&self.weight) {
            *shift *= weight;
        }
        Block {
            params,
            offset: Some(offset),
            rows: Arc::new(rows),
            tapes: Arc::default(),
            ..self.clone()
        }
    }

    /// Readings and, below them, rows of the soles.
    pub(super) fn height(&self) -> usize {
        let soles = if self.closure.is_some() { ROWS } else { 0 };
        (2 + soles) * self.data.len()
    }

    /// Rows by the base parameters of the first block.
    pub(in crate::diagnose) fn rows_of_first(&self) -> DMatrix<f64> {
        match self.shift() {
            Some(shift) => &*self.rows * &shift.matrix,
            None => (*self.rows).clone(),
        }
    }

    /// Base parameters here where those of the first block are `r`, m.
    pub(in crate::diagnose) fn params_from_first(&self, r: &[f64]) -> Vec<f64> {
        match self.shift() {
            Some(shift) => {
                let own = &shift.matrix * DVector::from_column_slice(r) + &shift.offset;
                own.as_slice().to_vec()
            }
            None => r.to_vec(),
        }
    }

    fn shift(&self) -> Option<&Shift> {
        self.further.as_ref()?.shift.as_deref()
    }

    /// Change of what motion adds to readings where masses are `r` (m) and not CAD's, m; empty of
    /// standing robots.
    pub(in crate::diagnose) fn motion_of(&self, r: &[f64]) -> Vec<f64> {
        let Some(rows) = &self.motion_rows else {
            return Vec::new();
        };
        let off = DVector::from_fn(r.len(), |k, _| r[k] - self.cad[k]);
        (&**rows * off).as_slice().to_vec()
    }

    /// Derivative of readings by masses where that of readings without motion is `still`.
    pub(in crate::diagnose) fn with_motion(&self, still: DMatrix<f64>) -> DMatrix<f64> {
        match &self.motion_rows {
            Some(rows) => still + &**rows,
            None => still,
        }
    }

    /// The reading of CAD's masses where that of `params` is given, by what is linear in masses, m.
    pub(in crate::diagnose) fn of_cad(&self, row: usize, reading: f64) -> f64 {
        let offset = self.offset.as_ref().map_or(0.0, |offset| offset[row]);
        reading - offset / self.weight[row]
    }

    /// Whitened residuals of readings that are `predicted`, m.
    pub(in crate::diagnose) fn residual(&self, predicted: &[f64]) -> DVector<f64> {
        DVector::from_fn(predicted.len(), |row, _| {
            (self.data.reading[row] - predicted[row]) * self.weight[row]
        })
    }

    /// Rows per independent one, of the axis that has fewer.
    pub(in crate::diagnose) fn rows_per_sample(&self) -> f64 {
        self.widened[0].max(self.widened[1]).powi(2)
    }

    /// Readings and the directions that masses take of them, where nothing states the noise and
    /// readings are fewer than twice those: what masses leave says little of it.
    pub fn too_few(&self) -> Option<[usize; 2]> {
        let unknown = self.data.noise_source == NoiseSource::Residuals;
        let (rows, directions) = (self.rows.nrows(), self.rows.ncols());
        (unknown && rows < 2 * directions).then_some([rows, directions.min(rows)])
    }

    /// The revolute joints that have a dead band under `terms`, with the place of its width among
    /// the unknowns.
    pub(in crate::diagnose) fn slack_joints(&self, terms: &[Term]) -> Vec<(usize, usize)> {
        let mut found = Vec::new();
        for (term, own) in with_places(terms, &self.context) {
            if let (Some(_), Some(instance)) = (term.dead_band(), term.effect()) {
                let joints = instance.target.revolute(self.context.robot);
                found.extend(joints.into_iter().map(|j| (j, own.start)));
            }
        }
        found
    }

    /// The programs of a set of terms, made once; two that ask at the same time may both make
    /// them, and the same.
    fn tapes(&self, terms: &[Term]) -> Arc<Tapes> {
        let known = || self.tapes.lock().unwrap_or_else(PoisonError::into_inner);
        let key = effects_of(terms);
        if let Some(tapes) = known().get(&key) {
            return tapes.clone();
        }
        let program = effects::reading(&self.context, &key, &self.params);
        let tapes = Arc::new(Tapes {
            reading: Tape::of_many(&program),
            moments: OnceLock::new(),
            soles: OnceLock::new(),
        });
        known().entry(key).or_insert(tapes).clone()
    }

    fn moments(&self, terms: &[Term]) -> Arc<Tape> {
        let tapes = self.tapes(terms);
        let made = tapes.moments.get_or_init(|| {
            let program = effects::moments(&self.context, &effects_of(terms), &self.params);
            Arc::new(Tape::of_many(&program))
        });
        made.clone()
    }

    fn soles(&self, terms: &[Term], other: &OtherFoot) -> Arc<Tape> {
        let tapes = self.tapes(terms);
        let made = tapes.soles.get_or_init(|| {
            let effects = effects_of(terms);
            let program = effects::other_sole(&self.context, &effects, &self.params, other.place());
            Arc::new(Tape::of_many(&program))
        });
        made.clone()
    }

    /// Outputs of a program at joint positions `q`, posture by posture.
    fn run(&self, tape: &Tape, q: &[f64], unknowns: &[f64], posture_context: &[f64]) -> Vec<f64> {
        let n = posture_context.len() / PostureContext::of(self.context.robot).len();
        let mut out = vec![0.0; n * tape.outputs()];
        let arguments = [
            Values::PerPosture(q),
            Values::Shared(unknowns),
            Values::PerPosture(posture_context),
        ];
        tape.run(&arguments, n, &mut out, FASTEST);
        out
    }

    /// Readings and derivatives of as many postures as there are contexts: per posture x then y, each value, ∂/∂e_1, ….
    pub fn evaluate(
        &self,
        terms: &[Term],
        unknowns: &[f64],
        q: &[f64],
        posture_context: &[f64],
    ) -> Vec<f64> {
        let tapes = self.tapes(terms);
        self.run(&tapes.reading, q, unknowns, posture_context)
    }

    /// Moments (m) and slopes of the reading by joint at positions `q`: 3 × dof per posture.
    pub(in crate::diagnose) fn evaluate_moments(
        &self,
        terms: &[Term],
        unknowns: &[f64],
        q: &[f64],
        posture_context: &[f64],
    ) -> Vec<f64> {
        self.run(&self.moments(terms), q, unknowns, posture_context)
    }

    /// Gravity moments and slopes of the robot with CAD masses, at positions `q`.
    pub(in crate::diagnose) fn moments_at(&self, q: &[f64]) -> Vec<f64> {
        self.evaluate_moments(&[], &[], q, &self.data.posture_context)
    }

    /// The soles at joint positions `q`; `None` where the log is not of both feet.
    pub(super) fn closed(
        &self,
        terms: &[Term],
        unknowns: &[f64],
        q: &[f64],
        posture_context: &[f64],
    ) -> Option<Closed> {
        let closure = self.closure.as_deref()?;
        // Sensors, masses and the ground move no sole: one program is enough for them all.
        let idle = !terms.iter().any(bends);
        let (own, given): (&[Term], &[f64]) = if idle { (&[], &[]) } else { (terms, unknowns) };
        let tape = self.soles(own, &closure.other);
        let out = self.run(&tape, q, given, posture_context);
        let width = 1 + given.len();
        let rows = ROWS * self.data.len();
        let slopes = DMatrix::from_fn(rows, unknowns.len(), |row, k| {
            if idle {
                0.0
            } else {
                out[row * width + 1 + k] * closure.weight(row)
            }
        });
        Some(Closed {
            residual: closure.whitened(out.iter().step_by(width).copied()),
            slopes,
        })
    }

    /// The sides on which joints rest in the context of a fit to this log.
    pub(in crate::diagnose) fn sides_of(&self, posture_context: &[f64]) -> OwnSides {
        let robot = self.context.robot;
        let layout = PostureContext::of(robot);
        let log = &self.data.posture_context;
        OwnSides::of(&layout, robot.dof(), log, posture_context)
    }

    /// Joint positions of every posture as a hypothesis bends them.
    pub fn bent(&self, terms: &[Term], unknowns: &[f64], posture_context: &[f64]) -> Vec<f64> {
        if !terms.iter().any(bends) {
            return self.data.q.clone();
        }
        let program = effects::joints(&self.context, &effects_of(terms), &self.params);
        let q = &self.data.q;
        self.run(&Tape::of_many(&program), q, unknowns, posture_context)
    }

    /// The effect of faults of wiring or of the record: the joint positions that they leave, and
    /// what becomes of a reading (m, two per posture).
    pub(in crate::diagnose) fn rewired(&self, faults: &[Term]) -> (Vec<f64>, Rewire) {
        let faults = effects_of(faults);
        let q = match faults.iter().any(|own| own.effect.stage() == Stage::Wiring) {
            true => wirings::positions(&self.context, &faults, &self.data.q),
            false => self.data.q.clone(),
        };
        let of_reading = |own: &Instance| own.effect.is_sensor_effect(&own.target);
        let reading = faults.iter().any(of_reading);
        let rewire = reading.then(|| effects::wired_reading(&self.context, &faults));
        (q, Rewire(rewire.map(|program| Tape::of_many(&program))))
    }
}

/// How a fault of the record changes readings; none where it does not.
pub(in crate::diagnose) struct Rewire(Option<Tape>);

impl Rewire {
    /// Readings under the fault, two per posture.
    pub(in crate::diagnose) fn readings(&self, readings: &[f64]) -> Vec<f64> {
        let Some(tape) = &self.0 else {
            return readings.to_vec();
        };
        let mut out = vec![0.0; readings.len()];
        let arguments = [Values::PerPosture(readings)];
        tape.run(&arguments, readings.len() / 2, &mut out, FASTEST);
        out
    }
}

/// The sides on which joints rest in a fit, where they are not those of the log's context.
#[derive(Debug, Clone)]
pub struct OwnSides {
    joints: Vec<usize>,
    /// Posture by posture.
    sides: Arc<Vec<f64>>,
}

impl OwnSides {
    /// The sides by which the context `own` of a fit differs from that of its log; robots have
    /// `dof` joints.
    pub fn of(layout: &PostureContext, dof: usize, log: &[f64], own: &[f64]) -> OwnSides {
        let postures = || (0..log.len()).step_by(layout.len());
        let differs = |joint: &usize| {
            let side = layout.side(*joint);
            postures().any(|at| own[at + side].to_bits() != log[at + side].to_bits())
        };
        let joints: Vec<usize> = (0..dof).filter(differs).collect();
        let sides = postures().flat_map(|at| joints.iter().map(move |j| own[at + layout.side(*j)]));
        OwnSides {
            sides: Arc::new(sides.collect()),
            joints,
        }
    }

    /// The context of the fit: that of its log with these sides in it.
    pub fn context(&self, layout: &PostureContext, log: &[f64]) -> Vec<f64> {
        let mut all = log.to_vec();
        let postures = all.chunks_exact_mut(layout.len());
        let own = self.sides.chunks_exact(self.joints.len().max(1));
        for (posture, sides) in postures.zip(own) {
            for (joint, side) in self.joints.iter().zip(sides) {
                posture[layout.side(*joint)] = *side;
            }
        }
        all
    }
}

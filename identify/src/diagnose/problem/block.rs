//! One log in one support as a block of the likelihood: its rows, their noise, and what a
//! hypothesis predicts of them.
//!
//! ```text
//! y_b = f_b(S_b e, T_b r) + noise        S_b: what an experiment makes of the unknowns
//!                                        T_b: base parameters here from those of the first block
//! 0   = h_b(S_b e) + noise               soles of a two-foot stand, see `feet`
//! m/M = 1 + Σ μ_k/(1 − μ_k) + δ + noise   total force, where the log has it
//! ```
//!
//! μ_k is the share of the weight that a load or a pull of S_b e adds, δ what CAD's mass is off by.
//!
//! Masses move no sole, and sensors and the ground's slope do not: what bends the legs does.
//! Where joints give way, they do so as in the readings, under the moments of a robot that
//! stands on the support alone.

use std::collections::HashMap;
use std::sync::{Arc, Mutex, PoisonError};

use nalgebra::{DMatrix, DVector, RowDVector};
use sesc_model::effects::{
    self, Catalog, EffectContext, Experiment, Instance, PostureContext, Stage,
};
use sesc_model::standard::Shift;
use sesc_model::tape::{Tape, Values};
use sesc_model::{Function, Model};

use super::{OnBlock, below, without};
use crate::Error;
use crate::diagnose::hypothesis::{CarriedExplanation, Term, effects_of, with_places};
use crate::evaluate::{Evaluator, FASTEST};
use crate::feet::{Closure, Feet, ROWS, of_many, of_one_foot, tell_contacts};
use crate::health::wirings;
use crate::logs::Sidecar;
use crate::observations::correlation::Process;
use crate::observations::criteria::correlation::{LARGE, SHORT};
use crate::observations::noise::NoiseSource;
use crate::observations::postures::{Postures, rms};
use crate::observations::rows::CopRows;
use crate::watch::Watch;

/// Rows of one log in one support.
#[derive(Clone)]
pub(crate) struct Block<'m> {
    /// The robot on this support, with the masses about which the log is explained.
    pub model: &'m Model,
    pub context: EffectContext<'m>,
    pub data: Postures,
    /// Base parameters from CAD, m.
    pub cad: Vec<f64>,
    /// Those about which readings are linear in masses: CAD's, or where a fit ended.
    pub params: Vec<f64>,
    /// Whitened shift of readings from `params` back to CAD's, where they differ.
    pub(in crate::diagnose) offset: Option<DVector<f64>>,
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
    /// What the total force weighs over CAD's mass, less one, and the deviation of that.
    pub(super) weighed: Option<[f64; 2]>,
    /// What the log is of beside the first one; none of the first itself.
    pub experiment: Option<Experiment>,
    /// Base parameters here from those of the first block; none on the same support.
    shift: Option<Arc<Shift>>,
    /// Shared by copies of the block, whose noise may be another.
    tapes: Arc<Mutex<Tapes>>,
}

/// What a model file predicts of a log, posture by posture.
pub(crate) struct InFile {
    /// x, y, m.
    pub readings: Vec<f64>,
    /// How far into its dead band each joint is.
    pub depths: Vec<f64>,
}

/// Programs by what they compute and the effects in them.
type Tapes = HashMap<(Output, Vec<Instance>), Arc<Tape>>;

/// What a program of a set of terms computes.
#[derive(Clone, Copy, PartialEq, Eq, Hash)]
enum Output {
    Reading,
    /// Of gravity, with slopes of the reading by joints.
    Moments,
    /// Joint positions.
    Joints,
    /// Where the other sole is.
    Sole,
    /// Of any masses: reading, and how far into its dead band each joint is.
    InFile,
    /// Of any masses: reading with its derivatives by the base parameters.
    ByMasses,
}

/// Whether a term moves a joint from where its encoder says.
fn bends(term: &Term) -> bool {
    let moves = |stage| stage <= Stage::Joints || stage == Stage::Bends;
    term.stage().is_some_and(moves)
}

/// Why noise is not told from a misfit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Untold {
    /// Nothing states it, and readings are fewer than twice the directions of the masses.
    Few { rows: usize, directions: usize },
    /// It lasts for more than a fifth of the log.
    Lasting,
    /// Nothing states it, and it would be as large as the spread of the readings.
    AsLargeAsSpread,
    /// Nothing states it, and it would be larger than a fifth of the sole.
    LargeForSole,
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
        let mut context =
            EffectContext::new(model, &data.cells, times, effects.clone()).fitted(data.t.is_some());
        context.moving = data.moved.is_some();
        let n = data.len();
        let mut rows = CopRows::new(model).of(&data.q, n, Some(&tilts(&data, model)));
        let motion_rows = data.moved.as_ref().map(|moved| {
            let standing = std::mem::replace(&mut rows, moved.rows.dense());
            Arc::new(&rows - standing)
        });
        if data.noise_source == NoiseSource::Residuals || data.moved.is_some() {
            let mut out = Evaluator::new(model, Function::Cop).run(&data.q, n);
            let moved = data.moved.iter().flat_map(|moved| &moved.shift);
            let moved = out.iter_mut().zip(moved.flatten());
            moved.for_each(|(cop, by)| *cop += by);
            let gap = DVector::from_fn(out.len(), |row, _| data.reading[row] - out[row]);
            // Noise, and whatever else is in the log.
            let (left, taken) = without(&rows, gap);
            data.limit_motion_noise(&left, taken);
            if data.noise_source == NoiseSource::Residuals {
                data.take_noise(&left, taken);
            }
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
            weighed: data.weight.map(|weight| weight.excess()),
            data,
            rows: Arc::new(rows),
            motion_rows,
            closure: closure.map(Arc::new),
            experiment: None,
            shift: None,
            tapes: Arc::default(),
        }
    }

    /// This log as one of an `experiment` beside the `first`.
    pub(crate) fn beside(self, first: &Block, experiment: Experiment) -> Block<'m> {
        let elsewhere = self.model.support() != first.model.support();
        Block {
            shift: elsewhere.then(|| Arc::new(self.model.params_from(first.context.robot))),
            experiment: Some(experiment),
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
            weighed: None,
            ..self.clone()
        }
    }

    /// The same robot on another support: nothing can be fitted there, explanations can be
    /// evaluated.
    pub(crate) fn on<'o>(&self, model: &'o Model) -> Block<'o>
    where
        'm: 'o,
    {
        let (cells, times) = (&self.data.cells, self.data.motion.is_some());
        Block {
            params: model.cad_params(),
            context: EffectContext::new(model, cells, times, self.context.catalog.clone())
                .fitted(self.data.t.is_some()),
            model,
            tapes: Arc::default(),
            ..self.clone()
        }
    }

    /// The robot of this block at other postures `q`, or at its own, before any reading is taken:
    /// each will be known to `noise` (m).
    pub(in crate::diagnose) fn at(&self, q: Option<&[f64]>, noise: f64) -> Block<'m> {
        let mut data = self.data.clone();
        if let Some(q) = q {
            let n = q.len() / self.model.dof();
            data.pose = vec![0; n];
            data.posture_context = vec![0.0; n * PostureContext::of(self.model).len()];
            data.q = q.to_vec();
        }
        let n = data.len();
        data.reading = vec![0.0; 2 * n];
        let rows = Evaluator::new(self.model, Function::RegressorCop).run(&data.q, n);
        let params = self.model.base.params.len();
        Block {
            weight: vec![1.0 / noise; 2 * n],
            rows: Arc::new(DMatrix::from_row_slice(2 * n, params, &rows)),
            data,
            offset: None,
            motion_rows: None,
            closure: None,
            weighed: None,
            ..self.clone()
        }
    }

    /// Readings and, below them, rows of the soles and the weight.
    pub(super) fn height(&self) -> usize {
        2 * self.data.len() + self.soles() + usize::from(self.weighed.is_some())
    }

    /// Rows of the soles.
    pub(super) fn soles(&self) -> usize {
        let closure = self.closure.as_ref();
        closure.map_or(0, |_| ROWS * self.data.len())
    }

    /// Rows by the base parameters of the first block.
    pub(in crate::diagnose) fn rows_of_first(&self) -> DMatrix<f64> {
        match &self.shift {
            Some(shift) => &*self.rows * &shift.matrix,
            None => (*self.rows).clone(),
        }
    }

    /// Base parameters here where those of the first block are `r`, m.
    fn params_from_first(&self, r: &[f64]) -> Vec<f64> {
        match &self.shift {
            Some(shift) => {
                let own = &shift.matrix * DVector::from_column_slice(r) + &shift.offset;
                own.as_slice().to_vec()
            }
            None => r.to_vec(),
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

    /// Readings that an explanation predicts, m.
    pub(in crate::diagnose) fn predicted(&self, on: &OnBlock) -> Vec<f64> {
        let rows = 0..self.weight.len();
        rows.map(|row| self.data.reading[row] - on.residual[row] / self.weight[row])
            .collect()
    }

    /// Whitened residuals of readings that an explanation leaves.
    pub(in crate::diagnose) fn readings_of<'o>(&self, on: &'o OnBlock) -> &'o [f64] {
        &on.residual.as_slice()[..self.weight.len()]
    }

    /// Whitened residuals of the soles that an explanation leaves.
    pub(in crate::diagnose) fn soles_of(&self, on: &OnBlock) -> DVector<f64> {
        let from = self.weight.len();
        DVector::from_column_slice(&on.residual.as_slice()[from..from + self.soles()])
    }

    /// Let an explanation predict other `readings`, m.
    pub(in crate::diagnose) fn put_readings(&self, readings: &[f64], on: &mut OnBlock) {
        let mut own = Arc::make_mut(&mut on.residual).rows_mut(0, readings.len());
        own.copy_from(&self.residual(readings));
    }

    /// One over the noise of each reading as it is, however few samples the readings are worth, 1/m.
    pub(in crate::diagnose) fn inverse_noise(&self) -> impl Iterator<Item = f64> {
        let rows = self.weight.iter().enumerate();
        rows.map(|(row, weight)| weight * self.widened[row % 2])
    }

    /// Rows per independent one, of the axis that has fewer.
    pub(in crate::diagnose) fn rows_per_sample(&self) -> f64 {
        self.widened[0].max(self.widened[1]).powi(2)
    }

    /// Noise of each axis as it is, RMS, m.
    pub(in crate::diagnose) fn noise_by_axis(&self) -> [f64; 2] {
        [0, 1].map(|axis| rms(self.inverse_noise().skip(axis).step_by(2).map(f64::recip)))
    }

    /// Why noise is not told from a misfit, if it is not; `sole`: its corners, m.
    pub(crate) fn why_untold(&self, sole: Option<[[f64; 2]; 2]>) -> Option<Untold> {
        let data = &self.data;
        let unknown = data.noise_source == NoiseSource::Residuals;
        // What masses leave of few readings says little.
        let (rows, directions) = (self.rows.nrows(), self.rows.ncols());
        if unknown && rows < 2 * directions {
            let directions = directions.min(rows);
            return Some(Untold::Few { rows, directions });
        }
        // Time of correlation: half as many rows as an independent one takes.
        let lasting = 0.5 * self.rows_per_sample();
        if data.t.is_some() && lasting > SHORT * data.len() as f64 {
            return Some(Untold::Lasting);
        }
        let noise = self.noise_by_axis();
        let spread = [0, 1].map(|axis| {
            let own = || data.reading.iter().skip(axis).step_by(2);
            let mean = own().sum::<f64>() / data.len() as f64;
            rms(own().map(|x| x - mean))
        });
        let is_large = |[low, high]: [[f64; 2]; 2]| {
            (0..2).any(|axis| noise[axis] > LARGE * (high[axis] - low[axis]))
        };
        // Where the position of a joint was taken from readings, they are known that badly.
        match unknown && data.spent.is_empty() {
            true if noise[0].hypot(noise[1]) >= spread[0].hypot(spread[1]) => {
                Some(Untold::AsLargeAsSpread)
            }
            true if sole.is_some_and(is_large) => Some(Untold::LargeForSole),
            _ => None,
        }
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

    /// The program of a set of terms, made once; two that ask at the same time may both make it,
    /// and the same.
    fn tape(&self, output: Output, terms: &[Term]) -> Arc<Tape> {
        let known = || self.tapes.lock().unwrap_or_else(PoisonError::into_inner);
        let key = (output, effects_of(terms));
        if let Some(tape) = known().get(&key) {
            return Arc::clone(tape);
        }
        let (context, terms, params) = (&self.context, &key.1, &self.params);
        let program = match (output, &self.closure) {
            (Output::Moments, _) => effects::moments(context, terms, params),
            (Output::Joints, _) => effects::joints(context, terms, params),
            (Output::InFile, _) => effects::resting_reading(context, terms),
            (Output::ByMasses, _) => effects::reading_by_masses(context, terms),
            (Output::Sole, Some(closure)) => {
                effects::other_sole(context, terms, params, closure.other.place())
            }
            _ => effects::reading(context, terms, params),
        };
        let tape = Arc::new(Tape::of_many(&program));
        known().entry(key).or_insert(tape).clone()
    }

    /// Outputs of the program of a set of terms at joint positions `q`, posture by posture; of one
    /// of any masses at `masses`, m.
    fn run(
        &self,
        output: Output,
        (terms, unknowns): (&[Term], &[f64]),
        q: &[f64],
        posture_context: &[f64],
        masses: Option<&[f64]>,
    ) -> Vec<f64> {
        let tape = self.tape(output, terms);
        let n = posture_context.len() / PostureContext::of(self.context.robot).len();
        let mut out = vec![0.0; n * tape.outputs()];
        let mut arguments = vec![
            Values::PerPosture(q),
            Values::Shared(unknowns),
            Values::PerPosture(posture_context),
        ];
        arguments.extend(masses.map(Values::Shared));
        tape.run(&arguments, n, &mut out, FASTEST);
        out
    }

    /// Readings and derivatives of as many postures as there are contexts: per posture x then y, each value, ∂/∂e_1, ….
    pub(crate) fn evaluate(
        &self,
        terms: &[Term],
        unknowns: &[f64],
        q: &[f64],
        posture_context: &[f64],
    ) -> Vec<f64> {
        self.run(Output::Reading, (terms, unknowns), q, posture_context, None)
    }

    /// What an explanation predicts at joint positions `q`, with slopes by the `count` unknowns of
    /// the first block.
    pub(in crate::diagnose) fn predict(
        &self,
        own: &CarriedExplanation,
        count: usize,
        q: &[f64],
        posture_context: &[f64],
    ) -> OnBlock {
        let out = self.evaluate(&own.terms, &own.unknowns, q, posture_context);
        let width = own.unknowns.len() + 1;
        let rows = out.len() / width;
        let predicted = (0..rows).map(|row| self.of_cad(row, out[row * width]));
        let mut residual = self.residual(&predicted.collect::<Vec<_>>());
        let mut slopes = DMatrix::from_fn(rows, width - 1, |row, k| {
            out[row * width + 1 + k] * self.weight[row]
        });
        if let Some(closure) = &self.closure {
            let (soles, by_unknowns) = self.closed(closure, own, q, posture_context);
            let both = residual.iter().chain(&soles).copied();
            residual = DVector::from_vec(both.collect());
            slopes = below(&[slopes.as_view(), by_unknowns.as_view()], width - 1);
        }
        if let Some([excess, std]) = self.weighed {
            let (carried, by_unknowns) = self.carried(own);
            residual = residual.push((excess - carried) / std);
            slopes = slopes.insert_row(residual.len() - 1, 0.0);
            slopes.set_row(residual.len() - 1, &(by_unknowns / std));
        }
        OnBlock {
            residual: Arc::new(residual),
            slopes: Arc::new(own.by_unknowns(&slopes, count)),
            sides: None,
            flipped: Vec::new(),
        }
    }

    /// What a file with an explanation predicts of this log where base parameters of the first
    /// block are `masses`, m.
    pub(in crate::diagnose) fn in_file(&self, own: &CarriedExplanation, masses: &[f64]) -> InFile {
        let (data, masses) = (&self.data, self.params_from_first(masses));
        let own = (&own.terms[..], &own.unknowns[..]);
        let context = &data.posture_context;
        let out = self.run(Output::InFile, own, &data.q, context, Some(&masses));
        let width = out.len() / data.len();
        let postures = out.chunks_exact(width).map(|own| own.split_at(2));
        let (readings, depths): (Vec<_>, Vec<_>) = postures.unzip();
        let mut readings = readings.concat();
        if let Some(rows) = &self.motion_rows {
            // Motion adds more or less where masses are not CAD's.
            let off = DVector::from_fn(masses.len(), |k, _| masses[k] - self.cad[k]);
            let motion = &**rows * off;
            let moved = readings.iter_mut().zip(&motion);
            moved.for_each(|(y, by)| *y += by);
        }
        InFile {
            readings,
            depths: depths.concat(),
        }
    }

    /// The same block about base parameters `masses` (m) of the first, slopes by masses as an
    /// explanation has them there.
    pub(in crate::diagnose) fn about(
        &self,
        own: &CarriedExplanation,
        posture_context: &[f64],
        masses: &[f64],
    ) -> Block<'m> {
        let params = self.params_from_first(masses);
        let (own, width) = ((&own.terms[..], &own.unknowns[..]), 1 + params.len());
        let q = &self.data.q;
        let out = self.run(Output::ByMasses, own, q, posture_context, Some(&params));
        let mut rows = DMatrix::from_fn(2 * self.data.len(), params.len(), |row, k| {
            out[row * width + 1 + k]
        });
        if let Some(motion) = &self.motion_rows {
            rows += &**motion;
        }
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

    /// Moments (m) and slopes of the reading by joint at positions `q`: 3 × dof per posture.
    pub(in crate::diagnose) fn evaluate_moments(
        &self,
        terms: &[Term],
        unknowns: &[f64],
        q: &[f64],
        posture_context: &[f64],
    ) -> Vec<f64> {
        self.run(Output::Moments, (terms, unknowns), q, posture_context, None)
    }

    /// Gravity moments and slopes of the robot with CAD masses, at positions `q`.
    pub(in crate::diagnose) fn moments_at(&self, q: &[f64]) -> Vec<f64> {
        self.evaluate_moments(&[], &[], q, &self.data.posture_context)
    }

    /// Whitened rows of the soles at joint positions `q`, three a posture: (0 − value)/σ, and the
    /// derivative of the value by the unknowns, over σ.
    fn closed(
        &self,
        closure: &Closure,
        CarriedExplanation {
            terms, unknowns, ..
        }: &CarriedExplanation,
        q: &[f64],
        posture_context: &[f64],
    ) -> (DVector<f64>, DMatrix<f64>) {
        // Sensors, masses and the ground move no sole: one program is enough for them all.
        let idle = !terms.iter().any(bends);
        let own: (&[Term], &[f64]) = if idle { (&[], &[]) } else { (terms, unknowns) };
        let out = self.run(Output::Sole, own, q, posture_context, None);
        let (rows, width) = (ROWS * self.data.len(), 1 + own.1.len());
        let mut slopes = DMatrix::zeros(rows, unknowns.len());
        if !idle {
            let slope = |row: usize, k: usize| out[row * width + 1 + k] * closure.weight(row);
            slopes = DMatrix::from_fn(rows, unknowns.len(), slope);
        }
        (closure.whitened(out.iter().step_by(width).copied()), slopes)
    }

    /// What loads and pulls of an explanation weigh over the robot's mass, with slopes by its
    /// unknowns.
    pub(in crate::diagnose) fn carried(&self, own: &CarriedExplanation) -> (f64, RowDVector<f64>) {
        let mut slopes = RowDVector::zeros(own.unknowns.len());
        let (mut all, robot_kg) = (0.0, self.context.robot.tree.mass);
        for (term, places) in with_places(&own.terms, &self.context) {
            let Some(instance) = term.effect() else {
                continue;
            };
            let added = |unknowns: &[f64]| {
                let share = instance.effect.load_share(unknowns, robot_kg);
                share / (1.0 - share)
            };
            let mut unknowns = own.unknowns[places.clone()].to_vec();
            all += added(&unknowns);
            for (k, scale) in term.scales(&self.context).into_iter().enumerate() {
                let (here, step) = (unknowns[k], 1e-4 * scale);
                let mut at = |x: f64| {
                    unknowns[k] = x;
                    added(&unknowns)
                };
                slopes[places.start + k] = (at(here + step) - at(here - step)) / (2.0 * step);
                unknowns[k] = here;
            }
        }
        (all, slopes)
    }

    /// Put joints of every posture of a context where `to` has them, by posture, joint and the side
    /// before.
    pub(in crate::diagnose) fn put_sides(
        &self,
        context: &mut [f64],
        joints: impl Iterator<Item = usize> + Clone,
        to: impl Fn(usize, usize, f64) -> f64,
    ) {
        let layout = PostureContext::of(self.context.robot);
        for (k, own) in context.chunks_exact_mut(layout.len()).enumerate() {
            for joint in joints.clone() {
                let side = &mut own[layout.side(joint)];
                *side = to(k, joint, *side);
            }
        }
    }

    /// The sides on which joints rest in the context of a fit to this log.
    pub(in crate::diagnose) fn sides_of(&self, own: &[f64]) -> OwnSides {
        let (robot, log) = (self.context.robot, &self.data.posture_context);
        let layout = PostureContext::of(robot);
        let postures = || (0..log.len()).step_by(layout.len());
        let differs = |joint: &usize| {
            let side = layout.side(*joint);
            postures().any(|at| own[at + side].to_bits() != log[at + side].to_bits())
        };
        let joints: Vec<usize> = (0..robot.dof()).filter(differs).collect();
        let sides = postures().flat_map(|at| joints.iter().map(move |j| own[at + layout.side(*j)]));
        OwnSides {
            sides: Arc::new(sides.collect()),
            joints,
        }
    }

    /// The context of this log with the sides of a fit in it.
    pub(in crate::diagnose) fn context_of(&self, own: &OwnSides) -> Vec<f64> {
        let mut context = self.data.posture_context.clone();
        for (place, joint) in own.joints.iter().enumerate() {
            self.put_sides(&mut context, [*joint].into_iter(), |k, _, _| {
                own.sides[k * own.joints.len() + place]
            });
        }
        context
    }

    /// Joint positions of every posture as a hypothesis bends them.
    pub(crate) fn bent(
        &self,
        terms: &[Term],
        unknowns: &[f64],
        posture_context: &[f64],
    ) -> Vec<f64> {
        if !terms.iter().any(bends) {
            return self.data.q.clone();
        }
        let own = (terms, unknowns);
        self.run(Output::Joints, own, &self.data.q, posture_context, None)
    }

    /// The effect of faults of wiring or of the record: the joint positions that they leave, and
    /// what becomes of a reading, where they change it.
    pub(in crate::diagnose) fn rewired(&self, faults: &[Term]) -> (Vec<f64>, Option<Tape>) {
        let faults = effects_of(faults);
        let q = match faults.iter().any(|own| own.effect.stage() == Stage::Wiring) {
            true => wirings::positions(&self.context, &faults, &self.data.q),
            false => self.data.q.clone(),
        };
        let of_reading = |own: &Instance| own.effect.is_sensor_effect(&own.target);
        let reading = faults.iter().any(of_reading);
        let rewire = reading.then(|| effects::wired_reading(&self.context, &faults));
        (q, rewire.map(|program| Tape::of_many(&program)))
    }
}

/// The soles of a log of both feet, which the caller, its sidecar or its contacts say; `None` of
/// one that stands on one foot. Where each foot has its own contact, the `data` learn what joints
/// do to that.
///
/// # Errors
/// When the other sole cannot be told.
pub(crate) fn soles_of(
    feet: &Feet,
    sidecar: &Sidecar,
    model: &Model,
    data: &mut Postures,
    watch: &mut dyn Watch,
) -> Result<Option<Closure>, Error> {
    let mut sidecar = sidecar.clone();
    sidecar.other_foot = sidecar.other_foot.or_else(|| data.other_foot.clone());
    let Some(other) = feet.of(&sidecar, model)? else {
        return Ok(None);
    };
    if let Some(note) = of_many(model, &other) {
        watch.note(&note);
    }
    if let Some(warning) = of_one_foot(model, &other, data) {
        watch.warning(&warning.into());
    }
    tell_contacts(data, model, &other);
    Ok(Some(Closure::of(model, other, &data.q, data.t.as_deref())))
}

/// Tilt of the ground in every posture.
pub(in crate::diagnose) fn tilts(data: &Postures, model: &Model) -> Vec<[f64; 2]> {
    let layout = PostureContext::of(model);
    let contexts = data.posture_context.chunks_exact(layout.len());
    let tilts = contexts.map(|context| [0, 1].map(|axis| context[layout.tilt(axis)]));
    tilts.collect()
}

/// The side of its dead band where a moment puts a joint.
pub(in crate::diagnose) fn side(moment: f64) -> f64 {
    if moment < 0.0 { -1.0 } else { 1.0 }
}

/// Outputs of a program of so many postures' own values alone.
pub(in crate::diagnose) fn run_alone(tape: &Tape, values: &[f64], postures: usize) -> Vec<f64> {
    let mut out = vec![0.0; postures * tape.outputs()];
    tape.run(&[Values::PerPosture(values)], postures, &mut out, FASTEST);
    out
}

/// The sides on which joints rest in a fit, where they are not those of the log's context.
#[derive(Debug, Clone)]
pub(in crate::diagnose) struct OwnSides {
    joints: Vec<usize>,
    /// Posture by posture.
    sides: Arc<Vec<f64>>,
}

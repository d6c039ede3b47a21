//! Hypotheses about one log: what they predict, and what they cost.

mod fitting;

use std::cell::RefCell;
use std::collections::HashMap;
use std::rc::Rc;

use nalgebra::{DMatrix, DVector};
use sesc_model::effects::{self, Circumstances, Instance, Setting, Stage, Target};
use sesc_model::tape::{Argument, Tape};
use sesc_model::{Function, Model};

use super::data::{Data, NoiseSource};
use super::nuisance::Nuisance;
use super::outliers::Outliers;
use crate::Error;
use crate::evaluate::{Evaluator, FASTEST};
use crate::fit::prior::{Prior, Tolerances};

pub(super) use fitting::State;

/// χ² at which an effect is reliably seen.
const VISIBLE: f64 = 60.0;

/// A log, the robot, and what is believed of its masses.
pub struct Problem<'m> {
    pub setting: Setting<'m>,
    pub data: Data,
    pub params: Vec<f64>,
    /// 1/σ per reading.
    pub weight: Vec<f64>,
    /// Masses within the prior that was asked for.
    pub nuisance: Nuisance,
    /// Masses within the usual tolerances of CAD, for `mass_distribution`.
    pub wide: Nuisance,
    /// F of the two.
    pub prior: DMatrix<f64>,
    pub wide_prior: DMatrix<f64>,
    /// Regressor rows of the unbent robot.
    pub rows: DMatrix<f64>,
    tapes: RefCell<HashMap<String, Rc<Tapes>>>,
    target_weights: HashMap<(&'static str, Target), f64>,
    kinds: usize,
}

/// What a set of instances runs on.
pub(super) struct Tapes {
    pub reading: Tape,
    /// Made when a dead band asks for sides.
    moments: RefCell<Option<Rc<Tape>>>,
}

/// A hypothesis, fitted.
#[derive(Debug, Clone)]
pub struct Fit {
    pub instances: Vec<Instance>,
    pub unknowns: Vec<f64>,
    /// Covariance of the unknowns.
    pub covariance: DMatrix<f64>,
    /// −2 log evidence without the price, less a constant: χ² with masses
    /// marginalised, walls, sides and outliers paid for.
    pub objective: f64,
    /// What its unknowns and the search cost.
    pub price: f64,
    /// Readings it predicts, CAD masses, m.
    pub predicted: Vec<f64>,
    /// Whitened residuals (reading − predicted)/σ.
    pub residual: DVector<f64>,
    /// Whitened derivative by the unknowns.
    pub slopes: DMatrix<f64>,
    /// Circumstances with the sides of dead bands, where they matter.
    pub circumstances: Option<Rc<Vec<f64>>>,
    pub outliers: Option<Outliers>,
    /// Postures with a joint on the side of its dead band that gravity does not favour.
    pub flipped: Vec<usize>,
    /// Walls that are touched: the answer lies at the edge of what is physical.
    pub strained: f64,
}

impl Fit {
    /// Smaller is better.
    pub fn score(&self) -> f64 {
        self.objective + self.price
    }

    pub fn has(&self, name: &str) -> bool {
        self.instances.iter().any(|i| i.effect.name() == name)
    }
}

/// What a fault makes of a reading.
type Rewire = fn([f64; 2]) -> [f64; 2];

/// How a set of readings counts in a fit.
#[derive(Clone, Copy)]
pub struct Rows<'a> {
    /// 1 or 0 per posture; all where `None`.
    pub keep: Option<&'a [bool]>,
}

pub const ALL: Rows = Rows { keep: None };

impl<'m> Problem<'m> {
    pub fn new(model: &'m Model, mut data: Data, prior: &Prior) -> Result<Problem<'m>, Error> {
        let setting = Setting::new(model, &data.cells, data.t.is_some());
        let n = data.len();
        let mut rows = Evaluator::new(model, Function::Regressor).run(&data.q, n);
        let p = model.base.params.len();
        let layout = Circumstances::of(model);
        let mut flat = DMatrix::zeros(2 * n, p);
        for k in 0..n {
            let row = &mut rows[3 * k * p..3 * (k + 1) * p];
            for axis in 0..2 {
                let tilt = data.circumstances[k * layout.len() + layout.tilt(axis)];
                for c in 0..p {
                    flat[(2 * k + axis, c)] = row[axis * p + c] + tilt * row[2 * p + c];
                }
            }
        }
        let factor = match prior {
            Prior::Free => free(&flat),
            Prior::Cad(_) => prior.factor(model).unwrap_or_else(|| DMatrix::zeros(p, 0)),
        };
        let usual = Prior::Cad(Tolerances::usual()).factor(model);
        let usual = usual.unwrap_or_else(|| DMatrix::zeros(p, 0));
        if data.noise_source == NoiseSource::Residuals {
            let out = Evaluator::new(model, Function::Cop).run(&data.q, n);
            data.take_noise(&left_by_masses(&flat, &data.reading, &out));
        }
        let weight: Vec<f64> = data.std.iter().map(|s| 1.0 / s).collect();
        let nuisance = Nuisance::new(&flat, &factor, &weight);
        let wide = Nuisance::new(&flat, &usual, &weight);
        let mut names: Vec<&str> = effects::instances(&setting)
            .iter()
            .map(|i| i.effect.name())
            .collect();
        names.dedup();
        Ok(Problem {
            params: model.cad_params(),
            kinds: names.len(),
            setting,
            data,
            weight,
            nuisance,
            wide,
            prior: factor,
            wide_prior: usual,
            rows: flat,
            tapes: RefCell::new(HashMap::new()),
            target_weights: HashMap::new(),
        })
    }

    /// This problem's log, for a robot that stands elsewhere: nothing can be fitted
    /// there, explanations can be evaluated.
    pub(super) fn elsewhere<'o>(&self, setting: Setting<'o>) -> Problem<'o> {
        Problem {
            params: setting.model.cad_params(),
            kinds: self.kinds,
            setting,
            data: self.data.clone(),
            weight: self.weight.clone(),
            nuisance: self.nuisance.clone(),
            wide: self.wide.clone(),
            prior: self.prior.clone(),
            wide_prior: self.wide_prior.clone(),
            rows: self.rows.clone(),
            tapes: RefCell::new(HashMap::new()),
            target_weights: HashMap::new(),
        }
    }

    /// What unknowns and the number of things that were looked at cost:
    /// `Σ p ln 2N + 2 ln(kinds / w_target)`, see [`Problem::weigh_targets`].
    pub fn price(&self, instances: &[Instance]) -> f64 {
        let readings = (2 * self.data.len()) as f64;
        let of = |instance: &Instance| {
            let own = (instance.effect.name(), instance.target.clone());
            let weight = match self.target_weights.get(&own) {
                Some(weight) => *weight,
                None => 1.0 / instance.effect.targets(&self.setting).len().max(1) as f64,
            };
            let unknowns = match instance.effect.name() {
                "cop_outliers" => 2,
                _ => instance.unknowns(&self.setting),
            };
            unknowns as f64 * readings.ln() + 2.0 * (self.kinds as f64 / weight).ln()
        };
        instances.iter().map(of).sum()
    }

    /// Share the chance of each effect among its targets by how well this log
    /// sees them: `visible` is χ² of an effect of ordinary size at each.
    ///
    /// A fault in an elbow that explains what an ankle's would has to be absurdly
    /// large. Weights of one effect sum to one, so false alarms stay as rare as
    /// with even weights.
    pub fn weigh_targets(&mut self, visible: &[(Instance, f64)]) {
        let chance = |chi2: f64| 0.02 + (1.0 + chi2 / VISIBLE).ln();
        let mut sums: HashMap<&str, f64> = HashMap::new();
        for (instance, chi2) in visible {
            *sums.entry(instance.effect.name()).or_default() += chance(*chi2);
        }
        for (instance, chi2) in visible {
            let name = instance.effect.name();
            let weight = chance(*chi2) / sums[name];
            self.target_weights
                .insert((name, instance.target.clone()), weight);
        }
    }

    /// The programs of a set of instances, made once.
    pub(super) fn tapes(&self, instances: &[Instance]) -> Rc<Tapes> {
        let key = format!("{instances:?}");
        if let Some(tapes) = self.tapes.borrow().get(&key) {
            return tapes.clone();
        }
        let program = effects::reading(&self.setting, instances, &self.params);
        let tapes = Rc::new(Tapes {
            reading: Tape::new(&program),
            moments: RefCell::new(None),
        });
        self.tapes.borrow_mut().insert(key, tapes.clone());
        tapes
    }

    fn moments(&self, instances: &[Instance]) -> Rc<Tape> {
        let tapes = self.tapes(instances);
        let mut made = tapes.moments.borrow_mut();
        made.get_or_insert_with(|| {
            let program = effects::moments(&self.setting, instances, &self.params);
            Rc::new(Tape::new(&program))
        })
        .clone()
    }

    /// Readings and derivatives of as many postures as have circumstances: per posture x then y, each value, ∂/∂e_1, ….
    pub fn evaluate(
        &self,
        instances: &[Instance],
        unknowns: &[f64],
        q: &[f64],
        circumstances: &[f64],
    ) -> Vec<f64> {
        let tapes = self.tapes(instances);
        let n = circumstances.len() / Circumstances::of(self.setting.model).len();
        let mut out = vec![0.0; n * tapes.reading.outputs()];
        let arguments = [
            Argument::PerPosture(q),
            Argument::Shared(unknowns),
            Argument::PerPosture(circumstances),
        ];
        tapes.reading.run(&arguments, n, &mut out, FASTEST);
        out
    }

    /// Moments (m) and slopes of the reading by joint: 3 × dof per posture.
    pub(super) fn evaluate_moments(
        &self,
        instances: &[Instance],
        unknowns: &[f64],
        circumstances: &[f64],
    ) -> Vec<f64> {
        self.evaluate_moments_at(instances, unknowns, &self.data.q, circumstances)
    }

    /// The same at joint positions `q`.
    pub(super) fn evaluate_moments_at(
        &self,
        instances: &[Instance],
        unknowns: &[f64],
        q: &[f64],
        circumstances: &[f64],
    ) -> Vec<f64> {
        let tape = self.moments(instances);
        let n = circumstances.len() / Circumstances::of(self.setting.model).len();
        let mut out = vec![0.0; n * tape.outputs()];
        let arguments = [
            Argument::PerPosture(q),
            Argument::Shared(unknowns),
            Argument::PerPosture(circumstances),
        ];
        tape.run(&arguments, n, &mut out, FASTEST);
        out
    }

    /// The masses' directions under a hypothesis.
    pub fn masses(&self, instances: &[Instance]) -> &Nuisance {
        match instances
            .iter()
            .any(|i| i.effect.name() == "mass_distribution")
        {
            true => &self.wide,
            false => &self.nuisance,
        }
    }

    /// Whether the usual tolerances of CAD leave masses more room than the prior.
    pub(super) fn is_wider(&self) -> bool {
        self.wide.log_det > self.nuisance.log_det
    }

    /// Readings that CAD foretells at joint positions `q`, on level ground.
    pub fn plain(&self, q: &[f64]) -> Vec<f64> {
        let n = q.len() / self.setting.model.dof();
        let model = self.setting.model;
        Evaluator::with_params(model, Function::Cop, self.params.clone()).run(q, n)
    }

    /// Joint positions of every posture as a hypothesis bends them.
    pub fn bent(&self, fit: &Fit) -> Vec<f64> {
        let joints: Vec<(usize, &Instance)> = fit
            .instances
            .iter()
            .enumerate()
            .filter(|(_, i)| i.effect.stage() <= Stage::Joints || i.effect.stage() == Stage::Bends)
            .collect();
        if joints.is_empty() {
            return self.data.q.clone();
        }
        let program = effects::joints(&self.setting, &fit.instances, &self.params);
        let tape = Tape::new(&program);
        let n = self.data.len();
        let mut out = vec![0.0; n * tape.outputs()];
        let circumstances = match &fit.circumstances {
            Some(own) => own.as_slice(),
            None => &self.data.circumstances,
        };
        let arguments = [
            Argument::PerPosture(&self.data.q),
            Argument::Shared(&fit.unknowns),
            Argument::PerPosture(circumstances),
        ];
        tape.run(&arguments, n, &mut out, FASTEST);
        out
    }

    /// The turning joints that have a dead band under `instances`, with the
    /// place of its width among the unknowns.
    pub(super) fn slack_joints(&self, instances: &[Instance]) -> Vec<(usize, usize)> {
        let mut found = Vec::new();
        let mut at = 0;
        for instance in instances {
            if instance.effect.name() == "backlash" {
                match instance.target {
                    Target::Joint(j) => found.push((j, at)),
                    _ => found.extend(self.setting.turning().into_iter().map(|j| (j, at))),
                }
            }
            at += instance.unknowns(&self.setting);
        }
        found
    }
}

/// What free masses leave of readings, m: noise, and whatever else is in the log.
/// Where postures are too few for that, all of the gap.
fn left_by_masses(rows: &DMatrix<f64>, reading: &[f64], cad: &[f64]) -> Vec<f64> {
    let gap = DVector::from_fn(reading.len(), |row, _| reading[row] - cad[row]);
    if rows.nrows() < 2 * rows.ncols() {
        return gap.as_slice().to_vec();
    }
    let directions = free(rows);
    let seen = rows * directions;
    let mut normal = seen.tr_mul(&seen);
    for k in 0..normal.nrows() {
        normal[(k, k)] *= 1.0 + 1e-9;
    }
    match normal.cholesky() {
        Some(factor) => (&gap - &seen * factor.solve(&seen.tr_mul(&gap)))
            .as_slice()
            .to_vec(),
        None => gap.as_slice().to_vec(),
    }
}

/// A prior so wide that it says nothing: 100 m on every direction that data see.
fn free(rows: &DMatrix<f64>) -> DMatrix<f64> {
    let svd = rows.clone().svd(false, true);
    let v = svd.v_t.unwrap_or_else(|| DMatrix::zeros(0, rows.ncols()));
    let largest = svd.singular_values.max();
    let kept: Vec<usize> = (0..svd.singular_values.len())
        .filter(|&k| svd.singular_values[k] > 1e-9 * largest)
        .collect();
    let mut factor = DMatrix::zeros(rows.ncols(), kept.len());
    for (to, &from) in kept.iter().enumerate() {
        factor.set_column(to, &(v.row(from).transpose() * 100.0));
    }
    factor
}

impl Problem<'_> {
    /// Gravity moments and slopes of the robot as CAD has it, at positions `q`.
    pub(super) fn moments_at(&self, q: &[f64]) -> Vec<f64> {
        let tape = self.moments(&[]);
        let n = self.data.len();
        let mut out = vec![0.0; n * tape.outputs()];
        let arguments = [
            Argument::PerPosture(q),
            Argument::Shared(&[]),
            Argument::PerPosture(&self.data.circumstances),
        ];
        tape.run(&arguments, n, &mut out, FASTEST);
        out
    }

    /// What a wiring fault does, without a program of its own: the joint
    /// positions it leaves, and what becomes of a reading.
    pub(super) fn rewired(&self, fault: &Instance) -> (Vec<f64>, Rewire) {
        let dof = self.setting.model.dof();
        let mut q = self.data.q.clone();
        let keep: Rewire = |y| y;
        let map = match (fault.effect.name(), &fault.target) {
            ("joint_sign", Target::Joint(j)) => {
                q.iter_mut().skip(*j).step_by(dof).for_each(|x| *x = -*x);
                keep
            }
            ("joint_swap", Target::Joints(a, b)) => {
                q.chunks_exact_mut(dof).for_each(|row| row.swap(*a, *b));
                keep
            }
            ("units", Target::Way("degrees")) => {
                let turning = self.setting.turning();
                for row in q.chunks_exact_mut(dof) {
                    turning.iter().for_each(|&j| row[j] = row[j].to_radians());
                }
                keep
            }
            ("units", Target::Way("centimetres")) => |y: [f64; 2]| y.map(|x| 100.0 * x),
            ("units", _) => |y: [f64; 2]| y.map(|x| 1000.0 * x),
            ("sensor_axes", Target::Way("swapped")) => |[x, y]: [f64; 2]| [y, x],
            ("sensor_axes", Target::Way("flip_x")) => |[x, y]: [f64; 2]| [-x, y],
            ("sensor_axes", _) => |[x, y]: [f64; 2]| [x, -y],
            _ => keep,
        };
        (q, map)
    }
}

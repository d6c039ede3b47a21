//! Experiments that could tell explanations apart, and what each would show.
//!
//! ```text
//! S_j = min over δ, z of ‖(y_i − y_j − J_j δ − K z)/σ‖² + ‖z‖²     old and new rows
//! ```
//!
//! the χ² by which explanation j would fail, its unknowns fitted again, if i
//! were true. Nine is enough to tell, as in the class itself.

use nalgebra::{DMatrix, DVector};
use sesc_model::effects::{Circumstances, Instance, Setting, Stage, Target};
use sesc_model::{Function, Model};

use super::problem::{Fit, Problem};
use crate::evaluate::Evaluator;

/// A known weight to carry, as a part of the robot's mass.
const WEIGHT: f64 = 0.1;

/// What one can do next.
#[derive(Debug, Clone, PartialEq)]
pub enum Experiment {
    /// New postures on the same foot.
    Postures,
    /// The same postures after a turn by 180° on the floor.
    Turned,
    /// Postures on the other foot.
    OtherFoot,
    /// The same postures with a known mass on a link.
    KnownWeight,
    /// The same postures, each approached from the other side.
    BothSides,
    /// The same postures with raw loads of the cells.
    RawCells,
    /// The same postures without whatever touches the robot.
    Untouched,
}

impl Experiment {
    /// As sidecars have it.
    pub fn name(&self) -> &'static str {
        match self {
            Experiment::Postures => "postures",
            Experiment::Turned => "turned",
            Experiment::OtherFoot => "other_foot",
            Experiment::KnownWeight => "known_weight",
            Experiment::BothSides => "both_sides",
            Experiment::RawCells => "raw_cells",
            Experiment::Untouched => "untouched",
        }
    }

    /// The experiment of this name whose log says all that there is to know of it: not
    /// the size of a weight, nor from where a posture was approached.
    pub fn of_log(name: &str) -> Option<Experiment> {
        let all = [
            Experiment::Postures,
            Experiment::Turned,
            Experiment::OtherFoot,
            Experiment::RawCells,
            Experiment::Untouched,
        ];
        all.into_iter().find(|experiment| experiment.name() == name)
    }

    /// What happens to an instance's unknowns in the experiment; `None`: it is gone.
    fn signs(&self, instance: &Instance, count: usize) -> Option<Vec<f64>> {
        let name = instance.effect.name();
        match (self, name) {
            // Ground and tether stay in the room while the robot turns.
            (Experiment::Turned, "ground_slope") => Some(vec![-1.0; 2]),
            (Experiment::Turned, "external_force") => Some(vec![-1.0, -1.0, 1.0]),
            (Experiment::Untouched, "external_force") => None,
            // Another foot has another sensor.
            (Experiment::OtherFoot, _) if instance.effect.stage() >= Stage::Cells => None,
            (_, "sensor_drift" | "cop_outliers" | "time_delay" | "unsettled_motion") => None,
            _ => Some(vec![1.0; count]),
        }
    }
}

/// Postures to be taken, and in what circumstances.
pub struct Postures<'m> {
    pub model: &'m Model,
    pub q: Vec<f64>,
    pub circumstances: Vec<f64>,
}

/// Whitened readings of an explanation and their slopes by its unknowns.
struct Rows {
    value: DVector<f64>,
    slopes: DMatrix<f64>,
}

impl Rows {
    fn below(self, more: Rows) -> Rows {
        let (a, b) = (self.value.len(), more.value.len());
        let p = self.slopes.ncols();
        let mut rows = Rows {
            value: DVector::zeros(a + b),
            slopes: DMatrix::zeros(a + b, p),
        };
        rows.value.rows_mut(0, a).copy_from(&self.value);
        rows.value.rows_mut(a, b).copy_from(&more.value);
        rows.slopes.rows_mut(0, a).copy_from(&self.slopes);
        rows.slopes.rows_mut(a, b).copy_from(&more.slopes);
        rows
    }
}

/// An explanation of a log as an experiment has it.
pub(super) struct Carried {
    pub instances: Vec<Instance>,
    /// Each of their unknowns: which one of the log's it is, and its sign.
    pub columns: Vec<(usize, f64)>,
}

impl Carried {
    pub fn unknowns(&self, of_log: &[f64]) -> Vec<f64> {
        let columns = self.columns.iter();
        columns.map(|(k, sign)| sign * of_log[*k]).collect()
    }
}

/// What becomes of `instances` of the robot `here`, if anything, in an experiment `there`.
pub(super) fn carried(
    experiment: &Experiment,
    here: &Setting,
    there: &Setting,
    instances: &[Instance],
) -> Carried {
    let mut carried = Carried {
        instances: Vec::new(),
        columns: Vec::new(),
    };
    let mut at = 0;
    for instance in instances {
        let count = instance.unknowns(here);
        let own = at..at + count;
        at += count;
        let Some(signs) = experiment.signs(instance, count) else {
            continue;
        };
        let name = here.name_of(&instance.target);
        let Some(target) = there.target_named(instance.effect, &name) else {
            continue;
        };
        carried.instances.push(Instance {
            effect: instance.effect,
            target,
        });
        carried.columns.extend(own.zip(signs));
    }
    carried
}

/// Explanations under an experiment. `here` is the problem of the log; `there` one
/// whose robot stands as the experiment has it (`here` unless on the other foot).
pub struct Trial<'a, 'm> {
    pub experiment: Experiment,
    pub here: &'a Problem<'m>,
    pub there: &'a Problem<'m>,
    pub postures: Postures<'m>,
}

impl Trial<'_, '_> {
    /// S of each of `others` if `truth` holds, and what each new posture adds to
    /// all of them.
    pub fn separations(&self, truth: &Fit, others: &[&Fit]) -> (Vec<f64>, Vec<f64>) {
        let n = self.postures.circumstances.len() / self.layout().len();
        let mut by_posture = vec![0.0; n];
        let told = self.rows(truth);
        let masses = self.masses();
        let separation = |other: &&Fit| {
            let theirs = self.rows(other);
            let left = least(&(&told.value - &theirs.value), &theirs.slopes, &masses);
            let old = left.len() - 2 * n;
            for (k, by) in by_posture.iter_mut().enumerate() {
                let own = left[old + 2 * k].powi(2) + left[old + 2 * k + 1].powi(2);
                *by += own.min(4.0);
            }
            left.norm_squared() + self.by_weight(truth, other)
        };
        let separations = others.iter().map(separation).collect();
        (separations, by_posture)
    }

    fn layout(&self) -> Circumstances {
        Circumstances::of(self.postures.model)
    }

    /// What the sum of raw cells tells: their noise on it is that of the CoP times
    /// weight over the cells' arm.
    fn by_weight(&self, truth: &Fit, other: &Fit) -> f64 {
        if self.experiment != Experiment::RawCells {
            return 0.0;
        }
        let setting = &self.here.setting;
        let carried = |fit: &Fit| -> f64 {
            let mut at = 0;
            let mut mass = 0.0;
            for instance in &fit.instances {
                let count = instance.unknowns(setting);
                let share = match instance.effect.name() {
                    "payload" => fit.unknowns[at],
                    "external_force" => fit.unknowns[at + 2],
                    _ => 0.0,
                };
                mass += setting.mass() * share / (1.0 - share);
                at += count;
            }
            mass
        };
        let arms = self.here.data.cells.iter().map(|c| c[0].abs());
        let arm = arms.fold(0.0, f64::max).max(0.01);
        let noise = self.here.data.noise_floor * setting.mass() / arm;
        let postures = self.here.data.len() as f64;
        postures * ((carried(truth) - carried(other)) / noise).powi(2)
    }

    /// Old rows as the log has them, then new ones.
    fn rows(&self, fit: &Fit) -> Rows {
        let here = self.here;
        let old = Rows {
            value: DVector::from_fn(fit.predicted.len(), |row, _| {
                fit.predicted[row] * here.weight[row]
            }),
            slopes: fit.slopes.clone(),
        };
        old.below(self.new_rows(fit))
    }

    fn new_rows(&self, fit: &Fit) -> Rows {
        let (here, there) = (&self.here.setting, &self.there.setting);
        let carried = carried(&self.experiment, here, there, &fit.instances);
        let mut unknowns = carried.unknowns(&fit.unknowns);
        let Carried {
            mut instances,
            columns,
        } = carried;
        if self.experiment == Experiment::KnownWeight {
            self.carry(&mut instances, &mut unknowns);
        }
        // Their order is their own: programs sort by stage, not by place in the list.
        let mut circumstances = self.postures.circumstances.clone();
        self.rest(&instances, &unknowns, &mut circumstances);
        let out = self
            .there
            .evaluate(&instances, &unknowns, &self.postures.q, &circumstances);
        let width = unknowns.len() + 1;
        let rows = out.len() / width;
        let weight = 1.0 / self.here.data.noise_floor;
        let mut slopes = DMatrix::zeros(rows, fit.unknowns.len());
        for row in 0..rows {
            for (own, (k, sign)) in columns.iter().enumerate() {
                slopes[(row, *k)] = sign * out[row * width + 1 + own] * weight;
            }
        }
        Rows {
            value: DVector::from_fn(rows, |row, _| out[row * width] * weight),
            slopes,
        }
    }

    fn carry(&self, instances: &mut Vec<Instance>, unknowns: &mut Vec<f64>) {
        let Some(effect) = sesc_model::effects::named("payload") else {
            return;
        };
        // On the heaviest link: the trunk carries a weight without bending an arm.
        let links = self.there.setting.links();
        let heaviest = links.into_iter().max_by(|a, b| {
            let mass = |t: &Target| match t {
                Target::Link(link) => self.there.setting.mass_of(*link),
                _ => 0.0,
            };
            mass(a).total_cmp(&mass(b))
        });
        if let Some(target) = heaviest {
            instances.push(Instance { effect, target });
            let share = WEIGHT / (1.0 + WEIGHT);
            let arm = 0.3 * self.there.setting.height();
            unknowns.extend([share, share * arm, 0.0, 0.0]);
        }
    }

    /// Sides of dead bands: gravity's, or in an approach from the other side, the other.
    fn rest(&self, instances: &[Instance], unknowns: &[f64], circumstances: &mut [f64]) {
        let joints = self.there.slack_joints(instances);
        if joints.is_empty() {
            return;
        }
        let layout = self.layout();
        let dof = self.postures.model.dof();
        let sense = match self.experiment {
            Experiment::BothSides => -1.0,
            _ => 1.0,
        };
        let moments =
            self.there
                .evaluate_moments_at(instances, unknowns, &self.postures.q, circumstances);
        for k in 0..circumstances.len() / layout.len() {
            for (joint, _) in &joints {
                let side = if moments[k * 3 * dof + joint] < 0.0 {
                    -1.0
                } else {
                    1.0
                };
                circumstances[k * layout.len() + layout.side(*joint)] = sense * side;
            }
        }
    }

    /// Whitened directions of mass errors, old rows and new ones.
    fn masses(&self) -> DMatrix<f64> {
        let here = self.here;
        let n = self.postures.circumstances.len() / self.layout().len();
        let directions = here.prior.ncols();
        let old = 2 * here.data.len();
        let mut k = DMatrix::zeros(old + 2 * n, directions);
        let mut first = &here.rows * &here.prior;
        for (mut row, w) in first.row_iter_mut().zip(&here.weight) {
            row *= *w;
        }
        k.rows_mut(0, old).copy_from(&first);
        // Base parameters of another support are others: shifted by lengths.
        let params = self.postures.model.base.params.len();
        let flat = Evaluator::new(self.postures.model, Function::RegressorCop);
        let rows = DMatrix::from_row_slice(2 * n, params, &flat.run(&self.postures.q, n));
        let map = match self.experiment {
            Experiment::OtherFoot => {
                let shift = self.postures.model.params_from(here.setting.model);
                &shift.matrix * &here.prior
            }
            _ => here.prior.clone(),
        };
        let second = rows * map / here.data.noise_floor;
        k.rows_mut(old, 2 * n).copy_from(&second);
        k
    }
}

/// What is left of `difference` once slopes and masses have taken their part.
fn least(difference: &DVector<f64>, slopes: &DMatrix<f64>, masses: &DMatrix<f64>) -> DVector<f64> {
    let (p, m) = (slopes.ncols(), masses.ncols());
    let mut all = DMatrix::zeros(difference.len(), p + m);
    all.columns_mut(0, p).copy_from(slopes);
    all.columns_mut(p, m).copy_from(masses);
    let mut normal = all.tr_mul(&all);
    for k in 0..p + m {
        normal[(k, k)] += if k < p {
            1e-9 * normal[(k, k)] + 1e-12
        } else {
            1.0
        };
    }
    match normal.cholesky() {
        Some(factor) => difference - &all * factor.solve(&all.tr_mul(difference)),
        None => difference.clone(),
    }
}

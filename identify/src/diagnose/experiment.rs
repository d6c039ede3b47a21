//! Experiments that could tell explanations apart: what each would show, and which shows most.
//!
//! ```text
//! S_j = min over δ, z of ‖(y_i + K_i z_i − y_j − J_j δ − K_j z)/σ‖² + ‖z‖² − ‖z_i‖²     old and new rows
//! ```
//!
//! the χ² by which explanation j would fail, its unknowns and masses fitted again, if i with the
//! masses that it found were true. Each has masses by its own prior. From [`TOLD_APART`](super::criteria::TOLD_APART) on it tells the two apart.

use std::path::Path;

use nalgebra::{DMatrix, DVector};
use sesc_model::effects::{Carry, Experiment, known_weight};
use sesc_model::tree::{Dof, is_support};
use sesc_model::{Model, Snapping};

use super::criteria::{self, NEXT_POSTURES, TOLD_APART};
use super::findings::{ExperimentProposal, Explained, Verdict};
use super::hypothesis::{CarriedExplanation, Term};
use super::problem::{Block, Fit, OnBlock, Problem, below, side};
use crate::Error;
use crate::logs::{PostureWriter, Row, Sidecar, Written};
use crate::observations::postures::range as range_of;
use crate::plan::design::short_order;
use crate::plan::{Geometry, Limits, Region, Scene, sample};
use crate::robot::Robot;

/// The experiment of this name whose log says all that there is to know of it: not
/// the size of a weight, nor from where a posture was approached.
pub(super) fn of_log(name: &str) -> Option<Experiment> {
    let told = |experiment: &Experiment| {
        !matches!(experiment, Experiment::KnownWeight | Experiment::BothSides)
    };
    let mut all = Experiment::ALL.into_iter().filter(told);
    all.find(|experiment| experiment.name() == name)
}

/// Postures to be taken next.
#[derive(Debug, Clone)]
pub struct NextLog {
    /// File of the robot's description.
    pub robot: String,
    /// Link on the ground.
    pub support: String,
    /// The experiment that they belong to, written into the sidecar.
    pub experiment: Experiment,
    /// The robot's independent joints, in the order of `q`.
    pub dofs: Vec<Dof>,
    /// Posture by posture, joint by joint, rad or m.
    pub q: Vec<f64>,
    /// Place of each posture among them by how much it tells, from 0; empty where all are
    /// to be taken.
    pub ranks: Vec<usize>,
}

impl NextLog {
    /// Write them to a log with its sidecar.
    ///
    /// # Errors
    /// When a file cannot be written.
    pub fn write(&self, path: &Path) -> Result<(), Error> {
        let mut log = PostureWriter::create(path, &self.dofs, Written::default())?;
        for (pose, q) in self.q.chunks_exact(self.dofs.len()).enumerate() {
            log.row(&Row {
                pose: pose as i64,
                q,
                ..Row::default()
            })?;
        }
        log.finish(&Sidecar {
            robot: Some(self.robot.clone()),
            support: Some(self.support.clone()),
            experiment: Some(self.experiment.name().to_string()),
            ..Sidecar::default()
        })?;
        Ok(())
    }
}

/// An experiment beside the logs of a problem: a block whose readings are not taken yet.
struct Trial<'a, 'm> {
    here: &'a Problem<'m>,
    there: Block<'m>,
}

impl<'a, 'm> Trial<'a, 'm> {
    /// At postures `q` where the robot stands as on `on`; those of the log unless given.
    fn new(
        experiment: Experiment,
        here: &'a Problem<'m>,
        on: &Block<'m>,
        q: Option<&[f64]>,
    ) -> Trial<'a, 'm> {
        let first = here.first();
        let there = on.at(q, first.data.noise_floor).beside(first, experiment);
        Trial { here, there }
    }

    /// S of each of `others` if `truth` holds, and what each new posture adds to
    /// all of them.
    fn separations(&self, truth: &Fit, others: &[&Fit]) -> (Vec<f64>, Vec<f64>) {
        let n = self.there.data.len();
        let mut by_posture = vec![0.0; n];
        let (expected, _) = self.rows(truth);
        let expected = expected + self.mass_shift(truth);
        let found = self.here.mass_errors(truth);
        // The total mass moves no reading, old or new.
        let total = usize::from(self.here.prior(&truth.terms).total.is_some());
        let paid = found.rows(0, found.len() - total).norm_squared();
        let separation = |other: &&Fit| {
            let (theirs, slopes) = self.rows(other);
            let (left, pays) = least(&(&expected - theirs), &slopes, &self.masses(&other.terms));
            let old = left.len() - 2 * n;
            for (k, by) in by_posture.iter_mut().enumerate() {
                let own = left[old + 2 * k].powi(2) + left[old + 2 * k + 1].powi(2);
                *by += own.min(criteria::TOLD_BY_ONE);
            }
            let apart = left.norm_squared() + pays - paid;
            apart.max(0.0) + self.by_weight(truth, other)
        };
        let separations = others.iter().map(separation).collect();
        (separations, by_posture)
    }

    /// What the sum of raw cells tells: their noise on it is that of the CoP times
    /// weight over the cells' arm.
    fn by_weight(&self, truth: &Fit, other: &Fit) -> f64 {
        if self.there.experiment != Some(Experiment::RawCells) {
            return 0.0;
        }
        let (first, data) = (self.here.first(), self.here.data());
        let carried = |fit: &Fit| {
            let own = self.here.carried(first, &fit.terms, &fit.unknowns);
            first.carried(&own).0
        };
        let arms = data.cells.iter().map(|c| c[0].abs());
        let noise = data.noise_floor / arms.fold(0.0, f64::max).max(0.01);
        data.len() as f64 * ((carried(truth) - carried(other)) / noise).powi(2)
    }

    /// Whitened readings of an explanation and their slopes by its unknowns: old rows as the logs
    /// have them, then new ones.
    fn rows(&self, fit: &Fit) -> (DVector<f64>, DMatrix<f64>) {
        let new = self.predict(fit);
        let blocks = self.here.blocks.iter().chain([&self.there]);
        let predicted = || fit.blocks.iter().chain([&new]);
        let values = blocks.clone().zip(predicted()).flat_map(|(block, own)| {
            let predicted = block.predicted(own).into_iter().zip(&block.weight);
            predicted.map(|(value, weight)| value * weight)
        });
        let slopes = blocks.zip(predicted());
        let slopes = slopes.map(|(block, own)| own.slopes.rows(0, block.weight.len()));
        let slopes: Vec<_> = slopes.collect();
        let slopes = below(&slopes, fit.unknowns.len());
        (DVector::from_vec(values.collect()), slopes)
    }

    /// New rows.
    fn predict(&self, fit: &Fit) -> OnBlock {
        let mut own = self.here.carried(&self.there, &fit.terms, &fit.unknowns);
        let there = &self.there.context;
        let mass = criteria::CARRIED_SHARE * there.mass();
        if self.there.experiment == Some(Experiment::KnownWeight)
            && let Some((weight, known)) = known_weight(there, mass, 0.3 * there.height())
        {
            // Their order is their own: programs sort by stage, not by place in the list.
            own.terms.push(Term::Effect(weight));
            own.unknowns.extend(known);
        }
        let context = self.sides(&own);
        let q = &self.there.data.q;
        self.there.predict(&own, fit.unknowns.len(), q, &context)
    }

    /// The context with sides of dead bands: gravity's, or in an approach from the other side,
    /// the other.
    fn sides(
        &self,
        CarriedExplanation {
            terms, unknowns, ..
        }: &CarriedExplanation,
    ) -> Vec<f64> {
        let data = &self.there.data;
        let mut context = data.posture_context.clone();
        let joints = self.there.slack_joints(terms);
        if joints.is_empty() {
            return context;
        }
        let dof = self.there.model.dof();
        let from_other = self.there.experiment == Some(Experiment::BothSides);
        let sense = if from_other { -1.0 } else { 1.0 };
        let there = &self.there;
        let moments = there.evaluate_moments(terms, unknowns, &data.q, &context);
        let joints = joints.iter().map(|(joint, _)| *joint);
        self.there.put_sides(&mut context, joints, |k, joint, _| {
            sense * side(moments[k * 3 * dof + joint])
        });
        context
    }

    /// What the masses of an explanation add to whitened readings, old rows and new ones.
    fn mass_shift(&self, fit: &Fit) -> DVector<f64> {
        let here = self.here;
        let (old, params) = (here.mass_shift(fit), here.params_of(fit));
        let off = params.iter().zip(&here.first().cad).map(|(r, cad)| r - cad);
        let off = DVector::from_iterator(params.len(), off);
        let new = self.there.rows_of_first() * off / here.data().noise_floor;
        let old = here.readings().flat_map(|range| &old.as_slice()[range]);
        DVector::from_vec(old.chain(new.as_slice()).copied().collect())
    }

    /// Whitened directions of mass errors under a hypothesis, old rows and new ones.
    fn masses(&self, terms: &[Term]) -> DMatrix<f64> {
        let (here, old) = (self.here, self.here.masses(terms).columns());
        let noise = here.data().noise_floor;
        let new = self.there.rows_of_first() * &here.prior(terms).factor / noise;
        let parts = here.readings().map(|range| old.rows_range(range));
        below(
            &parts.chain([new.as_view()]).collect::<Vec<_>>(),
            old.ncols(),
        )
    }
}

/// What is left of `difference` once slopes and masses have taken their part, and the square of
/// what masses took in units of their prior.
fn least(
    difference: &DVector<f64>,
    slopes: &DMatrix<f64>,
    masses: &DMatrix<f64>,
) -> (DVector<f64>, f64) {
    let (p, m) = (slopes.ncols(), masses.ncols());
    let mut all = slopes.clone().resize_horizontally(p + m, 0.0);
    all.columns_mut(p, m).copy_from(masses);
    let mut normal = all.tr_mul(&all);
    for k in 0..p + m {
        normal[(k, k)] += match k < p {
            true => 1e-9 * normal[(k, k)] + 1e-12,
            false => 1.0,
        };
    }
    match normal.cholesky() {
        Some(factor) => {
            let found = factor.solve(&all.tr_mul(difference));
            let pays = found.rows(p, m).norm_squared();
            (difference - &all * found, pays)
        }
        None => (difference.clone(), 0.0),
    }
}

/// An experiment that is proposed, with its postures.
pub(super) type Proposed = (ExperimentProposal, NextLog);

/// Experiments by how many of the class they exclude, the best first.
pub(super) fn proposed(
    problem: &Problem,
    found: &Explained,
    (robot, name): (&Robot, &str),
    snapping: Snapping,
    folder: Option<&Path>,
) -> Vec<Proposed> {
    let others: Vec<&Fit> = found.class.iter().skip(1).collect();
    if others.is_empty() {
        return Vec::new();
    }
    let first = problem.first();
    let fresh = candidates(problem, first.model, robot, folder);
    let other = other_foot(robot, first.model.support(), snapping);
    let on_other = other.as_ref().and_then(|model| {
        let q = candidates(problem, model, robot, folder)?;
        Some((first.on(model), q))
    });
    let fresh = fresh.as_deref();
    let here = [
        (Experiment::Postures, first, fresh),
        // When the robot is turned anyway, more informative postures cost nothing more.
        (Experiment::Turned, first, fresh),
        (Experiment::Untouched, first, None),
        (Experiment::KnownWeight, first, None),
        (Experiment::BothSides, first, None),
        (Experiment::RawCells, first, None),
    ];
    let there = on_other.as_ref();
    let there = there.map(|(on, q)| (Experiment::OtherFoot, on, Some(&q[..])));
    let trials = here.into_iter().chain(there);
    let trials = trials.filter(|(experiment, _, q)| match experiment {
        Experiment::Postures => q.is_some(),
        _ => makes_sense(*experiment, problem, found),
    });
    let mut all: Vec<Proposed> = Vec::new();
    for (experiment, on, q) in trials {
        let mut trial = Trial::new(experiment, problem, on, q);
        let mut ranks = Vec::new();
        if q.is_some() {
            let chosen;
            (chosen, ranks) = most_telling(&trial, &found.best, &others);
            trial = Trial::new(experiment, problem, on, Some(&chosen));
        }
        let (separations, _) = trial.separations(&found.best, &others);
        let support = on.model.support().to_string();
        let log = NextLog {
            robot: name.to_string(),
            dofs: first.model.tree.dofs.clone(),
            q: trial.there.data.q,
            ranks,
            experiment,
            support,
        };
        all.push((proposal(experiment, &log.support, separations), log));
    }
    let least = |(own, _): &Proposed| {
        let told = own.separations.iter().copied().filter(|s| *s > TOLD_APART);
        told.fold(f64::INFINITY, f64::min)
    };
    all.sort_by(|a, b| {
        let splits = b.0.splits.cmp(&a.0.splits);
        splits.then(least(b).total_cmp(&least(a)))
    });
    all
}

/// The postures of a trial that tell most, in an order that moves little, and the place of each
/// by how much it tells.
fn most_telling(trial: &Trial, truth: &Fit, others: &[&Fit]) -> (Vec<f64>, Vec<usize>) {
    let dof = trial.there.model.dof();
    let pick = |q: &[f64], order: &[usize]| -> Vec<f64> {
        let postures = order.iter().map(|&k| &q[k * dof..(k + 1) * dof]);
        postures.flatten().copied().collect()
    };
    let (_, by_posture) = trial.separations(truth, others);
    let mut best: Vec<usize> = (0..by_posture.len()).collect();
    best.sort_by(|a, b| by_posture[*b].total_cmp(&by_posture[*a]));
    best.truncate(NEXT_POSTURES);
    let chosen = pick(&trial.there.data.q, &best);
    let order = short_order(&chosen, dof);
    (pick(&chosen, &order), order)
}

fn makes_sense(experiment: Experiment, problem: &Problem, found: &Explained) -> bool {
    let any = |holds: fn(&Term) -> bool| found.class.iter().any(|f| f.terms.iter().any(holds));
    match experiment {
        Experiment::RawCells => !problem.data().raw_cells && !problem.data().cells.is_empty(),
        Experiment::BothSides => any(|term| term.dead_band().is_some()),
        Experiment::Untouched => any(|term| {
            let gone = |experiment| term.in_experiment(experiment) == Carry::Gone;
            gone(Experiment::Untouched) && !gone(Experiment::Postures)
        }),
        _ => true,
    }
}

fn proposal(experiment: Experiment, support: &str, separations: Vec<f64>) -> ExperimentProposal {
    let what = match experiment {
        Experiment::Postures => {
            format!("{NEXT_POSTURES} new postures on {support}, deeper and more varied")
        }
        Experiment::Turned => "postures after turning the robot by 180° on the floor".into(),
        Experiment::OtherFoot => format!("{NEXT_POSTURES} postures on the other foot, {support}"),
        Experiment::KnownWeight => {
            "the same postures with a known weight on the trunk, a tenth of the robot's".into()
        }
        Experiment::BothSides => "the same postures approached from the other side".into(),
        Experiment::RawCells => "the same postures with raw loads of the foot cells".into(),
        Experiment::Untouched => {
            "the same postures with nothing touching the robot, cables unplugged".into()
        }
    };
    ExperimentProposal {
        what,
        splits: separations.iter().filter(|s| **s > TOLD_APART).count(),
        separations,
    }
}

/// Balanced postures within what the log's joints do, and somewhat more.
fn candidates(
    problem: &Problem,
    model: &Model,
    robot: &Robot,
    folder: Option<&Path>,
) -> Option<Vec<f64>> {
    let (dof, data) = (model.dof(), problem.data());
    let mut limits = Limits::of_urdf(&model.tree.dofs);
    for (joint, range) in limits.ranges.iter_mut().enumerate() {
        let (low, high) = range_of(data.q.iter().skip(joint).step_by(dof).copied());
        let room = criteria::BEYOND_LOG * (high - low);
        let narrowed = (range.0.max(low - room), range.1.min(high + room));
        if narrowed.0 < narrowed.1 {
            *range = narrowed;
        }
    }
    let (least, most) = criteria::COP_BOX_M;
    let far = data.reading.iter().map(|x| x.abs());
    let half = far.fold(least, f64::max).min(most);
    let region = Region::square(half, 0.0).ok()?;
    let geometry = Geometry::read(&robot.description, folder);
    let (clearance, count) = (criteria::CLEARANCE_M, criteria::CANDIDATES);
    let mut scene = Scene::new(model, &geometry, &limits, &region, clearance, None);
    scene.sigmas = 2.0;
    let (q, _) = sample(&scene, 1, count, 20 * count, |_| Ok(())).ok()?;
    (q.len() >= NEXT_POSTURES * dof).then_some(q)
}

/// The robot on its other foot: the link of the mirrored name.
fn other_foot(robot: &Robot, support: &str, snapping: Snapping) -> Option<Model> {
    let pairs = [
        ("r_", "l_"),
        ("right", "left"),
        ("R_", "L_"),
        ("_r", "_l"),
        ("Right", "Left"),
        ("RIGHT", "LEFT"),
    ];
    let names: Vec<&str> = robot.description.link_names().collect();
    let mirrored = pairs.iter().find_map(|(a, b)| {
        let swapped = if support.contains(a) {
            support.replacen(a, b, 1)
        } else {
            support.replacen(b, a, 1)
        };
        (swapped != support && is_support(&swapped, names.iter().copied())).then_some(swapped)
    })?;
    robot.model(&mirrored, snapping, None).ok()
}

/// In a sentence or two, for the diagnosis.
pub(super) fn why(proposed: &[Proposed], found: &Explained) -> String {
    let Some((best, _)) = proposed.first() else {
        return match (found.diagnosis.verdict, found.class.len()) {
            (Verdict::Unusable, _) => "These data cannot be used.".to_string(),
            (Verdict::TooShort, _) => "The log is too short to tell anything apart.".to_string(),
            (Verdict::Unexplained, _) => {
                "No known effect explains these data, so there are no explanations that postures \
                 would tell apart: check the robot by hand first."
                    .to_string()
            }
            (_, 0 | 1) => "No other explanation fits these data.".to_string(),
            _ => "No experiment is known that would tell these apart.".to_string(),
        };
    };
    let others = found.class.len().saturating_sub(1);
    if best.splits == 0 {
        return format!(
            "No experiment that is known here would tell these apart; nearest is {} (χ² {:.0}).",
            best.what,
            best.separations.iter().copied().fold(0.0, f64::max)
        );
    }
    let excluded = match (best.splits, others) {
        (1, 1) => "the other explanation".to_string(),
        (2, 2) => "both other explanations".to_string(),
        (splits, others) if splits == others => format!("all {others} other explanations"),
        (splits, others) => format!("{splits} of the {others} other explanations"),
    };
    let mut text = format!(
        "Most would be told by {}: it would exclude {excluded}.",
        best.what
    );
    let more = proposed.iter().skip(1).filter(|(p, _)| p.splits > 0);
    let more = more.map(|(p, _)| format!("{} ({})", p.what, p.splits));
    let more: Vec<String> = more.take(2).collect();
    if !more.is_empty() {
        text.push_str(&format!(" Next best: {}.", more.join("; ")));
    }
    text
}

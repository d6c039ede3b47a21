//! Which experiment would tell the explanations of a class apart.

use std::path::Path;

use sesc_model::effects::{Carry, Experiment, PostureContext};
use sesc_model::tree::is_support;
use sesc_model::{Model, Snapping};

use super::criteria::{self, NEXT_POSTURES};
use super::experiment::{Postures, Trial};
use super::findings::{ExperimentProposal, Explained, Verdict};
use super::hypothesis::Term;
use super::problem::{Block, Fit, Problem};
use crate::plan::design::short_order;
use crate::plan::{Geometry, Limits, Region, Scene, sample};
use crate::robot::Robot;

/// Experiments, the best first, and the postures of the best.
#[derive(Default)]
pub struct Next {
    pub proposals: Vec<ExperimentProposal>,
    /// What the best is.
    pub experiment: Option<Experiment>,
    pub postures: Option<OnFoot>,
}

impl Next {
    /// The best experiment, if it would exclude any explanation.
    pub fn telling(&self) -> Option<&ExperimentProposal> {
        self.proposals.first().filter(|best| best.splits > 0)
    }
}

/// Rank experiments by how many of the class they exclude.
pub fn next(
    problem: &Problem,
    found: &Explained,
    robot: &Robot,
    snapping: Snapping,
    folder: Option<&Path>,
) -> Next {
    let truth = &found.best;
    let others: Vec<&Fit> = found.class.iter().skip(1).collect();
    if others.is_empty() {
        return Next::default();
    }
    let mut ranked: Vec<Ranked> = Vec::new();
    let model = problem.first.model;
    let support = model.support().to_string();
    let fresh = candidates(problem, model, robot, folder);
    let mut all = vec![
        Experiment::Untouched,
        Experiment::KnownWeight,
        Experiment::BothSides,
        Experiment::RawCells,
    ];
    match fresh {
        // When the robot is turned anyway, more informative postures cost nothing more.
        Some(q) => {
            for experiment in [Experiment::Postures, Experiment::Turned] {
                let q = q.clone();
                ranked.push(with_postures(
                    experiment,
                    problem,
                    &problem.first,
                    model,
                    q,
                    truth,
                    &others,
                ));
            }
        }
        None => all.insert(0, Experiment::Turned),
    }
    for experiment in all {
        if !makes_sense(experiment, problem, found) {
            continue;
        }
        let trial = Trial {
            experiment,
            here: problem,
            there: &problem.first,
            postures: Postures {
                model: problem.first.model,
                q: problem.first.data.q.clone(),
                posture_context: problem.first.data.posture_context.clone(),
            },
        };
        let (separations, _) = trial.separations(truth, &others);
        ranked.push(Ranked {
            proposal: proposal(trial.experiment, &support, separations),
            postures: OnFoot {
                support: support.clone(),
                q: problem.first.data.q.clone(),
                ranks: Vec::new(),
            },
            experiment: trial.experiment,
        });
    }
    if let Some(other) = other_foot(robot, &support, snapping) {
        let there = problem.first.on(&other);
        if let Some(q) = candidates(problem, &other, robot, folder) {
            let foot = Experiment::OtherFoot;
            ranked.push(with_postures(
                foot, problem, &there, &other, q, truth, &others,
            ));
        }
    }
    ranked.sort_by(|a, b| {
        let least = |p: &ExperimentProposal| {
            p.separations
                .iter()
                .copied()
                .filter(|s| *s > criteria::TOLD_APART)
                .fold(f64::INFINITY, f64::min)
        };
        let (a, b) = (&a.proposal, &b.proposal);
        b.splits.cmp(&a.splits).then(least(b).total_cmp(&least(a)))
    });
    Next {
        experiment: ranked.first().map(|best| best.experiment),
        postures: ranked.first().map(|best| best.postures.clone()),
        proposals: ranked.into_iter().map(|ranked| ranked.proposal).collect(),
    }
}

fn makes_sense(experiment: Experiment, problem: &Problem, found: &Explained) -> bool {
    let any = |holds: fn(&Term) -> bool| found.class.iter().any(|f| f.terms.iter().any(holds));
    match experiment {
        Experiment::RawCells => {
            !problem.first.data.raw_cells && !problem.first.data.cells.is_empty()
        }
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
        splits: separations
            .iter()
            .filter(|s| **s > criteria::TOLD_APART)
            .count(),
        separations,
    }
}

/// A support and the postures to take on it.
#[derive(Clone)]
pub struct OnFoot {
    pub support: String,
    /// Row by row.
    pub q: Vec<f64>,
    /// Place of each posture by how much it tells, from 0; empty where all are to be taken.
    pub ranks: Vec<usize>,
}

/// An experiment with what it would tell.
struct Ranked {
    experiment: Experiment,
    proposal: ExperimentProposal,
    postures: OnFoot,
}

/// Chooses the postures that tell most among many candidates, in an order that moves little.
fn with_postures(
    experiment: Experiment,
    here: &Problem,
    there: &Block,
    model: &Model,
    q: Vec<f64>,
    truth: &Fit,
    others: &[&Fit],
) -> Ranked {
    let dof = model.dof();
    let layout = PostureContext::of(model);
    let take = |q: &[f64]| Postures {
        model,
        q: q.to_vec(),
        posture_context: vec![0.0; q.len() / dof * layout.len()],
    };
    let mut trial = Trial {
        experiment,
        here,
        there,
        postures: take(&q),
    };
    let (_, by_posture) = trial.separations(truth, others);
    let mut best: Vec<usize> = (0..by_posture.len()).collect();
    best.sort_by(|a, b| by_posture[*b].total_cmp(&by_posture[*a]));
    best.truncate(NEXT_POSTURES);
    let chosen: Vec<f64> = best
        .iter()
        .flat_map(|&k| q[k * dof..(k + 1) * dof].iter().copied())
        .collect();
    let order = short_order(&chosen, dof);
    let chosen: Vec<f64> = order
        .iter()
        .flat_map(|&k| chosen[k * dof..(k + 1) * dof].iter().copied())
        .collect();
    trial.postures = take(&chosen);
    let (separations, _) = trial.separations(truth, others);
    let support = model.support().to_string();
    Ranked {
        proposal: proposal(trial.experiment, &support, separations),
        postures: OnFoot {
            support,
            q: chosen,
            ranks: order,
        },
        experiment: trial.experiment,
    }
}

/// Balanced postures within what the log's joints do, and somewhat more.
fn candidates(
    problem: &Problem,
    model: &Model,
    robot: &Robot,
    folder: Option<&Path>,
) -> Option<Vec<f64>> {
    let dof = model.dof();
    let mut limits = Limits::of_urdf(&model.tree.dofs);
    for (joint, range) in limits.ranges.iter_mut().enumerate() {
        let values = problem.first.data.q.iter().skip(joint).step_by(dof);
        let low = values.clone().copied().fold(f64::INFINITY, f64::min);
        let high = values.copied().fold(f64::NEG_INFINITY, f64::max);
        let room = criteria::BEYOND_LOG * (high - low);
        let narrowed = (range.0.max(low - room), range.1.min(high + room));
        if narrowed.0 < narrowed.1 {
            *range = narrowed;
        }
    }
    let far = problem.first.data.reading.iter().map(|x| x.abs());
    let half = far
        .fold(criteria::COP_BOX_M.0, f64::max)
        .min(criteria::COP_BOX_M.1);
    let region = Region::square(half, 0.0).ok()?;
    let geometry = Geometry::read(&robot.description, folder);
    let clearance = criteria::CLEARANCE_M;
    let mut scene = Scene::new(model, &geometry, &limits, &region, clearance, None);
    scene.sigmas = 2.0;
    let draws = 20 * criteria::CANDIDATES;
    let (q, _) = sample(&scene, 1, criteria::CANDIDATES, draws, |_| Ok(())).ok()?;
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
pub fn why(next: &Next, found: &Explained) -> String {
    let Some(best) = next.proposals.first() else {
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
    let more: Vec<String> = next
        .proposals
        .iter()
        .skip(1)
        .filter(|p| p.splits > 0)
        .take(2)
        .map(|p| format!("{} ({})", p.what, p.splits))
        .collect();
    if !more.is_empty() {
        text.push_str(&format!(" Next best: {}.", more.join("; ")));
    }
    text
}

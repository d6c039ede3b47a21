//! The diagnosis judged by closed forms, dense algebra and the virtual robot.

mod backlash_sides;
mod data;
mod held_out;
mod lasting;
mod leftover;
mod new_effect;
mod next;
mod nuisance;
mod outliers;
mod problem;
mod remedy;
mod request;
mod verdict;
mod view;

use std::sync::Arc;

use rand::SeedableRng as _;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution as _, StandardNormal};
use sesc_model::effects::{Catalog, Experiment, Instance};
use sesc_model::{Model, Snapping};
use sesc_reference::World;

use super::diagnosis::find;
use super::findings::{About, Explained};
use super::hypothesis::Term;
use super::problem::{Block, Fit, Problem};
use super::search::Beyond;
use super::{Quantity, Request, words};
use crate::fit::prior::{Prior, Tolerance, Tolerances};
use crate::logs::{LogSource, Table};
use crate::observations::postures::Postures;
use crate::robot::Robot;
use crate::simulate::Simulator;
use crate::tests::{SKEW, says};

const OP2_URDF: &str = include_str!("../../../../robots/op2/op2.urdf");

/// Standard deviation of a reading, m.
const NOISE: f64 = 5e-4;
/// |CoP| of balanced postures, m.
const BALANCED: f64 = 0.03;
/// Within ±30° of zero.
const RANGE: f64 = 0.52;

/// A robot, its model and its virtual twin.
struct Bench {
    model: Model,
    support: &'static str,
    twin: sesc_reference::Robot,
}

impl Bench {
    fn new(text: &str, support: &'static str) -> Bench {
        let robot = Robot::parse(text, "robot.urdf").unwrap();
        Bench {
            model: robot.model(support, Snapping::default(), None).unwrap(),
            support,
            twin: sesc_reference::Robot::from_urdf(text).unwrap(),
        }
    }

    fn op2() -> Bench {
        Bench::new(OP2_URDF, "r_sole")
    }

    fn skew() -> Bench {
        Bench::new(SKEW, "foot")
    }

    fn world(&self) -> World {
        World::new(&self.twin, self.support).unwrap()
    }

    /// Place of a joint in a posture.
    fn joint(&self, name: &str) -> usize {
        let mut dofs = self.model.tree.dofs.iter();
        dofs.position(|dof| dof.joint == name).unwrap()
    }

    fn postures(&self, count: usize, seed: u64) -> Vec<f64> {
        Simulator::new(&self.model.tree.dofs, Some(RANGE), seed).batch(count)
    }

    /// Postures in which the robot of the URDF does not fall.
    fn balanced(&self, count: usize, seed: u64) -> Vec<f64> {
        let world = self.world();
        let mut simulator = Simulator::new(&self.model.tree.dofs, Some(RANGE), seed);
        let stands = |q: &Vec<f64>| world.cop(q).iter().all(|x| x.abs() < BALANCED);
        std::iter::repeat_with(|| simulator.posture())
            .filter(stands)
            .take(count)
            .flatten()
            .collect()
    }

    /// What a world reads, with noise and, per posture, something else.
    fn read(
        &self,
        world: &World,
        q: &[f64],
        seed: u64,
        also: impl Fn(usize, &[f64]) -> [f64; 2],
    ) -> Postures {
        let dof = self.model.dof();
        let mut gauss = gauss(seed);
        let reading = q.chunks_exact(dof).enumerate().flat_map(|(k, q)| {
            let (cop, more) = (world.cop(q), also(k, q));
            [0, 1].map(|axis| cop[axis] + more[axis] + NOISE * gauss())
        });
        Postures::given(dof, q, &reading.collect::<Vec<_>>(), NOISE, 0.0)
    }

    fn log(&self, world: &World, q: &[f64], seed: u64) -> Postures {
        self.read(world, q, seed, |_, _| [0.0; 2])
    }

    /// CAD masses beyond doubt.
    fn certain(&self, data: Postures) -> Problem<'_> {
        let nothing = Tolerance {
            mass: Some(0.0),
            com: Some(0.0),
            mass_kg: None,
        };
        let certain = Tolerances {
            default: nothing,
            ..Tolerances::default()
        };
        self.of(data, &Prior::Cad(certain))
    }

    fn problem(&self, data: Postures, prior: &str) -> Problem<'_> {
        self.of(data, &Prior::named(prior, &self.model).unwrap())
    }

    fn of(&self, data: Postures, prior: &Prior) -> Problem<'_> {
        let block = Block::new(&self.model, data, None, &Catalog::standard());
        Problem::new(vec![block], prior)
    }

    fn diagnose(&self, data: Postures, prior: &str) -> Explained {
        diagnosed(&mut self.problem(data, prior))
    }
}

/// Angle by which the hip stands further than its encoder reads, rad.
const HIP: f64 = 0.05;

/// Postures and the log of the skewed robot with that offset.
fn off_hip() -> (Vec<f64>, Postures) {
    let bench = Bench::skew();
    let q = bench.postures(60, 3);
    let world = bench.world().joint_offset("hip", HIP).unwrap();
    let data = bench.log(&world, &q, 3);
    (q, data)
}

/// The columns of a log of the skewed robot.
fn table(q: &[f64], data: &Postures) -> Table {
    let of = |values: &[f64], from: usize| -> Vec<f64> {
        values.iter().skip(from).step_by(2).copied().collect()
    };
    Table::new("log.csv")
        .numbers("hip", of(q, 0))
        .numbers("knee", of(q, 1))
        .numbers("cop_x", of(&data.reading, 0))
        .numbers("cop_y", of(&data.reading, 1))
}

/// A request for the skewed robot.
fn request(log: impl Into<LogSource>) -> Request {
    let robot = Robot::parse(SKEW, "skew.urdf").unwrap();
    let mut request = Request::new(Arc::new(robot), log);
    request.support = Some("foot".into());
    request.prior = "tight".into();
    request.noise = Some(NOISE);
    request.floor = 0.0;
    request.corrected_urdf = true;
    request
}

/// A log beside that of an experiment.
fn together<'m>(first: &Problem<'m>, second: &Problem<'m>, experiment: Experiment) -> Problem<'m> {
    let second = second.first().clone().beside(first.first(), experiment);
    first.about(vec![first.first().clone(), second])
}

fn about() -> About<'static> {
    About {
        robot: "robot",
        support: "sole",
        log: "log.csv",
        prior: String::new(),
        health: Vec::new(),
        usable: true,
        scores: 0,
        sole: None,
    }
}

fn diagnosed(problem: &mut Problem) -> Explained {
    let mut found = find(problem, &about(), Beyond::Tried, &mut ()).unwrap();
    super::verdict::state(problem, &mut found);
    found
}

fn gauss(seed: u64) -> impl FnMut() -> f64 {
    let mut random = ChaCha8Rng::seed_from_u64(1000 + seed);
    move || StandardNormal.sample(&mut random)
}

/// An effect at its target, both by name.
fn term(problem: &Problem, effect: &str, target: &str) -> Term {
    match effect {
        "cop_outliers" => return Term::Outliers,
        "mass_distribution" => return Term::Masses,
        _ => (),
    }
    let effect = problem.first().context.catalog.named(effect).unwrap();
    let target = problem
        .first()
        .context
        .target_named(effect, target)
        .unwrap();
    Term::Effect(Instance { effect, target })
}

/// Values of all effects of a fit with their stated deviations.
fn values(problem: &Problem, fit: &Fit) -> Vec<Quantity> {
    let own = words::values(problem, fit).concat();
    own.into_iter().map(|(_, value)| value).collect()
}

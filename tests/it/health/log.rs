//! Logs of the OP2 and of what is broken about them.

use std::path::Path;
use std::sync::Arc;

use sesc_identify::diagnose::{Diagnosis, FLOOR_M, Report, Request, Verdict, diagnose};
use sesc_identify::fit::{self, Identification};
use sesc_identify::health::{self, Health};
use sesc_identify::logs::{LogSource, Sidecar, Table};
use sesc_identify::observations::Postures;
use sesc_identify::robot::Robot;
use sesc_identify::simulate::Simulator;
use sesc_model::Snapping;
use sesc_reference::World;
use sesc_test_support::command::ROOT;

pub const POSTURES: usize = 80;
pub const NOISE_M: f64 = 3e-4;

/// A log of the OP2 while it is broken.
#[derive(Clone)]
pub struct Log {
    pub robot: Arc<Robot>,
    pub joints: Vec<String>,
    pub q: Vec<Vec<f64>>,
    pub cop: Vec<[f64; 2]>,
    /// Loads of the cells, N, and their places, m.
    pub cells: Vec<Vec<f64>>,
    pub places: Vec<[f64; 2]>,
    /// Deviation of a reading as the columns `_std` have it, m; none without them.
    pub stated: Option<f64>,
    pub noise_is_given: bool,
}

impl Log {
    /// Postures of a world that stands on `foot`; `fixed` joints do not move.
    pub fn of(foot: &str, fixed: &[&str], hide: impl Fn(World) -> World, seed: u64) -> Log {
        let robot = Robot::read(Path::new(&format!("{ROOT}/robots/op2/op2.urdf"))).unwrap();
        let model = robot.model(foot, Snapping::default(), None).unwrap();
        let joints: Vec<String> = model.tree.dofs.iter().map(|d| d.joint.clone()).collect();
        let mut simulator = Simulator::new(&model.tree.dofs, Some(0.4), seed);
        let mut q: Vec<Vec<f64>> = (0..POSTURES).map(|_| simulator.posture()).collect();
        for q in &mut q {
            for (x, joint) in q.iter_mut().zip(&joints) {
                if fixed.contains(&joint.as_str()) {
                    *x = 0.2;
                }
            }
        }
        let described = sesc_reference::Robot::from_urdf(robot.text()).unwrap();
        let world = hide(World::new(&described, foot).unwrap());
        let cop = q
            .iter()
            .map(|q| world.cop(q).map(|y| y + simulator.gauss(NOISE_M)));
        Log {
            cop: cop.collect(),
            cells: Vec::new(),
            places: Vec::new(),
            stated: None,
            noise_is_given: true,
            robot: Arc::new(robot),
            joints,
            q,
        }
    }

    pub fn examine(&self, support: &str) -> Health {
        let model = self
            .robot
            .model(support, Snapping::default(), None)
            .unwrap();
        let (q, cop) = (self.q.concat(), self.cop.concat());
        let data = Postures::given(self.joints.len(), &q, &cop, NOISE_M, FLOOR_M);
        health::examine(&self.robot, &model, Snapping::default(), &data)
    }

    /// The log as a source.
    fn source(&self) -> LogSource {
        let axis = |k: usize| -> Vec<f64> { self.cop.iter().map(|y| y[k]).collect() };
        let mut log = Table::new("log");
        for k in 0..self.places.len() {
            let loads: Vec<f64> = self.cells.iter().map(|row| row[k]).collect();
            log = log.numbers(&format!("fsr_{}", k + 1), loads);
        }
        if self.places.is_empty() {
            log = log.numbers("cop_x", axis(0)).numbers("cop_y", axis(1));
        }
        if let Some(std) = self.stated {
            for name in ["cop_x_std", "cop_y_std"] {
                log = log.numbers(name, vec![std; self.q.len()]);
            }
        }
        for (j, joint) in self.joints.iter().enumerate() {
            let column: Vec<f64> = self.q.iter().map(|q| q[j]).collect();
            log = log.numbers(joint, column);
        }
        let mut log = LogSource::from(log);
        if !self.places.is_empty() {
            log = log.with_sidecar(Sidecar {
                cells: Some(self.places.clone()),
                ..Sidecar::default()
            });
        }
        log
    }

    /// What a fit of masses says.
    pub fn fit(&self, support: &str) -> Identification {
        let mut request = fit::Request::default();
        request.robot = Some(self.robot.clone());
        request.logs = vec![self.source()];
        request.support = Some(support.into());
        request.noise = (self.stated.is_none() && self.noise_is_given).then_some(NOISE_M);
        fit::fit(&request, &mut ()).unwrap().identification
    }

    pub fn diagnose(&self, support: &str) -> Report {
        let mut request = Request::new(self.robot.clone(), self.source());
        request.support = Some(support.into());
        request.noise = (self.stated.is_none() && self.noise_is_given).then_some(NOISE_M);
        diagnose(&request, &mut ()).unwrap()
    }
}

/// Kinds of findings and what each is of.
pub fn kinds(found: &Diagnosis) -> Vec<(&str, &str)> {
    let health = found.health.iter();
    health.map(|h| (h.kind.name(), &*h.target)).collect()
}

/// The finding of this kind, and no other; where nothing can be used it is drawn, and every row is
/// shown as the robot stood in it.
pub fn finds(log: &Log, support: &str, kind: &str, target: &str, usable: bool) {
    let found = log.diagnose(support).diagnosis;
    println!("{:?}: {}", kinds(&found), found.sentence);
    assert_eq!(kinds(&found), [(kind, target)]);
    assert_eq!(found.verdict == Verdict::Unusable, !usable);
    assert!(usable || found.steps.is_empty() && found.indistinguishable.is_empty());
    let drawn = ["cop_constant", "rows_shuffled", "other_foot"].contains(&kind);
    if drawn && log.q.len() == POSTURES {
        let picture = found.health[0].picture.as_ref().unwrap();
        assert_eq!(picture.points.len(), 2 * POSTURES, "{kind}");
        let stood: Vec<&Vec<f64>> = picture.rows.iter().map(|row| &row.q).collect();
        assert_eq!(stood, log.q.iter().collect::<Vec<_>>());
    }
}

pub fn finds_nothing(log: &Log, case: u64) {
    let found = log.examine("r_sole");
    assert!(found.findings.is_empty(), "{case}: {:?}", found.findings);
}

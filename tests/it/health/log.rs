//! Logs of the OP2 and of what is broken about them.

use std::sync::Arc;

use sesc_identify::diagnose::{Diagnosis, FLOOR_M, Request, Verdict};
use sesc_identify::fit::{self, Identification};
use sesc_identify::health::{self, Health};
use sesc_identify::logs::{LogSource, Sidecar, Table};
use sesc_identify::observations::Postures;
use sesc_identify::robot::Robot;
use sesc_identify::simulate::Simulator;
use sesc_model::Snapping;
use sesc_reference::World;
use sesc_test_support::recording::{Recording, table};
use sesc_test_support::stage::{Platform, Stage};

use crate::asked::{diagnosed, fitted, kinds, robot};

pub(super) const POSTURES: usize = 80;
pub(super) const NOISE_M: f64 = 3e-4;

/// A log of the OP2 while it is broken.
#[derive(Clone)]
pub(super) struct Log {
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
    pub(super) fn of(foot: &str, fixed: &[&str], hide: impl Fn(World) -> World, seed: u64) -> Log {
        let stage = Stage::new(Platform::Op2);
        let robot = robot(&stage);
        let model = robot.model(foot, Snapping::default(), None).unwrap();
        let joints: Vec<String> = model.tree.dofs.iter().map(|d| d.joint.clone()).collect();
        let mut simulator = Simulator::new(&model.tree.dofs, Some(0.4), seed);
        let mut q: Vec<Vec<f64>> = (0..POSTURES).map(|_| simulator.posture()).collect();
        for q in &mut q {
            let own = q.iter_mut().zip(&joints);
            let own = own.filter(|(_, joint)| fixed.contains(&joint.as_str()));
            own.for_each(|(x, _)| *x = 0.2);
        }
        let world = hide(World::new(&stage.robot, foot).unwrap());
        let cop = q
            .iter()
            .map(|q| world.cop(q).map(|y| y + simulator.gauss(NOISE_M)));
        Log {
            cop: cop.collect(),
            cells: Vec::new(),
            places: Vec::new(),
            stated: None,
            noise_is_given: true,
            robot,
            joints,
            q,
        }
    }

    /// The same, whose encoder of a joint says `at` all the time.
    pub(super) fn stuck(mut self, joint: &str, at: f64) -> Log {
        let joint = self.joints.iter().position(|name| name == joint).unwrap();
        self.q.iter_mut().for_each(|q| q[joint] = at);
        self
    }

    /// Joints and readings.
    pub(super) fn recording(&self) -> Recording {
        Recording {
            joints: self.joints.clone(),
            q: self.q.clone(),
            cop: self.cop.clone(),
            ..Recording::default()
        }
    }

    pub(super) fn examine(&self, support: &str) -> Health {
        let model = self.robot.model(support, Snapping::default(), None);
        let (q, cop) = (self.q.concat(), self.cop.concat());
        let data = Postures::given(self.joints.len(), &q, &cop, NOISE_M, FLOOR_M);
        health::examine(&self.robot, &model.unwrap(), Snapping::default(), &data)
    }

    /// The log as a source.
    fn source(&self) -> LogSource {
        let mut columns = self.recording().columns(false);
        let mut sidecar = Sidecar::default();
        if !self.places.is_empty() {
            columns.drain(..2);
            sidecar.cells = Some(self.places.clone());
        }
        let mut log = table(columns);
        for k in 0..self.places.len() {
            let loads: Vec<f64> = self.cells.iter().map(|row| row[k]).collect();
            log = log.numbers(&format!("fsr_{}", k + 1), loads);
        }
        if let Some(std) = self.stated {
            let state = |log: Table, name| log.numbers(name, vec![std; self.q.len()]);
            log = ["cop_x_std", "cop_y_std"].into_iter().fold(log, state);
        }
        LogSource::from(log).with_sidecar(sidecar)
    }

    fn noise(&self) -> Option<f64> {
        (self.stated.is_none() && self.noise_is_given).then_some(NOISE_M)
    }

    /// What a fit of masses says.
    pub(super) fn fit(&self) -> Identification {
        let mut request = fit::Request::default();
        request.robot = Some(self.robot.clone());
        request.logs = vec![self.source()];
        request.support = Some("r_sole".into());
        request.noise = self.noise();
        fitted(&request)
    }

    /// What a diagnosis on the right sole says.
    pub(super) fn diagnose(&self) -> Diagnosis {
        self.diagnose_on("r_sole")
    }

    fn diagnose_on(&self, support: &str) -> Diagnosis {
        let mut request = Request::new(self.robot.clone(), self.source());
        request.support = Some(support.into());
        request.noise = self.noise();
        diagnosed(&request)
    }
}

/// The finding of this kind, and no other; where nothing can be used it is drawn, and every row is
/// shown as the robot stood in it.
pub(super) fn finds(log: &Log, support: &str, kind: &str, target: &str, usable: bool) {
    let found = log.diagnose_on(support);
    assert_eq!(kinds(&found.health), [(kind, target)]);
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

pub(super) fn finds_nothing(log: &Log, case: u64) {
    let found = log.examine("r_sole");
    assert!(found.findings.is_empty(), "{case}: {:?}", found.findings);
}

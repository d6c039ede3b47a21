//! What a hypothesis predicts of a log: programs made once, run on tape.

use std::borrow::Cow;
use std::sync::{Arc, OnceLock, PoisonError};

use sesc_model::Function;
use sesc_model::effects::{self, PostureContext, Stage};
use sesc_model::tape::{Tape, Values};

use super::backlash_sides::OwnSides;
use super::{Fit, Problem};
use crate::diagnose::hypothesis::{Term, effects_of};
use crate::evaluate::{Evaluator, FASTEST};
use crate::feet::OtherFoot;

/// What a set of terms runs on.
pub(super) struct Tapes {
    pub reading: Tape,
    /// Made when a dead band asks for sides.
    moments: OnceLock<Arc<Tape>>,
    /// Made where the log is of both feet.
    soles: OnceLock<Arc<Tape>>,
}

impl Problem<'_> {
    /// The programs of a set of terms, made once; two who ask at the same time may both make
    /// them, and the same.
    fn tapes(&self, terms: &[Term]) -> Arc<Tapes> {
        let known = || self.tapes.lock().unwrap_or_else(PoisonError::into_inner);
        let key = effects_of(terms);
        if let Some(tapes) = known().get(&key) {
            return tapes.clone();
        }
        let program = effects::reading(&self.context, &key, &self.params);
        let tapes = Arc::new(Tapes {
            reading: Tape::new(&program),
            moments: OnceLock::new(),
            soles: OnceLock::new(),
        });
        known().entry(key).or_insert(tapes).clone()
    }

    fn moments(&self, terms: &[Term]) -> Arc<Tape> {
        let tapes = self.tapes(terms);
        let made = tapes.moments.get_or_init(|| {
            let program = effects::moments(&self.context, &effects_of(terms), &self.params);
            Arc::new(Tape::new(&program))
        });
        made.clone()
    }

    /// The program of the other sole under a set of terms.
    pub(super) fn soles(&self, terms: &[Term], other: &OtherFoot) -> Arc<Tape> {
        let tapes = self.tapes(terms);
        let made = tapes.soles.get_or_init(|| {
            let effects = effects_of(terms);
            let program = effects::other_sole(&self.context, &effects, &self.params, other.place());
            Arc::new(Tape::new(&program))
        });
        made.clone()
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
        let n = posture_context.len() / PostureContext::of(self.context.robot).len();
        let mut out = vec![0.0; n * tapes.reading.outputs()];
        let arguments = [
            Values::PerPosture(q),
            Values::Shared(unknowns),
            Values::PerPosture(posture_context),
        ];
        tapes.reading.run(&arguments, n, &mut out, FASTEST);
        out
    }

    /// Moments (m) and slopes of the reading by joint: 3 × dof per posture.
    pub(in crate::diagnose) fn evaluate_moments(
        &self,
        terms: &[Term],
        unknowns: &[f64],
        posture_context: &[f64],
    ) -> Vec<f64> {
        self.evaluate_moments_at(terms, unknowns, &self.data.q, posture_context)
    }

    /// The same at joint positions `q`.
    pub(in crate::diagnose) fn evaluate_moments_at(
        &self,
        terms: &[Term],
        unknowns: &[f64],
        q: &[f64],
        posture_context: &[f64],
    ) -> Vec<f64> {
        let tape = self.moments(terms);
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

    /// Readings that CAD predicts at joint positions `q`, on level ground.
    pub fn plain(&self, q: &[f64]) -> Vec<f64> {
        let n = q.len() / self.context.robot.dof();
        let model = self.model;
        Evaluator::with_params(model, Function::Cop, self.cad.clone()).run(q, n)
    }

    /// What is known of each posture under a fit to this log.
    pub(in crate::diagnose) fn posture_context_of(&self, fit: &Fit) -> Cow<'_, [f64]> {
        match &fit.sides {
            Some(own) => {
                let layout = PostureContext::of(self.context.robot);
                Cow::Owned(own.context(&layout, &self.data.posture_context))
            }
            None => Cow::Borrowed(&self.data.posture_context),
        }
    }

    /// The sides on which joints rest in the context of a fit to this log.
    pub(in crate::diagnose) fn sides_of(&self, posture_context: &[f64]) -> OwnSides {
        let robot = self.context.robot;
        let layout = PostureContext::of(robot);
        let log = &self.data.posture_context;
        OwnSides::of(&layout, robot.dof(), log, posture_context)
    }

    /// Joint positions of every posture as a hypothesis bends them.
    pub fn bent(&self, fit: &Fit) -> Vec<f64> {
        let joints: Vec<(usize, &Term)> = fit
            .terms
            .iter()
            .enumerate()
            .filter(|(_, term)| {
                let moves = |stage| stage <= Stage::Joints || stage == Stage::Bends;
                term.stage().is_some_and(moves)
            })
            .collect();
        if joints.is_empty() {
            return self.data.q.clone();
        }
        let program = effects::joints(&self.context, &effects_of(&fit.terms), &self.params);
        let tape = Tape::new(&program);
        let n = self.data.len();
        let mut out = vec![0.0; n * tape.outputs()];
        let posture_context = self.posture_context_of(fit);
        let arguments = [
            Values::PerPosture(&self.data.q),
            Values::Shared(&fit.unknowns),
            Values::PerPosture(&posture_context),
        ];
        tape.run(&arguments, n, &mut out, FASTEST);
        out
    }

    /// Gravity moments and slopes of the robot with CAD masses, at positions `q`.
    pub(in crate::diagnose) fn moments_at(&self, q: &[f64]) -> Vec<f64> {
        let tape = self.moments(&[]);
        let n = self.data.len();
        let mut out = vec![0.0; n * tape.outputs()];
        let arguments = [
            Values::PerPosture(q),
            Values::Shared(&[]),
            Values::PerPosture(&self.data.posture_context),
        ];
        tape.run(&arguments, n, &mut out, FASTEST);
        out
    }

    /// The effect of a fault of wiring or of the record: the joint positions that it
    /// leaves, and what becomes of a reading (m, two per posture).
    pub(in crate::diagnose) fn rewired(&self, fault: &Term) -> (Vec<f64>, Rewire) {
        let fault = effects_of(std::slice::from_ref(fault));
        let n = self.data.len();
        let joints = Tape::new(&effects::wired_joints(&self.context, &fault));
        let mut q = vec![0.0; n * joints.outputs()];
        joints.run(&[Values::PerPosture(&self.data.q)], n, &mut q, FASTEST);
        let rewire = Rewire(Tape::new(&effects::wired_reading(&self.context, &fault)));
        (q, rewire)
    }
}

/// How a fault of the record changes readings.
pub(in crate::diagnose) struct Rewire(Tape);

impl Rewire {
    /// Readings under the fault, two per posture.
    pub(in crate::diagnose) fn readings(&self, readings: &[f64]) -> Vec<f64> {
        let mut out = vec![0.0; readings.len()];
        let arguments = [Values::PerPosture(readings)];
        self.0
            .run(&arguments, readings.len() / 2, &mut out, FASTEST);
        out
    }
}

//! Whether soles that both stand on the floor close in the postures that are predicted.
//!
//! Where they do not, joints are not where encoders, and the effects of a model file, have them,
//! and predictions are off by as much.

use sesc_model::Model;
use sesc_model::effects::{self, Catalog, EffectContext, Instance, PostureContext};
use sesc_model::tape::{Tape, Values};

use crate::evaluate::FASTEST;
use crate::feet::{Closure, OtherFoot};

/// Postures that are looked at: from twice as many on, every other one of them is let go.
const POSTURES: usize = 2000;

/// Postures of a log on one support, evenly chosen.
pub(super) struct Soles {
    other: OtherFoot,
    q: Vec<f64>,
    /// Every so many rows one is kept.
    every: usize,
    rows: usize,
}

impl Soles {
    pub fn new(other: OtherFoot) -> Soles {
        Soles {
            other,
            q: Vec::new(),
            every: 1,
            rows: 0,
        }
    }

    /// Take note of postures `q[posture * dof + joint]`.
    pub fn see(&mut self, q: &[f64], dof: usize) {
        for posture in q.chunks_exact(dof.max(1)) {
            if self.rows.is_multiple_of(self.every) {
                self.q.extend(posture);
            }
            self.rows += 1;
            if self.q.len() >= 2 * POSTURES * dof {
                let all = std::mem::take(&mut self.q);
                let kept = all.chunks_exact(dof).step_by(2);
                self.q = kept.flatten().copied().collect();
                self.every *= 2;
            }
        }
    }

    /// What is said where they do not close, as `model` has its joints.
    pub fn open(&self, model: &Model) -> Option<String> {
        let q = bent(model, &self.q);
        let closure = Closure::of(model, self.other.clone(), &q, None);
        let found = match model.effects.is_empty() {
            true => closure.of_cad(),
            false => closure.of_model(),
        };
        (!found.closes).then(|| {
            format!(
                "{} Predictions take the joints to be there; a diagnosis of the log can tell what \
                 is off",
                found.sentence
            )
        })
    }
}

/// Joint positions as the effects of a model bend them.
fn bent(model: &Model, q: &[f64]) -> Vec<f64> {
    if model.effects.is_empty() {
        return q.to_vec();
    }
    let context = EffectContext::new(model, &[], false, Catalog::standard());
    let instances: Vec<Instance> = model.effects.iter().map(|(i, _)| i.clone()).collect();
    let values: Vec<f64> = model.effects.iter().flat_map(|(_, x)| x.clone()).collect();
    let tape = Tape::new(&effects::joints(&context, &instances, &model.params()));
    let n = q.len() / model.dof().max(1);
    let level = vec![0.0; n * PostureContext::of(model).len()];
    let arguments = [
        Values::PerPosture(q),
        Values::Shared(&values),
        Values::PerPosture(&level),
    ];
    let mut out = vec![0.0; q.len()];
    tape.run(&arguments, n, &mut out, FASTEST);
    out
}

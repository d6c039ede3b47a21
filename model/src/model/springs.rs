//! Whether joints that give way come to rest.
//!
//! ```text
//! φᵏ⁺¹ = φ + C τ(φᵏ)        ρ = max ‖C^½ H C^½‖ over the joint limits,  H = ∂τ/∂φ
//! ```
//!
//! Each round leaves out ρ of what the one before did. `H` is taken along one direction at a
//! time, by differences; the largest of 64 postures counts, the upright one among them.

use super::Model;
use crate::effects::{ROUNDS, Stage};
use crate::interface::{Function, Given};
use crate::numeric;
use crate::tape::{Kernels, Tape, Values};

/// Above this contraction there are more than the usual rounds,
const SOFT: f64 = 0.3;
/// and so many at most.
const MOST_ROUNDS: usize = 8;
/// Above this one rounds say nothing of where the robot rests.
const SOFTEST: f64 = 0.8;
/// What rounds may leave out of the CoM, m.
const LEFT_OUT_M: f64 = 1e-3;
/// Rounds after which the robot rests, at the softest to a millionth.
const AT_REST: usize = 64;
const POSTURES: usize = 64;
/// Powers of C H, by which its largest eigenvalue is found.
const POWERS: usize = 12;
/// Step of the differences, rad.
const STEP: f64 = 1e-5;

/// The rounds that the springs of a model take.
///
/// # Errors
/// Where rounds do not come to rest, in a sentence.
pub(super) fn rounds(model: &Model) -> Result<usize, String> {
    let weight = model.total_mass_kg() / model.tree.mass;
    let mut compliance = vec![0.0; model.dof()];
    for (instance, unknowns) in &model.effects {
        for joint in instance.target.revolute(model) {
            if instance.effect.is_spring() {
                compliance[joint] += unknowns[0] * weight;
            }
        }
    }
    if compliance.iter().all(|c| *c == 0.0) {
        return Ok(ROUNDS);
    }
    let still = Still::new(model);
    let contraction = still.contraction(&compliance);
    let soft = |what: String| {
        format!(
            "springs are too soft: {what}; give joint_compliance a larger stiffness_nm_per_rad (a \
             joint that carries the robot has five times that of gravity and more)"
        )
    };
    if contraction > SOFTEST {
        return Err(soft(format!(
            "where gravity bends a joint it adds {contraction:.2} of that bend again, and more \
             than {SOFTEST} comes to no rest"
        )));
    }
    let wanted = match contraction <= SOFT {
        true => ROUNDS,
        false => libm::ceil(ROUNDS as f64 * libm::log(SOFT) / libm::log(contraction)) as usize,
    };
    let rounds = wanted.min(MOST_ROUNDS);
    let left_out = still.left_out(&compliance, rounds);
    match left_out <= LEFT_OUT_M {
        true => Ok(rounds),
        false => Err(soft(format!(
            "{rounds} rounds of bending leave out {:.1} mm of the CoM",
            1e3 * left_out
        ))),
    }
}

/// The robot with its loads whose joints do not give way, in postures.
struct Still {
    moments: Tape,
    com: Tape,
    params: Vec<f64>,
    dof: usize,
    /// Row by row.
    postures: Vec<f64>,
}

impl Still {
    fn new(model: &Model) -> Still {
        let mut still = model.clone();
        still
            .effects
            .retain(|(instance, _)| instance.effect.stage() == Stage::Loads);
        let tape = |function| {
            let program = still.program(function, Given::Positions);
            Tape::new(&program.expect("positions give every function"))
        };
        let dofs = &model.tree.dofs;
        let upright: Vec<f64> = dofs
            .iter()
            .map(|dof| 0.0_f64.max(dof.lower).min(dof.upper))
            .collect();
        let others = numeric::postures(dofs, POSTURES - 1).flatten();
        Still {
            moments: tape(Function::GravityMoments),
            com: tape(Function::Com),
            params: model.params(),
            dof: dofs.len(),
            postures: upright.into_iter().chain(others).collect(),
        }
    }

    fn run(&self, tape: &Tape, q: &[f64], width: usize) -> Vec<f64> {
        let count = q.len() / self.dof;
        let mut out = vec![0.0; count * width];
        let arguments = [Values::PerPosture(q), Values::Shared(&self.params)];
        tape.run(&arguments, count, &mut out, Kernels::LIBM);
        out
    }

    /// The largest eigenvalue of C H over the postures, by its powers.
    fn contraction(&self, compliance: &[f64]) -> f64 {
        let root: Vec<f64> = compliance.iter().map(|c| libm::sqrt(*c)).collect();
        let largest = root.iter().copied().fold(0.0, f64::max);
        // No two entries alike, so that none is across the eigenvector.
        let start = (0..self.dof).map(|j| 1.0 / (1.0 + j as f64));
        let mut v: Vec<f64> = start.collect::<Vec<f64>>().repeat(POSTURES);
        let mut worst: f64 = 0.0;
        for _ in 0..POWERS {
            worst = 0.0;
            for row in v.chunks_mut(self.dof) {
                let norm = libm::sqrt(row.iter().map(|x| x * x).sum());
                row.iter_mut()
                    .for_each(|x| *x /= if norm > 0.0 { norm } else { 1.0 });
            }
            let place = |k: usize| k % self.dof;
            let moved = |step: f64| -> Vec<f64> {
                let both = self.postures.iter().zip(&v).enumerate();
                let at = both.map(|(k, (q, v))| q + step * v * root[place(k)] / largest);
                self.run(&self.moments, &at.collect::<Vec<f64>>(), self.dof)
            };
            let slopes = moved(STEP).into_iter().zip(moved(-STEP));
            let slopes = slopes.map(|(ahead, back)| largest * (ahead - back) / (2.0 * STEP));
            v = slopes
                .enumerate()
                .map(|(k, x)| root[place(k)] * x)
                .collect();
            for row in v.chunks(self.dof) {
                let norm = libm::sqrt(row.iter().map(|x| x * x).sum());
                worst = if norm.is_finite() {
                    worst.max(norm)
                } else {
                    f64::INFINITY
                };
            }
        }
        worst
    }

    /// How far the CoM after `rounds` is from where it rests, m, at most.
    fn left_out(&self, compliance: &[f64], rounds: usize) -> f64 {
        let mut bent = self.postures.clone();
        let mut found = Vec::new();
        for round in 0..AT_REST {
            if round == rounds {
                found = self.run(&self.com, &bent, 3);
            }
            let moments = self.run(&self.moments, &bent, self.dof);
            let straight = self.postures.iter().zip(moments).enumerate();
            bent = straight
                .map(|(k, (q, moment))| q + compliance[k % self.dof] * moment)
                .collect();
        }
        let at_rest = self.run(&self.com, &bent, 3);
        let off = found.chunks(3).zip(at_rest.chunks(3));
        let off = off.map(|(a, b)| libm::hypot(libm::hypot(a[0] - b[0], a[1] - b[1]), a[2] - b[2]));
        off.fold(0.0, |worst: f64, x| {
            if x.is_nan() {
                f64::INFINITY
            } else {
                worst.max(x)
            }
        })
    }
}
